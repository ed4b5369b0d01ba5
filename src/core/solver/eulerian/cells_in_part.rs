//! Cells in part: those of which the terrain covers more or less than their cell (M13).
//!
//! Faces are as long as the terrain along them; what of a side no water passes is a wall:
//!
//! ```text
//! (M28)  F ← ψ F + (w − ψ) F_wall,    Δt ≤ CFL Δ / (μ (|v| + c)),   μ = max(1, Σ_k w_k / (4 φ))
//! ```
//!
//! with ψ and w of (M14). The walls of both sides are those of [`super::walls`]; the pressure of still water is not part of any F, so
//! that water at rest stays at rest in cells of any shape. μ is the length of the sides over the area, against those of a whole cell.

use rayon::prelude::*;

use super::Scale;
use super::conforming::shape::Shape;
use super::faces::{EAST, NORTH, turned_by};
use super::rows::other;
use super::spans::ActiveSet;
use super::state::{Fastest, State};
use super::walls::mirrored;
use crate::lattice::Side;
use crate::math::larger;
use crate::solver::FlowProblem;

/// Parts of a side shorter than this (in spacings) are rounding.
const ROUNDING: f64 = 1e-9;

/// A face in the row of its owner.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
struct Face {
    column: usize,
    direction: usize,
    /// ψ, and what of the sides before and behind it is wall.
    open: f64,
    walls: [f64; 2],
}

/// A padded cell.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
struct Cell {
    row: usize,
    column: usize,
    area: f64,
    /// μ.
    haste: f64,
}

/// The cells in part of a problem, and their faces of every padded row.
#[derive(serde::Serialize, serde::Deserialize)]
pub(crate) struct CellsInPart {
    faces: Vec<Vec<Face>>,
    cells: Vec<Cell>,
}

impl CellsInPart {
    pub fn new(problem: &FlowProblem, state: &State) -> Self {
        let (lattice, cover) = (&problem.bed.lattice, &problem.bed.cover);
        let mut faces = vec![Vec::new(); state.rows + 2];
        let is_between_levels = |(row, column): (usize, usize), direction: usize| {
            [(row, column), other((row, column), direction)]
                .iter()
                .any(|&(row, column)| state.is_elsewhere(row, column))
        };
        for face in cover.faces() {
            let direction = if face.is_north { NORTH } else { EAST };
            if is_between_levels(face.place, direction) {
                continue;
            }
            let walls = face.sides.map(|side| side - face.open);
            faces[face.place.0].push(Face { column: face.place.1, direction, open: face.open, walls });
        }
        let cell = |part: &crate::bed::CellInPart| {
            let (column, row) = lattice.column_row(part.cell);
            let haste = larger(part.sides.iter().sum::<f64>() / (4.0 * part.area), 1.0);
            Cell { row: row + 1, column: column + 1, area: part.area, haste }
        };
        let mut cells: Vec<Cell> = cover.cells().iter().filter(|part| lattice.is_leaf(part.cell)).map(cell).collect();
        cells.extend(conforming(problem, state));
        cells.sort_by_key(|cell| (cell.row, cell.column));
        CellsInPart { faces, cells }
    }

    /// The length (in spacings) through which water passes a face, given by the padded row and column of its owner and its direction.
    pub fn open(&self, (row, column): (usize, usize), direction: usize) -> f64 {
        let found = self.faces[row].iter().find(|face| face.column == column && face.direction == direction);
        found.map_or(1.0, |face| face.open)
    }

    /// The padded places (row, column) of cells that own faces in part.
    pub fn owners(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.faces.iter().enumerate().flat_map(|(row, faces)| faces.iter().map(move |face| (row, face.column)))
    }

    /// The padded places of cells in part, and of those beside their faces.
    pub fn places(&self) -> Vec<(usize, usize)> {
        let of_face = |(row, face): (usize, &Face)| {
            let place = (row, face.column);
            [place, other(place, face.direction)]
        };
        let faces = self.faces.iter().enumerate().flat_map(|(row, faces)| faces.iter().map(move |face| (row, face)));
        faces.flat_map(of_face).chain(self.cells.iter().map(|cell| (cell.row, cell.column))).collect()
    }

    /// Whether a padded cell is in part.
    pub fn holds(&self, row: usize, column: usize) -> bool {
        self.find((row, column)).is_some()
    }

    /// μ of a padded cell (row, column).
    pub fn haste(&self, place: (usize, usize)) -> f64 {
        self.find(place).map_or(1.0, |cell| cell.haste)
    }

    fn find(&self, place: (usize, usize)) -> Option<&Cell> {
        let found = self.cells.binary_search_by_key(&place, |cell| (cell.row, cell.column));
        found.ok().map(|found| &self.cells[found])
    }

    /// Brings the fluxes of faces in part to what passes them.
    pub fn apply(&self, state: &mut State, active: &ActiveSet, scale: &Scale) {
        if self.cells.is_empty() {
            return;
        }
        let primitive = &state.primitive;
        active.rows_of(&mut state.flux).for_each(|(row, flux)| {
            for face in self.faces[row].iter().filter(|face| !active.is_asleep(row, face.column)) {
                let i = face.column;
                let behind = if face.direction == EAST { (row, i + 1) } else { (row + 1, i) };
                let thrust = |side: usize, (row, column): (usize, usize), sign: f64| {
                    let water = &primitive[row];
                    if face.walls[side].abs() < ROUNDING || water.depth[column] <= scale.dry_depth {
                        return 0.0;
                    }
                    let (u, v) = (water.velocity_x[column], water.velocity_y[column]);
                    let towards = sign * turned_by(face.direction, u, v).0;
                    face.walls[side] * mirrored(water.depth[column], towards, scale.gravity)
                };
                let thrusts = [thrust(0, (row, i), 1.0), thrust(1, behind, -1.0)];
                let out = &mut flux[face.direction];
                out.scale(i, face.open);
                out.normal_left[i] += thrusts[0];
                out.normal_right[i] += thrusts[1];
            }
        });
    }

    /// The greatest signal speed of the cells of a level (m/s), times μ and as [`State::fastest`] has it; where it is, and the flow speed of all water.
    pub fn fastest(&self, state: &State, scale: &Scale, level: usize) -> Fastest {
        let mut fastest = state.fastest(level);
        let rows = state.rows_of(&(level..level + 1));
        for &Cell { row, column, haste, .. } in self.cells.iter().filter(|cell| rows.contains(&cell.row)) {
            let water = &state.primitive[row];
            let (d, u, v) = (water.depth[column], water.velocity_x[column], water.velocity_y[column]);
            if d > scale.dry_depth {
                let signal_speed = state.haste(row) * haste * ((u * u + v * v).sqrt() + (scale.gravity * d).sqrt());
                if signal_speed > fastest.signal_speed {
                    fastest = Fastest { signal_speed, row, column, ..fastest };
                }
            }
        }
        fastest
    }

    /// Volume (m³) of all water, that of cells in part by their area.
    pub fn volume(&self, state: &State) -> f64 {
        let beside = |cell: &Cell| {
            let spacing = state.spacing[cell.row];
            (cell.area - 1.0) * state.water[cell.row].depth[cell.column] * spacing * spacing
        };
        state.volume() + self.cells.iter().map(beside).sum::<f64>()
    }
}

/// The cells that follow lines: they count by their area, and their faces are in `conforming`.
fn conforming(problem: &FlowProblem, state: &State) -> Vec<Cell> {
    let lattice = &problem.bed.lattice;
    let Some(made) = lattice.conforming() else { return Vec::new() };
    let mut shapes = vec![Shape::default(); made.cells().len()];
    for face in made.faces() {
        for (side, normal) in face.sides.into_iter().zip([face.normal(), face.normal() * -1.0]) {
            if let Side::Cell(cell) = side {
                let is_wall = matches!(face.sides[1], Side::Wall | Side::Nothing);
                shapes[cell].add(normal, face.length(), is_wall);
            }
        }
    }
    let cell = |(number, of_cell): (usize, &crate::lattice::Cell)| {
        let (column, row) = lattice.column_row(made.place(number));
        let haste = shapes[number].haste(of_cell.area, lattice.spacing);
        Cell { row: row + 1, column: column + 1, area: of_cell.area / lattice.cell_area(), haste }
    };
    let cells = made.cells().iter().enumerate().map(cell);
    cells.filter(|cell| state.has_terrain(cell.row, cell.column)).collect()
}

#[cfg(test)]
mod tests;
