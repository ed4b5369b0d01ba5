//! The classic SPH form of the shallow-water equations: summed depth, variable smoothing length, forces from a Lagrangian.
//!
//! ```text
//! d_i = Σ m_j W(r, h_i),   h_i = k_h (m_i / d_i)^(1/dim),   β_i = −(1/(dim d_i)) Σ m_j r W'(r, h_i)     (m: volume)
//! dv/dt = −Σ m_j [p_i/(d_i² β_i) ∇W(h_i) + p_j/(d_j² β_j) ∇W(h_j)] − g ∇z_b,   p = g d²/2
//! ```
//!
//! `RodriguezPaz2005`, hydrostatic unless the scenario asks for the inertia of the vertical motion over the bed (`forces`). Stabilised by an artificial
//! viscosity, or by p* of a Riemann solver in place of both p, as `Wu2020` compare them; with limited reconstruction or without.
//! **Weak spot**: a lake over an uneven bed does not stay at rest, because nothing balances the slope of the bed exactly.

mod density;
mod forces;

use super::moving::{ChosenKernel, Formulation, MovingMethods, MovingSolver, MovingWater, smoothing_factor};
use crate::math::Vec2;
use crate::methods::{BedSlope, Integrator, Reconstruction, Stabilisation};
use crate::particles::FluidSeed;
use crate::physics::dimension::Dimension;
use crate::solver::FlowProblem;

/// Neighbours are searched with this slack, and h grows by at most as much between two evaluations.
const SLACK: f64 = 1.1;

/// What the pair sums need of one particle beside its state.
#[derive(Clone, Copy, Debug, Default)]
struct Density {
    depth: f64,
    inverse_h: f64,
    /// β, the effect of the variable smoothing length.
    beta: f64,
    grad_depth: Vec2,
    grad_u: Vec2,
    grad_v: Vec2,
}

/// The variational formulation; scratch space only.
#[derive(Debug)]
pub struct Variational {
    dimension: Dimension,
    kernel: ChosenKernel,
    factor: f64,
    stabilisation: Stabilisation,
    reconstruction: Reconstruction,
    bed_slope: BedSlope,
    densities: Vec<Density>,
    /// Slope of the bed under each particle.
    slopes: Vec<Vec2>,
}

/// Lagrangian particles in the variational formulation.
pub type VariationalSolver = MovingSolver<Variational>;

impl VariationalSolver {
    /// Water in the plane.
    pub fn new(
        problem: FlowProblem,
        seeds: Vec<FluidSeed>,
        integrator: Integrator,
        stabilisation: Stabilisation,
    ) -> Self {
        Self::with_methods(problem, seeds, MovingMethods::new(integrator, stabilisation), Dimension::Two)
    }

    /// Water in the plane, or in a channel of unit width along x (a lattice of one row, walls at its two ends), by the given methods.
    pub fn with_methods(
        problem: FlowProblem,
        seeds: Vec<FluidSeed>,
        methods: MovingMethods,
        dimension: Dimension,
    ) -> Self {
        let (factor, kernel) = (smoothing_factor(dimension), ChosenKernel::new(methods.kernel, dimension));
        let variational = Variational {
            dimension,
            kernel,
            factor,
            stabilisation: methods.stabilisation,
            reconstruction: methods.reconstruction,
            bed_slope: methods.bed_slope,
            densities: Vec::new(),
            slopes: Vec::new(),
        };
        Self::with_formulation(problem, seeds, variational, methods, dimension)
    }
}

impl Formulation for Variational {
    const CARRIES_DEPTH: bool = false;

    fn prepare(&mut self, water: &mut MovingWater) {
        let particles = &mut water.particles;
        for i in 0..particles.len() {
            particles.smoothing_length[i] =
                self.factor * water.dimension.edge(particles.volume[i] / particles.depth[i]);
        }
        // At edges the summed depth falls below the seeded one and h grows past the slack: a few rounds settle both.
        for _ in 0..5 {
            self.evaluate(water);
        }
    }

    fn evaluate(&mut self, water: &mut MovingWater) {
        water.phases.end("motion");
        self.slopes.resize(water.particles.len(), Vec2::ZERO);
        water.sample_bed(&mut self.slopes, |slope, bed| *slope = bed.slope);
        water.phases.end("bed");
        let reach = SLACK * self.kernel.support();
        water.neighbours.search(&water.particles.position, &water.particles.smoothing_length, reach, &water.walls);
        water.phases.end("neighbours");
        self.sum_depths(water);
        water.phases.end("depths");
        self.find_rates(water);
        water.phases.end("rates");
    }
}
