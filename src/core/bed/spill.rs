//! Where the bed holds water back: the level of each cell from which water runs off.
//!
//! ```text
//! s_i = min over all ways from i to an outlet of the highest face on the way,   face_ij = max(z_i, z_j, pass sill)
//! ```
//!
//! found from the outlets inwards, the lowest first (priority flood: Barnes, Lehman and Mulla 2014, Computers & Geosciences 62). Water of a cell
//! below its spill level stays. Without an outlet all of it does.
//!
//! Left out: walls that are lines, dams that may break, and of cells that follow lines those that stand for no square of the lattice, which hold
//! nothing here.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::BedParticles;
use crate::lattice::NEIGHBOURS;

/// A place on the finest level that is reached at a level (m).
struct Reached {
    level: f64,
    place: (usize, usize),
}

impl Ord for Reached {
    /// The lowest comes first, and of several the one that lies first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.level.total_cmp(&self.level).then_with(|| other.place.cmp(&self.place))
    }
}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Reached {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Reached {}

/// The spill level (m) of each cell that stands for its place, no lower than its bed; infinite where no way leads to one of the `outlets`,
/// which are cells, and of no meaning without terrain.
pub fn spill_levels(bed: &BedParticles, outlets: &[usize]) -> Vec<f64> {
    let lattice = &bed.lattice;
    let mut spill = bed.elevation.clone();
    let mut is_outlet = vec![false; lattice.len()];
    outlets.iter().for_each(|&cell| is_outlet[cell] = true);
    let mut ways = BinaryHeap::new();
    // A coarse cell comes once for each of its places, and goes on from there.
    let mut passed = vec![false; lattice.columns * lattice.rows];
    for row in 0..lattice.rows {
        for column in 0..lattice.columns {
            let cell = lattice.leaf(column, row);
            spill[cell] = f64::INFINITY;
            if is_outlet[cell] && bed.has_terrain(cell) {
                ways.push(Reached { level: bed.elevation[cell], place: (row, column) });
            }
        }
    }
    while let Some(Reached { level, place: (row, column) }) = ways.pop() {
        if std::mem::replace(&mut passed[row * lattice.columns + column], true) {
            continue;
        }
        let cell = lattice.leaf(column, row);
        spill[cell] = spill[cell].min(level);
        for (across, up) in NEIGHBOURS {
            let (Some(column), Some(row)) = (column.checked_add_signed(across), row.checked_add_signed(up)) else {
                continue;
            };
            if column >= lattice.columns || row >= lattice.rows || passed[row * lattice.columns + column] {
                continue;
            }
            let other = lattice.leaf(column, row);
            if bed.has_terrain(other) {
                let sill = if other == cell { f64::NEG_INFINITY } else { bed.passes.between(cell, other) };
                ways.push(Reached { level: level.max(bed.elevation[other]).max(sill), place: (row, column) });
            }
        }
    }
    spill
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bed::{PassSill, PassSills};
    use crate::lattice::Lattice;
    use crate::math::Vec2;

    /// A strip of cells of 1 m with these elevations.
    fn strip(elevation: &[f64]) -> BedParticles {
        BedParticles::from_elevation(Lattice::new(Vec2::ZERO, elevation.len(), 1, 1.0), elevation.to_vec(), 0.0)
    }

    #[test]
    fn pits_spill_over_the_lowest_way_to_an_outlet() {
        let bed = strip(&[3.0, 1.0, 2.0, 0.5, 1.5, 0.0]);
        assert_eq!(spill_levels(&bed, &[5]), [3.0, 2.0, 2.0, 1.5, 1.5, 0.0]);
        // An outlet at either end: each pit takes the lower way.
        assert_eq!(spill_levels(&bed, &[0, 5]), [3.0, 2.0, 2.0, 1.5, 1.5, 0.0]);
        assert_eq!(spill_levels(&bed, &[]), [f64::INFINITY; 6]);
        // Behind a hole in the terrain no water runs off.
        let parted = strip(&[1.0, f64::NAN, 0.0]);
        assert_eq!(spill_levels(&parted, &[2]), [f64::INFINITY, f64::INFINITY, 0.0]);
    }

    #[test]
    fn a_ridge_within_a_cell_holds_water_back() {
        let mut bed = strip(&[1.0, 0.5, 0.0]);
        bed.passes = PassSills::new(vec![PassSill::whole(1, false, 2.0)]);
        assert_eq!(spill_levels(&bed, &[2]), [2.0, 2.0, 0.0]);
    }

    #[test]
    fn a_bowl_spills_at_its_lowest_rim() {
        let rim = [3.0, 3.0, 3.0, 3.0, 0.0, 2.0, 3.0, 3.0, 3.0];
        let lattice = Lattice::new(Vec2::ZERO, 3, 3, 1.0);
        let bed = BedParticles::from_elevation(lattice, rim.to_vec(), 0.0);
        let edge: Vec<usize> = (0..9).filter(|cell| *cell != 4).collect();
        assert_eq!(spill_levels(&bed, &edge), [3.0, 3.0, 3.0, 3.0, 2.0, 2.0, 3.0, 3.0, 3.0]);
    }
}
