//! What cells beside general faces give at most.

use std::ops::Range;

use super::super::spans::ActiveSet;
use super::super::state::{State, sides};
use super::super::update::Stage;
use super::GeneralFaces;

impl GeneralFaces {
    /// Scales the outflow of cells beside general faces that would give more water than they have in this stage of a step (s). Of coarse
    /// cells that step later, in a step of `whole` (s), no face takes more than its part.
    pub fn limit_outflow(
        &mut self,
        state: &mut State,
        (active, levels): (&ActiveSet, &Range<usize>),
        stage: Stage,
        (time_step, whole): (f64, f64),
    ) {
        let mut is_changed = false;
        if levels.end < self.of_level.len() {
            for number in 0..self.live[levels.end - 1].len() {
                is_changed |= self.spare_coarse(self.live[levels.end - 1][number], state, whole);
            }
        }
        let cells = active.at_hand();
        let cells = self.of_row[cells.start].start..self.of_row[cells.end - 1].end;
        for number in cells {
            let (row, column) = self.cells[number].place;
            // Dry cells give nothing.
            if state.primitive[row].depth[column] > 0.0 {
                is_changed |= self.limit_cell(number, state, levels, stage, time_step);
            }
        }
        if is_changed {
            self.put(state, levels);
        }
    }

    /// Scales what a face takes from a coarse cell that steps later to its part of what the cell has, over a step (s) of the cell.
    fn spare_coarse(&mut self, k: usize, state: &State, whole: f64) -> bool {
        let face = &self.faces[k];
        let (row, column) = face.places[face.coarse];
        let outwards = if face.coarse == 0 { self.now[k].passing.mass } else { -self.now[k].passing.mass };
        let area = state.spacing[row] * state.spacing[row] / state.ground[row].per_area[column];
        let held = state.water[row].depth[column].max(0.0) * area / face.of_coarse as f64;
        let wanted = outwards * face.length * whole;
        let is_short = outwards > 0.0 && wanted > held;
        if is_short {
            self.now[k].passing.reduce(held / wanted);
        }
        is_short
    }

    /// Scales what a cell gives, where that is more than it has; what it gave to a finer level before stays.
    fn limit_cell(
        &mut self,
        number: usize,
        state: &mut State,
        levels: &Range<usize>,
        stage: Stage,
        time_step: f64,
    ) -> bool {
        let cell = &self.cells[number];
        let (row, column) = cell.place;
        let depth = match stage {
            Stage::First => state.water[row].depth[column],
            Stage::Second => state.primitive[row].depth[column],
        };
        let sides = sides(cell.place);
        // What leaves over a side: what may be scaled, and what may not.
        let leaving = |side: usize| -> [f64; 2] {
            let (slot, sign) = sides[side];
            let Some(&first) = cell.faces[side].first() else {
                return [(sign * state.flux[slot.row][slot.direction].mass[slot.column]).max(0.0), 0.0];
            };
            let of_face =
                |&face: &usize| self.faces[face].share(side % 2) * (sign * self.now[face].passing.mass).max(0.0);
            let sum = cell.faces[side].iter().map(of_face).sum();
            if self.faces[first].level < levels.start { [0.0, sum] } else { [sum, 0.0] }
        };
        let [east, west, north, south] = [0, 1, 2, 3].map(leaving);
        let sum = |kind: usize| (east[kind] + west[kind]) + (north[kind] + south[kind]);
        let per_rate = time_step / state.spacing[row] * state.ground[row].per_area[column];
        let (free, fixed) = (per_rate * sum(0), per_rate * sum(1));
        let held = (depth - fixed).max(0.0);
        if free <= held {
            return false;
        }
        let share = held / free;
        for (side, faces) in cell.faces.iter().enumerate() {
            if faces.is_empty() {
                state.reduce(sides[side], share);
            }
            for &face in faces.iter().filter(|&&face| self.faces[face].level >= levels.start) {
                let passing = &mut self.now[face].passing;
                if sides[side].1 * passing.mass > 0.0 {
                    passing.reduce(share);
                }
            }
        }
        true
    }
}
