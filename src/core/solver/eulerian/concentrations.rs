//! The concentrations of all tracers in the padded rows, and what is known of them by place.

use std::collections::BTreeMap;
use std::ops::Range;

use super::rows::{Slot, WaterRow};
use crate::boundary::Tracer;
use crate::physics::tracer::Mixture;
use crate::solver::TracerLedger;

/// What comes in by which a concentration is given.
#[derive(Clone, Copy, Debug)]
pub(super) enum Given {
    /// A point source.
    Source(usize),
    /// A line source.
    LineSource(usize),
    /// Rain.
    Rain,
}

/// One tracer in all padded rows.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct Carried {
    pub given: Tracer,
    /// C as the faces see it.
    pub seen: Vec<Vec<f64>>,
    /// C at the start of the step.
    pub start: Vec<Vec<f64>>,
    /// By how much it is greater at the eastern and at the northern face.
    pub slopes: Vec<[Vec<f64>; 2]>,
    /// What the stage makes of it.
    pub next: Vec<Vec<f64>>,
    pub balance: TracerLedger,
}

/// A face over which water leaves the terrain or comes in: its place, the sign of what leaves, and the cell before it.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct RimFace {
    pub slot: Slot,
    pub sign: f64,
    pub inside: (usize, usize),
}

/// All tracers; nothing by default.
#[derive(Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct Tracers {
    pub carried: Vec<Carried>,
    /// Depth at the start of the step (m).
    pub start_depth: Vec<Vec<f64>>,
    /// The cells that took part in the first stage.
    pub first: Vec<Vec<Range<usize>>>,
    pub rim: Vec<RimFace>,
    /// The boundary of each face of one, by row, direction and column.
    pub beyond: BTreeMap<(usize, usize, usize), usize>,
    /// Cells whose faces are not all in the rows, by row and column; empty where there are none.
    pub is_apart: Vec<Vec<bool>>,
}

impl Carried {
    /// What water that comes in has.
    fn of(&self, given: Given) -> f64 {
        let at = |all: &[f64], which: usize| all.get(which).copied().unwrap_or(0.0);
        match given {
            Given::Source(which) => at(&self.given.sources, which),
            Given::LineSource(which) => at(&self.given.line_sources, which),
            Given::Rain => self.given.rain,
        }
    }
}

impl Tracers {
    /// Whether not all faces of a cell are in the rows.
    pub fn is_apart(&self, row: usize, column: usize) -> bool {
        self.is_apart.get(row).is_some_and(|row| row[column])
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.carried.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.carried.is_empty()
    }

    /// The concentrations of a tracer in a padded row.
    pub fn seen(&self, tracer: usize, row: usize) -> &[f64] {
        &self.carried[tracer].seen[row]
    }

    /// Sets the concentration of a tracer in a padded cell.
    pub fn set(&mut self, tracer: usize, (row, column): (usize, usize), concentration: f64) {
        self.carried[tracer].seen[row][column] = concentration;
    }

    /// The concentration of a tracer at a face of a cell, on the side (±1) of a direction, in water that leaves the cell.
    pub fn leaving(&self, tracer: usize, (row, column): (usize, usize), (direction, sign): (usize, f64)) -> f64 {
        let Carried { seen, slopes, .. } = &self.carried[tracer];
        seen[row][column] + sign * slopes[row][direction][column]
    }

    /// What water that comes in has of a tracer, and its rate of decay (1/s).
    pub fn given(&self, tracer: usize, given: Given) -> f64 {
        self.carried[tracer].of(given)
    }

    /// The rate of decay of a tracer (1/s).
    pub fn decay_rate(&self, tracer: usize) -> f64 {
        self.carried[tracer].given.decay
    }

    /// Mixes water that came into a padded cell to what was there (m of depth), and adds it to the balance by the area of the cell (m²).
    pub fn pour(&mut self, (row, column): (usize, usize), given: Given, [before, added]: [f64; 2], area: f64) {
        for carried in &mut self.carried {
            let own = carried.seen[row][column];
            let concentration = carried.of(given);
            let mixture = Mixture::NOTHING.with(before, own).with(added, concentration);
            carried.seen[row][column] = mixture.concentration_or(own);
            carried.balance.inflow += concentration * added * area;
        }
    }

    /// Looks at the water before it rains.
    pub fn before_rain(&mut self, state_water: &[WaterRow]) {
        if !self.is_empty() {
            self.start_depth.iter_mut().zip(state_water).for_each(|(own, row)| own.copy_from_slice(&row.depth));
        }
    }
}
