//! Rain and sources beside boundaries.

use super::*;

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
