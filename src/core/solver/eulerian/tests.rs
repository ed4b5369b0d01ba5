//! The core on made beds: rest, conservation, symmetry, walls, open edges, and the same bits for any number of threads.

use super::EulerianSolver;
use crate::bed::BedParticles;
use crate::boundary::Pieces;
use crate::lattice::{Lattice, WaterInCell};
use crate::math::Vec2;
use crate::solver::testing::run_steps;
use crate::solver::{Boundary, Condition, FlowProblem, FlowSolver, Forcing, OpenEdges};

fn lattice(columns: usize, rows: usize, spacing: f64) -> Lattice {
    Lattice::new(Vec2::ZERO, columns, rows, spacing)
}

pub(super) fn problem(lattice: Lattice, elevation: Vec<f64>, initial_depth: Vec<f64>) -> FlowProblem {
    FlowProblem {
        bed: BedParticles::from_elevation(lattice, elevation, 0.0),
        walls: Vec::new(),
        open_edges: OpenEdges::default(),
        forcing: Forcing::default(),
        initial_depth,
        gravity: 9.81,
        courant: 0.5,
        dry_depth: 1e-6,
    }
}

/// Repeatable noise between −0.5 and 0.5.
pub(super) fn noise(index: usize) -> f64 {
    let mut bits = index as u64 ^ 0x9e37_79b9_7f4a_7c15;
    for _ in 0..3 {
        bits = (bits ^ (bits >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    }
    (bits >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

/// Depths and discharges to the bit, cell by cell.
pub(super) fn bits(solver: &mut EulerianSolver) -> Vec<[u64; 3]> {
    let water = solver.water();
    // The sign of 0 is free.
    water.cells().map(|cell| [cell.depth, cell.discharge_x + 0.0, cell.discharge_y + 0.0].map(f64::to_bits)).collect()
}

pub(super) fn run(solver: &mut EulerianSolver, steps: usize) {
    run_steps(solver, steps);
}

/// Elevation (m) of the bed at a cell.
type Bed = Box<dyn Fn(usize) -> f64>;

#[test]
fn a_lake_stays_at_rest_on_every_bed() {
    let grid = lattice(40, 40, 1.0);
    let beds: [(&str, Bed); 6] = [
        ("bump", Box::new(move |i| 1.2 * (-0.02 * place_of(i).norm_squared()).exp())),
        ("vertical step", Box::new(|i| if i % 40 < 20 { 0.0 } else { 1.5 })),
        ("rough", Box::new(|i| 1.5 * noise(i))),
        ("emerged island", Box::new(move |i| 3.5 * (-0.02 * place_of(i).norm_squared()).exp())),
        ("many emerged pockets", Box::new(|i| 2.0 + 3.0 * noise(i))),
        (
            "no terrain in the middle",
            Box::new(move |i| if place_of(i).norm() < 6.0 { f64::NAN } else { 0.3 * noise(i) }),
        ),
    ];
    for (name, bed) in beds {
        let elevation: Vec<f64> = (0..grid.len()).map(&bed).collect();
        let depth = elevation.iter().map(|z| (2.0 - z).max(0.0)).collect();
        let mut solver = EulerianSolver::new(problem(grid.clone(), elevation, depth));
        run(&mut solver, 300);
        let speed = solver.choose_step().max_speed;
        assert!(speed < 1e-12, "{name}: {speed:e} m/s");
    }
}

fn place_of(index: usize) -> Vec2 {
    lattice(40, 40, 1.0).centre(index) - Vec2::new(20.0, 20.0)
}

#[test]
fn a_wall_keeps_two_lakes_apart() {
    let grid = lattice(40, 20, 1.0);
    let elevation = vec![0.0; grid.len()];
    let depth = (0..grid.len()).map(|i| if grid.centre(i).x < 20.3 { 5.0 } else { 1.0 }).collect();
    let mut problem = problem(grid, elevation, depth);
    problem.walls = vec![[Vec2::new(20.3, -5.0), Vec2::new(20.3, 25.0)]];
    let mut solver = EulerianSolver::new(problem);
    run(&mut solver, 200);
    assert!(solver.choose_step().max_speed < 1e-12);
}

/// Water column in the corner of a rough closed basin: water everywhere, fronts, thin films.
fn rough_dam_break() -> FlowProblem {
    let grid = lattice(60, 50, 2.0);
    let elevation: Vec<f64> = (0..grid.len()).map(|i| 0.02 * grid.centre(i).x + 0.8 * noise(i)).collect();
    let depth = (0..grid.len()).map(|i| if grid.centre(i).norm() < 50.0 { 6.0 } else { 0.0 }).collect();
    let mut problem = problem(grid, elevation, depth);
    problem.bed.manning.fill(0.03);
    problem
}

#[test]
fn a_closed_basin_keeps_its_volume_and_no_depth_falls_below_zero() {
    let mut solver = EulerianSolver::new(rough_dam_break());
    run(&mut solver, 400);
    assert!(solver.ledger().relative_error().abs() < 1e-13, "{:e}", solver.ledger().relative_error());
    assert!(solver.water().depths().iter().all(|depth| *depth >= 0.0));
}

#[test]
fn what_leaves_through_an_open_edge_is_booked() {
    let mut problem = rough_dam_break();
    for z in &mut problem.bed.elevation {
        *z = -*z;
    }
    let (width, height) = (120.0, 100.0);
    problem.open_edges =
        OpenEdges { pieces: vec![[Vec2::new(width, 0.0), Vec2::new(width, height)]].into(), reach: 1.1, outline: None };
    let mut solver = EulerianSolver::new(problem);
    run(&mut solver, 600);
    let ledger = solver.ledger();
    assert!(ledger.outflow > 0.2 * ledger.initial, "{ledger:?}");
    assert!(ledger.relative_error().abs() < 1e-12, "{:e}", ledger.relative_error());
}

#[test]
fn no_boundary_opens_a_sealed_cell() {
    let grid = lattice(30, 30, 1.0);
    let centre = Vec2::new(15.0, 15.0);
    let hole: Vec<usize> = (0..grid.len()).filter(|&i| (grid.centre(i) - centre).norm() < 3.0).collect();
    let elevation: Vec<f64> = (0..grid.len()).map(|i| if hole.contains(&i) { f64::NAN } else { 0.0 }).collect();
    let depth: Vec<f64> = elevation.iter().map(|z| if z.is_nan() { 0.0 } else { 1.0 }).collect();
    let corners = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)].map(|(x, y)| centre + Vec2::new(x, y));
    let around: Pieces = (0..4).map(|k| [corners[k], corners[(k + 1) % 4]]).collect();
    let uniform_flow = Boundary { pieces: around.clone(), condition: Condition::NormalDepth { slope: 0.01 } };
    for (is_sealed, has_condition) in [(false, false), (false, true), (true, false), (true, true)] {
        let mut problem = problem(grid.clone(), elevation.clone(), depth.clone());
        if is_sealed {
            problem.bed.sealed = hole.clone();
        }
        if has_condition {
            problem.forcing = Forcing { boundaries: vec![uniform_flow.clone()], reach: 4.0, ..Forcing::default() };
        } else {
            problem.open_edges = OpenEdges { pieces: around.clone(), reach: 4.0, outline: None };
        }
        let mut solver = EulerianSolver::new(problem);
        run(&mut solver, 20);
        let lost = solver.ledger().outflow;
        assert!(if is_sealed { lost.abs() <= 0.0 } else { lost > 1.0 }, "{is_sealed} {has_condition}: {lost}");
    }
}

#[test]
fn a_symmetric_dam_break_stays_symmetric() {
    let grid = lattice(61, 61, 0.2);
    let centre = Vec2::new(6.1, 6.1);
    let depth = (0..grid.len()).map(|i| if (grid.centre(i) - centre).norm() < 2.5 { 2.5 } else { 0.0 }).collect();
    let mut solver = EulerianSolver::new(problem(grid.clone(), vec![0.0; grid.len()], depth));
    run(&mut solver, 150);
    let depth = solver.water().depths();
    let at = |column: usize, row: usize| depth[grid.index(column, row)];
    let mut worst: f64 = 0.0;
    for row in 0..61 {
        for column in 0..61 {
            let here = at(column, row);
            for mirrored in [at(60 - column, row), at(column, 60 - row), at(row, column)] {
                worst = worst.max((here - mirrored).abs());
            }
        }
    }
    assert!(worst < 1e-12, "{worst:e}");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let state_after = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool of threads");
        pool.install(|| {
            let mut solver = EulerianSolver::new(rough_dam_break());
            run(&mut solver, 200);
            let bits = |cell: WaterInCell| [cell.depth, cell.discharge_x, cell.discharge_y].map(f64::to_bits);
            solver.water().cells().map(bits).collect::<Vec<_>>()
        })
    };
    let one = state_after(1);
    assert_eq!(one, state_after(2));
    assert_eq!(one, state_after(5));
}

#[test]
fn raising_the_datum_by_3000_m_changes_the_depths_by_rounding_only() {
    let depths = |datum: f64| {
        let mut problem = rough_dam_break();
        for z in &mut problem.bed.elevation {
            *z += datum;
        }
        let mut solver = EulerianSolver::new(problem);
        run(&mut solver, 100);
        solver.water().depths()
    };
    let worst = depths(0.0).iter().zip(depths(3000.0)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-6, "{worst:e} m");
}

#[test]
fn water_that_leaves_cells_dry_is_not_seen_there_however_seldom_one_looks() {
    let grid = lattice(400, 1, 1.0);
    let mut solver = EulerianSolver::new(problem(grid, vec![0.0; 400], vec![1.0; 400]));
    solver.set_velocity(|place| Vec2::new(if place.x < 200.0 { -8.0 } else { 8.0 }, 0.0));
    assert!(solver.water().depths()[200] > 0.5);
    run(&mut solver, 150);
    assert!(solver.water().depths()[195..205].iter().all(|depth| *depth < 0.01));
}

/// What one period leaves of a seiche of 0.1 m on 2 m of water, as a share: a basin of 200 m by 40 m between walls that is turned by an angle
/// (degrees) on cells of 2 m.
fn seiche_left(degrees: f64) -> f64 {
    const LENGTH: f64 = 200.0;
    const WIDTH: f64 = 40.0;
    let (sin, cos) = degrees.to_radians().sin_cos();
    let grid = lattice(110, 110, 2.0);
    let own = |cell: usize| {
        let place = grid.centre(cell) - Vec2::new(110.0, 110.0);
        Vec2::new(cos * place.x + sin * place.y, cos * place.y - sin * place.x)
    };
    let mode = |cell: usize| (std::f64::consts::PI * (own(cell).x / LENGTH + 0.5)).cos();
    let is_inside = |cell: usize| own(cell).x.abs() < 0.5 * LENGTH && own(cell).y.abs() < 0.5 * WIDTH;
    let inside: Vec<usize> = (0..grid.len()).filter(|&cell| is_inside(cell)).collect();
    let bed = (0..grid.len()).map(|cell| if is_inside(cell) { 0.0 } else { f64::NAN });
    let water = (0..grid.len()).map(|cell| if is_inside(cell) { 2.0 + 0.1 * mode(cell) } else { 0.0 });
    let mut solver = EulerianSolver::new(problem(grid.clone(), bed.collect(), water.collect()));
    let period = 2.0 * LENGTH / (2.0 * 9.81_f64).sqrt();
    let (mut time, mut greatest) = (0.0, 0.0_f64);
    while time < 1.15 * period {
        let step = solver.choose_step().time_step;
        solver.advance(step).expect("a stable run");
        time += step;
        if time > 0.85 * period {
            let water = solver.water();
            let height = |&cell: &usize| (water.at(cell).depth - 2.0) * mode(cell);
            let squares: f64 = inside.iter().map(|&cell| mode(cell) * mode(cell)).sum();
            greatest = greatest.max(inside.iter().map(height).sum::<f64>() / squares / 0.1);
        }
    }
    greatest
}

#[test]
fn a_seiche_goes_on_between_walls_askew_to_the_lattice() {
    for (degrees, documented) in [(0.0, 0.99), (10.0, 0.96), (30.0, 0.975), (45.0, 0.985)] {
        let left = seiche_left(degrees);
        println!("{degrees} degrees: {left:.3}");
        assert!(left > documented && left < 1.01, "{degrees} degrees: {left}");
    }
}
