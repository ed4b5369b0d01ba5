//! Moving water as it is gridded: depths of cells against means of exact solutions, so that fronts get no holes and no bumps.

#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use floodsim::math::Vec2;
use floodsim::particles::FluidSeed;
use floodsim::scenario::methods::{Integrator, Motion};
use floodsim::solver::lagrangian::LagrangianSolver;
use floodsim::solver::{FlowProblem, FlowSolver};
use floodsim::validation::cases::circles::{circular, spreading};
use floodsim::validation::exact::{Accuracy, ritter};
use floodsim::validation::{jittered_lattice, problem};

use crate::support::assert_below;

/// Samples of the exact depth along each edge of a cell.
const SAMPLES: usize = 8;

/// Mean and greatest error (m) of the depths of all cells at time `end` (s).
fn errors(problem: FlowProblem, seeds: Vec<FluidSeed>, end: f64, exact: impl Fn(Vec2) -> f64) -> (f64, f64) {
    let mut solver = LagrangianSolver::new(problem, seeds, Integrator::Leapfrog);
    while solver.time() < end {
        let step = solver.choose_step().time_step.min(end - solver.time());
        solver.advance(step).unwrap();
    }
    let grid = solver.water();
    let (mut sum, mut most) = (0.0, 0.0_f64);
    for (index, depth) in grid.depths().into_iter().enumerate() {
        let offset = |k: usize| ((k as f64 + 0.5) / SAMPLES as f64 - 0.5) * grid.lattice.spacing;
        let centre = grid.lattice.centre(index);
        let places = (0..SAMPLES * SAMPLES).map(|k| centre + Vec2::new(offset(k % SAMPLES), offset(k / SAMPLES)));
        let mean = places.map(&exact).sum::<f64>() / (SAMPLES * SAMPLES) as f64;
        sum += (depth - mean).abs();
        most = most.max((depth - mean).abs());
    }
    (sum / grid.lattice.len() as f64, most)
}

/// Ritter's dam break along a strip, with particles up to `jitter` spacings off their lattice.
fn ritter_errors(jitter: f64) -> (f64, f64) {
    const END: f64 = 5.0;
    let (spacing, dam, width) = (0.5, 40.0, 8.0);
    let problem = problem(200, 16, spacing, |_| 0.0);
    let places = jittered_lattice(dam, width, spacing, jitter);
    let seed = |position| FluidSeed { position, volume: spacing * spacing, depth: 1.0 };
    errors(problem, places.into_iter().map(seed).collect(), END, |place| ritter(1.0, place.x - dam, END).0)
}

// Bounds: errors that were found, and 3 % more. The greatest ones are those of the particles at the front and at the bore.

#[test]
fn dam_break_on_dry_ground() {
    assert_below(ritter_errors(0.0), (0.0112, 0.2005));
    assert_below(ritter_errors(0.2), (0.0052, 0.0970));
}

#[test]
fn circular_dam_break() {
    let setup = circular(0.1, Motion::Lagrangian, Accuracy::Second);
    assert_below(errors(setup.problem, setup.seeds, 1.4, |place| (setup.exact)(place).0), (0.00605, 0.1869));
    let setup = spreading(0.05, Motion::Lagrangian);
    assert_below(errors(setup.problem, setup.seeds, 1.0, |place| (setup.exact)(place).0), (6.3e-4, 0.0107));
}
