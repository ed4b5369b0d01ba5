//! Dams that break across a rough valley: rest before, the same water as without a dam, the volume balance.

use crate::boundary::{Breach, GrowthLaw, Opening, PointSource, Series, Trigger};
use crate::lattice::WaterInCell;
use crate::math::Vec2;
use crate::solver::changing_bed::scenes::valley::{
    COLUMNS, CREST, DAM, LEVEL, ROWS, SPACING, TRAPEZOID, breach, ground, lattice, problem,
};
use crate::solver::{EulerianMethods, EulerianSolver, FlowSolver};

fn run(solver: &mut EulerianSolver, end: f64, mut at_each_step: impl FnMut(&mut EulerianSolver)) {
    while solver.time() < end {
        let step = solver.choose_step().time_step.min(end - solver.time());
        solver.advance(step).expect("a stable run");
        at_each_step(solver);
    }
}

#[test]
fn the_lake_rests_until_the_trigger_and_not_after_it() {
    let mut solver = EulerianSolver::new(problem(Some(breach(Trigger::At(60.0), TRAPEZOID, GrowthLaw::Sine))));
    let mut fastest: f64 = 0.0;
    run(&mut solver, 60.0, |solver| fastest = fastest.max(solver.choose_step().max_speed));
    assert!(fastest <= 1e-12, "{fastest:e} m/s");
    assert_eq!(solver.breach_began(), Some(60.0));
    run(&mut solver, 120.0, |solver| {
        let error = solver.ledger().relative_error().abs();
        assert!(error <= 1e-12, "ledger {error:e}");
    });
    assert!(solver.choose_step().max_speed > 1.0);
    let depths = solver.water().depths();
    let wet_below = depths.iter().enumerate().filter(|(cell, d)| cell % COLUMNS > DAM && **d > 0.1);
    assert!(wet_below.count() > 50);
}

#[test]
fn a_whole_dam_that_goes_at_the_start_leaves_the_bits_of_the_run_without_it() {
    let mut with =
        EulerianSolver::new(problem(Some(breach(Trigger::At(0.0), Opening::Whole, GrowthLaw::Instantaneous))));
    let mut without = EulerianSolver::new(problem(None));
    run(&mut with, 30.0, |_| {});
    run(&mut without, 30.0, |_| {});
    assert_eq!(with.steps(), without.steps());
    let bits = |solver: &mut EulerianSolver| -> Vec<[u64; 3]> {
        let bits = |cell: WaterInCell| [cell.depth, cell.discharge_x, cell.discharge_y].map(f64::to_bits);
        solver.water().cells().map(bits).collect()
    };
    assert!(bits(&mut with) == bits(&mut without));
}

#[test]
fn growth_within_a_step_is_the_dam_gone_at_once() {
    let end = |law: GrowthLaw, duration: f64| {
        let breach = Breach { duration, ..breach(Trigger::At(0.0), Opening::Whole, law) };
        let mut solver = EulerianSolver::new(problem(Some(breach)));
        run(&mut solver, 30.0, |_| {});
        solver.water().depths()
    };
    let at_once = end(GrowthLaw::Instantaneous, 1.0);
    for law in [GrowthLaw::Linear, GrowthLaw::Sine] {
        let grown = end(law, 1e-3);
        let off = grown.iter().zip(&at_once).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{off:e} m");
        assert!(off < 1e-2, "{off} m");
    }
}

#[test]
fn a_straight_series_of_shares_gives_the_run_of_the_linear_law() {
    let series = Series::new(&[(0.0, 0.0), (40.0, 1.0)]).unwrap();
    let [by_series, by_law] = [GrowthLaw::Series(series), GrowthLaw::Linear].map(|law| {
        let mut solver = EulerianSolver::new(problem(Some(breach(Trigger::At(3.0), TRAPEZOID, law))));
        run(&mut solver, 60.0, |_| {});
        solver.water().depths().iter().map(|depth| depth.to_bits()).collect::<Vec<u64>>()
    });
    assert!(by_series == by_law);
}

#[test]
fn what_passes_the_opening_is_what_the_reservoir_loses() {
    let opening = breach(Trigger::At(3.0), TRAPEZOID, GrowthLaw::Linear);
    let mut problem = problem(Some(opening));
    // Between the dam and the reservoir, so that the water on the dam counts as passed; to the left of the line lies the east.
    let x = DAM as f64 * SPACING;
    problem.forcing.sections = vec![vec![[Vec2::new(x, ROWS as f64 * SPACING), Vec2::new(x, 0.0)]]];
    let reservoir = |solver: &mut EulerianSolver| -> f64 {
        let depth = solver.water().depths();
        let cells = (0..COLUMNS * ROWS).filter(|cell| cell % COLUMNS < DAM);
        cells.map(|cell| depth[cell]).sum::<f64>() * SPACING * SPACING
    };
    let mut solver = EulerianSolver::new(problem);
    let before = reservoir(&mut solver);
    run(&mut solver, 150.0, |_| {});
    let (after, passed) = (reservoir(&mut solver), solver.sections()[0].volume);
    assert!(passed > 0.2 * before, "{passed} of {before} m3");
    assert!((before - after - passed).abs() <= 1e-9 * passed, "{:e}", (before - after) / passed - 1.0);
}

#[test]
fn the_bed_ends_at_the_trapezoid() {
    let opening = breach(Trigger::At(1.0), TRAPEZOID, GrowthLaw::Sine);
    let mut solver = EulerianSolver::new(problem(Some(opening.clone())));
    let mut last = solver.bed_now().to_vec();
    assert!(last.iter().zip(&opening.cells).all(|(bed, cell)| bed.1 <= CREST.max(cell.ground)));
    run(&mut solver, 45.0, |solver| {
        assert!(solver.bed_now().iter().zip(&last).all(|(now, before)| now.1 <= before.1));
        last = solver.bed_now().to_vec();
    });
    for (bed, cell) in last.iter().zip(&opening.cells) {
        assert_eq!(bed.1.to_bits(), opening.bed(cell, 1.0).to_bits());
    }
    assert!(last.iter().filter(|bed| bed.1 < CREST - 7.0).count() >= 6);
}

#[test]
fn a_level_opens_the_dam_when_it_is_reached() {
    let place = Vec2::new(0.6 * DAM as f64 * SPACING, 60.0);
    let trigger = Trigger::Level { level: LEVEL + 0.5, place };
    let opening = breach(trigger, TRAPEZOID, GrowthLaw::Linear);
    let mut rising = problem(Some(opening.clone()));
    rising.forcing.sources = vec![PointSource { place: Vec2::new(20.0, 60.0), discharge: Series::constant(60.0) }];
    let watched = lattice().cell_at(place).unwrap();
    for moves in [false, true] {
        let methods = EulerianMethods { moves, ..EulerianMethods::default() };
        let mut solver = EulerianSolver::with_methods(rising.clone(), methods);
        assert_eq!(solver.has_moving(), moves);
        let mut before = LEVEL;
        while solver.breach_began().is_none() {
            assert!(before < LEVEL + 0.5 && solver.time() < 600.0);
            let step = solver.choose_step().time_step;
            solver.advance(step).unwrap();
            before = ground(watched) + solver.water().at(watched).depth;
        }
        assert!(before >= LEVEL + 0.5 - 1e-9 && solver.time() > 10.0, "{before} m at {} s", solver.time());
    }
    // Without inflow the level is never reached, and the dam stands.
    let mut still = EulerianSolver::new(problem(Some(opening)));
    run(&mut still, 60.0, |_| {});
    assert_eq!(still.breach_began(), None);
}
