//! Boundaries with a condition: rest, the volume of a hydrograph, uniform flow, waves that leave, and the same bits for any threads.

mod oblique;
mod sources;

use rayon::prelude::*;

use crate::boundary::{Boundary, Condition, LineSource, OpenEdges, PointSource, Rain, Rating, Series};
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::methods::Reconstruction;
use crate::solver::testing::{open, run_steps, run_until, still_water as problem};
use crate::solver::{EulerianMethods, EulerianSolver, FlowProblem, FlowSolver};

const G: f64 = 9.81;

/// Overflow (m²/s) of a sill 2 m high and `length` (m) long under a held head (m) above its crest.
fn overflow(length: f64, head: f64) -> f64 {
    let bed = |place: Vec2| if (145.0..145.0 + length).contains(&place.x) { 2.0 } else { 0.0 };
    let level = 2.0 + head;
    let mut problem = problem((120, 2), 2.5, bed, |place| if place.x < 145.0 { level } else { 0.0 });
    open(&mut problem, true, Condition::Stage(Series::constant(level)));
    open(&mut problem, false, Condition::NormalDepth { slope: 0.01 });
    problem.bed.manning.fill(0.005);
    let mut solver = EulerianSolver::new(problem);
    run_until(&mut solver, 1000.0);
    let before = solver.ledger().inflow - solver.ledger().outflow - solver.ledger().stored;
    let out_before = solver.ledger().outflow;
    run_until(&mut solver, 2000.0);
    assert!((solver.ledger().inflow - solver.ledger().outflow - solver.ledger().stored - before).abs() < 1e-8);
    (solver.ledger().outflow - out_before) / 1000.0 / 5.0
}

#[test]
fn a_sill_is_overtopped_by_what_a_broad_crested_weir_lets_pass() {
    // Length, head, and the share that docs/theory.md tells.
    for (length, head, documented) in [
        (15.0, 0.25, 0.985),
        (15.0, 0.5, 0.996),
        (15.0, 1.0, 1.0),
        (15.0, 2.0, 1.0),
        (2.5, 0.25, 1.006),
        (2.5, 0.5, 1.005),
        (2.5, 1.0, 1.004),
        (2.5, 2.0, 1.004),
    ] {
        let q = overflow(length, head);
        // Critical depth on the crest; the level is that of the water at rest, so that the head holds that of the velocity.
        let share = q / ((2.0_f64 / 3.0 * head).powf(1.5) * G.sqrt());
        println!("{length} m long, {head} m over it: {q} m²/s, {share} of the weir");
        let bounds = documented - 0.01..documented + 0.01;
        assert!(bounds.contains(&share), "{length} m long, {head} m over it: {q} m²/s, {share} of the weir");
    }
}

pub(super) fn noise(place: Vec2) -> f64 {
    ((place.x * 12.9898 + place.y * 78.233).sin() * 43_758.545_3).fract() - 0.5
}

#[test]
fn a_lake_stays_at_rest_behind_edges_at_its_level() {
    for level in [2.0, 1234.5] {
        let held = || Series::constant(level);
        for conditions in [
            [Condition::Stage(held()), Condition::Free],
            [Condition::Discharge { discharge: Series::constant(0.0), level: None }, Condition::Free],
            [Condition::Level(held()), Condition::Wave { level: held(), still: None }],
            [Condition::Wave { level: held(), still: Some(held()) }, Condition::Level(held())],
        ] {
            let bed = |place: Vec2| level - 2.0 + 2.5 * (noise(place) + 0.2);
            let mut problem = problem((30, 24), 1.0, bed, |_| level);
            let [west, east] = conditions;
            open(&mut problem, true, west);
            open(&mut problem, false, east);
            let mut solver = EulerianSolver::new(problem);
            let fastest = run_steps(&mut solver, 300);
            assert!(fastest < 1e-12, "level {level}: {fastest:e} m/s");
        }
    }
}

#[test]
fn a_bay_before_a_held_level_comes_to_rest() {
    // With the level held against all that comes in, an eddy at the edge grows to more than 5 m/s.
    for condition in [Condition::Stage(Series::constant(1.0)), Condition::Level(Series::constant(1.0))] {
        let mut problem = problem((30, 30), 5.0, |place| 0.5 * noise(place) - 1.75, |_| 0.0);
        problem.bed.manning.fill(0.02);
        open(&mut problem, true, condition);
        let mut solver = EulerianSolver::new(problem);
        run_until(&mut solver, 2500.0);
        let fastest = solver.choose_step().max_speed;
        assert!(fastest < 0.25, "{fastest} m/s");
    }
}

#[test]
fn over_the_crest_of_falling_ground_a_held_level_sends_critical_flow() {
    let mut problem = problem((40, 2), 2.5, |place| -0.05 * place.x, |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(0.01);
    open(&mut problem, true, Condition::Stage(Series::constant(0.9)));
    open(&mut problem, false, Condition::NormalDepth { slope: 0.05 });
    let mut solver = EulerianSolver::new(problem);
    run_until(&mut solver, 100.0);
    let before = solver.ledger().inflow;
    run_until(&mut solver, 200.0);
    let share = (solver.ledger().inflow - before) / 500.0 / (0.6_f64.powf(1.5) * G.sqrt());
    println!("{share} of a broad-crested weir");
    assert!((share - 1.0).abs() < 0.05, "{share} of a broad-crested weir");
}

/// The greatest depth and discharge by those of uniform flow, of a front down a dry slope of 1 in 20 with bed steps of four depths from cell to cell.
fn down_a_steep_slope(reconstruction: Reconstruction) -> (f64, f64) {
    let (slope, n, depth, spacing) = (0.05_f64, 0.035, 0.25_f64, 20.0);
    let mut problem = problem((60, 2), spacing, |place| -slope * place.x, |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(n);
    let uniform = depth.powf(5.0 / 3.0) * slope.sqrt() / n;
    let discharge = Series::constant(uniform * 2.0 * spacing);
    open(&mut problem, true, Condition::Discharge { discharge, level: Some(Series::constant(depth)) });
    open(&mut problem, false, Condition::NormalDepth { slope });
    let mut solver =
        EulerianSolver::with_methods(problem, EulerianMethods { reconstruction, ..EulerianMethods::default() });
    let mut greatest = (0.0_f64, 0.0_f64);
    while solver.time() < 2.0 * 60.0 * spacing * depth / uniform {
        let choice = solver.choose_step();
        solver.advance(choice.time_step).unwrap();
        let water = solver.water();
        greatest = water.cells().take(50).skip(20).fold(greatest, |greatest, cell| {
            (greatest.0.max(cell.depth / depth), greatest.1.max(cell.discharge_x / uniform))
        });
    }
    greatest
}

#[test]
fn fronts_down_steep_slopes_do_not_rise_above_uniform_flow() {
    for (reconstruction, bounds) in [(Reconstruction::Limited, (1.01, 1.01)), (Reconstruction::Sharp, (1.01, 1.02))] {
        let (depth, discharge) = down_a_steep_slope(reconstruction);
        println!("{reconstruction:?}: {depth} of the uniform depth, {discharge} of the discharge");
        assert!(
            depth < bounds.0 && discharge < bounds.1,
            "{reconstruction:?}: {depth} of the depth, {discharge} of the discharge"
        );
    }
}

/// A valley 40 m wide that falls to the east.
fn valley(place: Vec2) -> f64 {
    0.02 * (200.0 - place.x) + 0.01 * (place.y - 20.0).powi(2) + 0.1 * noise(place)
}

fn flooded_valley() -> FlowProblem {
    let mut problem = problem((80, 16), 2.5, valley, |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(0.04);
    problem.dry_depth = 1e-3;
    let hydrograph = Series::new(&[(10.0, 0.0), (60.0, 30.0), (60.0, 12.0), (140.0, 3.0)]).unwrap();
    open(&mut problem, true, Condition::Discharge { discharge: hydrograph, level: None });
    open(&mut problem, false, Condition::NormalDepth { slope: 0.02 });
    let across = |x: f64| vec![[Vec2::new(x, 40.0), Vec2::new(x, 23.1)], [Vec2::new(x, 23.1), Vec2::new(x, 0.0)]];
    problem.forcing.sections = vec![across(50.0), across(120.3), vec![[Vec2::new(90.0, 0.0), Vec2::new(99.0, 40.0)]]];
    problem
}

#[test]
fn a_hydrograph_is_booked_to_its_integral_on_dry_ground() {
    let mut solver = EulerianSolver::new(flooded_valley());
    let mut beyond = 0.0;
    for end in [30.0, 100.0, 200.0, 400.0] {
        run_until(&mut solver, end);
        let hydrograph = Series::new(&[(10.0, 0.0), (60.0, 30.0), (60.0, 12.0), (140.0, 3.0)]).unwrap();
        let (ledger, wanted) = (solver.ledger(), hydrograph.integral(0.0, end));
        assert!((ledger.inflow / wanted - 1.0).abs() < 1e-12, "{end} s: {} of {wanted} m3", ledger.inflow);
        assert!(ledger.relative_error().abs() < 1e-12, "{end} s: {:e}", ledger.relative_error());
        beyond = ledger.outflow;
    }
    assert!(beyond > 1500.0, "{beyond} m3 left");
    // What passed a section is what lies behind it or has left.
    let sections = solver.sections().to_vec();
    let depth = solver.water().depths();
    let behind = |x: f64| -> f64 {
        let lattice = Lattice::new(Vec2::ZERO, 80, 16, 2.5);
        (0..depth.len()).filter(|&i| lattice.centre(i).x > x).map(|i| depth[i] * 6.25).sum()
    };
    for (section, x) in [(0, 50.0), (1, 120.3)] {
        let wanted = behind(x) + solver.ledger().outflow;
        let found = sections[section].volume;
        assert!((found / wanted - 1.0).abs() < 1e-11, "{x}: {found} of {wanted} m3");
    }
    assert!(sections[2].volume < -1500.0, "drawn from the right to the left bank: {}", sections[2].volume);
    assert!((sections[0].discharge - 3.0).abs() < 0.1, "{} m3/s", sections[0].discharge);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let state_after = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut problem = flooded_valley();
            problem.forcing.rain = Some(Rain::Uniform(Series::constant(1e-5)));
            problem.forcing.sources =
                vec![PointSource { place: Vec2::new(60.0, 20.0), discharge: Series::constant(2.0) }];
            let mut solver = EulerianSolver::new(problem);
            for _ in 0..300 {
                let choice = solver.choose_step();
                solver.advance(choice.time_step).unwrap();
            }
            let bits: Vec<u64> = solver.water().depths().iter().map(|d| d.to_bits()).collect();
            (bits, solver.ledger().inflow.to_bits(), solver.sections()[0].volume.to_bits())
        })
    };
    let one = state_after(1);
    assert_eq!(one, state_after(2));
    assert_eq!(one, state_after(5));
}

/// Uniform flow of depth 1 m in a channel that starts dry and ends by a boundary with a condition or by an edge without one: greatest
/// relative errors of depth and velocity after `end` (s).
fn uniform(slope: f64, length: f64, spacing: f64, (end, has_condition): (f64, bool)) -> (f64, f64) {
    let (n, depth): (f64, f64) = (0.03, 1.0);
    let velocity = slope.sqrt() / n * depth.powf(2.0 / 3.0);
    let is_fast = velocity > (G * depth).sqrt();
    let columns = (length / spacing).round() as usize;
    let bed = |place: Vec2| -slope * place.x;
    let mut problem = problem((columns, 1), spacing, bed, |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(n);
    problem.dry_depth = 1e-3;
    let level = is_fast.then(|| Series::constant(depth));
    let discharge = Series::constant(depth * velocity * spacing);
    open(&mut problem, true, Condition::Discharge { discharge, level });
    if has_condition {
        open(&mut problem, false, Condition::NormalDepth { slope });
    } else {
        let edge = [Vec2::new(length, 0.0), Vec2::new(length, spacing)];
        problem.open_edges = OpenEdges { pieces: vec![edge].into(), reach: 1.1, outline: None };
    }
    let mut solver = EulerianSolver::new(problem);
    run_until(&mut solver, end);
    let ledger = solver.ledger();
    assert!(ledger.relative_error().abs() < 1e-12, "{:e}", ledger.relative_error());
    let water = solver.water();
    let errors = water
        .cells()
        .take(columns)
        .map(|cell| ((cell.depth / depth - 1.0).abs(), (cell.discharge_x / cell.depth / velocity - 1.0).abs()));
    errors.fold((0.0, 0.0), |worst, error| (worst.0.max(error.0), worst.1.max(error.1)))
}

#[test]
fn uniform_flow_enters_and_leaves_as_manning_has_it() {
    for (slope, end) in [(0.001, 6000.0), (0.02, 600.0)] {
        for has_condition in [true, false] {
            let (depth, velocity) = uniform(slope, 400.0, 4.0, (end, has_condition));
            println!("slope {slope}, condition {has_condition}: depth {depth:.1e}, velocity {velocity:.1e}");
            assert!(depth < 5e-3 && velocity < 5e-3, "slope {slope}, {has_condition}: {depth:e}, {velocity:e}");
        }
    }
}

/// A wave of amplitude `height` (m) on still water 1 m deep leaves to the east; the share that comes back.
fn reflected(height: f64, condition: Condition) -> f64 {
    let (spacing, length, middle) = (0.25, 100.0, 50.0);
    let hump = |place: Vec2| 1.0 + height * (-(place.x - middle).powi(2) / 25.0).exp();
    let mut problem = problem((400, 1), spacing, |_| 0.0, hump);
    // The water beyond the eastern edge is as it was there at the start: 1 m deep.
    open(&mut problem, false, condition);
    open(&mut problem, true, Condition::Free);
    let celerity = |d: f64| (G * d).sqrt();
    let mut solver = EulerianSolver::new(problem);
    solver.set_velocity(|place| Vec2::new(2.0 * (celerity(hump(place)) - celerity(1.0)), 0.0));
    // The whole wave has gone, and what came back is still on its way.
    let slowest = 3.0 * celerity(1.0 + height.min(0.0)) - 2.0 * celerity(1.0);
    run_until(&mut solver, 1.3 * (length - middle) / slowest);
    solver.water().depths().iter().map(|d| (d - 1.0).abs()).fold(0.0, f64::max) / height.abs()
}

#[test]
fn waves_leave_through_a_free_edge() {
    for height in [0.01, -0.01, 0.1, 0.5, -0.3] {
        let share = reflected(height, Condition::Free);
        println!("wave of {height} m: {:.3} % comes back", 100.0 * share);
        assert!(share < 0.02, "wave of {height} m: {share}");
    }
    // A level that is held sends all of it back: what is measured is no accident.
    let held = reflected(0.01, Condition::Stage(Series::constant(1.0)));
    assert!(held > 0.9, "{held}");
}

#[test]
fn a_tide_at_the_edge_of_a_basin_fills_and_empties_it() {
    // A basin much shorter than the tide follows it: Q = A dη/dt.
    // It starts without a jump of its rate, which would set the basin swinging.
    let tide = |time: f64| 0.5 * (std::f64::consts::TAU * time / 3600.0).cos() - 0.5;
    let points: Vec<(f64, f64)> = (0..=360).map(|i| f64::from(i) * 20.0).map(|t| (t, tide(t))).collect();
    let mut problem = problem((40, 6), 10.0, |_| -5.0, |_| 0.0);
    open(&mut problem, true, Condition::Stage(Series::new(&points).unwrap()));
    let mut solver = EulerianSolver::new(problem);
    let mut worst = 0.0_f64;
    for k in 1..=14 {
        let time = 450.0 * f64::from(k);
        run_until(&mut solver, time);
        worst = solver.water().depths().iter().map(|d| (d - 5.0 - tide(time)).abs()).fold(worst, f64::max);
    }
    let ledger = solver.ledger();
    println!("tide: greatest error of the level {worst:.1e} m; {ledger:?}");
    assert!(worst < 5e-3, "{worst} m");
    assert!(ledger.relative_error().abs() < 1e-12 && ledger.outflow > 0.0 && ledger.inflow > 0.0);
}

#[test]
fn a_rating_lets_out_what_its_level_says() {
    let rating = Rating::new(&[(0.5, 0.0), (1.0, 2.0), (2.0, 10.0)]).unwrap();
    let mut problem = problem((30, 8), 5.0, |_| 0.0, |_| 0.5);
    open(&mut problem, true, Condition::Discharge { discharge: Series::constant(6.0), level: None });
    open(&mut problem, false, Condition::Rating(rating.clone()));
    problem.bed.manning.fill(0.03);
    let mut solver = EulerianSolver::new(problem);
    run_until(&mut solver, 9000.0);
    let before = solver.ledger();
    run_until(&mut solver, 9100.0);
    let ledger = solver.ledger();
    let leaves = (ledger.outflow - before.outflow) / 100.0;
    let level = solver.water().at(4 * 30 + 29).depth;
    println!("rating: {leaves} m3/s at {level} m, which stands for {}", rating.discharge(level));
    assert!((leaves - 6.0).abs() < 0.03, "{leaves} m3/s");
    assert!((rating.discharge(level) / 6.0 - 1.0).abs() < 0.01, "level {level} m");
    assert!(ledger.relative_error().abs() < 1e-12);
}

#[test]
fn a_supercritical_inflow_turns_subcritical_when_the_reach_fills_up() {
    // A steep inflow into a closed basin: the bore runs back to the edge and drowns it, and the hydrograph still comes in.
    let mut problem = problem((60, 1), 2.0, |_| 0.0, |_| f64::NEG_INFINITY);
    problem.dry_depth = 1e-3;
    let condition = Condition::Discharge { discharge: Series::constant(2.0 * 3.0), level: Some(Series::constant(0.5)) };
    open(&mut problem, true, condition);
    let mut solver = EulerianSolver::new(problem);
    run_until(&mut solver, 10.0);
    assert!((solver.water().at(0).depth - 0.5).abs() < 0.05, "{} m", solver.water().at(0).depth);
    run_until(&mut solver, 100.0);
    assert!(solver.water().at(0).depth > 1.5, "{} m", solver.water().at(0).depth);
    let ledger = solver.ledger();
    assert!((ledger.inflow / 600.0 - 1.0).abs() < 1e-12 && ledger.relative_error().abs() < 1e-12);
}
