//! Riemann solvers for a face that moves with the water: no volume passes, and only p* and u* between the waves are asked for.

use super::side::Side;
use super::{lax_friedrichs, two_shock, two_waves};

/// A way to find the state between two others. Without branches, so that it runs in lanes; what it gives beside a dry side is
/// meaningless and must be left out by the caller.
pub trait FaceSolver {
    /// p* (m³/s²), 0 or more, and u* (m/s).
    fn star(left: Side, right: Side, gravity: f64) -> (f64, f64);
}

/// Two shocks or two rarefactions: `two_shock`.
#[derive(Clone, Copy, Debug)]
pub struct TwoShocks;

/// Two waves at the speeds of Toro for HLLC: `two_waves`.
#[derive(Clone, Copy, Debug)]
pub struct TwoWaves;

/// Both waves at the greatest speed: `lax_friedrichs`.
#[derive(Clone, Copy, Debug)]
pub struct LaxFriedrichs;

impl FaceSolver for TwoShocks {
    #[inline(always)]
    fn star(left: Side, right: Side, gravity: f64) -> (f64, f64) {
        two_shock::star(left, right, gravity)
    }
}

impl FaceSolver for TwoWaves {
    #[inline(always)]
    fn star(left: Side, right: Side, gravity: f64) -> (f64, f64) {
        two_waves::star(left, right, gravity)
    }
}

impl FaceSolver for LaxFriedrichs {
    #[inline(always)]
    fn star(left: Side, right: Side, gravity: f64) -> (f64, f64) {
        lax_friedrichs::star(left, right, gravity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::celerity;
    use crate::physics::flux::exact::ExactRiemann;
    use proptest::prelude::*;

    const G: f64 = 9.81;

    fn side(d: f64, u: f64) -> Side {
        Side { d, c: celerity(d, G), u }
    }

    type Solver = fn(Side, Side, f64) -> (f64, f64);

    const ALL: [(&str, Solver); 3] =
        [("two_shocks", TwoShocks::star), ("two_waves", TwoWaves::star), ("lax_friedrichs", LaxFriedrichs::star)];

    proptest! {
        #![proptest_config(ProptestConfig { rng_algorithm: prop::test_runner::RngAlgorithm::ChaCha, failure_persistence: None, ..ProptestConfig::with_cases(2000) })]

        #[test]
        fn equal_states_are_kept(d in 1e-6..50.0_f64, u in -30.0..30.0_f64) {
            for (name, star) in ALL {
                let (pressure, velocity) = star(side(d, u), side(d, u), G);
                let exact = 0.5 * G * d * d;
                prop_assert!((pressure - exact).abs() <= 1e-12 * exact, "{}: {} for {}", name, pressure, exact);
                prop_assert!((velocity - u).abs() <= 1e-12 * (1.0 + u.abs()), "{}: {} for {}", name, velocity, u);
            }
        }

        #[test]
        fn is_positive_finite_and_symmetric(
            d_l in 1e-6..50.0_f64, d_r in 1e-6..50.0_f64, u_l in -30.0..30.0_f64, u_r in -30.0..30.0_f64,
        ) {
            for (name, star) in ALL {
                let (pressure, velocity) = star(side(d_l, u_l), side(d_r, u_r), G);
                prop_assert!(pressure >= 0.0 && pressure.is_finite() && velocity.is_finite(), "{}", name);
                let (mirrored_pressure, mirrored_velocity) = star(side(d_r, -u_r), side(d_l, -u_l), G);
                prop_assert!((pressure - mirrored_pressure).abs() <= 1e-10 * (1.0 + pressure), "{}", name);
                prop_assert!((velocity + mirrored_velocity).abs() <= 1e-9 * (1.0 + velocity.abs()), "{}", name);
            }
        }

        #[test]
        fn water_that_closes_in_presses_harder(d in 0.1..10.0_f64, closing in 0.1..5.0_f64) {
            for (name, star) in ALL {
                let (pressure, velocity) = star(side(d, 0.5 * closing), side(d, -0.5 * closing), G);
                let exact = ExactRiemann::solve(d, 0.5 * closing, d, -0.5 * closing, G).star.depth;
                prop_assert!(pressure > 0.5 * G * d * d && velocity.abs() < 1e-12, "{}", name);
                // p* of a linear wave never exceeds that of the shock by more than the wider waves of the one-speed flux.
                prop_assert!(pressure < 0.5 * G * exact * exact * 1.3, "{}: {}", name, pressure / (0.5 * G * exact * exact));
            }
        }

        #[test]
        fn is_near_the_exact_state_for_weak_jumps(
            d in 1.0..2.0_f64, dd in -0.05..0.05_f64, u_l in -0.05..0.05_f64, u_r in -0.05..0.05_f64,
        ) {
            let exact = ExactRiemann::solve(d, u_l, d + dd, u_r, G).star;
            for (name, star) in ALL {
                let (pressure, velocity) = star(side(d, u_l), side(d + dd, u_r), G);
                // Acoustic waves: the error is of second order in jumps of five per cent.
                prop_assert!(((2.0 * pressure / G).sqrt() / exact.depth - 1.0).abs() < 5e-3, "{}", name);
                prop_assert!((velocity - exact.velocity).abs() < 0.02, "{}", name);
            }
        }
    }
}
