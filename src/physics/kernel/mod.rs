//! Smoothing kernels.

mod cubic_spline;

pub use cubic_spline::CubicSpline;
