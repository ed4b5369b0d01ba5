//! The variational form in the plane: a circular dam break between two walls of symmetry, and a closed box.

use floodsim::scenario::methods::{Integrator, Motion, Stabilisation};
use floodsim::solver::variational::VariationalSolver;
use floodsim::validation::cases::circles::circular;
use floodsim::validation::exact::Accuracy;
use floodsim::validation::{jittered_lattice, problem, seeds_at};

use crate::support::{assert_below, max_speed, methods, outcome, run_steps};

const SIZE: f64 = 12.0;
const SPACING: f64 = 0.4;

/// A closed box with a metre of level water.
fn box_of_water(stabilisation: Stabilisation) -> VariationalSolver {
    let cells = (SIZE / SPACING).round() as usize;
    let mut problem = problem(cells, cells, SPACING, |_| 0.0);
    problem.courant = VariationalSolver::default_courant(Integrator::Leapfrog);
    let places = jittered_lattice(SIZE, SIZE, SPACING, 0.0);
    let seeds = seeds_at(&problem, &places, SPACING * SPACING, |_| 1.0);
    VariationalSolver::new(problem, seeds, Integrator::Leapfrog, stabilisation)
}

/// Mean errors of depth (m) and velocity (m/s) of the dam break 2.5 m to 0.5 m, and how far the momentum is off the diagonal.
fn errors(spacing: f64, stabilisation: Stabilisation) -> ((f64, f64), f64) {
    let methods = methods(&[("formulation", "variational"), ("stabilisation", stabilisation.name())]);
    let outcome = outcome(&circular(spacing, Motion::Lagrangian, Accuracy::First), &methods);
    let momentum = outcome.end.momentum();
    ((outcome.errors.depth, outcome.errors.velocity), ((momentum.x - momentum.y) / momentum.x).abs())
}

#[test]
fn circular_dam_break_converges_and_keeps_its_symmetry() {
    for stabilisation in [Stabilisation::Riemann, Stabilisation::ArtificialViscosity] {
        let (coarse, _) = errors(0.4, stabilisation);
        let (fine, asymmetry) = errors(0.2, stabilisation);
        let bounds = match stabilisation {
            Stabilisation::Riemann => (0.0164, 0.0526),
            Stabilisation::ArtificialViscosity => (0.0197, 0.0663),
        };
        assert_below(fine, bounds);
        assert!(coarse.0 > 1.3 * fine.0 && coarse.1 > 1.3 * fine.1, "{coarse:?} to {fine:?}");
        assert!(asymmetry < 1e-12, "{asymmetry:e}");
    }
}

#[test]
fn box_of_level_water_stays_at_rest_between_its_walls() {
    // Mirror images complete every kernel: a lattice of particles on a level bed has no force, corners included.
    for stabilisation in [Stabilisation::Riemann, Stabilisation::ArtificialViscosity] {
        let mut solver = box_of_water(stabilisation);
        run_steps(&mut solver, 200);
        // Summed depths of about 1 m are iterated to 1e-10 m, which drives some 1e-9 m/s² at random, 200 steps long.
        assert!(max_speed(&solver) < 1e-6, "{stabilisation:?}: {:e} m/s", max_speed(&solver));
        let particles = &solver.state().particles;
        let worst = particles.depth.iter().map(|d| (d - 1.0).abs()).fold(0.0, f64::max);
        // The summed depth of a lattice is the integral of a kernel by a lattice rule.
        assert!(worst < 5e-3, "{worst}");
    }
}
