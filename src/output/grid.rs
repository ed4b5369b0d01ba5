//! The grid of the output files, and how lattice values come onto it.
//!
//! The grid covers the lattice from its north-western corner; where the cell does not divide its size, the last column
//! and row reach over its edge. With the cell of the lattice itself (the default) every value is taken as it is.
//! Otherwise:
//!
//! - frames are conservative: depth and discharge are means weighted by overlapping area, so that the sum of depth times
//!   area is the volume of the water; velocity is mean discharge over mean depth, and the level is the mean of that of the water;
//! - maps hold what counts most of the lattice cells that overlap a cell: the greatest depth, level, speed, class and duration,
//!   the first arrival, the last fall; the time of the greatest depth is that of the deepest of them, the bed their mean. No frame
//!   is deeper than the greatest depth, and nothing that was flooded is missing.
//!
//! Outside the terrain every grid holds [`FILL`].

mod maps;
mod overlap;
mod tracers;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::frames::Frame;
use super::ground_source::{GroundSource, SetBy, SourceGrid};
use super::maxima::Maxima;
use super::{Gauge, WET_DEPTH};
use crate::lattice::{Lattice, WaterInCell};
use crate::math::Vec2;
pub use maps::{GridMaps, ThresholdGrids};
use overlap::{Overlap, overlaps};

/// The one value that means "no value" in every float grid of every file.
pub const FILL: f32 = -9999.0;

/// A north-up grid of square cells.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
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
    /// The lattice, where it has levels: cells of any of them stand for its finest ones.
    nested: Option<Lattice>,
    column_overlaps: Vec<Vec<Overlap>>,
    row_overlaps: Vec<Vec<Overlap>>,
    /// Whether a cell holds any terrain. The writers' copies of the grid share it.
    has_terrain: Arc<[bool]>,
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
            nested: lattice.nest().map(|_| lattice.clone()),
            column_overlaps: (0..columns).map(|i| overlaps(i as f64 * cell, cell, spacing, lattice.columns)).collect(),
            row_overlaps: (0..rows).map(|i| overlaps(from_south(i), cell, spacing, lattice.rows)).collect(),
            has_terrain: Arc::default(),
        };
        let has_terrain = |down: &[Overlap], across: &[Overlap]| {
            grid.parts(down, across).any(|(_, index)| !bed_elevation[index].is_nan())
        };
        grid.has_terrain = grid.of_cells(has_terrain).into();
        grid
    }

    /// The grid of the pixels of a raster, on which nothing is averaged: corner in the north-west, edge of a cell (m), columns and rows,
    /// and whether each cell holds any terrain.
    pub(super) fn of_pixels(
        (west, north): (f64, f64),
        cell: f64,
        (columns, rows): (usize, usize),
        has_terrain: Arc<[bool]>,
    ) -> Self {
        let (column_overlaps, row_overlaps) = (Vec::new(), Vec::new());
        OutputGrid {
            west,
            north,
            cell,
            columns,
            rows,
            lattice_columns: 0,
            nested: None,
            column_overlaps,
            row_overlaps,
            has_terrain,
        }
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

    /// The cell of whichever level that stands for a cell of the finest one.
    fn leaf(&self, index: usize) -> usize {
        self.nested.as_ref().map_or(index, |lattice| lattice.leaf_of(index))
    }

    /// The cells that stand for the lattice in a cell of a row, each with its share of the area.
    fn parts<'a>(&'a self, down: &'a [Overlap], across: &'a [Overlap]) -> impl Iterator<Item = (f64, usize)> + 'a {
        self.finest_parts(down, across).map(|(share, index)| (share, self.leaf(index)))
    }

    /// The cells of the finest lattice that overlap a cell of a row, each with its share of the area.
    fn finest_parts<'a>(
        &'a self,
        down: &'a [Overlap],
        across: &'a [Overlap],
    ) -> impl Iterator<Item = (f64, usize)> + 'a {
        let across = move |down: &Overlap| {
            let (share, first) = (down.share, down.index * self.lattice_columns);
            across.iter().map(move |across| (share * across.share, first + across.index))
        };
        down.iter().flat_map(across)
    }

    /// Whether each cell is one of the lattice.
    fn is_lattice(&self) -> bool {
        let is_one = |overlaps: &Vec<Overlap>| overlaps.len() == 1 && (overlaps[0].share - 1.0).abs() <= 0.0;
        self.columns == self.lattice_columns && self.column_overlaps.iter().chain(&self.row_overlaps).all(is_one)
    }

    /// The bed (m) of a row of the finest lattice.
    fn bed_of_row<'a>(&self, bed: &'a [f64], row: usize) -> Cow<'a, [f64]> {
        let first = row * self.lattice_columns;
        match &self.nested {
            None => Cow::Borrowed(&bed[first..][..self.lattice_columns]),
            Some(lattice) => (0..lattice.columns).map(|column| bed[lattice.leaf(column, row)]).collect(),
        }
    }

    /// The value of each cell, from the rows and columns of the lattice that overlap it.
    fn of_cells<T>(&self, value: impl Fn(&[Overlap], &[Overlap]) -> T) -> Vec<T> {
        let mut values = Vec::with_capacity(self.len());
        for down in &self.row_overlaps {
            values.extend(self.column_overlaps.iter().map(|across| value(down, across)));
        }
        values
    }

    /// Visits the cells with terrain, row by row: their index and the mean of the water in them. `water` fills in that of a row of the
    /// lattice.
    fn for_each_mean(
        &self,
        bed: &[f64],
        water: impl Fn(usize, &mut [WaterInCell]),
        mut visit: impl FnMut(usize, &Mean),
    ) {
        let mut rows = Vec::new();
        let is_lattice = self.is_lattice();
        for (row, down) in self.row_overlaps.iter().enumerate() {
            rows.resize_with(down.len(), || vec![WaterInCell::default(); self.lattice_columns]);
            for (overlap, cells) in down.iter().zip(&mut rows) {
                water(overlap.index, cells);
            }
            let first = row * self.columns;
            let has_terrain = &self.has_terrain[first..][..self.columns];
            if is_lattice {
                let bed = self.bed_of_row(bed, down[0].index);
                let cells = rows[0].iter().zip(&*bed).zip(has_terrain).enumerate();
                for (column, ((&water, &bed), _)) in cells.filter(|(_, (_, has_terrain))| **has_terrain) {
                    let mut mean = Mean::default();
                    mean.add(1.0, water, bed);
                    visit(first + column, &mean);
                }
                continue;
            }
            let beds: Vec<Cow<'_, [f64]>> = down.iter().map(|overlap| self.bed_of_row(bed, overlap.index)).collect();
            for (column, across) in self.column_overlaps.iter().enumerate().filter(|(column, _)| has_terrain[*column]) {
                // The part of the cell without terrain counts as dry.
                let mut mean = Mean::default();
                for ((overlap, cells), bed) in down.iter().zip(&rows).zip(&beds) {
                    for across in across {
                        mean.add(overlap.share * across.share, cells[across.index], bed[across.index]);
                    }
                }
                visit(first + column, &mean);
            }
        }
    }

    /// A frame from the bed (m, NaN without terrain) and the water of the lattice, of which `water` fills in a row.
    pub fn frame(&self, time: f64, bed: &[f64], water: impl Fn(usize, &mut [WaterInCell])) -> Frame {
        let filled = || vec![FILL; self.len()];
        let mut frame = Frame {
            time,
            depth: filled(),
            water_level: filled(),
            velocity_x: filled(),
            velocity_y: filled(),
            concentrations: Vec::new(),
        };
        self.for_each_mean(bed, water, |cell, Mean { water, level, wet }| {
            frame.depth[cell] = water.depth as f32;
            (frame.velocity_x[cell], frame.velocity_y[cell]) = (0.0, 0.0);
            if water.depth > WET_DEPTH {
                frame.water_level[cell] = (level / wet) as f32;
                frame.velocity_x[cell] = (water.discharge_x / water.depth) as f32;
                frame.velocity_y[cell] = (water.discharge_y / water.depth) as f32;
            }
        });
        frame
    }

    /// The volume (m³) of the depths of a frame alone, to the same bits; see [`frame`](Self::frame).
    pub fn volume_of(&self, bed: &[f64], water: impl Fn(usize, &mut [WaterInCell])) -> f64 {
        let mut depth = vec![FILL; self.len()];
        self.for_each_mean(bed, water, |cell, mean| depth[cell] = mean.water.depth as f32);
        self.volume(&depth)
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
        let seen = |index: usize| maxima.seen(index);
        let level = |index: usize| greatest_level(maxima, bed_elevation, highest, index);
        let of_threshold = |which: usize| {
            let seen = |index| maxima.seen_of_threshold(index, which, time);
            ThresholdGrids {
                threshold: maxima.thresholds()[which],
                arrival: self.pick(bed_elevation, |index| seen(index).arrival, f64::min),
                duration: self.pick(bed_elevation, |index| seen(index).duration, f64::max),
                recession: self.pick(bed_elevation, |index| seen(index).recession, f64::max),
            }
        };
        let is_wet = |index: usize| maxima.seen(index).max_depth > WET_DEPTH;
        let level_of_wet = |index| if is_wet(index) { level(index) } else { f64::NAN };
        GridMaps {
            bed_elevation: self.mean_of_terrain(bed_elevation),
            max_depth: self.pick(bed_elevation, |index| seen(index).max_depth, f64::max),
            max_water_level: self.pick(bed_elevation, level_of_wet, f64::max),
            max_speed: self.pick(bed_elevation, |index| seen(index).max_speed, f64::max),
            max_depth_velocity: self.pick(bed_elevation, |index| seen(index).max_depth_velocity, f64::max),
            time_of_max_depth: self.times_of_max_depth(maxima),
            hazard_class: self.pick(bed_elevation, |index| f64::from(seen(index).hazard_class), f64::max),
            resolution: Vec::new(),
            max_depth_error: Vec::new(),
            arrival_time_error: Vec::new(),
            ground_source: SourceGrid::default(),
            thresholds: (0..maxima.thresholds().len()).map(of_threshold).collect(),
            tracers: Vec::new(),
        }
    }

    /// Of the values of the lattice cells with terrain in each cell the one that counts; [`FILL`] where all are NaN.
    fn pick(&self, bed: &[f64], value: impl Fn(usize) -> f64, which: impl Fn(f64, f64) -> f64) -> Vec<f32> {
        if self.is_lattice() {
            let mut values = Vec::with_capacity(self.len());
            for down in &self.row_overlaps {
                let row = down[0].index * self.lattice_columns..(down[0].index + 1) * self.lattice_columns;
                let leaves = row.map(|index| self.leaf(index));
                values.extend(leaves.map(|index| if bed[index].is_nan() { FILL } else { filled(value(index)) }));
            }
            return values;
        }
        self.of_cells(|down, across| {
            let parts = self.parts(down, across).filter(|(_, index)| !bed[*index].is_nan());
            filled(parts.map(|(_, index)| value(index)).fold(f64::NAN, &which))
        })
    }

    /// Who set the ground. In each cell what is built or fitted counts before the layers of the terrain, and of either kind the source with
    /// the greatest share of the area, the higher code of two with the same.
    pub fn ground_source(&self, source: &GroundSource) -> SourceGrid {
        let codes =
            if source.of_pixels.is_empty() { self.largest_share(&source.of_cells) } else { source.of_pixels.clone() };
        let shown: BTreeSet<u8> = codes.iter().copied().collect();
        let classes = source.classes.iter().filter(|class| shown.contains(&class.code)).cloned().collect();
        let codes = codes.into_iter().map(|code| if code == 0 { FILL } else { f32::from(code) }).collect();
        SourceGrid { codes, classes }
    }

    fn largest_share(&self, codes: &[u8]) -> Vec<u8> {
        self.of_cells(|down, across| {
            let mut shares: BTreeMap<u8, f64> = BTreeMap::new();
            for (share, index) in self.finest_parts(down, across).filter(|(_, index)| codes[*index] != 0) {
                *shares.entry(codes[index]).or_default() += share;
            }
            let by_share = |a: &(bool, u8, f64), b: &(bool, u8, f64)| a.0.cmp(&b.0).then(a.2.total_cmp(&b.2));
            let ranked = shares.into_iter().map(|(code, share)| (SetBy::is_built(code), code, share));
            ranked.max_by(by_share).map_or(0, |(_, code, _)| code)
        })
    }

    /// The time of the greatest depth of the deepest lattice cell in each cell.
    fn times_of_max_depth(&self, maxima: &Maxima) -> Vec<f32> {
        self.of_cells(|down, across| {
            let seen =
                self.parts(down, across).map(|(_, index)| maxima.seen(index)).filter(|seen| seen.max_depth > WET_DEPTH);
            let deepest = seen.reduce(|a, b| if b.max_depth > a.max_depth { b } else { a });
            filled(deepest.map_or(f64::NAN, |seen| seen.time_of_max_depth))
        })
    }

    /// The mean bed of the terrain in each cell.
    fn mean_of_terrain(&self, bed: &[f64]) -> Vec<f32> {
        self.of_cells(|down, across| {
            let parts = self.parts(down, across).filter(|(_, index)| !bed[*index].is_nan());
            let (area, sum) =
                parts.fold((0.0, 0.0), |(area, sum), (share, index)| (area + share, sum + share * bed[index]));
            filled(sum / area)
        })
    }
}

/// The mean of the water in a cell: depth and discharges, and of its wet part the level (m) times its share.
#[derive(Default)]
struct Mean {
    water: WaterInCell,
    level: f64,
    wet: f64,
}

impl Mean {
    #[inline]
    fn add(&mut self, share: f64, water: WaterInCell, bed: f64) {
        self.water.depth += share * water.depth;
        self.water.discharge_x += share * water.discharge_x;
        self.water.discharge_y += share * water.discharge_y;
        if water.depth > WET_DEPTH {
            self.level += share * (bed + water.depth);
            self.wet += share;
        }
    }
}

/// The greatest level (m) of a cell: that of its greatest depth, or what was seen where its bed changed.
pub(super) fn greatest_level(maxima: &Maxima, bed: &[f64], highest: &BTreeMap<usize, f64>, index: usize) -> f64 {
    highest.get(&index).copied().unwrap_or(bed[index] + maxima.seen(index).max_depth)
}

/// A value as it is written.
pub(super) fn filled(value: f64) -> f32 {
    if value.is_nan() { FILL } else { value as f32 }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values that must be taken over unchanged are compared exactly")]
mod tests;
