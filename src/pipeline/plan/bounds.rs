//! The bounds of steps and time, and of what a run takes, drawn from its first steps.

use std::ops::Range;

use super::advice::advice;
use super::disk::disk;
use super::measure::Measured;
use super::{Cells, MIB, Plan};
use crate::prepare::Scene;
use crate::scenario::Scenario;
use crate::scenario::methods::Motion;
use crate::seeding::{Reach, StillWater};

/// The mean of the fastest signal over a run, over √(g d) of the deepest water at the start: from half of that depth up to the front
/// of a dam break.
const SIGNAL: Range<f64> = 0.7..2.0;
/// An evaluation of particles of the variational formulation costs up to so many times what it does at the start: wide particles of thin water have many
/// neighbours, and walls show images of each (0.8 million evaluations a CPU second on a plane, 0.2 at Malpasset: decision 0003).
const DEARER_WHEN_SPREAD: f64 = 4.0;
/// Such a particle is taken to spread to so many times its width at most.
const WIDEST: f64 = 12.0;
/// Time (s) to write the maps per cell of the output grid: 2.5e-6 in the demonstration, 5e-6 at Malpasset at 40 m.
const MAP_SECONDS: Range<f64> = 1.5e-6..6e-6;
/// Memory (bytes) that a plan takes per cell of the lattice and a run does not: the water of the start, which the core has by then,
/// and how far it reaches.
const PLAN_BYTES: f64 = 40.0;
/// Memory (MiB) that the writers of a run take at most behind its first steps, whatever its size; they begin when the core is gone.
const WRITERS_MIB: f64 = 80.0;
/// Memory (bytes) that they take per cell of the lattice and of the output grid beyond that, at most.
const WRITERS_BYTES: f64 = 100.0;
/// Memory (bytes) that such a particle adds as it gets more neighbours.
const NEIGHBOUR_BYTES: f64 = 400.0;

/// Draws the bounds from the measurement, with the greatest memory so far (MiB).
pub fn draw(
    scenario: &Scenario,
    scene: &Scene,
    (still, reach): (&StillWater, &Reach),
    measured: Measured,
    (cells, memory_now): (Cells, f64),
) -> Plan {
    let spacing = scenario.resolution.value;
    let moves = are_particles(scenario);
    let wet = reach.cells_at.first().copied().unwrap_or(0);
    let growth = growth(scenario, still, reach, measured.particles);
    let (now, peak) = (measured.particles as f64, measured.most_particles as f64);
    let particles_at_most = match (moves, measured.is_whole) {
        (true, _) | (_, true) => peak..peak,
        (false, false) => {
            peak..peak.max(cells_of_each(scenario) * (reach.cells() + scene.needs.channel_particles) as f64)
        }
    };
    let steps = steps(scenario, &measured);
    let run_time = run_time(&steps, &measured, if moves { DEARER_WHEN_SPREAD } else { growth }, cells.of_maps);
    let cells_at_end = if moves { reach.cells() as f64 } else { now * growth };
    let neighbours = if moves { NEIGHBOUR_BYTES * peak / MIB } else { 0.0 };
    let spread = (reach.cells() as f64 / wet.max(1) as f64).sqrt().min(WIDEST);
    Plan {
        bed_particles: scene.needs.bed_particles,
        channel_particles: scene.needs.channel_particles,
        particles_at_start: measured.particles_at_start,
        particles_at_most,
        area: wet as f64 * spacing * spacing..reach.cells() as f64 * spacing * spacing,
        memory_mib: memory(memory_now, scene.lattice.len(), cells.of_maps, neighbours),
        steps,
        run_time,
        disk_mb: disk(scenario, scene, cells, wet as f64..cells_at_end),
        resolution: spacing..if moves { spacing * spread } else { spacing },
        choice: None,
        part: None,
        levels: Vec::new(),
        motion: scenario.numerics.motion,
        advice: advice(scene),
        measured,
        threads: rayon::current_num_threads(),
        warnings: Vec::new(),
    }
}

/// Greatest memory (MiB) of the run by that of its plan, on so many cells of lattice and maps.
fn memory(of_plan: f64, lattice_cells: usize, map_cells: usize, neighbours: f64) -> Range<f64> {
    let written = WRITERS_BYTES * (map_cells + lattice_cells) as f64 / MIB;
    of_plan - PLAN_BYTES * lattice_cells as f64 / MIB..of_plan + WRITERS_MIB + written + neighbours
}

fn are_particles(scenario: &Scenario) -> bool {
    !scenario.numerics.has_cells()
}

/// Cells for each square that the water reaches, at most: those that move are merged where they are smaller than half a square.
fn cells_of_each(scenario: &Scenario) -> f64 {
    if scenario.numerics.motion == Motion::Lagrangian { 2.0 } else { 1.0 }
}

/// The mean number of cells with water over the run, at most, over that after the measurement.
fn growth(scenario: &Scenario, still: &StillWater, reach: &Reach, now: usize) -> f64 {
    let deepest = still.depth.iter().copied().fold(0.0, f64::max);
    let front = 2.0 * (scenario.numerics.gravity * deepest).sqrt();
    if front <= 0.0 || now == 0 {
        return 1.0;
    }
    (reach.mean_cells(scenario.resolution.value, front, scenario.end_time) / now as f64).max(1.0)
}

/// Steps of the whole run.
fn steps(scenario: &Scenario, measured: &Measured) -> Range<f64> {
    let done = measured.steps as f64;
    let left = (scenario.end_time - measured.simulated).max(0.0);
    if measured.is_whole || left <= 0.0 {
        return done..done;
    }
    let fewest = left * SIGNAL.start / measured.first_step;
    let most = left * (SIGNAL.end / measured.first_step).max(1.0 / measured.shortest_step);
    (done + fewest).ceil()..(done + most).ceil()
}

/// Time (s) of the whole run, when an evaluation or their number grows by a factor at most.
fn run_time(steps: &Range<f64>, measured: &Measured, growth: f64, cells: usize) -> Range<f64> {
    let done = measured.steps as f64;
    let per_step = measured.seconds / measured.evaluations.max(1) as f64 * measured.last_evaluations as f64;
    let time = |steps: f64, growth: f64, write: f64| {
        measured.preparation + measured.seconds + (steps - done).max(0.0) * per_step * growth + write * cells as f64
    };
    time(steps.start, 1.0, MAP_SECONDS.start)..time(steps.end, growth, MAP_SECONDS.end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_goes_with_steps_and_with_growth() {
        let measured = Measured {
            preparation: 1.0,
            steps: 10,
            seconds: 2.0,
            evaluations: 1000,
            last_evaluations: 100,
            ..Measured::default()
        };
        // 0.2 s a step, 90 steps to go; written maps take 2e-6 s a cell or so.
        let time = run_time(&(100.0..190.0), &measured, 3.0, 0);
        assert!((time.start - 21.0).abs() < 1e-12 && (time.end - (3.0 + 180.0 * 0.2 * 3.0)).abs() < 1e-12, "{time:?}");
        assert!(run_time(&(10.0..10.0), &measured, 3.0, 1_000_000).end > 8.0);
    }
}
