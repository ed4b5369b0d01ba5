//! The cells of a run before it, as a layer: polygons of each level and reason in a GeoPackage of their own, with a default style.

use std::path::Path;

use gdal::config::{clear_thread_local_config_option, set_thread_local_config_option};
use gdal::errors::Result as GdalResult;
use gdal::vector::OGRwkbGeometryType;

use super::super::OutputCrs;
use super::super::cell_records::LevelRecord;
use super::super::folder::output_error;
use super::super::grid::OutputGrid;
use super::geopackage::{
    FIXED_DATE, Layer, Value, multipolygon, number_columns, spatial_ref_of, style_table, text_columns, write_layers,
};
use super::qgis::LayerStyle;
use super::read_back::compare_layers;
use crate::error::Error;

/// Where cells of a level stand for the same reason.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelArea {
    /// Edge of the cells (m).
    pub spacing: f64,
    /// Why they are of that level, in words.
    pub because: &'static str,
    /// Of each cell of the finest lattice, row 0 in the north, whether it belongs to the area.
    pub inside: Vec<bool>,
}

/// Writes the layer `levels` to a file that does not exist yet. `records` has what is known of each level.
///
/// # Errors
/// When it cannot be written.
pub fn write_level_layer(
    path: &Path,
    grid: &OutputGrid,
    crs: &OutputCrs,
    areas: &[LevelArea],
    records: &[LevelRecord],
) -> Result<(), Error> {
    let spatial_ref = spatial_ref_of(crs, path)?;
    let write = || -> GdalResult<Vec<(String, u64)>> {
        let mut spacings: Vec<f64> = areas.iter().map(|area| area.spacing).collect();
        spacings.dedup();
        let styles = style_table(vec![("levels", LayerStyle::Levels("spacing_m", &spacings))]);
        write_layers(path, &spatial_ref, vec![layer(grid, areas, records)?, styles])
    };
    set_thread_local_config_option("OGR_CURRENT_DATE", FIXED_DATE).map_err(|cause| output_error(path, cause))?;
    let written = write().map_err(|cause| output_error(path, cause));
    clear_thread_local_config_option("OGR_CURRENT_DATE").map_err(|cause| output_error(path, cause))?;
    compare_layers(path, &written?)
}

fn layer<'a>(grid: &OutputGrid, areas: &[LevelArea], records: &[LevelRecord]) -> GdalResult<Layer<'a>> {
    let mut columns = number_columns(&["spacing_m"]);
    columns.extend(text_columns(&["because"]));
    let names = ["area_m2", "level_cells", "level_wet_cells", "level_steps", "level_evaluations"];
    columns.extend(number_columns(&names));
    let mut features = Vec::new();
    for area in areas {
        let Some((geometry, square_metres)) = multipolygon(grid, &area.inside)? else { continue };
        let record = records.iter().find(|record| (record.spacing_m - area.spacing).abs() < 1e-9 * area.spacing);
        let of_level = |value: fn(&LevelRecord) -> f64| Value::Number(record.map(value));
        let values = vec![
            Value::Number(Some(area.spacing)),
            Value::Text(area.because.to_owned()),
            Value::Number(Some(square_metres)),
            of_level(|level| level.cells as f64),
            of_level(|level| level.expected_wet_cells),
            of_level(|level| level.expected_steps),
            of_level(|level| level.expected_evaluations),
        ];
        features.push((Some(geometry), values));
    }
    Ok(Layer { name: "levels", geometry: OGRwkbGeometryType::wkbMultiPolygon, columns, features })
}
