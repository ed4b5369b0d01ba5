//! Levels that are held at the boundary and waves that come in, against exact solutions: simple waves, uniform flow, critical flow onto dry
//! ground and over an edge, and waves that come back from a wall.

use super::tests::noise;
use crate::boundary::{Condition, Series};
use crate::math::Vec2;
use crate::solver::testing::{open, run_until, still_water as problem};
use crate::solver::{EulerianSolver, FlowProblem, FlowSolver};

const G: f64 = 9.81;

fn celerity(depth: f64) -> f64 {
    (G * depth).sqrt()
}

/// A series of a function of time (s) in steps of a twentieth of a second.
fn series(end: f64, value: impl Fn(f64) -> f64) -> Series {
    let points: Vec<(f64, f64)> = (0..=(20.0 * end) as usize).map(|i| i as f64 / 20.0).map(|t| (t, value(t))).collect();
    Series::new(&points).unwrap()
}

/// The smooth rise to `height` within `period` (s).
fn rise(time: f64, height: f64, period: f64) -> f64 {
    height * (0.5 * std::f64::consts::PI * (time / period).clamp(0.0, 1.0)).sin().powi(2)
}

/// Greatest errors of depth and velocity of the wave that a changing level at the western edge sends over 1 m of still water.
fn simple_wave(height: f64, spacing: f64, is_wave: bool) -> (f64, f64) {
    const END: f64 = 12.0;
    let level = |time: f64| 1.0 + rise(time, height, 10.0);
    let mut problem = problem(((60.0 / spacing) as usize, 1), spacing, |_| 0.0, |_| 1.0);
    let levels = series(END, level);
    let condition = if is_wave { Condition::Wave { level: levels, still: None } } else { Condition::Level(levels) };
    open(&mut problem, true, condition);
    let lattice = problem.bed.lattice.clone();
    let mut solver = EulerianSolver::new(problem);
    run_until(&mut solver, END);
    // The level at τ has come as far as x = (3c − 2c_0)(t − τ).
    let exact = |x: f64| {
        let (mut early, mut late) = (0.0, END);
        for _ in 0..60 {
            let middle = 0.5 * (early + late);
            let reach = (3.0 * celerity(level(middle)) - 2.0 * celerity(1.0)) * (END - middle);
            if reach > x { early = middle } else { late = middle }
        }
        let depth = level(early);
        (depth, 2.0 * (celerity(depth) - celerity(1.0)))
    };
    let water = solver.water();
    let errors = (0..lattice.len()).map(|cell| {
        let (depth, velocity) = exact(lattice.centre(cell).x);
        let found = water.at(cell);
        ((found.depth - depth).abs(), (found.discharge_x / found.depth - velocity).abs())
    });
    errors.fold((0.0, 0.0), |worst, error| (worst.0.max(error.0), worst.1.max(error.1)))
}

#[test]
fn a_changing_level_at_the_edge_sends_the_simple_wave_that_it_is() {
    for height in [0.2, -0.2] {
        for is_wave in [false, true] {
            let (coarse, fine) = (simple_wave(height, 0.5, is_wave), simple_wave(height, 0.25, is_wave));
            assert!(
                coarse.0 < 0.01 * height.abs() && coarse.1 < 0.03 * height.abs(),
                "{height} m, {is_wave}: {coarse:?}"
            );
            assert!(
                fine.0 < 0.5 * coarse.0 && fine.1 < 0.5 * coarse.1,
                "{height} m, {is_wave}: {coarse:?} to {fine:?}"
            );
        }
    }
}

/// Uniform flow between two levels held at the edges of a slope whose bed is `across` (m) higher by the row, each 40 m from the next;
/// greatest relative errors of depth and velocity.
fn uniform_between_levels(across: [f64; 4]) -> (f64, f64) {
    let (slope, n, spacing, columns) = (1e-3_f64, 0.03, 40.0, 50);
    let row = |place: Vec2| across[(place.y / spacing) as usize];
    let bed = |place: Vec2| row(place) - slope * place.x;
    let depth = |place: Vec2| 2.0 - row(place);
    let length = columns as f64 * spacing;
    let mut problem = problem((columns, 4), spacing, bed, |place| 2.0 - slope * place.x);
    problem.bed.manning.fill(n);
    // The flow is the same in all rows along the slope: its level stands even across it.
    open(&mut problem, true, Condition::Level(Series::constant(2.0)));
    open(&mut problem, false, Condition::Level(Series::constant(2.0 - slope * length)));
    let lattice = problem.bed.lattice.clone();
    let mut solver = EulerianSolver::new(problem);
    run_until(&mut solver, 12_000.0);
    assert!(solver.ledger().relative_error().abs() < 1e-12);
    let water = solver.water();
    let errors = (0..lattice.len()).map(|cell| {
        let (found, wanted) = (water.at(cell), depth(lattice.centre(cell)));
        let velocity = wanted.powf(2.0 / 3.0) * slope.sqrt() / n;
        ((found.depth / wanted - 1.0).abs(), (found.discharge_x / found.depth / velocity - 1.0).abs())
    });
    errors.fold((0.0, 0.0), |worst, error| (worst.0.max(error.0), worst.1.max(error.1)))
}

#[test]
fn levels_held_at_both_ends_of_a_river_are_those_of_its_flow() {
    for across in [[0.0; 4], [0.0, 0.3, -0.6, 0.9]] {
        let (depth, velocity) = uniform_between_levels(across);
        assert!(depth < 5e-3 && velocity < 5e-3, "{across:?}: {depth}, {velocity}");
    }
}

#[test]
fn between_still_water_and_a_level_the_flow_has_the_head_of_their_difference() {
    // No friction: u²/2g is the fall from the still water to the level at the other edge.
    for (fall, is_level) in [(0.02, true), (0.2, true), (0.02, false)] {
        let mut problem = problem((40, 1), 2.5, |_| 0.0, |_| 2.0);
        let far = Series::constant(2.0 - fall);
        open(&mut problem, true, Condition::Stage(Series::constant(2.0)));
        open(&mut problem, false, if is_level { Condition::Level(far) } else { Condition::Stage(far) });
        let mut solver = EulerianSolver::new(problem);
        run_until(&mut solver, 4000.0);
        let velocity = (2.0 * G * fall).sqrt();
        for cell in solver.water().cells().take(40) {
            let found = (cell.depth, cell.discharge_x / cell.depth);
            let is_right = (found.0 - 2.0 + fall).abs() < 1e-3 * fall && (found.1 / velocity - 1.0).abs() < 1e-3;
            assert!(is_right, "fall of {fall} m, {is_level}: {found:?}, {velocity} m/s");
        }
    }
}

#[test]
fn a_level_comes_onto_dry_ground_as_critical_flow() {
    // Level ground: the fan u − c = x/t behind a front at 3 c. Falling ground: the same flow at the edge for ever.
    for (slope, end) in [(0.0, 10.0), (0.05, 100.0)] {
        for (is_level, head) in [(true, 1.0), (false, 2.0 / 3.0)] {
            let mut problem = problem((80, 2), 2.5, |place| -slope * place.x, |_| f64::NEG_INFINITY);
            let level = Series::constant(0.9);
            open(&mut problem, true, if is_level { Condition::Level(level) } else { Condition::Stage(level) });
            open(&mut problem, false, Condition::Free);
            let mut solver = EulerianSolver::new(problem);
            run_until(&mut solver, 0.5 * end);
            let before = solver.ledger().inflow;
            run_until(&mut solver, end);
            let depth = head * 0.9;
            let share = (solver.ledger().inflow - before) / (0.5 * end * 5.0) / (depth * celerity(depth));
            assert!((share - 1.0).abs() < 0.01, "slope {slope}, level {is_level}: {share}");
            assert!(solver.ledger().relative_error().abs() < 1e-12);
        }
    }
}

#[test]
fn a_tide_that_falls_below_the_bed_drains_it_over_the_edge_and_comes_back() {
    // 200 m of level ground under 1 m of water: until the wave is back from the wall 8/27 √g passes the edge.
    let tide = |time: f64| (-0.5 + (time - 600.0).max(0.0) / 400.0).min(0.5);
    let mut problem = problem((200, 1), 1.0, |_| 0.0, |_| 1.0);
    problem.dry_depth = 1e-3;
    problem.bed.manning.fill(0.01);
    open(&mut problem, true, Condition::Level(series(3000.0, tide)));
    let mut solver = EulerianSolver::new(problem);
    run_until(&mut solver, 60.0);
    let share = solver.ledger().outflow / 60.0 / (8.0 / 27.0 * G.sqrt());
    // Friction takes 2.5 % of it.
    assert!((share - 1.0).abs() < 0.03, "{share}");
    run_until(&mut solver, 800.0);
    let left = solver.ledger().stored / 200.0;
    assert!(left < 0.08 && solver.ledger().inflow <= 0.0, "{left} m on average");
    run_until(&mut solver, 3000.0);
    let wet = solver.ledger().stored / 200.0;
    // It still swings by some 5 %.
    assert!((wet - 0.5).abs() < 0.05, "{wet} m where the tide stands at 0.5 m");
    assert!(solver.ledger().relative_error().abs() < 1e-12);
}

/// A hump of a wave of a height (m), 20 s long.
fn hump(time: f64, height: f64) -> f64 {
    height * (std::f64::consts::PI * (time / 20.0).clamp(0.0, 1.0)).sin().powi(2)
}

/// What comes in by a boundary to the west of 80 m of water 1 m deep before a wall, for so many seconds.
fn basin(spacing: f64, condition: Condition) -> FlowProblem {
    let mut problem = problem(((80.0 / spacing) as usize, 1), spacing, |_| 0.0, |_| 1.0);
    open(&mut problem, true, condition);
    problem
}

#[test]
fn a_wave_that_comes_back_from_a_wall_leaves() {
    for height in [0.01, 0.1, 0.3, -0.1] {
        for still in [None, Some(Series::constant(1.0))] {
            let level = series(200.0, |time| 1.0 + hump(time, height));
            let mut solver = EulerianSolver::new(basin(0.5, Condition::Wave { level, still }));
            // The crest is at the wall some 25 s after it came in.
            let mut highest = 0.0_f64;
            for moment in 0..400 {
                run_until(&mut solver, 0.1 * f64::from(moment));
                highest = highest.max((solver.water().at(159).depth - 1.0) / height);
            }
            run_until(&mut solver, 100.0);
            let left = solver.water().depths().iter().map(|d| (d - 1.0).abs()).fold(0.0, f64::max) / height.abs();
            assert!(left < 0.02, "{height} m: {left}");
            assert!((highest - 2.0).abs() < 0.1 + height.abs(), "{height} m: {highest}");
            assert!(solver.ledger().relative_error().abs() < 1e-12);
        }
    }
}

#[test]
fn a_swell_stands_before_a_wall_and_dies_with_its_source() {
    // Waves of 8 s, 5 cm high: twice that at the wall, as long as they come, and nothing after them.
    let swell = |time: f64| {
        0.05 * (std::f64::consts::TAU * time / 8.0).sin() * rise(time, 1.0, 16.0) * rise(120.0 - time, 1.0, 16.0)
    };
    let level = series(200.0, |time| 1.0 + swell(time));
    let mut solver = EulerianSolver::new(basin(0.5, Condition::Wave { level, still: None }));
    let mut highest = 0.0_f64;
    for moment in 0..=200 {
        run_until(&mut solver, 80.0 + 0.1 * f64::from(moment));
        highest = highest.max((solver.water().at(159).depth - 1.0) / 0.05);
    }
    run_until(&mut solver, 200.0);
    let left = solver.water().depths().iter().map(|d| (d - 1.0).abs()).fold(0.0, f64::max) / 0.05;
    assert!((1.8..2.25).contains(&highest) && left < 0.02, "{highest}, {left}");
}

#[test]
fn over_a_tide_a_wave_is_what_stands_above_it() {
    // The still level rises by a centimetre a second below no wave at all.
    let tide = series(400.0, |time| 1.0 + 1e-3 * time);
    let condition = Condition::Wave { level: tide.clone(), still: Some(tide) };
    let mut solver = EulerianSolver::new(basin(1.0, condition));
    run_until(&mut solver, 400.0);
    let off = solver.water().depths().iter().map(|d| (d - 1.4).abs()).fold(0.0, f64::max);
    // It follows by the water that has to come in: u = 80 m · 1e-3 / 1.4 = 0.057 m/s, and c − c_0 is half of that.
    assert!(off < 0.025, "{off} m");
}

#[test]
fn mirrored_water_before_a_level_has_mirrored_bits() {
    // Water that goes round at the edge, in at some faces and out at others, over ground mirrored along it.
    let ground = |place: Vec2| 0.5 * noise(place) - 1.75;
    let deep = |is_mirrored: bool| {
        let place = move |place: Vec2| if is_mirrored { Vec2::new(place.x, 60.0 - place.y) } else { place };
        let mut problem = problem((12, 12), 5.0, |at| ground(place(at)), |_| 0.0);
        open(&mut problem, true, Condition::Level(Series::constant(1.0)));
        let mut solver = EulerianSolver::new(problem);
        run_until(&mut solver, 60.0);
        solver.water().depths()
    };
    let (one, other) = (deep(false), deep(true));
    assert!((0..144).all(|i| one[i].to_bits() == other[12 * (11 - i / 12) + i % 12].to_bits()));
}
