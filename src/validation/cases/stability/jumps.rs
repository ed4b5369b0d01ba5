//! Hydraulic jumps that stand still along the lattice, as wide as long, over a bed with noise of a micrometre: rows of the lattice must not drift apart.

use super::{behind_jump, cell_seeds, fastest, fill};
use crate::math::Vec2;
use crate::physics::dimension::Dimension;
use crate::scenario::GRAVITY;
use crate::scenario::methods::Core;
use crate::solver::{Boundary, Condition, Series};
use crate::validation::case::{Case, Setup, SetupResult, Suite, Until};
use crate::validation::judge::{Limits, Measure, Share};
use crate::validation::outcome::{Outcome, Sample};
use crate::validation::scene::problem;

/// The cases.
pub const CASES: &[Case] = &[
    jump(
        "wide_jump_2",
        "A hydraulic jump of Froude number 2 standing along the lattice, 20 m wide, 100 s: rows must stay alike.",
        |s, m| wide(s, m, 2.0),
    ),
    jump("wide_jump_3", "The same at Froude number 3.", |s, m| wide(s, m, 3.0)),
    jump("wide_jump_5", "The same at Froude number 5.", |s, m| wide(s, m, 5.0)),
    jump("wide_jump_8", "The same at Froude number 8.", |s, m| wide(s, m, 8.0)),
];

const fn jump(name: &'static str, about: &'static str, setup: fn(f64, Core) -> SetupResult) -> Case {
    Case {
        name,
        suite: Suite::Stability,
        about,
        is_tuned: false,
        spacings: &[0.5],
        tested: 1,
        acceptance_limits: &[],
        setup,
    }
}

/// A jump in the middle of a channel fed from the west and held at the depth behind the jump in the east.
fn wide(spacing: f64, core: Core, froude: f64) -> SetupResult {
    const SHALLOW: f64 = 1.0;
    const END: f64 = 100.0;
    const LENGTH: f64 = 40.0;
    const WIDTH: f64 = 20.0;
    const JUMP: f64 = 0.5 * LENGTH;
    /// Amplitude of the noise of the bed (m).
    const NOISE: f64 = 1e-6;
    if core == Core::Variational {
        return Err("jumps of the variational formulation are known to wander".to_owned());
    }
    let speed = froude * (GRAVITY * SHALLOW).sqrt();
    let deep = behind_jump(SHALLOW, froude);
    let behind = speed * SHALLOW / deep;
    let state = move |x: f64| if x < JUMP { (SHALLOW, speed) } else { (deep, behind) };
    let noise = |place: Vec2| NOISE * (((place.x * 12.9898 + place.y * 78.233).sin() * 43_758.545_3).fract() - 0.5);
    let (columns, rows) = ((LENGTH / spacing).round() as usize, (WIDTH / spacing).round() as usize);
    let mut problem = problem(columns, rows, spacing, noise);
    problem.forcing.reach = 0.3 * spacing;
    let inflow = Condition::Discharge {
        discharge: Series::constant(speed * SHALLOW * WIDTH),
        level: Some(Series::constant(SHALLOW)),
    };
    for (x, condition) in [(0.0, inflow), (LENGTH, Condition::Stage(Series::constant(deep)))] {
        let side = vec![[Vec2::new(x, 0.0), Vec2::new(x, WIDTH)]];
        problem.forcing.boundaries.push(Boundary { pieces: side.into(), condition });
    }
    fill(&mut problem, |place| state(place.x).0);
    let seeds = cell_seeds(&problem);
    let exact = move |place: Vec2| (state(place.x).0, Vec2::new(state(place.x).1, 0.0));
    let mut setup = Setup::new(problem, seeds, Dimension::Two, Until::Time(END), Box::new(exact));
    setup.velocity = Some(Box::new(move |place| Vec2::new(state(place.x).1, 0.0)));
    setup.scale_speed = speed + (GRAVITY * SHALLOW).sqrt();
    let measures = move |outcome: &Outcome| {
        let is_behind = |sample: &&Sample| sample.place.x > JUMP + 5.0 && sample.place.x < LENGTH - 2.0;
        let off = |sample: &Sample| (sample.velocity - Vec2::new(behind, 0.0)).norm() / behind;
        let worst = outcome.end.samples.iter().filter(is_behind).map(off).fold(0.0, f64::max);
        let halfway = 0.5 * (SHALLOW + deep);
        let place = |row: usize| {
            let depths = &outcome.end.depth_on_lattice[row * columns..][..columns];
            let last = depths.iter().rposition(|d| *d < halfway).unwrap_or(0);
            let next = depths.get(last + 1).copied().unwrap_or(deep);
            last as f64 + 0.5 + (halfway - depths[last]) / (next - depths[last])
        };
        let moved = (0..rows).map(|row| (place(row) - JUMP / spacing).abs()).fold(0.0, f64::max);
        vec![
            Measure::new("velocity behind off by the share", worst, "", Share { holds: 0.05, fails: 0.5 }),
            Measure::new("the jump moved by", moved, "spacings", Share { holds: 1.0, fails: 4.0 }),
        ]
    };
    setup.limits = Some(Limits { speed: speed + fastest(SHALLOW, 0.0), measures: Box::new(measures) });
    Ok(setup)
}
