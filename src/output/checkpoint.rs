//! `checkpoint.bin`: the state of a run, from which it goes on to the same bytes.
//!
//! A line that names the format, a line of JSON that says of which run it is, the state in the format of `postcard`, and the SHA-256 of all that. The
//! checkpoint before stays as `checkpoint.before.bin`: one of both is whole, whenever the run or the machine ends.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

use super::folder::{RunFolder, output_error};
use crate::error::{Error, Problem, ProblemKind};

const NEWEST: &str = "checkpoint.bin";
const BEFORE: &str = "checkpoint.before.bin";

/// The first line.
const FORMAT: &str = "floodsim checkpoint 1\n";

/// Bytes of a SHA-256.
const DIGEST: u64 = 32;

/// Bytes that are handed on at once.
const BUFFER: usize = 1 << 20;

/// Writes on, and takes the digest of what passes.
struct Digesting<W> {
    inner: W,
    digest: Sha256,
    bytes: u64,
}

impl<W: Write> Write for Digesting<W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.digest.update(&bytes[..written]);
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.inner.flush()
    }
}

/// Writes a checkpoint: of which run it is, and its state. Returns its size (bytes).
///
/// # Errors
/// When it cannot be written; the one before stays.
pub fn write_checkpoint(folder: &RunFolder, run: &impl Serialize, state: &impl Serialize) -> Result<u64, Error> {
    let mut size = 0;
    let write = |path: &Path| {
        let written = || -> Result<u64, Box<dyn std::error::Error>> {
            let digesting = Digesting { inner: File::create(path)?, digest: Sha256::new(), bytes: 0 };
            let mut file = BufWriter::with_capacity(BUFFER, digesting);
            file.write_all(FORMAT.as_bytes())?;
            serde_json::to_writer(&mut file, run)?;
            file.write_all(b"\n")?;
            let file = postcard::to_io(state, file)?;
            let Digesting { mut inner, digest, bytes } =
                file.into_inner().map_err(std::io::IntoInnerError::into_error)?;
            inner.write_all(&digest.finalize())?;
            Ok(bytes + DIGEST)
        };
        size = written().map_err(|cause| output_error(path, cause))?;
        Ok(())
    };
    let (newest, before) = (folder.file(NEWEST), folder.file(BEFORE));
    let keep = || if newest.exists() { fs::rename(&newest, &before) } else { Ok(()) };
    folder.write_after(NEWEST, write, keep)?;
    Ok(size)
}

/// Deletes what a run that has ended would have gone on from: the checkpoints, and then the files that they count on.
///
/// # Errors
/// When it cannot be deleted.
pub fn delete_checkpoints(folder: &RunFolder) -> Result<(), Error> {
    for name in [NEWEST, BEFORE, "fields.partial.nc", "channels.partial.nc"] {
        let path = folder.file(name);
        match fs::remove_file(&path) {
            Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => return Err(output_error(&path, cause)),
            _ => {}
        }
    }
    Ok(())
}

/// Whether a folder has a checkpoint and no maps of a run that ended: the run was cut off.
pub fn is_cut_off(folder: &Path) -> bool {
    folder.join(NEWEST).exists() && !folder.join("maps.nc").exists()
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
        let mut file = BufReader::with_capacity(BUFFER, File::open(&path).map_err(said)?);
        let length = file.get_ref().metadata().map_err(said)?.len();
        let mut digest = Sha256::new();
        let mut state = file.by_ref().take(length.saturating_sub(DIGEST));
        loop {
            let bytes = state.fill_buf().map_err(said)?;
            if bytes.is_empty() {
                break;
            }
            digest.update(bytes);
            let count = bytes.len();
            state.consume(count);
        }
        let mut stated = Vec::new();
        file.read_to_end(&mut stated).map_err(said)?;
        if stated != digest.finalize().as_slice() {
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
        delete_checkpoints(&folder).unwrap();
        delete_checkpoints(&folder).unwrap();
        assert!(found().is_err());
    }
}
