//! Fronts in a channel on a level bed: over thin water, into vacuum, restarted from a thin film, and a hydraulic jump standing still.

use super::{DEPTH, PLACE, behind_jump, depth_error, fastest, fill, front};
use crate::math::Vec2;
use crate::particles::FluidSeed;
use crate::physics::dimension::Dimension;
use crate::scenario::GRAVITY;
use crate::scenario::methods::Core;
use crate::validation::case::{Case, Setup, Suite, Until};
use crate::validation::cases::dam_breaks::{DAM, DEEP, END, LENGTH, channel};
use crate::validation::exact::{ritter, ritter_front, stoker};
use crate::validation::judge::{Limits, Measure, Share};
use crate::validation::outcome::Outcome;
use crate::validation::scene::{flat_strip, line_seeds};

/// Depth (m) that makes the front on dry ground.
const FRONT_DEPTH: f64 = 0.01;

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "over_film",
        suite: Suite::Stability,
        about: "Dam break, 10 m of water over a film of 5 mm, 50 s, against Stoker's solution: depth, place of the bore, speed.",
        is_tuned: false,
        spacings: &[10.0, 5.0],
        tested: 1,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(over_thin_water(spacing, 0.005)),
    },
    Case {
        name: "ratio_100",
        suite: Suite::Stability,
        about: "Dam break with a depth ratio of 100 to 1, 10 m over 0.1 m, 50 s, against Stoker's solution.",
        is_tuned: true,
        spacings: &[10.0, 5.0],
        tested: 1,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(over_thin_water(spacing, 0.1)),
    },
    Case {
        name: "ratio_1000",
        suite: Suite::Stability,
        about: "Dam break with a depth ratio of 1000 to 1, 10 m over 0.01 m, 50 s, against Stoker's solution.",
        is_tuned: false,
        spacings: &[10.0, 5.0],
        tested: 1,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(over_thin_water(spacing, 0.01)),
    },
    Case {
        name: "two_rarefactions",
        suite: Suite::Stability,
        about: "Water 1 m deep torn apart at 8 m/s to both sides, faster than it can follow (2c = 6.3 m/s), 5 s, against the exact \
                solution with a vacuum in the middle.",
        is_tuned: false,
        spacings: &[2.0, 1.0],
        tested: 1,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(torn_apart(spacing)),
    },
    Case {
        name: "restart_film",
        suite: Suite::Stability,
        about: "Restart from a thin film: Ritter's dam break is started from its exact state at 20 s, whose tip is millimetres thin \
                and 20 m/s fast, and compared at 50 s.",
        is_tuned: false,
        spacings: &[10.0, 5.0],
        tested: 1,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(restarted(spacing)),
    },
    Case {
        name: "standing_jump",
        suite: Suite::Stability,
        about: "A hydraulic jump standing still, Froude number 3, with Belanger's depths of 1 m and 3.77 m, 20 s: it may not wander.",
        is_tuned: false,
        spacings: &[1.0, 0.5],
        tested: 1,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(standing_jump(spacing, true)),
    },
    Case {
        name: "standing_jump_unequal",
        suite: Suite::Stability,
        about: "The same with particles of the variational formulation that are equally far apart on both sides at the start, so that those behind the jump \
                carry 3.77 times the volume of those that come.",
        is_tuned: false,
        spacings: &[1.0, 0.5],
        tested: 1,
        acceptance_limits: &[],
        setup: |spacing, core| match core {
            Core::Eulerian | Core::Lagrangian => Err("cells do not carry their volume along".to_owned()),
            Core::Variational => Ok(standing_jump(spacing, false)),
        },
    },
];

/// 10 m of water over thin water (m).
fn over_thin_water(spacing: f64, film: f64) -> Setup {
    let mut setup = channel(spacing, film, END);
    let depth_at = move |x: f64| stoker(DEEP, film, x, END).0;
    // The bore is the only place ahead of the dam where the exact depth jumps.
    let (mut behind, mut ahead) = (0.0, LENGTH - DAM);
    while ahead - behind > 1e-6 {
        let x = 0.5 * (behind + ahead);
        if depth_at(x) > 1.001 * film { behind = x } else { ahead = x }
    }
    let halfway = 0.5 * (depth_at(behind) + film);
    let measures = move |outcome: &Outcome| {
        let found = front(outcome, halfway, spacing) - DAM;
        vec![
            depth_error(outcome, DEEP),
            Measure::new("place of the bore off by the share", (found / behind - 1.0).abs(), "", PLACE),
        ]
    };
    setup.limits = Some(Limits { speed: fastest(DEEP, 0.0), measures: Box::new(measures) });
    setup
}

/// Two rarefactions that leave a vacuum between them.
fn torn_apart(spacing: f64) -> Setup {
    const LENGTH: f64 = 400.0;
    const SPEED: f64 = 8.0;
    const DEPTH_THERE: f64 = 1.0;
    const END: f64 = 5.0;
    /// Half of the window (m): the bores from the walls stay outside.
    const WINDOW: f64 = 100.0;
    const MIDDLE: f64 = 0.5 * LENGTH;
    let celerity = (GRAVITY * DEPTH_THERE).sqrt();
    let mut problem = flat_strip(LENGTH, spacing, |_| 0.0);
    fill(&mut problem, |_| DEPTH_THERE);
    let seeds = line_seeds(&problem);
    let exact = move |place: Vec2| {
        let (xi, side) = ((place.x - MIDDLE).abs() / END, (place.x - MIDDLE).signum());
        if xi >= SPEED + celerity {
            (DEPTH_THERE, Vec2::new(side * SPEED, 0.0))
        } else if xi > SPEED - 2.0 * celerity {
            let c = (xi - SPEED + 2.0 * celerity) / 3.0;
            (c * c / GRAVITY, Vec2::new(side * (xi - c), 0.0))
        } else {
            (0.0, Vec2::ZERO)
        }
    };
    let mut setup = Setup::new(problem, seeds, Dimension::One, Until::Time(END), Box::new(exact));
    setup.velocity = Some(Box::new(|place| Vec2::new(SPEED * (place.x - MIDDLE).signum(), 0.0)));
    setup.counts = Box::new(|place| (place.x - MIDDLE).abs() < WINDOW);
    setup.scale_speed = SPEED + 2.0 * celerity;
    let dry = 0.5 * (SPEED - 2.0 * celerity) * END;
    let measures = move |outcome: &Outcome| {
        let inside = outcome.end.samples.iter().filter(|sample| (sample.place.x - MIDDLE).abs() < dry);
        let left = inside.map(|sample| sample.depth).fold(0.0, f64::max);
        vec![
            depth_error(outcome, DEPTH_THERE),
            Measure::new("depth left in the vacuum", left, "m", Share { holds: 1e-3, fails: 2e-2 }),
        ]
    };
    setup.limits = Some(Limits { speed: SPEED + fastest(DEPTH_THERE, 0.0), measures: Box::new(measures) });
    setup
}

/// Ritter's dam break from its state at a later time.
fn restarted(spacing: f64) -> Setup {
    const START: f64 = 20.0;
    let mut problem = flat_strip(LENGTH, spacing, |_| 0.0);
    fill(&mut problem, |place| ritter(DEEP, place.x - DAM, START).0);
    let seeds = line_seeds(&problem);
    let exact = |place: Vec2| {
        let (d, u) = ritter(DEEP, place.x - DAM, END);
        (d, Vec2::new(u, 0.0))
    };
    let mut setup = Setup::new(problem, seeds, Dimension::One, Until::Time(END - START), Box::new(exact));
    setup.velocity = Some(Box::new(|place| Vec2::new(ritter(DEEP, place.x - DAM, START).1, 0.0)));
    let place = ritter_front(DEEP, FRONT_DEPTH, END);
    let measures = move |outcome: &Outcome| {
        let found = front(outcome, FRONT_DEPTH, spacing) - DAM;
        vec![
            depth_error(outcome, DEEP),
            Measure::new("place of the front at 1 cm off by the share", (found / place - 1.0).abs(), "", PLACE),
        ]
    };
    setup.limits = Some(Limits { speed: fastest(DEEP, 0.0), measures: Box::new(measures) });
    setup
}

/// A hydraulic jump at rest, behind which particles of the variational formulation have the volume of those before it where they are `equal`: such a jump is made
/// of the water that came through it.
fn standing_jump(spacing: f64, equal: bool) -> Setup {
    const FROUDE: f64 = 3.0;
    const SHALLOW: f64 = 1.0;
    const END: f64 = 20.0;
    /// Metres before and behind the jump: u₁ + c₁ = 12.5 m/s and c₂ = 6.1 m/s do not come from the closed ends into the window.
    const SIDES: (f64, f64) = (300.0, 180.0);
    const WINDOW: f64 = 30.0;
    /// Where the depth behind the jump is taken (m from it).
    const BEHIND: std::ops::Range<f64> = 15.0..30.0;
    let speed = FROUDE * (GRAVITY * SHALLOW).sqrt();
    let deep = behind_jump(SHALLOW, FROUDE);
    let state = move |x: f64| if x < SIDES.0 { (SHALLOW, speed) } else { (deep, speed * SHALLOW / deep) };
    let mut problem = flat_strip(SIDES.0 + SIDES.1, spacing, |_| 0.0);
    fill(&mut problem, |place| state(place.x).0);
    let mut seeds = line_seeds(&problem);
    if equal {
        seeds.retain(|seed| seed.position.x < SIDES.0);
        let y = 0.5 * spacing;
        let number = (SIDES.1 * deep / (SHALLOW * spacing)).round();
        let volume = SIDES.1 * deep / number;
        seeds.extend((0..number as usize).map(|k| {
            let position = Vec2::new(SIDES.0 + (k as f64 + 0.5) * SIDES.1 / number, y);
            FluidSeed { position, volume, depth: deep }
        }));
    }
    let exact = move |place: Vec2| (state(place.x).0, Vec2::new(state(place.x).1, 0.0));
    let mut setup = Setup::new(problem, seeds, Dimension::One, Until::Time(END), Box::new(exact));
    setup.velocity = Some(Box::new(move |place| Vec2::new(state(place.x).1, 0.0)));
    setup.counts = Box::new(|place| (place.x - SIDES.0).abs() < WINDOW);
    setup.scale_speed = setup.scale_speed.max(speed);
    let measures = move |outcome: &Outcome| {
        let depths = &outcome.end.depth_on_lattice;
        let wet = depths.iter().take(((SIDES.0 + WINDOW) / spacing) as usize);
        let halfway = 0.5 * (SHALLOW + deep);
        let last_shallow = wet.clone().rposition(|d| *d < halfway).unwrap_or(0);
        let moved = ((last_shallow as f64 + 1.0) * spacing - SIDES.0) / spacing;
        let bounds = Share { holds: 2.0, fails: 10.0 };
        let mut wandering = Measure::new("the jump moved by", moved.abs(), "spacings", bounds);
        if moved != 0.0 {
            wandering.found += if moved < 0.0 { " upstream" } else { " downstream" };
        }
        let behind = SIDES.0 + BEHIND.start..SIDES.0 + BEHIND.end;
        let cells = (behind.start / spacing) as usize..(behind.end / spacing) as usize;
        let mean = depths[cells.clone()].iter().sum::<f64>() / cells.len() as f64;
        vec![
            Measure::new("mean depth error over the depth", outcome.errors.depth / deep, "", DEPTH),
            wandering,
            Measure::new("mean depth behind the jump off by the share", (mean / deep - 1.0).abs(), "", DEPTH),
        ]
    };
    setup.limits = Some(Limits { speed: speed + fastest(SHALLOW, 0.0), measures: Box::new(measures) });
    setup
}
