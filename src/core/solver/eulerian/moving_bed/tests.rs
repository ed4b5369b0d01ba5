//! A bed that moves: the surface goes with it, the volume stays, and the wave is that of the linear theory.

use crate::boundary::{BedLaw, BedMotion, Breach, DamCell, GrowthLaw, Opening, Patch, Series, Slide, Trigger};
use crate::math::Vec2;
use crate::solver::changing_bed::scenes::basin::{
    DEPTH, SMALL, above_slide, above_uplift, everywhere, hump, order, problem, slide, uplift,
};
use crate::solver::{EulerianSolver, FlowProblem, FlowSolver};

fn run(solver: &mut EulerianSolver, end: f64) {
    while solver.time() < end {
        let step = solver.choose_step().time_step.min(end - solver.time());
        solver.advance(step).expect("a stable run");
    }
}

/// The surface (m) of each cell.
fn surface(solver: &mut EulerianSolver, problem: &FlowProblem) -> Vec<f64> {
    let mut bed = problem.bed.elevation.clone();
    solver.bed_now().iter().for_each(|(cell, elevation)| bed[*cell] = *elevation);
    solver.water().depths().iter().zip(bed).map(|(depth, bed)| bed + depth).collect()
}

/// The mean error of the surface over the height of the hump, at a time (s) after a start by `motion` of the hump on `columns` cells
/// of a basin of 1600 m.
fn error(columns: usize, end: f64, motion: impl Fn(&FlowProblem) -> BedMotion, exact: impl Fn(f64) -> f64) -> f64 {
    let spacing = 1600.0 / columns as f64;
    let mut problem = problem((columns, 2), spacing, |_| -DEPTH);
    problem.forcing.moving_bed = vec![motion(&problem)];
    let mut solver = EulerianSolver::new(problem.clone());
    run(&mut solver, end);
    let found = surface(&mut solver, &problem);
    let sum: f64 = (0..columns).map(|k| (found[k] / SMALL - exact((k as f64 + 0.5) * spacing - 800.0)).abs()).sum();
    assert!(solver.ledger().relative_error().abs() < 1e-14);
    sum / columns as f64
}

#[test]
fn ground_that_rises_at_once_lifts_the_surface_by_as_much() {
    let bed = |place: Vec2| if place.x < 40.0 { 1.0 } else { -3.0 - 0.01 * place.y };
    let mut problem = problem((30, 20), 5.0, bed);
    let change = |place: Vec2| 0.4 * (-(place - Vec2::new(90.0, 50.0)).norm_squared() / 400.0).exp() - 0.1;
    let cells = everywhere(&problem, change);
    problem.forcing.moving_bed = vec![BedMotion { begin: 0.0, cells: cells.clone(), law: BedLaw::AtOnce }];
    let mut solver = EulerianSolver::new(problem.clone());
    let wet = |cell: usize| problem.initial_depth[cell] > 0.0;
    for (&(_, change), surface) in cells.iter().zip(surface(&mut solver, &problem)).filter(|((cell, _), _)| wet(*cell))
    {
        assert!((surface - change).abs() < 1e-14, "{surface} instead of {change}");
    }
    let before = solver.ledger().initial;
    run(&mut solver, 60.0);
    let (ledger, balance) = (solver.ledger(), solver.bed_balance().unwrap());
    assert!(ledger.relative_error().abs() < 1e-13 && ledger.inflow.abs() <= 0.0 && ledger.outflow.abs() <= 0.0);
    assert!((ledger.stored / before - 1.0).abs() < 1e-13);
    let sum =
        |only: &dyn Fn(usize, f64) -> f64| 25.0 * cells.iter().map(|&(cell, change)| only(cell, change)).sum::<f64>();
    assert!((balance.raised / sum(&|_, change| change.max(0.0)) - 1.0).abs() < 1e-12);
    assert!((balance.sunk / sum(&|_, change| (-change).max(0.0)) - 1.0).abs() < 1e-12);
    let of_wet = |cell: usize, change: f64| if wet(cell) { change.max(0.0) } else { 0.0 };
    assert!((balance.lifted / sum(&of_wet) - 1.0).abs() < 1e-12 && balance.lowered > 0.0);
}

#[test]
fn nothing_moves_before_the_ground_does() {
    let mut problem = problem((30, 4), 5.0, |place| -1.0 - 0.02 * place.x);
    let cells = everywhere(&problem, |place| 0.2 * hump(place.x - 75.0));
    problem.forcing.moving_bed = vec![BedMotion { begin: 12.0, cells, law: BedLaw::AtOnce }];
    let mut solver = EulerianSolver::new(problem.clone());
    let mut is_at_begin = false;
    while solver.time() < 12.0 {
        assert!(surface(&mut solver, &problem).iter().all(|surface| surface.abs() < 1e-14));
        let step = solver.choose_step().time_step;
        solver.advance(step).unwrap();
        is_at_begin |= (solver.time() - 12.0).abs() < 1e-9;
    }
    assert!(is_at_begin && surface(&mut solver, &problem)[15] > 0.15);
    run(&mut solver, 30.0);
    assert!(solver.choose_step().max_speed > 0.01);
}

#[test]
fn a_sudden_uplift_parts_into_two_waves() {
    let end = 30.0;
    let errors = [200, 400, 800].map(|columns| error(columns, end, uplift, |x| above_uplift(x, end)));
    println!("uplift: errors {errors:?}, order {:.2}", order(&errors));
    assert!(errors[2] < 3e-4 && order(&errors) > 1.8, "{errors:?}, order {:.2}", order(&errors));
}

#[test]
fn a_slide_makes_the_waves_of_the_linear_theory() {
    let end = 30.0;
    for froude in [0.4, 1.6] {
        let exact = |x: f64| above_slide(froude, x, end);
        let errors = [200, 400, 800].map(|columns| error(columns, end, |problem| slide(problem, froude), exact));
        println!("slide, Froude number {froude}: errors {errors:?}, order {:.2}", order(&errors));
        assert!(errors[2] < 1e-3 && order(&errors) > 1.5, "Froude {froude}: {errors:?}, order {:.2}", order(&errors));
    }
}

#[test]
fn a_steep_slide_into_a_lake_keeps_every_drop() {
    // A slope runs into a lake; the slide begins on dry ground and ends on its bottom.
    let mut problem = problem((60, 20), 5.0, |place| 12.0 - 0.2 * place.x.min(150.0));
    problem.dry_depth = 1e-3;
    let values: Vec<f64> =
        (0..36).map(|k| if (1..5).contains(&(k % 6)) && (1..5).contains(&(k / 6)) { 4.0 } else { 0.0 }).collect();
    let thickness = Patch { first: Vec2::new(20.0, 37.0), cell: Vec2::new(5.0, 5.0), columns: 6, values };
    let cells = everywhere(&problem, |place| thickness.at(place));
    let path = vec![Vec2::new(30.0, 50.0), Vec2::new(200.0, 55.0)];
    let velocity = Series::new(&[(0.0, 0.0), (3.0, 20.0), (12.0, 0.0)]).unwrap();
    let slide = Slide { thickness, path, velocity };
    let length = slide.distance(100.0);
    problem.forcing.moving_bed = vec![BedMotion { begin: 1.0, cells, law: BedLaw::Slide(slide.clone()) }];
    let mut solver = EulerianSolver::new(problem.clone());
    let (mut highest, mut fastest): (f64, f64) = (0.0, 0.0);
    while solver.time() < 60.0 {
        let choice = solver.choose_step();
        solver.advance(choice.time_step).expect("a stable run");
        highest = surface(&mut solver, &problem)
            .iter()
            .zip(solver.water().depths())
            .filter(|(_, d)| *d > 0.1)
            .map(|(s, _)| *s)
            .fold(highest, f64::max);
        fastest = fastest.max(choice.max_speed);
        assert!(
            solver.ledger().relative_error().abs() < 1e-13 && solver.water().depths().iter().all(|depth| *depth >= 0.0)
        );
    }
    assert!((1.0..12.0).contains(&highest) && (2.0..30.0).contains(&fastest), "{highest} m, {fastest} m/s");
    // The slide lies where it came to rest; what lay on the slope is gone there.
    let balance = solver.bed_balance().unwrap();
    let offset = slide.offset(length);
    let change = |cell: &(usize, f64)| {
        let centre = problem.bed.lattice.centre(cell.0);
        slide.thickness.at(centre - offset) - slide.thickness.at(centre)
    };
    let (mut up, mut down) = (0.0, 0.0);
    for cell in &problem.forcing.moving_bed[0].cells {
        up += 25.0 * change(cell).max(0.0);
        down -= 25.0 * change(cell).min(0.0);
    }
    assert!((balance.raised / up - 1.0).abs() < 1e-12 && (balance.sunk / down - 1.0).abs() < 1e-12, "{balance:?}");
    assert!((up / down - 1.0).abs() < 1e-2 && balance.lifted > 0.9 * up, "{balance:?}");
}

#[test]
fn a_dam_and_a_slide_are_both_handed_out() {
    let mut problem = problem((20, 3), 5.0, |_| -2.0);
    let dam = |row: usize| DamCell { cell: row * 20 + 5, station: 5.0 * row as f64, reach: 2.5, ground: -2.0 };
    problem.forcing.breach = Some(Breach {
        cells: (0..3).map(dam).collect(),
        rim: Vec::new(),
        crest: 1.0,
        trigger: Trigger::At(5.0),
        opening: Opening::Whole,
        law: GrowthLaw::Instantaneous,
        duration: 1.0,
    });
    for row in 0..3 {
        problem.bed.elevation[row * 20 + 5] = 1.0;
        problem.initial_depth[row * 20 + 5] = 0.0;
    }
    problem.forcing.moving_bed = vec![BedMotion { begin: 2.0, cells: vec![(12, 0.5)], law: BedLaw::AtOnce }];
    let mut solver = EulerianSolver::new(problem);
    run(&mut solver, 3.0);
    assert_eq!(solver.bed_now(), [(5, 1.0), (25, 1.0), (45, 1.0), (12, -1.5)]);
    run(&mut solver, 6.0);
    assert_eq!(solver.bed_now(), [(5, -2.0), (25, -2.0), (45, -2.0), (12, -1.5)]);
    assert!(solver.ledger().relative_error().abs() < 1e-13);
}
