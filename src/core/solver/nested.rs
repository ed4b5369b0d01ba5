//! One problem on a nested lattice, put together from one problem for each of its levels.
//!
//! Each level was prepared as a lattice of its own, with all that stands and moves on it. What belongs to cells is taken from the level that
//! stands for them; what belongs to places, such as walls and sections, is the same for all. A breaking dam and what joins channels belong to the finest level.

use std::sync::Arc;

use super::FlowProblem;
use crate::bed::{BedParticles, Cover, PassSills};
use crate::boundary::{BedMotion, Forcing, LineSource, Rain, RainFrames};
use crate::lattice::{Conforming, Lattice, Level, Nest};

/// Puts the problems of all levels, the finest first, together.
///
/// # Panics
/// Without as many problems as there are levels.
pub fn nested(levels: Vec<FlowProblem>, nest: Nest) -> FlowProblem {
    assert_eq!(levels.len(), nest.levels().len(), "a problem for each level");
    let stack = Stack { lattice: levels[0].bed.lattice.clone().nested(nest), levels };
    let bed = stack.bed();
    let forcing = stack.forcing();
    let initial_depth = stack.of_cells(0.0, |problem| &problem.initial_depth);
    let mut all = stack.levels.into_iter();
    let Some(mut finest) = all.next() else { unreachable!("a nest has a level") };
    for coarser in all {
        finest.open_edges.pieces.join(&coarser.open_edges.pieces);
    }
    FlowProblem { bed, forcing, initial_depth, ..finest }
}

/// The problems, and the lattice of all of them.
struct Stack {
    lattice: Lattice,
    levels: Vec<FlowProblem>,
}

impl Stack {
    /// Each problem with its level.
    fn each(&self) -> impl Iterator<Item = (&FlowProblem, Level)> {
        self.levels.iter().zip(self.lattice.levels())
    }

    /// The index in the stack of a cell of a level's own lattice, where the level stands for it; a cell that follows lines stands for the
    /// squares whose centres it holds.
    fn leaf(&self, level: Level, cell: usize) -> Option<usize> {
        let cell = self.lattice.in_stack(level, cell);
        let instead = || {
            let is_finest = level.first_row == 0;
            let conforming = self.lattice.conforming().filter(|_| is_finest)?;
            Some(conforming.place(conforming.instead_of(cell)??))
        };
        Some(cell).filter(|&cell| self.lattice.is_leaf(cell)).or_else(instead)
    }

    /// Of each cell that follows lines its place and the square about its centre, whose numbers it has.
    fn squares_of_lines(&self) -> impl Iterator<Item = (usize, Option<usize>)> + '_ {
        let finest = &self.levels[0].bed.lattice;
        let of_cells = |made: &'_ Conforming| {
            made.places()
                .zip(made.cells())
                .map(|(place, cell)| (place, finest.cell_of(cell.centre)))
                .collect::<Vec<_>>()
        };
        self.lattice.conforming().map(of_cells).unwrap_or_default().into_iter()
    }

    /// The numbers of all cells, each from the level that stands for it; `none` where there is no cell.
    fn of_cells<T: Copy>(&self, none: T, values: impl Fn(&FlowProblem) -> &[T]) -> Vec<T> {
        let mut all = vec![none; self.lattice.len()];
        for (problem, level) in self.each() {
            for (cell, &value) in values(problem).iter().enumerate() {
                if let Some(leaf) = self.leaf(level, cell) {
                    all[leaf] = value;
                }
            }
        }
        for (place, square) in self.squares_of_lines() {
            all[place] = square.and_then(|square| values(&self.levels[0]).get(square)).copied().unwrap_or(none);
        }
        all
    }

    fn bed(&self) -> BedParticles {
        let finest = &self.levels[0].bed;
        let cell_of = |level: Level, cell: usize| self.lattice.in_stack(level, cell);
        let of_level = |(problem, level): (&FlowProblem, Level)| -> Vec<usize> {
            problem.bed.sealed.iter().map(|&cell| self.lattice.in_stack(level, cell)).collect()
        };
        BedParticles {
            lattice: self.lattice.clone(),
            elevation: self.of_cells(f64::NAN, |problem| &problem.bed.elevation),
            is_sloped: finest.is_sloped,
            curvature: Vec::new(),
            manning: self.of_cells(0.0, |problem| &problem.bed.manning),
            sealed: self.each().flat_map(of_level).collect(),
            passes: PassSills::stacked(self.each().map(|(problem, level)| (&problem.bed.passes, level)), cell_of),
            cover: Cover::stacked(self.each().map(|(problem, level)| (&problem.bed.cover, level)), cell_of),
            constants: finest.constants,
        }
    }

    fn forcing(&self) -> Forcing {
        let mut forcing = self.levels[0].forcing.clone();
        for (number, boundary) in forcing.boundaries.iter_mut().enumerate() {
            for coarser in &self.levels[1..] {
                boundary.pieces.join(&coarser.forcing.boundaries[number].pieces);
            }
        }
        for (number, source) in forcing.line_sources.iter_mut().enumerate() {
            source.cells = self.shares(|forcing| &forcing.line_sources[number]);
        }
        for (number, motion) in forcing.moving_bed.iter_mut().enumerate() {
            let of_level = |(problem, level): (&FlowProblem, Level)| {
                let BedMotion { cells, .. } = &problem.forcing.moving_bed[number];
                cells.iter().filter_map(|&(cell, z)| Some((self.leaf(level, cell)?, z))).collect::<Vec<_>>()
            };
            motion.cells = self.each().flat_map(of_level).collect();
        }
        forcing.rain = self.rain();
        forcing
    }

    /// The cells of a line source, each with its share of the whole.
    fn shares(&self, source: impl Fn(&Forcing) -> &LineSource) -> Vec<(usize, f64)> {
        let of_level = |(problem, level): (&FlowProblem, Level)| {
            let cells = source(&problem.forcing).cells.iter();
            cells.filter_map(|&(cell, share)| Some((self.leaf(level, cell)?, share))).collect::<Vec<_>>()
        };
        let mut cells: Vec<(usize, f64)> = self.each().flat_map(of_level).collect();
        let whole: f64 = cells.iter().map(|(_, share)| share).sum();
        cells.iter_mut().for_each(|(_, share)| *share /= whole);
        cells
    }

    fn rain(&self) -> Option<Rain> {
        let of = |problem: &FlowProblem| problem.forcing.rain.clone();
        Some(match of(&self.levels[0])? {
            Rain::Uniform(series) => Rain::Uniform(series),
            Rain::Map { until, .. } => {
                let maps = |which: usize| {
                    self.of_cells(0.0, |problem| match &problem.forcing.rain {
                        Some(Rain::Map { rate, from, .. }) => [rate, from][which],
                        _ => &[],
                    })
                };
                Rain::Map { rate: maps(0), from: maps(1), until }
            }
            Rain::Frames(frames) => {
                // The places of all levels behind each other.
                let of_level = |(problem, _): (&FlowProblem, Level)| match &problem.forcing.rain {
                    Some(Rain::Frames(frames)) => Some(Arc::clone(frames)),
                    _ => None,
                };
                let levels: Vec<Arc<RainFrames>> = self.each().filter_map(of_level).collect();
                let mut place = vec![0; self.lattice.len()];
                let mut first = 0;
                for (frames, number) in levels.iter().zip(0..) {
                    let level = self.lattice.level(number);
                    for (cell, &of_cell) in frames.place.iter().enumerate() {
                        if let Some(leaf) = self.leaf(level, cell) {
                            place[leaf] = first + of_cell;
                        }
                    }
                    first += frames.from.len() as u32;
                }
                for (of_line, square) in self.squares_of_lines() {
                    place[of_line] = square.map_or(0, |square| levels[0].place[square]);
                }
                let joined =
                    |of: &dyn Fn(&RainFrames) -> &[f64]| levels.iter().flat_map(|frames| of(frames).to_vec()).collect();
                Rain::Frames(Arc::new(RainFrames {
                    place,
                    from: joined(&|frames| &frames.from),
                    intervals: frames.intervals.clone(),
                    rates: (0..frames.rates.len()).map(|k| joined(&|frames| &frames.rates[k])).collect(),
                }))
            }
        })
    }
}
