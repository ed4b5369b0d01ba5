//! Scenes for the tests of moving particles.

use crate::boundary::{Boundary, Condition};
use crate::math::Vec2;
use crate::particles::FluidSeed;
use crate::physics::dimension::Dimension;
use crate::scenario::methods::{Integrator, Stabilisation};
use crate::solver::lagrangian::LagrangianSolver;
use crate::solver::moving::MovingMethods;
use crate::solver::testing::still_water;
use crate::solver::{FlowProblem, FlowSolver};

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

/// Opens the western or eastern side of a problem from one share of its length to another.
pub fn open_part(problem: &mut FlowProblem, is_west: bool, part: (f64, f64), condition: Condition) {
    let size = problem.bed.lattice.size();
    let x = if is_west { 0.0 } else { size.x };
    let segments = vec![[Vec2::new(x, part.0 * size.y), Vec2::new(x, part.1 * size.y)]];
    problem.forcing.boundaries.push(Boundary { segments, condition });
}

pub fn open(problem: &mut FlowProblem, is_west: bool, condition: Condition) {
    open_part(problem, is_west, (0.0, 1.0), condition);
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
    LagrangianSolver::with_methods(problem, &seeds, methods, dimension)
}

pub fn run_until(solver: &mut LagrangianSolver, end: f64) -> usize {
    let mut steps = 0;
    while solver.time() < end - 1e-9 {
        let choice = solver.choose_step();
        solver.advance(choice.time_step.min(end - solver.time())).expect("a stable run");
        steps += 1;
    }
    steps
}
