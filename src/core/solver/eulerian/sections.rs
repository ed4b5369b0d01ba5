//! What passes cross-sections: the sum over the faces between cells on either side of a line, so that it is the very water that the
//! cells exchange.

use std::ops::Range;

use super::conforming::ConformingFaces;
use super::faces::{EAST, NORTH};
use super::general_faces::GeneralFaces;
use super::rows::other;
use super::state::State;
use crate::lattice::Level;
use crate::math::Vec2;
use crate::solver::{FlowProblem, SectionFlow};

/// A face that a section cuts: its row, column and direction, and how often it passes to the left of the line less to the right.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
struct Cut {
    row: usize,
    column: usize,
    direction: usize,
    sign: f64,
    /// Length of the face (m).
    width: f64,
}

/// All sections of a problem, and what passed them.
#[derive(serde::Serialize, serde::Deserialize)]
pub(crate) struct Sections {
    cuts: Vec<Vec<Cut>>,
    /// The general faces that each cuts, by number, and the same sign.
    general: Vec<Vec<(usize, f64)>>,
    /// The faces of cells that follow lines, in the same way.
    conforming: Vec<Vec<(usize, f64)>>,
    flows: Vec<SectionFlow>,
    /// Volume of the step under way (m³).
    passed: Vec<f64>,
}

impl Sections {
    pub fn new(problem: &FlowProblem, state: &State, (general, conforming): (&GeneralFaces, &ConformingFaces)) -> Self {
        let lattice = state.lattice();
        let of_line = |line: &Vec<[Vec2; 2]>| lattice.levels().flat_map(|level| cuts(line, state, level)).collect();
        let cuts: Vec<Vec<Cut>> = problem.forcing.sections.iter().map(of_line).collect();
        let of_general = |line: &Vec<[Vec2; 2]>| {
            let signs = general.places().map(|places| {
                let [from, to] = places.map(|(row, column)| state.position(row, column));
                (places.iter().all(|&(row, column)| state.has_terrain(row, column)), signed(line, from, to))
            });
            signs
                .enumerate()
                .filter(|(_, (is_face, sign))| *is_face && *sign != 0.0)
                .map(|(k, (_, sign))| (k, sign))
                .collect()
        };
        let general = problem.forcing.sections.iter().map(of_general).collect();
        let of_conforming = |line: &Vec<[Vec2; 2]>| {
            let sign = |places: Option<[(usize, usize); 2]>| {
                places.map_or(0.0, |places| {
                    let [from, to] = places.map(|(row, column)| state.position(row, column));
                    signed(line, from, to)
                })
            };
            let signs = conforming.places().map(sign).enumerate();
            signs.filter(|(_, sign)| *sign != 0.0).collect()
        };
        let conforming = problem.forcing.sections.iter().map(of_conforming).collect();
        let count = cuts.len();
        Sections { cuts, general, conforming, flows: vec![SectionFlow::default(); count], passed: vec![0.0; count] }
    }

    /// The padded places on both sides of faces that sections cut.
    pub fn places(&self) -> Vec<(usize, usize)> {
        let of_cut = |cut: &Cut| {
            let place = (cut.row, cut.column);
            [place, other(place, cut.direction)]
        };
        self.cuts.iter().flatten().flat_map(of_cut).collect()
    }

    /// Adds half of a step of `time_step` (s) at the fluxes of now: each of its two stages carries so much.
    pub fn add(
        &mut self,
        state: &State,
        (general, conforming): (&GeneralFaces, &ConformingFaces),
        levels: &Range<usize>,
        time_step: f64,
    ) {
        let rows = state.rows_of(levels);
        let special = self.general.iter().zip(&self.conforming);
        for ((cuts, (faces, own)), passed) in self.cuts.iter().zip(special).zip(&mut self.passed) {
            let through =
                |&(face, sign): &(usize, f64)| general.discharge(face, levels).map_or(0.0, |rate| sign * rate);
            let of_general: f64 = faces.iter().map(through).sum();
            let cuts = cuts.iter().filter(|cut| rows.contains(&cut.row));
            let rate: f64 = cuts.map(|c| c.width * c.sign * state.flux[c.row][c.direction].mass[c.column]).sum();
            let through_own = |&(face, sign): &(usize, f64)| sign * conforming.discharge(face);
            let of_own: f64 = if levels.start == 0 { own.iter().map(through_own).sum() } else { 0.0 };
            *passed += 0.5 * time_step * (rate + of_general + of_own);
        }
    }

    /// Closes a step (s).
    pub fn close(&mut self, time_step: f64) {
        for (passed, flow) in self.passed.iter_mut().zip(&mut self.flows) {
            flow.discharge = if time_step > 0.0 { *passed / time_step } else { 0.0 };
            flow.volume += *passed;
            *passed = 0.0;
        }
    }

    pub fn flows(&self) -> &[SectionFlow] {
        &self.flows
    }
}

/// The faces that a line cuts; a corner of the line on the way between two particles counts once.
fn cuts(line: &[[Vec2; 2]], state: &State, level: Level) -> Vec<Cut> {
    let spacing = level.spacing;
    let mut found = Vec::new();
    let low = |f: fn(&Vec2) -> f64| line.iter().flatten().map(f).fold(f64::INFINITY, f64::min);
    let high = |f: fn(&Vec2) -> f64| line.iter().flatten().map(f).fold(f64::NEG_INFINITY, f64::max);
    let padded = |value: f64, last: usize| ((value / spacing + 0.5).max(1.0) as usize).min(last);
    let rows = padded(low(|p| p.y) - spacing, level.rows)..=padded(high(|p| p.y) + spacing, level.rows);
    let columns = padded(low(|p| p.x) - spacing, level.columns)..=padded(high(|p| p.x) + spacing, level.columns);
    for row in rows.map(|row| level.first_row + row) {
        for column in columns.clone() {
            let from = state.position(row, column);
            for direction in [EAST, NORTH] {
                let way = if direction == EAST { Vec2::new(spacing, 0.0) } else { Vec2::new(0.0, spacing) };
                let sign = signed(line, from, from + way);
                let beyond = other((row, column), direction);
                if sign != 0.0 && state.has_terrain(row, column) && state.has_terrain(beyond.0, beyond.1) {
                    found.push(Cut { row, column, direction, sign, width: spacing });
                }
            }
        }
    }
    found
}

/// How often a way goes to the left of a line less how often to its right.
fn signed(line: &[[Vec2; 2]], from: Vec2, to: Vec2) -> f64 {
    let length = (to - from).norm();
    let along = (to - from) * (1.0 / length);
    let turn = |p: Vec2| Vec2::new((p - from).dot(along), (p - from).dot(Vec2::new(-along.y, along.x)));
    line.iter().map(|piece| passes(piece.map(turn), length)).sum()
}

/// Whether a piece crosses the way from the origin to (length, 0): 1 where that goes to the left of the piece, −1 to the right.
fn passes([a, b]: [Vec2; 2], length: f64) -> f64 {
    if (a.y >= 0.0) == (b.y >= 0.0) {
        return 0.0;
    }
    let x = a.x + (b.x - a.x) * (-a.y / (b.y - a.y));
    // A piece that goes down has the east to its left.
    if (0.0..length).contains(&x) { if b.y < a.y { 1.0 } else { -1.0 } } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_to_the_left_of_a_piece_counts_once() {
        let down = [Vec2::new(0.5, 1.0), Vec2::new(0.5, -1.0)];
        assert!((passes(down, 1.0) - 1.0).abs() < 1e-15);
        assert!((passes([down[1], down[0]], 1.0) + 1.0).abs() < 1e-15);
        assert!(passes(down, 0.4).abs() < 1e-15);
        // Two pieces that meet on the way.
        let corner = Vec2::new(0.5, 0.0);
        let both = passes([down[0], corner], 1.0) + passes([corner, down[1]], 1.0);
        assert!((both - 1.0).abs() < 1e-15);
    }
}
