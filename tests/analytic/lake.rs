//! A lake at rest stays at rest: any bed, any arrangement of particles.

use floodsim::math::Vec2;
use floodsim::validation::cases::lakes::{bump, island, rough, step, still};
use floodsim::validation::run;

use crate::support::moving;

const SPACING: f64 = 0.25;
const STEPS: usize = 300;
/// Rounding of levels near 100 m (1e-14 m) in sums over some thirty neighbours, for 300 steps.
const REST: f64 = 1e-12;

/// Greatest speed (m/s) in a few hundred steps; places are moved by up to `jitter` spacings in each direction.
fn speed(bed: fn(Vec2) -> f64, jitter: f64, integrator: &str) -> f64 {
    let (cost, ended) = run(&still(bed, SPACING, jitter, STEPS), &moving(integrator));
    assert!(ended.is_ok() && cost.steps == STEPS, "{cost:?}");
    cost.max_speed
}

#[test]
fn lake_is_at_rest_on_any_bed_and_arrangement() {
    for (name, bed) in [("bump", bump as fn(Vec2) -> f64), ("step", step), ("rough", rough)] {
        for jitter in [0.0, 0.15, 0.3] {
            let speed = speed(bed, jitter, "leapfrog");
            assert!(speed < REST, "{name}, jitter {jitter}: {speed:e} m/s");
        }
    }
}

#[test]
fn lake_is_at_rest_around_an_island() {
    for jitter in [0.0, 0.15] {
        let speed = speed(island, jitter, "leapfrog");
        assert!(speed < REST, "jitter {jitter}: {speed:e} m/s");
    }
    // Stronger jitter leaves true gaps of more than two spacings before the shore, into which water slumps.
    let slump = speed(island, 0.3, "leapfrog");
    assert!(slump < 0.02, "{slump:e} m/s");
}

#[test]
fn lake_is_at_rest_with_heun() {
    for bed in [rough, island] {
        let speed = speed(bed, 0.15, "heun");
        assert!(speed < REST, "{speed:e} m/s");
    }
}
