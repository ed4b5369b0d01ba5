//! Circular dam break in a quadrant whose two walls are the planes of symmetry, with cells that move.

use floodsim::scenario::methods::{Core, Integrator, Stabilisation};
use floodsim::solver::FlowSolver;
use floodsim::solver::variational::VariationalSolver;
use floodsim::validation::cases::circles::{circular, spreading};
use floodsim::validation::exact::Accuracy;

use crate::support::{assert_below, errors, moving, run_steps};

#[test]
fn circular_dam_break_converges() {
    let run = |spacing| errors(&circular(spacing, Core::Lagrangian, Accuracy::First), &moving());
    let (coarse, fine) = (run(0.4), run(0.2));
    assert_below(fine, (0.0117, 0.066));
    assert!(coarse.0 > 1.9 * fine.0 && coarse.1 > 1.8 * fine.1, "{coarse:?} to {fine:?}");
}

#[test]
fn spreading_cylinder_converges() {
    let run = |spacing| errors(&spreading(spacing, Core::Lagrangian), &moving());
    let (coarse, fine) = (run(0.05), run(0.025));
    assert_below(coarse, (5.7e-4, 0.0134));
    assert_below(fine, (3.0e-4, 0.0069));
    assert!(coarse.0 > 1.7 * fine.0 && coarse.1 > 1.7 * fine.1, "{coarse:?} to {fine:?}");
}

/// Not a check of accuracy: a run whose CPU time shows the cost of an evaluation.
#[test]
fn evaluations_are_counted() {
    let setup = circular(0.1, Core::Variational, Accuracy::First);
    let mut solver = VariationalSolver::new(setup.problem, setup.seeds, Integrator::Leapfrog, Stabilisation::TwoShocks);
    // Once before the first step, then once a step for the particles that take it.
    let mut expected = solver.particles() as u64;
    for _ in 0..60 {
        expected += solver.particles() as u64;
        run_steps(&mut solver, 1);
    }
    assert_eq!(solver.particle_evaluations(), expected);
}
