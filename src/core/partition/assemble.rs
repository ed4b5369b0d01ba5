//! From lines to cells and faces, in the order of the rules.

use super::faces::{MeshFace, faces};
use super::inside::Outlines;
use super::join::Groups;
use super::lines::Network;
use super::mesh::{Mesh, Part};
use super::seeds::Seeds;
use super::window::{Window, square_of};
use super::{BLOCKED, Cell, Face, Line, LineKind, Partition, Side, TOLERANCE, cut, voronoi};
use crate::lattice::{Lattice, depth_within};
use crate::math::Vec2;

/// What is at a part of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    Cell(usize),
    Wall,
    Nothing,
}

/// The partition of a lattice along some lines.
pub fn assemble(lattice: &Lattice, is_cell: &impl Fn(usize) -> bool, lines: &[Line]) -> Partition {
    let window = Window::new(lattice.columns, lattice.rows);
    let network = Network::new(window, lines, lattice.spacing);
    let outlines = Outlines::new(&network);
    let seeds = Seeds::new(&network, &outlines);
    let is_there = |column, row| window.lattice_cell((column, row)).is_some_and(is_cell);
    let (polygons, replaced) = polygons(lattice, &network, &seeds, &outlines, &is_there);
    let mesh = Mesh::new(polygons, &network);

    let start = |part: &Part| {
        let (column, row) = square_of(part.centre);
        match is_there(column, row) {
            true if outlines.hold(part.centre) => Place::Wall,
            true => Place::Cell(0),
            false => Place::Nothing,
        }
    };
    let places: Vec<Place> = mesh.parts.iter().map(start).collect();
    let is_wall = |line: u32| network.kinds[line as usize] != LineKind::Follow;
    let (cells, places, blocked) = cells(&mesh, &seeds, places, is_wall);
    let side_of = |part: Option<u32>, beside: Vec2| match part.map(|part| places[part as usize]) {
        Some(Place::Cell(cell)) => Side::Cell(cell),
        Some(Place::Wall) => Side::Wall,
        Some(Place::Nothing) => Side::Nothing,
        None => {
            let cell = window.lattice_cell(square_of(beside)).filter(|cell| is_cell(*cell) && !replaced[*cell]);
            cell.map_or(Side::Nothing, Side::Lattice)
        }
    };
    let scale = lattice.spacing;
    let face = |face: MeshFace| {
        let [from, to] = face.ends.map(|end| mesh.places[end as usize] * scale);
        Face { sides: face.sides, from, to, line: face.line.map(|line| line as usize) }
    };
    let faces = faces(&mesh, &network.kinds, side_of);
    let mut made = Partition {
        cells: with_areas(cells, &faces, &mesh.places),
        faces: faces.into_iter().map(face).collect(),
        replaced: (0..lattice.len()).filter(|cell| replaced[*cell] && is_cell(*cell)).collect(),
        blocked,
        faults: mesh.faults,
    };
    made.cells.iter_mut().for_each(|cell| enlarge(cell, scale));
    made
}

/// The polygons of the seeds, cut by the lines, and which cells of the lattice they replace.
fn polygons(
    lattice: &Lattice,
    network: &Network,
    seeds: &Seeds,
    outlines: &Outlines,
    is_there: &impl Fn(i64, i64) -> bool,
) -> (Vec<(usize, cut::Polygon)>, Vec<bool>) {
    let window = &network.window;
    let mut replaced = vec![false; lattice.len()];
    for cell in seeds.near_squares().filter_map(|square| window.lattice_cell(square)) {
        replaced[cell] = true;
    }
    let mut polygons = Vec::new();
    for (seed, place) in seeds.places.iter().enumerate() {
        if !seeds.is_square(seed) {
            let parts = cut::parts(voronoi::cell(*place, seeds), network, is_there);
            polygons.extend(parts.into_iter().map(|part| (seed, part)));
        } else if let Some(cell) = seeds.square[seed].and_then(|square| window.lattice_cell(square)) {
            replaced[cell] = false;
        }
    }
    for row in 0..lattice.rows {
        outlines.stretches(row as f64 + 0.5, |from, to| {
            // Columns whose centres lie between; a cast rounds towards 0.
            let column = |x: f64| (x + 0.5).max(0.0).min(lattice.columns as f64) as usize;
            (column(from)..column(to)).for_each(|column| replaced[lattice.index(column, row)] = true);
        });
    }
    (polygons, replaced)
}

/// The cells in units of the spacing, to which of them each part belongs, and how many parts were left out.
fn cells(
    mesh: &Mesh,
    seeds: &Seeds,
    mut places: Vec<Place>,
    is_wall: impl Fn(u32) -> bool,
) -> (Vec<Cell>, Vec<Place>, usize) {
    let corners =
        |part: &Part| -> Vec<Vec2> { part.corners.iter().map(|corner| mesh.places[*corner as usize]).collect() };
    let is_there: Vec<bool> = places.iter().map(|place| *place == Place::Cell(0)).collect();
    let holds_seed = |part: &Part| depth_within(&corners(part), seeds.places[part.seed]) >= -TOLERANCE;
    let holds_seed: Vec<bool> =
        mesh.parts.iter().zip(&is_there).map(|(part, is_there)| *is_there && holds_seed(part)).collect();
    let groups = Groups::new(mesh, &is_there, &holds_seed, is_wall);

    let mut members: Vec<(u32, u32)> =
        (0..mesh.parts.len() as u32).filter(|part| is_there[*part as usize]).map(|p| (groups.of(p), p)).collect();
    members.sort_unstable();
    let mut made: Vec<(Cell, Vec<u32>)> = Vec::new();
    let mut blocked = 0;
    for group in members.chunk_by(|a, b| a.0 == b.0) {
        let parts: Vec<u32> = group.iter().map(|(_, part)| *part).collect();
        let of_cell = parts.iter().map(|part| &mesh.parts[*part as usize]);
        let area: f64 = of_cell.clone().map(|part| part.area).sum();
        if area < BLOCKED {
            blocked += 1;
            parts.iter().for_each(|part| places[*part as usize] = Place::Wall);
            continue;
        }
        let moment = of_cell.clone().fold(Vec2::ZERO, |sum, part| sum + part.centre * part.area);
        made.push((Cell { centre: moment / area, area, parts: of_cell.map(corners).collect() }, parts));
    }
    made.sort_by_key(|(cell, parts)| {
        let (column, row) = square_of(cell.centre);
        (row, column, parts[0])
    });
    for (number, (_, parts)) in made.iter().enumerate() {
        parts.iter().for_each(|part| places[*part as usize] = Place::Cell(number));
    }
    (made.into_iter().map(|(cell, _)| cell).collect(), places, blocked)
}

/// The cells with the area within their faces, from which that of their parts differs by the tolerances.
fn with_areas(mut cells: Vec<Cell>, faces: &[MeshFace], places: &[Vec2]) -> Vec<Cell> {
    cells.iter_mut().for_each(|cell| cell.area = 0.0);
    for face in faces {
        for (side, ends) in face.sides.into_iter().zip([face.ends, [face.ends[1], face.ends[0]]]) {
            if let Side::Cell(cell) = side {
                let cell = &mut cells[cell];
                let [a, b] = ends.map(|end| places[end as usize] - cell.centre);
                cell.area += 0.5 * a.cross(b);
            }
        }
    }
    cells
}

fn enlarge(cell: &mut Cell, scale: f64) {
    cell.centre = cell.centre * scale;
    cell.area *= scale * scale;
    cell.parts.iter_mut().flatten().for_each(|corner| *corner = *corner * scale);
}
