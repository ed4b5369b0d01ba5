//! The balanced formulation with particles that move with the water.
//!
//! Depth is carried; every force is a difference that vanishes for a level surface, so that a lake stays at rest on any bed
//! and with any arrangement of particles. One evaluation has two passes over the neighbours: gradients, the free edge and the
//! smoothing lengths of the next evaluation (`gradients`), faces and rates (`rates`).
//!
//! ```text
//! dd/dt = −d div v,   dv/dt = −g ∇η,   η = d + z_b,   A = V/d
//! ```
//!
//! Deliberately left out: splitting, and merging in the plane, which made errors worse (decision 0018).

mod free_edge;
mod gradients;
mod pairs;
mod rates;
mod ridges;

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::moving::{CHUNK, ChosenKernel, Formulation, MovingMethods, MovingSolver, MovingWater, smoothing_factor};
use crate::math::{Sym2, Vec2};
use crate::methods::{BedSlope, Core, Integrator, Method, Reconstruction, Stabilisation};
use crate::particles::{FluidSeed, Line};
use crate::physics::dimension::Dimension;
use crate::solver::FlowProblem;
use crate::solver::scratch::Scratch;

/// Σ A W on a square lattice: not quite 1, and what particles that agree with their depths have.
fn lattice_partition(kernel: &ChosenKernel, dimension: Dimension) -> f64 {
    let factor = smoothing_factor(dimension);
    let reach = (factor * kernel.support()).ceil() as i32;
    let rows = match dimension {
        Dimension::One => 0..=0,
        Dimension::Two => -reach..=reach,
    };
    rows.flat_map(|row| (-reach..=reach).map(move |column| Vec2::new(f64::from(column), f64::from(row))))
        .map(|place| kernel.value(place.norm(), 1.0 / factor))
        .sum()
}

/// What other particles need to know of one: one cache line.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C, align(64))]
struct State {
    position: Vec2,
    velocity: Vec2,
    depth: f64,
    surface: f64,
    area: f64,
    inverse_h: f64,
}

/// Corrected gradients of one particle: one cache line.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C, align(64))]
struct Gradients {
    surface: Vec2,
    depth: Vec2,
    u: Vec2,
    v: Vec2,
}

/// What the first pass over the neighbours finds for the second one, kept in the memory of the rates until these are known.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Begun {
    /// L, the inverse of the first moment of the pair faces.
    correction: Sym2,
    /// As in `Standing`, the push without its direction, which is that of the openness.
    openness: Vec2,
    out_of_step: f64,
    push: f64,
}

/// What the neighbourhood of a particle says of where it stands.
#[derive(Clone, Copy, Debug, Default)]
struct Standing {
    /// S₀ / A^((dim−1)/dim): open length of the particle's outline, outwards, in units of its own edge.
    openness: Vec2,
    /// d' (ΣAW/(ΣAW)₀ − 1)(1 − χ) + d_i min(2 n·M n − 1, 0) χ (m): how much deeper the arrangement of the particles says the water is.
    out_of_step: f64,
    /// χ, 1 at a free edge.
    edge: f64,
    /// Acceleration (m/s²) outwards by the water's own weight at a free edge.
    push: f64,
}

/// The balanced formulation; scratch space only, all state is in `MovingWater`.
#[derive(Debug)]
pub struct Balanced {
    dimension: Dimension,
    kernel: ChosenKernel,
    /// One that Lagrangian particles have.
    faces: Stabilisation,
    reconstruction: Reconstruction,
    factor: f64,
    /// (ΣAW)₀: Σ A W where particles and depths agree.
    full: f64,
    states: Vec<State>,
    gradients: Vec<Gradients>,
    /// χ of each particle.
    edges: Vec<f64>,
    gradient_scratch: Scratch<gradients::GradientScratch>,
    rate_scratch: Scratch<rates::RateScratch>,
}

/// Moving particles in the balanced formulation.
pub type LagrangianSolver = MovingSolver<Balanced>;

impl LagrangianSolver {
    /// Water in the plane.
    ///
    /// The depths of `seeds` must be level minus `problem.bed.at(position)` for a lake to be at rest.
    pub fn new(problem: FlowProblem, seeds: Vec<FluidSeed>, integrator: Integrator) -> Self {
        Self::with_methods(problem, seeds, MovingMethods::new(integrator, Stabilisation::TwoShocks), Dimension::Two)
    }

    /// Water in the plane, or in a channel of unit width along x (a lattice of one row, walls at its two ends), by the given methods.
    ///
    /// # Panics
    /// With a stabilisation or a bed slope that Lagrangian particles do not have; a scenario that asks for them is refused.
    pub fn with_methods(
        problem: FlowProblem,
        seeds: Vec<FluidSeed>,
        methods: MovingMethods,
        dimension: Dimension,
    ) -> Self {
        assert!(methods.bed_slope == BedSlope::Hydrostatic, "the balanced formulation is hydrostatic");
        let faces = methods.stabilisation;
        assert!(faces.is_in(Core::Lagrangian), "Lagrangian particles have no {}", faces.name());
        let kernel = ChosenKernel::new(methods.kernel, dimension);
        let balanced = Balanced {
            dimension,
            full: lattice_partition(&kernel, dimension),
            kernel,
            faces,
            reconstruction: methods.reconstruction,
            factor: smoothing_factor(dimension),
            states: Vec::new(),
            gradients: Vec::new(),
            edges: Vec::new(),
            gradient_scratch: Scratch::default(),
            rate_scratch: Scratch::default(),
        };
        Self::with_formulation(problem, seeds, balanced, methods, dimension)
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
        water.phases.end("motion");
        let fluid = water.admit();
        water.phases.end("boundaries");
        self.states.resize(water.particles.len(), State::default());
        water.sample_bed(&mut self.states, |state, bed| state.surface = bed.elevation);
        water.phases.end("bed");
        water.neighbours.search(
            &water.particles.position,
            &water.particles.smoothing_length,
            self.kernel.support(),
            &water.walls,
        );
        water.phases.end("neighbours");
        self.pack(water);
        self.find_gradients(water);
        water.phases.end("gradients");
        self.find_rates(water);
        water.phases.end("rates");
        water.dismiss(fluid);
    }

    fn spare_memory(&mut self, particles: usize) -> Option<[&mut [Line]; 2]> {
        self.states.resize(particles, State::default());
        self.gradients.resize(particles, Gradients::default());
        Some([bytemuck::cast_slice_mut(&mut self.states), bytemuck::cast_slice_mut(&mut self.gradients)])
    }
}

impl Balanced {
    /// Copies what neighbours need side by side, to the bed under each particle.
    fn pack(&mut self, water: &MovingWater) {
        let particles = &water.particles;
        self.states.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, states)| {
            for (k, state) in states.iter_mut().enumerate() {
                let i = chunk * CHUNK + k;
                *state = State {
                    position: particles.position[i],
                    velocity: particles.velocity[i],
                    depth: particles.depth[i],
                    surface: particles.depth[i] + state.surface,
                    area: particles.volume[i] / particles.depth[i],
                    inverse_h: 1.0 / particles.smoothing_length[i],
                };
            }
        });
    }
}
