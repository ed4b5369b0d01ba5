//! Water that enters and leaves through open boundaries: uniform flow, waves that leave, a tide, a hydrograph on dry ground.

use crate::math::Vec2;
use crate::physics::dimension::Dimension;
use crate::scenario::methods::Core;
use crate::solver::{Boundary, Condition, FlowProblem, Series};
use crate::validation::case::{AcceptanceLimit, Case, ROWS, Setup, SetupResult, Suite, Until};
use crate::validation::exact::normal_velocity;
use crate::validation::outcome::{Check, Snapshot};
use crate::validation::scene::{flat_strip, line_seeds};

/// Depth of the uniform flow and of the still water before waves (m).
const DEPTH: f64 = 1.0;
/// Manning's n of the uniform flow (s·m^(−1/3)).
const ROUGHNESS: f64 = 0.03;
/// What depth and velocity of uniform flow may be off, anywhere, relative.
const UNIFORM: f64 = 5e-3;
/// What may come back of a wave, relative to its height.
const REFLECTED: f64 = 0.02;
/// What the ledger may be off, relative.
const LEDGER: f64 = 1e-9;
/// Steps of the long run.
const MANY: usize = 100_000;

const CHECKED: &[AcceptanceLimit] = &[AcceptanceLimit { checks: true, ..AcceptanceLimit::NONE }];

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "uniform_subcritical",
        suite: Suite::Analytic,
        about: "A channel (slope 0.001, n = 0.03) that starts dry, fed by a discharge and left at normal depth, after 6000 s against uniform flow 1 m deep.",
        is_tuned: false,
        spacings: &[8.0, 4.0, 2.0],
        tested: 2,
        acceptance_limits: CHECKED,
        setup: |spacing, _| uniform(spacing, 0.001, 6000.0),
    },
    Case {
        name: "uniform_supercritical",
        suite: Suite::Analytic,
        about: "The same on a slope of 0.02, fed by discharge and level, after 600 s: the flow is supercritical throughout.",
        is_tuned: false,
        spacings: &[8.0, 4.0, 2.0],
        tested: 2,
        acceptance_limits: CHECKED,
        setup: |spacing, _| uniform(spacing, 0.02, 600.0),
    },
    Case {
        name: "hydrograph_long",
        suite: Suite::Analytic,
        about: "A channel fed by a discharge that rises and falls every 100 s, over 100 000 steps: the volume balance against the integral of the hydrograph.",
        is_tuned: false,
        spacings: &[8.0, 4.0, 2.0],
        tested: 1,
        acceptance_limits: CHECKED,
        setup: hydrograph,
    },
    Case {
        name: "low_waves_leave",
        suite: Suite::Analytic,
        about: "A train of waves 1 cm high leaves a channel 1 m deep through a free edge; what comes back.",
        is_tuned: false,
        spacings: &[1.0, 0.5, 0.25],
        tested: 2,
        acceptance_limits: CHECKED,
        setup: |spacing, _| waves(spacing, 0.01),
    },
    Case {
        name: "high_waves_leave",
        suite: Suite::Analytic,
        about: "The same with waves 0.4 m high, which steepen into bores on their way.",
        is_tuned: false,
        spacings: &[1.0, 0.5, 0.25],
        tested: 2,
        acceptance_limits: CHECKED,
        setup: |spacing, _| waves(spacing, 0.4),
    },
    Case {
        name: "tide",
        suite: Suite::Analytic,
        about: "A tide of 0.1 m at the mouth of a basin 20 km long and 20 m deep, against the standing wave, after two tides.",
        is_tuned: false,
        spacings: &[400.0, 200.0, 100.0],
        tested: 2,
        // A hundredth of the tide: the answer is that of small waves, and the tide is half a hundredth of the depth.
        acceptance_limits: &[AcceptanceLimit { depth: Some(1e-3), ..AcceptanceLimit::NONE }],
        setup: tide,
    },
];

/// A channel of one row whose ends have conditions.
fn channel(
    (length, spacing): (f64, f64),
    bed: impl Fn(f64) -> f64,
    [west, east]: [Option<Condition>; 2],
) -> FlowProblem {
    let mut problem = flat_strip(length, spacing, bed);
    // Between the last particle of the riverbed and the edge the bed goes on by its slope.
    problem.bed.is_sloped = true;
    let size = problem.bed.lattice.size();
    // The faces along the channel lie half a spacing away.
    problem.forcing.reach = 0.3 * spacing;
    for (x, condition) in [(0.0, west), (size.x, east)] {
        if let Some(condition) = condition {
            // As wide as a channel in the plane (`Setup::in_plane`).
            let segments = vec![[Vec2::new(x, 0.0), Vec2::new(x, ROWS as f64 * size.y)]];
            problem.forcing.boundaries.push(Boundary { pieces: segments.into(), condition });
        }
    }
    problem
}

fn ledger_check(end: &Snapshot) -> Check {
    let error = end.ledger.relative_error().abs();
    Check { found: format!("ledger off by {error:.1e}"), is_met: error <= LEDGER }
}

fn uniform(spacing: f64, slope: f64, end: f64) -> SetupResult {
    let velocity = normal_velocity(DEPTH, slope, ROUGHNESS);
    // The level at the edge itself, where the bed is at 0.
    let is_fast = velocity > (crate::scenario::GRAVITY * DEPTH).sqrt();
    let inflow = Condition::Discharge {
        discharge: Series::constant(DEPTH * velocity * spacing),
        level: is_fast.then(|| Series::constant(DEPTH)),
    };
    let outflow = Condition::NormalDepth { slope };
    let mut problem = channel((400.0, spacing), |x| -slope * x, [Some(inflow), Some(outflow)]);
    problem.bed.manning.fill(ROUGHNESS);
    problem.dry_depth = 1e-3;
    let exact = Box::new(move |_| (DEPTH, Vec2::new(velocity, 0.0)));
    let mut setup = Setup::new(problem.clone(), line_seeds(&problem), Dimension::One, Until::Time(end), exact);
    setup.scale_depth = DEPTH;
    setup.scale_speed = velocity;
    setup.checks = Some(Box::new(move |_, end| {
        let depth = |worst: f64, s: &crate::validation::Sample| worst.max((s.depth / DEPTH - 1.0).abs());
        let speed = |worst: f64, s: &crate::validation::Sample| worst.max((s.velocity.x / velocity - 1.0).abs());
        let (depth, speed) = (end.samples.iter().fold(0.0, depth), end.samples.iter().fold(0.0, speed));
        let found = format!("largest relative error: depth {depth:.1e}, velocity {speed:.1e}");
        vec![Check { found, is_met: depth <= UNIFORM && speed <= UNIFORM }, ledger_check(end)]
    }));
    Ok(setup)
}

fn hydrograph(spacing: f64, core: Core) -> SetupResult {
    if core == Core::Lagrangian {
        return Err(
            "a balance over so many steps is that of the cells at rest, which boundaries have beside them".to_owned()
        );
    }
    let points: Vec<(f64, f64)> =
        (0..4000).map(|k| (50.0 * f64::from(k), spacing * if k % 2 == 0 { 0.2 } else { 3.0 })).collect();
    let series = Series::new(&points).ok_or("no series")?;
    let inflow = Condition::Discharge { discharge: series.clone(), level: None };
    let slope = 0.004;
    let outflow = Condition::NormalDepth { slope };
    let mut problem = channel((200.0, spacing), |x| -slope * x, [Some(inflow), Some(outflow)]);
    problem.bed.manning.fill(ROUGHNESS);
    problem.dry_depth = 1e-3;
    let mut setup = Setup::without_answer(problem.clone(), line_seeds(&problem), Dimension::One, Until::Steps(MANY));
    setup.scale_depth = DEPTH;
    setup.checks = Some(Box::new(move |_, end| {
        // Particles of the variational formulation carry volumes per metre of width.
        let width = if end.is_of_particles { spacing } else { 1.0 };
        let wanted = series.integral(0.0, end.time) / width;
        let off = (end.ledger.inflow / wanted - 1.0).abs();
        let found = format!("counted inflow off the integral of the hydrograph by {off:.1e} after {:.0} s", end.time);
        vec![Check { found, is_met: off <= LEDGER }, ledger_check(end)]
    }));
    Ok(setup)
}

fn waves(spacing: f64, height: f64) -> SetupResult {
    let (length, middle, wavelength) = (160.0, 70.0, 20.0);
    // Three crests and two troughs that end smoothly.
    let surface = move |x: f64| {
        let along = (x - middle) / wavelength;
        let envelope = if along.abs() < 1.5 { (std::f64::consts::PI * along / 3.0).cos().powi(2) } else { 0.0 };
        DEPTH + height * envelope * (std::f64::consts::TAU * along).cos()
    };
    // What comes back meets a wall in the west, and cannot leave again before the end.
    let mut problem = channel((length, spacing), |_| 0.0, [None, Some(Condition::Free)]);
    let lattice = problem.bed.lattice.clone();
    problem.initial_depth = (0..lattice.len()).map(|cell| surface(lattice.centre(cell).x)).collect();
    let celerity = |depth: f64| (crate::scenario::GRAVITY * depth).sqrt();
    // Slow water follows behind high waves: the lowest trough moves with 3 c − 2 c_0.
    let slowest = 3.0 * celerity(DEPTH - 0.8 * height) - 2.0 * celerity(DEPTH);
    let end = 1.1 * (length - middle + 1.5 * wavelength) / slowest;
    let exact = Box::new(|_| (DEPTH, Vec2::ZERO));
    let mut setup = Setup::new(problem.clone(), line_seeds(&problem), Dimension::One, Until::Time(end), exact);
    // A simple wave to the east.
    setup.velocity = Some(Box::new(move |place| Vec2::new(2.0 * (celerity(surface(place.x)) - celerity(DEPTH)), 0.0)));
    setup.checks = Some(Box::new(move |_, end| {
        let back = end.samples.iter().map(|s| (s.depth - DEPTH).abs()).fold(0.0, f64::max) / height;
        let found = format!("{:.2} % of the height comes back", 100.0 * back);
        vec![Check { found, is_met: back <= REFLECTED }, ledger_check(end)]
    }));
    Ok(setup)
}

/// Small waves in a basin of constant depth, closed at its end: η = a cos(ω t) cos(k (L − x)) / cos(k L), reached from rest at t = 0
/// by the whole of it: the run starts with its level and its velocity of that moment.
fn tide(spacing: f64, _: Core) -> SetupResult {
    let (length, depth, height, period) = (20_000.0, 20.0, 0.1, 12.0 * 3600.0);
    let omega = std::f64::consts::TAU / period;
    let k = omega / (crate::scenario::GRAVITY * depth).sqrt();
    let shape = move |x: f64| (k * (length - x)).cos() / (k * length).cos();
    let points: Vec<(f64, f64)> =
        (0..=2880).map(|step| 30.0 * f64::from(step)).map(|time| (time, height * (omega * time).cos())).collect();
    let stage = Series::new(&points).ok_or("no series")?;
    let mut problem = channel((length, spacing), |_| -depth, [Some(Condition::Stage(stage)), None]);
    let lattice = problem.bed.lattice.clone();
    let at = |cell: usize| depth + height * shape(lattice.centre(cell).x);
    problem.initial_depth = (0..lattice.len()).map(at).collect();
    let end = 2.0 * period;
    let exact = Box::new(move |place: Vec2| (depth + height * (omega * end).cos() * shape(place.x), Vec2::ZERO));
    Ok(Setup::new(problem.clone(), line_seeds(&problem), Dimension::One, Until::Time(end), exact))
}
