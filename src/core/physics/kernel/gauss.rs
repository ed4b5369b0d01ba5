//! The Gaussian: `GingoldMonaghan1977`.
//!
//! ```text
//! f(q) = exp(−q²) for q < 3,   k_W = 1/(√π erf 3) (1-D), 1/(π (1 − e⁻⁹)) (2-D),   support 3
//! ```
//!
//! Cut at q = 3, where it has fallen to e⁻⁹ = 1.2e-4, and normalised as cut.

use std::f64::consts::PI;

use super::Shape;
use crate::physics::dimension::Dimension;

/// erf 3, the error function.
pub(super) const ERF_3: f64 = 0.999_977_909_503_001_4;

/// The Gaussian, cut at three smoothing lengths of its own.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct Gauss;

impl Shape for Gauss {
    const SUPPORT: f64 = 3.0;

    fn new(_: Dimension) -> Self {
        Gauss
    }

    fn sigma(dimension: Dimension) -> f64 {
        match dimension {
            Dimension::One => 1.0 / (PI.sqrt() * ERF_3),
            Dimension::Two => 1.0 / (PI * (1.0 - (-9.0_f64).exp())),
        }
    }

    #[inline(always)]
    fn shape(self, q: f64) -> f64 {
        if q < Self::SUPPORT { (-q * q).exp() } else { 0.0 }
    }

    #[inline(always)]
    fn slope_shape(self, q: f64) -> f64 {
        -2.0 * q * self.shape(q)
    }
}
