//! Who holds a run folder: the run that has its file locked.

use std::fs::{self, TryLockError};
use std::io::{ErrorKind, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::fs::OFlags;

use crate::error::{Problem, ProblemKind};

/// Name of the file by which a run holds its folder; while the run lives, it is locked.
pub(super) const HOLD: &str = ".running";

/// The locked file of a run that is under way.
///
/// The system lets go of the lock when the process ends, however it ends: what a killed run leaves stands in nobody's way.
#[derive(Debug)]
pub(super) struct Hold {
    path: PathBuf,
    _file: fs::File,
}

impl Drop for Hold {
    fn drop(&mut self) {
        // Best effort: without its lock the file holds nobody up.
        let _ = fs::remove_file(&self.path);
    }
}

impl Hold {
    /// Takes the folder, or says why not.
    pub fn take(folder: &Path) -> Result<Hold, Problem> {
        /// Another run that looks at the lock has it for a moment.
        const TRIALS: usize = 20;
        const PAUSE: Duration = Duration::from_millis(10);
        let path = folder.join(HOLD);
        let failed = |cause: std::io::Error| unwritable(folder, &cause.to_string());
        for _ in 0..TRIALS {
            let mut options = no_link();
            let mut file = options.write(true).create(true).truncate(false).open(&path).map_err(failed)?;
            match file.try_lock() {
                // The run before may have deleted the file after it was opened here.
                Ok(()) if !is_same_file(&file, &path) => continue,
                Ok(()) => {}
                // Some network drives know no locks.
                Err(TryLockError::Error(cause)) if cause.kind() == ErrorKind::Unsupported => {}
                Err(TryLockError::Error(cause)) => return Err(failed(cause)),
                Err(TryLockError::WouldBlock) => {
                    std::thread::sleep(PAUSE);
                    continue;
                }
            }
            file.set_len(0).and_then(|()| write!(file, "{}", std::process::id())).map_err(failed)?;
            return Ok(Hold { path, _file: file });
        }
        Err(in_use(folder))
    }
}

/// Whether an open file is the one of that path.
fn is_same_file(file: &fs::File, path: &Path) -> bool {
    let identity = |metadata: &fs::Metadata| (metadata.dev(), metadata.ino());
    matches!((file.metadata(), fs::metadata(path)), (Ok(open), Ok(there)) if identity(&open) == identity(&there))
}

/// Opens a file to be read, but none that a link leads to, and without waiting for the writer of a pipe: somebody else may have laid it there.
fn no_link() -> fs::OpenOptions {
    let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK;
    let mut options = fs::OpenOptions::new();
    options.read(true).custom_flags(flags.bits().cast_signed());
    options
}

/// Whether a run that is under way holds the folder.
pub fn is_held(folder: &Path) -> bool {
    let file = no_link().open(folder.join(HOLD));
    file.is_ok_and(|file| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)))
}

pub(super) fn in_use(folder: &Path) -> Problem {
    let read = |mut file: fs::File| std::io::read_to_string(&mut file);
    let process = no_link().open(folder.join(HOLD)).and_then(read).ok().filter(|number| !number.is_empty());
    let process = process.map_or_else(|| "another process".to_owned(), |number| format!("process {number}"));
    Problem::error(
        ProblemKind::Output,
        "output-folder-in-use",
        "outputs.folder",
        format!("the output folder {} is in use by a run that is under way", folder.display()),
    )
    .with_cause(format!("{process} writes to it, and the files of both would be mixed"))
    .with_remedy("wait for its end, or choose another folder with --out")
}

/// The problem of a folder that can't be written.
pub(super) fn unwritable(path: &Path, cause: &str) -> Problem {
    Problem::error(
        ProblemKind::Output,
        "output-folder-unwritable",
        "outputs.folder",
        format!("the output folder {} cannot be written", path.display()),
    )
    .with_cause(cause)
    .with_remedy("choose a folder with --out that you may write to")
}
