//! The program as its users meet it: files in, messages, exit codes and files out.
#![allow(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

mod auto_resolution;
mod bad_inputs;
mod bad_scenarios;
mod boundaries;
mod breaches;
mod cells_in_part;
mod channels;
mod channels_alone;
mod commands;
mod compare;
mod dam_breaks;
mod doubtful_inputs;
mod error_estimate;
mod findings_of_runs;
mod foreign_inputs;
mod hot_start;
mod levels;
mod levels_planned;
mod limits;
mod lines;
mod maps_on_terrain;
mod mistaken_files;
mod moving_bed;
mod outlines;
mod package;
mod part_of_terrain;
mod plan;
mod rain;
mod resume;
mod smallest_inputs;
mod studies;
mod terrain;
mod tracers;
mod walls;
mod whole_runs;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::LazyLock;
use std::sync::mpsc::{Sender, channel};

use assert_cmd::Command;

/// What the program answered.
struct Answer {
    /// Exit code.
    code: i32,
    /// Results.
    stdout: String,
    /// Progress and errors.
    stderr: String,
}

/// Runs the program in a folder.
fn floodsim(folder: &Path, arguments: &[&str]) -> Answer {
    let output = Command::cargo_bin("floodsim").unwrap().current_dir(folder).args(arguments).output().unwrap();
    Answer {
        code: output.status.code().unwrap(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

/// Runs `s.yaml` in a folder into `out`; returns `run.json` and what the program said.
#[track_caller]
fn run_scene(folder: &Path, out: &str, options: &[&str]) -> (serde_json::Value, Answer) {
    let answer = floodsim(folder, &[&["run", "s.yaml", "--out", out, "--quiet"][..], options].concat());
    assert_eq!(answer.code, 0, "{}", answer.stderr);
    let record = std::fs::read_to_string(folder.join(out).join("run.json")).unwrap();
    (serde_json::from_str(&record).unwrap(), answer)
}

/// A GeoJSON feature with such a geometry.
fn feature(kind: &str, coordinates: &str) -> String {
    let geometry = format!(r#"{{"type":"{kind}","coordinates":[{coordinates}]}}"#);
    format!(r#"{{"type":"Feature","properties":{{}},"geometry":{geometry}}}"#)
}

/// Asserts that the check of `s.yaml` ends with this exit code and says all these texts, and that each error has a remedy.
#[track_caller]
fn assert_check(folder: &Path, code: i32, expected: &[&str]) {
    let check = floodsim(folder, &["check", "s.yaml"]);
    for text in expected {
        assert!(check.stdout.contains(text), "check does not say `{text}`, but\n{}", check.stdout);
    }
    assert_eq!(check.code, code, "{}", check.stdout);
    for problem in check.stdout.split("error[").skip(1) {
        assert!(problem.contains("\n  remedy  "), "no way out of: {problem}");
    }
}

/// A scenario with texts replaced, each of which must be in it.
#[track_caller]
fn changed(scenario: &str, changes: &[(&str, &str)]) -> String {
    let mut text = scenario.to_owned();
    for (from, to) in changes {
        assert!(text.contains(from), "`{from}` is not in the scenario");
        text = text.replace(from, to);
    }
    text
}

/// Does something with NetCDF files.
///
/// All of it is done on one thread: on any other than the first, HDF5 writes of attributes that it looks for in vain.
fn with_netcdf<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> T {
    type Work = Box<dyn FnOnce() + Send>;
    static WORKER: LazyLock<Sender<Work>> = LazyLock::new(|| {
        let (sender, receiver) = channel::<Work>();
        std::thread::spawn(move || receiver.into_iter().for_each(|work| work()));
        sender
    });
    let (answer, result) = channel();
    WORKER.send(Box::new(move || drop(answer.send(work())))).unwrap();
    result.recv().unwrap_or_else(|_| panic!("a NetCDF file could not be read or written"))
}

/// A NetCDF file as it is read back.
struct Netcdf {
    /// Lengths of the dimensions.
    dimensions: BTreeMap<String, usize>,
    /// Global attributes.
    attributes: BTreeMap<String, String>,
    /// Of each variable its dimensions and attributes, and its values where they are numbers.
    variables: BTreeMap<String, (String, Vec<f64>)>,
}

impl Netcdf {
    /// Reads a whole file.
    fn read(path: &Path) -> Netcdf {
        let path = path.to_path_buf();
        with_netcdf(move || {
            let file = netcdf::open(&path).unwrap();
            let text = |a: netcdf::Attribute| (a.name().to_owned(), format!("{:?}", a.value().unwrap()));
            let variable = |variable: netcdf::Variable| {
                let is_text = variable.vartype() == netcdf::types::NcVariableType::String;
                let dimensions: Vec<_> = variable.dimensions().iter().map(|d| (d.name(), d.len())).collect();
                let attributes: Vec<_> = variable.attributes().map(text).collect();
                let values = if is_text { Vec::new() } else { variable.get_values(..).unwrap() };
                (variable.name(), (format!("{dimensions:?} {attributes:?}"), values))
            };
            Netcdf {
                dimensions: file.dimensions().map(|d| (d.name(), d.len())).collect(),
                attributes: file.attributes().map(text).collect(),
                variables: file.variables().map(variable).collect(),
            }
        })
    }

    /// The values of a variable.
    fn values(&self, name: &str) -> &[f64] {
        &self.variables[name].1
    }

    /// Everything but the global attributes, with the bits of the values.
    fn bits(&self) -> BTreeMap<&str, (&str, Vec<u64>)> {
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect();
        self.variables.iter().map(|(name, (text, values))| (name.as_str(), (text.as_str(), bits(values)))).collect()
    }
}
