//! The core with resting particles against exact solutions: errors are means over the grid, and their order is checked.

use floodsim::scenario::methods::Motion;
use floodsim::validation::cases::circles::circular;
use floodsim::validation::cases::dam_breaks::{END, channel};
use floodsim::validation::exact::Accuracy;

use crate::support::{assert_below, errors, resting};

/// A channel 2000 m long, 10 m of water west of its middle and `right` (m) east of it, at 50 s.
fn channel_errors(spacing: f64, right: f64) -> (f64, f64) {
    errors(&channel(spacing, right, END), &resting())
}

#[test]
fn ritter_converges_at_first_order() {
    let (coarse, fine) = (channel_errors(10.0, 0.0), channel_errors(5.0, 0.0));
    // Measured .0184 and .0091 m; the velocity of the front's last cells is late.
    assert!(coarse.0 < 0.019 && fine.0 < 0.0095, "{coarse:?} to {fine:?}");
    assert!((coarse.0 / fine.0).log2() > 0.95, "{coarse:?} to {fine:?}");
}

#[test]
fn stoker_converges_at_first_order() {
    let (coarse, fine) = (channel_errors(10.0, 5.0), channel_errors(5.0, 5.0));
    assert_below(coarse, (0.0175, 0.0205));
    assert_below(fine, (0.0089, 0.0105));
    assert!((coarse.0 / fine.0).log2() > 0.95 && (coarse.1 / fine.1).log2() > 0.95, "{coarse:?} to {fine:?}");
}

#[test]
fn strong_bore_over_a_thin_layer_converges() {
    let (coarse, fine) = (channel_errors(10.0, 0.1), channel_errors(5.0, 0.1));
    assert!(coarse.0 < 0.023 && fine.0 < 0.0105, "{coarse:?} to {fine:?}");
    assert!((coarse.0 / fine.0).log2() > 0.95, "{coarse:?} to {fine:?}");
}

#[test]
fn circular_dam_break_converges_at_first_order() {
    let run = |spacing| errors(&circular(spacing, Motion::Eulerian, Accuracy::First), &resting());
    let (coarse, fine) = (run(0.2), run(0.1));
    // Measured .0157/.0750 and .0067/.0306 within 10 m of the centre.
    assert_below(fine, (0.0070, 0.0322));
    assert!((coarse.0 / fine.0).log2() > 1.0 && (coarse.1 / fine.1).log2() > 1.0, "{coarse:?} to {fine:?}");
}
