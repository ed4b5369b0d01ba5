//! Channels: the same water as a lattice of one row, rest, volume, uniform flow, and what passes into the plane and back.

mod ends;
mod junction;

use super::Primitive;
use crate::boundary::{Boundary, Channel, ChannelEnd, ChannelSection, Condition, Resistance, Series, Strip};
use crate::failure::FailurePlace;
use crate::math::Vec2;
use crate::solver::testing::{run_steps, run_until, still_water as plane};
use crate::solver::{EulerianSolver, FlowProblem, FlowSolver, edge_faces};

const G: f64 = 9.81;
const SMOOTH: Resistance = Resistance { manning: 0.0, smooth_walls: true };

/// A problem without terrain: channels alone.
fn alone(channel: Channel) -> FlowProblem {
    let mut problem = plane((1, 1), channel.spacing, |_| f64::NAN, |_| 0.0);
    problem.initial_depth = vec![0.0];
    problem.forcing.channels.push(channel);
    problem
}

/// A channel alone into which a discharge (m³/s) comes at its far end, and which goes on beyond its near end on a slope.
fn fed(mut channel: Channel, discharge: f64, slope: f64) -> EulerianSolver {
    channel.far = ChannelEnd::Open(Condition::Discharge { discharge: Series::constant(discharge), level: None });
    channel.near = ChannelEnd::Open(Condition::NormalDepth { slope });
    EulerianSolver::new(alone(channel))
}

/// A rectangular channel by functions of the distance from its far end (m).
fn channel(
    particles: usize,
    spacing: f64,
    (width, bed, level): (impl Fn(f64) -> f64, impl Fn(f64) -> f64, impl Fn(f64) -> f64),
    resistance: Resistance,
) -> Channel {
    let places: Vec<f64> = (0..particles).map(|i| (i as f64 + 0.5) * spacing).collect();
    let widths: Vec<f64> = (0..=particles).map(|f| width(f as f64 * spacing)).collect();
    let beds: Vec<f64> = places.iter().map(|x| bed(*x)).collect();
    let levels: Vec<f64> = places.iter().map(|x| level(*x)).collect();
    Channel::rectangular(spacing, &widths, &beds, &levels, resistance)
}

/// Joins a channel to the western (or eastern) edge of a problem, in the rows whose centres lie between two places (m).
fn join(problem: &mut FlowProblem, mut channel: Channel, is_west: bool, (from, to): (f64, f64)) {
    let lattice = &problem.bed.lattice;
    let x = if is_west { 0.0 } else { lattice.size().x };
    let faces = edge_faces(lattice, &problem.bed.elevation).into_iter();
    let faces = faces.filter(|face| (face.middle.x - x).abs() < 1e-9 && (from..=to).contains(&face.middle.y)).collect();
    channel.near = ChannelEnd::Joined(faces);
    problem.forcing.channels.push(channel);
}

/// Repeatable noise between −0.5 and 0.5.
fn noise(place: f64) -> f64 {
    ((place * 12.9898).sin() * 43_758.545_3).fract() - 0.5
}

/// A trapezoid in strips: bed width, sides of one in one, up to a depth.
fn trapezoid(bottom: f64, bed: f64, level: f64, manning: f64) -> ChannelSection {
    let (pieces, height) = (20, 2.0);
    let rise = height / pieces as f64;
    let mut strips = vec![Strip { width: bottom, bed }];
    strips.extend((0..pieces).map(|k| Strip { width: 2.0 * rise, bed: bed + (k as f64 + 0.5) * rise }));
    let perimeter = vec![(0.0, bottom), (height, bottom + 2.0 * height * 2.0_f64.sqrt())];
    ChannelSection { strips, perimeter, manning, level }
}

fn of_sections(spacing: f64, sections: Vec<ChannelSection>) -> Channel {
    let widths = |section: &ChannelSection| section.strips.iter().map(|strip| strip.width).collect::<Vec<f64>>();
    let mut face_widths: Vec<Vec<f64>> = sections.iter().map(widths).collect();
    face_widths.push(face_widths[0].clone());
    Channel { spacing, sections, face_widths, far: ChannelEnd::Wall, near: ChannelEnd::Wall }
}

#[test]
fn a_channel_moves_as_a_lattice_of_one_row() {
    let bed = |x: f64| 0.1 * (0.3 * x).sin() + 0.02 * noise(x);
    for behind in [0.3, -1.0] {
        let level = |x: f64| if x < 20.0 { 1.0 } else { behind };
        let row = plane((40, 1), 1.0, |place| bed(place.x), |place| level(place.x));
        let mut row = EulerianSolver::new(row);
        let mut reach = EulerianSolver::new(alone(channel(40, 1.0, (|_| 1.0, bed, level), SMOOTH)));
        run_until(&mut row, 4.0);
        run_until(&mut reach, 4.0);
        assert_eq!(row.steps(), reach.steps());
        let (water, samples) = (row.water(), reach.channels());
        for (i, (sample, cell)) in samples[0].iter().zip(water.cells()).enumerate() {
            let Primitive { depth, velocity, .. } = reach.reaches.reaches[0].primitive[i];
            let apart = (sample.depth - cell.depth).abs() + (velocity * depth - cell.discharge_x).abs();
            // Levels count from another height: rounding alone is between the two.
            assert!(apart < 1e-11, "level {behind}, particle {i}: {apart:e}");
        }
    }
}

#[test]
fn still_water_rests_in_channels_of_any_width_and_bed() {
    let wide = |x: f64| 2.0 + (0.7 * x).sin() + noise(x);
    let bed = |x: f64| 1.4 * noise(x);
    let rectangle = channel(60, 1.0, (wide, bed, |_| 0.5), Resistance { manning: 0.03, smooth_walls: false });
    let sections = (0..60).map(|i| trapezoid(1.0 + 0.5 * noise(i as f64), bed(i as f64), 0.5, 0.03));
    for (name, channel) in [("rectangle", rectangle), ("trapezoid", of_sections(1.0, sections.collect()))] {
        for end in [
            ChannelEnd::Wall,
            ChannelEnd::Open(Condition::Free),
            ChannelEnd::Open(Condition::Stage(Series::constant(0.5))),
        ] {
            let mut problem = alone(Channel { far: end.clone(), ..channel.clone() });
            problem.forcing.channels[0].sections[0].level = 0.5;
            let mut solver = EulerianSolver::new(problem);
            let fastest = run_steps(&mut solver, 400);
            assert!(fastest < 1e-12, "{name}, {end:?}: {fastest:e} m/s");
        }
    }
}

#[test]
fn a_bore_through_changing_sections_keeps_its_volume() {
    let wide = |x: f64| 2.0 + (0.2 * x).sin();
    let bed = |x: f64| 0.3 * noise(x);
    let level = |x: f64| if x < 20.0 { 2.0 } else { 0.0 };
    let rectangle = channel(60, 1.0, (wide, bed, level), Resistance { manning: 0.02, smooth_walls: false });
    let sections = (0..60).map(|i| trapezoid(1.0, bed(i as f64), level(i as f64), 0.02));
    for channel in [rectangle, of_sections(1.0, sections.collect())] {
        let mut solver = EulerianSolver::new(alone(channel));
        run_steps(&mut solver, 1000);
        let error = solver.ledger().relative_error();
        assert!(error.abs() < 1e-13, "{error:e}");
    }
}

#[test]
fn water_runs_dry_and_comes_back_in_a_channel_with_an_edge_for_a_bottom() {
    // A V of one in two, dry at first but for its upper end.
    let section = |i: usize| {
        let bed = 0.05 * (30.0 - i as f64) + 0.1 * noise(i as f64);
        let mut strips = vec![Strip { width: 0.0, bed }];
        strips.extend((0..16).map(|k| Strip { width: 0.5, bed: bed + (k as f64 + 0.5) / 8.0 }));
        let perimeter = vec![(0.0, 0.0), (2.0, 2.0 * 20.0_f64.sqrt())];
        ChannelSection { strips, perimeter, manning: 0.03, level: if i < 8 { 3.0 } else { 0.0 } }
    };
    let mut channel = of_sections(1.0, (0..40).map(section).collect());
    channel.near = ChannelEnd::Open(Condition::NormalDepth { slope: 0.05 });
    let mut solver = EulerianSolver::new(alone(channel));
    run_until(&mut solver, 300.0);
    let (ledger, samples) = (solver.ledger(), solver.channels());
    assert!(ledger.relative_error().abs() < 1e-12 && ledger.outflow > 0.9 * ledger.initial, "{ledger:?}");
    assert!(samples[0].iter().all(|sample| sample.depth >= 0.0 && sample.velocity.is_finite()));
}

#[test]
fn a_wave_in_a_narrowing_channel_grows_as_energy_asks() {
    // Green's law: a long small wave grows as the width to the power −1/2, here to twice its height.
    let hump = |x: f64| 1.0 + 0.001 * (-((x - 200.0) / 40.0).powi(2)).exp();
    let highest = |narrowing: f64| {
        let wide = move |x: f64| 4.0 - narrowing * ((x - 400.0) / 600.0).clamp(0.0, 1.0);
        let mut solver = EulerianSolver::new(alone(channel(300, 4.0, (wide, |_| 0.0, hump), SMOOTH)));
        run_until(&mut solver, 900.0 / G.sqrt());
        solver.channels()[0].iter().map(|sample| sample.level).fold(0.0, f64::max) - 1.0
    };
    let grown = highest(3.0) / highest(0.0);
    assert!((grown / 2.0 - 1.0).abs() < 0.02, "{grown}");
}

#[test]
fn uniform_flow_takes_the_depth_of_its_hydraulic_radius() {
    /// Slope, Manning's n, width and depth of a channel that is as deep as wide.
    const FLOW: (f64, f64, f64, f64) = (0.002, 0.02, 1.5, 1.5);
    let (slope, n, wide, depth) = FLOW;
    let bed = |x: f64| 1.0 - slope * x;
    let rows = |smooth_walls| {
        let channel =
            channel(100, 2.0, (|_| wide, bed, |x: f64| bed(x) + 0.5), Resistance { manning: n, smooth_walls });
        let radius = if smooth_walls { depth } else { wide * depth / (wide + 2.0 * depth) };
        (channel, wide * depth * radius.powf(2.0 / 3.0) * slope.sqrt() / n)
    };
    let area = (2.0 + depth) * depth;
    let radius = area / (2.0 + 2.0 * depth * 2.0_f64.sqrt());
    let sections = (0..100).map(|i| trapezoid(2.0, bed(2.0 * i as f64 + 1.0), bed(2.0 * i as f64 + 1.0) + 0.5, n));
    let in_strips = (of_sections(2.0, sections.collect()), area * radius.powf(2.0 / 3.0) * slope.sqrt() / n);
    for (k, (channel, discharge)) in [rows(false), rows(true), in_strips].into_iter().enumerate() {
        let mut solver = fed(channel, discharge, slope);
        run_until(&mut solver, 3000.0);
        // Where it comes in and where it leaves, too.
        for sample in &solver.channels()[0] {
            assert!((sample.depth / depth - 1.0).abs() < 0.005, "{k}: {sample:?}");
            assert!((sample.discharge / discharge - 1.0).abs() < 0.005, "{k}: {sample:?}, {discharge}");
        }
        let ledger = solver.ledger();
        assert!((ledger.inflow / (3000.0 * discharge) - 1.0).abs() < 1e-9 && ledger.relative_error().abs() < 1e-12);
    }
}

#[test]
fn all_of_a_discharge_comes_in_through_sections_with_strips_of_no_width() {
    // Two rows of one width, two that differ by rounding, and a V.
    let tables: [fn(usize) -> f64; 3] = [
        |k| if k == 0 { 40.0 } else { 0.0 },
        |k| if k == 0 { 40.0 } else { 4e-16 },
        |k| if k == 0 { 0.0 } else { 0.25 },
    ];
    for (number, width) in tables.into_iter().enumerate() {
        let section = |i: usize| {
            let bed = 100.0 - 0.01 * i as f64;
            let mut strips = vec![Strip { width: width(0), bed }];
            strips.extend((0..16).map(|k| Strip { width: width(k + 1), bed: bed + (k as f64 + 0.5) / 16.0 }));
            let whole: f64 = strips.iter().map(|strip| strip.width).sum();
            ChannelSection { strips, perimeter: vec![(0.0, width(0)), (1.0, whole + 2.0)], manning: 0.03, level: bed }
        };
        let mut solver = fed(of_sections(5.0, (0..40).map(section).collect()), 2.0, 0.002);
        run_until(&mut solver, 600.0);
        let ledger = solver.ledger();
        assert!((ledger.inflow / 1200.0 - 1.0).abs() < 1e-9, "{number}: {ledger:?}");
        assert!(ledger.relative_error().abs() < 1e-12, "{number}: {ledger:?}");
    }
}

#[test]
fn a_discharge_that_fills_the_plains_beside_a_dry_channel_settles_at_its_normal_depth() {
    /// Height above the bed and width of a channel between plains.
    const TABLE: [(f64, f64); 5] = [(0.0, 3.0), (0.5, 8.0), (2.0, 12.0), (2.2, 40.0), (4.0, 44.0)];
    /// Height of a strip (m), their number, discharge, slope, Manning's n.
    const STRIP: (f64, usize) = (0.1, 40);
    const FLOW: (f64, f64, f64) = (140.0, 0.003, 0.035);
    let (discharge, slope, manning) = FLOW;
    let width = |height: f64| {
        let upper = TABLE.iter().position(|row| row.0 >= height).unwrap_or(4).max(1);
        let (low, high) = (TABLE[upper - 1], TABLE[upper]);
        low.1 + (height - low.0) / (high.0 - low.0) * (high.1 - low.1)
    };
    let height = |k: usize| STRIP.0 * k as f64;
    let section = |i: usize| {
        let bed = 50.0 - slope * 10.0 * (i as f64 + 0.5);
        let rising =
            |k: usize| Strip { width: width(height(k + 1)) - width(height(k)), bed: bed + height(k) + 0.5 * STRIP.0 };
        let strips = std::iter::once(Strip { width: width(0.0), bed }).chain((0..STRIP.1).map(rising)).collect();
        let mut around = width(0.0);
        let mut perimeter = vec![(0.0, around)];
        for rows in TABLE.windows(2) {
            around += 2.0 * (rows[1].0 - rows[0].0).hypot(0.5 * (rows[1].1 - rows[0].1));
            perimeter.push((rows[1].0, around));
        }
        ChannelSection { strips, perimeter, manning, level: bed }
    };
    let mut solver = fed(of_sections(10.0, (0..60).map(section).collect()), discharge, slope);
    run_until(&mut solver, 1800.0);
    // Q = Σ A R^(2/3) √S/n of the channel below and above 2 m and of the plains, by hand: 3.182 m (3.283 m by the radius of the whole).
    for sample in &solver.channels()[0] {
        assert!((sample.discharge / discharge - 1.0).abs() < 0.005, "{sample:?}");
        assert!((sample.depth / 3.182 - 1.0).abs() < 0.005, "{sample:?}");
    }
}

#[test]
fn a_channel_between_plains_has_one_normal_depth_whatever_the_start() {
    /// Depth to the banks, width of the channel and of all, slope, Manning's n.
    const SECTION: (f64, f64, f64) = (3.0, 10.0, 110.0);
    const FLOW: (f64, f64) = (0.001, 0.03);
    let ((deep, narrow, wide), (slope, manning)) = (SECTION, FLOW);
    let carried = |area: f64, perimeter: f64| area * (area / perimeter).powf(2.0 / 3.0) * slope.sqrt() / manning;
    // By the radius of the whole 30 m3/s would be carried with 3.182 m, too, for ever after a flood.
    for (depth, start) in [(2.0, 0.5), (2.0, 4.5), (3.5, 0.5), (3.5, 4.5)] {
        let over = f64::max(depth - deep, 0.0);
        let main = carried(narrow * depth, narrow + 2.0 * depth.min(deep));
        let plains = if over > 0.0 { carried((wide - narrow) * over, wide - narrow + 2.0 * over) } else { 0.0 };
        let discharge = main + plains;
        let section = |i: usize| {
            let bed = 50.0 - slope * 10.0 * (i as f64 + 0.5);
            let strips = vec![Strip { width: narrow, bed }, Strip { width: wide - narrow, bed: bed + deep }];
            let at_banks = narrow + 2.0 * deep;
            let at_rim = at_banks + wide - narrow;
            let perimeter = vec![(0.0, narrow), (deep, at_banks), (deep, at_rim), (deep + 1.0, at_rim + 2.0)];
            ChannelSection { strips, perimeter, manning, level: bed + start }
        };
        let mut solver = fed(of_sections(10.0, (0..60).map(section).collect()), discharge, slope);
        run_until(&mut solver, 6000.0);
        for sample in &solver.channels()[0] {
            assert!((sample.depth / depth - 1.0).abs() < 0.002, "{depth} m from {start} m: {sample:?}");
            assert!((sample.discharge / discharge - 1.0).abs() < 0.005, "{depth} m from {start} m: {sample:?}");
        }
    }
}

/// 80 m³/s in a channel 40 m wide that falls 1 in 1000, and at its end by 5 m into a plane.
fn fall_into_a_plane(spacing: f64) -> EulerianSolver {
    let mut problem = plane((20, (40.0 / spacing) as usize), spacing, |place| -0.01 * place.x, |_| f64::NEG_INFINITY);
    problem.bed.manning.fill(0.02);
    let bed = |x: f64| 5.0 + 0.001 * (200.0 - x);
    let rough = Resistance { manning: 0.02, smooth_walls: true };
    let mut reach = channel((200.0 / spacing) as usize, spacing, (|_| 40.0, bed, |x: f64| bed(x) + 0.8), rough);
    reach.far = ChannelEnd::Open(Condition::Discharge { discharge: Series::constant(80.0), level: None });
    join(&mut problem, reach, true, (0.0, 40.0));
    let x = problem.bed.lattice.size().x;
    let edge = vec![[Vec2::new(x, 0.0), Vec2::new(x, 40.0)]];
    problem
        .forcing
        .boundaries
        .push(Boundary { pieces: edge.into(), condition: Condition::NormalDepth { slope: 0.01 } });
    EulerianSolver::new(problem)
}

/// A trapezoid of 5 to 8 m at the bottom through which 8 m³/s pass.
fn contraction() -> EulerianSolver {
    let bottom = |x: f64| 8.0 - 3.0 * (1.0 - (x - 100.0).abs() / 40.0).max(0.0);
    let sections = (0..40).map(|i| trapezoid(bottom(5.0 * (i as f64 + 0.5)), 0.0, 1.5, 0.03));
    let mut channel = of_sections(5.0, sections.collect());
    channel.far = ChannelEnd::Open(Condition::Discharge { discharge: Series::constant(8.0), level: None });
    channel.near = ChannelEnd::Open(Condition::Stage(Series::constant(1.5)));
    EulerianSolver::new(alone(channel))
}

#[test]
fn steady_flow_has_one_discharge_all_along() {
    for (name, mut solver, discharge) in [
        ("10 m", fall_into_a_plane(10.0), 80.0),
        ("5 m", fall_into_a_plane(5.0), 80.0),
        ("contraction", contraction(), 8.0),
    ] {
        assert!(
            solver.channels()[0].iter().all(|sample| sample.discharge.to_bits() == 0),
            "{name}: nothing has passed"
        );
        run_until(&mut solver, 2000.0);
        for (i, sample) in solver.channels()[0].iter().enumerate() {
            assert!((sample.discharge / discharge - 1.0).abs() < 1e-4, "{name}, particle {i}: {sample:?}");
        }
    }
}

#[test]
fn the_discharge_at_the_ends_is_what_was_booked_there() {
    let bed = |x: f64| 2.0 - 0.01 * x;
    let mut channel = channel(80, 2.5, (|_| 3.0, bed, |_| -9.0), Resistance { manning: 0.03, smooth_walls: true });
    let flood = Series::new(&[(0.0, 0.0), (60.0, 9.0), (120.0, 0.0), (400.0, 0.0)]).unwrap();
    channel.far = ChannelEnd::Open(Condition::Discharge { discharge: flood, level: None });
    channel.near = ChannelEnd::Open(Condition::NormalDepth { slope: 0.01 });
    let mut solver = EulerianSolver::new(alone(channel));
    let mut passed = [0.0; 2];
    while solver.time() < 300.0 {
        let choice = solver.choose_step();
        solver.advance(choice.time_step).unwrap();
        let samples = &solver.channels()[0];
        for (sum, sample) in passed.iter_mut().zip([samples[0], samples[79]]) {
            *sum += choice.time_step * sample.discharge;
        }
    }
    let ledger = solver.ledger();
    // A particle lies half a spacing from its end.
    assert!((passed[0] / ledger.inflow - 1.0).abs() < 0.01, "{passed:?}, {ledger:?}");
    assert!((passed[1] / ledger.outflow - 1.0).abs() < 0.01, "{passed:?}, {ledger:?}");
}

#[test]
fn a_breakdown_is_placed_in_its_channel() {
    let flat = |level: f64| channel(30, 2.0, (|_| 1.0, |_| 0.0, move |_| level), SMOOTH);
    let mut problem = alone(flat(1.0));
    problem.forcing.channels.push(flat(2.0));
    let mut solver = EulerianSolver::new(problem);
    let step = solver.choose_step().time_step;
    solver.reaches.reaches[1].water[17].discharge = f64::NAN;
    let failure = solver.advance(step).unwrap_err();
    let FailurePlace::InChannel { number: 2, distance } = failure.place else { panic!("{failure}") };
    // It has spread to the particles beside it.
    assert!((distance - 35.0).abs() <= 4.0 && failure.to_string().contains("in channel 2, 3"), "{failure}");
}
