//! Which core a scenario asks for, and the particles that it starts with.

use crate::math::Vec2;
use crate::physics::dimension::Dimension;
use crate::scenario::methods::{Formulation, Motion, Seeding};
use crate::scenario::{Numerics, Scenario};
use crate::seeding::{FluidSeed, StillWater, equal_volume_filling, lattice_filling, mean_cell_volume};
use crate::solver::lagrangian::LagrangianSolver;
use crate::solver::moving::{self, MovingMethods, MovingSolver, MovingWater};
use crate::solver::variational::VariationalSolver;
use crate::solver::{EulerianMethods, EulerianSolver, FlowProblem, FlowSolver};

/// A core with particles that move, whatever its formulation.
pub trait MovingCore: FlowSolver {
    /// The particles, as they are now.
    fn state(&self) -> &MovingWater;
    /// Gives the water a velocity (m/s) at the start, by place.
    fn set_velocity(&mut self, velocity: &dyn Fn(Vec2) -> Vec2);
}

impl<F: moving::Formulation> MovingCore for MovingSolver<F> {
    fn state(&self) -> &MovingWater {
        MovingSolver::state(self)
    }

    fn set_velocity(&mut self, velocity: &dyn Fn(Vec2) -> Vec2) {
        let particles = &mut self.state_mut().particles;
        for i in 0..particles.len() {
            particles.velocity[i] = velocity(particles.position[i]);
        }
        self.restart();
    }
}

/// A core of either motion.
pub enum Core {
    /// Particles that rest on the riverbed.
    Resting(Box<EulerianSolver>),
    /// Particles that move with the water.
    Moving(Box<dyn MovingCore>),
}

impl Core {
    /// The core of the chosen methods. Eulerian particles take the water of `problem`, moving ones that of `seeds`; a channel of
    /// one dimension is a lattice of one row.
    pub fn new(
        numerics: &Numerics,
        problem: FlowProblem,
        seeds: impl FnOnce() -> Vec<FluidSeed>,
        dimension: Dimension,
    ) -> Core {
        let methods = MovingMethods {
            integrator: numerics.integrator,
            kernel: numerics.kernel,
            stabilisation: numerics.stabilisation,
            reconstruction: numerics.reconstruction,
            bed_slope: numerics.bed_slope,
            wall: numerics.wall,
        };
        match (numerics.formulation, numerics.motion) {
            (Formulation::Balanced, Motion::Eulerian) => Core::Resting(Box::new(EulerianSolver::with_methods(
                problem,
                EulerianMethods {
                    flux: numerics.stabilisation,
                    reconstruction: numerics.reconstruction,
                    turbulence: numerics.turbulence,
                    constants: numerics.constants.eulerian,
                    sleeps: numerics.sleeps,
                    moves: false,
                },
            ))),
            (Formulation::Balanced, Motion::Lagrangian) => {
                Core::Moving(Box::new(LagrangianSolver::with_methods(problem, seeds(), methods, dimension)))
            }
            (Formulation::Variational, _) => {
                Core::Moving(Box::new(VariationalSolver::with_methods(problem, seeds(), methods, dimension)))
            }
        }
    }

    /// The core as one that takes steps.
    pub fn flow(&mut self) -> &mut dyn FlowSolver {
        match self {
            Core::Resting(solver) => solver.as_mut(),
            Core::Moving(solver) => solver.as_mut(),
        }
    }
}

/// The Lagrangian particles at the start; none where particles rest. `levels` (m) are those of the bodies of still water.
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

/// The core of the scenario's formulation and motion, with the velocity (m/s) of the water of each cell; it is at rest when there is none.
pub fn build(
    scenario: &Scenario,
    problem: FlowProblem,
    seeds: Vec<FluidSeed>,
    velocity: &[Vec2],
) -> Box<dyn FlowSolver> {
    let lattice = problem.bed.lattice.clone();
    let at = |place: Vec2| lattice.cell_at(place).and_then(|cell| velocity.get(cell)).copied().unwrap_or_default();
    match Core::new(&scenario.numerics, problem, || seeds, Dimension::Two) {
        Core::Resting(mut solver) => {
            if !velocity.is_empty() {
                solver.set_velocity(at);
            }
            solver
        }
        Core::Moving(mut solver) => {
            if !velocity.is_empty() {
                solver.set_velocity(&at);
            }
            solver
        }
    }
}
