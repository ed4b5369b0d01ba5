//! Water thinner than the steps of the bed: uniform flow, rain, a cliff; mirror images to the last bit.

use super::{EulerianMethods, EulerianSolver};
use crate::bed::BedParticles;
use crate::boundary::{Condition, Rain, Series};
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::methods::Reconstruction;
use crate::solver::testing::{open, run_until, still_water};
use crate::solver::{FlowProblem, FlowSolver};

const N: f64 = 0.04;

/// Repeatable noise of unit variance.
fn noise(index: usize) -> f64 {
    let part = |k: usize| ((index * 12 + k) as f64 * 78.233).sin() * 43_758.545_3;
    (0..12).map(|k| part(k).rem_euclid(1.0)).sum::<f64>() - 6.0
}

/// Uniform depth (m) of a unit discharge (m²/s) on a slope.
fn normal_depth(q: f64, slope: f64) -> f64 {
    (q * N / slope.sqrt()).powf(0.6)
}

fn solver(problem: FlowProblem, moves: bool) -> EulerianSolver {
    EulerianSolver::with_methods(problem, EulerianMethods { moves, ..EulerianMethods::default() })
}

/// Rows of a channel: where cells move, two beside each wall rest.
fn rows(moves: bool) -> usize {
    if moves { 8 } else { 2 }
}

/// A channel that falls by `slope` with a bed by column; fed with `q` (m²/s) in uniform flow, left at normal depth.
fn fed(
    (columns, spacing): (usize, f64),
    slope: f64,
    q: f64,
    bed: impl Fn(usize) -> f64,
    moves: bool,
) -> EulerianSolver {
    let at = |place: Vec2| bed((place.x / spacing) as usize);
    let mut problem = still_water((columns, rows(moves)), spacing, at, |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(N);
    problem.dry_depth = 1e-3;
    let level = bed(0) + 0.5 * slope * spacing + normal_depth(q, slope);
    let discharge = Series::constant(rows(moves) as f64 * spacing * q);
    open(&mut problem, true, Condition::Discharge { discharge, level: Some(Series::constant(level)) });
    open(&mut problem, false, Condition::NormalDepth { slope });
    solver(problem, moves)
}

/// Mean depth by the normal one, and greatest discharge in a cell by that of uniform flow, over the middle of a channel.
fn of_uniform(solver: &mut EulerianSolver, columns: usize, (depth, q): (f64, f64)) -> (f64, f64) {
    let row = solver.lattice.rows / 2;
    let water = solver.water();
    let middle: Vec<_> = (columns / 5..columns * 4 / 5).map(|column| water.at(row * columns + column)).collect();
    let mean = middle.iter().map(|cell| cell.depth).sum::<f64>() / middle.len() as f64;
    (mean / depth, middle.iter().map(|cell| cell.discharge_x).fold(0.0, f64::max) / q)
}

#[test]
fn a_step_on_a_steep_slope_does_not_hold_thin_water() {
    // The bed falls everywhere; one row of cells lies 1 m lower.
    let (slope, q, spacing) = (0.5, 0.02, 10.0);
    let bed = |column: usize| -slope * spacing * column as f64 - if column == 15 { 1.0 } else { 0.0 };
    for moves in [false, true] {
        let mut solver = fed((30, spacing), slope, q, bed, moves);
        run_until(&mut solver, 900.0);
        let deepest = solver.water().depths().iter().copied().fold(0.0, f64::max);
        println!("moves {moves}: {deepest} m, uniform {} m", normal_depth(q, slope));
        // Under cells that move some water stands before the step: see decision 0071.
        let most = if moves { 0.1 } else { 0.018 };
        assert!((0.016..most).contains(&deepest), "moves {moves}: {deepest} m");
    }
}

#[test]
fn metre_rounded_ground_carries_uniform_flow() {
    for (q, end, moves) in [(2.0, 2500.0, false), (20.0, 1200.0, false), (2.0, 2500.0, true), (20.0, 1200.0, true)] {
        let (slope, spacing, columns) = (0.1, 30.0, 100);
        let bed = |column: usize| (-3.0 * column as f64 - 1.5).round_ties_even();
        let mut solver = fed((columns, spacing), slope, q, bed, moves);
        run_until(&mut solver, end);
        let (depth, discharge) = of_uniform(&mut solver, columns, (normal_depth(q, slope), q));
        let seen =
            format!("{q} m2/s, moves {moves}: {depth} of the normal depth, discharge in a cell up to {discharge}");
        println!("{seen}");
        // Cells that move cross the steps of the bed, and the raise of their surface (M22) is less: see decision 0071.
        let bounds = if moves { (0.15, 0.6) } else { (0.03, 0.1) };
        assert!((depth - 1.0).abs() < bounds.0 && (discharge - 1.0).abs() < bounds.1, "{seen}");
    }
}

#[test]
fn a_rough_bed_holds_as_much_water_as_on_an_eight_times_finer_lattice() {
    // The bed of the finer one is linear between the middles of the cells.
    let (slope, sigma, q, columns) = (0.1, 0.2, 0.2, 100);
    let bed = |column: usize| -slope * 10.0 * column as f64 + sigma * noise(column);
    let between = |column: usize| {
        let at = ((column as f64 + 0.5) / 8.0 - 0.5).clamp(0.0, columns as f64 - 1.000_001);
        let (left, share) = (at.floor() as usize, at.fract());
        (1.0 - share) * bed(left) + share * bed(left + 1)
    };
    let of_normal = |mut solver: EulerianSolver, columns: usize| {
        run_until(&mut solver, 1500.0);
        of_uniform(&mut solver, columns, (normal_depth(q, slope), q)).0
    };
    let fine = of_normal(fed((8 * columns, 1.25), slope, q, between, false), 8 * columns);
    for moves in [false, true] {
        let coarse = of_normal(fed((columns, 10.0), slope, q, bed, moves), columns);
        println!("moves {moves}: coarse {coarse}, fine {fine} of the normal depth");
        assert!((coarse / fine - 1.0).abs() < 0.05, "moves {moves}: coarse {coarse}, fine {fine} of the normal depth");
    }
}

#[test]
fn rain_runs_off_a_rough_slope() {
    // 80 mm/h on a slope of 0.3 with noise of 0.15 m; kinematic routing leaves what a smooth plane keeps, to some per cent.
    let kept = |sigma: f64, moves: bool| {
        let bed = |place: Vec2| {
            let (column, row) = ((place.x / 10.0) as usize, (place.y / 10.0) as usize);
            -0.3 * place.x + sigma * noise(37 * row + column)
        };
        let mut problem = still_water((40, 20), 10.0, bed, |_| f64::NEG_INFINITY);
        problem.bed.manning.fill(N);
        problem.dry_depth = 1e-3;
        problem.forcing.rain = Some(Rain::Uniform(Series::constant(0.08 / 3600.0)));
        open(&mut problem, false, Condition::NormalDepth { slope: 0.3 });
        let mut solver = solver(problem, moves);
        run_until(&mut solver, 1200.0);
        solver.ledger().stored
    };
    for moves in [false, true] {
        let (smooth, rough) = (kept(0.0, moves), kept(0.15, moves));
        println!("moves {moves}: smooth {smooth} m3, rough {rough} m3");
        assert!((rough / smooth - 1.0).abs() < 0.05, "moves {moves}: smooth {smooth} m3, rough {rough} m3");
    }
}

#[test]
fn water_over_a_cliff_is_no_faster_than_the_lattice_can_tell() {
    let bed = |column: usize| if column < 30 { 120.0 } else { 0.0 } - 0.05 * column as f64;
    // Cells that move fall with their water: no faster than by the height.
    for (moves, bound) in [(false, 20.0), (true, (2.0 * 9.81 * 122.0_f64).sqrt())] {
        let mut solver = fed((60, 5.0), 0.01, 5.0, bed, moves);
        let mut fastest = 0.0_f64;
        while solver.time() < 200.0 {
            let choice = solver.choose_step();
            fastest = fastest.max(choice.max_speed);
            solver.advance(choice.time_step).unwrap();
        }
        println!("moves {moves}: {fastest} m/s");
        assert!(fastest < bound, "moves {moves}: {fastest} m/s");
    }
}

/// A dam break over a random bed, seen as it is or mirrored.
fn over_a_random_bed(
    place_of: impl Fn(usize, usize) -> (usize, usize),
    reconstruction: Reconstruction,
) -> Vec<[u64; 3]> {
    const SIZE: usize = 40;
    let lattice = Lattice::new(Vec2::ZERO, SIZE, SIZE, 2.0);
    let at = |cell: usize| {
        let (column, row) = place_of(cell % SIZE, cell / SIZE);
        (column, row, 1.5 * noise(SIZE * row + column) - 0.1 * column as f64)
    };
    let elevation: Vec<f64> = (0..lattice.len()).map(|cell| at(cell).2).collect();
    let is_wet = |cell: usize| at(cell).0 < 15 && at(cell).1 < 22;
    let initial_depth = (0..lattice.len()).map(|cell| if is_wet(cell) { 4.0 } else { 0.0 }).collect();
    let mut problem = FlowProblem {
        bed: BedParticles::from_elevation(lattice, elevation, 0.03),
        initial_depth,
        dry_depth: 1e-3,
        courant: 0.5,
        ..still_water((1, 1), 1.0, |_| 0.0, |_| 0.0)
    };
    problem.gravity = 9.81;
    let mut solver =
        EulerianSolver::with_methods(problem, EulerianMethods { reconstruction, ..EulerianMethods::default() });
    for _ in 0..200 {
        let choice = solver.choose_step();
        solver.advance(choice.time_step).unwrap();
    }
    let water = solver.water();
    (0..SIZE * SIZE)
        .map(|cell| water.at(cell))
        .map(|cell| [cell.depth, cell.discharge_x, cell.discharge_y].map(|value| (value + 0.0).to_bits()))
        .collect()
}

#[test]
fn mirror_images_are_equal_to_the_bit() {
    const LAST: usize = 39;
    let turned = |bits: u64| (-f64::from_bits(bits) + 0.0).to_bits();
    for reconstruction in [Reconstruction::Limited, Reconstruction::Sharp, Reconstruction::None] {
        let plain = over_a_random_bed(|column, row| (column, row), reconstruction);
        assert!(plain.iter().filter(|cell| f64::from_bits(cell[0]) > 0.1).count() > 400, "the water has spread");
        let in_x = over_a_random_bed(|column, row| (LAST - column, row), reconstruction);
        let in_y = over_a_random_bed(|column, row| (column, LAST - row), reconstruction);
        let transposed = over_a_random_bed(|column, row| (row, column), reconstruction);
        for (index, &[d, x, y]) in plain.iter().enumerate() {
            let (column, row) = (index % 40, index / 40);
            assert_eq!(
                in_x[40 * row + LAST - column],
                [d, turned(x), y],
                "{reconstruction:?}, in x, ({column}, {row})"
            );
            assert_eq!(
                in_y[40 * (LAST - row) + column],
                [d, x, turned(y)],
                "{reconstruction:?}, in y, ({column}, {row})"
            );
            assert_eq!(transposed[40 * column + row], [d, y, x], "{reconstruction:?}, transposed, ({column}, {row})");
        }
    }
}
