//! Flow in basins that end inside of cells: rest, volume, one dimension, the period of a swing, mirror images, what leaves.

use super::super::EulerianSolver;
use super::super::tests::{noise, problem, run};
use super::*;
use crate::bed::{BedParticles, Cover, Nothing, place_bed};
use crate::boundary::Pieces;
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::methods::BedMethod;
use crate::solver::{FlowSolver, OpenEdges};
use crate::terrain::{Layer, Raster, Terrain};

/// A south-western corner (m), and width and height (m).
type Rectangle = ((f64, f64), (f64, f64));

/// A basin from (west, south) on, of a width and a height (m), on cells of 1 m; its level (m), and the level of the water over its bed.
fn basin(
    (west, south): (f64, f64),
    (width, height): (f64, f64),
    bed: impl Fn(Vec2) -> f64,
    level: impl Fn(Vec2) -> f64,
) -> FlowProblem {
    on_rasters(&[((west, south), (width, height))], 1.0, bed, level)
}

/// The same on several rectangles, with cells of a spacing (m).
fn on_rasters(
    rectangles: &[Rectangle],
    spacing: f64,
    bed: impl Fn(Vec2) -> f64,
    level: impl Fn(Vec2) -> f64,
) -> FlowProblem {
    let layers = rectangles.iter().map(|&(corner, size)| Layer::Raster(raster(corner, size, &bed))).collect();
    let terrain = Terrain::new(layers).unwrap();
    let ends = terrain.extent().high / spacing;
    let (columns, rows) = (ends.x.ceil() as usize, ends.y.ceil() as usize);
    let lattice = Lattice::new(Vec2::ZERO, columns, rows, spacing);
    let made = place_bed(&terrain, &lattice, BedMethod::Pointwise, &Nothing, 0.0);
    let depth = (0..lattice.len()).map(|cell| (level(lattice.centre(cell)) - made.elevation[cell]).max(0.0));
    let mut problem = problem(lattice.clone(), made.elevation.clone(), depth.collect());
    let cover = Cover::find(&terrain, &terrain, &made);
    problem.bed = BedParticles { cover, ..problem.bed };
    problem
}

/// A raster of cells of 0.1 m.
fn raster((west, south): (f64, f64), (width, height): (f64, f64), bed: &impl Fn(Vec2) -> f64) -> Raster {
    let cell = 0.1;
    let (columns, rows) = ((width / cell).round() as usize, (height / cell).round() as usize);
    let mut raster = Raster {
        columns,
        rows,
        west,
        north: south + height,
        cell_x: cell,
        cell_y: cell,
        values: vec![0.0; columns * rows],
    };
    for i in 0..columns * rows {
        raster.values[i] = bed(raster.centre(i % columns, i / columns));
    }
    raster
}

/// Places of a basin that end at halves, less than halves and more.
const ENDS: [Rectangle; 4] =
    [((0.0, 0.0), (30.5, 17.5)), ((0.8, 0.7), (29.5, 15.4)), ((0.3, 0.4), (30.0, 16.0)), ((0.0, 0.0), (30.3, 17.8))];

#[test]
fn a_lake_in_cells_in_part_stays_at_rest() {
    for (corner, size) in ENDS {
        let rough = |place: Vec2| 1.5 * noise((place.x * 1000.0 + place.y * 77.0) as usize);
        let mut solver = EulerianSolver::new(basin(corner, size, rough, |_| 0.4));
        assert!(!solver.in_part.cells.is_empty());
        run(&mut solver, 300);
        let speed = solver.choose_step().max_speed;
        assert!(speed < 1e-12, "{corner:?} {size:?}: {speed:e} m/s");
    }
}

#[test]
fn volume_is_that_of_the_basin_and_is_kept() {
    for (corner, size) in ENDS {
        let is_high = |place: Vec2| place.x < 12.0 && place.y < 9.0;
        let level = |place: Vec2| if is_high(place) { 4.0 } else { 1.0 };
        let mut solver = EulerianSolver::new(basin(corner, size, |_| 0.0, level));
        let high = (12.0 - corner.0) * (9.0 - corner.1);
        let volume = size.0 * size.1 + 3.0 * high;
        let error = solver.ledger().stored / volume - 1.0;
        assert!(error.abs() < 1e-12, "{corner:?} {size:?}: {error:e}");
        run(&mut solver, 400);
        let error = solver.ledger().stored / volume - 1.0;
        assert!(error.abs() < 1e-12, "{corner:?} {size:?} after 400 steps: {error:e}");
        let fastest = solver.fastest().signal_speed;
        assert!(fastest < 12.0, "{fastest} m/s: a bore runs at 8 m/s");
    }
}

#[test]
fn flow_of_one_dimension_stays_so() {
    for (corner, size) in ENDS {
        let level = |place: Vec2| if place.x < 12.0 { 2.0 } else { 0.5 };
        let mut solver = EulerianSolver::new(basin(corner, size, |_| 0.0, level));
        run(&mut solver, 200);
        let rows: Vec<usize> = (1..=solver.state.rows).filter(|&row| solver.state.has_terrain(row, 10)).collect();
        for column in 1..=solver.state.lattice().columns {
            let depths: Vec<f64> = rows.iter().map(|&row| solver.state.water[row].depth[column]).collect();
            let spread = depths.iter().map(|depth| (depth - depths[0]).abs()).fold(0.0, f64::max);
            assert!(spread < 1e-12, "{corner:?} {size:?}: {spread:e} m in column {column}");
        }
    }
}

#[test]
fn a_swing_has_the_period_of_its_basin() {
    // The ends lie in cells that are given away, kept in part, or both.
    for (west, length) in [(0.7, 19.4), (0.3, 19.3), (0.4, 19.8)] {
        let level = |place: Vec2| 1.0 - 1e-3 * (std::f64::consts::PI * (place.x - west) / length).cos();
        let mut solver = EulerianSolver::new(basin((west, 0.0), (length, 3.0), |_| 0.0, level));
        // The water near the western end passes the level of rest twice in a period.
        let (mut crossings, mut before) = (Vec::new(), -1.0);
        while crossings.len() < 9 {
            let choice = solver.choose_step();
            let time = solver.time();
            solver.advance(choice.time_step).unwrap();
            let now = solver.state.water[2].depth[3] - 1.0;
            if (now > 0.0) != (before > 0.0) {
                crossings.push(time + choice.time_step * before / (before - now));
            }
            before = now;
        }
        let period = (crossings[8] - crossings[0]) / 4.0;
        let exact = 2.0 * length / 9.81_f64.sqrt();
        assert!((period / exact - 1.0).abs() < 4e-3, "{west} {length}: {period} s of {exact} s");
    }
}

#[test]
fn mirrored_basins_have_mirrored_water() {
    let size = (20.6, 11.4);
    let level = |place: Vec2| if (place - Vec2::new(6.0, 4.0)).norm() < 3.0 { 3.0 } else { 1.0 };
    let run_from = |west: f64, mirrored: bool| {
        let level = |place: Vec2| level(if mirrored { Vec2::new(21.0 - place.x, place.y) } else { place });
        let mut solver = EulerianSolver::new(basin((west, 0.3), size, |_| 0.0, level));
        run(&mut solver, 150);
        solver
    };
    // From 0.4 to 21 m, and from 0 to 20.6 m.
    let (own, other) = (run_from(0.4, false), run_from(0.0, true));
    for row in 1..=own.state.rows {
        for column in 1..=21 {
            let error = own.state.water[row].depth[column] - other.state.water[row].depth[22 - column];
            assert!(error.abs() < 1e-12, "{row} {column}: {error:e}");
        }
    }
}

#[test]
fn what_leaves_over_an_open_edge_is_as_wide_as_the_terrain() {
    // Uniform flow down a slope to an open edge in the east: by the width of the basin, whatever cells it has.
    let discharge = |south: f64, height: f64| {
        let slope = 0.01;
        let bed = move |place: Vec2| -slope * place.x;
        let mut problem = basin((0.0, south), (30.0, height), bed, move |place| 0.5 - slope * place.x);
        let edge = Pieces::from(vec![[Vec2::new(30.0, -1.0), Vec2::new(30.0, 20.0)]]);
        problem.open_edges = OpenEdges { pieces: edge, ..problem.open_edges };
        problem.bed.manning.fill(0.03);
        let mut solver = EulerianSolver::new(problem);
        let (state, slope) = (&mut solver, slope);
        state.set_velocity(|_| Vec2::new(0.5_f64.powf(2.0 / 3.0) * f64::sqrt(slope) / 0.03, 0.0));
        run(state, 20);
        let row = state.walls.leaving(&state.state, &state.active);
        row / height
    };
    let whole = discharge(0.0, 8.0);
    assert!(whole > 0.9, "{whole} m2/s");
    for (south, height) in [(0.0, 8.5), (0.6, 7.0), (0.3, 7.4)] {
        let part = discharge(south, height);
        assert!((part / whole - 1.0).abs() < 1e-9, "{south} {height}: {part} of {whole} m2/s");
    }
}

#[test]
fn a_dam_break_round_a_step_of_the_outline_is_that_on_half_cells() {
    // An L whose inner corner lies in the middle of a cell of 1 m, and on a corner of those of 0.5 m. Its mirror image about the diagonal.
    let shape = [((0.0, 0.0), (30.5, 12.5)), ((0.0, 0.0), (14.5, 28.5))];
    let turned = [((0.0, 0.0), (12.5, 30.5)), ((0.0, 0.0), (28.5, 14.5))];
    let level = |place: Vec2| if place.x > 20.5 { 2.0 } else { 1.0 };
    let level_turned = |place: Vec2| level(Vec2::new(place.y, place.x));
    let until = |mut solver: EulerianSolver, end: f64| {
        while solver.time() < end {
            let step = solver.choose_step().time_step.min(end - solver.time());
            solver.advance(step).unwrap();
        }
        solver
    };
    let coarse = until(EulerianSolver::new(on_rasters(&shape, 1.0, |_| 0.0, level)), 4.0);
    let other = until(EulerianSolver::new(on_rasters(&turned, 1.0, |_| 0.0, level_turned)), 4.0);
    let fine = until(EulerianSolver::new(on_rasters(&shape, 0.5, |_| 0.0, level)), 4.0);
    assert!(fine.in_part.cells.is_empty() && coarse.in_part.faces.iter().flatten().any(|face| face.walls[0] > 0.4));
    let depth = |solver: &EulerianSolver, row: usize, column: usize| solver.state.water[row].depth[column];
    let (mut error, mut area, mut at_corner) = (0.0, 0.0, 0.0_f64);
    for (row, column) in (1..=28).flat_map(|row| (1..=30).map(move |column| (row, column))) {
        if !coarse.state.has_terrain(row, column) {
            continue;
        }
        let own = depth(&coarse, row, column);
        assert!((own - depth(&other, column, row)).abs() < 1e-12, "row {row}, column {column}: the mirror image");
        // The four cells of 0.5 m, as far as there are any.
        let quarters = [
            (2 * row - 1, 2 * column - 1),
            (2 * row - 1, 2 * column),
            (2 * row, 2 * column - 1),
            (2 * row, 2 * column),
        ];
        let there: Vec<f64> = quarters
            .into_iter()
            .filter(|&(row, column)| row <= fine.state.rows && fine.state.has_terrain(row, column))
            .map(|(row, column)| depth(&fine, row, column))
            .collect();
        let apart = (own - there.iter().sum::<f64>() / there.len() as f64).abs();
        (error, area) = (error + apart, area + 1.0);
        if (row as f64 - 13.0).hypot(column as f64 - 15.0) < 3.0 {
            at_corner = at_corner.max(apart);
        }
    }
    println!("{} m on average, {at_corner} m at the corner", error / area);
    assert!(error / area < 0.02 && at_corner < 0.1, "{} m on average, {at_corner} m at the corner", error / area);
}

#[test]
fn a_narrow_gap_between_two_rasters_is_no_wall() {
    // It lies across a line of the lattice, beside one, and inside of a cell.
    let depth_beyond = |end: f64, begin: f64| {
        let shape = [((0.0, 0.0), (end, 6.0)), ((begin, 0.0), (30.0 - begin, 6.0))];
        let level = |place: Vec2| if place.x < 12.0 { 2.0 } else { 1.0 };
        let mut solver = EulerianSolver::new(on_rasters(&shape, 1.0, |_| 0.0, level));
        run(&mut solver, 60);
        solver.state.water[3].depth[19]
    };
    let whole = depth_beyond(15.0, 15.0);
    assert!(whole > 1.2, "{whole} m");
    for (end, begin) in [(14.9, 15.1), (14.8, 15.0), (14.6, 14.9), (15.0, 15.000_01)] {
        let own = depth_beyond(end, begin);
        assert!((own - whole).abs() < 0.1, "from {end} to {begin} m: {own} of {whole} m");
    }
}
