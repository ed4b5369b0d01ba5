//! Bed friction after Manning, implicit and solved exactly.
//!
//! dv/dt = −g n² |v| v / d^(4/3), over one step with the friction of the end of the step:
//!
//! ```text
//! |v'| + k |v'|² = |v|,   k = Δt g n² / d^(4/3),   |v'| = 2 |v| / (1 + √(1 + 4 k |v|))
//! ```
//!
//! The factor lies in (0, 1]: friction slows water and never turns it round, however thin the film; no limit on the step.
//! Values of n: `Chow1959`.

use crate::math::{Vec2, inverse_cube_root};

/// g n² / d^(4/3) (1/m); `depth` (m) above 0, `manning_n` (s·m^(−1/3)) 0 or more.
#[inline]
pub fn resistance(depth: f64, manning_n: f64, gravity: f64) -> f64 {
    debug_assert!(depth > 0.0 && manning_n >= 0.0);
    if manning_n > 0.0 { over_four_thirds(gravity * manning_n * manning_n, depth) } else { 0.0 }
}

/// Velocity (m/s) after `time_step` (s) of friction alone, from the resistance (1/m).
#[inline]
pub fn after_friction(velocity: Vec2, resistance: f64, time_step: f64) -> Vec2 {
    velocity * kept(velocity.norm(), time_step * resistance)
}

/// Share |v'|/|v| of a speed (m/s) that is left after one step; `depth` (m) above 0, `roughness` = Δt g n² (s·m^(1/3)). Without a
/// branch, for loops on lanes.
#[inline(always)]
pub fn kept_by_friction(speed: f64, depth: f64, roughness: f64) -> f64 {
    kept(speed, over_four_thirds(roughness, depth))
}

#[inline(always)]
fn kept(speed: f64, k: f64) -> f64 {
    2.0 / (1.0 + (1.0 + 4.0 * k * speed).sqrt())
}

/// x / d^(4/3)
#[inline(always)]
fn over_four_thirds(x: f64, depth: f64) -> f64 {
    let root = inverse_cube_root(depth);
    x * (root * root) * (root * root)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_the_implicit_equation() {
        let (d, n, g, dt) = (0.4_f64, 0.05, 9.81, 3.0);
        let before = Vec2::new(3.0, -4.0);
        let after = after_friction(before, resistance(d, n, g), dt);
        let k = dt * g * n * n / d.powf(4.0 / 3.0);
        assert!((after.norm() + k * after.norm_squared() - 5.0).abs() < 1e-14);
        assert!(after.cross(before).abs() < 1e-14, "the direction stays");
    }

    #[test]
    fn limits() {
        let before = Vec2::new(1.0, 2.0);
        assert_eq!(after_friction(before, resistance(1.0, 0.0, 9.81), 1.0), before);
        assert_eq!(kept_by_friction(3.0, 1e-3, 0.0).to_bits(), 1.0_f64.to_bits());
        assert!(after_friction(before, resistance(1e-9, 0.05, 9.81), 1.0).norm() < 1e-4);
    }
}
