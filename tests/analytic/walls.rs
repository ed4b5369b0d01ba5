//! Particles of the variational formulation: walls, open edges, the volume balance, and the same bits for any number of threads.

use floodsim::error::FailurePlace;
use floodsim::lattice::WaterInCell;
use floodsim::math::Vec2;
use floodsim::physics::dimension::Dimension;
use floodsim::scenario::methods::{Integrator, Stabilisation, WallMethod};
use floodsim::solver::variational::{MovingMethods, VariationalSolver};
use floodsim::solver::{FlowProblem, FlowSolver, OpenEdges};

use crate::support::{max_speed, run_steps};
use floodsim::validation::{jittered_lattice, problem, seeds_at};

const CELLS: usize = 30;
const SPACING: f64 = 1.0;
const SIZE: f64 = CELLS as f64 * SPACING;

/// A basin with a round piece without terrain at one corner and a rough bed.
fn basin() -> FlowProblem {
    let mut problem = problem(CELLS, CELLS, SPACING, |p| 90.0 + 1.5 * (0.7 * p.x).sin() * (0.5 * p.y).cos());
    for index in 0..problem.bed.lattice.len() {
        if problem.bed.lattice.centre(index).norm() < 9.0 {
            problem.bed.elevation[index] = f64::NAN;
        }
    }
    problem
}

fn solver(problem: FlowProblem, jitter: f64, level: impl Fn(Vec2) -> f64) -> VariationalSolver {
    let seeds = seeds_at(&problem, &jittered_lattice(SIZE, SIZE, SPACING, jitter), SPACING * SPACING, level);
    VariationalSolver::new(problem, seeds, Integrator::Leapfrog, Stabilisation::TwoShocks)
}

fn solver_with_virtual_particles(problem: FlowProblem, jitter: f64, level: impl Fn(Vec2) -> f64) -> VariationalSolver {
    let seeds = seeds_at(&problem, &jittered_lattice(SIZE, SIZE, SPACING, jitter), SPACING * SPACING, level);
    let methods = MovingMethods {
        wall: WallMethod::VirtualParticles,
        ..MovingMethods::new(Integrator::Leapfrog, Stabilisation::TwoShocks)
    };
    VariationalSolver::with_methods(problem, seeds, methods, Dimension::Two)
}

/// A bent dam from side to side.
fn dam() -> Vec<[Vec2; 2]> {
    let points = [Vec2::new(18.3, 0.0), Vec2::new(17.1, 11.2), Vec2::new(20.4, 21.0), Vec2::new(16.5, SIZE)];
    points.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

fn is_behind_dam(place: Vec2) -> bool {
    dam().iter().any(|[a, b]| place.y >= a.y && place.y <= b.y && (*b - *a).cross(place - *a) > 0.0)
}

#[test]
fn nothing_leaves_a_closed_basin_in_motion() {
    let problem = FlowProblem { walls: dam(), ..basin() };
    let mut solver =
        solver(problem, 0.0, |p| if is_behind_dam(p) { if p.y < 12.0 { 100.0 } else { 94.0 } } else { 85.0 });
    let at_start = solver.particles();
    run_steps(&mut solver, 400);
    assert!(solver.particles() <= at_start);
    let particles = &solver.state().particles;
    for &place in &particles.position {
        assert!(is_behind_dam(place) && place.norm() > 8.0, "{place:?}");
    }
    assert!(max_speed(&solver) > 0.5, "the water did move");
    let ledger = solver.ledger();
    assert!(ledger.relative_error().abs() < 1e-12 && ledger.outflow == 0.0);
}

#[test]
fn walls_of_virtual_particles_let_nothing_through() {
    let problem = FlowProblem { walls: dam(), ..basin() };
    let level = |p: Vec2| if is_behind_dam(p) { if p.y < 12.0 { 100.0 } else { 94.0 } } else { 85.0 };
    let mut solver = solver_with_virtual_particles(problem, 0.0, level);
    let at_start = solver.particles();
    run_steps(&mut solver, 400);
    assert!(solver.particles() <= at_start);
    assert!(solver.state().particles.position.iter().all(|&place| is_behind_dam(place) && place.norm() > 8.0));
    assert!(max_speed(&solver) > 0.5 && solver.ledger().relative_error().abs() < 1e-12);
}

#[test]
fn water_leaves_through_open_edges_and_is_booked() {
    let open_edges =
        OpenEdges { pieces: vec![[Vec2::new(SIZE, 0.0), Vec2::new(SIZE, SIZE)]].into(), reach: 0.1, outline: None };
    let mut solver = solver(FlowProblem { open_edges, ..basin() }, 0.0, |_| 94.0);
    run_steps(&mut solver, 400);
    let ledger = solver.ledger();
    assert!(ledger.outflow > 0.2 * ledger.initial, "only {} of {} m³ left", ledger.outflow, ledger.initial);
    assert!(ledger.relative_error().abs() < 1e-12);
    let on_lattice: f64 = solver.water().depths().iter().sum();
    assert!((on_lattice * SPACING * SPACING - ledger.stored).abs() < 1e-9 * ledger.stored);
}

#[test]
fn one_and_two_and_five_threads_give_equal_bits() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut solver = solver(basin(), 0.2, |p| if p.x > 15.0 { 97.0 } else { 93.0 });
            run_steps(&mut solver, 60);
            let bits = |cell: WaterInCell| [cell.depth, cell.discharge_x, cell.discharge_y].map(f64::to_bits);
            solver.water().cells().map(bits).collect::<Vec<_>>()
        })
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(5));
}

#[test]
fn broken_state_ends_the_run_with_its_place() {
    let mut solver = solver(basin(), 0.0, |_| 94.0);
    let step = solver.choose_step().time_step;
    solver.state_mut().particles.velocity[10].x = f64::NAN;
    let place = solver.state().particles.position[10];
    let failure = solver.advance(step).unwrap_err();
    assert_eq!(failure.limiter, "courant");
    assert!(failure.quantity.contains("position") || failure.quantity.contains("velocity"), "{failure}");
    // Map coordinates: the lattice of the tests begins at 1000, 2000.
    let FailurePlace::OnMap(on_map) = failure.place else { panic!("{failure}") };
    assert!((on_map.y - 2000.0 - place.y).abs() < SPACING, "{failure}");
}

#[test]
fn place_without_water_is_no_trouble() {
    let mut solver = VariationalSolver::new(basin(), Vec::new(), Integrator::Heun, Stabilisation::TwoShocks);
    assert_eq!(solver.choose_step().limit, floodsim::solver::StepLimit::NoWater);
    solver.advance(10.0).unwrap();
    assert!(solver.water().spans.is_empty() && solver.ledger().relative_error() == 0.0);
}
