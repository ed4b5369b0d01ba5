//! Straight pieces of walls and of open edges.

use crate::math::Vec2;

/// A straight piece of a wall or of an open edge, in local coordinates (m).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Edge {
    /// One end.
    pub start: Vec2,
    /// The other end.
    pub end: Vec2,
    /// Whether water leaves here; otherwise it is a wall.
    pub is_open: bool,
}

impl Edge {
    /// Unit vector along the piece.
    #[inline]
    pub fn direction(&self) -> Vec2 {
        (self.end - self.start) / (self.end - self.start).norm()
    }

    /// Signed distance (m) of a place from the line of the piece, positive to its left.
    #[inline]
    pub fn side(&self, place: Vec2) -> f64 {
        self.direction().cross(place - self.start)
    }

    /// Twice the area (m²) of the triangle of the piece and a place, positive to its left: the sign of `side` without its root.
    #[inline]
    pub fn turn(&self, place: Vec2) -> f64 {
        (self.end - self.start).cross(place - self.start)
    }

    /// Where the way from `a` to `b` crosses the piece, as a share of the way; ends of the piece are stretched by `margin` (m).
    #[inline]
    pub fn crossing(&self, a: Vec2, b: Vec2, margin: f64) -> Option<f64> {
        let (turn_a, turn_b) = (self.turn(a), self.turn(b));
        if turn_a * turn_b >= 0.0 {
            return None;
        }
        let share = turn_a / (turn_a - turn_b);
        let piece = self.end - self.start;
        let (along, length_squared) = (piece.dot(a + (b - a) * share - self.start), piece.norm_squared());
        let beyond = (-along).max(along - length_squared);
        (beyond <= 0.0 || beyond <= margin * length_squared.sqrt()).then_some(share)
    }
}

/// Distance (m) of a point from the straight piece between two ends.
pub fn distance_to_segment(point: Vec2, start: Vec2, end: Vec2) -> f64 {
    (point - nearest_on_segment(point, start, end)).norm()
}

/// The place of a segment that is nearest to a point.
pub fn nearest_on_segment(point: Vec2, start: Vec2, end: Vec2) -> Vec2 {
    let along = end - start;
    let share = ((point - start).dot(along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    start + along * share
}

/// Distance (m) between two pieces, 0 where they cross.
pub(super) fn gap_between(a: &Edge, b: &Edge) -> f64 {
    if a.crossing(b.start, b.end, 0.0).is_some() {
        return 0.0;
    }
    let ends = [(a.start, b), (a.end, b), (b.start, a), (b.end, a)];
    ends.into_iter().map(|(end, edge)| distance_to_segment(end, edge.start, edge.end)).fold(f64::INFINITY, f64::min)
}

/// The edges longer than `margin` (m); one that goes straight on where the one before it ends is joined to it.
///
/// A corner is seen in pieces that come near each other: a wall with a joint would lose the images beyond that joint.
pub(super) fn joined(edges: Vec<Edge>, margin: f64) -> Vec<Edge> {
    let mut joined: Vec<Edge> = Vec::with_capacity(edges.len());
    for edge in edges.into_iter().filter(|edge| (edge.end - edge.start).norm() > margin) {
        match joined.last_mut() {
            Some(last)
                if last.is_open == edge.is_open
                    && (edge.start - last.end).norm() <= margin
                    && (edge.end - last.end).dot(last.direction()) > 0.0
                    && last.side(edge.end).abs() <= margin =>
            {
                last.end = edge.end;
            }
            _ => joined.push(edge),
        }
    }
    joined
}
