//! Gradients of the particles in work: ∇q_i = Σ_j s_ij (q_j − q_i) e_ij over the four neighbours (M11), here (q_E − q_W)/2Δ
//! and (q_N − q_S)/2Δ.
//!
//! **Dry rule.** When one of a pair is dry (or a film) and its surface lies above the other's, the surface difference of the
//! pair counts as zero: a lake does not feel the hill beside it. A dry particle has no gradient.

use rayon::prelude::*;

use super::Scale;
use super::spans::ActiveSet;
use super::state::{GradientRow, PrimitiveRow, State};

/// The primitive rows south of a row, the row itself and the one north of it.
#[derive(Clone, Copy)]
struct Rows<'a> {
    south: &'a PrimitiveRow,
    here: &'a PrimitiveRow,
    north: &'a PrimitiveRow,
}

/// Fills the gradient rows of all cells in work.
pub(crate) fn evaluate(state: &mut State, active: &ActiveSet, scale: &Scale) {
    let primitive = &state.primitive;
    state.gradient.par_iter_mut().enumerate().with_min_len(4).for_each(|(row, gradient)| {
        for run in &active.work[row] {
            let rows = Rows { south: &primitive[row - 1], here: &primitive[row], north: &primitive[row + 1] };
            row_gradient(rows, (run.start, run.end), scale.spacing, scale.dry_depth, gradient);
        }
    });
}

/// Difference of surface levels after the dry rule.
#[inline(always)]
pub(crate) fn surface_difference(depth_i: f64, surface_i: f64, depth_j: f64, surface_j: f64, dry_depth: f64) -> f64 {
    let difference = surface_j - surface_i;
    let hill = (depth_j <= dry_depth && difference > 0.0) || (depth_i <= dry_depth && difference < 0.0);
    if hill { 0.0 } else { difference }
}

#[multiversion::multiversion(targets("x86_64+avx2", "x86_64+avx512f+avx512vl"))]
fn row_gradient(rows: Rows<'_>, (from, to): (usize, usize), dx: f64, dry: f64, out: &mut GradientRow) {
    let len = to - from;
    let per_two_spacings = 0.5 / dx;
    // Slices of equal length: the neighbours to the west, south, east and north, and the cells themselves.
    macro_rules! star {
        ($field:ident) => {
            (
                &rows.here.$field[from - 1..][..len],
                &rows.south.$field[from..][..len],
                &rows.here.$field[from..][..len],
                &rows.north.$field[from..][..len],
                &rows.here.$field[from + 1..][..len],
            )
        };
    }
    let (depth_w, depth_s, depth, depth_n, depth_e) = star!(depth);
    {
        let (w, s, eta, n, e) = star!(surface);
        let out_x = &mut out.surface_x[from..to];
        let out_y = &mut out.surface_y[from..to];
        for k in 0..len {
            let east = surface_difference(depth[k], eta[k], depth_e[k], e[k], dry);
            let west = surface_difference(depth[k], eta[k], depth_w[k], w[k], dry);
            let north = surface_difference(depth[k], eta[k], depth_n[k], n[k], dry);
            let south = surface_difference(depth[k], eta[k], depth_s[k], s[k], dry);
            let scale = if depth[k] > dry { per_two_spacings } else { 0.0 };
            out_x[k] = scale * (east - west);
            out_y[k] = scale * (north - south);
        }
    }
    macro_rules! plain {
        ($field:ident, $x:ident, $y:ident) => {{
            let (w, s, _, n, e) = star!($field);
            let out_x = &mut out.$x[from..to];
            let out_y = &mut out.$y[from..to];
            for k in 0..len {
                let scale = if depth[k] > dry { per_two_spacings } else { 0.0 };
                out_x[k] = scale * (e[k] - w[k]);
                out_y[k] = scale * (n[k] - s[k]);
            }
        }};
    }
    plain!(depth, depth_x, depth_y);
    plain!(velocity_x, u_x, u_y);
    plain!(velocity_y, v_x, v_y);
}
