//! `matrix` and `reduce`: many runs of one scenario, by hand-computed values of still water.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::{Netcdf, feature, floodsim};

/// A basin of 200 m by 100 m, whose bed is at 10 m in the west and at 11.2 m in the east. Its water rests.
const SCENARIO: &str = "\
floodsim: 1
title: Basin
crs: local
terrain: {layers: [{raster: dem.asc}]}
roughness: {manning: 0.03}
initial: [{reservoir: all.geojson, level: 11 m}]
boundaries: [{side: all, type: closed}]
resolution: 10 m
time: {end: 10 s}
outputs: {every: 10 s, gauges: g.csv, write: [maps, cog, tables]}
";

fn basin() -> TempDir {
    let folder = TempDir::new().unwrap();
    let row = |_| (0..20).map(|column| if column < 10 { "10" } else { "11.2" }).collect::<Vec<_>>().join(" ");
    let header = "ncols 20\nnrows 10\nxllcorner 1000\nyllcorner 2000\ncellsize 10\n";
    write(folder.path(), "dem.asc", &(header.to_owned() + &(0..10).map(row).collect::<Vec<_>>().join("\n") + "\n"));
    let all = "[[1000,2000],[1200,2000],[1200,2100],[1000,2100],[1000,2000]]";
    write(folder.path(), "all.geojson", &feature("Polygon", all));
    write(folder.path(), "g.csv", "id,x,y\n\"west, deep\",1050,2050\neast,1150,2050\n");
    write(folder.path(), "s.yaml", SCENARIO);
    folder
}

fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).unwrap();
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap()
}

#[track_caller]
fn assert_says(text: &str, expected: &[&str]) {
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for expected in expected {
        assert!(words.contains(expected), "`{expected}` is not in\n{text}");
    }
}

/// Levels of five members; the roughness changes nothing of still water.
const LEVELS: &str = "\
study: 1
title: Levels
base: s.yaml
folder: levels
vary:
  - {key: \"initial[0].level\", name: level, values: [11 m, 11.5 m, 12 m, 12.5 m, 13 m]}
  - {key: roughness.factor, range: [0.5, 2]}
samples: 2
";

#[test]
fn quantiles_are_those_of_the_waters() {
    let scene = basin();
    let folder = scene.path();
    write(folder, "study.yaml", LEVELS);
    let made = floodsim(folder, &["matrix", "study.yaml", "--jobs", "2", "--quiet"]);
    assert_eq!((made.code, made.stderr.as_str()), (0, ""));
    assert_says(&made.stdout, &["10 members, 10 done"]);
    assert_says(&read(folder, "levels/members.csv"), &["number,case,variant,level,roughness.factor 1,1,,11 m,"]);
    let reduced = floodsim(folder, &["reduce", "levels"]);
    assert_eq!((reduced.code, reduced.stderr.as_str()), (0, ""), "{}", reduced.stdout);
    // The west is 1 to 3 m deep; the east .3 to 1.8 m where the level reaches it: in 8 of 10 runs.
    assert_says(
        &reduced.stdout,
        &[
            "Levels: 10 of 10 members",
            "flooded area m2 10 of 10 10000.000 20000.000 20000.000 level +0.71",
            "west, deep max_depth_m 10 of 10 1.000 2.000 3.000 level +1.00",
            "east max_depth_m 8 of 10 0.000 0.800 1.800 level +1.00",
        ],
    );
    let maps = Netcdf::read(&folder.join("levels/reduced/statistics.nc"));
    let expected = [
        ("probability_flooded", 1.0, 0.8),
        ("probability_depth_0p50m", 1.0, 0.6),
        ("probability_depth_2p00m", 0.6, 0.0),
        ("max_depth_p05", 1.0, 0.0),
        ("max_depth_p50", 2.0, 0.8),
        ("max_depth_p95", 3.0, 1.8),
        ("max_depth_envelope", 3.0, 1.8),
        // Still water: H5 from 2 m, H4 from 1.2 m, H3 from .5 m on.
        ("probability_hazard_h4", 0.8, 0.4),
        ("probability_hazard_h6", 0.0, 0.0),
        ("hazard_class_envelope", 5.0, 4.0),
    ];
    for (name, west, east) in expected {
        for (index, value) in maps.values(name).iter().enumerate() {
            let expected = if index % 20 < 10 { west } else { east };
            assert!((value - expected).abs() < 1e-6, "{name} at {index}: {value} for {expected}");
        }
    }
    let fill = maps.values("arrival_time_p05")[0];
    assert!(fill < -9000.0, "water that stands nowhere rises arrives nowhere: {fill}");
    assert_says(&read(folder, "levels/reduced/tables/ranking.csv"), &["gauge,east,max_depth_m,1,level,1.0000"]);
    assert!(folder.join("levels/reduced/cog/probability_flooded.qml").exists());
    assert_says(&read(folder, "levels/reduced/report/index.html"), &["Probability of inundation", "level"]);
    members_are_runs_by_hand(folder);
}

/// A member gives the same bytes as its scenario run by hand, and as the base with the same values; another call runs nothing again.
fn members_are_runs_by_hand(folder: &Path) {
    let hand = floodsim(folder, &["levels/scenarios/0003.yaml", "--out", "hand", "--quiet"]);
    assert_eq!(hand.code, 0, "{}", hand.stderr);
    let members = read(folder, "levels/members.csv");
    let factor = members.lines().nth(3).and_then(|line| line.rsplit(',').next()).unwrap();
    let factor = format!("roughness.factor={factor}");
    let set = ["--set", "initial[0].level=12 m", "--set", &factor, "--quiet", "--out", "base"];
    assert_eq!(floodsim(folder, &[&["s.yaml"][..], &set].concat()).code, 0);
    for other in ["hand", "base"] {
        for name in ["tables/gauges.csv", "tables/gauge_series.csv", "tables/mass_balance.csv"] {
            assert_eq!(
                read(folder, &format!("levels/runs/0003/{name}")),
                read(folder, &format!("{other}/{name}")),
                "{name}"
            );
        }
        let [member, own] = ["levels/runs/0003", other].map(|run| Netcdf::read(&folder.join(run).join("maps.nc")));
        assert!(member.bits() == own.bits(), "the maps of {other} are others");
    }
    let before = read(folder, "levels/runs/0003/run.json");
    let again = floodsim(folder, &["matrix", "levels"]);
    assert_eq!((again.code, again.stderr.as_str()), (0, ""), "no member runs again");
    assert_eq!(read(folder, "levels/runs/0003/run.json"), before);
    // From elsewhere it is the same study.
    std::fs::create_dir(folder.join("sub")).unwrap();
    let elsewhere = floodsim(&folder.join("sub"), &["matrix", "../study.yaml"]);
    assert_eq!((elsewhere.code, elsewhere.stderr.as_str()), (0, ""));
    // What another program ran is not mixed with what this one runs.
    write(folder, "levels/runs/0003/run.json", &before.replace("\"version\": \"", "\"version\": \"0.0."));
    let mixed = floodsim(folder, &["matrix", "levels"]);
    assert_eq!(mixed.code, 8, "{}", mixed.stderr);
    assert_says(&mixed.stderr, &["error[study-changed]", "member 3 by floodsim 0.0."]);
    assert_says(&floodsim(folder, &["reduce", "levels"]).stdout, &["run by different programs: "]);
    let again = floodsim(folder, &["matrix", "levels", "--overwrite"]);
    assert_eq!(again.code, 0, "{}", again.stderr);
    assert_says(&again.stderr, &["member 3: done", "10 of 10 done"]);
}

#[test]
fn variants_differ_by_their_increment() {
    let scene = basin();
    let folder = scene.path();
    let study = "\
study: 1
base: s.yaml
folder: pairs
vary: [{key: \"initial[0].level\", times: true, values: [1, 1.1]}, {key: roughness.manning, values: [0.02, 0.04]}]
variants:
  - {name: failure}
  - {name: none, set: [\"initial[0].level=10.5 m\"]}
";
    write(folder, "study.yaml", study);
    assert_eq!(floodsim(folder, &["matrix", "study.yaml", "--quiet"]).code, 0);
    // Levels of 11 and 12.1 m; the variant decides on its own.
    let members = read(folder, "pairs/members.csv");
    assert_says(&members, &["1,1,failure,11 m,0.02", "2,1,none,,0.02", "5,3,failure,12.1 m,0.02", "8,4,none,,0.04"]);
    let reduced = floodsim(folder, &["reduce", "study.yaml", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&reduced.stdout).unwrap();
    let names: Vec<&str> =
        json["groups"].as_array().unwrap().iter().map(|group| group["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["failure", "none", "failure_less_none"]);
    let maps = Netcdf::read(&folder.join("pairs/reduced/failure_less_none/statistics.nc"));
    let (west, east) = (0, 15);
    for (name, in_west, in_east) in [
        ("max_depth_increment_p05", 0.5, 0.0),
        ("max_depth_increment_p95", 1.6, 0.9),
        ("probability_max_depth_increment", 1.0, 0.5),
    ] {
        let values = maps.values(name);
        assert!((values[west] - in_west).abs() < 1e-6 && (values[east] - in_east).abs() < 1e-6, "{name}: {values:?}");
    }
}

#[test]
fn members_that_fail_are_named_and_left_out() {
    let scene = basin();
    let folder = scene.path();
    write(
        folder,
        "study.yaml",
        "study: 1\nbase: s.yaml\nfolder: st\nvary: [{key: limits.particles, values: [1000, 10]}]\n",
    );
    let empty = floodsim(folder, &["matrix", "study.yaml", "--write-only"]);
    assert_eq!(empty.code, 0, "{}", empty.stderr);
    assert_says(&floodsim(folder, &["reduce", "st"]).stderr, &["error[no-members]"]);
    let made = floodsim(folder, &["matrix", "study.yaml"]);
    assert_eq!(made.code, 7, "{}", made.stderr);
    assert_says(&made.stderr, &["member 1: done", "member 2: failed (exit code 5: error[", "1 of 2 members failed"]);
    let reduced = floodsim(folder, &["reduce", "st"]);
    assert_eq!(reduced.code, 0, "{}", reduced.stderr);
    assert_says(&reduced.stdout, &["1 of 2 members", "left out member 2: exit code 5"]);
    // A record that was changed by hand leads nowhere else.
    let record = read(folder, "st/study.json");
    write(
        folder,
        "st/study.json",
        &record.replace("\"variants\": [\n    \"\"", "\"variants\": [\n    \"../../elsewhere\""),
    );
    assert_says(
        &floodsim(folder, &["reduce", "st"]).stderr,
        &["error[no-study]", "`../../elsewhere` is no name of a variant"],
    );
    write(folder, "st/study.json", &record);
    // Another study in its place, and more of the same.
    write(
        folder,
        "study.yaml",
        "study: 1\nbase: s.yaml\nfolder: st\nvary: [{key: limits.particles, values: [2000, 10]}]\n",
    );
    assert_says(&floodsim(folder, &["matrix", "study.yaml"]).stderr, &["error[study-changed]", "member 1 differs"]);
    write(
        folder,
        "study.yaml",
        "study: 1\nbase: s.yaml\nfolder: st\nvary: [{key: limits.particles, values: [2000]}]\n",
    );
    let replaced = floodsim(folder, &["matrix", "study.yaml", "--overwrite", "--only", "1"]);
    assert_eq!(replaced.code, 2, "{}", replaced.stderr);
    let replaced = floodsim(folder, &["matrix", "study.yaml", "--overwrite"]);
    assert_eq!(replaced.code, 0, "{}", replaced.stderr);
    assert_says(&replaced.stdout, &["1 members, 1 done"]);
    assert!(!folder.join("st/scenarios/0002.yaml").exists());
    assert_says(&floodsim(folder, &["matrix", "st", "--only", "2"]).stderr, &["the study has the members 1 to 1"]);
}

#[test]
fn members_without_maps_are_not_reduced() {
    let scene = basin();
    let folder = scene.path();
    write(folder, "s.yaml", &SCENARIO.replace("[maps, cog, tables]", "[tables]"));
    write(
        folder,
        "study.yaml",
        "study: 1\nbase: s.yaml\nfolder: st\nvary: [{key: roughness.manning, values: [0.03]}]\n",
    );
    assert_eq!(floodsim(folder, &["matrix", "study.yaml", "--quiet"]).code, 0);
    assert_says(&floodsim(folder, &["reduce", "st"]).stderr, &["error[not-written]", "outputs.write"]);
}

#[test]
fn problems_of_a_study_come_with_place_and_remedy() {
    let scene = basin();
    let folder = scene.path();
    let refused = |text: &str, code: i32, expected: &[&str]| {
        write(folder, "study.yaml", &format!("study: 1\nbase: s.yaml\nfolder: refused\n{text}\n"));
        let answer = floodsim(folder, &["matrix", "study.yaml"]);
        assert_eq!(answer.code, code, "{}", answer.stderr);
        assert_says(&answer.stderr, expected);
        assert!(!folder.join("refused").exists());
    };
    refused("samples: 3", 3, &["error[nothing-varies]"]);
    let several = "vary:\n  - {key: roughness.manning, range: [0.05, 0.03]}\n  - {key: time.end, range: [1 h 30 min, 2 h]}\n  \
                   - {key: a, triangular: [1 m, 2, 3 m]}\n  - {key: b, times: true, range: [1 m, 2 m]}\n  - {key: c}";
    refused(
        several,
        3,
        &[
            "error[not-a-distribution] vary[0].range (study.yaml:5:",
            "error[not-an-amount] vary[1].range (study.yaml:6:",
            "`1 h 30 min` is not one number",
            "different units",
            "factors (`times: true`) have no unit",
            "error[missing-key] vary[4]",
        ],
    );
    refused(
        "variants: [{name: a b}, {name: c}, {name: c}]",
        3,
        &["`a b` is no name", "`c` is no name", "error[variant-name]"],
    );
    refused(
        "vary: [{key: roughness.maning, values: [0.03]}]",
        3,
        &["error[member-refused]", "unknown key `maning`", "in member 1 ("],
    );
    refused(
        "vary: [{key: roughness.manning, range: [0.4, 0.8]}]\nsamples: 8",
        3,
        &["error[range] roughness.manning", "is out of range", "in member", "more"],
    );
    refused("vary: [{key: rain.rate, times: true, range: [1, 2]}]", 3, &["error[nothing-to-multiply] rain.rate"]);
    let many =
        "vary: [{key: roughness.manning, values: [0.03, 0.04]}, {key: roughness.factor, range: [1, 2]}]\nsamples: 5001";
    refused(many, 3, &["error[too-many-members]", "10002 members"]);
    refused("vary: [{key: roughness.manning, values: [0.03], range: [1, 2]}]", 3, &["error[conflict]"]);
    let twice = "vary: [{key: roughness.manning, values: [0.03]}, {key: roughness, values: [a]}, {key: outputs.folder, values: [x]}]";
    refused(twice, 3, &["error[conflict] vary[1]", "one holds the other", "error[conflict] vary[2]", "cannot vary"]);
    let part =
        "vary: [{key: resolution, values: [20 m]}]\nvariants: [{name: a}, {name: b, set: [\"resolution.finest=5 m\"]}]";
    refused(part, 3, &["error[conflict] variants[1]", "sets a part of `resolution`"]);
    folders_that_are_none_of_a_study_are_refused(folder);
}

fn folders_that_are_none_of_a_study_are_refused(folder: &Path) {
    assert_says(&floodsim(folder, &["matrix", "nothing.yaml"]).stderr, &["error[unreadable-file]"]);
    assert_says(&floodsim(folder, &["reduce", "."]).stderr, &["error[no-study]", "study.json"]);
    std::fs::create_dir(folder.join("refused")).unwrap();
    write(folder, "refused/mine.txt", "");
    write(
        folder,
        "study.yaml",
        "study: 1\nbase: s.yaml\nfolder: refused\nvary: [{key: roughness.manning, values: [0.03]}]\n",
    );
    assert_says(
        &floodsim(folder, &["matrix", "study.yaml"]).stderr,
        &["error[output-folder-not-empty]", "choose another `folder`"],
    );
}

#[test]
fn a_study_that_is_stopped_goes_on() {
    let scene = basin();
    let folder = scene.path();
    // Members that take a second or two each.
    let study = "\
study: 1
base: s.yaml
folder: long
vary:
  - {key: roughness.manning, values: [0.03, 0.031, 0.032]}
  - {key: time.end, values: [20 min]}
";
    let wavy = SCENARIO.replace("{reservoir: all.geojson, level: 11 m}", "{reservoir: part.geojson, level: 13 m}");
    write(folder, "part.geojson", &feature("Polygon", "[[1000,2000],[1040,2000],[1040,2030],[1000,2030],[1000,2000]]"));
    write(
        folder,
        "s.yaml",
        &wavy.replace("resolution: 10 m", "resolution: 2 m").replace("every: 10 s", "every: 10 min"),
    );
    write(folder, "study.yaml", study);
    let arguments = ["matrix", "study.yaml", "--jobs", "2", "--threads", "1"];
    let program = assert_cmd::cargo::cargo_bin("floodsim");
    let start = || {
        let mut command = Command::new(&program);
        command.current_dir(folder).args(arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    };
    let begin = Instant::now();
    let mut child = start();
    while !folder.join("long/runs/0002/run.json").exists() && begin.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(5));
    }
    let stopped = Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert!(stopped.success());
    assert_eq!(child.wait().unwrap().code(), Some(143));
    let whole = floodsim(folder, &arguments);
    assert_eq!(whole.code, 0, "{}", whole.stderr);
    assert_says(&whole.stdout, &["3 members, 3 done"]);
    let hand = floodsim(folder, &["long/scenarios/0002.yaml", "--out", "hand", "--quiet"]);
    assert_eq!(hand.code, 0, "{}", hand.stderr);
    assert_eq!(read(folder, "hand/tables/gauge_series.csv"), read(folder, "long/runs/0002/tables/gauge_series.csv"));
    let said = read(folder, "long/logs/0002.txt");
    assert!(said.matches("floodsim ").count() >= 2, "it went on, or began again: {said}");
}
