//! Every write, flush, close, rename and deletion of a small run fails once, by itself (`cargo faults`; needs `strace`; a quarter of an hour).
//!
//! Whatever fails, the run ends with exit code 0 or 8. What has its final name is what it is without the fault. A run that ended with 8 goes on to the
//! same files.
#![allow(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

const SCENARIO: &str = "\
floodsim: 1
crs: local
terrain: dem.asc
roughness: {manning: 0.03}
initial: [{reservoir: lake.geojson, level: 12 m}]
boundaries: [{side: east, type: open}]
resolution: 5 m
time: {end: 20 s}
outputs: {every: 4 s, gauges: g.csv, sections: sections.geojson, isochrones: [5 s, 10 s]}
limits: {checkpoint: 20 ms}
";

/// Its end (s).
const END: f64 = 20.0;

/// The calls that are counted.
const CALLS: &str = "openat,pwrite64,write,fsync,ftruncate,rename,unlink,close";

/// Closings before this one are those of the loader of the program.
const FIRST_OPENED: &str = "s.yaml";

fn scene() -> TempDir {
    let folder = TempDir::new().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let row = (0..40).map(|column| format!("{}", 12.0 - 0.1 * f64::from(column))).collect::<Vec<_>>().join(" ");
    let header = "ncols 40\nnrows 12\nxllcorner 1000\nyllcorner 2000\ncellsize 5\n";
    write("dem.asc", &(header.to_owned() + &vec![row; 12].join("\n") + "\n"));
    let polygon = "[[[1010,2010],[1060,2010],[1060,2050],[1010,2050],[1010,2010]]]";
    write("lake.geojson", &format!(r#"{{"type":"Polygon","coordinates":{polygon}}}"#));
    write("sections.geojson", r#"{"type":"LineString","coordinates":[[1100,2059],[1100,2001]]}"#);
    write("g.csv", "id,x,y\na,1040,2030\nb,1150,2030\n");
    write("s.yaml", SCENARIO);
    folder
}

/// Runs the program in a folder under `strace`, which lets a call fail.
fn run(folder: &Path, fault: Option<&str>) -> (Output, String) {
    let _ = std::fs::remove_dir_all(folder.join("out"));
    let mut command = Command::new("strace");
    command.args(["-f", "-qq", "-o", "calls", "-e", &format!("trace={CALLS}")]);
    command.args(fault.into_iter().flat_map(|fault| ["-e".to_owned(), format!("inject={fault}")]));
    command.arg(assert_cmd::cargo::cargo_bin("floodsim"));
    command.args(["run", "s.yaml", "--out", "out", "--quiet", "--threads", "1"]);
    let output = command.current_dir(folder).env("SOURCE_DATE_EPOCH", "0").output().unwrap();
    (output, std::fs::read_to_string(folder.join("calls")).unwrap_or_default())
}

/// The files with final names, without those that hold times and those that a run goes on from.
fn results(out: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![out.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            let name = path.strip_prefix(out).unwrap().display().to_string();
            let is_of_the_way = ["run.json", ".running", "checkpoint", "partial", ".unfinished"];
            if path.is_dir() {
                folders.push(path);
            } else if !is_of_the_way.iter().any(|part| name.contains(part)) {
                files.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    files
}

/// What is wrong after a fault; nothing where all is as it should be.
fn wrong(folder: &Path, output: &Output, whole: &BTreeMap<String, Vec<u8>>) -> Option<String> {
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let found = results(&folder.join("out"));
    let record = std::fs::read_to_string(folder.join("out/run.json")).unwrap_or_default();
    let record: serde_json::Value = serde_json::from_str(&record).unwrap_or_default();
    // A run that ended before its time has results of that time.
    let is_at_end = record["simulated_s"].as_f64().is_some_and(|time| time >= END);
    let damaged = found.iter().find(|(name, bytes)| whole.get(*name) != Some(bytes));
    if let Some((name, _)) = damaged.filter(|_| is_at_end) {
        return Some(format!("{name} is damaged"));
    }
    match output.status.code() {
        Some(0) if found.len() == whole.len() => None,
        Some(0) => Some(format!("{} of {} files, and exit code 0", found.len(), whole.len())),
        Some(8) if !said.contains("panicked") => {
            if !folder.join("out/checkpoint.bin").exists() && !folder.join("out/checkpoint.before.bin").exists() {
                // It had not begun to write.
                return (!found.is_empty()).then(|| "results, and nothing to go on from".to_owned());
            }
            let mut resume = Command::new(assert_cmd::cargo::cargo_bin("floodsim"));
            resume.args(["resume", "out", "--quiet"]).current_dir(folder).env("SOURCE_DATE_EPOCH", "0");
            let resumed = resume.output().unwrap();
            let is_same = resumed.status.success() && results(&folder.join("out")) == *whole;
            (!is_same).then(|| format!("it does not go on: {}", String::from_utf8_lossy(&resumed.stderr)))
        }
        code => Some(format!("exit code {code:?}: {said}")),
    }
}

/// Lets every call of a kind fail once, each in a run of its own.
fn assert_bears(call: &str, error: &str) {
    let scene = scene();
    let (whole, calls) = run(scene.path(), None);
    assert!(whole.status.success(), "{}", String::from_utf8_lossy(&whole.stderr));
    let whole = results(&scene.path().join("out"));
    let is_it = |line: &&str| line.split_whitespace().nth(1).is_some_and(|what| what.starts_with(&format!("{call}(")));
    let before = calls[..calls.find(FIRST_OPENED).unwrap()].lines().filter(is_it).count();
    let count = calls.lines().filter(is_it).count();
    let (mut zero, mut problems) = (0, Vec::new());
    for k in before + 1..=count {
        let (output, _) = run(scene.path(), Some(&format!("{call}:error={error}:when={k}")));
        zero += usize::from(output.status.success());
        if let Some(problem) = wrong(scene.path(), &output, &whole) {
            problems.push(format!("{call} {k} of {count}, {error}: {problem}"));
        }
    }
    println!("{call}, {error}: {} calls, {zero} of which the run does without", count - before);
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

#[test]
fn disks_that_are_full_at_any_write() {
    assert_bears("pwrite64", "ENOSPC");
}

#[test]
fn disks_that_are_full_at_any_write_in_a_row() {
    assert_bears("write", "ENOSPC");
}

#[test]
fn disks_that_fail_when_files_are_flushed() {
    assert_bears("fsync", "EIO");
}

#[test]
fn disks_that_fail_when_files_are_cut() {
    assert_bears("ftruncate", "EIO");
}

#[test]
fn disks_that_fail_when_files_get_their_names() {
    assert_bears("rename", "EIO");
}

#[test]
fn disks_that_fail_when_files_are_deleted() {
    assert_bears("unlink", "EIO");
}

#[test]
fn disks_that_fail_when_files_are_closed() {
    assert_bears("close", "EIO");
}
