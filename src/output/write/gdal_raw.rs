//! The one call of GDAL that its crate does not wrap.

use std::ffi::CString;

use gdal::errors::Result;
use gdal::raster::RasterBand;

/// Sets the unit of the values of a band.
#[expect(unsafe_code, reason = "the gdal crate has no wrapper for GDALSetRasterUnitType")]
pub(super) fn set_unit(band: &mut RasterBand<'_>, unit: &str) -> Result<()> {
    let unit = CString::new(unit)?;
    // SAFETY: the band lives as long as the borrow, the text is zero-terminated and GDAL copies it.
    let class = unsafe { gdal_sys::GDALSetRasterUnitType(band.c_rasterband(), unit.as_ptr()) };
    if class == gdal_sys::CPLErr::CE_None {
        Ok(())
    } else {
        Err(gdal::errors::GdalError::CplError { class, number: 0, msg: "the unit of a band was refused".into() })
    }
}
