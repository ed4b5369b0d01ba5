//! Boundaries with a condition beside moving particles: rest, the hydrograph in the books, uniform flow, waves that leave, levels and
//! ratings, and the same bits for any threads.

use super::LEAST_AREA;
use crate::boundary::{Boundary, Condition, PointSource, Rating, Series};
use crate::math::Vec2;
use crate::methods::Integrator;
use crate::physics::dimension::Dimension;
use crate::solver::lagrangian::LagrangianSolver;
use crate::solver::moving::Rates;
use crate::solver::moving::scene::{G, problem, solver};
use crate::solver::testing::{open, open_part, run_steps, run_until};
use crate::solver::{FlowProblem, FlowSolver};

fn noise(place: Vec2) -> f64 {
    ((place.x * 12.9898 + place.y * 78.233).sin() * 43_758.545_3).fract() - 0.5
}

#[test]
fn a_lake_stays_at_rest_behind_edges_at_its_level() {
    for level in [2.0, 1234.5] {
        let conditions = [
            Condition::Stage(Series::constant(level)),
            Condition::Discharge { discharge: Series::constant(0.0), level: None },
            Condition::Free,
            Condition::Rating(Rating::new(&[(level + 0.5, 0.0), (level + 1.0, 2.0)]).unwrap()),
        ];
        for condition in conditions {
            let bed = |place: Vec2| level - 2.0 + 2.5 * (noise(place) + 0.2);
            let mut problem = problem((20, 16), 1.0, bed, |_| level);
            open(&mut problem, true, condition.clone());
            open_part(&mut problem, false, (0.3, 0.7), condition.clone());
            let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
            let fastest = run_steps(&mut solver, 100);
            assert!(fastest < 1e-12, "level {level}, {condition:?}: {fastest:e} m/s");
            assert!(solver.ledger().relative_error().abs() < 1e-15, "{:?}", solver.ledger());
        }
    }
}

/// Opens all four sides of a problem.
fn open_all(problem: &mut FlowProblem, condition: Condition) {
    let size = problem.bed.lattice.size();
    let corners = [Vec2::ZERO, Vec2::new(size.x, 0.0), size, Vec2::new(0.0, size.y)];
    let pieces = (0..4).map(|k| [corners[k], corners[(k + 1) % 4]]).collect();
    problem.forcing.boundaries.push(Boundary { pieces, condition });
}

#[test]
fn a_lake_stays_at_rest_with_all_its_sides_open() {
    for level in [2.0, 1234.5] {
        for condition in [Condition::Stage(Series::constant(level)), Condition::Free] {
            let bed = |place: Vec2| level - 2.0 + 2.5 * (noise(place) + 0.2);
            let mut problem = problem((20, 16), 1.0, bed, |_| level);
            open_all(&mut problem, condition);
            let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
            run_until(&mut solver, 10.0);
            let fastest = solver.state().particles.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
            println!("level {level}: {fastest:e} m/s");
            assert!(fastest < 1e-12, "level {level}: {fastest:e} m/s");
        }
    }
}

/// A valley 40 m wide that falls to the east.
fn valley(place: Vec2) -> f64 {
    0.02 * (200.0 - place.x) + 0.01 * (place.y - 20.0).powi(2) + 0.1 * noise(place)
}

fn hydrograph() -> Series {
    Series::new(&[(10.0, 0.0), (60.0, 30.0), (60.0, 12.0), (140.0, 3.0)]).unwrap()
}

fn flooded_valley() -> FlowProblem {
    let mut problem = problem((80, 16), 2.5, valley, |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(0.04);
    problem.dry_depth = 1e-3;
    open(&mut problem, true, Condition::Discharge { discharge: hydrograph(), level: None });
    open(&mut problem, false, Condition::NormalDepth { slope: 0.02 });
    problem
}

#[test]
fn a_hydrograph_is_booked_to_its_integral_on_dry_ground() {
    let mut solver = solver(flooded_valley(), Dimension::Two, Integrator::Leapfrog);
    let mut beyond = 0.0;
    for end in [30.0, 100.0, 200.0, 400.0] {
        run_until(&mut solver, end);
        let (ledger, wanted) = (solver.ledger(), hydrograph().integral(0.0, end));
        let on_grid = solver.water().depths().iter().sum::<f64>() * 6.25;
        println!(
            "{end} s: {ledger:?}, off on the grid {:.1e}, {} particles",
            on_grid / ledger.stored - 1.0,
            solver.particles()
        );
        assert!((ledger.inflow / wanted - 1.0).abs() < 1e-12, "{end} s: {} of {wanted} m3", ledger.inflow);
        assert!(ledger.relative_error().abs() < 1e-12, "{end} s: {:e}", ledger.relative_error());
        beyond = ledger.outflow;
    }
    assert!(beyond > 1500.0, "{beyond} m3 left");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let state_after = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut solver = solver(flooded_valley(), Dimension::Two, Integrator::Leapfrog);
            for _ in 0..400 {
                let choice = solver.choose_step();
                solver.advance(choice.time_step).unwrap();
            }
            assert!(solver.particles() > 100 && solver.ledger().outflow > 0.0);
            let bits: Vec<u64> = solver.state().particles.depth.iter().map(|d| d.to_bits()).collect();
            (bits, solver.ledger().inflow.to_bits())
        })
    };
    let one = state_after(1);
    assert_eq!(one, state_after(2));
    assert_eq!(one, state_after(5));
}

/// Uniform flow of depth 1 m in a channel that starts dry: greatest relative errors of depth and velocity after `end` (s), of the particles
/// and on the grid, there at several times while a row of particles crosses the edges.
fn uniform(slope: f64, size: (usize, usize), spacing: f64, end: f64) -> [(f64, f64); 2] {
    let (n, depth): (f64, f64) = (0.03, 1.0);
    let velocity = slope.sqrt() / n * depth.powf(2.0 / 3.0);
    let is_fast = velocity > (G * depth).sqrt();
    let mut problem = problem(size, spacing, |place| -slope * place.x, |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(n);
    problem.dry_depth = 1e-3;
    let level = is_fast.then(|| Series::constant(depth));
    let discharge = Series::constant(depth * velocity * spacing * size.1 as f64);
    open(&mut problem, true, Condition::Discharge { discharge, level });
    open(&mut problem, false, Condition::NormalDepth { slope });
    let dimension = if size.1 == 1 { Dimension::One } else { Dimension::Two };
    let mut solver = solver(problem, dimension, Integrator::Leapfrog);
    run_until(&mut solver, end);
    let ledger = solver.ledger();
    assert!(ledger.relative_error().abs() < 1e-12, "{:e}", ledger.relative_error());
    let off = |d: f64, v: Vec2| ((d / depth - 1.0).abs(), ((v.x / velocity - 1.0).abs()).max(v.y.abs() / velocity));
    let worse = |worst: (f64, f64), error: (f64, f64)| (worst.0.max(error.0), worst.1.max(error.1));
    let particles = &solver.state().particles;
    let of_particles =
        particles.depth.iter().zip(&particles.velocity).map(|(d, v)| off(*d, *v)).fold((0.0, 0.0), worse);
    let mut on_grid = (0.0, 0.0);
    for k in 1..=16 {
        run_until(&mut solver, end + 0.13 * f64::from(k) * spacing / velocity);
        let water = solver.water();
        on_grid = (0..size.0 * size.1).map(|cell| water.at(cell)).fold(on_grid, |worst, at| {
            worse(worst, off(at.depth, Vec2::new(at.discharge_x, at.discharge_y) * (1.0 / at.depth)))
        });
    }
    [of_particles, on_grid]
}

#[test]
fn uniform_flow_enters_and_leaves_as_manning_has_it() {
    for (slope, size, end) in
        [(0.001, (100, 1), 6000.0), (0.02, (100, 1), 600.0), (0.001, (50, 8), 3000.0), (0.02, (50, 8), 400.0)]
    {
        let [(depth, velocity), (on_grid, _)] = uniform(slope, size, 4.0, end);
        println!(
            "slope {slope}, {size:?}: depth {depth:.1e}, velocity {velocity:.1e}; depth on the grid {on_grid:.1e}"
        );
        assert!(depth < 5e-3 && velocity < 5e-3, "slope {slope}: {depth:e}, {velocity:e}");
    }
}

#[test]
fn uniform_flow_is_on_the_grid_what_it_is_up_to_the_edges() {
    for (slope, end) in [(0.001, 3000.0), (0.02, 400.0)] {
        let [_, (depth, velocity)] = uniform(slope, (100, 10), 2.0, end);
        println!("slope {slope}: depth {depth:.1e}, velocity {velocity:.1e}");
        assert!(depth < 5e-3 && velocity < 5e-3, "slope {slope}: {depth:e}, {velocity:e}");
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
    let mut solver = solver(problem, Dimension::One, Integrator::Leapfrog);
    let particles = &mut solver.state_mut().particles;
    for i in 0..particles.len() {
        particles.velocity[i] = Vec2::new(2.0 * (celerity(hump(particles.position[i])) - celerity(1.0)), 0.0);
    }
    solver.restart();
    // The whole wave has gone, and what came back is still on its way.
    let slowest = 3.0 * celerity(1.0 + height.min(0.0)) - 2.0 * celerity(1.0);
    run_until(&mut solver, 1.3 * (length - middle) / slowest);
    solver.state().particles.depth.iter().map(|d| (d - 1.0).abs()).fold(0.0, f64::max) / height.abs()
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
    println!("held level: {held}");
    assert!(held > 0.9, "{held}");
}

#[test]
fn a_wave_in_the_plane_leaves_on_all_sides() {
    let hump = |place: Vec2| 1.0 + 0.05 * (-(place - Vec2::new(20.0, 20.0)).norm_squared() / 16.0).exp();
    let mut problem = problem((40, 40), 1.0, |_| 0.0, hump);
    open_all(&mut problem, Condition::Free);
    let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
    run_until(&mut solver, 16.0);
    let left = solver.state().particles.depth.iter().map(|d| (d - 1.0).abs()).fold(0.0, f64::max) / 0.05;
    let ledger = solver.ledger();
    println!("hump: {:.2} % is left; {ledger:?}", 100.0 * left);
    assert!(left < 0.05 && ledger.relative_error().abs() < 1e-12);
}

#[test]
fn a_tide_at_the_edge_of_a_basin_fills_and_empties_it() {
    // A basin much shorter than the tide follows it: Q = A dη/dt.
    // It starts without a jump of its rate, which would set the basin swinging.
    let tide = |time: f64| 0.5 * (std::f64::consts::TAU * time / 3600.0).cos() - 0.5;
    let points: Vec<(f64, f64)> = (0..=360).map(|i| f64::from(i) * 20.0).map(|t| (t, tide(t))).collect();
    let mut problem = problem((40, 6), 10.0, |_| -5.0, |_| 0.0);
    open(&mut problem, true, Condition::Stage(Series::new(&points).unwrap()));
    let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
    let (mut worst, mut on_grid) = (0.0_f64, 0.0_f64);
    for k in 1..=14 {
        let time = 450.0 * f64::from(k);
        run_until(&mut solver, time);
        worst = solver.state().particles.depth.iter().map(|d| (d - 5.0 - tide(time)).abs()).fold(worst, f64::max);
        let mean = solver.water().depths().iter().sum::<f64>() / 240.0;
        on_grid = on_grid.max((mean - 5.0 - tide(time)).abs());
        println!("{time}: {worst:.2e} {on_grid:.2e}; {}", solver.particles());
    }
    let ledger = solver.ledger();
    println!("tide: greatest error of the level {worst:.1e} m; {ledger:?}");
    assert!(worst < 5e-3, "{worst} m");
    assert!(ledger.relative_error().abs() < 1e-12 && ledger.outflow > 0.0 && ledger.inflow > 0.0);
}

#[test]
fn what_goes_to_and_fro_across_an_edge_does_not_fall_to_dust() {
    // Waves of 8 s from a level that swings: water crosses the edge by less than a spacing, and turns.
    let level = |k: i32| (f64::from(k), 1.0 + 0.2 * (f64::from(k) * std::f64::consts::FRAC_PI_4).sin());
    let swell = Series::new(&(0..=400).map(level).collect::<Vec<_>>()).unwrap();
    let mut problem = problem((12, 6), 1.0, |place| 0.3 * noise(place), |_| 1.0);
    open(&mut problem, true, Condition::Stage(swell));
    let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
    run_until(&mut solver, 400.0);
    let open = &solver.state().open;
    let smallest = open.buffer.iter().map(|particle| particle.area).fold(f64::INFINITY, f64::min);
    println!(
        "{} buffer particles, the smallest of {smallest:e} m2, {} of water",
        open.buffer.len(),
        solver.particles()
    );
    assert!(smallest >= LEAST_AREA, "{smallest:e} m2");
    assert!(open.buffer.len() < 60 && solver.particles() < 100, "{} and {}", open.buffer.len(), solver.particles());
}

#[test]
fn a_rating_lets_out_what_its_level_says() {
    let rating = Rating::new(&[(0.5, 0.0), (1.0, 2.0), (2.0, 10.0)]).unwrap();
    let mut problem = problem((30, 8), 5.0, |_| 0.0, |_| 0.5);
    open(&mut problem, true, Condition::Discharge { discharge: Series::constant(6.0), level: None });
    open(&mut problem, false, Condition::Rating(rating.clone()));
    problem.bed.manning.fill(0.03);
    let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
    run_until(&mut solver, 9000.0);
    let before = solver.ledger();
    run_until(&mut solver, 9600.0);
    let ledger = solver.ledger();
    let leaves = (ledger.outflow - before.outflow) / 600.0;
    let level = solver.water().at(4 * 30 + 29).depth;
    println!("rating: {leaves} m3/s at {level} m, which stands for {}", rating.discharge(level));
    assert!((leaves - 6.0).abs() < 0.03, "{leaves} m3/s");
    assert!((rating.discharge(level) / 6.0 - 1.0).abs() < 0.01, "level {level} m");
    assert!(ledger.relative_error().abs() < 1e-12);
}

/// A river 20 m wide between banks of 1 m that falls to a level held at its mouth.
fn river_mouth(spacing: f64, condition: Condition) -> FlowProblem {
    let banks = |y: f64| if (20.0..40.0).contains(&y) { 0.0 } else { 1.0 };
    let bed = |place: Vec2| 10.0 - 0.2 * (place.x / 5.0).floor() + banks(place.y);
    let cells = |length: f64| (length / spacing) as usize;
    let mut problem = problem((cells(200.0), cells(60.0)), spacing, bed, |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(0.03);
    problem.dry_depth = 1e-3;
    let discharge = Series::new(&[(0.0, 0.0), (30.0, 12.0), (90.0, 4.0)]).unwrap();
    open_part(&mut problem, true, (1.0 / 3.0, 2.0 / 3.0), Condition::Discharge { discharge, level: None });
    open(&mut problem, false, condition);
    problem
}

#[test]
fn water_that_swings_in_a_mouth_is_on_the_grid_what_it_is_in_the_books() {
    for (level, spacing) in [(2.5, 5.0), (3.0, 5.0), (3.1, 5.0), (4.0, 5.0), (4.0, 2.5)] {
        let problem = river_mouth(spacing, Condition::Stage(Series::constant(level)));
        let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
        let mut worst = 0.0_f64;
        for k in 1..=24 {
            run_until(&mut solver, 5.0 * f64::from(k));
            let on_grid = solver.water().depths().iter().sum::<f64>() * spacing * spacing;
            worst = worst.max((on_grid / solver.ledger().stored - 1.0).abs());
        }
        let ledger = solver.ledger();
        println!("{level} m, cells of {spacing} m: {worst:.1e} off on the grid; {ledger:?}");
        assert!(ledger.inflow > 900.0 && ledger.outflow > 100.0, "it swings: {ledger:?}");
        assert!(ledger.relative_error().abs() < 1e-12);
        assert!(worst < 1e-12, "{level} m: {worst:e}");
    }
}

#[test]
fn what_was_brought_in_advance_is_taken_from_farther_away_where_too_little_stands_before_the_face() {
    let problem = river_mouth(5.0, Condition::Stage(Series::constant(3.1)));
    let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
    run_until(&mut solver, 80.0);
    let open = &mut solver.state_mut().open;
    let index = open.faces.iter().position(|face| face.outwards.x > 0.5 && face.sill < 9.0).unwrap();
    open.owed[index] -= 400.0;
    let stored = solver.ledger().stored;
    let on_grid = solver.water().depths().iter().sum::<f64>() * 25.0;
    println!("{on_grid} m3 on the grid, {stored} m3 in the books");
    assert!(stored > 100.0 && (on_grid / stored - 1.0).abs() < 1e-12, "{on_grid} of {stored} m3");
}

#[test]
fn what_drifted_past_a_bend_of_the_outline_comes_in_by_the_face_nearest_to_it_or_not_at_all() {
    // A sea over level ground, held at its level along a step of the terrain, whose corner the outline cuts at 45 degrees.
    let bed = |p: Vec2| if p.y < if p.x > 9.0 { 2.0 } else { 1.0 } { f64::NAN } else { -5.0 };
    let mut problem = problem((18, 18), 1.0, bed, |_| 0.0);
    let line = [Vec2::new(0.0, 1.0), Vec2::new(9.0, 1.0), Vec2::new(9.0, 2.0), Vec2::new(18.0, 2.0)];
    let pieces = line.windows(2).map(|ends| [ends[0], ends[1]]).collect();
    problem.forcing.boundaries = vec![Boundary { pieces, condition: Condition::Stage(Series::constant(0.0)) }];
    let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
    run_until(&mut solver, 0.1);
    let water = solver.state_mut();
    let (open, fluid) = (&mut water.open, water.particles.len());
    let south = open.faces.iter().position(|face| (face.middle.x - 7.0).abs() < 1.0 && face.outwards.y < -0.999);
    let cut = open.faces.iter().position(|face| face.outwards.x > 0.5 && face.outwards.y < -0.5);
    let (south, cut) = (south.unwrap(), cut.unwrap());
    // Both have passed the line of the southern face; the first stands beyond the cut corner, the second over open water.
    open.buffer.truncate(0);
    for position in [Vec2::new(8.9, 1.02), Vec2::new(5.2, 1.02)] {
        let face = south as u32;
        open.buffer.push(super::BufferParticle {
            face,
            position,
            area: 1.0,
            smoothing_length: 1.5,
            rates: Rates::default(),
        });
    }
    open.enter(&mut water.particles, &mut water.rates, (&water.bed, &water.walls));
    assert_eq!(water.particles.len(), fluid + 1, "one came in");
    assert_eq!(water.particles.position[fluid], Vec2::new(5.2, 1.02));
    let [kept] = &open.buffer[..] else { panic!("{:?}", open.buffer) };
    assert_eq!(kept.face as usize, cut, "{:?}", open.faces[kept.face as usize]);
}

/// A basin of 100 m by 100 m, level or a bowl, dry or with water to a level, with a source off its middle; 0.5 m³/s for 600 s.
fn fed_basin(bed: impl Fn(Vec2) -> f64, level: f64) -> (LagrangianSolver, f64) {
    let mut problem = problem((20, 20), 5.0, bed, |_| level);
    problem.bed.manning.fill(0.05);
    problem.dry_depth = 1e-3;
    problem.forcing.sources = vec![PointSource { place: Vec2::new(31.0, 41.0), discharge: Series::constant(0.5) }];
    let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
    let mut fastest = 0.0_f64;
    while solver.time() < 600.0 - 1e-9 {
        let choice = solver.choose_step();
        fastest = fastest.max(choice.max_speed);
        solver.advance(choice.time_step.min(600.0 - solver.time())).unwrap();
    }
    let ledger = solver.ledger();
    assert!((ledger.inflow / 300.0 - 1.0).abs() < 1e-12 && ledger.relative_error().abs() < 1e-12, "{ledger:?}");
    let on_grid = solver.water().depths().iter().sum::<f64>() * 25.0;
    assert!((on_grid / ledger.stored - 1.0).abs() < 1e-12, "{on_grid} m3 on the grid of {}", ledger.stored);
    println!("{} particles, fastest {fastest:.2} m/s", solver.particles());
    (solver, fastest)
}

#[test]
fn a_source_runs_on_dry_ground_and_into_water() {
    let bowl = |p: Vec2| 0.02 * (p - Vec2::new(50.0, 50.0)).norm();
    let (mut dry, fastest) = fed_basin(bowl, f64::NEG_INFINITY);
    let depth = dry.water().depths();
    println!("bowl: {} m in the middle, at the source {}", depth[10 * 20 + 10], depth[8 * 20 + 6]);
    assert!(depth[10 * 20 + 10] > 0.1 && fastest < 3.0, "it gathers in the middle");
    let (lake, fastest) = fed_basin(|_| 0.0, 1.0);
    let level = 1.0 + 300.0 / 10_000.0;
    let off = lake.state().particles.depth.iter().map(|d| (d - level).abs()).fold(0.0, f64::max);
    println!("lake: greatest error of the level {off:.1e} m");
    assert!(off < 1e-2 && fastest < 0.2, "{off} m, {fastest} m/s");
}

#[test]
fn a_supercritical_inflow_turns_subcritical_when_the_reach_fills_up() {
    // A steep inflow into a closed basin: the bore runs back to the edge and drowns it, and the hydrograph still comes in.
    let mut problem = problem((60, 1), 2.0, |_| 0.0, |_| f64::NEG_INFINITY);
    problem.dry_depth = 1e-3;
    let condition = Condition::Discharge { discharge: Series::constant(2.0 * 3.0), level: Some(Series::constant(0.5)) };
    open(&mut problem, true, condition);
    let mut solver = solver(problem, Dimension::One, Integrator::Leapfrog);
    run_until(&mut solver, 10.0);
    let first = solver.water().at(0).depth;
    println!("{first} m");
    assert!((first - 0.5).abs() < 0.05, "{first} m");
    run_until(&mut solver, 100.0);
    println!("{:?}", solver.ledger());
    assert!(solver.water().at(0).depth > 1.5, "{} m", solver.water().at(0).depth);
    let ledger = solver.ledger();
    assert!((ledger.inflow / 300.0 - 1.0).abs() < 1e-12 && ledger.relative_error().abs() < 1e-12);
}

/// A tide (m) that rises from 0 to 1 m in ten minutes.
fn tide(time: f64) -> f64 {
    0.5 - 0.5 * (std::f64::consts::PI * time / 600.0).cos()
}

/// That tide along two sides that meet in a corner over ground that rises from there.
fn tide_in_a_corner(cells: usize, slope: f64, floor: f64) -> FlowProblem {
    let spacing = 5.0;
    let mut problem = problem((cells, cells), spacing, |p| floor + slope * (p.x + p.y), |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(0.03);
    problem.dry_depth = 1e-3;
    let points: Vec<(f64, f64)> = (0..=60).map(|i| f64::from(i) * 10.0).map(|t| (t, tide(t))).collect();
    let far = cells as f64 * spacing;
    let corners = [Vec2::new(0.0, far), Vec2::ZERO, Vec2::new(far, 0.0)];
    let pieces = corners.windows(2).map(|ends| [ends[0], ends[1]]).collect();
    let condition = Condition::Stage(Series::new(&points).unwrap());
    problem.forcing.boundaries.push(Boundary { pieces, condition });
    problem
}

#[test]
fn a_tide_on_two_sides_of_a_corner_rises_in_it_as_beyond() {
    for (floor, bound) in [(0.0, 0.06), (-0.5, 0.1)] {
        let problem = tide_in_a_corner(24, 0.004, floor);
        let bed = problem.bed.elevation.clone();
        let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
        let (mut worst, mut of_particles) = (0.0_f64, 0.0_f64);
        for k in 1..=20 {
            let time = 30.0 * f64::from(k);
            run_until(&mut solver, time);
            let tide = tide(time);
            let water = solver.water();
            let near = (0..24 * 24).filter(|cell| cell % 24 < 8 && cell / 24 < 8);
            let levels = near.map(|cell| (water.at(cell).depth, bed[cell])).filter(|(depth, _)| *depth > 0.05);
            let off = levels.map(|(depth, ground)| depth + ground - tide).fold(0.0, f64::max);
            let state = solver.state();
            let particles = &state.particles;
            let is_near = |i: &usize| particles.position[*i].norm() < 40.0;
            let level = |i: usize| particles.depth[i] + state.bed_at(particles.position[i]).elevation;
            of_particles = (0..particles.len()).filter(is_near).map(|i| level(i) - tide).fold(of_particles, f64::max);
            worst = worst.max(off);
        }
        let ledger = solver.ledger();
        println!("ground from {floor} m: {worst:.3} m on the grid, {of_particles:.3} m of particles; {ledger:?}");
        assert!(worst < bound, "ground from {floor} m: {worst} m");
        assert!(ledger.relative_error().abs() < 1e-12);
    }
}
