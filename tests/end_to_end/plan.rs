//! `floodsim plan`: what it promises, against the run; and what it refuses, as `check` does.

use std::path::PathBuf;

use serde_json::Value;
use tempfile::TempDir;

use crate::floodsim;

/// The demonstration at 20 m: a few seconds, more than a plan measures.
const COARSE: [&str; 4] = ["--set", "resolution=20 m", "--set", "outputs.cell=20 m"];

fn shipped(name: &str) -> String {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(name).join("scenario.yaml").display().to_string()
}

/// The plan of a shipped scenario as JSON, its exit code and stderr.
fn plan(name: &str, arguments: &[&str]) -> (Value, i32, String) {
    let folder = TempDir::new().unwrap();
    let file = shipped(name);
    let answer = floodsim(folder.path(), &[&["plan", &file, "--json"], arguments].concat());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "a plan writes nothing");
    (serde_json::from_str(&answer.stdout).unwrap(), answer.code, answer.stderr)
}

/// Asserts that a value lies between the two ends of a range.
#[track_caller]
fn assert_within(plan: &Value, pointer: &str, actual: &Value) {
    let range: Vec<f64> = serde_json::from_value(plan.pointer(pointer).unwrap().clone()).unwrap();
    let actual = actual.as_f64().unwrap();
    assert!(range[0] <= actual && actual <= range[1], "{pointer}: {actual} is not within {range:?}");
}

#[test]
fn the_run_keeps_within_the_bounds_of_its_plan() {
    for motion in ["eulerian", "lagrangian"] {
        let methods = format!("numerics.motion={motion}");
        let folder = TempDir::new().unwrap();
        let settings = [&COARSE[..], &["--set", "time.end=5 min", "--set", &methods]].concat();
        let (plan, code, stderr) = plan("demo", &settings);
        assert_eq!((code, stderr.as_str()), (0, ""));
        let file = shipped("demo");
        let arguments = [&["run", &file, "--out", "out", "--quiet"], &settings[..]].concat();
        assert_eq!(floodsim(folder.path(), &arguments).code, 0);
        let out = folder.path().join("out");
        let run: Value = serde_json::from_str(&std::fs::read_to_string(out.join("run.json")).unwrap()).unwrap();
        assert_eq!(plan.pointer("/particles/bed"), Some(&run["bed_particles"]));
        assert_eq!(plan.pointer("/particles/initial"), run.pointer("/particles/initial"));
        assert_within(&plan, "/particles/peak", &run["particles"]["peak"]);
        assert_within(&plan, "/steps", &run["steps"]);
        assert_within(&plan, "/resolution_m", &20.0.into());
        let parts = run["phase_s"].as_object().unwrap().keys().filter(|key| key.starts_with("compute: ")).count();
        assert!(parts > 4, "{}", run["phase_s"]);
        assert!(
            plan["motion"]["why"]
                .as_str()
                .unwrap()
                .starts_with("for the same CPU time Eulerian particles have the smaller error")
        );
        assert_eq!(plan["motion"]["chosen"], motion);
    }
}

#[test]
fn a_run_that_ends_within_the_measurement_is_told_as_it_is() {
    let settings = [&COARSE[..], &["--set", "time.end=10 s"]].concat();
    let (plan, code, _) = plan("demo", &settings);
    assert_eq!((code, &plan["measured"]["whole_run"]), (0, &true.into()));
    let steps = &plan["measured"]["steps"];
    assert_within(&plan, "/steps", steps);
    assert_eq!(plan["steps"][0], plan["steps"][1]);
    assert!((plan["measured"]["simulated_s"].as_f64().unwrap() - 10.0).abs() < 1e-9);
}

#[test]
fn people_get_a_table() {
    let folder = TempDir::new().unwrap();
    let file = shipped("lake_at_rest");
    let answer = floodsim(folder.path(), &["plan", &file]);
    assert_eq!(answer.code, 0, "{}", answer.stderr);
    for word in ["particles", "memory", "steps", "run time", "disk", "resolution", "would take", "threads"] {
        assert!(answer.stdout.contains(word), "{word}: {}", answer.stdout);
    }
}

#[test]
fn limits_and_faults_are_refused_as_by_check() {
    for (setting, expected, code) in [
        ("limits.particles=1000", 5, "particle-limit"),
        ("limits.memory=1 MB", 5, "memory-limit"),
        ("resolution=50 km", 3, "resolution-too-coarse"),
        ("terrain.layers[0].raster=none.tif", 4, "missing-file"),
    ] {
        let settings = [&COARSE[..], &["--set", setting]].concat();
        let (refused, exit, _) = plan("demo", &settings);
        assert_eq!(exit, expected, "{setting}: {refused}");
        assert!(refused["problems"].as_array().unwrap().iter().any(|problem| problem["code"] == code), "{refused}");
        let folder = TempDir::new().unwrap();
        let file = shipped("demo");
        let checked = floodsim(folder.path(), &[&["check", &file, "--json"], &settings[..]].concat());
        assert_eq!((serde_json::from_str::<Value>(&checked.stdout).unwrap(), checked.code), (refused, expected));
    }
}
