//! Reading terrain: rasters by GDAL, and survey points; what becomes of them is in [`floodsim_core::terrain`].

mod ascii_grid;
mod read;
mod survey_read;

pub use floodsim_core::terrain::{
    Layer, Overlay, Piece, PixelBlock, PixelGrid, PointInterpolation, Raster, Survey, SurveyPoint, Terrain,
};
pub use read::{PLAUSIBLE_ELEVATION, Placing, RasterFile, RasterRequest};
pub use survey_read::{SurveyFile, read_survey};
