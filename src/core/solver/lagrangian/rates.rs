//! Faces between pairs, and the rates of velocity and depth.
//!
//! On the way from i to j along e, with limited slopes (a of η, b of u = v·e):
//!
//! ```text
//! a_1 = ½ Λ(2 ∇η_i·x_ij − Δη, Δη),  Λ(X, Y) = least of 2 |X|, 2 |Y|, |(1 − κ) X + (1 + κ) Y|/2 with their sign, 0 where they differ in it
//! κ = 1/10 for levels, 1/3 for velocities, 0 for depths                                              (VanLeer1985)
//! d_iR = clamp(d_i + slope, 0, 2 d_i),  z_l = η_i + a_1 − d_iR,  z* = max(z_l, z_r)     (Audusse2004, on limited states)
//! d_l = clamp(η_i + a_1 − z*, 0, d_iR),  d_r likewise;  (p*, u*) from two shocks or as chosen; p* = 0 where either is dry
//! dv/dt = −(1/d_i) Σ 2 A_j G_ij (L_i e) [p* − g d_l²/2 + g d_i a_1] + push
//! dd/dt = −d_i {div v + Σ [k_d (D3 + D2) + (1 − k_d) D1]} + α [d' (ΣAW/(ΣAW)₀ − 1)(1 − χ) + d_i min(2 n·M n − 1, 0) χ] ṙ_i / h_i
//! D1 = 2 A_j G_ij (e·L_i e)(u_f − (u_i + u_j)/2),   D3 = −A_j G_ij c̄ (Δη − a_1 − a_2) 2 min(d_i, d_j) / ((d_i + d_j) d_i)
//! D2 = (1 − χ) A_j G_ij (e·L_i e)(b_1 − b_2) where the pair leaves each other, u_j > u_i; otherwise 0
//! u_f = ū + (u* − ū) d_l/d_iR with ū = (u_i + u_j)/2; where d_l is dry u_f = u_i, where d_r is dry max(u_i, min(u_i + b_1, ū))
//! k_d = min(d_i, d_j) / max(d_i, d_j);   d' = d_i where ΣAW < (ΣAW)₀, otherwise min(d_i, ΣAWd / ΣAW)
//! ṙ_i = largest of Δu where the pair leaves each other, of (u_i + b_1) − (u_j − b_2) where it approaches, and 0
//! ```
//!
//! D2 is the part of D1 that limited slopes of the velocity give, which D3 lacks: with it the errors of a rarefaction fall by
//! a third. Between particles that approach it spoils the speed of bores (decision 0008).
//!
//! (ΣAW)₀ is ΣAW on a square lattice, 1.003 in the plane: with 1 in its place water swelled wherever it was sheared or stretched,
//! which was most of the error of an oscillating bowl (decision 0011).
//!
//! At a free edge half of the neighbourhood is missing, and ΣAW says nothing. There the share of the first moment across the
//! edge, n·M n, stands for it: one half where the neighbours behind are as far away as the depth says, less where the gap is wider.
//! Without it the outermost particle of a dry front stayed twice too deep, and the front a tenth behind (decision 0018).
//!
//! Depths follow the arrangement as fast as the water is drawn out, but where it is pressed together only as fast as limited slopes leave
//! a jump: within a bore ΣAW is off by the stencil, and with all of Δu the water behind a bore was a little too shallow and too
//! fast at every spacing (decision 0022).
//!
//! A crowded particle swells no faster than the depth around it allows. By its own depth it would swell without end in a pond
//! narrower than its neighbours.
//!
//! The share d_l/d_iR of the face that is not blocked by a sill keeps a deep particle beside a high shore from answering to
//! the velocity of a film, √(g/d_l) d_i, which outran every step: an island's shore rang after two hundred steps at rest.
//!
//! Where too few neighbours are in contact with a particle to tell the slope of its surface, that of the bed stands for it:
//!
//! ```text
//! dv/dt −= g min(1, 4 Fr²) (∇z_b − (2M)⁺ 2M ∇z_b),   M = Σ A_j G_ij r e eᵀ over pairs with d_l > 0 and d_r > 0
//! ```
//!
//! Otherwise the scattered front of a flood in a mountain valley flies straight on over banks and bends, which it did at
//! Malpasset at twice the observed speed. M is enough everywhere but there, and the Froude number keeps at rest what rests: a
//! lonely particle may be a puddle.
//!
//! The bracket vanishes for a level surface on any bed and is exact for a plane one. Positions move with v plus a shift out
//! of the crowd, 0.3 max(−Δu, |Δu| min(|S₀|/A^((dim−1)/dim), 1)) (1 − χ) S₀ / A^((dim−1)/dim), which vanishes at rest. Where
//! nobody approaches, only an open outline tells of a crowd to leave: water that is evenly drawn out has none, and shifted particles
//! carried their velocities to the wrong places there (decision 0022).

use rayon::prelude::*;

use super::pairs::{BLOCK, Group, LANES, Pairs, gather_gradients, gather_states, greatest, measure, total};
use super::{Balanced, Begun, Gradients, State};
use crate::math::{Sym2, Vec2, clamp, larger, smaller};
use crate::methods::{Reconstruction, Stabilisation};
use crate::physics::celerity;
use crate::physics::dimension::Dimension;
use crate::physics::flux::{FaceSolver, LaxFriedrichs, Side, TwoShocks, TwoWaves};
use crate::physics::limiter::half_monotonised;
use crate::solver::moving::{CHUNK, CHUNKS_AT_ONCE, ChosenKernel, MovingWater, Rates, correction, is_inverted};

/// α: how fast carried depths follow the arrangement of the particles.
const RELAXATION: f64 = 0.5;
/// κ of velocities: the weight of the difference towards the face, at which linear slopes are exact to the third order.
const KAPPA_VELOCITIES: f64 = 1.0 / 3.0;
/// κ of levels. With that of velocities an oscillating bowl loses half as much again (decision 0036).
const KAPPA_LEVELS: f64 = 0.1;
/// κ of depths: the mean of both differences.
const KAPPA_DEPTHS: f64 = 0.0;
/// Share of the speed of their neighbours with which particles leave a crowd.
const SHIFT: f64 = 0.3;
/// The moment of contacts counts so many times: half of what an inverse needs suffices to know the surface.
const ENOUGH_CONTACT: f64 = 2.0;
/// Froude number squared from which on a particle without support feels the whole slope.
const FREE_FROUDE_SQUARED: f64 = 0.25;
/// A face with less water (m) than this is dry.
const DRY_FACE: f64 = 1e-9;

/// What a thread works in.
#[derive(Debug)]
pub(super) struct RateScratch {
    pairs: Pairs,
    sums: [Sums; CHUNK],
    list: Vec<u32>,
}

impl Default for RateScratch {
    fn default() -> Self {
        RateScratch { pairs: Pairs::new(), sums: [Sums::default(); CHUNK], list: Vec::new() }
    }
}

/// The sums over the pair faces of one particle.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// Σ 2 A_j G_ij (L e) [p* − g d_l²/2 + g d_i a_1] (m³/s²·1/m).
    force: Vec2,
    /// Σ [k_d (D3 + D2) + (1 − k_d) D1] (1/s).
    divergence: f64,
    /// Σ A_j G_ij (e·L e) d_l c_l / d_i (1/s): how hard the faces resist a motion of i alone.
    stiffness: f64,
    /// M over the pairs whose waters meet; not so where one stands above the other's surface.
    contact: Sym2,
    /// Greatest speed at which a neighbour approaches (m/s), 0 or more.
    closing: f64,
    /// ṙ_i: largest speed at which a neighbour leaves, or jump left at the face where it approaches (m/s), 0 or more.
    stir: f64,
}

impl Balanced {
    /// Fills `water.rates`.
    pub(super) fn find_rates(&mut self, water: &mut MovingWater) {
        let mut rates = std::mem::take(&mut water.rates);
        rates.resize(water.particles.len(), Rates::default());
        let water_ref = &*water;
        rates.par_chunks_mut(CHUNK).enumerate().with_max_len(CHUNKS_AT_ONCE).for_each(|(chunk, rates)| {
            self.rate_scratch.with(|scratch| self.find_rates_of(water_ref, chunk * CHUNK, scratch, rates));
        });
        water.rates = rates;
    }

    /// The same for the particles of a chunk, from `first` on.
    fn find_rates_of(&self, water: &MovingWater, first: usize, scratch: &mut RateScratch, rates: &mut [Rates]) {
        let RateScratch { pairs, sums, list } = scratch;
        let sums = &mut sums[..rates.len()];
        sums.fill(Sums::default());
        let around = self.around(water, first, bytemuck::cast_slice(rates));
        for i in first..first + sums.len() {
            let ridges = self.ridges_near(water, self.states[i].position);
            for block in water.neighbours.of(i, list).blocks(BLOCK) {
                if !pairs.has_room_for(block) {
                    sum_faces(pairs, sums, &around);
                }
                gather_states(pairs, i, block, &self.states, water.walls.isometries(), ridges);
                gather_gradients(pairs, block, &self.gradients, water.walls.isometries());
            }
        }
        sum_faces(pairs, sums, &around);
        // Apart from the sums: its steps wait for each other, and those of several particles go on side by side.
        for (k, (rates, sums)) in rates.iter_mut().zip(sums).enumerate() {
            *rates = self.rates_of(water, first + k, sums, &bytemuck::must_cast(*rates));
        }
    }

    fn around<'a>(&'a self, water: &MovingWater, first: usize, begun: &'a [Begun]) -> Around<'a> {
        Around {
            first,
            begun,
            edges: &self.edges[first..],
            states: &self.states,
            gradients: &self.gradients,
            kernel: &self.kernel,
            faces: self.faces,
            reconstruction: self.reconstruction,
            gravity: water.gravity,
        }
    }

    fn rates_of(&self, water: &MovingWater, i: usize, sums: &Sums, begun: &Begun) -> Rates {
        let (me, mine, edge) = (&self.states[i], &self.gradients[i], self.edges[i]);
        let approach = sums.closing.max(sums.stir);
        let divergence = mine.u.x + mine.v.y + sums.divergence;
        let inside = 1.0 - edge;
        let openness = begun.openness.norm();
        let shift = sums.closing.max(approach * openness.min(1.0));
        let push = if begun.push > 0.0 { begun.openness / openness * begun.push } else { Vec2::ZERO };
        let relaxation = RELAXATION * begun.out_of_step * sums.stir * me.inverse_h;
        let unsupported = self.unsupported(water, me, sums.contact);
        Rates {
            acceleration: push - sums.force / me.depth - unsupported,
            depth_rate: relaxation - me.depth * divergence,
            shift: begun.openness * (SHIFT * shift * inside),
            approach,
            // The faces slow a lonely motion at the rate Σ A_j G_ij (e·L e) d_l c_l / d_i, of which leapfrog with predicted
            // velocity stands 1/Δt. Inside the water dim c_i over this rate is about h; beside an edge, where L is large,
            // and on steep ground, where d_l exceeds d_i, it is less.
            reach: (1.0 / me.inverse_h).min(
                self.dimension.count() * celerity(me.depth, water.gravity) / sums.stiffness.max(f64::MIN_POSITIVE),
            ),
        }
    }
}

impl Balanced {
    /// The part of g ∇z_b (m/s²) that no neighbour in contact tells a particle of; see the head of this file.
    fn unsupported(&self, water: &MovingWater, me: &State, contact: Sym2) -> Vec2 {
        let scale = |value: f64| ENOUGH_CONTACT * value;
        let contact = Sym2 { xx: scale(contact.xx), xy: scale(contact.xy), yy: scale(contact.yy) };
        if is_inverted(contact) {
            return Vec2::ZERO;
        }
        let mut slope = water.bed_at(me.position).slope;
        if self.dimension == Dimension::One {
            slope.y = 0.0;
        }
        let froude_squared = me.velocity.norm_squared() / (water.gravity * me.depth);
        let share = (froude_squared / FREE_FROUDE_SQUARED).min(1.0);
        (slope - correction(contact).apply(contact.apply(slope))) * (water.gravity * share)
    }
}

/// What the pair faces of the particles of a chunk need.
struct Around<'a> {
    /// The first particle of the chunk.
    first: usize,
    /// Of each particle of the chunk.
    begun: &'a [Begun],
    /// χ, 1 at a free edge, from the chunk on.
    edges: &'a [f64],
    states: &'a [State],
    gradients: &'a [Gradients],
    kernel: &'a ChosenKernel,
    faces: Stabilisation,
    reconstruction: Reconstruction,
    gravity: f64,
}

/// Half the limited difference of a quantity between i and j, from the gradients at i and at j along e; 0 without
/// reconstruction.
#[inline(always)]
fn half_slopes<const IS_LIMITED: bool>(along_i: f64, along_j: f64, difference: f64, kappa: f64) -> (f64, f64) {
    if IS_LIMITED {
        (
            half_monotonised(2.0 * along_i - difference, difference, kappa),
            half_monotonised(2.0 * along_j - difference, difference, kappa),
        )
    } else {
        (0.0, 0.0)
    }
}

/// Adds what is in work to the sums of the chunk, by the chosen Riemann solver, with or without limited slopes, and ends the work.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn sum_faces(pairs: &mut Pairs, sums: &mut [Sums], around: &Around<'_>) {
    match (around.faces, around.reconstruction != Reconstruction::None) {
        (Stabilisation::TwoWaves, true) => sum_faces_by::<TwoWaves, true>(pairs, sums, around),
        (Stabilisation::TwoWaves, false) => sum_faces_by::<TwoWaves, false>(pairs, sums, around),
        (Stabilisation::LaxFriedrichs, true) => sum_faces_by::<LaxFriedrichs, true>(pairs, sums, around),
        (Stabilisation::LaxFriedrichs, false) => sum_faces_by::<LaxFriedrichs, false>(pairs, sums, around),
        (_, true) => sum_faces_by::<TwoShocks, true>(pairs, sums, around),
        (_, false) => sum_faces_by::<TwoShocks, false>(pairs, sums, around),
    }
}

#[inline(always)]
fn sum_faces_by<F: FaceSolver, const IS_LIMITED: bool>(pairs: &mut Pairs, sums: &mut [Sums], around: &Around<'_>) {
    let g = around.gravity;
    measure(pairs, around.states, around.kernel);
    let (states, gradients) = (around.states, around.gradients);
    for k in 0..pairs.count() {
        let (i, groups) = pairs.of(k);
        reconstruct_levels::<IS_LIMITED>(groups, &states[i], &gradients[i]);
    }
    for k in 0..pairs.count() {
        let (i, groups) = pairs.of(k);
        reconstruct_velocities::<IS_LIMITED>(groups, &states[i], &gradients[i], g);
    }
    solve::<F>(pairs.all_groups_mut(), g);
    for k in 0..pairs.count() {
        let (i, groups) = pairs.of(k);
        add_up(&mut sums[i - around.first], groups, i, around);
    }
    pairs.clear();
}

// Four loops over the pairs, and that of `measure`, instead of one: the steps of a pair wait for each other, and short loops keep many pairs on their way.

/// The first: levels and depths on both sides of each face from limited slopes.
#[inline(always)]
fn reconstruct_levels<const IS_LIMITED: bool>(groups: &mut [Group], me: &State, mine: &Gradients) {
    for group in groups {
        let Group { state, gradients: theirs, r, e_x, e_y, own_depth, d_l, d_r, slope, surface_jump, .. } = group;
        for k in 0..LANES {
            let (x, y) = (r[k] * e_x[k], r[k] * e_y[k]);
            let (d_eta, d_d) = (state.surface[k] - me.surface, state.depth[k] - me.depth);
            let (a_1, a_2) = half_slopes::<IS_LIMITED>(
                mine.surface.x * x + mine.surface.y * y,
                theirs.surface_x[k] * x + theirs.surface_y[k] * y,
                d_eta,
                KAPPA_LEVELS,
            );
            let (s_1, s_2) = half_slopes::<IS_LIMITED>(
                mine.depth.x * x + mine.depth.y * y,
                theirs.depth_x[k] * x + theirs.depth_y[k] * y,
                d_d,
                KAPPA_DEPTHS,
            );
            let d_ir = clamp(me.depth + s_1, 0.0, 2.0 * me.depth);
            let d_jr = clamp(state.depth[k] - s_2, 0.0, 2.0 * state.depth[k]);
            // Levels relative to η_i, so that a high datum costs no digits.
            let (eta_l, eta_r) = (a_1, d_eta - a_2);
            let z_star = larger(eta_l - d_ir, eta_r - d_jr);
            own_depth[k] = d_ir;
            d_l[k] = clamp(eta_l - z_star, 0.0, d_ir);
            d_r[k] = clamp(eta_r - z_star, 0.0, d_jr);
            slope[k] = a_1;
            surface_jump[k] = d_eta - a_1 - a_2;
        }
    }
}

/// The second: velocities on both sides from limited slopes, and the celerities, whose roots are taken meanwhile.
#[inline(always)]
fn reconstruct_velocities<const IS_LIMITED: bool>(groups: &mut [Group], me: &State, mine: &Gradients, gravity: f64) {
    for group in groups {
        let Group { state, gradients: theirs, r, e_x, e_y, d_l, d_r, c_l, c_r, .. } = group;
        let Group { own_u, other_u, u_l, u_r, velocity_jump, stir, .. } = group;
        for k in 0..LANES {
            (c_l[k], c_r[k]) = ((gravity * d_l[k]).sqrt(), (gravity * d_r[k]).sqrt());
            let (ex, ey) = (e_x[k], e_y[k]);
            let (x, y) = (r[k] * ex, r[k] * ey);
            let u_i = me.velocity.x * ex + me.velocity.y * ey;
            let u_j = state.velocity_x[k] * ex + state.velocity_y[k] * ey;
            let du = u_j - u_i;
            // e·(∇v e): the gradient of u along e.
            let (b_1, b_2) = half_slopes::<IS_LIMITED>(
                (mine.u.x * x + mine.u.y * y) * ex + (mine.v.x * x + mine.v.y * y) * ey,
                (theirs.u_x[k] * x + theirs.u_y[k] * y) * ex + (theirs.v_x[k] * x + theirs.v_y[k] * y) * ey,
                du,
                KAPPA_VELOCITIES,
            );
            (own_u[k], other_u[k]) = (u_i, u_j);
            (u_l[k], u_r[k]) = (u_i + b_1, u_j - b_2);
            velocity_jump[k] = b_1 - b_2;
            stir[k] = if du > 0.0 { du } else { b_1 + b_2 - du };
        }
    }
}

/// The third: the Riemann problem of each face.
#[inline(always)]
fn solve<F: FaceSolver>(groups: &mut [Group], gravity: f64) {
    for Group { d_l, d_r, u_l, u_r, c_l, c_r, p_star, u_star, .. } in groups {
        for k in 0..LANES {
            let left = Side { d: d_l[k], c: c_l[k], u: u_l[k] };
            let right = Side { d: d_r[k], c: c_r[k], u: u_r[k] };
            (p_star[k], u_star[k]) = F::star(left, right, gravity);
        }
    }
}

/// The last: adds the pairs of a particle to its sums.
#[inline(always)]
fn add_up(sums: &mut Sums, groups: &[Group], i: usize, around: &Around<'_>) {
    let (me, k, g) = (&around.states[i], i - around.first, around.gravity);
    let (l, inside) = (around.begun[k].correction, 1.0 - around.edges[k]);
    let (c_i, inverse_depth) = ((g * me.depth).sqrt(), 1.0 / me.depth);
    // On the stack, where they stay in registers.
    let [mut force_x, mut force_y, mut divergence, mut stiffness] = [[0.0; LANES]; 4];
    let [mut contact_xx, mut contact_xy, mut contact_yy, mut closing, mut stir] = [[0.0; LANES]; 5];
    for group in groups {
        let Group { state, r, e_x, e_y, weight, own_depth, d_l, d_r, c_l, .. } = group;
        let Group { own_u, other_u, u_l, p_star, u_star, slope, surface_jump, velocity_jump, .. } = group;
        let depth = &state.depth;
        for k in 0..LANES {
            let (ex, ey, d_l) = (e_x[k], e_y[k], d_l[k]);
            let (u_i, du, u_mean) = (own_u[k], other_u[k] - own_u[k], 0.5 * (own_u[k] + other_u[k]));
            let (is_left_wet, is_right_wet) = (d_l > DRY_FACE, d_r[k] > DRY_FACE);
            let u_wet = u_mean + (u_star[k] - u_mean) * (d_l / own_depth[k]);
            let u_open = larger(u_i, smaller(u_l[k], u_mean));
            let u_right = if is_right_wet { u_wet } else { u_open };
            let u_face = if is_left_wet { u_right } else { u_i };
            let p_right = if is_right_wet { p_star[k] } else { 0.0 };
            let p_star = if is_left_wet { p_right } else { 0.0 };
            let contact = if is_right_wet { weight[k] * r[k] } else { 0.0 };
            let contact = if is_left_wet { contact } else { 0.0 };
            let (shallow, deep) = (smaller(me.depth, depth[k]), larger(me.depth, depth[k]));
            let inverse = 1.0 / (deep * (me.depth + depth[k]));
            let theta = shallow * (me.depth + depth[k]) * inverse;
            let c_mean = 0.5 * (c_i + (g * depth[k]).sqrt());
            let (l_x, l_y) = (l.xx * ex + l.xy * ey, l.xy * ex + l.yy * ey);
            let e_l_e = l_x * ex + l_y * ey;
            let by_velocity = 2.0 * e_l_e * (u_face - u_mean);
            let by_surface = -c_mean * surface_jump[k] * 2.0 * shallow * deep * inverse * inverse_depth;
            let leaving = if du > 0.0 { inside * e_l_e * velocity_jump[k] } else { 0.0 };
            let pressure = 2.0 * weight[k] * (p_star - 0.5 * g * d_l * d_l + g * me.depth * slope[k]);
            force_x[k] += pressure * l_x;
            force_y[k] += pressure * l_y;
            divergence[k] += weight[k] * (theta * (by_surface + leaving) + (1.0 - theta) * by_velocity);
            stiffness[k] += weight[k] * e_l_e * d_l * c_l[k] * inverse_depth;
            contact_xx[k] += contact * ex * ex;
            contact_xy[k] += contact * ex * ey;
            contact_yy[k] += contact * ey * ey;
            closing[k] = larger(closing[k], -du);
            stir[k] = larger(stir[k], group.stir[k]);
        }
    }
    sums.force += Vec2::new(total(force_x), total(force_y));
    sums.divergence += total(divergence);
    sums.stiffness += total(stiffness);
    sums.contact.xx += total(contact_xx);
    sums.contact.xy += total(contact_xy);
    sums.contact.yy += total(contact_yy);
    sums.closing = larger(sums.closing, greatest(closing));
    sums.stir = larger(sums.stir, greatest(stir));
}
