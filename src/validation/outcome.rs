//! What comes out of a run: the water at its start and end, its errors, what it cost, why it broke.

use std::fmt;

use crate::error::NumericalFailure;
use crate::math::Vec2;
use crate::solver::{Ledger, TracerLedger};

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
    /// Concentration of the first tracer of the problem; 0 where it has none.
    pub concentration: f64,
}

/// All water at one moment: particles of the variational formulation, or the cells of the lattice with those that are dry.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Whether they are particles.
    pub is_of_particles: bool,
    /// The particles, or the cells.
    pub samples: Vec<Sample>,
    /// Depth (m) on the lattice, onto which particles are gridded as for the maps; the mean of its rows for a channel in the plane.
    pub depth_on_lattice: Vec<f64>,
    /// Gravity (m/s²).
    pub gravity: f64,
    /// Simulated time (s).
    pub time: f64,
    /// The volume balance of the core; in a channel those of a strip as wide as a cell.
    pub ledger: Ledger,
    /// The balance of each tracer.
    pub tracers: Vec<TracerLedger>,
}

impl Snapshot {
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

/// Something that was found beside the errors.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// What was found, with its number.
    pub found: String,
    /// Whether it is as it must be.
    pub is_met: bool,
}

/// Mean absolute errors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Of the depth (m).
    pub depth: f64,
    /// Of the velocity (m/s).
    pub velocity: f64,
}

impl Errors {
    /// The mean of several; not a number where there are none.
    pub fn mean(all: &[Errors]) -> Errors {
        let mean = |of: fn(&Errors) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
        Errors { depth: mean(|errors| errors.depth), velocity: mean(|errors| errors.velocity) }
    }
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
