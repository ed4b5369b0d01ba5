//! Where water may leave the terrain.

use super::wall::distance_to_segment;
use crate::math::Vec2;

/// A line is square to a face where the cosine between the face and the line is below this: six degrees off.
const SQUARE: f64 = 0.1;

/// Water that leaves the terrain through an open edge is booked; at all other edges the terrain ends at a wall.
///
/// Edges of the lattice and of no-data areas are walls. A lattice or no-data edge face is open when its midpoint lies
/// within `reach` of one of these lines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OpenEdges {
    /// Straight pieces of lines in local coordinates (m).
    pub segments: Vec<[Vec2; 2]>,
    /// Distance up to which a line opens a face of the edge (m).
    pub reach: f64,
    /// Every edge face is open, those of no-data areas included, whatever the lines say.
    pub whole_outline: bool,
}

impl OpenEdges {
    /// Whether a face of the edge of the terrain is open, with its midpoint and its normal in either direction (local coordinates).
    pub fn is_open(&self, midpoint: Vec2, normal: Vec2) -> bool {
        self.whole_outline || opens(&self.segments, self.reach, (midpoint, normal))
    }
}

/// Whether straight pieces of lines open an edge face, given by its midpoint and its normal in either direction, within a reach (m).
pub fn opens(pieces: &[[Vec2; 2]], reach: f64, (midpoint, normal): (Vec2, Vec2)) -> bool {
    pieces.iter().filter_map(|piece| distance_to_face(piece, midpoint, normal)).any(|far| far <= reach)
}

/// Distance (m) of a straight piece of a line from an edge face that it may open; none from a face square to it, which lies around the
/// corner where the line is drawn up to one. A piece without length may open any.
pub(super) fn distance_to_face(piece: &[Vec2; 2], midpoint: Vec2, normal: Vec2) -> Option<f64> {
    let across = (piece[1] - piece[0]).perpendicular();
    let is_square = across.dot(normal).abs() < SQUARE * across.norm() * normal.norm();
    (!is_square).then(|| distance_to_segment(midpoint, piece[0], piece[1]))
}
