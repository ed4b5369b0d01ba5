//! The bed of a dam that breaks: it falls between two steps, and the water on it keeps its depth and its momentum (M46).
//!
//! Volume is kept to the last bit, because no depth changes; what the water loses is the height through which it falls.

use super::state::{State, datum, step_of_bed};
use crate::solver::FlowProblem;
use crate::solver::changing_bed::BreakingDam;

/// The dam of a problem on the padded lattice.
#[derive(serde::Serialize, serde::Deserialize)]
pub(crate) struct Breaking {
    dam: BreakingDam,
    /// Padded cells (row, column) of the dam, in the order of its bed.
    places: Vec<(usize, usize)>,
    /// Where the level is watched.
    watched: Option<(usize, usize)>,
    datum: f64,
}

impl Breaking {
    pub fn new(problem: &FlowProblem) -> Option<Self> {
        let lattice = &problem.bed.lattice;
        let dam = BreakingDam::new(problem)?;
        let padded = |cell: usize| {
            let (column, row) = lattice.column_row(cell);
            (row + 1, column + 1)
        };
        Some(Breaking {
            places: dam.bed().iter().map(|(cell, _)| padded(*cell)).collect(),
            watched: dam.watched().and_then(|place| lattice.cell_at(place)).map(padded),
            datum: datum(&problem.bed, &problem.initial_depth),
            dam,
        })
    }

    /// Sets the bed of a time (s).
    pub fn follow(&mut self, state: &mut State, time: f64, dry_depth: f64) {
        let level = |(row, column): (usize, usize)| {
            let depth = state.water[row].depth[column];
            (depth > dry_depth).then(|| self.datum + state.ground[row].bed[column] + depth)
        };
        self.dam.watch(time, |_| self.watched.and_then(level));
        if !self.dam.follow(time) {
            return;
        }
        for ((_, bed), &(row, column)) in self.dam.bed().iter().zip(&self.places) {
            state.ground[row].bed[column] = bed - self.datum;
        }
        for &(row, column) in &self.places {
            for (r, c) in [(row, column), (row, column - 1), (row, column + 1), (row - 1, column), (row + 1, column)] {
                let step = step_of_bed(&state.ground, r, c);
                state.ground[r].step[c] = step;
            }
        }
    }

    /// A step (s) from a time on, shortened so that it ends where the breach begins or has grown.
    pub fn step_until_change(&self, time: f64, step: f64) -> f64 {
        self.dam.step_until_change(time, step)
    }

    /// The padded cell (row, column) whose level opens the dam, where one does.
    pub fn watched(&self) -> Option<(usize, usize)> {
        self.watched
    }

    /// The padded cells (row, column) whose bed changes.
    pub fn places(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.places.iter().copied()
    }

    /// The cells of the dam and their bed (m) now.
    pub fn bed(&self) -> &[(usize, f64)] {
        self.dam.bed()
    }

    /// The time (s) at which the breach began.
    pub fn opened(&self) -> Option<f64> {
        self.dam.opened()
    }
}

#[cfg(test)]
mod tests;
