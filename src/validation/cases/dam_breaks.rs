//! Dam breaks in a channel of unit width, 2000 m long with the dam in its middle, 10 m of water behind it.
//!
//! The channel, depths, spacing and times are those of `Wu2020`, so that their tables can be laid beside ours.

use std::sync::OnceLock;

use crate::math::Vec2;
use crate::physics::dimension::Dimension;
use crate::scenario::methods::{Core, Motion};
use crate::validation::case::{AcceptanceLimit, Case, Checks, Exact, Scope, Setup, SetupResult, Suite, Until};
use crate::validation::exact::{Profile, plane_dam_break, ritter, ritter_front, stoker};
use crate::validation::outcome::{Check, Snapshot};
use crate::validation::scene::{self, flat_strip, line_seeds, seeds_at};

/// Length of the channel (m).
pub const LENGTH: f64 = 2000.0;
/// Place of the dam (m).
pub const DAM: f64 = 1000.0;
/// Depth behind the dam (m).
pub const DEEP: f64 = 10.0;
/// Time of the comparison (s).
pub const END: f64 = 50.0;
/// Times (s) around that one, over which the bore crosses cells of every spacing.
const MOMENTS: [f64; 13] = [44.0, 45.0, 46.0, 47.0, 48.0, 49.0, 50.0, 51.0, 52.0, 53.0, 54.0, 55.0, 56.0];
/// Depth (m) that makes the front, and how far its place may be off, relatively.
const FRONT: (f64, f64) = (0.01, 0.05);
/// Manning's n (s·m^(−1/3)) of the rough channel.
const ROUGHNESS: f64 = 0.03;
/// Cells of its reference: a fifth of the finest spacing, of second order.
const REFERENCE_CELLS: usize = 4000;

/// Rows of cells of the channel where it is a plane.
const ROWS: usize = 20;

/// What is asked on dry bed; the same of a single row and of a plane.
const RITTER_BARS: &[AcceptanceLimit] = &[
    AcceptanceLimit {
        scope: Scope::Of(Motion::Lagrangian),
        spacing: Some(10.0),
        depth: Some(0.021),
        velocity: Some(0.021),
        ..AcceptanceLimit::NONE
    },
    AcceptanceLimit { scope: Scope::Of(Motion::Lagrangian), order: Some((1.0, Some(1.0))), ..AcceptanceLimit::NONE },
    AcceptanceLimit {
        scope: Scope::Of(Motion::Eulerian),
        spacing: Some(10.0),
        depth: Some(0.017),
        ..AcceptanceLimit::NONE
    },
    AcceptanceLimit { scope: Scope::Of(Motion::Eulerian), order: Some((1.0, None)), ..AcceptanceLimit::NONE },
    AcceptanceLimit { checks: true, ..AcceptanceLimit::NONE },
];

/// What is asked on wet bed.
const STOKER_BARS: &[AcceptanceLimit] = &[
    AcceptanceLimit {
        scope: Scope::Of(Motion::Lagrangian),
        spacing: Some(10.0),
        depth: Some(0.024),
        velocity: Some(0.026),
        ..AcceptanceLimit::NONE
    },
    AcceptanceLimit {
        scope: Scope::Of(Motion::Eulerian),
        spacing: Some(10.0),
        depth: Some(0.0165),
        velocity: Some(0.019),
        ..AcceptanceLimit::NONE
    },
    AcceptanceLimit { order: Some((1.0, Some(1.0))), ..AcceptanceLimit::NONE },
];

/// A dam break in the plane, on which nothing was tuned.
const fn in_plane(
    name: &'static str,
    about: &'static str,
    acceptance_limits: &'static [AcceptanceLimit],
    setup: fn(f64, Core) -> SetupResult,
) -> Case {
    Case {
        name,
        suite: Suite::Analytic,
        about,
        is_tuned: false,
        spacings: &[10.0, 5.0, 2.5],
        tested: 2,
        acceptance_limits,
        setup,
    }
}

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "ritter",
        suite: Suite::Analytic,
        about: "Dam break on dry bed against Ritter's solution: 10 m of water, 50 s; the front at 1 cm depth within 5 %.",
        is_tuned: true,
        spacings: &[10.0, 5.0, 2.5],
        tested: 2,
        acceptance_limits: RITTER_BARS,
        setup: |spacing, _| Ok(channel(spacing, 0.0, END)),
    },
    in_plane(
        "ritter_plane",
        "The same as ritter in a plane of 20 rows of cells: along a single row particles cannot leave their line.",
        RITTER_BARS,
        |spacing, _| Ok(plane(spacing, 0.0)),
    ),
    Case {
        name: "stoker",
        suite: Suite::Analytic,
        about: "Dam break on wet bed, 10 m over 5 m, against Stoker's solution at 50 s: a bore and a rarefaction.",
        is_tuned: true,
        spacings: &[10.0, 5.0, 2.5],
        tested: 2,
        acceptance_limits: STOKER_BARS,
        setup: |spacing, _| Ok(channel(spacing, 5.0, END)),
    },
    in_plane(
        "stoker_plane",
        "The same as stoker in a plane of 20 rows of cells: along a single row particles cannot leave their line.",
        STOKER_BARS,
        |spacing, _| Ok(plane(spacing, 5.0)),
    ),
    Case {
        name: "stoker_moments",
        suite: Suite::Analytic,
        about: "The same as stoker, errors averaged over 13 moments from 44 to 56 s: at one moment the order is also that of \
                the place of the bore within its cell.",
        is_tuned: true,
        spacings: &[10.0, 5.0, 2.5],
        tested: 2,
        acceptance_limits: &[AcceptanceLimit { order: Some((1.0, Some(1.0))), ..AcceptanceLimit::NONE }],
        setup: |spacing, _| Ok(channel_at_moments(spacing, 5.0)),
    },
    Case {
        name: "stoker_strong",
        suite: Suite::Analytic,
        about: "Dam break over thin water, 10 m over 0.1 m, against Stoker's solution at 50 s: errors must fall with the spacing.",
        is_tuned: true,
        spacings: &[10.0, 5.0, 2.5],
        tested: 2,
        acceptance_limits: &[AcceptanceLimit { order: Some((0.0, Some(0.0))), ..AcceptanceLimit::NONE }],
        setup: |spacing, _| Ok(channel(spacing, 0.1, END)),
    },
    Case {
        name: "wu_dry",
        suite: Suite::Analytic,
        about: "The dry dam break of Wu et al. (2020), spacing 10 m, 50 s; they report 0.0356 m and 0.0351 m/s.",
        is_tuned: true,
        spacings: &[10.0, 5.0, 2.5],
        tested: 1,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(channel(spacing, 0.0, 50.0)),
    },
    Case {
        name: "wu_wet_30s",
        suite: Suite::Analytic,
        about: "The wet dam break of Wu et al. (2020), 10 m over 5 m, spacing 10 m, at 30 s.",
        is_tuned: true,
        spacings: &[10.0, 5.0, 2.5],
        tested: 1,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(channel(spacing, 5.0, 30.0)),
    },
    Case {
        name: "wu_wet_50s",
        suite: Suite::Analytic,
        about: "The wet dam break of Wu et al. (2020) at 50 s; they report 0.0613 m and 0.0603 m/s.",
        is_tuned: true,
        spacings: &[10.0, 5.0, 2.5],
        tested: 1,
        acceptance_limits: &[],
        setup: |spacing, _| Ok(channel(spacing, 5.0, 50.0)),
    },
    Case {
        name: "dressler",
        suite: Suite::Analytic,
        about: "Dam break on dry bed with friction (Manning n = 0.03), 50 s, against finite volumes of 0.5 m, because \
                Dressler's own series holds for Chezy's friction, and away from the tip only.",
        is_tuned: false,
        spacings: &[10.0, 5.0, 2.5],
        tested: 2,
        acceptance_limits: &[],
        setup: |spacing, _| rough_channel(spacing),
    },
];

fn still_channel(spacing: f64, right: f64) -> (crate::solver::FlowProblem, Vec<crate::particles::FluidSeed>) {
    let mut problem = flat_strip(LENGTH, spacing, |_| 0.0);
    let lattice = &problem.bed.lattice;
    let depth = |place: Vec2| if place.x < DAM { DEEP } else { right };
    problem.initial_depth = (0..lattice.len()).map(|cell| depth(lattice.centre(cell))).collect();
    let seeds = line_seeds(&problem);
    (problem, seeds)
}

/// The answer at a time (s) with `right` (m) of water beyond the dam.
fn answer(right: f64, time: f64) -> Exact {
    Box::new(move |place| {
        let x = place.x - DAM;
        let (d, u) = if right > 0.0 { stoker(DEEP, right, x, time) } else { ritter(DEEP, x, time) };
        (d, Vec2::new(u, 0.0))
    })
}

/// The channel compared at each of [`MOMENTS`].
fn channel_at_moments(spacing: f64, right: f64) -> Setup {
    let [earlier @ .., end] = MOMENTS;
    let earlier = earlier.map(|time| (time, answer(right, time))).into();
    Setup { earlier, ..channel(spacing, right, end) }
}

/// The channel without friction, `right` (m) of water beyond the dam, compared at `end` (s).
pub fn channel(spacing: f64, right: f64, end: f64) -> Setup {
    let (problem, seeds) = still_channel(spacing, right);
    let mut setup = Setup::new(problem, seeds, Dimension::One, Until::Time(end), answer(right, end));
    setup.checks = checks_of_front(spacing, right, end);
    setup
}

/// The channel without friction as a plane of [`ROWS`] rows between straight walls, compared at [`END`].
fn plane(spacing: f64, right: f64) -> Setup {
    let mut problem = scene::problem((LENGTH / spacing).round() as usize, ROWS, spacing, |_| 0.0);
    let lattice = &problem.bed.lattice;
    let places: Vec<Vec2> = (0..lattice.len()).map(|cell| lattice.centre(cell)).collect();
    let depth = |place: Vec2| if place.x < DAM { DEEP } else { right };
    problem.initial_depth = places.iter().map(|&place| depth(place)).collect();
    let seeds = seeds_at(&problem, &places, problem.bed.lattice.cell_area(), depth);
    let mut setup = Setup::new(problem, seeds, Dimension::Two, Until::Time(END), answer(right, END));
    setup.checks = checks_of_front(spacing, right, END);
    setup
}

/// On dry bed the place of the front at a time (s).
fn checks_of_front(spacing: f64, right: f64, time: f64) -> Option<Checks> {
    let place = ritter_front(DEEP, FRONT.0, time);
    let checks: Checks = Box::new(move |_, last| vec![front(last, spacing, place)]);
    (right == 0.0).then_some(checks)
}

/// The rough channel against its reference.
fn rough_channel(spacing: f64) -> SetupResult {
    static REFERENCE: OnceLock<Profile> = OnceLock::new();
    let reference =
        REFERENCE.get_or_init(|| plane_dam_break((DEEP, 0.0), DAM, (LENGTH, REFERENCE_CELLS), ROUGHNESS, END));
    let (mut problem, seeds) = still_channel(spacing, 0.0);
    problem.bed.manning.fill(ROUGHNESS);
    let exact: Exact = Box::new(|place| {
        let (d, u) = reference.at(place.x);
        (d, Vec2::new(u, 0.0))
    });
    let mut setup = Setup::new(problem, seeds, Dimension::One, Until::Time(END), exact);
    let place = reference.reach(FRONT.0) - DAM;
    setup.checks = Some(Box::new(move |_, last| vec![front(last, spacing, place)]));
    Ok(setup)
}

/// The easternmost place on the lattice, between two cells, where the depth falls below that of the front, against where it should
/// be (m from the dam); in a plane the depth is that of the mean row.
fn front(end: &Snapshot, spacing: f64, exact: f64) -> Check {
    let columns = (LENGTH / spacing).round() as usize;
    let rows = end.depth_on_lattice.chunks(columns);
    let share_of_row = 1.0 / rows.len() as f64;
    let mut depth = vec![0.0; columns];
    for row in rows {
        depth.iter_mut().zip(row).for_each(|(mean, depth)| *mean += depth * share_of_row);
    }
    let last = depth.iter().rposition(|depth| *depth >= FRONT.0).unwrap_or(0);
    let next = depth.get(last + 1).copied().unwrap_or(0.0);
    let share = (depth[last] - FRONT.0) / (depth[last] - next).max(f64::MIN_POSITIVE);
    let found = (last as f64 + 0.5 + share.clamp(0.0, 1.0)) * spacing - DAM;
    let error = found / exact - 1.0;
    Check {
        found: format!("front at 1 cm {found:.0} m from the dam, exact {exact:.0} m ({:+.1} %)", 100.0 * error),
        is_met: error.abs() <= FRONT.1,
    }
}
