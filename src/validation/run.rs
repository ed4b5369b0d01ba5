//! One run of a setup with chosen methods: from the start to the end, or to the step at which it breaks.

use super::case::{Exact, Setup, Until};
use super::choice::Choice;
use super::error::errors;
use super::judge::Limits;
use super::outcome::{Broken, Cost, Errors, Excess, Outcome, Sample, Snapshot};
use crate::lattice::WaterInCell;
use crate::math::Vec2;
use crate::physics::dimension::Dimension;
use crate::pipeline::clock::processor_seconds;
use crate::pipeline::cores::Core;
use crate::solver::StepChoice;
use crate::solver::threads::in_pool;

/// A run may take so many times the steps foreseen, and a few more; beyond that its step has collapsed.
const STEPS_IN_RESERVE: f64 = 20.0;
const FEWEST_STEPS: f64 = 1000.0;
/// A run whose end is this near (s) is over.
const END_TOLERANCE: f64 = 1e-9;
/// The share of the scale of the depth below which the velocity of an Eulerian particle's film is not looked at.
const FILM_SHARE: f64 = 1e-4;

/// The water of a core as it is now.
fn snapshot(core: &mut Core, setup: &Setup) -> Snapshot {
    let gravity = setup.problem.gravity;
    let samples = match core {
        Core::Variational(solver) => {
            let state = solver.state();
            let particles = &state.particles;
            let sample = |i: usize| Sample {
                place: particles.position[i],
                depth: particles.depth[i],
                velocity: particles.velocity[i],
                volume: particles.volume[i],
                bed: state.bed_at(particles.position[i]).elevation,
                concentration: 0.0,
            };
            (0..particles.len()).map(sample).collect()
        }
        Core::Balanced(_) => samples_on_lattice(core, setup),
    };
    let is_of_particles = matches!(core, Core::Variational(_));
    let depths = core.flow().water().depths();
    let depth_on_lattice = if setup.rows > 1 { mean_of_rows(&depths, setup.rows) } else { depths };
    let solver = core.flow();
    let (time, ledger, tracers) = (solver.time(), solver.ledger(), solver.tracers());
    Snapshot { is_of_particles, samples, depth_on_lattice, gravity, time, ledger, tracers }
}

/// The mean of so many rows of a lattice.
fn mean_of_rows(values: &[f64], rows: usize) -> Vec<f64> {
    let columns = values.len() / rows;
    (0..columns).map(|column| values[column..].iter().step_by(columns).sum::<f64>() / rows as f64).collect()
}

/// The cells with terrain, with the water that the maps would show there.
fn samples_on_lattice(core: &mut Core, setup: &Setup) -> Vec<Sample> {
    let bed = &setup.problem.bed;
    let lattice = &bed.lattice;
    let area = match setup.dimension {
        Dimension::One => lattice.spacing,
        Dimension::Two => lattice.cell_area(),
    };
    let film = FILM_SHARE * setup.scale_depth;
    let has_tracers = !setup.problem.forcing.tracers.is_empty();
    let water = core.flow().water();
    let sample = |i: usize| {
        let WaterInCell { depth, discharge_x, discharge_y } = water.at(i);
        let velocity = if depth > film { Vec2::new(discharge_x, discharge_y) / depth } else { Vec2::ZERO };
        let (column, row) = lattice.column_row(i);
        let concentration = if has_tracers { water.rows.concentration(0, row)[column] } else { 0.0 };
        let (place, volume, bed) = (lattice.centre(i), depth * area, bed.elevation[i]);
        Sample { place, depth, velocity, volume, bed, concentration }
    };
    (0..lattice.len()).filter(|&i| bed.has_terrain(i)).map(sample).collect()
}

/// Runs a setup to its end; a run that breaks says why.
pub fn run(setup: &Setup, choice: &Choice) -> (Cost, Result<Outcome, Broken>) {
    in_pool(|| run_on_threads(setup, choice))
}

fn run_on_threads(setup: &Setup, choice: &Choice) -> (Cost, Result<Outcome, Broken>) {
    let mut problem = setup.problem.clone();
    problem.courant = setup.courant.unwrap_or(choice.numerics.cfl);
    problem.dry_depth = choice.dry_depth().unwrap_or(problem.dry_depth);
    let steps_allowed = steps_foreseen(setup, choice) * STEPS_IN_RESERVE + FEWEST_STEPS;
    let before = processor_seconds();
    let mut core = Core::new(&choice.numerics, problem, || setup.seeds.clone(), setup.dimension);
    if let Some(velocity) = &setup.velocity {
        core.set_velocity(velocity);
    }
    let start = snapshot(&mut core, setup);
    let mut cost = Cost { particles: core.flow().particles(), ..Cost::default() };
    let mut found_errors = Vec::new();
    let mut score = |snapshot: &Snapshot, exact: &Exact| {
        found_errors.push(errors(snapshot, setup, exact));
    };
    let mut broken = None;
    for (time, exact) in &setup.earlier {
        broken = broken.or_else(|| advance(&mut core, setup, Until::Time(*time), steps_allowed, &mut cost));
        score(&snapshot(&mut core, setup), exact);
    }
    let broken = broken.or_else(|| advance(&mut core, setup, setup.until, steps_allowed, &mut cost));
    cost.cpu_s = processor_seconds() - before;
    let solver = core.flow();
    cost.particles = cost.particles.max(solver.particles());
    cost.evaluations = solver.particle_evaluations();
    if let Some(broken) = broken {
        return (cost, Err(broken));
    }
    let volume_error = solver.ledger().relative_error();
    let end = snapshot(&mut core, setup);
    let found = setup.checks.as_ref().map_or_else(Vec::new, |checks| checks(&start, &end));
    score(&end, &setup.exact);
    let errors = Errors::mean(&found_errors);
    (cost, Ok(Outcome { errors, start, end, checks: found, volume_error }))
}

/// Steps of the Courant number over the spacing, at the greatest signal speed of the answer.
fn steps_foreseen(setup: &Setup, choice: &Choice) -> f64 {
    match setup.until {
        Until::Steps(steps) => steps as f64,
        Until::Time(end) => {
            let signal = setup.scale_speed + (setup.problem.gravity * setup.scale_depth).sqrt();
            end * signal / (setup.courant.unwrap_or(choice.numerics.cfl) * setup.problem.bed.lattice.spacing)
        }
    }
}

/// Steps to a moment; the reason where it is not reached.
fn advance(core: &mut Core, setup: &Setup, until: Until, steps_allowed: f64, cost: &mut Cost) -> Option<Broken> {
    let speed_limit = setup.limits.as_ref().map_or(f64::INFINITY, Limits::allowed_speed);
    loop {
        let choice = core.flow().choose_step();
        cost.max_speed = cost.max_speed.max(choice.max_speed);
        if cost.excess.is_none() && choice.max_speed > speed_limit {
            cost.excess = Some(excess(core, setup, &choice));
        }
        let solver = core.flow();
        let (is_over, step) = match until {
            Until::Time(end) => (solver.time() >= end - END_TOLERANCE, choice.time_step.min(end - solver.time())),
            Until::Steps(steps) => (cost.steps >= steps, choice.time_step),
        };
        if is_over {
            return None;
        }
        if cost.steps as f64 > steps_allowed {
            let (steps, time, limiter) = (cost.steps, solver.time(), choice.limit.name());
            return Some(Broken::TooManySteps { steps, time, limiter, place: choice.position });
        }
        if let Err(failure) = solver.advance(step) {
            return Some(Broken::Failure(failure));
        }
        cost.steps += 1;
    }
}

/// The fastest water now.
fn excess(core: &mut Core, setup: &Setup, choice: &StepChoice) -> Excess {
    let now = snapshot(core, setup);
    let fastest = now.samples.iter().max_by(|a, b| a.velocity.norm().total_cmp(&b.velocity.norm()));
    Excess {
        time: core.flow().time(),
        place: fastest.map_or(choice.position, |sample| sample.place),
        speed: choice.max_speed,
        limiter: choice.limit.name(),
    }
}
