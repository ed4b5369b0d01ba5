//! Long runs, and the Courant number.

use std::f64::consts::PI;

use super::{DEPTH, cell_seeds, fastest, fill};
use crate::math::Vec2;
use crate::physics::dimension::Dimension;
use crate::scenario::methods::Core;
use crate::validation::case::{Case, Setup, SetupResult, Suite, Until};
use crate::validation::cases::circles::{DEPTHS, circular};
use crate::validation::cases::lakes::{LEVEL, SIZE, bump, noise, still};
use crate::validation::exact::Accuracy;
use crate::validation::judge::{Limits, Measure, Share};
use crate::validation::outcome::Outcome;
use crate::validation::scene::problem;

/// Spacings (m) of the long runs; the finer one takes many more steps.
const LONG: &[f64] = &[0.5, 0.25];
/// Greatest speed (m/s) of the noise in a calm lake.
const NOISE: f64 = 1e-6;

macro_rules! courant_numbers {
    ($($name:literal, $courant:literal;)+) => {
        &[
        Case {
            name: "clumping",
            suite: Suite::Stability,
            about: "Particles that a vortex stirs in a closed pond, 5000 steps at 0.5 m and 100000 at 0.25 m: the distance to the nearest \
                    neighbour over the square root of the particle's area; points at random have a median of 0.47.",
            is_tuned: false,
            spacings: LONG,
            tested: 1,
            acceptance_limits: &[],
            setup: stirred,
        },
        Case {
            name: "calm",
            suite: Suite::Stability,
            about: "A lake over a bump with a noise of 1e-6 m/s, 5000 steps at 0.5 m and 100000 at 0.25 m: the noise may not grow.",
            is_tuned: false,
            spacings: LONG,
            tested: 1,
            acceptance_limits: &[],
            setup: |spacing, _| Ok(calm(spacing)),
        },
        $(
            Case {
                name: $name,
                suite: Suite::Stability,
                about: concat!(
                    "The circular dam break of the analytic suite with the Courant number ", stringify!($courant),
                    ", whatever the methods say; a scenario takes 1 at most."
                ),
                is_tuned: true,
                spacings: &[0.2],
                tested: 1,
                acceptance_limits: &[],
                setup: |spacing, core| Ok(with_courant(spacing, core, $courant)),
            },
        )+
        ]
    };
}

/// The cases.
pub const CASES: &[Case] = courant_numbers! {
    "cfl_02", 0.2;
    "cfl_04", 0.4;
    "cfl_06", 0.6;
    "cfl_08", 0.8;
    "cfl_10", 1.0;
    "cfl_12", 1.2;
    "cfl_14", 1.4;
    "cfl_16", 1.6;
};

fn steps(spacing: f64) -> usize {
    if spacing < LONG[0] { 100_000 } else { 5_000 }
}

fn stirred(spacing: f64, core: Core) -> SetupResult {
    const WATER: f64 = 1.0;
    const SPEED: f64 = 0.3;
    if core != Core::Variational {
        return Err("cells do not stand closer than their partition lets them".to_owned());
    }
    let cells = (SIZE / spacing).round() as usize;
    let mut problem = problem(cells, cells, spacing, |_| 0.0);
    fill(&mut problem, |_| WATER);
    let seeds = cell_seeds(&problem);
    let mut setup = Setup::without_answer(problem, seeds, Dimension::Two, Until::Steps(steps(spacing)));
    setup.velocity = Some(Box::new(|place| {
        let (x, y) = (PI * place.x / SIZE, PI * place.y / SIZE);
        Vec2::new(x.sin() * y.cos(), -x.cos() * y.sin()) * SPEED
    }));
    setup.limits = Some(Limits { speed: SPEED + fastest(WATER, 0.0), measures: Box::new(clumps) });
    Ok(setup)
}

/// How near the nearest neighbours are, against points at random, of which a share 1 − exp(−π r²) has one nearer than r: the smaller the
/// ratio of theirs to ours, the better. Twice as far as at random holds, nearer than at random fails.
fn clumps(outcome: &Outcome) -> Vec<Measure> {
    let samples = &outcome.end.samples;
    let nearest = |i: usize| {
        let others = (0..samples.len()).filter(|&j| j != i);
        let distance = others.map(|j| (samples[j].place - samples[i].place).norm()).fold(f64::INFINITY, f64::min);
        distance / (samples[i].volume / samples[i].depth).sqrt()
    };
    let mut distances: Vec<f64> = (0..samples.len()).map(nearest).collect();
    distances.sort_by(f64::total_cmp);
    [("one in twenty", 0.05, 2.0), ("half", 0.5, 1.5)]
        .into_iter()
        .map(|(who, share, better)| {
            let at_random = (-f64::ln(1.0 - share) / PI).sqrt();
            let ours = distances[(share * distances.len() as f64) as usize];
            let what = format!("{who} nearer than {ours:.2} particle widths, at random {at_random:.2}; ratio");
            let mut measure = Measure::new(&what, at_random / ours, "", Share { holds: 1.0 / better, fails: 1.0 });
            measure.asked = format!("nearest neighbour of {who} {better} times as far as at random (fails below 1)");
            measure
        })
        .collect()
}

fn calm(spacing: f64) -> Setup {
    let mut setup = still(bump, spacing, 0.0, steps(spacing));
    setup.checks = None;
    setup.velocity = Some(Box::new(|place| {
        Vec2::new(2.0 * noise(place) - 1.0, 2.0 * noise(place + Vec2::new(SIZE, 0.0)) - 1.0) * (NOISE / 2.0_f64.sqrt())
    }));
    let measures = |outcome: &Outcome| {
        let speed = outcome.end.samples.iter().map(|sample| sample.velocity.norm()).fold(0.0, f64::max);
        // A millimetre per second in a lake that should be still is seen on a map.
        vec![Measure::new("speed at the end", speed, "m/s", Share { holds: NOISE, fails: 1e-3 })]
    };
    let deepest = LEVEL - bump(Vec2::ZERO);
    setup.limits = Some(Limits { speed: fastest(deepest, 0.0), measures: Box::new(measures) });
    setup
}

fn with_courant(spacing: f64, core: Core, courant: f64) -> Setup {
    let mut setup = circular(spacing, core, Accuracy::Second);
    setup.checks = None;
    setup.courant = Some(courant);
    let measures = |outcome: &Outcome| {
        let error = outcome.errors.depth / DEPTHS.0;
        vec![Measure::new("mean depth error over the depth", error, "", DEPTH)]
    };
    setup.limits = Some(Limits { speed: fastest(DEPTHS.0, 0.0), measures: Box::new(measures) });
    setup
}
