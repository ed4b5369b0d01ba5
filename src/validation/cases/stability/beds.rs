//! Beds that break methods: a cliff, a vertical step, noise, a steep slope under a film; and friction at vanishing depth.

use super::{KEPT, PLACE, cell_seeds, energy_gain, fastest, fill, strip};
use crate::math::Vec2;
use crate::physics::dimension::Dimension;
use crate::scenario::GRAVITY;
use crate::validation::case::{Case, Setup, Suite, Until};
use crate::validation::cases::lakes::noise;
use crate::validation::exact::normal_velocity;
use crate::validation::judge::{Limits, Measure, Share};
use crate::validation::outcome::Outcome;
use crate::validation::scene::{flat_strip, line_seeds};

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "waterfall",
        suite: Suite::Stability,
        about: "Water 1 m deep spills over a cliff of ten depths for 15 s: the spilled volume against Ritter's critical brink, \
                8/27 c d per second, speed and energy.",
        is_tuned: false,
        spacings: &[1.0, 0.5],
        tested: 1,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(waterfall(spacing)),
    },
    Case {
        name: "step_wave",
        suite: Suite::Stability,
        about: "A dam-break wave, 2 m over 0.5 m, runs against a vertical step of 1 m in the bed and over it, 10 s: energy may not grow.",
        is_tuned: false,
        spacings: &[0.5, 0.25],
        tested: 1,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(wave_over(spacing, |place| if place.x < 40.0 { 0.0 } else { 1.0 }, 1.0)),
    },
    Case {
        name: "noise_wave",
        suite: Suite::Stability,
        about: "The same wave over a bed of noise, up to 0.8 m from one cell to the next, 10 s: energy may not grow.",
        is_tuned: false,
        spacings: &[0.5, 0.25],
        tested: 1,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(wave_over(spacing, |place| if place.x < 20.0 { 0.0 } else { 0.8 * noise(place) }, 0.8)),
    },
    Case {
        name: "steep_film",
        suite: Suite::Stability,
        about: "A film of 2 mm with n = 0.03 on a slope of 1 in 1 for 5 s, against Manning's velocity.",
        is_tuned: false,
        spacings: &[1.0, 0.5],
        tested: 1,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(steep_film(spacing)),
    },
    Case {
        name: "friction_film",
        suite: Suite::Stability,
        about: "A film of 1 mm at 2 m/s is stopped by friction (n = 0.05) within 1 s, against v = v0/(1 + g n2 v0 t/d^(4/3)): \
                friction may not turn it round.",
        is_tuned: false,
        spacings: &[1.0, 0.5],
        tested: 1,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(stopped(spacing, 1e-3)),
    },
    Case {
        name: "friction_vanishing",
        suite: Suite::Stability,
        about: "The same at vanishing depth, 0.01 mm.",
        is_tuned: false,
        spacings: &[1.0, 0.5],
        tested: 1,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(stopped(spacing, 1e-5)),
    },
];

/// A reservoir that ends at a cliff; the brink is critical from the first moment, so that Ritter's discharge at the dam is exact until
/// the wave comes back from the closed end.
fn waterfall(spacing: f64) -> Setup {
    const CLIFF: f64 = 60.0;
    const LENGTH: f64 = 380.0;
    const DROP: f64 = 10.0;
    const WATER: f64 = 1.0;
    const END: f64 = 15.0;
    let mut problem = strip(LENGTH, spacing, |place| if place.x < CLIFF { DROP } else { 0.0 });
    fill(&mut problem, |place| if place.x < CLIFF { WATER } else { 0.0 });
    let seeds = cell_seeds(&problem);
    let width = super::ROWS as f64 * spacing;
    let exact = 8.0 / 27.0 * (GRAVITY * WATER).sqrt() * WATER * END * width;
    let mut setup = Setup::without_answer(problem, seeds, Dimension::Two, Until::Time(END));
    setup.scale_speed = fastest(WATER, DROP);
    let measures = move |outcome: &Outcome| {
        let below = outcome.end.samples.iter().filter(|sample| sample.place.x > CLIFF);
        let spilled = below.map(|sample| sample.volume).sum::<f64>() / exact;
        vec![
            Measure::new("spilled volume off Ritter's by the share", (spilled - 1.0).abs(), "", PLACE),
            energy_gain(outcome, 0.0),
        ]
    };
    setup.limits = Some(Limits { speed: fastest(WATER, DROP), measures: Box::new(measures) });
    setup
}

/// 2 m of water over a level of 0.5 m, in a channel whose bed rises by up to `height` (m).
fn wave_over(spacing: f64, bed: impl Fn(Vec2) -> f64, height: f64) -> Setup {
    const LENGTH: f64 = 60.0;
    const DAM: f64 = 20.0;
    const LEVELS: (f64, f64) = (2.0, 0.5);
    const END: f64 = 10.0;
    let mut problem = strip(LENGTH, spacing, bed);
    let lattice = problem.bed.lattice.clone();
    let depth = |cell: usize| {
        let level = if lattice.centre(cell).x < DAM { LEVELS.0 } else { LEVELS.1 };
        (level - problem.bed.elevation[cell]).max(0.0)
    };
    problem.initial_depth = (0..lattice.len()).map(depth).collect();
    let seeds = cell_seeds(&problem);
    let mut setup = Setup::without_answer(problem, seeds, Dimension::Two, Until::Time(END));
    let measures = |outcome: &Outcome| vec![energy_gain(outcome, 0.0)];
    setup.limits = Some(Limits { speed: fastest(LEVELS.0, height), measures: Box::new(measures) });
    setup
}

/// A film on a slope of 1.
fn steep_film(spacing: f64) -> Setup {
    const LENGTH: f64 = 60.0;
    const SLOPE: f64 = 1.0;
    const FILM: f64 = 0.002;
    const ROUGHNESS: f64 = 0.03;
    const WINDOW: std::ops::Range<f64> = 20.0..40.0;
    const END: f64 = 5.0;
    let mut problem = strip(LENGTH, spacing, |place| SLOPE * (LENGTH - place.x));
    problem.bed.is_sloped = true;
    problem.bed.manning.fill(ROUGHNESS);
    fill(&mut problem, |_| FILM);
    let seeds = cell_seeds(&problem);
    let velocity = normal_velocity(FILM, SLOPE, ROUGHNESS);
    let exact = Box::new(move |_| (FILM, Vec2::new(velocity, 0.0)));
    let mut setup = Setup::new(problem, seeds, Dimension::Two, Until::Time(END), exact);
    setup.counts = Box::new(|place| WINDOW.contains(&place.x));
    setup.scale_speed = velocity;
    let measures = move |outcome: &Outcome| {
        vec![
            Measure::new("mean depth error over the depth", outcome.errors.depth / FILM, "", KEPT),
            Measure::new("mean velocity error over the velocity", outcome.errors.velocity / velocity, "", KEPT),
        ]
    };
    setup.limits = Some(Limits { speed: fastest(FILM, SLOPE * LENGTH), measures: Box::new(measures) });
    setup
}

/// A film (m) that friction stops.
fn stopped(spacing: f64, film: f64) -> Setup {
    const LENGTH: f64 = 40.0;
    const ROUGHNESS: f64 = 0.05;
    const SPEED: f64 = 2.0;
    const END: f64 = 1.0;
    const WINDOW: std::ops::Range<f64> = 15.0..25.0;
    let mut problem = flat_strip(LENGTH, spacing, |_| 0.0);
    problem.bed.manning.fill(ROUGHNESS);
    fill(&mut problem, |_| film);
    let seeds = line_seeds(&problem);
    let slowing = GRAVITY * ROUGHNESS * ROUGHNESS * SPEED / film.powf(4.0 / 3.0);
    let velocity = SPEED / (1.0 + slowing * END);
    let exact = Box::new(move |_| (film, Vec2::new(velocity, 0.0)));
    let mut setup = Setup::new(problem, seeds, Dimension::One, Until::Time(END), exact);
    setup.velocity = Some(Box::new(|_| Vec2::new(SPEED, 0.0)));
    setup.counts = Box::new(|place| WINDOW.contains(&place.x));
    setup.scale_speed = SPEED;
    let measures = move |outcome: &Outcome| {
        let inside = outcome.end.samples.iter().filter(|sample| WINDOW.contains(&sample.place.x));
        let backwards = inside.map(|sample| -sample.velocity.x).fold(0.0, f64::max);
        vec![
            Measure::new(
                "mean velocity error over the velocity at the start",
                outcome.errors.velocity / SPEED,
                "",
                KEPT,
            ),
            Measure::new("velocity backwards", backwards, "m/s", Share { holds: 0.0, fails: 1e-9 }),
        ]
    };
    setup.limits = Some(Limits { speed: SPEED + fastest(film, 0.0), measures: Box::new(measures) });
    setup
}
