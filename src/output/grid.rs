//! The grid of the output files, and how lattice values come onto it.
//!
//! The grid covers the lattice from its north-western corner; where the cell does not divide its size, the last column
//! and row reach over its edge. With the cell of the lattice itself (the default) every value is taken as it is.
//! Otherwise:
//!
//! - frames are conservative: depth and discharge are means weighted by overlapping area, so that the sum of depth times
//!   area is the volume of the water, and velocity is mean discharge over mean depth;
//! - maps are sampled: every map of a cell, bed elevation included, is that of the lattice cell at its centre, so that depth,
//!   level, times and class of one cell belong together.
//!
//! Outside the terrain every grid holds [`FILL`].

use std::collections::BTreeMap;
use std::sync::Arc;

use super::frames::Frame;
use super::maxima::{Maxima, ThresholdSeen};
use super::{Gauge, WET_DEPTH};
use crate::lattice::{Lattice, WaterInCell};
use crate::math::Vec2;

/// The one value that means "no value" in every float grid of every file.
pub const FILL: f32 = -9999.0;

/// The overlap of an output column or row with a lattice column or row.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Overlap {
    /// Lattice column or row.
    index: usize,
    /// Length of the overlap over the length of the output cell.
    share: f64,
}

/// A north-up grid of square cells.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputGrid {
    /// Map coordinate of the western edge (m).
    pub west: f64,
    /// Map coordinate of the northern edge (m).
    pub north: f64,
    /// Edge of a cell (m).
    pub cell: f64,
    /// Number of columns.
    pub columns: usize,
    /// Number of rows.
    pub rows: usize,
    lattice_columns: usize,
    column_overlaps: Vec<Vec<Overlap>>,
    row_overlaps: Vec<Vec<Overlap>>,
    centre_columns: Vec<Option<usize>>,
    centre_rows: Vec<Option<usize>>,
    /// Mean bed elevation of the terrain in each cell (m); NaN without terrain. The writers' copies of the grid share it.
    mean_bed: Arc<[f64]>,
}

/// The maps for one threshold on the output grid.
#[derive(Clone, Debug, PartialEq)]
pub struct ThresholdGrids {
    /// The threshold (m).
    pub threshold: f64,
    /// Time of arrival (s); [`FILL`] where the water never came.
    pub arrival: Vec<f32>,
    /// Time under water (s).
    pub duration: Vec<f32>,
    /// Time of the last fall below the threshold (s); [`FILL`] where there was none.
    pub recession: Vec<f32>,
}

/// The maps of a run on the output grid, `[rows * columns]`, row 0 in the north.
#[derive(Clone, Debug, PartialEq)]
pub struct GridMaps {
    /// Bed elevation (m).
    pub bed_elevation: Vec<f32>,
    /// Greatest depth (m).
    pub max_depth: Vec<f32>,
    /// Greatest water level (m); [`FILL`] where always dry.
    pub max_water_level: Vec<f32>,
    /// Greatest speed (m/s).
    pub max_speed: Vec<f32>,
    /// Greatest depth times speed of one moment (m²/s).
    pub max_depth_velocity: Vec<f32>,
    /// Time of the greatest depth (s); [`FILL`] where always dry.
    pub time_of_max_depth: Vec<f32>,
    /// Hazard class, 0 (dry) to 6; [`FILL`] outside the terrain.
    pub hazard_class: Vec<f32>,
    /// One entry for each threshold.
    pub thresholds: Vec<ThresholdGrids>,
}

impl OutputGrid {
    /// A grid of cells with edge `cell` (m, positive) over a lattice with the given bed (m, NaN without terrain).
    pub fn new(lattice: &Lattice, cell: f64, bed_elevation: &[f64]) -> Self {
        let spacing = lattice.spacing;
        let size = lattice.size();
        // A grid of 3 cells of 0.1 m over 0.3 m must not get a fourth by rounding.
        let cells_over = |length: f64| ((length / cell - 1e-6).ceil() as usize).max(usize::from(length > 0.0));
        let (columns, rows) = (cells_over(size.x), cells_over(size.y));
        let from_south = |row: usize| size.y - (row as f64 + 1.0) * cell;
        let mut grid = OutputGrid {
            west: lattice.origin.x,
            north: lattice.origin.y + size.y,
            cell,
            columns,
            rows,
            lattice_columns: lattice.columns,
            column_overlaps: (0..columns).map(|i| overlaps(i as f64 * cell, cell, spacing, lattice.columns)).collect(),
            row_overlaps: (0..rows).map(|i| overlaps(from_south(i), cell, spacing, lattice.rows)).collect(),
            centre_columns: (0..columns).map(|i| holder((i as f64 + 0.5) * cell, spacing, lattice.columns)).collect(),
            centre_rows: (0..rows).map(|i| holder(from_south(i) + 0.5 * cell, spacing, lattice.rows)).collect(),
            mean_bed: Arc::default(),
        };
        grid.mean_bed = grid.mean_of_terrain(bed_elevation);
        grid
    }

    /// Takes another bed (m, NaN without terrain) for the frames from now on.
    pub(super) fn set_bed(&mut self, bed_elevation: &[f64]) {
        self.mean_bed = self.mean_of_terrain(bed_elevation);
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.columns * self.rows
    }

    /// Whether the grid has no cell: that of a run without terrain.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Map coordinates of the centres of the columns, west to east (m).
    pub fn x(&self) -> Vec<f64> {
        (0..self.columns).map(|i| self.west + (i as f64 + 0.5) * self.cell).collect()
    }

    /// Map coordinates of the centres of the rows, north to south (m).
    pub fn y(&self) -> Vec<f64> {
        (0..self.rows).map(|i| self.north - (i as f64 + 0.5) * self.cell).collect()
    }

    /// Map coordinates of the corner between the columns `column - 1` and `column`, the rows `row - 1` and `row` (m).
    pub fn corner(&self, column: usize, row: usize) -> Vec2 {
        Vec2::new(self.west + column as f64 * self.cell, self.north - row as f64 * self.cell)
    }

    /// The index of the grid cell that holds a gauge, if it lies on the grid.
    pub fn cell_of(&self, gauge: &Gauge) -> Option<usize> {
        let column = ((gauge.position.x - self.west) / self.cell).floor();
        let row = ((self.north - gauge.position.y) / self.cell).floor();
        let inside = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        inside.then(|| row as usize * self.columns + column as usize)
    }

    /// Sum of depth times area of a frame (m³), from the values as they are written.
    pub fn volume(&self, depth: &[f32]) -> f64 {
        let wet = depth.iter().filter(|&&depth| depth > 0.0);
        wet.map(|&depth| f64::from(depth)).sum::<f64>() * self.cell * self.cell
    }

    /// A frame from the water at each column and row of the lattice.
    pub fn frame(&self, time: f64, water: impl Fn(usize, usize) -> WaterInCell) -> Frame {
        let mut frame = Frame {
            time,
            depth: vec![FILL; self.len()],
            water_level: vec![FILL; self.len()],
            velocity_x: vec![FILL; self.len()],
            velocity_y: vec![FILL; self.len()],
        };
        for cell in (0..self.len()).filter(|&cell| !self.mean_bed[cell].is_nan()) {
            let mean = self.mean_water(cell, &water);
            frame.depth[cell] = mean.depth as f32;
            (frame.velocity_x[cell], frame.velocity_y[cell]) = (0.0, 0.0);
            if mean.depth > WET_DEPTH {
                frame.water_level[cell] = (self.mean_bed[cell] + mean.depth) as f32;
                frame.velocity_x[cell] = (mean.discharge_x / mean.depth) as f32;
                frame.velocity_y[cell] = (mean.discharge_y / mean.depth) as f32;
            }
        }
        frame
    }

    /// The maps of the run up to `time` (s) on the grid, with the bed at its end (m, NaN without terrain), and the greatest level (m)
    /// of the cells whose bed changed.
    pub(super) fn maps(
        &self,
        maxima: &Maxima,
        time: f64,
        bed_elevation: &[f64],
        highest: &BTreeMap<usize, f64>,
    ) -> GridMaps {
        let on_terrain = |value: &dyn Fn(usize) -> f64| {
            self.sample(|index| if bed_elevation[index].is_nan() { f64::NAN } else { value(index) })
        };
        let where_wet = |value: &dyn Fn(usize) -> f64| {
            on_terrain(&|index| if maxima.seen(index).max_depth > WET_DEPTH { value(index) } else { f64::NAN })
        };
        let of_threshold = |which: usize| {
            let value = |value: fn(ThresholdSeen) -> f64| {
                on_terrain(&|index| value(maxima.seen_of_threshold(index, which, time)))
            };
            ThresholdGrids {
                threshold: maxima.thresholds()[which],
                arrival: value(|seen| seen.arrival),
                duration: value(|seen| seen.duration),
                recession: value(|seen| seen.recession),
            }
        };
        GridMaps {
            bed_elevation: self.sample(|index| bed_elevation[index]),
            max_depth: on_terrain(&|index| maxima.seen(index).max_depth),
            max_water_level: where_wet(&|index| {
                highest.get(&index).copied().unwrap_or(bed_elevation[index] + maxima.seen(index).max_depth)
            }),
            max_speed: on_terrain(&|index| maxima.seen(index).max_speed),
            max_depth_velocity: on_terrain(&|index| maxima.seen(index).max_depth_velocity),
            time_of_max_depth: where_wet(&|index| maxima.seen(index).time_of_max_depth),
            hazard_class: on_terrain(&|index| f64::from(maxima.seen(index).hazard_class)),
            thresholds: (0..maxima.thresholds().len()).map(of_threshold).collect(),
        }
    }

    /// Mean water of an output cell; the part of the cell without terrain counts as dry.
    fn mean_water(&self, cell: usize, water: impl Fn(usize, usize) -> WaterInCell) -> WaterInCell {
        let (column, row) = (cell % self.columns, cell / self.columns);
        let mut sum = WaterInCell::default();
        for down in &self.row_overlaps[row] {
            for across in &self.column_overlaps[column] {
                let (share, water) = (down.share * across.share, water(across.index, down.index));
                sum.depth += share * water.depth;
                sum.discharge_x += share * water.discharge_x;
                sum.discharge_y += share * water.discharge_y;
            }
        }
        sum
    }

    /// Mean of a value over an output cell.
    fn mean(&self, cell: usize, values: &[f64]) -> f64 {
        let (column, row) = (cell % self.columns, cell / self.columns);
        let mut sum = 0.0;
        for down in &self.row_overlaps[row] {
            for across in &self.column_overlaps[column] {
                sum += down.share * across.share * values[down.index * self.lattice_columns + across.index];
            }
        }
        sum
    }

    fn mean_of_terrain(&self, bed_elevation: &[f64]) -> Arc<[f64]> {
        let terrain: Vec<f64> = bed_elevation.iter().map(|z| if z.is_nan() { 0.0 } else { 1.0 }).collect();
        let elevation: Vec<f64> = bed_elevation.iter().map(|z| if z.is_nan() { 0.0 } else { *z }).collect();
        (0..self.len()).map(|cell| self.mean(cell, &elevation) / self.mean(cell, &terrain)).collect()
    }

    /// The values at the centres of the cells; NaN becomes [`FILL`].
    fn sample(&self, value: impl Fn(usize) -> f64) -> Vec<f32> {
        let mut values = Vec::with_capacity(self.len());
        for row in &self.centre_rows {
            for column in &self.centre_columns {
                let index = row.zip(*column).map(|(row, column)| row * self.lattice_columns + column);
                let value = index.map_or(f64::NAN, &value);
                values.push(if value.is_nan() { FILL } else { value as f32 });
            }
        }
        values
    }
}

/// Lattice cells along one axis that overlap the interval from `start` of length `cell`.
fn overlaps(start: f64, cell: f64, spacing: f64, count: usize) -> Vec<Overlap> {
    let first = (start / spacing + 1e-9).floor().max(0.0) as usize;
    let last = (((start + cell) / spacing - 1e-9).ceil().max(0.0) as usize).min(count);
    let overlap = |index: usize| {
        let from = start.max(index as f64 * spacing);
        let to = (start + cell).min((index + 1) as f64 * spacing);
        Overlap { index, share: if (cell - spacing).abs() < 1e-9 * spacing { 1.0 } else { (to - from) / cell } }
    };
    (first..last).map(overlap).collect()
}

/// The lattice cell along one axis that holds a place.
fn holder(place: f64, spacing: f64, count: usize) -> Option<usize> {
    let index = (place / spacing + 1e-9).floor();
    (index >= 0.0 && index < count as f64).then_some(index as usize)
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values that must be taken over unchanged are compared exactly")]
mod tests {
    use super::*;

    fn lattice() -> Lattice {
        Lattice { origin: Vec2::new(500.0, 900.0), columns: 7, rows: 5, spacing: 2.0 }
    }

    #[test]
    fn lattice_cells_are_taken_as_they_are_and_turned_north_up() {
        let lattice = lattice();
        let bed: Vec<f64> = (0..lattice.len()).map(|index| index as f64).collect();
        let grid = OutputGrid::new(&lattice, 2.0, &bed);
        assert_eq!((grid.columns, grid.rows), (7, 5));
        assert_eq!((grid.west, grid.north), (500.0, 910.0));
        let depth: Vec<f64> = (0..lattice.len()).map(|index| 1.0 + index as f64).collect();
        let frame = grid.frame(3.0, |column, row| {
            let depth = depth[lattice.index(column, row)];
            WaterInCell { depth, discharge_x: depth, discharge_y: 0.0 }
        });
        assert_eq!(frame.depth[0], 1.0 + 28.0, "the first value is the north-western cell");
        assert_eq!(frame.depth[4 * 7], 1.0, "the first value of the last row is the south-western cell");
        assert_eq!(frame.water_level[4 * 7 + 1], 1.0 + 2.0);
        assert_eq!(frame.velocity_x[9], 1.0);
    }

    #[test]
    fn volume_is_kept_for_any_cell() {
        let lattice = lattice();
        let mut bed = vec![10.0; lattice.len()];
        bed[11] = f64::NAN;
        let depth: Vec<f64> =
            (0..lattice.len()).map(|index| if index == 11 { 0.0 } else { 0.1 * index as f64 }).collect();
        let volume = depth.iter().sum::<f64>() * lattice.cell_area();
        for cell in [0.5, 1.0, 2.0, 3.0, 4.0, 7.3, 20.0] {
            let grid = OutputGrid::new(&lattice, cell, &bed);
            let frame = grid.frame(0.0, |column, row| {
                let depth = depth[lattice.index(column, row)];
                WaterInCell { depth, discharge_x: depth, discharge_y: depth }
            });
            let error = grid.volume(&frame.depth) / volume - 1.0;
            assert!(error.abs() < 1e-6, "cell {cell}: {error:e}, more than the rounding of single precision");
        }
    }

    #[test]
    fn ground_without_terrain_is_filled() {
        let lattice = lattice();
        let mut bed = vec![1.0; lattice.len()];
        bed[0] = f64::NAN;
        let grid = OutputGrid::new(&lattice, 2.0, &bed);
        let frame = grid.frame(0.0, |_, _| WaterInCell::default());
        assert_eq!(frame.depth[4 * 7], FILL);
        assert_eq!(frame.depth[4 * 7 + 1], 0.0);
        assert_eq!(frame.water_level[4 * 7 + 1], FILL, "dry ground has no water level");
    }
}
