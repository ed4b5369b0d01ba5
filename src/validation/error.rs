//! Mean absolute errors: over the particles of the variational formulation, over the cells that are wet in the balanced one, as the maps show them.
//!
//! ```text
//! error of the depth = Σ |d − d_exact| / N,   error of the velocity = Σ |v − v_exact| / N
//! ```
//!
//! A cell is wet when either depth exceeds a ten-thousandth of the greatest one; its velocity counts as an error of 0 where
//! the exact depth is below half a per cent of the greatest, because the velocity of such a film means nothing.

use super::case::{Exact, Setup};
use super::outcome::{Errors, Snapshot};

/// Share of the greatest depth from which a cell is wet.
const WET_SHARE: f64 = 1e-4;
/// Share of the greatest depth from which the velocity of a cell counts.
const THICK_SHARE: f64 = 5e-3;

/// The errors of a snapshot of a setup against an answer; none where no particle counts.
pub fn errors(snapshot: &Snapshot, setup: &Setup, exact: &Exact) -> Errors {
    let (wet, thick) = if snapshot.is_of_particles {
        (f64::NEG_INFINITY, f64::NEG_INFINITY)
    } else {
        (WET_SHARE * setup.scale_depth, THICK_SHARE * setup.scale_depth)
    };
    let (mut sum, mut number) = (Errors::default(), 0);
    for sample in snapshot.samples.iter().filter(|sample| (setup.counts)(sample.place)) {
        let (depth, velocity) = exact(sample.place);
        if sample.depth <= wet && depth <= wet {
            continue;
        }
        sum.depth += (sample.depth - depth).abs();
        sum.velocity += if depth > thick { (sample.velocity - velocity).norm() } else { 0.0 };
        number += 1;
    }
    let number = f64::from(number.max(1));
    Errors { depth: sum.depth / number, velocity: sum.velocity / number }
}
