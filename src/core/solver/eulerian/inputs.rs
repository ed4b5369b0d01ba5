//! Sources at points and along lines, and rain: depth that is added at the end of each step, and keeps the momentum as it is.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::Scale;
use super::concentrations::Given;
use super::moving_cells::MovingCells;
use super::spans::ActiveSet;
use super::state::State;
use super::tracers::mix_rain;
use crate::boundary::{LineSource, PointSource, Rain, Series};
use crate::solver::{FlowProblem, Passage, Way};

/// A source and its padded cells, each with its share.
#[derive(serde::Serialize, serde::Deserialize)]
struct Spring {
    way: Way,
    discharge: Series,
    cells: Vec<((usize, usize), f64)>,
    /// Volume (m³) that came.
    booked: f64,
}

/// What gives the concentration of the water of a source.
fn given(way: Way) -> Given {
    match way {
        Way::LineSource(which) => Given::LineSource(which),
        Way::Source(which) => Given::Source(which),
        _ => Given::Rain,
    }
}

/// All sources and the rain of a problem.
#[derive(serde::Serialize, serde::Deserialize)]
pub(crate) struct Inputs {
    /// Places in a row of the lattice.
    columns: usize,
    springs: Vec<Spring>,
    /// For each cell to which sources give its spacing (m), who they are and what of their discharge makes depth in it: their shares by
    /// its 1/φ.
    givers: Vec<(f64, Vec<(usize, f64)>)>,
    rain: Option<Rain>,
    /// Volume (m³) that rained.
    rained: f64,
    /// The cells for whose squares cells that move stand.
    pub squares_that_move: Vec<usize>,
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
        let spring = |way: Way, discharge: &Series, cells: Vec<(usize, f64)>| {
            let cells = cells.into_iter().map(|(cell, share)| (padded(cell), share));
            let on_terrain = cells.filter(|((row, column), _)| state.has_terrain(*row, *column)).collect();
            Spring { way, discharge: discharge.clone(), cells: on_terrain, booked: 0.0 }
        };
        let at_point = |(index, source): (usize, &PointSource)| {
            let cells = lattice.cell_at(source.place).map(|cell| (cell, 1.0)).into_iter().collect();
            spring(Way::Source(index), &source.discharge, cells)
        };
        let along_line = |(index, source): (usize, &LineSource)| {
            spring(Way::LineSource(index), &source.discharge, source.cells.clone())
        };
        let points = problem.forcing.sources.iter().enumerate().map(at_point);
        let springs: Vec<Spring> =
            points.chain(problem.forcing.line_sources.iter().enumerate().map(along_line)).collect();
        let mut givers: BTreeMap<(usize, usize), Vec<(usize, f64)>> = BTreeMap::new();
        for (number, spring) in springs.iter().enumerate() {
            for &(cell, share) in &spring.cells {
                let per_area = state.ground[cell.0].per_area[cell.1];
                givers.entry(cell).or_default().push((number, share * per_area));
            }
        }
        let rain = problem.forcing.rain.clone();
        let places = if let Some(Rain::Frames(frames)) = &rain { frames.from.len() } else { 0 };
        let givers = givers.into_iter().map(|((row, _), givers)| (state.spacing[row], givers)).collect();
        Inputs {
            columns: lattice.columns,
            springs,
            givers,
            is_wetted: rain.is_some(),
            rain,
            rained: 0.0,
            falling: vec![0.0; places],
            squares_that_move: Vec::new(),
        }
    }

    /// The cells (row, column) of the sources.
    pub fn cells(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.springs.iter().flat_map(|spring| spring.cells.iter().map(|(cell, _)| *cell))
    }

    /// Adds what comes to rows at hand between two times (s); returns its volume (m³).
    pub fn add(&mut self, state: &mut State, active: &ActiveSet, from: f64, to: f64) -> f64 {
        let at_hand = active.at_hand();
        let mut volume = 0.0;
        for Spring { way, discharge, cells, booked } in &mut self.springs {
            let came = discharge.integral(from, to).max(0.0);
            for ((row, column), share) in cells.iter().filter(|((row, _), _)| at_hand.contains(row)) {
                let area = state.spacing[*row] * state.spacing[*row];
                let (before, added) =
                    (state.water[*row].depth[*column], came * share / area * state.ground[*row].per_area[*column]);
                state.water[*row].depth[*column] += added;
                state.tracers.pour((*row, *column), given(*way), [before, added], state.area((*row, *column)));
                volume += came * share;
                *booked += came * share;
            }
        }
        if let Some(rain) = &self.rain {
            let columns = self.columns;
            let everywhere = if let Rain::Uniform(_) = rain { rain.depth(0, from, to) } else { 0.0 };
            if let Rain::Frames(frames) = rain {
                let falling = self.falling.iter_mut().enumerate();
                falling.for_each(|(place, depth)| *depth = frames.depth(place, from, to));
            }
            let falling = &self.falling;
            state.tracers.before_rain(&state.water);
            let (ground, spacing) = (&state.ground, &state.spacing);
            let rows = active.rows_of(&mut state.water).map(|(row, water)| {
                let mut fallen = 0.0;
                for column in (1..water.depth.len()).filter(|&column| ground[row].per_area[column] > 0.0) {
                    let cell = (row - 1) * columns + column - 1;
                    let depth = match rain {
                        Rain::Uniform(_) => everywhere,
                        Rain::Map { .. } => rain.depth(cell, from, to),
                        Rain::Frames(frames) => falling[frames.place[cell] as usize],
                    };
                    water.depth[column] += depth;
                    fallen += depth / ground[row].per_area[column];
                }
                fallen * (spacing[row] * spacing[row])
            });
            // Row by row, so that the threads do not matter.
            let fallen: Vec<f64> = rows.collect();
            mix_rain(state);
            let fallen = fallen.iter().sum::<f64>();
            volume += fallen;
            self.rained += fallen;
        }
        volume
    }

    /// Lets the rain between two times (s) fall on cells that move; returns its volume (m³).
    pub fn rain_on(&mut self, moving: &mut MovingCells, from: f64, to: f64) -> f64 {
        let Some(rain) = &self.rain else { return 0.0 };
        let fallen = moving.rain(|cell| rain.depth(cell, from, to));
        self.rained += fallen;
        fallen
    }

    /// What came by each source and by rain until a time (s).
    pub fn passages(&self, state: &State, time: f64) -> Vec<Passage> {
        let came = |way: Way, inflow: f64, asked: f64| Passage { way, inflow, outflow: 0.0, asked: Some(asked) };
        let springs =
            self.springs.iter().map(|spring| came(spring.way, spring.booked, spring.discharge.integral(0.0, time)));
        let mut passages: Vec<Passage> = springs.collect();
        if let Some(rain) = &self.rain {
            let all = |row: usize| 1..=state.columns(row);
            let with_terrain = |row: usize| all(row).filter(move |&column| state.ground[row].per_area[column] > 0.0);
            let cells = (1..=state.rows).flat_map(|row| with_terrain(row).map(move |column| (row, column)));
            let fallen = |(row, column): (usize, usize)| {
                let depth = rain.depth((row - 1) * self.columns + column - 1, 0.0, time);
                depth / state.ground[row].per_area[column] * (state.spacing[row] * state.spacing[row])
            };
            let on_moving = self.squares_that_move.iter().map(|&cell| rain.depth(cell, 0.0, time));
            let asked = cells.map(fallen).sum::<f64>() + on_moving.sum::<f64>() * state.lattice().cell_area();
            passages.push(came(Way::Rain, self.rained, asked));
        }
        passages
    }

    /// The longest step (s) from a time on in which the sources of no cell fill it so fast that the water leaves it again within the
    /// step.
    pub fn longest_step(&self, scale: &Scale, time: f64, step: f64) -> f64 {
        let largest: Vec<f64> = self.springs.iter().map(|spring| spring.discharge.largest(time, time + step)).collect();
        let longest = |(spacing, givers): &(f64, Vec<(usize, f64)>)| {
            let rise = givers.iter().map(|&(spring, share)| largest[spring] * share).sum::<f64>() / (spacing * spacing);
            // A cell that was dry has d = (Q/A) Δt after the step, and its water spreads with 2 √(g d).
            let reach = scale.courant * spacing;
            if rise > 0.0 { (reach * reach / (4.0 * scale.gravity * rise)).cbrt() } else { f64::INFINITY }
        };
        self.givers.iter().map(longest).fold(step, f64::min)
    }
}
