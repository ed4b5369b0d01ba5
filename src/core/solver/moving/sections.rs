//! What passes cross-sections among moving particles.
//!
//! A particle whose way in a step crosses a line passes it with all of its volume, to the left of the line or to the right. Particles
//! would come in jumps so; but each is spread as on the grid, and stands on both sides while it passes:
//!
//! ```text
//! (M73)  Ω = Σ ± V_j over all ways across the line + Σ_j V_j [I(ρ_j/√A_j) − H(ρ_j)]
//! ```
//!
//! with ρ the distance from the line, positive to its left, I the integral of the cubic spline that ends at ±2, and H the step from 0 to 1 at
//! 0. Ω grows evenly while particles pass, and the second sum does not pile up: it has only those that stand near the line. The discharge of
//! a step is the growth of Ω in it by motion alone; what comes from above or out of the ground passes no line. Nothing is reported before the
//! first particle reaches the line with its own edge.

use rayon::prelude::*;

use super::CHUNK;
use crate::math::Vec2;
use crate::particles::FluidParticles;
use crate::physics::dimension::Dimension;
use crate::solver::{FlowProblem, SectionFlow};

/// One section.
#[derive(Clone, Debug)]
struct Line {
    /// Its straight pieces, one after the other (m).
    pieces: Vec<[Vec2; 2]>,
    /// The corners of the rectangle around it (m).
    low: Vec2,
    high: Vec2,
    /// Whether it goes on straight beyond its first and last place: where these lie off the terrain.
    goes_on: [bool; 2],
}

/// All sections of a problem, and what passed them.
#[derive(Clone, Debug)]
pub(super) struct Sections {
    lines: Vec<Line>,
    dimension: Dimension,
    flows: Vec<SectionFlow>,
    /// P (m³) of each section, and whether water has reached it.
    passed: Vec<(f64, bool)>,
    /// Where the particles stood at the beginning of the step (m).
    starts: Vec<Vec2>,
    /// Of each section, the second sum of (M73) at the beginning of the step (m³).
    straddled: Vec<f64>,
    /// Of each section, the volume of the ways across it in the step (m³).
    crossed: Vec<f64>,
}

impl Sections {
    pub fn new(problem: &FlowProblem, dimension: Dimension) -> Self {
        let is_off = |place: Vec2| problem.bed.at(place).is_none();
        let lines: Vec<Line> = problem.forcing.sections.iter().map(|pieces| Line::new(pieces, is_off)).collect();
        let count = lines.len();
        Sections {
            lines,
            dimension,
            flows: vec![SectionFlow::default(); count],
            passed: vec![(0.0, false); count],
            starts: Vec::new(),
            straddled: vec![0.0; count],
            crossed: vec![0.0; count],
        }
    }

    /// What passed so far.
    pub fn flows(&self) -> &[SectionFlow] {
        &self.flows
    }

    /// Remembers the particles at the beginning of a step.
    pub fn begin(&mut self, particles: &FluidParticles) {
        if self.lines.is_empty() {
            return;
        }
        self.starts.clone_from(&particles.position);
        for (line, straddled) in self.lines.iter().zip(&mut self.straddled) {
            *straddled = line.straddling(particles, self.dimension);
        }
        self.crossed.fill(0.0);
    }

    /// Counts the particles that moved from where they began to `place(i)` (m), those that leave with it included.
    pub fn count(&mut self, volume: &[f64], place: impl Fn(usize) -> Vec2 + Sync) {
        for (line, crossed) in self.lines.iter().zip(&mut self.crossed) {
            *crossed += in_chunks(&self.starts, |i| volume[i] * line.crossings(self.starts[i], place(i)));
        }
    }

    /// What changes from here to `go_on` is no motion.
    pub fn pause(&mut self, particles: &FluidParticles) {
        for (line, straddled) in self.lines.iter().zip(&mut self.straddled) {
            *straddled -= line.straddling(particles, self.dimension);
        }
    }

    /// Goes on after `pause`.
    pub fn go_on(&mut self, particles: &FluidParticles) {
        for (line, straddled) in self.lines.iter().zip(&mut self.straddled) {
            *straddled += line.straddling(particles, self.dimension);
        }
    }

    /// Counts the particles from the `first` on, which came in over an edge in the time (s) of the step, and closes it.
    pub fn close(&mut self, particles: &FluidParticles, first: usize, time_step: f64) {
        for (number, line) in self.lines.iter().enumerate() {
            let mut passed = self.crossed[number] - self.straddled[number];
            for i in first..particles.len() {
                let place = particles.position[i];
                passed += particles.volume[i] * line.crossings(place - particles.velocity[i] * time_step, place);
            }
            passed += line.straddling(particles, self.dimension);
            let (volume, is_reached) = &mut self.passed[number];
            *volume += passed;
            *is_reached = *is_reached || self.crossed[number] != 0.0 || line.is_reached(particles, self.dimension);
            if *is_reached {
                let discharge = if time_step > 0.0 { passed / time_step } else { 0.0 };
                self.flows[number] = SectionFlow { discharge, volume: *volume };
            }
        }
    }
}

/// The sum of a quantity over all particles, in the same order for any number of threads.
fn in_chunks(places: &[Vec2], of: impl Fn(usize) -> f64 + Sync) -> f64 {
    let sum = |(chunk, places): (usize, &[Vec2])| (0..places.len()).map(|k| of(chunk * CHUNK + k)).sum::<f64>();
    places.par_chunks(CHUNK).enumerate().map(sum).collect::<Vec<f64>>().iter().sum()
}

/// I: the share of a particle that stands to the left of a line which it has passed by so many times its edge.
fn share(x: f64) -> f64 {
    let (beyond, side) = (x.abs(), if x > 0.0 { 1.0 } else { 0.0 });
    let rest = if beyond < 1.0 {
        0.5 - beyond * (2.0 / 3.0 - beyond * beyond * (1.0 / 3.0 - beyond / 8.0))
    } else {
        (2.0 - beyond).max(0.0).powi(4) / 24.0
    };
    (side - rest).abs()
}

impl Line {
    fn new(pieces: &[[Vec2; 2]], is_off: impl Fn(Vec2) -> bool) -> Self {
        let ends = || pieces.iter().flatten();
        let low =
            ends().fold(Vec2::new(f64::INFINITY, f64::INFINITY), |low, p| Vec2::new(low.x.min(p.x), low.y.min(p.y)));
        let high = ends().fold(low, |high, p| Vec2::new(high.x.max(p.x), high.y.max(p.y)));
        let is_piece = |piece: &&[Vec2; 2]| (piece[1] - piece[0]).norm_squared() > 0.0;
        let pieces: Vec<[Vec2; 2]> = pieces.iter().filter(is_piece).copied().collect();
        let goes_on = [pieces.first().map(|piece| piece[0]), pieces.last().map(|piece| piece[1])];
        Line { goes_on: goes_on.map(|end| end.is_some_and(&is_off)), pieces, low, high }
    }

    /// How often a way goes over to the left of the line, less to the right.
    fn crossings(&self, from: Vec2, to: Vec2) -> f64 {
        let is_apart = |a: f64, b: f64, low: f64, high: f64| a.max(b) < low || a.min(b) > high;
        if is_apart(from.x, to.x, self.low.x, self.high.x) || is_apart(from.y, to.y, self.low.y, self.high.y) {
            return 0.0;
        }
        let way = to - from;
        let crossing = |&[a, b]: &[Vec2; 2]| {
            let is_left = |place: Vec2| (b - a).cross(place - a) > 0.0;
            // A corner that the way meets belongs to one of its pieces: the question is the same for both.
            let is_beside = |corner: Vec2| way.cross(corner - from) > 0.0;
            if is_left(from) == is_left(to) || is_beside(a) == is_beside(b) {
                0.0
            } else if is_left(to) {
                1.0
            } else {
                -1.0
            }
        };
        self.pieces.iter().map(crossing).sum()
    }

    /// Distance (m) of a place from the line, positive to its left; none where an end of the line is nearest.
    fn distance(&self, place: Vec2) -> Option<f64> {
        let last = self.pieces.len().wrapping_sub(1);
        let mut nearest = (f64::INFINITY, None::<f64>, 0.0_f64);
        for (k, &[a, b]) in self.pieces.iter().enumerate() {
            let (along, offset) = (b - a, place - a);
            let share = along.dot(offset) / along.norm_squared();
            let (before, behind) = (k == 0 && share < 0.0, k == last && share > 1.0);
            let side = along.cross(offset) / along.norm();
            let goes_on = (before && self.goes_on[0]) || (behind && self.goes_on[1]);
            let distance = if goes_on || (0.0..=1.0).contains(&share) {
                side.abs()
            } else {
                (place - if share < 0.0 { a } else { b }).norm()
            };
            // Beside a corner that is nearest the piece from which the place lies farther aside knows its side.
            let order = distance.total_cmp(&nearest.0);
            if order.is_lt() || (order.is_eq() && side.abs() > nearest.2) {
                let is_beyond = (before || behind) && !goes_on;
                let signed = if side > 0.0 { distance } else { -distance };
                nearest = (distance, (!is_beyond).then_some(signed), side.abs());
            }
        }
        nearest.1
    }

    /// Distance (m) of a particle from the line, as `distance`, and its edge (m); none where it stands more than so many edges away.
    fn near(&self, particles: &FluidParticles, i: usize, dimension: Dimension, edges: f64) -> Option<(f64, f64)> {
        let place = particles.position[i];
        let edge = dimension.edge(particles.volume[i] / particles.depth[i]);
        let (low, high) = (place - self.low, self.high - place);
        if low.x.min(low.y).min(high.x).min(high.y) < -edges * edge {
            return None;
        }
        self.distance(place).filter(|distance| distance.abs() <= edges * edge).map(|distance| (distance, edge))
    }

    /// Whether the edge of a particle reaches the line.
    fn is_reached(&self, particles: &FluidParticles, dimension: Dimension) -> bool {
        (0..particles.len()).any(|i| self.near(particles, i, dimension, 0.5).is_some())
    }

    /// Σ V [I(ρ/√A) − H(ρ)] (m³).
    fn straddling(&self, particles: &FluidParticles, dimension: Dimension) -> f64 {
        in_chunks(&particles.position, |i| {
            let Some((distance, edge)) = self.near(particles, i, dimension, 2.0) else { return 0.0 };
            let step = if distance > 0.0 { 1.0 } else { 0.0 };
            particles.volume[i] * (share(distance / edge) - step)
        })
    }
}

#[cfg(test)]
mod tests;
