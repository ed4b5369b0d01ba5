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
//! One record for a cell is one cache line. A cell in still or slowly falling water costs a few comparisons a step: times
//! under water are booked when they end, not step by step. Each cell is written by one thread and reads only itself, so
//! the bits do not depend on the number of threads.

use rayon::prelude::*;

use super::WET_DEPTH;
use super::hazard::greater_class;
use crate::lattice::{Span, WaterOnLattice};

/// Number of cells under water from which it pays to share a step between threads.
const PARALLEL_CELLS: usize = 4096;

/// Rows that a thread takes at least.
const PARALLEL_ROWS: usize = 8;

/// What is kept of one cell besides the thresholds; the squares spare a root at each step.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
struct CellRecord {
    previous_depth: f64,
    previous_discharge_x: f64,
    previous_discharge_y: f64,
    max_depth: f64,
    time_of_max_depth: f64,
    max_speed_squared: f64,
    max_discharge_squared: f64,
    hazard_class: u8,
}

/// What is kept of one cell for one threshold; times are NaN until they happen.
#[derive(Clone, Copy, Debug)]
struct ThresholdRecord {
    arrival: f64,
    under_water_since: f64,
    last_fall: f64,
    duration: f64,
}

/// The maps for one threshold on the lattice; NaN where something never happened.
#[derive(Clone, Debug, PartialEq)]
pub struct ThresholdMaps {
    /// The threshold τ (m).
    pub threshold: f64,
    /// Time of arrival (s); NaN where the water never came.
    pub arrival: Vec<f64>,
    /// Sum of the times with d ≥ τ (s); 0 where there were none.
    pub duration: Vec<f64>,
    /// Time of the last fall below τ (s); NaN where there was none or where the water still stands.
    pub recession: Vec<f64>,
}

/// The maps of a run on the lattice, `[rows * columns]`, row 0 in the south.
#[derive(Clone, Debug, PartialEq)]
pub struct LatticeMaps {
    /// Greatest depth (m); 0 where always dry.
    pub max_depth: Vec<f64>,
    /// First time of the greatest depth (s); NaN where always dry.
    pub time_of_max_depth: Vec<f64>,
    /// Greatest speed (m/s).
    pub max_speed: Vec<f64>,
    /// Greatest depth times speed of one moment (m²/s).
    pub max_depth_velocity: Vec<f64>,
    /// Greatest hazard class of one moment, 1 to 6; 0 where always dry.
    pub hazard_class: Vec<u8>,
    /// One entry for each threshold, in the order of the plan.
    pub thresholds: Vec<ThresholdMaps>,
}

/// Follows the maxima of all cells.
#[derive(Debug)]
pub(super) struct Maxima {
    columns: usize,
    thresholds: Vec<f64>,
    rise_on_wet: f64,
    initial_depth: Vec<f64>,
    cells: Vec<CellRecord>,
    crossings: Vec<ThresholdRecord>,
}

/// The depth and discharge of a cell at the step before.
#[derive(Clone, Copy, Debug)]
pub(super) struct PreviousWater {
    pub(super) depth: f64,
    pub(super) discharge_x: f64,
    pub(super) discharge_y: f64,
}

impl PreviousWater {
    /// The water `share` of the way to a later moment.
    pub(super) fn towards(self, later: PreviousWater, share: f64) -> PreviousWater {
        let mix = |a: f64, b: f64| a + (b - a) * share;
        PreviousWater {
            depth: mix(self.depth, later.depth),
            discharge_x: mix(self.discharge_x, later.discharge_x),
            discharge_y: mix(self.discharge_y, later.discharge_y),
        }
    }
}

impl Maxima {
    /// An empty record for `cells` cells in rows of `columns`; `thresholds` (m) must not be empty.
    pub(super) fn new(cells: usize, columns: usize, thresholds: &[f64], rise_on_wet: f64) -> Self {
        assert!(!thresholds.is_empty(), "invariant: a resolved scenario has at least one threshold");
        let never =
            ThresholdRecord { arrival: f64::NAN, under_water_since: f64::NAN, last_fall: f64::NAN, duration: 0.0 };
        Maxima {
            columns,
            thresholds: thresholds.to_vec(),
            rise_on_wet,
            initial_depth: vec![0.0; cells],
            cells: vec![CellRecord { time_of_max_depth: f64::NAN, ..CellRecord::default() }; cells],
            crossings: vec![never; cells * thresholds.len()],
        }
    }

    /// Takes the water at the start of the run.
    pub(super) fn start(&mut self, time: f64, water: &WaterOnLattice<'_>) {
        for span in water.spans {
            for index in span.cells(self.columns) {
                self.initial_depth[index] = water.depth[index];
                for (which, &threshold) in self.thresholds.iter().enumerate() {
                    if water.depth[index] >= threshold {
                        let crossing = &mut self.crossings[index * self.thresholds.len() + which];
                        crossing.under_water_since = time;
                        if water.depth[index] >= arrival_depth(threshold, water.depth[index], self.rise_on_wet) {
                            crossing.arrival = time;
                        }
                    }
                }
            }
        }
        self.step(time, time, water);
    }

    /// Takes the water at the end of a compute step from `before` to `after` (s).
    pub(super) fn step(&mut self, before: f64, after: f64, water: &WaterOnLattice<'_>) {
        let under_water: usize = water.spans.iter().map(|span| (span.to - span.from) as usize).sum();
        let (columns, count) = (self.columns, self.thresholds.len());
        let rules = Rules { before, after, thresholds: &self.thresholds, rise_on_wet: self.rise_on_wet };
        let initial_depth = &self.initial_depth;
        let row_of_cells = |(row, (cells, crossings)): (usize, (&mut [CellRecord], &mut [ThresholdRecord]))| {
            let first = water.spans.partition_point(|span| (span.row as usize) < row);
            for span in water.spans[first..].iter().take_while(|span| span.row as usize == row) {
                for column in span.from as usize..span.to as usize {
                    let index = row * columns + column;
                    let now = (water.depth[index], water.discharge_x[index], water.discharge_y[index]);
                    let crossings = &mut crossings[column * count..(column + 1) * count];
                    rules.update(now, initial_depth[index], &mut cells[column], crossings);
                }
            }
        };
        if under_water < PARALLEL_CELLS {
            let rows = self.cells.chunks_mut(columns).zip(self.crossings.chunks_mut(columns * count));
            rows.enumerate().for_each(row_of_cells);
        } else {
            let rows = self.cells.par_chunks_mut(columns).zip(self.crossings.par_chunks_mut(columns * count));
            rows.enumerate().with_min_len(PARALLEL_ROWS).for_each(row_of_cells);
        }
    }

    /// The water of a cell at the last step taken.
    #[inline]
    pub(super) fn previous(&self, index: usize) -> PreviousWater {
        let cell = &self.cells[index];
        PreviousWater {
            depth: cell.previous_depth,
            discharge_x: cell.previous_discharge_x,
            discharge_y: cell.previous_discharge_y,
        }
    }

    /// The maps at the end of the run at `time` (s).
    pub(super) fn maps(&self, time: f64) -> LatticeMaps {
        let of_cells = |value: fn(&CellRecord) -> f64| self.cells.iter().map(value).collect::<Vec<f64>>();
        LatticeMaps {
            max_depth: of_cells(|cell| cell.max_depth),
            time_of_max_depth: of_cells(|cell| cell.time_of_max_depth),
            max_speed: of_cells(|cell| cell.max_speed_squared.sqrt()),
            max_depth_velocity: of_cells(|cell| cell.max_discharge_squared.sqrt()),
            hazard_class: self.cells.iter().map(|cell| cell.hazard_class).collect(),
            thresholds: (0..self.thresholds.len()).map(|which| self.threshold_maps(which, time)).collect(),
        }
    }

    fn threshold_maps(&self, which: usize, time: f64) -> ThresholdMaps {
        let records = || self.crossings.iter().skip(which).step_by(self.thresholds.len());
        let still_under_water = |record: &ThresholdRecord| !record.under_water_since.is_nan();
        let last_stay = |record: &ThresholdRecord| {
            if still_under_water(record) { time - record.under_water_since } else { 0.0 }
        };
        ThresholdMaps {
            threshold: self.thresholds[which],
            arrival: records().map(|record| record.arrival).collect(),
            duration: records().map(|record| record.duration + last_stay(record)).collect(),
            recession: records()
                .map(|record| if still_under_water(record) { f64::NAN } else { record.last_fall })
                .collect(),
        }
    }
}

/// The depth (m) at which the water counts as arrived.
#[inline]
pub(super) fn arrival_depth(threshold: f64, initial_depth: f64, rise_on_wet: f64) -> f64 {
    if initial_depth > WET_DEPTH { threshold.max(initial_depth + rise_on_wet) } else { threshold }
}

/// What one step does to a cell.
struct Rules<'a> {
    before: f64,
    after: f64,
    thresholds: &'a [f64],
    rise_on_wet: f64,
}

impl Rules<'_> {
    /// Time at which the depth passes `depth` between two steps; the caller knows that it does.
    #[inline]
    fn crossing(&self, depth: f64, depth_before: f64, depth_after: f64) -> f64 {
        let share = (depth - depth_before) / (depth_after - depth_before);
        self.before + (self.after - self.before) * share
    }

    #[inline]
    fn update(
        &self,
        (depth, discharge_x, discharge_y): (f64, f64, f64),
        initial_depth: f64,
        cell: &mut CellRecord,
        crossings: &mut [ThresholdRecord],
    ) {
        let previous = cell.previous_depth;
        for (crossing, &threshold) in crossings.iter_mut().zip(self.thresholds) {
            if (previous >= threshold) != (depth >= threshold) && self.after > self.before {
                self.book_crossing(threshold, previous, depth, crossing);
            }
        }
        if depth > cell.max_depth {
            for (crossing, &threshold) in crossings.iter_mut().zip(self.thresholds) {
                let arrival_depth = arrival_depth(threshold, initial_depth, self.rise_on_wet);
                if crossing.arrival.is_nan() && depth >= arrival_depth && self.after > self.before {
                    crossing.arrival = self.crossing(arrival_depth, previous, depth);
                }
            }
            cell.max_depth = depth;
            cell.time_of_max_depth = self.after;
        }
        if depth > WET_DEPTH {
            let discharge_squared = discharge_x * discharge_x + discharge_y * discharge_y;
            cell.max_discharge_squared = cell.max_discharge_squared.max(discharge_squared);
            if discharge_squared > cell.max_speed_squared * depth * depth {
                cell.max_speed_squared = discharge_squared / (depth * depth);
            }
            cell.hazard_class = greater_class(cell.hazard_class, depth, discharge_squared);
        }
        cell.previous_depth = depth;
        cell.previous_discharge_x = discharge_x;
        cell.previous_discharge_y = discharge_y;
    }

    #[cold]
    fn book_crossing(&self, threshold: f64, previous: f64, depth: f64, crossing: &mut ThresholdRecord) {
        let time = self.crossing(threshold, previous, depth);
        if depth >= threshold {
            crossing.under_water_since = time;
        } else {
            crossing.duration += time - crossing.under_water_since;
            crossing.under_water_since = f64::NAN;
            crossing.last_fall = time;
        }
    }
}

impl Span {
    /// Indices of the cells of the span on a lattice with `columns` columns.
    #[inline]
    pub(super) fn cells(&self, columns: usize) -> std::ops::Range<usize> {
        let start = self.row as usize * columns;
        start + self.from as usize..start + self.to as usize
    }
}
