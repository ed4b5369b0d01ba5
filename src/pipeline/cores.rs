//! Which core a scenario asks for, and the particles that it starts with.

use crate::physics::dimension::Dimension;
use crate::scenario::Scenario;
use crate::scenario::methods::{Formulation, Motion, Seeding};
use crate::seeding::{FluidSeed, StillWater, equal_volume_filling, lattice_filling, mean_cell_volume};
use crate::solver::lagrangian::LagrangianSolver;
use crate::solver::moving::MovingMethods;
use crate::solver::variational::VariationalSolver;
use crate::solver::{EulerianSolver, FlowProblem, FlowSolver};

/// The moving particles at the start; none where particles rest. `levels` (m) are those of the bodies of still water.
pub fn seeds(scenario: &Scenario, problem: &FlowProblem, still: &StillWater, levels: &[f64]) -> Vec<FluidSeed> {
    let numerics = &scenario.numerics;
    match (numerics.motion, numerics.seeding) {
        (Motion::Eulerian, _) => Vec::new(),
        (Motion::Lagrangian, Seeding::Lattice) => lattice_filling(&problem.bed.lattice, still),
        (Motion::Lagrangian, Seeding::EqualVolume) => {
            let particle_volume = mean_cell_volume(still);
            if particle_volume > 0.0 {
                equal_volume_filling(levels, &problem.bed, still, particle_volume)
            } else {
                Vec::new()
            }
        }
    }
}

/// The core of the scenario's formulation and motion, with its water at rest.
pub fn build(scenario: &Scenario, problem: FlowProblem, seeds: Vec<FluidSeed>) -> Box<dyn FlowSolver> {
    let numerics = &scenario.numerics;
    let methods = MovingMethods {
        integrator: numerics.integrator,
        kernel: numerics.kernel,
        stabilisation: numerics.stabilisation,
        reconstruction: numerics.reconstruction,
        bed_slope: numerics.bed_slope,
    };
    match (numerics.formulation, numerics.motion) {
        (Formulation::Balanced, Motion::Eulerian) => {
            Box::new(EulerianSolver::with_methods(problem, numerics.stabilisation, numerics.reconstruction))
        }
        (Formulation::Balanced, Motion::Lagrangian) => {
            Box::new(LagrangianSolver::with_methods(problem, &seeds, methods, Dimension::Two))
        }
        (Formulation::Variational, _) => {
            Box::new(VariationalSolver::with_methods(problem, &seeds, methods, Dimension::Two))
        }
    }
}
