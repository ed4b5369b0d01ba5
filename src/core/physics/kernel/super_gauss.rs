//! The super-Gaussian: `Monaghan1992`.
//!
//! ```text
//! f(q) = (1 − q²/a) exp(−q²) for q < 3,   a = 1 + dim/2,   support 3
//! k_W = 1/(⅔ √π erf 3 + 2 e⁻⁹) (1-D), 1/(π (½ + 4 e⁻⁹)) (2-D)
//! ```
//!
//! Of fourth order, since its second moment vanishes: it is negative beyond q = √a, and its slope is positive beyond √(1 + a).
//! Cut at q = 3, where f is −6e-4 at most, and normalised as cut.

use std::f64::consts::PI;

use super::Shape;
use super::gauss::ERF_3;
use crate::physics::dimension::Dimension;

/// The super-Gaussian, cut at three smoothing lengths of its own.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct SuperGauss {
    /// 1/a.
    per_zero_squared: f64,
}

impl Shape for SuperGauss {
    const SUPPORT: f64 = 3.0;

    fn new(dimension: Dimension) -> Self {
        SuperGauss { per_zero_squared: 1.0 / (1.0 + 0.5 * dimension.count()) }
    }

    fn sigma(dimension: Dimension) -> f64 {
        let end = (-9.0_f64).exp();
        match dimension {
            Dimension::One => 1.0 / (2.0 / 3.0 * PI.sqrt() * ERF_3 + 2.0 * end),
            Dimension::Two => 1.0 / (PI * (0.5 + 4.0 * end)),
        }
    }

    #[inline(always)]
    fn shape(self, q: f64) -> f64 {
        let square = q * q;
        if q < Self::SUPPORT { (1.0 - self.per_zero_squared * square) * (-square).exp() } else { 0.0 }
    }

    #[inline(always)]
    fn slope_shape(self, q: f64) -> f64 {
        let square = q * q;
        let bracket = 1.0 + self.per_zero_squared * (1.0 - square);
        if q < Self::SUPPORT { -2.0 * q * bracket * (-square).exp() } else { 0.0 }
    }
}
