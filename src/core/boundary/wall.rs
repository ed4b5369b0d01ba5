//! Walls and open edges as straight pieces, found through spatial bins; the path of a particle along them.
//!
//! A wall has no thickness and two sides: no path crosses it and no two particles act through it.

use super::edge::{Edge, distance_to_segment, gap_between, joined};
use super::isometry::{Corner, Isometry};
use crate::math::{Vec2, floor};

/// Way, in widths of a bin, from a place at `share` of the bin to its rim along a direction, told by its reciprocal: infinite or not
/// a number where it never comes there.
#[inline]
fn to_the_rim(share: f64, reciprocal: f64) -> f64 {
    if reciprocal > 0.0 { (1.0 - share) * reciprocal } else { -share * reciprocal }
}

/// Where a particle's way ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Path {
    /// The end (m).
    pub position: Vec2,
    /// Unit normals of the walls at which the way was reflected, in order; zero vectors where none was.
    pub bounces: [Vec2; MOST_BOUNCES],
    /// Whether the way left through an open edge.
    pub has_left: bool,
    /// Whether the particle had to be held where it was.
    pub is_held: bool,
}

/// A way is reflected at most so often; a particle in a narrower wedge waits for a step.
const MOST_BOUNCES: usize = 3;

impl Path {
    /// The velocity after all bounces.
    pub fn turned(&self, mut velocity: Vec2) -> Vec2 {
        if self.is_held {
            return Vec2::ZERO;
        }
        for &normal in self.bounces.iter().take_while(|normal| **normal != Vec2::ZERO) {
            velocity = velocity - normal * (2.0 * velocity.dot(normal));
        }
        velocity
    }
}

/// The particles of walls that are made of them (`virtual_particles`).
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct VirtualParticles {
    pub places: Vec<Vec2>,
    /// Where the particles of each edge begin in `places`.
    pub starts: Vec<u32>,
    /// Index of the first of their transforms in `Walls::isometries`.
    pub first_transform: u32,
}

/// All walls and open edges of a place.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Walls {
    edges: Vec<Edge>,
    origin: Vec2,
    bin: f64,
    columns: usize,
    rows: usize,
    starts: Vec<u32>,
    members: Vec<u32>,
    /// For each bin, how many bins away (in the greater of both directions) the nearest bin with an edge is.
    clearance: Vec<u32>,
    margin: f64,
    /// The identity, the reflection in each edge, and the two reflections of each corner.
    isometries: Vec<Isometry>,
    /// Where the corners of each edge begin in `corners`.
    corner_starts: Vec<u32>,
    corners: Vec<Corner>,
    /// In place of mirror images, where the walls are made of particles.
    virtual_particles: Option<VirtualParticles>,
}

/// Two walls that come as near as this share of the spacing make a corner. The outline of a lattice has gaps of 0.5 and 0.71
/// spacings: rounding must not decide about either.
const CORNER_GAP: f64 = 0.6;
/// Width of the rim of a bin, in bins.
const RIM: f64 = 0.01;

impl Walls {
    /// Sorts edges into bins of twice `spacing` (m). Edges of no length are dropped, and straight chains become one edge.
    pub fn new(edges: Vec<Edge>, spacing: f64) -> Self {
        let edges = joined(edges, 1e-9 * spacing);
        let bin = 2.0 * spacing;
        let ends = || edges.iter().flat_map(|edge| [edge.start, edge.end]);
        let low =
            ends().fold(Vec2::new(f64::INFINITY, f64::INFINITY), |low, p| Vec2::new(low.x.min(p.x), low.y.min(p.y)));
        let high = ends().fold(low, |high, p| Vec2::new(high.x.max(p.x), high.y.max(p.y)));
        let origin = if edges.is_empty() { Vec2::ZERO } else { low - Vec2::new(0.5 * bin, 0.5 * bin) };
        let span = if edges.is_empty() { Vec2::ZERO } else { high - origin };
        let (columns, rows) = ((span.x / bin) as usize + 2, (span.y / bin) as usize + 2);
        let mut walls = Walls {
            edges,
            origin,
            bin,
            columns,
            rows,
            starts: Vec::new(),
            members: Vec::new(),
            clearance: Vec::new(),
            margin: 1e-9 * spacing,
            isometries: vec![Isometry::IDENTITY],
            corner_starts: vec![0],
            corners: Vec::new(),
            virtual_particles: None,
        };
        walls.fill_bins();
        walls.measure_clearance();
        walls.find_corners(CORNER_GAP * spacing);
        walls
    }

    /// What images are made with: the identity, the reflection in each edge, the two reflections of each corner.
    #[inline]
    pub fn isometries(&self) -> &[Isometry] {
        &self.isometries
    }

    /// The particles that the walls are made of, if they are.
    #[inline]
    pub(super) fn virtual_particles(&self) -> Option<&VirtualParticles> {
        self.virtual_particles.as_ref()
    }

    /// Takes virtual particles and their transforms.
    pub(super) fn add_virtual_particles(&mut self, virtuals: VirtualParticles, transforms: Vec<Isometry>) {
        self.isometries.extend(transforms);
        self.virtual_particles = Some(virtuals);
    }

    /// Index of the reflection in an edge in `isometries`.
    #[inline]
    pub(super) fn reflection_in(edge: u32) -> u32 {
        edge + 1
    }

    /// The corners in which the line of sight meets an edge first.
    #[inline]
    pub(super) fn corners_of(&self, edge: u32) -> &[Corner] {
        &self.corners[self.corner_starts[edge as usize] as usize..self.corner_starts[edge as usize + 1] as usize]
    }

    /// Finds the pairs of walls that meet at an angle, up to a `gap` (m). Parallel ones give no image of an image.
    fn find_corners(&mut self, gap: f64) {
        self.isometries.extend(self.edges.iter().map(Isometry::reflection));
        let mut near = Vec::new();
        for (first, edge) in self.edges.iter().enumerate() {
            let half_length = 0.5 * (edge.end - edge.start).norm();
            self.near((edge.start + edge.end) * 0.5, half_length + gap, &mut near);
            for &second in near.iter().filter(|&&second| second as usize != first) {
                let other = &self.edges[second as usize];
                let are_parallel = edge.direction().cross(other.direction()).abs() < 1e-6;
                if edge.is_open || other.is_open || are_parallel || gap_between(edge, other) > gap {
                    continue;
                }
                let outer = self.isometries[Self::reflection_in(first as u32) as usize];
                let inner = self.isometries[Self::reflection_in(second) as usize];
                let transform = self.isometries.len() as u32;
                self.isometries.push(inner.then(&outer));
                self.corners.push(Corner { first: first as u32, second, transform });
            }
            self.corner_starts.push(self.corners.len() as u32);
        }
    }

    /// Length (m) below which two places on a wall count as one.
    pub fn margin(&self) -> f64 {
        self.margin
    }

    /// The edges.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    fn bin_range(&self, low: Vec2, high: Vec2) -> (std::ops::RangeInclusive<usize>, std::ops::RangeInclusive<usize>) {
        let index = |value: f64, most: usize| ((value / self.bin) as usize).min(most - 1);
        let (low, high) = (low - self.origin, high - self.origin);
        (index(low.x, self.columns)..=index(high.x, self.columns), index(low.y, self.rows)..=index(high.y, self.rows))
    }

    fn fill_bins(&mut self) {
        let mut pairs = Vec::new();
        let half_diagonal = 0.75 * self.bin;
        // An edge on the rim of two bins belongs to both.
        let rim = Vec2::new(RIM, RIM) * self.bin;
        for (member, edge) in self.edges.iter().enumerate() {
            let low = Vec2::new(edge.start.x.min(edge.end.x), edge.start.y.min(edge.end.y));
            let high = Vec2::new(edge.start.x.max(edge.end.x), edge.start.y.max(edge.end.y));
            let (columns, rows) = self.bin_range(low - rim, high + rim);
            for row in rows {
                for column in columns.clone() {
                    let centre = self.origin + Vec2::new(column as f64 + 0.5, row as f64 + 0.5) * self.bin;
                    if distance_to_segment(centre, edge.start, edge.end) <= half_diagonal {
                        pairs.push(((row * self.columns + column) as u32, member as u32));
                    }
                }
            }
        }
        pairs.sort_unstable();
        self.starts = vec![0; self.columns * self.rows + 1];
        for &(bin, _) in &pairs {
            self.starts[bin as usize + 1] += 1;
        }
        for bin in 1..self.starts.len() {
            self.starts[bin] += self.starts[bin - 1];
        }
        self.members = pairs.into_iter().map(|(_, member)| member).collect();
    }

    /// Two sweeps of the chessboard distance.
    fn measure_clearance(&mut self) {
        let (columns, rows) = (self.columns, self.rows);
        let far = u32::MAX / 2;
        let mut clearance: Vec<u32> =
            (0..columns * rows).map(|bin| if self.starts[bin] < self.starts[bin + 1] { 0 } else { far }).collect();
        let relax = |clearance: &mut Vec<u32>, bin: usize, other: usize| {
            clearance[bin] = clearance[bin].min(clearance[other] + 1)
        };
        for row in 0..rows {
            for column in 0..columns {
                let bin = row * columns + column;
                if column > 0 {
                    relax(&mut clearance, bin, bin - 1);
                }
                for other in column.saturating_sub(1)..(column + 2).min(columns) {
                    if row > 0 {
                        relax(&mut clearance, bin, (row - 1) * columns + other);
                    }
                }
            }
        }
        for row in (0..rows).rev() {
            for column in (0..columns).rev() {
                let bin = row * columns + column;
                if column + 1 < columns {
                    relax(&mut clearance, bin, bin + 1);
                }
                for other in column.saturating_sub(1)..(column + 2).min(columns) {
                    if row + 1 < rows {
                        relax(&mut clearance, bin, (row + 1) * columns + other);
                    }
                }
            }
        }
        self.clearance = clearance;
    }

    /// Whether surely no edge lies within `reach` (m) of a place.
    #[inline]
    pub fn is_clear(&self, place: Vec2, reach: f64) -> bool {
        let local = (place - self.origin) / self.bin;
        if local.x < 0.0 || local.y < 0.0 || local.x >= self.columns as f64 || local.y >= self.rows as f64 {
            return self.edges.is_empty();
        }
        let clearance = self.clearance[local.y as usize * self.columns + local.x as usize];
        clearance > 0 && f64::from(clearance - 1) * self.bin > reach
    }

    /// Fills `found` with the edges within `reach` (m) of a place, in ascending order.
    pub fn near(&self, place: Vec2, reach: f64, found: &mut Vec<u32>) {
        found.clear();
        if self.is_clear(place, reach) {
            return;
        }
        let corner = Vec2::new(reach, reach);
        let (columns, rows) = self.bin_range(place - corner, place + corner);
        for row in rows {
            let cells = row * self.columns;
            let (from, to) =
                (self.starts[cells + columns.start()] as usize, self.starts[cells + columns.end() + 1] as usize);
            found.extend_from_slice(&self.members[from..to]);
        }
        found.sort_unstable();
        found.dedup();
        found.retain(|&member| {
            let edge = &self.edges[member as usize];
            distance_to_segment(place, edge.start, edge.end) <= reach
        });
    }

    /// Whether a wall among the edges `near` crosses the way from `a` to `b`. Open edges do not count.
    #[inline]
    pub fn is_blocked(&self, near: &[u32], a: Vec2, b: Vec2) -> bool {
        near.iter().any(|&member| {
            let edge = &self.edges[member as usize];
            !edge.is_open && edge.crossing(a, b, self.margin).is_some()
        })
    }

    /// Whether a wall crosses the way from `a` to `b`, by the bins along the way: for ways of any length.
    pub fn is_walled(&self, a: Vec2, b: Vec2) -> bool {
        let length = (b - a).norm();
        if length == 0.0 || self.is_clear((a + b) * 0.5, 0.5 * length) {
            return false;
        }
        // All in widths of a bin. A bin holds every edge that comes near its rim, so that a step past it misses nothing.
        let (start, along, length) = ((a - self.origin) / self.bin, (b - a) / length, length / self.bin);
        let reciprocal = Vec2::new(1.0 / along.x, 1.0 / along.y);
        let past_the_rim = 0.1 * RIM;
        let mut way = 0.0;
        while way <= length {
            let local = start + along * way;
            let (column, row) = (floor(local.x), floor(local.y));
            let is_inside = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
            let mut step = to_the_rim(local.x - column, reciprocal.x).min(to_the_rim(local.y - row, reciprocal.y));
            if is_inside {
                let bin = row as usize * self.columns + column as usize;
                let members = &self.members[self.starts[bin] as usize..self.starts[bin + 1] as usize];
                if self.is_blocked(members, a, b) {
                    return true;
                }
                step = step.max(f64::from(self.clearance[bin]) - 1.0);
            }
            way += step + past_the_rim;
        }
        false
    }

    /// Follows the straight way from `from` to `to`: walls reflect it, an open edge lets it out.
    ///
    /// `near` is scratch space.
    pub fn travel(&self, from: Vec2, to: Vec2, near: &mut Vec<u32>) -> Path {
        let mut path = Path { position: to, bounces: [Vec2::ZERO; MOST_BOUNCES], has_left: false, is_held: false };
        let reach = (to - from).norm() + 10.0 * self.margin;
        if self.is_clear(from, reach) {
            return path;
        }
        self.near(from, reach, near);
        let mut start = from;
        for bounce in 0..=MOST_BOUNCES {
            let first = near
                .iter()
                .filter_map(|&member| {
                    let edge = &self.edges[member as usize];
                    edge.crossing(start, path.position, self.margin).map(|share| (share, edge))
                })
                .min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((share, edge)) = first else { return path };
            if edge.is_open {
                path.has_left = true;
                return path;
            }
            if bounce == MOST_BOUNCES {
                break;
            }
            // The normal points to the side from which the way comes; the way ends at least a margin off the wall.
            let normal = edge.direction().perpendicular() * edge.side(start).signum();
            let behind = normal.dot(path.position - edge.start);
            path.bounces[bounce] = normal;
            let hit = start + (path.position - start) * share;
            path.position += normal * (-behind + (-behind).max(self.margin));
            // A step back keeps a hit in a corner on the near side of both walls.
            let back = start - hit;
            start = hit + back * (self.margin / back.norm().max(self.margin));
        }
        path.position = from;
        path.is_held = true;
        path
    }
}

#[cfg(test)]
mod tests;
