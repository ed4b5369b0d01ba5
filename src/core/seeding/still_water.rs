//! Filling polygons to their level: the depth of still water at every cell of the lattice, and its volume.
//!
//! A cell is filled exactly to the level or not at all, because a lake at rest must be level to the last digit:
//!
//! ```text
//! d = η − z_b
//! ```
//!
//! The volume to be met is the integral of max(level − terrain, 0) over the polygon (`scan.rs`). Steps for each body:
//!
//! 1. Cells whose centre lies in the polygon and below the level are filled, and the pockets that their water reaches outside
//!    the polygon (`leaks.rs`). A sliver of the polygon beyond a wall is left out.
//! 2. The bed of the filled cells, and of those that the shore cuts, is set so that each holds its share of the integral
//!    (`shore.rs`): the volume is then met cell by cell, and the lake is level.
//! 3. Where the rim lies in open water, as along a dam that is taken away, a set bed would be a sill. There the volume is met
//!    by taking in cells that the rim cuts (those covered most come first) or leaving them out (those covered least), the
//!    latter beside open ground only: a lake is filled up to its pockets, and holds what they hold.
//!
//! Cells at an upright bank of the terrain's pixels keep their bed, and the volume to be met is that which they hold.
//!
//! What is left is reported: cells at a wall, filled whole or not at all, and a body of a few cells in open water.
//! Where bodies overlap the later one wins.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::StillBody;
use super::leaks::{Barriers, Filling, Leak};
use super::scan::{BodyScan, scan_body};
use super::scan_line::ScanLines;
use super::shore::{fit_bed_to_water, is_pocket};
use crate::bed::{BedParticles, Surface};
use crate::constants::SeedingConstants;

/// What the seeded volume may differ from the integral, relative.
pub const VOLUME_TOLERANCE: f64 = 1e-3;

/// The volumes of one body of still water.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SeededVolume {
    /// Integral of level minus terrain over the polygon, where positive (m³); parts that later bodies cover are left out. Up to the edge
    /// of the terrain in the cells there, and with what the cells at upright banks hold.
    pub integral_m3: f64,
    /// The part of it that a polygon which ends short of the edge of the terrain leaves out, less what a polygon has beyond cells in part.
    pub at_edge_m3: f64,
    /// The part of it that cells at upright banks of the terrain's pixels hold more than the polygon has there, because they are filled
    /// whole or not at all; below 0 where they hold less.
    pub at_banks_m3: f64,
    /// Volume on the lattice (m³).
    pub seeded_m3: f64,
    /// Number of cells with water.
    pub cells: usize,
    /// Cells at the rim taken in or left out against the rule of the centre.
    pub toggled: usize,
    /// Cells outside the rule of the centre that were filled because the lake reaches them at its level and stops there.
    pub pocket_cells: usize,
    /// Cells with the shore or the rim of the polygon in them whose bed was set to hold their share of the water.
    pub shore_cells: usize,
    /// The largest change of the bed there (m), upwards or downwards.
    pub largest_bed_change_at_shore: f64,
    /// The largest change of the bed of cells wholly under water (m): to the mean of the terrain from what the bed method says.
    pub largest_bed_change_under_water: f64,
    /// Area of the polygon (m²), as far as it lies on the lattice.
    pub area_m2: f64,
    /// Area of that where there is no terrain within a cell (m²).
    pub area_without_terrain_m2: f64,
    /// Where the water would leave the polygon at its level, the lowest place of each gap, deepest first.
    pub leaks: Vec<Leak>,
}

impl SeededVolume {
    /// (seeded − integral) / integral; 0 for a body without water.
    pub fn relative_error(&self) -> f64 {
        if self.integral_m3 > 0.0 { (self.seeded_m3 - self.integral_m3) / self.integral_m3 } else { 0.0 }
    }

    /// `at_banks_m3` over the integral over the polygon alone; 0 for a body without water.
    pub fn share_at_banks(&self) -> f64 {
        let own = self.integral_m3 - self.at_edge_m3 - self.at_banks_m3;
        if own > 0.0 { self.at_banks_m3 / own } else { 0.0 }
    }

    /// Whether the seeded volume is as near to the integral as promised. A body of a few cells may not be: its shore is
    /// finer than the lattice.
    pub fn is_within_tolerance(&self) -> bool {
        self.relative_error().abs() <= VOLUME_TOLERANCE
    }
}

/// Still water on the lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct StillWater {
    /// Depth d (m) of every cell.
    pub depth: Vec<f64>,
    /// Number of the body that fills a cell.
    pub body: Vec<Option<u32>>,
    /// The volumes of each body, in the order given.
    pub volumes: Vec<SeededVolume>,
}

impl StillWater {
    /// The volumes alone: the water itself is in the core by then.
    pub fn into_volumes(self) -> Vec<SeededVolume> {
        self.volumes
    }
}

/// Fills bodies of still water; returns the water, and the cells whose bed is to be set to hold their share of it, ascending, with that
/// bed (m).
///
/// - `surface`: the terrain itself, for the integral
/// - `barriers`: what water does not pass beside the bed
/// - `constants`: those of the method
pub fn fill_still_water(
    bodies: &[StillBody],
    bed: &BedParticles,
    surface: &impl Surface,
    barriers: Barriers<'_>,
    constants: &SeedingConstants,
) -> (StillWater, Vec<(usize, f64)>) {
    let lines: Vec<ScanLines> = bodies.iter().map(|body| ScanLines::new(&body.polygon, &bed.lattice)).collect();
    let scans: Vec<BodyScan> =
        (0..bodies.len()).map(|number| scan_body(bodies[number].level, &lines[number..], bed, surface)).collect();

    let mut shaped = bed.clone();
    let mut filling = Filling::new(&mut shaped, barriers, *constants);
    for (number, (body, scan)) in bodies.iter().zip(&scans).enumerate() {
        for &(cell, _) in scan.cells.iter().filter(|(_, part)| part.holds_centre) {
            if filling.is_below(cell, body.level) {
                filling.body[cell] = Some(number as u32);
            }
        }
    }
    let mut volumes = Vec::with_capacity(bodies.len());
    for (number, (body, scan)) in bodies.iter().zip(scans).enumerate() {
        volumes.push(adjust(number as u32, body.level, scan, &mut filling, surface));
    }
    let body = filling.body;
    let depth = body
        .par_iter()
        .zip(&shaped.elevation)
        .map(|(body, &z_b)| body.map_or(0.0, |number| bodies[number as usize].level - z_b))
        .collect();
    let is_set = |&cell: &usize| shaped.elevation[cell].to_bits() != bed.elevation[cell].to_bits();
    let set = (0..bed.lattice.len()).filter(is_set).map(|cell| (cell, shaped.elevation[cell])).collect();
    (StillWater { depth, body, volumes }, set)
}

/// Fills the pockets of a body, fits the bed to its shore, brings its volume near the integral, and finds its leaks.
fn adjust(number: u32, level: f64, scan: BodyScan, filling: &mut Filling, surface: &impl Surface) -> SeededVolume {
    let holds = |filling: &Filling, cells: &[usize]| -> Vec<usize> {
        cells.iter().copied().filter(|&cell| filling.body[cell] == Some(number)).collect()
    };
    let mut reached: Vec<usize> = scan.cells.iter().map(|&(cell, _)| cell).collect();
    let mut open = filling.open_ground(level, &scan);
    filling.leave_out_slivers(number, level, &scan, &mut open);
    let by_centre = holds(filling, &reached);
    let pockets = filling.fill_pockets(number, level, &by_centre, &open);
    reached.extend(&pockets);
    reached.sort_unstable();
    reached.dedup();
    let shore = fit_bed_to_water((number, level), &scan, &reached, filling, surface);
    let integral = scan.integral + shore.at_edge + shore.at_banks;
    let toggled = meet_volume((number, level), (&scan, integral), &reached, filling);
    let cells = holds(filling, &reached);
    SeededVolume {
        integral_m3: integral,
        at_edge_m3: shore.at_edge,
        at_banks_m3: shore.at_banks,
        seeded_m3: cells.iter().map(|&cell| volume_of(filling, cell, level)).sum(),
        cells: cells.len(),
        toggled,
        pocket_cells: pockets.len(),
        shore_cells: shore.cells,
        largest_bed_change_at_shore: shore.largest_change,
        largest_bed_change_under_water: shore.largest_change_under_water,
        area_m2: scan.area,
        area_without_terrain_m2: scan.area_without_terrain,
        leaks: filling.leaks(level, &cells),
    }
}

/// Volume (m³) of a cell that is filled to a level.
fn volume_of(filling: &Filling, cell: usize, level: f64) -> f64 {
    (level - filling.bed.elevation[cell]) * filling.bed.area(cell)
}

/// Takes in and leaves out cells cut by the rim until the volume is within the tolerance or no cell brings it nearer.
/// Returns the number of cells that differ from before.
fn meet_volume(
    (number, level): (u32, f64),
    (scan, integral): (&BodyScan, f64),
    reached: &[usize],
    filling: &mut Filling,
) -> usize {
    let mut rim: Vec<(usize, f64)> = scan
        .cells
        .iter()
        .filter(|&&(cell, part)| part.is_cut() && filling.is_below(cell, level))
        .map(|&(cell, part)| (cell, part.coverage))
        .collect();
    rim.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let before: Vec<Option<u32>> = rim.iter().map(|&(cell, _)| filling.body[cell]).collect();
    let held: BTreeSet<usize> =
        rim.iter().map(|&(cell, _)| cell).filter(|&cell| filling.body[cell] == Some(number)).collect();
    // Dry ground between the lake and a pocket, or beside what was left out, would be a trench in the lake.
    let is_beside_open_ground = |filling: &Filling, cell: usize| {
        filling.gaps(cell, level).any(|other| !held.contains(&other))
            && !filling.neighbours(cell, level).any(|other| is_pocket(number, other, scan, filling))
    };
    let volume_aim = filling.constants.volume_aim;
    let filled = reached.iter().filter(|&&cell| filling.body[cell] == Some(number));
    let mut surplus = filled.map(|&cell| volume_of(filling, cell, level)).sum::<f64>() - integral;
    loop {
        let at_start = surplus;
        let is_taking_in = surplus < 0.0;
        for place in 0..rim.len() {
            if surplus.abs() <= volume_aim * integral || (surplus < 0.0) != is_taking_in {
                break;
            }
            // Best covered first when taking in, least covered first when leaving out.
            let cell = if is_taking_in { rim[place].0 } else { rim[rim.len() - 1 - place].0 };
            let volume = volume_of(filling, cell, level);
            let is_useful = volume < 2.0 * surplus.abs();
            let is_possible = if is_taking_in {
                filling.body[cell].is_none()
                    && filling.neighbours(cell, level).any(|other| filling.body[other] == Some(number))
            } else {
                filling.body[cell] == Some(number) && is_beside_open_ground(filling, cell)
            };
            if is_useful && is_possible {
                filling.body[cell] = is_taking_in.then_some(number);
                surplus += if is_taking_in { volume } else { -volume };
            }
        }
        #[expect(clippy::float_cmp, reason = "unchanged means that no cell was toggled")]
        if surplus == at_start {
            break;
        }
    }
    rim.iter().zip(before).filter(|&(&(cell, _), before)| filling.body[cell] != before).count()
}

#[cfg(test)]
pub(crate) mod tests;
