//! The kernel that a run has chosen. Loops over neighbours are written once for any kernel and compiled for each; which of them
//! runs is decided before the loop.

use crate::methods::Kernel;
use crate::physics::dimension::Dimension;
use crate::physics::kernel::{
    Bell, CubicSpline, Gauss, Quadratic, QuarticSpline, QuinticSpline, Shape, Smoothing, SuperGauss, WendlandC2,
    WendlandC4,
};

/// k_h of h = k_h A^(1/dim): 1.2 in one dimension and 1.5 in two, where 1.2 cannot tell jitter from an edge.
pub fn smoothing_factor(dimension: Dimension) -> f64 {
    match dimension {
        Dimension::One => 1.2,
        Dimension::Two => 1.5,
    }
}

/// One of the kernels, normalised on the lattice that particles are laid on.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
#[expect(missing_docs, reason = "the names are those of the registry")]
pub enum ChosenKernel {
    CubicSpline(Smoothing<CubicSpline>),
    Quadratic(Smoothing<Quadratic>),
    QuarticSpline(Smoothing<QuarticSpline>),
    QuinticSpline(Smoothing<QuinticSpline>),
    Gauss(Smoothing<Gauss>),
    SuperGauss(Smoothing<SuperGauss>),
    Bell(Smoothing<Bell>),
    WendlandC2(Smoothing<WendlandC2>),
    WendlandC4(Smoothing<WendlandC4>),
}

/// Evaluates an expression once for the chosen kernel, as a value of its own type: `with_kernel!(chosen, kernel => …)`.
macro_rules! with_kernel {
    ($chosen:expr, $kernel:ident => $body:expr) => {{
        use $crate::solver::variational::ChosenKernel;
        match $chosen {
            ChosenKernel::CubicSpline($kernel) => $body,
            ChosenKernel::Quadratic($kernel) => $body,
            ChosenKernel::QuarticSpline($kernel) => $body,
            ChosenKernel::QuinticSpline($kernel) => $body,
            ChosenKernel::Gauss($kernel) => $body,
            ChosenKernel::SuperGauss($kernel) => $body,
            ChosenKernel::Bell($kernel) => $body,
            ChosenKernel::WendlandC2($kernel) => $body,
            ChosenKernel::WendlandC4($kernel) => $body,
        }
    }};
}
pub(in crate::solver) use with_kernel;

impl ChosenKernel {
    /// The kernel of that name in the given dimension.
    pub fn new(kernel: Kernel, dimension: Dimension) -> Self {
        fn of<S: Shape>(dimension: Dimension) -> Smoothing<S> {
            Smoothing::new(dimension).on_lattice(dimension, smoothing_factor(dimension))
        }
        match kernel {
            Kernel::CubicSpline => ChosenKernel::CubicSpline(of(dimension)),
            Kernel::Quadratic => ChosenKernel::Quadratic(of(dimension)),
            Kernel::QuarticSpline => ChosenKernel::QuarticSpline(of(dimension)),
            Kernel::QuinticSpline => ChosenKernel::QuinticSpline(of(dimension)),
            Kernel::Gauss => ChosenKernel::Gauss(of(dimension)),
            Kernel::SuperGauss => ChosenKernel::SuperGauss(of(dimension)),
            Kernel::Bell => ChosenKernel::Bell(of(dimension)),
            Kernel::WendlandC2 => ChosenKernel::WendlandC2(of(dimension)),
            Kernel::WendlandC4 => ChosenKernel::WendlandC4(of(dimension)),
        }
    }

    /// W (m^−dim) at distance `r` (m) for 1/h (1/m); for single pairs.
    pub fn value(&self, r: f64, inverse_h: f64) -> f64 {
        with_kernel!(self, kernel => kernel.value(r, inverse_h))
    }

    /// λ = −Σ A r W'/dim over the lattice on which the kernel is normalised; the integral of the kernel makes it nearly 1.
    pub fn lattice_moment(&self, dimension: Dimension) -> f64 {
        let factor = smoothing_factor(dimension);
        let reach = (factor * self.support()).ceil() as i32;
        let rows = if dimension == Dimension::One { 0..=0 } else { -reach..=reach };
        let places = rows.flat_map(|row| (-reach..=reach).map(move |column| f64::from(row * row + column * column)));
        let sum: f64 =
            places.map(f64::sqrt).map(|r| r * with_kernel!(self, kernel => kernel.slope(r, 1.0 / factor))).sum();
        -sum / dimension.count()
    }

    /// Radius of the support in smoothing lengths.
    pub fn support(&self) -> f64 {
        with_kernel!(self, kernel => kernel.support())
    }
}
