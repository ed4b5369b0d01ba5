//! The variational form in the plane: a circular dam break between two walls of symmetry, and a closed box.

use floodsim::math::{Sym2, Vec2};
use floodsim::particles::FluidSeed;
use floodsim::physics::dimension::Dimension;
use floodsim::scenario::GRAVITY;
use floodsim::scenario::methods::{BedSlope, Core, Integrator, Stabilisation};
use floodsim::solver::FlowSolver;
use floodsim::solver::variational::{MovingMethods, VariationalSolver};
use floodsim::validation::cases::circles::circular;
use floodsim::validation::exact::Accuracy;
use floodsim::validation::{flat_strip, jittered_lattice, line_seeds, problem, seeds_at};

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
    let outcome = outcome(&circular(spacing, Core::Variational, Accuracy::First), &methods);
    let momentum = outcome.end.momentum();
    ((outcome.errors.depth, outcome.errors.velocity), ((momentum.x - momentum.y) / momentum.x).abs())
}

#[test]
fn circular_dam_break_converges_and_keeps_its_symmetry() {
    let bounds = [(Stabilisation::TwoShocks, (0.0164, 0.0526)), (Stabilisation::ArtificialViscosity, (0.0197, 0.0663))];
    for (stabilisation, bounds) in bounds {
        let (coarse, _) = errors(0.4, stabilisation);
        let (fine, asymmetry) = errors(0.2, stabilisation);
        assert_below(fine, bounds);
        assert!(coarse.0 > 1.3 * fine.0 && coarse.1 > 1.3 * fine.1, "{coarse:?} to {fine:?}");
        assert!(asymmetry < 1e-12, "{asymmetry:e}");
    }
}

#[test]
fn channel_of_one_row_pushes_nothing_across_over_an_uneven_bed() {
    let mut problem = flat_strip(20.0, 0.5, |x| 0.4 * (0.9 * x).sin());
    problem.courant = VariationalSolver::default_courant(Integrator::Leapfrog);
    let lattice = &problem.bed.lattice;
    problem.initial_depth = (0..lattice.len()).map(|cell| 1.0 - problem.bed.elevation[cell]).collect();
    let middle = 0.5 * lattice.size().y;
    let methods = MovingMethods::new(Integrator::Leapfrog, Stabilisation::ArtificialViscosity);
    let seeds = line_seeds(&problem);
    let mut solver = VariationalSolver::with_methods(problem, seeds, methods, Dimension::One);
    run_steps(&mut solver, 300);
    // Nothing acts across: neither force nor rounding.
    let particles = &solver.state().particles;
    assert!(particles.velocity.iter().all(|v| v.y.abs() <= 0.0), "{:?}", particles.velocity);
    assert!(particles.position.iter().all(|place| (place.y - middle).abs() <= 0.0));
    // Still water on the lattice of its bed rests (M116): rounding of forces of 10 m/s², 300 steps long.
    assert!(max_speed(&solver) < 1e-9, "{:e} m/s", max_speed(&solver));
}

#[test]
fn box_of_level_water_stays_at_rest_between_its_walls() {
    // Mirror images complete every kernel: a lattice of particles on a level bed has no force, corners included.
    for stabilisation in [Stabilisation::TwoShocks, Stabilisation::ArtificialViscosity] {
        let mut solver = box_of_water(stabilisation);
        run_steps(&mut solver, 200);
        // Summed depths of about 1 m are iterated to 1e-10 m, which drives some 1e-9 m/s² at random, 200 steps long.
        assert!(max_speed(&solver) < 1e-6, "{stabilisation:?}: {:e} m/s", max_speed(&solver));
        let particles = &solver.state().particles;
        let worst = particles.depth.iter().map(|d| (d - 1.0).abs()).fold(0.0, f64::max);
        // Kernels are normalised on the lattice.
        assert!(worst < 1e-7, "{worst}");
    }
}

#[test]
fn still_water_beside_an_oblique_wall_rests() {
    // Images in an oblique wall lie on no lattice: the sums of cells there are as far from 1 as those of the particles.
    let cells = (SIZE / SPACING).round() as usize;
    let mut problem = problem(cells, cells, SPACING, |p| 0.3 * (1.3 * p.x).sin() * (0.9 * p.y).cos());
    problem.courant = VariationalSolver::default_courant(Integrator::Leapfrog);
    problem.bed.is_sloped = true;
    problem.walls.push([Vec2::new(3.13, 0.0), Vec2::new(8.37, SIZE)]);
    let places = jittered_lattice(SIZE, SIZE, SPACING, 0.0);
    let seeds = seeds_at(&problem, &places, SPACING * SPACING, |_| 2.0);
    let mut solver = VariationalSolver::new(problem, seeds, Integrator::Leapfrog, Stabilisation::ArtificialViscosity);
    run_steps(&mut solver, 100);
    // Rounding of forces of 10 m/s², 100 steps long.
    assert!(max_speed(&solver) < 1e-9, "{:e} m/s", max_speed(&solver));
}

/// Greatest changes of two energies (m²/s²) of a lone particle that slides through a bowl of radius of curvature 20 m from a
/// height of 10 m, over its kinetic energy at the bottom: with and without that of the vertical motion.
#[expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
fn energy_changes(bed_slope: BedSlope) -> (f64, f64) {
    const SPACING: f64 = 0.5;
    let (centre, curvature) = (Vec2::new(50.0, 40.0), Sym2 { xx: 0.05, xy: 0.01, yy: 0.04 });
    let bowl = |p: Vec2| 0.5 * (p - centre).dot(curvature.apply(p - centre));
    let mut problem = problem(200, 160, SPACING, bowl);
    problem.bed.is_sloped = true;
    // A lone particle spreads over the whole bowl, some 1e-6 m deep, and must not count as dry.
    problem.dry_depth = 1e-9;
    let position = centre + Vec2::new(-20.0, 3.0);
    let seeds = vec![FluidSeed { position, volume: 0.01, depth: 0.01 }];
    let methods =
        MovingMethods { bed_slope, ..MovingMethods::new(Integrator::Leapfrog, Stabilisation::ArtificialViscosity) };
    let mut solver = VariationalSolver::with_methods(problem, seeds, methods, Dimension::Two);
    let energies = |solver: &VariationalSolver| {
        let particles = &solver.state().particles;
        let (x, v) = (particles.position[0] - centre, particles.velocity[0]);
        let flat = 0.5 * v.norm_squared() + GRAVITY * bowl(x + centre);
        (flat + 0.5 * v.dot(curvature.apply(x)).powi(2), flat)
    };
    let first = energies(&solver);
    let (mut with, mut without) = (0.0_f64, 0.0_f64);
    while solver.time() < 20.0 {
        let step = solver.choose_step().time_step.min(0.01);
        solver.advance(step).unwrap();
        let now = energies(&solver);
        with = with.max((now.0 / first.0 - 1.0).abs());
        without = without.max((now.1 / first.1 - 1.0).abs());
    }
    (with, without)
}

#[test]
fn particle_on_a_steep_bed_keeps_the_energy_of_its_motion_in_space() {
    // Slopes between particles of the bed are bilinear, half a cell off at most: a per cent of the radius.
    let (with, without) = energy_changes(BedSlope::Steep);
    println!("steep: {with:e}, {without:e}");
    assert!(with < 0.01 && without > 0.1, "{with:e}, {without:e}");
    // The shallow-water equations keep the energy of the motion in the plane instead.
    let (with, without) = energy_changes(BedSlope::Hydrostatic);
    println!("hydrostatic: {with:e}, {without:e}");
    assert!(without < 0.01 && with > 0.1, "{with:e}, {without:e}");
}
