//! Datasets of GDAL while they are read.

use gdal::Dataset;

use crate::geodata::alone;

/// Keeps GDAL's cache of blocks small, where the planner does not say otherwise: every block is read once, and by default the cache takes a
/// twentieth of the machine's memory.
pub(super) fn keep_cache_small() {
    /// Megabytes.
    const SIZE: &str = "64";
    const OPTION: &str = "GDAL_CACHEMAX";
    if gdal::config::get_config_option(OPTION, "").is_ok_and(|size| size.is_empty()) {
        let _ = gdal::config::set_config_option(OPTION, SIZE);
    }
}

/// A dataset that is closed while nobody else is in the NetCDF library.
#[derive(Debug)]
pub(super) struct Closing(pub Option<Dataset>);

impl std::ops::Deref for Closing {
    type Target = Dataset;

    fn deref(&self) -> &Dataset {
        match &self.0 {
            Some(dataset) => dataset,
            None => unreachable!("it is taken out when it is dropped"),
        }
    }
}

impl Drop for Closing {
    fn drop(&mut self) {
        let _alone = alone();
        drop(self.0.take());
    }
}
