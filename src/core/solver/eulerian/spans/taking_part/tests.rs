//! Cells that take no part change nothing: a run is the same to the last bit with all of the rim about its water.

use super::super::ActiveSet;
use crate::boundary::{BedLaw, BedMotion, Boundary, Condition, GrowthLaw, PointSource, Series, Trigger};
use crate::lattice::{Lattice, Nest};
use crate::math::Vec2;
use crate::methods::{Reconstruction, Stabilisation, Turbulence};
use crate::partition::{Line, LineKind, Partition};
use crate::solver::changing_bed::scenes::valley::{self, TRAPEZOID, breach};
use crate::solver::eulerian::tests::{bits, noise, problem};
use crate::solver::eulerian::{EulerianMethods, EulerianSolver};
use crate::solver::testing::run_steps;
use crate::solver::{FlowProblem, FlowSolver, OpenEdges, nested};

impl ActiveSet {
    /// Keeps all cells of the rim.
    fn keep_all(&mut self) {
        for (kept, bounds) in self.kept.iter_mut().zip(&self.bounds) {
            *kept = bounds.iter().map(|[_, columns]| columns.clone()).collect();
        }
    }
}

/// Runs a problem with and without the rim.
fn compare(name: &str, problem: &FlowProblem, methods: EulerianMethods) {
    let new = || EulerianSolver::with_methods(problem.clone(), methods);
    let (mut one, mut other) = (new(), new());
    other.active.keep_all();
    for steps in [1, 2, 20, 100, 200] {
        run_steps(&mut one, steps);
        run_steps(&mut other, steps);
        assert!(bits(&mut one) == bits(&mut other), "{name}, {steps} steps");
    }
    assert_eq!(one.left_over_edges.to_bits(), other.left_over_edges.to_bits(), "{name}");
    assert!(one.ledger().relative_error().abs() < 1e-12, "{name}: {:e}", one.ledger().relative_error());
    let left = one.evaluations as f64 / other.evaluations as f64;
    println!("{name}: {left:.2} of the evaluations");
    assert!(left < 0.95, "{name}: {left:.2} of the evaluations");
}

/// Ground (m) of a rough valley that winds and falls to the east.
fn ground(place: Vec2) -> f64 {
    let off = (place.y - 40.0 - 8.0 * (place.x / 17.0).sin()).abs();
    (off - 6.0).max(0.0) * 0.5 - 0.03 * place.x + 0.4 * noise(place.x as usize * 997 + place.y as usize)
}

/// A lattice of some cells (m) in the valley, with water in its west.
fn in_valley(columns: usize, rows: usize, spacing: f64) -> FlowProblem {
    let lattice = Lattice::new(Vec2::ZERO, columns, rows, spacing);
    let elevation: Vec<f64> = (0..lattice.len()).map(|cell| ground(lattice.centre(cell))).collect();
    let is_lake = |cell: usize| lattice.centre(cell).x < 40.0;
    let depth = |cell: usize| if is_lake(cell) { (5.0 - elevation[cell]).max(0.0) } else { 0.0 };
    let depths = (0..lattice.len()).map(depth).collect();
    let mut problem = problem(lattice, elevation, depths);
    problem.bed.manning.fill(0.03);
    // Films that count.
    problem.dry_depth = 1e-3;
    problem
}

/// The valley with a wall askew, a hole, an open side and a spring.
fn valley_with_all() -> FlowProblem {
    let mut problem = in_valley(120, 80, 1.0);
    problem.walls = vec![[Vec2::new(50.3, 30.0), Vec2::new(61.7, 45.2)]];
    let is_hole = |place: Vec2| (place - Vec2::new(75.0, 34.0)).norm() < 3.5;
    for cell in 0..problem.bed.lattice.len() {
        if is_hole(problem.bed.lattice.centre(cell)) {
            problem.bed.elevation[cell] = f64::NAN;
        }
    }
    let east = [Vec2::new(120.0, 0.0), Vec2::new(120.0, 80.0)];
    problem.open_edges = OpenEdges { pieces: vec![east].into(), reach: 0.6, outline: None };
    let discharge = Series::new(&[(0.0, 2.0), (60.0, 2.0)]).expect("a series");
    problem.forcing.sources.push(PointSource { place: Vec2::new(95.0, 70.0), discharge });
    problem
}

/// The valley on three levels.
fn valley_on_levels() -> FlowProblem {
    let nest = Nest::graded((128, 80), 1.0, 16, 2, |column, _| usize::from(column < 3) * 2);
    let levels = nest.levels().iter().map(|of| in_valley(of.columns, of.rows, of.spacing)).collect();
    nested(levels, nest)
}

#[test]
fn the_rim_counts_for_nothing_on_one_lattice() {
    let problem = valley_with_all();
    let usual = EulerianMethods::default();
    let of = |flux: Stabilisation, reconstruction: Reconstruction| EulerianMethods { flux, reconstruction, ..usual };
    for (name, methods) in [
        ("usual", usual),
        ("sharp", of(usual.flux, Reconstruction::Sharp)),
        ("without reconstruction", of(usual.flux, Reconstruction::None)),
        ("Lax-Friedrichs", of(Stabilisation::LaxFriedrichs, usual.reconstruction)),
        ("turbulence", EulerianMethods { turbulence: Turbulence::MixingLength, ..usual }),
        ("asleep", EulerianMethods { sleeps: true, ..usual }),
    ] {
        compare(name, &problem, methods);
    }
}

#[test]
fn the_rim_counts_for_nothing_beside_boundaries_and_ground_that_moves() {
    let mut problem = in_valley(120, 80, 1.0);
    let side = |x: f64| vec![[Vec2::new(x, 20.0), Vec2::new(x, 60.0)]].into();
    let rising = Series::new(&[(0.0, 5.0), (5.0, 6.0)]).expect("a series");
    problem.forcing.boundaries = vec![
        Boundary { pieces: side(0.0), condition: Condition::Stage(rising) },
        Boundary { pieces: side(120.0), condition: Condition::Free },
    ];
    problem.forcing.reach = 0.3;
    compare("boundaries", &problem, EulerianMethods::default());

    // Dry ground in the way of the water sinks by two metres, and ground under the lake rises.
    let mut problem = in_valley(120, 80, 1.0);
    let lattice = problem.bed.lattice.clone();
    let change = |place: Vec2| match place.x {
        20.0..30.0 => 0.5,
        45.0..60.0 => -2.0,
        _ => 0.0,
    };
    let cells = (0..lattice.len()).map(|cell| (cell, change(lattice.centre(cell)))).collect();
    problem.forcing.moving_bed = vec![BedMotion { begin: 1.0, cells, law: BedLaw::AtOnce }];
    compare("ground that moves", &problem, EulerianMethods::default());
}

#[test]
fn what_a_recorder_looks_at_holds_all_that_changes() {
    let methods = EulerianMethods { sleeps: true, ..EulerianMethods::default() };
    for (name, problem) in [("one lattice", valley_with_all()), ("levels", valley_on_levels())] {
        let mut solver = EulerianSolver::with_methods(problem, methods);
        for step in 0..150 {
            let before = bits(&mut solver);
            run_steps(&mut solver, 1);
            let after = bits(&mut solver);
            let water = solver.water();
            let mut is_seen = vec![false; after.len()];
            for span in water.spans {
                let first = span.row as usize * water.lattice.columns;
                is_seen[first + span.from as usize..first + span.to as usize].fill(true);
            }
            let is_missed = |&cell: &usize| before[cell] != after[cell] && !is_seen[cell];
            assert_eq!((0..after.len()).find(is_missed), None, "{name}, step {step}");
        }
    }
}

#[test]
fn the_rim_counts_for_nothing_on_levels_and_beside_lines() {
    let usual = EulerianMethods::default();
    compare("levels", &valley_on_levels(), usual);
    compare("levels asleep", &valley_on_levels(), EulerianMethods { sleeps: true, ..usual });

    let whole = in_valley(120, 80, 1.0);
    let lattice = whole.bed.lattice.clone();
    let line = |kind: LineKind, points: &[(f64, f64)]| Line {
        points: points.iter().map(|&(x, y)| Vec2::new(x, y)).collect(),
        is_closed: false,
        kind,
    };
    let lines = [
        line(LineKind::Follow, &[(20.0, 33.0), (70.0, 39.0), (110.0, 30.0)]),
        line(LineKind::Wall, &[(55.0, 44.0), (80.0, 52.0)]),
    ];
    let made = Partition::new(&lattice, |_| true, &lines);
    let lattice = lattice.clone().nested(Nest::of_one_level((120, 80), 1.0).with(made.on(&lattice)));
    let leaves = |of: &dyn Fn(Vec2) -> f64, none: f64| -> Vec<f64> {
        (0..lattice.len()).map(|i| if lattice.is_leaf(i) { of(lattice.centre(i)) } else { none }).collect()
    };
    let elevation = leaves(&ground, f64::NAN);
    let depth = leaves(&|place| if place.x < 40.0 { (5.0 - ground(place)).max(0.0) } else { 0.0 }, 0.0);
    let beside_lines = FlowProblem { dry_depth: whole.dry_depth, ..problem(lattice, elevation, depth) };
    compare("lines", &beside_lines, usual);
}

#[test]
fn the_rim_counts_for_nothing_while_a_dam_breaks() {
    let breaking = valley::problem(Some(breach(Trigger::At(1.0), TRAPEZOID, GrowthLaw::Sine)));
    compare("breach", &breaking, EulerianMethods::default());
}
