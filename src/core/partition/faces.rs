//! The faces between cells: edges of the mesh, those of one straight face put together.

use super::mesh::Mesh;
use super::{LineKind, Side};
use crate::math::Vec2;

/// How far (spacings) the corner between two edges may lie beside the straight face that replaces them: on a line, and elsewhere. The
/// areas of cells are those within their faces.
const STRAIGHT: [f64; 2] = [1e-13, 1e-9];

/// A direction to which hardly any line is at right angles.
const FORWARD: Vec2 = Vec2::new(1.0, 0.618_034);

const NONE: u32 = u32::MAX;

/// A face with the numbers of its ends; side 0 is a cell, to the left on the way from `ends[0]` to `ends[1]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshFace {
    /// What is on either side.
    pub sides: [Side; 2],
    /// Its ends.
    pub ends: [u32; 2],
    /// The line on which it lies.
    pub line: Option<u32>,
}

/// The faces of all cells; a wall between two cells gives one for each.
///
/// - `side_of`: what a part of the mesh belongs to; of no part, what is there beside the middle of an edge.
pub fn faces(mesh: &Mesh, kinds: &[LineKind], side_of: impl Fn(Option<u32>, Vec2) -> Side) -> Vec<MeshFace> {
    let is_wall = |line: Option<u32>| line.is_some_and(|line| kinds[line as usize] != LineKind::Follow);
    let mut found: Vec<MeshFace> = Vec::new();
    for edge in &mesh.edges {
        let [from, to] = edge.ends.map(|end| mesh.places[end as usize]);
        let beside = (from + to) * 0.5 - (to - from).perpendicular() * (0.1 / (to - from).norm());
        let sides = [side_of(Some(edge.left), beside), side_of(edge.right, beside)];
        let (ends, line) = (edge.ends, edge.line);
        let back = [ends[1], ends[0]];
        match sides {
            [Side::Cell(a), Side::Cell(b)] if a == b && !is_wall(line) => {}
            // Walls within a cell all run the same way, so that they can be put together.
            [Side::Cell(a), Side::Cell(b)] if a == b && (to - from).dot(FORWARD) < 0.0 => {
                found.push(MeshFace { sides, ends: back, line });
            }
            [Side::Cell(a), Side::Cell(b)] if a > b => {
                found.push(MeshFace { sides: [sides[1], sides[0]], ends: back, line })
            }
            [Side::Cell(_), _] => found.push(MeshFace { sides, ends, line }),
            [_, Side::Cell(_)] => found.push(MeshFace { sides: [sides[1], sides[0]], ends: back, line }),
            _ => {}
        }
    }
    let found = straightened(found, &mesh.places);
    found.into_iter().flat_map(|face| walls_parted(face, is_wall(face.line))).collect()
}

/// A face on a wall as the faces of the cells on either side.
fn walls_parted(face: MeshFace, is_wall: bool) -> impl Iterator<Item = MeshFace> {
    let [a, b] = face.sides;
    let own = MeshFace { sides: [a, if is_wall { Side::Wall } else { b }], ..face };
    let is_between = is_wall && matches!(b, Side::Cell(_));
    let other = MeshFace { sides: [b, Side::Wall], ends: [face.ends[1], face.ends[0]], ..face };
    [Some(own), is_between.then_some(other)].into_iter().flatten()
}

/// Puts edges together that follow each other on a straight line between the same sides.
fn straightened(faces: Vec<MeshFace>, places: &[Vec2]) -> Vec<MeshFace> {
    let mut of_corner: Vec<[u32; 2]> = vec![[NONE; 2]; places.len()];
    let mut count: Vec<u8> = vec![0; places.len()];
    for (number, face) in faces.iter().enumerate() {
        for end in face.ends.map(|end| end as usize) {
            if count[end] < 2 {
                of_corner[end][count[end] as usize] = number as u32;
            }
            count[end] = count[end].saturating_add(1);
        }
    }
    // The face that goes on from a corner at which one arrives by another one.
    let after = |number: u32, corner: u32, is_forward: bool| -> Option<u32> {
        if count[corner as usize] != 2 {
            return None;
        }
        let [a, b] = of_corner[corner as usize];
        let (own, other) = (faces[number as usize], if a == number { b } else { a });
        let next = faces[other as usize];
        let meets = if is_forward { next.ends[0] == corner } else { next.ends[1] == corner };
        let is_same = other != number && meets && own.sides == next.sides && own.line == next.line;
        let [first, second] = if is_forward { [own, next] } else { [next, own] };
        (is_same && is_straight(first.ends, second.ends[1], own.line, places)).then_some(other)
    };
    let mut found = Vec::with_capacity(faces.len());
    for (number, face) in faces.iter().enumerate() {
        if after(number as u32, face.ends[0], false).is_some() {
            continue;
        }
        let (mut whole, mut last) = (*face, number as u32);
        while let Some(next) = after(last, whole.ends[1], true) {
            let next_ends = faces[next as usize].ends;
            if !is_straight(whole.ends, next_ends[1], whole.line, places) {
                found.push(whole);
                whole.ends[0] = next_ends[0];
            }
            whole.ends[1] = next_ends[1];
            last = next;
        }
        found.push(whole);
    }
    found
}

/// Whether one goes straight on from an edge to a further corner.
fn is_straight(ends: [u32; 2], further: u32, line: Option<u32>, places: &[Vec2]) -> bool {
    let [from, corner, to] = [ends[0], ends[1], further].map(|end| places[end as usize]);
    let (first, second) = (corner - from, to - corner);
    let bend = first.cross(second).abs() / (to - from).norm();
    bend <= STRAIGHT[usize::from(line.is_none())] && first.dot(second) > 0.0
}
