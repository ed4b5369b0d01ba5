//! Oscillations in a paraboloid, without friction.
//!
//! ```text
//! bed          z_b = −h₀ (1 − r²/a²),  r from the middle
//! planar       η = (B h₀/a²) (2x cos ωt + 2y sin ωt − B),  u = −Bω sin ωt,  v = Bω cos ωt,  ω = √(2 g h₀)/a
//! axisymmetric η = h₀ { √(1−A²)/(1−A cos ωt) − 1 − (r²/a²) [(1−A²)/(1−A cos ωt)² − 1] },
//!              velocity = r/2 · ωA sin ωt/(1−A cos ωt), outwards,  A = (a⁴−r₀⁴)/(a⁴+r₀⁴),  ω = √(8 g h₀)/a
//! ```
//!
//! Source: `Thacker1981`.

use std::f64::consts::PI;

use crate::math::Vec2;
use crate::scenario::GRAVITY;

/// A paraboloid whose rim, at level 0, is a circle.
#[derive(Clone, Copy, Debug)]
pub struct Bowl {
    /// a, the radius of the rim (m).
    pub radius: f64,
    /// h₀, the depth of the bowl in the middle (m).
    pub depth: f64,
    /// The middle (m).
    pub centre: Vec2,
}

impl Bowl {
    /// Bed elevation (m).
    pub fn bed(&self, place: Vec2) -> f64 {
        -self.depth * (1.0 - (place - self.centre).norm_squared() / (self.radius * self.radius))
    }

    /// Period (s) of the planar oscillation.
    pub fn planar_period(&self) -> f64 {
        2.0 * PI * self.radius / (2.0 * GRAVITY * self.depth).sqrt()
    }

    /// Surface level (m, below the bed where it is dry) and velocity (m/s) of the planar oscillation; `offset` is B (m).
    pub fn planar(&self, offset: f64, place: Vec2, t: f64) -> (f64, Vec2) {
        let phase = 2.0 * PI * t / self.planar_period();
        let (p, speed) = (place - self.centre, 2.0 * PI * offset / self.planar_period());
        let slope = offset * self.depth / (self.radius * self.radius);
        let level = slope * (2.0 * p.x * phase.cos() + 2.0 * p.y * phase.sin() - offset);
        (level, Vec2::new(-speed * phase.sin(), speed * phase.cos()))
    }

    /// Period (s) of the axisymmetric oscillation.
    pub fn axisymmetric_period(&self) -> f64 {
        2.0 * PI * self.radius / (8.0 * GRAVITY * self.depth).sqrt()
    }

    /// Surface level (m) and velocity (m/s) of the axisymmetric oscillation; `start` is r₀, the radius of the water at t = 0 (m).
    pub fn axisymmetric(&self, start: f64, place: Vec2, t: f64) -> (f64, Vec2) {
        let phase = 2.0 * PI * t / self.axisymmetric_period();
        let (a4, r4) = (self.radius.powi(4), start.powi(4));
        let amplitude = (a4 - r4) / (a4 + r4);
        let (root, nearness) = ((1.0 - amplitude * amplitude).sqrt(), 1.0 - amplitude * phase.cos());
        let p = place - self.centre;
        let share = p.norm_squared() / (self.radius * self.radius);
        let level = self.depth * (root / nearness - 1.0 - share * (root * root / (nearness * nearness) - 1.0));
        let rate = 2.0 * PI / self.axisymmetric_period() * amplitude * phase.sin() / nearness;
        (level, p * (0.5 * rate))
    }

    /// Potential energy over water density and gravity (m⁴), above the deepest point, of `volume` (m³) at rest: πa²D³/(3h₀) with
    /// the depth D = √(2 h₀ volume/(πa²)) in the middle.
    pub fn potential_at_rest(&self, volume: f64) -> f64 {
        let area = PI * self.radius * self.radius;
        let depth = (2.0 * self.depth * volume / area).sqrt();
        area * depth.powi(3) / (3.0 * self.depth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOWL: Bowl = Bowl { radius: 1.0, depth: 0.1, centre: Vec2::ZERO };

    /// Checks ∂d/∂t + div(d v) = 0 and ∂v/∂t + (v·∇)v + g ∇η = 0 by central differences.
    fn check(solution: impl Fn(Vec2, f64) -> (f64, Vec2)) {
        let step = 1e-5;
        let (east, north) = (Vec2::new(step, 0.0), Vec2::new(0.0, step));
        let depth = |p: Vec2, t: f64| solution(p, t).0 - BOWL.bed(p);
        let per_step = 0.5 / step;
        for (place, t) in [(Vec2::new(0.2, 0.1), 0.3), (Vec2::new(0.3, -0.2), 1.1)] {
            let (_, v) = solution(place, t);
            assert!(depth(place, t) > 0.01);
            let flux = |p: Vec2| solution(p, t).1 * depth(p, t);
            let volume = (depth(place, t + step) - depth(place, t - step)) * per_step
                + (flux(place + east).x - flux(place - east).x + flux(place + north).y - flux(place - north).y)
                    * per_step;
            let rate = (solution(place, t + step).1 - solution(place, t - step).1) * per_step;
            let along = (solution(place + east, t).1 - solution(place - east, t).1) * (v.x * per_step)
                + (solution(place + north, t).1 - solution(place - north, t).1) * (v.y * per_step);
            let slope = Vec2::new(
                solution(place + east, t).0 - solution(place - east, t).0,
                solution(place + north, t).0 - solution(place - north, t).0,
            ) * per_step;
            let momentum = rate + along + slope * GRAVITY;
            // Differences of second order with steps of 1e-5.
            assert!(volume.abs() < 1e-7 && momentum.norm() < 1e-6, "{volume:e} {momentum:?}");
        }
    }

    #[test]
    fn both_oscillations_solve_the_equations() {
        check(|p, t| BOWL.planar(0.5, p, t));
        check(|p, t| BOWL.axisymmetric(0.8, p, t));
    }

    #[test]
    fn potential_energy_at_rest_is_the_integral() {
        let (n, depth) = (100_000, 0.07_f64);
        let dz = depth / f64::from(n);
        let area = |z: f64| PI * z / BOWL.depth;
        let heights = || (0..n).map(|k| (f64::from(k) + 0.5) * dz);
        let volume: f64 = heights().map(|z| area(z) * dz).sum();
        let energy: f64 = heights().map(|z| area(z) * dz * z).sum();
        assert!((BOWL.potential_at_rest(volume) / energy - 1.0).abs() < 1e-8);
    }
}
