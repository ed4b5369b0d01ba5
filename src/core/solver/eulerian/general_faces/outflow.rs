//! What cells beside general faces give at most.

use std::ops::Range;

use rayon::prelude::*;

use super::super::spans::ActiveSet;
use super::super::state::{State, sides};
use super::super::update::Stage;
use super::face::Face;
use super::in_rows::Cell;
use super::{AT_ONCE, GeneralFaces, Now};

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
        let mut is_changed = levels.end < self.of_level.len() && self.spare_coarse(levels.end - 1, state, whole);
        // What a cell gives is its own: the limit of one changes nothing for another. Dry cells give nothing.
        let is_short = |cell: &&Cell| {
            let (row, column) = cell.place;
            state.primitive[row].depth[column] > 0.0 && self.share(cell, state, levels, stage, time_step) < 1.0
        };
        let rows = active.at_hand().into_par_iter().with_min_len(active.rows_at_once());
        let of_row = |row: usize| active.among(row, self.cells.of_row(row), |cell| cell.place.1);
        let short: Vec<Cell> = rows.flat_map_iter(|row| of_row(row).filter(is_short).cloned()).collect();
        for cell in &short {
            let share = self.share(cell, state, levels, stage, time_step);
            self.limit_cell(cell, share, state, levels);
            is_changed = true;
        }
        if is_changed {
            self.put(state, active);
        }
    }

    /// Scales what the faces between a level and the next coarser one, whose cells step later, take from these to their parts of what the
    /// cells have, over a step (s) of the cells. Whether any takes more.
    fn spare_coarse(&mut self, level: usize, state: &State, whole: f64) -> bool {
        let all = self.of_level[level].clone();
        let spare = |((face, now), is_live): ((&Face, &mut Now), &bool)| {
            let outwards = if face.coarse == 0 { now.passing.mass } else { -now.passing.mass };
            if !is_live || outwards <= 0.0 {
                return false;
            }
            let (row, column) = face.places[face.coarse];
            let area = state.area((row, column));
            let held = state.water[row].depth[column].max(0.0) * area / face.of_coarse as f64;
            let wanted = outwards * face.length * whole;
            let is_short = wanted > held;
            if is_short {
                now.passing.reduce(held / wanted);
            }
            is_short
        };
        let faces = self.faces[all.clone()].par_iter().zip(self.now[all.clone()].par_iter_mut());
        let faces = faces.zip(self.is_live[all].par_iter()).with_min_len(AT_ONCE);
        faces.map(spare).reduce(|| false, |a, b| a || b)
    }

    /// The share of what a cell gives that it has in a stage of a step (s), 1 where it has it all; what it gave to a finer level before stays.
    fn share(&self, cell: &Cell, state: &State, levels: &Range<usize>, stage: Stage, time_step: f64) -> f64 {
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
        if free <= held { 1.0 } else { held / free }
    }

    /// Scales what a cell gives.
    fn limit_cell(&mut self, cell: &Cell, share: f64, state: &mut State, levels: &Range<usize>) {
        let sides = sides(cell.place);
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
    }
}
