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
//!
//! The smoothing lengths of the next evaluation come out of the same pass:
//!
//! ```text
//! h_i = κ a_i^(1/dim),   a_i = max(A_i, Σ w A_j / Σ w),   w = W(r / max(h_i, h_j)) / W(0)
//! ```
//!
//! Without the smoothing of the areas a thin particle beside deep ones loses touch with its own kind, and bores over thin
//! water blow up.

use rayon::prelude::*;

use super::pairs::{BLOCK, LaneSum, Pairs, measure_and_cover};
use super::{Balanced, Gradients, Local, State};
use crate::bed::BedParticles;
use crate::boundary::{Image, Isometry};
use crate::math::{Sym2, Vec2};
use crate::solver::moving::{CHUNK, ChosenKernel, Glance, MovingWater, correction};

impl Balanced {
    /// Fills `gradients`, `locals` and `lengths`.
    pub(super) fn find_gradients(&mut self, water: &MovingWater) {
        let particles = water.particles.len();
        let mut gradients = std::mem::take(&mut self.gradients);
        let mut locals = std::mem::take(&mut self.locals);
        let mut lengths = std::mem::take(&mut self.lengths);
        gradients.resize(particles, Gradients::default());
        locals.resize(particles, Local::default());
        lengths.resize(particles, 0.0);
        gradients
            .par_chunks_mut(CHUNK)
            .zip(locals.par_chunks_mut(CHUNK))
            .zip(lengths.par_chunks_mut(CHUNK))
            .zip(water.neighbours.chunks())
            .enumerate()
            .for_each(|(chunk, (((gradients, locals), lengths), near))| {
                let (mut pairs, mut glance) = (Pairs::new(), Glance::default());
                for k in 0..gradients.len() {
                    let i = chunk * CHUNK + k;
                    let sums = sum_pairs(
                        &mut pairs,
                        &self.states[i],
                        near.of(k),
                        &self.states,
                        water.walls.isometries(),
                        &self.kernel,
                        self.ridges_near(water, self.states[i].position),
                    );
                    (gradients[k], locals[k]) = self.finish(&self.states[i], &sums);
                    lengths[k] = self.next_smoothing_length(&self.states[i], &sums);
                    self.find_free_edge(water, i, near.of(k), &mut glance, &mut locals[k]);
                }
            });
        self.gradients = gradients;
        self.locals = locals;
        self.lengths = lengths;
    }

    fn finish(&self, me: &State, sums: &Sums) -> (Gradients, Local) {
        let moment = Sym2 { xx: sums.moment_xx.total(), xy: sums.moment_xy.total(), yy: sums.moment_yy.total() };
        let vector = |x: &LaneSum, y: &LaneSum| Vec2::new(x.total(), y.total());
        let correction = correction(moment);
        let gradients = Gradients {
            surface: correction.apply(vector(&sums.surface_x, &sums.surface_y)),
            depth: correction.apply(vector(&sums.depth_x, &sums.depth_y)),
            u: correction.apply(vector(&sums.u_x, &sums.u_y)),
            v: correction.apply(vector(&sums.v_x, &sums.v_y)),
        };
        // S₀ / A^((dim−1)/dim) = −2 A^(1/dim) Σ A_j G e, since A / A^((dim−1)/dim) = A^(1/dim).
        let openness = vector(&sums.closure_x, &sums.closure_y) * (-2.0 * self.dimension.edge(me.area));
        let own = me.area * self.kernel.at_zero(me.inverse_h);
        let partition = own + sums.partition.total();
        let mean_depth = (own * me.depth + sums.depth_sum.total()) / partition;
        let backing = openness.dot(moment.apply(openness)) / openness.norm_squared().max(f64::MIN_POSITIVE);
        (gradients, Local { correction, openness, partition, mean_depth, backing, edge: 0.0, push: Vec2::ZERO })
    }

    fn next_smoothing_length(&self, me: &State, sums: &Sums) -> f64 {
        let smoothed = (me.area + sums.weighted_area.total()) / (1.0 + sums.weights.total());
        self.factor * self.dimension.edge(me.area.max(smoothed))
    }
}

/// The sums over the pairs of one particle.
#[derive(Default)]
struct Sums {
    moment_xx: LaneSum,
    moment_xy: LaneSum,
    moment_yy: LaneSum,
    closure_x: LaneSum,
    closure_y: LaneSum,
    partition: LaneSum,
    depth_sum: LaneSum,
    surface_x: LaneSum,
    surface_y: LaneSum,
    depth_x: LaneSum,
    depth_y: LaneSum,
    u_x: LaneSum,
    u_y: LaneSum,
    v_x: LaneSum,
    v_y: LaneSum,
    weights: LaneSum,
    weighted_area: LaneSum,
}

#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn sum_pairs(
    pairs: &mut Pairs,
    me: &State,
    images: &[Image],
    states: &[State],
    isometries: &[Isometry],
    kernel: &ChosenKernel,
    ridges: Option<&BedParticles>,
) -> Sums {
    let mut sums = Sums::default();
    for images in images.chunks(BLOCK) {
        pairs.gather_states(me, images, states, isometries, ridges);
        measure_and_cover(pairs, me.inverse_h, kernel);
        let n = pairs.len();
        let (r, weight) = (&pairs.r[..n], &pairs.weight[..n]);
        let (e_x, e_y) = (&pairs.e_x[..n], &pairs.e_y[..n]);
        let (area, depth) = (&pairs.area[..n], &pairs.depth[..n]);
        let [a, b, c, d, ..] = &mut pairs.terms;
        let (a, b, c, d) = (&mut a[..n], &mut b[..n], &mut c[..n], &mut d[..n]);
        sums.weights.add(a);
        sums.partition.add(b);
        for k in 0..n {
            c[k] = b[k] * depth[k];
        }
        sums.depth_sum.add(c);
        for k in 0..n {
            let stretch = weight[k] * r[k];
            b[k] = a[k] * area[k];
            a[k] = stretch * e_x[k] * e_x[k];
            c[k] = stretch * e_x[k] * e_y[k];
            d[k] = stretch * e_y[k] * e_y[k];
        }
        sums.weighted_area.add(b);
        sums.moment_xx.add(a);
        sums.moment_xy.add(c);
        sums.moment_yy.add(d);
        for k in 0..n {
            c[k] = weight[k] * e_x[k];
            d[k] = weight[k] * e_y[k];
        }
        sums.closure_x.add(c);
        sums.closure_y.add(d);
        let differences = [
            (&pairs.surface, me.surface, &mut sums.surface_x, &mut sums.surface_y),
            (&pairs.depth, me.depth, &mut sums.depth_x, &mut sums.depth_y),
            (&pairs.velocity_x, me.velocity.x, &mut sums.u_x, &mut sums.u_y),
            (&pairs.velocity_y, me.velocity.y, &mut sums.v_x, &mut sums.v_y),
        ];
        for (values, mine, sum_x, sum_y) in differences {
            let values = &values[..n];
            for k in 0..n {
                a[k] = c[k] * (values[k] - mine);
                b[k] = d[k] * (values[k] - mine);
            }
            sum_x.add(a);
            sum_y.add(b);
        }
    }
    sums
}
