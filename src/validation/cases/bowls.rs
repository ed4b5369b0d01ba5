//! Oscillations in a paraboloid: water that comes back to where it was.

use crate::math::Vec2;
use crate::physics::dimension::Dimension;
use crate::scenario::methods::{Core, Motion};
use crate::solver::{FlowProblem, Tracer};
use crate::validation::case::{AcceptanceLimit, Case, Scope, Setup, Suite, Until};
use crate::validation::exact::Bowl;
use crate::validation::outcome::{Check, Sample, Snapshot};
use crate::validation::scene::{jittered_lattice, problem, seeds_at};

/// Half of the edge of the square (m).
const HALF: f64 = 1.6;
/// The bowl of `Thacker1981` in the size that everybody takes.
pub const BOWL: Bowl = Bowl { radius: 1.0, depth: 0.1, centre: Vec2::new(HALF, HALF) };
/// Radius (m) of the water at the start of the axisymmetric oscillation.
const START_RADIUS: f64 = 0.8;
/// Offset (m) of the planar oscillation.
const OFFSET: f64 = 0.5;
/// How far the energy may be off, relatively.
const ENERGY: f64 = 1e-3;
/// The riverbed of particles of the variational formulation is so many times as fine as they are.
const BED_CELLS: f64 = 4.0;

const SPACINGS: &[f64] = &[0.1, 0.05, 0.025];

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "thacker_planar",
        suite: Suite::Analytic,
        about: "Thacker's planar oscillation (a = 1 m, h0 = 0.1 m, B = 0.5 m) after three periods, at a/10 to a/40; at a/40 2e-4 of h0.",
        is_tuned: true,
        spacings: SPACINGS,
        tested: 2,
        acceptance_limits: &[
            AcceptanceLimit { scope: Scope::Better, spacing: Some(0.025), depth: Some(2e-5), ..AcceptanceLimit::NONE },
            AcceptanceLimit {
                scope: Scope::Of(Motion::Eulerian),
                spacing: Some(0.025),
                depth: Some(1e-3),
                ..AcceptanceLimit::NONE
            },
            AcceptanceLimit { scope: Scope::Better, spacing: Some(0.025), checks: true, ..AcceptanceLimit::NONE },
        ],
        setup: |spacing, core| Ok(planar(spacing, core, 3.0)),
    },
    Case {
        name: "thacker_axisymmetric",
        suite: Suite::Analytic,
        about: "Thacker's axisymmetric oscillation (r0 = 0.8 m) after one period, at a/10 to a/40; at a/40 3e-4 of h0.",
        is_tuned: true,
        spacings: SPACINGS,
        tested: 2,
        acceptance_limits: &[
            AcceptanceLimit { scope: Scope::Better, spacing: Some(0.025), depth: Some(3e-5), ..AcceptanceLimit::NONE },
            AcceptanceLimit { scope: Scope::Better, spacing: Some(0.025), checks: true, ..AcceptanceLimit::NONE },
        ],
        setup: |spacing, core| Ok(axisymmetric(spacing, core, 1.0)),
    },
    Case {
        name: "tracer_bowl",
        suite: Suite::Analytic,
        about: "A bell of marked water (0.4 m) in Thacker's planar oscillation, after three periods back where it was, at a/10 to a/40.",
        is_tuned: false,
        spacings: SPACINGS,
        tested: 2,
        acceptance_limits: &[AcceptanceLimit { checks: true, ..AcceptanceLimit::NONE }],
        setup: |spacing, core| match core {
            Core::Variational => Err("its particles carry no tracers".to_owned()),
            Core::Eulerian | Core::Lagrangian => Ok(marked(spacing, core, 3.0)),
        },
    },
];

/// Radius (m) of the marked water.
const BELL: f64 = 0.4;
/// How far the amount may be off, relatively: rounding of some thousand steps.
const AMOUNT: f64 = 1e-12;

/// The concentration at the start: 1 in the middle of the water, 0 from [`BELL`] on.
fn bell(place: Vec2) -> f64 {
    let distance = (place - BOWL.centre - Vec2::new(OFFSET, 0.0)).norm() / BELL;
    if distance < 1.0 { 0.5 * (1.0 + (std::f64::consts::PI * distance).cos()) } else { 0.0 }
}

/// The planar oscillation with marked water in its middle: the water moves as a whole, so that the mark goes with it and comes back.
fn marked(spacing: f64, core: Core, periods: f64) -> Setup {
    let mut setup = planar(spacing, core, periods);
    let lattice = &setup.problem.bed.lattice;
    let initial = (0..lattice.len()).map(|cell| bell(lattice.centre(cell))).collect();
    setup.problem.forcing.tracers = vec![Tracer { initial, ..Tracer::default() }];
    setup.checks = Some(Box::new(|start, end| vec![mixing(start, end), amount(end)]));
    setup
}

/// What is left of the peak and of the variance, and the mean error by volume: what was mixed on the way.
fn mixing(start: &Snapshot, end: &Snapshot) -> Check {
    let peak =
        |of: &Snapshot| of.samples.iter().filter(|s| s.volume > 0.0).map(|s| s.concentration).fold(0.0, f64::max);
    let variance = |of: &Snapshot| {
        let mean = of.samples.iter().map(|s| s.volume * s.concentration).sum::<f64>() / of.volume();
        of.samples.iter().map(|s| s.volume * (s.concentration - mean).powi(2)).sum::<f64>()
    };
    let error = |s: &Sample| s.volume * (s.concentration - bell(s.place)).abs();
    let least = end.samples.iter().filter(|s| s.volume > 0.0).map(|s| s.concentration).fold(0.0, f64::min);
    Check {
        found: format!(
            "of the mark {:.3} of the peak and {:.3} of the variance left, mean error {:.2e}",
            peak(end) / peak(start),
            variance(end) / variance(start),
            end.samples.iter().map(error).sum::<f64>() / end.volume()
        ),
        // No concentration leaves the bounds of its sources.
        is_met: peak(end) <= peak(start) && least >= 0.0,
    }
}

/// Whether the amount of the mark is kept.
fn amount(end: &Snapshot) -> Check {
    let error = end.tracers.iter().map(|tracer| tracer.relative_error().abs()).fold(0.0, f64::max);
    Check { found: format!("amount off by {error:.1e}"), is_met: error <= AMOUNT }
}

/// The planar oscillation after so many periods.
pub fn planar(spacing: f64, core: Core, periods: f64) -> Setup {
    let end = periods * BOWL.planar_period();
    let mut setup = oscillation(spacing, core, end, |place, t| BOWL.planar(OFFSET, place, t));
    setup.velocity = Some(Box::new(|place| BOWL.planar(OFFSET, place, 0.0).1));
    setup
}

/// The axisymmetric oscillation after so many periods.
pub fn axisymmetric(spacing: f64, core: Core, periods: f64) -> Setup {
    let end = periods * BOWL.axisymmetric_period();
    oscillation(spacing, core, end, |place, t| BOWL.axisymmetric(START_RADIUS, place, t))
}

fn oscillation(spacing: f64, core: Core, end: f64, solution: fn(Vec2, f64) -> (f64, Vec2)) -> Setup {
    let cell = match core {
        Core::Eulerian | Core::Lagrangian => spacing,
        Core::Variational => spacing / BED_CELLS,
    };
    let cells = (2.0 * HALF / cell).round() as usize;
    let mut problem: FlowProblem = problem(cells, cells, cell, |place| BOWL.bed(place));
    let level = |place: Vec2| solution(place, 0.0).0;
    let places = jittered_lattice(2.0 * HALF, 2.0 * HALF, spacing, 0.0);
    let seeds = seeds_at(&problem, &places, spacing * spacing, level);
    let lattice = &problem.bed.lattice;
    let depth = |cell: usize| (level(lattice.centre(cell)) - problem.bed.elevation[cell]).max(0.0);
    problem.initial_depth = (0..lattice.len()).map(depth).collect();
    let exact = move |place: Vec2| {
        let (level, velocity) = solution(place, end);
        let depth = level - BOWL.bed(place);
        if depth > 0.0 { (depth, velocity) } else { (0.0, Vec2::ZERO) }
    };
    let mut setup = Setup::new(problem, seeds, Dimension::Two, Until::Time(end), Box::new(exact));
    setup.checks = Some(Box::new(|start, end| vec![energy(start, end)]));
    setup
}

/// Energy at the end over that at the start: above the deepest point, and of what can move (above the water at rest).
fn energy(start: &Snapshot, end: &Snapshot) -> Check {
    let datum = -BOWL.depth;
    let (first, last) = (start.energy(datum), end.energy(datum));
    let at_rest = start.gravity * BOWL.potential_at_rest(start.volume());
    let ratio = last / first;
    Check {
        found: format!(
            "energy {ratio:.5} of that at the start; of what can move {:.4}",
            (last - at_rest) / (first - at_rest)
        ),
        is_met: (ratio - 1.0).abs() <= ENERGY,
    }
}
