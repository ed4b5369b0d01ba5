//! What each cell has seen so far: maxima, the times of arrival and recession, duration, hazard.
//!
//! Everything is followed at compute steps. Depth is taken as linear in time between two steps, so that a crossing of a
//! depth D between (t₀, d₀) and (t₁, d₁) lies at
//!
//! ```text
//! t = t₀ + (t₁ − t₀) (D − d₀)/(d₁ − d₀)
//! ```
//!
//! Arrival for a threshold τ: on ground that was dry at the start, the first time with d ≥ τ; on ground that was wet
//! (deeper than [`WET_DEPTH`](super::WET_DEPTH)), the first time with d ≥ max(τ, d(0) + rise), that is, when the level
//! has risen by `rise_on_wet` and the threshold is reached. Duration is the sum of all times with d ≥ τ; recession is the
//! last fall below τ, and missing while the place is still under water.
//!
//! A cell in still or slowly falling water costs a few comparisons a step, on lanes of the processor: times under water are counted when
//! they begin and when they end, not step by step. Records of cells that stay dry are zero in every bit and never touched, so that they take no memory:
//! the system gives it at the first touch, but to records that are not laid to whole cache lines. Times that are written to maps and
//! nowhere else are kept in their single precision. Each cell is written by one thread and reads only itself, so the bits do not
//! depend on the number of threads.

mod record;
mod rules;
#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values that must be the same to the last digit are compared exactly")]
mod tests;

use bytemuck::allocation::zeroed_vec;
use rayon::prelude::*;

use super::WET_DEPTH;
use crate::lattice::{WaterInCell, WaterOnLattice};
use record::{Block, BlockOfWater, LANES, Moment, ThresholdRecord};
use rules::{RowOfRecords, Rules};

/// Number of cells under water from which it pays to share a step between threads.
const PARALLEL_CELLS: usize = 4096;

/// Rows that a thread takes at least.
const PARALLEL_ROWS: usize = 8;

/// What a cell has seen up to now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    /// Greatest depth (m); 0 where always dry.
    pub max_depth: f64,
    /// First time of the greatest depth (s); NaN where always dry.
    pub time_of_max_depth: f64,
    /// Greatest speed (m/s).
    pub max_speed: f64,
    /// Greatest depth times speed of one moment (m²/s).
    pub max_depth_velocity: f64,
    /// Greatest hazard class of one moment, 1 to 6; 0 where always dry.
    pub hazard_class: u8,
}

/// What a cell has seen of a threshold τ up to now; NaN where something never happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ThresholdSeen {
    /// Time of arrival (s); NaN where the water never came.
    pub arrival: f64,
    /// Sum of the times with d ≥ τ (s); 0 where there were none.
    pub duration: f64,
    /// Time of the last fall below τ (s); NaN where there was none or where the water still stands.
    pub recession: f64,
}

/// Follows the maxima of all cells.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Maxima {
    columns: usize,
    /// Blocks of a row.
    blocks_of_row: usize,
    thresholds: Vec<f64>,
    rise_on_wet: f64,
    /// The water of the last step taken.
    previous: Vec<BlockOfWater>,
    /// Empty where nobody asks for maxima, as the next.
    blocks: Vec<Block>,
    crossings: Vec<ThresholdRecord>,
}

impl Maxima {
    /// An empty record for `cells` cells in rows of `columns`; `thresholds` (m) must not be empty.
    pub(super) fn new(cells: usize, columns: usize, thresholds: &[f64], rise_on_wet: f64) -> Self {
        assert!(!thresholds.is_empty(), "invariant: a resolved scenario has at least one threshold");
        // Rows of no cells are none to go through, but rows all the same.
        let columns = columns.max(1);
        let blocks_of_row = columns.div_ceil(LANES);
        Maxima {
            columns,
            blocks_of_row,
            thresholds: thresholds.to_vec(),
            rise_on_wet,
            previous: zeroed_vec(cells.div_ceil(columns) * blocks_of_row),
            blocks: zeroed_vec(cells.div_ceil(columns) * blocks_of_row),
            crossings: zeroed_vec(cells * thresholds.len()),
        }
    }

    /// Keeps the water of the last step alone.
    pub(super) fn leave_out(&mut self) {
        (self.thresholds, self.blocks, self.crossings) = (Vec::new(), Vec::new(), Vec::new());
    }

    /// Takes the water at the start of the run.
    pub(super) fn start(&mut self, time: f64, water: &WaterOnLattice<'_>) {
        let spans = if self.blocks.is_empty() { &[] } else { water.spans };
        for span in spans {
            let row = water.rows.row(span.row as usize);
            for column in span.from as usize..span.to as usize {
                let (depth, index) = (row.depth[column], span.row as usize * self.columns + column);
                let (block, lane) = self.place(index);
                self.blocks[block].initial_depth[lane] = depth;
                for (which, &threshold) in self.thresholds.iter().enumerate() {
                    if depth >= threshold {
                        let crossing = &mut self.crossings[index * self.thresholds.len() + which];
                        crossing.duration = -time;
                        if depth >= arrival_depth(threshold, depth, self.rise_on_wet) {
                            crossing.arrival = Moment::at(time);
                        }
                    }
                }
            }
        }
        self.step(time, time, water);
    }

    /// The block of a cell, and its place in it.
    #[inline]
    fn place(&self, index: usize) -> (usize, usize) {
        let (row, column) = (index / self.columns, index % self.columns);
        (row * self.blocks_of_row + column / LANES, column % LANES)
    }

    /// Takes the water at the end of a compute step from `before` to `after` (s).
    pub(super) fn step(&mut self, before: f64, after: f64, water: &WaterOnLattice<'_>) {
        let under_water: usize = water.spans.iter().map(|span| (span.to - span.from) as usize).sum();
        let (blocks_of_row, crossings_of_row) = (self.blocks_of_row, self.columns * self.thresholds.len());
        let rules = Rules { before, after, thresholds: &self.thresholds, rise_on_wet: self.rise_on_wet };
        let Maxima { previous, blocks, crossings, .. } = self;
        let follow = |row: usize, records: RowOfRecords<'_>| {
            let spans = water.spans_of_row(row);
            if !spans.is_empty() {
                rules.follow_row(&water.rows.row(row), spans, records);
            }
        };
        if under_water < PARALLEL_CELLS {
            for spans in water.spans.chunk_by(|a, b| a.row == b.row) {
                let row = spans[0].row as usize;
                let records = RowOfRecords {
                    previous: row_of(previous, row, blocks_of_row),
                    blocks: row_of(blocks, row, blocks_of_row),
                    crossings: row_of(crossings, row, crossings_of_row),
                };
                rules.follow_row(&water.rows.row(row), spans, records);
            }
        } else if blocks.is_empty() {
            let rows = previous.par_chunks_mut(blocks_of_row).enumerate().with_min_len(PARALLEL_ROWS);
            rows.for_each(|(row, previous)| {
                follow(row, RowOfRecords { previous, blocks: &mut [], crossings: &mut [] });
            });
        } else {
            let seen = blocks.par_chunks_mut(blocks_of_row).zip(crossings.par_chunks_mut(crossings_of_row));
            let rows = previous.par_chunks_mut(blocks_of_row).zip(seen).enumerate().with_min_len(PARALLEL_ROWS);
            rows.for_each(|(row, (previous, (blocks, crossings)))| {
                follow(row, RowOfRecords { previous, blocks, crossings });
            });
        }
    }

    /// The water of a cell at the last step taken.
    #[inline]
    pub(super) fn previous(&self, index: usize) -> WaterInCell {
        let (block, lane) = self.place(index);
        let previous = &self.previous[block];
        WaterInCell {
            depth: previous.depth[lane],
            discharge_x: previous.discharge_x[lane],
            discharge_y: previous.discharge_y[lane],
        }
    }

    /// The thresholds (m).
    pub(super) fn thresholds(&self) -> &[f64] {
        &self.thresholds
    }

    /// What a cell has seen.
    #[inline]
    pub(super) fn seen(&self, index: usize) -> Seen {
        let (block, lane) = self.place(index);
        let block = &self.blocks[block];
        Seen {
            max_depth: block.max_depth[lane],
            time_of_max_depth: block.time_of_max_depth[lane].time(),
            max_speed: block.max_speed_squared[lane].sqrt(),
            max_depth_velocity: block.max_discharge_squared[lane].sqrt(),
            hazard_class: block.hazard_class[lane],
        }
    }

    /// What a cell has seen of a threshold, given by its place in the plan, up to `time` (s).
    pub(super) fn seen_of_threshold(&self, index: usize, which: usize, time: f64) -> ThresholdSeen {
        let record = self.crossings[index * self.thresholds.len() + which];
        let is_under_water = self.previous(index).depth >= self.thresholds[which];
        ThresholdSeen {
            arrival: record.arrival.time(),
            duration: record.duration + if is_under_water { time } else { 0.0 },
            recession: if is_under_water { f64::NAN } else { record.recession.time() },
        }
    }
}

/// The depth (m) at which the water counts as arrived.
#[inline]
pub(super) fn arrival_depth(threshold: f64, initial_depth: f64, rise_on_wet: f64) -> f64 {
    if initial_depth > WET_DEPTH { threshold.max(initial_depth + rise_on_wet) } else { threshold }
}

/// The part of a row, `len` entries long, of an array that has one for each row, or none at all.
fn row_of<T>(all: &mut [T], row: usize, len: usize) -> &mut [T] {
    if all.is_empty() { all } else { &mut all[row * len..][..len] }
}
