//! The balanced formulation with particles that move with the water.
//!
//! Depth is carried; every force is a difference that vanishes for a level surface, so that a lake stays at rest on any bed
//! and with any arrangement of particles. One evaluation has three passes over the neighbours:
//! smoothing lengths from smoothed areas (here), gradients and the free edge (`gradients`), faces and rates (`rates`).
//!
//! ```text
//! dd/dt = −d div v,   dv/dt = −g ∇η,   η = d + z_b,   A = V/d
//! ```
//!
//! Deliberately left out: splitting and merging, which made every measured error worse.

mod free_edge;
mod gradients;
mod rates;

use rayon::prelude::*;

use super::moving::{CHUNK, Formulation, MovingSolver, MovingWater};
use crate::boundary::{Image, Isometry};
use crate::math::{Sym2, Vec2};
use crate::particles::FluidSeed;
use crate::physics::dimension::Dimension;
use crate::physics::kernel::CubicSpline;
use crate::scenario::methods::Integrator;
use crate::solver::FlowProblem;

/// h = κ A^(1/dim): 1.2 in one dimension and 1.5 in two, where 1.2 cannot tell jitter from an edge.
fn smoothing_factor(dimension: Dimension) -> f64 {
    match dimension {
        Dimension::One => 1.2,
        Dimension::Two => 1.5,
    }
}

/// Neighbours are searched with this slack, and h grows by at most as much between two evaluations.
const SLACK: f64 = 1.1;

/// What other particles need to know of one: one cache line.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
struct State {
    position: Vec2,
    velocity: Vec2,
    depth: f64,
    surface: f64,
    area: f64,
    inverse_h: f64,
}

/// Corrected gradients of one particle: one cache line.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
struct Gradients {
    surface: Vec2,
    depth: Vec2,
    u: Vec2,
    v: Vec2,
}

/// What only the particle itself needs.
#[derive(Clone, Copy, Debug, Default)]
struct Local {
    /// L, the inverse of the first moment of the pair faces.
    correction: Sym2,
    /// S₀ / A^((dim−1)/dim): open length of the particle's outline, outwards, in units of its own edge.
    openness: Vec2,
    /// Σ A W, 1 where particles and depths agree.
    partition: f64,
    /// χ, 1 at a free edge.
    edge: f64,
    /// Acceleration (m/s²) by the water's own weight at a free edge.
    push: Vec2,
}

/// The balanced formulation; scratch space only, all state is in `MovingWater`.
#[derive(Debug)]
pub struct Balanced {
    dimension: Dimension,
    kernel: CubicSpline,
    factor: f64,
    lengths: Vec<f64>,
    areas: Vec<f64>,
    states: Vec<State>,
    gradients: Vec<Gradients>,
    locals: Vec<Local>,
}

/// Moving particles in the balanced formulation.
pub type LagrangianSolver = MovingSolver<Balanced>;

impl LagrangianSolver {
    /// Water in the plane.
    ///
    /// The depths of `seeds` must be level minus `problem.bed.at(position)` for a lake to be at rest.
    pub fn new(problem: FlowProblem, seeds: Vec<FluidSeed>, integrator: Integrator) -> Self {
        Self::with_dimension(problem, &seeds, integrator, Dimension::Two)
    }

    /// Water in a channel of unit width along x: a lattice of one row; walls at its two ends.
    pub fn one_dimensional(problem: FlowProblem, seeds: Vec<FluidSeed>, integrator: Integrator) -> Self {
        Self::with_dimension(problem, &seeds, integrator, Dimension::One)
    }

    fn with_dimension(problem: FlowProblem, seeds: &[FluidSeed], integrator: Integrator, dimension: Dimension) -> Self {
        let balanced = Balanced {
            dimension,
            kernel: CubicSpline::new(dimension),
            factor: smoothing_factor(dimension),
            lengths: Vec::new(),
            areas: Vec::new(),
            states: Vec::new(),
            gradients: Vec::new(),
            locals: Vec::new(),
        };
        Self::with_formulation(problem, seeds, balanced, integrator, dimension)
    }
}

/// A neighbour as particle i sees it.
#[derive(Clone, Copy)]
struct Seen {
    /// Distance (m).
    r: f64,
    /// Unit vector from i to the neighbour; zero where both coincide.
    e: Vec2,
    /// The same vector as the neighbour itself would measure it: turned back by its isometry.
    own_e: Vec2,
    state: State,
}

impl Seen {
    #[inline(always)]
    fn new(me: &State, image: Image, states: &[State], transforms: &[Isometry]) -> Self {
        let mut state = states[image.index as usize];
        if image.transform != 0 {
            let isometry = &transforms[image.transform as usize];
            state.position = isometry.point(state.position);
            state.velocity = isometry.vector(state.velocity);
        }
        let offset = state.position - me.position;
        let r = offset.norm();
        let e = offset * (1.0 / r.max(f64::MIN_POSITIVE));
        let own_e = if image.transform != 0 { transforms[image.transform as usize].inverse_vector(e) } else { e };
        Seen { r, e, own_e, state }
    }

    /// Whether the neighbour lies outside both supports: the search finds some that do.
    #[inline(always)]
    fn is_far(&self, me: &State) -> bool {
        self.r * me.inverse_h.min(self.state.inverse_h) >= CubicSpline::SUPPORT
    }

    /// A_j G_ij, the neighbour's area times the mean slope of both kernels (m^(−dim−1) · m^dim), 0 or more.
    #[inline(always)]
    fn face(&self, me: &State, kernel: &CubicSpline) -> f64 {
        let slopes = kernel.slope(self.r, me.inverse_h) + kernel.slope(self.r, self.state.inverse_h);
        -0.5 * self.state.area * slopes
    }
}

impl Formulation for Balanced {
    const CARRIES_DEPTH: bool = true;

    fn prepare(&mut self, water: &mut MovingWater) {
        let particles = &mut water.particles;
        for i in 0..particles.len() {
            particles.smoothing_length[i] =
                self.factor * water.dimension.edge(particles.volume[i] / particles.depth[i]);
        }
        // The smoothed areas depend on the smoothing lengths: three rounds settle them.
        for _ in 0..3 {
            self.evaluate(water);
        }
    }

    fn evaluate(&mut self, water: &mut MovingWater) {
        water.sample_bed();
        water.neighbours.search(&water.particles.position, &water.particles.smoothing_length, SLACK, &water.walls);
        self.choose_smoothing_lengths(water);
        self.pack(water);
        self.find_gradients(water);
        self.find_rates(water);
    }
}

impl Balanced {
    /// h_i = κ a_i^(1/dim) with the smoothed area a_i = max(A_i, Σ w A_j / Σ w), w = W(r / max(h_i, h_j)).
    ///
    /// Without the smoothing a thin particle beside deep ones loses touch with its own kind, and bores over thin water blow up.
    fn choose_smoothing_lengths(&mut self, water: &mut MovingWater) {
        let (particles, dimension, factor) = (&water.particles, water.dimension, self.factor);
        self.lengths.resize(particles.len(), 0.0);
        self.areas.clear();
        self.areas.extend(particles.volume.iter().zip(&particles.depth).map(|(volume, depth)| volume / depth));
        let areas = &self.areas;
        self.lengths.par_chunks_mut(CHUNK).zip(water.neighbours.chunks()).enumerate().for_each(
            |(chunk, (lengths, near))| {
                for (k, length) in lengths.iter_mut().enumerate() {
                    let i = chunk * CHUNK + k;
                    let area = areas[i];
                    let (place, h_i) = (particles.position[i], particles.smoothing_length[i]);
                    let (mut weights, mut weighted) = (1.0, area);
                    for image in near.of(k) {
                        let j = image.index as usize;
                        let mut other = particles.position[j];
                        if image.transform != 0 {
                            other = water.walls.isometries()[image.transform as usize].point(other);
                        }
                        let h = h_i.max(particles.smoothing_length[j]);
                        let w = CubicSpline::shape((other - place).norm() / h);
                        weights += w;
                        weighted += w * areas[j];
                    }
                    let smoothed = area.max(weighted / weights);
                    *length = (factor * dimension.edge(smoothed)).min(SLACK * h_i);
                }
            },
        );
        water.particles.smoothing_length.copy_from_slice(&self.lengths);
    }

    /// Copies what neighbours need side by side.
    fn pack(&mut self, water: &MovingWater) {
        let particles = &water.particles;
        self.states.resize(particles.len(), State::default());
        self.states.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, states)| {
            for (k, state) in states.iter_mut().enumerate() {
                let i = chunk * CHUNK + k;
                *state = State {
                    position: particles.position[i],
                    velocity: particles.velocity[i],
                    depth: particles.depth[i],
                    surface: particles.depth[i] + water.bed_points[i].elevation,
                    area: particles.volume[i] / particles.depth[i],
                    inverse_h: 1.0 / particles.smoothing_length[i],
                };
            }
        });
    }
}
