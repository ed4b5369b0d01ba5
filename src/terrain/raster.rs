//! A georeferenced raster in memory, row 0 in the north, NaN where there is no data.

use crate::math::Vec2;

/// A north-up raster.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// Number of columns.
    pub columns: usize,
    /// Number of rows.
    pub rows: usize,
    /// Map coordinate of the western edge (m).
    pub west: f64,
    /// Map coordinate of the northern edge (m).
    pub north: f64,
    /// Width of a cell (m).
    pub cell_x: f64,
    /// Height of a cell (m), positive.
    pub cell_y: f64,
    /// Values `[rows, columns]`, row 0 in the north; NaN is no data.
    pub values: Vec<f64>,
}

impl Raster {
    /// The value of a cell.
    #[inline]
    pub fn value(&self, column: usize, row: usize) -> f64 {
        self.values[row * self.columns + column]
    }

    /// Map coordinates of the centre of a cell.
    #[inline]
    pub fn centre(&self, column: usize, row: usize) -> Vec2 {
        Vec2::new(self.west + (column as f64 + 0.5) * self.cell_x, self.north - (row as f64 + 0.5) * self.cell_y)
    }

    /// Map coordinate of the eastern edge (m).
    pub fn east(&self) -> f64 {
        self.west + self.columns as f64 * self.cell_x
    }

    /// Map coordinate of the southern edge (m).
    pub fn south(&self) -> f64 {
        self.north - self.rows as f64 * self.cell_y
    }
}
