//! The coordinate reference system as GDAL and the NetCDF files want it.

use std::path::Path;

use gdal::config::{clear_thread_local_config_option, set_thread_local_config_option};
use gdal::spatial_ref::{AxisMappingStrategy, CoordTransform, SpatialRef};
use netcdf::AttributeValue;

use super::super::OutputCrs;
use super::super::folder::output_error;
use super::super::grid::OutputGrid;
use super::projection::cf_attributes;
use crate::error::Error;

/// A projected system, ready for writing; `None` stands for plain metres.
pub(super) struct WritableCrs {
    /// For GDAL, with x before y.
    pub(super) spatial_ref: SpatialRef,
    /// Attributes of the `crs` variable.
    pub(super) attributes: Vec<(&'static str, AttributeValue)>,
    /// WKT in the dialect of ArcGIS, for the attribute `esri_pe_string` of data variables.
    pub(super) esri_wkt: Option<String>,
}

impl WritableCrs {
    /// Prepares a system; `path` is the file that will get it, for the message.
    pub(super) fn new(crs: &OutputCrs, path: &Path) -> Result<Option<Self>, Error> {
        let OutputCrs::Projected { wkt2, authority } = crs else {
            return Ok(None);
        };
        let failed = |cause| output_error(path, format!("the coordinate reference system cannot be written: {cause}"));
        let mut spatial_ref = SpatialRef::from_wkt(wkt2).map_err(failed)?;
        spatial_ref.set_axis_mapping_strategy(AxisMappingStrategy::TraditionalGisOrder);
        let projjson = spatial_ref.to_projjson().map_err(failed)?;
        let mut attributes = cf_attributes(&projjson).unwrap_or_default();
        // The WKT is the truth. Readers disagree on which of the two names they look for, and an older dialect beside
        // it would win in some of them, so both hold the same text.
        attributes.push(("crs_wkt", wkt2.as_str().into()));
        attributes.push(("spatial_ref", wkt2.as_str().into()));
        if let Some(authority) = authority {
            attributes.push(("epsg_code", authority.as_str().into()));
        }
        attributes.push(("long_name", "coordinate reference system".into()));
        let esri_wkt = esri_wkt(&spatial_ref).ok();
        Ok(Some(WritableCrs { spatial_ref, attributes, esri_wkt }))
    }

    /// The extent in degrees as ACDD attributes; empty where the system cannot be converted.
    pub(super) fn geospatial_attributes(&self, grid: &OutputGrid) -> Vec<(&'static str, f64)> {
        let extent = || -> gdal::errors::Result<[f64; 4]> {
            let mut geographic = SpatialRef::from_epsg(4326)?;
            geographic.set_axis_mapping_strategy(AxisMappingStrategy::TraditionalGisOrder);
            let transform = CoordTransform::new(&self.spatial_ref, &geographic)?;
            let (north_west, south_east) = (grid.corner(0, 0), grid.corner(grid.columns, grid.rows));
            transform.transform_bounds(&[north_west.x, south_east.y, south_east.x, north_west.y], 21)
        };
        let Ok([west, south, east, north]) = extent() else {
            return Vec::new();
        };
        // A millionth of a degree is a decimetre; more digits would differ between versions of PROJ.
        let rounded = |degrees: f64| (degrees * 1e6).round() / 1e6;
        vec![
            ("geospatial_lat_min", rounded(south)),
            ("geospatial_lat_max", rounded(north)),
            ("geospatial_lon_min", rounded(west)),
            ("geospatial_lon_max", rounded(east)),
        ]
    }
}

/// The system in the dialect of ArcGIS, whatever dialect the rest of the program has asked GDAL for.
fn esri_wkt(spatial_ref: &SpatialRef) -> gdal::errors::Result<String> {
    set_thread_local_config_option("OSR_WKT_FORMAT", "WKT1_ESRI")?;
    let wkt = spatial_ref.to_wkt();
    clear_thread_local_config_option("OSR_WKT_FORMAT")?;
    wkt
}
