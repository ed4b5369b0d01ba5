//! The regular lattice of riverbed particles, and what lies on it.
//!
//! Row 0 is the southernmost row, column 0 the westernmost column; the index of a cell is `row * columns + column`.
//! Local coordinates have their origin in the south-western corner of the lattice; only `terrain` and `output` know map
//! coordinates (a national grid's six or seven digits would eat the digits that the core needs).

use crate::math::Vec2;

/// A lattice of square cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    /// Map coordinates of the south-western corner (m).
    pub origin: Vec2,
    /// Number of cells from west to east.
    pub columns: usize,
    /// Number of cells from south to north.
    pub rows: usize,
    /// Edge of a cell, and distance of two bed particles (m).
    pub spacing: f64,
}

impl Lattice {
    /// Number of cells.
    pub fn len(&self) -> usize {
        self.columns * self.rows
    }

    /// Whether the lattice has no cell.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Area of a cell (m²).
    pub fn cell_area(&self) -> f64 {
        self.spacing * self.spacing
    }

    /// Index of a cell.
    #[inline]
    pub fn index(&self, column: usize, row: usize) -> usize {
        debug_assert!(column < self.columns && row < self.rows);
        row * self.columns + column
    }

    /// Column and row of a cell.
    #[inline]
    pub fn column_row(&self, index: usize) -> (usize, usize) {
        (index % self.columns, index / self.columns)
    }

    /// Centre of a cell in local coordinates (m).
    #[inline]
    pub fn centre(&self, index: usize) -> Vec2 {
        let (column, row) = self.column_row(index);
        Vec2::new((column as f64 + 0.5) * self.spacing, (row as f64 + 0.5) * self.spacing)
    }

    /// The cell that holds a place given in local coordinates, if it lies on the lattice.
    #[inline]
    pub fn cell_at(&self, local: Vec2) -> Option<usize> {
        let column = (local.x / self.spacing).floor();
        let row = (local.y / self.spacing).floor();
        let inside = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        inside.then(|| self.index(column as usize, row as usize))
    }

    /// Local coordinates to map coordinates (m).
    #[inline]
    pub fn to_map(&self, local: Vec2) -> Vec2 {
        local + self.origin
    }

    /// Map coordinates to local coordinates (m).
    #[inline]
    pub fn to_local(&self, map: Vec2) -> Vec2 {
        map - self.origin
    }

    /// Width and height (m).
    pub fn size(&self) -> Vec2 {
        Vec2::new(self.columns as f64 * self.spacing, self.rows as f64 * self.spacing)
    }
}

/// A run of neighbouring cells of one row: columns `from..to`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The row.
    pub row: u32,
    /// First column.
    pub from: u32,
    /// One past the last column.
    pub to: u32,
}

/// The water of one moment on the lattice, as the recorder of maps sees it, whatever motion the solver uses.
///
/// Cells outside all `spans` are dry now and were dry at the step before, but for films that rest where they were left.
#[derive(Clone, Copy, Debug)]
pub struct WaterOnLattice<'a> {
    /// Water depth (m), `[rows * columns]`.
    pub depth: &'a [f64],
    /// Discharge per metre of width to the east (m²/s), depth times velocity, `[rows * columns]`.
    pub discharge_x: &'a [f64],
    /// Discharge per metre of width to the north (m²/s), `[rows * columns]`.
    pub discharge_y: &'a [f64],
    /// Where water may be, in ascending order of rows and columns, without overlap.
    pub spans: &'a [Span],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centre_and_cell_agree() {
        let lattice = Lattice { origin: Vec2::new(1e6, 2e6), columns: 7, rows: 5, spacing: 2.5 };
        for index in 0..lattice.len() {
            assert_eq!(lattice.cell_at(lattice.centre(index)), Some(index));
        }
        assert_eq!(lattice.cell_at(Vec2::new(-0.1, 1.0)), None);
        assert_eq!(lattice.cell_at(Vec2::new(17.5, 1.0)), None);
    }
}
