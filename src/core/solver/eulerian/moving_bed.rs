//! The bed that moves as prescribed: at the start of a step it goes to the middle of the step, at its end to the end of it, and the
//! water on it keeps its depth and its velocity (M47), (M48).
//!
//! Its surface rises and falls with the bed: that is the wave. Volume is kept to the last bit, because no depth changes. The two
//! halves make the splitting of second order in time. The step lets a slide cross no more of a cell than a wave.

use super::Scale;
use super::state::{State, datum, step_of_bed};
use crate::solver::changing_bed::MovingGround;
use crate::solver::{BedBalance, FlowProblem};

/// All parts of the bed that move, on the padded lattice.
#[derive(serde::Serialize, serde::Deserialize)]
pub(crate) struct MovingBed {
    ground: MovingGround,
    /// Padded places (row, column) of the cells, in the order of their bed.
    places: Vec<(usize, usize)>,
    datum: f64,
}

impl MovingBed {
    /// None where nothing moves.
    pub fn new(problem: &FlowProblem) -> Option<Self> {
        let (lattice, ground) = (&problem.bed.lattice, MovingGround::new(problem)?);
        let padded = |(cell, _): &(usize, f64)| {
            let (column, row) = lattice.column_row(*cell);
            (row + 1, column + 1)
        };
        Some(MovingBed {
            places: ground.bed().iter().map(padded).collect(),
            datum: datum(&problem.bed, &problem.initial_depth),
            ground,
        })
    }

    /// Sets the bed of a time (s).
    pub fn follow(&mut self, state: &mut State, time: f64, dry_depth: f64) {
        if !self.ground.follow(time, time) {
            return;
        }
        let (mut lifted, mut lowered) = (0.0, 0.0);
        for (k, rise) in self.ground.rises() {
            let (row, column) = self.places[k];
            state.ground[row].bed[column] = self.ground.bed()[k].1 - self.datum;
            if state.water[row].depth[column] > dry_depth {
                let area = state.area((row, column));
                lifted += area * rise.max(0.0);
                lowered += area * rise.min(0.0);
            }
        }
        self.ground.book(lifted);
        self.ground.book(lowered);
        for (k, _) in self.ground.rises() {
            let (row, column) = self.places[k];
            for (r, c) in [(row, column), (row, column - 1), (row, column + 1), (row - 1, column), (row + 1, column)] {
                let step = step_of_bed(&state.ground, r, c);
                state.ground[r].step[c] = step;
            }
        }
    }

    /// A step (s) from a time on, so short that a slide crosses no more of a cell than a wave may, and that it ends where a
    /// part of the bed begins to move.
    pub fn longest_step(&self, scale: &Scale, time: f64, step: f64) -> f64 {
        self.ground.longest_step(scale.courant * scale.spacing, time, step)
    }

    /// The padded cells whose bed may move.
    pub fn places(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.places.iter().copied()
    }

    /// The cells whose bed may move, and their bed (m) now.
    pub fn bed(&self) -> &[(usize, f64)] {
        self.ground.bed()
    }

    /// What the bed has moved so far.
    pub fn balance(&self) -> BedBalance {
        self.ground.balance()
    }
}

#[cfg(test)]
mod tests;
