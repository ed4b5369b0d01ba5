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

use bytemuck::Zeroable;
use bytemuck::allocation::zeroed_vec;
use rayon::prelude::*;

use super::WET_DEPTH;
use super::hazard::greater_class;
use crate::lattice::{Span, WaterInCell, WaterInRow, WaterOnLattice};
use crate::math::larger;

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

/// Cells of a row that are looked at together.
const LANES: usize = 8;

/// A number of each cell of a block.
type Lanes = [f64; LANES];

/// What is kept of some cells of a row besides the thresholds; the squares spare a root at each step.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(C)]
struct Block {
    initial_depth: Lanes,
    max_depth: Lanes,
    max_speed_squared: Lanes,
    max_discharge_squared: Lanes,
    time_of_max_depth: [ShortMoment; LANES],
    hazard_class: [u8; LANES],
}

/// The water of some cells of a row.
#[derive(Clone, Copy, Debug, Zeroable)]
#[repr(C)]
struct BlockOfWater {
    depth: Lanes,
    discharge_x: Lanes,
    discharge_y: Lanes,
}

impl BlockOfWater {
    /// (d·|v|)² of each cell (m⁴/s²).
    #[inline(always)]
    fn discharge_squared(&self) -> Lanes {
        let mut squares = [0.0; LANES];
        for ((square, x), y) in squares.iter_mut().zip(&self.discharge_x).zip(&self.discharge_y) {
            *square = x * x + y * y;
        }
        squares
    }

    /// The water of the columns `from..to` of a row, which lie in the block that begins with column `first`; in its other columns that of
    /// before.
    #[inline(always)]
    fn of_row(row: &WaterInRow<'_>, first: usize, (from, to): (usize, usize), before: &BlockOfWater) -> Self {
        if to - from == LANES {
            let whole = |values: &[f64]| {
                let mut lanes = [0.0; LANES];
                lanes.copy_from_slice(&values[first..][..LANES]);
                lanes
            };
            return BlockOfWater {
                depth: whole(row.depth),
                discharge_x: whole(row.discharge_x),
                discharge_y: whole(row.discharge_y),
            };
        }
        let mut block = *before;
        let lanes = from - first..to - first;
        block.depth[lanes.clone()].copy_from_slice(&row.depth[from..to]);
        block.discharge_x[lanes.clone()].copy_from_slice(&row.discharge_x[from..to]);
        block.discharge_y[lanes].copy_from_slice(&row.discharge_y[from..to]);
        block
    }
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

    /// Takes the water of a row within its spans.
    fn follow_row(&self, row: &WaterInRow<'_>, spans: &[Span], mut records: RowOfRecords<'_>) {
        for span in spans {
            follow_span(self, row, (span.from as usize, span.to as usize), &mut records);
        }
    }

    /// Takes the water of a block of cells now and at the step before; `crossings` are those of its cells.
    #[inline(always)]
    fn follow(
        &self,
        (previous, now): (&BlockOfWater, &BlockOfWater),
        block: &mut Block,
        crossings: &mut [ThresholdRecord],
    ) {
        let changes = self.changes((previous, now), block);
        if changes.iter().fold(0, |all, change| all | change) == 0 {
            return;
        }
        let discharge_squared = now.discharge_squared();
        let count = self.thresholds.len();
        let moment = ShortMoment::at(self.after);
        for (lane, change) in changes.into_iter().enumerate().filter(|(_, change)| *change != 0) {
            let depth = now.depth[lane];
            if change & IS_CROSSED != 0 {
                self.cross(previous.depth[lane], depth, &mut crossings[lane * count..][..count]);
            }
            if change & IS_ARRIVING != 0 {
                let depths = (block.initial_depth[lane], previous.depth[lane], depth);
                self.arrive(depths, &mut crossings[lane * count..][..count]);
            }
            if change & IS_DEEPER != 0 {
                block.time_of_max_depth[lane] = moment;
            }
            // The class grows with a maximum only: it is that of the greatest depth, speed and discharge, each by itself.
            if depth > WET_DEPTH {
                block.hazard_class[lane] = greater_class(block.hazard_class[lane], depth, discharge_squared[lane]);
            }
        }
        for (lane, discharge_squared) in discharge_squared.into_iter().enumerate() {
            let depth = now.depth[lane];
            block.max_depth[lane] = larger(depth, block.max_depth[lane]);
            // A film has neither speed nor discharge.
            let (square, counted) = (depth * depth, if depth > WET_DEPTH { discharge_squared } else { 0.0 });
            block.max_discharge_squared[lane] = larger(counted, block.max_discharge_squared[lane]);
            let speed_squared = block.max_speed_squared[lane];
            let is_faster = counted > speed_squared * depth * depth;
            block.max_speed_squared[lane] = if is_faster { counted / square } else { speed_squared };
        }
    }

    /// Of each cell what changes: in still or falling water nothing does.
    #[inline(always)]
    fn changes(&self, (previous, now): (&BlockOfWater, &BlockOfWater), block: &Block) -> [u64; LANES] {
        let mut changes = [0; LANES];
        let mut highest = 0.0;
        for &threshold in self.thresholds {
            highest = larger(threshold, highest);
            if self.after > self.before {
                let depths = previous.depth.iter().zip(&now.depth);
                for (change, (before, after)) in changes.iter_mut().zip(depths) {
                    *change |= u64::from((*before >= threshold) != (*after >= threshold)) * IS_CROSSED;
                }
            }
        }
        let discharge_squared = now.discharge_squared();
        for (lane, change) in changes.iter_mut().enumerate() {
            let (depth, discharge_squared) = (now.depth[lane], discharge_squared[lane]);
            let is_faster = (depth > WET_DEPTH)
                & ((discharge_squared > block.max_discharge_squared[lane])
                    | (discharge_squared > block.max_speed_squared[lane] * depth * depth));
            let is_deeper = depth > block.max_depth[lane];
            // Where the water was deeper than any depth of arrival it has arrived.
            let last_arrival = larger(block.initial_depth[lane] + self.rise_on_wet, highest);
            let is_arriving = is_deeper & (block.max_depth[lane] < last_arrival);
            *change |= u64::from(is_deeper) * IS_DEEPER
                + u64::from(is_faster) * IS_FASTER
                + u64::from(is_arriving) * IS_ARRIVING;
        }
        changes
    }

    /// Books the arrival of water that is deeper than ever: depths (m) at the start, at the step before and now.
    #[inline(never)]
    fn arrive(&self, (initial, previous, depth): (f64, f64, f64), crossings: &mut [ThresholdRecord]) {
        for (crossing, &threshold) in crossings.iter_mut().zip(self.thresholds) {
            let arrival_depth = arrival_depth(threshold, initial, self.rise_on_wet);
            if !crossing.arrival.has_come() && depth >= arrival_depth && self.after > self.before {
                crossing.arrival = Moment::at(self.crossing(arrival_depth, previous, depth));
            }
        }
    }

    /// Books the thresholds that the depth of a cell crosses.
    #[cold]
    fn cross(&self, previous: f64, depth: f64, crossings: &mut [ThresholdRecord]) {
        for (crossing, &threshold) in crossings.iter_mut().zip(self.thresholds) {
            if (previous >= threshold) != (depth >= threshold) {
                self.book_crossing(threshold, previous, depth, crossing);
            }
        }
    }

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

/// The records of a row: the water of the step before, and what its cells have seen, unless nobody asks.
struct RowOfRecords<'a> {
    previous: &'a mut [BlockOfWater],
    blocks: &'a mut [Block],
    crossings: &'a mut [ThresholdRecord],
}

/// The part of a row, `len` entries long, of an array that has one for each row, or none at all.
fn row_of<T>(all: &mut [T], row: usize, len: usize) -> &mut [T] {
    if all.is_empty() { all } else { &mut all[row * len..][..len] }
}

/// What can change in a cell: its depth passes a threshold, is greater than ever, or its speed or its discharge is.
const IS_CROSSED: u64 = 1;
const IS_DEEPER: u64 = 2;
const IS_FASTER: u64 = 4;
/// It may have come to a depth of arrival.
const IS_ARRIVING: u64 = 8;

/// Takes the water of a row in the columns `from..to`.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn follow_span(rules: &Rules<'_>, row: &WaterInRow<'_>, (from, to): (usize, usize), records: &mut RowOfRecords<'_>) {
    let count = rules.thresholds.len();
    let mut column = from;
    while column < to {
        let number = column / LANES;
        let first = number * LANES;
        let end = to.min(first + LANES);
        let previous = &mut records.previous[number];
        let now = BlockOfWater::of_row(row, first, (column, end), previous);
        if let Some(block) = records.blocks.get_mut(number) {
            rules.follow((previous, &now), block, &mut records.crossings[first * count..]);
        }
        *previous = now;
        column = end;
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values that must be the same to the last digit are compared exactly")]
mod tests {
    use super::*;
    use crate::lattice::{FlatWater, Lattice};
    use crate::math::Vec2;

    const THRESHOLDS: [f64; 2] = [0.1, 0.3];
    const RISE: f64 = 0.05;

    /// What a cell has seen, step by step and cell by cell: the plain version.
    #[derive(Clone, Default)]
    struct Plain {
        initial: f64,
        previous: f64,
        seen: (f64, f64, f64, u8, f64),
        thresholds: [(Option<f64>, f64, Option<f64>); 2],
    }

    impl Plain {
        fn follow(&mut self, (before, after): (f64, f64), depth: f64, x: f64, y: f64) {
            let crossing =
                |threshold: f64, from: f64| before + (after - before) * ((threshold - from) / (depth - from));
            for (seen, threshold) in self.thresholds.iter_mut().zip(THRESHOLDS) {
                if (self.previous >= threshold) != (depth >= threshold) {
                    let time = crossing(threshold, self.previous);
                    seen.1 += if depth < threshold { time } else { -time };
                    if depth < threshold {
                        seen.2 = Some(time);
                    }
                }
                let arrival = arrival_depth(threshold, self.initial, RISE);
                if seen.0.is_none() && depth > self.seen.0 && depth >= arrival {
                    seen.0 = Some(crossing(arrival, self.previous));
                }
            }
            if depth > self.seen.0 {
                (self.seen.0, self.seen.4) = (depth, after);
            }
            if depth > WET_DEPTH {
                let squared = x * x + y * y;
                self.seen.2 = self.seen.2.max(squared);
                if squared > self.seen.1 * depth * depth {
                    self.seen.1 = squared / (depth * depth);
                }
                self.seen.3 = greater_class(self.seen.3, depth, squared);
            }
            self.previous = depth;
        }
    }

    #[test]
    fn lanes_see_what_each_cell_by_itself_does() {
        let lattice = Lattice { origin: Vec2::ZERO, columns: 29, rows: 3, spacing: 1.0 };
        let spans = [(0, 3, 21), (1, 0, 8), (1, 10, 29), (2, 15, 17)].map(|(row, from, to)| Span { row, from, to });
        let is_inside = |cell: usize| {
            let (column, row) = ((cell % 29) as u32, (cell / 29) as u32);
            spans.iter().any(|span| span.row == row && (span.from..span.to).contains(&column))
        };
        let mut maxima = Maxima::new(lattice.len(), lattice.columns, &THRESHOLDS, RISE);
        let mut plain = vec![Plain::default(); lattice.len()];
        for step in 0..60 {
            let time = 1.5 * f64::from(step);
            let mut rows = FlatWater::dry(&lattice);
            for cell in (0..lattice.len()).filter(|&cell| is_inside(cell)) {
                let phase = 0.21 * f64::from(step) + 0.7 * cell as f64;
                rows.depth[cell] = (0.02 * f64::from(step % 25) * phase.sin() + 0.1 * phase.cos()).max(0.0);
                rows.discharge_x[cell] = rows.depth[cell] * 3.0 * (1.3 * phase).sin();
                rows.discharge_y[cell] = rows.depth[cell] * 4.5 * (0.4 * phase).cos();
            }
            let water = WaterOnLattice { rows: &rows, lattice: &lattice, spans: &spans };
            if step == 0 {
                maxima.start(0.0, &water);
            } else {
                maxima.step(time - 1.5, time, &water);
            }
            for cell in (0..lattice.len()).filter(|&cell| is_inside(cell)) {
                let (depth, plain) = (rows.depth[cell], &mut plain[cell]);
                if step == 0 {
                    (plain.initial, plain.previous) = (depth, depth);
                    for (seen, threshold) in plain.thresholds.iter_mut().zip(THRESHOLDS) {
                        seen.0 = (depth >= arrival_depth(threshold, depth, RISE)).then_some(0.0);
                    }
                }
                plain.follow((time - 1.5, time), depth, rows.discharge_x[cell], rows.discharge_y[cell]);
            }
        }
        for (cell, plain) in plain.iter().enumerate() {
            let (seen, (depth, speed, discharge, class, time)) = (maxima.seen(cell), plain.seen);
            assert_eq!((seen.max_depth, seen.hazard_class), (depth, class), "cell {cell}");
            assert_eq!((seen.max_speed, seen.max_depth_velocity), (speed.sqrt(), discharge.sqrt()), "cell {cell}");
            assert!(if depth > 0.0 {
                seen.time_of_max_depth == time
            } else {
                seen.time_of_max_depth.is_nan() || time == 0.0
            });
            for (which, (expected, threshold)) in plain.thresholds.iter().zip(THRESHOLDS).enumerate() {
                let (arrival, duration, recession) = *expected;
                let seen = maxima.seen_of_threshold(cell, which, 88.5);
                let is_under = plain.previous >= threshold;
                assert_eq!(seen.arrival.to_bits(), arrival.unwrap_or(f64::NAN).to_bits(), "cell {cell}");
                assert_eq!(seen.duration, duration + if is_under { 88.5 } else { 0.0 }, "cell {cell}");
                let recession = recession.filter(|_| !is_under).map(|time| f64::from(time as f32));
                assert_eq!(seen.recession.is_nan(), recession.is_none(), "cell {cell}");
                assert_eq!(seen.recession.max(0.0), recession.unwrap_or(0.0), "cell {cell}");
            }
        }
        assert!((0..lattice.len()).any(|cell| maxima.seen(cell).hazard_class == 6));
    }
}
