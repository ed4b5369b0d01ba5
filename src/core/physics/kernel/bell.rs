//! The bell-shaped kernel: `Lucy1977`.
//!
//! ```text
//! f(q) = (1 + 3q) (1 − q)₊³,   k_W = 5/4 (1-D), 5/π (2-D),   support 1
//! ```

use std::f64::consts::PI;

use super::Shape;
use crate::physics::dimension::Dimension;

/// Lucy's kernel.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct Bell;

impl Shape for Bell {
    const SUPPORT: f64 = 1.0;

    fn new(_: Dimension) -> Self {
        Bell
    }

    fn sigma(dimension: Dimension) -> f64 {
        match dimension {
            Dimension::One => 1.25,
            Dimension::Two => 5.0 / PI,
        }
    }

    #[inline(always)]
    fn shape(self, q: f64) -> f64 {
        let inside = (1.0 - q).max(0.0);
        (1.0 + 3.0 * q) * (inside * inside * inside)
    }

    #[inline(always)]
    fn slope_shape(self, q: f64) -> f64 {
        let inside = (1.0 - q).max(0.0);
        -12.0 * q * (inside * inside)
    }
}
