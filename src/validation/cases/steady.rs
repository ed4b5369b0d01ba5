//! Steady flow over a bump, and along a slope with friction.
//!
//! Without inflow and outflow: the flow starts from its exact steady state in a channel so long that nothing from its closed ends
//! comes into the window of comparison before the end: what is measured is how far the state that the method keeps is from the
//! exact one. With inflow and outflow: `open_channels.rs`.

use crate::math::Vec2;
use crate::physics::dimension::Dimension;
use crate::validation::case::{AcceptanceLimit, Case, Setup, SetupResult, Suite, Until};
use crate::validation::exact::{Bump, MacDonald, bump_bed};
use crate::validation::scene::{flat_strip, line_seeds};

const SPACINGS: &[f64] = &[0.5, 0.25, 0.125];

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "bump_subcritical",
        suite: Suite::Analytic,
        about: "Subcritical flow over a bump (q = 4.42 m2/s, d = 2 m) kept for 40 s against Bernoulli's equation.",
        is_tuned: true,
        spacings: SPACINGS,
        tested: 2,
        acceptance_limits: &[
            AcceptanceLimit { spacing: Some(0.125), depth: Some(5.4e-4), ..AcceptanceLimit::NONE },
            AcceptanceLimit { order: Some((1.5, None)), ..AcceptanceLimit::NONE },
        ],
        setup: |spacing, _| Ok(over_bump(spacing, Bump::on_one_branch(4.42, 2.0), (280.0, 170.0), 40.0)),
    },
    Case {
        name: "bump_transcritical",
        suite: Suite::Analytic,
        about: "Flow that turns supercritical at the crest of a bump (q = 1.53 m2/s) kept for 40 s against Bernoulli's equation.",
        is_tuned: false,
        spacings: SPACINGS,
        tested: 2,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(over_bump(spacing, Bump::transcritical(1.53), (200.0, 150.0), 40.0)),
    },
    Case {
        name: "bump_jump",
        suite: Suite::Analytic,
        about: "Transcritical flow over a bump with a hydraulic jump behind it (q = 0.18 m2/s, d = 0.33 m) kept for 60 s.",
        is_tuned: false,
        spacings: SPACINGS,
        tested: 2,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(over_bump(spacing, Bump::with_jump(0.18, 0.33), (160.0, 130.0), 60.0)),
    },
    Case {
        name: "bump_supercritical",
        suite: Suite::Analytic,
        about: "Supercritical flow over a bump (q = 25 m2/s, d = 2 m) kept for 8 s against Bernoulli's equation.",
        is_tuned: false,
        spacings: SPACINGS,
        tested: 2,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(over_bump(spacing, Bump::on_one_branch(25.0, 2.0), (160.0, 60.0), 8.0)),
    },
    Case {
        name: "macdonald",
        suite: Suite::Analytic,
        about: "MacDonald's subcritical flow along a slope with friction (q = 2 m2/s, n = 0.033, 1000 m) kept for 100 s.",
        is_tuned: false,
        spacings: &[20.0, 10.0, 5.0],
        tested: 2,
        acceptance_limits: &[],
        setup: macdonald,
    },
];

/// The bump, 10 m downstream of the start of its reach of 25 m, with so many metres of channel before and behind it.
fn over_bump(spacing: f64, flow: Bump, (before, behind): (f64, f64), end: f64) -> Setup {
    let state = flow.clone();
    let problem = channel(spacing, before + 25.0 + behind, |x| bump_bed(x - before), |x| flow.at(x - before).0);
    steady(problem, before, (2.0, 22.0), end, move |x| state.at(x))
}

fn macdonald(spacing: f64, _: crate::scenario::methods::Core) -> SetupResult {
    let (before, behind) = (600.0, 300.0);
    let length = before + 1000.0 + behind;
    let flow = MacDonald::new(-before, 1000.0 + behind, 0.1);
    let mut problem = channel(spacing, length, |x| flow.bed(x - before), |x| MacDonald::at(x - before).0);
    problem.bed.manning.fill(MacDonald::MANNING);
    Ok(steady(problem, before, (0.0, 1000.0), 100.0, MacDonald::at))
}

fn channel(
    spacing: f64,
    length: f64,
    bed: impl Fn(f64) -> f64,
    depth: impl Fn(f64) -> f64,
) -> crate::solver::FlowProblem {
    let mut problem = flat_strip(length, spacing, bed);
    let lattice = &problem.bed.lattice;
    problem.initial_depth = (0..lattice.len()).map(|cell| depth(lattice.centre(cell).x)).collect();
    problem
}

/// A flow that is `state` at its place `x` (m) from the start of the reach, compared within the window (m).
fn steady(
    problem: crate::solver::FlowProblem,
    before: f64,
    window: (f64, f64),
    end: f64,
    state: impl Fn(f64) -> (f64, f64) + Clone + Send + Sync + 'static,
) -> Setup {
    let seeds = line_seeds(&problem);
    let exact = {
        let state = state.clone();
        move |place: Vec2| {
            let (d, u) = state(place.x - before);
            (d, Vec2::new(u, 0.0))
        }
    };
    let mut setup = Setup::new(problem, seeds, Dimension::One, Until::Time(end), Box::new(exact));
    setup.velocity = Some(Box::new(move |place| Vec2::new(state(place.x - before).1, 0.0)));
    setup.counts = Box::new(move |place| (window.0..window.1).contains(&(place.x - before)));
    setup.scale_speed = setup.scale_speed.max(13.0);
    setup
}
