//! Pair forces of the variational form, with one of two stabilisations.
//!
//! Monaghan's viscosity acts on approaching pairs:
//!
//! ```text
//! dv/dt −= Σ m_j Π_ij ∇W̄,   Π_ij = −α c̄ (v_ij·x_ij) / (d̄ √(r² + 0.01 h̄²)),   α = 1
//! ```
//!
//! The other one puts p* of two shocks for both pressures.

use rayon::prelude::*;

use super::{Density, Variational};
use crate::math::Vec2;
use crate::physics::celerity;
use crate::physics::flux::two_shock;
use crate::physics::limiter::van_leer;
use crate::scenario::methods::Stabilisation;
use crate::solver::moving::{CHUNK, ChunkNeighbours, MovingWater, Rates};

/// α of the artificial viscosity.
const VISCOSITY: f64 = 1.0;

impl Variational {
    /// Fills `water.rates`.
    pub(super) fn find_rates(&mut self, water: &mut MovingWater) {
        let mut rates = std::mem::take(&mut water.rates);
        rates.resize(water.particles.len(), Rates::default());
        rates.par_chunks_mut(CHUNK).zip(water.neighbours.chunks()).enumerate().for_each(|(chunk, (rates, near))| {
            for (k, rates) in rates.iter_mut().enumerate() {
                *rates = self.rates_of(water, chunk * CHUNK + k, k, near);
            }
        });
        water.rates = rates;
    }

    fn rates_of(&self, water: &MovingWater, i: usize, k: usize, near: &ChunkNeighbours) -> Rates {
        let (particles, g, mine) = (&water.particles, water.gravity, &self.densities[i]);
        let v_i = particles.velocity[i];
        let mut force = Vec2::ZERO;
        let mut approach = 0.0_f64;
        for image in near.of(k) {
            let j = image.index as usize;
            let isometry = &water.walls.isometries()[image.transform as usize];
            let other = &self.densities[j];
            let offset = isometry.point(particles.position[j]) - particles.position[i];
            let r = offset.norm();
            let e = offset / r.max(f64::MIN_POSITIVE);
            let own_e = isometry.inverse_vector(e);
            // Slopes of W along e, 0 or negative.
            let (slope_i, slope_j) = (self.kernel.slope(r, mine.inverse_h), self.kernel.slope(r, other.inverse_h));
            if slope_i + slope_j >= 0.0 {
                continue;
            }
            let v_j = isometry.vector(particles.velocity[j]);
            let (u_i, u_j) = (v_i.dot(e), v_j.dot(e));
            let pair = match self.stabilisation {
                Stabilisation::ArtificialViscosity => {
                    0.5 * g * (slope_i / mine.beta + slope_j / other.beta)
                        + viscosity(mine, other, r, u_j - u_i, g) * 0.5 * (slope_i + slope_j)
                }
                Stabilisation::Riemann => {
                    let p = star_pressure(mine, other, e, own_e, r, (u_i, u_j), g);
                    p * (slope_i / (mine.depth * mine.depth * mine.beta)
                        + slope_j / (other.depth * other.depth * other.beta))
                }
            };
            // The gradient of W by x_i points against e.
            force += e * (particles.volume[j] * pair);
            approach = approach.max((u_j - u_i).abs());
        }
        let bed = water.bed_points[i].slope * g;
        Rates { acceleration: force - bed, depth_rate: 0.0, shift: Vec2::ZERO, approach, reach: 1.0 / mine.inverse_h }
    }
}

/// Π (m/s²·m/m), 0 where the pair separates; `du` = u_j − u_i along e.
#[inline]
fn viscosity(mine: &Density, other: &Density, r: f64, du: f64, g: f64) -> f64 {
    let h = 2.0 / (mine.inverse_h + other.inverse_h);
    let c = 0.5 * (celerity(mine.depth, g) + celerity(other.depth, g));
    let d = 0.5 * (mine.depth + other.depth);
    // v_ij·x_ij = (v_i − v_j)·(x_i − x_j) = r du.
    -VISCOSITY * c * (r * du).min(0.0) / (d * (r * r + 0.01 * h * h).sqrt())
}

/// p* (m³/s²) between the limited states of a pair.
#[inline]
fn star_pressure(mine: &Density, other: &Density, e: Vec2, own_e: Vec2, r: f64, (u_i, u_j): (f64, f64), g: f64) -> f64 {
    let half = |along: f64, difference: f64| 0.5 * van_leer(2.0 * along * r - difference, difference);
    let (dd, du) = (other.depth - mine.depth, u_j - u_i);
    let d_l = (mine.depth + half(mine.grad_depth.dot(e), dd)).max(0.1 * mine.depth);
    let d_r = (other.depth - half(other.grad_depth.dot(own_e), dd)).max(0.1 * other.depth);
    let along = |density: &Density, e: Vec2| density.grad_u.dot(e) * e.x + density.grad_v.dot(e) * e.y;
    let u_l = u_i + half(along(mine, e), du);
    let u_r = u_j - half(along(other, own_e), du);
    let star = two_shock(d_l, u_l, d_r, u_r, g);
    0.5 * g * star.depth * star.depth
}
