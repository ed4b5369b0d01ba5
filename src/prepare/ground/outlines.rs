//! Outlines of blocked buildings, which cells follow: footprints that touch or overlap are one building.

use geo::orient::{Direction, Orient};
use geo::{Area, BoundingRect, Coord, Intersects, MapCoords, MultiPolygon, Polygon};

use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::partition::{Line, LineKind};
use crate::prepare::polygons;

/// Buildings of less than this share of a cell change nothing that a cell could show.
const LEAST_SHARE: f64 = 0.01;

/// The outlines of some footprints (map coordinates) as lines of a lattice: of each building that outside, and those of its courtyards.
pub fn outlines<'a>(footprints: impl Iterator<Item = &'a MultiPolygon<f64>>, lattice: &Lattice) -> Vec<Vec<Line>> {
    let local = |at: Coord<f64>| {
        let place = lattice.to_local(Vec2::new(at.x, at.y));
        Coord { x: place.x, y: place.y }
    };
    let footprints: Vec<Polygon<f64>> =
        footprints.flat_map(|area| &area.0).map(|polygon| polygon.map_coords(local)).collect();
    let is_seen = |polygon: &Polygon<f64>| polygon.unsigned_area() > LEAST_SHARE * lattice.cell_area();
    united(footprints).iter().filter(|polygon| is_seen(polygon)).map(|polygon| rings(polygon, lattice)).collect()
}

/// The polygons, those that touch or overlap as one. A building that stands alone keeps its places to the last digit.
fn united(mut polygons: Vec<Polygon<f64>>) -> Vec<Polygon<f64>> {
    let bounds = |polygon: &Polygon<f64>| polygon.bounding_rect().map(|bounds| (bounds.min(), bounds.max()));
    polygons.retain(|polygon| bounds(polygon).is_some());
    polygons.sort_by(|a, b| {
        let west = |polygon| bounds(polygon).map_or(0.0, |(low, _)| low.x);
        west(a).total_cmp(&west(b))
    });
    let boxes: Vec<(Coord<f64>, Coord<f64>)> = polygons.iter().filter_map(bounds).collect();
    // The first building of each group.
    let mut first: Vec<usize> = (0..polygons.len()).collect();
    for (i, (low, high)) in boxes.iter().enumerate() {
        let near = (i + 1..boxes.len()).take_while(|&j| boxes[j].0.x <= high.x);
        for j in near.filter(|&j| boxes[j].0.y <= high.y && boxes[j].1.y >= low.y) {
            if polygons[i].intersects(&polygons[j]) {
                let (a, b) = (first[i].min(first[j]), first[i].max(first[j]));
                first.iter_mut().filter(|first| **first == b).for_each(|first| *first = a);
            }
        }
    }
    let mut groups: Vec<(usize, Polygon<f64>)> = first.into_iter().zip(polygons).collect();
    groups.sort_by_key(|(first, _)| *first);
    let united = |group: &[(usize, Polygon<f64>)]| polygons::union(group.iter().map(|(_, p)| p.clone()).collect());
    groups.chunk_by(|a, b| a.0 == b.0).flat_map(united).collect()
}

/// The rings of a polygon: that outside to the left, those of courtyards to the right. A courtyard that no cell could show is built over.
fn rings(polygon: &Polygon<f64>, lattice: &Lattice) -> Vec<Line> {
    let polygon = polygon.orient(Direction::Default);
    let courtyards = polygon
        .interiors()
        .iter()
        .filter(|ring| Polygon::new((*ring).clone(), Vec::new()).unsigned_area() > LEAST_SHARE * lattice.cell_area());
    let line = |ring: &geo::LineString<f64>| {
        let points = ring.0.iter().map(|at| Vec2::new(at.x, at.y)).collect();
        Line { points, is_closed: true, kind: LineKind::Outline }
    };
    std::iter::once(polygon.exterior()).chain(courtyards).map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use geo::polygon;

    fn square(x: f64, y: f64, size: f64) -> MultiPolygon<f64> {
        let polygon = polygon![(x: x, y: y), (x: x + size, y: y), (x: x + size, y: y + size), (x: x, y: y + size)];
        MultiPolygon(vec![polygon])
    }

    #[test]
    fn houses_that_touch_are_one_and_tiny_ones_are_none() {
        let lattice = Lattice::new(Vec2::new(100.0, 200.0), 10, 10, 2.0);
        let mut ring = square(111.0, 211.0, 6.0);
        ring.0[0].interiors_push(geo::LineString::from(vec![(112.0, 212.0), (116.0, 212.0), (116.0, 216.0)]));
        let houses = [
            square(101.0, 201.0, 2.0),
            square(103.0, 202.0, 2.0),
            square(104.0, 203.5, 3.0),
            square(108.0, 201.0, 0.1),
            square(107.5, 206.6, 1.0),
            ring,
        ];
        let found = outlines(houses.iter(), &lattice);
        let sizes: Vec<Vec<usize>> =
            found.iter().map(|house| house.iter().map(|ring| ring.points.len()).collect()).collect();
        assert_eq!(sizes, [vec![13], vec![5], vec![5, 4]]);
        let area = |ring: &Line| -> f64 { ring.points.windows(2).map(|ends| 0.5 * ends[0].cross(ends[1])).sum() };
        let areas: Vec<f64> = found.iter().flatten().map(area).collect();
        for (found, expected) in areas.iter().zip([4.0 + 4.0 + 9.0 - 0.5, 1.0, 36.0, -8.0]) {
            assert!((found - expected).abs() < 1e-6, "{areas:?}");
        }
    }
}
