//! Which cells are active: wet ones and, of a rim of two cells around them, those that water can reach.
//!
//! Water can advance by one cell in each of the two stages of a step, so a rim of two is exact: nothing is cut off. What is higher than the water
//! [does not take part](taking_part). Cells that follow lines have no neighbours in the rows: their rim is what [`links`] join them to.
//! Columns and rows are padded ones (the lattice's plus one).

mod asleep;
mod links;
mod runs;
mod taking_part;
#[cfg(test)]
mod tests;

use rayon::prelude::*;

use super::state::{FluxRow, State};
use crate::lattice::Span;
use crate::math::{MOST_LANES, simd};
use asleep::Asleep;
use links::Links;
pub(crate) use runs::Run;
use runs::{holds, tidy, widened, within};
use taking_part::runs_of;

/// Width of the rim around wet cells.
const RIM: usize = 2;

/// Number of active cells from which it pays to share a loop over them: to wake another thread takes as long as some hundred cells.
const SHARED_CELLS: usize = 2048;

/// Rows that a thread takes at least of a loop that is shared.
const ROWS_OF_A_THREAD: usize = 4;

/// The same of the search for active cells, which is faster than other loops.
const ROWS_OF_A_SEARCH: usize = 16;

/// The runs of active cells, for every padded row.
#[derive(serde::Serialize, serde::Deserialize)]
pub(crate) struct ActiveSet {
    /// Of each padded row the rows and columns of its level; none of rows around and between levels.
    bounds: Vec<Option<[Run; 2]>>,
    /// The padded rows of cells that follow lines.
    apart: Run,
    /// The runs of each padded row that no other level stands for.
    own: Vec<Vec<Run>>,
    links: Links,
    asleep: Asleep,
    /// Whether blocks woke since that was last asked.
    has_woken: bool,
    at_hand: Run,
    cells_at_hand: usize,
    /// All runs that were active since the step of all levels began.
    recorded_runs: Vec<Vec<Run>>,
    wet: Vec<Vec<Run>>,
    /// Those of the step before, and the rows where they differ.
    wet_before: Vec<Vec<Run>>,
    changed: Vec<bool>,
    /// The rows of which it is to be found again what water reaches.
    is_stale: Vec<bool>,
    /// Runs that are active as if they were wet: water may come to them from elsewhere than their neighbours.
    fed: Vec<Vec<Run>>,
    /// Water with its rim.
    reached: Vec<Vec<Run>>,
    /// Of that the cells that are active, be they higher than the water: those which own faces that are no ordinary pairs, or get water over others.
    kept: Vec<Vec<Run>>,
    /// The active cells.
    pub work: Vec<Vec<Run>>,
    /// Those of the stage before.
    before: Vec<Vec<Run>>,
    /// All that were active in the last step of all levels, and what sleeps, as spans of the lattice: what a recorder has to look at.
    recorded: Vec<Span>,
    /// The runs of a row of it, where water sleeps there.
    with_asleep: Vec<Run>,
    /// Numbers that the processor takes at once.
    lanes: usize,
}

impl ActiveSet {
    /// The wet cells of a state, and `fed`, the runs of each padded row to which water comes from elsewhere. `linked` are the places (row,
    /// column) on the two sides of general faces: these join cells that are no neighbours in the rows. `kept` are those
    /// that own faces which are no ordinary pairs.
    pub fn new(
        state: &State,
        dry_depth: f64,
        fed: Vec<Vec<Run>>,
        linked: Vec<[(usize, usize); 2]>,
        kept: impl Iterator<Item = (usize, usize)>,
    ) -> Self {
        let kept = runs_of(kept.chain(linked.iter().flatten().copied()), &fed);
        let mut active = ActiveSet {
            bounds: (0..state.rows + 2).map(|row| state.bounds(row)).collect(),
            apart: state.rows_apart(),
            own: (0..state.rows + 2).map(|row| state.own_runs(row)).collect(),
            links: Links::new(&linked, state.rows + 2),
            asleep: Asleep::default(),
            has_woken: false,
            at_hand: 0..state.rows + 2,
            cells_at_hand: 0,
            recorded_runs: vec![Vec::new(); state.rows + 2],
            wet: vec![Vec::new(); state.rows + 2],
            wet_before: vec![Vec::new(); state.rows + 2],
            changed: vec![true; state.rows + 2],
            is_stale: vec![true; state.rows + 2],
            fed,
            kept,
            reached: vec![Vec::new(); state.rows + 2],
            work: vec![Vec::new(); state.rows + 2],
            before: vec![Vec::new(); state.rows + 2],
            recorded: Vec::new(),
            with_asleep: Vec::new(),
            lanes: if simd() == "avx512" { MOST_LANES } else { 4 },
        };
        // The first search looks at every cell, later ones only at those active.
        for row in 1..=state.rows {
            find_wet(&state.water[row].depth, 1..state.columns(row) + 1, dry_depth, &mut active.wet[row]);
        }
        active.spread();
        active.settle();
        active.work.clone_from(&active.reached);
        active.take_in_hand(0..state.rows + 2);
        active.take_for_record();
        active.end_record();
        active
    }

    /// The runs of a padded row for loops on lanes: the active ones, each with as many of the cells behind it as make up whole pieces, up to water
    /// that sleeps. Those take no part, so that nothing changes in them; they end before the next run begins.
    pub fn whole_pieces(&self, row: usize) -> impl Iterator<Item = Run> + '_ {
        let asleep = self.asleep.in_row(row);
        self.work[row].iter().map(move |run| {
            let end = run.start + run.len().next_multiple_of(self.lanes);
            let next = asleep.get(asleep.partition_point(|other| other.start < run.end));
            run.start..next.map_or(end, |next| end.min(next.start))
        })
    }

    /// Of things of a padded row, in ascending order of their columns, those in the work.
    pub fn among<'a, T>(
        &'a self,
        row: usize,
        all: &'a [T],
        column: impl Fn(&T) -> usize + Copy,
    ) -> impl Iterator<Item = &'a T> {
        self.work[row].iter().flat_map(move |run| {
            let first = all.partition_point(|thing| column(thing) < run.start);
            let of_run = &all[first..];
            &of_run[..of_run.partition_point(|thing| column(thing) < run.end)]
        })
    }

    /// Whether blocks woke since that was last asked.
    pub fn has_woken(&mut self) -> bool {
        std::mem::take(&mut self.has_woken)
    }

    /// Whether a padded cell is in a block that sleeps.
    pub fn is_asleep(&self, row: usize, column: usize) -> bool {
        holds(self.asleep.in_row(row), column)
    }

    /// Keeps what passes faces beside water that sleeps.
    pub fn hold(&self, flux: &mut [FluxRow]) {
        self.asleep.hold(flux, &self.at_hand);
    }

    /// The same of a row whose cells are each other's neighbours; none of cells that follow lines.
    pub fn pieces_of_squares(&self, row: usize) -> impl Iterator<Item = Run> + '_ {
        (!self.apart.contains(&row)).then(|| self.whole_pieces(row)).into_iter().flatten()
    }

    /// Rows that a thread takes at least in a loop over the active cells: all of them where the cells are few.
    pub fn rows_at_once(&self) -> usize {
        if self.cells_at_hand < SHARED_CELLS { usize::MAX } else { ROWS_OF_A_THREAD }
    }

    /// Of some quantity of all rows that of the rows at hand, with their numbers, for a loop that threads share.
    pub fn rows_of<'a, Row: Send>(
        &self,
        all: &'a mut [Row],
    ) -> impl IndexedParallelIterator<Item = (usize, &'a mut Row)> + use<'a, Row> {
        let first = self.at_hand.start;
        let rows = all[self.at_hand.clone()].par_iter_mut().enumerate().with_min_len(self.rows_at_once());
        rows.map(move |(k, row)| (first + k, row))
    }

    /// The rows at hand: all, or those of the levels that take a step.
    pub fn at_hand(&self) -> Run {
        self.at_hand.clone()
    }

    /// Cells whose water moves.
    pub fn wet_cells(&self) -> usize {
        self.wet.iter().flatten().map(|run| run.len()).sum::<usize>() + self.asleep.wet_cells()
    }

    /// Lets water at rest sleep that nothing reaches; `restless` are places (row, column) where something happens by itself, beside those that
    /// are fed.
    pub fn put_to_sleep(&mut self, state: &State, restless: impl Iterator<Item = (usize, usize)>) {
        let ActiveSet { own, wet, fed, links, .. } = self;
        let fed = fed.iter().enumerate().flat_map(|(row, runs)| runs.iter().cloned().flatten().map(move |c| (row, c)));
        self.asleep = Asleep::new(state, (own, wet), fed.chain(restless), links.places());
        if !self.asleep.is_empty() {
            self.changed.fill(true);
            self.spread();
            self.settle();
            for (work, own) in self.work.iter_mut().zip(&self.own) {
                *work = own.iter().flat_map(|own| within(work, own.clone())).collect();
            }
            self.take_in_hand(self.at_hand.clone());
        }
    }

    /// The spans that a recorder has to look at after a step.
    pub fn recorded(&self) -> &[Span] {
        &self.recorded
    }

    /// Takes cells as water, with a rim about them.
    pub fn reach(&mut self, places: impl Iterator<Item = (usize, usize)>) {
        let ActiveSet { wet, reached, bounds, own, is_stale, apart, .. } = self;
        // A wet cell has its rim.
        for (row, column) in places.filter(|&(row, column)| !holds(&wet[row], column)) {
            let Some([rows, columns]) = &bounds[row] else { continue };
            let (rim, around) = rim_of(row, rows, apart);
            is_stale[around.clone()].fill(true);
            let run = widened(&(column..column + 1), rim, columns);
            let rows = reached[around.clone()].iter_mut().zip(&own[around]);
            rows.for_each(|(reached, own)| reached.extend(within(own, run.clone())));
        }
        for (reached, _) in reached.iter_mut().zip(is_stale).filter(|(_, is_stale)| **is_stale) {
            tidy(reached);
        }
    }

    /// Takes some rows in hand: those of the levels that take a step.
    pub fn take_in_hand(&mut self, rows: Run) {
        self.at_hand = rows;
        let cells = |runs: &Vec<Run>| runs.iter().map(|run| run.len()).sum::<usize>();
        self.cells_at_hand = self.work[self.at_hand.clone()].iter().map(cells).sum();
    }

    /// Cells active in the rows at hand.
    pub fn cells_at_hand(&self) -> usize {
        self.cells_at_hand
    }

    /// Follows the water of the rows at hand after a step.
    pub fn follow(&mut self, state: &State, dry_depth: f64) {
        self.find_wet(state, dry_depth);
        if !self.asleep.is_empty() {
            let rows = self.asleep.wake(state, &self.at_hand, (&mut self.own, &mut self.wet));
            self.has_woken |= !rows.is_empty();
            for row in rows {
                self.changed[row] = true;
                self.work[row].extend_from_slice(&self.wet[row]);
                tidy(&mut self.work[row]);
                self.recorded_runs[row].extend_from_slice(&self.work[row]);
            }
        }
        self.spread();
        self.settle();
        self.take_in_hand(self.at_hand.clone());
    }

    /// Finds the wet cells of the rows at hand, among those in the work, and the rows where they changed.
    fn find_wet(&mut self, state: &State, dry_depth: f64) {
        let (first, rows) = (self.at_hand.start, self.rows_at_once().max(ROWS_OF_A_SEARCH));
        let (water, work) = (&state.water, &self.work);
        let wet = self.wet[self.at_hand.clone()].par_iter_mut();
        let before = self.wet_before[self.at_hand.clone()].par_iter_mut();
        let changed = self.changed[self.at_hand.clone()].par_iter_mut();
        wet.zip(before).zip(changed).enumerate().with_min_len(rows).for_each(|(k, ((wet, before), changed))| {
            let row = first + k;
            std::mem::swap(wet, before);
            wet.clear();
            for run in &work[row] {
                find_wet(&water[row].depth, run.clone(), dry_depth, wet);
            }
            *changed = wet != before;
        });
    }

    /// Takes the active cells of the rows at hand for those that a recorder has to look at after the step of all levels.
    fn take_for_record(&mut self) {
        for row in self.at_hand.clone() {
            let (runs, work) = (&mut self.recorded_runs[row], &self.work[row]);
            if !runs.ends_with(work) {
                runs.extend_from_slice(work);
            }
        }
    }

    /// Ends a step of all levels: what was active in it is to be looked at.
    pub fn end_record(&mut self) {
        self.recorded_runs.iter_mut().for_each(tidy);
        record(&self.recorded_runs, &self.asleep, (&mut self.recorded, &mut self.with_asleep));
        self.recorded_runs.iter_mut().for_each(Vec::clear);
    }

    /// What water reaches in a row: wet runs of the rows within the rim, widened by the rim, joined where they nearly touch; and what general faces
    /// link to it. It is found again where any of that changed.
    fn spread(&mut self) {
        self.links.follow(&self.wet, &self.changed, &self.apart, &mut self.is_stale);
        let at_once = self.rows_at_once().max(ROWS_OF_A_SEARCH);
        let ActiveSet { wet, fed, bounds, apart, own, links, changed, reached, is_stale, .. } = self;
        let (wet, changed) = (&*wet, &*changed);
        let rows = reached.par_iter_mut().zip(is_stale).enumerate().with_min_len(at_once);
        rows.for_each(|(row, (reached, is_stale))| {
            let Some([rows, columns]) = &bounds[row] else { return };
            let (rim, around) = rim_of(row, rows, apart);
            *is_stale |= changed[around.clone()].contains(&true);
            if !*is_stale {
                return;
            }
            reached.clear();
            let mut take = |run: &Run| reached.extend(within(&own[row], widened(run, rim, columns)));
            wet[around.clone()].iter().chain(&fed[around.clone()]).flatten().for_each(&mut take);
            around.flat_map(|row| links.reached(row)).for_each(|column| take(&(column..column + 1)));
            tidy(reached);
        });
    }

    /// No row is left to be looked at.
    fn settle(&mut self) {
        self.changed.fill(false);
        self.is_stale.fill(false);
    }
}

/// The runs of padded rows, and those that sleep, as spans of the lattice.
fn record(rows: &[Vec<Run>], asleep: &Asleep, (spans, all): (&mut Vec<Span>, &mut Vec<Run>)) {
    spans.clear();
    for (row, runs) in rows.iter().enumerate() {
        let resting = asleep.wet_in_row(row);
        let runs = if resting.is_empty() {
            runs
        } else {
            all.clear();
            all.extend(runs.iter().chain(resting).cloned());
            tidy(all);
            &*all
        };
        let of_row = runs.iter().map(|run| Span {
            row: (row - 1) as u32,
            from: (run.start - 1) as u32,
            to: (run.end - 1) as u32,
        });
        spans.extend(of_row);
    }
}

/// How wide the rim in a row is, and the rows in it among those of its level; none about cells that follow lines.
fn rim_of(row: usize, rows: &Run, apart: &Run) -> (usize, Run) {
    let rim = if apart.contains(&row) { 0 } else { RIM };
    (rim, row.saturating_sub(rim).max(rows.start)..(row + rim + 1).min(rows.end))
}

/// Deeper than the dry depth, or no number: that must stay active until the watch sees it.
fn is_water(depth: f64, dry_depth: f64) -> bool {
    depth > dry_depth || depth.is_nan()
}

/// Appends the runs of cells deeper than the dry depth.
fn find_wet(depth: &[f64], within: Run, dry_depth: f64, wet: &mut Vec<Run>) {
    let mut column = within.start;
    while column < within.end {
        if is_water(depth[column], dry_depth) {
            let start = column;
            while column < within.end && is_water(depth[column], dry_depth) {
                column += 1;
            }
            wet.push(start..column);
        } else {
            column += 1;
        }
    }
}
