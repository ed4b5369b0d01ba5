//! The quadratic kernel: `Johnson1996`.
//!
//! ```text
//! f(q) = (1 − q/2)₊²,   k_W = 3/4 (1-D), 3/(2π) (2-D),   support 2
//! ```
//!
//! Its slope does not vanish at q = 0, so that particles that come close go on repelling each other; the price is a kink of W there.

use std::f64::consts::PI;

use super::Shape;
use crate::physics::dimension::Dimension;

/// The quadratic kernel.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct Quadratic;

impl Shape for Quadratic {
    const SUPPORT: f64 = 2.0;

    fn new(_: Dimension) -> Self {
        Quadratic
    }

    fn sigma(dimension: Dimension) -> f64 {
        match dimension {
            Dimension::One => 0.75,
            Dimension::Two => 1.5 / PI,
        }
    }

    #[inline(always)]
    fn shape(self, q: f64) -> f64 {
        let inside = (1.0 - 0.5 * q).max(0.0);
        inside * inside
    }

    #[inline(always)]
    fn slope_shape(self, q: f64) -> f64 {
        -(1.0 - 0.5 * q).max(0.0)
    }
}
