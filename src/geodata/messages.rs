//! GDAL's own messages, caught and handed on instead of written to stderr.
//!
//! GDAL reports through one handler for the whole process and calls it on the thread that has the trouble; so the
//! messages are collected for each thread.

use std::cell::RefCell;
use std::sync::Once;

use gdal::errors::CplErrType;

thread_local! {
    static MESSAGES: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

/// Does `work`, in which GDAL may read through the NetCDF library, and returns its result with the warnings and errors that GDAL reported meanwhile
/// on this thread.
pub fn capture<T>(work: impl FnOnce() -> T) -> (T, Vec<String>) {
    heard(|| {
        let _alone = alone();
        work()
    })
}

/// The same for work that has nothing to do with NetCDF.
pub fn heard<T>(work: impl FnOnce() -> T) -> (T, Vec<String>) {
    static INSTALLED: Once = Once::new();
    INSTALLED.call_once(|| {
        gdal::config::set_error_handler(|severity, _number, message| {
            if matches!(severity, CplErrType::Warning | CplErrType::Failure | CplErrType::Fatal) {
                // A thread that is just ending has no store any more; its message is lost, which harms nobody.
                let _ = MESSAGES.try_with(|messages| messages.borrow_mut().push(message.trim().to_string()));
            }
        });
    });
    let outer = MESSAGES.take();
    let result = work();
    let mut messages = MESSAGES.replace(outer);
    messages.dedup();
    (result, messages)
}

/// Holds the lock of the NetCDF library, which bears one thread at a time: GDAL reads through the same library, without knowing of
/// the others. A thread may take it again while it has it.
pub fn alone() -> impl Drop {
    netcdf_sys::libnetcdf_lock.lock()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_caught_and_do_not_leak_into_the_next_capture() {
        let (result, messages) = capture(|| gdal::spatial_ref::SpatialRef::from_definition("EPSG:999999"));
        assert!(result.is_err());
        assert!(messages.iter().any(|m| m.contains("crs not found")), "{messages:?}");
        let ((), messages) = capture(|| ());
        assert!(messages.is_empty());
    }
}
