//! Smoothing kernels: each one a shape f(q) with f(0) = 1, its support and its factor in one and two dimensions.
//!
//! ```text
//! W(r, h) = k_W / (k_s h)^dim f(r / (k_s h))
//! ```
//!
//! The literature gives every kernel a smoothing length of its own. Here h is that of the cubic spline for all of them, so that
//! time steps, viscosities and the gridding mean the same length; another kernel is stretched by k_s until its second moment
//! is that of the cubic spline, as `DehnenAly2012` compare kernels:
//!
//! ```text
//! k_s² = spread²(cubic) / spread²(f),   spread²(f) = ∫ q² |f| dV / ∫ |f| dV
//! ```
//!
//! The magnitude |f| stands there for the super-Gaussian, whose second moment is 0. In the letters of the literature a kernel
//! has the smoothing factor k_s k_h, with the k_h of the cubic spline.

mod bell;
mod cubic_spline;
mod gauss;
mod quadratic;
mod quartic_spline;
mod quintic_spline;
mod super_gauss;
#[cfg(test)]
mod tests;
mod wendland_c2;
mod wendland_c4;

pub use bell::Bell;
pub use cubic_spline::CubicSpline;
pub use gauss::Gauss;
pub use quadratic::Quadratic;
pub use quartic_spline::QuarticSpline;
pub use quintic_spline::QuinticSpline;
pub use super_gauss::SuperGauss;
pub use wendland_c2::WendlandC2;
pub use wendland_c4::WendlandC4;

use super::dimension::Dimension;

/// A kernel without its length and its factor.
pub trait Shape: Copy {
    /// The argument q at which the support ends.
    const SUPPORT: f64;
    /// Whether the smoothing length is that of this shape, so that it needs no stretching.
    const IS_REFERENCE: bool = false;

    /// The shape in the given dimension.
    fn new(dimension: Dimension) -> Self;

    /// k_W, by which the integral of k_W f is 1 in the given dimension.
    fn sigma(dimension: Dimension) -> f64;

    /// f(q) for q of 0 or more: 1 at 0, 0 beyond the support.
    fn shape(self, q: f64) -> f64;

    /// f'(q).
    fn slope_shape(self, q: f64) -> f64;
}

/// A kernel in a given dimension, a function of the distance and of 1/h.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct Smoothing<S> {
    shape: S,
    sigma: f64,
    // h^(−dim) = inverse_h (constant + linear · inverse_h), without a branch.
    constant: f64,
    linear: f64,
    stretch: f64,
    per_stretch: f64,
}

impl<S: Shape> Smoothing<S> {
    /// The kernel, normalised for the given dimension.
    pub fn new(dimension: Dimension) -> Self {
        let stretch = if S::IS_REFERENCE { 1.0 } else { spread::<CubicSpline>(dimension) / spread::<S>(dimension) };
        let (constant, linear, volume) = match dimension {
            Dimension::One => (1.0, 0.0, stretch),
            Dimension::Two => (0.0, 1.0, stretch * stretch),
        };
        let sigma = S::sigma(dimension) / volume;
        Smoothing { shape: S::new(dimension), sigma, constant, linear, stretch, per_stretch: 1.0 / stretch }
    }

    /// The same so that Σ A W is 1 on the square lattice of particles of area A with h = `factor` √A, where the integral of the kernel makes it
    /// nearly so (in one dimension 0.2 % off for the cubic spline, 10 % for `Quadratic` with its kink in the middle).
    pub fn on_lattice(self, dimension: Dimension, factor: f64) -> Self {
        let reach = (factor * self.support()).ceil() as i32;
        let rows = if dimension == Dimension::One { 0..=0 } else { -reach..=reach };
        let places = rows.flat_map(|row| (-reach..=reach).map(move |column| f64::from(row * row + column * column)));
        let sum: f64 = places.map(|squared| self.value(squared.sqrt(), 1.0 / factor)).sum();
        Smoothing { sigma: self.sigma / sum, ..self }
    }

    /// s: the kernel's own smoothing length over h.
    pub fn stretch(&self) -> f64 {
        self.stretch
    }

    /// Radius of the support in smoothing lengths h.
    pub fn support(&self) -> f64 {
        self.stretch * S::SUPPORT
    }

    /// W(0) (m^−dim) for 1/h (1/m).
    #[inline(always)]
    pub fn at_zero(&self, inverse_h: f64) -> f64 {
        self.sigma * inverse_h * (self.constant + self.linear * inverse_h)
    }

    #[inline(always)]
    fn stretched(&self, value: f64) -> f64 {
        if S::IS_REFERENCE { value } else { value * self.per_stretch }
    }

    /// W over its value at r = 0, at distance `r` (m) for 1/h (1/m).
    #[inline(always)]
    pub fn share(&self, r: f64, inverse_h: f64) -> f64 {
        self.shape.shape(self.stretched(r * inverse_h))
    }

    /// W (m^−dim) at distance `r` (m) for 1/h (1/m).
    #[inline(always)]
    pub fn value(&self, r: f64, inverse_h: f64) -> f64 {
        self.at_zero(inverse_h) * self.share(r, inverse_h)
    }

    /// dW/dr (m^(−dim−1)) at distance `r` (m) for 1/h (1/m).
    #[inline(always)]
    pub fn slope(&self, r: f64, inverse_h: f64) -> f64 {
        let q = self.stretched(r * inverse_h);
        self.at_zero(inverse_h) * self.stretched(inverse_h) * self.shape.slope_shape(q)
    }
}

/// √(∫ q² |f| dV / ∫ |f| dV), by the midpoint rule; its error is below 1e-7.
fn spread<S: Shape>(dimension: Dimension) -> f64 {
    const CELLS: u32 = 4000;
    let shape = S::new(dimension);
    let (mut moment, mut total) = (0.0, 0.0);
    for k in 0..CELLS {
        let q = (f64::from(k) + 0.5) * S::SUPPORT / f64::from(CELLS);
        let shell = match dimension {
            Dimension::One => 1.0,
            Dimension::Two => q,
        };
        let weight = shape.shape(q).abs() * shell;
        total += weight;
        moment += weight * q * q;
    }
    (moment / total).sqrt()
}
