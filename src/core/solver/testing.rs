//! Problems for the tests of the cores.

use super::threads::in_pool;
use super::{Boundary, Condition, FlowProblem, FlowSolver, Forcing, OpenEdges};
use crate::bed::BedParticles;
use crate::lattice::Lattice;
use crate::math::Vec2;

/// Still water of a level (m) over a bed (m), both by place, on so many columns and rows within walls.
pub(super) fn still_water(
    (columns, rows): (usize, usize),
    spacing: f64,
    bed: impl Fn(Vec2) -> f64,
    level: impl Fn(Vec2) -> f64,
) -> FlowProblem {
    let lattice = Lattice::new(Vec2::ZERO, columns, rows, spacing);
    let elevation: Vec<f64> = (0..lattice.len()).map(|i| bed(lattice.centre(i))).collect();
    let initial_depth = (0..lattice.len()).map(|i| (level(lattice.centre(i)) - elevation[i]).max(0.0)).collect();
    let mut bed = BedParticles::from_elevation(lattice, elevation, 0.0);
    bed.is_sloped = true;
    FlowProblem {
        bed,
        walls: Vec::new(),
        open_edges: OpenEdges::default(),
        forcing: Forcing { reach: 0.3 * spacing, ..Forcing::default() },
        initial_depth,
        gravity: 9.81,
        courant: 0.5,
        dry_depth: 1e-6,
    }
}

/// Opens the western or eastern side of a problem from one share of its length to another.
pub(super) fn open_part(problem: &mut FlowProblem, is_west: bool, part: (f64, f64), condition: Condition) {
    let size = problem.bed.lattice.size();
    let x = if is_west { 0.0 } else { size.x };
    let segments = vec![[Vec2::new(x, part.0 * size.y), Vec2::new(x, part.1 * size.y)]];
    problem.forcing.boundaries.push(Boundary { pieces: segments.into(), condition });
}

/// Opens the western or eastern side of a problem.
pub(super) fn open(problem: &mut FlowProblem, is_west: bool, condition: Condition) {
    open_part(problem, is_west, (0.0, 1.0), condition);
}

/// Takes so many steps; returns the greatest speed (m/s) before any of them.
pub(super) fn run_steps(solver: &mut impl FlowSolver, steps: usize) -> f64 {
    in_pool(|| {
        let mut fastest = 0.0_f64;
        for _ in 0..steps {
            let choice = solver.choose_step();
            fastest = fastest.max(choice.max_speed);
            solver.advance(choice.time_step).expect("a stable run");
        }
        fastest
    })
}

/// Runs until a time (s); returns the number of steps.
pub(super) fn run_until(solver: &mut impl FlowSolver, end: f64) -> usize {
    in_pool(|| {
        let mut steps = 0;
        while solver.time() < end - 1e-9 {
            let choice = solver.choose_step();
            solver.advance(choice.time_step.min(end - solver.time())).expect("a stable run");
            steps += 1;
        }
        steps
    })
}
