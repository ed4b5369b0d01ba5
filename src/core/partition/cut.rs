//! Convex polygons cut in two by straight lines.

use super::TOLERANCE;
use super::lines::{Network, bounds};
use super::segment::Segment;
use super::voronoi::between;
use super::window::square_of;
use crate::math::Vec2;

/// A convex polygon, counter-clockwise.
pub type Polygon = Vec<Vec2>;

/// The parts into which the lines near it, and the sides of cells that do not exist, cut a convex polygon.
///
/// A segment cuts along its whole straight line, within those parts into which it reaches itself. Parts that no line separates are
/// joined later on.
pub fn parts(polygon: Polygon, network: &Network, is_there: &impl Fn(i64, i64) -> bool) -> Vec<Polygon> {
    let (low, high) = bounds(&polygon);
    let mut near = Vec::new();
    network.near(low, high, &mut near);
    let mut parts = vec![polygon];
    for number in near {
        cut_all(&mut parts, &network.segments[number as usize]);
    }
    for segment in sides_of_the_missing(low, high, is_there) {
        cut_all(&mut parts, &segment);
    }
    parts
}

/// The sides between cells that exist and cells that do not, within a box.
fn sides_of_the_missing(low: Vec2, high: Vec2, is_there: &impl Fn(i64, i64) -> bool) -> Vec<Segment> {
    let (from, to) = (square_of(low), square_of(high));
    let mut sides = Vec::new();
    for row in from.1..=to.1 {
        for column in from.0..=to.0 {
            let at = |x: i64, y: i64| Vec2::new((column + x) as f64, (row + y) as f64);
            let is_own = is_there(column, row);
            if column < to.0 && is_own != is_there(column + 1, row) {
                sides.push(Segment { ends: [at(1, 0), at(1, 1)], line: 0 });
            }
            if row < to.1 && is_own != is_there(column, row + 1) {
                sides.push(Segment { ends: [at(0, 1), at(1, 1)], line: 0 });
            }
        }
    }
    sides
}

fn cut_all(parts: &mut Vec<Polygon>, segment: &Segment) {
    for i in 0..parts.len() {
        if let Some([left, right]) = halves(&parts[i], segment) {
            parts[i] = left;
            parts.push(right);
        }
    }
}

/// Left and right part of a convex polygon, if a segment reaches into it.
fn halves(polygon: &Polygon, segment: &Segment) -> Option<[Polygon; 2]> {
    let (start, along) = (segment.ends[0], segment.along());
    let length = along.norm();
    let to_left: Vec<f64> = polygon.iter().map(|corner| along.cross(*corner - start) / length).collect();
    let has = |sign: f64| to_left.iter().any(|distance| sign * distance > TOLERANCE);
    if !has(1.0) || !has(-1.0) || reach_within(polygon, segment) <= TOLERANCE {
        return None;
    }
    let [mut left, mut right] = [Vec::new(), Vec::new()];
    for (i, corner) in polygon.iter().enumerate() {
        let next = (i + 1) % polygon.len();
        let (a, b) = (to_left[i], to_left[next]);
        if a > -TOLERANCE {
            left.push(*corner);
        }
        if a < TOLERANCE {
            right.push(*corner);
        }
        if a.min(b) <= -TOLERANCE && a.max(b) >= TOLERANCE {
            let place = between(*corner, polygon[next], a, b);
            left.push(place);
            right.push(place);
        }
    }
    Some([left, right])
}

/// Length of a segment within a convex polygon.
fn reach_within(polygon: &Polygon, segment: &Segment) -> f64 {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for (i, corner) in polygon.iter().enumerate() {
        let side = polygon[(i + 1) % polygon.len()] - *corner;
        if side.norm() <= TOLERANCE {
            continue; // Its direction is rounding.
        }
        let [a, b] = segment.ends.map(|end| side.cross(end - *corner));
        match (a > 0.0, b > 0.0) {
            (true, true) => {}
            (false, false) => return 0.0,
            (false, true) => from = from.max(a / (a - b)),
            (true, false) => to = to.min(a / (a - b)),
        }
    }
    (to - from) * segment.along().norm()
}
