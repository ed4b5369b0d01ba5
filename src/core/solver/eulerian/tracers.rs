//! Tracers: what is carried with the water from cell to cell, and changes nothing of its flow.
//!
//! A cell keeps the concentration C, not the amount, so that water of one concentration keeps it to the last bit. In a stage of a step its water is mixed
//! anew, of what stays and what comes (M111 to M113); the volumes are those that passed in that stage, after all limits. Both stages together are
//! those of (M33):
//!
//! ```text
//! (M114)  C' = mix(d, C of what stays; f_k, C_k of what comes),   C'' = mix(d_0, C_0; d_1, C_1)     d_1, C_1 of the second stage
//! (M115)  C ← C exp(−k Δt)
//! ```
//!
//! with d_0 and C_0 of the start of the step. No face of cells that follow lines has a slope. Water that comes over a boundary, by sources
//! and as rain has the concentration that it is given. Levels and channels have no tracers: a scenario that asks for both is refused.

mod stage;
#[cfg(test)]
mod tests;

use super::EulerianSolver;
use super::concentrations::{Carried, Given, RimFace, Tracers};
use super::conforming::ConformingFaces;
use super::open::OpenBoundaries;
use super::state::{Slot, State};
use super::update::Stage;
use super::walls::Walls;
use crate::boundary::Tracer;
use crate::solver::{FlowProblem, TracerLedger};

impl Carried {
    fn new(given: &Tracer, state: &State) -> Self {
        let zeros = || state.water.iter().map(|row| vec![0.0; row.depth.len()]).collect::<Vec<_>>();
        let mut seen = zeros();
        let lattice = state.lattice();
        let square = |row: usize, column: usize| {
            let place = state.position(row, column) * (1.0 / lattice.spacing);
            let at = |place: f64, count: usize| (place.max(0.0) as usize).min(count.saturating_sub(1));
            at(place.y, lattice.rows) * lattice.columns + at(place.x, lattice.columns)
        };
        if !given.initial.is_empty() {
            for (row, seen) in seen.iter_mut().enumerate() {
                let is_wet = |column: usize| state.has_terrain(row, column) && state.water[row].depth[column] > 0.0;
                for (column, seen) in seen.iter_mut().enumerate().filter(|(column, _)| is_wet(*column)) {
                    *seen = given.initial[square(row, column)];
                }
            }
        }
        let slopes = state.water.iter().map(|row| [(); 2].map(|()| vec![0.0; row.depth.len()])).collect();
        Carried { given: given.clone(), start: zeros(), next: zeros(), seen, slopes, balance: TracerLedger::default() }
    }

    /// The amount in the rows.
    fn stored(&self, state: &State) -> f64 {
        let of_row = |row: usize| {
            let (depth, per_area) = (&state.water[row].depth, &state.ground[row].per_area);
            let columns = (0..depth.len()).filter(|&column| per_area[column] > 0.0);
            let sum: f64 = columns.map(|column| depth[column] * self.seen[row][column] / per_area[column]).sum();
            sum * (state.spacing[row] * state.spacing[row])
        };
        (0..self.seen.len()).map(of_row).sum()
    }
}

impl Tracers {
    /// Those of a problem.
    ///
    /// # Panics
    /// On levels and with channels; a scenario that asks for that is refused.
    pub fn new(problem: &FlowProblem, state: &State, (walls, open): (&Walls, &OpenBoundaries)) -> Self {
        let given = &problem.forcing.tracers;
        if given.is_empty() {
            return Tracers::default();
        }
        let has_levels = state.lattice().level_count() > 1;
        assert!(!has_levels && problem.forcing.channels.is_empty(), "no tracers on levels and in channels");
        let rim_face = |slot: Slot| {
            let Slot { row, direction, column } = slot;
            let owner = (row, column);
            let (sign, inside) = if state.has_terrain(row, column) {
                (1.0, owner)
            } else {
                (-1.0, super::rows::other(owner, direction))
            };
            RimFace { slot, sign, inside }
        };
        let of_boundaries = open.slots().map(|(slot, _)| slot);
        let key = |slot: Slot| (slot.row, slot.direction, slot.column);
        Tracers {
            carried: given.iter().map(|given| Carried::new(given, state)).collect(),
            start_depth: state.water.iter().map(|row| row.depth.clone()).collect(),
            first: vec![Vec::new(); state.water.len()],
            rim: walls.open_faces().chain(of_boundaries).map(rim_face).collect(),
            beyond: open.slots().map(|(slot, line)| (key(slot), line)).collect(),
            is_apart: Vec::new(),
        }
    }

    /// Marks the cells whose faces are not all in the rows.
    pub fn set_apart(&mut self, state: &State, places: impl Iterator<Item = (usize, usize)>) {
        let mut places = places.peekable();
        if self.carried.is_empty() || places.peek().is_none() {
            return;
        }
        self.is_apart = state.water.iter().map(|row| vec![false; row.depth.len()]).collect();
        places.for_each(|(row, column)| self.is_apart[row][column] = true);
    }

    /// The integral of C² of the first tracer over the water of the rows.
    #[cfg(test)]
    fn square_in_rows(&self, state: &State) -> f64 {
        let cells = |row: usize| (0..state.water[row].depth.len()).map(move |column| (row, column));
        let all =
            (0..state.water.len()).flat_map(cells).filter(|&(row, column)| state.ground[row].per_area[column] > 0.0);
        let square = |(row, column): (usize, usize)| {
            let volume = state.water[row].depth[column] * state.area((row, column));
            volume * self.carried[0].seen[row][column].powi(2)
        };
        all.map(square).sum()
    }

    /// Lets the tracers of the rows decay over a step (s).
    fn decay(&mut self, state: &State, time_step: f64) {
        for carried in self.carried.iter_mut().filter(|carried| carried.given.decay > 0.0) {
            let kept = (-carried.given.decay * time_step).exp();
            carried.balance.decayed += (1.0 - kept) * carried.stored(state);
            carried.seen.iter_mut().flatten().for_each(|seen| *seen *= kept);
        }
    }
}

/// Puts the tracers of a problem into a state.
pub(super) fn set(
    problem: &FlowProblem,
    state: &mut State,
    (walls, open, conforming): (&Walls, &OpenBoundaries, &ConformingFaces),
) {
    let mut tracers = Tracers::new(problem, state, (walls, open));
    tracers.set_apart(state, conforming.cells());
    state.tracers = tracers;
}

/// Mixes the rain that fell since [`Tracers::before_rain`] to the water of the rows.
pub(super) fn mix_rain(state: &mut State) {
    let mut tracers = std::mem::take(&mut state.tracers);
    if !tracers.is_empty() {
        let before = std::mem::take(&mut tracers.start_depth);
        for (row, before) in before.iter().enumerate() {
            for (column, &before) in before.iter().enumerate() {
                let added = state.water[row].depth[column] - before;
                if added > 0.0 {
                    tracers.pour((row, column), Given::Rain, [before, added], state.area((row, column)));
                }
            }
        }
        tracers.start_depth = before;
    }
    state.tracers = tracers;
}

impl EulerianSolver {
    /// Carries the tracers of the rows through a stage of a step (s).
    pub(super) fn carry_tracers(&mut self, stage: Stage, time_step: f64) {
        if self.state.tracers.is_empty() {
            return;
        }
        let mut tracers = std::mem::take(&mut self.state.tracers);
        tracers.take(&self.state, (&self.active, &self.conforming), stage, (time_step, self.scale.dry_depth));
        self.state.tracers = tracers;
    }

    /// Finds the slopes of the tracers of the rows for a stage of a step (s).
    pub(super) fn find_tracer_slopes(&mut self, stage: Stage, time_step: f64) {
        if self.state.tracers.is_empty() {
            return;
        }
        let mut tracers = std::mem::take(&mut self.state.tracers);
        tracers.find_slopes(&self.state, &self.active, &self.scale, stage, time_step);
        self.state.tracers = tracers;
    }

    /// Lets the tracers decay over a step (s).
    pub(super) fn decay_tracers(&mut self, time_step: f64) {
        if let Some(moving) = &mut self.moving {
            moving.decay_tracers(time_step);
        }
        let mut tracers = std::mem::take(&mut self.state.tracers);
        tracers.decay(&self.state, time_step);
        self.state.tracers = tracers;
    }

    /// The balance of each tracer.
    pub(super) fn tracer_ledgers(&self) -> Vec<TracerLedger> {
        let ledger = |(which, carried): (usize, &Carried)| {
            let mut ledger = carried.balance;
            ledger.stored = carried.stored(&self.state);
            if let Some(moving) = &self.moving {
                let TracerLedger { inflow, decayed, stored, .. } = moving.tracer_ledger(which);
                ledger.inflow += inflow;
                ledger.decayed += decayed;
                ledger.stored += stored;
            }
            ledger
        };
        self.state.tracers.carried.iter().enumerate().map(ledger).collect()
    }

    /// Notes the amounts at the start.
    pub(super) fn note_initial_tracers(&mut self) {
        let stored: Vec<f64> = self.tracer_ledgers().iter().map(|ledger| ledger.stored).collect();
        self.state
            .tracers
            .carried
            .iter_mut()
            .zip(stored)
            .for_each(|(carried, stored)| carried.balance.initial = stored);
    }
}
