//! Thacker's axisymmetric oscillation in a paraboloid.

use floodsim::math::Vec2;
use floodsim::scenario::methods::Integrator;
use floodsim::solver::lagrangian::LagrangianSolver;

use crate::support::{GRAVITY, assert_below, places, problem, run_until, seeds_at};

const RADIUS: f64 = 1.0;
const DEPTH: f64 = 0.1;
const START_RADIUS: f64 = 0.8;
const HALF: f64 = 1.6;

/// Surface level (m) at distance `r` from the middle when the cosine of the phase is `cosine`; the rim of the bowl is at 0.
fn level(r: f64, cosine: f64) -> f64 {
    let (a4, r4) = (RADIUS.powi(4), START_RADIUS.powi(4));
    let amplitude = (a4 - r4) / (a4 + r4);
    let (root, nearness) = ((1.0 - amplitude * amplitude).sqrt(), 1.0 - amplitude * cosine);
    DEPTH * (root / nearness - 1.0 - r * r / (RADIUS * RADIUS) * (root * root / (nearness * nearness) - 1.0))
}

/// Mean depth error over the depth in the middle, and mean velocity error by volume (m/s), after whole periods.
fn errors(spacing: f64, periods: f64, integrator: Integrator) -> (f64, f64) {
    let centre = Vec2::new(HALF, HALF);
    let bed = |p: Vec2| -DEPTH * (1.0 - (p - centre).norm_squared() / (RADIUS * RADIUS));
    let cells = (2.0 * HALF / spacing * 4.0).round() as usize;
    let mut problem = problem(cells, cells, 0.25 * spacing, bed);
    problem.courant = LagrangianSolver::default_courant(integrator);
    let seeds = seeds_at(&problem, &places(2.0 * HALF, 2.0 * HALF, spacing, 0.0), spacing * spacing, |p| {
        level((p - centre).norm(), 1.0)
    });
    let mut solver = LagrangianSolver::new(problem, seeds, integrator);
    let period = 2.0 * std::f64::consts::PI * RADIUS / (8.0 * GRAVITY * DEPTH).sqrt();
    run_until(&mut solver, periods * period);
    let particles = &solver.state().particles;
    let (mut depth, mut velocity, mut volume) = (0.0, 0.0, 0.0);
    for i in 0..particles.len() {
        let place = particles.position[i];
        let exact = (level((place - centre).norm(), 1.0) - bed(place)).max(0.0);
        depth += (particles.depth[i] - exact).abs() / DEPTH;
        velocity += particles.velocity[i].norm() * particles.volume[i];
        volume += particles.volume[i];
    }
    (depth / particles.len() as f64, velocity / volume)
}

#[test]
fn oscillation_returns_after_three_periods() {
    let coarse = errors(0.1, 3.0, Integrator::Leapfrog);
    let fine = errors(0.05, 3.0, Integrator::Leapfrog);
    println!(
        "bowl after three periods, depth over the middle's and velocity (m/s): a/10 {coarse:.4?}, a/20 {fine:.4?}"
    );
    // The bounds at a/10 were 6.0e-2 and 2.0e-2 once: decisions 0007 and 0008 say what they paid for.
    assert_below(coarse, (6.3e-2, 2.3e-2));
    assert_below(fine, (1.15e-2, 4.0e-3));
    assert!(coarse.0 > 2.0 * fine.0, "{coarse:?} to {fine:?}");
    // Heun's method has the larger error in time.
    assert_below(errors(0.05, 3.0, Integrator::Heun), (7.5e-3, 3.5e-2));
}
