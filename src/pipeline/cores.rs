//! Which core a scenario asks for, and the particles that it starts with.

use crate::math::Vec2;
use crate::physics::dimension::Dimension;
use crate::scenario::methods::{Formulation, Motion, Seeding};
use crate::scenario::{Numerics, Scenario};
use crate::seeding::{FluidSeed, StillWater, equal_volume_filling, lattice_filling, mean_cell_volume};
use crate::solver::variational::{MovingMethods, VariationalSolver};
use crate::solver::{EulerianMethods, EulerianSolver, FlowProblem, FlowSolver};

/// A core of either formulation.
#[derive(serde::Serialize, serde::Deserialize)]
pub enum Core {
    /// Cells, that rest or move.
    Balanced(Box<EulerianSolver>),
    /// Sums over particles.
    Variational(Box<VariationalSolver>),
}

impl Core {
    /// The core of the chosen methods. Cells take the water of `problem`, particles of the variational formulation that of `seeds`; a channel of
    /// one dimension is a lattice of one row.
    pub fn new(
        numerics: &Numerics,
        problem: FlowProblem,
        seeds: impl FnOnce() -> Vec<FluidSeed>,
        dimension: Dimension,
    ) -> Core {
        match numerics.formulation {
            Formulation::Balanced => Core::Balanced(Box::new(EulerianSolver::with_methods(
                problem,
                EulerianMethods {
                    flux: numerics.stabilisation,
                    reconstruction: numerics.reconstruction,
                    turbulence: numerics.turbulence,
                    constants: numerics.constants.eulerian,
                    sleeps: numerics.sleeps,
                    moves: numerics.motion == Motion::Lagrangian,
                },
            ))),
            Formulation::Variational => {
                let methods = MovingMethods {
                    integrator: numerics.integrator,
                    kernel: numerics.kernel,
                    stabilisation: numerics.stabilisation,
                    reconstruction: numerics.reconstruction,
                    bed_slope: numerics.bed_slope,
                    wall: numerics.wall,
                };
                Core::Variational(Box::new(VariationalSolver::with_methods(problem, seeds(), methods, dimension)))
            }
        }
    }

    /// Gives the water a velocity (m/s) at the start, by place.
    pub fn set_velocity(&mut self, velocity: &dyn Fn(Vec2) -> Vec2) {
        match self {
            Core::Balanced(solver) => solver.set_velocity(velocity),
            Core::Variational(solver) => solver.set_velocity(velocity),
        }
    }

    /// The core as one that is looked at.
    pub fn as_flow(&self) -> &dyn FlowSolver {
        match self {
            Core::Balanced(solver) => solver.as_ref(),
            Core::Variational(solver) => solver.as_ref(),
        }
    }

    /// The core as one that takes steps.
    pub fn flow(&mut self) -> &mut dyn FlowSolver {
        match self {
            Core::Balanced(solver) => solver.as_mut(),
            Core::Variational(solver) => solver.as_mut(),
        }
    }
}

/// The particles of the variational formulation at the start; none in the balanced one. `levels` (m) are those of the bodies of still water.
pub fn seeds(scenario: &Scenario, problem: &FlowProblem, still: &StillWater, levels: &[f64]) -> Vec<FluidSeed> {
    let numerics = &scenario.numerics;
    match (numerics.formulation, numerics.seeding) {
        (Formulation::Balanced, _) => Vec::new(),
        (Formulation::Variational, Seeding::Lattice) => lattice_filling(&problem.bed.lattice, still),
        (Formulation::Variational, Seeding::EqualVolume) => {
            let particle_volume = mean_cell_volume(still);
            if particle_volume > 0.0 {
                equal_volume_filling(levels, &problem.bed, still, particle_volume)
            } else {
                Vec::new()
            }
        }
    }
}

/// The core of the scenario's formulation and motion as one that takes steps.
pub fn build(
    scenario: &Scenario,
    problem: FlowProblem,
    seeds: Vec<FluidSeed>,
    velocity: &[Vec2],
) -> Box<dyn FlowSolver> {
    match with_velocity(scenario, problem, seeds, velocity) {
        Core::Balanced(solver) => solver,
        Core::Variational(solver) => solver,
    }
}

/// The core of the scenario's formulation and motion, with the velocity (m/s) of the water of each cell; it is at rest when there is none.
pub fn with_velocity(scenario: &Scenario, problem: FlowProblem, seeds: Vec<FluidSeed>, velocity: &[Vec2]) -> Core {
    let lattice = problem.bed.lattice.clone();
    let at = |place: Vec2| lattice.cell_at(place).and_then(|cell| velocity.get(cell)).copied().unwrap_or_default();
    let mut core = Core::new(&scenario.numerics, problem, || seeds, Dimension::Two);
    if !velocity.is_empty() {
        core.set_velocity(&at);
    }
    core
}
