//! Where general faces stand in the rows of the lattice: the cells beside them, and the sides of these.

use std::ops::Range;

use super::super::faces::EAST;
use super::super::state::{Slot, State};
use super::super::walls::{Beside, Walls};
use super::face::{Face, Place};

/// A cell with general faces: those on each of its sides, in the order of [`NEIGHBOURS`](crate::lattice::NEIGHBOURS).
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Cell {
    pub place: Place,
    pub beside: Beside,
    pub faces: [Vec<usize>; 4],
}

/// A side of a cell in the rows of fluxes, and the faces that it consists of.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct SideOfCell {
    pub slot: Slot,
    /// Which side of its faces it is.
    pub side: usize,
    pub faces: Vec<usize>,
}

/// Something that belongs to padded rows, row by row.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct ByRow<T> {
    all: Vec<T>,
    of_row: Vec<Range<usize>>,
}

impl<T> ByRow<T> {
    /// `all` is sorted by row, among so many.
    fn new(all: Vec<T>, rows: usize, row_of: impl Fn(&T) -> usize) -> Self {
        let first = |row: usize| all.partition_point(|one| row_of(one) < row);
        let of_row = (0..rows).map(|row| first(row)..first(row + 1)).collect();
        ByRow { all, of_row }
    }

    /// Those of a row.
    pub fn of_row(&self, row: usize) -> &[T] {
        &self.all[self.of_row[row].clone()]
    }
}

/// The cells with general faces.
pub(super) fn cells_beside(faces: &[Face], state: &State, walls: &Walls) -> ByRow<Cell> {
    let mut beside: Vec<(Place, usize, usize)> = Vec::new();
    for (number, face) in faces.iter().enumerate() {
        let sides = if face.direction == EAST { [0, 1] } else { [2, 3] };
        beside.extend(face.places.into_iter().zip(sides).map(|(place, side)| (place, side, number)));
    }
    beside.retain(|(place, ..)| state.has_terrain(place.0, place.1));
    beside.sort_unstable();
    let cell = |beside: &[(Place, usize, usize)]| {
        let on = |side: usize| beside.iter().filter(|(_, of, _)| *of == side).map(|(.., face)| *face).collect();
        let place = beside[0].0;
        Cell { place, beside: walls.beside(place.0, place.1), faces: [0, 1, 2, 3].map(on) }
    };
    let cells = beside.chunk_by(|a, b| a.0 == b.0).map(cell).collect();
    ByRow::new(cells, state.rows + 2, |cell: &Cell| cell.place.0)
}

/// The sides of cells that consist of general faces.
pub(super) fn sides_of_cells(faces: &[Face], state: &State) -> ByRow<SideOfCell> {
    let of_face = |(number, face): (usize, &Face)| {
        [0, 1].map(|side| {
            let Slot { row, direction, column } = face.slots[side];
            ([row, column, direction, side], number)
        })
    };
    let mut all: Vec<([usize; 4], usize)> = faces.iter().enumerate().flat_map(of_face).collect();
    all.sort_unstable();
    let of_side = |faces: &[([usize; 4], usize)]| {
        let [row, column, direction, side] = faces[0].0;
        SideOfCell { slot: Slot { row, direction, column }, side, faces: faces.iter().map(|(_, face)| *face).collect() }
    };
    let sides = all.chunk_by(|a, b| a.0 == b.0).map(of_side).collect();
    ByRow::new(sides, state.rows + 2, |side: &SideOfCell| side.slot.row)
}
