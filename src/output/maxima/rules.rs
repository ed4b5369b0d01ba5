//! What one step does to the records of a row, on lanes of the processor.

use super::arrival_depth;
use super::record::{Block, BlockOfWater, LANES, Moment, ShortMoment, ThresholdRecord};
use crate::lattice::{Span, WaterInRow};
use crate::math::larger;
use crate::output::WET_DEPTH;
use crate::output::hazard::greater_class;

/// What one step does to a cell.
pub(super) struct Rules<'a> {
    pub(super) before: f64,
    pub(super) after: f64,
    pub(super) thresholds: &'a [f64],
    pub(super) rise_on_wet: f64,
}

impl Rules<'_> {
    /// Time at which the depth passes `depth` between two steps; the caller knows that it does.
    #[inline]
    fn crossing(&self, depth: f64, depth_before: f64, depth_after: f64) -> f64 {
        let share = (depth - depth_before) / (depth_after - depth_before);
        self.before + (self.after - self.before) * share
    }

    /// Takes the water of a row within its spans.
    pub(super) fn follow_row(&self, row: &WaterInRow<'_>, spans: &[Span], mut records: RowOfRecords<'_>) {
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
pub(super) struct RowOfRecords<'a> {
    pub(super) previous: &'a mut [BlockOfWater],
    pub(super) blocks: &'a mut [Block],
    pub(super) crossings: &'a mut [ThresholdRecord],
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
