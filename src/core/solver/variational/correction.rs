//! The correction matrix of sums over neighbours: the inverse of their first moment where there is one.
//!
//! ```text
//! L = f(M),   f(λ) = 1/λ for λ ≥ 0.45, else 1 + (1/0.45 − 1) λ/0.45
//! ```
//!
//! Where neighbours are too few for an inverse, f goes to 1, so that a lonely particle amplifies nothing.

use crate::math::Sym2;

/// Eigenvalues of M below this are too small to be inverted.
const LEAST_EIGENVALUE: f64 = 0.45;

#[inline]
fn inverse_eigenvalue(lambda: f64) -> f64 {
    if lambda >= LEAST_EIGENVALUE {
        1.0 / lambda
    } else {
        1.0 + (1.0 / LEAST_EIGENVALUE - 1.0) * lambda / LEAST_EIGENVALUE
    }
}

/// Whether the correction of a moment is its inverse.
#[inline]
pub fn is_inverted(moment: Sym2) -> bool {
    // Without a root: what is left of the matrix has no negative eigenvalue.
    let (xx, yy) = (moment.xx - LEAST_EIGENVALUE, moment.yy - LEAST_EIGENVALUE);
    xx + yy >= 0.0 && xx * yy >= moment.xy * moment.xy
}

/// L = f(M): f applied to the eigenvalues of a symmetric matrix.
#[inline]
pub fn correction(moment: Sym2) -> Sym2 {
    if is_inverted(moment) {
        let per_determinant = 1.0 / moment.determinant();
        let Sym2 { xx, xy, yy } = moment;
        return Sym2 { xx: yy * per_determinant, xy: -xy * per_determinant, yy: xx * per_determinant };
    }
    bounded(moment)
}

/// L where an eigenvalue is too small to be inverted.
#[cold]
fn bounded(moment: Sym2) -> Sym2 {
    let (small, large) = moment.eigenvalues();
    let (f_small, f_large) = (inverse_eigenvalue(small), inverse_eigenvalue(large));
    let spread = large - small;
    // L = a I + b M takes both eigenvalues where they should go; equal ones need no b.
    let b = if spread > 1e-12 { (f_large - f_small) / spread } else { 0.0 };
    let a = f_small - b * small;
    Sym2 { xx: a + b * moment.xx, xy: b * moment.xy, yy: a + b * moment.yy }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values that are exact in binary")]
mod tests {
    use super::*;
    use crate::math::Vec2;

    #[test]
    fn correction_inverts_and_stays_bounded() {
        let moment = Sym2 { xx: 0.9, xy: 0.2, yy: 0.8 };
        let inverse = correction(moment);
        let back = moment.apply(inverse.apply(Vec2::new(1.0, -2.0)));
        assert!((back - Vec2::new(1.0, -2.0)).norm() < 1e-14);
        assert!(is_inverted(moment) && !is_inverted(Sym2 { yy: 0.4, ..moment }));
        let lonely = correction(Sym2 { xx: 1e-6, xy: 0.0, yy: 0.0 });
        assert!(lonely.xx < 1.01 && lonely.yy == 1.0);
        assert!((inverse_eigenvalue(0.45) - inverse_eigenvalue(0.45 - 1e-12)).abs() < 1e-10);
    }
}
