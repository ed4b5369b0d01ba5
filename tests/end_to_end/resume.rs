//! Runs that are cut off and go on: to the same bytes, whenever that was, and not with other inputs.

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::whole_runs::{files, lasting, manifest};
use crate::{changed, feature, floodsim};

/// A plain that falls to the east with a ditch, where a channel comes in from the west; rain, a source, ground that rises.
const SCENARIO: &str = "\
floodsim: 1
crs: local
terrain: dem.asc
roughness: {manning: 0.03}
channels:
  - id: upper
    length: 200 m
    width: 20 m
    bed: 10 m
    slope: 0.01
    upstream: {discharge: {series: q.csv, column: q, unit: m3/s, time_unit: min}}
    joins: {side: west, from: 2020, to: 2040}
boundaries:
  - {edge: east, normal_depth: {slope: 0.01}}
sources:
  - {at: [1150, 2030], discharge: 3 m3/s}
rain: {rate: 200 mm/h}
moving_bed: [{change: change.asc, at: 20 s, share: {series: share.csv}}]
resolution: 5 m
time: {end: 8 min}
outputs: {every: 10 s, sections: sections.geojson, gauges: g.csv}
";

/// A scenario in a folder, with what is set beside it.
struct Scene {
    folder: TempDir,
    scenario: String,
    set: Vec<String>,
}

impl Scene {
    /// One that ships.
    fn shipped(name: &str, set: &[&str]) -> Scene {
        let folder = TempDir::new().unwrap();
        let scenario = format!("{}/scenarios/{name}/scenario.yaml", env!("CARGO_MANIFEST_DIR"));
        Scene { folder, scenario, set: set.iter().map(|&set| set.to_owned()).collect() }
    }

    /// The plain of this file.
    fn plain(changes: &[(&str, &str)]) -> Scene {
        let scene = Scene { folder: TempDir::new().unwrap(), scenario: "s.yaml".into(), set: Vec::new() };
        let grid = |of: &dyn Fn(usize, usize) -> f64| {
            let row = |row: usize| (0..60).map(|column| format!("{}", of(column, row))).collect::<Vec<_>>().join(" ");
            let header = "ncols 60\nnrows 12\nxllcorner 1000\nyllcorner 2000\ncellsize 5\nNODATA_value -9999\n";
            header.to_owned() + &(0..12).map(row).collect::<Vec<_>>().join("\n") + "\n"
        };
        let low = |row: usize| if (4..8).contains(&row) { 0.0 } else { 1.0 };
        scene.write("dem.asc", &grid(&|column, row| 10.0 - 0.05 * (column as f64 + 0.5) + low(row)));
        let rises = |column: usize, row: usize| if (30..34).contains(&column) && row < 6 { 1.5 } else { 0.0 };
        scene.write("change.asc", &grid(&rises));
        scene.write("share.csv", "time_s,share\n0,0\n200,0.4\n300,1\n");
        scene.write("q.csv", "t,q\n0,0\n1,30\n9,10\n700,10\n");
        scene.write("g.csv", "id,x,y\na,1100,2030\nb,1250,2030\n");
        scene.write("sections.geojson", &feature("LineString", "[1200,2059],[1200,2001]"));
        scene.write("s.yaml", &changed(SCENARIO, changes));
        scene
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn arguments(&self, out: &str) -> Vec<String> {
        let run = ["run", &self.scenario, "--out", out, "--quiet", "--threads", "1"].map(str::to_owned);
        let every = ["limits.checkpoint=50 ms".to_owned()];
        let set = self.set.iter().chain(&every).flat_map(|set| ["--set".to_owned(), set.clone()]);
        run.into_iter().chain(set).collect()
    }

    /// Runs it to its end in the folder `name`; returns how long that took.
    fn whole(&self, name: &str) -> Duration {
        std::fs::create_dir(self.path(name)).unwrap();
        let start = Instant::now();
        let mut child = self.start(name, &self.arguments("out"));
        assert_eq!(child.wait().unwrap().code(), Some(0));
        start.elapsed()
    }

    fn start(&self, name: &str, arguments: &[String]) -> Child {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin("floodsim"));
        // Relative paths count from where the run was started.
        let folder = self.path(name);
        let scenario = self.path("s.yaml");
        let arguments = arguments.iter().map(|argument| match argument.as_str() {
            "s.yaml" => scenario.display().to_string(),
            other => other.to_owned(),
        });
        command.current_dir(folder).args(arguments).env("SOURCE_DATE_EPOCH", "0");
        let said = std::fs::File::create(self.path("said")).unwrap();
        command.stdout(Stdio::null()).stderr(said).spawn().unwrap()
    }

    /// Runs it, cuts it off after shares of a time each, and goes on until it is done.
    fn in_pieces(&self, name: &str, (whole, shares): (Duration, &[f64]), signal: &str) {
        std::fs::create_dir(self.path(name)).unwrap();
        let resume = |threads: &str| ["resume", "out", "--quiet", "--threads", threads].map(str::to_owned).to_vec();
        let mut arguments = self.arguments("out");
        for (k, share) in shares.iter().enumerate() {
            let mut child = self.start(name, &arguments);
            std::thread::sleep(whole.mul_f64(*share));
            if child.try_wait().unwrap().is_some() {
                break;
            }
            let kill = format!("kill -{signal} {}", child.id());
            assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
            child.wait().unwrap();
            // Cut off before there was anything to go on from, it begins again.
            if self.path(name).join("out/checkpoint.bin").exists() {
                arguments = resume(if k % 2 == 0 { "2" } else { "1" });
            } else {
                let _ = std::fs::remove_dir_all(self.path(name).join("out"));
                arguments = self.arguments("out");
            }
        }
        if !self.path(name).join("out/maps.nc").exists() || self.path(name).join("out/checkpoint.bin").exists() {
            let code = self.start(name, &arguments).wait().unwrap().code();
            assert_eq!(code, Some(0), "{name}: {}", std::fs::read_to_string(self.path("said")).unwrap());
        }
    }
}

/// Asserts that two folders have the same files, and records that differ in times alone.
#[track_caller]
fn assert_same(scene: &Scene, names: [&str; 2]) {
    let outs = names.map(|name| scene.path(name).join("out"));
    let [one, other] = outs.each_ref().map(|out| {
        let mut record = lasting(out);
        record["command"] = manifest(out)["command"].clone();
        for key in ["checkpoints", "resumed_at_s"] {
            record.as_object_mut().unwrap().remove(key);
        }
        if let Some(estimate) = record["error_estimate"].as_object_mut() {
            estimate.remove("cpu_s");
        }
        record
    });
    assert_eq!(one, other);
    let [one, other] = outs.each_ref().map(|out| files(out));
    assert!(one.keys().eq(other.keys()), "{:?} and {:?}", one.keys(), other.keys());
    // Its scenario has the place of the folder.
    let is_place = |name: &str| ["run.json", "scenario.resolved.yaml"].contains(&name);
    let differing: Vec<&String> =
        one.iter().filter(|(name, bytes)| !is_place(name) && other[*name] != **bytes).map(|(name, _)| name).collect();
    assert!(differing.is_empty(), "{differing:?}");
}

#[track_caller]
fn assert_goes_on(scene: &Scene) {
    let whole = scene.whole("whole");
    for (k, shares) in [&[0.45][..], &[0.75, 0.3], &[0.3, 0.5, 0.2]].into_iter().enumerate() {
        let name = format!("in pieces {k}");
        scene.in_pieces(&name, (whole, shares), if k == 2 { "TERM" } else { "KILL" });
        assert_same(scene, ["whole", &name]);
    }
}

#[test]
fn a_killed_run_goes_on_to_the_same_bytes_on_cells_that_rest() {
    assert_goes_on(&Scene::shipped("demo", &["resolution=40 m", "time.end=15 min", "outputs.every=20 s"]));
}

#[test]
fn a_killed_run_goes_on_to_the_same_bytes_on_cells_that_move() {
    let set = ["resolution=40 m", "time.end=3 min", "outputs.every=10 s", "numerics.motion=lagrangian"];
    assert_goes_on(&Scene::shipped("demo", &set));
    assert_goes_on(&Scene::shipped("spill", &["time.end=20 s", "outputs.every=2 s"]));
}

#[test]
fn a_killed_run_goes_on_to_the_same_bytes_with_particles_of_the_variational_formulation() {
    let methods = ["numerics.formulation=variational", "numerics.motion=lagrangian"];
    let set = ["resolution=40 m", "time.end=2 min", "outputs.every=10 s"];
    assert_goes_on(&Scene::shipped("demo", &[&set[..], &methods].concat()));
}

#[test]
fn a_killed_run_goes_on_to_the_same_bytes_with_a_breach_and_levels() {
    let levels = "resolution={finest: 40 m, coarsest: 80 m}";
    assert_goes_on(&Scene::shipped("breach", &[levels, "time.end=20 min"]));
}

#[test]
fn a_killed_run_goes_on_to_the_same_bytes_with_all_that_brings_water() {
    assert_goes_on(&Scene::plain(&[]));
    // Maps on the raster of the terrain, and errors by a second run.
    let outputs = "outputs: {every: 10 s, cell: terrain, error_estimate: true}";
    let before = "outputs: {every: 10 s, sections: sections.geojson, gauges: g.csv}";
    assert_goes_on(&Scene::plain(&[
        (before, outputs),
        ("moving_bed: [{change: change.asc, at: 20 s, share: {series: share.csv}}]\n", ""),
    ]));
}

/// A run that was cut off, in the folder `out` of the scene.
fn cut_off(scene: &Scene) {
    let mut child = scene.start(".", &scene.arguments("out"));
    let begin = Instant::now();
    while !scene.path("out/checkpoint.before.bin").exists() {
        assert!(begin.elapsed() < Duration::from_secs(60) && child.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(300));
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn a_run_does_not_go_on_with_other_inputs_or_twice() {
    let scene = Scene::plain(&[("time: {end: 8 min}", "time: {end: 10 h}")]);
    cut_off(&scene);
    let there = || floodsim(scene.folder.path(), &["resume", "out", "--quiet"]);
    let dem = std::fs::read(scene.path("dem.asc")).unwrap();
    scene.write("q.csv", "t,q\n0,0\n1,30\n9,20\n700,10\n");
    scene.write("dem.asc", &String::from_utf8(dem.clone()).unwrap().replace("9.975", "9.976"));
    let answer = there();
    assert_eq!(answer.code, 4, "{}", answer.stderr);
    for text in ["error[inputs-changed]", "dem.asc", "q.csv", "\n  remedy  "] {
        assert!(answer.stderr.contains(text), "{}", answer.stderr);
    }
    assert!(!answer.stderr.contains("share.csv"), "{}", answer.stderr);
    // The scenario file itself may change: the run goes on as it was begun.
    scene.write("q.csv", "t,q\n0,0\n1,30\n9,10\n700,10\n");
    std::fs::write(scene.path("dem.asc"), dem).unwrap();
    scene.write("s.yaml", "floodsim: 1\n");
    let mut child = scene.start(".", &["resume", "out", "--quiet"].map(str::to_owned));
    std::thread::sleep(Duration::from_secs(1));
    assert!(child.try_wait().unwrap().is_none());
    let twice = there();
    assert!(twice.code == 8 && twice.stderr.contains("error[output-folder-in-use]"), "{}", twice.stderr);
    child.kill().unwrap();
    child.wait().unwrap();
    let none = floodsim(scene.folder.path(), &["resume", "nowhere"]);
    assert!(none.code == 4 && none.stderr.contains("error[no-checkpoint]"), "{}", none.stderr);
}

#[test]
fn a_report_of_a_killed_run_shows_what_there_is_and_the_run_goes_on_after_it() {
    let scene = Scene::plain(&[]);
    scene.whole("whole");
    std::fs::create_dir(scene.path("other")).unwrap();
    let mut child = scene.start("other", &scene.arguments("out"));
    while !scene.path("other/out/checkpoint.before.bin").exists() {
        assert!(child.try_wait().unwrap().is_none(), "the run has ended");
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let other = scene.path("other");
    let report = floodsim(&other, &["report", "out"]);
    assert_eq!(report.code, 0, "{}", report.stderr);
    assert!(report.stderr.contains("warning: the run was stopped at"), "{}", report.stderr);
    assert!(other.join("out/report/index.html").exists() && other.join("out/tables/gauges.csv").exists());
    assert_eq!(manifest(&other.join("out"))["status"], "stopped");
    std::fs::remove_dir_all(other.join("out/report")).unwrap();
    let resume = ["resume", "out", "--quiet"].map(str::to_owned);
    assert_eq!(scene.start("other", &resume).wait().unwrap().code(), Some(0));
    assert_same(&scene, ["whole", "other"]);
}

#[test]
fn results_are_verified_by_their_checksums() {
    let scene = Scene::plain(&[("time: {end: 8 min}", "time: {end: 30 s}")]);
    assert_eq!(scene.start(".", &scene.arguments("out")).wait().unwrap().code(), Some(0));
    assert!(!scene.path("out/checkpoint.bin").exists());
    let verify = || floodsim(scene.folder.path(), &["verify", "out"]);
    let answer = verify();
    assert!(
        answer.code == 0 && answer.stdout.contains("files are as the run read and wrote them"),
        "{}",
        answer.stderr
    );
    let maps = scene.path("out/maps.nc");
    let mut bytes = std::fs::read(&maps).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&maps, bytes).unwrap();
    std::fs::remove_file(scene.path("out/tables/gauges.csv")).unwrap();
    scene.write("g.csv", "id,x,y\na,1100,2031\n");
    let answer = verify();
    assert_eq!(answer.code, 4);
    assert!(answer.stderr.contains("error[outputs-changed]") && answer.stderr.contains("error[inputs-changed]"));
    for name in ["maps.nc", "tables/gauges.csv", "g.csv"] {
        assert!(answer.stderr.contains(&format!("{name} is not as the run")), "{}", answer.stderr);
    }
    assert_eq!(answer.stderr.matches("is not as the run").count(), 3, "{}", answer.stderr);
}

#[test]
fn a_run_without_checkpoints_leaves_none() {
    let mut scene = Scene::plain(&[("time: {end: 8 min}", "time: {end: 10 h}")]);
    scene.set.push("limits.checkpoint=off".into());
    let mut arguments = scene.arguments("out");
    // The last one on the command line would count.
    arguments.truncate(arguments.len() - 2);
    let mut child = scene.start(".", &arguments);
    let begin = Instant::now();
    while !scene.path("out/fields.partial.nc").exists() {
        assert!(begin.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let answer = floodsim(scene.folder.path(), &["resume", "out"]);
    assert!(answer.code == 4 && answer.stderr.contains("error[no-checkpoint]"), "{}", answer.stderr);
}
