//! Where water may leave the terrain.

use std::collections::HashMap;

use rstar::primitives::{GeomWithData, Line};
use rstar::{AABB, RTree};

use super::edge::distance_to_segment;
use crate::lattice::Lattice;
use crate::math::{Vec2, segments_cross};

/// A line is square to a face where the cosine between the face and the line is below this: six degrees off.
const SQUARE: f64 = 0.1;
/// What counts as rounding of a place, in reaches.
const ROUNDING: f64 = 1e-9;

/// Straight pieces of lines in local coordinates (m), found by their place: an outline has as many of them as edge faces.
#[derive(Clone, Debug, Default)]
pub struct Pieces(RTree<Piece>);

/// A piece, and whether its line ends at each of its ends.
type Piece = GeomWithData<Line<[f64; 2]>, [bool; 2]>;

impl FromIterator<[Vec2; 2]> for Pieces {
    fn from_iter<I: IntoIterator<Item = [Vec2; 2]>>(pieces: I) -> Self {
        Pieces(RTree::bulk_load(with_ends(pieces)))
    }
}

impl From<Vec<[Vec2; 2]>> for Pieces {
    fn from(pieces: Vec<[Vec2; 2]>) -> Self {
        pieces.into_iter().collect()
    }
}

impl Extend<[Vec2; 2]> for Pieces {
    fn extend<I: IntoIterator<Item = [Vec2; 2]>>(&mut self, pieces: I) {
        with_ends(pieces).into_iter().for_each(|piece| self.0.insert(piece));
    }
}

impl PartialEq for Pieces {
    fn eq(&self, other: &Self) -> bool {
        let both = |piece: &Piece| (*piece.geom(), piece.data);
        self.0.iter().map(both).eq(other.0.iter().map(both))
    }
}

impl Pieces {
    /// Number of pieces.
    pub fn len(&self) -> usize {
        self.0.size()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Takes others in.
    pub fn join(&mut self, others: &Pieces) {
        others.0.iter().for_each(|piece| self.0.insert(*piece));
    }

    /// Whether one of them crosses a way.
    pub fn cross(&self, way: [Vec2; 2]) -> bool {
        let around = AABB::from_corners(coordinates(way[0]), coordinates(way[1]));
        let mut near = self.0.locate_in_envelope_intersecting(&around);
        near.any(|piece| segments_cross(way, [place(piece.geom().from), place(piece.geom().to)]))
    }

    /// All of them, in no order that means anything.
    pub fn iter(&self) -> impl Iterator<Item = [Vec2; 2]> + '_ {
        self.0.iter().map(|piece| [place(piece.geom().from), place(piece.geom().to)])
    }

    /// Where one of them begins.
    pub fn place(&self) -> Option<Vec2> {
        self.0.iter().next().map(|piece| place(piece.geom().from))
    }

    /// Distance (m) of the nearest piece that opens an edge face within a reach (m); the face is given by its midpoint and its normal in
    /// either direction. A line opens the faces beside it, and none whose midpoint lies beyond its ends.
    pub fn distance_to_face(&self, reach: f64, face: (Vec2, Vec2)) -> Option<f64> {
        self.nearest(reach, face, |piece, midpoint| !is_beyond_end(piece, midpoint, ROUNDING * reach))
    }

    /// The same with the faces beyond its ends: of a line that ends between the midpoints of two faces it tells which is nearer.
    pub fn distance_beyond_ends(&self, reach: f64, face: (Vec2, Vec2)) -> Option<f64> {
        self.nearest(reach, face, |_, _| true)
    }

    fn nearest(
        &self,
        reach: f64,
        (midpoint, normal): (Vec2, Vec2),
        counts: impl Fn(&Piece, Vec2) -> bool,
    ) -> Option<f64> {
        let aside = Vec2::new(reach, reach) * (1.0 + ROUNDING);
        let around = AABB::from_corners(coordinates(midpoint - aside), coordinates(midpoint + aside));
        let near = self.0.locate_in_envelope_intersecting(&around);
        let along_face = near.filter(|piece| !is_square(piece, normal) && counts(piece, midpoint));
        along_face.map(|piece| distance(piece, midpoint)).filter(|far| *far <= reach).reduce(f64::min)
    }
}

fn coordinates(place: Vec2) -> [f64; 2] {
    [place.x, place.y]
}

fn place([x, y]: [f64; 2]) -> Vec2 {
    Vec2::new(x, y)
}

/// The ends of lines are those places at which a single piece that has a length ends.
fn with_ends(pieces: impl IntoIterator<Item = [Vec2; 2]>) -> Vec<Piece> {
    let bits = |place: Vec2| [place.x.to_bits(), place.y.to_bits()];
    let pieces: Vec<[Vec2; 2]> = pieces.into_iter().collect();
    let mut meeting: HashMap<[u64; 2], u32> = HashMap::new();
    let long = pieces.iter().filter(|[start, end]| start != end);
    long.flatten().for_each(|&end| *meeting.entry(bits(end)).or_default() += 1);
    let piece = |[start, end]: [Vec2; 2]| {
        let is_last = [start, end].map(|place| start == end || meeting[&bits(place)] == 1);
        GeomWithData::new(Line::new(coordinates(start), coordinates(end)), is_last)
    };
    pieces.into_iter().map(piece).collect()
}

/// Share of the way along a piece at which it is nearest to a place, below 0 or above 1 beyond its ends, and its length (m).
fn share_along(piece: &Piece, to: Vec2) -> (f64, f64) {
    let start = place(piece.geom().from);
    let along = place(piece.geom().to) - start;
    ((to - start).dot(along) / along.norm_squared().max(f64::MIN_POSITIVE), along.norm())
}

fn distance(piece: &Piece, to: Vec2) -> f64 {
    let (start, end) = (place(piece.geom().from), place(piece.geom().to));
    distance_to_segment(to, start, end)
}

/// Whether a place lies farther than so much (m) beyond an end of a line; beside a piece without length all other places do.
fn is_beyond_end(piece: &Piece, to: Vec2, rounding: f64) -> bool {
    let (share, length) = share_along(piece, to);
    if length <= 0.0 {
        return distance(piece, to) > rounding;
    }
    let [first, last] = piece.data;
    (first && -share * length > rounding) || (last && (share - 1.0) * length > rounding)
}

/// Whether a piece is square to an edge face: that lies around the corner where the line is drawn up to one. A piece without length is
/// square to none.
fn is_square(piece: &Piece, normal: Vec2) -> bool {
    let across = (place(piece.geom().to) - place(piece.geom().from)).perpendicular();
    across.dot(normal).abs() < SQUARE * across.norm() * normal.norm()
}

/// Water that leaves the terrain through an open edge is counted; at all other edges the terrain ends at a wall.
///
/// Edges of the lattice and of no-data areas are walls. A lattice or no-data edge face is open when its midpoint lies beside one of
/// these lines, within `reach`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OpenEdges {
    /// Those of the lines.
    pub pieces: Pieces,
    /// Distance up to which a line opens a face of the edge (m).
    pub reach: f64,
    /// Where it is given every edge face is open, whatever the lines say, but for those of these holes.
    pub outline: Option<Holes>,
}

/// Holes of the terrain: areas without data that terrain encloses.
#[derive(Clone, Debug, PartialEq)]
pub struct Holes {
    /// The squares of the finest level.
    pub lattice: Lattice,
    /// Those of the holes, ascending.
    pub cells: Vec<usize>,
}

impl Holes {
    /// Whether a face lies on the rim of a hole, with its midpoint and its normal in either direction (local coordinates). For a face of a coarser
    /// level, `times` as long: whether a square beside it has part of a hole, and all finest squares along it lie on the lattice.
    pub fn is_at_rim(&self, times: f64, midpoint: Vec2, normal: Vec2) -> bool {
        let normal = normal * (self.lattice.spacing / normal.norm());
        let along = normal.perpendicular();
        let count = times.round().max(1.0) as usize;
        let cell = |out: f64, k: usize| {
            self.lattice.cell_at(midpoint + normal * out + along * (k as f64 + 0.5 - 0.5 * count as f64))
        };
        let is_hole = |cell: usize| self.cells.binary_search(&cell).is_ok();
        let is_inside = (0..count).all(|k| cell(0.5, k).is_some() && cell(-0.5, k).is_some());
        let outs = (0..count).flat_map(|out| [out as f64 + 0.5, -0.5 - out as f64]);
        is_inside && outs.flat_map(|out| (0..count).filter_map(move |k| cell(out, k))).any(is_hole)
    }
}

impl OpenEdges {
    /// Whether a face of the edge of the terrain is open, with its midpoint and its normal in either direction (local coordinates).
    pub fn is_open(&self, midpoint: Vec2, normal: Vec2) -> bool {
        self.is_open_within(1.0, midpoint, normal)
    }

    /// The same for a face so many times as long as those of the finest level.
    pub fn is_open_within(&self, times: f64, midpoint: Vec2, normal: Vec2) -> bool {
        self.outline.as_ref().is_some_and(|holes| !holes.is_at_rim(times, midpoint, normal))
            || self.pieces.distance_to_face(times * self.reach, (midpoint, normal)).is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_outline_is_open_but_for_the_rims_of_holes() {
        let lattice = Lattice::new(Vec2::ZERO, 5, 5, 2.0);
        let (hole, outline) = ((Vec2::new(4.0, 5.0), Vec2::new(1.0, 0.0)), (Vec2::new(0.0, 5.0), Vec2::new(1.0, 0.0)));
        let mut open =
            OpenEdges { outline: Some(Holes { lattice, cells: vec![12] }), reach: 0.1, ..Default::default() };
        for sign in [1.0, -1.0] {
            assert!(!open.is_open(hole.0, hole.1 * sign) && open.is_open(outline.0, outline.1 * sign));
        }
        // A line along it opens a hole.
        open.pieces = vec![[Vec2::new(4.0, 4.0), Vec2::new(4.0, 6.0)]].into();
        assert!(open.is_open(hole.0, hole.1));
    }
}
