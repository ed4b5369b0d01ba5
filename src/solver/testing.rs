//! Problems for the tests of the cores.

use super::{FlowProblem, Forcing, OpenEdges};
use crate::bed::{BedParticles, derive_shape};
use crate::lattice::Lattice;
use crate::math::Vec2;

/// Still water of a level (m) over a bed (m), both by place, on so many columns and rows within walls.
pub(super) fn still_water(
    (columns, rows): (usize, usize),
    spacing: f64,
    bed: impl Fn(Vec2) -> f64,
    level: impl Fn(Vec2) -> f64,
) -> FlowProblem {
    let lattice = Lattice { origin: Vec2::ZERO, columns, rows, spacing };
    let elevation: Vec<f64> = (0..lattice.len()).map(|i| bed(lattice.centre(i))).collect();
    let initial_depth = (0..lattice.len()).map(|i| (level(lattice.centre(i)) - elevation[i]).max(0.0)).collect();
    let mut bed = BedParticles::from_elevation(lattice, elevation, 0.0);
    derive_shape(&mut bed);
    FlowProblem {
        bed,
        walls: Vec::new(),
        open_edges: OpenEdges::default(),
        forcing: Forcing { reach: 0.3 * spacing, ..Forcing::default() },
        initial_depth,
        gravity: 9.81,
        courant: 0.5,
        dry_depth: 1e-6,
    }
}
