//! Thacker's axisymmetric oscillation in a paraboloid with cells that move.

use floodsim::scenario::methods::Core;
use floodsim::validation::cases::bowls::{BOWL, axisymmetric};

use crate::support::{assert_below, moving, outcome};

/// Mean depth error over the depth in the middle, and mean velocity error by volume (m/s), after whole periods.
fn errors(spacing: f64, periods: f64) -> (f64, f64) {
    let setup = axisymmetric(spacing, Core::Lagrangian, periods);
    let outcome = outcome(&setup, &moving());
    (outcome.errors.depth / BOWL.depth, outcome.end.velocity_error_by_volume(|place| (setup.exact)(place).1))
}

#[test]
fn oscillation_returns_after_three_periods() {
    let (coarse, fine) = (errors(0.1, 3.0), errors(0.05, 3.0));
    println!(
        "bowl after three periods, depth over the middle's and velocity (m/s): a/10 {coarse:.4?}, a/20 {fine:.4?}"
    );
    assert_below(coarse, (5.9e-2, 4.5e-2));
    assert_below(fine, (1.9e-2, 2.1e-2));
    assert!(coarse.0 > 2.0 * fine.0, "{coarse:?} to {fine:?}");
}
