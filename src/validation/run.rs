//! One run of a setup with chosen methods: from the start to the end, or to the step at which it breaks.

use std::fmt;

use super::case::{Check, Exact, Setup, Until};
use super::choice::Choice;
use super::error::{Errors, errors, errors_on_map};
use super::judge::Limits;
use crate::error::NumericalFailure;
use crate::lattice::WaterInCell;
use crate::math::Vec2;
use crate::physics::dimension::Dimension;
use crate::pipeline::clock::processor_seconds;
use crate::pipeline::cores::Core;
use crate::solver::threads::in_pool;
use crate::solver::{Ledger, StepChoice};

/// A run may take so many times the steps foreseen, and a few more; beyond that its step has collapsed.
const STEPS_IN_RESERVE: f64 = 20.0;
const FEWEST_STEPS: f64 = 1000.0;
/// A run whose end is this near (s) is over.
const END_TOLERANCE: f64 = 1e-9;
/// The share of the scale of the depth below which the velocity of an Eulerian particle's film is not looked at.
const FILM_SHARE: f64 = 1e-4;

/// One particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Local coordinates (m).
    pub place: Vec2,
    /// Depth (m).
    pub depth: f64,
    /// Velocity (m/s).
    pub velocity: Vec2,
    /// Volume (m³; in a channel m²).
    pub volume: f64,
    /// Bed elevation (m).
    pub bed: f64,
}

/// All particles at one moment: moving ones, or the riverbed's with those that are dry.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Whether the particles move.
    pub is_moving: bool,
    /// The particles.
    pub samples: Vec<Sample>,
    /// The cells of the lattice, onto which Lagrangian particles are gridded as for the maps; empty where the setup asks for no score on the
    /// map, and where particles rest, whose samples are the cells.
    pub on_map: Vec<Sample>,
    /// Depth (m) on the lattice, where Lagrangian particles are gridded as for the maps.
    pub depth_on_lattice: Vec<f64>,
    /// Gravity (m/s²).
    pub gravity: f64,
    /// Simulated time (s).
    pub time: f64,
    /// The volume balance of the core; in a channel those of a strip as wide as a cell.
    pub ledger: Ledger,
}

impl Snapshot {
    fn take(core: &mut Core, setup: &Setup) -> Snapshot {
        let gravity = setup.problem.gravity;
        let samples = match core {
            Core::Moving(solver) => {
                let state = solver.state();
                let particles = &state.particles;
                let sample = |i: usize| Sample {
                    place: particles.position[i],
                    depth: particles.depth[i],
                    velocity: particles.velocity[i],
                    volume: particles.volume[i],
                    bed: state.bed_at(particles.position[i]).elevation,
                };
                (0..particles.len()).map(sample).collect()
            }
            Core::Resting(_) => samples_on_lattice(core, setup),
        };
        let is_moving = matches!(core, Core::Moving(_));
        let on_map = if is_moving && setup.is_scored_on_map { samples_on_lattice(core, setup) } else { Vec::new() };
        let depth_on_lattice = core.flow().water().depths();
        let (time, ledger) = (core.flow().time(), core.flow().ledger());
        Snapshot { is_moving, samples, on_map, depth_on_lattice, gravity, time, ledger }
    }

    /// Volume of all water (m³).
    pub fn volume(&self) -> f64 {
        self.samples.iter().map(|sample| sample.volume).sum()
    }

    /// Momentum over the water's density (m⁴/s).
    pub fn momentum(&self) -> Vec2 {
        self.samples.iter().fold(Vec2::ZERO, |sum, sample| sum + sample.velocity * sample.volume)
    }

    /// Kinetic and potential energy over the water's density (m⁵/s²), the latter above `datum` (m).
    pub fn energy(&self, datum: f64) -> f64 {
        let of =
            |s: &Sample| s.volume * (0.5 * s.velocity.norm_squared() + self.gravity * (s.bed + 0.5 * s.depth - datum));
        self.samples.iter().map(of).sum()
    }

    /// Mean speed by volume (m/s) of the difference to a velocity at each place.
    pub fn velocity_error_by_volume(&self, exact: impl Fn(Vec2) -> Vec2) -> f64 {
        let error = |s: &Sample| s.volume * (s.velocity - exact(s.place)).norm();
        self.samples.iter().map(error).sum::<f64>() / self.volume()
    }
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
    let water = core.flow().water();
    let sample = |i: usize| {
        let WaterInCell { depth, discharge_x, discharge_y } = water.at(i);
        let velocity = if depth > film { Vec2::new(discharge_x, discharge_y) / depth } else { Vec2::ZERO };
        Sample { place: lattice.centre(i), depth, velocity, volume: depth * area, bed: bed.elevation[i] }
    };
    (0..lattice.len()).filter(|&i| bed.has_terrain(i)).map(sample).collect()
}

/// Why a run ended before its time.
#[derive(Clone, Debug, PartialEq)]
pub enum Broken {
    /// The numerics broke down.
    Failure(NumericalFailure),
    /// Far more steps than foreseen.
    TooManySteps {
        /// Steps taken.
        steps: usize,
        /// Time reached (s).
        time: f64,
        /// What limited the steps.
        limiter: &'static str,
        /// Where (local coordinates, m).
        place: Vec2,
    },
}

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Broken::Failure(failure) => write!(f, "{failure}"),
            Broken::TooManySteps { steps, time, limiter, place } => write!(
                f,
                "given up at t = {time:.3} s after {steps} steps: the time step collapsed (limited by {limiter} at {:.1}, {:.1})",
                place.x, place.y
            ),
        }
    }
}

/// What came out of a run that reached its end.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The water at the start.
    pub start: Snapshot,
    /// The water at the end.
    pub end: Snapshot,
    /// Mean errors; without a meaning where there is no answer to compare with.
    pub errors: Errors,
    /// The same on the map, where particles move and the setup asks for it.
    pub errors_on_map: Option<Errors>,
    /// What else was looked at.
    pub checks: Vec<Check>,
    /// Volume ledger: relative error.
    pub volume_error: f64,
}

/// What a run cost, whether it reached its end or not.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Most particles that carried water, of the start and the end.
    pub particles: usize,
    /// Evaluations of the rates of one particle.
    pub evaluations: u64,
    /// Steps.
    pub steps: usize,
    /// Processor time (s) of the steps, all threads together.
    pub cpu_s: f64,
    /// Greatest speed (m/s) at any step.
    pub max_speed: f64,
    /// Where the water was first faster than it may be.
    pub excess: Option<Excess>,
}

/// The first step at which the water was faster than its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excess {
    /// Simulated time (s).
    pub time: f64,
    /// The fastest particle's place (local coordinates, m).
    pub place: Vec2,
    /// The greatest speed (m/s).
    pub speed: f64,
    /// What limited the time step.
    pub limiter: &'static str,
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
        match &mut core {
            Core::Resting(solver) => solver.set_velocity(velocity),
            Core::Moving(solver) => solver.set_velocity(velocity),
        }
    }
    let start = Snapshot::take(&mut core, setup);
    let mut cost = Cost { particles: core.flow().particles(), ..Cost::default() };
    let (mut found_of_particles, mut found_on_map) = (Vec::new(), Vec::new());
    let mut score = |snapshot: &Snapshot, exact: &Exact| {
        found_of_particles.push(errors(snapshot, setup, exact));
        found_on_map.extend((!snapshot.on_map.is_empty()).then(|| errors_on_map(snapshot, setup, exact)));
    };
    let mut broken = None;
    for (time, exact) in &setup.earlier {
        broken = broken.or_else(|| advance(&mut core, setup, Until::Time(*time), steps_allowed, &mut cost));
        score(&Snapshot::take(&mut core, setup), exact);
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
    let end = Snapshot::take(&mut core, setup);
    let found = setup.checks.as_ref().map_or_else(Vec::new, |checks| checks(&start, &end));
    score(&end, &setup.exact);
    let errors = Errors::mean(&found_of_particles);
    let errors_on_map = (!found_on_map.is_empty()).then(|| Errors::mean(&found_on_map));
    (cost, Ok(Outcome { errors, errors_on_map, start, end, checks: found, volume_error }))
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
    let now = Snapshot::take(core, setup);
    let fastest = now.samples.iter().max_by(|a, b| a.velocity.norm().total_cmp(&b.velocity.norm()));
    Excess {
        time: core.flow().time(),
        place: fastest.map_or(choice.position, |sample| sample.place),
        speed: choice.max_speed,
        limiter: choice.limit.name(),
    }
}
