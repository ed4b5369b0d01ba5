//! The one place where GDAL opens an input: with the drivers of the formats that the program is made for, and no others.
//!
//! GDAL knows some 200 formats. Many of them name a server, a database or a program, and a file chooses its driver by its own content. The others
//! are taken out of GDAL once, so that the sources of a VRT, too, are opened by none of them; code in a file is never run.

use std::path::{Path, PathBuf};
use std::sync::Once;

use gdal::config::{clear_config_option, set_config_option};
use gdal::raster::GdalDataType;
use gdal::{Dataset, DatasetOptions, DriverManager, GdalOpenFlags};

use super::unwrapped::{files_of, let_fetch, take_asked};
use crate::error::{Problem, input_error};

/// Drivers that open rasters.
pub const RASTER: [&str; 21] = [
    "AAIGrid",
    "AIG",
    "DTED",
    "EHdr",
    "ENVI",
    "GPKG",
    "GRASSASCIIGrid",
    "GS7BG",
    "GSAG",
    "GSBG",
    "GTiff",
    "HFA",
    "JP2OpenJPEG",
    "netCDF",
    "PCRaster",
    "PNG",
    "RST",
    "SAGA",
    "SRTMHGT",
    "USGSDEM",
    "VRT",
];

/// Drivers that open vector files.
pub const VECTOR: [&str; 16] = [
    "CSV",
    "DXF",
    "ESRI Shapefile",
    "ESRIJSON",
    "FlatGeobuf",
    "GML",
    "GPKG",
    "GPX",
    "GeoJSON",
    "GeoJSONSeq",
    "KML",
    "LIBKML",
    "MapInfo File",
    "OpenFileGDB",
    "SQLite",
    "TopoJSON",
];

/// Drivers that only write, or work in memory.
const OWN: [&str; 3] = ["COG", "MEM", "Memory"];

/// The option by which GDAL's readers of network paths open one name alone, and a name that no file has.
const ONE_NAME: (&str, &str) = ("CPL_VSIL_CURL_ALLOWED_FILENAME", "/vsicurl/none");

/// Sets GDAL up, once.
fn set_up() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // Counting registers all of them first.
        let all: Vec<_> = (0..DriverManager::count()).filter_map(|i| DriverManager::get_driver(i).ok()).collect();
        let is_known = |name: &str| RASTER.iter().chain(&VECTOR).chain(&OWN).any(|known| *known == name);
        all.iter().filter(|driver| !is_known(&driver.short_name())).for_each(DriverManager::deregister_driver);
        let _ = set_config_option("GDAL_VRT_ENABLE_PYTHON", "NO");
        let _ = set_config_option(ONE_NAME.0, ONE_NAME.1);
        let_fetch(false);
    });
}

/// Lets GDAL read from the network, or not.
pub fn allow_remote(is_allowed: bool) {
    set_up();
    let_fetch(is_allowed);
    let _ = if is_allowed { clear_config_option(ONE_NAME.0) } else { set_config_option(ONE_NAME.0, ONE_NAME.1) };
}

/// Opens a raster.
///
/// # Errors
/// Those of GDAL.
pub fn raster(path: &Path, open_options: Option<&[&str]>) -> gdal::errors::Result<Dataset> {
    let dataset = open(path, GdalOpenFlags::GDAL_OF_RASTER, &RASTER, open_options)?;
    if !is_text_of_integers(&dataset) {
        return Ok(dataset);
    }
    let options: Vec<&str> = open_options.unwrap_or_default().iter().copied().chain(["DATATYPE=Float64"]).collect();
    open(path, GdalOpenFlags::GDAL_OF_RASTER, &RASTER, Some(&options))
}

/// Whether a dataset is a grid of text whose numbers GDAL takes for 32-bit integers: greater ones come as others, without a word.
fn is_text_of_integers(dataset: &Dataset) -> bool {
    let is_integer = || dataset.rasterband(1).is_ok_and(|band| band.band_type() == GdalDataType::Int32);
    dataset.driver().short_name() == "AAIGrid" && is_integer()
}

/// Opens a vector file.
///
/// # Errors
/// Those of GDAL.
pub fn vector(path: &Path, open_options: Option<&[&str]>) -> gdal::errors::Result<Dataset> {
    open(path, GdalOpenFlags::GDAL_OF_VECTOR, &VECTOR, open_options)
}

fn open(
    path: &Path,
    kind: GdalOpenFlags,
    drivers: &[&str],
    open_options: Option<&[&str]>,
) -> gdal::errors::Result<Dataset> {
    set_up();
    take_asked();
    let open_flags = kind | GdalOpenFlags::GDAL_OF_VERBOSE_ERROR;
    let options =
        DatasetOptions { open_flags, allowed_drivers: Some(drivers), open_options, ..DatasetOptions::default() };
    Dataset::open_ex(path, options)
}

/// The problem of a file that asked for an address while it was opened, and did not get it.
pub fn address_asked_for(path: &Path) -> Option<Problem> {
    let message = format!("{} asks for {}", path.display(), take_asked()?);
    let problem =
        input_error("foreign-file", message).with_cause("its reference system or its description is on a network");
    Some(
        problem.with_remedy(
            "write it with `ogr2ogr -a_srs EPSG:... OUT FILE`, or trust it with `limits.allow_remote: true`",
        ),
    )
}

/// The files that a raster is read from, itself, its side files and the sources of a VRT; none where it is no raster.
pub fn files_of_raster(path: &Path) -> Vec<PathBuf> {
    let (files, _) = super::capture(|| raster(path, None).map(|dataset| files_of(&dataset)));
    files.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_drivers_of_the_lists_are_there() {
        set_up();
        let names: Vec<String> = DriverManager::all().map(|driver| driver.short_name()).collect();
        for known in ["GTiff", "AAIGrid", "netCDF", "VRT", "GPKG", "GeoJSON", "ESRI Shapefile", "COG", "MEM"] {
            assert!(names.iter().any(|name| name == known), "{known} is not there");
        }
        for unknown in ["WMS", "WFS", "PostgreSQL", "HTTP", "OGR_VRT", "PDF"] {
            assert!(!names.iter().any(|name| name == unknown), "{unknown} is there");
        }
    }
}
