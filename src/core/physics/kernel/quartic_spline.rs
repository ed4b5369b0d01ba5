//! The quartic B-spline: `Schoenberg1946`, in this form after `Morris1996`.
//!
//! ```text
//! f(q) = [(5/2 − q)₊⁴ − 5 (3/2 − q)₊⁴ + 10 (1/2 − q)₊⁴] 8/115,   k_W = 115/192 (1-D), 1380/(1199π) (2-D),   support 5/2
//! ```

use std::f64::consts::PI;

use super::Shape;
use crate::physics::dimension::Dimension;

/// One over the sum of the pieces at q = 0.
const AT_ZERO: f64 = 8.0 / 115.0;

/// The quartic B-spline.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct QuarticSpline;

impl Shape for QuarticSpline {
    const SUPPORT: f64 = 2.5;

    fn new(_: Dimension) -> Self {
        QuarticSpline
    }

    fn sigma(dimension: Dimension) -> f64 {
        match dimension {
            Dimension::One => 115.0 / 192.0,
            Dimension::Two => 1380.0 / (1199.0 * PI),
        }
    }

    #[inline(always)]
    fn shape(self, q: f64) -> f64 {
        let [a, b, c] = [(2.5 - q).max(0.0), (1.5 - q).max(0.0), (0.5 - q).max(0.0)];
        let fourth = |x: f64| (x * x) * (x * x);
        AT_ZERO * (fourth(a) - 5.0 * fourth(b) + 10.0 * fourth(c))
    }

    #[inline(always)]
    fn slope_shape(self, q: f64) -> f64 {
        let [a, b, c] = [(2.5 - q).max(0.0), (1.5 - q).max(0.0), (0.5 - q).max(0.0)];
        let third = |x: f64| x * x * x;
        -4.0 * AT_ZERO * (third(a) - 5.0 * third(b) + 10.0 * third(c))
    }
}
