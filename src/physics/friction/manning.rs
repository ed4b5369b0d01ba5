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

use crate::math::Vec2;

/// Share of a speed (m/s) that is left after one step; `radius` (m) above 0 is the depth, in a channel the hydraulic radius, and
/// `roughness` is Δt g n² (m^(1/3)·s).
#[inline(always)]
pub fn kept(speed: f64, radius: f64, roughness: f64) -> f64 {
    let k = roughness / (radius * radius.cbrt());
    2.0 / (1.0 + (1.0 + 4.0 * k * speed).sqrt())
}

/// Velocity (m/s) after `time_step` (s) of Manning friction alone; `depth` (m) above 0, `manning_n` (s·m^(−1/3)) 0 or more.
#[inline]
pub fn after_friction(velocity: Vec2, depth: f64, manning_n: f64, gravity: f64, time_step: f64) -> Vec2 {
    debug_assert!(depth > 0.0 && manning_n >= 0.0);
    velocity * kept(velocity.norm(), depth, time_step * gravity * manning_n * manning_n)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_the_implicit_equation() {
        let (d, n, g, dt) = (0.4_f64, 0.05, 9.81, 3.0);
        let before = Vec2::new(3.0, -4.0);
        let after = after_friction(before, d, n, g, dt);
        let k = dt * g * n * n / d.powf(4.0 / 3.0);
        assert!((after.norm() + k * after.norm_squared() - 5.0).abs() < 1e-14);
        assert!(after.cross(before).abs() < 1e-14, "the direction stays");
    }

    #[test]
    fn limits() {
        let before = Vec2::new(1.0, 2.0);
        assert_eq!(after_friction(before, 1.0, 0.0, 9.81, 1.0), before);
        assert!(after_friction(before, 1e-9, 0.05, 9.81, 1.0).norm() < 1e-4);
    }
}
