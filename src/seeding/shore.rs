//! The bed of cells at the shore, set so that the cell holds its share of the water when it is filled to the level.
//!
//! ```text
//! z_b = η − V/Δ²,   V = ∫ max(η − terrain, 0) dA   over the cell inside the polygon
//! ```
//!
//! For a cell wholly inside the polygon that is the mean of the terrain with what stands above the level cut down to it. The
//! bed is never set below the lowest terrain in the cell, because no part of it is deeper than that. A cell whose uncovered part
//! is water as well, because a filled pocket lies behind it, counts whole.
//!
//! Left as they are: cells wholly under water; cells beside open ground, where a raised bed would be a sill in the breach;
//! cells at a wall, which are filled whole or not at all by the side on which their centre lies; and dry cells beside
//! ground below the level, which hold the water back.

use super::leaks::Filling;
use super::scan::{BodyScan, volume_of_whole_cell};
use crate::bed::Surface;

/// What was done to the bed.
#[derive(Default)]
pub(super) struct Shore {
    /// Number of cells with another bed.
    pub cells: usize,
    /// The largest change of the bed (m).
    pub largest_change: f64,
}

/// A share less deep than this (m) is no water.
const SHALLOWEST_SHARE: f64 = 1e-6;

/// Sets the bed of the cells at the shore of a body, and fills those that thereby come to lie below its level.
///
/// - `(number, level)`: the body
/// - `reached`: the cells that its polygon touches and those of its pockets, in ascending order
pub(super) fn fit_bed_to_shore(
    (number, level): (u32, f64),
    scan: &BodyScan,
    reached: &[usize],
    filling: &mut Filling,
    surface: &impl Surface,
) -> Shore {
    let mut shore = Shore::default();
    let area = filling.bed.lattice.cell_area();
    for &cell in reached {
        if !filling.bed.has_terrain(cell) || !is_at_shore(number, level, cell, scan, filling) {
            continue;
        }
        let part = scan.part(cell);
        let is_before_pocket = || filling.neighbours(cell).any(|other| is_pocket(number, other, scan, filling));
        let share = if part.is_cut() && (part.coverage <= 0.0 || is_before_pocket()) {
            volume_of_whole_cell(level, cell, filling.bed, surface)
        } else {
            part.volume
        };
        let before = filling.bed.elevation[cell];
        let is_wet = share / area > SHALLOWEST_SHARE;
        let z_b = if is_wet { level - share / area } else { before.max(level) };
        filling.body[cell] = is_wet.then_some(number);
        filling.bed.elevation[cell] = z_b;
        shore.cells += 1;
        shore.largest_change = shore.largest_change.max((z_b - before).abs());
    }
    shore
}

/// Whether a cell outside the polygon is filled.
fn is_pocket(number: u32, cell: usize, scan: &BodyScan, filling: &Filling) -> bool {
    filling.body[cell] == Some(number) && scan.part(cell).coverage <= 0.0
}

/// Whether the bed of a cell is to be set.
fn is_at_shore(number: u32, level: f64, cell: usize, scan: &BodyScan, filling: &Filling) -> bool {
    let part = scan.part(cell);
    let is_filled = filling.body[cell] == Some(number);
    let is_below = filling.is_below(cell, level);
    let is_partly_wet = if is_filled {
        part.is_cut() || part.has_shore
    } else {
        let is_beside_water = || filling.neighbours(cell).any(|other| filling.body[other] == Some(number));
        filling.body[cell].is_none() && !is_below && part.volume > 0.0 && (part.holds_centre || is_beside_water())
    };
    is_partly_wet && !filling.is_at_wall(cell) && filling.gaps(cell, level).next().is_none()
}
