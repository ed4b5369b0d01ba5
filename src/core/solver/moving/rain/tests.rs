//! Rain on moving particles: its volume, the level of a lake, run-off from a slope, dry ground, and the same bits for any threads.

use rayon::prelude::*;

use crate::bed::BedParticles;
use crate::boundary::{Condition, Rain, Series};
use crate::math::Vec2;
use crate::methods::Integrator;
use crate::physics::dimension::Dimension;
use crate::solver::lagrangian::LagrangianSolver;
use crate::solver::moving::scene::{problem, solver};
use crate::solver::testing::{open, run_until};
use crate::solver::{EulerianSolver, FlowProblem, FlowSolver, Way};

fn rain(problem: &mut FlowProblem, rate: f64) {
    problem.forcing.rain = Some(Rain::Uniform(Series::constant(rate)));
}

fn volume_on_grid(solver: &mut LagrangianSolver) -> f64 {
    let water = solver.water();
    water.depths().iter().sum::<f64>() * water.lattice.cell_area()
}

#[test]
fn a_lake_rises_by_what_falls_and_stays_at_rest() {
    // Over a level bed and over a bed of bumps below the surface; closed walls.
    let bumps = |p: Vec2| 0.3 * (0.4 * p.x).sin() * (0.3 * p.y).cos();
    let beds: [&dyn Fn(Vec2) -> f64; 2] = [&|_| 0.0, &bumps];
    for (k, bed) in beds.into_iter().enumerate() {
        let mut problem = problem((24, 16), 2.5, bed, |_| 1.0);
        rain(&mut problem, 1e-4);
        let bed: BedParticles = problem.bed.clone();
        let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
        run_until(&mut solver, 300.0);
        let (ledger, wanted) = (solver.ledger(), 300.0 * 1e-4 * 60.0 * 40.0);
        assert!((ledger.inflow / wanted - 1.0).abs() < 1e-12, "{ledger:?}");
        assert!(ledger.relative_error().abs() < 1e-12, "{:e}", ledger.relative_error());
        let on_grid = volume_on_grid(&mut solver);
        assert!((on_grid / ledger.stored - 1.0).abs() < 1e-12, "{on_grid} m3 on the grid of {}", ledger.stored);
        let particles = &solver.state().particles;
        let level = |i: usize| particles.depth[i] + bed.at(particles.position[i]).unwrap().elevation;
        let off = (0..particles.len()).map(|i| (level(i) - 1.03).abs()).fold(0.0, f64::max);
        let fastest = particles.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
        println!("bed {k}: level off by {off:.1e} m, fastest {fastest:.1e} m/s, {} particles", particles.len());
        assert!(off < 1e-9 && fastest < 1e-9, "{off} m, {fastest} m/s");
    }
}

#[test]
fn rain_beyond_a_levee_does_not_lift_the_lake_before_it() {
    let bed = |p: Vec2| {
        if p.x < 50.0 {
            0.0
        } else if p.x < 62.5 {
            6.0
        } else {
            -3.0
        }
    };
    let mut problem = problem((32, 12), 2.5, bed, |p| if p.x < 50.0 { 2.0 } else { f64::NEG_INFINITY });
    let rate = (0..32 * 12).map(|cell| if cell % 32 > 24 { 1e-4 } else { 0.0 }).collect();
    problem.forcing.rain = Some(Rain::Map { rate, from: vec![0.0; 32 * 12], until: 1e6 });
    problem.dry_depth = 1e-3;
    let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
    let lake = |solver: &LagrangianSolver| -> f64 {
        let particles = &solver.state().particles;
        (0..particles.len()).filter(|&i| particles.position[i].x < 50.0).map(|i| particles.volume[i]).sum()
    };
    let before = lake(&solver);
    run_until(&mut solver, 200.0);
    assert!((lake(&solver) / before - 1.0).abs() < 1e-12, "{before} m3, then {} m3", lake(&solver));
    let particles = &solver.state().particles;
    let of_lake = (0..particles.len()).filter(|&i| particles.position[i].x < 50.0);
    let fastest = of_lake.map(|i| particles.velocity[i].norm()).fold(0.0, f64::max);
    assert!(fastest < 1e-12, "the lake moves at {fastest} m/s");
    assert!(solver.ledger().inflow > 10.0 && solver.ledger().relative_error().abs() < 1e-12);
}

/// Rain on a dry plane of 100 m that falls to the east by 2 %, and leaves at its foot.
fn slope(spacing: f64) -> FlowProblem {
    let size = ((100.0 / spacing) as usize, (20.0 / spacing) as usize);
    let mut problem = problem(size, spacing, |p| 10.0 - 0.02 * p.x, |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(0.03);
    problem.dry_depth = 1e-3;
    open(&mut problem, false, Condition::NormalDepth { slope: 0.02 });
    rain(&mut problem, 1e-4);
    problem
}

#[test]
fn rain_runs_off_a_slope_with_its_own_discharge() {
    let wanted = 1e-4 * 100.0 * 20.0;
    let mut resting = EulerianSolver::new(slope(2.5));
    let mut moving = solver(slope(2.5), Dimension::Two, Integrator::Leapfrog);
    let mut left = (0.0, 0.0);
    for end in [150.0, 300.0, 600.0, 900.0, 1500.0] {
        run_until(&mut resting, end);
        let steps = run_until(&mut moving, end);
        let (a, b) = (moving.ledger(), resting.ledger());
        println!("{end} s: {steps} steps, {} particles, {a:?}, resting {b:?}", moving.particles());
        assert!(a.relative_error().abs() < 1e-12);
        let on_grid = volume_on_grid(&mut moving);
        assert!((on_grid / a.stored - 1.0).abs() < 5e-3, "{on_grid} m3 on the grid of {}", a.stored);
        // It is steady after a quarter of an hour: until then the slope keeps some hundredths of the rain.
        if end < 1000.0 {
            left = (a.outflow, b.outflow);
        }
        if end >= 600.0 {
            assert!((a.stored / b.stored - 1.0).abs() < 0.1, "{} and {} m3 on the slope", a.stored, b.stored);
        }
    }
    let discharges = [(moving.ledger().outflow - left.0) / 600.0, (resting.ledger().outflow - left.1) / 600.0];
    println!("discharge {discharges:?} of {wanted} m3/s");
    assert!((discharges[0] / wanted - 1.0).abs() < 0.03, "{discharges:?}");
    assert!((discharges[0] / discharges[1] - 1.0).abs() < 0.03, "{discharges:?}");
    let passages = moving.passages();
    let rain = passages.iter().find(|passage| passage.way == Way::Rain).unwrap();
    assert!((rain.inflow / rain.asked.unwrap() - 1.0).abs() < 1e-12 && rain.inflow > 299.0, "{rain:?}");
}

/// Depth in the middle of a cone of 5 % with a lake, on which 36 mm fall within ten minutes, over that among resting particles, less one:
/// after these ten minutes and after twenty-five. How films come down is a matter of chance: the rain is stronger by so many millionths.
fn bowl_in_rain(millionths: f64) -> [f64; 2] {
    let bowl = |p: Vec2| 0.05 * (p - Vec2::new(50.0, 50.0)).norm();
    let mut problem = problem((40, 40), 2.5, bowl, |_| 1.0);
    problem.bed.manning.fill(0.03);
    problem.dry_depth = 1e-3;
    let strength = 6e-5 * (1.0 + 1e-6 * millionths);
    let rate = Series::new(&[(0.0, strength), (600.0, strength), (600.0, 0.0), (9000.0, 0.0)]).unwrap();
    problem.forcing.rain = Some(Rain::Uniform(rate));
    let mut resting = EulerianSolver::new(problem.clone());
    let mut moving = solver(problem, Dimension::Two, Integrator::Leapfrog);
    [600.0, 1500.0].map(|end| {
        run_until(&mut resting, end);
        let steps = run_until(&mut moving, end);
        let (ledger, of_resting) = (moving.ledger(), resting.ledger());
        let middle = |depths: &[f64]| [820, 819, 780, 779].iter().map(|&cell: &usize| depths[cell] / 4.0).sum::<f64>();
        let (found, wanted) = (middle(&moving.water().depths()), middle(&resting.water().depths()));
        println!("{end} s: {steps} steps, {} particles, {found} m in the middle, {wanted} m", moving.particles());
        assert!(ledger.relative_error().abs() < 1e-12 && (ledger.stored / of_resting.stored - 1.0).abs() < 1e-3);
        assert!((volume_on_grid(&mut moving) / ledger.stored - 1.0).abs() < 1e-12);
        // Films that ran into the lake are no crumbs there.
        assert!(moving.particles() < 1200 && steps < 6000, "{} particles, {steps} steps", moving.particles());
        found / wanted - 1.0
    })
}

#[test]
fn rain_on_a_bowl_gathers_in_its_lake() {
    let runs: Vec<[f64; 2]> = (0..6_u8).into_par_iter().map(|k| bowl_in_rain(f64::from(k))).collect();
    println!("{runs:?}");
    for (moment, within) in [0.05, 0.02].into_iter().enumerate() {
        let mean = runs.iter().map(|run| run[moment]).sum::<f64>() / 6.0;
        assert!(mean.abs() < within, "mean {mean} of {runs:?}");
        assert!(runs.iter().all(|run| run[moment].abs() < 2.0 * within), "{runs:?}");
    }
}

#[test]
fn drizzle_stays_where_it_falls_until_it_runs() {
    let mut problem = slope(5.0);
    rain(&mut problem, 1e-5);
    let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
    run_until(&mut solver, 190.0);
    assert_eq!(solver.particles(), 0);
    let depths = solver.water().depths();
    assert!(depths.iter().all(|depth| (depth - 1.9e-3).abs() < 1e-6), "{depths:?}");
    assert!((solver.ledger().stored / (1.9e-3 * 2000.0) - 1.0).abs() < 1e-12);
    run_until(&mut solver, 205.0);
    assert_eq!(solver.particles(), 80);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let state_after = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut solver = solver(slope(2.5), Dimension::Two, Integrator::Leapfrog);
            run_until(&mut solver, 80.0);
            assert!(solver.particles() > 100);
            let bits: Vec<u64> = solver.state().particles.volume.iter().map(|volume| volume.to_bits()).collect();
            (bits, solver.ledger().inflow.to_bits())
        })
    };
    let one = state_after(1);
    assert_eq!(one, state_after(2));
    assert_eq!(one, state_after(5));
}

#[test]
fn a_pond_beside_a_large_calm_lake_is_drawn_as_it_rises() {
    // Nothing moves, and all that falls in ten minutes is a 2500th of the water.
    let mut problem = problem((40, 8), 2.5, |_| 0.0, |p| if p.x < 75.0 { 10.0 } else { 0.2 });
    problem.walls = vec![[Vec2::new(75.0, 0.0), Vec2::new(75.0, 20.0)]];
    problem.dry_depth = 1e-3;
    rain(&mut problem, 5e-6);
    let pond = problem.bed.lattice.index(35, 4);
    let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
    let at_start = solver.water().at(pond).depth;
    let mut behind = 0.0_f64;
    while solver.time() < 600.0 {
        let choice = solver.choose_step();
        assert!(choice.max_speed < 1e-3, "{} m/s", choice.max_speed);
        solver.advance(choice.time_step).unwrap();
        let (now, time) = (solver.water().at(pond).depth, solver.time());
        behind = behind.max((at_start + 5e-6 * time - now).abs());
    }
    println!("the pond is {behind:.1e} m behind at most");
    // A hundredth of the depth below which water does not move.
    assert!(behind < 1e-5, "{behind} m");
}
