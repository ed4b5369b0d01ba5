//! A raster of anything but the ground: read over the run's area in the run's coordinates.

use std::path::PathBuf;

use super::Findings;
use crate::error::Problem;
use crate::geodata::Crs;
use crate::scenario::{Scenario, Sourced};
use crate::terrain::{Raster, RasterFile, RasterRequest, Resampling};

/// Reads the first band of a file as it stands, warped where the scenario allows it; problems and warnings go to `findings`.
pub(super) fn read(
    file: &Sourced<PathBuf>,
    resampling: Resampling,
    scenario: &Scenario,
    crs: Option<&Crs>,
    findings: &mut Findings,
) -> Option<Raster> {
    let (raster, warnings) = values(file, resampling, scenario, crs, findings)?;
    findings.add_all(file, warnings);
    Some(raster)
}

/// The same for heights in a unit of their own, which are no elevations of a place on Earth.
pub(super) fn read_heights(
    file: &Sourced<PathBuf>,
    scenario: &Scenario,
    crs: Option<&Crs>,
    findings: &mut Findings,
) -> Option<Raster> {
    let (raster, mut warnings) = values(file, Resampling::Bilinear, scenario, crs, findings)?;
    warnings.retain(|warning| warning.code != "doubtful-elevation");
    findings.add_all(file, warnings);
    Some(raster)
}

fn values(
    file: &Sourced<PathBuf>,
    resampling: Resampling,
    scenario: &Scenario,
    crs: Option<&Crs>,
    findings: &mut Findings,
) -> Option<(Raster, Vec<Problem>)> {
    let opened = findings.take(file, RasterFile::open(&file.value))?;
    let request = RasterRequest {
        path: &file.value,
        unit: 1.0,
        offset: 0.0,
        reproject: scenario.reproject,
        resampling,
        resolution: scenario.resolution.value,
        memory: scenario.limits.memory,
    };
    findings.take(file, opened.read(&request, crs?))
}
