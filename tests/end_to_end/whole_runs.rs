//! Whole runs of the program: every file there, the same bytes for any number of threads, the same maps for any interval of
//! frames and from the resolved scenario, and a run that ended early is known as such.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::{Answer, floodsim};

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

/// The program, its paths and dates apart from the test's own surroundings.
fn program(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("floodsim"));
    command.current_dir(folder).args(arguments).stdout(Stdio::null()).stderr(Stdio::null());
    command
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

/// Every variable of a NetCDF file: its dimensions, attributes and the bits of its values.
fn variables(path: &Path) -> BTreeMap<String, (String, Vec<u64>)> {
    let file = netcdf::open(path).unwrap();
    let described = |variable: netcdf::Variable| {
        let dimensions: Vec<String> =
            variable.dimensions().iter().map(|d| format!("{}={}", d.name(), d.len())).collect();
        let attributes: Vec<String> =
            variable.attributes().map(|a| format!("{}={:?}", a.name(), a.value().unwrap())).collect();
        let values: Vec<f64> = variable.get_values(..).unwrap();
        let text = format!("{dimensions:?} {attributes:?}");
        (variable.name(), (text, values.into_iter().map(f64::to_bits).collect()))
    };
    file.variables().map(described).collect()
}

/// The global attributes of a NetCDF file without `history`, which holds the command.
fn global_attributes(path: &Path) -> Vec<String> {
    let file = netcdf::open(path).unwrap();
    let attributes = file.attributes().filter(|attribute| attribute.name() != "history");
    attributes.map(|attribute| format!("{}={:?}", attribute.name(), attribute.value().unwrap())).collect()
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
    let maps = variables(&out.join("maps.nc"));
    for map in MAPS {
        assert!(maps.contains_key(map), "maps.nc has no {map}");
    }
    let fields = variables(&out.join("fields.nc"));
    for field in ["depth", "water_level", "velocity_x", "velocity_y"] {
        assert!(fields.contains_key(field), "fields.nc has no {field}");
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
    for name in names {
        let file = name.join("scenario.yaml");
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
    let cases: [(&str, &[&str]); 3] = [("demo", &SHORT_DEMO), ("ritter", &short_ritter), ("lake_at_rest", &short_lake)];
    for (name, arguments) in cases {
        let folder = TempDir::new().unwrap();
        let answer = run(folder.path(), &shipped(name), arguments);
        assert!(answer.stdout.contains("results in out"), "{}", answer.stdout);
        let out = folder.path().join("out");
        assert_whole(&out);
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

#[test]
fn one_and_two_threads_give_equal_bytes() {
    let by_flag = |threads: &str| {
        let folder = TempDir::new().unwrap();
        run(folder.path(), &shipped("demo"), &[&SHORT_DEMO[..], &["--threads", threads]].concat());
        folder
    };
    let (one, two) = (by_flag("1"), by_flag("2"));
    let (one, two) = (one.path().join("out"), two.path().join("out"));
    assert_eq!((&manifest(&one)["threads"], &manifest(&two)["threads"]), (&1.into(), &2.into()));
    assert_eq!(lasting(&one), lasting(&two));
    let (files_one, files_two) = (files(&one), files(&two));
    assert!(files_one.keys().eq(files_two.keys()));
    for (name, bytes) in &files_one {
        if name.ends_with(".nc") {
            // The command with its number of threads is in the global attributes.
            assert!(variables(&one.join(name)) == variables(&two.join(name)), "{name} differs");
        } else if name != "run.json" {
            assert!(*bytes == files_two[name], "{name} differs");
        }
    }

    // With the dates stated and the threads not in the command, nothing at all may differ but times.
    let by_surroundings = |threads: &str| {
        let folder = TempDir::new().unwrap();
        let scenario = shipped("demo");
        let arguments = [&["run", &scenario, "--out", "out"], &SHORT_DEMO[..]].concat();
        let mut command = program(folder.path(), &arguments);
        command.env("SOURCE_DATE_EPOCH", "1704067199").env("RAYON_NUM_THREADS", threads);
        assert!(command.status().unwrap().success());
        folder
    };
    let (one, two) = (by_surroundings("1"), by_surroundings("2"));
    let (one, two) = (one.path().join("out"), two.path().join("out"));
    assert_eq!((&manifest(&one)["threads"], &manifest(&two)["threads"]), (&1.into(), &2.into()));
    let (mut files_one, mut files_two) = (files(&one), files(&two));
    assert_eq!(lasting(&one), lasting(&two));
    files_one.remove("run.json").zip(files_two.remove("run.json")).unwrap();
    for (name, bytes) in &files_one {
        assert!(*bytes == files_two[name], "{name} differs");
    }
    assert!(files_one.len() >= 7 + 2 * MAPS.len() && files_one.len() == files_two.len());
    assert!(global_attributes(&one.join("maps.nc")).iter().any(|a| a.contains("2023-12-31T23:59:59Z")));
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
        let [first, second] = ["first", "out"].map(|run| variables(&folder.path().join(run).join(name)));
        assert!(first == second, "{name} differs");
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
        let frames = netcdf::open(folder.path().join("out/fields.nc")).unwrap().dimension("time").unwrap().len();
        (frames, variables(&folder.path().join("out/maps.nc")))
    };
    let (dense, sparse) = (maps("10 s"), maps("600 s"));
    assert_eq!((dense.0, sparse.0), (67, 3));
    let reached = |maps: &BTreeMap<String, (String, Vec<u64>)>| {
        let missing = f64::from(-9999f32).to_bits();
        maps["arrival_time"].1.iter().filter(|bits| **bits != missing).count()
    };
    assert!(reached(&dense.1) > 1000, "{} cells were reached", reached(&dense.1));
    for (name, map) in &dense.1 {
        assert!(*map == sparse.1[name], "{name} differs");
    }
}

/// Starts a long run of the demonstration and waits until it has written its first frames.
fn start_long_run(folder: &Path) -> Child {
    let arguments = ["run", &shipped("demo"), "--out", "out", "--set", "time.end=10 h", "--set", "outputs.every=1 s"];
    let mut child = program(folder, &arguments).spawn().unwrap();
    let start = Instant::now();
    let partial = folder.join("out/fields.partial.nc");
    while !partial.metadata().is_ok_and(|metadata| metadata.len() > 5_000_000) {
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
        let fields = netcdf::open(out.join("fields.nc")).unwrap();
        let times: Vec<f64> = fields.variable("time").unwrap().get_values(..).unwrap();
        assert!(times.len() > 2 && times.last().is_some_and(|last| *last <= simulated + 1e-6), "{times:?}");
        assert!(variables(&out.join("maps.nc")).contains_key("arrival_time"));
        let report = floodsim(folder.path(), &["report", "out"]);
        assert_eq!(report.code, 0, "{}", report.stderr);
        assert!(report.stderr.contains("warning: the run was stopped at"), "{}", report.stderr);
        let page = std::fs::read_to_string(out.join("report/index.html")).unwrap();
        assert!(page.contains("<p class=\"status bad\"><b>the run was stopped at"));
    }
}

#[test]
fn a_killed_run_is_not_taken_as_whole_but_its_frames_can_be_read() {
    let folder = TempDir::new().unwrap();
    let mut child = start_long_run(folder.path());
    child.kill().unwrap();
    child.wait().unwrap();
    let out = folder.path().join("out");
    assert_eq!(manifest(&out)["status"], "running");
    assert!(!out.join("maps.nc").exists() && !out.join("fields.nc").exists());
    let partial = netcdf::open(out.join("fields.partial.nc")).unwrap();
    assert!(partial.dimension("time").unwrap().len() > 2);
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
