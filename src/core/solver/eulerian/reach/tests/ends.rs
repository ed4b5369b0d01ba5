//! Conditions at the ends of a channel: waves, levels, discharges of sections.

use super::*;

/// Sections with one level of 4 m at rest: a rectangle, a V, a trapezoid, and a channel between plains.
fn sections_of_waves() -> [(&'static str, Vec<Strip>); 4] {
    let sloped = |bottom: f64, rise: f64| {
        let mut strips = vec![Strip { width: bottom, bed: 0.0 }];
        strips.extend((0..24).map(|k| Strip { width: 0.25 * rise, bed: 0.25 * (k as f64 + 0.5) }));
        strips
    };
    let plains = vec![Strip { width: 10.0, bed: 0.0 }, Strip { width: 100.0, bed: 3.0 }];
    [
        ("rectangle", vec![Strip { width: 20.0, bed: 0.0 }]),
        ("V", sloped(0.0, 4.0)),
        ("trapezoid", sloped(5.0, 6.0)),
        ("channel between plains", plains),
    ]
}

#[test]
fn waves_leave_sections_of_any_shape() {
    for (name, strips) in sections_of_waves() {
        for height in [0.02, 1.0] {
            let hump = |x: f64| 4.0 + if (x - 500.0).abs() < 60.0 { height } else { 0.0 };
            let section = |i: usize| ChannelSection {
                strips: strips.clone(),
                perimeter: vec![(0.0, 1.0), (10.0, 1.0)],
                manning: 0.0,
                level: hump(5.0 * (i as f64 + 0.5)),
            };
            let mut channel = of_sections(5.0, (0..200).map(section).collect());
            channel.far = ChannelEnd::Open(Condition::Free);
            channel.near = ChannelEnd::Open(Condition::Free);
            let mut solver = EulerianSolver::new(alone(channel));
            let away = |solver: &EulerianSolver| {
                solver.channels()[0].iter().map(|sample| (sample.level - 4.0).abs()).fold(0.0, f64::max)
            };
            // The crests leave after 70 to 140 s, the tail behind them some 80 s later.
            run_until(&mut solver, 60.0);
            let wave = away(&solver);
            run_until(&mut solver, 240.0);
            let back = away(&solver) / wave;
            assert!(back < 0.01, "{name}, {height} m: {back}");
        }
    }
}

#[test]
fn levels_and_waves_at_the_ends_of_a_channel_are_those_of_a_lattice_of_one_row() {
    let bed = |x: f64| 0.1 * (0.3 * x).sin() + 0.02 * noise(x);
    let levels = |height: f64| {
        let points: Vec<(f64, f64)> =
            (0..=60).map(|k| 0.2 * f64::from(k)).map(|t| (t, 1.0 + height * (0.8 * t).sin())).collect();
        Series::new(&points).unwrap()
    };
    let still = Some(Series::constant(1.0));
    for (behind, condition) in [
        (1.0, Condition::Level(levels(0.3))),
        (1.0, Condition::Wave { level: levels(0.3), still: None }),
        (1.0, Condition::Wave { level: levels(0.3), still }),
        (-1.0, Condition::Level(levels(0.3))),
    ] {
        let mut row = plane((40, 1), 1.0, |place| bed(place.x), |_| behind);
        row.forcing
            .boundaries
            .push(Boundary { pieces: vec![[Vec2::ZERO, Vec2::new(0.0, 1.0)]].into(), condition: condition.clone() });
        let mut reach = channel(40, 1.0, (|_| 1.0, bed, |_| behind), SMOOTH);
        reach.far = ChannelEnd::Open(condition.clone());
        let (mut row, mut reach) = (EulerianSolver::new(row), EulerianSolver::new(alone(reach)));
        run_until(&mut row, 10.0);
        run_until(&mut reach, 10.0);
        let (water, samples) = (row.water(), reach.channels());
        let apart = samples[0]
            .iter()
            .zip(water.cells())
            .map(|(sample, cell)| (sample.depth - cell.depth).abs())
            .fold(0.0, f64::max);
        let name = if matches!(condition, Condition::Level(_)) { "level" } else { "wave" };
        // The flux of a section is that of the state at its end, that of a face the one between it and the state before it.
        assert!(apart < 0.03, "{name} over {behind} m: {apart} m");
        assert!(reach.ledger().relative_error().abs() < 1e-12);
    }
}

#[test]
fn a_wave_enters_sections_of_any_shape_comes_back_and_leaves() {
    for (name, strips) in sections_of_waves() {
        for height in [0.02, 0.5] {
            let section = |_: usize| ChannelSection {
                strips: strips.clone(),
                perimeter: vec![(0.0, 1.0), (10.0, 1.0)],
                manning: 0.0,
                level: 4.0,
            };
            let hump = |t: f64| height * (std::f64::consts::PI * (t / 60.0).clamp(0.0, 1.0)).sin().powi(2);
            let points: Vec<(f64, f64)> = (0..=800).map(f64::from).map(|t| (t, 4.0 + hump(t))).collect();
            let mut channel = of_sections(5.0, (0..100).map(section).collect());
            channel.far = ChannelEnd::Open(Condition::Wave { level: Series::new(&points).unwrap(), still: None });
            let mut solver = EulerianSolver::new(alone(channel));
            let away = |solver: &EulerianSolver, from: usize| {
                solver.channels()[0][from..].iter().map(|sample| (sample.level - 4.0).abs()).fold(0.0, f64::max)
            };
            let mut at_wall = 0.0_f64;
            for moment in 0..40 {
                run_until(&mut solver, 5.0 * f64::from(moment));
                at_wall = at_wall.max(away(&solver, 99));
            }
            run_until(&mut solver, 600.0);
            let back = away(&solver, 0) / height;
            assert!(back < 0.02 && at_wall > 1.7 * height, "{name}, {height} m: {at_wall} m, {back}");
        }
    }
}

#[test]
fn a_level_held_at_the_ends_of_a_compound_channel_is_that_of_its_flow() {
    /// Slope, Manning's n and depth.
    const FLOW: (f64, f64, f64) = (0.001, 0.03, 3.6);
    let (slope, manning, depth) = FLOW;
    let section = |i: usize| {
        let bed = 50.0 - slope * 10.0 * (i as f64 + 0.5);
        let strips = vec![Strip { width: 10.0, bed }, Strip { width: 60.0, bed: bed + 3.0 }];
        let perimeter = vec![(0.0, 10.0), (3.0, 16.0), (3.0, 76.0), (4.0, 78.0)];
        ChannelSection { strips, perimeter, manning, level: bed + depth }
    };
    let mut channel = of_sections(10.0, (0..100).map(section).collect());
    channel.far = ChannelEnd::Open(Condition::Level(Series::constant(50.0 + depth)));
    channel.near = ChannelEnd::Open(Condition::Level(Series::constant(50.0 - slope * 1000.0 + depth)));
    let mut solver = EulerianSolver::new(alone(channel));
    run_until(&mut solver, 6000.0);
    let carried = |area: f64, perimeter: f64| area * (area / perimeter).powf(2.0 / 3.0) * slope.sqrt() / manning;
    let discharge = carried(10.0 * depth, 16.0) + carried(60.0 * (depth - 3.0), 60.0 + 2.0 * (depth - 3.0));
    for sample in &solver.channels()[0] {
        assert!((sample.depth / depth - 1.0).abs() < 5e-3, "{sample:?}");
        assert!((sample.discharge / discharge - 1.0).abs() < 1e-2, "{sample:?}, {discharge} m3/s");
    }
}
