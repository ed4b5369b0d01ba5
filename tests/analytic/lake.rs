//! A lake at rest stays at rest: any bed, any arrangement of particles.

use floodsim::math::Vec2;
use floodsim::particles::FluidSeed;
use floodsim::scenario::methods::Integrator;
use floodsim::solver::FlowProblem;
use floodsim::solver::lagrangian::LagrangianSolver;

use crate::support::{max_speed, places, problem, run_steps, seeds_at};

const CELLS: usize = 24;
const SPACING: f64 = 0.25;
const SIZE: f64 = CELLS as f64 * SPACING;
const LEVEL: f64 = 100.0;
pub const STEPS: usize = 300;
/// Rounding of levels near 100 m (1e-14 m) in sums over some thirty neighbours, for 300 steps.
const REST: f64 = 1e-12;

/// A repeatable number in [0, 1) for each place.
fn noise(place: Vec2) -> f64 {
    ((place.x * 12.9898 + place.y * 78.233).sin() * 43_758.545_3).fract().abs()
}

/// A hill of unit height.
fn hill(place: Vec2) -> f64 {
    (-(place - Vec2::new(3.1, 2.9)).norm_squared() / 2.0).exp()
}

fn bump(place: Vec2) -> f64 {
    LEVEL - 1.0 + 0.5 * hill(place)
}

fn step(place: Vec2) -> f64 {
    LEVEL - if place.x < 3.0 { 1.0 } else { 0.2 }
}

pub fn rough(place: Vec2) -> f64 {
    LEVEL - 1.0 + 0.8 * noise(place)
}

pub fn island(place: Vec2) -> f64 {
    LEVEL - 1.0 + 1.8 * hill(place)
}

/// A lake over a bed; places are moved by up to `jitter` spacings in each direction.
pub fn lake_of(bed: fn(Vec2) -> f64, jitter: f64) -> (FlowProblem, Vec<FluidSeed>) {
    let problem = problem(CELLS, CELLS, SPACING, bed);
    let seeds = seeds_at(&problem, &places(SIZE, SIZE, SPACING, jitter), SPACING * SPACING, |_| LEVEL);
    (problem, seeds)
}

/// Greatest speed (m/s) after a few hundred steps.
fn speed(bed: fn(Vec2) -> f64, jitter: f64, integrator: Integrator) -> f64 {
    let (problem, seeds) = lake_of(bed, jitter);
    let mut solver = LagrangianSolver::new(problem, seeds, integrator);
    run_steps(&mut solver, STEPS);
    max_speed(&solver)
}

#[test]
fn lake_is_at_rest_on_any_bed_and_arrangement() {
    for (name, bed) in [("bump", bump as fn(Vec2) -> f64), ("step", step), ("rough", rough)] {
        for jitter in [0.0, 0.15, 0.3] {
            let speed = speed(bed, jitter, Integrator::Leapfrog);
            assert!(speed < REST, "{name}, jitter {jitter}: {speed:e} m/s");
        }
    }
}

#[test]
fn lake_is_at_rest_around_an_island() {
    for jitter in [0.0, 0.15] {
        let speed = speed(island, jitter, Integrator::Leapfrog);
        assert!(speed < REST, "jitter {jitter}: {speed:e} m/s");
    }
    // Stronger jitter leaves true gaps of more than two spacings before the shore, into which water slumps.
    let slump = speed(island, 0.3, Integrator::Leapfrog);
    assert!(slump < 0.02, "{slump:e} m/s");
}

#[test]
fn lake_is_at_rest_with_heun() {
    for bed in [rough, island] {
        let speed = speed(bed, 0.15, Integrator::Heun);
        assert!(speed < REST, "{speed:e} m/s");
    }
}
