//! Where a line from west to east lies inside a polygon: crossings with the edges, sorted and paired (even-odd rule).
//!
//! The rule makes holes holes whichever way round their ring runs. Edges are kept by rows of the lattice, so that one line
//! costs only the edges near it: a whole lattice is scanned in time proportional to cells plus edges.

use geo::{CoordsIter, LinesIter};

use crate::lattice::Lattice;
use crate::math::Vec2;

/// A stretch of a scan line: from and to (m, local).
pub type Interval = (f64, f64);

/// A polygon made ready for scan lines on a lattice.
pub struct ScanLines {
    /// Edges with the number of their polygon, grouped by the rows of the lattice that they touch.
    edges_of_row: Vec<Vec<(usize, [Vec2; 2])>>,
    spacing: f64,
    /// Columns and rows of the lattice that the polygon can touch: first, and one past the last.
    pub columns: (usize, usize),
    /// See `columns`.
    pub rows: (usize, usize),
}

impl ScanLines {
    /// Sorts the edges of a polygon given in map coordinates into the rows of the lattice.
    pub fn new(polygon: &geo::MultiPolygon<f64>, lattice: &Lattice) -> Self {
        let to_local = |c: geo::Coord<f64>| lattice.to_local(Vec2::new(c.x, c.y));
        let (mut low, mut high) =
            (Vec2::new(f64::INFINITY, f64::INFINITY), Vec2::new(f64::NEG_INFINITY, f64::NEG_INFINITY));
        for corner in polygon.coords_iter().map(to_local) {
            low = Vec2::new(low.x.min(corner.x), low.y.min(corner.y));
            high = Vec2::new(high.x.max(corner.x), high.y.max(corner.y));
        }
        // A cast to an unsigned integer saturates: what lies outside the lattice ends at its border.
        let range = |low: f64, high: f64, count: usize| {
            let first = ((low / lattice.spacing).floor() as usize).min(count);
            let end = (((high / lattice.spacing).floor() + 1.0).max(0.0) as usize).min(count);
            (first, end.max(first))
        };
        let columns = range(low.x, high.x, lattice.columns);
        let rows = range(low.y, high.y, lattice.rows);
        let mut edges_of_row = vec![Vec::new(); lattice.rows];
        for (part, polygon) in polygon.iter().enumerate() {
            for line in polygon.lines_iter() {
                let edge = [to_local(line.start), to_local(line.end)];
                let (first, end) = range(edge[0].y.min(edge[1].y), edge[0].y.max(edge[1].y), lattice.rows);
                for row in &mut edges_of_row[first..end] {
                    row.push((part, edge));
                }
            }
        }
        ScanLines { edges_of_row, spacing: lattice.spacing, columns, rows }
    }

    /// Adds the ordinates (m, local) of the corners inside a row: between two of them the polygon's width changes linearly.
    /// A rim with more corners than `most` has no long edge along the row for which they would matter.
    pub fn corners(&self, row: usize, most: usize, out: &mut Vec<f64>) {
        let edges = &self.edges_of_row[row];
        if edges.len() <= most {
            let inside = (row as f64 * self.spacing, (row + 1) as f64 * self.spacing);
            let ordinates = edges.iter().map(|(_, [start, _])| start.y);
            out.extend(ordinates.filter(|&y| inside.0 < y && y < inside.1));
        }
    }

    /// The stretches of the line at `y` (m, local) inside the polygon, in ascending order and apart from each other.
    pub fn intervals(&self, y: f64, crossings: &mut Vec<(usize, f64)>, inside: &mut Vec<Interval>) {
        crossings.clear();
        inside.clear();
        let Some(edges) = self.edges_of_row.get((y / self.spacing).floor() as usize) else { return };
        for &(part, [start, end]) in edges {
            // Half open, so that a corner on the line counts once.
            if (start.y <= y) != (end.y <= y) {
                crossings.push((part, start.x + (y - start.y) / (end.y - start.y) * (end.x - start.x)));
            }
        }
        crossings.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        inside.extend(crossings.chunks_exact(2).map(|pair| (pair[0].1, pair[1].1)));
        // Parts of one body may touch or overlap: their union counts.
        inside.sort_by(|a, b| a.0.total_cmp(&b.0));
        inside.dedup_by(|next, kept| {
            let joined = next.0 <= kept.1;
            if joined {
                kept.1 = kept.1.max(next.1);
            }
            joined
        });
    }
}

/// Takes `holes` out of `stretches`; both in ascending order and without overlap, and so is the result.
pub fn subtract(stretches: &mut Vec<Interval>, holes: &[Interval]) {
    if holes.is_empty() {
        return;
    }
    let mut rest = Vec::with_capacity(stretches.len() + holes.len());
    for &(start, to) in stretches.iter() {
        let mut from = start;
        for &(hole_from, hole_to) in holes.iter().filter(|hole| hole.1 > start && hole.0 < to) {
            if hole_from > from {
                rest.push((from, hole_from));
            }
            from = from.max(hole_to);
        }
        if from < to {
            rest.push((from, to));
        }
    }
    *stretches = rest;
}

#[cfg(test)]
mod tests {
    use super::*;
    use geo::{MultiPolygon, polygon};

    fn lattice() -> Lattice {
        Lattice::new(Vec2::new(1000.0, 0.0), 10, 10, 1.0)
    }

    fn scan(polygon: MultiPolygon<f64>, y: f64) -> Vec<Interval> {
        let (mut crossings, mut inside) = (Vec::new(), Vec::new());
        ScanLines::new(&polygon, &lattice()).intervals(y, &mut crossings, &mut inside);
        inside
    }

    #[test]
    fn hole_is_a_hole_whichever_way_round() {
        let hole = [(1004.0, 4.0), (1006.0, 4.0), (1006.0, 6.0), (1004.0, 6.0)];
        let ring = |corners: Vec<(f64, f64)>| geo::LineString::from(corners);
        let outer = || ring(vec![(1002.0, 2.0), (1008.0, 2.0), (1008.0, 8.0), (1002.0, 8.0)]);
        for corners in [hole.to_vec(), hole.iter().rev().copied().collect()] {
            let polygon = geo::Polygon::new(outer(), vec![ring(corners)]);
            assert_eq!(scan(MultiPolygon(vec![polygon.clone()]), 5.0), [(2.0, 4.0), (6.0, 8.0)]);
            assert_eq!(scan(MultiPolygon(vec![polygon]), 3.0), [(2.0, 8.0)]);
        }
    }

    #[test]
    fn overlapping_parts_count_once() {
        let square = |x: f64| {
            let (w, e) = (1000.0 + x, 1003.0 + x);
            polygon![(x: w, y: 1.0), (x: e, y: 1.0), (x: e, y: 4.0), (x: w, y: 4.0)]
        };
        assert_eq!(scan(MultiPolygon(vec![square(1.0), square(2.0), square(6.0)]), 2.0), [(1.0, 5.0), (6.0, 9.0)]);
    }

    #[test]
    fn polygon_reaching_beyond_the_lattice_is_cut_there() {
        let large = polygon![(x: 990.0, y: -5.0), (x: 1004.0, y: -5.0), (x: 1004.0, y: 50.0), (x: 990.0, y: 50.0)];
        let lines = ScanLines::new(&MultiPolygon(vec![large]), &lattice());
        assert_eq!((lines.columns, lines.rows), ((0, 5), (0, 10)));
        let outside = polygon![(x: 900.0, y: 1.0), (x: 905.0, y: 1.0), (x: 905.0, y: 2.0)];
        let lines = ScanLines::new(&MultiPolygon(vec![outside]), &lattice());
        assert_eq!(lines.columns.0, lines.columns.1);
    }

    #[test]
    fn subtraction_splits_and_cuts() {
        let mut stretches = vec![(0.0, 4.0), (5.0, 6.0), (7.0, 9.0)];
        subtract(&mut stretches, &[(1.0, 2.0), (3.0, 5.5), (6.5, 10.0)]);
        assert_eq!(stretches, [(0.0, 1.0), (2.0, 3.0), (5.5, 6.0)]);
    }
}
