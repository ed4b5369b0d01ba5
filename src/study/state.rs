//! How far the run of a member is, by its folder.

use std::path::{Path, PathBuf};

use super::record::{run_of, scenario_of};
use crate::checksum;
use crate::output::{has_checkpoint, is_in_use};
use crate::plain_file::read_to_string;

/// How far it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// It is to be run.
    New {
        /// Whether something is in its folder.
        replaces: bool,
    },
    /// It was cut off, and can go on.
    CutOff,
    /// Another process runs it.
    InUse,
    /// It is done.
    Done,
    /// It ended, and would end so again: why.
    Failed(String),
}

impl State {
    /// Why the run has no results to count on; none where it is done.
    pub fn lacks(&self) -> Option<&str> {
        match self {
            State::Done => None,
            State::New { .. } => Some("it was not run"),
            State::CutOff => Some("its run was cut off"),
            State::InUse => Some("its run is under way"),
            State::Failed(why) => Some(why),
        }
    }
}

/// The record of a run, as far as it can be read.
pub(super) fn record_of(run: &Path) -> serde_json::Value {
    let record = read_to_string(run.join("run.json")).ok();
    record.and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default()
}

/// The program that ran a member: version and commit.
pub fn program_of(study: &Path, member: usize) -> String {
    program_in(&record_of(&run_of(study, member)))
}

/// The program that the record of a run names.
pub(super) fn program_in(record: &serde_json::Value) -> String {
    let text = |key: &str| record[key].as_str().unwrap_or("unknown");
    format!("{} ({})", text("version"), text("git"))
}

/// The file that says why a member failed before it had a record of its own; its first line is the checksum of the scenario.
fn failure_file(study: &Path, member: usize) -> PathBuf {
    study.join(format!("logs/{member:04}.failed"))
}

/// Keeps why a member failed, or forgets it where it is run again.
///
/// # Errors
/// When the file cannot be written.
pub fn keep_failure(study: &Path, member: usize, why: Option<&str>) -> std::io::Result<()> {
    let file = failure_file(study, member);
    match why {
        Some(why) => std::fs::write(file, format!("{}\n{why}\n", checksum_of(study, member).unwrap_or_default())),
        None if file.exists() => std::fs::remove_file(file),
        None => Ok(()),
    }
}

/// The checksum of the scenario of a member.
fn checksum_of(study: &Path, member: usize) -> Option<String> {
    checksum::of_file(&scenario_of(study, member)).ok().map(|(_, sha256)| sha256)
}

/// The state of a member of the study in a folder.
pub fn state(study: &Path, member: usize) -> State {
    let folder = run_of(study, member);
    if is_in_use(&folder) {
        return State::InUse;
    }
    let scenario = checksum_of(study, member);
    let failure = read_to_string(failure_file(study, member)).unwrap_or_default();
    if let Some((sha256, why)) = failure.split_once('\n')
        && Some(sha256) == scenario.as_deref()
    {
        return State::Failed(why.trim_end().to_owned());
    }
    if !folder.exists() {
        return State::New { replaces: false };
    }
    let record = record_of(&folder);
    if record["scenario_sha256"].as_str() != scenario.as_deref() {
        return State::New { replaces: true };
    }
    match (record["status"].as_str(), record["exit_code"].as_i64()) {
        (Some("done"), Some(0)) => State::Done,
        (Some("done"), _) => State::Failed("it did not pass a quality gate".to_owned()),
        (Some("failed"), Some(6)) => State::Failed("its numerics broke down".to_owned()),
        _ if has_checkpoint(&folder) => State::CutOff,
        _ => State::New { replaces: true },
    }
}
