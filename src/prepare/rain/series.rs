//! Rain as a series of rasters: a NetCDF variable of time, y and x, or a CSV list of times and raster files.
//!
//! Each raster holds for its interval, constant in time: from its own time to that of the next one (`stamp: begin`), from the one
//! before to its own (`stamp: end`), or as the bounds of a NetCDF file say. The raster at an end of the series that has no
//! neighbour there holds as long as the one beside it. Not here: their values and losses ([`crate::prepare::rain::frames`]), the axes
//! ([`crate::geodata::cf_axes`]) and times ([`crate::prepare::rain::times`]) of a NetCDF file.

mod intervals;
mod list;
mod units;

use std::ops::Range;
use std::path::PathBuf;

use crate::calendar::UtcTime;
use crate::error::{Problem, input_error};
use crate::geodata::cf_axes::{check_axes_are_known, check_order, gdal_name, is_netcdf, text_of};
use crate::geodata::{Crs, netcdf_file, readable_file};
use crate::prepare::findings::Findings;
use crate::prepare::rain::Losses;
use crate::prepare::rain::times::{self, Start, Times};
use crate::scenario::{RainUnit, Scenario, Sourced, Stamp, VectorSource};
use crate::terrain::RasterFile;
use intervals::{coverage, far_beyond, intervals};
pub use list::listed_files;
use list::{List, list_series};
pub use units::check_unit;
use units::{times_time, unit_of_file, unit_remedy};

/// Rasters with their times, their values not yet read.
#[derive(Debug)]
pub struct Opened {
    /// The interval (s) of each raster.
    pub intervals: Vec<Range<f64>>,
    pub rasters: Rasters,
    pub unit: RainUnit,
    pub losses: Losses,
    /// Reference system of the run.
    pub crs: Crs,
}

/// Where the rasters are.
#[derive(Debug)]
pub enum Rasters {
    /// Bands of one file.
    Bands(Box<RasterFile>),
    /// Files of one raster each.
    Files(Vec<PathBuf>),
}

/// What the scenario says of the series.
pub struct Asked<'a> {
    pub file: &'a Sourced<VectorSource>,
    pub unit: Option<RainUnit>,
    pub stamp: Option<Stamp>,
    /// Date of the file at which the run begins.
    pub start: Option<UtcTime>,
}

/// Opens the file and finds the interval of each raster; none after an error.
pub fn open(
    asked: &Asked,
    losses: Losses,
    scenario: &Scenario,
    crs: Option<&Crs>,
    findings: &mut Findings,
) -> Option<Opened> {
    let path = &asked.file.value.path;
    findings.take(asked.file, readable_file(path))?;
    let reference = scenario.reference_time;
    // Dates have no unit, and the times of a NetCDF file have theirs beside them.
    let (times, rasters, unit, has_unit) = if is_netcdf(path) {
        let (times, rasters, unit) = findings.take(asked.file, netcdf_series(asked, reference))?;
        (times, rasters, unit, false)
    } else {
        let List { times, files, unit, is_dated } = findings.take_all(asked.file, list_series(asked, reference))?;
        (Times { times, bounds: None }, Rasters::Files(files), unit, !is_dated)
    };
    let name = path.display().to_string();
    let intervals = findings.take(asked.file, intervals(&times, asked.stamp, &name))?;
    let gaps = coverage(&intervals, losses.until, times.bounds.is_some(), &name);
    findings.add_all(asked.file, gaps);
    if has_unit {
        findings.add_all(asked.file, far_beyond(&intervals, losses.until, &name));
    }
    Some(Opened { intervals, rasters, unit, losses, crs: crs?.clone() })
}

/// A NetCDF variable of three dimensions, the first of which is the time.
fn netcdf_series(asked: &Asked, reference: Option<UtcTime>) -> Result<(Times, Rasters, RainUnit), Problem> {
    let path = &asked.file.value.path;
    let name = path.display().to_string();
    let file = netcdf_file::open(path).map_err(|cause| times::not_netcdf(&name, &cause))?;
    let variable = rain_variable(&file, asked.file.value.layer.as_deref(), &name)?;
    check_order(&file, &variable, &name)?;
    check_axes_are_known(&file, &variable, &name)?;
    let times = times::read(&file, &variable, Start { own: asked.start, reference }, &name)?;
    let unit = netcdf_unit(asked, &variable, &name)?;
    let raster = RasterFile::open_as(path, &gdal_name(path, &variable.name()))?;
    if raster.bands() != times.times.len() {
        let cause = format!("it has {} rasters and {} times", raster.bands(), times.times.len());
        return Err(times::no_time(&variable.name(), &name, cause));
    }
    Ok((times, Rasters::Bands(Box::new(raster)), unit))
}

/// The variable of that name, or the only one of time, y and x.
fn rain_variable<'a>(file: &'a netcdf::File, asked: Option<&str>, name: &str) -> Result<netcdf::Variable<'a>, Problem> {
    let of_three: Vec<netcdf::Variable<'a>> = file.variables().filter(|v| v.dimensions().len() == 3).collect();
    let names = of_three.iter().map(|variable| variable.name()).collect::<Vec<_>>().join(", ");
    let listed = if names.is_empty() { "it has none".to_owned() } else { format!("it has {names}") };
    let count = of_three.len();
    let mut fitting = of_three.into_iter().filter(|variable| asked.is_none_or(|asked| variable.name() == asked));
    match (fitting.next(), asked) {
        (Some(variable), Some(_)) => Ok(variable),
        (Some(variable), None) if count == 1 => Ok(variable),
        (None, Some(asked)) => {
            let message = format!("{name} has no variable `{asked}` of time, y and x");
            Err(input_error("no-variable", message).with_cause(listed).with_remedy("correct the name behind the colon"))
        }
        (_, None) => {
            let message = format!("which variable of {name} is the rain is not known");
            let remedy = "name one behind a colon, as in `radar.nc:rainfall`; its dimensions are time, y and x";
            Err(input_error("no-variable", message).with_cause(listed).with_remedy(remedy))
        }
    }
}

/// The unit of the scenario, which must agree with that of the variable, or else the latter.
fn netcdf_unit(asked: &Asked, variable: &netcdf::Variable, name: &str) -> Result<RainUnit, Problem> {
    let written = text_of(variable, "units");
    let own = written.as_deref().and_then(unit_of_file);
    match (asked.unit, own, written) {
        (Some(asked), _, written) => {
            check_unit(asked, &written.unwrap_or_default(), &format!("`{}` of {name}", variable.name())).map(|()| asked)
        }
        (None, Some(unit), _) => Ok(unit),
        (None, None, written) => {
            let cause = written.as_deref().and_then(times_time);
            let found = match (written, &cause) {
                (None, _) => "no unit".to_owned(),
                (Some(written), None) => format!("the unit `{written}`, which is not known"),
                (Some(written), Some(_)) => format!("the unit `{written}`, which is none of rain"),
            };
            let message = format!("`{}` of {name} has {found}", variable.name());
            let problem = input_error("missing-unit", message).with_remedy(unit_remedy());
            Err(cause.into_iter().fold(problem, Problem::with_cause))
        }
    }
}

#[cfg(test)]
mod tests;
