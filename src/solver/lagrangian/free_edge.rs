//! The free edge of the water: where nothing but air stands before a particle, its own weight pushes it out.
//!
//! ```text
//! s = |S₀| / A^((dim−1)/dim),  n = S₀/|S₀|;  χ = 0 where s < 0.25, otherwise
//! χ = clamp((0.75 − Σ A_j W(x_i + 1.2 A^(1/dim) n − x_j, h_j)) / 0.2, 0, 1)
//! push = χ g δ²/2 · A^((dim−1)/dim) n / V,   δ = depth of the edge above the bed before it
//! ```
//!
//! It asks whether the place where the water would flow is covered already. Carried depth would never start to flow
//! otherwise: all surface levels of a dam are equal. A gap narrower than two spacings before water, a wall or higher ground is
//! no edge: the same sum is taken at twice the distance, and the greater one counts. So shorelines and gaps in an
//! irregular arrangement stay at rest.

use super::{Balanced, Local};
use crate::boundary::Image;
use crate::math::Vec2;
use crate::physics::kernel::{Shape, Smoothing};
use crate::solver::moving::{ChunkNeighbours, MovingWater, with_kernel};

/// Below this share of open outline a particle is inside the water.
const LEAST_OPENNESS: f64 = 0.25;
/// Coverage of the place ahead at which an edge begins to count, and the width of the transition.
const COVERED: f64 = 0.75;
/// The same beside a wall, which cuts gaps of up to two spacings into any arrangement; a straight edge covers 0.2.
const COVERED_BESIDE_WALL: f64 = 0.55;
const TRANSITION: f64 = 0.2;
/// Distance of the place ahead, in particle edges; a second look goes twice as far.
const AHEAD: f64 = 1.2;

impl Balanced {
    /// Sets χ and the push of particle `i`, at place `k` of its chunk.
    pub(super) fn find_free_edge(
        &self,
        water: &MovingWater,
        i: usize,
        k: usize,
        near: &ChunkNeighbours,
        local: &mut Local,
    ) {
        let openness = local.openness.norm();
        if openness < LEAST_OPENNESS {
            return;
        }
        let me = &self.states[i];
        let edge_length = self.dimension.edge(me.area);
        let outward = local.openness / openness;
        let ahead = me.position + outward * (AHEAD * edge_length);
        let farther = me.position + outward * (2.0 * AHEAD * edge_length);
        let images = near.of(k);
        let (cover, farther_cover) = with_kernel!(&self.kernel, kernel => {
            let own = me.area * kernel.value(AHEAD * edge_length, me.inverse_h);
            self.cover(kernel, water, images, (ahead, farther), own)
        });
        let is_beside_wall = images.iter().any(|image| image.transform != 0);
        let covered = if is_beside_wall { COVERED_BESIDE_WALL } else { COVERED };
        local.edge = ((covered - cover.max(farther_cover)) / TRANSITION).clamp(0.0, 1.0);
        if local.edge > 0.0 {
            local.push = outward * (local.edge * self.push(water, i, farther));
        }
    }

    /// Σ A_j W at two places over what a particle sees, at the first one beside its `own` share.
    fn cover<S: Shape>(
        &self,
        kernel: &Smoothing<S>,
        water: &MovingWater,
        images: &[Image],
        (ahead, farther): (Vec2, Vec2),
        own: f64,
    ) -> (f64, f64) {
        let isometries = water.walls.isometries();
        images.iter().fold((own, 0.0), |(cover, farther_cover), image| {
            let other = &self.states[image.index as usize];
            let place = isometries[image.transform as usize].point(other.position);
            let share = |at: Vec2| other.area * kernel.value((place - at).norm(), other.inverse_h);
            (cover + share(ahead), farther_cover + share(farther))
        })
    }

    /// Acceleration (m/s²) of a particle whose whole side is open.
    fn push(&self, water: &MovingWater, i: usize, farther: Vec2) -> f64 {
        let me = &self.states[i];
        let bed_ahead = [0.25, 0.5, 0.75, 1.0]
            .into_iter()
            .map(|share| water.bed_at(me.position + (farther - me.position) * share).elevation)
            .fold(f64::NEG_INFINITY, f64::max);
        if bed_ahead >= me.surface || water.walls.is_walled(me.position, farther) {
            return 0.0;
        }
        let bed_here = water.bed_points[i].elevation;
        let depth = (me.surface - bed_ahead.max(bed_here)).clamp(0.0, me.depth);
        0.5 * water.gravity * depth * depth * self.dimension.side(me.area) / water.particles.volume[i]
    }
}
