//! The exact Riemann solver of the shallow-water equations, dry states included: `Toro2001`, chapters 5 and 6.
//!
//! Slow; the oracle of tests and of reference solutions.

use super::Star;
use crate::physics::celerity;

/// The exact solution of one Riemann problem, to be sampled at any x/t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactRiemann {
    d_l: f64,
    u_l: f64,
    d_r: f64,
    u_r: f64,
    gravity: f64,
    /// The state between the waves; depth 0 where a dry bed opens or lay.
    pub star: Star,
}

/// Change of velocity across the wave that leads from depth `d_k` to `d` (m/s), and its derivative by `d` (1/s).
fn wave(d: f64, d_k: f64, g: f64) -> (f64, f64) {
    if d <= d_k {
        let c = celerity(d, g);
        (2.0 * (c - celerity(d_k, g)), g / c)
    } else {
        let g_k = (0.5 * g * (d + d_k) / (d * d_k)).sqrt();
        ((d - d_k) * g_k, g_k - g * (d - d_k) / (4.0 * d * d * g_k))
    }
}

impl ExactRiemann {
    /// Solves the problem of two states: depths of 0 or more (m), velocities positive from left to right (m/s).
    pub fn solve(d_l: f64, u_l: f64, d_r: f64, u_r: f64, gravity: f64) -> Self {
        let (c_l, c_r) = (celerity(d_l, gravity), celerity(d_r, gravity));
        let opens_dry_bed = u_r - u_l >= 2.0 * (c_l + c_r);
        let star = if d_l <= 0.0 || d_r <= 0.0 || opens_dry_bed {
            Star { depth: 0.0, velocity: 0.5 * (u_l + u_r) + c_l - c_r }
        } else {
            let mut d = (0.5 * (c_l + c_r) + 0.25 * (u_l - u_r)).powi(2) / gravity;
            for _ in 0..100 {
                let (f_l, slope_l) = wave(d, d_l, gravity);
                let (f_r, slope_r) = wave(d, d_r, gravity);
                let next = (d - (f_l + f_r + u_r - u_l) / (slope_l + slope_r)).max(0.1 * d);
                let change = (next - d).abs();
                d = next;
                if change <= 1e-15 * d {
                    break;
                }
            }
            let (f_l, _) = wave(d, d_l, gravity);
            let (f_r, _) = wave(d, d_r, gravity);
            Star { depth: d, velocity: 0.5 * (u_l + u_r + f_r - f_l) }
        };
        ExactRiemann { d_l, u_l, d_r, u_r, gravity, star }
    }

    /// Depth (m) and velocity (m/s) at x/t (m/s); velocity 0 on dry bed.
    pub fn sample(&self, xi: f64) -> (f64, f64) {
        let from_left =
            self.star.depth > 0.0 && xi < self.star.velocity || self.star.depth <= 0.0 && xi < self.dry_middle();
        if from_left {
            self.sample_left(self.d_l, self.u_l, self.star.velocity, xi)
        } else {
            let (d, u) = self.sample_left(self.d_r, -self.u_r, -self.star.velocity, -xi);
            (d, -u)
        }
    }

    /// A speed inside the dry gap.
    fn dry_middle(&self) -> f64 {
        let left_front = self.u_l + 2.0 * celerity(self.d_l, self.gravity);
        let right_front = self.u_r - 2.0 * celerity(self.d_r, self.gravity);
        if self.d_l <= 0.0 {
            right_front
        } else if self.d_r <= 0.0 {
            left_front
        } else {
            0.5 * (left_front + right_front)
        }
    }

    /// Samples the wave of one side, seen as a left one.
    fn sample_left(&self, d_k: f64, u_k: f64, u_star: f64, xi: f64) -> (f64, f64) {
        if d_k <= 0.0 {
            return (0.0, 0.0);
        }
        let g = self.gravity;
        let (c_k, d_star) = (celerity(d_k, g), self.star.depth);
        if d_star > d_k {
            let speed = u_k - c_k * (0.5 * d_star * (d_star + d_k)).sqrt() / d_k;
            return if xi < speed { (d_k, u_k) } else { (d_star, u_star) };
        }
        let (head, tail) =
            if d_star > 0.0 { (u_k - c_k, u_star - celerity(d_star, g)) } else { (u_k - c_k, u_k + 2.0 * c_k) };
        if xi < head {
            (d_k, u_k)
        } else if xi > tail {
            if d_star > 0.0 { (d_star, u_star) } else { (0.0, 0.0) }
        } else {
            let c = (u_k + 2.0 * c_k - xi) / 3.0;
            (c * c / g, (u_k + 2.0 * c_k + 2.0 * xi) / 3.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dam_break_on_wet_bed_has_the_published_middle_state() {
        // Stoker's dam break 10 m over 5 m; middle state 7.2692 m and 2.9205 m/s.
        let exact = ExactRiemann::solve(10.0, 0.0, 5.0, 0.0, 9.81);
        assert!((exact.star.depth - 7.2692).abs() < 1e-3);
        assert!((exact.star.velocity - 2.9205).abs() < 1e-3);
    }

    #[test]
    fn shock_satisfies_rankine_hugoniot() {
        let (d_r, g) = (1.0, 9.81);
        let exact = ExactRiemann::solve(6.0, 0.0, d_r, 0.0, g);
        let Star { depth: d, velocity: u } = exact.star;
        let speed = d * u / (d - d_r);
        let momentum = speed * d * u - (d * u * u + 0.5 * g * (d * d - d_r * d_r));
        assert!(momentum.abs() < 1e-10);
        assert_eq!(exact.sample(speed * 1.0001), (1.0, 0.0));
        assert!((exact.sample(speed * 0.9999).0 - d).abs() < 1e-12);
    }

    #[test]
    fn dry_dam_break_is_ritter() {
        let exact = ExactRiemann::solve(10.0, 0.0, 0.0, 0.0, 9.81);
        let c = (9.81_f64 * 10.0).sqrt();
        let (d, u) = exact.sample(0.0);
        assert!((d - 40.0 / 9.0).abs() < 1e-12 && (u - 2.0 / 3.0 * c).abs() < 1e-12);
        assert_eq!(exact.sample(2.0 * c + 0.01), (0.0, 0.0));
        assert_eq!(exact.sample(-c - 0.01), (10.0, 0.0));
        let mirrored = ExactRiemann::solve(0.0, 0.0, 10.0, 0.0, 9.81).sample(0.0);
        assert!((mirrored.0 - d).abs() < 1e-12 && (mirrored.1 + u).abs() < 1e-12);
    }
}
