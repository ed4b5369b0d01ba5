//! The program as its users meet it: files in, messages, exit codes and files out.
#![allow(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

mod bad_inputs;
mod bad_scenarios;
mod commands;
mod dam_breaks;
#[path = "../support/mod.rs"]
mod support;
mod whole_runs;

use std::path::Path;

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
