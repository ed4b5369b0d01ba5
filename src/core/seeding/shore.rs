//! The bed under still water, set so that each cell holds its share when it is filled to the level.
//!
//! ```text
//! z_b = η − V/Δ²,   V = ∫ max(η − terrain, 0) dA   over the cell inside the polygon
//! ```
//!
//! For a cell under water that is the mean of the terrain; for one with the shore in it, the mean of the terrain with what
//! stands above the level cut down to it. The bed is never set below the lowest terrain in the cell, because no part of the
//! cell is deeper than that. A cell that the rim of the polygon cuts where the ground beyond is dry holds what lies
//! inside; where a filled pocket lies beyond, or the terrain ends, it counts whole: a bed that is raised along the edge of the
//! terrain, because the polygon ends short of it, would be a row of sills in the flow that comes later.
//!
//! Cells in part (`bed::Cover`) count whole, with all of their area, and keep their bed where no shore runs through them.
//!
//! Left as they are: cells that the rim cuts beside open ground or another body, and those on the way there (`Filling::approach`),
//! where a raised bed would be a sill in open water: the opening of a dam would be narrower up to the rim than beyond it. So are
//! cells that the rim cuts at a wall, where a cell is filled whole or not at all by the side on which its centre lies, and dry cells
//! beside ground below the level, which hold the water back.
//!
//! So are cells at an upright bank of the terrain's own pixels, as a quay is: those that an upright step divides
//! ([`is_divided_about`]), whose bed is the ground on its larger side, and those that the rim cuts beside one. A bed between its foot and its top
//! is neither, and would be a sill before it. They are filled whole or not at all; what that adds or takes is reported.
//!
//! So are dry cells on an upright bank that is not in the pixels: one that stands higher above the level than the water beside it is
//! deep, which no plane does. Cut down to the level, a house in a film would lose the cells of its outline to the flood that comes
//! later. What such cells would hold goes to the cells before the bank whose bed is raised for the part of the bank in them, as far as
//! they have room for it:
//!
//! ```text
//! V' = V + f (V_whole − V),   f = min(1, Σ V on the bank / Σ (V_whole − V))
//! ```
//!
//! with V_whole what a cell holds on the bed that it had.

use std::collections::BTreeSet;

use super::leaks::Filling;
use super::scan::{BodyScan, CellPart, volume_of_whole_cell};
use crate::bed::{NINE_CELLS, Surface, is_divided_about};

/// What was done to the bed.
#[derive(Default)]
pub(super) struct Shore {
    /// Number of cells with the shore or the rim in them whose bed was set.
    pub cells: usize,
    /// The largest change of the bed there (m).
    pub largest_change: f64,
    /// The largest change of the bed of cells wholly under water (m).
    pub largest_change_under_water: f64,
    /// What the cells at the edge of the terrain hold more than the polygon has there and beyond it (m³).
    pub at_edge: f64,
    /// What the cells at upright banks hold more than the polygon has there (m³); below 0 where they hold less.
    pub at_banks: f64,
}

impl Shore {
    /// Takes note of a change (m) of the bed of a cell.
    fn note(&mut self, part: CellPart, change: f64) {
        if part.is_cut() || part.has_shore {
            self.cells += usize::from(change > 0.0);
            self.largest_change = self.largest_change.max(change);
        } else {
            self.largest_change_under_water = self.largest_change_under_water.max(change);
        }
    }
}

/// A share less deep than this (m) is no water.
const SHALLOWEST_SHARE: f64 = 1e-6;
/// Changes of the bed less than this (m) are rounding: a plane stays a plane.
const ROUNDING: f64 = 1e-9;

/// Sets the bed of the cells of a body, and fills those at its shore that thereby come to lie below its level.
///
/// - `(number, level)`: the body
/// - `reached`: the cells that its polygon touches and those of its pockets, in ascending order
pub(super) fn fit_bed_to_water(
    (number, level): (u32, f64),
    scan: &BodyScan,
    reached: &[usize],
    filling: &mut Filling,
    surface: &impl Surface,
) -> Shore {
    let approach = filling.approach(number, level, reached);
    let mut banks = upright_banks((number, level), reached, filling);
    banks.retain(|&cell| !is_at_pixel_bank(cell, scan.part(cell), filling, surface));
    let mut shore = Shore::default();
    // Cells with their beds before; those before a bank, with the room (m³) that is left in them.
    let (mut set, mut foot) = (Vec::new(), Vec::new());
    let (mut on_banks, mut in_part) = (0.0, 0.0);
    for &cell in reached {
        let part = scan.part(cell);
        let (is_in_part, area) = (filling.bed.cover.holds(cell), filling.bed.area(cell));
        let is_set = filling.bed.has_terrain(cell)
            && is_to_be_set((number, level), cell, part, (filling, &approach))
            && !(is_in_part && is_at_pixel_bank(cell, part, filling, surface));
        if is_in_part && !(is_set && part.has_shore && !banks.contains(&cell)) {
            if filling.body[cell] == Some(number) {
                in_part += (level - filling.bed.elevation[cell]) * area - part.volume;
            } else if !filling.bed.has_terrain(cell) {
                in_part -= part.volume;
            }
            continue;
        }
        if !filling.bed.has_terrain(cell) {
            shore.at_edge -= part.volume;
            continue;
        }
        if !is_set {
            continue;
        }
        let whole = || volume_of_whole_cell(level, cell, filling.bed, surface);
        let is_before_pocket = || filling.neighbours(cell, level).any(|other| is_pocket(number, other, scan, filling));
        let is_at_edge = || filling.neighbours(cell, level).any(|other| !filling.bed.has_terrain(other));
        let is_at_pixel_bank = is_at_pixel_bank(cell, part, filling, surface);
        let before = filling.bed.elevation[cell];
        let mut share = part.volume;
        if banks.contains(&cell) {
            on_banks += share;
            continue;
        }
        if is_in_part {
            share = whole() * filling.bed.cover.cell(cell).area;
            in_part += share - part.volume;
        } else if part.is_cut() && (part.coverage <= 0.0 || is_before_pocket()) {
            share = whole();
        } else if part.is_cut() && is_at_edge() {
            share = whole();
            shore.at_edge += share - part.volume;
        } else if !is_at_pixel_bank && filling.neighbours(cell, level).any(|other| banks.contains(&other)) {
            foot.push((cell, ((level - before) * area - share).max(0.0)));
        }
        if is_at_pixel_bank {
            let held = if filling.body[cell].is_some() { (level - before) * area } else { 0.0 };
            shore.at_banks += held - share;
            continue;
        }
        let is_wet = share / area > SHALLOWEST_SHARE;
        filling.body[cell] = is_wet.then_some(number);
        let z_b = if is_wet { level - share / area } else { before.max(level) };
        if (z_b - before).abs() > ROUNDING {
            filling.bed.elevation[cell] = z_b;
        }
        set.push((cell, before));
    }
    let room: f64 = foot.iter().map(|(_, room)| room).sum();
    let fraction = if room > 0.0 { (on_banks / room).min(1.0) } else { 0.0 };
    for (cell, room) in foot {
        if filling.body[cell] == Some(number) {
            filling.bed.elevation[cell] -= fraction * room / filling.bed.area(cell);
        }
    }
    shore.at_edge = shore.at_edge.max(0.0) + in_part;
    for (cell, before) in set {
        shore.note(scan.part(cell), (filling.bed.elevation[cell] - before).abs());
    }
    shore
}

/// Whether a cell is at an upright bank of the terrain's own pixels: one divides it or, where the rim cuts it, stands beside it.
fn is_at_pixel_bank(cell: usize, part: CellPart, filling: &Filling, surface: &impl Surface) -> bool {
    let cells = if part.is_cut() { NINE_CELLS } else { 1.0 };
    is_divided_about(surface, filling.bed, cell, cells)
}

/// Dry cells that stand higher above the level than the water of a body beside them is deep.
fn upright_banks((number, level): (u32, f64), reached: &[usize], filling: &Filling) -> BTreeSet<usize> {
    let z_b = &filling.bed.elevation;
    let is_upright = |&cell: &usize| {
        let wet = filling.neighbours(cell, level).filter(|&other| filling.body[other] == Some(number));
        let lowest = wet.map(|other| z_b[other]).reduce(f64::min);
        lowest.is_some_and(|lowest| z_b[cell] - level > level - lowest)
    };
    let is_dry = |&cell: &usize| filling.body[cell].is_none() && filling.bed.has_terrain(cell);
    reached.iter().copied().filter(is_dry).filter(is_upright).collect()
}

/// Whether a cell outside the polygon is filled.
pub(super) fn is_pocket(number: u32, cell: usize, scan: &BodyScan, filling: &Filling) -> bool {
    filling.body[cell] == Some(number) && scan.part(cell).coverage <= 0.0
}

/// Whether the bed of a cell is to be set.
fn is_to_be_set(
    (number, level): (u32, f64),
    cell: usize,
    part: CellPart,
    (filling, approach): (&Filling, &BTreeSet<usize>),
) -> bool {
    let is_beside_other_water = || {
        let is_other = |body: Option<u32>| body.is_some_and(|body| body != number);
        filling.neighbours(cell, level).any(|other| is_other(filling.body[other]))
    };
    let is_enclosed = || !filling.is_at_wall(cell) && filling.gaps(cell, level).next().is_none();
    match filling.body[cell] {
        Some(body) if body == number && part.is_cut() => is_enclosed() && !is_beside_other_water(),
        Some(body) if body == number => !approach.contains(&cell),
        Some(_) => false,
        None => {
            let is_beside_water = || filling.neighbours(cell, level).any(|other| filling.body[other] == Some(number));
            !filling.is_below(cell, level)
                && part.volume > 0.0
                && (part.holds_centre || is_beside_water())
                && is_enclosed()
                && !is_beside_other_water()
        }
    }
}
