//! Sources along lines: their books, their shares, dry ground and lakes, walls, and the same bits for any threads.

use crate::boundary::{LineSource, PointSource, Series};
use crate::math::Vec2;
use crate::methods::Integrator;
use crate::physics::dimension::Dimension;
use crate::solver::lagrangian::LagrangianSolver;
use crate::solver::moving::scene::{problem, solver};
use crate::solver::testing::run_until;
use crate::solver::{EulerianSolver, FlowProblem, FlowSolver, Way};

fn along(cells: impl Iterator<Item = usize>, count: usize, discharge: Series) -> Vec<LineSource> {
    let share = 1.0 / count as f64;
    let cells = cells.take(count).map(|cell| (cell, share)).collect();
    vec![LineSource { name: String::new(), cells, discharge }]
}

/// A basin of 100 m by 50 m of a bed (m) by place, with a line of springs across its middle: 0.25 m³/s, then 0.75 m³/s.
fn fed(bed: impl Fn(Vec2) -> f64, level: f64) -> FlowProblem {
    let mut problem = problem((40, 20), 2.5, bed, |_| level);
    problem.bed.manning.fill(0.04);
    problem.dry_depth = 1e-3;
    let discharge = Series::new(&[(0.0, 0.25), (200.0, 0.25), (200.0, 0.75), (300.0, 0.75)]).unwrap();
    problem.forcing.line_sources = along((0..20).map(|row| row * 40 + 20), 20, discharge);
    problem
}

fn assert_booked(solver: &mut LagrangianSolver, wanted: f64) {
    let ledger = solver.ledger();
    assert!((ledger.inflow / wanted - 1.0).abs() < 1e-12 && ledger.relative_error().abs() < 1e-12, "{ledger:?}");
    let on_grid = solver.water().depths().iter().sum::<f64>() * solver.state().bed.lattice.cell_area();
    assert!((on_grid / ledger.stored - 1.0).abs() < 1e-12, "{on_grid} m3 on the grid of {}", ledger.stored);
    let passages = solver.passages();
    let line = passages.iter().find(|passage| passage.way == Way::LineSource(0)).unwrap();
    assert!((line.inflow / line.asked.unwrap() - 1.0).abs() < 1e-12, "{line:?}");
}

#[test]
fn a_line_runs_on_dry_ground_as_before_resting_particles() {
    let slope = |p: Vec2| 2.0 - 0.02 * p.x;
    let mut moving = solver(fed(slope, f64::NEG_INFINITY), Dimension::Two, Integrator::Leapfrog);
    let mut resting = EulerianSolver::new(fed(slope, f64::NEG_INFINITY));
    // As a film it runs ahead: by the time the front is 40 m down the slope by a fifth in volume, and by a tenth once it has met the foot.
    for (end, wanted, within) in [(20.0, 5.0, 0.0), (200.0, 50.0, 0.3), (300.0, 125.0, 0.15)] {
        let steps = run_until(&mut moving, end);
        run_until(&mut resting, end);
        assert_booked(&mut moving, wanted);
        let depths = [moving.water().depths().to_vec(), resting.water().depths().to_vec()];
        let [beyond, beyond_resting] =
            [0, 1].map(|k| 6.25 * (0..800).filter(|cell| cell % 40 >= 30).map(|cell| depths[k][cell]).sum::<f64>());
        let stored: f64 = depths[0].iter().sum();
        let shares = depths[0].chunks(40).map(|row| row.iter().sum::<f64>() / stored * 20.0);
        let (least, most) =
            shares.fold((f64::INFINITY, 0.0_f64), |(low, high), share| (low.min(share), high.max(share)));
        println!(
            "{end} s: {steps} steps, {} particles, rows {least:.2} to {most:.2}, {beyond:.1} m3 beyond 75 m ({beyond_resting:.1})",
            moving.particles()
        );
        assert!(least > 0.75 && most < 1.3, "the rows have {least} to {most} of their part");
        assert!((beyond - beyond_resting).abs() <= within * beyond_resting, "{beyond} and {beyond_resting} m3");
    }
    assert!(moving.state().owed() < 1.0, "{} m3 are no particle yet", moving.state().owed());
}

#[test]
fn a_lake_rises_evenly_along_a_line() {
    let mut lake = solver(fed(|_| 0.0, 1.0), Dimension::Two, Integrator::Leapfrog);
    let mut fastest = 0.0_f64;
    while lake.time() < 300.0 - 1e-9 {
        let choice = lake.choose_step();
        fastest = fastest.max(choice.max_speed);
        lake.advance(choice.time_step.min(300.0 - lake.time())).unwrap();
    }
    assert_booked(&mut lake, 125.0);
    let level = 1.0 + 125.0 / 5000.0;
    let off = lake.state().particles.depth.iter().map(|d| (d - level).abs()).fold(0.0, f64::max);
    println!("lake: level off by {off:.1e} m, fastest {fastest:.2} m/s");
    assert!(off < 5e-3 && fastest < 0.05, "{off} m, {fastest} m/s");
}

#[test]
fn the_cells_of_a_line_give_by_their_shares() {
    // Two cells far from each other, with ground between them that no water passes.
    let bed = |p: Vec2| if (p.x - 50.0).abs() < 10.0 { 5.0 } else { 0.0 };
    let mut problem = problem((40, 8), 2.5, bed, |_| f64::NEG_INFINITY);
    problem.dry_depth = 1e-3;
    let discharge = Series::constant(0.5);
    let cells = vec![(4 * 40 + 5, 0.75), (4 * 40 + 34, 0.25)];
    problem.forcing.line_sources = vec![LineSource { name: String::new(), cells, discharge }];
    let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
    run_until(&mut solver, 300.0);
    assert_booked(&mut solver, 150.0);
    let particles = &solver.state().particles;
    let west = (0..particles.len()).filter(|&i| particles.position[i].x < 50.0).map(|i| particles.volume[i]);
    let share = west.sum::<f64>() / 150.0;
    // Within one particle of a cell of 0.5 m.
    assert!((share - 0.75).abs() < 0.02, "{share}");
}

#[test]
fn a_line_beside_a_wall_or_a_levee_does_not_lift_the_water_behind_it() {
    let levee = |p: Vec2| if (p.x - 55.0).abs() < 1.5 { 3.0 } else { 0.0 };
    for (name, is_walled) in [("wall", true), ("levee", false)] {
        let bed = |p: Vec2| if is_walled { 0.0 } else { levee(p) };
        // At rest on both sides, dry on the levee.
        let mut problem = problem((40, 20), 2.5, bed, |_| 1.0);
        let discharge = Series::constant(0.5);
        problem.forcing.line_sources = along((0..20).map(|row| row * 40 + 19), 20, discharge);
        if is_walled {
            problem.walls = vec![[Vec2::new(55.0, 0.0), Vec2::new(55.0, 50.0)]];
        }
        let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
        let behind = |solver: &LagrangianSolver| {
            let particles = &solver.state().particles;
            (0..particles.len())
                .filter(|&i| particles.position[i].x > 56.0)
                .map(|i| (particles.depth[i] - 1.0).abs())
                .fold(0.0, f64::max)
        };
        for _ in 0..20 {
            let choice = solver.choose_step();
            solver.advance(choice.time_step).unwrap();
        }
        println!("{name}: {:.1e} m behind it after {} s", behind(&solver), solver.time());
        assert!(solver.ledger().inflow > 0.1 && behind(&solver) < 1e-9, "{name}: {} m", behind(&solver));
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let state_after = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut problem = fed(|p| 0.01 * p.x, 0.5);
            problem.forcing.sources =
                vec![PointSource { place: Vec2::new(81.0, 21.0), discharge: Series::constant(0.5) }; 2];
            let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
            for _ in 0..300 {
                let choice = solver.choose_step();
                solver.advance(choice.time_step).unwrap();
            }
            let bits: Vec<u64> = solver.state().particles.depth.iter().map(|d| d.to_bits()).collect();
            (bits, solver.ledger().inflow.to_bits())
        })
    };
    let one = state_after(1);
    assert_eq!(one, state_after(2));
    assert_eq!(one, state_after(5));
}
