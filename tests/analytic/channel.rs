//! Dam breaks in a channel of one dimension.

use floodsim::math::Vec2;
use floodsim::particles::FluidSeed;
use floodsim::scenario::methods::{Integrator, Stabilisation};
use floodsim::solver::FlowSolver;
use floodsim::solver::lagrangian::LagrangianSolver;
use floodsim::solver::variational::VariationalSolver;

use crate::support::{mean_errors, problem, ritter, run_until, stoker};

const LENGTH: f64 = 2000.0;
const DAM: f64 = 1000.0;

/// Particles of one length, deep up to the dam.
fn dam_break(spacing: f64, left: f64, right: f64, integrator: Integrator) -> LagrangianSolver {
    let columns = (LENGTH / spacing) as usize;
    let mut problem = problem(columns, 1, spacing, |_| 0.0);
    problem.courant = LagrangianSolver::default_courant(integrator);
    let seeds: Vec<FluidSeed> = (0..columns)
        .map(|column| {
            let x = (column as f64 + 0.5) * spacing;
            let depth = if x < DAM { left } else { right };
            FluidSeed { position: Vec2::new(x, 0.5 * spacing), volume: depth * spacing, depth }
        })
        .filter(|seed| seed.depth > 0.0)
        .collect();
    LagrangianSolver::one_dimensional(problem, seeds, integrator)
}

fn errors(spacing: f64, left: f64, right: f64, integrator: Integrator, end: f64) -> (f64, f64) {
    let mut solver = dam_break(spacing, left, right, integrator);
    run_until(&mut solver, end);
    let errors = mean_errors(&solver, |place| {
        let x = place.x - DAM;
        let (d, u) = if right > 0.0 { stoker(left, right, x, end) } else { ritter(left, x, end) };
        (d, Vec2::new(u, 0.0))
    });
    println!(
        "{left}/{right} dx {spacing} {}: depth {:.4} velocity {:.4} steps {} evaluations {}",
        integrator.name(),
        errors.0,
        errors.1,
        solver.steps(),
        solver.particle_evaluations()
    );
    assert!(solver.ledger().relative_error().abs() < 1e-12);
    errors
}

#[test]
fn explore() {
    for right in [0.0, 5.0] {
        for stab in [Stabilisation::ArtificialViscosity, Stabilisation::Riemann] {
            for spacing in [10.0, 5.0] {
                let columns = (LENGTH / spacing) as usize;
                let problem = problem(columns, 1, spacing, |_| 0.0);
                let seeds: Vec<FluidSeed> = (0..columns)
                    .map(|column| {
                        let x = (column as f64 + 0.5) * spacing;
                        let depth = if x < DAM { 10.0 } else { right };
                        FluidSeed { position: Vec2::new(x, 0.5 * spacing), volume: depth * spacing, depth }
                    })
                    .filter(|seed| seed.depth > 0.0)
                    .collect();
                let mut solver = VariationalSolver::one_dimensional(problem, seeds, Integrator::Leapfrog, stab);
                run_until(&mut solver, 50.0);
                let errors = mean_errors(&solver, |place| {
                    let x = place.x - DAM;
                    let (d, u) = if right > 0.0 { stoker(10.0, right, x, 50.0) } else { ritter(10.0, x, 50.0) };
                    (d, Vec2::new(u, 0.0))
                });
                println!("{right} {spacing} {stab:?} {errors:.4?} {}", solver.steps());
            }
        }
    }
    for dx in [10.0, 5.0, 2.5] {
        for i in [Integrator::Leapfrog, Integrator::Heun] {
            errors(dx, 10.0, 0.0, i, 50.0);
            errors(dx, 10.0, 5.0, i, 50.0);
        }
    }
}
