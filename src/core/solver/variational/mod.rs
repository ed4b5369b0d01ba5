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

mod correction;
mod density;
mod forces;
mod kernel;
mod neighbours;
mod solver;
mod step;
mod water;

pub(super) use kernel::with_kernel;
pub use kernel::{ChosenKernel, smoothing_factor};
pub use neighbours::{CHUNK, CHUNKS_AT_ONCE, Neighbours, Seen};
pub use solver::VariationalSolver;
pub use water::MovingWater;

use bytemuck::{Pod, Zeroable};

use crate::math::Vec2;
use crate::methods::{BedSlope, Integrator, Kernel, Reconstruction, Stabilisation, WallMethod};
use crate::physics::dimension::Dimension;

/// Neighbours are searched with this slack, and h grows by at most as much between two evaluations.
const SLACK: f64 = 1.1;

/// The methods of moving particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MovingMethods {
    /// Time integration.
    pub integrator: Integrator,
    /// Smoothing kernel.
    pub kernel: Kernel,
    /// Treatment of pairs.
    pub stabilisation: Stabilisation,
    /// What a pair takes for the states on both sides of its face.
    pub reconstruction: Reconstruction,
    /// Effect of the bed's slope.
    pub bed_slope: BedSlope,
    /// What stands for walls.
    pub wall: WallMethod,
}

impl MovingMethods {
    /// An integrator and a treatment of pairs, and the usual choice of everything else.
    pub fn new(integrator: Integrator, stabilisation: Stabilisation) -> Self {
        let reconstruction = stabilisation.usual_reconstruction();
        MovingMethods {
            integrator,
            kernel: Kernel::default(),
            stabilisation,
            reconstruction,
            bed_slope: BedSlope::default(),
            wall: WallMethod::default(),
        }
    }
}

/// The rates of one particle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable, serde::Serialize, serde::Deserialize)]
#[repr(C)]
pub struct Rates {
    /// dv/dt (m/s²) without friction.
    pub acceleration: Vec2,
    /// Greatest speed (m/s) at which a neighbour approaches or leaves.
    pub approach: f64,
    /// Length (m) that a signal must not outrun in a step.
    pub reach: f64,
}

/// What the pair sums need of one particle beside its state.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
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
#[derive(Debug, serde::Serialize, serde::Deserialize)]
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

impl Variational {
    fn new(methods: MovingMethods, dimension: Dimension) -> Self {
        Variational {
            dimension,
            kernel: ChosenKernel::new(methods.kernel, dimension),
            factor: smoothing_factor(dimension),
            stabilisation: methods.stabilisation,
            reconstruction: methods.reconstruction,
            bed_slope: methods.bed_slope,
            densities: Vec::new(),
            slopes: Vec::new(),
        }
    }

    /// Chooses the first smoothing lengths; called once, before the first evaluation.
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

    /// Finds depth, smoothing length and rates of the particles for their present state.
    fn evaluate(&mut self, water: &mut MovingWater) {
        water.phases.end("motion");
        self.slopes.resize(water.particles.len(), Vec2::ZERO);
        water.sample_bed(&mut self.slopes, |slope, bed| *slope = bed.slope);
        water.phases.end("bed");
        let (reach, particles) = (SLACK * self.kernel.support(), &water.particles);
        water.neighbours.search(&particles.position, &particles.smoothing_length, reach, &water.walls);
        water.phases.end("neighbours");
        self.sum_depths(water);
        water.phases.end("depths");
        self.find_rates(water);
        water.phases.end("rates");
    }
}
