//! Where water may leave the terrain.

use super::wall::distance_to_segment;
use crate::math::Vec2;

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
    /// Whether the edge of the terrain is open at a place (local coordinates, m).
    pub fn is_open(&self, place: Vec2) -> bool {
        let near = |segment: &[Vec2; 2]| distance_to_segment(place, segment[0], segment[1]) <= self.reach;
        self.whole_outline || self.segments.iter().any(near)
    }
}
