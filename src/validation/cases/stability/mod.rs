//! Where methods fail: harsh problems, each run held to what physics allows (see `validation::judge` for the criteria of all).
//!
//! No inflow feeds them: flows that need one start from their exact state in a channel so long that nothing from
//! its closed ends comes into the window before the end.

mod beds;
mod fronts;
mod jumps;
mod long_runs;
mod walls;

use crate::math::Vec2;
use crate::scenario::GRAVITY;
use crate::solver::FlowProblem;
use crate::validation::case::Case;
use crate::validation::judge::{ENERGY, Measure, Share};
use crate::validation::outcome::Outcome;
use crate::validation::scene::problem;

/// The cases, one list per file.
pub const FAMILIES: &[&[Case]] = &[fronts::CASES, jumps::CASES, beds::CASES, walls::CASES, long_runs::CASES];

/// Rows of a channel over an uneven bed: one row alone has no bed beside it.
const ROWS: usize = 4;
/// Mean error of a depth as a share of the greatest depth.
const DEPTH: Share = Share { holds: 0.01, fails: 0.05 };
/// Relative error of a place, of a velocity that must be kept, of a volume.
const PLACE: Share = Share { holds: 0.05, fails: 0.2 };
const KEPT: Share = Share { holds: 0.05, fails: 0.5 };

/// Depth (m) behind a standing jump before which the water is `shallow` (m): d₂ = d₁ (√(1 + 8 Fr²) − 1)/2 (Belanger's equation, in
/// `Chow1959`).
fn behind_jump(shallow: f64, froude: f64) -> f64 {
    0.5 * shallow * ((1.0 + 8.0 * froude * froude).sqrt() - 1.0)
}

/// Greatest speed (m/s) of water `depth` (m) deep that falls by `drop` (m): 2 √(g depth) + √(2 g drop).
fn fastest(depth: f64, drop: f64) -> f64 {
    2.0 * (GRAVITY * depth).sqrt() + (2.0 * GRAVITY * drop).sqrt()
}

/// A channel along x in two dimensions, `length` (m) long, with walls on both sides.
fn strip(length: f64, spacing: f64, bed: impl Fn(Vec2) -> f64) -> FlowProblem {
    problem((length / spacing).round() as usize, ROWS, spacing, bed)
}

/// Fills the lattice with water of a depth (m) that follows a function of the place.
fn fill(problem: &mut FlowProblem, depth: impl Fn(Vec2) -> f64) {
    let lattice = &problem.bed.lattice;
    problem.initial_depth = (0..lattice.len()).map(|cell| depth(lattice.centre(cell))).collect();
}

/// One particle on each wet cell of a problem in two dimensions.
fn cell_seeds(problem: &FlowProblem) -> Vec<crate::particles::FluidSeed> {
    let lattice = &problem.bed.lattice;
    let wet = (0..lattice.len()).filter(|&cell| problem.initial_depth[cell] > 0.0);
    wet.map(|cell| {
        let depth = problem.initial_depth[cell];
        crate::particles::FluidSeed { position: lattice.centre(cell), volume: depth * lattice.cell_area(), depth }
    })
    .collect()
}

/// Mean error of the depth as a share of the greatest depth (m).
fn depth_error(outcome: &Outcome, deepest: f64) -> Measure {
    Measure::new("mean depth error over the depth", outcome.errors.depth / deepest, "", DEPTH)
}

/// What a flow without friction or outflow gained in energy above a datum (m), which must not be anything.
fn energy_gain(outcome: &Outcome, datum: f64) -> Measure {
    let (start, end) = (outcome.start.energy(datum), outcome.end.energy(datum));
    Measure::new("energy gained over that at the start", end / start - 1.0, "", ENERGY)
}

/// The easternmost place (m) on a lattice of one row, between two cells, where the depth (m) falls below a value.
fn front(outcome: &Outcome, depth: f64, spacing: f64) -> f64 {
    let depths = &outcome.end.depth_on_lattice;
    let Some(last) = depths.iter().rposition(|d| *d >= depth) else { return 0.0 };
    let next = depths.get(last + 1).copied().unwrap_or(0.0);
    let share = (depths[last] - depth) / (depths[last] - next).max(f64::MIN_POSITIVE);
    (last as f64 + 0.5 + share.clamp(0.0, 1.0)) * spacing
}
