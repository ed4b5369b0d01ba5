//! The cubic B-spline kernel in one and two dimensions: `Monaghan1992`.
//!
//! ```text
//! W(r, h) = σ / h^dim f(q),   q = r/h,   f(q) = (2 − q)₊³ / 4 − (1 − q)₊³,   σ = 2/3 (1-D), 10/(7π) (2-D)
//! ```
//!
//! The form with positive parts has no branch and equals the usual two pieces.

use crate::physics::dimension::Dimension;

/// The cubic B-spline; its support ends at r = 2h.
#[derive(Clone, Copy, Debug)]
pub struct CubicSpline {
    sigma: f64,
    // h^(−dim) = inverse_h (constant + linear · inverse_h), without a branch.
    constant: f64,
    linear: f64,
}

impl CubicSpline {
    /// Radius of the support in smoothing lengths.
    pub const SUPPORT: f64 = 2.0;

    /// The kernel, normalised for the given dimension.
    pub fn new(dimension: Dimension) -> Self {
        match dimension {
            Dimension::One => CubicSpline { sigma: 2.0 / 3.0, constant: 1.0, linear: 0.0 },
            Dimension::Two => CubicSpline { sigma: 10.0 / (7.0 * std::f64::consts::PI), constant: 0.0, linear: 1.0 },
        }
    }

    /// f(q), 1 at q = 0.
    #[inline(always)]
    pub fn shape(q: f64) -> f64 {
        let outer = (2.0 - q).max(0.0);
        let inner = (1.0 - q).max(0.0);
        0.25 * outer * outer * outer - inner * inner * inner
    }

    #[inline(always)]
    fn norm(&self, inverse_h: f64) -> f64 {
        self.sigma * inverse_h * (self.constant + self.linear * inverse_h)
    }

    /// W (m^−dim) at distance `r` (m) for 1/h (1/m).
    #[inline(always)]
    pub fn value(&self, r: f64, inverse_h: f64) -> f64 {
        self.norm(inverse_h) * Self::shape(r * inverse_h)
    }

    /// dW/dr (m^(−dim−1)), 0 or negative, at distance `r` (m) for 1/h (1/m).
    #[inline(always)]
    pub fn slope(&self, r: f64, inverse_h: f64) -> f64 {
        let q = r * inverse_h;
        let outer = (2.0 - q).max(0.0);
        let inner = (1.0 - q).max(0.0);
        self.norm(inverse_h) * inverse_h * (3.0 * inner * inner - 0.75 * outer * outer)
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values that are exact in binary")]
mod tests {
    use super::*;

    fn integral(dimension: Dimension, h: f64) -> f64 {
        let kernel = CubicSpline::new(dimension);
        let cells = 20_000;
        let dr = 2.0 * h / f64::from(cells);
        (0..cells)
            .map(|k| {
                let r = (f64::from(k) + 0.5) * dr;
                let shell = match dimension {
                    Dimension::One => 2.0,
                    Dimension::Two => 2.0 * std::f64::consts::PI * r,
                };
                kernel.value(r, 1.0 / h) * shell * dr
            })
            .sum()
    }

    #[test]
    fn integrates_to_one() {
        for h in [0.3, 1.0, 17.0] {
            for dimension in [Dimension::One, Dimension::Two] {
                // Midpoint rule with 20 000 cells on a piecewise cubic: error below 1e-8.
                assert!((integral(dimension, h) - 1.0).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn slope_is_the_derivative() {
        for dimension in [Dimension::One, Dimension::Two] {
            let kernel = CubicSpline::new(dimension);
            for r in [0.1, 0.7, 1.1, 1.9, 2.3, 2.5] {
                let step = 1e-5;
                let difference = (kernel.value(r + step, 0.8) - kernel.value(r - step, 0.8)) / (2.0 * step);
                assert!((difference - kernel.slope(r, 0.8)).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn has_the_two_pieces_of_the_textbook() {
        assert_eq!(CubicSpline::shape(0.0), 1.0);
        assert!((CubicSpline::shape(0.5) - (1.0 - 1.5 * 0.25 + 0.75 * 0.125)).abs() < 1e-15);
        assert!((CubicSpline::shape(1.5) - 0.25 * 0.125).abs() < 1e-15);
        assert_eq!(CubicSpline::shape(2.0), 0.0);
    }
}
