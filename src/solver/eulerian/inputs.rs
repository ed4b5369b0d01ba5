//! Sources at points and along lines, and rain: depth that is added at the end of each step, and keeps the momentum as it is.

use rayon::prelude::*;

use super::Scale;
use super::state::State;
use crate::boundary::{LineSource, PointSource, Rain, Series};
use crate::solver::FlowProblem;

/// A source and its padded cells, each with its share.
struct Spring {
    discharge: Series,
    cells: Vec<((usize, usize), f64)>,
}

/// All sources and the rain of a problem.
pub(crate) struct Inputs {
    springs: Vec<Spring>,
    rain: Option<Rain>,
    /// What falls within a step (m) at each place of rain by frames.
    falling: Vec<f64>,
    /// Whether it rains: water may then come to every cell.
    pub is_wetted: bool,
}

impl Inputs {
    pub fn new(problem: &FlowProblem, state: &State) -> Self {
        let lattice = &problem.bed.lattice;
        let padded = |cell: usize| {
            let (column, row) = lattice.column_row(cell);
            (row + 1, column + 1)
        };
        let spring = |discharge: &Series, cells: Vec<(usize, f64)>| {
            let cells = cells.into_iter().map(|(cell, share)| (padded(cell), share));
            let on_terrain = cells.filter(|((row, column), _)| state.has_terrain(*row, *column)).collect();
            Spring { discharge: discharge.clone(), cells: on_terrain }
        };
        let at_point =
            |source: &PointSource| Some(spring(&source.discharge, vec![(lattice.cell_at(source.place)?, 1.0)]));
        let points = problem.forcing.sources.iter().filter_map(at_point);
        let along_line = |source: &LineSource| spring(&source.discharge, source.cells.clone());
        let springs = points.chain(problem.forcing.line_sources.iter().map(along_line)).collect();
        let rain = problem.forcing.rain.clone();
        let places = if let Some(Rain::Frames(frames)) = &rain { frames.from.len() } else { 0 };
        Inputs { springs, is_wetted: rain.is_some(), rain, falling: vec![0.0; places] }
    }

    /// The cells (row, column) of the sources.
    pub fn cells(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.springs.iter().flat_map(|spring| spring.cells.iter().map(|(cell, _)| *cell))
    }

    /// Adds what comes between two times (s); returns its volume (m³).
    pub fn add(&mut self, state: &mut State, scale: &Scale, from: f64, to: f64) -> f64 {
        let area = scale.spacing * scale.spacing;
        let mut volume = 0.0;
        for Spring { discharge, cells } in &self.springs {
            let came = discharge.integral(from, to).max(0.0);
            for ((row, column), share) in cells {
                state.water[*row].depth[*column] += came * share / area;
                volume += came * share;
            }
        }
        if let Some(rain) = &self.rain {
            let columns = state.columns;
            let everywhere = if let Rain::Uniform(_) = rain { rain.depth(0, from, to) } else { 0.0 };
            if let Rain::Frames(frames) = rain {
                let falling = self.falling.iter_mut().enumerate();
                falling.for_each(|(place, depth)| *depth = frames.depth(place, from, to));
            }
            let falling = &self.falling;
            let ground = &state.ground;
            let rows = state.water.par_iter_mut().enumerate().with_min_len(4).map(|(row, water)| {
                let mut fallen = 0.0;
                for column in 1..=columns {
                    if !ground[row].has_terrain(column) {
                        continue;
                    }
                    let cell = (row - 1) * columns + column - 1;
                    let depth = match rain {
                        Rain::Uniform(_) => everywhere,
                        Rain::Map { .. } => rain.depth(cell, from, to),
                        Rain::Frames(frames) => falling[frames.place[cell] as usize],
                    };
                    water.depth[column] += depth;
                    fallen += depth;
                }
                fallen
            });
            // Row by row, so that the threads do not matter.
            let fallen: Vec<f64> = rows.collect();
            volume += fallen.iter().sum::<f64>() * area;
        }
        volume
    }

    /// The longest step (s) from a time on in which no source fills its cell so fast that the water leaves it again within the step.
    pub fn longest_step(&self, scale: &Scale, time: f64, step: f64) -> f64 {
        let area = scale.spacing * scale.spacing;
        let longest = |spring: &Spring| {
            let share = spring.cells.iter().map(|(_, share)| *share).fold(0.0, f64::max);
            let rise = spring.discharge.largest(time, time + step) * share / area;
            // A cell that was dry has d = (Q/A) Δt after the step, and its water spreads with 2 √(g d).
            let reach = scale.courant * scale.spacing;
            if rise > 0.0 { (reach * reach / (4.0 * scale.gravity * rise)).cbrt() } else { f64::INFINITY }
        };
        self.springs.iter().map(longest).fold(step, f64::min)
    }
}
