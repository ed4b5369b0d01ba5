//! Gradients of the active particles: ∇X_i = Σ_j Γ_ij (X_j − X_i) e_ij over the four neighbours (M18), here (X_E − X_W)/2Δ
//! and (X_N − X_S)/2Δ.
//!
//! **Dry rule.** When one of a pair is dry (or a film) and its surface lies above the other's, the surface difference of the
//! pair counts as zero: a lake does not feel the hill beside it. A dry particle has no gradient.

use rayon::prelude::*;

use super::Scale;
use super::spans::ActiveSet;
use super::state::{GradientRow, GroundRow, PrimitiveRow, State};
use crate::math::{Vec2, larger};

/// The rows south of a row, the row itself and the one north of it.
#[derive(Clone, Copy)]
struct Rows<'a, Row> {
    south: &'a Row,
    here: &'a Row,
    north: &'a Row,
}

impl<'a, Row> Rows<'a, Row> {
    fn around(all: &'a [Row], row: usize) -> Self {
        Rows { south: &all[row - 1], here: &all[row], north: &all[row + 1] }
    }

    /// A row whose cells have themselves for neighbours to the south and north.
    fn alone(row: &'a Row) -> Self {
        Rows { south: row, here: row, north: row }
    }
}

/// Fills the gradient rows of all active cells.
pub(crate) fn evaluate(state: &mut State, active: &ActiveSet, scale: &Scale) {
    let (primitive, ground, spacing) = (&state.primitive, &state.ground, &state.spacing);
    active.rows_of(&mut state.gradient).for_each(|(row, gradient)| {
        for run in active.pieces_of_squares(row) {
            let (water, ground) = (Rows::around(primitive, row), Rows::around(ground, row));
            row_gradient(water, ground, (run.start, run.end), spacing[row], scale.dry_depth, gradient);
        }
    });
}

/// The same along a lone row, for cells that have a neighbour on either side.
pub(super) fn along(
    water: &PrimitiveRow,
    ground: &GroundRow,
    cells: (usize, usize),
    scale: &Scale,
    out: &mut GradientRow,
) {
    let (water, ground) = (Rows::alone(water), Rows::alone(ground));
    row_gradient(water, ground, cells, scale.spacing, scale.dry_depth, out);
}

/// Difference of surface levels (m) after the dry rule, between particles of which depth and bed elevation (m) are given. The
/// levels are summed first: those of a lake at rest are then equal to the last digit.
#[inline(always)]
pub(crate) fn surface_difference((depth_i, bed_i): (f64, f64), (depth_j, bed_j): (f64, f64), dry_depth: f64) -> f64 {
    let difference = (bed_j + depth_j) - (bed_i + depth_i);
    let hill = (depth_j <= dry_depth && difference > 0.0) || (depth_i <= dry_depth && difference < 0.0);
    if hill { 0.0 } else { difference }
}

/// The same over a sill (m) between both, which cuts off what lies below it (M26).
#[inline(always)]
pub(crate) fn difference_over_sill(
    (depth_i, bed_i): (f64, f64),
    (depth_j, bed_j): (f64, f64),
    sill: f64,
    dry_depth: f64,
) -> f64 {
    let difference = larger(bed_j + depth_j, sill) - larger(bed_i + depth_i, sill);
    let hill = (depth_j <= dry_depth && difference > 0.0) || (depth_i <= dry_depth && difference < 0.0);
    if hill { 0.0 } else { difference }
}

/// The determinant of what banks leave of a gradient, below which it is not solved for: banks all around.
const LEAST_KEPT: f64 = 0.2;

/// The gradient of the surface of which `found` is what faces without a bank make of it; `kept` are the rows of the matrix that they leave (M97).
pub(super) fn without_banks(kept: [Vec2; 2], found: Vec2) -> Vec2 {
    let determinant = kept[0].cross(kept[1]);
    if determinant <= LEAST_KEPT {
        return found;
    }
    let Vec2 { x, y } = found;
    Vec2::new(kept[1].y * x - kept[0].y * y, kept[0].x * y - kept[1].x * x) * (1.0 / determinant)
}

#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn row_gradient(
    water: Rows<'_, PrimitiveRow>,
    ground: Rows<'_, GroundRow>,
    (from, to): (usize, usize),
    dx: f64,
    dry: f64,
    out: &mut GradientRow,
) {
    let len = to - from;
    let per_two_spacings = 0.5 / dx;
    // Slices of equal length: the neighbours to the west, south, east and north, and the cells themselves.
    macro_rules! star {
        ($rows:ident, $field:ident) => {
            (
                &$rows.here.$field[from - 1..][..len],
                &$rows.south.$field[from..][..len],
                &$rows.here.$field[from..][..len],
                &$rows.north.$field[from..][..len],
                &$rows.here.$field[from + 1..][..len],
            )
        };
    }
    let (depth_w, depth_s, depth, depth_n, depth_e) = star!(water, depth);
    {
        let (w, s, bed, n, e) = star!(ground, bed);
        let out_x = &mut out.surface_x[from..to];
        let out_y = &mut out.surface_y[from..to];
        for k in 0..len {
            let east = surface_difference((depth[k], bed[k]), (depth_e[k], e[k]), dry);
            let west = surface_difference((depth[k], bed[k]), (depth_w[k], w[k]), dry);
            let north = surface_difference((depth[k], bed[k]), (depth_n[k], n[k]), dry);
            let south = surface_difference((depth[k], bed[k]), (depth_s[k], s[k]), dry);
            let scale = if depth[k] > dry { per_two_spacings } else { 0.0 };
            out_x[k] = scale * (east - west);
            out_y[k] = scale * (north - south);
        }
    }
    macro_rules! plain {
        ($field:ident, $x:ident, $y:ident) => {{
            let (w, s, here, n, e) = star!(water, $field);
            let out_x = &mut out.$x[from..to];
            let out_y = &mut out.$y[from..to];
            for k in 0..len {
                let scale = if depth[k] > dry { per_two_spacings } else { 0.0 };
                out_x[k] = scale * ((e[k] - here[k]) - (w[k] - here[k]));
                out_y[k] = scale * ((n[k] - here[k]) - (s[k] - here[k]));
            }
        }};
    }
    plain!(depth, depth_x, depth_y);
    plain!(velocity_x, u_x, u_y);
    plain!(velocity_y, v_x, v_y);
}
