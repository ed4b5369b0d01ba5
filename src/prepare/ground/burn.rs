//! Lines on the lattice: the cells that one crosses, those within its width, and the place on it that is nearest to a cell.

use std::collections::{BTreeMap, BTreeSet};

use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::prepare::polygons::distance_to_segment;

/// The cells that a line (local coordinates, m) crosses.
///
/// They close every way from cell to cell through a common edge: where the line passes through a corner, the two cells on its
/// way meet there, and the other two have no common edge.
pub fn crossed(line: &[Vec2], lattice: &Lattice) -> BTreeSet<usize> {
    cells(line, 0.0, lattice)
}

/// A part of a straight piece (local coordinates, m) between two lines of the lattice.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    pub ends: [Vec2; 2],
    pub middle: Vec2,
    pub length: f64,
}

/// The length (m) of a line (local coordinates, m) in each cell, and the pieces of it that lie beside the lattice.
pub fn lengths(line: &[Vec2], lattice: &Lattice) -> (BTreeMap<usize, f64>, Vec<[Vec2; 2]>) {
    let (mut inside, mut beside) = (BTreeMap::new(), Vec::new());
    for part in line.windows(2).flat_map(|piece| cut([piece[0], piece[1]], lattice)) {
        match lattice.cell_at(part.middle) {
            Some(cell) => *inside.entry(cell).or_insert(0.0) += part.length,
            None => beside.push(part.ends),
        }
    }
    (inside, beside)
}

/// A straight piece (local coordinates, m) in parts, each in one cell or beside the lattice, from its start to its end.
pub fn cut([start, end]: [Vec2; 2], lattice: &Lattice) -> Vec<Part> {
    let along = end - start;
    let mut cuts = vec![0.0, 1.0];
    for (start, along, count) in [(start.x, along.x, lattice.columns), (start.y, along.y, lattice.rows)] {
        let edge_at = |place: f64| (place / lattice.spacing).clamp(0.0, count as f64);
        let (low, high) = (edge_at(start.min(start + along)), edge_at(start.max(start + along)));
        let cut = |edge: usize| (edge as f64 * lattice.spacing - start) / along;
        cuts.extend((low.floor() as usize..=high.ceil() as usize).map(cut).filter(|cut| *cut > 0.0 && *cut < 1.0));
    }
    cuts.sort_by(f64::total_cmp);
    let part = |pair: &[f64]| Part {
        ends: [pair[0], pair[1]].map(|share| start + along * share),
        middle: start + along * (0.5 * (pair[0] + pair[1])),
        length: (pair[1] - pair[0]) * along.norm(),
    };
    cuts.windows(2).map(part).collect()
}

/// The cells of a strip along a line (local coordinates, m): those that it crosses, those whose centres lie within half of
/// the width (m), and one more wherever two of them meet at a corner only.
///
/// They close every way from cell to cell, through corners, too, and water that runs along them finds a common edge everywhere.
pub fn strip(line: &[Vec2], width: f64, lattice: &Lattice) -> BTreeSet<usize> {
    let mut found = cells(line, width, lattice);
    for cell in found.clone() {
        let (column, row) = lattice.column_row(cell);
        if row + 1 == lattice.rows {
            continue;
        }
        for beside in [column.checked_sub(1), Some(column + 1).filter(|&east| east < lattice.columns)] {
            let Some(beside) = beside else { continue };
            let between = [lattice.index(beside, row), lattice.index(column, row + 1)];
            if found.contains(&lattice.index(beside, row + 1)) && !between.iter().any(|cell| found.contains(cell)) {
                let distance = |cell: usize| foot_of(lattice.centre(cell), line).distance;
                let is_nearer = distance(between[1]) < distance(between[0]);
                found.insert(between[usize::from(is_nearer)]);
            }
        }
    }
    found
}

/// The cells that a line crosses, and those whose centres lie within half of the width (m) of it.
fn cells(line: &[Vec2], width: f64, lattice: &Lattice) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    let half = 0.5 * width;
    let index = |x: f64, count: usize| ((x / lattice.spacing).floor().max(0.0) as usize).min(count.saturating_sub(1));
    for piece in line.windows(2) {
        let [a, b] = [piece[0], piece[1]];
        for row in index(a.y.min(b.y) - half, lattice.rows)..=index(a.y.max(b.y) + half, lattice.rows) {
            for column in index(a.x.min(b.x) - half, lattice.columns)..=index(a.x.max(b.x) + half, lattice.columns) {
                let corner = Vec2::new(column as f64, row as f64) * lattice.spacing;
                let cell = lattice.index(column, row);
                let is_within = || width > 0.0 && distance_to_segment(lattice.centre(cell), [a, b]) <= half;
                if passes(piece, corner, lattice.spacing) || is_within() {
                    found.insert(cell);
                }
            }
        }
    }
    found
}

/// Whether a piece has a part of some length in a cell; along an edge it belongs to the cell beyond, as places do.
fn passes(piece: &[Vec2], corner: Vec2, spacing: f64) -> bool {
    let (start, along) = (piece[0], piece[1] - piece[0]);
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for (start, along, low) in [(start.x, along.x, corner.x), (start.y, along.y, corner.y)] {
        if along.abs() > 0.0 {
            let (a, b) = ((low - start) / along, (low + spacing - start) / along);
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        } else if start < low || start >= low + spacing {
            return false;
        }
    }
    from < to
}

/// The place on a line that is nearest to another one.
#[derive(Clone, Copy, Debug)]
pub struct Foot {
    /// Its distance (m) along the line from the start.
    pub station: f64,
    /// Its distance (m) from the other place.
    pub distance: f64,
    /// Where it lies.
    pub foot: Vec2,
    /// The direction of the line there, of length 1.
    pub direction: Vec2,
}

/// The foot of a place on a line of two vertices or more, no two of them that follow each other the same.
pub fn foot_of(place: Vec2, line: &[Vec2]) -> Foot {
    let mut best = Foot { station: 0.0, distance: f64::INFINITY, foot: Vec2::default(), direction: Vec2::default() };
    let mut before = 0.0;
    for piece in line.windows(2) {
        let along = piece[1] - piece[0];
        let (share, length) = (((place - piece[0]).dot(along) / along.norm_squared()).clamp(0.0, 1.0), along.norm());
        let foot = piece[0] + along * share;
        let distance = (place - foot).norm();
        if distance < best.distance {
            best = Foot { station: before + share * length, distance, foot, direction: along * (1.0 / length) };
        }
        before += length;
    }
    best
}

/// The value at a place, linear along the line between the values at its vertices.
pub fn value_at(place: Vec2, line: &[Vec2], values: &[f64]) -> f64 {
    let station = foot_of(place, line).station;
    let mut before = 0.0;
    for (piece, ends) in line.windows(2).zip(values.windows(2)) {
        let length = (piece[1] - piece[0]).norm();
        if station <= before + length {
            return ends[0] + (ends[1] - ends[0]) * ((station - before) / length).clamp(0.0, 1.0);
        }
        before += length;
    }
    values.last().copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice() -> Lattice {
        Lattice::new(Vec2::ZERO, 12, 10, 2.0)
    }

    #[test]
    fn the_lengths_in_the_cells_are_those_of_the_line() {
        let line = [Vec2::new(1.0, 1.0), Vec2::new(7.0, 1.0), Vec2::new(7.0, 4.0), Vec2::new(4.0, 0.0)];
        let (inside, beside) = lengths(&line, &lattice());
        assert!((inside.values().sum::<f64>() - 14.0).abs() < 1e-12 && beside.is_empty());
        // Along the first row 1, 2, 2 and 1 m; the way back leaves the fourth column after 5/3 m, and the second row after 5/2.
        let cell = |column, row| inside[&lattice().index(column, row)];
        assert!((cell(0, 0) - 1.0).abs() < 1e-12 && (cell(1, 0) - 2.0).abs() < 1e-12, "{inside:?}");
        assert!((cell(3, 1) - 11.0 / 3.0).abs() < 1e-12 && (cell(2, 1) - 5.0 / 6.0).abs() < 1e-12, "{inside:?}");
        let (inside, beside) = lengths(&[Vec2::new(-3.0, 5.0), Vec2::new(30.0, 5.0)], &lattice());
        assert!((inside.values().sum::<f64>() - 24.0).abs() < 1e-12);
        assert_eq!(beside, [[Vec2::new(-3.0, 5.0), Vec2::new(0.0, 5.0)], [Vec2::new(24.0, 5.0), Vec2::new(30.0, 5.0)]]);
        // Along an edge it belongs to the cells beyond, as places do.
        let (inside, _) = lengths(&[Vec2::new(4.0, 0.0), Vec2::new(4.0, 20.0)], &lattice());
        assert!(inside.keys().all(|cell| cell % 12 == 2) && inside.len() == 10);
    }

    /// Lines from the southern to the northern edge: straight, diagonal through corners, along an edge, bent.
    fn lines() -> Vec<Vec<Vec2>> {
        let mut lines = vec![
            vec![Vec2::new(9.3, -1.0), Vec2::new(9.3, 21.0)],
            vec![Vec2::new(2.0, 0.0), Vec2::new(22.0, 20.0)],
            vec![Vec2::new(22.0, 0.0), Vec2::new(2.0, 20.0)],
            vec![Vec2::new(10.0, -1.0), Vec2::new(10.0, 21.0)],
            vec![Vec2::new(3.1, -0.5), Vec2::new(15.7, 8.2), Vec2::new(6.4, 20.5)],
            vec![Vec2::new(4.0, 0.0), Vec2::new(14.0, 10.0), Vec2::new(4.0, 20.0)],
        ];
        lines.extend((0..40).map(|k| {
            let x = |k: i32| 4.0 + f64::from((k * 37) % 31) * 0.5;
            vec![Vec2::new(x(k), -0.5), Vec2::new(x(k + 7), 9.7), Vec2::new(x(k + 3), 20.5)]
        }));
        lines
    }

    /// Whether water from the western edge reaches the eastern one by the given steps without entering the cells.
    fn passes_by(cells: &BTreeSet<usize>, steps: &[(isize, isize)]) -> bool {
        let lattice = lattice();
        let mut reached: Vec<usize> = (0..10).map(|row| row * 12).filter(|cell| !cells.contains(cell)).collect();
        let mut next = 0;
        while next < reached.len() {
            let (column, row) = lattice.column_row(reached[next]);
            next += 1;
            for (dc, dr) in steps {
                let (c, r) = (column as isize + dc, row as isize + dr);
                if (0..12).contains(&c) && (0..10).contains(&r) {
                    let cell = lattice.index(c as usize, r as usize);
                    if !cells.contains(&cell) && !reached.contains(&cell) {
                        reached.push(cell);
                    }
                }
            }
        }
        assert!(!reached.is_empty());
        reached.iter().any(|cell| cell % 12 == 11)
    }

    const EDGES: [(isize, isize); 4] = [(1, 0), (-1, 0), (0, 1), (0, -1)];
    const CORNERS: [(isize, isize); 4] = [(1, 1), (-1, 1), (1, -1), (-1, -1)];

    #[test]
    fn the_cells_of_a_line_close_every_way_through_edges() {
        for line in lines() {
            let dam = crossed(&line, &lattice());
            assert!(!passes_by(&dam, &EDGES), "{line:?}");
        }
    }

    #[test]
    fn the_cells_of_a_strip_close_every_way_through_corners_too_and_hang_together_by_edges() {
        let all: Vec<(isize, isize)> = EDGES.into_iter().chain(CORNERS).collect();
        let lattice = lattice();
        for line in lines() {
            for width in [0.0, 1.0, 5.0] {
                let strip = strip(&line, width, &lattice);
                assert!(!passes_by(&strip, &all), "{line:?}");
                // The strip itself is one channel of cells with common edges.
                let mut reached = vec![*strip.first().unwrap()];
                let mut next = 0;
                while let Some(&cell) = reached.get(next) {
                    next += 1;
                    let (column, row) = lattice.column_row(cell);
                    for (dc, dr) in EDGES {
                        let (c, r) = (column.checked_add_signed(dc), row.checked_add_signed(dr));
                        if let (Some(c), Some(r)) = (c.filter(|&c| c < 12), r.filter(|&r| r < 10)) {
                            let cell = lattice.index(c, r);
                            if strip.contains(&cell) && !reached.contains(&cell) {
                                reached.push(cell);
                            }
                        }
                    }
                }
                assert_eq!(reached.len(), strip.len(), "{line:?} {width}");
            }
        }
    }

    #[test]
    fn a_line_along_an_edge_takes_one_row_of_cells_and_its_width_more() {
        let lattice = lattice();
        let line = [Vec2::new(10.0, 0.0), Vec2::new(10.0, 20.0)];
        let dam = crossed(&line, &lattice);
        assert_eq!(dam.len(), 10);
        assert!(dam.iter().all(|cell| cell % 12 == 5));
        let station = |cell: usize| foot_of(lattice.centre(cell), &line).station;
        assert!((station(5) - 1.0).abs() < 1e-12 && (station(9 * 12 + 5) - 19.0).abs() < 1e-12);
        let columns = |width: f64| {
            let columns: BTreeSet<usize> = strip(&line, width, &lattice).iter().map(|cell| cell % 12).collect();
            columns.into_iter().collect::<Vec<_>>()
        };
        assert_eq!(columns(0.5), [5]);
        assert_eq!(columns(2.5), [4, 5]);
        assert_eq!(columns(6.0), [3, 4, 5, 6]);
    }

    #[test]
    fn the_foot_of_a_place_is_that_on_the_nearest_piece() {
        let line = [Vec2::new(0.0, 0.0), Vec2::new(10.0, 0.0), Vec2::new(10.0, 5.0)];
        let cases = [
            ((3.0, 2.0), [3.0, 2.0, 1.0, 0.0]),
            ((13.0, 4.0), [14.0, 3.0, 0.0, 1.0]),
            ((-3.0, -4.0), [0.0, 5.0, 1.0, 0.0]),
        ];
        for ((x, y), expected) in cases {
            let foot = foot_of(Vec2::new(x, y), &line);
            let found = [foot.station, foot.distance, foot.direction.x, foot.direction.y];
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{x} {y}: {found:?}");
        }
    }

    #[test]
    fn values_are_linear_along_the_line() {
        let line = [Vec2::new(0.0, 0.0), Vec2::new(10.0, 0.0), Vec2::new(10.0, 5.0)];
        let values = [1.0, 2.0, 4.0];
        let cases = [((-3.0, 1.0), 1.0), ((5.0, 2.0), 1.5), ((12.0, 2.5), 3.0), ((10.0, 9.0), 4.0)];
        for ((x, y), expected) in cases {
            assert!((value_at(Vec2::new(x, y), &line, &values) - expected).abs() < 1e-12, "{x} {y}");
        }
    }
}
