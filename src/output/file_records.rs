//! The files of a run in `run.json`, and how a signal is told there.

use std::path::Path;

use serde::{Deserialize, Serialize};

/// An input file.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
pub struct InputFile {
    /// The path as the scenario names it.
    pub path: String,
    /// SHA-256 of its bytes, in hexadecimal digits.
    pub sha256: String,
}

/// A file that a run wrote.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
pub struct OutputFile {
    /// The path in its folder.
    pub path: String,
    /// Its size.
    pub bytes: u64,
    /// SHA-256 of its bytes, in hexadecimal digits.
    pub sha256: String,
}

/// The checkpoints of a run.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct CheckpointRecord {
    /// How many were written.
    pub count: usize,
    /// Time that they took (s).
    pub wall_s: f64,
    /// Size of the last one (bytes).
    pub bytes: u64,
}

/// Says in the `run.json` of a folder that a signal stopped its run, where that is still under way. Whoever calls it leaves the program, and can do
/// nothing about a failure.
pub fn mark_stopped(folder: &Path, exit_code: i32) {
    let path = folder.join("run.json");
    let Ok(text) = std::fs::read_to_string(&path) else { return };
    let text = text.replacen("\"status\": \"running\"", "\"status\": \"stopped\"", 1);
    let text = text.replacen("\"exit_code\": null", &format!("\"exit_code\": {exit_code}"), 1);
    // Another name than that of the file that may be being written.
    let temporary = folder.join(".unfinished.stopped.json");
    let _ = std::fs::write(&temporary, text).and_then(|()| std::fs::rename(&temporary, &path));
}
