//! From face fluxes to the new state: the sums of (M10), friction, and the two stages of Heun's method.
//!
//! ```text
//! (M17)  U' = F(U + Δt L(U))        U'' = F(U + ½ Δt (L(U) + L(U')))
//! ```
//!
//! The first stage leaves U + ½ Δt L(U) where U was. F is the implicit Manning friction of one step (M18), exact for friction alone:
//! |v_new| = (√(1 + 4 k |v|) − 1) / (2 k), k = Δt g n² / d^(4/3).

use rayon::prelude::*;

use super::Scale;
use super::faces::{EAST, NORTH};
use super::spans::{ActiveSet, Run};
use super::state::{FluxRow, GroundRow, NO_TERRAIN, State, WaterRow};
use crate::physics::friction::manning;

/// Which half of Heun's method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    First,
    Second,
}

impl Stage {
    /// What stands of a conserved quantity after the stage, and what it is taken for: the first stage looks ahead by the whole step,
    /// of which half counts (`gained`).
    #[inline(always)]
    pub fn take(self, held: f64, gained: f64) -> (f64, f64) {
        let stands = held + gained;
        let ahead = match self {
            Stage::First => 1.0,
            Stage::Second => 0.0,
        };
        (stands, stands + ahead * gained)
    }
}

/// Water leaving through the four faces of a cell (m²/s), inflow not counted.
fn outflow(south: &FluxRow, here: &FluxRow, i: usize) -> f64 {
    (here[EAST].mass[i].max(0.0) - here[EAST].mass[i - 1].min(0.0))
        + (here[NORTH].mass[i].max(0.0) - south[NORTH].mass[i].min(0.0))
}

/// Scales the outflow of cells that would give more water than they have in this stage.
pub(crate) fn limit_outflow(state: &mut State, active: &ActiveSet, scale: &Scale, stage: Stage, time_step: f64) {
    let step_ratio = time_step / scale.spacing;
    let (flux, water, ground) = (&state.flux, &state.water, &state.ground);
    let short: Vec<(usize, usize, f64)> = (1..state.rows + 1)
        .into_par_iter()
        .with_min_len(4)
        .flat_map_iter(|row| {
            let depth = match stage {
                Stage::First => &water[row].depth,
                Stage::Second => &water[row].stage_depth,
            };
            // A cell without terrain gives what comes over the boundary of the flow: it is not short of it.
            let cells = active.work[row].iter().cloned().flatten().filter(move |&i| ground[row].bed[i] < NO_TERRAIN);
            cells.filter_map(move |i| {
                let wanted = step_ratio * outflow(&flux[row - 1], &flux[row], i);
                (wanted > depth[i]).then(|| (row, i, depth[i].max(0.0) / wanted))
            })
        })
        .collect();
    for (row, i, share) in short {
        let reduce = |state: &mut State, row: usize, direction: usize, i: usize, sign: f64| {
            let face = &mut state.flux[row][direction];
            if face.mass[i] * sign > 0.0 {
                face.mass[i] *= share;
                face.tangential[i] *= share;
            }
        };
        reduce(state, row, EAST, i, 1.0);
        reduce(state, row, NORTH, i, 1.0);
        reduce(state, row, EAST, i - 1, -1.0);
        reduce(state, row - 1, NORTH, i, -1.0);
    }
}

/// Takes the step from the start (first stage) or from the first stage's state (second stage).
pub(crate) fn apply(state: &mut State, active: &ActiveSet, scale: &Scale, stage: Stage, time_step: f64) {
    let (flux, ground) = (&state.flux, &state.ground);
    state.water.par_iter_mut().enumerate().with_min_len(4).for_each(|(row, water)| {
        for run in &active.work[row] {
            let south = &flux[row - 1];
            row_update(south, &flux[row], &ground[row], run.clone(), scale, stage, time_step, water);
        }
    });
}

#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
#[expect(clippy::too_many_arguments, reason = "the rows that one row's update reads and writes")]
fn row_update(
    south: &FluxRow,
    here: &FluxRow,
    ground: &GroundRow,
    run: Run,
    scale: &Scale,
    stage: Stage,
    time_step: f64,
    water: &mut WaterRow,
) {
    let (step_ratio, dry_depth) = (time_step / scale.spacing, scale.dry_depth);
    let (east, north, from_south) = (&here[EAST], &here[NORTH], &south[NORTH]);
    for i in run {
        let gained_depth = (east.mass[i - 1] - east.mass[i]) + (from_south.mass[i] - north.mass[i]);
        let gained_x =
            (east.normal_right[i - 1] - east.normal_left[i]) + (from_south.tangential[i] - north.tangential[i]);
        let gained_y =
            (from_south.normal_right[i] - north.normal_left[i]) + (east.tangential[i - 1] - east.tangential[i]);
        // What passes a boundary of the flow stays out of the books of the cell beyond.
        let half = if ground.bed[i] < NO_TERRAIN { 0.5 * step_ratio } else { 0.0 };
        let (half_depth, raised) = stage.take(water.depth[i], half * gained_depth);
        let (half_x, q_x) = stage.take(water.discharge_x[i], half * gained_x);
        let (half_y, q_y) = stage.take(water.discharge_y[i], half * gained_y);
        // What is not a number stays, so that the watch sees it.
        let depth = if raised < 0.0 { 0.0 } else { raised };
        let kept =
            if depth <= dry_depth { 0.0 } else { kept_by_friction(depth, q_x, q_y, ground.friction[i] * time_step) };
        let (q_x, q_y) = (counted(kept * q_x), counted(kept * q_y));
        match stage {
            Stage::First => {
                (water.stage_depth[i], water.stage_discharge_x[i], water.stage_discharge_y[i]) = (depth, q_x, q_y);
                (water.depth[i], water.discharge_x[i], water.discharge_y[i]) = (half_depth, half_x, half_y);
            }
            Stage::Second => {
                (water.depth[i], water.discharge_x[i], water.discharge_y[i]) = (depth, q_x, q_y);
            }
        }
    }
}

/// A discharge, or 0 where it is so small (m²/s) that arithmetic with it would leave the range of normal numbers and be slow.
#[inline(always)]
pub(super) fn counted(discharge: f64) -> f64 {
    if discharge.abs() < 1e-100 { 0.0 } else { discharge }
}

/// Share of the velocity that is left after one step of Manning friction alone (M18); `roughness` is Δt g n².
#[inline(always)]
fn kept_by_friction(depth: f64, q_x: f64, q_y: f64, roughness: f64) -> f64 {
    manning::kept((q_x * q_x + q_y * q_y).sqrt() / depth, depth, roughness)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_alone_is_exact() {
        // dv/dt = −k' v², k' = g n²/d^(4/3), taken implicitly: v_new = v − Δt k' v_new².
        let (d, v, n, dt): (f64, f64, f64, f64) = (0.4, 3.0, 0.05, 2.0);
        let kept = kept_by_friction(d, d * v, 0.0, dt * 9.81 * n * n);
        let v_new = kept * v;
        let k = 9.81 * n * n / d.powf(4.0 / 3.0);
        assert!((v_new - (v - dt * k * v_new * v_new)).abs() < 1e-12);
    }

    #[test]
    fn without_roughness_nothing_is_lost() {
        assert_eq!(kept_by_friction(1.0, 2.0, 1.0, 0.0).to_bits(), 1.0_f64.to_bits());
    }
}
