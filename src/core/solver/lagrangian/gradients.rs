//! Corrected gradients from the pair faces, and the open length of each particle's outline.
//!
//! ```text
//! G_ij = −(W'(r, h_i) + W'(r, h_j)) / 2
//! M_i  = Σ A_j G_ij r e eᵀ,   L_i = f(M_i)   (`moving::correction`)
//! ∇X_i = L_i Σ A_j (X_j − X_i) G_ij e
//! S₀_i = −2 A_i Σ A_j G_ij e
//! ```
//!
//! The mean slope of both kernels keeps strong contrasts of volume stable.
//!
//! The smoothing lengths of the next evaluation come out of the same pass:
//!
//! ```text
//! h_i = k_h Ā_i^(1/dim),   Ā_i = max(A_i, Σ w A_j / Σ w),   w = W(r / max(h_i, h_j)) / W(0)
//! ```
//!
//! Without the smoothing of the areas a thin particle beside deep ones loses touch with its own kind, and bores over thin
//! water blow up.

use rayon::prelude::*;

use super::pairs::{BLOCK, Group, LANES, Pairs, gather_states, measure_and_cover, total};
use super::{Balanced, Begun, Gradients, Standing, State};
use crate::math::{Sym2, Vec2};
use crate::solver::moving::{CHUNK, CHUNKS_AT_ONCE, ChosenKernel, Glance, MovingWater, Rates, correction};

impl Balanced {
    /// Fills `gradients`, `edges`, what the rates are begun with, and the smoothing lengths of the next evaluation.
    pub(super) fn find_gradients(&mut self, water: &mut MovingWater) {
        let particles = water.particles.len();
        let mut gradients = std::mem::take(&mut self.gradients);
        let mut edges = std::mem::take(&mut self.edges);
        let mut lengths = std::mem::take(&mut water.particles.smoothing_length);
        let mut rates = std::mem::take(&mut water.rates);
        let around = &*water;
        gradients.resize(particles, Gradients::default());
        edges.resize(particles, 0.0);
        rates.resize(particles, Rates::default());
        gradients
            .par_chunks_mut(CHUNK)
            .zip(edges.par_chunks_mut(CHUNK))
            .zip(lengths.par_chunks_mut(CHUNK))
            .zip(bytemuck::cast_slice_mut::<_, Begun>(&mut rates).par_chunks_mut(CHUNK))
            .enumerate()
            .with_max_len(CHUNKS_AT_ONCE)
            .for_each(|(chunk, (((gradients, edges), lengths), begun))| {
                self.gradient_scratch.with(|scratch| {
                    self.find_gradients_of(around, chunk * CHUNK, scratch, (gradients, edges, lengths, begun));
                });
            });
        self.gradients = gradients;
        self.edges = edges;
        water.particles.smoothing_length = lengths;
        water.rates = rates;
    }

    /// The same for the particles of a chunk, from `first` on.
    fn find_gradients_of(
        &self,
        around: &MovingWater,
        first: usize,
        scratch: &mut GradientScratch,
        found: (&mut [Gradients], &mut [f64], &mut [f64], &mut [Begun]),
    ) {
        let GradientScratch { pairs, sums, glance, list } = scratch;
        let (gradients, edges, lengths, begun) = found;
        let sums = &mut sums[..gradients.len()];
        sums.fill(Sums::default());
        for i in first..first + sums.len() {
            let ridges = self.ridges_near(around, self.states[i].position);
            for block in around.neighbours.of(i, list).blocks(BLOCK) {
                if !pairs.has_room_for(block) {
                    sum_pairs(pairs, first, sums, &self.states, &self.kernel);
                }
                gather_states(pairs, i, block, &self.states, around.walls.isometries(), ridges);
            }
        }
        sum_pairs(pairs, first, sums, &self.states, &self.kernel);
        // Apart from the sums: its steps wait for each other, and those of several particles go on side by side.
        for (k, sums) in sums.iter().enumerate() {
            let me = &self.states[first + k];
            (gradients[k], begun[k].correction) = finish(sums);
            lengths[k] = self.next_smoothing_length(me, sums);
        }
        for (k, sums) in sums.iter().enumerate() {
            let me = &self.states[first + k];
            // S₀ / A^((dim−1)/dim) = −2 A^(1/dim) Σ A_j G e, since A / A^((dim−1)/dim) = A^(1/dim).
            let openness = sums.closure * (-2.0 * self.dimension.edge(me.area));
            let mut standing = Standing { openness, ..Standing::default() };
            self.find_free_edge(around, first + k, list, glance, &mut standing);
            standing.out_of_step = self.out_of_step(me, sums, &standing);
            edges[k] = standing.edge;
            begun[k] = Begun {
                correction: begun[k].correction,
                openness: standing.openness,
                out_of_step: standing.out_of_step,
                push: standing.push,
            };
        }
    }

    fn out_of_step(&self, me: &State, sums: &Sums, standing: &Standing) -> f64 {
        let own = me.area * self.kernel.at_zero(me.inverse_h);
        let partition = own + sums.partition;
        let mean_depth = (own * me.depth + sums.depth_sum) / partition;
        let crowding = partition / self.full - 1.0;
        let swelling = if crowding > 0.0 { me.depth.min(mean_depth) } else { me.depth };
        let openness = standing.openness;
        let backing = openness.dot(sums.moment.apply(openness)) / openness.norm_squared().max(f64::MIN_POSITIVE);
        let edge_crowding = (2.0 * backing - 1.0).min(0.0);
        swelling * crowding * (1.0 - standing.edge) + me.depth * edge_crowding * standing.edge
    }

    fn next_smoothing_length(&self, me: &State, sums: &Sums) -> f64 {
        let smoothed = (me.area + sums.weighted_area) / (1.0 + sums.weights);
        self.factor * self.dimension.edge(me.area.max(smoothed))
    }
}

/// The gradients, and L.
fn finish(sums: &Sums) -> (Gradients, Sym2) {
    let correction = correction(sums.moment);
    let gradients = Gradients {
        surface: correction.apply(sums.surface),
        depth: correction.apply(sums.depth),
        u: correction.apply(sums.u),
        v: correction.apply(sums.v),
    };
    (gradients, correction)
}

/// What a thread works in.
#[derive(Debug)]
pub(super) struct GradientScratch {
    pairs: Pairs,
    sums: [Sums; CHUNK],
    glance: Glance,
    list: Vec<u32>,
}

impl Default for GradientScratch {
    fn default() -> Self {
        GradientScratch {
            pairs: Pairs::new(),
            sums: [Sums::default(); CHUNK],
            glance: Glance::default(),
            list: Vec::new(),
        }
    }
}

/// The sums over the pairs of one particle.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    /// M.
    moment: Sym2,
    /// Σ A_j G_ij e (1/m).
    closure: Vec2,
    /// Σ A_j W, without the particle itself.
    partition: f64,
    /// Σ A_j W d_j (m), without the particle itself.
    depth_sum: f64,
    /// Σ A_j (q_j − q_i) G_ij e for q = η, d and both components of the velocity.
    surface: Vec2,
    depth: Vec2,
    u: Vec2,
    v: Vec2,
    /// Σ w, without the particle itself.
    weights: f64,
    /// Σ w A_j (m²), without the particle itself.
    weighted_area: f64,
}

/// Adds what is in work to the sums of a chunk, whose first particle is `first`, and ends the work.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn sum_pairs(pairs: &mut Pairs, first: usize, sums: &mut [Sums], states: &[State], kernel: &ChosenKernel) {
    measure_and_cover(pairs, states, kernel);
    for k in 0..pairs.count() {
        let (i, groups) = pairs.of(k);
        let (me, sums) = (&states[i], &mut sums[i - first]);
        // On the stack, where they stay in registers.
        let [mut weights, mut weighted_area, mut partition, mut depth_sum] = [[0.0; LANES]; 4];
        let [mut moment_xx, mut moment_xy, mut moment_yy, mut closure_x] = [[0.0; LANES]; 4];
        let [mut closure_y, mut surface_x_sum, mut surface_y_sum, mut depth_x_sum] = [[0.0; LANES]; 4];
        let [mut depth_y_sum, mut u_x_sum, mut u_y_sum, mut v_x_sum] = [[0.0; LANES]; 4];
        let [mut v_y_sum] = [[0.0; LANES]; 1];
        for Group { state, r, e_x, e_y, weight, share, covered, .. } in groups {
            for k in 0..LANES {
                let (slope_x, slope_y) = (weight[k] * e_x[k], weight[k] * e_y[k]);
                let (stretch_x, stretch_y) = (slope_x * r[k], slope_y * r[k]);
                weights[k] += share[k];
                weighted_area[k] += share[k] * state.area[k];
                partition[k] += covered[k];
                depth_sum[k] += covered[k] * state.depth[k];
                moment_xx[k] += stretch_x * e_x[k];
                moment_xy[k] += stretch_x * e_y[k];
                moment_yy[k] += stretch_y * e_y[k];
                closure_x[k] += slope_x;
                closure_y[k] += slope_y;
                let (d_eta, d_d) = (state.surface[k] - me.surface, state.depth[k] - me.depth);
                let (d_u, d_v) = (state.velocity_x[k] - me.velocity.x, state.velocity_y[k] - me.velocity.y);
                surface_x_sum[k] += slope_x * d_eta;
                surface_y_sum[k] += slope_y * d_eta;
                depth_x_sum[k] += slope_x * d_d;
                depth_y_sum[k] += slope_y * d_d;
                u_x_sum[k] += slope_x * d_u;
                u_y_sum[k] += slope_y * d_u;
                v_x_sum[k] += slope_x * d_v;
                v_y_sum[k] += slope_y * d_v;
            }
        }
        sums.weights += total(weights);
        sums.weighted_area += total(weighted_area);
        sums.partition += total(partition);
        sums.depth_sum += total(depth_sum);
        sums.moment.xx += total(moment_xx);
        sums.moment.xy += total(moment_xy);
        sums.moment.yy += total(moment_yy);
        sums.closure += Vec2::new(total(closure_x), total(closure_y));
        sums.surface += Vec2::new(total(surface_x_sum), total(surface_y_sum));
        sums.depth += Vec2::new(total(depth_x_sum), total(depth_y_sum));
        sums.u += Vec2::new(total(u_x_sum), total(u_y_sum));
        sums.v += Vec2::new(total(v_x_sum), total(v_y_sum));
    }
    pairs.clear();
}
