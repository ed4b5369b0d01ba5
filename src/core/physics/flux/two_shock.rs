//! The approximate Riemann solver with two shocks or two rarefactions: `Toro2001`, section 10.6.
//!
//! ```text
//! d_0 = [ (c_l + c_r)/2 + (u_l − u_r)/4 ]₊² / g            two rarefactions; exact where d_0 ≤ min(d_l, d_r)
//! g_k = √( g (d_0 + d_k) / (2 d_0 d_k) )
//! d*  = [ g_l d_l + g_r d_r + u_l − u_r ]₊ / (g_l + g_r)   two shocks
//! u*  = (u_l + u_r)/2 + [ (d* − d_r) g_r − (d* − d_l) g_l ] / 2
//! ```
//!
//! The positive parts keep d* at 0 or above, also where two rarefactions leave a vacuum.

use std::f64::consts::SQRT_2;

use super::side::Side;
use crate::math::{larger, smaller};
use crate::physics::celerity;

/// The state between the two waves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Star {
    /// Depth (m), 0 or more.
    pub depth: f64,
    /// Velocity (m/s), positive from left to right.
    pub velocity: f64,
}

/// The state between the waves of two wet states.
///
/// - `d_l`, `d_r`: depths (m), above 0
/// - `u_l`, `u_r`: velocities (m/s), positive from left to right
#[inline(always)]
pub fn two_shock(d_l: f64, u_l: f64, d_r: f64, u_r: f64, gravity: f64) -> Star {
    let c_l = celerity(d_l, gravity);
    let c_r = celerity(d_r, gravity);
    let bracket = (0.5 * (c_l + c_r) + 0.25 * (u_l - u_r)).max(0.0);
    let d_0 = bracket * bracket / gravity;
    let mean = 0.5 * (u_l + u_r);
    if d_0 <= d_l.min(d_r) {
        return Star { depth: d_0, velocity: mean + c_l - c_r };
    }
    let g_l = (0.5 * gravity * (d_0 + d_l) / (d_0 * d_l)).sqrt();
    let g_r = (0.5 * gravity * (d_0 + d_r) / (d_0 * d_r)).sqrt();
    let depth = ((g_l * d_l + g_r * d_r + u_l - u_r) / (g_l + g_r)).max(0.0);
    Star { depth, velocity: mean + 0.5 * ((depth - d_r) * g_r - (depth - d_l) * g_l) }
}

/// p* (m³/s²) and u* (m/s) between two wet states: the same without branches, by two roots and one division.
///
/// ```text
/// b = [ (c_l + c_r)/2 + (u_l − u_r)/4 ]₊,   p = √(c_l² + b²),   q = √(c_r² + b²)
/// g_l = g p / (√2 b c_l),   g_r = g q / (√2 b c_r)                        since d_0 = b²/g and c² = g d
/// S = p c_r + q c_l,   N = [ c_l p + c_r q + √2 b (u_l − u_r) ]₊
/// d* = [ d_l + (b² − c_l²) / g ]₊                                          two rarefactions
/// d* = [ d_l + c_l { q (c_r² − c_l²) + √2 b c_r (u_l − u_r) } / (g S) ]₊   two shocks
/// u* = (u_l + u_r)/2 + { N (q c_l − p c_r) + S (c_l p − c_r q) } / (2 √2 b S)
/// ```
///
/// Depths are told from d_l on, so that of equal states is kept to the last digit: what rests is not stirred by rounding.
#[inline(always)]
pub(super) fn star(left: Side, right: Side, g: f64) -> (f64, f64) {
    let (Side { d: d_l, c: c_l, u: u_l }, Side { d: d_r, c: c_r, u: u_r }) = (left, right);
    let closing = u_l - u_r;
    let b = larger(0.5 * (c_l + c_r) + 0.25 * closing, 0.0);
    let b_squared = b * b;
    let (p, q) = ((c_l * c_l + b_squared).sqrt(), (c_r * c_r + b_squared).sqrt());
    let (p_l, q_r) = (c_l * p, c_r * q);
    let (p_r, q_l) = (c_r * p, c_l * q);
    let s = p_r + q_l;
    let push = SQRT_2 * b * closing;
    let n = larger(p_l + q_r + push, 0.0);
    let per_b_s = 1.0 / (b * s);
    let has_rarefactions = b_squared <= g * smaller(d_l, d_r);
    let by_shocks = c_l * (q * ((c_r - c_l) * (c_r + c_l)) + push * c_r) * (b * per_b_s);
    // g (d* − d_l)
    let rise = if has_rarefactions { (b - c_l) * (b + c_l) } else { by_shocks };
    let depth = larger(d_l + rise * (1.0 / g), 0.0);
    let shocks = (n * (q_l - p_r) + s * (p_l - q_r)) * (0.25 * SQRT_2 * per_b_s);
    let turn = if has_rarefactions { c_l - c_r } else { shocks };
    (0.5 * g * depth * depth, 0.5 * (u_l + u_r) + turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::flux::exact::ExactRiemann;
    use proptest::prelude::*;

    const G: f64 = 9.81;

    #[test]
    fn equal_states_are_kept() {
        let star = two_shock(2.0, 0.7, 2.0, 0.7, G);
        assert!((star.depth - 2.0).abs() < 1e-15 && (star.velocity - 0.7).abs() < 1e-15);
    }

    #[test]
    fn what_rests_is_not_stirred_by_rounding() {
        for k in 1..1000 {
            let d = 0.037 * f64::from(k);
            let side = Side { d, c: celerity(d, G), u: 0.0 };
            assert_eq!(star(side, side, G), (0.5 * G * d * d, 0.0));
        }
    }

    #[test]
    fn two_rarefactions_are_exact() {
        let exact = ExactRiemann::solve(2.0, -1.0, 2.5, 1.5, G);
        let star = two_shock(2.0, -1.0, 2.5, 1.5, G);
        assert!((star.depth - exact.star.depth).abs() < 1e-12);
        assert!((star.velocity - exact.star.velocity).abs() < 1e-12);
    }

    #[test]
    fn vacuum_has_depth_zero() {
        let star = two_shock(1.0, -20.0, 1.0, 20.0, G);
        assert_eq!(star, Star { depth: 0.0, velocity: 0.0 });
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_algorithm: prop::test_runner::RngAlgorithm::ChaCha, failure_persistence: None, ..ProptestConfig::with_cases(2000) })]

        #[test]
        fn is_positive_finite_and_symmetric(
            d_l in 1e-6..50.0_f64, d_r in 1e-6..50.0_f64, u_l in -30.0..30.0_f64, u_r in -30.0..30.0_f64,
        ) {
            let star = two_shock(d_l, u_l, d_r, u_r, G);
            prop_assert!(star.depth >= 0.0 && star.depth.is_finite() && star.velocity.is_finite());
            let mirrored = two_shock(d_r, -u_r, d_l, -u_l, G);
            prop_assert!((star.depth - mirrored.depth).abs() <= 1e-12 * (1.0 + star.depth));
            prop_assert!((star.velocity + mirrored.velocity).abs() <= 1e-9 * (1.0 + star.velocity.abs()));
        }

        #[test]
        fn both_forms_are_the_same(
            d_l in 1e-6..50.0_f64, d_r in 1e-6..50.0_f64, u_l in -30.0..30.0_f64, u_r in -30.0..30.0_f64,
        ) {
            let plain = two_shock(d_l, u_l, d_r, u_r, G);
            let (left, right) =
                (Side { d: d_l, c: celerity(d_l, G), u: u_l }, Side { d: d_r, c: celerity(d_r, G), u: u_r });
            let (pressure, velocity) = star(left, right, G);
            // Rounding, of numbers as large as the velocities that the shocks differ by.
            let scale = 1.0 + u_l.abs() + u_r.abs() + left.c + right.c;
            prop_assert!((pressure - 0.5 * G * plain.depth * plain.depth).abs() <= 1e-10 * (pressure + scale));
            prop_assert!((velocity - plain.velocity).abs() <= 1e-10 * scale, "{} for {}", velocity, plain.velocity);
        }

        #[test]
        fn is_near_the_exact_state_for_moderate_jumps(
            d_l in 1.0..2.0_f64, d_r in 1.0..2.0_f64, u_l in -1.0..1.0_f64, u_r in -1.0..1.0_f64,
        ) {
            let exact = ExactRiemann::solve(d_l, u_l, d_r, u_r, G);
            let star = two_shock(d_l, u_l, d_r, u_r, G);
            // Within a per cent (Toro's table) but for water torn apart at nearly 2 m/s: 1.25 % at 1 m | 2 m, -1 m/s | 1 m/s.
            prop_assert!((star.depth - exact.star.depth).abs() < 0.0126 * exact.star.depth);
            prop_assert!((star.velocity - exact.star.velocity).abs() < 0.05);
        }
    }
}
