//! The outline of the terrain as straight edges: around the lattice and around every area without data.
//!
//! The outline runs through the midpoints of the faces between cells with and without terrain, so that every cell centre
//! with terrain lies inside; stair steps become straight where that moves the line by less than 0.3 spacings, while corners
//! of the lattice and corners between longer straight pieces stay sharp. Areas touching only at a corner stay apart.

use super::edge::Edge;
use crate::bed::BedParticles;
use crate::math::Vec2;

/// How far (in spacings) a stair step may be straightened: less than the 0.35 between a cell centre and a cut corner.
const STRAIGHTENING: f64 = 0.3;
/// Straight runs of at least so many faces keep the corner between them.
const SHARP_RUN: usize = 3;

/// A directed face with terrain to its left.
#[derive(Clone, Copy, Debug)]
struct Face {
    start: (i64, i64),
    direction: (i64, i64),
    is_open: bool,
}

impl Face {
    fn end(&self) -> (i64, i64) {
        (self.start.0 + self.direction.0, self.start.1 + self.direction.1)
    }
}

/// The edges of the terrain in local coordinates, open where the midpoint of a face is.
pub fn outline(bed: &BedParticles, is_open: impl Fn(Vec2, Vec2) -> bool) -> Vec<Edge> {
    let mut edges = Vec::new();
    for ring in rings(bed, is_open) {
        let first = ring
            .iter()
            .enumerate()
            .position(|(k, face)| face.is_open != ring[(k + ring.len() - 1) % ring.len()].is_open);
        let is_uniform = first.is_none();
        let mut faces = ring;
        faces.rotate_left(first.unwrap_or(0));
        let mut from = 0;
        while from < faces.len() {
            let run = faces[from..].iter().take_while(|face| face.is_open == faces[from].is_open).count();
            let points = polyline(&faces[from..from + run], is_uniform, bed);
            let is_open = faces[from].is_open;
            edges.extend(points.windows(2).map(|pair| Edge { start: pair[0], end: pair[1], is_open }));
            from += run;
        }
    }
    edges
}

/// Closed chains of faces, each with terrain to the left.
fn rings(bed: &BedParticles, is_open: impl Fn(Vec2, Vec2) -> bool) -> Vec<Vec<Face>> {
    let lattice = &bed.lattice;
    let (columns, rows) = (lattice.columns as i64, lattice.rows as i64);
    let has_terrain = |column: i64, row: i64| {
        column >= 0 && row >= 0 && column < columns && row < rows && bed.has_terrain((row * columns + column) as usize)
    };
    // The face that leaves vertex (column, row) in direction k (east, north, west, south) exists when there is terrain to its
    // left and none to its right.
    let directions = [(1_i64, 0_i64), (0, 1), (-1, 0), (0, -1)];
    let left_cell = [(0, 0), (-1, 0), (-1, -1), (0, -1)];
    let right_cell = [(0, -1), (0, 0), (-1, 0), (-1, -1)];
    let exists = |vertex: (i64, i64), k: usize| {
        has_terrain(vertex.0 + left_cell[k].0, vertex.1 + left_cell[k].1)
            && !has_terrain(vertex.0 + right_cell[k].0, vertex.1 + right_cell[k].1)
    };
    let slot = |vertex: (i64, i64), k: usize| ((vertex.1 * (columns + 1) + vertex.0) * 4) as usize + k;
    let mut is_used = vec![false; ((columns + 1) * (rows + 1) * 4) as usize];
    let mut rings = Vec::new();
    for start in (0..=rows).flat_map(|row| (0..=columns).map(move |column| (column, row))) {
        for first in 0..4 {
            if !exists(start, first) || is_used[slot(start, first)] {
                continue;
            }
            let (mut vertex, mut k) = (start, first);
            let mut ring = Vec::new();
            while !is_used[slot(vertex, k)] {
                is_used[slot(vertex, k)] = true;
                let face = Face { start: vertex, direction: directions[k], is_open: false };
                let place = midpoint(&face) * lattice.spacing;
                let along = Vec2::new(directions[k].0 as f64, directions[k].1 as f64);
                ring.push(Face { is_open: is_open(place, along.perpendicular()) && !bed.is_sealed(place), ..face });
                vertex = face.end();
                // Left turn first: diagonal cells with terrain are not joined.
                match [1, 0, 3].into_iter().map(|turn| (k + turn) % 4).find(|&next| exists(vertex, next)) {
                    Some(next) => k = next,
                    None => break,
                }
            }
            rings.push(ring);
        }
    }
    rings
}

fn midpoint(face: &Face) -> Vec2 {
    Vec2::new(face.start.0 as f64 + 0.5 * face.direction.0 as f64, face.start.1 as f64 + 0.5 * face.direction.1 as f64)
}

fn vertex(point: (i64, i64)) -> Vec2 {
    Vec2::new(point.0 as f64, point.1 as f64)
}

/// The simplified points (m) of one run of faces; a closed ring repeats its first point at the end.
fn polyline(faces: &[Face], is_closed: bool, bed: &BedParticles) -> Vec<Vec2> {
    let runs = straight_runs(faces, is_closed);
    let (columns, rows) = (bed.lattice.columns as i64, bed.lattice.rows as i64);
    let mut points = Vec::new();
    let mut first_corner = None;
    if !is_closed {
        points.push(vertex(faces[0].start));
    }
    for (k, face) in faces.iter().enumerate() {
        points.push(midpoint(face));
        let next = if k + 1 < faces.len() { k + 1 } else { 0 };
        if (next > 0 || is_closed) && faces[next].direction != face.direction {
            let corner = face.end();
            let on_lattice_corner = (corner.0 == 0 || corner.0 == columns) && (corner.1 == 0 || corner.1 == rows);
            if on_lattice_corner || runs[k].min(runs[next]) >= SHARP_RUN {
                first_corner = first_corner.or(Some(points.len()));
                points.push(vertex(corner));
            }
        }
    }
    if is_closed {
        // The first point stays whatever it is: a ring begins at a corner, so that no straight wall has a joint.
        points.rotate_left(first_corner.unwrap_or(0));
        points.push(points[0]);
    } else {
        points.push(vertex(faces[faces.len() - 1].end()));
    }
    let simple = simplified(&points);
    let kept = if is_closed && simple.len() < 4 { points } else { simple };
    kept.into_iter().map(|point| point * bed.lattice.spacing).collect()
}

/// For every face, how many faces its straight piece has, counted up to `SHARP_RUN`.
fn straight_runs(faces: &[Face], is_closed: bool) -> Vec<usize> {
    let count = faces.len();
    let reach = SHARP_RUN.min(count) - 1;
    (0..count)
        .map(|k| {
            let same = |other: usize| faces[other % count].direction == faces[k].direction;
            let ahead = (1..=reach).take_while(|step| (is_closed || k + step < count) && same(k + step)).count();
            let behind = (1..=reach).take_while(|&step| (is_closed || step <= k) && same(k + count - step)).count();
            (1 + ahead + behind).min(SHARP_RUN)
        })
        .collect()
}

/// Douglas and Peucker's simplification in units of the spacing; the first and the last point stay.
fn simplified(points: &[Vec2]) -> Vec<Vec2> {
    let mut keep = vec![false; points.len()];
    let last = points.len() - 1;
    keep[0] = true;
    keep[last] = true;
    let mut stack = vec![(0, last)];
    while let Some((from, to)) = stack.pop() {
        let mut farthest = (STRAIGHTENING, 0);
        for k in from + 1..to {
            let distance = super::edge::distance_to_segment(points[k], points[from], points[to]);
            if distance > farthest.0 {
                farthest = (distance, k);
            }
        }
        if farthest.1 > 0 {
            keep[farthest.1] = true;
            stack.push((from, farthest.1));
            stack.push((farthest.1, to));
        }
    }
    points.iter().zip(keep).filter(|(_, kept)| *kept).map(|(&point, _)| point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::OpenEdges;
    use crate::lattice::Lattice;

    fn bed(columns: usize, rows: usize, has_terrain: impl Fn(usize, usize) -> bool) -> BedParticles {
        let lattice = Lattice::new(Vec2::ZERO, columns, rows, 2.0);
        let elevation = (0..lattice.len())
            .map(|index| {
                let (column, row) = lattice.column_row(index);
                if has_terrain(column, row) { 0.0 } else { f64::NAN }
            })
            .collect();
        BedParticles::from_elevation(lattice, elevation, 0.0)
    }

    fn enclosed_area(edges: &[Edge]) -> f64 {
        edges.iter().map(|edge| 0.5 * edge.start.cross(edge.end)).sum()
    }

    #[test]
    fn rectangle_keeps_its_corners() {
        let edges = outline(&bed(7, 5, |_, _| true), |_, _| false);
        assert!((enclosed_area(&edges) - 14.0 * 10.0).abs() < 1e-12);
        assert!(edges.len() == 4 && edges.iter().all(|edge| !edge.is_open), "no joint in a straight wall");
    }

    #[test]
    fn hole_and_stair_keep_every_centre_inside() {
        let terrain = |column: usize, row: usize| column + row < 14 && !(column == 3 && row == 3);
        let bed = bed(10, 10, terrain);
        let edges = outline(&bed, |_, _| false);
        for index in (0..bed.lattice.len()).filter(|&index| bed.has_terrain(index)) {
            let centre = bed.lattice.centre(index);
            let nearest = edges
                .iter()
                .map(|edge| super::super::edge::distance_to_segment(centre, edge.start, edge.end))
                .fold(f64::INFINITY, f64::min);
            assert!(nearest > 0.05 * 2.0, "centre {index} is {nearest} m from the outline");
        }
        let diagonal = edges.iter().map(|edge| (edge.end - edge.start).norm()).fold(0.0, f64::max);
        assert!(diagonal > 7.0, "the stair becomes one line");
    }

    #[test]
    fn lines_open_the_faces_within_reach() {
        let east =
            OpenEdges { pieces: vec![[Vec2::new(14.0, 0.0), Vec2::new(14.0, 10.0)]].into(), reach: 0.5, outline: None };
        let edges = outline(&bed(7, 5, |_, _| true), |place, normal| east.is_open(place, normal));
        let open: Vec<&Edge> = edges.iter().filter(|edge| edge.is_open).collect();
        assert!(!open.is_empty() && open.iter().all(|edge| edge.start.x > 13.999 && edge.end.x > 13.999));
        let length: f64 = open.iter().map(|edge| (edge.end - edge.start).norm()).sum();
        assert!((length - 10.0).abs() < 1e-12);
        assert!((enclosed_area(&edges) - 140.0).abs() < 1e-12);
    }

    #[test]
    fn sealed_cells_stay_closed_whatever_opens_the_outline() {
        let hole = |column: usize, row: usize| (3..5).contains(&column) && row == 2;
        let mut bed = bed(7, 5, |column, row| !hole(column, row));
        let everything = |_: Vec2, _: Vec2| true;
        assert!(outline(&bed, everything).iter().all(|edge| edge.is_open));
        bed.sealed = (0..35).filter(|&index| hole(index % 7, index / 7)).collect();
        let closed: Vec<Edge> = outline(&bed, everything).into_iter().filter(|edge| !edge.is_open).collect();
        assert!(!closed.is_empty());
        for edge in closed {
            let middle = (edge.start + edge.end) * 0.5;
            assert!((middle - Vec2::new(8.0, 5.0)).norm() < 3.0, "{middle:?}");
        }
    }
}
