//! The cubic B-spline: `Monaghan1992`.
//!
//! ```text
//! f(q) = (2 − q)₊³ / 4 − (1 − q)₊³,   k_W = 2/3 (1-D), 10/(7π) (2-D),   support 2
//! ```
//!
//! The form with positive parts has no branch and equals the usual two pieces.

use std::f64::consts::PI;

use super::Shape;
use crate::math::larger;
use crate::physics::dimension::Dimension;

/// The cubic B-spline, whose smoothing length is that of all kernels.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct CubicSpline;

impl Shape for CubicSpline {
    const SUPPORT: f64 = 2.0;
    const IS_REFERENCE: bool = true;

    fn new(_: Dimension) -> Self {
        CubicSpline
    }

    fn sigma(dimension: Dimension) -> f64 {
        match dimension {
            Dimension::One => 2.0 / 3.0,
            Dimension::Two => 10.0 / (7.0 * PI),
        }
    }

    #[inline(always)]
    fn shape(self, q: f64) -> f64 {
        let outer = larger(2.0 - q, 0.0);
        let inner = larger(1.0 - q, 0.0);
        0.25 * outer * outer * outer - inner * inner * inner
    }

    #[inline(always)]
    fn slope_shape(self, q: f64) -> f64 {
        let outer = larger(2.0 - q, 0.0);
        let inner = larger(1.0 - q, 0.0);
        3.0 * inner * inner - 0.75 * outer * outer
    }
}
