//! Tracers on cells that rest and on cells that move: uniform ones stay so, nothing is lost, and none leaves its bounds.

use super::super::{EulerianMethods, EulerianSolver};
use crate::boundary::{Condition, LineSource, PointSource, Rain, Series, Tracer};
use crate::math::Vec2;
use crate::solver::threads::in_pool;
use crate::solver::{FlowProblem, FlowSolver};

/// A hillside with a wall, a lake that runs down it, an open side, rain, and sources.
fn scene() -> FlowProblem {
    let lattice = crate::lattice::Lattice::new(Vec2::ZERO, 50, 30, 2.0);
    let bed = |place: Vec2| 0.02 * (100.0 - place.x) + 0.1 * (place.x * 0.7).sin() * (place.y * 0.4).cos();
    let level = |place: Vec2| if place.x < 30.0 { 3.0 } else { 0.0 };
    let elevation: Vec<f64> = (0..lattice.len()).map(|i| bed(lattice.centre(i))).collect();
    let depth = (0..lattice.len()).map(|i| (level(lattice.centre(i)) - elevation[i]).max(0.0)).collect();
    let mut problem = super::super::tests::problem(lattice, elevation, depth);
    problem.bed.manning.fill(0.03);
    problem.walls.push([Vec2::new(60.0, 0.0), Vec2::new(60.0, 30.0)]);
    let east = vec![[Vec2::new(100.0, 0.0), Vec2::new(100.0, 60.0)]];
    problem.forcing.reach = 0.6;
    problem.forcing.boundaries.push(crate::boundary::Boundary { pieces: east.into(), condition: Condition::Free });
    let west = vec![[Vec2::new(0.0, 0.0), Vec2::new(0.0, 60.0)]];
    let discharge = Condition::Discharge { discharge: Series::constant(3.0), level: None };
    problem.forcing.boundaries.push(crate::boundary::Boundary { pieces: west.into(), condition: discharge });
    problem.forcing.rain = Some(Rain::Uniform(Series::constant(1e-4)));
    problem.forcing.sources.push(PointSource { place: Vec2::new(80.0, 10.0), discharge: Series::constant(2.0) });
    let cells = vec![(1240, 0.5), (1241, 0.5)];
    problem.forcing.line_sources.push(LineSource { name: String::new(), cells, discharge: Series::constant(0.5) });
    problem
}

/// The same concentration of all water.
fn uniform(problem: &FlowProblem, concentration: f64) -> Tracer {
    Tracer {
        initial: vec![concentration; problem.bed.lattice.len()],
        boundaries: vec![concentration; 2],
        sources: vec![concentration],
        line_sources: vec![concentration],
        rain: concentration,
        decay: 0.0,
    }
}

/// Checked water by its place, from 0.2 to 5, with clean water by the sources but one.
fn checked(problem: &FlowProblem) -> Tracer {
    let initial = (0..problem.bed.lattice.len()).map(|i| if (i / 3 + i / 150) % 2 == 0 { 5.0 } else { 0.2 });
    Tracer {
        initial: initial.collect(),
        boundaries: vec![9.0, 3.0],
        sources: vec![4.0],
        line_sources: vec![0.0],
        rain: 0.5,
        decay: 0.0,
    }
}

fn solver(problem: FlowProblem, moves: bool) -> EulerianSolver {
    EulerianSolver::with_methods(problem, EulerianMethods { moves, ..EulerianMethods::default() })
}

fn run(solver: &mut EulerianSolver, end: f64) {
    in_pool(|| {
        while solver.time() < end {
            let step = solver.choose_step().time_step.min(end - solver.time());
            solver.advance(step).expect("a stable run");
        }
    });
}

/// Depths and concentrations of the wet cells on the map.
fn on_map(solver: &mut EulerianSolver, tracer: usize) -> Vec<(f64, f64)> {
    let water = solver.water();
    let rows = (0..water.lattice.rows).flat_map(|row| {
        let (own, of) = (water.rows.row(row), water.rows.concentration(tracer, row));
        (0..of.len()).map(move |column| (own.depth[column], of[column])).collect::<Vec<_>>()
    });
    rows.filter(|(depth, _)| *depth > 0.0).collect()
}

#[test]
#[expect(clippy::float_cmp, reason = "a uniform concentration stays what it is to the last bit")]
fn a_uniform_concentration_stays_uniform_to_the_last_bit() {
    // A third has no end in binary.
    let concentration = 1.0 / 3.0;
    for moves in [false, true] {
        let mut problem = scene();
        problem.forcing.tracers = vec![uniform(&problem, concentration)];
        let mut solver = solver(problem, moves);
        assert_eq!(solver.has_moving(), moves);
        run(&mut solver, 30.0);
        let water = on_map(&mut solver, 0);
        assert!(water.len() > 1200);
        assert!(water.iter().all(|(_, of)| *of == concentration), "{moves}");
        let (ledger, volumes) = (solver.tracers()[0], solver.ledger());
        assert!((ledger.stored / (concentration * volumes.stored) - 1.0).abs() < 1e-13);
        assert!((ledger.inflow / (concentration * volumes.inflow) - 1.0).abs() < 1e-12, "{ledger:?} {volumes:?}");
        assert!((ledger.outflow / (concentration * volumes.outflow) - 1.0).abs() < 1e-12, "{ledger:?} {volumes:?}");
    }
}

#[test]
fn nothing_is_lost_and_no_concentration_leaves_its_bounds() {
    for moves in [false, true] {
        let mut problem = scene();
        problem.forcing.tracers = vec![checked(&problem), uniform(&problem, 1.0)];
        let mut solver = solver(problem, moves);
        run(&mut solver, 30.0);
        let ledger = solver.tracers()[0];
        assert!(ledger.outflow > 1.0 && ledger.inflow > 1.0, "{ledger:?}");
        assert!(ledger.relative_error().abs() < 1e-12, "{moves}: {ledger:?} {:e}", ledger.relative_error());
        // The water beyond the eastern side has 9, and stays there.
        let outside = on_map(&mut solver, 0).iter().filter(|(_, of)| !(0.0..=5.0).contains(of)).count();
        assert_eq!(outside, 0, "{moves}");
    }
}

#[test]
fn what_decays_follows_its_law() {
    for moves in [false, true] {
        let mut problem = scene();
        (problem.forcing.rain, problem.forcing.sources, problem.forcing.line_sources) = (None, Vec::new(), Vec::new());
        problem.forcing.boundaries.clear();
        problem.forcing.tracers = vec![Tracer { decay: 0.05, ..uniform(&problem, 8.0) }];
        let mut solver = solver(problem, moves);
        run(&mut solver, 20.0);
        let expected = 8.0 * (-1.0_f64).exp();
        let worst = on_map(&mut solver, 0).iter().map(|(_, of)| (of / expected - 1.0).abs()).fold(0.0, f64::max);
        let ledger = solver.tracers()[0];
        assert!(worst < 1e-12 && ledger.relative_error().abs() < 1e-12, "{worst:e} {ledger:?}");
    }
}

#[test]
fn threads_change_no_bit() {
    let bits = |threads: usize, moves: bool| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let mut problem = scene();
            problem.forcing.tracers = vec![checked(&problem)];
            let mut solver = solver(problem, moves);
            for _ in 0..60 {
                let step = solver.choose_step().time_step;
                solver.advance(step).expect("a stable run");
            }
            let stored = solver.tracers()[0].stored.to_bits();
            on_map(&mut solver, 0).iter().map(|(_, of)| of.to_bits()).chain([stored]).collect::<Vec<u64>>()
        })
    };
    for moves in [false, true] {
        assert!(bits(1, moves) == bits(2, moves), "{moves}");
    }
}

/// A flat tray of 60 by 60 m with a square of marked water in a stream without waves.
fn stream() -> FlowProblem {
    let lattice = crate::lattice::Lattice::new(Vec2::ZERO, 60, 60, 1.0);
    let is_marked = |place: Vec2| (place.x - 20.0).abs() < 5.0 && (place.y - 30.0).abs() < 5.0;
    let initial = (0..lattice.len()).map(|i| f64::from(u8::from(is_marked(lattice.centre(i))))).collect();
    let count = lattice.len();
    let mut problem = super::super::tests::problem(lattice, vec![0.0; count], vec![1.0; count]);
    problem.forcing.tracers = vec![Tracer { initial, ..Tracer::default() }];
    problem
}

#[test]
fn moving_cells_keep_the_variance_that_faces_mix_away() {
    let kept = |moves: bool| {
        let mut solver = solver(stream(), moves);
        let variance = |solver: &EulerianSolver| {
            let cells = solver.moving.as_ref().map(|moving| moving.tracer_square(0));
            cells.unwrap_or(0.0) + solver.state.tracers.square_in_rows(&solver.state)
        };
        let before = variance(&solver);
        solver.set_velocity(|_| Vec2::new(2.0, 0.7));
        // The waves from the walls do not reach the square, which goes 6 m.
        run(&mut solver, 3.0);
        variance(&solver) / before
    };
    let (resting, moving) = (kept(false), kept(true));
    println!("of the square of the concentration {resting:.4} is kept on resting cells, {moving:.6} on moving ones");
    assert!(moving > 0.9999 && resting < 0.95, "{resting} {moving}");
}

#[test]
fn a_front_over_dry_ground_loses_nothing_of_what_it_carries() {
    // Cells take part in the second stage of a step that did not in the first.
    for moves in [false, true] {
        let lattice = crate::lattice::Lattice::new(Vec2::ZERO, 60, 40, 1.0);
        let depth = |place: Vec2| if (place - Vec2::new(25.0, 20.0)).norm() < 8.0 { 2.0 } else { 0.0 };
        let bed = |place: Vec2| 0.05 * (place.y * 0.9).sin() + 0.03 * (place.x * 1.3).cos();
        let depths = (0..lattice.len()).map(|i| depth(lattice.centre(i))).collect();
        let beds = (0..lattice.len()).map(|i| bed(lattice.centre(i))).collect();
        let initial = (0..lattice.len()).map(|i| 2.0 + lattice.centre(i).x.sin()).collect();
        let mut problem = super::super::tests::problem(lattice, beds, depths);
        problem.forcing.tracers = vec![Tracer { initial, ..Tracer::default() }];
        let mut solver = solver(problem, moves);
        run(&mut solver, 8.0);
        let ledger = solver.tracers()[0];
        assert!(ledger.relative_error().abs() < 1e-13, "{moves}: {:e}", ledger.relative_error());
        let outside = on_map(&mut solver, 0).iter().filter(|(_, of)| !(1.0..=3.0).contains(of)).count();
        assert_eq!(outside, 0, "{moves}");
    }
}
