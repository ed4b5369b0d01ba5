//! `checkpoint.bin`: the state of a run, from which it goes on to the same bytes.
//!
//! A line that names the format, a line of JSON that says of which run it is, the state in the format of `postcard`, and the SHA-256 of all that. The
//! checkpoint before stays as `checkpoint.before.bin`: one of both is whole, whenever the run or the machine ends.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::file_records::RUNNING;
use super::folder::{RunFolder, output_error};
use crate::checksum::{Checked, LENGTH, of_bytes};
use crate::error::{Error, Problem, ProblemKind};
use crate::plain_file;

const NEWEST: &str = "checkpoint.bin";
const BEFORE: &str = "checkpoint.before.bin";

/// The first line.
const FORMAT: &str = "floodsim checkpoint 1\n";

/// Bytes that are handed on at once.
const BUFFER: usize = 1 << 20;

/// Writes a checkpoint: of which run it is, and its state. Returns its size (bytes).
///
/// # Errors
/// When it cannot be written; the one before stays.
pub fn write_checkpoint(folder: &RunFolder, run: &impl Serialize, state: &impl Serialize) -> Result<u64, Error> {
    let mut size = 0;
    let write = |path: &Path| {
        let written = || -> Result<u64, Box<dyn std::error::Error>> {
            let mut file = BufWriter::with_capacity(BUFFER, Checked::new(File::create(path)?));
            file.write_all(FORMAT.as_bytes())?;
            serde_json::to_writer(&mut file, run)?;
            file.write_all(b"\n")?;
            if let Err(error) = postcard::to_io(state, &mut file) {
                // It says nothing of the cause; what could not be written can't be flushed.
                file.flush()?;
                return Err(error.into());
            }
            let checked = file.into_inner().map_err(std::io::IntoInnerError::into_error)?;
            let (mut file, bytes, checksum) = checked.finish();
            file.write_all(&checksum)?;
            Ok(bytes + LENGTH)
        };
        size = written().map_err(|cause| output_error(path, cause))?;
        Ok(())
    };
    let (newest, before) = (folder.file(NEWEST), folder.file(BEFORE));
    let keep = || if newest.exists() { fs::rename(&newest, &before) } else { Ok(()) };
    folder.write_after(NEWEST, write, keep)?;
    Ok(size)
}

/// Whether the run of a folder can go on and has not said how it ended, or has no maps: then what it computed is still to be written.
pub fn is_cut_off(folder: &Path) -> bool {
    let record = plain_file::read_to_string(folder.join("run.json")).unwrap_or_default();
    has_checkpoint(folder) && (record.contains(RUNNING) || !folder.join("maps.nc").exists())
}

/// Whether the run of a folder has something to go on from.
pub fn has_checkpoint(folder: &Path) -> bool {
    [NEWEST, BEFORE].iter().any(|name| folder.join(name).exists())
}

/// A whole checkpoint of a folder.
pub struct Checkpoint<R> {
    /// Of which run it is.
    pub run: R,
    path: PathBuf,
    file: BufReader<File>,
}

impl<R: DeserializeOwned> Checkpoint<R> {
    /// The newest whole checkpoint of a folder.
    ///
    /// # Errors
    /// `no-checkpoint` where there is none.
    pub fn find(folder: &Path) -> Result<Self, Problem> {
        let mut causes = Vec::new();
        for name in [NEWEST, BEFORE] {
            match Self::open(folder.join(name)) {
                Ok(found) => return Ok(found),
                Err(cause) => causes.push(format!("{name}: {cause}")),
            }
        }
        let message = format!("{} holds no checkpoint from which a run could go on", folder.display());
        Err(Problem::error(ProblemKind::Input, "no-checkpoint", "", message).with_cause(causes.join("; ")).with_remedy(
            "run the scenario again; a run that is done keeps none, and `limits.checkpoint: off` writes none",
        ))
    }

    fn open(path: PathBuf) -> Result<Self, String> {
        let said = |cause: std::io::Error| cause.to_string();
        let mut file = BufReader::with_capacity(BUFFER, plain_file::open(&path).map_err(said)?);
        let length = file.get_ref().metadata().map_err(said)?.len();
        let (_, found) = of_bytes(file.by_ref().take(length.saturating_sub(LENGTH))).map_err(said)?;
        let mut stated = Vec::new();
        file.read_to_end(&mut stated).map_err(said)?;
        if stated != found {
            return Err("its bytes are not those that were written".to_owned());
        }
        file.seek(SeekFrom::Start(0)).map_err(said)?;
        let (mut format, mut run) = (String::new(), String::new());
        file.read_line(&mut format).map_err(said)?;
        if format != FORMAT {
            return Err("it has the format of another version".to_owned());
        }
        file.read_line(&mut run).map_err(said)?;
        let run = serde_json::from_str(&run).map_err(|cause| cause.to_string())?;
        Ok(Checkpoint { run, path, file })
    }

    /// The state that it holds.
    ///
    /// # Errors
    /// When it cannot be read, or is that of another program.
    pub fn into_state<S: DeserializeOwned>(self) -> Result<S, Error> {
        let mut scratch = [0; 256];
        let read = postcard::from_io((self.file, &mut scratch));
        read.map(|(state, _)| state)
            .map_err(|cause| Error::Internal(format!("{}: the state cannot be read: {cause}", self.path.display())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_whole_checkpoint_counts() {
        let place = tempfile::tempdir().unwrap();
        let folder = RunFolder::create(place.path(), false).unwrap();
        let found = || Checkpoint::<String>::find(place.path());
        assert_eq!(found().err().map(|problem| problem.code), Some("no-checkpoint"));
        let numbers = vec![f64::NAN, -0.0, 1.0 / 3.0, f64::MIN_POSITIVE / 8.0, f64::INFINITY];
        let texts: Vec<String> = (0..100).map(|k| format!("a name of some length, {k}")).collect();
        for k in 0..3_u64 {
            let size = write_checkpoint(&folder, &format!("run\n{k}"), &(k, &numbers, &texts)).unwrap();
            assert_eq!(size, fs::metadata(place.path().join(NEWEST)).unwrap().len());
        }
        let state = || {
            let found = found().unwrap();
            let run = found.run.clone();
            let state: (u64, Vec<f64>, Vec<String>) = found.into_state().unwrap();
            (run, state)
        };
        let (run, (k, same, names)) = state();
        assert_eq!((run.as_str(), k, names), ("run\n2", 2, texts));
        let bits = |numbers: &[f64]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&same), bits(&numbers));
        // One bit of it is wrong, or it was cut short: the one before counts.
        let newest = place.path().join(NEWEST);
        let whole = fs::read(&newest).unwrap();
        for damaged in [0, 40, whole.len() - 60, whole.len() - 1] {
            let mut bytes = whole.clone();
            bytes[damaged] ^= 4;
            fs::write(&newest, bytes).unwrap();
            assert_eq!(state().0, "run\n1", "{damaged}");
        }
        for length in [0, 10, whole.len() / 2, whole.len() - 1] {
            fs::write(&newest, &whole[..length]).unwrap();
            assert_eq!(state().0, "run\n1", "{length}");
        }
        // What can go on is cut off while its record says that it runs, and where it has no maps.
        for (status, maps, expected) in
            [("running", true, true), ("running", false, true), ("stopped", false, true), ("stopped", true, false)]
        {
            folder
                .write("run.json", serde_json::json!({"status": status}).to_string().replace(':', ": ").as_bytes())
                .unwrap();
            if maps {
                folder.write("maps.nc", b"").unwrap()
            } else {
                let _ = fs::remove_file(folder.file("maps.nc"));
            }
            assert_eq!(is_cut_off(place.path()), expected, "{status} {maps}");
        }
        folder.write("fields.partial.nc", b"frames").unwrap();
        folder.delete_way().unwrap();
        folder.delete_way().unwrap();
        assert!(found().is_err() && !folder.file("fields.partial.nc").exists());
    }
}
