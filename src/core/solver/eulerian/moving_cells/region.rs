//! Where cells move: squares of the lattice far enough from all that only resting cells know.
//!
//! Squares beside walls, edges, sills, boundaries, sources, sections, dams and ground that moves rest, and the squares next to these are *pinned*: they
//! take part in the partition and keep their place. All others move with the water that they hold.

use std::collections::BTreeSet;

use super::super::general_faces::Place;
use super::super::state::State;

/// What a square of the lattice is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(super) enum Square {
    /// Not part of the partition.
    Apart,
    /// Rests in the rows, beside pinned cells.
    Fixed,
    /// A cell of the partition that does not move.
    Pinned,
    /// A cell of the partition that moves.
    Free,
}

/// The squares of padded rows.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct Region {
    columns: usize,
    squares: Vec<Square>,
}

impl Region {
    /// All squares of a state with terrain but those that have to rest.
    pub fn new(state: &State, resting: &BTreeSet<Place>) -> Self {
        let (columns, rows) = (state.lattice().columns + 2, state.lattice().rows + 2);
        let mut squares = vec![Square::Apart; rows * columns];
        let rests = |row: usize, column: usize| !state.has_terrain(row, column) || resting.contains(&(row, column));
        for row in 1..rows - 1 {
            for column in 1..columns - 1 {
                squares[row * columns + column] = if rests(row, column) { Square::Fixed } else { Square::Free };
            }
        }
        let mut region = Region { columns, squares };
        let is_beside = |region: &Region, row: usize, column: usize, kinds: &[Square]| {
            let rows = row.saturating_sub(1)..(row + 2).min(rows);
            rows.flat_map(|r| (column.saturating_sub(1)..(column + 2).min(columns)).map(move |c| (r, c)))
                .any(|(r, c)| kinds.contains(&region.at((r, c))))
        };
        let places = || (1..rows - 1).flat_map(|row| (1..columns - 1).map(move |column| (row, column)));
        let beside_fixed: Vec<Place> = places()
            .filter(|&(row, column)| region.at((row, column)) == Square::Free)
            .filter(|&(row, column)| is_beside(&region, row, column, &[Square::Fixed, Square::Apart]))
            .collect();
        for place in beside_fixed {
            *region.at_mut(place) = Square::Pinned;
        }
        let apart: Vec<Place> = places()
            .filter(|&(row, column)| region.at((row, column)) == Square::Fixed)
            .filter(|&(row, column)| {
                !state.has_terrain(row, column) || !is_beside(&region, row, column, &[Square::Pinned])
            })
            .collect();
        for place in apart {
            *region.at_mut(place) = Square::Apart;
        }
        region
    }

    /// What a padded place is.
    pub fn at(&self, (row, column): Place) -> Square {
        self.squares[row * self.columns + column]
    }

    /// Whether a padded place is that of a cell of the partition, at the start.
    pub fn holds(&self, place: Place) -> bool {
        place.0 < self.squares.len() / self.columns && matches!(self.at(place), Square::Pinned | Square::Free)
    }

    fn at_mut(&mut self, (row, column): Place) -> &mut Square {
        &mut self.squares[row * self.columns + column]
    }

    /// The places of squares in the partition or beside it, with what they are: near ones have near numbers.
    pub fn cells(&self) -> Vec<(Place, Square)> {
        let rows = self.squares.len() / self.columns;
        let blocks = |count: usize| (0..count.div_ceil(BLOCK)).map(move |k| k * BLOCK..((k + 1) * BLOCK).min(count));
        let in_blocks = blocks(rows).flat_map(|rows| blocks(self.columns).map(move |columns| (rows.clone(), columns)));
        let places = in_blocks.flat_map(|(rows, columns)| rows.flat_map(move |r| columns.clone().map(move |c| (r, c))));
        places.map(|place| (place, self.at(place))).filter(|(_, square)| *square != Square::Apart).collect()
    }
}

/// Squares along a block of near numbers.
const BLOCK: usize = 16;
