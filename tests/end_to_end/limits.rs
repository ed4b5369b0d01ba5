//! Limits of memory and disk: kept before a run and while it goes on, in words, and without a crash.

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use tempfile::TempDir;

use crate::whole_runs::{files, manifest};
use crate::{Answer, Netcdf, changed, feature, floodsim};

const SCENARIO: &str = "\
floodsim: 1
crs: local
terrain: dem.asc
roughness: {manning: 0.03}
initial: [{reservoir: lake.geojson, level: 12 m}]
resolution: 5 m
time: {end: 60 s}
outputs: {every: 5 s}
";

/// A plain that falls to the east, with a lake in the west of it.
fn plain(changes: &[(&str, &str)]) -> TempDir {
    let folder = TempDir::new().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let row = (0..60).map(|column| format!("{}", 10.0 - 0.05 * f64::from(column))).collect::<Vec<_>>().join(" ");
    let header = "ncols 60\nnrows 40\nxllcorner 1000\nyllcorner 2000\ncellsize 5\nNODATA_value -9999\n";
    write("dem.asc", &(header.to_owned() + &vec![row; 40].join("\n") + "\n"));
    write("lake.geojson", &feature("Polygon", "[[1000,2000],[1100,2000],[1100,2200],[1000,2200],[1000,2000]]"));
    write("s.yaml", &changed(SCENARIO, changes));
    folder
}

/// Asserts that a command ends with a code and these words.
#[track_caller]
fn assert_says(answer: &Answer, code: i32, words: &[&str]) {
    let said = format!("{}{}", answer.stdout, answer.stderr);
    assert_eq!(answer.code, code, "{said}");
    for word in words {
        assert!(said.contains(word), "{word}: {said}");
    }
}

fn count(of: &Path) -> usize {
    std::fs::read_dir(of).map_or(0, Iterator::count)
}

#[test]
fn the_samples_of_gauges_count_in_memory() {
    let mut gauges = "id,x,y\n".to_owned();
    (0..400).for_each(|k| writeln!(gauges, "g{k},{},{}", 1002 + k % 200, 2003 + k / 200).unwrap());
    let folder = plain(&[("every: 5 s", "every: 5 s, gauges: g.csv, gauges_every: 5 ms")]);
    std::fs::write(folder.path().join("g.csv"), gauges).unwrap();
    // 400 gauges, 12 000 samples of 112 bytes: 540 MB.
    for command in ["check", "plan", "run"] {
        let answer = floodsim(folder.path(), &[command, "s.yaml", "--set", "limits.memory=300 MB"]);
        assert_says(&answer, 5, &["memory-limit", "about 623.6 MB", "limit is 300.0 MB"]);
    }
    assert_says(&floodsim(folder.path(), &["check", "s.yaml", "--set", "limits.memory=700 MB"]), 0, &[]);
}

#[test]
fn a_limit_below_what_the_program_takes_says_so() {
    let answer = floodsim(plain(&[]).path(), &["check", "s.yaml", "--set", "limits.memory=50 MB"]);
    assert_says(&answer, 5, &["memory-limit", "the program alone takes 85.0 MB"]);
}

#[test]
fn inputs_that_nobody_counted_end_the_program_at_its_limit() {
    let breaklines =
        "terrain: {layers: [{raster: dem.asc}], breaklines: [{lines: crest.geojson, mode: raise, z: 11 m}]}";
    let folder = plain(&[("terrain: dem.asc", breaklines)]);
    let vertex = |k: u32| format!("[{}.{},{}.5]", 1010 + k % 270, k % 10, 2010 + k / 10_000);
    let vertices = (0..1_500_000).map(vertex).collect::<Vec<_>>().join(",");
    std::fs::write(folder.path().join("crest.geojson"), feature("LineString", &format!("[{vertices}]"))).unwrap();
    for command in ["check", "run"] {
        let answer = floodsim(folder.path(), &[command, "s.yaml", "--set", "limits.memory=100 MB"]);
        assert_says(&answer, 5, &["error[memory-limit]", "limit is 100.0 MB", "remedy"]);
    }
    assert_eq!(count(&folder.path().join("runs")), 0, "nothing is left of it");
}

#[test]
fn a_process_that_gets_no_more_memory_ends_with_words() {
    let folder = plain(&[]);
    let program = assert_cmd::cargo::cargo_bin("floodsim");
    // From what the loader can just do with up to enough.
    for kibibytes in (300..700).step_by(50).map(|megabytes| megabytes * 1000) {
        let line =
            format!("ulimit -v {kibibytes}; exec {} run s.yaml --threads 1 --quiet --overwrite", program.display());
        let output = Command::new("sh").args(["-c", &line]).current_dir(folder.path()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        let code = output.status.code();
        assert!(matches!(code, Some(0 | 5)), "{kibibytes} KiB: {code:?}: {said}");
        assert!(code == Some(0) || !said.is_empty(), "{kibibytes} KiB");
    }
}

#[test]
fn a_run_that_takes_more_of_the_disk_than_it_may_is_refused() {
    let folder = plain(&[]);
    for command in ["check", "plan", "run"] {
        let answer = floodsim(folder.path(), &[command, "s.yaml", "--set", "limits.disk=400 kB"]);
        // 2400 cells of 16 bytes in 13 frames.
        assert_says(
            &answer,
            5,
            &["disk-limit", "takes 499.2 kB of the disk or more", "limit is 400.0 kB", "outputs.every"],
        );
    }
    assert_eq!(count(&folder.path().join("runs")), 0);
    // More than disks have: 6 million cells of output in 60 000 frames.
    let more = ["--set", "outputs.cell=0.1 m", "--set", "outputs.every=1 ms"];
    let answer = floodsim(folder.path(), &[&["check", "s.yaml"], &more[..]].concat());
    assert_says(&answer, 8, &["error[disk-full]", "are free for", "--out"]);
    let doubtful = floodsim(folder.path(), &["plan", "s.yaml", "--set", "limits.disk=600 kB"]);
    assert_says(&doubtful, 0, &["warning[disk-may-fill]"]);
}

#[test]
fn a_run_that_reaches_its_limit_of_the_disk_writes_its_maps_and_goes_on() {
    let long = [("end: 60 s", "end: 40 min"), ("every: 5 s", "every: 2 s")];
    let folder = plain(&long);
    let run = |out: &str, more: &[&str]| {
        let arguments = [&["run", "s.yaml", "--threads", "1", "--quiet", "--out", out], more].concat();
        floodsim(folder.path(), &arguments)
    };
    assert_eq!(run("whole", &[]).code, 0);
    let out = folder.path().join("cut");
    let whole = std::fs::metadata(folder.path().join("whole/fields.nc")).unwrap().len();
    assert!(whole > 100_000);
    // The uncompressed frames take 46 MB.
    let cut = run("cut", &["--set", "limits.disk=46.5 MB", "--set", "limits.checkpoint=20 ms"]);
    assert_says(&cut, 5, &["error[disk-limit]", "floodsim resume"]);
    assert!(out.join("maps.nc").is_file() && out.join("tables/mass_balance.csv").is_file());
    let told = manifest(&out);
    assert_eq!((&told["status"], &told["exit_code"]), (&"failed".into(), &5.into()));
    let other = floodsim(folder.path(), &["resume", "cut", "--set", "resolution=10 m"]);
    assert_says(&other, 2, &["limits alone may be set"]);
    assert_says(&floodsim(folder.path(), &["resume", "cut", "--quiet", "--set", "limits.disk=1 GB"]), 0, &[]);
    for name in ["maps.nc", "fields.nc"] {
        let values = |out: &str| Netcdf::read(&folder.path().join(out).join(name)).variables;
        assert_eq!(values("whole"), values("cut"), "{name}");
    }
    let tables = |out: &str| files(&folder.path().join(out).join("tables"));
    assert_eq!(tables("whole"), tables("cut"));
}
