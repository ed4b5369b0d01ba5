//! Dam breaks in a channel of one dimension with the variational formulation: error and order against exact solutions.
//!
//! Bounds are the errors measured on the day, a few per cent added: truncation, not rounding.

use floodsim::validation::cases::dam_breaks::{END, channel};

use crate::support::{assert_below, errors, methods};

/// Errors at 10 m and 5 m stay below their bounds, and fall by at least 2^order.
fn check(coarse: (f64, f64), fine: (f64, f64), bounds: [(f64, f64); 2], order: f64) {
    assert_below(coarse, bounds[0]);
    assert_below(fine, bounds[1]);
    let ratio = 2.0_f64.powf(order);
    assert!(coarse.0 > ratio * fine.0 && coarse.1 > ratio * fine.1, "{coarse:?} to {fine:?}");
}

#[test]
fn variational_form_has_its_known_errors() {
    let run = |spacing, right, stabilisation| {
        let methods = methods(&[("formulation", "variational"), ("stabilisation", stabilisation)]);
        errors(&channel(spacing, right, END), &methods)
    };
    let (viscosity, two_shocks) = ("artificial_viscosity", "two_shocks");
    check(run(10.0, 0.0, viscosity), run(5.0, 0.0, viscosity), [(0.039, 0.0435), (0.024, 0.0225)], 0.6);
    check(run(10.0, 5.0, viscosity), run(5.0, 5.0, viscosity), [(0.0466, 0.0360), (0.0296, 0.0205)], 0.6);
    check(run(10.0, 0.0, two_shocks), run(5.0, 0.0, two_shocks), [(0.062, 0.066), (0.037, 0.036)], 0.6);
    check(run(10.0, 5.0, two_shocks), run(5.0, 5.0, two_shocks), [(0.055, 0.046), (0.036, 0.029)], 0.6);
}
