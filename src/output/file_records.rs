//! The files of a run in `run.json`, and the end of a run that can't write that file anew.

use std::io::Write;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::plain_file;

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

/// What `run.json` says of a run that has not ended.
pub(super) const RUNNING: &str = "\"status\": \"running\"";

/// Says in the `run.json` of a folder how its run ended, where that says that it is still under way and can't be written anew: the program is
/// leaving, or the disk is full. Where it has no room beside the file it writes over it; a failure is left as it is.
pub fn mark_ended(folder: &Path, status: &str, exit_code: i32) {
    let path = folder.join("run.json");
    let Ok(text) = plain_file::read_to_string(&path) else { return };
    let ended = text.replacen(RUNNING, &format!("\"status\": \"{status}\""), 1);
    let ended = ended.replacen("\"exit_code\": null", &format!("\"exit_code\": {exit_code}"), 1);
    // Another name than that of the file that may be being written.
    let temporary = folder.join(".unfinished.ended.json");
    // A link there would lead elsewhere.
    let _ = std::fs::remove_file(&temporary);
    let written = std::fs::File::create_new(&temporary).and_then(|mut file| file.write_all(ended.as_bytes()));
    if written.and_then(|()| std::fs::rename(&temporary, &path)).is_err() {
        let _ = std::fs::remove_file(&temporary);
        // No longer than the file is.
        if ended.len() <= text.len() {
            let over = format!("{ended:length$}", length = text.len());
            let _ = std::fs::OpenOptions::new()
                .write(true)
                .open(&path)
                .and_then(|mut file| file.write_all(over.as_bytes()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_is_written_over_the_record_where_there_is_no_room_beside_it() {
        let record =
            |status: &str, code: &str| format!("{{\n  \"status\": \"{status}\",\n  \"exit_code\": {code}\n}}\n");
        for has_room in [true, false] {
            let place = tempfile::tempdir().unwrap();
            let path = place.path().join("run.json");
            if !has_room {
                std::fs::create_dir(place.path().join(".unfinished.ended.json")).unwrap();
            }
            std::fs::write(&path, record("running", "null")).unwrap();
            mark_ended(place.path(), "failed", 8);
            let ended = std::fs::read_to_string(&path).unwrap();
            assert_eq!(ended.trim_end(), record("failed", "8").trim_end());
            // What has ended has ended.
            mark_ended(place.path(), "stopped", 143);
            assert_eq!(std::fs::read_to_string(&path).unwrap(), ended);
        }
    }
}
