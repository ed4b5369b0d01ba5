//! Squares that stay as they are beside the cells of a partition, though lines run through them.

use super::join::LEAST_AREA;
use super::{Cell, Face, Partition, Side};
use crate::lattice::Lattice;
use crate::math::Vec2;

/// Pieces of a face shorter than this (spacings) are round-off.
const SHORTEST: f64 = 1e-9;

impl Partition {
    /// The same with squares of the lattice where [`Partition::new`] had no cell: what lies beyond a face there is the square. Slivers
    /// that have nothing but squares beside them are left out.
    #[must_use]
    pub fn beside(mut self, lattice: &Lattice, is_kept: impl Fn(usize) -> bool) -> Self {
        let faces = std::mem::take(&mut self.faces);
        self.faces = faces.into_iter().flat_map(|face| joined(face, lattice, &is_kept)).collect();
        self.leave_out_slivers(LEAST_AREA * lattice.spacing);
        self
    }

    /// Leaves out slivers: cells with nothing but squares beside them, so that they could be joined to nothing, that are narrower than `least` (m)
    /// between these and their wall. Their faces on squares are walls then.
    fn leave_out_slivers(&mut self, least: f64) {
        // Of each cell the sum of its sides on squares (m), along their normals, and whether there is another cell beside it.
        let mut beside = vec![(Vec2::ZERO, false); self.cells.len()];
        for face in &self.faces {
            match face.sides {
                [Side::Cell(a), Side::Cell(b)] => [a, b].into_iter().for_each(|cell| beside[cell].1 = true),
                [Side::Cell(cell), Side::Lattice(_)] => beside[cell].0 += face.normal() * face.length(),
                _ => {}
            }
        }
        let is_sliver =
            |(cell, (squares, has_cell)): (&Cell, &(Vec2, bool))| !has_cell && cell.area < least * squares.norm();
        let left_out: Vec<bool> = self.cells.iter().zip(&beside).map(is_sliver).collect();
        let next =
            |count: &mut usize, is_left_out: &bool| Some(std::mem::replace(count, *count + usize::from(!is_left_out)));
        let number: Vec<usize> = left_out.iter().scan(0, next).collect();
        let without = |face: Face| match face.sides {
            [Side::Cell(cell), square @ Side::Lattice(_)] if left_out[cell] => {
                Some(Face { sides: [square, Side::Wall], from: face.to, to: face.from, ..face })
            }
            [Side::Cell(cell), _] if left_out[cell] => None,
            sides => {
                let numbered = |side| if let Side::Cell(cell) = side { Side::Cell(number[cell]) } else { side };
                Some(Face { sides: sides.map(numbered), ..face })
            }
        };
        self.faces = std::mem::take(&mut self.faces).into_iter().filter_map(without).collect();
        let cells = std::mem::take(&mut self.cells).into_iter().zip(left_out);
        self.cells = cells.filter_map(|(cell, is_left_out)| (!is_left_out).then_some(cell)).collect();
    }
}

/// A face divided at the corners of squares, each piece with the square beyond it.
fn joined(face: Face, lattice: &Lattice, is_kept: &impl Fn(usize) -> bool) -> Vec<Face> {
    if face.sides[1] != Side::Nothing {
        return vec![face];
    }
    let spacing = lattice.spacing;
    let beyond = |face: &Face| {
        let place = face.middle() + face.normal() * (0.1 * spacing);
        lattice.cell_at(place).filter(|&square| is_kept(square))
    };
    let mut ends = vec![face.from];
    ends.extend(corners(face.from, face.to, spacing));
    ends.push(face.to);
    let pieces: Vec<Face> = ends.windows(2).map(|ends| Face { from: ends[0], to: ends[1], ..face }).collect();
    let with_square = |piece: &Face| {
        let square = beyond(piece);
        Face { sides: [piece.sides[0], square.map_or(Side::Nothing, Side::Lattice)], ..*piece }
    };
    pieces.iter().map(with_square).collect()
}

/// The corners of squares between the ends of a face along a side of squares, in order.
fn corners(from: Vec2, to: Vec2, spacing: f64) -> Vec<Vec2> {
    let is_east_west = (to.x - from.x).abs() > (to.y - from.y).abs();
    let (first, last) = if is_east_west { (from.x, to.x) } else { (from.y, to.y) };
    let (low, high) = (first.min(last) / spacing + SHORTEST, first.max(last) / spacing - SHORTEST);
    let corner = |k: i64| {
        let at = k as f64 * spacing;
        if is_east_west { Vec2::new(at, from.y) } else { Vec2::new(from.x, at) }
    };
    let mut found: Vec<Vec2> = (low.ceil() as i64..=high.floor() as i64).map(corner).collect();
    if first > last {
        found.reverse();
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::{Line, LineKind};
    use super::*;

    #[test]
    fn a_square_that_stays_has_all_of_its_sides() {
        let lattice = Lattice::new(Vec2::ZERO, 12, 9, 2.0);
        let places = [(-1.0, 3.0), (25.0, 14.0)].map(|(x, y)| Vec2::new(x, y));
        let line = Line { points: places.to_vec(), is_closed: false, kind: LineKind::Follow };
        let is_kept = |cell: usize| cell % 12 < 2 || cell % 12 > 8;
        let made = Partition::new(&lattice, |cell| !is_kept(cell), &[line]).beside(&lattice, is_kept);
        let replaced: std::collections::BTreeSet<usize> = made.replaced.iter().copied().collect();
        assert!(replaced.iter().all(|&cell| !is_kept(cell)) && replaced.len() > 20);
        let mut sides = std::collections::BTreeMap::<usize, f64>::new();
        for face in &made.faces {
            assert!(face.sides[1] != Side::Nothing, "{face:?}");
            if let Side::Lattice(square) = face.sides[1] {
                *sides.entry(square).or_default() += face.length() / lattice.spacing;
            }
        }
        for (&square, length) in &sides {
            let beside = crate::lattice::NEIGHBOURS.iter().filter_map(|&step| lattice.neighbour(square, step));
            let count = beside.filter(|other| replaced.contains(other)).count();
            assert!((length - count as f64).abs() < 1e-12, "{square}: {length} of {count}");
        }
    }

    #[test]
    fn slivers_between_lines_and_squares_that_stay_are_left_out() {
        let lattice = Lattice::new(Vec2::ZERO, 24, 20, 2.0);
        // A disc of squares, and lines that cut off its stairs.
        let middle = Vec2::new(24.0, 20.0);
        let is_kept = |cell: usize| (lattice.centre(cell) - middle).norm() < 10.0;
        let (mut left_out, mut walls) = (0, 0);
        for k in 0..24 {
            let (sin, cos) = (0.11 + f64::from(k) * 0.13).sin_cos();
            let (along, off) = (Vec2::new(cos, sin) * 60.0, Vec2::new(-sin, cos) * 9.2);
            let line = Line {
                points: vec![middle + off - along, middle + off + along],
                is_closed: false,
                kind: LineKind::Wall,
            };
            let plain = Partition::new(&lattice, |cell| !is_kept(cell), std::slice::from_ref(&line));
            let made = plain.clone().beside(&lattice, is_kept);
            left_out += plain.cells.len() - made.cells.len();
            let mut of_cell = vec![(Vec2::ZERO, Vec2::ZERO, false); made.cells.len()];
            for face in &made.faces {
                walls += usize::from(matches!(face.sides, [Side::Lattice(_), Side::Wall]));
                for (own, other, sign) in [(0, 1, 1.0), (1, 0, -1.0)] {
                    let Side::Cell(cell) = face.sides[own] else { continue };
                    of_cell[cell].1 += face.normal() * (sign * face.length());
                    match face.sides[other] {
                        Side::Lattice(_) => of_cell[cell].0 += face.normal() * (sign * face.length()),
                        Side::Cell(_) => of_cell[cell].2 = true,
                        _ => {}
                    }
                }
            }
            for (cell, (squares, closure, has_cell)) in made.cells.iter().zip(of_cell) {
                assert!(closure.norm() < 1e-9, "the faces of a cell close: {closure:?}");
                assert!(
                    has_cell || cell.area >= 0.3 * 2.0 * squares.norm(),
                    "{cell:?} beside {squares:?} m of squares"
                );
            }
        }
        assert!(left_out > 3 && walls >= left_out, "{left_out} left out, {walls} sides of squares on walls");
    }
}
