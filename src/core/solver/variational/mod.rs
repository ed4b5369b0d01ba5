//! The classic SPH form of the shallow-water equations: summed depth, variable smoothing length, forces from a Lagrangian.
//!
//! ```text
//! d_i = Σ m_j W(r, h_ij),   h_i = h_0 (d_0/d_i)^(1/dim),   h_ij² = (h_i² + h_j²)/2,   β_i = −(1/(dim d_i)) Σ m_j r W'(r, h_ij)     (m: volume)
//! dv/dt = −Σ m_j [p_i/(d_i² β_i) + p_j/(d_j² β_j)] ∇W(h_ij) − g ∇z_b,   p = g d²/2
//! ```
//!
//! `RodriguezPaz2005`, hydrostatic unless the scenario asks for the inertia of the vertical motion over the bed (`forces`). Stabilised by an artificial
//! viscosity, or by p* of a Riemann solver in place of both p, as `Wu2020` compare them; with limited reconstruction or without.
//! The bed is balanced by what still water on the lattice of the bed would do (`still`). **Weak spot**: particles that have left their lattice
//! find no rest; a lake of them moves.

mod correction;
mod density;
mod forces;
mod kernel;
mod neighbours;
mod solver;
mod step;
mod still;
mod water;

pub(super) use kernel::with_kernel;
pub use kernel::{ChosenKernel, smoothing_factor};
pub use neighbours::{CHUNK, CHUNKS_AT_ONCE, Neighbours, Seen};
pub use solver::VariationalSolver;
pub use water::MovingWater;

use bytemuck::{Pod, Zeroable};

use crate::bed::BedPoint;
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
            kernel: Kernel::WendlandC2,
            stabilisation,
            reconstruction,
            bed_slope: BedSlope::default(),
            wall: WallMethod::default(),
        }
    }
}

/// 1/h_ij (1/m) of a pair, h_ij² = (h_i² + h_j²)/2, from the squares of both smoothing lengths (m²).
#[inline(always)]
fn inverse_of_pair(h_i_squared: f64, h_j_squared: f64) -> f64 {
    1.0 / (0.5 * (h_i_squared + h_j_squared)).sqrt()
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
    raw_beta: f64,
    /// The level of still water with this depth here (m).
    level: f64,
    /// What that still water does against the slope of the bed (m/s²).
    still: Vec2,
    /// β of still water over β.
    grad_h: f64,
    grad_level: Vec2,
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
    /// The bed under each particle.
    grounds: Vec<BedPoint>,
    /// λ: −Σ A r W'/dim on the lattice.
    lattice_moment: f64,
}

impl Variational {
    fn new(methods: MovingMethods, dimension: Dimension) -> Self {
        let kernel = ChosenKernel::new(methods.kernel, dimension);
        let lattice_moment = kernel.lattice_moment(dimension);
        Variational {
            dimension,
            kernel,
            factor: smoothing_factor(dimension),
            stabilisation: methods.stabilisation,
            reconstruction: methods.reconstruction,
            bed_slope: methods.bed_slope,
            densities: Vec::new(),
            grounds: Vec::new(),
            lattice_moment,
        }
    }

    /// Chooses the first smoothing lengths; called once, before the first evaluation.
    fn prepare(&mut self, water: &mut MovingWater) {
        let particles = &mut water.particles;
        for i in 0..particles.len() {
            particles.smoothing_length[i] =
                self.factor * water.dimension.edge(particles.volume[i] / particles.depth[i]);
        }
        self.find_neighbours(water);
        self.weigh(water);
        self.evaluate(water);
    }

    fn find_neighbours(&self, water: &mut MovingWater) {
        let (reach, particles) = (SLACK * self.kernel.support(), &water.particles);
        water.neighbours.search(&particles.position, &particles.smoothing_length, reach, &water.walls);
    }

    /// Finds depth, smoothing length and rates of the particles for their present state.
    fn evaluate(&mut self, water: &mut MovingWater) {
        water.phases.end("motion");
        self.grounds.resize(water.particles.len(), BedPoint { elevation: 0.0, slope: Vec2::ZERO });
        water.sample_bed(&mut self.grounds, |ground, bed| *ground = bed);
        water.phases.end("bed");
        self.find_neighbours(water);
        water.phases.end("neighbours");
        self.sum_depths(water);
        water.phases.end("depths");
        self.compare_with_still_water(water);
        water.phases.end("still water");
        if self.reconstruction != Reconstruction::None {
            self.find_gradients(water);
            water.phases.end("gradients");
        }
        self.find_rates(water);
        water.phases.end("rates");
    }
}
