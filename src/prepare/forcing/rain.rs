//! Rain: its series and rasters opened, and put on the lattice.

use crate::bed::BedParticles;
use crate::boundary::Rain;
use crate::error::input_error;
use crate::geodata::Crs;
use crate::prepare::findings::Findings;
use crate::prepare::rain::{self, Losses, frames, series as rain_series};
use crate::prepare::tables::dates::Origin;
use crate::prepare::tables::rows::Meaning;
use crate::prepare::tables::series;
use crate::scenario::units::INTENSITY;
use crate::scenario::{Rain as Written, RainAmount, RainUnit, Scenario, Sourced};
use crate::terrain::{Layer, RasterFile, Terrain};

const FALLING: Meaning = Meaning {
    dimension: &INTENSITY,
    negative: Some("leave out the rows of a code for missing values; what the ground takes of the rain is `losses`"),
};

/// Rain before it is put on the lattice.
#[derive(Debug)]
pub enum OpenedRain {
    Uniform(Rain),
    Raster(Terrain, Losses),
    Series(rain_series::Opened),
}

/// Opens the file of the rain; what is not rain is refused.
pub fn open(
    rain: &Sourced<Written>,
    scenario: &Scenario,
    crs: Option<&Crs>,
    findings: &mut Findings,
) -> Option<OpenedRain> {
    let until = rain.value.duration.unwrap_or(scenario.end_time).min(scenario.end_time);
    let losses = Losses { initial: rain.value.initial_loss, constant: rain.value.constant_loss, until };
    match &rain.value.amount {
        RainAmount::Rate(rate) => {
            let (key, place) = rate.source();
            let rate = series::series(rate, FALLING, (until, Origin::of_run(scenario)), findings)?;
            if let Some(problem) = rain::doubtful(rate.peak()) {
                findings.add_at(key, place.cloned(), problem);
            }
            Some(OpenedRain::Uniform(rain::uniform(&rate, losses)))
        }
        RainAmount::Raster { file, unit } => {
            let check = |opened: &RasterFile| {
                rain_series::check_unit(RainUnit::Intensity(unit.1), &opened.unit(), &file.value.display().to_string())
            };
            let mut raster = crate::prepare::raster::read(file, scenario, crs, &check, findings)?;
            let negative = raster.values.iter().filter(|value| **value < 0.0).count();
            if negative > 0 {
                let message = format!("{negative} cells of {} have rain below 0", file.value.display());
                let problem = input_error("negative-value", message)
                    .with_cause("a fill value that the file does not declare, perhaps")
                    .with_remedy("declare it, as with `gdal_edit.py -a_nodata`");
                findings.add(file, problem);
                return None;
            }
            raster.values.iter_mut().for_each(|value| *value *= unit.1);
            findings.add_all(file, rain::doubtful(raster.values.iter().copied().fold(0.0, f64::max)));
            Terrain::new(vec![Layer::Raster(raster)]).map(|terrain| OpenedRain::Raster(terrain, losses))
        }
        RainAmount::Series { file, unit, stamp, start } => {
            let unit = unit.as_ref().map(|unit| unit.1);
            let asked = rain_series::Asked { file, unit, stamp: *stamp, start: *start };
            rain_series::open(&asked, losses, scenario, crs, findings).map(OpenedRain::Series)
        }
    }
}

/// Puts the rain on the lattice.
pub fn on_lattice(
    opened: OpenedRain,
    source: &Sourced<Written>,
    scenario: &Scenario,
    ground: &BedParticles,
    findings: &mut Findings,
) -> Option<Rain> {
    match opened {
        OpenedRain::Uniform(rain) => Some(rain),
        OpenedRain::Raster(raster, losses) => Some(rain::map(at_cells(&raster, source, ground, findings), losses)),
        OpenedRain::Series(series) => match &source.value.amount {
            RainAmount::Series { file, .. } => frames::on_lattice(series, file, scenario, ground, findings),
            RainAmount::Rate(_) | RainAmount::Raster { .. } => None,
        },
    }
}

/// The rate (m/s) of a raster of rain at every cell; refuses one that does not cover the terrain.
fn at_cells(raster: &Terrain, source: &Sourced<Written>, ground: &BedParticles, findings: &mut Findings) -> Vec<f64> {
    let (lattice, bed) = (&ground.lattice, &ground.elevation);
    let at = |cell: usize| raster.elevation(lattice.to_map(lattice.centre(cell)));
    let values: Vec<Option<f64>> = (0..lattice.len()).map(at).collect();
    let with_terrain = || (0..lattice.len()).filter(|&cell| !bed[cell].is_nan());
    let missing: Vec<usize> = with_terrain().filter(|&cell| values[cell].is_none()).collect();
    if let Some(&first) = missing.first() {
        let share = 100.0 * missing.len() as f64 / with_terrain().count() as f64;
        let message =
            format!("the raster of rain has no value for {share:.1} % of the terrain ({} cells)", missing.len());
        let problem = input_error("rain-gap", message)
            .with_remedy("give it values there, 0 where no rain falls")
            .with_at(lattice.to_map(lattice.centre(first)));
        findings.add(source, problem);
    }
    // At the rim of the raster a rate goes on as it falls, to no rain at most.
    values.into_iter().map(|value| value.unwrap_or(0.0).max(0.0)).collect()
}
