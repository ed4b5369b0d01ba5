//! A second run of the same scenario on cells twice as wide, and what the maps of both say of the error of the finer one.
//!
//! ```text
//! (M96)  e = max |d(2Δ) − d(Δ)| / (2^p − 1),  p = 1     over the place and those beside it, up to one wide cell away
//! ```
//!
//! The order p is 1 because the errors that count are those of shores and fronts, where every scheme for water that dries is of first order.
//! The greatest difference about a place is taken, since two runs agree by chance where their water levels cross.

use crate::error::{Error, Problem, ProblemKind};
use crate::output::{ErrorRecord, FILL, GridMaps, OutputGrid, Recorder};
use crate::prepare::{Runnable, prepare};
use crate::scenario::methods::Motion;
use crate::scenario::{Levels, Scenario, Sourced};
use crate::solver::FlowSolver;

use super::records::balance;
use super::stages::{flow_problem, recorder_of, recorder_plan};
use super::steps::step_towards;
use super::{clock, cores, levels};

/// The maps of a run on wider cells.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct SecondRun {
    grid: OutputGrid,
    maps: GridMaps,
    /// What it was.
    record: ErrorRecord,
}

/// The scenario on cells twice as wide, with maps on its own cells and nothing else.
fn on_wider_cells(scenario: &Scenario) -> Scenario {
    let mut wider = scenario.clone();
    wider.resolution.value *= 2.0;
    wider.levels = scenario.levels.as_ref().map(|levels| {
        let mut levels = Levels::clone(levels);
        levels.coarsest.value *= 2.0;
        levels.refine.iter_mut().for_each(|Sourced { value, .. }| value.to *= 2.0);
        levels
    });
    wider.outputs.cell = wider.resolution.value;
    wider.outputs.maps_on_terrain = None;
    wider.outputs.gauges = None;
    wider.outputs.sections = None;
    wider
}

/// Runs a scenario on cells twice as wide.
///
/// # Errors
/// The problem, as a warning, where the scenario cannot be run on them, or the run breaks down.
pub(super) fn run(scenario: &Scenario) -> Result<SecondRun, Problem> {
    let wider = on_wider_cells(scenario);
    let spacing = wider.resolution.value;
    let without = |cause: String| {
        let message = format!("the error of the maps is not estimated: there is no run on cells of {spacing} m");
        let problem = Problem::warning(ProblemKind::Scenario, "no-error-estimate", "outputs.error_estimate", message);
        problem.with_cause(cause).with_remedy("take a finer `resolution`, or leave `outputs.error_estimate` out")
    };
    let before = clock::processor_seconds();
    let Runnable { setup, .. } = prepare(&wider).into_runnable().map_err(|error| without(first_of(&error)))?;
    let (setup, _) = levels::settle(&wider, setup);
    let problem = flow_problem(&wider, &setup, setup.bed.clone());
    let seeds = cores::seeds(&wider, &problem, &setup.still_water, &setup.scene.levels());
    let mut solver = cores::build(&wider, problem, seeds, &setup.initial_velocity);
    if wider.numerics.motion == Motion::Lagrangian && !solver.has_moving() {
        return Err(without("no cell moves there, as cells of this run do".to_owned()));
    }
    let mut recorder = recorder_of(&wider, recorder_plan(&wider, &setup.scene, setup.bed, setup.pixels));
    recorder.leave_out_frames();
    to_the_end(wider.end_time, solver.as_mut(), &mut recorder).map_err(|error| without(error.to_string()))?;
    let record = ErrorRecord {
        spacing_m: spacing,
        order: 1,
        particle_evaluations: solver.particle_evaluations(),
        cpu_s: clock::processor_seconds() - before,
        ..ErrorRecord::default()
    };
    Ok(SecondRun { grid: recorder.grid_of_maps().clone(), maps: recorder.finish().maps, record })
}

/// The first error of several.
fn first_of(error: &Error) -> String {
    match error {
        Error::Problems(problems) => {
            problems.first().map_or_else(String::new, |problem| format!("{} ({})", problem.message, problem.code))
        }
        other => other.to_string(),
    }
}

/// Takes all steps.
fn to_the_end(end: f64, solver: &mut dyn FlowSolver, recorder: &mut Recorder) -> Result<(), Error> {
    let mut no_sink = |_| Ok(());
    let first = balance(solver);
    recorder.start(&solver.water(), first, &mut no_sink)?;
    while solver.time() < end {
        let step = step_towards(end, solver);
        solver.advance(step.time_step)?;
        if solver.is_record_due(end) {
            let time = solver.time();
            let balance = recorder.is_frame_due(time).then(|| balance(solver));
            recorder.step(time, &solver.water(), balance, &mut no_sink)?;
        }
    }
    Ok(())
}

/// Depth (m) from which ground counts as flooded in the means of the record.
const FLOODED: f64 = 0.01;

impl SecondRun {
    /// Adds the estimated errors to the maps of the finer run; returns what they come to.
    pub fn compare(self, grid: &OutputGrid, maps: &mut GridMaps) -> ErrorRecord {
        let nearest = self.places(grid);
        let about = (self.record.spacing_m / grid.cell).round().max(1.0) as usize;
        let depth = |cell: usize, bed: f32| {
            let (level, depth) = (self.maps.max_water_level[cell], self.maps.max_depth[cell]);
            if depth > 0.0 && level > FILL { (level - bed).max(0.0) } else { 0.0 }
        };
        let depths: Vec<f32> = nearest
            .iter()
            .zip(maps.bed_elevation.iter().zip(&maps.max_depth))
            .map(|(place, (&bed, &own))| match place {
                Some(cell) if bed > FILL && own > FILL => (own - depth(*cell, bed)).abs(),
                _ => FILL,
            })
            .collect();
        let arrival = |(place, own): (&Option<usize>, &f32)| match place {
            Some(cell) if *own > FILL => {
                let other = self.maps.thresholds[0].arrival[*cell];
                if other > FILL { (own - other).abs() } else { FILL }
            }
            _ => FILL,
        };
        let arrivals: Vec<f32> = nearest.iter().zip(&maps.thresholds[0].arrival).map(arrival).collect();
        maps.max_depth_error = greatest_about(grid.columns, &depths, about);
        maps.arrival_time_error = greatest_about(grid.columns, &arrivals, about);
        let is_flooded = |(error, depth): &(&f32, &f32)| **error > FILL && f64::from(**depth) >= FLOODED;
        let of_depth = maps.max_depth_error.iter().zip(&maps.max_depth).filter(is_flooded);
        let of_depth = of_depth.map(|(error, _)| f64::from(*error)).collect();
        let of_arrival = maps.arrival_time_error.iter().filter(|error| **error > FILL).map(|error| f64::from(*error));
        let (mean_depth_m, depth_95_m) = mean_and_95(of_depth);
        let (mean_arrival_s, arrival_95_s) = mean_and_95(of_arrival.collect());
        ErrorRecord { mean_depth_m, depth_95_m, mean_arrival_s, arrival_95_s, ..self.record }
    }

    /// Of each cell of a grid the one of the second run at its centre.
    fn places(&self, grid: &OutputGrid) -> Vec<Option<usize>> {
        let own = &self.grid;
        let within = |place: f64, count: usize| {
            let index = (place / own.cell).floor();
            (index >= 0.0 && index < count as f64).then_some(index as usize)
        };
        let columns: Vec<Option<usize>> = grid.x().iter().map(|x| within(x - own.west, own.columns)).collect();
        let rows: Vec<Option<usize>> = grid.y().iter().map(|y| within(own.north - y, own.rows)).collect();
        let place = |row: Option<usize>, column: Option<usize>| Some(row? * own.columns + column?);
        rows.iter().flat_map(|row| columns.iter().map(move |column| place(*row, *column))).collect()
    }
}

/// The greatest value within so many cells of each that has one.
fn greatest_about(columns: usize, values: &[f32], about: usize) -> Vec<f32> {
    let rows = values.len() / columns.max(1);
    // First along the rows, then along the columns.
    let along = |values: &[f32], index: usize, step: usize, at: usize, count: usize| {
        let (from, to) = (at.saturating_sub(about), (at + about + 1).min(count));
        (from..to).map(|other| values[index + other * step - at * step]).fold(FILL, f32::max)
    };
    let wide: Vec<f32> = (0..values.len()).map(|cell| along(values, cell, 1, cell % columns, columns)).collect();
    let greatest =
        |cell: usize| if values[cell] > FILL { along(&wide, cell, columns, cell / columns, rows) } else { FILL };
    (0..values.len()).map(greatest).collect()
}

/// The mean, and the value that 95 % do not exceed; none of nothing.
fn mean_and_95(mut values: Vec<f64>) -> (Option<f64>, Option<f64>) {
    if values.is_empty() {
        return (None, None);
    }
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.sort_unstable_by(f64::total_cmp);
    (Some(mean), Some(values[(values.len() - 1) * 95 / 100]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_greatest_about_a_place_stays_on_ground() {
        let values = [0.0, 1.0, FILL, 0.0, 0.0, 5.0];
        assert_eq!(greatest_about(3, &values, 1), [1.0, 5.0, FILL, 1.0, 5.0, 5.0]);
        assert_eq!(greatest_about(3, &values, 2), [5.0, 5.0, FILL, 5.0, 5.0, 5.0]);
    }

    #[test]
    fn means_of_nothing_are_none() {
        assert_eq!(mean_and_95(Vec::new()), (None, None));
        assert_eq!(mean_and_95((0..=100).map(f64::from).collect()), (Some(50.0), Some(95.0)));
    }
}
