//! Moving depth and velocity of the active particles, and the greatest signal speed.

use rayon::prelude::*;

use super::Scale;
use super::spans::ActiveSet;
use super::state::{Fastest, State};

/// Fills the primitive rows of all active cells from the water at the end of a step. (After its first stage `update` has filled them.)
///
/// Water that is not deeper than the dry depth is a film: the pairs see its depth, but it has no velocity and gives nothing.
pub(crate) fn evaluate(state: &mut State, active: &ActiveSet, scale: &Scale) {
    let water = &state.water;
    active.rows_of(&mut state.primitive).for_each(|(row, primitive)| {
        let water = &water[row];
        let mut fastest = Fastest { row, ..Fastest::default() };
        let mut flow_speed_squared: f64 = 0.0;
        for run in &active.work[row] {
            for i in run.clone() {
                let d = water.depth[i];
                let per_depth = per_moving_depth(d, scale.dry_depth);
                let (u, v) = (water.discharge_x[i] * per_depth, water.discharge_y[i] * per_depth);
                primitive.depth[i] = d;
                primitive.velocity_x[i] = u;
                primitive.velocity_y[i] = v;
                let speed_squared = u * u + v * v;
                flow_speed_squared =
                    if speed_squared > flow_speed_squared { speed_squared } else { flow_speed_squared };
                let signal_speed =
                    if d <= scale.dry_depth { 0.0 } else { speed_squared.sqrt() + (scale.gravity * d).sqrt() };
                // A value that is not a number must win, so that the watch sees it.
                if signal_speed > fastest.signal_speed || signal_speed.is_nan() {
                    fastest.signal_speed = signal_speed;
                    fastest.column = i;
                }
            }
        }
        fastest.flow_speed = flow_speed_squared.sqrt();
        primitive.fastest = fastest;
    });
}

/// 1/d (1/m), or 0 for a film: what makes a velocity of a discharge.
#[inline(always)]
pub(super) fn per_moving_depth(depth: f64, dry_depth: f64) -> f64 {
    if depth <= dry_depth { 0.0 } else { 1.0 / depth }
}
