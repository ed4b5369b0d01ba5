//! Whole runs of the program: every file there, the same bytes for any number of threads, the same maps for any interval of
//! frames and from the resolved scenario, and a run that ended early is known as such.

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

fn manifest(out: &Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(out.join("run.json")).unwrap()).unwrap()
}

/// Every file below a folder, relative to it, with its bytes.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
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
fn lasting(out: &Path) -> serde_json::Value {
    let mut all = manifest(out);
    for key in ["command", "threads", "wall_s", "cpu_s", "phase_s", "peak_rss_mb"] {
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
            let method = format!("numerics={{motion: lagrangian, seeding: {seeding}}}");
            let arguments = [short, &["--set", &method, "--set", "time.end=1 s"]].concat();
            let summary = run(folder.path(), &shipped(name), &arguments).stdout;
            let record = manifest(&folder.path().join("out"));
            let initial = record["volume_m3"]["initial"].as_f64().unwrap();
            assert!(number_after(&summary, "to hold its volume: ground changed in ") > 0.0, "{summary}");
            let integral = number_after(&summary, "integral of level minus terrain ");
            // The summary prints seven digits.
            assert!((initial / integral - 1.0).abs() < 1e-6, "{name}, {seeding}: {initial} m3 of {integral} m3");
            assert_eq!(record["methods"]["seeding"], seeding);
            let volumes = summary.split_once("Lagrangian particles: ").unwrap().1;
            let (least, greatest) = (number_after(volumes, " with "), number_after(volumes, " to "));
            assert!((seeding == "equal_volume") == (least.to_bits() == greatest.to_bits()), "{summary}");
            counts.push(record["particles"]["initial"].as_i64().unwrap());
            assert_eq!(counts.last(), Some(&(number_after(&summary, "Lagrangian particles: ") as i64)));
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
        (MOVING, [&moving[..], &["reconstruction: none", "kernel: wendland_c2", "stabilisation: two_waves"]].concat()),
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
fn one_and_two_threads_give_equal_bytes() {
    // All in one folder, since the record of a run holds it.
    let folder = TempDir::new().unwrap();
    let scenario = shipped("demo");
    let run_as = |name: &str, threads: &str, by_flag: bool| {
        let flag: &[&str] = if by_flag { &["--threads", threads] } else { &[] };
        let mut command = Command::new(assert_cmd::cargo::cargo_bin("floodsim"));
        command.args(["run", &scenario, "--out", "out", "--quiet"]).args(SHORT_DEMO).args(flag);
        command.current_dir(folder.path()).stdout(Stdio::null()).stderr(Stdio::null());
        if !by_flag {
            command.env("SOURCE_DATE_EPOCH", "1704067199").env("RAYON_NUM_THREADS", threads);
        }
        assert!(command.status().unwrap().success());
        let out = folder.path().join(name);
        std::fs::rename(folder.path().join("out"), &out).unwrap();
        assert_eq!(manifest(&out)["threads"].to_string(), threads);
        out
    };
    let (one, two) = (run_as("one", "1", true), run_as("two", "2", true));
    assert_eq!(lasting(&one), lasting(&two));
    let (files_one, files_two) = (files(&one), files(&two));
    assert!(files_one.keys().eq(files_two.keys()) && files_one.len() >= 8 + 2 * MAPS.len());
    for (name, bytes) in &files_one {
        if name.ends_with(".nc") {
            // The date, and the command with its number of threads, are in the global attributes.
            let (mut one, mut two) = (Netcdf::read(&one.join(name)), Netcdf::read(&two.join(name)));
            for attribute in ["date_created", "history"] {
                one.attributes.remove(attribute).zip(two.attributes.remove(attribute)).unwrap();
            }
            assert!(one.bits() == two.bits() && one.attributes == two.attributes, "{name} differs");
        } else if name != "run.json" {
            assert!(*bytes == files_two[name], "{name} differs");
        }
    }

    // With the date stated and the threads not in the command, nothing at all may differ but the record of times.
    let (one, two) = (run_as("stated one", "1", false), run_as("stated two", "2", false));
    assert_eq!(lasting(&one), lasting(&two));
    let (files_one, files_two) = (files(&one), files(&two));
    assert!(files_one.keys().eq(files_two.keys()));
    for (name, bytes) in files_one.iter().filter(|(name, _)| *name != "run.json") {
        assert!(*bytes == files_two[name], "{name} differs");
    }
    assert!(Netcdf::read(&one.join("maps.nc")).attributes["date_created"].contains("2023-12-31T23:59:59Z"));
}

#[test]
fn what_is_left_out_is_not_written_and_changes_nothing_of_the_rest() {
    let folder = TempDir::new().unwrap();
    let run_with = |parts: &str, out: &str| {
        let write = format!("outputs.write={parts}");
        let settings = [&SHORT_DEMO[..], &["--set", &write]].concat();
        run(folder.path(), &shipped("demo"), if parts.is_empty() { &SHORT_DEMO } else { &settings });
        std::fs::rename(folder.path().join("out"), folder.path().join(out)).unwrap();
        folder.path().join(out)
    };
    let whole = run_with("", "whole");
    let files_whole = files(&whole);
    let is_of = |name: &str, parts: &[&str]| {
        let part = match name {
            "fields.nc" => "fields",
            "maps.nc" => "maps",
            "results.gpkg" => "gpkg",
            _ => name.split_once('/').map_or("always", |(folder, _)| folder),
        };
        part == "always" || parts.contains(&part)
    };
    for (number, parts) in
        [&["maps", "tables"][..], &["fields"], &["tables"], &["cog", "gpkg"], &[]].into_iter().enumerate()
    {
        let out = run_with(&format!("[{}]", parts.join(",")), &format!("out{number}"));
        let found = files(&out);
        let expected: Vec<&String> = files_whole.keys().filter(|name| is_of(name, parts)).collect();
        assert_eq!(found.keys().collect::<Vec<_>>(), expected, "{parts:?}");
        for name in expected.into_iter().filter(|name| name.starts_with("cog/") || name.starts_with("tables/")) {
            assert!(found[name] == files_whole[name], "{parts:?}: {name} differs");
        }
        for name in ["maps.nc", "fields.nc"].into_iter().filter(|name| is_of(name, parts)) {
            assert!(
                Netcdf::read(&whole.join(name)).bits() == Netcdf::read(&out.join(name)).bits(),
                "{parts:?}: {name}"
            );
        }
        let (one, two) = (manifest(&whole), manifest(&out));
        assert!(one["not_written"].is_null());
        let left_out = ["fields", "maps", "cog", "gpkg", "tables", "sections", "channels"];
        let left_out: Vec<&str> = left_out.into_iter().filter(|part| !parts.contains(part)).collect();
        assert_eq!(two["not_written"], serde_json::json!(left_out));
        for key in ["volume_m3", "gates", "steps", "particle_evaluations", "max_speed_m_s"] {
            assert_eq!(one[key], two[key], "{parts:?}: {key}");
        }
    }
    let report = floodsim(folder.path(), &["report", "out2"]);
    assert!(report.code == 4 && report.stderr.contains("add `maps` to `outputs.write`"), "{}", report.stderr);
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
    assert!((0.98..1.001).contains(&share), "{share}: {times:?}");
    for phase in ["compute", "outputs"] {
        let parts = sum(&|name| name.starts_with(&format!("{phase}: ")));
        let share = parts / run["phase_s"][phase].as_f64().unwrap();
        assert!((0.98..1.001).contains(&share), "{phase} {share}: {times:?}");
    }
    assert!(times.iter().any(|(name, _)| *name == "compute: water balance"));
}

#[test]
fn the_resolved_scenario_gives_the_same_maps() {
    let folder = TempDir::new().unwrap();
    run(folder.path(), &shipped("demo"), &SHORT_DEMO);
    let resolved = folder.path().join("resolved.yaml");
    std::fs::rename(folder.path().join("out"), folder.path().join("first")).unwrap();
    // Its paths are absolute: it runs from anywhere.
    std::fs::copy(folder.path().join("first/scenario.resolved.yaml"), &resolved).unwrap();
    run(folder.path(), &resolved.display().to_string(), &[]);
    for name in ["maps.nc", "fields.nc"] {
        let [first, second] = ["first", "out"].map(|run| Netcdf::read(&folder.path().join(run).join(name)));
        assert!(first.bits() == second.bits(), "{name} differs");
    }
    let text = |run: &str| std::fs::read_to_string(folder.path().join(run).join("scenario.resolved.yaml")).unwrap();
    let without_folder = |text: String| -> Vec<String> {
        text.lines().filter(|line| !line.trim_start().starts_with("folder:")).map(str::to_owned).collect()
    };
    assert_eq!(without_folder(text("first")), without_folder(text("out")));
}

#[test]
fn the_maps_are_the_same_for_any_interval_of_frames() {
    let maps = |every: &str| {
        let folder = TempDir::new().unwrap();
        let every = format!("outputs.every={every}");
        let longer = [&SHORT_DEMO[..4], &["--set", "time.end=11 min", "--set", &every]].concat();
        run(folder.path(), &shipped("demo"), &longer);
        let frames = Netcdf::read(&folder.path().join("out/fields.nc")).dimensions["time"];
        (frames, Netcdf::read(&folder.path().join("out/maps.nc")))
    };
    let ((frames_dense, dense), (frames_sparse, sparse)) = (maps("10 s"), maps("600 s"));
    assert_eq!((frames_dense, frames_sparse), (67, 3));
    let reached = dense.values("arrival_time").iter().filter(|time| **time >= 0.0).count();
    assert!(reached > 1000, "{reached} cells were reached");
    let (dense, sparse) = (dense.bits(), sparse.bits());
    for (name, map) in &dense {
        assert!(*map == sparse[name], "{name} differs");
    }
}

/// Starts a long run of the demonstration and waits until it has written its first frames.
fn start_long_run(folder: &Path) -> Child {
    start_long_run_by(folder, Command::new(assert_cmd::cargo::cargo_bin("floodsim")))
}

/// The same by a command that is the program, or becomes it.
fn start_long_run_by(folder: &Path, mut command: Command) -> Child {
    let arguments = ["run", &shipped("demo"), "--out", "out", "--set", "time.end=10 h", "--set", "outputs.every=1 s"];
    command.current_dir(folder).args(arguments).stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().unwrap();
    let start = Instant::now();
    let partial = folder.join("out/fields.partial.nc");
    while !partial.metadata().is_ok_and(|metadata| metadata.len() > 30_000_000) {
        assert!(start.elapsed() < Duration::from_secs(60), "no frames after a minute");
        assert!(child.try_wait().unwrap().is_none(), "the run ended by itself");
        std::thread::sleep(Duration::from_millis(20));
    }
    child
}

#[cfg(unix)]
#[test]
fn a_terminated_run_closes_its_files_and_says_so() {
    for (signal, code) in [("TERM", 143), ("INT", 130)] {
        let folder = TempDir::new().unwrap();
        let mut child = start_long_run(folder.path());
        let kill = format!("kill -{signal} {}", child.id());
        assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(code));
        let out = folder.path().join("out");
        let record = manifest(&out);
        assert_eq!((&record["status"], &record["exit_code"]), (&"stopped".into(), &code.into()));
        let simulated = record["simulated_s"].as_f64().unwrap();
        assert!(simulated > 0.0 && simulated < 36_000.0);
        assert!(!out.join("fields.partial.nc").exists());
        let fields = Netcdf::read(&out.join("fields.nc"));
        let times = fields.values("time");
        assert!(times.len() > 2 && times.last().is_some_and(|last| *last <= simulated + 1e-6), "{times:?}");
        assert!(Netcdf::read(&out.join("maps.nc")).variables.contains_key("arrival_time"));
        let report = floodsim(folder.path(), &["report", "out"]);
        assert_eq!(report.code, 0, "{}", report.stderr);
        assert!(report.stderr.contains("warning: the run was stopped at"), "{}", report.stderr);
        let page = std::fs::read_to_string(out.join("report/index.html")).unwrap();
        assert!(page.contains("<p class=\"status bad\"><b>the run was stopped at"));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_hang_up_stops_a_run_that_is_not_to_outlive_its_terminal() {
    let send = |signal: &str, child: &Child| {
        let kill = format!("kill -{signal} {}", child.id());
        assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    };
    for (disposition, code) in [("--default-signal=HUP", 129), ("--ignore-signal=HUP", 143)] {
        let folder = TempDir::new().unwrap();
        let mut command = Command::new("env");
        command.arg(disposition).arg(assert_cmd::cargo::cargo_bin("floodsim"));
        let mut child = start_long_run_by(folder.path(), command);
        send("HUP", &child);
        if code == 143 {
            std::thread::sleep(Duration::from_secs(1));
            assert!(child.try_wait().unwrap().is_none(), "the run under nohup ended");
            send("TERM", &child);
        }
        assert_eq!(child.wait().unwrap().code(), Some(code));
        let out = folder.path().join("out");
        assert_eq!((&manifest(&out)["status"], &manifest(&out)["exit_code"]), (&"stopped".into(), &code.into()));
        assert!(!out.join("fields.partial.nc").exists() && out.join("maps.nc").exists());
    }
}

#[test]
fn a_killed_run_is_not_taken_as_whole_but_its_frames_can_be_read() {
    let folder = TempDir::new().unwrap();
    let mut child = start_long_run(folder.path());
    // While it lives, nobody else may write there.
    let mixed = floodsim(folder.path(), &["run", &shipped("ritter"), "--out", "out", "--overwrite"]);
    assert_eq!(mixed.code, 8, "{}", mixed.stderr);
    assert!(mixed.stderr.contains("error[output-folder-in-use] --out"), "{}", mixed.stderr);
    assert!(mixed.stderr.contains(&format!("process {}", child.id())), "{}", mixed.stderr);
    child.kill().unwrap();
    child.wait().unwrap();
    let out = folder.path().join("out");
    assert_eq!(manifest(&out)["status"], "running");
    assert!(!out.join("maps.nc").exists() && !out.join("fields.nc").exists());
    let partial = Netcdf::read(&out.join("fields.partial.nc"));
    let times = partial.values("time").to_vec();
    assert!(times.len() > 2 && times.windows(2).all(|pair| pair[1] > pair[0]), "{times:?}");
    let report = floodsim(folder.path(), &["report", "out"]);
    assert_eq!((report.code, report.stdout.as_str()), (4, ""));
    assert!(report.stderr.contains("error[unfinished-run]") && report.stderr.contains("remedy"), "{}", report.stderr);
    assert!(!out.join("report").exists());
    // The next run takes its place when told to, and leaves nothing of it.
    let next = ["run", &shipped("ritter"), "--out", "out", "--set", "time.end=1 s"];
    assert_eq!(floodsim(folder.path(), &next).code, 8);
    assert_eq!(floodsim(folder.path(), &[&next[..], &["--overwrite"]].concat()).code, 0);
    assert_whole(&out);
}
