//! Faces between pairs, and the rates of velocity and depth.
//!
//! On the way from i to j along e, with slopes limited by van Leer (a of η, b of u = v·e):
//!
//! ```text
//! d_iR = clamp(d_i + slope, 0, 2 d_i),  z_iR = η_i + a_1 − d_iR,  z* = max(z_iR, z_jR)     (Audusse2004, on limited states)
//! d_l = clamp(η_i + a_1 − z*, 0, d_iR),  d_r likewise;  (p*, u*) from two shocks; p* = 0 where either is dry
//! dv/dt = −(1/d_i) Σ 2 A_j G_ij (L_i e) [p* − g d_l²/2 + g d_i a_1] + push
//! dd/dt = −d_i {div v + Σ [θ D3 + (1 − θ) D1]} + α d_i (ΣAW − 1)(1 − χ) max|Δu| / h_i
//! D1 = 2 A_j G_ij (e·L_i e)(u_f − (u_i + u_j)/2),   D3 = −A_j G_ij c̄ (Δη − a_1 − a_2) 2 min(d_i, d_j) / ((d_i + d_j) d_i)
//! u_f = ū + (u* − ū) d_l/d_iR with ū = (u_i + u_j)/2; where d_l is dry u_f = u_i, where d_r is dry max(u_i, min(u_i + b_1, ū))
//! θ = min(d_i, d_j) / max(d_i, d_j)
//! ```
//!
//! The share d_l/d_iR of the face that is not blocked by a sill keeps a deep particle beside a high shore from answering to
//! the velocity of a film, √(g/d_l) d_i, which outran every step: an island's shore rang after two hundred steps at rest.
//!
//! Where too few neighbours are in contact with a particle to tell the slope of its surface, that of the bed stands for it:
//!
//! ```text
//! dv/dt −= g min(1, 4 Fr²) (∇z_b − f(2M) 2M ∇z_b),   M = Σ A_j G_ij r e eᵀ over pairs with d_l > 0 and d_r > 0
//! ```
//!
//! Otherwise the scattered front of a flood in a mountain valley flies straight on over banks and bends, which it did at
//! Malpasset at twice the observed speed. M is enough everywhere but there, and the Froude number keeps at rest what rests: a
//! lonely particle may be a puddle.
//!
//! The bracket vanishes for a level surface on any bed and is exact for a plane one. Positions move with v plus a shift out
//! of the crowd, 0.3 max|Δu| (1 − χ) S₀ / A^((dim−1)/dim), which vanishes at rest.

use rayon::prelude::*;

use super::{Balanced, Gradients, Seen, State};
use crate::math::{Sym2, Vec2};
use crate::physics::celerity;
use crate::physics::dimension::Dimension;
use crate::physics::flux::two_shock;
use crate::physics::limiter::van_leer;
use crate::solver::moving::{CHUNK, ChunkNeighbours, MovingWater, Rates, correction};

/// α: how fast carried depths follow the arrangement of the particles.
const RELAXATION: f64 = 0.5;
/// Share of the greatest approach speed with which particles leave a crowd.
const SHIFT: f64 = 0.3;
/// The moment of contacts counts so many times: half of what an inverse needs suffices to know the surface.
const ENOUGH_CONTACT: f64 = 2.0;
/// Froude number squared from which on a particle without support feels the whole slope.
const FREE_FROUDE_SQUARED: f64 = 0.25;
/// A face with less water (m) than this is dry.
const DRY_FACE: f64 = 1e-9;

/// What a pair face does to particle i.
struct Face {
    /// p* − g d_l²/2 + g d_i a_1 (m³/s²).
    pressure: f64,
    /// θ D3 + (1 − θ) D1, without the factor A_j G_ij (m/s); D1 in the first part wants e·L e.
    divergence: f64,
    /// d_l c_l / d_i (m/s): how hard the face resists a motion of i alone.
    impedance: f64,
    /// Whether the waters of both meet; not so where one stands above the other's surface.
    is_contact: bool,
}

impl Balanced {
    /// Fills `water.rates`.
    pub(super) fn find_rates(&mut self, water: &mut MovingWater) {
        let mut rates = std::mem::take(&mut water.rates);
        rates.resize(water.particles.len(), Rates::default());
        let water_ref = &*water;
        rates.par_chunks_mut(CHUNK).zip(water.neighbours.chunks()).enumerate().for_each(|(chunk, (rates, near))| {
            for (k, rates) in rates.iter_mut().enumerate() {
                *rates = self.rates_of(water_ref, chunk * CHUNK + k, k, near);
            }
        });
        water.rates = rates;
    }

    fn rates_of(&self, water: &MovingWater, i: usize, k: usize, near: &ChunkNeighbours) -> Rates {
        let gravity = water.gravity;
        let (me, mine, local) = (&self.states[i], &self.gradients[i], &self.locals[i]);
        let mut force = Vec2::ZERO;
        let mut divergence = mine.u.x + mine.v.y;
        let mut approach = 0.0_f64;
        let mut stiffness = 0.0;
        let mut contact = Sym2::default();
        for &image in near.of(k) {
            let seen = Seen::new(me, image, &self.states, water.walls.isometries());
            if seen.is_far(me) {
                continue;
            }
            let weight = seen.face(me, &self.kernel);
            let corrected = local.correction.apply(seen.e);
            let others = &self.gradients[image.index as usize];
            let difference = (seen.state.velocity - me.velocity).dot(seen.e);
            let e_l_e = corrected.dot(seen.e);
            let face = pair_face(me, mine, &seen, others, difference, e_l_e, gravity);
            stiffness += weight * e_l_e * face.impedance;
            force += corrected * (2.0 * weight * face.pressure);
            let stretch = if face.is_contact { weight * seen.r } else { 0.0 };
            contact.xx += stretch * seen.e.x * seen.e.x;
            contact.xy += stretch * seen.e.x * seen.e.y;
            contact.yy += stretch * seen.e.y * seen.e.y;
            divergence += weight * face.divergence;
            approach = approach.max(difference.abs());
        }
        let inside = 1.0 - local.edge;
        let relaxation = RELAXATION * me.depth * (local.partition - 1.0) * inside * approach * me.inverse_h;
        let unsupported = self.unsupported(water, i, contact);
        Rates {
            acceleration: local.push - force / me.depth - unsupported,
            depth_rate: relaxation - me.depth * divergence,
            shift: local.openness * (SHIFT * approach * inside),
            approach,
            // The faces slow a lonely motion at the rate Σ A_j G_ij (e·L e) d_l c_l / d_i, of which leapfrog with predicted
            // velocity stands 1/Δt. Inside the water dim c_i over this rate is about h; beside an edge, where L is large,
            // and on steep ground, where d_l exceeds d_i, it is less.
            reach: (1.0 / me.inverse_h)
                .min(self.dimension.count() * celerity(me.depth, gravity) / stiffness.max(f64::MIN_POSITIVE)),
        }
    }
}

impl Balanced {
    /// The part of g ∇z_b (m/s²) that no neighbour in contact tells a particle of; see the head of this file.
    fn unsupported(&self, water: &MovingWater, i: usize, contact: Sym2) -> Vec2 {
        let (me, mut slope) = (&self.states[i], water.bed_points[i].slope);
        if self.dimension == Dimension::One {
            slope.y = 0.0;
        }
        let scale = |value: f64| ENOUGH_CONTACT * value;
        let contact = Sym2 { xx: scale(contact.xx), xy: scale(contact.xy), yy: scale(contact.yy) };
        let froude_squared = me.velocity.norm_squared() / (water.gravity * me.depth);
        let share = (froude_squared / FREE_FROUDE_SQUARED).min(1.0);
        (slope - correction(contact).apply(contact.apply(slope))) * (water.gravity * share)
    }
}

/// Half the limited difference of a quantity between i and j, from the gradient at one of them along e.
#[inline(always)]
fn half_slope(along: f64, difference: f64) -> f64 {
    0.5 * van_leer(2.0 * along - difference, difference)
}

#[inline(always)]
fn pair_face(me: &State, mine: &Gradients, seen: &Seen, others: &Gradients, du: f64, e_l_e: f64, g: f64) -> Face {
    let (other, e, own_e, r) = (&seen.state, seen.e, seen.own_e, seen.r);
    let u_i = me.velocity.dot(e);
    let u_j = other.velocity.dot(e);
    let d_eta = other.surface - me.surface;
    let a_1 = half_slope(mine.surface.dot(e) * r, d_eta);
    let a_2 = half_slope(others.surface.dot(own_e) * r, d_eta);
    // e·(∇v e): the gradient of u along e.
    let b_1 = half_slope((mine.u.dot(e) * e.x + mine.v.dot(e) * e.y) * r, du);
    let b_2 = half_slope((others.u.dot(own_e) * own_e.x + others.v.dot(own_e) * own_e.y) * r, du);
    let d_d = other.depth - me.depth;
    let d_ir = (me.depth + half_slope(mine.depth.dot(e) * r, d_d)).clamp(0.0, 2.0 * me.depth);
    let d_jr = (other.depth - half_slope(others.depth.dot(own_e) * r, d_d)).clamp(0.0, 2.0 * other.depth);
    // Levels relative to η_i, so that a high datum costs no digits.
    let (eta_l, eta_r) = (a_1, d_eta - a_2);
    let z_star = (eta_l - d_ir).max(eta_r - d_jr);
    let d_l = (eta_l - z_star).clamp(0.0, d_ir);
    let d_r = (eta_r - z_star).clamp(0.0, d_jr);
    let u_mean = 0.5 * (u_i + u_j);
    let (p_star, u_face) = if d_l <= DRY_FACE {
        (0.0, u_i)
    } else if d_r <= DRY_FACE {
        (0.0, u_i.max((u_i + b_1).min(u_mean)))
    } else {
        let star = two_shock(d_l, u_i + b_1, d_r, u_j - b_2, g);
        (0.5 * g * star.depth * star.depth, u_mean + (star.velocity - u_mean) * (d_l / d_ir))
    };
    let (shallow, deep) = (me.depth.min(other.depth), me.depth.max(other.depth));
    let theta = shallow / deep;
    let c_mean = 0.5 * (celerity(me.depth, g) + celerity(other.depth, g));
    let by_velocity = 2.0 * e_l_e * (u_face - u_mean);
    let by_surface = -c_mean * (d_eta - a_1 - a_2) * 2.0 * shallow / ((me.depth + other.depth) * me.depth);
    Face {
        pressure: p_star - 0.5 * g * d_l * d_l + g * me.depth * a_1,
        impedance: d_l * celerity(d_l, g) / me.depth,
        is_contact: d_l > DRY_FACE && d_r > DRY_FACE,
        divergence: theta * by_surface + (1.0 - theta) * by_velocity,
    }
}
