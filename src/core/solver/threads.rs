//! Where a run takes place: among the threads that share its loops.
//!
//! A loop that is begun on a thread of its own is handed over to the pool, and the thread waits for it: two switches for each of the dozen
//! loops of a step. From inside the pool a loop begins at once, and only what another thread takes over has a price
//! (`docs/decisions/0056-runs-inside-the-pool.md`).

/// Runs on a thread of the pool: at once where this is one, else handed over to it as a whole. Panics pass through.
pub fn in_pool<R: Send>(run: impl FnOnce() -> R + Send) -> R {
    if rayon::current_thread_index().is_some() { run() } else { rayon::scope(|_| run()) }
}
