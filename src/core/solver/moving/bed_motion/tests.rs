//! Beds that change under moving particles: the scenes of the resting ones.

use crate::boundary::{
    BedLaw, BedMotion, Breach, DamCell, GrowthLaw, Opening, Patch, PointSource, Rain, Series, Slide, Trigger,
};
use crate::math::Vec2;
use crate::methods::{Integrator, Stabilisation, WallMethod};
use crate::physics::dimension::Dimension;
use crate::solver::changing_bed::scenes::{basin, valley};
use crate::solver::lagrangian::LagrangianSolver;
use crate::solver::moving::MovingMethods;
use crate::solver::moving::scene::seeds;
use crate::solver::{EulerianSolver, FlowProblem, FlowSolver};

/// One particle on each wet cell, and the Courant number of the integrator.
fn solver_by(problem: FlowProblem, dimension: Dimension, integrator: Integrator) -> LagrangianSolver {
    solver_with(problem, dimension, MovingMethods::new(integrator, Stabilisation::TwoShocks))
}

fn solver_with(problem: FlowProblem, dimension: Dimension, methods: MovingMethods) -> LagrangianSolver {
    let seeds = seeds(&problem, dimension);
    let courant = LagrangianSolver::default_courant(methods.integrator);
    LagrangianSolver::with_methods(FlowProblem { courant, ..problem }, seeds, methods, dimension)
}

fn solver(problem: FlowProblem) -> LagrangianSolver {
    solver_by(problem, Dimension::Two, Integrator::Leapfrog)
}

/// The valley with the dam of a breach, its slopes derived.
fn valley(breach: Option<Breach>) -> FlowProblem {
    let mut problem = valley::problem(breach);
    problem.bed.is_sloped = true;
    problem
}

fn run(solver: &mut impl FlowSolver, end: f64, mut at_each_step: impl FnMut(&mut dyn FlowSolver)) {
    while solver.time() < end {
        let step = solver.choose_step().time_step.min(end - solver.time());
        solver.advance(step).expect("a stable run");
        at_each_step(solver);
    }
}

/// Volume (m³) of the particles east of a place (m).
fn beyond(solver: &LagrangianSolver, x: f64) -> f64 {
    let particles = &solver.state().particles;
    particles.position.iter().zip(&particles.volume).filter(|(p, _)| p.x > x).map(|(_, volume)| volume).sum()
}

/// The line of the dam (m).
const LINE: f64 = (valley::DAM as f64 + 0.5) * valley::SPACING;

/// A dam with a crest (m) so many cells thick.
fn thick_dam(mut breach: Breach, crest: f64, thickness: usize) -> FlowProblem {
    let cells = breach.cells.clone();
    for beside in 1..thickness {
        breach.cells.extend(cells.iter().map(|cell| {
            let cell = DamCell { cell: cell.cell + beside, ..*cell };
            DamCell { ground: valley::ground(cell.cell), ..cell }
        }));
    }
    breach.crest = crest;
    let mut problem = valley::problem(Some(breach.clone()));
    for cell in &breach.cells {
        problem.bed.elevation[cell.cell] = breach.bed(cell, 0.0);
    }
    problem.bed.is_sloped = true;
    problem
}

/// Cells east of the dam that have water on the grid.
fn wet_beyond(solver: &mut LagrangianSolver, thickness: usize) -> usize {
    let depths = solver.water().depths();
    let is_beyond = |cell: usize| cell % valley::COLUMNS >= valley::DAM + thickness;
    (0..depths.len()).filter(|&cell| is_beyond(cell) && depths[cell] > 0.0).count()
}

#[test]
fn the_lake_rests_until_the_trigger_and_not_after_it() {
    let breach = valley::breach(Trigger::At(60.0), valley::TRAPEZOID, GrowthLaw::Sine);
    for (wall, crest, thickness) in [
        (WallMethod::Mirror, valley::CREST, 1),
        (WallMethod::Mirror, valley::LEVEL + 0.02, 1),
        (WallMethod::Mirror, valley::CREST, 2),
        (WallMethod::VirtualParticles, valley::CREST, 1),
    ] {
        let methods = MovingMethods { wall, ..MovingMethods::new(Integrator::Leapfrog, Stabilisation::TwoShocks) };
        let mut solver = solver_with(thick_dam(breach.clone(), crest, thickness), Dimension::Two, methods);
        let mut fastest: f64 = 0.0;
        run(&mut solver, 60.0, |solver| fastest = fastest.max(solver.choose_step().max_speed));
        println!("{wall:?}, crest {crest} m, {thickness} cells: fastest before the trigger {fastest:e} m/s");
        assert!(fastest <= 1e-12, "{wall:?}, crest {crest} m, {thickness} cells: {fastest:e} m/s");
        assert_eq!(solver.breach_began(), Some(60.0));
        assert!(beyond(&solver, LINE).abs() <= 0.0);
        assert_eq!(wet_beyond(&mut solver, thickness), 0, "the grid has water beyond a dam that stands");
        run(&mut solver, 120.0, |solver| {
            let error = solver.ledger().relative_error().abs();
            assert!(error <= 1e-12, "ledger {error:e}");
        });
        assert!(solver.choose_step().max_speed > 1.0);
        assert!(wet_beyond(&mut solver, thickness) > 50);
    }
}

#[test]
fn rain_on_the_crest_opens_no_wall() {
    let breach = valley::breach(Trigger::At(120.0), Opening::Whole, GrowthLaw::Instantaneous);
    let crest = breach.cells[breach.cells.len() / 2].cell;
    let mut problem = valley(Some(breach));
    let cells = problem.bed.lattice.len();
    let rate = (0..cells).map(|cell| if cell == crest { 1e-4 } else { 0.0 }).collect();
    problem.forcing.rain = Some(Rain::Map { rate, from: vec![0.0; cells], until: 1e6 });
    let mut solver = solver(problem);
    let walls = solver.state().walls.edges().len();
    run(&mut solver, 100.0, |_| {});
    assert!(solver.ledger().inflow > 0.0 && solver.ledger().relative_error().abs() < 1e-12);
    assert_eq!(solver.state().walls.edges().len(), walls, "the dam is a wall no more");
}

#[test]
fn waves_on_the_lake_do_not_pass_a_dam_that_stands() {
    for (level_below, thickness) in [(None, 1), (None, 2), (Some(206.0), 1)] {
        let breach = valley::breach(Trigger::At(1e9), Opening::Whole, GrowthLaw::Instantaneous);
        let mut problem = thick_dam(breach, valley::CREST, thickness);
        if let Some(level) = level_below {
            for cell in (0..problem.bed.lattice.len()).filter(|cell| cell % valley::COLUMNS > valley::DAM) {
                problem.initial_depth[cell] = (level - problem.bed.elevation[cell]).max(0.0);
            }
        }
        let mut solver = solver(problem);
        let below = beyond(&solver, LINE);
        let particles = &mut solver.state_mut().particles;
        for (place, velocity) in particles.position.iter().zip(&mut particles.velocity) {
            if place.x < LINE && place.x > 0.5 * LINE {
                *velocity = Vec2::new(1.5, 0.0);
            }
        }
        solver.restart();
        let mut fastest: f64 = 0.0;
        run(&mut solver, 60.0, |solver| fastest = fastest.max(solver.choose_step().max_speed));
        println!("{thickness} cells: beyond the dam {} m3, before {below} m3, {fastest} m/s", beyond(&solver, LINE));
        assert!((beyond(&solver, LINE) - below).abs() <= 1e-9 * below, "{} m3", beyond(&solver, LINE));
        if level_below.is_none() {
            assert_eq!(wet_beyond(&mut solver, thickness), 0);
        }
    }
}

#[test]
fn a_whole_dam_that_goes_at_the_start_leaves_the_bits_of_the_run_without_it() {
    let breach = valley::breach(Trigger::At(0.0), Opening::Whole, GrowthLaw::Instantaneous);
    let [mut with, mut without] = [Some(breach), None].map(|breach| solver(valley(breach)));
    run(&mut with, 30.0, |_| {});
    run(&mut without, 30.0, |_| {});
    assert_eq!(with.steps(), without.steps());
    let bits = |solver: &LagrangianSolver| -> Vec<[u64; 3]> {
        let p = &solver.state().particles;
        (0..p.len()).map(|i| [p.position[i].x, p.velocity[i].y, p.depth[i]].map(f64::to_bits)).collect()
    };
    assert!(bits(&with) == bits(&without));
}

#[test]
fn what_passes_the_opening_is_what_the_reservoir_loses() {
    for (opening, law) in [(valley::TRAPEZOID, GrowthLaw::Linear), (Opening::Whole, GrowthLaw::Instantaneous)] {
        let problem = valley(Some(valley::breach(Trigger::At(3.0), opening, law.clone())));
        let mut resting = EulerianSolver::new(problem.clone());
        let mut moving = solver(problem);
        let before = moving.ledger().stored;
        let mut of_resting = 0.0;
        for time in [10.0, 20.0, 30.0, 45.0, 60.0, 90.0, 150.0] {
            run(&mut moving, time, |_| {});
            run(&mut resting, time, |_| {});
            let depths = resting.water().depths();
            of_resting = (0..depths.len())
                .filter(|cell| cell % valley::COLUMNS > valley::DAM)
                .map(|cell| depths[cell] * valley::SPACING * valley::SPACING)
                .sum::<f64>();
            println!(
                "{law:?} {time} s: beyond the dam {:.0} m3, of resting particles {of_resting:.0} m3",
                beyond(&moving, LINE)
            );
        }
        let passed = beyond(&moving, LINE);
        let lost = before - (moving.ledger().stored - passed);
        assert!(passed > 0.2 * before, "{passed} of {before} m3");
        assert!((lost - passed).abs() <= 1e-9 * passed, "{:e}", lost / passed - 1.0);
        assert!((passed / of_resting - 1.0).abs() < 0.15, "{passed} m3, resting {of_resting} m3");
    }
}

#[test]
fn a_level_opens_the_dam_when_it_is_reached() {
    let place = Vec2::new(0.6 * valley::DAM as f64 * valley::SPACING, 60.0);
    let trigger = Trigger::Level { level: valley::LEVEL + 0.5, place };
    let breach = valley::breach(trigger, valley::TRAPEZOID, GrowthLaw::Linear);
    let mut rising = valley(Some(breach.clone()));
    rising.forcing.sources = vec![PointSource { place: Vec2::new(20.0, 60.0), discharge: Series::constant(60.0) }];
    let [mut resting, mut moving]: [Box<dyn FlowSolver>; 2] =
        [Box::new(EulerianSolver::new(rising.clone())), Box::new(solver(rising))];
    let mut began = [0.0; 2];
    for (solver, began) in [&mut resting, &mut moving].into_iter().zip(&mut began) {
        while solver.breach_began().is_none() {
            assert!(solver.time() < 600.0);
            let step = solver.choose_step().time_step;
            solver.advance(step).unwrap();
        }
        *began = solver.breach_began().unwrap();
    }
    println!("the level is reached at {began:?} s, resting and moving");
    assert!((began[1] / began[0] - 1.0).abs() < 0.15, "{began:?}");
    // Without inflow the level is never reached, and the dam stands.
    let mut still = solver(valley(Some(breach)));
    run(&mut still, 60.0, |_| {});
    assert_eq!(still.breach_began(), None);
}

#[test]
fn a_lake_that_is_lifted_as_a_whole_stays_at_rest() {
    for (datum, law) in [
        (0.0, BedLaw::Share(Series::new(&[(0.0, 0.0), (5.0, 0.3), (20.0, 1.0)]).unwrap())),
        (0.0, BedLaw::AtOnce),
        (1234.0, BedLaw::Share(Series::new(&[(0.0, 0.0), (20.0, 1.0)]).unwrap())),
    ] {
        let bumps = |place: Vec2| 0.4 * (0.31 * place.x).sin() * (0.2 * place.y).cos();
        let bed = |place: Vec2| 2.0 - 0.1 * place.x.min(80.0) - bumps(place);
        let mut problem = basin::problem((30, 20), 5.0, bed);
        problem.bed.elevation.iter_mut().for_each(|bed| *bed += datum);
        let cells = basin::everywhere(&problem, |_| 2.5);
        problem.forcing.moving_bed = vec![BedMotion { begin: 1.0, cells, law: law.clone() }];
        let wet = problem.initial_depth.iter().filter(|depth| **depth > 1e-3).count();
        let mut solver = solver(problem);
        let mut fastest: f64 = 0.0;
        run(&mut solver, 30.0, |solver| fastest = fastest.max(solver.choose_step().max_speed));
        let books = solver.bed_balance().unwrap();
        println!("{law:?}: {fastest:e} m/s, {books:?}");
        assert!(fastest < 1e-12, "{law:?}: {fastest:e} m/s");
        assert!((books.raised / (600.0 * 25.0 * 2.5) - 1.0).abs() < 1e-12 && books.sunk.abs() <= 0.0);
        assert!((books.lifted / (wet as f64 * 25.0 * 2.5) - 1.0).abs() < 1e-9 && books.lowered.abs() <= 0.0);
        assert!(solver.ledger().relative_error().abs() < 1e-14);
    }
}

/// The mean error of the surface over the height of the hump, at a time (s) after a start by `motion` on `columns` particles.
fn error(
    (columns, integrator): (usize, Integrator),
    end: f64,
    motion: impl Fn(&FlowProblem) -> BedMotion,
    exact: impl Fn(f64) -> f64,
) -> f64 {
    let mut problem = basin::problem((columns, 1), 1600.0 / columns as f64, |_| -basin::DEPTH);
    problem.forcing.moving_bed = vec![motion(&problem)];
    let mut solver = solver_by(problem, Dimension::One, integrator);
    run(&mut solver, end, |_| {});
    let (particles, bed) = (&solver.state().particles, &solver.state().bed);
    let error = |i: usize| {
        let place = particles.position[i];
        let surface = bed.at(place).unwrap().elevation + particles.depth[i];
        (surface / basin::SMALL - exact(place.x - 800.0)).abs()
    };
    assert!(solver.ledger().relative_error().abs() < 1e-14);
    (0..particles.len()).map(error).sum::<f64>() / particles.len() as f64
}

#[test]
fn waves_over_a_moving_bed_are_those_of_the_linear_theory() {
    let end = 30.0;
    for integrator in [Integrator::Leapfrog, Integrator::Heun] {
        let sizes = [200, 400, 800].map(|columns| (columns, integrator));
        let uplift = sizes.map(|size| error(size, end, basin::uplift, |x| basin::above_uplift(x, end)));
        println!("{integrator:?}, uplift: errors {uplift:?}, order {:.2}", basin::order(&uplift));
        assert!(uplift[2] < 1e-3 && basin::order(&uplift) > 1.5, "{uplift:?}");
        for froude in [0.4, 1.6] {
            let exact = |x: f64| basin::above_slide(froude, x, end);
            let slide = sizes.map(|size| error(size, end, |problem| basin::slide(problem, froude), exact));
            println!(
                "{integrator:?}, slide, Froude number {froude}: errors {slide:?}, order {:.2}",
                basin::order(&slide)
            );
            assert!(slide[2] < 3e-3 && basin::order(&slide) > 1.5, "{slide:?}");
        }
    }
}

#[test]
fn a_steep_slide_into_a_lake_keeps_every_drop() {
    // A slope runs into a lake; the slide begins on dry ground and ends on its bottom.
    let mut problem = basin::problem((60, 20), 5.0, |place| 12.0 - 0.2 * place.x.min(150.0));
    problem.dry_depth = 1e-3;
    let values: Vec<f64> =
        (0..36).map(|k| if (1..5).contains(&(k % 6)) && (1..5).contains(&(k / 6)) { 4.0 } else { 0.0 }).collect();
    let thickness = Patch { first: Vec2::new(20.0, 37.0), cell: Vec2::new(5.0, 5.0), columns: 6, values };
    let cells = basin::everywhere(&problem, |place| thickness.at(place));
    let path = vec![Vec2::new(30.0, 50.0), Vec2::new(200.0, 55.0)];
    let velocity = Series::new(&[(0.0, 0.0), (3.0, 20.0), (12.0, 0.0)]).unwrap();
    let slide = Slide { thickness, path, velocity };
    problem.forcing.moving_bed = vec![BedMotion { begin: 1.0, cells, law: BedLaw::Slide(slide) }];
    let mut resting = EulerianSolver::new(problem.clone());
    run(&mut resting, 60.0, |_| {});
    let mut moving = solver(problem);
    let mut fastest: f64 = 0.0;
    run(&mut moving, 60.0, |solver| {
        fastest = fastest.max(solver.choose_step().max_speed);
        assert!(solver.ledger().relative_error().abs() < 1e-13);
    });
    let [of_resting, of_moving] = [resting.bed_balance().unwrap(), moving.bed_balance().unwrap()];
    println!("slide: resting {of_resting:?}, moving {of_moving:?}, fastest {fastest} m/s");
    assert!(
        (of_moving.raised / of_resting.raised - 1.0).abs() < 1e-12 && (2.0..30.0).contains(&fastest),
        "{fastest} m/s"
    );
    assert!((of_moving.lifted / of_resting.lifted - 1.0).abs() < 0.1, "{of_moving:?}, resting {of_resting:?}");
    assert_eq!(resting.bed_now(), moving.bed_now());
}

#[test]
fn a_step_ends_where_the_ground_begins_to_move_and_resolves_a_slide() {
    let mut problem = basin::problem((40, 4), 5.0, |_| -1.0);
    let slide = basin::slide(&problem, 30.0);
    problem.forcing.moving_bed = vec![BedMotion { begin: 2.0, ..slide }];
    let speed = 30.0 * (basin::GRAVITY * basin::DEPTH).sqrt();
    let mut solver = solver(problem);
    let mut is_at_begin = false;
    while solver.time() < 2.5 {
        let step = solver.choose_step().time_step;
        if solver.time() >= 2.0 {
            assert!(step * speed <= 0.4 * 5.0 * (1.0 + 1e-12), "{step} s");
        }
        solver.advance(step).unwrap();
        is_at_begin |= (solver.time() - 2.0).abs() < 1e-9;
    }
    assert!(is_at_begin);
}

#[test]
fn a_dam_and_ground_that_moves_are_both_handed_out() {
    let breach = valley::breach(Trigger::At(5.0), Opening::Whole, GrowthLaw::Instantaneous);
    let mut problem = valley(Some(breach.clone()));
    let (lake, ground) = (5 + 12 * valley::COLUMNS, valley::ground(5 + 12 * valley::COLUMNS));
    problem.forcing.moving_bed = vec![BedMotion { begin: 2.0, cells: vec![(lake, 0.5)], law: BedLaw::AtOnce }];
    let mut solver = solver(problem);
    let bed = |share: f64, lift: f64| -> Vec<(usize, f64)> {
        let dam = breach.cells.iter().map(|cell| (cell.cell, breach.bed(cell, share)));
        dam.chain([(lake, ground + lift)]).collect()
    };
    assert_eq!(solver.bed_now(), bed(0.0, 0.0));
    run(&mut solver, 3.0, |_| {});
    assert_eq!(solver.bed_now(), bed(0.0, 0.5));
    run(&mut solver, 6.0, |_| {});
    assert_eq!(solver.bed_now(), bed(1.0, 0.5));
    assert!(solver.bed_now().iter().all(|&(cell, bed)| solver.state().bed.elevation[cell].to_bits() == bed.to_bits()));
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let breach = valley::breach(Trigger::At(2.0), valley::TRAPEZOID, GrowthLaw::Linear);
            let mut problem = valley(Some(breach));
            let cells = basin::everywhere(&problem, |place| 0.01 * (place.x - 150.0).abs().sqrt());
            let share = Series::new(&[(0.0, 0.0), (20.0, 1.0)]).unwrap();
            problem.forcing.moving_bed = vec![BedMotion {
                begin: 1.0,
                cells: cells.into_iter().filter(|(cell, _)| cell % valley::COLUMNS < 10).collect(),
                law: BedLaw::Share(share),
            }];
            let mut solver = solver(problem);
            run(&mut solver, 30.0, |_| {});
            let books = solver.bed_balance().unwrap();
            let p = &solver.state().particles;
            let state = (0..p.len()).flat_map(|i| [p.position[i].x, p.velocity[i].y, p.depth[i]]);
            state.chain([books.lifted, books.raised]).map(f64::to_bits).collect::<Vec<u64>>()
        })
    };
    assert!(bits(1) == bits(3));
}
