//! Wendland's kernel of class C2: `Wendland1995`.
//!
//! ```text
//! f(q) = (1 − q/2)₊⁴ (1 + 2q),   k_W = 3/4 (1-D), 7/(4π) (2-D),   support 2
//! ```
//!
//! This is the function for the plane and for space. In one dimension it is taken, too: the one for the line would be Lucy's.

use std::f64::consts::PI;

use super::Shape;
use crate::physics::dimension::Dimension;

/// Wendland's function ψ₃,₁.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct WendlandC2;

impl Shape for WendlandC2 {
    const SUPPORT: f64 = 2.0;

    fn new(_: Dimension) -> Self {
        WendlandC2
    }

    fn sigma(dimension: Dimension) -> f64 {
        match dimension {
            Dimension::One => 0.75,
            Dimension::Two => 7.0 / (4.0 * PI),
        }
    }

    #[inline(always)]
    fn shape(self, q: f64) -> f64 {
        let inside = (1.0 - 0.5 * q).max(0.0);
        let square = inside * inside;
        (square * square) * (1.0 + 2.0 * q)
    }

    #[inline(always)]
    fn slope_shape(self, q: f64) -> f64 {
        let inside = (1.0 - 0.5 * q).max(0.0);
        -5.0 * q * (inside * inside * inside)
    }
}
