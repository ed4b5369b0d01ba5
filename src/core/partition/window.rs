//! The squares of an endless lattice of spacing 1 by column and row; those of the lattice of a run and a margin have an index.

use crate::math::Vec2;

/// How far (squares) beyond the lattice lines still matter.
const MARGIN: i64 = 6;

/// Column and row of a square; the lattice begins at (0, 0).
pub type Square = (i64, i64);

/// The square that holds a place.
pub fn square_of(place: Vec2) -> Square {
    (place.x.floor() as i64, place.y.floor() as i64)
}

/// Centre of a square.
pub fn centre_of((column, row): Square) -> Vec2 {
    Vec2::new(column as f64 + 0.5, row as f64 + 0.5)
}

/// The lattice and its margin.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    columns: i64,
    rows: i64,
}

impl Window {
    /// The window of a lattice.
    pub fn new(columns: usize, rows: usize) -> Self {
        Window { columns: columns as i64, rows: rows as i64 }
    }

    /// Number of squares.
    pub fn len(&self) -> usize {
        ((self.columns + 2 * MARGIN) * (self.rows + 2 * MARGIN)) as usize
    }

    /// Index of a square, if the window has it.
    #[inline]
    pub fn index(&self, (column, row): Square) -> Option<usize> {
        let width = self.columns + 2 * MARGIN;
        let (column, row) = (column + MARGIN, row + MARGIN);
        let is_inside = column >= 0 && row >= 0 && column < width && row < self.rows + 2 * MARGIN;
        is_inside.then(|| (row * width + column) as usize)
    }

    /// The square of an index.
    pub fn square(&self, index: usize) -> Square {
        let width = self.columns + 2 * MARGIN;
        (index as i64 % width - MARGIN, index as i64 / width - MARGIN)
    }

    /// Index of the lattice's own cell, if the square is one.
    #[inline]
    pub fn lattice_cell(&self, (column, row): Square) -> Option<usize> {
        let is_inside = column >= 0 && row >= 0 && column < self.columns && row < self.rows;
        is_inside.then(|| (row * self.columns + column) as usize)
    }

    /// The corners in the south-west and in the north-east.
    pub fn corners(&self) -> [Vec2; 2] {
        let margin = MARGIN as f64;
        [Vec2::new(-margin, -margin), Vec2::new(self.columns as f64 + margin, self.rows as f64 + margin)]
    }

    /// The squares that a box touches, row by row, within the window.
    pub fn squares(&self, low: Vec2, high: Vec2) -> impl Iterator<Item = Square> + use<> {
        let within = |place: f64, count: i64| (place.floor() as i64).clamp(-MARGIN, count + MARGIN - 1);
        let columns = within(low.x, self.columns)..=within(high.x, self.columns);
        let rows = within(low.y, self.rows)..=within(high.y, self.rows);
        rows.flat_map(move |row| columns.clone().map(move |column| (column, row)))
    }

    /// Row of a place counted from the southern end of the margin, within the window.
    pub fn row_of(&self, y: f64) -> usize {
        ((y.floor() as i64).clamp(-MARGIN, self.rows + MARGIN - 1) + MARGIN) as usize
    }

    /// Number of rows with the margin.
    pub fn row_count(&self) -> usize {
        (self.rows + 2 * MARGIN) as usize
    }
}
