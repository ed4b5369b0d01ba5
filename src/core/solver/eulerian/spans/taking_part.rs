//! Which cells within the rim of the water take part in a stage: the rim alone is wide where water lies between banks.
//!
//! A cell that is dry, or holds a film, and stands no lower than the level of any water beside it gets nothing and gives nothing. The depth over
//! the higher bed (M21) and the slope of the surface towards it, by the dry rule of (M18), are 0; a film gives nothing, and does not mix (M32). So
//! such cells are left out at the ends of runs, and no bit of the water changes by that.

use rayon::prelude::*;

use super::super::state::State;
use super::super::update::Stage;
use super::runs::{Run, holds, left};
use super::{ActiveSet, ROWS_OF_A_SEARCH, is_water};

impl ActiveSet {
    /// Chooses the cells of the rows at hand for a stage. Those of the first stage stay in the second; those that a step does not need any more
    /// are brought to rest.
    pub fn choose(&mut self, state: &mut State, stage: Stage, dry_depth: f64) {
        let rows = self.at_hand.clone();
        let at_once = self.rows_at_once().max(ROWS_OF_A_SEARCH);
        let known = &*state;
        let (reached, kept, apart) = (&self.reached[rows.clone()], &self.kept[rows.clone()], &self.apart);
        let work = self.work[rows.clone()].par_iter_mut().zip(&mut self.before[rows.clone()]);
        let chosen = work.zip(reached).zip(kept).enumerate().with_min_len(at_once);
        chosen.for_each(|(k, (((work, before), reached), kept))| {
            let row = rows.start + k;
            std::mem::swap(work, before);
            work.clear();
            if reached.is_empty() {
                return;
            }
            if apart.contains(&row) {
                work.extend_from_slice(reached);
                return;
            }
            let about = About::new(known, row, dry_depth);
            let takes_part = |&column: &usize| about.may_change(column) || holds(kept, column);
            let mut of_first = if stage == Stage::First { [].iter() } else { before.iter() }.peekable();
            for run in reached {
                // What is active of it already; nothing is from its end to its start.
                let active = of_first.next_if(|active| active.start < run.end).cloned().unwrap_or(run.end..run.start);
                let first = (run.start..active.start).find(takes_part).unwrap_or(active.start);
                let last = (active.end.max(first)..run.end).rfind(takes_part).map_or(active.end, |last| last + 1);
                if first < run.end {
                    work.push(first..last.max(first + 1));
                }
            }
        });
        if stage == Stage::First {
            for row in rows.clone().filter(|&row| self.before[row] != self.work[row]) {
                left(&self.before[row], &self.work[row]).flatten().for_each(|column| state.rest(row, column));
            }
        }
        self.take_in_hand(rows);
        if stage == Stage::Second {
            self.take_for_record();
        }
    }
}

/// Depths and beds (m) of a padded row and of those beside it.
struct About<'a> {
    /// Of the row, of that to the south and of that to the north.
    depth: [&'a [f64]; 3],
    bed: [&'a [f64]; 3],
    dry_depth: f64,
}

impl<'a> About<'a> {
    fn new(state: &'a State, row: usize, dry_depth: f64) -> Self {
        let rows = [row, row.saturating_sub(1), row + 1];
        let depth = rows.map(|row| state.primitive.get(row).map_or(&[][..], |water| &water.depth));
        let bed = rows.map(|row| state.ground.get(row).map_or(&[][..], |ground| &ground.bed));
        About { depth, bed, dry_depth }
    }

    /// Whether a cell holds water, or water may come to it in a stage.
    fn may_change(&self, column: usize) -> bool {
        let [own, south, north] = self.depth;
        let [own_bed, south_bed, north_bed] = self.bed;
        let film = own[column];
        if is_water(film, self.dry_depth) {
            return true;
        }
        // Less the film, which may round the bed at the face down.
        let bed = own_bed[column] - film;
        // Rows beside a level may be shorter.
        let is_higher = |depth: &[f64], beds: &[f64], column: usize| {
            depth.get(column).is_some_and(|&depth| is_water(depth, self.dry_depth) && beds[column] + depth > bed)
        };
        is_higher(own, own_bed, column.wrapping_sub(1))
            || is_higher(own, own_bed, column + 1)
            || is_higher(south, south_bed, column)
            || is_higher(north, north_bed, column)
    }
}

/// The runs of some padded places (row, column), with some that each row has already.
pub(super) fn runs_of(places: impl Iterator<Item = (usize, usize)>, others: &[Vec<Run>]) -> Vec<Vec<Run>> {
    let mut rows = others.to_vec();
    places.for_each(|(row, column)| rows[row].push(column..column + 1));
    for runs in &mut rows {
        runs.sort_unstable_by_key(|run| (run.start, run.end));
        runs.dedup_by(|next, run| {
            let touches = next.start <= run.end;
            run.end = if touches { run.end.max(next.end) } else { run.end };
            touches
        });
    }
    rows
}

#[cfg(test)]
mod tests;
