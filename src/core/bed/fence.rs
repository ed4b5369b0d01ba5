//! The shortest fence that parts the two cells of a face: the width of a gap in a ridge, at any angle (M12).

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;

use super::sill::SHUT;

/// Lengths of fences are whole numbers, so that they are the same in any order: half of a pixel, and half of its diagonal.
const HALF_A_PIXEL: u64 = 1 << 20;
const HALF_A_DIAGONAL: u64 = 1_482_910;
/// Halvings of the range of levels in which the crest is looked for.
const HALVINGS: usize = 10;

/// The pixels of two cells, row by row from the far side of the one to the far side of the other.
pub(super) struct Window {
    pub columns: usize,
    /// The rows of each cell; one on the edge is a row of both.
    pub cells: [Range<usize>; 2],
    /// Elevation (m), without end where there is no terrain.
    pub values: Vec<f64>,
}

/// The share of a face that is open, and the level (m) of the rest; none where a ridge leaves all of it open or nothing, or is no
/// higher than the ground rises under it.
///
/// - `ground`: the same window without ridges
/// - `base` (m): the level at which the gap is measured
/// - `most`: a face of which more than this share is open has no gap
pub(super) fn opening(terrain: &Window, ground: &Window, base: f64, most: f64) -> Option<(f64, f64)> {
    let mut kept = vec![false; terrain.values.len()];
    for side in 0..2 {
        terrain.keep(base, side, &mut kept)?;
    }
    let share = |level: f64| match (terrain.fence(level, &kept), ground.fence(level, &kept)) {
        (Some(length), Some(free)) if free > 0 => length as f64 / free as f64,
        _ => 1.0,
    };
    let open = share(base);
    if open <= 0.0 || open > most {
        return None;
    }
    let top = terrain.range().1;
    let half = 0.5 * (1.0 + open);
    if share(top) < half {
        return Some((open, SHUT));
    }
    let (mut low, mut high) = (base, top);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if share(middle) < half {
            low = middle;
        } else {
            high = middle;
        }
    }
    let (lowest, highest) = ground.range();
    (high - base > highest - lowest).then_some((open, high))
}

impl Window {
    fn rows(&self) -> usize {
        self.values.len() / self.columns
    }

    /// Marks what no fence crosses on one side of the face: the far half of the widest place that lies no higher than a level (m), and
    /// what lies behind it. None where all is higher.
    fn keep(&self, level: f64, side: usize, kept: &mut [bool]) -> Option<()> {
        let columns = self.columns;
        let rows = self.cells[side].clone();
        let place = self.widest_place(level, rows.clone())?;
        let row_of = |pixel: &usize| *pixel / columns;
        let (from, to) = (place.iter().map(row_of).min()?, place.iter().map(row_of).max()?);
        for pixel in place {
            let (row, column) = (pixel / columns, pixel % columns);
            let (is_far, behind) = if side == 0 {
                (2 * row <= from + to, if row == from { 0..row } else { 0..0 })
            } else {
                (2 * row >= from + to, if row == to { row..rows.end } else { 0..0 })
            };
            kept[pixel] |= is_far;
            behind.for_each(|row| kept[row * columns + column] = true);
        }
        Some(())
    }

    /// What the largest squares no higher than a level (m) cover that fit into some rows; of several such places the largest, of
    /// equal ones the lowest, and all of those that are equal in both.
    fn widest_place(&self, level: f64, rows: Range<usize>) -> Option<Vec<usize>> {
        let columns = self.columns;
        // The side of the largest square whose last pixel is this one.
        let mut sides = vec![0usize; self.values.len()];
        for (row, column) in rows.clone().flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let pixel = row * columns + column;
            let is_inside = row > rows.start && column > 0;
            let before = [1, columns, columns + 1].map(|back| if is_inside { sides[pixel - back] } else { 0 });
            let smallest = before.into_iter().min().unwrap_or(0);
            sides[pixel] = if self.values[pixel] <= level { smallest + 1 } else { 0 };
        }
        let largest = sides.iter().copied().max().filter(|&side| side > 0)?;
        let mut is_wide = vec![false; self.values.len()];
        for last in (0..sides.len()).filter(|&pixel| sides[pixel] == largest) {
            for row in 0..largest {
                let end = last + 1 - row * columns;
                is_wide[end - largest..end].fill(true);
            }
        }
        // The size, the sum of heights and the pixels.
        let mut best = (0, 0.0, Vec::new());
        for first in rows.start * columns..rows.end * columns {
            let place = take_joined(first, columns, rows.end, &mut is_wide);
            let height = place.iter().map(|&pixel| self.values[pixel]).sum::<f64>();
            let is_larger = place.len() > best.0;
            if is_larger || place.len() == best.0 && height < best.1 {
                best = (place.len(), height, place);
            } else if !place.is_empty() && place.len() == best.0 && height <= best.1 {
                best.2.extend(place);
            }
        }
        Some(best.2)
    }

    /// Length of the shortest fence from the first column to the last that parts what lies no higher than a level (m): pixels above it
    /// cost nothing. None where what is kept leaves no way.
    fn fence(&self, level: f64, kept: &[bool]) -> Option<u64> {
        let columns = self.columns;
        let rows = self.rows();
        let is_open = |pixel: usize| u64::from(self.values[pixel] <= level);
        let mut lengths = vec![u64::MAX; self.values.len()];
        let mut next: BinaryHeap<Reverse<(u64, usize)>> = BinaryHeap::new();
        for pixel in (0..rows).map(|row| row * columns).filter(|&pixel| !kept[pixel]) {
            lengths[pixel] = HALF_A_PIXEL * is_open(pixel);
            next.push(Reverse((lengths[pixel], pixel)));
        }
        let mut shortest = None;
        while let Some(Reverse((length, pixel))) = next.pop() {
            if shortest.is_some_and(|shortest| length >= shortest) {
                break;
            }
            if length > lengths[pixel] {
                continue;
            }
            if pixel % columns + 1 == columns {
                let whole = length + HALF_A_PIXEL * is_open(pixel);
                shortest = Some(shortest.map_or(whole, |shortest: u64| shortest.min(whole)));
            }
            for (k, there) in neighbours(pixel, columns, rows).into_iter().enumerate() {
                let Some(there) = there.filter(|&there| !kept[there]) else { continue };
                let half = if k < 4 { HALF_A_PIXEL } else { HALF_A_DIAGONAL };
                let further = length + half * (is_open(pixel) + is_open(there));
                if further < lengths[there] {
                    lengths[there] = further;
                    next.push(Reverse((further, there)));
                }
            }
        }
        shortest
    }

    /// The lowest and the highest elevation (m) where there is terrain.
    fn range(&self) -> (f64, f64) {
        let finite = self.values.iter().filter(|z| z.is_finite());
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &z| (low.min(z), high.max(z)))
    }
}

/// Takes the marked pixels that hang together with one over edges; none if it is not marked.
fn take_joined(first: usize, columns: usize, rows: usize, is_marked: &mut [bool]) -> Vec<usize> {
    let mut place = Vec::new();
    let mut take = |pixel: usize, place: &mut Vec<usize>| {
        if std::mem::take(&mut is_marked[pixel]) {
            place.push(pixel);
        }
    };
    take(first, &mut place);
    let mut next = 0;
    while let Some(&pixel) = place.get(next) {
        neighbours(pixel, columns, rows).into_iter().take(4).flatten().for_each(|there| take(there, &mut place));
        next += 1;
    }
    place
}

/// The pixels around a pixel: those that it shares an edge with, then those at its corners.
fn neighbours(pixel: usize, columns: usize, rows: usize) -> [Option<usize>; 8] {
    let (column, row) = (pixel % columns, pixel / columns);
    [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1)].map(|(dc, dr): (isize, isize)| {
        let (column, row) = (column.checked_add_signed(dc)?, row.checked_add_signed(dr)?);
        (column < columns && row < rows).then(|| row * columns + column)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fence_is_as_long_as_the_gap_at_any_angle() {
        let field = |columns: usize, rows: usize, z: &dyn Fn(f64, f64) -> f64| Window {
            columns,
            cells: [0..rows / 2, rows / 2..rows],
            values: (0..columns * rows).map(|k| z((k % columns) as f64 + 0.5, (k / columns) as f64 + 0.5)).collect(),
        };
        let fence = |window: &Window, level: f64| {
            let length = window.fence(level, &vec![false; window.values.len()]).unwrap();
            length as f64 / (2 * HALF_A_PIXEL) as f64
        };
        // From the first column to the last: nothing is in the way of the water.
        assert!((fence(&field(10, 20, &|_, _| 0.0), 1.0) - 10.0).abs() < 1e-12);
        // A wall along the rows with a gap of four columns, and one askew.
        let along = field(10, 20, &|x, y| if (8.0..9.0).contains(&y) && !(3.0..7.0).contains(&x) { 2.0 } else { 0.0 });
        assert!((fence(&along, 1.0) - 4.0).abs() < 1e-12 && (fence(&along, 2.0) - 10.0).abs() < 1e-12);
        let askew = field(10, 20, &|x, y| {
            let (across, along) = (y - x - 5.0, y + x - 15.0);
            if across.abs() < 2.0 && along.abs() > 5.0 { 2.0 } else { 0.0 }
        });
        assert!((fence(&askew, 1.0) - 7.0).abs() < 0.8, "{}", fence(&askew, 1.0));
        let plain = field(10, 20, &|_, _| 0.0);
        let (share, crest) = opening(&along, &plain, 1.0, 0.9).unwrap();
        assert!((share - 0.4).abs() < 1e-12 && (crest - 2.0).abs() < 1e-2);
        let (share, crest) = opening(&askew, &plain, 1.0, 0.9).unwrap();
        assert!((share - 0.7).abs() < 0.08 && (crest - 2.0).abs() < 1e-2);
        // Neither a wall without a gap, nor none, nor one on ground that rises by more than it is high.
        assert_eq!(opening(&field(10, 20, &|_, y| if y as usize == 8 { 2.0 } else { 0.0 }), &plain, 1.0, 0.9), None);
        assert_eq!(opening(&plain, &plain, 1.0, 0.9), None);
        assert_eq!(opening(&along, &field(10, 20, &|x, _| 0.2 * x), 1.0, 0.9), None);
    }
}
