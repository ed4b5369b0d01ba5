//! Pair forces of the variational form, with one of four stabilisations.
//!
//! The viscosity acts on approaching pairs:
//!
//! ```text
//! dv/dt −= Σ m_j Π_ij ∇W,   Π_ij = −(c̄ − 3/2 w) w/d̄,   w = (v_ij·x_ij)/√(r² + 0.01 h_ij²)
//! ```
//!
//! which is that of `Monaghan1997` (M117): what approaches faster than waves run is stopped, too, and passes through nothing. The others put p* of a
//! Riemann solver (`physics::flux`) for both pressures. All see the states of the particles, or states carried to the middle between them by
//! limited gradients; the viscosity sees v_ij only.

use rayon::prelude::*;

use super::{CHUNK, Density, MovingWater, Rates, Seen, Variational, inverse_of_pair, with_kernel};
use crate::math::{Sym2, Vec2};
use crate::methods::{BedSlope, Reconstruction, Stabilisation};
use crate::physics::celerity;
use crate::physics::flux::{FaceSolver, LaxFriedrichs, Side, TwoWaves, two_shock};
use crate::physics::kernel::{Shape, Smoothing};
use crate::physics::limiter::van_leer;

/// How the speed of approach adds to the speeds of both waves (`Monaghan1997`: 3).
const SIGNAL: f64 = 3.0;
/// Pairs that separate more slowly than this share of the speed of waves are braked, too.
const STILL: f64 = 1e-3;

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
            // The slope of W along e; positive ones are there with the super-Gaussian only.
            let of_pair = inverse_of_pair(mine.inverse_h.powi(-2), other.inverse_h.powi(-2));
            let slope = kernel.slope(r, of_pair);
            if slope == 0.0 {
                continue;
            }
            let v_j = isometry.vector(particles.velocity[j]);
            let (u_i, u_j) = (v_i.dot(e), v_j.dot(e));
            let (d_i, d_j) = over_one_bed(mine, other);
            let (left, right) = self.sides((mine, other), (d_i, d_j), (e, own_e), r, (u_i, u_j), g);
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
                    0.5 * g * (mine.grad_h + other.grad_h) + viscosity(mine, other, (r, of_pair), right.u - left.u, g)
                }
                Some(p) => p * (mine.grad_h / (d_i * d_i) + other.grad_h / (d_j * d_j)),
            };
            // The gradient of W by x_i points against e.
            force += e * (particles.volume[j] * slope * pair);
            approach = approach.max((u_j - u_i).abs());
        }
        let slope = self.grounds[i].slope;
        let acceleration = match self.bed_slope {
            BedSlope::Hydrostatic => force - mine.still,
            BedSlope::Steep => {
                let internal = force - mine.still + slope * g;
                on_steep_bed(internal, v_i, slope, water.curvature_at(particles.position[i]), g)
            }
        };
        Rates { acceleration, approach, reach: 1.0 / mine.inverse_h }
    }

    /// The states of i and j on both sides of the face between them; `u` are the velocities along e.
    #[inline(always)]
    fn sides(
        &self,
        (mine, other): (&Density, &Density),
        (own, others): (f64, f64),
        (e, own_e): (Vec2, Vec2),
        r: f64,
        u: (f64, f64),
        g: f64,
    ) -> (Side, Side) {
        let (mut d_l, mut u_l, mut d_r, mut u_r) = (own, u.0, others, u.1);
        if self.reconstruction != Reconstruction::None {
            let half = |along: f64, difference: f64| 0.5 * van_leer(2.0 * along * r - difference, difference);
            let along = |density: &Density, e: Vec2| density.grad_u.dot(e) * e.x + density.grad_v.dot(e) * e.y;
            let (rise, du) = (other.level - mine.level, u.1 - u.0);
            d_l = (own + half(mine.grad_level.dot(e), rise)).max(0.1 * own);
            d_r = (others - half(other.grad_level.dot(own_e), rise)).max(0.1 * others);
            u_l = u.0 + half(along(mine, e), du);
            u_r = u.1 - half(along(other, own_e), du);
        }
        (Side { d: d_l, c: celerity(d_l, g), u: u_l }, Side { d: d_r, c: celerity(d_r, g), u: u_r })
    }
}

/// Depths (m) of i and j over the bed between them, the mean of L − d: equal where the levels are. Over a level bed they are d.
///
/// Either changes by at most half of the lesser depth of both, and both are those of one lake as long as its shore is not between them.
#[inline(always)]
fn over_one_bed(mine: &Density, other: &Density) -> (f64, f64) {
    let rise = (other.level - other.depth) - (mine.level - mine.depth);
    let shift = (0.5 * rise).clamp(-0.5 * other.depth, 0.5 * mine.depth);
    (mine.depth - shift, other.depth + shift)
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
fn viscosity(mine: &Density, other: &Density, (r, inverse_h): (f64, f64), du: f64, g: f64) -> f64 {
    let c = 0.5 * (celerity(mine.depth, g) + celerity(other.depth, g));
    let d = 0.5 * (mine.depth + other.depth);
    let h = 1.0 / inverse_h;
    // v_ij·x_ij = (v_i − v_j)·(x_i − x_j) = r du.
    let w = r * du / (r * r + 0.01 * h * h).sqrt();
    let approach = w.min(0.0);
    // What is as slow as the particles of still water that find their places is braked both ways.
    let both_ways = (w - approach) / (1.0 + (w / (STILL * c).max(f64::MIN_POSITIVE)).powi(2));
    -(c * (approach + both_ways) - 0.5 * SIGNAL * approach * approach) / d
}
