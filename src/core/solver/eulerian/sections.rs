//! What passes cross-sections: the sum over the faces between cells on either side of a line, so that it is the very water that the
//! cells exchange.

use super::Scale;
use super::faces::{EAST, NORTH};
use super::state::State;
use crate::math::Vec2;
use crate::solver::{FlowProblem, SectionFlow};

/// A face that a section cuts: its row, column and direction, and how often it passes to the left of the line less to the right.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cut {
    row: usize,
    column: usize,
    direction: usize,
    sign: f64,
}

/// All sections of a problem, and what passed them.
pub(crate) struct Sections {
    cuts: Vec<Vec<Cut>>,
    flows: Vec<SectionFlow>,
    /// Volume of the step under way (m³).
    passed: Vec<f64>,
}

impl Sections {
    pub fn new(problem: &FlowProblem, state: &State) -> Self {
        let spacing = problem.bed.lattice.spacing;
        let cuts: Vec<Vec<Cut>> = problem.forcing.sections.iter().map(|line| cuts(line, state, spacing)).collect();
        let count = cuts.len();
        Sections { cuts, flows: vec![SectionFlow::default(); count], passed: vec![0.0; count] }
    }

    /// Adds half of a step of `time_step` (s) at the fluxes of now: each of its two stages carries so much.
    pub fn add(&mut self, state: &State, scale: &Scale, time_step: f64) {
        for (cuts, passed) in self.cuts.iter().zip(&mut self.passed) {
            let rate: f64 = cuts.iter().map(|c| c.sign * state.flux[c.row][c.direction].mass[c.column]).sum();
            *passed += 0.5 * time_step * scale.spacing * rate;
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
fn cuts(line: &[[Vec2; 2]], state: &State, spacing: f64) -> Vec<Cut> {
    let mut found = Vec::new();
    let low = |f: fn(&Vec2) -> f64| line.iter().flatten().map(f).fold(f64::INFINITY, f64::min);
    let high = |f: fn(&Vec2) -> f64| line.iter().flatten().map(f).fold(f64::NEG_INFINITY, f64::max);
    let padded = |value: f64, last: usize| ((value / spacing + 0.5).max(1.0) as usize).min(last);
    let rows = padded(low(|p| p.y) - spacing, state.rows)..=padded(high(|p| p.y) + spacing, state.rows);
    let columns = padded(low(|p| p.x) - spacing, state.columns)..=padded(high(|p| p.x) + spacing, state.columns);
    for row in rows {
        for column in columns.clone() {
            let from = State::position(row, column, spacing);
            for direction in [EAST, NORTH] {
                let turn = |p: Vec2| if direction == EAST { p - from } else { Vec2::new((p - from).y, -(p - from).x) };
                let sign: f64 = line.iter().map(|piece| passes(piece.map(turn), spacing)).sum();
                let other = if direction == EAST { (row, column + 1) } else { (row + 1, column) };
                if sign != 0.0 && state.has_terrain(row, column) && state.has_terrain(other.0, other.1) {
                    found.push(Cut { row, column, direction, sign });
                }
            }
        }
    }
    found
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
