//! Moving depth and velocity of the particles in work, and the greatest signal speed.

use rayon::prelude::*;

use super::Scale;
use super::spans::ActiveSet;
use super::state::{Fastest, State};

/// Which state the quantities are taken from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// The start (or end) of a step.
    Step,
    /// The state after the first stage.
    Stage,
}

/// Fills the primitive rows of all cells in work.
///
/// Water that is not deeper than the dry depth is a film: the pairs see its depth, but it has no velocity and gives nothing.
pub(crate) fn evaluate(state: &mut State, active: &ActiveSet, scale: &Scale, source: Source) {
    let water = &state.water;
    state.primitive.par_iter_mut().enumerate().with_min_len(4).for_each(|(row, primitive)| {
        let water = &water[row];
        let (depth, discharge_x, discharge_y) = match source {
            Source::Step => (&water.depth, &water.discharge_x, &water.discharge_y),
            Source::Stage => (&water.stage_depth, &water.stage_discharge_x, &water.stage_discharge_y),
        };
        let mut fastest = Fastest { row, ..Fastest::default() };
        let mut flow_speed_squared: f64 = 0.0;
        for run in &active.work[row] {
            for i in run.clone() {
                let d = depth[i];
                let is_film = d <= scale.dry_depth;
                let per_depth = if is_film { 0.0 } else { 1.0 / d };
                let (u, v) = (discharge_x[i] * per_depth, discharge_y[i] * per_depth);
                primitive.depth[i] = d;
                primitive.velocity_x[i] = u;
                primitive.velocity_y[i] = v;
                let speed_squared = u * u + v * v;
                flow_speed_squared =
                    if speed_squared > flow_speed_squared { speed_squared } else { flow_speed_squared };
                let signal_speed = if is_film { 0.0 } else { speed_squared.sqrt() + (scale.gravity * d).sqrt() };
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
