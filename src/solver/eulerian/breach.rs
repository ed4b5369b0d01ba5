//! The bed of a dam that breaks: it falls between two steps, and the water on it keeps its depth and its momentum (M46).
//!
//! Volume is kept to the last bit, because no depth changes; what the water loses is the height through which it falls.

use super::state::{State, datum, step_of_bed};
use crate::boundary::{Breach, Trigger};
use crate::solver::FlowProblem;

/// Share of a time by which rounding may miss it.
const ROUND_OFF: f64 = 1e-12;

/// The dam of a problem and how far it has gone.
pub(crate) struct Breaking {
    breach: Breach,
    /// Padded cells (row, column) of the dam, in the order of the breach.
    places: Vec<(usize, usize)>,
    /// Where the level is watched.
    watched: Option<(usize, usize)>,
    /// The time (s) at which the breach began.
    opened: Option<f64>,
    /// The share of the growth that the bed shows.
    share: f64,
    datum: f64,
    /// The bed (m) of the cells of the dam now.
    bed: Vec<(usize, f64)>,
}

impl Breaking {
    pub fn new(problem: &FlowProblem) -> Option<Self> {
        let lattice = &problem.bed.lattice;
        let breach = problem.forcing.breach.clone()?;
        let padded = |cell: usize| {
            let (column, row) = lattice.column_row(cell);
            (row + 1, column + 1)
        };
        let watched = match breach.trigger {
            Trigger::At(_) => None,
            Trigger::Level { place, .. } => lattice.cell_at(place).map(padded),
        };
        Some(Breaking {
            places: breach.cells.iter().map(|cell| padded(cell.cell)).collect(),
            watched,
            opened: None,
            share: 0.0,
            datum: datum(&problem.bed, &problem.initial_depth),
            bed: breach.cells.iter().map(|cell| (cell.cell, breach.bed(cell, 0.0))).collect(),
            breach,
        })
    }

    /// Sets the bed of a time (s).
    pub fn follow(&mut self, state: &mut State, time: f64, dry_depth: f64) {
        if self.opened.is_none() {
            self.opened = match self.breach.trigger {
                Trigger::At(at) => (time >= at * (1.0 - ROUND_OFF)).then_some(at),
                Trigger::Level { level, .. } => self.watched.and_then(|(row, column)| {
                    let depth = state.water[row].depth[column];
                    let surface = self.datum + state.ground[row].bed[column] + depth;
                    (depth > dry_depth && surface >= level).then_some(time)
                }),
            };
        }
        let Some(opened) = self.opened else { return };
        // A time that rounding leaves a little before the trigger counts as the trigger.
        let share = self.breach.share((time - opened).max(0.0));
        if share <= self.share {
            return;
        }
        self.share = share;
        for ((cell, bed), &(row, column)) in self.breach.cells.iter().zip(&mut self.bed).zip(&self.places) {
            bed.1 = self.breach.bed(cell, share);
            state.ground[row].bed[column] = bed.1 - self.datum;
        }
        for &(row, column) in &self.places {
            for (r, c) in [(row, column), (row, column - 1), (row, column + 1), (row - 1, column), (row + 1, column)] {
                let step = step_of_bed(&state.ground, r, c);
                state.ground[r].step[c] = step;
            }
        }
    }

    /// A step (s) from a time on, shortened so that it ends where the breach begins.
    pub fn step_until_trigger(&self, time: f64, step: f64) -> f64 {
        match (self.opened, self.breach.trigger) {
            (None, Trigger::At(at)) if at > time && at < time + step => at - time,
            _ => step,
        }
    }

    /// The cells of the dam and their bed (m) now.
    pub fn bed(&self) -> &[(usize, f64)] {
        &self.bed
    }

    /// The time (s) at which the breach began.
    pub fn opened(&self) -> Option<f64> {
        self.opened
    }
}

#[cfg(test)]
mod tests;
