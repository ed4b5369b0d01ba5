//! The flux of Lax and Friedrichs with a local speed (`Rusanov1961`), which `Ata2005` brought to particles.
//!
//! Seen from the mean velocity both waves run at the greatest speed there is, and both carry the same impedance:
//!
//! ```text
//! S_m = max(c_l, c_r) + |u_l − u_r|/2,   ζ = S_m (d_l + d_r)/2
//! p* = (p_l + p_r)/2 + ζ (u_l − u_r)/2,   u* = (u_l + u_r)/2 + (p_l − p_r)/(2ζ)
//! ```
//!
//! Unlike the artificial viscosity it acts on pairs that separate, too.

use super::side::{Side, between_waves};

/// p* (m³/s²) and u* (m/s) between two wet states.
#[inline(always)]
pub(super) fn star(left: Side, right: Side, g: f64) -> (f64, f64) {
    let fastest = if left.c > right.c { left.c } else { right.c };
    let impedance = 0.5 * (left.d + right.d) * (fastest + 0.5 * (left.u - right.u).abs());
    between_waves(left, right, (impedance, impedance), g)
}

/// Fluxes of volume (m²/s) and normal momentum (m³/s²) through a face at rest:
///
/// ```text
/// F = (F_l + F_r)/2 − S_m (U_r − U_l)/2,   S_m = max(|u_l| + c_l, |u_r| + c_r)
/// ```
///
/// - `d_l`, `d_r`: depths (m), 0 or more
/// - `u_l`, `u_r`: velocities (m/s), positive from left to right
#[inline(always)]
pub fn lax_friedrichs(d_l: f64, u_l: f64, d_r: f64, u_r: f64, g: f64) -> (f64, f64) {
    let (s_l, s_r) = (u_l.abs() + (g * d_l).sqrt(), u_r.abs() + (g * d_r).sqrt());
    // The velocity of a dry side means nothing.
    let (s_l, s_r) = (if d_l > 0.0 { s_l } else { 0.0 }, if d_r > 0.0 { s_r } else { 0.0 });
    let fastest = if s_l > s_r { s_l } else { s_r };
    let (q_l, q_r) = (d_l * u_l, d_r * u_r);
    let momentum_l = q_l * u_l + 0.5 * g * d_l * d_l;
    let momentum_r = q_r * u_r + 0.5 * g * d_r * d_r;
    (0.5 * (q_l + q_r - fastest * (d_r - d_l)), 0.5 * (momentum_l + momentum_r - fastest * (q_r - q_l)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { rng_algorithm: prop::test_runner::RngAlgorithm::ChaCha, failure_persistence: None, ..ProptestConfig::with_cases(2000) })]

        #[test]
        fn flux_of_equal_states_is_the_physical_one(d in 0.0..50.0_f64, u in -30.0..30.0_f64) {
            let (f_d, f_n) = lax_friedrichs(d, u, d, u, 9.81);
            prop_assert!((f_d - d * u).abs() <= 1e-12 * (1.0 + (d * u).abs()));
            let momentum = d * u * u + 0.5 * 9.81 * d * d;
            prop_assert!((f_n - momentum).abs() <= 1e-12 * (1.0 + momentum));
        }

        #[test]
        fn flux_mirrors_with_the_states(
            d_l in 0.0..50.0_f64, d_r in 0.0..50.0_f64, u_l in -30.0..30.0_f64, u_r in -30.0..30.0_f64,
        ) {
            let (f_d, f_n) = lax_friedrichs(d_l, u_l, d_r, u_r, 9.81);
            let (b_d, b_n) = lax_friedrichs(d_r, -u_r, d_l, -u_l, 9.81);
            prop_assert!((f_d + b_d).abs() <= 1e-12 * (1.0 + f_d.abs()) && (f_n - b_n).abs() <= 1e-12 * (1.0 + f_n.abs()));
        }

        #[test]
        fn a_step_of_half_the_limit_keeps_depths_positive(
            d_l in 0.0..50.0_f64, d in 0.0..50.0_f64, d_r in 0.0..50.0_f64,
            u_l in -30.0..30.0_f64, u in -30.0..30.0_f64, u_r in -30.0..30.0_f64,
        ) {
            let speed = |d: f64, u: f64| u.abs() + (9.81 * d).sqrt();
            let fastest = speed(d_l, u_l).max(speed(d, u)).max(speed(d_r, u_r));
            let out = lax_friedrichs(d, u, d_r, u_r, 9.81).0 - lax_friedrichs(d_l, u_l, d, u, 9.81).0;
            prop_assert!(d - 0.5 / fastest * out >= -1e-12);
        }
    }
}
