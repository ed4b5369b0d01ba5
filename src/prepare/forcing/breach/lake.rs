//! The lake behind a dam: its filling on the ground with the dam, the ground as the lake has shaped it, and the cross-section along the dam.

use std::collections::BTreeSet;

use super::dam::dam_cell;
use super::{BESIDE_DAM, Opened};
use crate::bed::BedParticles;
use crate::math::Vec2;
use crate::output::{Section, SetBy};
use crate::prepare::findings::Findings;
use crate::prepare::ground::burn::{Foot, foot_of};
use crate::prepare::ground::gaps::around;
use crate::prepare::ground::{Change, Ground, Made};
use crate::prepare::water::{self, SourcedBody};
use crate::seeding::{Barriers, StillWater};
use crate::solver::{Breach, DamCell, RimCell, Trigger};

/// A bed raised by no more than this (m) is rounding.
const ROUND_OFF: f64 = 1e-9;

/// The bed of the dam, as far as it stands at a share of its growth.
pub fn beds(breach: &Breach, share: f64) -> Vec<Change> {
    breach.beds(share).map(|(cell, z_b)| Change { cell, made: Made::Bed(z_b), by: SetBy::Dam }).collect()
}

/// The terrain in the cells that a dam raises at a share of its growth.
fn terrain(breach: &Breach, share: f64) -> Vec<Change> {
    let level = |cell: &DamCell| {
        let z_b = breach.bed(cell, share);
        if share <= 0.0 { Some(breach.crest) } else { Some(z_b).filter(|z_b| *z_b > cell.ground) }
    };
    let change = |cell: &DamCell| {
        let made = Made::RaiseTerrain(level(cell)?);
        Some(Change { cell: cell.cell, made, by: SetBy::Dam })
    };
    breach.cells.iter().filter_map(change).collect()
}

/// The cells in which a dam stands above its ground at a share of its growth, ascending.
fn cells_standing(breach: &Breach, share: f64) -> Vec<usize> {
    let stands = |cell: &&DamCell| breach.bed(cell, share) > cell.ground;
    breach.cells.iter().filter(stands).map(|cell| cell.cell).collect()
}

/// Fills the lake behind the dam, on the bed that the dam has at the start: one that goes at once then never stands, and its run is that
/// without a dam. Leaks are those with the dam standing.
pub fn fill_behind(
    breach: Option<&Breach>,
    bodies: &[SourcedBody],
    (walls, is_complete): (&[[Vec2; 2]], bool),
    ground: &mut Ground<'_>,
    findings: &mut Findings,
) -> StillWater {
    let share = breach.map_or(0.0, Breach::share_at_start);
    let standing_at = |share| breach.map_or(Vec::new(), |breach| cells_standing(breach, share));
    if let Some(breach) = breach.filter(|_| share > 0.0) {
        let mut with_dam = ground.clone();
        with_dam.take(beds(breach, 0.0));
        with_dam.take(terrain(breach, 0.0));
        let dam = standing_at(0.0);
        water::fill(bodies, &mut with_dam, Barriers { walls, dam: &dam }, is_complete, findings);
    }
    breach.into_iter().for_each(|breach| ground.take(terrain(breach, share)));
    let is_complete = is_complete && share <= 0.0;
    let dam = standing_at(share);
    water::fill(bodies, ground, Barriers { walls, dam: &dam }, is_complete, findings)
}

/// Takes the bed as the lake has shaped it: below a dam that is gone at the start, and beside one that stands, where what the shore raised
/// would be a sill before its opening and sinks with it.
///
/// - `before`: the bed (m) before the lake was filled
pub fn settle(opened: &Opened, breach: &mut Breach, before: &[f64], bed: &BedParticles) {
    let share = breach.share_at_start();
    if share > 0.0 {
        for cell in &mut breach.cells {
            if before[cell.cell] <= cell.ground {
                cell.ground = bed.elevation[cell.cell];
            }
        }
        return;
    }
    let lattice = &bed.lattice;
    let line: Vec<Vec2> = opened.line.iter().map(|place| lattice.to_local(*place)).collect();
    let dam: BTreeSet<usize> = breach.cells.iter().map(|cell| cell.cell).collect();
    let beside: BTreeSet<usize> = dam.iter().flat_map(|cell| around(*cell, lattice)).collect();
    let is_raised = |cell: &usize| !dam.contains(cell) && bed.elevation[*cell] > before[*cell] + ROUND_OFF;
    let rim = |cell: usize| RimCell { at: dam_cell(cell, &line, lattice, before[cell]), raised: bed.elevation[cell] };
    breach.rim = beside.into_iter().filter(is_raised).map(rim).collect();
}

/// Name of the cross-section along the dam; an underscore more for each one of that name that the scenario has.
const SECTION: &str = "breach";

/// The cross-section along the dam, through which the flood passes: drawn so that what leaves the lake counts as positive.
pub fn section(
    opened: &Opened,
    breach: &Breach,
    others: &[Section],
    bed: &BedParticles,
    water: &StillWater,
) -> Section {
    let lattice = &bed.lattice;
    let mut line = opened.line.clone();
    let local: Vec<Vec2> = line.iter().map(|place| lattice.to_local(*place)).collect();
    // Water is counted towards the left of the line.
    if rise_to_the_left(&local, breach, bed, water) > 0.0 {
        line.reverse();
    }
    let mut id = SECTION.to_owned();
    while others.iter().any(|other| other.id == id) {
        id.push('_');
    }
    Section { id, line }
}

/// How much higher the lake stands on the left of the dam than what is on its right (m, summed along the dam): by the water of the start where it
/// lies beside the dam, or else by the place whose level the dam waits for, or by the ground, which falls downstream.
fn rise_to_the_left(line: &[Vec2], breach: &Breach, bed: &BedParticles, water: &StillWater) -> f64 {
    let lattice = &bed.lattice;
    let [start, end] = [line.first(), line.last()].map(|place| place.copied().unwrap_or_default());
    let left = (end - start).perpendicular() * (1.0 / (end - start).norm().max(f64::MIN_POSITIVE));
    let beside = |cell: &DamCell, side: f64| {
        let place = lattice.centre(cell.cell) + left * (side * BESIDE_DAM * lattice.spacing);
        lattice.cell_at(place).filter(|cell| bed.has_terrain(*cell))
    };
    let pairs: Vec<[usize; 2]> =
        breach.cells.iter().filter_map(|cell| Some([beside(cell, 1.0)?, beside(cell, -1.0)?])).collect();
    let is_wet = |pair: &&[usize; 2]| pair.iter().any(|cell| water.depth[*cell] > 0.0);
    let has_water = pairs.iter().any(|pair| is_wet(&pair));
    if let (Trigger::Level { place, .. }, false) = (&breach.trigger, has_water) {
        let Foot { foot, direction, .. } = foot_of(*place, line);
        return (*place - foot).dot(direction.perpendicular());
    }
    let level = |cell: usize| bed.elevation[cell] + water.depth[cell];
    let counted = pairs.iter().filter(|pair| !has_water || is_wet(pair));
    counted.map(|[on_left, on_right]| level(*on_left) - level(*on_right)).sum()
}
