//! `maps.nc`: the maps of the run, one variable each, on `(y, x)`.
//!
//! Maxima carry the end of the run as the scalar coordinate `time`; arrival, duration and recession carry their threshold
//! as a scalar coordinate. The time has no bounds: CF gives those of a scalar one dimension, its checker asks for two.

use netcdf::Options;

use super::super::folder::{RunFolder, output_error};
use super::super::grid::{FILL, GridMaps, OutputGrid};
use super::crs::WritableCrs;
use super::netcdf_file::{FileDescription, NetcdfFile, Written};
use super::read_back::ReadBack;
use super::variables::{MapKind, MapVariable, map_variables, threshold_name};
use super::{FileHead, Provenance};
use crate::error::Error;

/// The value for "outside the terrain" in the class map, the same number as in the others.
const CLASS_FILL: i16 = FILL as i16;

/// Writes `maps.nc`; `end_time` (s) is the time up to which the run was recorded, `rise_on_wet` (m) that of the recorder.
///
/// # Errors
/// When it cannot be written.
pub fn write_maps(
    folder: &RunFolder,
    grid: &OutputGrid,
    head: FileHead<'_>,
    maps: &GridMaps,
    end_time: f64,
    rise_on_wet: f64,
) -> Result<(), Error> {
    let of_run = |file: &mut NetcdfFile<'_>| {
        define_period(file, head.provenance, end_time)?;
        maps.thresholds.iter().try_for_each(|grids| define_threshold(file, grids.threshold))
    };
    write_variables((folder, "maps.nc"), grid, head, &map_variables(maps, rise_on_wet), of_run)
}

/// Writes maps that are not those of one run, such as `differences.nc`.
///
/// # Errors
/// When it cannot be written.
pub fn write_map_file(
    file: (&RunFolder, &str),
    grid: &OutputGrid,
    head: FileHead<'_>,
    maps: &[MapVariable<'_>],
) -> Result<(), Error> {
    write_variables(file, grid, head, maps, |_| Ok(()))
}

/// Writes maps as variables of one file, after what `define` adds to it.
fn write_variables(
    (folder, name): (&RunFolder, &str),
    grid: &OutputGrid,
    FileHead { crs, provenance }: FileHead<'_>,
    variables: &[MapVariable<'_>],
    define: impl FnOnce(&mut NetcdfFile<'_>) -> netcdf::Result<()>,
) -> Result<(), Error> {
    let description = FileDescription { grid: grid.clone(), crs: crs.clone(), provenance: provenance.clone() };
    folder.write_with(name, |path| {
        let crs = WritableCrs::new(crs, path)?;
        let file = Written::create(path, Options::NETCDF4).map_err(|cause| output_error(path, cause))?;
        let mut file = NetcdfFile::describe(file, path, &crs, &description)?;
        let write = |file: &mut NetcdfFile<'_>| -> netcdf::Result<()> {
            define(file)?;
            file.define_compressed(|file| variables.iter().try_for_each(|variable| define_map(file, variable, grid)))?;
            file.write_coordinates(grid)?;
            variables.iter().try_for_each(|variable| write_values(file, variable))
        };
        write(&mut file).map_err(|cause| output_error(path, cause))?;
        file.file.close().map_err(|cause| output_error(path, cause))?;
        let back = ReadBack::open(path)?;
        variables.iter().try_for_each(|variable| match variable.kind {
            MapKind::Class => back.compare(&variable.name, .., &classes_of(variable)),
            _ => back.compare(&variable.name, .., variable.values),
        })
    })
}

/// The scalar coordinate `time` at the end of the run.
fn define_period(file: &mut NetcdfFile<'_>, provenance: &Provenance, end_time: f64) -> netcdf::Result<()> {
    file.define_time(&[], provenance)?;
    file.describe_variable("time", &[("comment", "end of the run; maxima are over all its compute steps")])?;
    file.variable("time")?.put_value(end_time, ())
}

fn threshold_variable(threshold: f64) -> String {
    format!("threshold_{}", threshold_name(threshold))
}

fn define_threshold(file: &mut NetcdfFile<'_>, threshold: f64) -> netcdf::Result<()> {
    let name = threshold_variable(threshold);
    file.file.add_variable::<f64>(&name, &[])?;
    let long_name = format!("depth threshold {threshold} m");
    let attributes = [("standard_name", "flood_water_thickness"), ("long_name", &long_name), ("units", "m")];
    file.describe_variable(&name, &attributes)?;
    file.variable(&name)?.put_value(threshold, ())
}

fn define_map(file: &mut NetcdfFile<'_>, map: &MapVariable<'_>, grid: &OutputGrid) -> netcdf::Result<()> {
    let name = map.name.as_str();
    if map.kind == MapKind::Class {
        file.file.add_variable::<i16>(name, &["y", "x"])?;
        file.compress(name, &[grid.rows, grid.columns])?;
        let values: Vec<i16> = map.classes.iter().map(|class| i16::from(class.value)).collect();
        let meanings: Vec<&str> = map.classes.iter().map(|class| class.name.as_str()).collect();
        let mut variable = file.variable(name)?;
        variable.put_attribute("_FillValue", CLASS_FILL)?;
        variable.put_attribute("flag_values", values)?;
        variable.put_attribute("flag_meanings", meanings.join(" "))?;
    } else {
        file.file.add_variable::<f32>(name, &["y", "x"])?;
        file.compress(name, &[grid.rows, grid.columns])?;
        file.variable(name)?.put_attribute("_FillValue", FILL)?;
    }
    let coordinates = match map.threshold {
        Some(threshold) => threshold_variable(threshold),
        None if map.cell_methods.contains("time:") => "time".to_string(),
        None => String::new(),
    };
    file.describe_variable(
        name,
        &[
            ("standard_name", map.standard_name.unwrap_or_default()),
            ("long_name", &map.long_name),
            ("units", map.units),
            ("cell_methods", map.cell_methods),
            ("coordinates", &coordinates),
            ("comment", &map.comment),
        ],
    )?;
    file.georeference(name)
}

/// The values of a map of classes.
fn classes_of(map: &MapVariable<'_>) -> Vec<i16> {
    map.values.iter().map(|value| *value as i16).collect()
}

fn write_values(file: &mut NetcdfFile<'_>, map: &MapVariable<'_>) -> netcdf::Result<()> {
    let mut variable = file.variable(&map.name)?;
    if map.kind == MapKind::Class {
        variable.put_values(&classes_of(map), ..)
    } else {
        variable.put_values(map.values, ..)
    }
}
