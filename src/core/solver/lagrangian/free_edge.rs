//! The free edge of the water: where nothing but air stands before a particle, its own weight pushes it out.
//!
//! ```text
//! s = |S₀| / A^((dim−1)/dim),  n = S₀/|S₀|,  x_1 = x_i + 1.2 A^(1/dim) n,  x_2 = x_i + 2.4 A^(1/dim) n
//! C_k = Σ A_j W(x_k − x_j, h_j),  χ(C) = clamp((C_0 − C) / 0.2, 0, 1);  χ = 0 where s < 0.25, otherwise χ(max C_k)
//! C′_k = Σ_m w_m [z_b(x_k + ξ_m) < η_i] / Σ_m w_m
//! C_0 = 0.75, 0.7 where the particle sees images in a wall
//! push = χ(max C_k / C′_k) g d_e²/2 · A^((dim−1)/dim) n / V,   d_e = depth of the edge above the bed before it
//! ```
//!
//! It asks whether the place where the water would flow is covered already. Carried depth would never start to flow
//! otherwise: all surface levels of a dam are equal. A gap narrower than two spacings before water, a wall or higher ground is
//! no edge: the same sum is taken at twice the distance, and the greater one counts. So gaps in an irregular arrangement
//! stay at rest.
//!
//! All water that reaches a place counts, also what lies beyond the particle's own neighbours: their share alone takes the
//! widest gaps of a disordered lake for edges. Ground above the surface, a share 1 − C′ of the place, will never be covered: the
//! water at a shore covers half of the place before it, and is at rest.

use super::ridges::share_in_sight;
use super::{Balanced, Standing, State};
use crate::boundary::Image;
use crate::math::Vec2;
use crate::physics::dimension::Dimension;
use crate::solver::moving::{Glance, MovingWater};

/// Below this share of open outline a particle is inside the water.
const LEAST_OPENNESS: f64 = 0.25;
/// Coverage of the place ahead at which an edge begins to count, and the width of the transition.
const COVERED: f64 = 0.75;
/// The same beside a wall, which cuts gaps of up to two spacings into any arrangement; a straight edge covers 0.2.
const COVERED_BESIDE_WALL: f64 = 0.7;
const TRANSITION: f64 = 0.2;
/// Distance of the place ahead, in particle edges; a second look goes twice as far.
const AHEAD: f64 = 1.2;

/// Distance of the samples of the bed around a place, in smoothing lengths.
const SAMPLING: f64 = 0.6;
/// √3 / 2, the distance of two rows.
const HALF_ROOT_3: f64 = 0.866_025_403_784_438_6;
/// A point of a hexagonal lattice and its two rings of neighbours.
const HEXAGON: [Vec2; 19] = [
    Vec2::new(0.0, 0.0),
    Vec2::new(1.0, 0.0),
    Vec2::new(-1.0, 0.0),
    Vec2::new(0.5, HALF_ROOT_3),
    Vec2::new(-0.5, HALF_ROOT_3),
    Vec2::new(0.5, -HALF_ROOT_3),
    Vec2::new(-0.5, -HALF_ROOT_3),
    Vec2::new(2.0, 0.0),
    Vec2::new(-2.0, 0.0),
    Vec2::new(1.5, HALF_ROOT_3),
    Vec2::new(-1.5, HALF_ROOT_3),
    Vec2::new(1.5, -HALF_ROOT_3),
    Vec2::new(-1.5, -HALF_ROOT_3),
    Vec2::new(0.0, 2.0 * HALF_ROOT_3),
    Vec2::new(0.0, -2.0 * HALF_ROOT_3),
    Vec2::new(1.0, 2.0 * HALF_ROOT_3),
    Vec2::new(-1.0, 2.0 * HALF_ROOT_3),
    Vec2::new(1.0, -2.0 * HALF_ROOT_3),
    Vec2::new(-1.0, -2.0 * HALF_ROOT_3),
];

impl Balanced {
    /// Sets χ and the push of particle `i`; `list` is overwritten.
    pub(super) fn find_free_edge(
        &self,
        water: &MovingWater,
        i: usize,
        list: &mut Vec<u32>,
        glance: &mut Glance,
        standing: &mut Standing,
    ) {
        let openness = standing.openness.norm();
        if openness < LEAST_OPENNESS {
            return;
        }
        let seen = water.neighbours.of(i, list);
        let me = &self.states[i];
        let outward = standing.openness / openness;
        let ahead = outward * (AHEAD * self.dimension.edge(me.area));
        let mut cover = [1.0, 2.0].map(|times| self.cover_by(me, me.position, me.position + ahead * times));
        let ridges = self.ridges_near(water, me.position);
        for image in seen.iter() {
            let other = &self.states[image.index as usize];
            let place = water.walls.isometries()[image.transform as usize].point(other.position);
            let in_sight = ridges.map_or(1.0, |bed| share_in_sight(bed, me, other));
            for (k, cover) in cover.iter_mut().enumerate() {
                *cover += in_sight * self.cover_by(other, place, me.position + ahead * (k + 1) as f64);
            }
        }
        let covered = if seen.iter().any(|image| image.transform != 0) { COVERED_BESIDE_WALL } else { COVERED };
        let open_share = |cover: f64| ((covered - cover) / TRANSITION).clamp(0.0, 1.0);
        // More water may reach these places than the particle itself sees, never less: most particles are done here.
        standing.edge = open_share(cover[0].max(cover[1]));
        if standing.edge == 0.0 {
            return;
        }
        let push = self.push(water, i, me.position + ahead * 2.0);
        if push == 0.0 {
            return;
        }
        let places = [1.0, 2.0].map(|times| self.place_ahead(water, me, ahead * times, glance));
        for (cover, &place) in cover.iter_mut().zip(&places) {
            *cover = cover.max(self.cover_at(water, place, glance));
        }
        standing.edge = open_share(cover[0].max(cover[1]));
        if standing.edge > 0.0 {
            let wet = places.map(|place| self.share_below(water, me, place, glance));
            standing.push = push * open_share((cover[0] / wet[0]).max(cover[1] / wet[1]));
        }
    }

    /// A W: how far the water of a particle seen at `place` covers another place.
    #[inline(always)]
    fn cover_by(&self, particle: &State, place: Vec2, covered: Vec2) -> f64 {
        particle.area * self.kernel.value((covered - place).norm(), particle.inverse_h)
    }

    /// The place at an offset from a particle; of one behind a wall, the place before the wall whose image it is.
    fn place_ahead(&self, water: &MovingWater, me: &State, ahead: Vec2, glance: &mut Glance) -> Vec2 {
        water.walls.travel(me.position, me.position + ahead, &mut glance.near).position
    }

    /// Σ A W over all particles that reach a place.
    fn cover_at(&self, water: &MovingWater, place: Vec2, glance: &mut Glance) -> f64 {
        let isometries = water.walls.isometries();
        let images = water.neighbours.at(place, &water.particles.position, &water.walls, glance);
        let cover = |image: &Image| {
            let other = &self.states[image.index as usize];
            self.cover_by(other, isometries[image.transform as usize].point(other.position), place)
        };
        images.iter().map(cover).sum::<f64>()
    }

    /// Kernel mean of the ground below the surface of `me` around a place, by the points of a hexagonal lattice.
    fn share_below(&self, water: &MovingWater, me: &State, place: Vec2, glance: &mut Glance) -> f64 {
        let (mut below, mut all) = (0.0, 0.0);
        for point in HEXAGON {
            if self.dimension == Dimension::One && point.y != 0.0 {
                continue;
            }
            let offset = point * (SAMPLING / me.inverse_h);
            let weight = self.kernel.value(offset.norm(), me.inverse_h);
            let sample = water.walls.travel(place, place + offset, &mut glance.near).position;
            all += weight;
            if water.bed_at(sample).elevation < me.surface {
                below += weight;
            }
        }
        below / all
    }

    /// Acceleration (m/s²) of a particle whose whole side is open.
    fn push(&self, water: &MovingWater, i: usize, farther: Vec2) -> f64 {
        let me = &self.states[i];
        let bed_ahead = [0.25, 0.5, 0.75, 1.0]
            .into_iter()
            .map(|share| water.bed_at(me.position + (farther - me.position) * share).elevation)
            .fold(water.bed.sill(me.position, farther), f64::max);
        if bed_ahead >= me.surface || water.walls.is_walled(me.position, farther) {
            return 0.0;
        }
        let depth = (me.surface - bed_ahead).clamp(0.0, me.depth);
        0.5 * water.gravity * depth * depth * self.dimension.side(me.area) / water.particles.volume[i]
    }
}
