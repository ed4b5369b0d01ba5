//! Still water asleep: what sleeps, what wakes it, and that a run is the same but for rounding.

use crate::lattice::{Lattice, Nest};
use crate::math::Vec2;
use crate::solver::eulerian::tests::{bits, noise, problem};
use crate::solver::eulerian::{EulerianMethods, EulerianSolver};
use crate::solver::testing::{run_steps, run_until};
use crate::solver::{FlowProblem, FlowSolver, nested};

/// Level (m) of the lakes, and of the water that falls into them.
const LEVEL: f64 = 2.0;
const HUMP: f64 = 3.0;

/// Cells of a basin, some more than nine blocks by six.
const CELLS: (usize, usize) = (150, 101);

/// A lake over rough ground with islands, and a hump of water in its south-western corner where `has_hump`; all seen in a mirror where it says so, of
/// the columns and of the rows.
fn lake(has_hump: bool, mirrored: (bool, bool)) -> FlowProblem {
    let (columns, rows) = CELLS;
    let lattice = Lattice::new(Vec2::ZERO, columns, rows, 1.0);
    let place = |cell: usize| {
        let (column, row) = lattice.column_row(cell);
        let column = if mirrored.0 { columns - 1 - column } else { column };
        (column, if mirrored.1 { rows - 1 - row } else { row })
    };
    let bed = |cell: usize| {
        let (column, row) = place(cell);
        2.5 * (noise(row * columns + column) + 0.3)
    };
    let elevation: Vec<f64> = (0..lattice.len()).map(bed).collect();
    let is_hump = |cell: usize| has_hump && place(cell).0 < 12 && place(cell).1 < 12;
    let level = |cell: usize| if is_hump(cell) { HUMP } else { LEVEL };
    let depth = (0..lattice.len()).map(|cell| (level(cell) - elevation[cell]).max(0.0)).collect();
    problem(lattice, elevation, depth)
}

/// The same on two levels, the finer one about the hump.
fn lake_on_levels() -> FlowProblem {
    let finer = Nest::graded((160, 96), 0.5, 16, 1, |column, row| usize::from(column > 0 || row > 0));
    let level = |columns: usize, rows: usize, spacing: f64| {
        let own = Lattice::new(Vec2::ZERO, columns, rows, spacing);
        let elevation = vec![0.0; own.len()];
        let is_hump = |cell: usize| own.centre(cell).norm() < 6.0;
        let depth = (0..own.len()).map(|cell| if is_hump(cell) { HUMP } else { LEVEL }).collect();
        problem(own, elevation, depth)
    };
    let levels = finer.levels().iter().map(|of| level(of.columns, of.rows, of.spacing)).collect();
    nested(levels, finer)
}

/// A solver whose water sleeps.
fn sleepy(problem: FlowProblem) -> EulerianSolver {
    EulerianSolver::with_methods(problem, EulerianMethods { sleeps: true, ..EulerianMethods::default() })
}

fn sleeping(solver: &EulerianSolver) -> usize {
    solver.active.asleep.wet_cells()
}

#[test]
fn a_lake_at_rest_costs_no_work() {
    let mut solver = sleepy(lake(false, (false, false)));
    let wet = solver.active.wet_cells();
    run_steps(&mut solver, 1);
    assert_eq!((sleeping(&solver), solver.active.wet_cells()), (wet, wet));
    let evaluations = solver.evaluations;
    run_steps(&mut solver, 20);
    assert_eq!((solver.evaluations, solver.active.wet_cells()), (evaluations, wet));
    assert!(solver.ledger().relative_error().abs() < 1e-15);
}

#[test]
fn mirror_images_are_the_same_to_the_last_bit() {
    let run = |mirrored: (bool, bool), steps: usize| {
        let mut solver = sleepy(lake(true, mirrored));
        run_steps(&mut solver, steps);
        solver
    };
    for steps in [1, 5, 40, 90] {
        let mut seen = run((false, false), steps);
        let (columns, rows) = CELLS;
        println!("{steps} steps: {} of {} cells asleep", sleeping(&seen), seen.active.wet_cells());
        assert!(sleeping(&seen) > 1000);
        for mirrored in [(true, false), (false, true), (true, true)] {
            let (image, bits_of_seen) = (bits(&mut run(mirrored, steps)), bits(&mut seen));
            for (cell, own) in bits_of_seen.iter().enumerate() {
                let (column, row) = (cell % columns, cell / columns);
                let column = if mirrored.0 { columns - 1 - column } else { column };
                let row = if mirrored.1 { rows - 1 - row } else { row };
                let turn = |value: u64, is_turned: bool| {
                    let value = f64::from_bits(value);
                    (if is_turned { 0.0 - value } else { value }).to_bits()
                };
                let [depth, qx, qy] = image[row * columns + column];
                assert_eq!(*own, [depth, turn(qx, mirrored.0), turn(qy, mirrored.1)], "cell {cell} in {mirrored:?}");
            }
        }
    }
}

#[test]
fn a_wave_into_sleeping_water_is_that_into_water_awake() {
    for (name, scene) in [("one lattice", lake(true, (false, false))), ("levels", lake_on_levels())] {
        let (mut one, mut other) = (sleepy(scene.clone()), EulerianSolver::new(scene));
        let initial = other.volume();
        let mut asleep = Vec::new();
        for time in [1.0, 4.0, 12.0, 40.0] {
            run_until(&mut one, time);
            run_until(&mut other, time);
            asleep.push(sleeping(&one));
            let depths = one.water().depths();
            let worst = depths.iter().zip(other.water().depths()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            println!("{name}, {time} s: {} cells asleep, {worst:e} m", sleeping(&one));
            assert!(worst < 1e-9, "{name}, {time} s: {worst:e} m");
        }
        assert!(asleep[0] > 1000 && asleep[3] == 0, "{name}: {asleep:?}");
        assert!((one.volume() / initial - 1.0).abs() < 1e-13, "{name}");
        assert!(one.evaluations < other.evaluations);
    }
}

#[test]
fn any_number_of_threads_wakes_the_same_blocks() {
    let state_after = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool of threads");
        pool.install(|| {
            let mut solver = sleepy(lake(true, (false, false)));
            run_steps(&mut solver, 80);
            bits(&mut solver)
        })
    };
    let one = state_after(1);
    assert!([2, 5].into_iter().all(|threads| state_after(threads) == one));
}
