//! Summed depth and smoothing length of each particle, found together by Newton's method, and the gradients for limited
//! reconstruction.
//!
//! With S(h) = Σ m_j W(r, h) and h tied to d, the derivative of d − S at the solution is β, so that d ← d + (S − d)/β.

use rayon::prelude::*;

use super::correction::correction;
use super::{CHUNK, Density, MovingWater, SLACK, Seen, Variational, with_kernel};
use crate::math::{Sym2, Vec2};
use crate::methods::Reconstruction;
use crate::physics::kernel::{Shape, Smoothing};

const MOST_ROUNDS: usize = 30;
const TOLERANCE: f64 = 1e-10;
/// A lonely particle has β = 0; below this the step of Newton's method is damped.
const LEAST_BETA: f64 = 0.3;

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
        let volume = particles.volume[i];
        let h_limit = SLACK * particles.smoothing_length[i];
        // The smoothing length may not outgrow the search: so the depth has a floor.
        let floor = match self.dimension {
            crate::physics::dimension::Dimension::One => volume * self.factor / h_limit,
            crate::physics::dimension::Dimension::Two => volume * (self.factor / h_limit).powi(2),
        }
        .max(water.dry_depth);
        let mut d = particles.depth[i].max(floor);
        let (mut inverse_h, mut beta) = (0.0, 1.0);
        for _ in 0..MOST_ROUNDS {
            inverse_h = 1.0 / (self.factor * self.dimension.edge(volume / d));
            let mut sum = volume * kernel.value(0.0, inverse_h);
            let mut moment = 0.0;
            for image in images.iter() {
                let j = image.index as usize;
                let other = water.walls.isometries()[image.transform as usize].point(particles.position[j]);
                let r = (other - particles.position[i]).norm();
                sum += particles.volume[j] * kernel.value(r, inverse_h);
                moment -= particles.volume[j] * r * kernel.slope(r, inverse_h);
            }
            beta = (moment / (self.dimension.count() * d)).max(LEAST_BETA);
            let next = (d + (sum - d) / beta).clamp(0.7 * d, 1.4 * d).max(floor);
            let change = (next - d).abs();
            d = next;
            if change <= TOLERANCE * d {
                break;
            }
        }
        let mut density = Density { depth: d, inverse_h, beta, ..Density::default() };
        if self.reconstruction != Reconstruction::None {
            self.find_gradients(kernel, water, i, images, &mut density);
        }
        density
    }

    /// Corrected gradients over the particle's own kernel; depths of neighbours are those of the latest evaluation.
    fn find_gradients<S: Shape>(
        &self,
        kernel: &Smoothing<S>,
        water: &MovingWater,
        i: usize,
        images: Seen<'_>,
        density: &mut Density,
    ) {
        let particles = &water.particles;
        let (mut moment, mut depth, mut u, mut v) = (Sym2::default(), Vec2::ZERO, Vec2::ZERO, Vec2::ZERO);
        for image in images.iter() {
            let j = image.index as usize;
            let isometry = &water.walls.isometries()[image.transform as usize];
            let offset = isometry.point(particles.position[j]) - particles.position[i];
            let r = offset.norm().max(f64::MIN_POSITIVE);
            let e = offset / r;
            let face = -particles.volume[j] / particles.depth[j] * kernel.slope(r, density.inverse_h);
            let difference = isometry.vector(particles.velocity[j]) - particles.velocity[i];
            moment.xx += face * r * e.x * e.x;
            moment.xy += face * r * e.x * e.y;
            moment.yy += face * r * e.y * e.y;
            depth += e * (face * (particles.depth[j] - particles.depth[i]));
            u += e * (face * difference.x);
            v += e * (face * difference.y);
        }
        let correction = correction(moment);
        density.grad_depth = correction.apply(depth);
        density.grad_u = correction.apply(u);
        density.grad_v = correction.apply(v);
    }
}
