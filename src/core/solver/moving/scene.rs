//! Scenes for the tests of moving particles.

use crate::math::Vec2;
use crate::methods::{Integrator, Stabilisation};
use crate::particles::FluidSeed;
use crate::physics::dimension::Dimension;
use crate::solver::FlowProblem;
use crate::solver::lagrangian::LagrangianSolver;
use crate::solver::moving::MovingMethods;
use crate::solver::testing::still_water;

pub const G: f64 = 9.81;

/// Still water with the Courant number of leapfrog.
pub fn problem(
    size: (usize, usize),
    spacing: f64,
    bed: impl Fn(Vec2) -> f64,
    level: impl Fn(Vec2) -> f64,
) -> FlowProblem {
    FlowProblem { courant: 0.4, ..still_water(size, spacing, bed, level) }
}

/// One particle on each wet cell, as `seeding: lattice` places them.
pub fn seeds(problem: &FlowProblem, dimension: Dimension) -> Vec<FluidSeed> {
    let lattice = &problem.bed.lattice;
    let seed = |cell: usize| {
        let depth = problem.initial_depth[cell];
        FluidSeed { position: lattice.centre(cell), volume: depth * dimension.area(lattice.spacing), depth }
    };
    (0..lattice.len()).filter(|&cell| problem.initial_depth[cell] > 1e-3).map(seed).collect()
}

pub fn solver(problem: FlowProblem, dimension: Dimension, integrator: Integrator) -> LagrangianSolver {
    let seeds = seeds(&problem, dimension);
    let methods = MovingMethods::new(integrator, Stabilisation::TwoShocks);
    LagrangianSolver::with_methods(problem, seeds, methods, dimension)
}
