//! The signals that end a run: SIGINT, SIGTERM, and SIGHUP unless it is ignored.
//!
//! At the first one the run writes a checkpoint, then its results, and ends. At a second one, or where that takes too long, the program leaves at
//! once, whatever it is at: what has its final name is whole, and `floodsim resume` goes on.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::{Handle, Signals as Arriving};

use super::leave::leave;
use crate::error::Error;

/// How long a run has to end after a signal; batch systems kill after ten seconds and more.
const GRACE: Duration = Duration::from_secs(8);

/// The signals that came.
pub(super) struct Signals {
    received: Arc<AtomicUsize>,
    handle: Handle,
}

impl Drop for Signals {
    fn drop(&mut self) {
        self.handle.close();
    }
}

impl Signals {
    /// Begins to watch.
    pub fn watch() -> Result<Self, Error> {
        let failed = |cause: std::io::Error| Error::Internal(format!("signals cannot be watched: {cause}"));
        let hang_up = Some(SIGHUP).filter(|_| is_stopped_by_hang_up());
        // A file as large as the system lets it be is one that cannot be written, and no reason to be killed.
        signal_hook::flag::register(SIGXFSZ, Arc::default()).map_err(failed)?;
        let mut arriving = Arriving::new([SIGINT, SIGTERM].into_iter().chain(hang_up)).map_err(failed)?;
        let signals = Signals { received: Arc::default(), handle: arriving.handle() };
        let received = Arc::clone(&signals.received);
        let watch = move || {
            for signal in arriving.forever() {
                if received.swap(signal as usize, Ordering::Relaxed) != 0 {
                    leave_at(signal);
                }
                std::thread::spawn(move || {
                    std::thread::sleep(GRACE);
                    leave_at(signal);
                });
            }
        };
        std::thread::Builder::new().name("signals".into()).spawn(watch).map_err(failed)?;
        Ok(signals)
    }

    /// The number of the last one; 0 before any came.
    pub fn received(&self) -> usize {
        self.received.load(Ordering::Relaxed)
    }
}

/// Ends the program at once.
fn leave_at(signal: i32) -> ! {
    leave("stopped", 128 + signal, format!("error: stopped by signal {signal} before all results were written"))
}

/// Whether SIGHUP is not ignored, as `nohup` has it: that run is to outlive its terminal, and to watch the signal would end it. Where
/// the system does not tell, the signal is left as it is.
pub(crate) fn is_stopped_by_hang_up() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask >> (SIGHUP - 1) & 1 == 0)
}
