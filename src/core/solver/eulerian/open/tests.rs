//! Boundaries with a condition: rest, the volume of a hydrograph, uniform flow, waves that leave, and the same bits for any threads.

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
        let lattice = Lattice { origin: Vec2::ZERO, columns: 80, rows: 16, spacing: 2.5 };
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
        problem.open_edges = OpenEdges { pieces: vec![edge].into(), reach: 1.1, whole_outline: false };
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

#[test]
fn rain_and_sources_are_booked_and_flow_together() {
    let mut problem = problem((20, 20), 5.0, |p| 0.02 * (p - Vec2::new(50.0, 50.0)).norm(), |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(0.05);
    problem.dry_depth = 1e-3;
    problem.forcing.rain = Some(Rain::Uniform(Series::new(&[(0.0, 2e-5), (100.0, 2e-5), (100.0, 0.0)]).unwrap()));
    problem.forcing.sources = vec![PointSource { place: Vec2::new(11.0, 11.0), discharge: Series::constant(0.5) }];
    let mut solver = EulerianSolver::new(problem);
    run_until(&mut solver, 600.0);
    let (wanted, ledger) = (2e-5 * 100.0 * 10_000.0 + 0.5 * 600.0, solver.ledger());
    assert!((ledger.inflow / wanted - 1.0).abs() < 1e-12, "{} of {wanted} m3", ledger.inflow);
    assert!(ledger.relative_error().abs() < 1e-12 && ledger.outflow.abs() <= 0.0);
    assert!(solver.water().at(10 * 20 + 10).depth > 0.1, "it gathers in the middle");
}

#[test]
fn many_sources_in_a_cell_are_one() {
    let flooded = |count: usize| {
        let mut problem = problem((21, 21), 5.0, |_| 0.0, |_| f64::NEG_INFINITY);
        problem.dry_depth = 1e-3;
        let source = PointSource { place: Vec2::new(52.0, 52.0), discharge: Series::constant(100.0 / count as f64) };
        problem.forcing.sources = vec![source; count];
        let mut solver = EulerianSolver::new(problem);
        let mut highest = 0.0_f64;
        while solver.time() < 5.0 {
            let step = solver.choose_step().time_step;
            solver.advance(step).unwrap();
            highest = highest.max(solver.water().at(10 * 21 + 10).depth);
        }
        (solver.steps(), highest)
    };
    let (one, many) = (flooded(1), flooded(64));
    // A sum of 64 parts in place of their whole: rounding.
    assert!(one.0 == many.0 && (one.1 - many.1).abs() < 1e-9, "{one:?} and {many:?}");
}

#[test]
fn a_line_source_spreads_by_its_shares_and_books_all_of_it() {
    let mut problem = problem((20, 4), 5.0, |_| 0.0, |_| f64::NEG_INFINITY);
    // The middle column, its four cells alike: the same flow to both sides, and none along the line.
    let discharge = Series::new(&[(0.0, 0.0), (20.0, 2.0), (40.0, 1.0)]).unwrap();
    let cells = (0..4).map(|row| (row * 20 + 10, 0.25)).collect();
    problem.forcing.line_sources = vec![LineSource { name: String::new(), cells, discharge: discharge.clone() }];
    let mut solver = EulerianSolver::new(problem.clone());
    run_until(&mut solver, 30.0);
    let ledger = solver.ledger();
    assert!((ledger.inflow / discharge.integral(0.0, 30.0) - 1.0).abs() < 1e-13, "{} m3", ledger.inflow);
    assert!(ledger.relative_error().abs() < 1e-12);
    let water = solver.water();
    assert!(water.cells().all(|cell| cell.discharge_y.abs() < 1e-14));
    assert!((0..9).all(|k| (water.at(9 - k).depth - water.at(11 + k).depth).abs() < 1e-13));
    // Shares that differ leave depths that differ by them within the first step.
    problem.forcing.line_sources[0].cells = vec![(5, 0.75), (50, 0.25)];
    let mut solver = EulerianSolver::new(problem);
    let step = solver.choose_step().time_step;
    solver.advance(step).unwrap();
    assert!((solver.water().at(5).depth - 3.0 * solver.water().at(50).depth).abs() < 1e-16);
}

/// Half a hump at a wall, which mirrors it, 60 m before the eastern edge of a basin, or of one that is longer by so many cells of 1 m: the level above rest (m) 2 m before the place of
/// that edge, in each step of 0.1 s for 45 s, at the angles (degrees) at which the wave comes to it.
fn hump_before_an_edge(height: f64, longer: usize, condition: Condition, angles: &[f64]) -> Vec<Vec<f64>> {
    let (before, rows) = (90.0, 140);
    let hump = |place: Vec2| 1.0 + height * (-(place - Vec2::new(before, 0.0)).norm_squared() / 25.0).exp();
    let columns = 150 + longer;
    let mut problem = problem((columns, rows), 1.0, |_| 0.0, hump);
    let side = |x: f64| vec![[Vec2::new(x, 0.0), Vec2::new(x, rows as f64)]];
    let edges = [(0.0, Condition::Free), (columns as f64, condition)];
    let boundary = |(x, condition)| Boundary { pieces: side(x).into(), condition };
    problem.forcing.boundaries.extend(edges.map(boundary));
    let cells: Vec<usize> =
        angles.iter().map(|angle| (60.0 * angle.to_radians().tan()) as usize * columns + 147).collect();
    let mut solver = EulerianSolver::new(problem);
    (1..=450)
        .map(|moment| {
            run_until(&mut solver, 0.1 * f64::from(moment));
            let water = solver.water();
            cells.iter().map(|&cell| water.at(cell).depth - 1.0).collect()
        })
        .collect()
}

#[test]
fn waves_leave_at_all_angles() {
    let angles = [0.0, 20.0, 36.0, 47.0, 61.0];
    let heights = [0.01, 0.3];
    let edges = [(60, Condition::Free), (0, Condition::Free), (0, Condition::Stage(Series::constant(1.0)))];
    let runs: Vec<_> = heights.into_iter().flat_map(|height| edges.iter().map(move |edge| (height, edge))).collect();
    let levels: Vec<_> = runs
        .into_par_iter()
        .map(|(height, (longer, condition))| hump_before_an_edge(height, *longer, condition.clone(), &angles))
        .collect();
    for (height, levels) in heights.into_iter().zip(levels.chunks_exact(edges.len())) {
        let endless = &levels[0];
        // Of the wave as it arrives.
        let share = |with_edge: &[Vec<f64>]| {
            let greatest = |of: &dyn Fn(usize) -> f64| (0..endless.len()).map(of).fold(0.0, f64::max);
            let back =
                |k: usize| greatest(&|i| (with_edge[i][k] - endless[i][k]).abs()) / greatest(&|i| endless[i][k].abs());
            std::array::from_fn::<f64, 5, _>(back)
        };
        let (free, held) = (share(&levels[1]), share(&levels[2]));
        for ((angle, free), held) in angles.iter().zip(free).zip(held) {
            println!(
                "hump of {height} m at {angle} degrees: {:.1} % comes back, {:.0} % from held levels",
                100.0 * free,
                100.0 * held
            );
            assert!(free < 0.065 && held > 10.0 * free, "hump of {height} m at {angle} degrees: {free}, {held}");
        }
    }
}

#[test]
fn a_hydrograph_over_a_ragged_edge_is_booked_and_both_directions_are_alike() {
    // A plane that falls to the north-east, without terrain in its south-western corner; the water comes in along that.
    let corner = |place: Vec2| place.x < 30.0 && place.y < 30.0;
    let bed = |place: Vec2| if corner(place) { f64::NAN } else { 10.0 - 0.01 * (place.x + place.y) };
    let mut problem = problem((24, 24), 5.0, bed, |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(0.03);
    problem.dry_depth = 1e-3;
    let at = |x: f64, y: f64| Vec2::new(x, y);
    let notch = vec![[at(30.0, 0.0), at(30.0, 30.0)], [at(30.0, 30.0), at(0.0, 30.0)]];
    let far = vec![[at(120.0, 0.0), at(120.0, 120.0)], [at(120.0, 120.0), at(0.0, 120.0)]];
    let discharge = Condition::Discharge { discharge: Series::constant(5.0), level: None };
    problem.forcing.boundaries.push(Boundary { pieces: notch.into(), condition: discharge });
    problem.forcing.boundaries.push(Boundary { pieces: far.into(), condition: Condition::NormalDepth { slope: 0.01 } });
    problem.forcing.rain = Some(Rain::Uniform(Series::constant(1e-5)));
    let mut solver = EulerianSolver::new(problem);
    run_until(&mut solver, 600.0);
    let ledger = solver.ledger();
    let supplied = 600.0 * (5.0 + 1e-5 * 25.0 * (24.0 * 24.0 - 36.0));
    assert!((ledger.inflow / supplied - 1.0).abs() < 1e-12, "{} of {supplied} m³", ledger.inflow);
    assert!(ledger.relative_error().abs() < 1e-12 && ledger.outflow > 0.1 * supplied, "{ledger:?}");
    let depths = solver.water().depths();
    for row in 0..24 {
        for column in 0..row {
            let (here, mirrored) = (depths[24 * row + column], depths[24 * column + row]);
            assert!((here - mirrored).abs() < 1e-9, "({column}, {row}): {here} and {mirrored} m");
        }
    }
}

/// A channel of 200 m by 60 m, turned by an angle (degrees) on the lattice, in which uniform flow of 1 m²/s would be 0.6 m deep: depth and
/// unit discharge along it, in six strips from bank to bank, at a distance (m) from its middle.
fn askew(degrees: f64, spacing: f64, distance: f64) -> [(f64, f64); 6] {
    const SLOPE: f64 = 0.005;
    let (size, middle) = ((240.0 / spacing) as usize, Vec2::new(120.0, 120.0));
    let (sin, cos) = degrees.to_radians().sin_cos();
    let own = |place: Vec2| {
        let offset = place - middle;
        Vec2::new(cos * offset.x + sin * offset.y, cos * offset.y - sin * offset.x)
    };
    let bed = |place: Vec2| {
        let own = own(place);
        if own.x.abs() < 100.0 && own.y.abs() < 30.0 { -SLOPE * own.x } else { f64::NAN }
    };
    let mut problem = problem((size, size), spacing, bed, |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(0.03);
    problem.dry_depth = 1e-3;
    problem.forcing.reach = 1.5 * spacing;
    let end = |x: f64| vec![[28.0, -28.0].map(|y| middle + Vec2::new(cos * x - sin * y, sin * x + cos * y))];
    let discharge = Condition::Discharge { discharge: Series::constant(60.0), level: None };
    problem.forcing.boundaries.push(Boundary { pieces: end(-100.0).into(), condition: discharge });
    problem
        .forcing
        .boundaries
        .push(Boundary { pieces: end(100.0).into(), condition: Condition::NormalDepth { slope: SLOPE } });
    let lattice = problem.bed.lattice.clone();
    let mut solver = EulerianSolver::new(problem);
    run_until(&mut solver, 900.0);
    let water = solver.water();
    [-25.0, -15.0, -5.0, 5.0, 15.0, 25.0].map(|across| {
        let is_there = |&cell: &usize| {
            let own = own(lattice.centre(cell));
            (own.x - distance).abs() <= 5.0 && (own.y - across).abs() <= 5.0
        };
        let cells: Vec<_> = (0..lattice.len()).filter(is_there).map(|cell| water.at(cell)).collect();
        let mean = |value: &dyn Fn(&crate::lattice::WaterInCell) -> f64| {
            cells.iter().map(value).sum::<f64>() / cells.len() as f64
        };
        (mean(&|water| water.depth), mean(&|water| cos * water.discharge_x + sin * water.discharge_y))
    })
}

#[test]
fn water_enters_and_leaves_an_edge_askew_to_the_lattice_over_its_whole_width() {
    let uniform = (0.03 / 0.005_f64.sqrt()).powf(0.6);
    for degrees in [0.0, 10.0, 30.0] {
        let (inlet, outlet) = (askew(degrees, 5.0, -80.0), askew(degrees, 5.0, 90.0));
        println!("{degrees} degrees: {inlet:.2?}, {outlet:.2?}");
        let tolerance = if degrees > 0.0 { 0.06 } else { 1e-3 };
        for (_, discharge) in &inlet[1..5] {
            assert!((discharge - 1.0).abs() < 1.5 * tolerance, "{degrees} degrees: {discharge} m²/s");
        }
        for (depth, _) in &outlet[1..5] {
            assert!((depth / uniform - 1.0).abs() < tolerance, "{degrees} degrees: {depth} m");
        }
    }
}

/// Mean depth (m) over the middle 60 % of the width, 150 to 250 m from the inlet, of 1 m deep uniform flow on a slope between banks that rise by
/// `bank` (m) for each metre, or where there is none between walls, in a channel of a width (m) at the bottom, turned by an angle (degrees) on cells of 2 m.
fn between_banks(degrees: f64, slope: f64, bank: Option<f64>, width: f64) -> f64 {
    const SPACING: f64 = 2.0;
    let (sin, cos) = degrees.to_radians().sin_cos();
    let own = |place: Vec2| {
        let offset = place - Vec2::new(0.0, 40.0);
        Vec2::new(cos * offset.x + sin * offset.y, cos * offset.y - sin * offset.x)
    };
    let bed = |place: Vec2| {
        let own = own(place);
        let beside = (own.y.abs() - 0.5 * width).max(0.0);
        let above = if beside > 0.0 { bank.map_or(f64::NAN, |bank| (bank * beside).min(6.0)) } else { 0.0 };
        -slope * own.x + above
    };
    let rows = (80.0 + 300.0 * sin / cos) / SPACING;
    let mut problem = problem((150, rows as usize), SPACING, bed, |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(0.03);
    problem.dry_depth = 1e-3;
    // What the bottom and both banks carry.
    let discharge = Series::constant((width + bank.map_or(0.0, |bank| 2.0 * 0.375 / bank)) * slope.sqrt() / 0.03);
    open(&mut problem, true, Condition::Discharge { discharge, level: None });
    open(&mut problem, false, Condition::NormalDepth { slope });
    let lattice = problem.bed.lattice.clone();
    let mut solver = EulerianSolver::new(problem);
    run_until(&mut solver, 300.0 * (0.02 / slope).sqrt());
    let water = solver.water();
    let is_there = |&cell: &usize| {
        let own = own(lattice.centre(cell));
        own.y.abs() < 0.3 * width && (150.0..250.0).contains(&own.x)
    };
    let depths: Vec<f64> = (0..lattice.len()).filter(is_there).map(|cell| water.at(cell).depth).collect();
    depths.iter().sum::<f64>() / depths.len() as f64
}

#[test]
fn banks_askew_to_the_lattice_hold_water_up_as_told() {
    // Angle, slope, rise of the banks, and by how much the water is too deep: what docs/theory.md tells.
    let upright = Some(f64::INFINITY);
    let channels = [
        (0.0, 0.02, upright, 0.0),
        (0.0, 0.02, Some(0.5), 0.0),
        (10.0, 0.02, Some(0.5), 0.012),
        (30.0, 0.02, Some(0.5), 0.022),
        (10.0, 0.02, upright, 0.092),
        (30.0, 0.02, upright, 0.106),
    ];
    let depths = channels.par_iter().map(|&(degrees, slope, bank, _)| between_banks(degrees, slope, bank, 40.0));
    for ((degrees, slope, bank, documented), depth) in channels.into_iter().zip(depths.collect::<Vec<_>>()) {
        println!("{degrees} degrees, slope {slope}, banks {bank:?}: {depth} m");
        assert!(
            (depth - 1.0 - documented).abs() < 0.005,
            "{degrees} degrees, slope {slope}, banks {bank:?}: {depth} m"
        );
    }
}

#[test]
fn walls_askew_to_the_lattice_do_not_hold_water_up() {
    // Angle, width and slope; at 45° the cells between the walls are 41.0 and 12.7 m wide.
    let channels = [
        (0.0, 40.0, 0.005, 0.0),
        (5.0, 40.0, 0.005, 0.0),
        (10.0, 40.0, 0.005, 0.0),
        (20.0, 40.0, 0.005, 0.0),
        (30.0, 40.0, 0.005, 0.0),
        (30.0, 40.0, 0.02, 0.0),
        (45.0, 40.0, 0.005, (40.0_f64 / 41.0).powf(0.6) - 1.0),
        (10.0, 12.0, 0.005, 0.0),
        (20.0, 12.0, 0.005, 0.0),
        (30.0, 12.0, 0.005, 0.0),
        (40.0, 12.0, 0.005, 0.0),
        (45.0, 12.0, 0.005, (12.0_f64 / 12.7).powf(0.6) - 1.0),
    ];
    let depths = channels.par_iter().map(|&(degrees, width, slope, _)| between_banks(degrees, slope, None, width));
    for ((degrees, width, slope, documented), depth) in channels.into_iter().zip(depths.collect::<Vec<_>>()) {
        println!("{degrees} degrees, {width} m wide, slope {slope}: {depth:.4} m");
        assert!(
            (depth - 1.0 - documented).abs() < 0.012,
            "{degrees} degrees, {width} m wide, slope {slope}: {depth} m"
        );
    }
}

#[test]
fn what_leaves_over_an_edge_inside_the_lattice_has_left() {
    let conditions = [Some(Condition::NormalDepth { slope: 0.02 }), Some(Condition::Free), None];
    for condition in conditions {
        let mut problem = problem((40, 9), 2.5, |p| 0.02 * (100.0 - p.x), |p| if p.x < 40.0 { 3.0 } else { -1.0 });
        problem.bed.manning.fill(0.04);
        problem.dry_depth = 1e-3;
        // The terrain ends before the last two columns.
        for cell in (0..360).filter(|cell| cell % 40 > 37) {
            problem.bed.elevation[cell] = f64::NAN;
            problem.initial_depth[cell] = 0.0;
        }
        let edge = vec![[Vec2::new(95.0, 0.0), Vec2::new(95.0, 22.5)]];
        match condition {
            Some(condition) => problem.forcing.boundaries.push(Boundary { pieces: edge.into(), condition }),
            None => problem.open_edges = OpenEdges { pieces: edge.into(), reach: 0.5, whole_outline: false },
        }
        let mut solver = EulerianSolver::new(problem);
        run_until(&mut solver, 60.0);
        let ledger = solver.ledger();
        assert!(ledger.outflow > 0.1 * ledger.initial, "{ledger:?}");
        assert!(ledger.relative_error().abs() < 1e-12, "{ledger:?}");
        assert!((0..360).filter(|cell| cell % 40 > 37).all(|cell| solver.water().at(cell).depth <= 0.0));
    }
}
