//! Circular dam break in a quadrant whose two walls are the planes of symmetry.

use floodsim::math::Vec2;
use floodsim::scenario::methods::Integrator;
use floodsim::solver::FlowSolver;
use floodsim::solver::lagrangian::LagrangianSolver;

use crate::support::{mean_errors, places, problem, radial_reference, run_until, seeds_at};

const SIZE: f64 = 12.0;
const DAM: f64 = 2.5;
const END: f64 = 1.4;

fn quadrant(spacing: f64, integrator: Integrator) -> LagrangianSolver {
    let cells = (SIZE / spacing).round() as usize;
    let mut problem = problem(cells, cells, spacing, |_| 0.0);
    problem.courant = LagrangianSolver::default_courant(integrator);
    let level = |p: Vec2| if p.norm() < DAM { 2.5 } else { 0.5 };
    let seeds = seeds_at(&problem, &places(SIZE, SIZE, spacing, 0.0), spacing * spacing, level);
    LagrangianSolver::new(problem, seeds, integrator)
}

#[test]
fn explore_circle() {
    let reference = radial_reference(2.5, 0.5, DAM, 17.0, END, 4000);
    for (dx, integrator) in [(0.2, Integrator::Leapfrog), (0.2, Integrator::Heun), (0.1, Integrator::Leapfrog)] {
        let start = std::time::Instant::now();
        let mut solver = quadrant(dx, integrator);
        run_until(&mut solver, END);
        let errors = mean_errors(&solver, |p| {
            let (d, u) = reference(p.norm());
            (d, p * (u / p.norm()))
        });
        let s = start.elapsed().as_secs_f64();
        println!("circle {dx} {}: {errors:.4?} {} us/eval {:.2} (wall)", integrator.name(), solver.steps(), s * 1e6 / solver.particle_evaluations() as f64);
        let p = &solver.state().particles;
        let sum = (0..p.len()).fold(Vec2::ZERO, |s, i| s + p.velocity[i] * p.volume[i]);
        println!("symmetry {:e}", (sum.x - sum.y) / sum.x);
    }
}

#[test]
fn explore_spread() {
    let reference = radial_reference(1.0, 1e-9, 1.0, 8.0, 1.0, 4000);
    for dx in [0.05, 0.025] {
        let cells = (8.0 / 0.1_f64).round() as usize;
        let problem = problem(cells, cells, 0.1, |_| 0.0);
        let all = places(1.0, 1.0, dx, 0.0);
        let seeds = seeds_at(&problem, &all, dx * dx, |p| if p.norm() < 1.0 { 1.0 } else { 0.0 });
        let mut solver = LagrangianSolver::new(problem, seeds, Integrator::Leapfrog);
        run_until(&mut solver, 1.0);
        let p = &solver.state().particles;
        let (mut depth, mut velocity, mut volume, mut far) = (0.0, 0.0, 0.0, 0.0_f64);
        for i in 0..p.len() {
            let r = p.position[i].norm();
            let (d, u) = reference(r);
            depth += (p.depth[i] - d).abs();
            velocity += p.volume[i] * (p.velocity[i] - p.position[i] * (u / r)).norm();
            volume += p.volume[i];
            far = far.max(r);
        }
        println!("spread {dx}: depth {:.2e} velocity {:.3} far {far:.2} steps {} n {}", depth / p.len() as f64, velocity / volume, solver.steps(), p.len());
    }
}
