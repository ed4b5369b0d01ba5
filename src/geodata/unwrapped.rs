//! GDAL functions that the gdal crate does not wrap: warping by `gdalwarp` arguments, the horizontal part of a CRS, and
//! what a band of a picture is for.
#![expect(
    unsafe_code,
    reason = "GDALWarp and OSRDemoteTo2D have no safe wrapper in the gdal crate, and that of the colour panics at new ones"
)]

use std::ffi::{CString, c_char};

use gdal::Dataset;
use gdal::raster::RasterBand;
use gdal::spatial_ref::{AxisMappingStrategy, SpatialRef};

/// Warps a raster with the arguments of the `gdalwarp` program into a new raster in memory.
///
/// # Errors
/// GDAL's reason, as far as it gives one; the rest goes to [`super::capture`].
pub fn warp_to_memory(source: &Dataset, arguments: &[&str]) -> Result<Dataset, String> {
    let all: Result<Vec<CString>, _> =
        ["-of", "MEM"].iter().chain(arguments).map(|argument| CString::new(*argument)).collect();
    let all = all.map_err(|error| error.to_string())?;
    let mut pointers: Vec<*mut c_char> = all.iter().map(|argument| argument.as_ptr().cast_mut()).collect();
    pointers.push(std::ptr::null_mut());
    // SAFETY: `pointers` is a null-terminated list of strings that live until the end of this function, and GDAL copies
    // what it keeps. `source` is an open dataset. The result is a new dataset that nobody else owns.
    unsafe {
        let options = gdal_sys::GDALWarpAppOptionsNew(pointers.as_mut_ptr(), std::ptr::null_mut());
        if options.is_null() {
            return Err("the warp options were refused".to_string());
        }
        let mut handle = source.c_dataset();
        let mut usage_error = 0;
        let result =
            gdal_sys::GDALWarp(c"".as_ptr(), std::ptr::null_mut(), 1, &raw mut handle, options, &raw mut usage_error);
        gdal_sys::GDALWarpAppOptionsFree(options);
        if result.is_null() {
            Err("the raster could not be warped".to_string())
        } else {
            Ok(Dataset::from_c_dataset(result))
        }
    }
}

/// The horizontal part of a CRS, with x to the east as first axis: what two files must share.
pub fn horizontal_part(crs: &SpatialRef) -> SpatialRef {
    let mut flat = crs.clone();
    // SAFETY: `flat` is a valid object that only this function holds; a null name keeps the name.
    // A failure leaves it as it was, which the comparison then treats as what it is.
    unsafe {
        gdal_sys::OSRDemoteTo2D(flat.to_c_hsrs(), std::ptr::null());
    }
    flat.set_axis_mapping_strategy(AxisMappingStrategy::TraditionalGisOrder);
    flat
}

/// Whether a band says of each cell how opaque it is: at 0 there is nothing, as beside a raster that `gdalwarp -dstalpha` turned.
pub fn is_alpha(band: &RasterBand) -> bool {
    // SAFETY: the band is open as long as it is borrowed, and the handle goes no further.
    let colour = unsafe { gdal_sys::GDALGetRasterColorInterpretation(band.c_rasterband()) };
    colour == gdal_sys::GDALColorInterp::GCI_AlphaBand
}
