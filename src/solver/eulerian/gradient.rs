//! Gradients of the particles in work: ∇q_i = Σ_j s_ij (q_j − q_i) e_ij over the eight neighbours (M11).
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
    let axis = 0.5 * scale.weights.axis;
    let diagonal = 0.5 * scale.weights.diagonal * std::f64::consts::FRAC_1_SQRT_2;
    state.gradient.par_iter_mut().enumerate().with_min_len(4).for_each(|(row, gradient)| {
        for run in &active.work[row] {
            let rows = Rows { south: &primitive[row - 1], here: &primitive[row], north: &primitive[row + 1] };
            row_gradient(rows, (run.start, run.end), axis, diagonal, scale.dry_depth, gradient);
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
fn row_gradient(rows: Rows<'_>, (from, to): (usize, usize), axis: f64, diagonal: f64, dry: f64, out: &mut GradientRow) {
    let len = to - from;
    // Slices of equal length, shifted by one column west, none, and east.
    macro_rules! shifted {
        ($field:ident, $offset:expr) => {
            (
                &rows.south.$field[from + $offset - 1..][..len],
                &rows.here.$field[from + $offset - 1..][..len],
                &rows.north.$field[from + $offset - 1..][..len],
            )
        };
    }
    let (depth_sw, depth_w, depth_nw) = shifted!(depth, 0);
    let (depth_s, depth_c, depth_n) = shifted!(depth, 1);
    let (depth_se, depth_e, depth_ne) = shifted!(depth, 2);
    {
        let (sw, w, nw) = shifted!(surface, 0);
        let (s, c, n) = shifted!(surface, 1);
        let (se, e, ne) = shifted!(surface, 2);
        let out_x = &mut out.surface_x[from..to];
        let out_y = &mut out.surface_y[from..to];
        for k in 0..len {
            let (d, eta) = (depth_c[k], c[k]);
            let east = surface_difference(d, eta, depth_e[k], e[k], dry);
            let west = surface_difference(d, eta, depth_w[k], w[k], dry);
            let north = surface_difference(d, eta, depth_n[k], n[k], dry);
            let south = surface_difference(d, eta, depth_s[k], s[k], dry);
            let north_east = surface_difference(d, eta, depth_ne[k], ne[k], dry);
            let south_west = surface_difference(d, eta, depth_sw[k], sw[k], dry);
            let north_west = surface_difference(d, eta, depth_nw[k], nw[k], dry);
            let south_east = surface_difference(d, eta, depth_se[k], se[k], dry);
            let wet = if d > dry { 1.0 } else { 0.0 };
            let (rising, falling) = (north_east - south_west, south_east - north_west);
            out_x[k] = wet * (axis * (east - west) + diagonal * (rising + falling));
            out_y[k] = wet * (axis * (north - south) + diagonal * (rising - falling));
        }
    }
    macro_rules! plain {
        ($field:ident, $x:ident, $y:ident) => {{
            let (sw, w, nw) = shifted!($field, 0);
            let (s, _, n) = shifted!($field, 1);
            let (se, e, ne) = shifted!($field, 2);
            let out_x = &mut out.$x[from..to];
            let out_y = &mut out.$y[from..to];
            for k in 0..len {
                let wet = if depth_c[k] > dry { 1.0 } else { 0.0 };
                let (rising, falling) = (ne[k] - sw[k], se[k] - nw[k]);
                out_x[k] = wet * (axis * (e[k] - w[k]) + diagonal * (rising + falling));
                out_y[k] = wet * (axis * (n[k] - s[k]) + diagonal * (rising - falling));
            }
        }};
    }
    plain!(depth, depth_x, depth_y);
    plain!(velocity_x, u_x, u_y);
    plain!(velocity_y, v_x, v_y);
}
