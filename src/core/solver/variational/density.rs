//! Summed depth and smoothing length of each particle, found together by Newton's method, and the gradients for limited
//! reconstruction.
//!
//! With S(h) = Σ m_j W(r, h_ij) and h tied to d, d ← d + (S − d)/(1 − dS/dd).

use rayon::prelude::*;

use super::correction::correction;
use super::{CHUNK, Density, MovingWater, SLACK, Seen, Variational, inverse_of_pair, with_kernel};
use crate::math::{Sym2, Vec2};
use crate::physics::kernel::{Shape, Smoothing};

const MOST_ROUNDS: usize = 30;
/// Relative: what is left drives still water.
const TOLERANCE: f64 = 1e-13;
/// Below this rate of d − S the step of Newton's method is damped.
const LEAST_RATE: f64 = 0.3;

impl Variational {
    /// Sets depth and smoothing length of all particles, and `densities`.
    pub(super) fn sum_depths(&mut self, water: &mut MovingWater) {
        let mut densities = std::mem::take(&mut self.densities);
        densities.resize(water.particles.len(), Density::default());
        let around = &*water;
        densities.par_chunks_mut(CHUNK).enumerate().for_each_init(Vec::new, |list, (chunk, densities)| {
            for (k, density) in densities.iter_mut().enumerate() {
                let i = chunk * CHUNK + k;
                let seen = around.neighbours.of(i, list);
                *density = with_kernel!(&self.kernel, kernel => self.density_of(kernel, around, i, seen));
            }
        });
        for (i, density) in densities.iter().enumerate() {
            water.particles.depth[i] = density.depth;
            water.particles.smoothing_length[i] = 1.0 / density.inverse_h;
        }
        self.densities = densities;
    }

    fn density_of<S: Shape>(&self, kernel: &Smoothing<S>, water: &MovingWater, i: usize, images: Seen<'_>) -> Density {
        let particles = &water.particles;
        let (volume, share) = (particles.volume[i], particles.share[i]);
        let h_limit = SLACK * particles.smoothing_length[i];
        // The smoothing length may not outgrow the search: so the depth has a floor.
        let floor = match self.dimension {
            crate::physics::dimension::Dimension::One => share * self.factor / h_limit,
            crate::physics::dimension::Dimension::Two => share * (self.factor / h_limit).powi(2),
        }
        .max(water.dry_depth);
        let count = self.dimension.count();
        let mut d = particles.depth[i].max(floor);
        let (mut inverse_h, mut raw_beta) = (0.0, 1.0);
        for _ in 0..MOST_ROUNDS {
            inverse_h = 1.0 / (self.factor * self.dimension.edge(share / d));
            let h_squared = inverse_h.powi(-2);
            // Of the sum, its first moment, and the part of dim S that follows the own smoothing length.
            let mut sum = volume * kernel.value(0.0, inverse_h);
            let (mut moment, mut own) = (0.0, count * sum);
            for image in images.iter() {
                let j = image.index as usize;
                let other = water.walls.isometries()[image.transform as usize].point(particles.position[j]);
                let r = (other - particles.position[i]).norm();
                let of_pair = inverse_of_pair(h_squared, particles.smoothing_length[j].powi(2));
                let (share, slope) = (particles.volume[j] * kernel.value(r, of_pair), r * kernel.slope(r, of_pair));
                sum += share;
                moment -= particles.volume[j] * slope;
                own += 0.5 * h_squared * of_pair * of_pair * (count * share + particles.volume[j] * slope);
            }
            raw_beta = moment / (count * d);
            let rate = (1.0 - own / (count * d)).max(LEAST_RATE);
            let next = (d + (sum - d) / rate).clamp(0.7 * d, 1.4 * d).max(floor);
            let change = (next - d).abs();
            d = next;
            if change <= TOLERANCE * d {
                break;
            }
        }
        Density { depth: d, inverse_h, raw_beta, ..Density::default() }
    }

    /// V̂, by which the smoothing length follows the depth: that of a plane area A at the start, h = k_h A^(1/dim) whatever the water there.
    pub(super) fn weigh(&mut self, water: &mut MovingWater) {
        let around = &*water;
        let mut list = Vec::new();
        let sums: Vec<f64> = (0..around.particles.len())
            .map(|i| {
                let particles = &around.particles;
                let inverse_h = 1.0 / particles.smoothing_length[i];
                let own = particles.volume[i] * self.kernel.value(0.0, inverse_h);
                around.neighbours.of(i, &mut list).iter().fold(own, |sum, image| {
                    let j = image.index as usize;
                    let other = around.walls.isometries()[image.transform as usize].point(particles.position[j]);
                    let r = (other - particles.position[i]).norm();
                    sum + particles.volume[j] * self.kernel.value(r, inverse_h)
                })
            })
            .collect();
        let particles = &mut water.particles;
        for (i, depth) in sums.into_iter().enumerate() {
            particles.share[i] = particles.volume[i] / particles.depth[i] * depth.max(water.dry_depth);
            particles.depth[i] = depth.max(water.dry_depth);
        }
    }

    /// Sets the gradients of level and velocity in `densities`.
    pub(super) fn find_gradients(&mut self, water: &MovingWater) {
        let gradients = |i: usize, list: &mut Vec<u32>| with_kernel!(&self.kernel, kernel => self.gradients_of(kernel, water, i, water.neighbours.of(i, list)));
        let found: Vec<[Vec2; 3]> = (0..self.densities.len())
            .into_par_iter()
            .with_min_len(CHUNK)
            .map_init(Vec::new, |list, i| gradients(i, list))
            .collect();
        for (density, [level, u, v]) in self.densities.iter_mut().zip(found) {
            (density.grad_level, density.grad_u, density.grad_v) = (level, u, v);
        }
    }

    /// Corrected gradients over the particle's own kernel.
    fn gradients_of<S: Shape>(
        &self,
        kernel: &Smoothing<S>,
        water: &MovingWater,
        i: usize,
        images: Seen<'_>,
    ) -> [Vec2; 3] {
        let (particles, own) = (&water.particles, &self.densities[i]);
        let (mut moment, mut level, mut u, mut v) = (Sym2::default(), Vec2::ZERO, Vec2::ZERO, Vec2::ZERO);
        for image in images.iter() {
            let j = image.index as usize;
            let isometry = &water.walls.isometries()[image.transform as usize];
            let offset = isometry.point(particles.position[j]) - particles.position[i];
            let r = offset.norm().max(f64::MIN_POSITIVE);
            let e = offset / r;
            let face = -particles.volume[j] / particles.depth[j]
                * kernel.slope(r, inverse_of_pair(own.inverse_h.powi(-2), self.densities[j].inverse_h.powi(-2)));
            let difference = isometry.vector(particles.velocity[j]) - particles.velocity[i];
            moment.xx += face * r * e.x * e.x;
            moment.xy += face * r * e.x * e.y;
            moment.yy += face * r * e.y * e.y;
            level += e * (face * (self.densities[j].level - own.level));
            u += e * (face * difference.x);
            v += e * (face * difference.y);
        }
        let correction = correction(moment);
        [level, u, v].map(|sum| correction.apply(sum))
    }
}
