//! Dams that break across a rough valley: rest before, the same water as without a dam, volumes in the books.

use crate::bed::BedParticles;
use crate::boundary::{Breach, DamCell, GrowthLaw, Opening, PointSource, Series, Trigger};
use crate::lattice::{Lattice, WaterInCell};
use crate::math::Vec2;
use crate::solver::{EulerianSolver, FlowProblem, FlowSolver, Forcing, OpenEdges};

const COLUMNS: usize = 60;
const ROWS: usize = 24;
const SPACING: f64 = 5.0;
/// Column of the dam.
const DAM: usize = 20;
const CREST: f64 = 212.0;
const LEVEL: f64 = 209.3;

const TRAPEZOID: Opening = Opening::Trapezoid { middle: 60.0, bottom_width: 30.0, side_slope: 1.0, invert: 204.5 };

/// A valley that falls to the east at 0.5 %, with banks and bumps.
fn ground(cell: usize) -> f64 {
    let place = lattice().centre(cell);
    let across = (place.y - 60.0) / 60.0;
    let bumps = 0.3 * (0.37 * place.x).sin() * (0.53 * place.y).cos();
    203.0 - 0.005 * place.x + 10.0 * across * across + bumps
}

fn lattice() -> Lattice {
    Lattice { origin: Vec2::new(4e5, 5e6), columns: COLUMNS, rows: ROWS, spacing: SPACING }
}

/// The lake above the dam and the valley below it; without a breach there is no dam.
fn problem(breach: Option<Breach>) -> FlowProblem {
    let lattice = lattice();
    let mut elevation: Vec<f64> = (0..lattice.len()).map(ground).collect();
    let initial_depth = (0..lattice.len())
        .map(|cell| if cell % COLUMNS < DAM { (LEVEL - elevation[cell]).max(0.0) } else { 0.0 })
        .collect();
    for cell in breach.iter().flat_map(|breach| &breach.cells) {
        elevation[cell.cell] = elevation[cell.cell].max(CREST);
    }
    FlowProblem {
        bed: BedParticles::from_elevation(lattice, elevation, 0.03),
        walls: Vec::new(),
        open_edges: OpenEdges::default(),
        forcing: Forcing { breach, ..Forcing::default() },
        initial_depth,
        gravity: 9.81,
        courant: 0.5,
        dry_depth: 1e-3,
    }
}

fn breach(trigger: Trigger, opening: Opening, law: GrowthLaw) -> Breach {
    let cell = |row: usize| DamCell {
        cell: row * COLUMNS + DAM,
        station: (row as f64 + 0.5) * SPACING,
        ground: ground(row * COLUMNS + DAM),
    };
    Breach { cells: (0..ROWS).map(cell).collect(), crest: CREST, trigger, opening, law, duration: 40.0 }
}

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
    let mut solver = EulerianSolver::new(rising);
    let mut before = LEVEL;
    while solver.breach_began().is_none() {
        assert!(before < LEVEL + 0.5 && solver.time() < 600.0);
        let step = solver.choose_step().time_step;
        solver.advance(step).unwrap();
        before = ground(watched) + solver.water().at(watched).depth;
    }
    assert!(before >= LEVEL + 0.5 - 1e-9 && solver.time() > 10.0, "{before} m at {} s", solver.time());
    // Without inflow the level is never reached, and the dam stands.
    let mut still = EulerianSolver::new(problem(Some(opening)));
    run(&mut still, 60.0, |_| {});
    assert_eq!(still.breach_began(), None);
}
