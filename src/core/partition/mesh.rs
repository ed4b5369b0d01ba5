//! The parts of all cells with corners and edges in common: what one part has as an edge, the part beside it has, too.
//!
//! Corners of different parts that are the same but for rounding become one. Where a corner of one part lies on the side of another, that
//! side is divided there. So the sides of a part close to rounding, whatever was computed before, and volume has no way to get lost.

use super::cut::Polygon;
use super::lines::{Network, bounds};
use super::segment::Segment;
use super::weld::Weld;
use super::window::square_of;
use super::{LineKind, TOLERANCE};
use crate::math::Vec2;

/// A convex part of the Voronoi cell of a seed.
pub struct Part {
    /// Its seed.
    pub seed: usize,
    /// Its corners, counter-clockwise.
    pub corners: Vec<u32>,
    /// Its area.
    pub area: f64,
    /// Its centre of gravity.
    pub centre: Vec2,
}

/// An edge between parts.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// Its ends; the part `left` lies to the left.
    pub ends: [u32; 2],
    /// The part to the left.
    pub left: u32,
    /// The part to the right, if there is one.
    pub right: Option<u32>,
    /// The line on which it lies.
    pub line: Option<u32>,
}

/// Parts that share corners and edges.
pub struct Mesh {
    /// The corners.
    pub places: Vec<Vec2>,
    /// The parts.
    pub parts: Vec<Part>,
    /// The edges, each once.
    pub edges: Vec<Edge>,
    /// Edges that more than two parts have, or two on the same side; 0 unless tolerances failed.
    pub faults: usize,
}

impl Mesh {
    /// The mesh of the polygons of seeds.
    pub fn new(polygons: Vec<(usize, Polygon)>, network: &Network) -> Self {
        let mut weld = Weld::default();
        // A line may end or bend within the side of a polygon that lies on it.
        network.traces.iter().flat_map(|trace| &trace.points).for_each(|point| _ = weld.number(*point));
        let mut loops: Vec<(usize, Vec<u32>)> = Vec::with_capacity(polygons.len());
        for (seed, polygon) in polygons {
            let corners = polygon.into_iter().map(|corner| weld.number(snapped(corner, network)));
            loops.push((seed, corners.collect()));
        }
        let places = weld.places;
        let by_square = BySquare::new(&places);
        let mut parts = Vec::with_capacity(loops.len());
        for (seed, corners) in loops {
            let corners = without_spikes(divided(&corners, &places, &by_square));
            if corners.len() > 2 {
                let (area, centre) = area_and_centre(corners.iter().map(|corner| places[*corner as usize]));
                parts.push(Part { seed, corners, area, centre });
            }
        }
        let (mut edges, faults) = edges(&parts);
        for edge in &mut edges {
            edge.line = line_of(edge.ends.map(|end| places[end as usize]), network);
        }
        Mesh { places, parts, edges, faults }
    }
}

/// A corner moved onto what it means: the end of a segment, the crossing of two, the segment itself, the corner of a square.
fn snapped(corner: Vec2, network: &Network) -> Vec2 {
    let is_near = |place: &Vec2| (corner - *place).norm() <= TOLERANCE;
    let mut on: Option<(&Segment, Vec2)> = None;
    for number in network.at(corner) {
        let segment = &network.segments[*number as usize];
        if let Some(end) = segment.ends.into_iter().find(is_near) {
            return end;
        }
        let nearest = segment.nearest(corner);
        match on {
            _ if !is_near(&nearest) => {}
            None => on = Some((segment, nearest)),
            Some((first, place)) => {
                let crossing = first.crossing(segment).map(|(share, _)| first.ends[0] + first.along() * share);
                on = Some((first, crossing.filter(is_near).unwrap_or(place)));
            }
        }
    }
    let of_square = Vec2::new(corner.x.round(), corner.y.round());
    let on_lattice = if is_near(&of_square) { of_square } else { corner };
    on.map_or(on_lattice, |(_, place)| place)
}

/// Corners by the row and column of the square that holds them.
struct BySquare {
    sorted: Vec<(i64, i64, u32)>,
}

impl BySquare {
    fn new(places: &[Vec2]) -> Self {
        let at = |(number, place): (usize, &Vec2)| {
            let (column, row) = square_of(*place);
            (row, column, number as u32)
        };
        let mut sorted: Vec<(i64, i64, u32)> = places.iter().enumerate().map(at).collect();
        sorted.sort_unstable();
        BySquare { sorted }
    }

    /// Corners in the squares of a row from one column to another.
    fn in_row(&self, row: i64, from: i64, to: i64) -> impl Iterator<Item = u32> {
        let first = self.sorted.partition_point(|known| (known.0, known.1) < (row, from));
        let within = self.sorted[first..].iter().take_while(move |known| known.0 == row && known.1 <= to);
        within.map(|known| known.2)
    }
}

/// A loop of corners with those of others that lie on its sides.
fn divided(corners: &[u32], places: &[Vec2], by_square: &BySquare) -> Vec<u32> {
    let mut found: Vec<u32> = Vec::with_capacity(corners.len() + 4);
    for (i, from) in corners.iter().enumerate() {
        let to = corners[(i + 1) % corners.len()];
        if *from == to {
            continue;
        }
        found.push(*from);
        let (a, b) = (places[*from as usize], places[to as usize]);
        let (low, high) = bounds(&[a, b]);
        let slack = Vec2::new(2.0 * TOLERANCE, 2.0 * TOLERANCE);
        let (low, high) = (square_of(low - slack), square_of(high + slack));
        let along = (b - a) / (b - a).norm();
        let length = (b - a).norm();
        let mut between: Vec<(f64, u32)> = Vec::new();
        for number in (low.1..=high.1).flat_map(|row| by_square.in_row(row, low.0, high.0)) {
            let way = places[number as usize] - a;
            let share = way.dot(along);
            let is_on = along.cross(way).abs() <= 2.0 * TOLERANCE && share > 0.0 && share < length;
            if is_on && number != *from && number != to {
                between.push((share, number));
            }
        }
        between.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.extend(between.into_iter().map(|(_, number)| number));
    }
    found
}

/// A loop of corners without ways there and back.
fn without_spikes(corners: Vec<u32>) -> Vec<u32> {
    let mut kept: Vec<u32> = Vec::with_capacity(corners.len());
    for corner in corners {
        match kept.len() {
            count if count > 0 && kept[count - 1] == corner => {}
            count if count > 1 && kept[count - 2] == corner => _ = kept.pop(),
            _ => kept.push(corner),
        }
    }
    loop {
        let count = kept.len();
        if count > 1 && kept[0] == kept[count - 1] {
            kept.pop();
        } else if count > 2 && kept[0] == kept[count - 2] {
            kept.truncate(count - 2);
        } else if count > 2 && kept[1] == kept[count - 1] {
            kept.remove(0);
            kept.pop();
        } else {
            return kept;
        }
    }
}

/// Area and centre of gravity of a polygon, counter-clockwise.
pub fn area_and_centre(corners: impl Iterator<Item = Vec2> + Clone) -> (f64, Vec2) {
    let Some(origin) = corners.clone().next() else { return (0.0, Vec2::ZERO) };
    let (mut twice, mut moment) = (0.0, Vec2::ZERO);
    let after = corners.clone().skip(1).chain(std::iter::once(origin));
    for (a, b) in corners.zip(after) {
        let (a, b) = (a - origin, b - origin);
        twice += a.cross(b);
        moment += (a + b) * a.cross(b);
    }
    let shift = if twice.abs() > f64::MIN_POSITIVE { moment / (3.0 * twice) } else { Vec2::ZERO };
    (0.5 * twice, origin + shift)
}

/// The edges of all parts, and how many do not fit.
fn edges(parts: &[Part]) -> (Vec<Edge>, usize) {
    let mut sides: Vec<(u32, u32, bool, u32)> = Vec::new();
    for (number, part) in parts.iter().enumerate() {
        for (i, from) in part.corners.iter().enumerate() {
            let to = part.corners[(i + 1) % part.corners.len()];
            sides.push((*from.min(&to), *from.max(&to), *from < to, number as u32));
        }
    }
    sides.sort_unstable();
    let (mut edges, mut faults) = (Vec::with_capacity(sides.len() / 2 + 1), 0);
    for same in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let (low, high, is_up, left) = same[0];
        let ends = if is_up { [low, high] } else { [high, low] };
        let right = same.get(1).filter(|other| other.2 != is_up).map(|other| other.3);
        faults += usize::from(same.len() > 2 || (same.len() == 2 && right.is_none()));
        edges.push(Edge { ends, left, right, line: None });
    }
    (edges, faults)
}

/// The line on which an edge lies: one that water cannot cross before others, then the first.
fn line_of([a, b]: [Vec2; 2], network: &Network) -> Option<u32> {
    let segments = network.at((a + b) * 0.5).iter().map(|number| &network.segments[*number as usize]);
    let is_on = |end: Vec2, segment: &Segment| segment.distance(end) <= 2.0 * TOLERANCE;
    let on = segments.filter(|segment| is_on(a, segment) && is_on(b, segment)).map(|segment| segment.line);
    on.min_by_key(|line| (network.kinds[*line] == LineKind::Follow, *line)).map(|line| line as u32)
}
