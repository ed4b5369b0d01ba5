//! The faces of open boundaries: straight pieces of the outline, one spacing long, each with the condition nearest to it.

use crate::boundary::{Edge, distance_to_segment};
use crate::math::Vec2;
use crate::physics::dimension::Dimension;
use crate::solver::{EdgeFace, FlowProblem, edge_faces};

/// A piece of an open boundary.
#[derive(Clone, Debug)]
pub(super) struct Face {
    /// Index of its boundary.
    pub line: usize,
    /// Its ends (m).
    pub ends: [Vec2; 2],
    /// Its middle (m).
    pub middle: Vec2,
    /// Unit normal away from the terrain.
    pub outwards: Vec2,
    /// Length (m); 1 in one dimension, where volumes are per metre of width.
    pub width: f64,
    /// Elevation of the bed (m) and its slope.
    pub sill: f64,
    pub slope: Vec2,
    /// g n² (m^(1/3)).
    pub friction: f64,
    /// Level (m) of the water at the start; none where it was dry.
    pub rest: Option<f64>,
}

impl Face {
    /// Distance (m) of a place beyond the face; negative on the terrain.
    #[inline]
    pub fn beyond(&self, place: Vec2) -> f64 {
        (place - self.middle).dot(self.outwards)
    }

    /// The share of a particle (0 to 1) that stands beyond the face: that of its edge (m) along the way out.
    pub fn share_beyond(&self, place: Vec2, edge: f64) -> f64 {
        (0.5 + self.beyond(place) / edge).clamp(0.0, 1.0)
    }

    /// Whether a place lies before the piece, or behind it, and not to a side.
    pub fn faces(&self, place: Vec2) -> bool {
        let along = (place - self.middle).cross(self.outwards);
        let half = 0.5 * (self.ends[1] - self.ends[0]).norm();
        along > -half && along <= half
    }

    /// Its length in spacings; 1 in one dimension.
    pub fn width_in(&self, spacing: f64) -> f64 {
        (self.ends[1] - self.ends[0]).norm() / spacing
    }

    /// Distance (m) of a place from the piece.
    pub fn distance(&self, place: Vec2) -> f64 {
        distance_to_segment(place, self.ends[0], self.ends[1])
    }
}

/// The faces of all boundaries of a problem, and the walls that guide the water beyond them up to `depth` (m): without them the
/// particles in a corner between a boundary and a wall would see water beyond the one and nothing beyond the other.
///
/// `edges`: the outline, with terrain to the left of each.
pub(super) fn faces_and_guides(
    problem: &FlowProblem,
    edges: &[Edge],
    dimension: Dimension,
    depth: f64,
) -> (Vec<Face>, Vec<Edge>) {
    if problem.forcing.boundaries.is_empty() {
        return (Vec::new(), Vec::new());
    }
    if dimension == Dimension::One {
        return (faces_of_channel(problem), Vec::new());
    }
    let bed = &problem.bed;
    let spacing = bed.lattice.spacing;
    let openings: Vec<(Vec2, Option<usize>)> = edge_faces(&bed.lattice, &bed.elevation)
        .into_iter()
        .map(|EdgeFace { cell, middle }| {
            let line = problem.forcing.boundary_at(middle, middle - bed.lattice.centre(cell));
            (middle, line.filter(|_| !bed.is_sealed(middle)))
        })
        .collect();
    let line_at = |place: Vec2| {
        let squared = |opening: &&(Vec2, Option<usize>)| (opening.0 - place).norm_squared();
        openings.iter().min_by(|a, b| squared(a).total_cmp(&squared(b))).and_then(|opening| opening.1)
    };
    let mut faces: Vec<Face> = Vec::new();
    for edge in edges.iter().filter(|edge| edge.is_open) {
        let along = edge.end - edge.start;
        let count = (along.norm() / spacing).round().max(1.0);
        let outwards = -edge.direction().perpendicular();
        for k in 0..count as usize {
            let [start, end] = [k as f64, k as f64 + 1.0].map(|k| edge.start + along * (k / count));
            let middle = (start + end) * 0.5;
            if let Some(line) = line_at(middle) {
                faces.push(face(problem, line, [start, end], outwards, (end - start).norm()));
            }
        }
    }
    let guides = guides(&faces, depth, 1e-6 * spacing);
    (faces, guides)
}

/// The ends of a channel of one dimension that are open.
fn faces_of_channel(problem: &FlowProblem) -> Vec<Face> {
    let size = problem.bed.lattice.size();
    let end = |(x, outwards): (f64, Vec2)| {
        let middle = Vec2::new(x, 0.5 * size.y);
        let line = problem.forcing.boundary_at(middle, outwards).filter(|_| !problem.bed.is_sealed(middle))?;
        Some(face(problem, line, [Vec2::new(x, 0.0), Vec2::new(x, size.y)], outwards, 1.0))
    };
    [(0.0, Vec2::new(-1.0, 0.0)), (size.x, Vec2::new(1.0, 0.0))].into_iter().filter_map(end).collect()
}

fn face(problem: &FlowProblem, line: usize, ends: [Vec2; 2], outwards: Vec2, width: f64) -> Face {
    let (bed, lattice) = (&problem.bed, &problem.bed.lattice);
    let middle = (ends[0] + ends[1]) * 0.5;
    // A straightened outline may run up to a third of a spacing off the faces of the cells.
    let inside = |share: f64| middle - outwards * (share * lattice.spacing);
    let point = [1e-6, 0.1, 0.3, 0.5].into_iter().find_map(|share| bed.at(inside(share)).map(|point| (share, point)));
    let (sill, slope) = point.map_or((f64::INFINITY, Vec2::ZERO), |(share, point)| {
        (point.elevation + point.slope.dot(outwards) * (share * lattice.spacing), point.slope)
    });
    let cell = [0.5, 0.3, 0.1]
        .into_iter()
        .find_map(|share| lattice.cell_at(inside(share)).filter(|&cell| bed.has_terrain(cell)));
    let roughness = cell.map_or(0.0, |cell| bed.manning[cell]);
    let rest = cell.filter(|&cell| problem.initial_depth[cell] > problem.dry_depth);
    let rest = rest.map(|cell| bed.elevation[cell] + problem.initial_depth[cell]);
    let friction = problem.gravity * roughness * roughness;
    Face { line, ends, middle, outwards, width, sill, slope, friction, rest }
}

/// Walls that go on outwards from both ends of each chain of faces.
fn guides(faces: &[Face], depth: f64, margin: f64) -> Vec<Edge> {
    let mut guides = Vec::new();
    for face in faces {
        for (k, &end) in face.ends.iter().enumerate() {
            let goes_on = |other: &Face| (other.ends[1 - k] - end).norm() <= margin;
            if !faces.iter().any(goes_on) {
                guides.push(Edge { start: end, end: end + face.outwards * depth, is_open: false });
            }
        }
    }
    guides
}
