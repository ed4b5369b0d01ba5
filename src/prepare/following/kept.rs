//! Squares that stay as they are though cells about them follow lines.

use std::collections::BTreeSet;

use crate::bed::{BedParticles, SHUT};
use crate::lattice::{Lattice, NEIGHBOURS};
use crate::math::Vec2;
use crate::prepare::ground::Changes;
use crate::solver::{ChannelEnd, Forcing, OpenEdges};

/// Squares that stay as they are around what needs the lattice: boundaries, dams, cells in part.
const KEPT_AROUND: isize = 1;

/// The squares that stay as they are: those at open edges, and what is on the lattice in another way. Where no water passes some lines (`are_walls`),
/// levees and other ridges hold that meet them, and do so on squares alone.
pub fn kept(
    bed: &BedParticles,
    (changes, are_walls): (&Changes, bool),
    forcing: &Forcing,
    open_edges: &OpenEdges,
) -> Vec<bool> {
    let lattice = &bed.lattice;
    let is_ground = |cell: usize| bed.has_terrain(cell) || is_built(bed, cell);
    let is_open = |cell: usize, step: (isize, isize)| {
        let normal = Vec2::new(step.0 as f64, step.1 as f64);
        let middle = lattice.centre(cell) + normal * (0.5 * lattice.spacing);
        let is_edge = lattice.neighbour(cell, step).is_none_or(|other| !is_ground(other));
        is_edge && (open_edges.is_open(middle, normal) || forcing.boundary_at(middle, normal).is_some())
    };
    let is_at_open_edge = |&cell: &usize| NEIGHBOURS.iter().any(|&step| is_open(cell, step));
    let mut cells: BTreeSet<usize> =
        (0..lattice.len()).filter(|&cell| is_ground(cell)).filter(is_at_open_edge).collect();
    cells.extend(bed.cover.cells().iter().map(|part| part.cell));
    if are_walls {
        cells.extend(changes.raised().filter(|&cell| bed.has_terrain(cell)));
        let ridges = bed.passes.iter().filter(|sill| sill.level < SHUT);
        cells.extend(ridges.flat_map(|sill| [sill.cell, sill.other(lattice)]));
    }
    if let Some(breach) = &forcing.breach {
        cells.extend(breach.cells_and_rim());
    }
    cells.extend(forcing.moving_bed.iter().flat_map(|motion| motion.cells.iter().map(|(cell, _)| *cell)));
    let ends = forcing.channels.iter().flat_map(|channel| [&channel.far, &channel.near]);
    cells.extend(ends.flat_map(ChannelEnd::joined_cells));
    let mut kept = vec![false; lattice.len()];
    for cell in cells {
        around(lattice, cell, KEPT_AROUND).for_each(|near| kept[near] = true);
    }
    kept
}

/// Whether a square has terrain under a blocked building that holds its centre.
pub fn is_built(bed: &BedParticles, cell: usize) -> bool {
    bed.sealed.binary_search(&cell).is_ok()
}

/// The squares at most so many columns and rows from one.
pub fn around(lattice: &Lattice, cell: usize, reach: isize) -> impl Iterator<Item = usize> {
    let steps = (-reach..=reach).flat_map(move |up| (-reach..=reach).map(move |across| (across, up)));
    steps.filter_map(move |step| lattice.neighbour(cell, step))
}
