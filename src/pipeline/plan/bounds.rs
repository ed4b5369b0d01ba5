//! The bounds of steps and time, and of what a run takes, drawn from its first steps.

use std::ops::Range;

use super::advice::advice;
use super::look::Expected;
use super::measure::Measured;
use super::{MIB, Plan};
use crate::pipeline::disk::{Cells, Disk, disk};
use crate::prepare::{BYTES_PER_SAMPLE, Scene};
use crate::scenario::Scenario;
use crate::scenario::methods::Motion;
use crate::seeding::{Reach, StillWater};

/// What runs had at most and at least of what a look said of them: cells with water, their mean, steps, time (decision 0073).
const CELLS: Range<f64> = 0.5..2.0;
const MEAN_CELLS: Range<f64> = 0.7..1.6;
const STEPS: Range<f64> = 0.5..2.0;
const TIME: Range<f64> = 0.5..2.0;
/// Time (s) to start, to write files however small, and to read them back.
const WRITING: Range<f64> = 0.05..1.0;
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

/// Draws the bounds from the measurement and the look, with the greatest memory so far (MiB).
pub fn draw(
    scenario: &Scenario,
    scene: &Scene,
    (still, reach): (&StillWater, &Reach),
    (measured, expected): (Measured, Option<Expected>),
    (cells, memory_now): (Cells, f64),
) -> (Plan, Disk) {
    let spacing = scenario.resolution.value;
    let moves = are_particles(scenario);
    let wet = reach.cells_at.first().copied().unwrap_or(0);
    let growth = growth(scenario, still, reach, measured.particles);
    let (now, peak) = (measured.particles as f64, measured.most_particles as f64);
    let particles_at_most = particles(scenario, scene, reach, (&measured, expected));
    let steps = match expected {
        Some(expected) => steps_by(&measured, expected),
        None => steps(scenario, &measured),
    };
    let run_time = match expected {
        Some(expected) => time_by(&measured, (expected, &steps), cells.of_maps),
        None => run_time(&steps, &measured, if moves { DEARER_WHEN_SPREAD } else { growth }, cells.of_maps),
    };
    let wet_cells = match expected {
        Some(expected) => MEAN_CELLS.start * expected.mean..MEAN_CELLS.end * expected.mean,
        None if moves => wet as f64..reach.cells() as f64,
        None => wet as f64..now * growth,
    };
    let of_checkpoints = scenario.limits.checkpoint.is_some_and(|every| run_time.end > every);
    let disk = disk(scenario, scene, cells, (wet_cells, of_checkpoints));
    let neighbours = if moves { NEIGHBOUR_BYTES * peak / MIB } else { 0.0 };
    let spread = (reach.cells() as f64 / wet.max(1) as f64).sqrt().min(WIDEST);
    let cell_area = spacing * spacing;
    let in_mb = |bytes: &Range<f64>| bytes.start / 1e6..bytes.end / 1e6;
    let covered = expected.map_or(reach.cells() as f64, |expected| CELLS.end * expected.most);
    let plan = Plan {
        bed_particles: scene.needs.bed_particles,
        channel_particles: scene.needs.channel_particles,
        particles_at_start: measured.particles_at_start,
        particles_at_most,
        area: wet as f64 * cell_area..(wet as f64).max(covered) * cell_area,
        memory_mib: memory(memory_now, scene.lattice.len(), (cells.of_maps, samples(scenario, scene)), neighbours),
        steps,
        run_time,
        disk_mb: in_mb(&disk.at_end),
        disk_on_the_way_mb: in_mb(&disk.on_the_way),
        resolution: spacing..if moves { spacing * spread } else { spacing },
        choice: None,
        part: None,
        levels: Vec::new(),
        motion: scenario.numerics.motion,
        advice: advice(scene),
        look: expected.map(|expected| expected.spacing),
        measured,
        threads: rayon::current_num_threads(),
        warnings: Vec::new(),
    };
    (plan, disk)
}

/// Particles that carry water at once, at most.
fn particles(
    scenario: &Scenario,
    scene: &Scene,
    reach: &Reach,
    (measured, expected): (&Measured, Option<Expected>),
) -> Range<f64> {
    let (peak, beside) = (measured.most_particles as f64, scene.needs.channel_particles as f64);
    let of_each = cells_of_each(scenario);
    match expected {
        _ if are_particles(scenario) || measured.is_whole => peak..peak,
        Some(expected) => {
            let all = of_each * (scene.needs.bed_particles as f64 + beside);
            let most = of_each * CELLS.end * expected.most + beside;
            peak.max(CELLS.start * expected.most)..peak.max(most).min(all)
        }
        None => peak..peak.max(of_each * (reach.cells() as f64 + beside)),
    }
}

/// Samples of all gauges over the run.
fn samples(scenario: &Scenario, scene: &Scene) -> f64 {
    let gauges = scene.gauges.len() + scene.channels.iter().map(|channel| channel.gauges.len()).sum::<usize>();
    gauges as f64 * (scenario.end_time / scenario.outputs.gauges_every).ceil()
}

/// Steps of the whole run by a look, no fewer than were measured.
fn steps_by(measured: &Measured, expected: Expected) -> Range<f64> {
    let done = measured.steps as f64;
    done.max((STEPS.start * expected.steps).ceil())..done.max((STEPS.end * expected.steps).ceil())
}

/// Time (s) of the whole run by a look: by its evaluations, and by its steps, which cost something each however little water there is.
fn time_by(measured: &Measured, (expected, steps): (Expected, &Range<f64>), map_cells: f64) -> Range<f64> {
    let per_evaluation = measured.seconds / measured.evaluations.max(1) as f64;
    let per_step = measured.seconds / measured.steps.max(1) as f64;
    let (of_evaluations, of_steps) = (per_evaluation * expected.evaluations, per_step * expected.steps);
    let least = TIME.start * of_evaluations.min(of_steps).max(0.5 * of_evaluations);
    let most = TIME.end * of_evaluations.max(of_steps.min(2.0 * of_evaluations));
    let done = measured.seconds * (steps.start / measured.steps.max(1) as f64).min(1.0);
    measured.preparation + done.max(least) + MAP_SECONDS.start * map_cells + WRITING.start
        ..measured.preparation + done.max(most) + MAP_SECONDS.end * map_cells + WRITING.end
}

/// Greatest memory (MiB) of the run by that of its plan, on so many cells of lattice and maps.
fn memory(of_plan: f64, lattice_cells: usize, (map_cells, samples): (f64, f64), neighbours: f64) -> Range<f64> {
    let written = WRITERS_BYTES * (map_cells + lattice_cells as f64) / MIB;
    let series = samples / MIB;
    of_plan - PLAN_BYTES * lattice_cells as f64 / MIB
        ..of_plan + WRITERS_MIB + written + neighbours + BYTES_PER_SAMPLE * series
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
fn run_time(steps: &Range<f64>, measured: &Measured, growth: f64, cells: f64) -> Range<f64> {
    let done = measured.steps as f64;
    let per_step = measured.seconds / measured.evaluations.max(1) as f64 * measured.last_evaluations as f64;
    let time = |steps: f64, growth: f64, write: f64| {
        measured.preparation + measured.seconds + (steps - done).max(0.0) * per_step * growth + write * cells
    };
    time(steps.start, 1.0, MAP_SECONDS.start) + WRITING.start..time(steps.end, growth, MAP_SECONDS.end) + WRITING.end
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
        let time = run_time(&(100.0..190.0), &measured, 3.0, 0.0);
        let most = 3.0 + 180.0 * 0.2 * 3.0 + WRITING.end;
        assert!((time.start - 21.0 - WRITING.start).abs() < 1e-12 && (time.end - most).abs() < 1e-12, "{time:?}");
        assert!(run_time(&(10.0..10.0), &measured, 3.0, 1e6).end > 8.0);
    }
}
