//! The pairs of one particle side by side: what the loops over neighbours read and write, one column for each quantity.
//!
//! Neighbours are gathered in blocks, so that nothing is allocated and everything stays in the first level of the cache; the
//! loops over a block have no branch, and run on as many lanes as the processor has. All sums are taken in the same order
//! whatever that number is.

use super::ridges::share_in_sight;
use super::{Gradients, State};
use crate::bed::BedParticles;
use crate::boundary::{Image, Isometry};
use crate::math::{Vec2, larger, smaller};
use crate::physics::kernel::{Shape, Smoothing};
use crate::solver::moving::{ChosenKernel, with_kernel};

/// Most pairs in a block.
pub(super) const BLOCK: usize = 64;
/// Blocks are filled up to a multiple of this number with pairs that weigh nothing.
pub(super) const LANES: usize = 8;

/// Most terms that one loop over the pairs makes at once.
const TERMS: usize = 8;

/// One quantity of all pairs of a block.
pub(super) type Column = [f64; BLOCK];

/// The neighbours of a particle as it sees them: those behind a wall reflected.
#[derive(Clone, Debug)]
pub(super) struct Pairs {
    /// Number of pairs with those that fill up.
    len: usize,
    /// x_j − x_i (m).
    pub offset_x: Column,
    pub offset_y: Column,
    pub velocity_x: Column,
    pub velocity_y: Column,
    pub depth: Column,
    pub surface: Column,
    pub area: Column,
    pub inverse_h: Column,
    pub surface_x: Column,
    pub surface_y: Column,
    pub depth_x: Column,
    pub depth_y: Column,
    pub u_x: Column,
    pub u_y: Column,
    pub v_x: Column,
    pub v_y: Column,
    /// Distance r (m).
    pub r: Column,
    /// e, the unit vector from i to j; zero where both coincide.
    pub e_x: Column,
    pub e_y: Column,
    /// A_j G_ij (1/m).
    pub weight: Column,
    /// Terms of sums on their way.
    pub terms: [Column; TERMS],
}

impl Pairs {
    pub(super) fn new() -> Self {
        let zero = [0.0; BLOCK];
        Pairs {
            len: 0,
            offset_x: zero,
            offset_y: zero,
            velocity_x: zero,
            velocity_y: zero,
            depth: zero,
            surface: zero,
            area: zero,
            inverse_h: zero,
            surface_x: zero,
            surface_y: zero,
            depth_x: zero,
            depth_y: zero,
            u_x: zero,
            u_y: zero,
            v_x: zero,
            v_y: zero,
            r: zero,
            e_x: zero,
            e_y: zero,
            weight: zero,
            terms: [zero; TERMS],
        }
    }

    /// Number of pairs in work, a multiple of the lanes.
    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Gathers the states of one block of neighbours, `BLOCK` at most; beside `ridges` with the share of their area that is in sight.
    pub(super) fn gather_states(
        &mut self,
        me: &State,
        images: &[Image],
        states: &[State],
        isometries: &[Isometry],
        ridges: Option<&BedParticles>,
    ) {
        for (k, image) in images.iter().take(BLOCK).enumerate() {
            let other = &states[image.index as usize];
            let (mut position, mut velocity) = (other.position, other.velocity);
            if image.transform != 0 {
                let isometry = &isometries[image.transform as usize];
                position = isometry.point(position);
                velocity = isometry.vector(velocity);
            }
            self.offset_x[k] = position.x - me.position.x;
            self.offset_y[k] = position.y - me.position.y;
            self.velocity_x[k] = velocity.x;
            self.velocity_y[k] = velocity.y;
            self.depth[k] = other.depth;
            self.surface[k] = other.surface;
            self.area[k] = other.area;
            self.inverse_h[k] = other.inverse_h;
        }
        self.len = images.len().min(BLOCK).next_multiple_of(LANES);
        for k in images.len().min(BLOCK)..self.len {
            self.set_nothing(k, me);
        }
        if let Some(bed) = ridges {
            self.hide(me, images, states, bed);
        }
    }

    /// Takes from the area of each pair what ridges hide of it; apart, so that the loop above stays as short without them.
    #[cold]
    fn hide(&mut self, me: &State, images: &[Image], states: &[State], bed: &BedParticles) {
        for (k, image) in images.iter().take(BLOCK).enumerate() {
            let in_sight = share_in_sight(bed, me, &states[image.index as usize]);
            if in_sight > 0.0 {
                self.area[k] *= in_sight;
            } else {
                self.set_nothing(k, me);
            }
        }
    }

    /// A particle's pair with itself, of no area: it adds nothing to any sum.
    #[inline(always)]
    fn set_nothing(&mut self, k: usize, me: &State) {
        (self.offset_x[k], self.offset_y[k]) = (0.0, 0.0);
        (self.velocity_x[k], self.velocity_y[k]) = (me.velocity.x, me.velocity.y);
        (self.depth[k], self.surface[k]) = (me.depth, me.surface);
        (self.area[k], self.inverse_h[k]) = (0.0, me.inverse_h);
    }

    /// Gathers the gradients of the same neighbours, turned as the particle sees them.
    pub(super) fn gather_gradients(
        &mut self,
        mine: &Gradients,
        images: &[Image],
        gradients: &[Gradients],
        isometries: &[Isometry],
    ) {
        for (k, image) in images.iter().take(BLOCK).enumerate() {
            let mut other = gradients[image.index as usize];
            if image.transform != 0 {
                other = other.reflected(&isometries[image.transform as usize]);
            }
            self.set_gradients(k, &other);
        }
        for k in images.len().min(BLOCK)..self.len {
            self.set_gradients(k, mine);
        }
    }

    #[inline(always)]
    fn set_gradients(&mut self, k: usize, gradients: &Gradients) {
        (self.surface_x[k], self.surface_y[k]) = (gradients.surface.x, gradients.surface.y);
        (self.depth_x[k], self.depth_y[k]) = (gradients.depth.x, gradients.depth.y);
        (self.u_x[k], self.u_y[k]) = (gradients.u.x, gradients.u.y);
        (self.v_x[k], self.v_y[k]) = (gradients.v.x, gradients.v.y);
    }

    /// Distances, directions and weights from offsets, areas and smoothing lengths. `COVERS`: puts the weight w of each pair's area
    /// into the first column of `terms`, A_j W(r, h_i) into the second.
    #[inline(always)]
    fn measure_with<S: Shape, const COVERS: bool>(&mut self, inverse_h: f64, kernel: &Smoothing<S>) {
        let n = self.len;
        let (x, y) = (&self.offset_x[..n], &self.offset_y[..n]);
        let (area, other_inverse_h) = (&self.area[..n], &self.inverse_h[..n]);
        let (r, weight) = (&mut self.r[..n], &mut self.weight[..n]);
        let (e_x, e_y) = (&mut self.e_x[..n], &mut self.e_y[..n]);
        let [shares, covered, ..] = &mut self.terms;
        let (shares, covered) = (&mut shares[..n], &mut covered[..n]);
        for k in 0..n {
            let distance = (x[k] * x[k] + y[k] * y[k]).sqrt();
            let inverse = 1.0 / larger(distance, f64::MIN_POSITIVE);
            let slopes = kernel.slope(distance, inverse_h) + kernel.slope(distance, other_inverse_h[k]);
            r[k] = distance;
            e_x[k] = x[k] * inverse;
            e_y[k] = y[k] * inverse;
            weight[k] = -0.5 * area[k] * slopes;
            if COVERS {
                // The pairs that fill up have no area and must not count.
                let is_real = if area[k] > 0.0 { 1.0 } else { 0.0 };
                shares[k] = is_real * kernel.share(distance, smaller(inverse_h, other_inverse_h[k]));
                covered[k] = area[k] * kernel.value(distance, inverse_h);
            }
        }
    }
}

/// Distances, directions and weights of all pairs, by the chosen kernel.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
pub(super) fn measure(pairs: &mut Pairs, inverse_h: f64, kernel: &ChosenKernel) {
    with_kernel!(kernel, kernel => pairs.measure_with::<_, false>(inverse_h, kernel));
}

/// The same, with the weight w of each pair's area in the first column of `terms`, and A_j W(r, h_i) in the second.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
pub(super) fn measure_and_cover(pairs: &mut Pairs, inverse_h: f64, kernel: &ChosenKernel) {
    with_kernel!(kernel, kernel => pairs.measure_with::<_, true>(inverse_h, kernel));
}

impl Gradients {
    /// The gradients as seen in a mirror.
    fn reflected(&self, isometry: &Isometry) -> Gradients {
        // T' = R T Rᵀ for the gradient of the velocity: first the rows, then the columns.
        let (u, v) = (isometry.vector(self.u), isometry.vector(self.v));
        let (along_x, along_y) = (isometry.vector(Vec2::new(u.x, v.x)), isometry.vector(Vec2::new(u.y, v.y)));
        Gradients {
            surface: isometry.vector(self.surface),
            depth: isometry.vector(self.depth),
            u: Vec2::new(along_x.x, along_y.x),
            v: Vec2::new(along_x.y, along_y.y),
        }
    }
}

/// A sum over the pairs of all blocks, kept in lanes until its end.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LaneSum([f64; LANES]);

impl LaneSum {
    #[inline(always)]
    pub(super) fn add(&mut self, values: &[f64]) {
        for values in values.as_chunks::<LANES>().0 {
            for (sum, value) in self.0.iter_mut().zip(values) {
                *sum += value;
            }
        }
    }

    #[inline(always)]
    pub(super) fn total(&self) -> f64 {
        let [a, b, c, d, e, f, g, h] = self.0;
        ((a + b) + (c + d)) + ((e + f) + (g + h))
    }
}

/// The greatest value over the pairs of all blocks.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LaneMaximum([f64; LANES]);

impl LaneMaximum {
    #[inline(always)]
    pub(super) fn add(&mut self, values: &[f64]) {
        for values in values.as_chunks::<LANES>().0 {
            for (most, &value) in self.0.iter_mut().zip(values) {
                *most = larger(*most, value);
            }
        }
    }

    #[inline(always)]
    pub(super) fn total(&self) -> f64 {
        self.0.into_iter().fold(0.0, f64::max)
    }
}
