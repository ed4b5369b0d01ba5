//! Which core a scenario asks for.

use crate::scenario::Scenario;
use crate::scenario::methods::{Formulation, Motion};
use crate::seeding::{StillWater, lattice_filling};
use crate::solver::lagrangian::LagrangianSolver;
use crate::solver::variational::VariationalSolver;
use crate::solver::{EulerianSolver, FlowProblem, FlowSolver};

/// The core of the scenario's formulation and motion, with its water at rest.
///
/// Moving particles start on the lattice, one in each wet cell.
pub fn build(scenario: &Scenario, problem: FlowProblem, still: &StillWater) -> Box<dyn FlowSolver> {
    let numerics = &scenario.numerics;
    if numerics.formulation == Formulation::Balanced && numerics.motion == Motion::Eulerian {
        return Box::new(EulerianSolver::new(problem));
    }
    let seeds = lattice_filling(&problem.bed.lattice, still);
    match numerics.formulation {
        Formulation::Balanced => Box::new(LagrangianSolver::new(problem, seeds, numerics.integrator)),
        Formulation::Variational => {
            Box::new(VariationalSolver::new(problem, seeds, numerics.integrator, numerics.stabilisation))
        }
    }
}
