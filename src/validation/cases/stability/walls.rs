//! Walls: a closed box with its corners, and a gap as wide as one spacing.

use super::{cell_seeds, energy_gain, fastest, fill};
use crate::math::Vec2;
use crate::physics::dimension::Dimension;
use crate::scenario::GRAVITY;
use crate::validation::case::{Case, Setup, Suite, Until};
use crate::validation::judge::{Limits, Measure, Share};
use crate::validation::outcome::Outcome;
use crate::validation::scene::problem;

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "corners",
        suite: Suite::Stability,
        about: "A block of water, 3 m wide and 1 m deep, let go in a corner of a closed dry box of 8 m, 8 s, reflected by the other \
                corners: nobody leaves, symmetry about the diagonal, energy does not grow.",
        is_tuned: false,
        spacings: &[0.25, 0.125],
        tested: 1,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(corners(spacing)),
    },
    Case {
        name: "gap",
        suite: Suite::Stability,
        about: "Water 1 m deep runs through a gap of 0.4 m between two walls, as wide as one spacing (two at the finer one), 10 s, \
                against the volume over a weir of that width, which nothing may exceed.",
        is_tuned: false,
        spacings: &[0.4, 0.2],
        tested: 1,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(gap(spacing)),
    },
];

fn corners(spacing: f64) -> Setup {
    const SIZE: f64 = 8.0;
    const BLOCK: f64 = 3.0;
    const WATER: f64 = 1.0;
    const END: f64 = 8.0;
    let cells = (SIZE / spacing).round() as usize;
    let mut problem = problem(cells, cells, spacing, |_| 0.0);
    fill(&mut problem, |place| if place.x.max(place.y) < BLOCK { WATER } else { 0.0 });
    let seeds = cell_seeds(&problem);
    let mut setup = Setup::without_answer(problem, seeds, Dimension::Two, Until::Time(END));
    let measures = move |outcome: &Outcome| {
        let is_inside = |place: Vec2| (0.0..=SIZE).contains(&place.x) && (0.0..=SIZE).contains(&place.y);
        let outside = outcome.end.samples.iter().filter(|sample| !is_inside(sample.place)).count();
        let depth = &outcome.end.depth_on_lattice;
        let mirrored = |cell: usize| depth[(cell % cells) * cells + cell / cells];
        let off: f64 = (0..depth.len()).map(|cell| (depth[cell] - mirrored(cell)).abs()).sum();
        let unequal = off / depth.iter().sum::<f64>();
        vec![
            Measure::new("particles outside", outside as f64, "", Share { holds: 0.0, fails: 0.0 }),
            Measure::new("share of the water off its mirror image", unequal, "", Share { holds: 1e-9, fails: 0.1 }),
            energy_gain(outcome, 0.0),
        ]
    };
    setup.limits = Some(Limits { speed: fastest(WATER, 0.0), measures: Box::new(measures) });
    setup
}

fn gap(spacing: f64) -> Setup {
    const SIZE: (f64, f64) = (12.0, 6.0);
    const GAP: f64 = 0.4;
    const WATER: f64 = 1.0;
    const END: f64 = 10.0;
    let wall = 0.5 * SIZE.0;
    let (columns, rows) = ((SIZE.0 / spacing).round() as usize, (SIZE.1 / spacing).round() as usize);
    let mut problem = problem(columns, rows, spacing, |_| 0.0);
    let (south, north) = (0.5 * (SIZE.1 - GAP), 0.5 * (SIZE.1 + GAP));
    problem.walls =
        vec![[Vec2::new(wall, 0.0), Vec2::new(wall, south)], [Vec2::new(wall, north), Vec2::new(wall, SIZE.1)]];
    fill(&mut problem, |place| if place.x < wall { WATER } else { 0.0 });
    let seeds = cell_seeds(&problem);
    let weir = over_weir(WATER, GAP, wall * SIZE.1, END);
    let mut setup = Setup::without_answer(problem, seeds, Dimension::Two, Until::Time(END));
    let measures = move |outcome: &Outcome| {
        let beyond = outcome.end.samples.iter().filter(|sample| sample.place.x > wall);
        let share = beyond.map(|sample| sample.volume).sum::<f64>() / weir;
        vec![
            // The jet behind a sharp edge is about 0.6 as wide as the gap.
            Measure::new("share of the weir's volume held back", 1.0 - share, "", Share { holds: 0.4, fails: 0.8 }),
            Measure::new("volume over the weir's", share, "", Share { holds: 1.0, fails: 1.2 }),
        ]
    };
    setup.limits = Some(Limits { speed: fastest(WATER, 0.0), measures: Box::new(measures) });
    setup
}

/// Volume (m³) over a broad weir from a basin, dH/dt = −(2/3)^(3/2) √g H^(3/2) width/area: the greatest that the energy of still water
/// lets through.
fn over_weir(depth: f64, width: f64, area: f64, time: f64) -> f64 {
    let rate = (2.0_f64 / 3.0).powf(1.5) * GRAVITY.sqrt() * width / area;
    let left = (depth.powf(-0.5) + 0.5 * rate * time).powi(-2);
    area * (depth - left)
}
