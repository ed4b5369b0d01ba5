//! A lake at rest stays at rest: any bed, any arrangement of particles, beside walls.

use floodsim::math::Vec2;
use floodsim::scenario::methods::Integrator;
use floodsim::solver::FlowSolver;
use floodsim::solver::lagrangian::LagrangianSolver;

use crate::support::{max_speed, places, problem, run_steps, seeds_at};

const CELLS: usize = 32;
const SPACING: f64 = 0.25;
const LEVEL: f64 = 100.0;

/// A repeatable number in [0, 1) for each place.
fn noise(place: Vec2) -> f64 {
    ((place.x * 12.9898 + place.y * 78.233).sin() * 43758.5453).fract().abs()
}

fn lake(bed: impl Fn(Vec2) -> f64, jitter: f64, integrator: Integrator) -> LagrangianSolver {
    let problem = problem(CELLS, CELLS, SPACING, bed);
    let size = CELLS as f64 * SPACING;
    let seeds = seeds_at(&problem, &places(size, size, SPACING, jitter), SPACING * SPACING, |_| LEVEL);
    LagrangianSolver::new(problem, seeds, integrator)
}

fn rest_speed(mut solver: LagrangianSolver) -> f64 {
    run_steps(&mut solver, 300);
    max_speed(&solver)
}

fn hill(place: Vec2) -> f64 {
    (-(place - Vec2::new(4.1, 3.9)).norm_squared() / 2.0).exp()
}

#[test]
fn explore_lake() {
    for integrator in [Integrator::Leapfrog, Integrator::Heun] {
        for jitter in [0.0, 0.15, 0.3] {
            println!("{jitter} bump {:e}", rest_speed(lake(|p| LEVEL - 1.0 + 0.5 * hill(p), jitter, integrator)));
            println!(
                "{jitter} step {:e}",
                rest_speed(lake(|p| LEVEL - if p.x < 4.0 { 1.0 } else { 0.2 }, jitter, integrator))
            );
            println!("{jitter} rough {:e}", rest_speed(lake(|p| LEVEL - 1.0 + 0.8 * noise(p), jitter, integrator)));
            println!("{jitter} emerged {:e}", rest_speed(lake(|p| LEVEL - 1.0 + 1.8 * hill(p), jitter, integrator)));
        }
    }
}
