//! Sections among moving particles: their geometry, uniform flow, the balance of what passed, and the same bits for any threads.

use rayon::prelude::*;

use super::{Line, share};
use crate::boundary::{Condition, Series};
use crate::math::Vec2;
use crate::methods::Integrator;
use crate::physics::dimension::Dimension;
use crate::solver::FlowSolver;
use crate::solver::lagrangian::LagrangianSolver;
use crate::solver::moving::scene::{problem, solver};
use crate::solver::testing::{open, run_until};

fn line(corners: &[(f64, f64)]) -> Line {
    Line::new(&pieces(corners), |_| false)
}

fn pieces(corners: &[(f64, f64)]) -> Vec<[Vec2; 2]> {
    let places: Vec<Vec2> = corners.iter().map(|&(x, y)| Vec2::new(x, y)).collect();
    places.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

#[test]
fn a_way_counts_once_with_its_sign() {
    // Drawn from the north to the south: the east is to its left.
    let bent = line(&[(0.0, 2.0), (0.0, 0.0), (1.0, -2.0)]);
    let crossings = |from: (f64, f64), to: (f64, f64)| bent.crossings(Vec2::new(from.0, from.1), Vec2::new(to.0, to.1));
    assert!((crossings((-1.0, 1.0), (1.0, 1.0)) - 1.0).abs() < 1e-15);
    assert!((crossings((1.0, 1.0), (-1.0, 1.0)) + 1.0).abs() < 1e-15);
    assert!(crossings((-1.0, 3.0), (1.0, 3.0)).abs() < 1e-15, "past its end");
    // Through the corner, and up to the very line and on.
    assert!((crossings((-1.0, 0.0), (1.0, 0.0)) - 1.0).abs() < 1e-15);
    let (first, second) = (crossings((-1.0, 1.0), (0.0, 1.0)), crossings((0.0, 1.0), (1.0, 1.0)));
    assert!((first + second - 1.0).abs() < 1e-15, "{first}, {second}");
    // There and back across both pieces.
    assert!(crossings((-0.1, 1.0), (0.4, -1.0)).abs() < 1e-15);
}

#[test]
fn distances_have_the_sign_of_their_side() {
    let bent = line(&[(0.0, 2.0), (0.0, 0.0), (1.0, -2.0)]);
    let distance = |x: f64, y: f64| bent.distance(Vec2::new(x, y));
    assert!((distance(0.5, 1.0).unwrap() - 0.5).abs() < 1e-15);
    assert!((distance(-0.5, 1.0).unwrap() + 0.5).abs() < 1e-15);
    // Nearest to the corner, on the outer side of the bend.
    assert!((distance(-0.3, -0.1).unwrap() + 0.1_f64.hypot(0.3)).abs() < 1e-15);
    assert_eq!((distance(0.1, 2.5), distance(1.2, -2.5)), (None, None));
    assert!(share(-2.0).abs() < 1e-15 && (share(0.0) - 0.5).abs() < 1e-15 && (share(1.0) - 23.0 / 24.0).abs() < 1e-15);
    assert!((share(2.0) - 1.0).abs() < 1e-15 && (share(0.4) + share(-0.4) - 1.0).abs() < 1e-15);
}

/// Uniform flow of depth 1 m through two sections, one across and one askew; its greatest relative errors of the discharge while it is steady,
/// and of the volume (m³), and the volume of a particle.
fn uniform(slope: f64, rows: usize, integrator: Integrator) -> (f64, f64, f64) {
    let (n, depth, spacing): (f64, f64, f64) = (0.03, 1.0, 4.0);
    let velocity = slope.sqrt() / n * depth.powf(2.0 / 3.0);
    let is_fast = velocity > (9.81 * depth).sqrt();
    let width = spacing * rows as f64;
    let mut problem = problem((60, rows), spacing, |place| -slope * place.x, |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(n);
    problem.dry_depth = 1e-3;
    let discharge = Series::constant(depth * velocity * width);
    let level = is_fast.then(|| Series::constant(depth));
    open(&mut problem, true, Condition::Discharge { discharge, level });
    open(&mut problem, false, Condition::NormalDepth { slope });
    let askew = if rows == 1 {
        vec![[Vec2::new(110.0, 4.0), Vec2::new(110.0, 0.0)]]
    } else {
        pieces(&[(110.0, width + 1.0), (116.3, 0.4 * width), (131.0, -1.0)])
    };
    problem.forcing.sections = vec![pieces(&[(90.7, width), (90.7, 0.0)]), askew];
    let dimension = if rows == 1 { Dimension::One } else { Dimension::Two };
    let steady = if is_fast { 150.0 } else { 2000.0 };
    // In one dimension volumes count per metre of width.
    let (wanted, particle) = match dimension {
        Dimension::One => (depth * velocity, depth * spacing),
        Dimension::Two => (depth * velocity * width, depth * spacing * spacing),
    };
    let mut solver = solver(problem, dimension, integrator);
    run_until(&mut solver, steady);
    let before = solver.sections().to_vec();
    let (mut of_discharge, mut of_volume) = (0.0_f64, 0.0_f64);
    while solver.time() < steady + 100.0 {
        let step = solver.choose_step().time_step;
        solver.advance(step).unwrap();
        for (flow, before) in solver.sections().iter().zip(&before) {
            of_discharge = of_discharge.max((flow.discharge / wanted - 1.0).abs());
            let passed = wanted * (solver.time() - steady);
            of_volume = of_volume.max((flow.volume - before.volume - passed).abs());
        }
    }
    (of_discharge, of_volume, particle)
}

#[test]
fn uniform_flow_passes_with_its_discharge() {
    for integrator in [Integrator::Leapfrog, Integrator::Heun] {
        for (slope, rows) in [(0.001, 1), (0.02, 1), (0.001, 8), (0.02, 8)] {
            let (of_discharge, of_volume, particle) = uniform(slope, rows, integrator);
            println!(
                "{integrator:?}, slope {slope}, {rows} rows: discharge {of_discharge:.1e}, volume {of_volume:.2e} of {particle} m3"
            );
            assert!(of_discharge < 0.01 && of_volume < 0.02 * particle, "{of_discharge}, {of_volume}");
        }
    }
}

/// A winding valley 40 m wide that falls to the east, with a flood that comes and goes, and is higher by so many millionths.
fn flooded_valley(millionths: f64) -> LagrangianSolver {
    let bed = |p: Vec2| 0.02 * (200.0 - p.x) + 0.01 * (p.y - 20.0 - 5.0 * (0.05 * p.x).sin()).powi(2);
    let mut problem = problem((80, 16), 2.5, bed, |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(0.04);
    problem.dry_depth = 1e-3;
    let hydrograph =
        Series::new(&[(10.0, 0.0), (60.0, 30.0 * (1.0 + 1e-6 * millionths)), (60.0, 12.0), (140.0, 3.0)]).unwrap();
    open(&mut problem, true, Condition::Discharge { discharge: hydrograph, level: None });
    open(&mut problem, false, Condition::NormalDepth { slope: 0.02 });
    let bent = pieces(&[(115.0, 40.0), (120.3, 23.1), (112.0, 0.0)]);
    problem.forcing.sections = vec![
        pieces(&[(50.0, 40.0), (50.0, 0.0)]),
        bent,
        pieces(&[(90.0, 0.0), (99.0, 40.0)]),
        pieces(&[(115.0, 40.0), (112.0, 0.0)]),
    ];
    solver(problem, Dimension::Two, Integrator::Leapfrog)
}

/// Mean and deviation of the discharge (m³/s) of the first three sections from 400 s to 1200 s, after a look at the volume of the first.
fn discharges_of_valley(millionths: f64) -> [(f64, f64); 3] {
    let mut solver = flooded_valley(millionths);
    for end in [30.0, 60.0, 100.0, 200.0, 400.0] {
        run_until(&mut solver, end);
        let particles = &solver.state().particles;
        let behind = |i: usize| {
            let edge = (particles.volume[i] / particles.depth[i]).sqrt();
            particles.volume[i] * share((particles.position[i].x - 50.0) / edge)
        };
        let behind: f64 = (0..particles.len()).map(behind).sum();
        let owed = solver.state().open.owed_by(1);
        let (wanted, found) = (behind + solver.ledger().outflow + owed, solver.sections()[0].volume);
        println!("{end} s: {found} of {wanted} m3 behind or gone");
        assert!((found - wanted).abs() < 1e-9, "{found} of {wanted} m3");
    }
    let (mut steps, mut sums) = (0.0, [(0.0, 0.0); 3]);
    while solver.time() < 1200.0 {
        let step = solver.choose_step().time_step;
        solver.advance(step).unwrap();
        steps += 1.0;
        for (flow, (sum, squares)) in solver.sections().iter().zip(&mut sums) {
            *sum += flow.discharge;
            *squares += flow.discharge * flow.discharge;
        }
    }
    sums.map(|(sum, squares): (f64, f64)| (sum / steps, (squares / steps - (sum / steps).powi(2)).sqrt()))
}

#[test]
fn what_passed_lies_behind_or_has_left() {
    // How the crowds come that form behind the bends is a matter of chance.
    let runs: Vec<[(f64, f64); 3]> = (0..4_u8).into_par_iter().map(|k| discharges_of_valley(f64::from(k))).collect();
    println!("mean and deviation of the discharge: {runs:?} m3/s");
    let found = [0, 1, 2].map(|section: usize| {
        let mean = |of: fn((f64, f64)) -> f64| runs.iter().map(|run| of(run[section])).sum::<f64>() / 4.0;
        (mean(|(mean, _)| mean), mean(|(_, deviation)| deviation))
    });
    // The stream of 3 m3/s is five particles wide.
    for (k, sign) in [1.0, 1.0, -1.0].into_iter().enumerate() {
        assert!((found[k].0 * sign - 3.0).abs() < 0.1 && found[k].1 < 1.2, "section {k}: {found:?}");
    }
    assert!((found[0].0 - 3.0).abs() < 0.07 && found[0].1 < 0.25, "{found:?}");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let state_after = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut solver = flooded_valley(0.0);
            run_until(&mut solver, 60.0);
            assert!(solver.particles() > 100);
            solver.sections().iter().map(|flow| (flow.volume.to_bits(), flow.discharge.to_bits())).collect::<Vec<_>>()
        })
    };
    let one = state_after(1);
    assert_eq!(one, state_after(2));
    assert_eq!(one, state_after(5));
}
