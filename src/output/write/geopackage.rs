//! `results.gpkg`: outline, isochrones, gauges, cross-sections, ridges narrower than a cell, and findings, each layer with a default style.
//!
//! The date of change in the file's own tables is fixed, so that equal results give equal bytes.

use std::path::Path;

use gdal::config::{clear_thread_local_config_option, set_thread_local_config_option};
use gdal::errors::Result as GdalResult;
use gdal::spatial_ref::SpatialRef;
use gdal::vector::{Feature, FieldDefn, Geometry, LayerAccess, LayerOptions, OGRFieldType, OGRwkbGeometryType};
use gdal::{Dataset, DriverManager};

use super::super::folder::{RunFolder, output_error};
use super::super::grid::{FILL, GridMaps, OutputGrid};
use super::super::outline::{Region, regions};
use super::super::recording::Recording;
use super::super::ridges::Ridge;
use super::super::sections::{Section, SectionResult};
use super::super::{Gauge, OutputCrs};
use super::crs::WritableCrs;
use super::qgis::{LayerStyle, vector_style};
use super::read_back::{compare_layers, without_messages};
use crate::error::{Error, Problem, Severity};
use crate::math::Vec2;

/// The stand-in for the dates that the format asks for.
pub(super) const FIXED_DATE: &str = "2000-01-01T00:00:00.000Z";

/// The system without a place on Earth, by the name under which the format has a number for it (-1).
const PLAIN_METRES: &str = r#"ENGCRS["Undefined Cartesian SRS",EDATUM[""],CS[Cartesian,2],AXIS["x",east,ORDER[1]],AXIS["y",north,ORDER[2]],LENGTHUNIT["metre",1]]"#;

/// A value of a column.
pub(super) enum Value {
    Text(String),
    Number(Option<f64>),
    Date(&'static str),
}

/// A layer before it is written: columns with their types, and one entry for each feature.
pub(super) struct Layer<'a> {
    pub(super) name: &'a str,
    pub(super) geometry: OGRwkbGeometryType::Type,
    pub(super) columns: Vec<(String, OGRFieldType::Type)>,
    pub(super) features: Vec<(Option<Geometry>, Vec<Value>)>,
}

/// What the layers beside the maps show.
#[derive(Clone, Copy, Debug)]
pub struct Findings<'a> {
    /// The gauges.
    pub gauges: &'a [Gauge],
    /// The cross-sections.
    pub sections: &'a [Section],
    /// What each of them saw.
    pub section_results: &'a [SectionResult],
    /// Ridges of the terrain that cells do not see.
    pub ridges: &'a [Ridge],
    /// Steep banks of the terrain that cells follow (map coordinates, m).
    pub banks: &'a [Vec<Vec2>],
    /// Times (s).
    pub isochrones: &'a [f64],
    /// The problems, of which those with a place become points.
    pub problems: &'a [Problem],
}

/// Writes `results.gpkg`.
///
/// # Errors
/// When it cannot be written.
pub fn write_geopackage(
    folder: &RunFolder,
    grid: &OutputGrid,
    crs: &OutputCrs,
    recording: &Recording,
    findings: &Findings<'_>,
) -> Result<(), Error> {
    let write = |path: &Path| {
        let spatial_ref = spatial_ref_of(crs, path)?;
        let write = || -> GdalResult<Vec<(String, u64)>> {
            let mut layers = vec![
                extent_layer(grid, &recording.maps)?,
                isochrone_layer(grid, &recording.maps, findings.isochrones)?,
                gauge_layer(findings.gauges, recording)?,
                findings_layer(findings.problems)?,
            ];
            let has_sections = !findings.sections.is_empty();
            if has_sections {
                layers.push(section_layer(findings.sections, findings.section_results)?);
            }
            let has_ridges = !findings.ridges.is_empty();
            if has_ridges {
                layers.push(ridge_layer(findings.ridges)?);
            }
            let has_banks = !findings.banks.is_empty();
            if has_banks {
                layers.push(bank_layer(findings.banks)?);
            }
            layers.push(style_layer(findings.isochrones, [has_sections, has_ridges, has_banks]));
            write_layers(path, &spatial_ref, layers)
        };
        set_thread_local_config_option("OGR_CURRENT_DATE", FIXED_DATE).map_err(|cause| output_error(path, cause))?;
        let written = write().map_err(|cause| output_error(path, cause));
        clear_thread_local_config_option("OGR_CURRENT_DATE").map_err(|cause| output_error(path, cause))?;
        compare_layers(path, &written?)
    };
    folder.write_with("results.gpkg", |path| without_messages(path, || write(path)))
}

/// The reference system of the layers of a file.
pub(super) fn spatial_ref_of(crs: &OutputCrs, path: &Path) -> Result<SpatialRef, Error> {
    match WritableCrs::new(crs, path)? {
        Some(crs) => Ok(crs.spatial_ref),
        None => SpatialRef::from_wkt(PLAIN_METRES).map_err(|cause| output_error(path, cause)),
    }
}

/// Writes layers; returns their names with their numbers of features.
pub(super) fn write_layers(
    path: &Path,
    spatial_ref: &SpatialRef,
    layers: Vec<Layer<'_>>,
) -> GdalResult<Vec<(String, u64)>> {
    let driver = DriverManager::get_driver_by_name("GPKG")?;
    let mut dataset = driver.create_vector_only(path)?;
    let mut written = Vec::new();
    for layer in layers {
        written.push((layer.name.to_owned(), layer.features.len() as u64));
        write_layer(&mut dataset, spatial_ref, layer)?;
    }
    dataset.close()?;
    Ok(written)
}

/// One transaction for each layer: without, each feature would be one.
fn write_layer(dataset: &mut Dataset, spatial_ref: &SpatialRef, layer: Layer<'_>) -> GdalResult<()> {
    let mut transaction = dataset.start_transaction()?;
    {
        let table = transaction.create_layer(LayerOptions {
            name: layer.name,
            srs: (layer.geometry != OGRwkbGeometryType::wkbNone).then_some(spatial_ref),
            ty: layer.geometry,
            options: None,
        })?;
        for (name, kind) in &layer.columns {
            FieldDefn::new(name, *kind)?.add_to_layer(&table)?;
        }
        for (geometry, values) in layer.features {
            let mut feature = Feature::new(table.defn())?;
            if let Some(geometry) = geometry {
                feature.set_geometry(geometry)?;
            }
            for (index, value) in values.into_iter().enumerate() {
                match value {
                    Value::Text(text) => feature.set_field_string(index, &text)?,
                    Value::Date(date) => feature.set_field_string(index, date)?,
                    Value::Number(Some(number)) => feature.set_field_double(index, number)?,
                    Value::Number(None) => feature.set_field_null(index)?,
                }
            }
            feature.create(&table)?;
        }
    }
    transaction.commit()
}

pub(super) fn number_columns(names: &[&str]) -> Vec<(String, OGRFieldType::Type)> {
    names.iter().map(|name| (name.to_string(), OGRFieldType::OFTReal)).collect()
}

pub(super) fn text_columns(names: &[&str]) -> Vec<(String, OGRFieldType::Type)> {
    names.iter().map(|name| (name.to_string(), OGRFieldType::OFTString)).collect()
}

/// The cells for which `inside` holds, as one multipolygon and its area (m²); none when there are no such cells.
pub(super) fn multipolygon(grid: &OutputGrid, inside: &[bool]) -> GdalResult<Option<(Geometry, f64)>> {
    let regions = regions(grid.columns, inside);
    if regions.is_empty() {
        return Ok(None);
    }
    let mut all = Geometry::empty(OGRwkbGeometryType::wkbMultiPolygon)?;
    for region in &regions {
        all.add_geometry(polygon(grid, region)?)?;
    }
    let cells = inside.iter().filter(|&&cell| cell).count();
    Ok(Some((all, cells as f64 * grid.cell * grid.cell)))
}

fn polygon(grid: &OutputGrid, region: &Region) -> GdalResult<Geometry> {
    let mut polygon = Geometry::empty(OGRwkbGeometryType::wkbPolygon)?;
    for corners in &region.rings {
        let mut ring = Geometry::empty(OGRwkbGeometryType::wkbLinearRing)?;
        for &(column, row) in corners.iter().chain(corners.first()) {
            let corner = grid.corner(column, row);
            ring.add_point_2d((corner.x, corner.y));
        }
        polygon.add_geometry(ring)?;
    }
    Ok(polygon)
}

/// Where the greatest depth reaches the first threshold.
fn extent_layer<'a>(grid: &OutputGrid, maps: &GridMaps) -> GdalResult<Layer<'a>> {
    let threshold = maps.thresholds[0].threshold;
    let inside: Vec<bool> = maps.max_depth.iter().map(|&depth| f64::from(depth) >= threshold).collect();
    let features = multipolygon(grid, &inside)?.into_iter();
    Ok(Layer {
        name: "inundation_extent",
        geometry: OGRwkbGeometryType::wkbMultiPolygon,
        columns: number_columns(&["threshold_m", "area_m2"]),
        features: features
            .map(|(geometry, area)| (Some(geometry), vec![Value::Number(Some(threshold)), Value::Number(Some(area))]))
            .collect(),
    })
}

/// The areas that the water reaches between one isochrone and the next, by the arrival for the first threshold.
fn isochrone_layer<'a>(grid: &OutputGrid, maps: &GridMaps, isochrones: &[f64]) -> GdalResult<Layer<'a>> {
    let arrival = &maps.thresholds[0].arrival;
    let mut features = Vec::new();
    let mut earlier = None;
    for &time in isochrones {
        let within = |&arrival: &f32| {
            let arrives = arrival.to_bits() != FILL.to_bits();
            arrives && f64::from(arrival) <= time && earlier.is_none_or(|earlier| f64::from(arrival) > earlier)
        };
        let inside: Vec<bool> = arrival.iter().map(within).collect();
        if let Some((geometry, area)) = multipolygon(grid, &inside)? {
            let values = [earlier.unwrap_or(0.0), time, time / 60.0, area];
            features.push((Some(geometry), values.map(|value| Value::Number(Some(value))).into()));
        }
        earlier = Some(time);
    }
    let columns = number_columns(&["arrival_from_s", "arrival_s", "arrival_min", "area_m2"]);
    Ok(Layer { name: "isochrones", geometry: OGRwkbGeometryType::wkbMultiPolygon, columns, features })
}

fn point(x: f64, y: f64) -> GdalResult<Geometry> {
    let mut point = Geometry::empty(OGRwkbGeometryType::wkbPoint)?;
    point.add_point_2d((x, y));
    Ok(point)
}

/// The gauges with all results and the columns of their own file.
fn gauge_layer<'a>(gauges: &[Gauge], recording: &Recording) -> GdalResult<Layer<'a>> {
    let mut columns = text_columns(&["id"]);
    let results = ["bed_m", "arrival_s", "arrival_min", "max_depth_m", "max_level_m", "time_of_max_s", "max_speed_m_s"];
    columns.extend(number_columns(&results));
    let mut own: Vec<&str> = Vec::new();
    for (name, _) in gauges.iter().flat_map(|gauge| &gauge.attributes) {
        if !own.contains(&name.as_str()) {
            own.push(name);
        }
    }
    for name in &own {
        columns.push((unused_name(name, &columns), OGRFieldType::OFTString));
    }
    let feature = |(gauge, result): (&Gauge, &super::super::GaugeResult)| {
        let mut values = vec![Value::Text(gauge.id.clone())];
        let minutes = result.arrival.map(|time| time / 60.0);
        values.extend(
            [
                result.bed,
                result.arrival,
                minutes,
                result.max_depth,
                result.max_level,
                result.time_of_max,
                result.max_speed,
            ]
            .map(Value::Number),
        );
        for column in &own {
            let value = gauge.attributes.iter().find(|(name, _)| name == column);
            values.push(value.map_or(Value::Number(None), |(_, value)| Value::Text(value.clone())));
        }
        Ok((Some(point(gauge.position.x, gauge.position.y)?), values))
    };
    let features = gauges.iter().zip(&recording.gauge_results).map(feature).collect::<GdalResult<_>>()?;
    Ok(Layer { name: "gauges", geometry: OGRwkbGeometryType::wkbPoint, columns, features })
}

/// A line through places.
fn line(places: &[Vec2]) -> GdalResult<Geometry> {
    let mut line = Geometry::empty(OGRwkbGeometryType::wkbLineString)?;
    places.iter().for_each(|place| line.add_point_2d((place.x, place.y)));
    Ok(line)
}

/// The cross-sections with all results.
fn section_layer<'a>(sections: &[Section], results: &[SectionResult]) -> GdalResult<Layer<'a>> {
    let mut columns = text_columns(&["id"]);
    columns.extend(number_columns(&["arrival_s", "peak_discharge_m3_s", "time_of_peak_s", "volume_m3"]));
    let feature = |(section, result): (&Section, &SectionResult)| {
        let mut values = vec![Value::Text(section.id.clone())];
        let numbers = [result.arrival, Some(result.peak_discharge), result.time_of_peak, Some(result.volume)];
        values.extend(numbers.map(Value::Number));
        Ok((Some(line(&section.line)?), values))
    };
    let features = sections.iter().zip(results).map(feature).collect::<GdalResult<_>>()?;
    Ok(Layer { name: "sections", geometry: OGRwkbGeometryType::wkbLineString, columns, features })
}

/// The faces that carry a ridge which their cells do not see.
fn ridge_layer<'a>(ridges: &[Ridge]) -> GdalResult<Layer<'a>> {
    let columns = number_columns(&["sill_m", "rise_m", "bed_left_m", "bed_right_m", "open_share", "crest_m"]);
    let feature = |ridge: &Ridge| {
        let [left, right] = ridge.beds.map(Some);
        let numbers = [ridge.sill, ridge.rise(), left, right, Some(ridge.open), ridge.crest];
        Ok((Some(line(&ridge.line)?), numbers.map(Value::Number).into()))
    };
    let features = ridges.iter().map(feature).collect::<GdalResult<_>>()?;
    Ok(Layer { name: "ridges", geometry: OGRwkbGeometryType::wkbLineString, columns, features })
}

/// The steep banks of the terrain that cells follow.
fn bank_layer<'a>(banks: &[Vec<Vec2>]) -> GdalResult<Layer<'a>> {
    let feature = |bank: &Vec<Vec2>| {
        let length = bank.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum();
        Ok((Some(line(bank)?), vec![Value::Number(Some(length))]))
    };
    let features = banks.iter().map(feature).collect::<GdalResult<_>>()?;
    let columns = number_columns(&["length_m"]);
    Ok(Layer { name: "banks", geometry: OGRwkbGeometryType::wkbLineString, columns, features })
}

/// A column name that is not taken; SQLite does not tell upper from lower case.
fn unused_name(name: &str, columns: &[(String, OGRFieldType::Type)]) -> String {
    let is_taken = |candidate: &str| {
        let same = |other: &str| other.eq_ignore_ascii_case(candidate);
        same("fid") || same("geom") || columns.iter().any(|(column, _)| same(column))
    };
    let numbered = (2..).map(|number| format!("{name}_{number}"));
    std::iter::once(name.to_string()).chain(numbered).find(|candidate| !is_taken(candidate)).unwrap_or_default()
}

/// The findings that have a place.
fn findings_layer<'a>(findings: &[Problem]) -> GdalResult<Layer<'a>> {
    let mut features = Vec::new();
    for finding in findings {
        let Some(at) = finding.at else { continue };
        let severity = if finding.severity == Severity::Error { "error" } else { "warning" };
        let texts = [
            severity.to_string(),
            finding.code.to_string(),
            finding.key.clone(),
            finding.message.clone(),
            finding.cause.clone().unwrap_or_default(),
            finding.remedy.clone().unwrap_or_default(),
        ];
        features.push((Some(point(at.x, at.y)?), texts.map(Value::Text).into()));
    }
    let columns = text_columns(&["severity", "code", "key", "message", "cause", "remedy"]);
    Ok(Layer { name: "findings", geometry: OGRwkbGeometryType::wkbPoint, columns, features })
}

/// The styles of the layers beside the maps.
fn style_layer<'a>(isochrones: &[f64], [has_sections, has_ridges, has_banks]: [bool; 3]) -> Layer<'a> {
    let mut styles = vec![
        ("inundation_extent", LayerStyle::Area("49,130,189,60", "8,81,156,255")),
        ("isochrones", LayerStyle::Categories("arrival_s", isochrones)),
        ("gauges", LayerStyle::Point("255,215,0,255", "id")),
        ("findings", LayerStyle::Point("215,25,28,255", "code")),
    ];
    if has_sections {
        styles.push(("sections", LayerStyle::Line("227,26,28,255", "id")));
    }
    if has_ridges {
        styles.push(("ridges", LayerStyle::Line("122,1,119,255", "sill_m")));
    }
    if has_banks {
        styles.push(("banks", LayerStyle::Line("140,86,75,255", "length_m")));
    }
    style_table(styles)
}

/// The table in which QGIS looks for default styles.
pub(super) fn style_table<'a>(styles: Vec<(&str, LayerStyle<'_>)>) -> Layer<'a> {
    let names =
        ["f_table_catalog", "f_table_schema", "f_table_name", "f_geometry_column", "styleName", "styleQML", "styleSLD"];
    let mut columns = text_columns(&names);
    columns.push(("useAsDefault".into(), OGRFieldType::OFTInteger));
    columns.extend(text_columns(&["description", "owner", "ui"]));
    columns.push(("update_time".into(), OGRFieldType::OFTDateTime));
    let feature = |(name, style): (&str, LayerStyle<'_>)| {
        let texts = ["", "", name, "geom", "default", &vector_style(&style), ""];
        let mut values: Vec<Value> = texts.map(|value| Value::Text(value.to_string())).into();
        values.push(Value::Number(Some(1.0)));
        values.extend(["default style", "", ""].map(|value| Value::Text(value.to_string())));
        values.push(Value::Date(FIXED_DATE));
        (None, values)
    };
    Layer {
        name: "layer_styles",
        geometry: OGRwkbGeometryType::wkbNone,
        columns,
        features: styles.into_iter().map(feature).collect(),
    }
}
