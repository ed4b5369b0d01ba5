//! Water on a lattice, row by row.

use bytemuck::Zeroable;

use super::Lattice;

/// A run of neighbouring cells of one row: columns `from..to`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Span {
    /// The row.
    pub row: u32,
    /// First column.
    pub from: u32,
    /// One past the last column.
    pub to: u32,
}

/// The water of one cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Zeroable)]
pub struct WaterInCell {
    /// Water depth (m).
    pub depth: f64,
    /// Discharge per metre of width to the east (m²/s), depth times velocity.
    pub discharge_x: f64,
    /// Discharge per metre of width to the north (m²/s).
    pub discharge_y: f64,
}

impl WaterInCell {
    /// The water `share` of the way to a later moment.
    pub fn towards(self, later: WaterInCell, share: f64) -> WaterInCell {
        let mix = |a: f64, b: f64| a + (b - a) * share;
        WaterInCell {
            depth: mix(self.depth, later.depth),
            discharge_x: mix(self.discharge_x, later.discharge_x),
            discharge_y: mix(self.discharge_y, later.discharge_y),
        }
    }
}

/// The water of a row of cells, column 0 first; units as in [`WaterInCell`].
#[derive(Clone, Copy, Debug)]
pub struct WaterInRow<'a> {
    /// Depth of each cell.
    pub depth: &'a [f64],
    /// Discharge to the east of each cell.
    pub discharge_x: &'a [f64],
    /// Discharge to the north of each cell.
    pub discharge_y: &'a [f64],
}

impl WaterInRow<'_> {
    /// The water of a column.
    #[inline]
    pub fn at(&self, column: usize) -> WaterInCell {
        WaterInCell {
            depth: self.depth[column],
            discharge_x: self.discharge_x[column],
            discharge_y: self.discharge_y[column],
        }
    }
}

/// Whatever holds water row by row.
pub trait WaterRows: Sync {
    /// The water of a row.
    fn row(&self, row: usize) -> WaterInRow<'_>;

    /// The concentration of a tracer in each cell of a row; nothing where no tracer is carried.
    fn concentration(&self, _tracer: usize, _row: usize) -> &[f64] {
        &[]
    }
}

/// The water of one moment on the lattice, as the recorder of maps sees it, whatever motion the solver uses.
///
/// Cells outside all `spans` are dry now and were dry at the step before, but for films that rest where they were left.
#[derive(Clone, Copy)]
pub struct WaterOnLattice<'a> {
    /// The water, row by row.
    pub rows: &'a dyn WaterRows,
    /// The lattice.
    pub lattice: &'a Lattice,
    /// Where water may be, in ascending order of rows and columns, without overlap.
    pub spans: &'a [Span],
}

impl WaterOnLattice<'_> {
    /// The water of a cell.
    pub fn at(&self, index: usize) -> WaterInCell {
        let (column, row) = self.lattice.column_row(index);
        self.rows.row(row).at(column)
    }

    /// The spans of a row.
    pub fn spans_of_row(&self, row: usize) -> &[Span] {
        let first = self.spans.partition_point(|span| (span.row as usize) < row);
        let count = self.spans[first..].partition_point(|span| span.row as usize == row);
        &self.spans[first..][..count]
    }

    /// The water of all cells, row by row.
    pub fn cells(&self) -> impl Iterator<Item = WaterInCell> + '_ {
        let columns = self.lattice.columns;
        let cell = |row: &WaterInRow<'_>, column| {
            if column < row.depth.len() { row.at(column) } else { WaterInCell::default() }
        };
        let rows = (0..self.lattice.all_rows()).map(|row| self.rows.row(row));
        rows.flat_map(move |row| (0..columns).map(move |column| cell(&row, column)))
    }

    /// Depth of all cells (m), `[rows * columns]`.
    pub fn depths(&self) -> Vec<f64> {
        self.cells().map(|water| water.depth).collect()
    }
}

/// Water in plain arrays `[rows * columns]`; units as in [`WaterInCell`].
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct FlatWater {
    /// Number of columns.
    pub columns: usize,
    /// Depth.
    pub depth: Vec<f64>,
    /// Discharge to the east.
    pub discharge_x: Vec<f64>,
    /// Discharge to the north.
    pub discharge_y: Vec<f64>,
}

impl FlatWater {
    /// No water on a lattice.
    pub fn dry(lattice: &Lattice) -> Self {
        let zeros = || vec![0.0; lattice.len()];
        FlatWater { columns: lattice.columns, depth: zeros(), discharge_x: zeros(), discharge_y: zeros() }
    }
}

impl WaterRows for FlatWater {
    fn row(&self, row: usize) -> WaterInRow<'_> {
        let cells = row * self.columns..(row + 1) * self.columns;
        WaterInRow {
            depth: &self.depth[cells.clone()],
            discharge_x: &self.discharge_x[cells.clone()],
            discharge_y: &self.discharge_y[cells],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec2;

    #[test]
    fn the_spans_of_a_row_are_found() {
        let lattice = Lattice::new(Vec2::ZERO, 6, 4, 1.0);
        let spans = [Span { row: 1, from: 1, to: 3 }, Span { row: 1, from: 4, to: 5 }, Span { row: 3, from: 0, to: 6 }];
        let (dry, spans) = (FlatWater::dry(&lattice), &spans[..]);
        let water = WaterOnLattice { rows: &dry, lattice: &lattice, spans };
        let found: Vec<&[Span]> = (0..4).map(|row| water.spans_of_row(row)).collect();
        assert_eq!(found, [&spans[..0], &spans[..2], &spans[..0], &spans[2..]]);
    }
}
