//! The made dam break of the benches: a basin twice as long as wide, half of it full of water, over a gently uneven bed.

#![allow(dead_code, reason = "every bench uses its own part")]

use floodsim::math::Vec2;
use floodsim::particles::FluidSeed;
use floodsim::solver::phases::PhaseTime;
use floodsim::solver::{EulerianMethods, EulerianSolver, FlowProblem, FlowSolver};
use floodsim::validation::{jittered_lattice, problem};

/// Depth (m) of the water behind the dam, above a bed at 0.
const DEPTH: f64 = 10.0;
/// Edge of a cell (m).
const SPACING: f64 = 5.0;
/// Roughness of the bed (s·m^(−1/3)).
const MANNING: f64 = 0.03;

/// Eulerian or Lagrangian particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Resting.
    Eulerian,
    /// Moving.
    Lagrangian,
}

impl Motion {
    /// Both.
    pub const ALL: [Motion; 2] = [Motion::Eulerian, Motion::Lagrangian];

    /// As in a scenario.
    pub fn name(self) -> &'static str {
        match self {
            Motion::Eulerian => "eulerian",
            Motion::Lagrangian => "lagrangian",
        }
    }
}

/// A basin twice as long as wide; its western half holds about so many wet cells.
pub fn dam_break(particles: usize) -> FlowProblem {
    dam_break_in(particles, 2)
}

/// The same in a basin of so many cells for each that is wet.
pub fn dam_break_in(particles: usize, cells_for_each: usize) -> FlowProblem {
    let rows = (particles as f64).sqrt().round() as usize;
    let wet_columns = (particles as f64 / rows as f64).round() as usize;
    let columns = cells_for_each * wet_columns;
    let mut problem =
        problem(columns, rows, SPACING, |place| 0.3 * (place.x / 40.0).sin() * (place.y / 55.0).cos() - 0.5);
    problem.bed.manning.fill(MANNING);
    let lattice = &problem.bed.lattice;
    let middle = wet_columns as f64 * SPACING;
    problem.initial_depth = (0..lattice.len())
        .map(|cell| if lattice.centre(cell).x < middle { DEPTH - problem.bed.elevation[cell] } else { 0.0 })
        .collect();
    problem.dry_depth = 1e-3;
    problem
}

/// One particle on each wet cell.
pub fn seeds(problem: &FlowProblem) -> Vec<FluidSeed> {
    let lattice = &problem.bed.lattice;
    let seed = |cell: usize| {
        let depth = problem.initial_depth[cell];
        FluidSeed { position: lattice.centre(cell), volume: depth * lattice.cell_area(), depth }
    };
    (0..lattice.len()).filter(|&cell| problem.initial_depth[cell] > 0.0).map(seed).collect()
}

/// The dam break of so many particles in a motion, by the default methods, with the dam just gone.
pub fn solver(motion: Motion, particles: usize) -> Box<dyn FlowSolver> {
    solver_for(motion, dam_break(particles))
}

/// A problem in a motion, by the default methods.
pub fn solver_for(motion: Motion, mut problem: FlowProblem) -> Box<dyn FlowSolver> {
    problem.courant = 0.5;
    let methods = EulerianMethods { moves: motion == Motion::Lagrangian, ..EulerianMethods::default() };
    Box::new(EulerianSolver::with_methods(problem, methods))
}

/// Takes so many steps, and grids the water after each as a run does.
pub fn steps(solver: &mut dyn FlowSolver, count: usize) {
    for _ in 0..count {
        let step = solver.choose_step().time_step;
        if let Err(failure) = solver.advance(step) {
            panic!("the dam break of the benches broke down: {failure}");
        }
        if solver.is_record_due(f64::INFINITY) {
            std::hint::black_box(solver.water().spans.len());
        }
    }
}

/// What a number of steps cost, phase by phase.
pub struct Cost {
    /// Evaluations of the rates of one particle.
    pub evaluations: u64,
    /// Each phase of the core.
    pub phases: Vec<(&'static str, PhaseTime)>,
}

impl Cost {
    /// All phases together.
    pub fn sum(&self) -> PhaseTime {
        self.phases.iter().fold(PhaseTime::default(), |sum, (_, time)| PhaseTime {
            wall: sum.wall + time.wall,
            cpu: sum.cpu + time.cpu,
        })
    }

    /// One phase by name.
    pub fn phase(&self, name: &str) -> PhaseTime {
        self.phases.iter().find(|(phase, _)| *phase == name).map_or_else(PhaseTime::default, |(_, time)| *time)
    }
}

/// Takes so many steps and says what they cost.
pub fn cost(solver: &mut dyn FlowSolver, count: usize) -> Cost {
    let (before, evaluations) = (solver.phases().times().to_vec(), solver.particle_evaluations());
    steps(solver, count);
    let spent = |(name, time): &(&'static str, PhaseTime)| {
        let earlier = before.iter().find(|(phase, _)| phase == name).map_or_else(PhaseTime::default, |(_, t)| *t);
        (*name, PhaseTime { wall: time.wall - earlier.wall, cpu: time.cpu - earlier.cpu })
    };
    Cost {
        evaluations: solver.particle_evaluations() - evaluations,
        phases: solver.phases().times().iter().map(spent).collect(),
    }
}

/// Does work on so many threads.
pub fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(work),
        Err(cause) => panic!("the threads could not be started: {cause}"),
    }
}

/// Positions on a disordered lattice of unit spacing, always the same.
pub fn disordered(count: usize) -> Vec<Vec2> {
    let edge = (count as f64).sqrt().round();
    jittered_lattice(edge, edge, 1.0, 0.3)
}
