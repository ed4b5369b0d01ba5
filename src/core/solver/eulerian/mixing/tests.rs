//! Mixing by turbulence: shear layers on squares, across levels and over polygons.

use super::{EAST, NORTH};
use crate::bed::BedParticles;
use crate::constants::EulerianConstants;
use crate::lattice::{Lattice, Nest};
use crate::math::Vec2;
use crate::methods::Turbulence;
use crate::partition::{Line, LineKind, Partition};
use crate::physics::turbulence::{eddy_viscosity, square_of_length};
use crate::solver::eulerian::{EulerianMethods, EulerianSolver, tests};
use crate::solver::{FlowProblem, FlowSolver, nested};

fn problem(grid: &Lattice, initial_depth: Vec<f64>) -> FlowProblem {
    tests::problem(grid.clone(), vec![0.0; grid.len()], initial_depth)
}

fn solver(grid: &Lattice, initial_depth: Vec<f64>, turbulence: Turbulence) -> EulerianSolver {
    mixed(problem(grid, initial_depth), turbulence)
}

fn mixed(problem: FlowProblem, turbulence: Turbulence) -> EulerianSolver {
    EulerianSolver::with_methods(problem, EulerianMethods { turbulence, ..EulerianMethods::default() })
}

fn run(solver: &mut EulerianSolver, end: f64) {
    while solver.time() < end {
        let step = solver.choose_step().time_step.min(end - solver.time());
        solver.advance(step).expect("a stable run");
    }
}

#[test]
fn faces_have_a_stress_where_both_sides_have_terrain_and_water() {
    let grid = Lattice::new(Vec2::ZERO, 19, 12, 0.5);
    // Rows of faces with holes of both kinds, longer than any lanes, and a rest of fewer.
    let elevation = (0..grid.len()).map(|index| if index % 7 == 3 { f64::NAN } else { 0.0 }).collect();
    let depth = (0..grid.len()).map(|index| if index % 5 == 2 { 0.0 } else { 1.0 }).collect();
    let mut solver = mixed(tests::problem(grid.clone(), elevation, depth), Turbulence::MixingLength);
    solver.set_velocity(|place| Vec2::new(place.x * place.y, place.x + 2.0 * place.y));
    super::add(&mut solver.state, &solver.active, &solver.scale, &EulerianConstants::DEFAULT, 0.01);
    let has_water = |row: usize, column: usize| {
        solver.state.has_terrain(row, column) && solver.state.primitive[row].depth[column] > 0.0
    };
    for (row, column) in (1..=grid.rows).flat_map(|row| (1..=grid.columns).map(move |column| (row, column))) {
        let beyond = [(EAST, row, column + 1), (NORTH, row + 1, column)];
        for (direction, to_row, to_column) in beyond {
            let face = &solver.state.flux[row][direction];
            let stress = [face.normal_left[column], face.normal_right[column], face.tangential[column]];
            let is_wet = has_water(row, column) && has_water(to_row, to_column);
            assert!(stress.iter().all(|part| if is_wet { *part < 0.0 } else { part.abs() <= 0.0 }), "{stress:?}");
        }
    }
}

/// Speed (m/s), width (m) and middle (m) of a shear layer, its time (s) and the width of the channel (m).
const SPEED: f64 = 0.5;
const WIDTH: f64 = 1.0;
const MIDDLE: f64 = 6.0;
const END: f64 = 4.0;
const CHANNEL: f64 = 12.0;

fn layer(y: f64) -> f64 {
    SPEED * ((y - MIDDLE) / WIDTH).tanh()
}

/// The layer at the end by ∂u/∂t = ∂(ν ∂u/∂y)/∂y alone, on cells of 5 cm, as a function of the place.
fn widened() -> impl Fn(f64) -> f64 {
    let (dy, dt) = (0.05, 0.002);
    let mut u: Vec<f64> = (0..(CHANNEL / dy) as usize).map(|k| layer((k as f64 + 0.5) * dy)).collect();
    for _ in 0..(END / dt).round() as usize {
        let stress: Vec<f64> = u
            .windows(2)
            .map(|pair| (pair[1] - pair[0]) / dy)
            .map(|shear| eddy_viscosity(1.0, 0.0, shear.abs(), square_of_length(0.09, 6.0)) * shear)
            .collect();
        for (k, here) in u.iter_mut().enumerate() {
            let north = stress.get(k).copied().unwrap_or(0.0);
            let south = k.checked_sub(1).map_or(0.0, |k| stress[k]);
            *here += dt / dy * (north - south);
        }
    }
    move |y: f64| {
        let k = (y / dy - 0.5).floor();
        let share = y / dy - 0.5 - k;
        u[k as usize] * (1.0 - share) + u[k as usize + 1] * share
    }
}

#[test]
fn a_shear_layer_widens_as_its_diffusion_in_one_dimension_and_keeps_its_momentum() {
    // So long that nothing from its ends comes to the middle.
    let grid = Lattice::new(Vec2::ZERO, 240, 48, CHANNEL / 48.0);
    let exact = widened();
    let (mut errors, mut sums) = (Vec::new(), Vec::new());
    for turbulence in Turbulence::ALL {
        let mut solver = solver(&grid, vec![1.0; grid.len()], *turbulence);
        solver.set_velocity(|place| Vec2::new(layer(place.y), 0.0));
        run(&mut solver, END);
        let column: Vec<(f64, f64)> = (0..grid.rows)
            .map(|row| (grid.centre(row * grid.columns + 120).y, row + 1))
            .map(|(y, row)| (y, solver.state.water[row].discharge_x[121] / solver.state.water[row].depth[121]))
            .collect();
        let off = column.iter().map(|(y, u)| (u - exact(*y)).abs()).sum::<f64>() / column.len() as f64;
        errors.push(off / SPEED);
        sums.push(column.iter().map(|(_, u)| u).sum::<f64>());
    }
    assert!(errors[0] > 0.02, "without mixing the layer stays as it was: {errors:?}");
    assert!(errors[1] < 0.002, "{errors:?}");
    assert!(sums.iter().all(|sum| sum.abs() < 1e-12), "{sums:?}");
}

#[test]
fn both_directions_of_the_lattice_are_alike() {
    let grid = Lattice::new(Vec2::ZERO, 40, 40, 0.5);
    // A column of water off the middle, symmetric about the diagonal.
    let is_high = |index: usize| (grid.centre(index) - Vec2::new(7.0, 7.0)).norm() < 3.0;
    let depth = (0..grid.len()).map(|index| if is_high(index) { 2.0 } else { 0.5 }).collect();
    let mut solver = solver(&grid, depth, Turbulence::MixingLength);
    run(&mut solver, 4.0);
    let depth = |row: usize, column: usize| solver.state.water[row].depth[column];
    let mut worst = 0.0_f64;
    for row in 1..=40 {
        for column in 1..=40 {
            worst = worst.max((depth(row, column) - depth(column, row)).abs());
        }
    }
    assert!(worst < 1e-12, "{worst:e}");
    assert!(solver.ledger().relative_error().abs() < 1e-13);
}

#[test]
fn a_scene_as_large_as_you_like_is_the_same_by_the_law_of_froude() {
    // 64 times as large: times by 8, n by 2, all of them powers of two, so that nothing is rounded otherwise.
    let flow = |scale: f64, time: f64, roughness: f64| {
        let grid = Lattice::new(Vec2::ZERO, 40, 24, 0.05 * scale);
        let place = |index: usize| grid.centre(index) * (1.0 / scale);
        let elevation: Vec<f64> = (0..grid.len())
            .map(|index| if (place(index) - Vec2::new(1.3, 0.5)).norm() < 0.2 { f64::NAN } else { 0.0 })
            .collect();
        let depth = (0..grid.len()).map(|index| scale * if place(index).x < 0.7 { 0.4 } else { 0.02 }).collect();
        let bed = BedParticles::from_elevation(grid.clone(), elevation, 0.01 * roughness);
        let dry_depth = 1e-3 * scale;
        let mut solver = mixed(FlowProblem { bed, dry_depth, ..problem(&grid, depth) }, Turbulence::MixingLength);
        run(&mut solver, 2.0 * time);
        (0..24).flat_map(|row| solver.state.water[row + 1].depth[1..=40].to_vec()).collect::<Vec<f64>>()
    };
    let (small, large) = (flow(1.0, 1.0, 1.0), flow(64.0, 8.0, 2.0));
    let apart = small.iter().zip(&large).map(|(d, scaled)| (scaled / 64.0 - d).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-9, "{apart:e} m of 0.4 m");
    assert!(small.iter().any(|d| *d > 0.1) && small.iter().any(|d| *d < 0.05), "the water moves");
}

/// Water 1 m deep within walls, 40 m square, on cells of 25 cm: three levels about the middle, or with cells that follow a line askew through it.
fn with_general_faces(has_levels: bool) -> FlowProblem {
    let (count, spacing) = (160, 0.25);
    let lattice = Lattice::new(Vec2::ZERO, count, count, spacing);
    if has_levels {
        let is_fine = |block: usize| (9..11).contains(&block);
        let wanted = |column: usize, row: usize| if is_fine(column) && is_fine(row) { 0 } else { 2 };
        let nest = Nest::graded((count, count), spacing, 8, 2, wanted);
        let own = |level: &crate::lattice::Level| Lattice::new(Vec2::ZERO, level.columns, level.rows, level.spacing);
        let levels = nest.levels().iter().map(|level| problem(&own(level), vec![1.0; own(level).len()])).collect();
        return nested(levels, nest);
    }
    let points = [Vec2::new(2.0, 10.0), Vec2::new(38.0, 29.0)].to_vec();
    let made = Partition::new(&lattice, |_| true, &[Line { points, is_closed: false, kind: LineKind::Follow }]);
    let nest = Nest::of_one_level((count, count), spacing).with(made.on(&lattice));
    let lattice = lattice.nested(nest);
    let of_cells = |value: f64, none: f64| -> Vec<f64> {
        (0..lattice.len()).map(|cell| if lattice.is_leaf(cell) { value } else { none }).collect()
    };
    let depth = of_cells(1.0, 0.0);
    tests::problem(lattice.clone(), of_cells(0.0, f64::NAN), depth)
}

/// The cells of a run with their centres and velocities.
fn velocities(solver: &mut EulerianSolver) -> Vec<(Vec2, Vec2)> {
    let water = solver.water();
    let lattice = &water.lattice;
    let own = (0..lattice.len()).filter(|&cell| lattice.is_leaf(cell));
    let of_cell = |cell: usize| {
        let here = water.at(cell);
        (lattice.centre(cell), Vec2::new(here.discharge_x, here.discharge_y) * (1.0 / here.depth))
    };
    own.map(of_cell).collect()
}

#[test]
fn an_even_shear_moves_no_water_across_levels_and_over_polygons() {
    for has_levels in [true, false] {
        let after = [Turbulence::None, Turbulence::MixingLength].map(|turbulence| {
            let mut solver = mixed(with_general_faces(has_levels), turbulence);
            solver.set_velocity(|place| Vec2::new(0.03 * place.x + 0.08 * place.y, 0.05 * place.x - 0.02 * place.y));
            solver.advance(1e-5).expect("a stable step");
            velocities(&mut solver)
        });
        let mut seen = 0;
        for ((place, without), (_, with)) in after[0].iter().zip(&after[1]) {
            let from_middle = *place - Vec2::new(20.0, 20.0);
            if from_middle.x.abs() < 12.0 && from_middle.y.abs() < 12.0 {
                // One face alone would give ν |S|/Δ = 0.02 m/s² or more.
                let rate = (*with - *without).norm() / 1e-5;
                assert!(rate < 1e-7, "{rate:e} m/s² at {place:?}, levels: {has_levels}");
                seen += 1;
            }
        }
        assert!(seen > 500, "{seen}");
    }
}

#[test]
fn a_shear_layer_widens_across_levels_and_over_polygons() {
    let exact = widened();
    for has_levels in [true, false] {
        let way = if has_levels { Vec2::new(1.0, 0.0) } else { Vec2::new(36.0, 19.0) * (1.0 / 36.0_f64.hypot(19.0)) };
        let across = |place: Vec2| (place - Vec2::new(20.0, 19.5)).dot(way.perpendicular());
        let errors = [Turbulence::None, Turbulence::MixingLength].map(|turbulence| {
            let mut solver = mixed(with_general_faces(has_levels), turbulence);
            solver.set_velocity(|place| way * layer(MIDDLE + across(place)));
            run(&mut solver, END);
            let all = velocities(&mut solver);
            let near = all.iter().filter(|(place, _)| (*place - Vec2::new(20.0, 20.0)).norm() < 6.0);
            let off = near.filter(|(place, _)| across(*place).abs() < 4.0);
            let errors: Vec<f64> = off.map(|(place, v)| (v.dot(way) - exact(MIDDLE + across(*place))).abs()).collect();
            errors.iter().sum::<f64>() / errors.len() as f64 / SPEED
        });
        println!("levels {has_levels}: {errors:?}");
        // Cells of the coarsest level are as wide as the layer; askew on squares alone it is 0.012.
        assert!(errors[0] > 0.02 && errors[1] < 0.012, "levels {has_levels}: {errors:?}");
    }
}

#[test]
fn the_stress_on_general_faces_keeps_momentum() {
    for has_levels in [true, false] {
        let momentum = [Turbulence::None, Turbulence::MixingLength].map(|turbulence| {
            let mut solver = mixed(with_general_faces(has_levels), turbulence);
            solver.set_velocity(|place| {
                let noise = |k: f64| (k * (place.x * 12.9898 + place.y * 78.233)).sin();
                // Nothing comes to the walls.
                let is_inside = (place - Vec2::new(20.0, 20.0)).norm() < 12.0;
                Vec2::new(noise(1.0), noise(1.7)) * if is_inside { 0.3 } else { 0.0 }
            });
            solver.advance(1e-5).expect("a stable step");
            let water = solver.water();
            let lattice = &water.lattice;
            let sum = |of: &dyn Fn(usize) -> f64| -> f64 {
                (0..lattice.len()).filter(|&cell| lattice.is_leaf(cell)).map(|c| of(c) * lattice.area_of(c)).sum()
            };
            [sum(&|cell| water.at(cell).discharge_x), sum(&|cell| water.at(cell).discharge_y)]
        });
        for (without, with) in momentum[0].iter().zip(&momentum[1]) {
            // Of forces of some 0.02 m³/s² on each of 10⁴ metres of faces.
            let force = (with - without) / 1e-5;
            assert!(force.abs() < 1e-6, "{force:e} m⁴/s², levels: {has_levels}");
        }
    }
}
