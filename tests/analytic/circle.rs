//! Circular dam break in a quadrant whose two walls are the planes of symmetry.

use floodsim::scenario::methods::{Integrator, Motion};
use floodsim::solver::FlowSolver;
use floodsim::solver::lagrangian::LagrangianSolver;
use floodsim::validation::cases::circles::{circular, spreading};
use floodsim::validation::exact::Accuracy;

use crate::support::{assert_below, moving, outcome, run_steps};

/// Mean errors of depth (m) and velocity (m/s), and how far the total momentum is off the diagonal, relatively.
fn errors(spacing: f64, integrator: &str) -> ((f64, f64), f64) {
    let outcome = outcome(&circular(spacing, Motion::Lagrangian, Accuracy::First), &moving(integrator));
    let momentum = outcome.end.momentum();
    ((outcome.errors.depth, outcome.errors.velocity), ((momentum.x - momentum.y) / momentum.x).abs())
}

#[test]
fn circular_dam_break_converges_and_keeps_its_symmetry() {
    let (coarse, _) = errors(0.4, "leapfrog");
    let (fine, asymmetry) = errors(0.2, "leapfrog");
    assert_below(fine, (0.0118, 0.0462));
    assert!(coarse.0 > 1.9 * fine.0 && coarse.1 > 1.9 * fine.1, "{coarse:?} to {fine:?}");
    // Rounding of sums over 3600 particles.
    assert!(asymmetry < 1e-12, "{asymmetry:e}");
    assert_below(errors(0.2, "heun").0, (0.0121, 0.0482));
}

/// The spreading cylinder: error of depth (m) by particles, of velocity (m/s) by volume.
fn spreading_errors(spacing: f64) -> (f64, f64) {
    let setup = spreading(spacing, Motion::Lagrangian);
    let outcome = outcome(&setup, &moving("leapfrog"));
    (outcome.errors.depth, outcome.end.velocity_error_by_volume(|place| (setup.exact)(place).1))
}

#[test]
fn spreading_cylinder_converges() {
    let (coarse, fine) = (spreading_errors(0.05), spreading_errors(0.025));
    assert_below(coarse, (5.1e-3, 0.049));
    assert_below(fine, (2.7e-3, 0.020));
    assert!(coarse.0 > 1.7 * fine.0 && coarse.1 > 1.7 * fine.1, "{coarse:?} to {fine:?}");
}

/// Not a check of accuracy: a run whose CPU time shows the cost of an evaluation.
#[test]
fn evaluations_are_counted() {
    let setup = circular(0.1, Motion::Lagrangian, Accuracy::First);
    let mut solver = LagrangianSolver::new(setup.problem, setup.seeds, Integrator::Leapfrog);
    // Once before the first step, then once a step for the particles that take it.
    let mut expected = solver.particles() as u64;
    for _ in 0..60 {
        expected += solver.particles() as u64;
        run_steps(&mut solver, 1);
    }
    assert_eq!(solver.particle_evaluations(), expected);
}
