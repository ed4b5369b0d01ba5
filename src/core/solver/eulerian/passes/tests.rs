use super::super::state::State;
use super::super::tests::{noise, problem, run};
use super::super::walls::Walls;
use super::super::{EulerianMethods, EulerianSolver};
use super::Passes;
use crate::bed::{PassSill, PassSills};
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::solver::{FlowProblem, FlowSolver};

const COLUMNS: usize = 40;

fn lattice(rows: usize) -> Lattice {
    Lattice::new(Vec2::ZERO, COLUMNS, rows, 1.0)
}

/// The same sill (m) in all faces to the east of a column.
fn ridge(rows: usize, column: usize, level: f64) -> Vec<PassSill> {
    (0..rows).map(|row| PassSill::whole(row * COLUMNS + column, false, level)).collect()
}

fn depths(solver: &mut EulerianSolver) -> Vec<f64> {
    solver.water().depths()
}

#[test]
fn pockets_on_both_sides_of_ridges_stay_at_rest_at_their_own_levels() {
    let lattice = lattice(30);
    let mut sills = Vec::new();
    // Ridges around blocks of 4 by 3 cells, and a few inside them under the water.
    for cell in 0..lattice.len() {
        let (column, row) = lattice.column_row(cell);
        for (is_north, is_ridge) in [(false, column % 4 == 3), (true, row % 3 == 2)] {
            let is_last = if is_north { row + 1 == 30 } else { column + 1 == COLUMNS };
            if !is_last && (is_ridge || noise(cell) > 0.2) {
                sills.push(PassSill::whole(cell, is_north, if is_ridge { 3.0 } else { 0.9 }));
            }
        }
    }
    let elevation: Vec<f64> = (0..lattice.len()).map(|cell| noise(cell + 7)).collect();
    let level = |cell: usize| {
        let (column, row) = lattice.column_row(cell);
        let block = row / 3 * 10 + column / 4;
        // Some are dry, some but for their lowest cells.
        if block % 5 == 0 { -1.0 } else { 2.0 + 1.9 * noise(block + 3000) }
    };
    let depth = elevation.iter().enumerate().map(|(cell, z)| (level(cell) - z).max(0.0)).collect();
    let mut problem = problem(lattice, elevation, depth);
    problem.bed.passes = PassSills::new(sills);
    let mut solver = EulerianSolver::new(problem);
    let before = depths(&mut solver);
    run(&mut solver, 300);
    let speed = solver.choose_step().max_speed;
    assert!(speed < 1e-12, "{speed:e} m/s");
    let moved = before.iter().zip(depths(&mut solver)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(moved < 1e-12, "{moved:e} m");
}

/// Water of a level (m) to the west of a ridge of 2 m on noisy ground, mirrored or not.
fn overtopped(level: f64, is_mirrored: bool) -> FlowProblem {
    let lattice = lattice(6);
    let place = |cell: usize| {
        let (column, row) = lattice.column_row(cell);
        row * COLUMNS + if is_mirrored { COLUMNS - 1 - column } else { column }
    };
    // Numbers of few digits: their sums are the same in any order.
    let few_digits = |z: f64| (1024.0 * z).round() / 1024.0;
    let elevation: Vec<f64> = (0..lattice.len()).map(|cell| few_digits(0.2 * noise(place(cell)))).collect();
    let wet = |cell: usize| place(cell) % COLUMNS < 19;
    let depth = (0..lattice.len()).map(|cell| if wet(cell) { level - elevation[cell] } else { 0.0 }).collect();
    let mut sills = ridge(6, if is_mirrored { COLUMNS - 20 } else { 18 }, 2.0);
    for sill in &mut sills {
        sill.level += 0.1 * noise(sill.cell / COLUMNS);
        sill.crest = sill.level;
    }
    let mut problem = problem(lattice, elevation, depth);
    problem.bed.manning = vec![0.03; problem.bed.lattice.len()];
    problem.bed.passes = PassSills::new(sills);
    problem
}

#[test]
fn flow_over_a_ridge_has_the_mirror_image_of_its_mirror_image() {
    let (mut plain, mut mirrored) =
        (EulerianSolver::new(overtopped(3.0, false)), EulerianSolver::new(overtopped(3.0, true)));
    run(&mut plain, 400);
    run(&mut mirrored, 400);
    let (plain, mirrored) = (depths(&mut plain), depths(&mut mirrored));
    let image = |cell: usize| cell / COLUMNS * COLUMNS + COLUMNS - 1 - cell % COLUMNS;
    let worst = (0..plain.len()).map(|cell| (plain[cell] - mirrored[image(cell)]).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-10, "{worst:e} m");
}

#[test]
fn flow_over_a_ridge_keeps_its_volume() {
    let mut solver = EulerianSolver::new(overtopped(3.0, false));
    run(&mut solver, 400);
    assert!(solver.ledger().relative_error().abs() < 1e-12);
    assert!(depths(&mut solver)[25] > 0.05, "water passed the ridge");
}

#[test]
fn nothing_passes_a_ridge_that_stands_above_the_water() {
    let mut solver = EulerianSolver::new(overtopped(1.9375, false));
    run(&mut solver, 400);
    assert!(depths(&mut solver).iter().enumerate().all(|(cell, &depth)| cell % COLUMNS < 19 || depth == 0.0));
}

#[test]
fn a_ridge_passes_what_a_broad_crested_weir_does() {
    // A basin of 190 m over a ridge of 1 m, on smooth ground that falls away beyond it.
    let lattice = {
        let plain = lattice(1);
        Lattice::new(plain.origin, plain.columns, plain.rows, 10.0)
    };
    let elevation: Vec<f64> = (0..COLUMNS).map(|column| if column < 19 { 0.0 } else { -0.5 }).collect();
    let depth = (0..COLUMNS).map(|column| if column < 19 { 2.0 } else { 0.0 }).collect();
    let mut problem = problem(lattice, elevation, depth);
    problem.bed.passes = PassSills::new(ridge(1, 18, 1.0));
    let mut solver = EulerianSolver::new(problem);
    let beyond = |solver: &mut EulerianSolver| depths(solver)[19..].iter().sum::<f64>() * 10.0;
    let (mut weir, mut start) = (0.0, 0.0);
    while solver.time() < 80.0 {
        let step = solver.choose_step().time_step;
        let before = solver.water().at(17);
        if solver.time() < 20.0 {
            start = beyond(&mut solver);
        } else {
            // The head two cells before the crest, with that of the velocity.
            let velocity = before.discharge_x / before.depth;
            let head = before.depth + velocity * velocity / (2.0 * 9.81) - 1.0;
            weir += step * 9.81_f64.sqrt() * (2.0 / 3.0 * head).powf(1.5);
        }
        solver.advance(step).unwrap();
    }
    let passed = beyond(&mut solver) - start;
    assert!((passed / weir - 1.0).abs() < 0.1, "{passed} m², weir {weir} m²");
}

#[test]
fn a_sill_moves_with_the_lower_of_its_two_cells() {
    let problem = overtopped(3.0, false);
    let mut state = State::new(&problem.bed, &problem.initial_depth, problem.gravity);
    let walls = Walls::new(&problem, &state, EulerianMethods::default());
    let mut passes = Passes::new(&problem, &state, &walls);
    let [face] = passes.faces[1][..] else { unreachable!("one ridge") };
    // Padded cells 19 and 20 of row 1.
    for (rises, expected) in [([0.0, -0.5], -0.5), ([0.25, -0.5], -0.5), ([0.25, 1.0], 0.25), ([0.0, 4.0], 0.0)] {
        for (side, rise) in rises.into_iter().enumerate() {
            state.ground[1].bed[19 + side] = face.beds[side] + rise;
        }
        passes.follow(&state.ground);
        let level = passes.faces[1][0].level;
        assert!((level - face.level_at_start - expected).abs() < 1e-12, "{rises:?}: {level} m");
        let beside = |column: usize, way: usize| {
            passes.cells[1].iter().find(|cell| cell.column == column).map(|cell| cell.sills[way])
        };
        // East of the one, west of the other.
        assert_eq!([beside(19, 0), beside(20, 1)], [Some(level); 2]);
    }
}
