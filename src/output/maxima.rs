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
//! A cell in still or slowly falling water costs a few comparisons a step: times under water are booked when they begin and when
//! they end, not step by step. Records of cells that stay dry are zero in every bit and never touched, so that they take no memory:
//! the system gives it at the first touch, but to records that are not laid to whole cache lines. Times that are written to maps and
//! nowhere else are kept in their single precision. Each cell is written by one thread and reads only itself, so the bits do not
//! depend on the number of threads.

use bytemuck::Zeroable;
use bytemuck::allocation::zeroed_vec;
use rayon::prelude::*;

use super::WET_DEPTH;
use super::hazard::greater_class;
use crate::lattice::{Span, WaterInCell, WaterOnLattice};

/// Number of cells under water from which it pays to share a step between threads.
const PARALLEL_CELLS: usize = 4096;

/// Rows that a thread takes at least.
const PARALLEL_ROWS: usize = 8;

/// A time that may not have come yet: all bits are 0 until then.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(transparent)]
struct Moment(u64);

impl Moment {
    const NEVER: u64 = f64::NAN.to_bits();

    /// A time (s), not NaN.
    fn at(time: f64) -> Self {
        Moment(time.to_bits() ^ Self::NEVER)
    }

    /// The time (s); NaN where it has not come.
    fn time(self) -> f64 {
        f64::from_bits(self.0 ^ Self::NEVER)
    }

    fn has_come(self) -> bool {
        self.0 != 0
    }
}

/// The same in single precision.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(transparent)]
struct ShortMoment(u32);

impl ShortMoment {
    const NEVER: u32 = f32::NAN.to_bits();

    /// A time (s), not NaN.
    fn at(time: f64) -> Self {
        ShortMoment((time as f32).to_bits() ^ Self::NEVER)
    }

    /// The time (s); NaN where it has not come.
    fn time(self) -> f64 {
        f64::from(f32::from_bits(self.0 ^ Self::NEVER))
    }
}

/// What is kept of one cell besides the thresholds; the squares spare a root at each step.
#[derive(Clone, Copy, Debug, Zeroable)]
struct CellRecord {
    initial_depth: f64,
    previous: WaterInCell,
    max_depth: f64,
    max_speed_squared: f64,
    max_discharge_squared: f64,
    time_of_max_depth: ShortMoment,
    hazard_class: u8,
}

/// What is kept of one cell for one threshold. Whether the cell is under water tells its depth.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(C, packed(4))]
struct ThresholdRecord {
    arrival: Moment,
    /// Time under water (s); while that goes on, less the time of now.
    duration: f64,
    /// The latest fall below the threshold.
    recession: ShortMoment,
}

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
#[derive(Debug)]
pub(super) struct Maxima {
    columns: usize,
    thresholds: Vec<f64>,
    rise_on_wet: f64,
    cells: Vec<CellRecord>,
    crossings: Vec<ThresholdRecord>,
}

impl Maxima {
    /// An empty record for `cells` cells in rows of `columns`; `thresholds` (m) must not be empty.
    pub(super) fn new(cells: usize, columns: usize, thresholds: &[f64], rise_on_wet: f64) -> Self {
        assert!(!thresholds.is_empty(), "invariant: a resolved scenario has at least one threshold");
        Maxima {
            // Rows of no cells are none to go through, but rows all the same.
            columns: columns.max(1),
            thresholds: thresholds.to_vec(),
            rise_on_wet,
            cells: zeroed_vec(cells),
            crossings: zeroed_vec(cells * thresholds.len()),
        }
    }

    /// Takes the water at the start of the run.
    pub(super) fn start(&mut self, time: f64, water: &WaterOnLattice<'_>) {
        for span in water.spans {
            for index in span.cells(self.columns) {
                let depth = water.at(index).depth;
                self.cells[index].initial_depth = depth;
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

    /// Takes the water at the end of a compute step from `before` to `after` (s).
    pub(super) fn step(&mut self, before: f64, after: f64, water: &WaterOnLattice<'_>) {
        let under_water: usize = water.spans.iter().map(|span| (span.to - span.from) as usize).sum();
        let (columns, count) = (self.columns, self.thresholds.len());
        let rules = Rules { before, after, thresholds: &self.thresholds, rise_on_wet: self.rise_on_wet };
        let row_of_cells = |(row, (cells, crossings)): (usize, (&mut [CellRecord], &mut [ThresholdRecord]))| {
            let first = water.spans.partition_point(|span| (span.row as usize) < row);
            let water_of_row = water.rows.row(row);
            for span in water.spans[first..].iter().take_while(|span| span.row as usize == row) {
                for column in span.from as usize..span.to as usize {
                    let crossings = &mut crossings[column * count..(column + 1) * count];
                    rules.update(water_of_row.at(column), &mut cells[column], crossings);
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
    pub(super) fn previous(&self, index: usize) -> WaterInCell {
        self.cells[index].previous
    }

    /// The thresholds (m).
    pub(super) fn thresholds(&self) -> &[f64] {
        &self.thresholds
    }

    /// What a cell has seen.
    pub(super) fn seen(&self, index: usize) -> Seen {
        let cell = &self.cells[index];
        Seen {
            max_depth: cell.max_depth,
            time_of_max_depth: cell.time_of_max_depth.time(),
            max_speed: cell.max_speed_squared.sqrt(),
            max_depth_velocity: cell.max_discharge_squared.sqrt(),
            hazard_class: cell.hazard_class,
        }
    }

    /// What a cell has seen of a threshold, given by its place in the plan, up to `time` (s).
    pub(super) fn seen_of_threshold(&self, index: usize, which: usize, time: f64) -> ThresholdSeen {
        let record = self.crossings[index * self.thresholds.len() + which];
        let is_under_water = self.cells[index].previous.depth >= self.thresholds[which];
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
    fn update(&self, now: WaterInCell, cell: &mut CellRecord, crossings: &mut [ThresholdRecord]) {
        let WaterInCell { depth, discharge_x, discharge_y } = now;
        let previous = cell.previous.depth;
        for (crossing, &threshold) in crossings.iter_mut().zip(self.thresholds) {
            if (previous >= threshold) != (depth >= threshold) && self.after > self.before {
                self.book_crossing(threshold, previous, depth, crossing);
            }
        }
        if depth > cell.max_depth {
            for (crossing, &threshold) in crossings.iter_mut().zip(self.thresholds) {
                let arrival_depth = arrival_depth(threshold, cell.initial_depth, self.rise_on_wet);
                if !crossing.arrival.has_come() && depth >= arrival_depth && self.after > self.before {
                    crossing.arrival = Moment::at(self.crossing(arrival_depth, previous, depth));
                }
            }
            cell.max_depth = depth;
            cell.time_of_max_depth = ShortMoment::at(self.after);
        }
        if depth > WET_DEPTH {
            let discharge_squared = discharge_x * discharge_x + discharge_y * discharge_y;
            cell.max_discharge_squared = cell.max_discharge_squared.max(discharge_squared);
            if discharge_squared > cell.max_speed_squared * depth * depth {
                cell.max_speed_squared = discharge_squared / (depth * depth);
            }
            cell.hazard_class = greater_class(cell.hazard_class, depth, discharge_squared);
        }
        cell.previous = now;
    }

    #[cold]
    fn book_crossing(&self, threshold: f64, previous: f64, depth: f64, crossing: &mut ThresholdRecord) {
        let time = self.crossing(threshold, previous, depth);
        if depth < threshold {
            crossing.duration += time;
            crossing.recession = ShortMoment::at(time);
        } else {
            crossing.duration -= time;
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
