//! Where a flood goes on beyond the end of a run on coarse cells, which close narrow valleys and whose fronts lag.
//!
//! From the cells that the water reached the way down is followed over the lowest ground in each coarse cell, as water finds it: of all cells beside
//! those seen the lowest is next, so that hollows fill up to their rims. It ends at the edge of the lattice, where the hollows would hold all of the
//! flood, and so far beyond the water as [`FURTHER`] says. The depth is taken along.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::unseen_flow::{Greatest, REACHED};
use crate::bed::BedParticles;
use crate::lattice::Lattice;
use crate::math::Rectangle;

/// A way is followed so far, over the length of the flood.
const FURTHER: f64 = 0.5;
/// Heights are ordered by whole parts of a metre of this number.
const ORDERED: f64 = 1e6;

/// The eight cells about a cell.
const AROUND: [(isize, isize); 8] = [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1)];

/// The depths (m) of a flood on its way beyond the cells that it reached in a run on level `number`; 0 in those cells, and where it does not come.
///
/// - `at_start`: depths (m) of the cells at the start
pub(super) fn beyond(
    greatest: &Greatest,
    at_start: &[f64],
    finest: &BedParticles,
    (number, coarse): (usize, &Lattice),
) -> Vec<f64> {
    let mut beyond = vec![0.0; greatest.depth.len()];
    let lowest = lowest_ground(finest, number, coarse);
    let is_flooded = |cell: usize| greatest.depth[cell] >= REACHED && at_start[cell] < REACHED;
    let flooded: Vec<usize> = (0..lowest.len()).filter(|&cell| is_flooded(cell) && !lowest[cell].is_nan()).collect();
    let limit = FURTHER * length(&flooded, coarse);
    let mut left = flooded.iter().map(|&cell| greatest.depth[cell]).sum::<f64>();
    let mut is_seen = vec![false; lowest.len()];
    // By height, and in the order of the cells: depth and way (m) beyond the water.
    let mut next: BinaryHeap<Reverse<(i64, usize)>> = BinaryHeap::new();
    let mut brought = vec![(0.0, 0.0); lowest.len()];
    let order = |height: f64| (ORDERED * height).round() as i64;
    for cell in flooded {
        is_seen[cell] = true;
        brought[cell] = (greatest.depth[cell], 0.0);
        next.push(Reverse((order(lowest[cell]), cell)));
    }
    while let Some(Reverse((height, cell))) = next.pop() {
        let (column, row) = coarse.column_row(cell);
        if column == 0 || row == 0 || column + 1 == coarse.columns || row + 1 == coarse.rows {
            break;
        }
        let (depth, way) = brought[cell];
        left -= height as f64 / ORDERED - lowest[cell];
        if left < 0.0 {
            break;
        }
        if greatest.depth[cell] < REACHED {
            beyond[cell] = depth;
        }
        for offset in AROUND {
            let Some(beside) = coarse.neighbour(cell, offset) else { continue };
            let further = way + coarse.spacing * f64::hypot(offset.0 as f64, offset.1 as f64);
            let was_wet = at_start[beside] >= REACHED;
            if is_seen[beside] || was_wet || lowest[beside].is_nan() || further > limit {
                continue;
            }
            is_seen[beside] = true;
            brought[beside] = (depth, further);
            next.push(Reverse((height.max(order(lowest[beside])), beside)));
        }
    }
    beyond
}

/// The diagonal (m) of the rectangle about the centres of some cells; 0 about none.
fn length(cells: &[usize], lattice: &Lattice) -> f64 {
    let about = Rectangle::about(cells.iter().map(|&cell| lattice.centre(cell)));
    about.map_or(0.0, |Rectangle { low, high }| (high - low).norm())
}

/// The lowest ground (m) of the finest cells in each cell of level `number`; not a number where there is none.
fn lowest_ground(finest: &BedParticles, number: usize, coarse: &Lattice) -> Vec<f64> {
    let mut lowest = vec![f64::NAN; coarse.columns * coarse.rows];
    for row in 0..finest.lattice.rows {
        for column in 0..finest.lattice.columns {
            let of_coarse = &mut lowest[(row >> number) * coarse.columns + (column >> number)];
            *of_coarse = of_coarse.min(finest.elevation[finest.lattice.index(column, row)]);
        }
    }
    lowest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec2;

    /// A valley from west to east in cells of 10 m, five of them wide, in high ground; the lowest ground of its floor falls or rises along it.
    fn valley(floor: impl Fn(usize) -> f64) -> BedParticles {
        let lattice = Lattice::new(Vec2::ZERO, 160, 48, 10.0);
        let elevation = (0..lattice.len()).map(|cell| {
            let (column, row) = lattice.column_row(cell);
            if (17..22).contains(&row) { floor(column) } else { 100.0 }
        });
        BedParticles::from_elevation(lattice.clone(), elevation.collect(), 0.03)
    }

    /// The coarse cells, of 80 m, that are reached when the water ended in the seventh.
    fn reached(bed: &BedParticles) -> Vec<usize> {
        let coarse = Lattice::new(Vec2::ZERO, 20, 6, 80.0);
        let (mut depth, mut at_start) = (vec![0.0; coarse.len()], vec![0.0; coarse.len()]);
        for column in 1..7 {
            depth[coarse.index(column, 2)] = 2.0;
        }
        (depth[coarse.index(0, 2)], at_start[coarse.index(0, 2)]) = (5.0, 5.0);
        let greatest = Greatest { discharge: vec![0.0; depth.len()], depth };
        let beyond = beyond(&greatest, &at_start, bed, (3, &coarse));
        (0..coarse.len()).filter(|&cell| f64::max(greatest.depth[cell], beyond[cell]) >= REACHED).collect()
    }

    #[test]
    fn a_flood_goes_on_down_its_valley_for_half_of_its_length() {
        let bed = valley(|column| 50.0 - 0.1 * column as f64);
        // 400 m long; 200 m further are two cells.
        assert_eq!(reached(&bed), (40..49).collect::<Vec<usize>>());
    }

    #[test]
    fn it_fills_a_hollow_and_ends_before_a_dam_that_holds_it_all() {
        let with_rim = |rim: f64| valley(move |column| if column < 60 { 40.0 } else { rim });
        let [low, high] = [0.5, 60.0].map(|rim| reached(&with_rim(40.0 + rim)));
        assert!(low.contains(&48) && !high.contains(&48), "{low:?} {high:?}");
    }
}
