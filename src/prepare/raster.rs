//! A raster of anything but the ground: read over the run's area in the run's coordinates.

use std::path::{Path, PathBuf};

use super::Findings;
use crate::error::Problem;
use crate::geodata::Crs;
use crate::scenario::{Reading, Scenario, Sourced};
use crate::terrain::{Placing, Raster, RasterFile, RasterRequest};

/// What must hold of a file before its values are read.
type Check<'a> = &'a dyn Fn(&RasterFile) -> Result<(), Problem>;

/// Reads the first band of a file as it stands, warped where the scenario allows it; problems and warnings go to `findings`.
pub(super) fn read(
    file: &Sourced<PathBuf>,
    scenario: &Scenario,
    crs: Option<&Crs>,
    check: Check<'_>,
    findings: &mut Findings,
) -> Option<Raster> {
    let (raster, warnings) = values(file, scenario, crs, check, findings)?;
    findings.add_all(file, warnings);
    Some(raster)
}

/// The same for heights in a unit of their own (so many metres), which are no elevations of a place on Earth.
pub(super) fn read_heights(
    file: &Sourced<PathBuf>,
    unit: f64,
    scenario: &Scenario,
    crs: Option<&Crs>,
    findings: &mut Findings,
) -> Option<Raster> {
    let check = |opened: &RasterFile| opened.check_unit_of_heights(Some(unit), &file.value);
    let (raster, mut warnings) = values(file, scenario, crs, &check, findings)?;
    warnings.retain(|warning| warning.code != "doubtful-elevation");
    findings.add_all(file, warnings);
    Some(raster)
}

fn values(
    file: &Sourced<PathBuf>,
    scenario: &Scenario,
    crs: Option<&Crs>,
    check: Check<'_>,
    findings: &mut Findings,
) -> Option<(Raster, Vec<Problem>)> {
    let opened = findings.take(file, RasterFile::open(&file.value))?;
    findings.take(file, check(&opened))?;
    findings.take(file, opened.read(&request(&file.value, scenario), crs?))
}

/// The same of values that belong to whole cells, with the way to them where the raster has another system.
pub(super) fn read_in_place(
    file: &Sourced<PathBuf>,
    scenario: &Scenario,
    crs: Option<&Crs>,
    findings: &mut Findings,
) -> Option<(Raster, Option<Placing>)> {
    let opened = findings.take(file, RasterFile::open(&file.value))?;
    let Reading { part, pixel } = scenario.reading;
    let request = RasterRequest { part: part.map(|part| part.own), pixel, ..request(&file.value, scenario) };
    let read = opened.read_in_place(&request, crs?);
    let (raster, placing, warnings) = findings.take(file, read)?;
    findings.add_all(file, warnings);
    Some((raster, placing))
}

/// Asks for all of a raster in its own unit.
pub(super) fn request<'a>(path: &'a Path, scenario: &Scenario) -> RasterRequest<'a> {
    RasterRequest {
        path,
        unit: 1.0,
        offset: 0.0,
        reproject: scenario.reproject,
        resolution: scenario.resolution.value,
        memory: scenario.limits.memory,
        part: None,
        pixel: None,
        is_ground: false,
    }
}
