//! Runs of columns in a row: what they hold, what they have in common, and joining them.

use crate::math::MOST_LANES;

/// Runs of dry cells up to this length inside a row stay active: longer loops beat fewer cells.
const BRIDGE: usize = MOST_LANES - 2;

/// A run of padded columns `from..to`.
pub(crate) type Run = std::ops::Range<usize>;

/// A run with a rim at its ends, within its row.
pub fn widened(run: &Run, rim: usize, columns: &Run) -> Run {
    run.start.saturating_sub(rim).max(columns.start)..(run.end + rim).min(columns.end)
}

/// The parts of a run that lie in some sorted runs.
pub fn within(runs: &[Run], run: Run) -> impl Iterator<Item = Run> {
    let first = runs.partition_point(|own| own.end <= run.start);
    let last = runs.partition_point(|own| own.start < run.end).max(first);
    runs[first..last].iter().map(move |own| own.start.max(run.start)..own.end.min(run.end))
}

/// Whether a column lies in one of some sorted runs.
pub fn holds(runs: &[Run], column: usize) -> bool {
    runs.get(runs.partition_point(|run| run.end <= column)).is_some_and(|run| run.start <= column)
}

/// Hands what sorted runs have in some columns over to others, in order.
pub fn hand_over(from: &mut Vec<Run>, to: &mut Vec<Run>, columns: &Run) {
    to.extend(within(from, columns.clone()));
    to.sort_unstable_by_key(|run| run.start);
    let left = from.iter().flat_map(|run| {
        let before = run.start..run.end.min(columns.start);
        let behind = run.start.max(columns.end)..run.end;
        [before, behind].into_iter().filter(|piece| !piece.is_empty())
    });
    *from = left.collect();
}

/// Sorts runs and joins those that nearly touch.
pub fn tidy(runs: &mut Vec<Run>) {
    runs.sort_unstable_by_key(|run| (run.start, run.end));
    join(runs);
}

/// The parts of some sorted runs that lie in none of others.
pub fn left<'a>(before: &'a [Run], now: &'a [Run]) -> impl Iterator<Item = Run> + 'a {
    before.iter().flat_map(move |run| {
        let first = now.partition_point(|now| now.end <= run.start);
        let ends = now[first..].iter().take_while(|now| now.start < run.end).cloned();
        let mut from = run.start;
        ends.chain(std::iter::once(run.end..run.end)).map(move |now| {
            let gap = from..now.start;
            from = now.end;
            gap
        })
    })
}

/// Joins sorted runs that overlap or lie at most [`BRIDGE`] cells apart, in place.
pub fn join(runs: &mut Vec<Run>) {
    let mut kept = 0;
    for next in 1..runs.len() {
        if runs[next].start <= runs[kept].end + BRIDGE {
            runs[kept].end = runs[kept].end.max(runs[next].end);
        } else {
            kept += 1;
            runs[kept] = runs[next].clone();
        }
    }
    runs.truncate((kept + 1).min(runs.len()));
}
