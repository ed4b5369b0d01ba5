//! Where water may leave the terrain.

use rstar::primitives::Line;
use rstar::{AABB, RTree};

use super::wall::distance_to_segment;
use crate::math::Vec2;

/// A line is square to a face where the cosine between the face and the line is below this: six degrees off.
const SQUARE: f64 = 0.1;
/// Pieces are looked for within so many times the reach, so that rounding leaves none out.
const ROUNDING: f64 = 1.0 + 1e-9;

/// Straight pieces of lines in local coordinates (m), found by their place: an outline has as many of them as edge faces.
#[derive(Clone, Debug, Default)]
pub struct Pieces(RTree<Line<[f64; 2]>>);

impl FromIterator<[Vec2; 2]> for Pieces {
    fn from_iter<I: IntoIterator<Item = [Vec2; 2]>>(pieces: I) -> Self {
        Pieces(RTree::bulk_load(pieces.into_iter().map(line).collect()))
    }
}

impl From<Vec<[Vec2; 2]>> for Pieces {
    fn from(pieces: Vec<[Vec2; 2]>) -> Self {
        pieces.into_iter().collect()
    }
}

impl Extend<[Vec2; 2]> for Pieces {
    fn extend<I: IntoIterator<Item = [Vec2; 2]>>(&mut self, pieces: I) {
        pieces.into_iter().for_each(|piece| self.0.insert(line(piece)));
    }
}

impl PartialEq for Pieces {
    fn eq(&self, other: &Self) -> bool {
        self.0.iter().eq(other.0.iter())
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

    /// Where one of them begins.
    pub fn place(&self) -> Option<Vec2> {
        self.0.iter().next().map(|piece| Vec2::new(piece.from[0], piece.from[1]))
    }

    /// Distance (m) of the nearest piece that opens an edge face within a reach (m); the face is given by its midpoint and its normal in
    /// either direction.
    pub fn distance_to_face(&self, reach: f64, (midpoint, normal): (Vec2, Vec2)) -> Option<f64> {
        let aside = Vec2::new(reach, reach) * ROUNDING;
        let around = AABB::from_corners(coordinates(midpoint - aside), coordinates(midpoint + aside));
        let near = self.0.locate_in_envelope_intersecting(&around);
        near.filter_map(|piece| distance_to_face(piece, midpoint, normal)).filter(|far| *far <= reach).reduce(f64::min)
    }
}

fn coordinates(place: Vec2) -> [f64; 2] {
    [place.x, place.y]
}

fn line([start, end]: [Vec2; 2]) -> Line<[f64; 2]> {
    Line::new(coordinates(start), coordinates(end))
}

/// Distance (m) of a straight piece of a line from an edge face that it may open; none from a face square to it, which lies around the
/// corner where the line is drawn up to one. A piece without length may open any.
fn distance_to_face(piece: &Line<[f64; 2]>, midpoint: Vec2, normal: Vec2) -> Option<f64> {
    let [start, end] = [piece.from, piece.to].map(|[x, y]| Vec2::new(x, y));
    let across = (end - start).perpendicular();
    let is_square = across.dot(normal).abs() < SQUARE * across.norm() * normal.norm();
    (!is_square).then(|| distance_to_segment(midpoint, start, end))
}

/// Water that leaves the terrain through an open edge is booked; at all other edges the terrain ends at a wall.
///
/// Edges of the lattice and of no-data areas are walls. A lattice or no-data edge face is open when its midpoint lies
/// within `reach` of one of these lines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OpenEdges {
    /// Those of the lines.
    pub pieces: Pieces,
    /// Distance up to which a line opens a face of the edge (m).
    pub reach: f64,
    /// Every edge face is open, those of no-data areas included, whatever the lines say.
    pub whole_outline: bool,
}

impl OpenEdges {
    /// Whether a face of the edge of the terrain is open, with its midpoint and its normal in either direction (local coordinates).
    pub fn is_open(&self, midpoint: Vec2, normal: Vec2) -> bool {
        self.whole_outline || self.pieces.distance_to_face(self.reach, (midpoint, normal)).is_some()
    }
}
