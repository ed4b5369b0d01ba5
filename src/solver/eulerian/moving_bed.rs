//! The bed that moves as prescribed: at the start of a step it goes to the middle of the step, at its end to the end of it, and the
//! water on it keeps its depth and its velocity (M56), (M57).
//!
//! Its surface rises and falls with the bed: that is the wave. Volume is kept to the last bit, because no depth changes. The two
//! halves make the splitting of second order in time. The step lets a slide cross no more of a cell than a wave.

use super::Scale;
use super::state::{State, datum, step_of_bed};
use crate::boundary::BedMotion;
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::solver::{BedBooks, FlowProblem};

/// All parts of the bed that move.
pub(crate) struct MovingBed {
    motions: Vec<BedMotion>,
    /// For each motion the index of each of its cells in the lists below.
    places: Vec<Vec<usize>>,
    /// Padded place (row, column), centre (m) and bed at the start (m) of each cell.
    cells: Vec<((usize, usize), Vec2, f64)>,
    /// The bed (m) of the cells now.
    bed: Vec<(usize, f64)>,
    /// The bed (m) of the cells while it is found.
    next: Vec<f64>,
    datum: f64,
    area: f64,
    /// Volume (m³) by which the bed has lifted and lowered the water on it.
    lifted: f64,
    lowered: f64,
}

impl MovingBed {
    /// None where nothing moves.
    pub fn new(problem: &FlowProblem) -> Option<Self> {
        let (lattice, motions) = (&problem.bed.lattice, problem.forcing.moving_bed.clone());
        if motions.is_empty() {
            return None;
        }
        let mut union: Vec<usize> = motions.iter().flat_map(|motion| motion.cells.iter().map(|cell| cell.0)).collect();
        union.retain(|&cell| problem.bed.has_terrain(cell));
        union.sort_unstable();
        union.dedup();
        let place = |(cell, _): &(usize, f64)| union.binary_search(cell).unwrap_or(usize::MAX);
        let places = motions.iter().map(|motion| motion.cells.iter().map(place).collect()).collect();
        let cell = |cell: &usize| {
            let (column, row) = lattice.column_row(*cell);
            ((row + 1, column + 1), lattice.centre(*cell), problem.bed.elevation[*cell])
        };
        Some(MovingBed {
            places,
            cells: union.iter().map(cell).collect(),
            bed: union.iter().map(|&cell| (cell, problem.bed.elevation[cell])).collect(),
            next: vec![0.0; union.len()],
            datum: datum(&problem.bed, &problem.initial_depth),
            area: Lattice::cell_area(lattice),
            lifted: 0.0,
            lowered: 0.0,
            motions,
        })
    }

    /// Sets the bed of a time (s).
    pub fn follow(&mut self, state: &mut State, time: f64, dry_depth: f64) {
        for (next, (_, _, start)) in self.next.iter_mut().zip(&self.cells) {
            *next = *start;
        }
        for (motion, places) in self.motions.iter().zip(&self.places) {
            let progress = motion.progress(time);
            for (k, &place) in places.iter().enumerate() {
                if let Some(next) = self.next.get_mut(place) {
                    *next += motion.change(k, self.cells[place].1, progress);
                }
            }
        }
        let mut has_moved = false;
        for ((now, next), ((row, column), ..)) in self.bed.iter_mut().zip(&mut self.next).zip(&self.cells) {
            let rise = *next - now.1;
            if rise.abs() > 0.0 {
                now.1 = *next;
                state.ground[*row].bed[*column] = *next - self.datum;
                if state.water[*row].depth[*column] > dry_depth {
                    self.lifted += self.area * rise.max(0.0);
                    self.lowered -= self.area * rise.min(0.0);
                }
                has_moved = true;
            }
            // From here on the mark of a cell that moved.
            *next = rise;
        }
        if !has_moved {
            return;
        }
        let moved = self.next.iter().zip(&self.cells).filter(|(rise, _)| rise.abs() > 0.0);
        for (_, &((row, column), ..)) in moved {
            for (r, c) in [(row, column), (row, column - 1), (row, column + 1), (row - 1, column), (row + 1, column)] {
                let step = step_of_bed(&state.ground, r, c);
                state.ground[r].step[c] = step;
            }
        }
    }

    /// A step (s) from a time on, so short that a slide crosses no more of a cell than a wave may, and that it ends where a
    /// part of the bed begins to move.
    pub fn longest_step(&self, scale: &Scale, time: f64, step: f64) -> f64 {
        let mut longest = step;
        for motion in &self.motions {
            let speed = motion.fastest(time, time + longest);
            if speed * longest > scale.courant * scale.spacing {
                longest = scale.courant * scale.spacing / speed;
            }
            if motion.begin > time && motion.begin < time + longest {
                longest = motion.begin - time;
            }
        }
        longest
    }

    /// The cells whose bed may move, and their bed (m) now.
    pub fn bed(&self) -> &[(usize, f64)] {
        &self.bed
    }

    /// What the bed has moved so far.
    pub fn books(&self) -> BedBooks {
        let changes = || self.bed.iter().zip(&self.cells).map(|(now, cell)| self.area * (now.1 - cell.2));
        BedBooks {
            raised: changes().map(|volume| volume.max(0.0)).sum(),
            sunk: changes().map(|volume| (-volume).max(0.0)).sum(),
            lifted: self.lifted,
            lowered: self.lowered,
        }
    }
}

#[cfg(test)]
mod tests;
