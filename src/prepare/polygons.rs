//! Polygons on the lattice: which cells they hold, whether they cross themselves, how near a place is to their outline.

use geo::line_intersection::{LineIntersection, line_intersection};
use geo::{Area, BooleanOps, Line, LineString, MultiPolygon, Polygon, Validation, unary_union};

use crate::lattice::Lattice;
use crate::math::Vec2;

/// An area with a value that holds in it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ValuedArea {
    /// In map coordinates (m).
    pub area: MultiPolygon<f64>,
    pub value: f64,
}

/// What is wrong with a polygon.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum PolygonFault {
    /// It has fewer than three places, or no area.
    Empty,
    /// A coordinate is not finite.
    NotFinite,
    /// Its outline crosses itself here (map coordinates).
    Crossing(Vec2),
    /// It breaks the rules of simple polygons in a way that leaves its area clear: it touches itself, or a hole sticks out.
    Untidy(String),
}

fn rings(polygon: &Polygon<f64>) -> impl Iterator<Item = &LineString<f64>> {
    std::iter::once(polygon.exterior()).chain(polygon.interiors())
}

/// The fault of a polygon, if it has one.
pub(super) fn fault(polygon: &Polygon<f64>) -> Option<PolygonFault> {
    if rings(polygon).any(|ring| ring.0.iter().any(|c| !c.x.is_finite() || !c.y.is_finite())) {
        return Some(PolygonFault::NotFinite);
    }
    if polygon.exterior().0.len() < 4 {
        return Some(PolygonFault::Empty);
    }
    let invalid = polygon.check_validation().err();
    if let Some(invalid) = invalid {
        return Some(match first_crossing(polygon) {
            Some(place) => PolygonFault::Crossing(place),
            None if polygon.unsigned_area() <= 0.0 => PolygonFault::Empty,
            None => PolygonFault::Untidy(invalid.to_string()),
        });
    }
    (polygon.unsigned_area() <= 0.0).then_some(PolygonFault::Empty)
}

/// The westernmost place where two edges of a polygon cross inside both.
fn first_crossing(polygon: &Polygon<f64>) -> Option<Vec2> {
    let mut edges: Vec<Line<f64>> = rings(polygon).flat_map(LineString::lines).collect();
    let west = |line: &Line<f64>| line.start.x.min(line.end.x);
    let east = |line: &Line<f64>| line.start.x.max(line.end.x);
    edges.sort_by(|a, b| west(a).total_cmp(&west(b)));
    for (i, edge) in edges.iter().enumerate() {
        for other in edges[i + 1..].iter().take_while(|other| west(other) <= east(edge)) {
            if let Some(LineIntersection::SinglePoint { intersection, is_proper: true }) =
                line_intersection(*edge, *other)
            {
                return Some(Vec2::new(intersection.x, intersection.y));
            }
        }
    }
    None
}

/// Polygons as one area, what they share counted once. They all run to the left, as those of [`Feature`](crate::vector::Feature) do.
pub(super) fn union(polygons: Vec<Polygon<f64>>) -> MultiPolygon<f64> {
    if polygons.len() > 1 { unary_union(&polygons) } else { MultiPolygon::new(polygons) }
}

/// What is left of an area without another one.
pub(super) fn without(area: &MultiPolygon<f64>, other: &MultiPolygon<f64>) -> MultiPolygon<f64> {
    area.difference(other)
}

/// Indices of the cells whose centres lie inside an area given in map coordinates, ascending.
pub(super) fn cells_inside(area: &MultiPolygon<f64>, lattice: &Lattice) -> Vec<usize> {
    let mut cells = Vec::new();
    for polygon in area {
        add_cells_inside(polygon, lattice, &mut cells);
    }
    cells.sort_unstable();
    cells.dedup();
    cells
}

/// Scan line: on each row the outline is crossed an even number of times, and every second stretch is inside.
fn add_cells_inside(polygon: &Polygon<f64>, lattice: &Lattice, cells: &mut Vec<usize>) {
    let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); lattice.rows];
    let s = lattice.spacing;
    for edge in rings(polygon).flat_map(LineString::lines) {
        let a = lattice.to_local(Vec2::new(edge.start.x, edge.start.y));
        let b = lattice.to_local(Vec2::new(edge.end.x, edge.end.y));
        let (low, high) = if a.y <= b.y { (a, b) } else { (b, a) };
        let first = (low.y / s - 0.5).ceil().max(0.0) as usize;
        let last = (high.y / s - 0.5).ceil().clamp(0.0, lattice.rows as f64) as usize;
        for (row, crossed) in crossings.iter_mut().enumerate().take(last).skip(first) {
            let y = (row as f64 + 0.5) * s;
            crossed.push(low.x + (y - low.y) / (high.y - low.y) * (high.x - low.x));
        }
    }
    for (row, crossed) in crossings.iter_mut().enumerate() {
        crossed.sort_by(f64::total_cmp);
        for pair in crossed.chunks_exact(2) {
            let from = (pair[0] / s - 0.5).ceil().max(0.0) as usize;
            let to = (pair[1] / s - 0.5).ceil().clamp(0.0, lattice.columns as f64) as usize;
            cells.extend((from..to).map(|column| lattice.index(column, row)));
        }
    }
}

/// Distance (m) from a place to the outline of an area, both in map coordinates.
pub(super) fn distance_to_outline(area: &MultiPolygon<f64>, place: Vec2) -> f64 {
    let edges = area.iter().flat_map(|polygon| rings(polygon).flat_map(LineString::lines));
    edges
        .map(|edge| {
            distance_to_segment(place, [Vec2::new(edge.start.x, edge.start.y), Vec2::new(edge.end.x, edge.end.y)])
        })
        .fold(f64::INFINITY, f64::min)
}

/// Distance (m) from a place to a straight piece of a line.
pub(super) fn distance_to_segment(place: Vec2, [start, end]: [Vec2; 2]) -> f64 {
    let along = end - start;
    let length_squared = along.norm_squared();
    let share = if length_squared > 0.0 { ((place - start).dot(along) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
    (place - (start + along * share)).norm()
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "made values are met exactly")]
mod tests {
    use super::*;
    use geo::{Contains, point, polygon};

    #[test]
    fn a_bow_tie_is_a_crossing_and_a_flat_polygon_is_empty() {
        let bow_tie = polygon![(x: 0.0, y: 0.0), (x: 10.0, y: 10.0), (x: 10.0, y: 0.0), (x: 0.0, y: 10.0)];
        assert_eq!(fault(&bow_tie), Some(PolygonFault::Crossing(Vec2::new(5.0, 5.0))));
        let flat = polygon![(x: 0.0, y: 0.0), (x: 10.0, y: 0.0), (x: 20.0, y: 0.0)];
        assert_eq!(fault(&flat), Some(PolygonFault::Empty));
        let square = polygon![(x: 0.0, y: 0.0), (x: 10.0, y: 0.0), (x: 10.0, y: 10.0), (x: 0.0, y: 10.0)];
        assert_eq!(fault(&square), None);
        let infinite = polygon![(x: 0.0, y: 0.0), (x: f64::INFINITY, y: 0.0), (x: 10.0, y: 10.0)];
        assert_eq!(fault(&infinite), Some(PolygonFault::NotFinite));
    }

    #[test]
    fn a_polygon_that_only_touches_itself_is_untidy() {
        let touching = polygon![
            (x: 0.0, y: 0.0), (x: 5.0, y: 5.0), (x: 0.0, y: 10.0), (x: 10.0, y: 10.0), (x: 5.0, y: 5.0), (x: 10.0, y: 0.0)
        ];
        assert!(matches!(fault(&touching), Some(PolygonFault::Untidy(_))), "{:?}", fault(&touching));
    }

    #[test]
    fn the_scan_line_agrees_with_point_in_polygon() {
        let lattice = Lattice::new(Vec2::new(1000.0, 2000.0), 40, 30, 2.5);
        let outer: LineString<f64> = (0..17)
            .map(|i| {
                let (angle, radius) = (f64::from(i) * 0.37, if i % 2 == 0 { 60.0 } else { 21.0 });
                (1045.3 + radius * angle.cos(), 2031.7 + radius * angle.sin())
            })
            .collect();
        let hole = LineString::from(vec![(1040.1, 2030.2), (1052.3, 2030.9), (1046.0, 2040.4)]);
        let area = MultiPolygon::new(vec![Polygon::new(outer, vec![hole])]);
        let cells = cells_inside(&area, &lattice);
        let expected: Vec<usize> = (0..lattice.len())
            .filter(|&i| {
                let centre = lattice.to_map(lattice.centre(i));
                area.contains(&point!(x: centre.x, y: centre.y))
            })
            .collect();
        assert!(cells.len() > 100);
        assert_eq!(cells, expected);
    }

    #[test]
    fn the_distance_to_a_segment_is_that_to_its_nearest_place() {
        let piece = [Vec2::ZERO, Vec2::new(10.0, 0.0)];
        assert_eq!(distance_to_segment(Vec2::new(13.0, 4.0), piece), 5.0);
        assert_eq!(distance_to_segment(Vec2::new(3.0, -2.0), piece), 2.0);
    }
}
