//! Whole runs of the program: every file there, the same bytes for any number of threads, the same maps for any interval of
//! frames and from the resolved scenario, and a run that ended early is known as such.

mod same_bytes;
mod stopped;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::{Answer, Netcdf, floodsim};

/// The maps of every run; each further threshold of arrival adds its own.
const MAPS: [&str; 9] = [
    "bed_elevation",
    "max_depth",
    "max_water_level",
    "max_speed",
    "max_depth_velocity",
    "arrival_time",
    "time_of_max_depth",
    "flood_duration",
    "hazard_class",
];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The file of a scenario that ships.
fn shipped(name: &str) -> String {
    root().join("scenarios").join(name).join("scenario.yaml").display().to_string()
}

/// The settings that make the demonstration short.
const SHORT_DEMO: [&str; 6] = ["--set", "resolution=20 m", "--set", "outputs.cell=20 m", "--set", "time.end=3 min"];

/// Runs a scenario into the folder `out` below `folder`, with the given further arguments, and asserts that it succeeds.
#[track_caller]
fn run(folder: &Path, scenario: &str, arguments: &[&str]) -> Answer {
    let all = [&["run", scenario, "--out", "out", "--quiet"], arguments].concat();
    let answer = floodsim(folder, &all);
    assert_eq!(answer.code, 0, "{scenario} {arguments:?}: {}", answer.stderr);
    answer
}

pub(crate) fn manifest(out: &Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(out.join("run.json")).unwrap()).unwrap()
}

/// Every file below a folder, relative to it, with its bytes.
pub(crate) fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().display().to_string();
                found.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    found
}

/// The record of a run without what may differ: the command, times, memory and threads.
pub(crate) fn lasting(out: &Path) -> serde_json::Value {
    let mut all = manifest(out);
    for key in ["command", "threads", "wall_s", "cpu_s", "phase_s", "peak_rss_mb", "outputs"] {
        assert!(all.as_object_mut().unwrap().remove(key).is_some(), "run.json has no `{key}`");
    }
    all
}

/// Asserts that a run folder holds every file and value of the contract.
#[track_caller]
fn assert_whole(out: &Path) {
    let all = files(out);
    let mut expected: Vec<String> = [
        "run.json",
        "scenario.resolved.yaml",
        "fields.nc",
        "maps.nc",
        "results.gpkg",
        "tables/gauges.csv",
        "tables/gauge_series.csv",
        "tables/mass_balance.csv",
    ]
    .map(str::to_owned)
    .to_vec();
    expected.extend(MAPS.iter().flat_map(|map| [format!("cog/{map}.tif"), format!("cog/{map}.qml")]));
    for name in &expected {
        assert!(all.get(name).is_some_and(|bytes| !bytes.is_empty()), "{name} is missing or empty");
    }
    assert!(all.keys().all(|name| !name.contains("unfinished") && !name.contains("partial")), "{:?}", all.keys());
    let maps = Netcdf::read(&out.join("maps.nc"));
    for map in MAPS {
        assert!(maps.variables.contains_key(map), "maps.nc has no {map}");
    }
    let fields = Netcdf::read(&out.join("fields.nc"));
    for field in ["depth", "water_level", "velocity_x", "velocity_y"] {
        assert!(fields.variables.contains_key(field), "fields.nc has no {field}");
    }
    let run = manifest(out);
    assert_eq!((&run["status"], &run["exit_code"]), (&"done".into(), &0.into()));
    assert!(run["volume_m3"]["error_relative"].as_f64().unwrap().abs() < 1e-9);
}

#[test]
fn every_scenario_that_ships_passes_the_check() {
    let data = std::env::var_os("FLOODSIM_DATA").map_or_else(|| root().join("../shared/data"), PathBuf::from);
    let mut names: Vec<PathBuf> =
        std::fs::read_dir(root().join("scenarios")).unwrap().map(|entry| entry.unwrap().path()).collect();
    names.sort();
    assert!(names.len() >= 4, "{names:?}");
    for name in names {
        let file = name.join("scenario.yaml");
        // Those of the laboratory lie side by side in one folder; their suite runs them.
        if name.ends_with("laboratory") {
            continue;
        }
        let needs_data = std::fs::read_to_string(&file).unwrap().contains("FLOODSIM_DATA");
        if needs_data && !data.join(name.file_name().unwrap()).exists() {
            eprintln!("skipped: {} is absent; set FLOODSIM_DATA to the folder of the real data", data.display());
            continue;
        }
        let output = Command::new(assert_cmd::cargo::cargo_bin("floodsim"))
            .args(["check", "--json"])
            .arg(&file)
            .env("FLOODSIM_DATA", data.canonicalize().unwrap_or_else(|_| data.clone()))
            .output()
            .unwrap();
        let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(
            (output.status.code(), found["errors"].as_u64()),
            (Some(0), Some(0)),
            "{}: {found:#}",
            file.display()
        );
        println!("{}: {} warnings", file.display(), found["warnings"]);
    }
}

#[test]
fn the_scenarios_run_write_every_file_and_are_reported() {
    let short_lake = ["--set", "time.end=20 s"];
    let short_ritter = ["--set", "time.end=20 s"];
    let short_river = ["--set", "resolution=10 m", "--set", "outputs.cell=10 m", "--set", "time.end=15 min"];
    let short_breach = ["--set", "resolution=20 m", "--set", "time.end=15 min"];
    let cases: [(&str, &[&str]); 5] = [
        ("demo", &SHORT_DEMO),
        ("ritter", &short_ritter),
        ("lake_at_rest", &short_lake),
        ("river_flood", &short_river),
        ("breach", &short_breach),
    ];
    for (name, arguments) in cases {
        let folder = TempDir::new().unwrap();
        let answer = run(folder.path(), &shipped(name), arguments);
        assert!(answer.stdout.contains("results in out"), "{}", answer.stdout);
        let out = folder.path().join("out");
        assert_whole(&out);
        assert_eq!(out.join("sections.nc").exists(), ["river_flood", "breach"].contains(&name));
        let record = &manifest(&out)["breach"];
        assert_eq!(record["began_s"].as_f64(), (name == "breach").then_some(120.0), "{record}");
        let report = floodsim(folder.path(), &["report", "out"]);
        assert_eq!((report.code, report.stderr.as_str()), (0, ""), "{}", report.stdout);
        for line in report.stdout.lines() {
            assert!(folder.path().join(line).metadata().unwrap().len() > 1000, "{line} is empty");
        }
        assert!(report.stdout.contains("out/report/index.html"), "{}", report.stdout);
        // A second run takes the place of the first and of its report.
        let again = floodsim(folder.path(), &["run", &shipped("ritter"), "--out", "out", "--set", "time.end=1 s"]);
        assert_eq!(again.code, 8, "{}", again.stderr);
        let arguments = ["run", &shipped("ritter"), "--out", "out", "--set", "time.end=1 s", "--overwrite"];
        assert_eq!(floodsim(folder.path(), &arguments).code, 0);
        assert!(!out.join("sections.nc").exists() && !out.join("tables/sections.csv").exists());
        assert!(!out.join("report/index.html").exists() && !out.join("cog/arrival_time_0p50m.tif").exists());
    }
}

#[test]
fn a_lake_at_rest_stays_at_rest() {
    let folder = TempDir::new().unwrap();
    run(folder.path(), &shipped("lake_at_rest"), &["--set", "time.end=60 s"]);
    let speed = manifest(&folder.path().join("out"))["max_speed_m_s"].as_f64().unwrap();
    println!("lake at rest, 60 s: greatest speed {speed:.1e} m/s");
    assert!(speed < 1e-10, "{speed:e} m/s");
}

/// The first number after some words of a text.
fn number_after(text: &str, words: &str) -> f64 {
    let rest = text.split_once(words).unwrap_or_else(|| panic!("no `{words}` in {text}")).1;
    rest.split_whitespace().next().unwrap().parse().unwrap()
}

#[test]
fn both_fillings_hold_the_integral_of_level_minus_terrain() {
    let short_lake: &[&str] = &["--set", "time.end=1 s"];
    for (name, short) in [("demo", &SHORT_DEMO[..]), ("lake_at_rest", short_lake)] {
        let mut counts = Vec::new();
        for seeding in ["lattice", "equal_volume"] {
            let folder = TempDir::new().unwrap();
            let method = format!("numerics={{formulation: variational, seeding: {seeding}}}");
            let arguments = [short, &["--set", &method, "--set", "time.end=1 s", "--set", "rain="]].concat();
            let summary = run(folder.path(), &shipped(name), &arguments).stdout;
            let record = manifest(&folder.path().join("out"));
            let initial = record["volume_m3"]["initial"].as_f64().unwrap();
            assert!(number_after(&summary, "to hold its volume: ground changed in ") > 0.0, "{summary}");
            let integral = number_after(&summary, "integral of level minus terrain ");
            // The summary prints seven digits.
            assert!((initial / integral - 1.0).abs() < 1e-6, "{name}, {seeding}: {initial} m3 of {integral} m3");
            assert_eq!(record["methods"]["seeding"], seeding);
            let volumes = summary.split_once("\nparticles: ").unwrap().1;
            let (least, greatest) = (number_after(volumes, " with "), number_after(volumes, " to "));
            assert!((seeding == "equal_volume") == (least.to_bits() == greatest.to_bits()), "{summary}");
            counts.push(record["particles"]["initial"].as_i64().unwrap());
            assert_eq!(counts.last(), Some(&(number_after(&summary, "\nparticles: ") as i64)));
        }
        // One body: as many particles of one volume as there are wet cells.
        assert_eq!(counts[0], counts[1], "{name}");
    }
}

#[test]
fn the_variational_formulation_runs_on_real_ground_through_the_whole_program() {
    let folder = TempDir::new().unwrap();
    let coarse = ["--set", "resolution=40 m", "--set", "outputs.cell=40 m", "--set", "time.end=6 min"];
    run(folder.path(), &shipped("demo"), &[&coarse[..], &["--set", "numerics.formulation=variational"]].concat());
    let out = folder.path().join("out");
    assert_whole(&out);
    let record = manifest(&out);
    assert_eq!(record["methods"]["formulation"], "variational");
    // A drop from the crest of the dam to the outlet, 120 m lower, ends at 49 m/s.
    let speed = record["max_speed_m_s"].as_f64().unwrap();
    assert!((5.0..49.0).contains(&speed), "{speed} m/s");
    let maps = Netcdf::read(&out.join("maps.nc"));
    let reached = maps.values("arrival_time").iter().filter(|time| **time > 0.0).count();
    assert!(reached > 100, "{reached} cells were reached");
}

#[test]
fn a_breakdown_of_the_numerics_is_said_with_time_place_quantity_and_limiter() {
    let folder = TempDir::new().unwrap();
    // Waves that cross a cell in 1e-15 s leave no step to take.
    let arguments = ["run", &shipped("demo"), "--out", "out", "--quiet", "--set", "resolution=40 m"];
    let absurd = ["--set", "numerics.gravity=1e30 m/s2"];
    let answer = floodsim(folder.path(), &[&arguments[..], &absurd].concat());
    assert_eq!((answer.code, answer.stdout.as_str()), (6, ""), "{}", answer.stderr);
    let last = answer.stderr.lines().last().unwrap();
    let parts = ["error: the run broke down at t = ", "step 1", "time step is ", " at 64", "limited by courant"];
    for part in parts {
        assert!(last.contains(part), "no `{part}` in: {last}");
    }
    let record = manifest(&folder.path().join("out"));
    assert_eq!((&record["status"], &record["exit_code"]), (&"failed".into(), &6.into()));
}

#[test]
fn no_core_ignores_a_setting_of_the_numerics() {
    const VARIATIONAL: &str = "formulation: variational";
    const MOVING: &str = "motion: lagrangian";
    let general = vec!["bed: shepard", "bed: moving_least_squares", "cfl: 0.3", "gravity: 9 m/s2", "dry_depth: 2 m"];
    let moving = ["integrator: heun", "seeding: equal_volume"];
    let settings = [
        ("", vec!["reconstruction: none", "stabilisation: lax_friedrichs"]),
        (MOVING, vec!["reconstruction: sharp", "stabilisation: lax_friedrichs"]),
        (
            VARIATIONAL,
            [
                &moving[..],
                &["reconstruction: limited", "kernel: bell", "stabilisation: two_shocks", "bed_slope: steep"],
            ]
            .concat(),
        ),
    ];
    let mut seen: Vec<(String, u64)> = Vec::new();
    for (core, own) in settings {
        let changes = [general.clone(), own].concat();
        for change in std::iter::once("").chain(changes) {
            let folder = TempDir::new().unwrap();
            let parts: Vec<&str> = [core, change].into_iter().filter(|part| !part.is_empty()).collect();
            let methods = format!("numerics={{{}}}", parts.join(", "));
            let coarse = ["--set", "resolution=40 m", "--set", "outputs.cell=40 m", "--set", "time.end=40 s"];
            run(folder.path(), &shipped("demo"), &[&coarse[..], &["--set", &methods]].concat());
            let maps = Netcdf::read(&folder.path().join("out/maps.nc"));
            let sum = maps.values("max_speed").iter().filter(|speed| speed.is_finite()).sum::<f64>();
            assert!(sum > 0.0, "{methods}: no water moves");
            if let Some((other, _)) = seen.iter().find(|(_, bits)| *bits == sum.to_bits()) {
                panic!("`{methods}` gives the same greatest speeds as `{other}`");
            }
            seen.push((methods, sum.to_bits()));
        }
    }
}

#[test]
fn the_phases_of_a_run_account_for_its_time() {
    let folder = TempDir::new().unwrap();
    run(folder.path(), &shipped("demo"), &[&SHORT_DEMO[..], &["--threads", "1"]].concat());
    let run = manifest(&folder.path().join("out"));
    let times: Vec<(&str, f64)> = run["phase_s"]
        .as_object()
        .unwrap()
        .iter()
        .map(|(name, time)| (name.as_str(), time.as_f64().unwrap()))
        .collect();
    let sum =
        |is_part: &dyn Fn(&str) -> bool| times.iter().filter(|(name, _)| is_part(name)).map(|time| time.1).sum::<f64>();
    let share = sum(&|name| !name.contains(": ")) / run["wall_s"].as_f64().unwrap();
    // Beside other work a thread may lose its processor between two phases.
    assert!((0.9..1.001).contains(&share), "{share}: {times:?}");
    for phase in ["compute", "outputs"] {
        let parts = sum(&|name| name.starts_with(&format!("{phase}: ")));
        let share = parts / run["phase_s"][phase].as_f64().unwrap();
        assert!((0.9..1.001).contains(&share), "{phase} {share}: {times:?}");
    }
    assert!(times.iter().any(|(name, _)| *name == "compute: water balance"));
}
