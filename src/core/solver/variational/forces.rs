//! Pair forces of the variational form, with one of four stabilisations.
//!
//! The viscosity acts on approaching pairs:
//!
//! ```text
//! dv/dt −= Σ m_j Π_ij ∇W̄,   Π_ij = −α c̄ (v_ij·x_ij) / (d̄ √(r² + 0.01 h̄²)),   α = 1
//! ```
//!
//! which is `Monaghan1992` without the ratio h̄/r. The others put p* of a Riemann solver (`physics::flux`) for both pressures. All see
//! the states of the particles, or states carried to the middle between them by limited gradients; the viscosity sees v_ij only.

use rayon::prelude::*;

use super::{CHUNK, Density, MovingWater, Rates, Seen, Variational, with_kernel};
use crate::math::{Sym2, Vec2};
use crate::methods::{BedSlope, Reconstruction, Stabilisation};
use crate::physics::celerity;
use crate::physics::flux::{FaceSolver, LaxFriedrichs, Side, TwoWaves, two_shock};
use crate::physics::kernel::{Shape, Smoothing};
use crate::physics::limiter::van_leer;

/// α of the artificial viscosity.
const VISCOSITY: f64 = 1.0;

impl Variational {
    /// Fills `water.rates`.
    pub(super) fn find_rates(&mut self, water: &mut MovingWater) {
        let mut rates = std::mem::take(&mut water.rates);
        rates.resize(water.particles.len(), Rates::default());
        rates.par_chunks_mut(CHUNK).enumerate().for_each_init(Vec::new, |list, (chunk, rates)| {
            for (k, rates) in rates.iter_mut().enumerate() {
                let i = chunk * CHUNK + k;
                let seen = water.neighbours.of(i, list);
                *rates = with_kernel!(&self.kernel, kernel => self.rates_of(kernel, water, i, seen));
            }
        });
        water.rates = rates;
    }

    fn rates_of<S: Shape>(&self, kernel: &Smoothing<S>, water: &MovingWater, i: usize, images: Seen<'_>) -> Rates {
        let (particles, g, mine) = (&water.particles, water.gravity, &self.densities[i]);
        let v_i = particles.velocity[i];
        let mut force = Vec2::ZERO;
        let mut approach = 0.0_f64;
        for image in images.iter() {
            let j = image.index as usize;
            let isometry = &water.walls.isometries()[image.transform as usize];
            let other = &self.densities[j];
            let offset = isometry.point(particles.position[j]) - particles.position[i];
            let r = offset.norm();
            let e = offset / r.max(f64::MIN_POSITIVE);
            let own_e = isometry.inverse_vector(e);
            // Slopes of W along e; positive ones are there with the super-Gaussian only.
            let (slope_i, slope_j) = (kernel.slope(r, mine.inverse_h), kernel.slope(r, other.inverse_h));
            if slope_i.abs() + slope_j.abs() <= 0.0 {
                continue;
            }
            let v_j = isometry.vector(particles.velocity[j]);
            let (u_i, u_j) = (v_i.dot(e), v_j.dot(e));
            let (left, right) = self.sides(mine, other, (e, own_e), r, (u_i, u_j), g);
            let pressure = match self.stabilisation {
                Stabilisation::ArtificialViscosity => None,
                Stabilisation::TwoShocks => {
                    let star = two_shock(left.d, left.u, right.d, right.u, g);
                    Some(0.5 * g * star.depth * star.depth)
                }
                Stabilisation::LaxFriedrichs => Some(LaxFriedrichs::star(left, right, g).0),
                Stabilisation::TwoWaves | Stabilisation::TwoRarefactions => Some(TwoWaves::star(left, right, g).0),
            };
            let pair = match pressure {
                None => {
                    0.5 * g * (slope_i / mine.beta + slope_j / other.beta)
                        + viscosity(mine, other, r, right.u - left.u, g) * 0.5 * (slope_i + slope_j)
                }
                Some(p) => {
                    p * (slope_i / (mine.depth * mine.depth * mine.beta)
                        + slope_j / (other.depth * other.depth * other.beta))
                }
            };
            // The gradient of W by x_i points against e.
            force += e * (particles.volume[j] * pair);
            approach = approach.max((u_j - u_i).abs());
        }
        let slope = self.slopes[i];
        let acceleration = match self.bed_slope {
            BedSlope::Hydrostatic => force - slope * g,
            BedSlope::Steep => on_steep_bed(force, v_i, slope, water.curvature_at(particles.position[i]), g),
        };
        Rates { acceleration, approach, reach: 1.0 / mine.inverse_h }
    }

    /// The states of i and j on both sides of the face between them; `u` are the velocities along e.
    #[inline(always)]
    fn sides(
        &self,
        mine: &Density,
        other: &Density,
        (e, own_e): (Vec2, Vec2),
        r: f64,
        u: (f64, f64),
        g: f64,
    ) -> (Side, Side) {
        let (mut d_l, mut u_l, mut d_r, mut u_r) = (mine.depth, u.0, other.depth, u.1);
        if self.reconstruction != Reconstruction::None {
            let half = |along: f64, difference: f64| 0.5 * van_leer(2.0 * along * r - difference, difference);
            let along = |density: &Density, e: Vec2| density.grad_u.dot(e) * e.x + density.grad_v.dot(e) * e.y;
            let (dd, du) = (other.depth - mine.depth, u.1 - u.0);
            d_l = (mine.depth + half(mine.grad_depth.dot(e), dd)).max(0.1 * mine.depth);
            d_r = (other.depth - half(other.grad_depth.dot(own_e), dd)).max(0.1 * other.depth);
            u_l = u.0 + half(along(mine, e), du);
            u_r = u.1 - half(along(other, own_e), du);
        }
        (Side { d: d_l, c: celerity(d_l, g), u: u_l }, Side { d: d_r, c: celerity(d_r, g), u: u_r })
    }
}

/// dv/dt (m/s²) over a steep bed, of slope ∇z_b and curvature K, by an internal acceleration −a_p: (M79).
///
/// From the Lagrangian ½ |v|² + ½ (v·∇z_b)² − g z_b, which counts the vertical motion of water that follows the bed.
#[inline]
fn on_steep_bed(internal: Vec2, v: Vec2, slope: Vec2, curvature: Sym2, g: f64) -> Vec2 {
    internal - slope * ((g + v.dot(curvature.apply(v)) + internal.dot(slope)) / (1.0 + slope.norm_squared()))
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
