//! No cell gives more water in a stage than it has: its outflow is scaled down where it would.

use std::ops::Range;

use rayon::prelude::*;

use super::conforming::ConformingFaces;
use super::faces::{EAST, NORTH};
use super::general_faces::GeneralFaces;
use super::moving_cells::MovingCells;
use super::spans::{ActiveSet, Run};
use super::state::{FluxRow, State, sides};
use super::update::Stage;
use crate::math::{larger, smaller};

/// Scales the outflow of cells that would give more water than they have in this stage.
///
/// - `levels`: those that take the step
/// - `time_step` (s): their step, and that of the coarser levels which step later
pub(crate) fn limit(
    state: &mut State,
    (active, levels): (&ActiveSet, &Range<usize>),
    (general, conforming, moving): (&mut GeneralFaces, &mut ConformingFaces, &mut Option<MovingCells>),
    stage: Stage,
    (time_step, of_coarser): (f64, f64),
) {
    let (flux, water, primitive, ground) = (&state.flux, &state.water, &state.primitive, &state.ground);
    let spacing = &state.spacing;
    let short: Vec<(usize, usize, f64)> = active
        .at_hand()
        .into_par_iter()
        .with_min_len(active.rows_at_once())
        .filter(|&row| row > 0)
        .flat_map_iter(|row| {
            let depth: &[f64] = match stage {
                Stage::First => &water[row].depth,
                Stage::Second => &primitive[row].depth,
            };
            let (south, here) = (&flux[row - 1], &flux[row]);
            let per_area: &[f64] = &ground[row].per_area;
            let rows = (south, here, depth, per_area);
            let step_ratio = time_step / spacing[row];
            let runs = active.work[row].iter().filter(move |run| some_are_short(rows, run, step_ratio));
            runs.cloned().flatten().filter_map(move |i| {
                let passing = [here[EAST].mass[i], here[EAST].mass[i - 1], here[NORTH].mass[i], south[NORTH].mass[i]];
                let wanted = step_ratio * per_area[i] * outflow(passing);
                (wanted > depth[i]).then(|| (row, i, depth[i].max(0.0) / wanted))
            })
        })
        .collect();
    let is_special = |place| general.is_beside(place) || conforming.is_beside(place);
    for (row, i, share) in short.into_iter().filter(|&(row, i, _)| !is_special((row, i))) {
        sides((row, i)).into_iter().for_each(|side| state.reduce(side, share));
    }
    general.limit_outflow(state, (active, levels), stage, (time_step, of_coarser));
    if levels.start == 0 {
        conforming.limit_outflow(state, stage, time_step);
    }
    if let Some(moving) = moving {
        moving.limit_outflow(state, stage, time_step);
    }
}

/// Water leaving a cell (m²/s) through its faces, given what passes those to the east, west, north and south; inflow not counted.
#[inline(always)]
fn outflow([east, west, north, south]: [f64; 4]) -> f64 {
    (larger(east, 0.0) - smaller(west, 0.0)) + (larger(north, 0.0) - smaller(south, 0.0))
}

/// Whether any cell of a run would give more than it has: rarely so, and then its cells are looked at one by one. A cell without terrain
/// gives what comes over the boundary of the flow: it is not short of it.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn some_are_short(
    (south, here, depth, per_area): (&FluxRow, &FluxRow, &[f64], &[f64]),
    run: &Run,
    step_ratio: f64,
) -> bool {
    let len = run.len();
    let (east, west) = (&here[EAST].mass[run.start..][..len], &here[EAST].mass[run.start - 1..][..len]);
    let (north, from_south) = (&here[NORTH].mass[run.start..][..len], &south[NORTH].mass[run.start..][..len]);
    let (depth, per_area) = (&depth[run.start..][..len], &per_area[run.start..][..len]);
    let mut is_short = false;
    for i in 0..len {
        is_short |= step_ratio * per_area[i] * outflow([east[i], west[i], north[i], from_south[i]]) > depth[i];
    }
    is_short
}
