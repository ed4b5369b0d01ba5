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

use super::{Balanced, Local, State};
use crate::boundary::Image;
use crate::math::Vec2;
use crate::solver::moving::{Glance, MovingWater};

/// Below this share of open outline a particle is inside the water.
const LEAST_OPENNESS: f64 = 0.25;
/// Coverage of the place ahead at which an edge begins to count, and the width of the transition.
const COVERED: f64 = 0.75;
const TRANSITION: f64 = 0.2;
/// Distance of the place ahead, in particle edges; a second look goes twice as far.
const AHEAD: f64 = 1.2;

impl Balanced {
    /// Sets χ and the push of particle `i`.
    pub(super) fn find_free_edge(
        &self,
        water: &MovingWater,
        i: usize,
        images: &[Image],
        glance: &mut Glance,
        local: &mut Local,
    ) {
        let openness = local.openness.norm();
        if openness < LEAST_OPENNESS {
            return;
        }
        let me = &self.states[i];
        let outward = local.openness / openness;
        let ahead = outward * (AHEAD * self.dimension.edge(me.area));
        let mut cover = [1.0, 2.0].map(|times| self.cover_by(me, me.position, me.position + ahead * times));
        for image in images {
            let other = &self.states[image.index as usize];
            let place = water.walls.isometries()[image.transform as usize].point(other.position);
            for (k, cover) in cover.iter_mut().enumerate() {
                *cover += self.cover_by(other, place, me.position + ahead * (k + 1) as f64);
            }
        }
        // What the particle itself sees covers no more than what reaches the places: most particles are done here.
        if cover[0].max(cover[1]) >= COVERED {
            return;
        }
        let covered = (1..3).map(|k| self.cover_at(water, me.position, me.position + ahead * f64::from(k), glance));
        let covered = covered.fold(cover[0].max(cover[1]), f64::max);
        local.edge = ((COVERED - covered) / TRANSITION).clamp(0.0, 1.0);
        if local.edge > 0.0 {
            local.push = outward * (local.edge * self.push(water, i, me.position + ahead * 2.0));
        }
    }

    /// A W: how far the water of a particle seen at `place` covers another place.
    #[inline(always)]
    fn cover_by(&self, particle: &State, place: Vec2, covered: Vec2) -> f64 {
        particle.area * self.kernel.value((covered - place).norm(), particle.inverse_h)
    }

    /// Σ A W over all particles that reach a place as seen from `from`; behind a wall, that of the place before it.
    fn cover_at(&self, water: &MovingWater, from: Vec2, place: Vec2, glance: &mut Glance) -> f64 {
        let place = water.walls.travel(from, place, &mut Vec::new()).position;
        let isometries = water.walls.isometries();
        let images = water.neighbours.at(place, &water.particles.position, &water.walls, glance);
        let cover = |image: &Image| {
            let other = &self.states[image.index as usize];
            self.cover_by(other, isometries[image.transform as usize].point(other.position), place)
        };
        images.iter().map(cover).sum()
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
