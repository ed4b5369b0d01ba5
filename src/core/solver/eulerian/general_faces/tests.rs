//! Levels of a nested lattice: rest, streams, waves, volume, mirror images.

use super::super::stepping::Stepping;
use super::super::tests::{noise, problem};
use super::super::{EulerianMethods, EulerianSolver};
use crate::boundary::{Pieces, Series};
use crate::lattice::{Lattice, Nest};
use crate::math::Vec2;
use crate::methods::Turbulence;
use crate::solver::testing::run_steps;
use crate::solver::{Boundary, Condition, FlowProblem, FlowSolver, PointSource, Rain, Way, nested};

/// What a place of the finest lattice is like: by the index of a cell there and its centre.
type Of<'a> = &'a dyn Fn(usize, Vec2) -> f64;

/// A lattice of `columns` by `rows` cells of 1 m with three levels in blocks of 8 cells; `finest` tells the level that a block asks for.
fn nest(columns: usize, rows: usize, wanted: impl Fn(usize, usize) -> usize) -> (Lattice, Nest) {
    (Lattice::new(Vec2::ZERO, columns, rows, 1.0), Nest::graded((columns, rows), 1.0, 8, 2, wanted))
}

/// Water up to levels (m) on a bed (m), coarse cells with the means of the finest ones.
fn scene((lattice, nest): (Lattice, Nest), bed: Of<'_>, level: Of<'_>) -> FlowProblem {
    let mut levels = Vec::new();
    let mut elevation: Vec<f64> = (0..lattice.len()).map(|cell| bed(cell, lattice.centre(cell))).collect();
    for number in 0..nest.levels().len() {
        let of_level = nest.levels()[number];
        let own = Lattice::new(Vec2::ZERO, of_level.columns, of_level.rows, of_level.spacing);
        if number > 0 {
            let finer = nest.levels()[number - 1];
            let at = |column: usize, row: usize| elevation[row * finer.columns + column];
            let mean = |cell: usize| {
                let (column, row) = own.column_row(cell);
                0.25 * ((at(2 * column, 2 * row) + at(2 * column + 1, 2 * row))
                    + (at(2 * column, 2 * row + 1) + at(2 * column + 1, 2 * row + 1)))
            };
            elevation = (0..own.len()).map(mean).collect();
        }
        let depth = (0..own.len()).map(|cell| (level(cell, own.centre(cell)) - elevation[cell]).max(0.0)).collect();
        levels.push(problem(own, elevation.clone(), depth));
    }
    nested(levels, nest)
}

fn speed(solver: &mut EulerianSolver) -> f64 {
    solver
        .water()
        .cells()
        .map(|water| water.discharge_x.hypot(water.discharge_y) / water.depth.max(1e-6))
        .fold(0.0, f64::max)
}

#[test]
fn blocks_that_touch_are_one_level_apart() {
    let (lattice, nest) = nest(100, 70, |column, row| if (column, row) == (5, 4) { 0 } else { 2 });
    let lattice = lattice.nested(nest);
    let mut area = 0.0;
    for cell in (0..lattice.len()).filter(|&cell| lattice.is_leaf(cell)) {
        area += lattice.area_of(cell);
        let spacing = lattice.area_of(cell).sqrt();
        for (x, y) in [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let beyond = lattice.centre(cell) + Vec2::new(x, y) * (0.5 * spacing + 0.25);
            let Some(beside) = lattice.cell_at(beyond) else { continue };
            let ratio = lattice.area_of(beside).sqrt() / spacing;
            assert!((0.5..=2.0).contains(&ratio), "{ratio} at {beyond:?}");
        }
        assert_eq!(lattice.cell_at(lattice.centre(cell)).unwrap_or(cell), cell);
    }
    // Coarse cells reach over the edge by less than one of them.
    assert!((7000.0..104.0 * 72.0 + 1.0).contains(&area), "{area}");
}

#[test]
fn a_lake_rests_across_levels_on_every_bed() {
    let middle = |column: usize, row: usize| if (2..4).contains(&column) && (3..5).contains(&row) { 0 } else { 2 };
    let beds: [(&str, Of<'_>, Of<'_>); 3] = [
        ("rough", &|cell, _| 1.5 * noise(cell), &|_, _| 2.0),
        ("islands", &|cell, _| 2.0 + 3.0 * noise(cell), &|_, _| 2.0),
        ("bump", &|_, place| 3.0 * (-0.004 * (place - Vec2::new(40.0, 32.0)).norm_squared()).exp(), &|_, _| 2.0),
    ];
    for (name, bed, level) in beds {
        let mut solver = EulerianSolver::new(scene(nest(96, 64, middle), bed, level));
        assert!(solver.general.faces.len() > 100, "{name}");
        run_steps(&mut solver, 1000);
        let fastest = speed(&mut solver);
        assert!(fastest < 1e-12, "{name}: {fastest:e} m/s");
        assert!(solver.ledger().relative_error().abs() < 1e-13, "{name}");
    }
}

#[test]
fn a_uniform_stream_is_uniform_across_levels() {
    let middle = |column: usize, row: usize| if (5..7).contains(&column) && (5..7).contains(&row) { 0 } else { 2 };
    // On level ground nothing may change until the walls tell.
    let mut solver = EulerianSolver::new(scene(nest(96, 96, middle), &|_, _| 0.0, &|_, _| 2.0));
    solver.set_velocity(|_| Vec2::new(1.5, 0.7));
    run_steps(&mut solver, 12);
    let lattice = solver.water().lattice.clone();
    let water: Vec<_> = solver.water().cells().collect();
    let mut seen = 0;
    for cell in (0..lattice.len()).filter(|&cell| lattice.is_leaf(cell)) {
        let place = lattice.centre(cell) - Vec2::new(48.0, 48.0);
        if place.x.abs() < 24.0 && place.y.abs() < 24.0 {
            let off = (water[cell].depth - 2.0).abs()
                + (water[cell].discharge_x - 3.0).abs()
                + (water[cell].discharge_y - 1.4).abs();
            assert!(off < 1e-12, "{off:e} at {place:?}");
            seen += 1;
        }
    }
    assert!(seen > 600, "{seen}");
}

/// Depth and discharges of a dam break over random ground on three levels, seen through `image`, by place.
fn broken_dam(image: &dyn Fn(Vec2) -> Vec2, turbulence: Turbulence) -> impl Fn(Vec2) -> [f64; 3] + use<> {
    const SIDE: usize = 96;
    let block_at = |column: usize, row: usize| image(Vec2::new(8.0 * column as f64 + 4.0, 8.0 * row as f64 + 4.0));
    let is_fine = |place: Vec2| (24.0..56.0).contains(&place.x) && (32.0..48.0).contains(&place.y);
    let wanted = |column: usize, row: usize| if is_fine(block_at(column, row)) { 0 } else { 2 };
    // Elevations that are summed without rounding, so that all images have one datum to the bit.
    let ground = |place: Vec2| 2.0 * noise(place.x as usize + SIDE * place.y as usize) - 0.03 * place.x;
    let bed = |_: usize, place: Vec2| (1024.0 * ground(image(place))).round() / 1024.0;
    let level = |cell: usize, place: Vec2| {
        let seen = image(place);
        bed(cell, place) + if seen.x < 40.0 && seen.y < 56.0 { 4.0 } else { -1.0 }
    };
    let methods = EulerianMethods { turbulence, ..EulerianMethods::default() };
    let mut solver = EulerianSolver::with_methods(scene(nest(SIDE, SIDE, wanted), &bed, &level), methods);
    run_steps(&mut solver, 200);
    assert!(solver.ledger().relative_error().abs() < 1e-13, "{:e}", solver.ledger().relative_error());
    let lattice = solver.water().lattice.clone();
    let water: Vec<_> = solver.water().cells().collect();
    move |place| {
        let cell = water[lattice.cell_at(place).expect("a place on the lattice")];
        [cell.depth, cell.discharge_x, cell.discharge_y]
    }
}

#[test]
fn volume_is_kept_and_mirror_images_have_mirrored_bits() {
    let side = 96.0;
    let bits = |water: [f64; 3]| water.map(|value| (value + 0.0).to_bits());
    for &turbulence in Turbulence::ALL {
        let plain = broken_dam(&|place| place, turbulence);
        let in_x = broken_dam(&|place| Vec2::new(side - place.x, place.y), turbulence);
        let transposed = broken_dam(&|place| Vec2::new(place.y, place.x), turbulence);
        let mut wet = 0;
        for cell in 0..96 * 96 {
            let place = Vec2::new(f64::from(cell % 96) + 0.5, f64::from(cell / 96) + 0.5);
            let [d, x, y] = plain(place);
            wet += usize::from(d > 0.1);
            assert_eq!(bits(in_x(Vec2::new(side - place.x, place.y))), bits([d, -x, y]), "in x, {place:?}");
            assert_eq!(bits(transposed(Vec2::new(place.y, place.x))), bits([d, y, x]), "transposed, {place:?}");
        }
        assert!(wet > 3000, "{wet}");
    }
}

#[test]
fn a_wave_passes_a_jump_of_levels() {
    let still = 2.0_f64;
    // With one step for both levels, and with a step for each.
    for (is_fine_first, is_together) in [(true, true), (false, true), (true, false), (false, false)] {
        let half = |column: usize, _| if (column < 16) == is_fine_first { 0 } else { 1 };
        let (lattice, _) = nest(256, 16, half);
        let nest = Nest::graded((256, 16), 1.0, 8, 1, half);
        let c = (9.81 * still).sqrt();
        let hump = |x: f64| 0.05 * (-((x - 64.0) / 10.0_f64).powi(2)).exp();
        let mut solver = EulerianSolver::new(scene((lattice, nest), &|_, _| 0.0, &|_, place| still + hump(place.x)));
        solver.set_velocity(|place| Vec2::new(2.0 * ((9.81 * (still + hump(place.x))).sqrt() - c), 0.0));
        let end = 110.0 / c;
        while solver.time() < end {
            let step = choose(&mut solver, is_together).min(end - solver.time());
            solver.advance(step).unwrap();
        }
        let lattice = solver.water().lattice.clone();
        let water: Vec<_> = solver.water().cells().collect();
        let leaves = || (0..lattice.len()).filter(|&cell| lattice.is_leaf(cell));
        let back = leaves()
            .filter(|&cell| (10.0..110.0).contains(&lattice.centre(cell).x))
            .map(|cell| (water[cell].depth - still).abs())
            .fold(0.0, f64::max);
        let crest = leaves().map(|cell| water[cell].depth - still).fold(0.0, f64::max);
        println!(
            "fine first {is_fine_first}, one step for both {is_together}: comes back {:.3} %, crest {:.2} %",
            back / 0.05 * 100.0,
            crest / 0.05 * 100.0
        );
        assert!(back < 0.005 * 0.05, "{is_fine_first}: {back}");
    }
}

/// The next step (s): that of the coarsest level, or one for all.
fn choose(solver: &mut EulerianSolver, is_together: bool) -> f64 {
    let step = solver.choose_step().time_step;
    if !is_together {
        return step;
    }
    let of_finest = step / solver.stepping.steps_of_finest();
    solver.stepping = Stepping::new(solver.lattice.level_count());
    of_finest
}

fn depths_at(solver: &mut EulerianSolver) -> impl Fn(Vec2) -> f64 + use<> {
    let lattice = solver.water().lattice.clone();
    let depths = solver.water().depths();
    move |place| depths[lattice.cell_at(place).expect("a place on the lattice")]
}

#[test]
fn levels_that_step_by_themselves_bring_what_one_step_for_all_does() {
    let centre = Vec2::new(48.0, 48.0);
    let level = |_: usize, place: Vec2| if (place - centre).norm() < 12.0 { 4.0 } else { 1.0 };
    let bed = |cell: usize, _: Vec2| 0.6 * noise(cell);
    let solver =
        |wanted: &dyn Fn(usize, usize) -> usize| EulerianSolver::new(scene(nest(96, 96, wanted), &bed, &level));
    let middle = |column: usize, row: usize| if (4..8).contains(&column) && (4..8).contains(&row) { 0 } else { 2 };
    let end = 6.0;
    let run = |mut solver: EulerianSolver, is_together: bool| {
        while solver.time() < end {
            let step = choose(&mut solver, is_together);
            solver.advance(step.min(end - solver.time())).unwrap();
        }
        assert!(solver.ledger().relative_error().abs() < 1e-13);
        (solver.particle_evaluations(), depths_at(&mut solver))
    };
    let (evaluations, by_level) = run(solver(&middle), false);
    let (of_one_step, together) = run(solver(&middle), true);
    let (_, fine) = run(solver(&|_, _| 0), true);
    let apart = |a: &dyn Fn(Vec2) -> f64, b: &dyn Fn(Vec2) -> f64| {
        let places = (0..96 * 96).map(|k| Vec2::new(f64::from(k % 96) + 0.5, f64::from(k / 96) + 0.5));
        places.map(|place| (a(place) - b(place)).abs()).sum::<f64>() / 9216.0
    };
    let (by_steps, by_levels) = (apart(&by_level, &together), apart(&together, &fine));
    println!("{by_steps:.2e} m by steps, {by_levels:.2e} m by levels, evaluations {evaluations} of {of_one_step}");
    assert!(by_steps < 0.1 * by_levels, "{by_steps} and {by_levels} m");
    assert!((evaluations as f64) < 0.9 * of_one_step as f64, "{evaluations} of {of_one_step}");
}

#[test]
fn levels_without_water_change_no_bit() {
    let bed = |cell: usize, _: Vec2| 0.6 * noise(cell);
    let level = |_: usize, place: Vec2| if (place - Vec2::new(48.0, 48.0)).norm() < 12.0 { 4.0 } else { 1.0 };
    let (lattice, all_fine) = nest(96, 96, |_, _| 0);
    let one = Nest::of_one_level((96, 96), 1.0);
    let run = |nest: Nest| {
        let mut solver = EulerianSolver::new(scene((lattice.clone(), nest), &bed, &level));
        run_steps(&mut solver, 60);
        let depths: Vec<u64> = solver.water().depths()[..96 * 96].iter().map(|depth| depth.to_bits()).collect();
        (solver.time().to_bits(), depths)
    };
    assert!(run(all_fine) == run(one));
}

#[test]
fn a_river_runs_through_levels_between_its_boundaries() {
    // 4 m²/s on a slope of 1e-3, n = 0.03: uniform flow all through, whatever the levels.
    let (slope, n, q) = (1e-3_f64, 0.03, 4.0);
    let depth = (q * n / slope.sqrt()).powf(0.6);
    let patch = |column: usize, row: usize| if (6..10).contains(&column) && row < 2 { 0 } else { 2 };
    let bed = |_: usize, place: Vec2| -slope * place.x;
    let mut problem = scene(nest(160, 32, patch), &bed, &|cell, place| bed(cell, place) + depth);
    problem.bed.manning.fill(n);
    problem.bed.is_sloped = true;
    let side = |x: f64| Pieces::from(vec![[Vec2::new(x, 0.0), Vec2::new(x, 32.0)]]);
    let discharge = Condition::Discharge { discharge: Series::constant(32.0 * q), level: None };
    problem.forcing.boundaries = vec![
        Boundary { pieces: side(0.0), condition: discharge },
        Boundary { pieces: side(160.0), condition: Condition::NormalDepth { slope } },
    ];
    problem.forcing.reach = 0.5;
    // Across coarse cells, along a jump of levels, across both and through fine cells.
    let line = |a: (f64, f64), b: (f64, f64)| vec![[Vec2::new(a.0, a.1), Vec2::new(b.0, b.1)]];
    problem.forcing.sections = vec![
        line((20.0, 40.0), (20.0, -8.0)),
        line((47.5, 40.0), (47.5, -8.0)),
        line((30.0, 40.0), (90.0, -8.0)),
        line((64.3, 40.0), (64.3, -8.0)),
    ];
    let mut solver = EulerianSolver::new(problem);
    solver.set_velocity(|_| Vec2::new(q / depth, 0.0));
    while solver.time() < 400.0 {
        let step = solver.choose_step().time_step;
        solver.advance(step).unwrap();
    }
    let found = depths_at(&mut solver);
    for x in [10.0, 44.0, 49.0, 64.0, 81.0, 120.0] {
        for y in [3.0, 15.0, 17.0, 29.0] {
            let off = found(Vec2::new(x, y)) / depth - 1.0;
            assert!(off.abs() < 0.005, "{off} at {x}, {y}");
        }
    }
    for (section, flow) in solver.sections().iter().enumerate() {
        assert!((flow.discharge / (32.0 * q) - 1.0).abs() < 0.002, "{section}: {}", flow.discharge);
    }
    assert!(solver.ledger().relative_error().abs() < 1e-12);
}

#[test]
fn rain_and_sources_fall_on_cells_of_all_levels() {
    let patch = |column: usize, row: usize| if column < 4 && row < 4 { 0 } else { 2 };
    let mut problem = scene(nest(96, 64, patch), &|cell, _| 0.4 * noise(cell), &|_, _| -1.0);
    problem.forcing.rain = Some(Rain::Uniform(Series::constant(1e-4)));
    problem.forcing.sources = [(10.3, 10.3), (80.3, 50.3)]
        .map(|(x, y)| PointSource { place: Vec2::new(x, y), discharge: Series::constant(0.5) })
        .to_vec();
    let mut solver = EulerianSolver::new(problem);
    run_steps(&mut solver, 60);
    let time = solver.time();
    let expected = time * (1e-4 * 96.0 * 64.0 + 2.0 * 0.5);
    let error = solver.ledger().stored / expected - 1.0;
    assert!(error.abs() < 1e-12, "{error:e}");
    let rained = solver.passages().into_iter().find(|passage| passage.way == Way::Rain).unwrap();
    assert!((rained.inflow / (time * 1e-4 * 96.0 * 64.0) - 1.0).abs() < 1e-12, "{rained:?}");
}
