//! Wendland's kernel of class C4: `Wendland1995`.
//!
//! ```text
//! f(q) = (1 − q/2)₊⁶ (1 + 3q + 35/12 q²),   k_W = 27/32 (1-D), 9/(4π) (2-D),   support 2
//! ```
//!
//! The function for the plane and for space, in one dimension, too.

use std::f64::consts::PI;

use super::Shape;
use crate::physics::dimension::Dimension;

/// Wendland's function ψ₃,₂.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct WendlandC4;

impl Shape for WendlandC4 {
    const SUPPORT: f64 = 2.0;

    fn new(_: Dimension) -> Self {
        WendlandC4
    }

    fn sigma(dimension: Dimension) -> f64 {
        match dimension {
            Dimension::One => 27.0 / 32.0,
            Dimension::Two => 9.0 / (4.0 * PI),
        }
    }

    #[inline(always)]
    fn shape(self, q: f64) -> f64 {
        let inside = (1.0 - 0.5 * q).max(0.0);
        let square = inside * inside;
        (square * square * square) * (1.0 + q * (3.0 + 35.0 / 12.0 * q))
    }

    #[inline(always)]
    fn slope_shape(self, q: f64) -> f64 {
        let inside = (1.0 - 0.5 * q).max(0.0);
        let square = inside * inside;
        -14.0 / 3.0 * q * (1.0 + 2.5 * q) * (square * square * inside)
    }
}
