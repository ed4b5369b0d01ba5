//! Small fits: the solution of their equations, and how far a fitted height may leave its samples.

use crate::math::{Sym2, Vec2};

/// Moments of neighbours on a lattice are either zero or at least as large as the smallest weight (about 1e-3 of the
/// largest); what lies below this fraction is rounding.
pub(super) const SINGULAR: f64 = 1e-9;

/// A fitted height that leaves the range of the samples by as much as the fit deserves; `fitted` are the samples, each with
/// what the fit makes of it.
pub(super) fn bounded_by(height: f64, fitted: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut lowest, mut highest, mut residual) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
    for (elevation, fit) in fitted {
        lowest = lowest.min(elevation);
        highest = highest.max(elevation);
        residual = residual.max((elevation - fit).abs());
    }
    bounded(height, (lowest, highest), residual)
}

/// A fitted height, of which what lies beyond a range is reduced by the largest residual of the fit: nothing for a plane.
pub(super) fn bounded(height: f64, (lowest, highest): (f64, f64), residual: f64) -> f64 {
    let within = height.clamp(lowest, highest);
    let beyond = height - within;
    within + beyond.signum() * (beyond.abs() - residual).max(0.0)
}

/// The solution of `matrix` x = `right` for a regular matrix.
pub(super) fn solve(matrix: Sym2, right: Vec2) -> Vec2 {
    Sym2 { xx: matrix.yy, xy: -matrix.xy, yy: matrix.xx }.apply(right) / matrix.determinant()
}

/// Solves a symmetric system, given by its lower triangle, by Cholesky's method; `None` when it is singular.
pub(super) fn solve_cholesky<const N: usize>(mut matrix: [[f64; N]; N], mut right: [f64; N]) -> Option<[f64; N]> {
    for i in 0..N {
        let diagonal = matrix[i][i];
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum();
            let rest = matrix[i][j] - known;
            matrix[i][j] = if j < i {
                rest / matrix[j][j]
            } else if rest > SINGULAR * diagonal {
                rest.sqrt()
            } else {
                return None;
            };
        }
        let known: f64 = (0..i).map(|k| matrix[i][k] * right[k]).sum();
        right[i] = (right[i] - known) / matrix[i][i];
    }
    for i in (0..N).rev() {
        let known: f64 = (i + 1..N).map(|k| matrix[k][i] * right[k]).sum();
        right[i] = (right[i] - known) / matrix[i][i];
    }
    Some(right)
}
