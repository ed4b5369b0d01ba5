//! How far the run of a member is, by its folder.

use std::path::Path;

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

/// The state of a member of the study in a folder.
pub fn state(study: &Path, member: usize) -> State {
    let folder = run_of(study, member);
    if !folder.exists() {
        return State::New { replaces: false };
    }
    if is_in_use(&folder) {
        return State::InUse;
    }
    let record = read_to_string(folder.join("run.json")).ok();
    let record = record.and_then(|text| serde_json::from_str::<serde_json::Value>(&text).ok()).unwrap_or_default();
    let scenario = checksum::of_file(&scenario_of(study, member)).ok().map(|(_, sha256)| sha256);
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
