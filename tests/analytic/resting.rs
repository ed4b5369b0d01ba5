//! The core with resting particles against exact solutions: errors are means over the grid, and their order is checked.

use floodsim::error::NumericalFailure;
use floodsim::math::Vec2;
use floodsim::solver::{EulerianSolver, FlowProblem, FlowSolver};

use crate::support::{assert_below, problem, radial_reference, ritter, stoker};

/// Steps to `end` (s).
fn run_until(solver: &mut EulerianSolver, end: f64) -> Result<(), NumericalFailure> {
    while solver.time() < end {
        let time_step = solver.choose_step().time_step.min(end - solver.time());
        solver.advance(time_step)?;
    }
    Ok(())
}

/// Mean errors of depth (m) and velocity (m/s) over the cells at which `counts` holds.
fn mean_errors(
    solver: &mut EulerianSolver,
    centres: &[Vec2],
    exact: impl Fn(Vec2) -> (f64, Vec2),
    counts: impl Fn(usize) -> bool,
) -> (f64, f64) {
    let water = solver.water();
    let (mut depth_error, mut velocity_error, mut cells) = (0.0, 0.0, 0);
    for (i, &place) in centres.iter().enumerate().filter(|(i, _)| counts(*i)) {
        let (d, v) = exact(place);
        let velocity = if water.depth[i] > 1e-3 {
            Vec2::new(water.discharge_x[i], water.discharge_y[i]) / water.depth[i]
        } else {
            Vec2::ZERO
        };
        depth_error += (water.depth[i] - d).abs();
        // Below half a per cent of 10 m the velocity of a front means nothing.
        velocity_error += if d > 0.05 { (velocity - v).norm() } else { 0.0 };
        cells += 1;
    }
    (depth_error / f64::from(cells), velocity_error / f64::from(cells))
}

#[expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
fn channel_errors(spacing: f64, right: f64) -> (f64, f64) {
    channel_errors_by(EulerianSolver::new, spacing, right).unwrap()
}

/// A channel of three rows between walls, 2000 m long, 10 m of water west of its middle and `right` (m) east of it, at 50 s.
pub fn channel_errors_by(
    solver: impl Fn(FlowProblem) -> EulerianSolver,
    spacing: f64,
    right: f64,
) -> Result<(f64, f64), NumericalFailure> {
    let columns = (2000.0 / spacing).round() as usize;
    let mut problem = problem(columns, 3, spacing, |_| 0.0);
    let lattice = problem.bed.lattice.clone();
    let centres: Vec<Vec2> = (0..lattice.len()).map(|i| lattice.centre(i)).collect();
    problem.initial_depth = centres.iter().map(|place| if place.x < 1000.0 { 10.0 } else { right }).collect();
    problem.courant = 0.5;
    let mut solver = solver(problem);
    run_until(&mut solver, 50.0)?;
    let exact = |place: Vec2| {
        let (d, u) = if right > 0.0 {
            stoker(10.0, right, place.x - 1000.0, 50.0)
        } else {
            ritter(10.0, place.x - 1000.0, 50.0)
        };
        (d, Vec2::new(u, 0.0))
    };
    Ok(mean_errors(&mut solver, &centres, exact, |i| lattice.column_row(i).1 == 1))
}

#[test]
fn ritter_converges_at_first_order() {
    let (coarse, fine) = (channel_errors(10.0, 0.0), channel_errors(5.0, 0.0));
    // Measured .0182 and .0090 m; the velocity of the front's last cells is late.
    assert!(coarse.0 < 0.019 && fine.0 < 0.0095, "{coarse:?} to {fine:?}");
    assert!((coarse.0 / fine.0).log2() > 0.95, "{coarse:?} to {fine:?}");
}

#[test]
fn stoker_converges_at_first_order() {
    let (coarse, fine) = (channel_errors(10.0, 5.0), channel_errors(5.0, 5.0));
    assert_below(coarse, (0.0175, 0.0205));
    assert_below(fine, (0.0089, 0.0105));
    assert!((coarse.0 / fine.0).log2() > 0.95 && (coarse.1 / fine.1).log2() > 0.95, "{coarse:?} to {fine:?}");
}

#[test]
fn strong_bore_over_a_thin_layer_converges() {
    let (coarse, fine) = (channel_errors(10.0, 0.1), channel_errors(5.0, 0.1));
    assert!(coarse.0 < 0.023 && fine.0 < 0.0105, "{coarse:?} to {fine:?}");
    assert!((coarse.0 / fine.0).log2() > 0.95, "{coarse:?} to {fine:?}");
}

/// 2.5 m of water within 2.5 m, 0.5 m around it, in a quadrant between walls, at 1.4 s.
#[expect(clippy::unwrap_used, reason = "a failed step is a failed test")]
fn circle_errors(spacing: f64) -> (f64, f64) {
    let cells = (12.0 / spacing).round() as usize;
    let mut problem = problem(cells, cells, spacing, |_| 0.0);
    let lattice = problem.bed.lattice.clone();
    let centres: Vec<Vec2> = (0..lattice.len()).map(|i| lattice.centre(i)).collect();
    problem.initial_depth = centres.iter().map(|place| if place.norm() < 2.5 { 2.5 } else { 0.5 }).collect();
    problem.courant = 0.5;
    let mut solver = EulerianSolver::new(problem);
    run_until(&mut solver, 1.4).unwrap();
    let reference = radial_reference(2.5, 0.5, 2.5, 17.0, 1.4, 2000);
    let exact = |place: Vec2| {
        let (d, u) = reference(place.norm());
        (d, place * (u / place.norm()))
    };
    mean_errors(&mut solver, &centres, exact, |i| centres[i].norm() < 10.0)
}

#[test]
fn circular_dam_break_converges_at_first_order() {
    let (coarse, fine) = (circle_errors(0.2), circle_errors(0.1));
    // Measured .0155/.0742 and .0067/.0306 within 10 m of the centre.
    assert_below(fine, (0.0070, 0.0322));
    assert!((coarse.0 / fine.0).log2() > 1.0 && (coarse.1 / fine.1).log2() > 1.0, "{coarse:?} to {fine:?}");
}
