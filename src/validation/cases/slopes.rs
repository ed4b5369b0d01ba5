//! Uniform flow on a long slope with friction.

use crate::math::Vec2;
use crate::physics::dimension::Dimension;
use crate::validation::case::{Case, Setup, Suite, Until};
use crate::validation::exact::normal_velocity;
use crate::validation::scene::{flat_strip, line_seeds};

/// Length of the slope (m).
const LENGTH: f64 = 2000.0;
/// Fall of the bed per metre.
const SLOPE: f64 = 0.05;
/// Manning's n (s·m^(−1/3)).
const ROUGHNESS: f64 = 0.03;
/// Depth (m), everywhere at the start.
pub const DEPTH: f64 = 0.5;
/// Where nothing from the ends of the slope has come (m).
const WINDOW: std::ops::Range<f64> = 900.0..1200.0;
/// Time (s): some ten times what friction needs.
const END: f64 = 40.0;

/// The cases.
pub const CASES: &[Case] = &[Case {
    name: "normal_depth",
    suite: Suite::Analytic,
    about: "Water 0.5 m deep, let go on a slope of 0.05 with n = 0.03, against Manning's velocity after 40 s.",
    is_tuned: true,
    spacings: &[8.0, 4.0, 2.0],
    tested: 2,
    acceptance_limits: &[],
    setup: |spacing, _| Ok(uniform(spacing)),
}];

/// Manning's velocity (m/s) of that depth on that slope.
pub fn velocity() -> f64 {
    normal_velocity(DEPTH, SLOPE, ROUGHNESS)
}

/// Water let go on the slope.
pub fn uniform(spacing: f64) -> Setup {
    let mut problem = flat_strip(LENGTH, spacing, |x| SLOPE * (LENGTH - x));
    problem.bed.manning.fill(ROUGHNESS);
    problem.initial_depth.fill(DEPTH);
    let seeds = line_seeds(&problem);
    let exact = Box::new(|_| (DEPTH, Vec2::new(velocity(), 0.0)));
    let mut setup = Setup::new(problem, seeds, Dimension::One, Until::Time(END), exact);
    setup.counts = Box::new(|place| WINDOW.contains(&place.x));
    setup
}
