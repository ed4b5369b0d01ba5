//! Leaving at once: at a second signal, at the limit of memory, or where the system gives no more of it.
//!
//! What has its final name in the run folder is whole, and `floodsim resume` goes on from the last checkpoint.

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::{ExitCode, Problem, ProblemKind, say};
use crate::math::in_bytes;
use crate::output::mark_ended;

/// The folder of the run that is under way, whose `run.json` says how it ended.
static FOLDER: Mutex<Option<PathBuf>> = Mutex::new(None);

/// From now on the program writes to this folder.
pub(super) fn writes_to(folder: &Path) {
    if let Ok(mut known) = FOLDER.lock() {
        *known = Some(folder.to_path_buf());
    }
}

/// Ends the program with words and an exit code. No handler runs: those of libraries would meet files that are being written.
pub(super) fn leave(status: &str, code: i32, words: impl Display) -> ! {
    // A lock that is held here is never given back.
    let folder = FOLDER.try_lock().ok().and_then(|mut folder| folder.take());
    if let Some(folder) = &folder {
        mark_ended(folder, status, code);
    }
    say(words);
    if folder.is_some() {
        say(
            "note: what has its final name in the run folder is whole; `floodsim resume` goes on from the last checkpoint",
        );
    }
    signal_hook::low_level::exit(code)
}

/// The problem of a program that reached its limit of memory.
pub(super) fn over_memory(message: String) -> Problem {
    Problem::error(ProblemKind::Limit, "memory-limit", "limits.memory", message)
        .with_remedy("take a coarser `resolution`, fewer gauges or a longer `outputs.gauges_every`, cut the terrain to the valley, or raise the limit")
}

/// Ends the program where the system gives it no memory of so many bytes.
pub fn out_of_memory(bytes: usize) -> ! {
    static IS_LEAVING: AtomicBool = AtomicBool::new(false);
    // Saying so takes some memory, too.
    if IS_LEAVING.swap(true, Ordering::Relaxed) {
        signal_hook::low_level::exit(ExitCode::Limit as i32)
    }
    let message = format!("the system gives the program no {} more of memory", in_bytes(bytes as f64));
    leave(
        "failed",
        ExitCode::Limit as i32,
        over_memory(message).with_cause("a limit of its process (`ulimit -v`), or the machine has no more"),
    )
}
