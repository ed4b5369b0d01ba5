//! Rasters of rain on the lattice: the cell of the raster that holds the centre of a cell of the lattice counts for it, and every
//! value that the run needs is checked.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use crate::bed::BedParticles;
use crate::boundary::{Rain, RainFrames};
use crate::error::{Problem, ProblemKind, Severity, input_error};
use crate::lattice::Lattice;
use crate::math::{Vec2, in_bytes};
use crate::prepare::findings::Findings;
use crate::prepare::rain::series::{Opened, Rasters, check_unit};
use crate::prepare::rain::{DOUBTFUL, DOUBTFUL_CAUSE, Losses};
use crate::scenario::units::INTENSITY;
use crate::scenario::{RainUnit, Scenario, Sourced, VectorSource};
use crate::terrain::{Placing, Raster, RasterFile};

/// Share of the greatest depth within which two depths are the same.
const SAME_DEPTH: f64 = 1e-6;
/// Share of a cell by which the places of two rasters may differ.
const SAME_PLACE: f64 = 1e-3;

/// The rasters of one grid, as far as cells of the lattice lie in them.
struct Grid {
    of: Raster,
    /// The way to them, where they lie in another system.
    placing: Option<Placing>,
    /// Index in the raster of each place, and cells of the lattice in it.
    places: Vec<(usize, usize)>,
    /// A cell of the lattice in each place.
    example: Vec<usize>,
    /// Place of each cell of the lattice.
    place: Vec<u32>,
}

impl Grid {
    /// Finds the places; a problem where the raster does not cover the terrain.
    fn new(
        (raster, placing): (Raster, Option<Placing>),
        path: &Path,
        name: &str,
        ground: &BedParticles,
    ) -> Result<(Grid, Option<Problem>), Problem> {
        let (lattice, bed) = (&ground.lattice, &ground.elevation);
        let mut numbers: BTreeMap<usize, u32> = BTreeMap::new();
        let cells: Vec<usize> = (0..lattice.len()).filter(|&cell| !bed[cell].is_nan()).collect();
        let mut centres: Vec<Vec2> = cells.iter().map(|&cell| lattice.to_map(lattice.centre(cell))).collect();
        if let Some(placing) = &placing {
            placing.apply(&mut centres, path)?;
        }
        let place = vec![0; lattice.len()];
        let mut grid = Grid { of: raster, placing, places: Vec::new(), example: Vec::new(), place };
        let mut beside = Vec::new();
        for (&cell, &centre) in cells.iter().zip(&centres) {
            let Some((column, row)) = grid.of.cell_at(centre) else {
                beside.push(cell);
                continue;
            };
            let index = row * grid.of.columns + column;
            let next = grid.places.len() as u32;
            let number = *numbers.entry(index).or_insert(next);
            if number == next {
                grid.places.push((index, 0));
                grid.example.push(cell);
            }
            grid.places[number as usize].1 += 1;
            grid.place[cell] = number;
        }
        let problem = beside.first().map(|&first| {
            let share = share_of(beside.len(), cells.len(), lattice);
            input_error("rain-outside", format!("the rasters of {name} do not cover {share}"))
                .with_remedy("take rasters of the whole terrain, or cut the terrain; check that both have the same CRS")
                .with_at(lattice.to_map(lattice.centre(first)))
        });
        Ok((grid, problem))
    }

    /// Whether a raster lies on the same grid.
    fn is_same(&self, other: &Raster, placing: Option<&Placing>) -> bool {
        let is_placed_alike = match (&self.placing, placing) {
            (Some(own), Some(other)) => own.is_same(other, SAME_PLACE),
            (None, None) => true,
            _ => false,
        };
        let own = &self.of;
        let near = |a: f64, b: f64| (a - b).abs() <= SAME_PLACE * own.cell_x.min(own.cell_y);
        is_placed_alike
            && (own.columns, own.rows) == (other.columns, other.rows)
            && near(own.west, other.west)
            && near(own.north, other.north)
            && near(own.east(), other.east())
            && near(own.south(), other.south())
    }
}

/// Part of the terrain, as a share, in cells and by its area.
fn share_of(cells: usize, terrain: usize, lattice: &Lattice) -> String {
    let share = 100.0 * cells as f64 / terrain.max(1) as f64;
    format!("{share:.1} % of the terrain ({cells} cells, {} m²)", cells as f64 * lattice.cell_area())
}

/// Values that a raster should not have.
#[derive(Default)]
struct Faulty {
    /// Rasters that have them, the first of them at this time (s) on a cell of the lattice, and the most cells of one.
    rasters: usize,
    first: Option<(f64, usize)>,
    most_cells: usize,
}

impl Faulty {
    fn note(&mut self, values: &[f64], grid: &Grid, from: f64, is_faulty: impl Fn(f64) -> bool) {
        let found: Vec<usize> = (0..values.len()).filter(|&place| is_faulty(values[place])).collect();
        let Some(&first) = found.first() else { return };
        self.rasters += 1;
        self.first.get_or_insert((from, grid.example[first]));
        self.most_cells = self.most_cells.max(found.iter().map(|&place| grid.places[place].1).sum());
    }

    /// The problem: `what` some rasters have.
    fn problem(
        &self,
        code: &'static str,
        what: &str,
        count: usize,
        terrain: usize,
        lattice: &Lattice,
    ) -> Option<Problem> {
        let (time, cell) = self.first?;
        let share = share_of(self.most_cells, terrain, lattice);
        let message = format!("{} of {count} rasters {what} for up to {share}, first at {time} s", self.rasters);
        Some(input_error(code, message).with_at(lattice.to_map(lattice.centre(cell))))
    }
}

/// The problem of so many rasters with so many cells on the terrain, where they exceed the memory (bytes).
fn too_large(rasters: usize, cells: usize, memory: f64) -> Option<Problem> {
    let bytes = (rasters * cells * size_of::<f64>()) as f64;
    (bytes > memory).then(|| {
        let [needed, limit] = [bytes, memory].map(in_bytes);
        let message = format!(
            "{rasters} rasters with {cells} cells each on the terrain need {needed} of memory, over the limit of {limit}"
        );
        Problem::error(ProblemKind::Limit, "memory-limit", "", message)
            .with_remedy("coarsen the rasters in space or time, or raise `limits.memory`")
    })
}

/// A file of a list, which must not leave open which of its bands is meant.
fn open_single(path: &Path, unit: RainUnit) -> Result<RasterFile, Problem> {
    let raster = RasterFile::open(path)?;
    check_unit(unit, &raster.unit(), &path.display().to_string())?;
    if raster.bands() == 1 {
        return Ok(raster);
    }
    let message = format!("{} has {} bands, and a list gives one raster for each time", path.display(), raster.bands());
    Err(input_error("several-bands", message)
        .with_remedy("write each band that is rain to a file of its own (`gdal_translate -b 1 IN OUT`) and list that"))
}

/// Of the warnings of each file the first of each kind, with the number of files that have it.
fn one_of_a_kind(reported: Vec<Vec<Problem>>) -> Vec<Problem> {
    let mut kinds: Vec<(Problem, usize)> = Vec::new();
    for mut warnings in reported {
        warnings.dedup_by_key(|warning| warning.code);
        for warning in warnings {
            match kinds.iter_mut().find(|(first, _)| first.code == warning.code) {
                Some((_, files)) => *files += 1,
                None => kinds.push((warning, 1)),
            }
        }
    }
    let counted = |(mut warning, files): (Problem, usize)| {
        if files > 1 {
            warning.message += &format!(" (the first of {files} such rasters of the list)");
        }
        warning
    };
    kinds.into_iter().map(counted).collect()
}

/// The problem of depths (m) that look like totals since the beginning: in three rasters or more they fall nowhere, and their mean
/// rises.
fn accumulated(depths: &[Vec<f64>], grid: &Grid, name: &str) -> Option<Problem> {
    let [first, .., last] = depths else { return None };
    let greatest = depths.iter().flatten().copied().fold(0.0, f64::max);
    let falls = |pair: &[Vec<f64>]| {
        pair[0].iter().zip(&pair[1]).any(|(before, now)| now.is_nan() || *now < before - SAME_DEPTH * greatest)
    };
    let mean = |depths: &[f64]| {
        let cells: usize = grid.places.iter().map(|place| place.1).sum();
        let sum: f64 = depths.iter().zip(&grid.places).map(|(depth, place)| depth * place.1 as f64).sum();
        sum / cells.max(1) as f64
    };
    let (from, to) = (mean(first), mean(last));
    if depths.len() < 3 || depths.windows(2).any(falls) || to - from <= SAME_DEPTH * greatest {
        return None;
    }
    let message = format!(
        "the depths of {name} fall nowhere in {} rasters, and their mean over the terrain rises from {:.3} mm to {:.3} mm",
        depths.len(),
        from * 1e3,
        to * 1e3
    );
    Some(
        input_error("accumulated-rain", message)
            .with_cause("they count from the beginning of the series, it seems, and not for each interval")
            .with_remedy("take the differences of the rasters first (`cdo deltat IN OUT`); rain that does grow from each interval to the next can be given as intensities (`mm/h`)"),
    )
}

/// Reads the rasters that the run needs; none after an error.
pub fn on_lattice(
    opened: Opened,
    file: &Sourced<VectorSource>,
    scenario: &Scenario,
    ground: &BedParticles,
    findings: &mut Findings,
) -> Option<Rain> {
    let Opened { intervals, rasters, unit, losses, crs } = opened;
    let name = file.value.path.display().to_string();
    let needed: Vec<usize> =
        (0..intervals.len()).filter(|&k| intervals[k].end > 0.0 && intervals[k].start < losses.until).collect();
    let memory = scenario.limits.memory;
    let mut frames =
        Frames { name: &name, ground, count: needed.len(), memory, grid: None, beside: None, values: Vec::new() };
    let request = |path| crate::prepare::raster::request(path, scenario);
    match rasters {
        Rasters::Bands(raster) => {
            let (path, bands) = (&file.value.path, needed.iter().map(|k| k + 1));
            let warnings =
                raster.read_bands(bands, &request(path), &crs, |raster, placing| frames.take(raster, placing, path));
            let warnings = findings.take(file, warnings)?;
            findings.add_all(file, warnings);
        }
        Rasters::Files(paths) => {
            let mut reported = Vec::new();
            for path in needed.iter().map(|&k| &paths[k]) {
                let read = open_single(path, unit).and_then(|raster| {
                    raster.read_bands(1..2, &request(path), &crs, |raster, placing| frames.take(raster, placing, path))
                });
                reported.push(findings.take(file, read)?);
            }
            findings.add_all(file, one_of_a_kind(reported));
        }
    }
    let Frames { grid, beside, mut values, .. } = frames;
    let grid = grid?;
    let is_covered = beside.is_none();
    findings.add_all(file, beside);
    let needed: Vec<Range<f64>> = needed.iter().map(|&k| intervals[k].clone()).collect();
    let total = to_rates(&mut values, &needed, unit, &grid, &name);
    let is_sound = check_values((&values, &needed), &grid, file, &ground.lattice, findings) && total.is_none();
    findings.add_all(file, total);
    (is_covered && is_sound).then(|| run_off(values, &needed, grid.place, losses))
}

/// Turns values into rates (m/s); the problem of depths that grow from the start on.
fn to_rates(
    values: &mut [Vec<f64>],
    intervals: &[Range<f64>],
    unit: RainUnit,
    grid: &Grid,
    name: &str,
) -> Option<Problem> {
    let (RainUnit::Intensity(factor) | RainUnit::Depth(factor)) = unit;
    values.iter_mut().flatten().for_each(|value| *value *= factor);
    let RainUnit::Depth(_) = unit else { return None };
    let total = accumulated(values, grid, name);
    for (rates, interval) in values.iter_mut().zip(intervals) {
        rates.iter_mut().for_each(|rate| *rate /= interval.end - interval.start);
    }
    total
}

/// Rasters as they are read, one after the other: all on the grid of the first one.
struct Frames<'a> {
    name: &'a str,
    ground: &'a BedParticles,
    /// How many of them there will be, and the memory (bytes) that they may take.
    count: usize,
    memory: f64,
    grid: Option<Grid>,
    /// The problem of a grid that does not cover the terrain.
    beside: Option<Problem>,
    values: Vec<Vec<f64>>,
}

impl Frames<'_> {
    fn take(&mut self, raster: Raster, placing: Option<&Placing>, path: &Path) -> Result<(), Problem> {
        if self.grid.is_none() {
            let raster_and_way = (raster.clone(), placing.cloned());
            let (grid, beside) = Grid::new(raster_and_way, path, self.name, self.ground)?;
            (self.grid, self.beside) = (Some(grid), beside);
        }
        let Some(grid) = &self.grid else { return Ok(()) };
        if !grid.is_same(&raster, placing) {
            let message = format!("{} lies on another grid than the raster before it", path.display());
            return Err(
                input_error("other-grid", message).with_remedy("bring all rasters to one grid with `gdalwarp -te -tr`")
            );
        }
        if let Some(problem) = too_large(self.count, grid.places.len(), self.memory) {
            return Err(problem);
        }
        self.values.push(grid.places.iter().map(|&(index, _)| raster.values[index]).collect());
        Ok(())
    }
}

/// Reports values that are missing, negative or beyond all rain; whether there are none of the first two.
fn check_values(
    (values, intervals): (&[Vec<f64>], &[Range<f64>]),
    grid: &Grid,
    file: &Sourced<VectorSource>,
    lattice: &Lattice,
    findings: &mut Findings,
) -> bool {
    let (mut missing, mut negative, mut doubtful) = (Faulty::default(), Faulty::default(), Faulty::default());
    for (rates, interval) in values.iter().zip(intervals) {
        let from = interval.start;
        missing.note(rates, grid, from.max(0.0), f64::is_nan);
        negative.note(rates, grid, from.max(0.0), |rate| rate < 0.0);
        doubtful.note(rates, grid, from.max(0.0), |rate| rate > DOUBTFUL);
    }
    let (count, terrain) = (values.len(), grid.places.iter().map(|place| place.1).sum());
    let name = file.value.path.display();
    let of =
        |faulty: &Faulty, code, what: &str| faulty.problem(code, &format!("of {name} {what}"), count, terrain, lattice);
    let missing = of(&missing, "rain-gap", "have no value")
        .map(|problem| problem.with_remedy("give them values there, 0 where no rain falls"));
    let negative = of(&negative, "negative-value", "have rain below 0").map(|problem| {
        problem
            .with_cause("a fill value that the file does not declare, perhaps")
            .with_remedy("declare it: `_FillValue` in NetCDF (`ncatted`), `gdal_edit.py -a_nodata` otherwise")
    });
    let is_implausible = values.iter().flatten().any(|rate| *rate > INTENSITY.most);
    let (severity, code, bound) = if is_implausible {
        (Severity::Error, "implausible-value", format!("up to more than {:.0} m/s", INTENSITY.most))
    } else {
        (Severity::Warning, "rain-doubtful", format!("more than {:.0} mm/h", DOUBTFUL * 3.6e6))
    };
    let doubtful = of(&doubtful, code, &format!("have {bound}"))
        .map(|found| Problem { severity, ..found.with_cause(DOUBTFUL_CAUSE).with_remedy("check the unit") });
    let is_sound = missing.is_none() && negative.is_none() && !is_implausible;
    findings.add_all(file, missing.into_iter().chain(negative).chain(doubtful));
    is_sound
}

/// What runs off of intensities (m/s) in intervals (s): nothing until the initial loss has fallen, then the intensity less the
/// constant loss, as far as it is above 0.
fn run_off(mut rates: Vec<Vec<f64>>, intervals: &[Range<f64>], place: Vec<u32>, losses: Losses) -> Rain {
    let within = |interval: &Range<f64>| interval.start.max(0.0)..interval.end.min(losses.until);
    let intervals: Vec<Range<f64>> = intervals.iter().map(within).collect();
    let filled = |number: usize| {
        let mut missing = losses.initial;
        if missing <= 0.0 {
            return 0.0;
        }
        for (rates, interval) in rates.iter().zip(&intervals) {
            let falls = rates[number] * (interval.end - interval.start);
            if falls >= missing {
                return interval.start + missing / rates[number];
            }
            missing -= falls;
        }
        f64::INFINITY
    };
    let from = (0..rates.first().map_or(0, Vec::len)).map(filled).collect();
    rates.iter_mut().flatten().for_each(|rate| *rate = (*rate - losses.constant).max(0.0));
    Rain::Frames(Arc::new(RainFrames { place, from, intervals, rates }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rasters_beyond_the_memory_are_refused() {
        assert_eq!(too_large(100, 1_000_000, 0.8e9), None);
        let problem = too_large(101, 1_000_000, 0.8e9).unwrap();
        assert!(problem.kind == ProblemKind::Limit && problem.message.contains("101 rasters"), "{problem}");
    }

    #[test]
    fn losses_take_the_beginning_and_a_share_of_each_raster() {
        let losses = Losses { initial: 6.0, constant: 0.5, until: 10.0 };
        let rates = vec![vec![2.0, 0.0, 0.25], vec![1.0, 3.0, 0.25], vec![4.0, 4.0, 0.25]];
        let rain = run_off(rates, &[-1.0..2.0, 2.0..6.0, 6.0..12.0], vec![0, 1, 2], losses);
        // 4 fall until 2 s and 2 more until 4 s; then 0.5 for 2 s and 3.5 for 4 s.
        assert!((rain.depth(0, 0.0, 99.0) - 15.0).abs() < 1e-14 && rain.depth(0, 0.0, 4.0).abs() <= 0.0);
        // 6 fall from 2 to 4 s; then 2.5 for 2 s and 3.5 for 4 s.
        assert!((rain.depth(1, 0.0, 99.0) - 19.0).abs() < 1e-14 && (rain.depth(1, 3.0, 5.0) - 2.5).abs() < 1e-14);
        assert!(rain.depth(2, 0.0, 99.0).abs() <= 0.0);
    }
}
