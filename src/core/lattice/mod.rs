//! The regular lattice of riverbed particles, and what lies on it.
//!
//! Row 0 is the southernmost row, column 0 the westernmost column; the index of a cell is `row * columns + column`. A nested lattice has
//! coarser levels behind its own rows ([`Nest`]): rows of cells of twice, four times the edge and so on, by the same rule of the index.
//! Local coordinates have their origin in the south-western corner of the lattice; only `terrain` and `output` know map
//! coordinates (a national grid's six or seven digits would eat the digits that the core needs).

mod conforming;
mod nest;
mod water;

use std::ops::Range;
use std::sync::Arc;

use crate::math::Vec2;
pub use conforming::{Cell, Conforming, Face, Side, depth_within};
pub use nest::{Level, Nest};
pub use water::{FlatWater, Span, WaterInCell, WaterInRow, WaterOnLattice, WaterRows};

/// How far (in cells) beyond the outermost edge a place still lies on it: the round-off of map coordinates.
const EDGE_TOLERANCE: f64 = 1e-6;

/// The steps (column, row) to the four neighbours of a cell: east, west, north, south.
pub const NEIGHBOURS: [(isize, isize); 4] = [(1, 0), (-1, 0), (0, 1), (0, -1)];

/// A lattice of square cells; where it is nested, the finest of its levels.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Lattice {
    /// Map coordinates of the south-western corner (m).
    pub origin: Vec2,
    /// Number of cells from west to east.
    pub columns: usize,
    /// Number of cells from south to north.
    pub rows: usize,
    /// Edge of a cell, and distance of two bed particles (m).
    pub spacing: f64,
    /// Its coarser levels, where it has any.
    nest: Option<Arc<Nest>>,
}

impl Lattice {
    /// One lattice of `columns` by `rows` cells of an edge `spacing` (m), from its south-western corner `origin` (map).
    pub fn new(origin: Vec2, columns: usize, rows: usize, spacing: f64) -> Self {
        Lattice { origin, columns, rows, spacing, nest: None }
    }

    /// The same with coarser levels.
    #[must_use]
    pub fn nested(self, nest: Nest) -> Self {
        Lattice { nest: Some(Arc::new(nest)), ..self }
    }

    /// Its coarser levels, where it has any.
    pub fn nest(&self) -> Option<&Nest> {
        self.nest.as_deref()
    }

    /// The cells that follow lines, where it has any.
    #[inline]
    pub fn conforming(&self) -> Option<&Conforming> {
        self.nest().and_then(Nest::conforming)
    }

    /// The cell that follows lines at an index, by its number.
    #[inline]
    pub fn conforming_at(&self, index: usize) -> Option<usize> {
        self.conforming()?.number_at(index)
    }

    /// Number of levels; 1 where it is not nested.
    pub fn level_count(&self) -> usize {
        self.nest().map_or(1, |nest| nest.levels().len())
    }

    /// A level; 0 is the finest.
    pub fn level(&self, level: usize) -> Level {
        let own = Level { first_row: 0, columns: self.columns, rows: self.rows, spacing: self.spacing };
        self.nest().map_or(own, |nest| nest.levels()[level])
    }

    /// All levels, the finest first.
    pub fn levels(&self) -> impl Iterator<Item = Level> + '_ {
        (0..self.level_count()).map(|level| self.level(level))
    }

    /// The places of the cells of a level, and those behind them in its rows.
    pub fn places_of(&self, level: Level) -> Range<usize> {
        level.first_row * self.columns..(level.first_row + level.rows) * self.columns
    }

    /// The cells that stand for their places on a level, with those that follow lines on the finest.
    pub fn leaves_of(&self, level: Level) -> impl Iterator<Item = usize> + '_ {
        let conforming = self.conforming().filter(|_| level.first_row == 0);
        let of_lines = conforming.into_iter().flat_map(Conforming::places);
        self.places_of(level).filter(|&place| self.is_leaf(place)).chain(of_lines)
    }

    /// The index of a cell of a level, given by its index on a lattice of that level alone.
    pub fn in_stack(&self, level: Level, cell: usize) -> usize {
        self.index(cell % level.columns, level.first_row + cell / level.columns)
    }

    /// The level of a row.
    #[inline]
    pub fn level_of_row(&self, row: usize) -> Level {
        self.level(self.nest().map_or(0, |nest| nest.number_of_row(row)))
    }

    /// Number of rows of all levels, with those between them that hold no cell.
    pub fn all_rows(&self) -> usize {
        self.nest().map_or(self.rows, Nest::all_rows)
    }

    /// Number of places of cells: `columns` for each row of all levels.
    pub fn len(&self) -> usize {
        self.columns * self.all_rows()
    }

    /// Whether the lattice has no cell.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Area of a cell of the finest level (m²).
    pub fn cell_area(&self) -> f64 {
        self.spacing * self.spacing
    }

    /// Edge of a cell of the level to which an index belongs (m).
    pub fn spacing_of(&self, index: usize) -> f64 {
        self.level_of_row(index / self.columns).spacing
    }

    /// Area of such a cell (m²).
    pub fn area_of(&self, index: usize) -> f64 {
        if let (Some(conforming), Some(number)) = (self.conforming(), self.conforming_at(index)) {
            return conforming.cells()[number].area;
        }
        let spacing = self.spacing_of(index);
        spacing * spacing
    }

    /// Index of a cell.
    #[inline]
    pub fn index(&self, column: usize, row: usize) -> usize {
        debug_assert!(column < self.columns && row < self.all_rows());
        row * self.columns + column
    }

    /// Column and row of a cell.
    #[inline]
    pub fn column_row(&self, index: usize) -> (usize, usize) {
        (index % self.columns, index / self.columns)
    }

    /// The cell at a step (column, row) from a cell, if the level of the cell has it.
    #[inline]
    pub fn neighbour(&self, index: usize, (across, up): (isize, isize)) -> Option<usize> {
        let (column, row) = self.column_row(index);
        let level = self.level_of_row(row);
        let (column, row) = (column.checked_add_signed(across)?, row.checked_add_signed(up)?);
        (column < level.columns && level.holds_row(row)).then(|| self.index(column, row))
    }

    /// Centre of a cell in local coordinates (m).
    #[inline]
    pub fn centre(&self, index: usize) -> Vec2 {
        if let (Some(conforming), Some(number)) = (self.conforming(), self.conforming_at(index)) {
            return conforming.cells()[number].centre;
        }
        let (column, row) = self.column_row(index);
        let Level { first_row, spacing, .. } = self.level_of_row(row);
        Vec2::new((column as f64 + 0.5) * spacing, ((row - first_row) as f64 + 0.5) * spacing)
    }

    /// The cell that holds a place given in local coordinates, if it lies on the lattice.
    #[inline]
    pub fn cell_at(&self, local: Vec2) -> Option<usize> {
        let (column, row) = (local.x / self.spacing, local.y / self.spacing);
        let inside = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        // A cast rounds down here.
        inside.then(|| self.holding((column as usize, row as usize), local))
    }

    /// The cell that holds a place (local coordinates, m) in a square of the finest level (column, row).
    #[inline]
    fn holding(&self, (column, row): (usize, usize), local: Vec2) -> usize {
        let leaf = self.leaf(column, row);
        let Some(conforming) = self.conforming() else { return leaf };
        let square = self.index(column, row);
        // The whole square may be one of the lattice.
        if leaf == square && conforming.instead_of(square).is_none() {
            return leaf;
        }
        conforming.cell_at(square, local).map_or(leaf, |number| conforming.place(number))
    }

    /// The cell, of whichever level, that stands for a cell of the finest level.
    #[inline]
    pub fn leaf(&self, column: usize, row: usize) -> usize {
        let Some(nest) = self.nest() else { return self.index(column, row) };
        let level = nest.level_of(column, row);
        if let (0, Some(conforming)) = (level, nest.conforming())
            && let Some(Some(number)) = conforming.instead_of(self.index(column, row))
        {
            return conforming.place(number);
        }
        self.index(column >> level, nest.levels()[level].first_row + (row >> level))
    }

    /// The same by the index of the cell of the finest level.
    #[inline]
    pub fn leaf_of(&self, finest: usize) -> usize {
        self.leaf(finest % self.columns, finest / self.columns)
    }

    /// Whether an index is that of a cell which stands for its place: all are, but where levels are nested.
    pub fn is_leaf(&self, index: usize) -> bool {
        let Some(nest) = self.nest() else { return true };
        let (column, row) = self.column_row(index);
        let number = nest.number_of_row(row);
        let level = nest.levels()[number];
        if let (0, Some(conforming)) = (number, nest.conforming())
            && (row >= level.rows || conforming.instead_of(index).is_some())
        {
            return conforming.number_at(index).is_some();
        }
        column < level.columns
            && level.holds_row(row)
            && nest.level_of(column << number, (row - level.first_row) << number) == number
    }

    /// The cell of a place given in local coordinates that may lie on the outermost edge of the lattice: there it belongs to the last
    /// cell, as places on the edge of a raster do.
    pub fn cell_of(&self, local: Vec2) -> Option<usize> {
        let index = |place: f64, count: usize| {
            let place = place / self.spacing;
            let inside = count > 0 && (-EDGE_TOLERANCE..=count as f64 + EDGE_TOLERANCE).contains(&place);
            // A cast rounds towards 0.
            inside.then(|| (place as usize).min(count - 1))
        };
        Some(self.holding((index(local.x, self.columns)?, index(local.y, self.rows)?), local))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centre_and_cell_agree() {
        let lattice = Lattice::new(Vec2::new(1e6, 2e6), 7, 5, 2.5);
        for index in 0..lattice.len() {
            assert_eq!(lattice.cell_at(lattice.centre(index)), Some(index));
        }
        assert_eq!(lattice.cell_at(Vec2::new(-0.1, 1.0)), None);
        assert_eq!(lattice.cell_at(Vec2::new(17.5, 1.0)), None);
    }

    #[test]
    fn a_place_on_the_outermost_edge_belongs_to_the_last_cell() {
        let lattice = Lattice::new(Vec2::new(1e6, 2e6), 7, 5, 2.5);
        for (x, y, cell) in [(17.5, 1.0, 6), (1.0, 12.5, 28), (17.5, 12.5, 34), (0.0, 0.0, 0), (17.5 + 1e-9, 3.0, 13)] {
            assert_eq!(lattice.cell_of(Vec2::new(x, y)), Some(cell), "{x}, {y}");
        }
        for (x, y) in [(17.51, 1.0), (-0.01, 1.0), (1.0, 12.51), (f64::NAN, 1.0)] {
            assert_eq!(lattice.cell_of(Vec2::new(x, y)), None, "{x}, {y}");
        }
        for index in 0..lattice.len() {
            assert_eq!(lattice.cell_of(lattice.centre(index)), Some(index));
        }
    }
}
