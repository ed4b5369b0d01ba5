//! Circular dam break in a quadrant whose two walls are the planes of symmetry.

use floodsim::math::Vec2;
use floodsim::scenario::methods::Integrator;
use floodsim::solver::FlowSolver;
use floodsim::solver::lagrangian::LagrangianSolver;

use crate::support::{assert_below, mean_errors, places, problem, radial_reference, run_steps, run_until, seeds_at};

const SIZE: f64 = 12.0;
const DAM: f64 = 2.5;
const END: f64 = 1.4;

fn quadrant(spacing: f64, integrator: Integrator) -> LagrangianSolver {
    let cells = (SIZE / spacing).round() as usize;
    let mut problem = problem(cells, cells, spacing, |_| 0.0);
    problem.courant = LagrangianSolver::default_courant(integrator);
    let level = |p: Vec2| if p.norm() < DAM { 2.5 } else { 0.5 };
    let seeds = seeds_at(&problem, &places(SIZE, SIZE, spacing, 0.0), spacing * spacing, level);
    LagrangianSolver::new(problem, seeds, integrator)
}

/// Mean errors of depth (m) and velocity (m/s), and how far the total momentum is off the diagonal, relatively.
fn errors(spacing: f64, integrator: Integrator) -> ((f64, f64), f64) {
    let reference = radial_reference(2.5, 0.5, DAM, 17.0, END, 2000);
    let mut solver = quadrant(spacing, integrator);
    run_until(&mut solver, END);
    let errors = mean_errors(&solver, |p| {
        let (d, u) = reference(p.norm());
        (d, p * (u / p.norm()))
    });
    let particles = &solver.state().particles;
    let momentum = (0..particles.len()).fold(Vec2::ZERO, |sum, i| sum + particles.velocity[i] * particles.volume[i]);
    (errors, ((momentum.x - momentum.y) / momentum.x).abs())
}

#[test]
fn circular_dam_break_converges_and_keeps_its_symmetry() {
    let (coarse, _) = errors(0.4, Integrator::Leapfrog);
    let (fine, asymmetry) = errors(0.2, Integrator::Leapfrog);
    assert_below(fine, (0.0118, 0.0462));
    assert!(coarse.0 > 1.9 * fine.0 && coarse.1 > 1.9 * fine.1, "{coarse:?} to {fine:?}");
    // Rounding of sums over 3600 particles.
    assert!(asymmetry < 1e-12, "{asymmetry:e}");
    assert_below(errors(0.2, Integrator::Heun).0, (0.0121, 0.0482));
}

/// A cylinder of water, 1 m high, spreading on dry ground to a fiftieth of its depth: error of depth (m) by particles, of
/// velocity (m/s) by volume.
fn spreading_errors(spacing: f64) -> (f64, f64) {
    let reference = radial_reference(1.0, 1e-9, 1.0, 8.0, 1.0, 2000);
    let problem = problem(80, 80, 0.1, |_| 0.0);
    let inside = |p: Vec2| if p.norm() < 1.0 { 1.0 } else { 0.0 };
    let seeds = seeds_at(&problem, &places(1.0, 1.0, spacing, 0.0), spacing * spacing, inside);
    let mut solver = LagrangianSolver::new(problem, seeds, Integrator::Leapfrog);
    run_until(&mut solver, 1.0);
    let particles = &solver.state().particles;
    let (mut depth, mut velocity, mut volume) = (0.0, 0.0, 0.0);
    for i in 0..particles.len() {
        let (place, r) = (particles.position[i], particles.position[i].norm());
        let (d, u) = reference(r);
        depth += (particles.depth[i] - d).abs();
        velocity += particles.volume[i] * (particles.velocity[i] - place * (u / r)).norm();
        volume += particles.volume[i];
    }
    (depth / particles.len() as f64, velocity / volume)
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
    let mut solver = quadrant(0.1, Integrator::Leapfrog);
    run_steps(&mut solver, 60);
    assert_eq!(solver.particle_evaluations(), 61 * solver.particles() as u64);
}
