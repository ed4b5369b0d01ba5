//! Terrain: rasters and survey points as a surface that can be asked for its elevation anywhere.

mod raster;

pub use raster::Raster;
