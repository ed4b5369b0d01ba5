//! The quintic B-spline: `Schoenberg1946`, in this form after `Morris1996`.
//!
//! ```text
//! f(q) = [(3 − q)₊⁵ − 6 (2 − q)₊⁵ + 15 (1 − q)₊⁵] / 66,   k_W = 11/20 (1-D), 231/(239π) (2-D),   support 3
//! ```

use std::f64::consts::PI;

use super::Shape;
use crate::physics::dimension::Dimension;

/// One over the sum of the pieces at q = 0.
const AT_ZERO: f64 = 1.0 / 66.0;

/// The quintic B-spline.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct QuinticSpline;

impl Shape for QuinticSpline {
    const SUPPORT: f64 = 3.0;

    fn new(_: Dimension) -> Self {
        QuinticSpline
    }

    fn sigma(dimension: Dimension) -> f64 {
        match dimension {
            Dimension::One => 0.55,
            Dimension::Two => 231.0 / (239.0 * PI),
        }
    }

    #[inline(always)]
    fn shape(self, q: f64) -> f64 {
        let [a, b, c] = [(3.0 - q).max(0.0), (2.0 - q).max(0.0), (1.0 - q).max(0.0)];
        let fifth = |x: f64| (x * x) * (x * x) * x;
        AT_ZERO * (fifth(a) - 6.0 * fifth(b) + 15.0 * fifth(c))
    }

    #[inline(always)]
    fn slope_shape(self, q: f64) -> f64 {
        let [a, b, c] = [(3.0 - q).max(0.0), (2.0 - q).max(0.0), (1.0 - q).max(0.0)];
        let fourth = |x: f64| (x * x) * (x * x);
        -5.0 * AT_ZERO * (fourth(a) - 6.0 * fourth(b) + 15.0 * fourth(c))
    }
}
