//! Circular dam breaks in a quadrant whose two walls are the planes of symmetry.

use std::sync::OnceLock;

use crate::math::Vec2;
use crate::physics::dimension::Dimension;
use crate::scenario::methods::Core;
use crate::validation::case::{AcceptanceLimit, Case, Exact, Setup, Suite, Until};
use crate::validation::exact::{Accuracy, Profile, radial_dam_break};
use crate::validation::outcome::{Check, Sample, Snapshot};
use crate::validation::scene::{jittered_lattice, problem, seeds_at};

/// Edge of the quadrant (m).
pub const SIZE: f64 = 12.0;
/// Radius of the dam (m).
pub const DAM: f64 = 2.5;
/// Depths inside and outside (m).
pub const DEPTHS: (f64, f64) = (2.5, 0.5);
/// Time of the comparison (s).
pub const END: f64 = 1.4;
/// Cells are compared up to this radius (m), which no wave has reached.
const COMPARED: f64 = 10.0;
/// Cells of the reference, over 17 m: a twelfth of the finest spacing.
const REFERENCE_CELLS: usize = 4000;
/// Cells of the reference of first order, against which the bounds of the tests were measured.
const COARSE_REFERENCE_CELLS: usize = 2000;
/// Symmetry to the rounding of sums over some thousand particles.
const SYMMETRY: f64 = 1e-12;

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "circular_dam",
        suite: Suite::Analytic,
        about: "Circular dam break, 2.5 m over 0.5 m within 2.5 m, at 1.4 s against radial finite volumes of 4 mm; symmetric to 1e-12.",
        is_tuned: true,
        spacings: &[0.2, 0.1, 0.05],
        tested: 2,
        acceptance_limits: &[
            AcceptanceLimit { order: Some((1.0, Some(1.0))), ..AcceptanceLimit::NONE },
            AcceptanceLimit { checks: true, ..AcceptanceLimit::NONE },
        ],
        setup: |spacing, core| Ok(circular(spacing, core, Accuracy::Second)),
    },
    Case {
        name: "circular_dam_deep",
        suite: Suite::Analytic,
        about: "Circular dam break, 10 m over 1 m within 11 m, in a square of 50 m, at 0.69 s against radial finite volumes.",
        is_tuned: false,
        spacings: &[1.0, 0.5, 0.25],
        tested: 2,
        acceptance_limits: &[AcceptanceLimit { order: Some((0.0, Some(0.0))), ..AcceptanceLimit::NONE }],
        setup: |spacing, _| Ok(deep(spacing)),
    },
    Case {
        name: "spreading_cylinder",
        suite: Suite::Analytic,
        about: "A cylinder of water, 1 m high and wide, spreading on dry ground for 1 s to a fiftieth of its depth, against radial finite volumes.",
        is_tuned: true,
        spacings: &[0.1, 0.05, 0.025],
        tested: 2,
        acceptance_limits: &[],
        setup: |spacing, core| Ok(self::spreading(spacing, core)),
    },
];

fn radially(reference: &'static Profile) -> Exact {
    Box::new(|place| {
        let r = place.norm();
        let (d, u) = reference.at(r);
        (d, place * (u / r))
    })
}

/// The circular dam break, against a reference of either order.
pub fn circular(spacing: f64, core: Core, accuracy: Accuracy) -> Setup {
    static REFERENCES: [OnceLock<Profile>; 2] = [OnceLock::new(), OnceLock::new()];
    let (slot, cells) = match accuracy {
        Accuracy::First => (0, COARSE_REFERENCE_CELLS),
        Accuracy::Second => (1, REFERENCE_CELLS),
    };
    let reference = REFERENCES[slot].get_or_init(|| radial_dam_break(DEPTHS, DAM, (17.0, cells), END, accuracy));
    let level = |place: Vec2| if place.norm() < DAM { DEPTHS.0 } else { DEPTHS.1 };
    let mut setup = quadrant(SIZE, spacing, spacing, level, END, radially(reference));
    if core != Core::Variational {
        setup.counts = Box::new(|place| place.norm() < COMPARED);
    }
    setup.checks = Some(Box::new(|_, end| vec![symmetry(end)]));
    setup
}

/// The circular dam break as other codes were measured on it: in a whole square, whose edges no wave has reached.
fn deep(spacing: f64) -> Setup {
    static REFERENCE: OnceLock<Profile> = OnceLock::new();
    const CENTRE: Vec2 = Vec2::new(25.0, 25.0);
    let reference =
        REFERENCE.get_or_init(|| radial_dam_break((10.0, 1.0), 11.0, (40.0, REFERENCE_CELLS), 0.69, Accuracy::Second));
    let level = |place: Vec2| if (place - CENTRE).norm() < 11.0 { 10.0 } else { 1.0 };
    let exact = radially(reference);
    quadrant(50.0, spacing, spacing, level, 0.69, Box::new(move |place| exact(place - CENTRE)))
}

/// The spreading cylinder; the lattice of particles of the variational formulation and of their bed are different ones.
pub fn spreading(spacing: f64, core: Core) -> Setup {
    static REFERENCE: OnceLock<Profile> = OnceLock::new();
    let reference =
        REFERENCE.get_or_init(|| radial_dam_break((1.0, 1e-9), 1.0, (8.0, REFERENCE_CELLS), 1.0, Accuracy::First));
    let cell = match core {
        Core::Eulerian | Core::Lagrangian => spacing,
        Core::Variational => 0.1,
    };
    let level = |place: Vec2| if place.norm() < 1.0 { 1.0 } else { 0.0 };
    quadrant(8.0, cell, spacing, level, 1.0, radially(reference))
}

/// A square from the origin, `size` (m) wide, with cells of `cell` (m) and particles `spacing` (m) apart.
fn quadrant(size: f64, cell: f64, spacing: f64, level: fn(Vec2) -> f64, end: f64, exact: Exact) -> Setup {
    let cells = (size / cell).round() as usize;
    let mut problem = problem(cells, cells, cell, |_| 0.0);
    let seeds = seeds_at(&problem, &jittered_lattice(size, size, spacing, 0.0), spacing * spacing, level);
    let lattice = &problem.bed.lattice;
    problem.initial_depth = (0..lattice.len()).map(|cell| level(lattice.centre(cell))).collect();
    Setup::new(problem, seeds, Dimension::Two, Until::Time(end), exact)
}

/// How far the momentum is off the diagonal, and the depths of cells off their mirror images.
fn symmetry(end: &Snapshot) -> Check {
    let momentum = end.momentum();
    let mut worst = ((momentum.x - momentum.y) / momentum.x).abs();
    if !end.is_of_particles {
        let edge = (end.samples.len() as f64).sqrt().round() as usize;
        let depth = |sample: &Sample| sample.depth;
        for (i, sample) in end.samples.iter().enumerate() {
            worst = worst.max((depth(sample) - depth(&end.samples[(i % edge) * edge + i / edge])).abs());
        }
    }
    Check { found: format!("mirror symmetry to {worst:.1e}"), is_met: worst <= SYMMETRY }
}
