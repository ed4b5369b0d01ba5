//! The cells of rasters themselves, not what lies between them: for what hangs on how they join.

use std::ops::Range;

use super::{Layer, Overlay, SPACING_ROUNDING, Terrain};
use crate::math::Vec2;

/// A centre nearer to the edge of a rectangle than this share of a cell lies on it: the round-off of map coordinates.
const ON_EDGE: f64 = 1e-6;

/// The grid of the cells of a raster, which goes on beyond it; column 0 in the west, row 0 in the north.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelGrid {
    west: f64,
    north: f64,
    cell: Vec2,
    layer: usize,
}

/// A rectangle of cells of a [`PixelGrid`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PixelBlock {
    /// Columns, from west to east.
    pub columns: Range<i64>,
    /// Rows, from north to south.
    pub rows: Range<i64>,
}

impl PixelGrid {
    /// The cells whose centres lie in a rectangle or on its edge (map coordinates).
    pub fn block(&self, low: Vec2, high: Vec2) -> PixelBlock {
        let range = |from: f64, to: f64, cell: f64| {
            let first = (from / cell - 0.5 - ON_EDGE).ceil() as i64;
            first..((to / cell - 0.5 + ON_EDGE).floor() as i64 + 1).max(first)
        };
        PixelBlock {
            columns: range(low.x - self.west, high.x - self.west, self.cell.x),
            rows: range(self.north - high.y, self.north - low.y, self.cell.y),
        }
    }

    /// Map coordinates of the centre of a cell.
    pub fn centre(&self, column: i64, row: i64) -> Vec2 {
        Vec2::new(self.west + (column as f64 + 0.5) * self.cell.x, self.north - (row as f64 + 0.5) * self.cell.y)
    }

    /// Column and row of the cell that holds a place (map coordinates).
    pub fn at(&self, map: Vec2) -> (i64, i64) {
        let Vec2 { x, y } = self.cell;
        (((map.x - self.west) / x).floor() as i64, ((self.north - map.y) / y).floor() as i64)
    }

    /// Width and height of a cell (m).
    pub fn cell(&self) -> Vec2 {
        self.cell
    }
}

impl Terrain {
    /// The grid of the finest raster that overlaps a rectangle (map coordinates), if its cells are smaller than `spacing` (m).
    pub fn pixel_grid(&self, low: Vec2, high: Vec2, spacing: f64) -> Option<PixelGrid> {
        let area = |grid: &PixelGrid| grid.cell.x * grid.cell.y;
        // Of equal ones the topmost.
        self.grids(low, high, spacing).reduce(|finest, grid| if area(&grid) <= area(&finest) { grid } else { finest })
    }

    /// The grids of all rasters that overlap a rectangle (map coordinates), with cells smaller than `spacing` (m): one for each size of cells.
    pub fn pixel_grids(&self, low: Vec2, high: Vec2, spacing: f64) -> Vec<PixelGrid> {
        let mut found: Vec<PixelGrid> = Vec::new();
        for grid in self.grids(low, high, spacing) {
            match found.iter_mut().find(|other| is_same_size(other.cell, grid.cell)) {
                Some(other) => *other = grid,
                None => found.push(grid),
            }
        }
        found
    }

    fn grids(&self, low: Vec2, high: Vec2, spacing: f64) -> impl Iterator<Item = PixelGrid> + '_ {
        self.layers.iter().enumerate().filter_map(move |(index, layer)| {
            let Layer::Raster(raster) = layer else { return None };
            let (least, greatest) = (raster.cell_x.min(raster.cell_y), raster.cell_x.max(raster.cell_y));
            let is_finer = least < spacing * (1.0 - SPACING_ROUNDING) && greatest <= spacing * (1.0 + SPACING_ROUNDING);
            let overlaps =
                raster.west < high.x && raster.east() > low.x && raster.south() < high.y && raster.north > low.y;
            (is_finer && overlaps).then(|| PixelGrid {
                west: raster.west,
                north: raster.north,
                cell: Vec2::new(raster.cell_x, raster.cell_y),
                layer: index,
            })
        })
    }

    /// Elevation (m) of the terrain at a cell of a grid, NaN where there is none. A raster counts with the value of its cell that
    /// holds the centre, as an upright block: a ridge of cells that meet at corners has no gap at them.
    pub fn pixel(&self, grid: &PixelGrid, column: i64, row: i64) -> f64 {
        self.layer_of_pixel(grid, column, row).map_or(f64::NAN, |(_, elevation)| elevation)
    }

    /// The same; not a number where what counts is no raster with cells of the same size.
    pub fn pixel_of_size(&self, grid: &PixelGrid, column: i64, row: i64) -> f64 {
        let is_of_size = |layer: usize| match &self.layers[layer] {
            Layer::Raster(raster) => is_same_size(Vec2::new(raster.cell_x, raster.cell_y), grid.cell),
            _ => false,
        };
        let counting = self.layer_of_pixel(grid, column, row).filter(|&(layer, _)| is_of_size(layer));
        counting.map_or(f64::NAN, |(_, elevation)| elevation)
    }

    /// Index of the layer that counts at a cell of a grid, and the elevation (m) of [`pixel`](Self::pixel).
    pub fn layer_of_pixel(&self, grid: &PixelGrid, column: i64, row: i64) -> Option<(usize, f64)> {
        if grid.layer + 1 == self.layers.len()
            && self.overlays[grid.layer] == Overlay::Replace
            && let Layer::Raster(raster) = &self.layers[grid.layer]
            && let (Ok(column), Ok(row)) = (usize::try_from(column), usize::try_from(row))
            && column < raster.columns
            && row < raster.rows
        {
            let value = raster.value(column, row);
            if !value.is_nan() {
                return Some((grid.layer, value));
            }
        }
        let place = grid.centre(column, row);
        let read = |layer: &Layer| match layer {
            Layer::Raster(raster) => {
                let (column, row) = raster.cell_at(place)?;
                Some(raster.value(column, row)).filter(|value| !value.is_nan())
            }
            Layer::Survey(survey) => survey.elevation(place),
        };
        self.top_of_first(self.layers.len(), &read)
    }
}

/// Whether cells are of one size but for the rounding of spacings.
fn is_same_size(a: Vec2, b: Vec2) -> bool {
    let is_same = |a: f64, b: f64| (a - b).abs() <= SPACING_ROUNDING * b;
    is_same(a.x, b.x) && is_same(a.y, b.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terrain::Raster;

    fn raster(west: f64, north: f64, cell: f64, columns: usize, rows: usize, value: f64) -> Layer {
        Layer::Raster(Raster {
            columns,
            rows,
            west,
            north,
            cell_x: cell,
            cell_y: cell,
            values: vec![value; columns * rows],
        })
    }

    #[test]
    fn the_finest_raster_gives_the_grid_and_each_raster_its_own_cells() {
        let layers = vec![raster(0.0, 100.0, 20.0, 5, 5, 1.0), raster(21.0, 80.0, 5.0, 8, 8, 2.0)];
        let terrain = Terrain::new(layers).unwrap();
        let rectangle = |x: f64, y: f64| (Vec2::new(x, y), Vec2::new(x + 40.0, y + 40.0));
        let grid_at = |x: f64, y: f64, spacing: f64| {
            let (low, high) = rectangle(x, y);
            terrain.pixel_grid(low, high, spacing)
        };
        let fine = grid_at(40.0, 40.0, 40.0).unwrap();
        assert_eq!(fine.cell(), Vec2::new(5.0, 5.0));
        assert_eq!(grid_at(70.0, 0.0, 40.0).unwrap().cell(), Vec2::new(20.0, 20.0));
        assert_eq!(grid_at(70.0, 0.0, 20.0), None);
        assert_eq!(grid_at(40.0, 40.0, 5.0), None);
        let sizes = |spacing: f64| -> Vec<f64> {
            let (low, high) = rectangle(40.0, 40.0);
            terrain.pixel_grids(low, high, spacing).iter().map(|grid| grid.cell().x).collect()
        };
        assert_eq!((sizes(40.0), sizes(20.0), sizes(5.0)), (vec![20.0, 5.0], vec![5.0], vec![]));
        // Beyond the fine raster its grid goes on over the coarse one.
        let (column, row) = fine.at(Vec2::new(2.0, 3.0));
        assert_eq!((terrain.pixel(&fine, column, row), terrain.pixel(&fine, 0, 0)), (1.0, 2.0));
        assert!(terrain.pixel_of_size(&fine, column, row).is_nan() && terrain.pixel_of_size(&fine, 0, 0) > 1.0);
        assert!(terrain.pixel(&fine, -100, 0).is_nan());
    }

    #[test]
    fn a_block_holds_the_centres_on_its_edge() {
        let terrain = Terrain::new(vec![raster(1000.0, 2000.0, 2.0, 50, 50, 0.0)]).unwrap();
        let low = Vec2::new(1005.0, 1990.0);
        let grid = terrain.pixel_grid(low, low + Vec2::new(5.0, 5.0), 5.0).unwrap();
        let PixelBlock { columns, rows } = grid.block(low, low + Vec2::new(4.0, 6.0));
        assert_eq!((columns, rows), (2..5, 2..5));
        assert_eq!(grid.centre(2, 2), Vec2::new(1005.0, 1995.0));
    }
}
