//! Corrected gradients from the pair faces, and the open length of each particle's outline.
//!
//! ```text
//! G_ij = (|W'(r, h_i)| + |W'(r, h_j)|) / 2
//! M_i  = Σ A_j G_ij r e eᵀ,   L_i = f(M_i)   (`moving::correction`)
//! ∇q_i = L_i Σ A_j (q_j − q_i) G_ij e
//! S₀_i = −2 A_i Σ A_j G_ij e
//! ```
//!
//! The mean slope of both kernels keeps strong contrasts of volume stable.

use rayon::prelude::*;

use super::{Balanced, Gradients, Local, Seen, State};
use crate::math::{Sym2, Vec2};
use crate::solver::moving::{CHUNK, ChunkNeighbours, MovingWater, correction};

impl Balanced {
    /// Fills `gradients` and `locals`.
    pub(super) fn find_gradients(&mut self, water: &MovingWater) {
        let particles = water.particles.len();
        let mut gradients = std::mem::take(&mut self.gradients);
        let mut locals = std::mem::take(&mut self.locals);
        gradients.resize(particles, Gradients::default());
        locals.resize(particles, Local::default());
        gradients
            .par_chunks_mut(CHUNK)
            .zip(locals.par_chunks_mut(CHUNK))
            .zip(water.neighbours.chunks())
            .enumerate()
            .for_each(|(chunk, ((gradients, locals), near))| {
                for k in 0..gradients.len() {
                    let i = chunk * CHUNK + k;
                    (gradients[k], locals[k]) = self.gradients_of(water, i, k, near);
                    self.find_free_edge(water, i, k, near, &mut locals[k]);
                }
            });
        self.gradients = gradients;
        self.locals = locals;
    }

    fn gradients_of(&self, water: &MovingWater, i: usize, k: usize, near: &ChunkNeighbours) -> (Gradients, Local) {
        let me: &State = &self.states[i];
        let mut moment = Sym2::default();
        let mut sum = Gradients::default();
        let mut closure = Vec2::ZERO;
        let mut partition = me.area * self.kernel.value(0.0, me.inverse_h);
        for &image in near.of(k) {
            let seen = Seen::new(me, image, &self.states, water.walls.isometries());
            if seen.is_far(me) {
                continue;
            }
            let (other, e) = (&seen.state, seen.e);
            let face = seen.face(me, &self.kernel);
            let stretch = face * seen.r;
            moment.xx += stretch * e.x * e.x;
            moment.xy += stretch * e.x * e.y;
            moment.yy += stretch * e.y * e.y;
            closure += e * face;
            partition += other.area * self.kernel.value(seen.r, me.inverse_h);
            sum.surface += e * (face * (other.surface - me.surface));
            sum.depth += e * (face * (other.depth - me.depth));
            sum.u += e * (face * (other.velocity.x - me.velocity.x));
            sum.v += e * (face * (other.velocity.y - me.velocity.y));
        }
        let correction = correction(moment);
        let gradients = Gradients {
            surface: correction.apply(sum.surface),
            depth: correction.apply(sum.depth),
            u: correction.apply(sum.u),
            v: correction.apply(sum.v),
        };
        // S₀ / A^((dim−1)/dim) = −2 A^(1/dim) Σ A_j G e, since A / A^((dim−1)/dim) = A^(1/dim).
        let openness = closure * (-2.0 * self.dimension.edge(me.area));
        (gradients, Local { correction, openness, partition, edge: 0.0, push: Vec2::ZERO })
    }
}
