//! Squares that stay as they are beside the cells of a partition, though lines run through them.

use super::{Face, Partition, Side};
use crate::lattice::Lattice;
use crate::math::Vec2;

/// Pieces of a face shorter than this (spacings) are round-off.
const SHORTEST: f64 = 1e-9;

impl Partition {
    /// The same with squares of the lattice where [`Partition::new`] had no cell: what lies beyond a face there is the square.
    #[must_use]
    pub fn beside(mut self, lattice: &Lattice, is_kept: impl Fn(usize) -> bool) -> Self {
        let faces = std::mem::take(&mut self.faces);
        self.faces = faces.into_iter().flat_map(|face| joined(face, lattice, &is_kept)).collect();
        self
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
}
