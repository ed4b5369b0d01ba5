//! The limit of memory, watched: what was estimated before is what is known of a scene, and inputs may be of another kind.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::clock::resident_bytes;
use super::leave::{leave, over_memory};
use crate::error::{Error, ExitCode};
use crate::math::in_bytes;
use crate::prepare::BYTES_OF_PROGRAM;

/// How often memory is looked at: a program fills some 100 MB in that time at most.
const INTERVAL: Duration = Duration::from_millis(50);

/// Ends the program where it takes more memory than allowed, as long as this value lives.
pub(super) struct MemoryWatch(Arc<AtomicBool>);

impl MemoryWatch {
    /// Begins to watch a limit (bytes). One below what the program itself takes is refused with all else that is wrong, and is not watched here.
    pub fn begin(limit: f64) -> Result<Self, Error> {
        let limit = limit.max(BYTES_OF_PROGRAM);
        let is_over = Arc::new(AtomicBool::new(false));
        let ends = Arc::clone(&is_over);
        let watch = move || {
            while !ends.load(Ordering::Relaxed) {
                let resident = resident_bytes().unwrap_or(0.0);
                if resident > limit {
                    let message =
                        format!("the program takes {} of memory; the limit is {}", in_bytes(resident), in_bytes(limit));
                    leave("failed", ExitCode::Limit as i32, over_memory(message))
                }
                std::thread::sleep(INTERVAL);
            }
        };
        let started = std::thread::Builder::new().name("memory".into()).spawn(watch);
        started.map_err(|cause| Error::Internal(format!("memory cannot be watched: {cause}")))?;
        Ok(MemoryWatch(is_over))
    }
}

impl Drop for MemoryWatch {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
