//! From face fluxes to the new state: the sums of (M17), friction, and the two stages of Heun's method.
//!
//! ```text
//! (M33)  U' = F(U + Δt L(U))        U'' = F(U + ½ Δt (L(U) + L(U')))
//! ```
//!
//! The sums of a cell in part are over its area, 1/φ of (M13).
//!
//! The first stage leaves U + ½ Δt L(U) where U was. F is the implicit Manning friction of one step (M34), exact for friction alone
//! ([`kept_by_friction`]).

use rayon::prelude::*;

use super::Scale;
use super::faces::{EAST, NORTH};
use super::primitive::per_moving_depth;
use super::spans::{ActiveSet, Run};
use super::state::{FluxRow, GroundRow, PrimitiveRow, State, WaterRow};
use crate::physics::friction::manning::kept_by_friction;

/// Which half of Heun's method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    First,
    Second,
}

impl Stage {
    /// What [`take`] looks ahead by: the first stage by the whole step, though what it gains counts half.
    #[inline(always)]
    pub fn ahead(self) -> f64 {
        match self {
            Stage::First => 1.0,
            Stage::Second => 0.0,
        }
    }
}

/// Takes the step from the start (first stage) or from the first stage's state (second stage). What the first stage makes of the water
/// goes where the second looks for it, into the primitive rows.
pub(crate) fn apply(state: &mut State, active: &ActiveSet, scale: &Scale, stage: Stage, time_step: f64) {
    let (flux, ground, spacing) = (&state.flux, &state.ground, &state.spacing);
    let rows = active.rows_of(&mut state.water).zip(active.rows_of(&mut state.primitive));
    rows.for_each(|((row, water), (_, primitive))| {
        let scale = &scale.on(spacing[row]);
        for run in active.whole_pieces(row) {
            let rows = (&flux[row - 1], &flux[row], &ground[row]);
            match stage {
                Stage::First => row_update::<true>(rows, run, scale, time_step, water, primitive),
                Stage::Second => row_update::<false>(rows, run, scale, time_step, water, primitive),
            }
        }
    });
}

/// The update of a run of cells from the faces of the row to the south and of their own.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn row_update<const IS_FIRST: bool>(
    (south, here, ground): (&FluxRow, &FluxRow, &GroundRow),
    run: Run,
    scale: &Scale,
    time_step: f64,
    water: &mut WaterRow,
    primitive: &mut PrimitiveRow,
) {
    let (step_ratio, dry_depth) = (time_step / scale.spacing, scale.dry_depth);
    let (from, len) = (run.start, run.len());
    macro_rules! columns {
        ($row:expr, $from:expr, $($field:ident)+) => { ($(&$row.$field[$from..][..len],)+) };
    }
    let (west_mass, west_normal, west_tangential) = columns!(here[EAST], from - 1, mass normal_right tangential);
    let (east_mass, east_normal, east_tangential) = columns!(here[EAST], from, mass normal_left tangential);
    let (south_mass, south_normal, south_tangential) = columns!(south[NORTH], from, mass normal_right tangential);
    let (north_mass, north_normal, north_tangential) = columns!(here[NORTH], from, mass normal_left tangential);
    let (per_area, friction) = columns!(ground, from, per_area friction);
    let WaterRow { depth, discharge_x, discharge_y } = water;
    let depth = &mut depth[from..][..len];
    let (discharge_x, discharge_y) = (&mut discharge_x[from..][..len], &mut discharge_y[from..][..len]);
    let stage_depth = &mut primitive.depth[from..][..len];
    let (stage_u, stage_v) = (&mut primitive.velocity_x[from..][..len], &mut primitive.velocity_y[from..][..len]);
    let ahead = if IS_FIRST { Stage::First } else { Stage::Second }.ahead();
    for i in 0..len {
        let gained_depth = (west_mass[i] - east_mass[i]) + (south_mass[i] - north_mass[i]);
        let gained_x = (west_normal[i] - east_normal[i]) + (south_tangential[i] - north_tangential[i]);
        let gained_y = (south_normal[i] - north_normal[i]) + (west_tangential[i] - east_tangential[i]);
        let half = 0.5 * step_ratio * per_area[i];
        let (half_depth, raised) = take(depth[i], half * gained_depth, ahead);
        let (half_x, q_x) = take(discharge_x[i], half * gained_x, ahead);
        let (half_y, q_y) = take(discharge_y[i], half * gained_y, ahead);
        // What is not a number stays, so that the watch sees it.
        let new_depth = if raised < 0.0 { 0.0 } else { raised };
        let speed = (q_x * q_x + q_y * q_y).sqrt() / new_depth;
        let slowed = kept_by_friction(speed, new_depth, friction[i] * time_step);
        let kept = if new_depth <= dry_depth { 0.0 } else { slowed };
        let (new_x, new_y) = (counted(kept * q_x), counted(kept * q_y));
        if IS_FIRST {
            let per_depth = per_moving_depth(new_depth, dry_depth);
            (stage_depth[i], stage_u[i], stage_v[i]) = (new_depth, new_x * per_depth, new_y * per_depth);
            (depth[i], discharge_x[i], discharge_y[i]) = (half_depth, half_x, half_y);
        } else {
            (depth[i], discharge_x[i], discharge_y[i]) = (new_depth, new_x, new_y);
        }
    }
}

/// What a stage leaves of a conserved quantity of which it gains half of its step, and what it makes of it.
#[inline(always)]
pub(super) fn take(held: f64, gained: f64, ahead: f64) -> (f64, f64) {
    let left = held + gained;
    (left, left + ahead * gained)
}

/// A discharge, or 0 where it is so small (m²/s) that arithmetic with it would leave the range of normal numbers and be slow.
#[inline(always)]
pub(super) fn counted(discharge: f64) -> f64 {
    if discharge.abs() < 1e-100 { 0.0 } else { discharge }
}
