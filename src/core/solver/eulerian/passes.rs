//! Faces over a ridge that their two cells do not see: its pass sill (M10) is the bed at the face.
//!
//! ```text
//! (M25)  z* ← max(z*, P)                           after (M21)
//! (M26)  D η = max(η_j, P) − max(η_i, P)           in (M18) and (M19); no slope where both levels lie below P
//! (M27) F = ψ F(P) + (1 − ψ) F(P^c)               of a face in a gap: the rest stands as high as the crest, P^c in (M25)
//! ```
//!
//! Both sides see the same bed at the face. At rest a level below P leaves no depth there, and levels above it are equal: no term is
//! left, whatever stands on the two sides. Faces with a sill are few; they are computed anew after the ordinary ones.
//!
//! Where the bed of a cell moves, the sill goes with the lower of the two: a breach takes the ridge with the ground, and ground that
//! rises lifts it.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::faces::{EAST, Half, NORTH, Numbers, Side, Sill, over_sill, single};
use super::rows::other;
use super::spans::ActiveSet;
use super::state::{GroundRow, State, datum};
use super::walls::{Beside, NO_SILLS, SpecialCell, Walls, correct_gradients};
use super::{EulerianMethods, Scale};
use crate::bed::PassSill;
use crate::lattice::NEIGHBOURS;
use crate::math::larger;
use crate::solver::FlowProblem;

/// The faces with a sill, and the cells beside them, of every padded row.
#[derive(serde::Serialize, serde::Deserialize)]
pub(crate) struct Passes {
    faces: Vec<Vec<PassFace>>,
    cells: Vec<Vec<SpecialCell>>,
}

/// A face with a sill, in the row of its owner.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
struct PassFace {
    column: usize,
    direction: usize,
    /// Its level (m) now, and on the beds of the start.
    level: f64,
    /// The share of the face that has this level, and the level (m) of the rest above it.
    share: f64,
    crest: f64,
    level_at_start: f64,
    crest_at_start: f64,
    /// The beds (m) of the two cells at the start.
    beds: [f64; 2],
}

impl Passes {
    /// The sills of a problem.
    pub fn new(problem: &FlowProblem, state: &State, walls: &Walls) -> Self {
        let (lattice, datum) = (&problem.bed.lattice, datum(&problem.bed, &problem.initial_depth));
        let mut faces = vec![Vec::new(); state.rows + 2];
        let mut cells: Vec<BTreeMap<usize, Beside>> = vec![BTreeMap::new(); state.rows + 2];
        for sill in problem.bed.passes.iter() {
            let (column, row) = lattice.column_row(sill.cell);
            let place = (row + 1, column + 1);
            let direction = if sill.is_north { NORTH } else { EAST };
            // Where another level stands for one of the cells the face is a general one.
            if [place, other(place, direction)].iter().any(|&(row, column)| state.is_elsewhere(row, column)) {
                continue;
            }
            for (row, column) in [place, other(place, direction)] {
                cells[row].entry(column).or_insert_with(|| walls.beside(row, column));
            }
            faces[place.0].push(PassFace::new(sill, (place.1, direction), problem, datum));
        }
        faces.iter_mut().for_each(|row| row.sort_by_key(|face: &PassFace| face.column));
        let cell = |(column, beside)| SpecialCell { column, beside, sills: NO_SILLS };
        let cells = cells.into_iter().map(|row| row.into_iter().map(cell).collect()).collect();
        let mut passes = Passes { faces, cells };
        passes.follow(&state.ground);
        passes
    }

    /// Brings the sills to the bed of now.
    pub fn follow(&mut self, ground: &[GroundRow]) {
        for row in 0..self.faces.len() {
            for k in 0..self.faces[row].len() {
                let face = &mut self.faces[row][k];
                let here = (row, face.column);
                let there = other(here, face.direction);
                let rises = [here, there].map(|(row, column)| ground[row].bed[column]);
                let rise = (rises[0] - face.beds[0]).min(rises[1] - face.beds[1]);
                face.level = face.level_at_start + rise;
                face.crest = face.crest_at_start + rise;
                let (level, offset) = (face.level, if face.direction == EAST { (1, 0) } else { (0, 1) });
                self.set_beside(here, offset, level);
                self.set_beside(there, (-offset.0, -offset.1), level);
            }
        }
    }

    /// The padded places of cells beside sills.
    pub fn places(&self) -> Vec<(usize, usize)> {
        let cells = self.cells.iter().enumerate();
        cells.flat_map(|(row, cells)| cells.iter().map(move |cell| (row, cell.column))).collect()
    }

    /// The levels (m) of the sills on the ways from a padded cell to its neighbours.
    pub fn sills(&self, row: usize, column: usize) -> [f64; 4] {
        let found = self.cells[row].binary_search_by_key(&column, |cell| cell.column);
        found.map_or(NO_SILLS, |place| self.cells[row][place].sills)
    }

    /// Whether a gap leaves a part of the face open from a padded cell to its neighbour at an offset (column, row).
    pub fn is_part(&self, (row, column): (usize, usize), offset: (isize, isize)) -> bool {
        let (direction, owner) = match offset {
            (1, 0) => (EAST, (row, column)),
            (-1, 0) => (EAST, (row, column - 1)),
            (0, 1) => (NORTH, (row, column)),
            _ => (NORTH, (row - 1, column)),
        };
        let is_it = |face: &&PassFace| face.column == owner.1 && face.direction == direction;
        self.faces[owner.0].iter().find(is_it).is_some_and(|face| face.share < 1.0)
    }

    fn set_beside(&mut self, (row, column): (usize, usize), offset: (isize, isize), level: f64) {
        let found = self.cells[row].binary_search_by_key(&column, |cell| cell.column);
        let way = NEIGHBOURS.iter().position(|neighbour| *neighbour == offset);
        if let (Ok(place), Some(way)) = (found, way) {
            self.cells[row][place].sills[way] = level;
        }
    }

    /// Gradients of the cells beside sills, after those beside walls.
    pub fn correct_gradients(&self, state: &mut State, active: &ActiveSet, scale: &Scale) {
        correct_gradients(&self.cells, state, active, scale);
    }

    /// Fluxes of the faces with a sill.
    pub fn apply(&self, state: &mut State, active: &ActiveSet, scale: &Scale, methods: EulerianMethods) {
        let (primitive, gradient, ground, spacing) = (&state.primitive, &state.gradient, &state.ground, &state.spacing);
        let side = |row: usize| Side { water: &primitive[row], slope: &gradient[row], ground: &ground[row] };
        active.rows_of(&mut state.flux).for_each(|(row, flux)| {
            let numbers = Numbers::new(&scale.on(spacing[row]), methods);
            for face in active.among(row, &self.faces[row], |face| face.column) {
                let there = other((row, face.column), face.direction);
                // Between films nothing flows, whatever stands between them.
                let is_film = |(row, column): (usize, usize)| primitive[row].depth[column] <= scale.dry_depth;
                if is_film((row, face.column)) && is_film(there) {
                    continue;
                }
                let half = |(row, column): (usize, usize)| {
                    let half = Half::of_side(side(row), column, face.direction, spacing[row]);
                    // The sill is a step of the bed beside the particle.
                    Half { step: larger(half.step, face.level - half.z), ..half }
                };
                let (i, j) = (half((row, face.column)), half(there));
                let part = |level: f64| over_sill(i, j, Sill { level, lowest: face.level }, numbers, methods);
                let out = &mut flux[face.direction];
                let k = face.column;
                let open =
                    if face.level > f64::NEG_INFINITY { part(face.level) } else { single(i, j, numbers, methods) };
                let sum = if face.share < 1.0 {
                    let rest = part(face.crest);
                    let mean = |open: f64, rest: f64| face.share * open + (1.0 - face.share) * rest;
                    (mean(open.0, rest.0), mean(open.1, rest.1), mean(open.2, rest.2), mean(open.3, rest.3))
                } else {
                    open
                };
                (out.mass[k], out.tangential[k], out.normal_left[k], out.normal_right[k]) = sum;
            }
        });
    }
}

impl PassFace {
    fn new(sill: &PassSill, (column, direction): (usize, usize), problem: &FlowProblem, datum: f64) -> Self {
        let beds = [sill.cell, sill.other(&problem.bed.lattice)].map(|cell| problem.bed.elevation[cell] - datum);
        let level = sill.level - datum;
        let crest = sill.crest - datum;
        PassFace {
            column,
            direction,
            level,
            share: sill.share,
            crest,
            level_at_start: level,
            crest_at_start: crest,
            beds,
        }
    }
}

#[cfg(test)]
mod tests;
