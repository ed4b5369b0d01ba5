//! Levels that are held and waves that come in beside moving particles, against the water of resting ones and exact solutions.

use crate::boundary::{Condition, Series};
use crate::math::Vec2;
use crate::methods::Integrator;
use crate::physics::dimension::Dimension;
use crate::solver::moving::scene::{G, problem, solver};
use crate::solver::testing::{open, run_steps, run_until};
use crate::solver::{EulerianSolver, FlowProblem, FlowSolver};

fn celerity(depth: f64) -> f64 {
    (G * depth).sqrt()
}

/// A series of a function of time (s) in steps of a twentieth of a second.
fn series(end: f64, value: impl Fn(f64) -> f64) -> Series {
    let points: Vec<(f64, f64)> = (0..=(20.0 * end) as usize).map(|i| i as f64 / 20.0).map(|t| (t, value(t))).collect();
    Series::new(&points).unwrap()
}

/// Greatest differences of depth (m) and inflow (share) between moving and resting particles after a time (s).
fn apart(problem: &FlowProblem, end: f64, dimension: Dimension) -> (f64, f64) {
    let mut moving = solver(problem.clone(), dimension, Integrator::Leapfrog);
    let mut resting = EulerianSolver::new(problem.clone());
    run_until(&mut moving, end);
    run_until(&mut resting, end);
    let width = if dimension == Dimension::One { problem.bed.lattice.spacing } else { 1.0 };
    let depths =
        moving.water().depths().iter().zip(resting.water().depths()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let (a, b) = (moving.ledger(), resting.ledger());
    assert!(a.relative_error().abs() < 1e-12, "{a:?}");
    let net = |ledger: &crate::solver::Ledger| ledger.inflow - ledger.outflow;
    (depths, net(&a) * width / net(&b) - 1.0)
}

#[test]
fn a_changing_level_sends_the_same_wave_as_with_resting_particles() {
    for height in [0.2, -0.2] {
        let level = move |time: f64| 1.0 + height * (0.05 * std::f64::consts::PI * time.min(10.0)).sin().powi(2);
        for (name, condition) in [
            ("level", Condition::Level(series(12.0, level))),
            ("wave", Condition::Wave { level: series(12.0, level), still: None }),
        ] {
            let mut problem = problem((120, 1), 0.5, |_| 0.0, |_| 1.0);
            open(&mut problem, true, condition);
            let (depth, volume) = apart(&problem, 12.0, Dimension::One);
            // Measured: 4.4 % of the height, .4 % of the volume.
            assert!(depth < 0.05 * 0.2 && volume.abs() < 0.01, "{name} {height} m: {depth} m, {volume}");
        }
    }
}

#[test]
fn a_level_comes_onto_dry_ground_as_critical_flow() {
    for (slope, end) in [(0.0, 10.0), (0.05, 100.0)] {
        let mut problem = problem((80, 1), 2.5, |place| -slope * place.x, |_| f64::NEG_INFINITY);
        problem.dry_depth = 1e-3;
        let level = Series::constant(0.9);
        open(&mut problem, true, Condition::Level(level));
        open(&mut problem, false, Condition::Free);
        let mut solver = solver(problem, Dimension::One, Integrator::Leapfrog);
        run_until(&mut solver, 0.5 * end);
        let before = solver.ledger().inflow;
        run_until(&mut solver, end);
        let depth: f64 = 0.9;
        let share = (solver.ledger().inflow - before) / (0.5 * end) / (depth * celerity(depth));
        assert!((share - 1.0).abs() < 0.05, "slope {slope}: {share}");
    }
}

#[test]
fn levels_held_at_both_ends_of_a_river_are_those_of_its_flow() {
    let (slope, n, spacing) = (1e-3_f64, 0.03, 20.0);
    let bed = |place: Vec2| -slope * place.x;
    let mut problem = problem((50, 3), spacing, bed, |place| 2.0 - slope * place.x);
    problem.bed.manning.fill(n);
    open(&mut problem, true, Condition::Level(Series::constant(2.0)));
    open(&mut problem, false, Condition::Level(Series::constant(2.0 - slope * 1000.0)));
    let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
    run_until(&mut solver, 6000.0);
    let velocity = 2.0_f64.powf(2.0 / 3.0) * slope.sqrt() / n;
    let particles = &solver.state().particles;
    let off = particles
        .depth
        .iter()
        .zip(&particles.velocity)
        .map(|(d, v)| ((d / 2.0 - 1.0).abs(), (v.x / velocity - 1.0).abs()));
    let (depth, speed) = off.fold((0.0, 0.0), |worst: (f64, f64), error| (worst.0.max(error.0), worst.1.max(error.1)));
    assert!(depth < 1e-2 && speed < 1e-2, "{depth}, {speed}");
}

#[test]
fn a_wave_that_comes_back_from_a_wall_leaves() {
    for height in [0.01, 0.1, 0.3] {
        let hump = |time: f64| height * (std::f64::consts::PI * (time / 20.0).clamp(0.0, 1.0)).sin().powi(2);
        let mut problem = problem((160, 1), 0.5, |_| 0.0, |_| 1.0);
        open(&mut problem, true, Condition::Wave { level: series(100.0, |time| 1.0 + hump(time)), still: None });
        let mut solver = solver(problem, Dimension::One, Integrator::Leapfrog);
        let mut highest = 0.0_f64;
        for moment in 0..400 {
            run_until(&mut solver, 0.1 * f64::from(moment));
            let particles = solver.state().particles.depth.iter().map(|d| d - 1.0);
            highest = highest.max(particles.fold(0.0, f64::max) / height);
        }
        run_until(&mut solver, 100.0);
        let left = solver.state().particles.depth.iter().map(|d| (d - 1.0).abs()).fold(0.0, f64::max) / height;
        assert!(left < 0.03 && (highest - 2.0).abs() < 0.15 + height, "{height} m: {left}, {highest}");
        assert!(solver.ledger().relative_error().abs() < 1e-12);
    }
}

#[test]
fn a_lake_stays_at_rest_behind_levels_and_waves_at_its_level() {
    let noise = |place: Vec2| ((place.x * 12.9898 + place.y * 78.233).sin() * 43_758.545_3).fract() - 0.5;
    for level in [2.0, 1234.5] {
        let held = || Series::constant(level);
        let mut problem = problem((20, 16), 1.0, |place| level - 2.0 + 2.5 * (noise(place) + 0.2), |_| level);
        open(&mut problem, true, Condition::Level(held()));
        open(&mut problem, false, Condition::Wave { level: held(), still: None });
        let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
        let fastest = run_steps(&mut solver, 100);
        assert!(fastest < 1e-12, "level {level}: {fastest:e} m/s");
    }
}
