//! A stage of a step for the tracers of the rows: the slopes (M111, M112), and the water mixed anew (M114).

use rayon::prelude::*;

use super::super::Scale;
use super::super::concentrations::{Carried, Tracers};
use super::super::conforming::ConformingFaces;
use super::super::rows::{EAST, NORTH};
use super::super::spans::ActiveSet;
use super::super::state::{State, sides};
use super::super::update::Stage;
use crate::physics::tracer::{Mixture, at_face, share_of_slopes};

/// A padded place (row, column).
type Place = (usize, usize);

/// The cells beside a padded one, in the order of [`NEIGHBOURS`](crate::lattice::NEIGHBOURS).
fn beside((row, column): Place) -> [Place; 4] {
    [(row, column + 1), (row, column - 1), (row + 1, column), (row - 1, column)]
}

/// Direction and sign of each side, in the same order.
const SIDES: [(usize, f64); 4] = [(EAST, 1.0), (EAST, -1.0), (NORTH, 1.0), (NORTH, -1.0)];

/// The depth of a padded cell from which a stage begins (m).
fn depth_before(state: &State, (row, column): Place, stage: Stage) -> f64 {
    match stage {
        Stage::First => state.water[row].depth[column],
        Stage::Second => state.primitive[row].depth[column],
    }
}

/// The concentrations beside a wet cell less its own, 0 where it is dry, and the least and greatest of them all.
fn about(seen: &[Vec<f64>], state: &State, place: Place, (stage, dry_depth): (Stage, f64)) -> ([f64; 4], [f64; 2]) {
    let own = seen[place.0][place.1];
    let mut bounds = [own; 2];
    let differences = beside(place).map(|other| {
        if !state.has_terrain(other.0, other.1) || depth_before(state, other, stage) <= dry_depth {
            return 0.0;
        }
        let there = seen[other.0][other.1];
        bounds = [bounds[0].min(there), bounds[1].max(there)];
        there - own
    });
    (differences, bounds)
}

/// What leaves a padded cell over each of its sides in a step (s), in metres of its depth; less than 0 where it comes.
fn leaving(state: &State, place: Place, time_step: f64) -> [f64; 4] {
    let per = time_step / state.spacing[place.0] * state.ground[place.0].per_area[place.1];
    sides(place).map(|(slot, sign)| per * sign * state.flux[slot.row][slot.direction].mass[slot.column])
}

impl Tracers {
    /// Finds the slopes of all active cells.
    pub(in super::super) fn find_slopes(
        &mut self,
        state: &State,
        active: &ActiveSet,
        scale: &Scale,
        stage: Stage,
        time_step: f64,
    ) {
        let mut all = std::mem::take(&mut self.carried);
        for Carried { seen, slopes, .. } in &mut all {
            let seen = &seen[..];
            active.rows_of(slopes).for_each(|(row, slopes)| {
                for column in active.work[row].iter().cloned().flatten() {
                    let is_whole = state.ground[row].per_area[column] > 0.0 && !self.is_apart(row, column);
                    let depth = depth_before(state, (row, column), stage);
                    let found = if is_whole && depth > scale.dry_depth {
                        slopes_at(
                            seen,
                            state,
                            (row, column),
                            (stage, scale.dry_depth),
                            leaving(state, (row, column), time_step),
                        )
                    } else {
                        [0.0; 2]
                    };
                    (slopes[EAST][column], slopes[NORTH][column]) = (found[EAST], found[NORTH]);
                }
            });
        }
        self.carried = all;
    }

    /// Mixes the water of all active cells anew, and adds what passes the rim to the balance.
    pub(in super::super) fn take(
        &mut self,
        state: &State,
        (active, conforming): (&ActiveSet, &ConformingFaces),
        stage: Stage,
        (time_step, dry_depth): (f64, f64),
    ) {
        self.begin(state, active, stage);
        for which in 0..self.carried.len() {
            self.book(which, state, 0.5 * time_step);
            let mut next = std::mem::take(&mut self.carried[which].next);
            let this = &*self;
            active.rows_of(&mut next).for_each(|(row, next)| {
                for column in active.work[row].iter().cloned().flatten() {
                    if state.ground[row].per_area[column] > 0.0 && !this.is_apart(row, column) {
                        let mixture = this.mixed(which, state, (row, column), (stage, time_step, dry_depth));
                        next[column] = this.ended(which, (row, column), stage, mixture);
                    } else {
                        next[column] = this.carried[which].seen[row][column];
                    }
                }
            });
            if !self.is_apart.is_empty() {
                for (place, mixture) in self.mixed_apart(which, (state, conforming), (stage, time_step)) {
                    next[place.0][place.1] = self.ended(which, place, stage, mixture);
                }
            }
            self.carried[which].next = next;
        }
        self.end(active);
    }

    /// What a stage makes of the concentration of a cell whose water it mixed.
    fn ended(&self, which: usize, (row, column): Place, stage: Stage, mixture: Mixture) -> f64 {
        let Carried { seen, start, .. } = &self.carried[which];
        let own = mixture.concentration_or(seen[row][column]);
        match stage {
            Stage::First => own,
            Stage::Second => {
                let both = Mixture::NOTHING.with(self.start_depth[row][column], start[row][column]);
                both.with(mixture.volume(), own).concentration_or(own)
            }
        }
    }

    /// The water of a cell after an Euler step, by its depth.
    fn mixed(
        &self,
        which: usize,
        state: &State,
        place: Place,
        (stage, time_step, dry_depth): (Stage, f64, f64),
    ) -> Mixture {
        let leaving = leaving(state, place, time_step);
        let seen = &self.carried[which].seen;
        let own = seen[place.0][place.1];
        let (mut left, mut beyond) = (depth_before(state, place, stage), 0.0);
        for (leaving, side) in leaving.into_iter().zip(SIDES).filter(|(leaving, _)| *leaving > 0.0) {
            left -= leaving;
            beyond += leaving * (self.leaving(which, place, side) - own);
        }
        // Rounding alone could take it beyond the bounds, the farther the less stays.
        let (_, [least, greatest]) = about(seen, state, place, (stage, dry_depth));
        let kept = if left > 0.0 { (own - beyond / left).clamp(least, greatest) } else { own };
        let mut mixture = Mixture::NOTHING.with(left, kept);
        for (which_side, from) in beside(place).into_iter().enumerate().filter(|(side, _)| leaving[*side] < 0.0) {
            mixture = mixture.with(-leaving[which_side], self.coming(which, state, (place, which_side), from));
        }
        mixture
    }

    /// The concentration of what comes into a cell over one of its sides.
    fn coming(&self, which: usize, state: &State, (place, side): (Place, usize), from: Place) -> f64 {
        if state.has_terrain(from.0, from.1) {
            let (direction, sign) = SIDES[side];
            return self.leaving(which, from, (direction, -sign));
        }
        let (slot, _) = sides(place)[side];
        let line = self.beyond.get(&(slot.row, slot.direction, slot.column));
        line.and_then(|&line| self.carried[which].given.boundaries.get(line)).copied().unwrap_or(0.0)
    }

    /// The same of the cells whose faces are not all in the rows: what leaves has the concentration of the cell.
    fn mixed_apart<'a>(
        &'a self,
        which: usize,
        (state, conforming): (&'a State, &'a ConformingFaces),
        (stage, time_step): (Stage, f64),
    ) -> impl Iterator<Item = (Place, Mixture)> + 'a {
        conforming.exchanges().map(move |(place, faces, others)| {
            let per_volume = time_step / state.area(place);
            let over_rows = leaving(state, place, time_step);
            let over_sides = others
                .iter()
                .map(|&side| (over_rows[side], self.coming(which, state, (place, side), beside(place)[side])));
            let over_faces = faces.map(|(beyond, rate)| {
                let coming = beyond.map_or(0.0, |(row, column)| self.carried[which].seen[row][column]);
                (rate * per_volume, coming)
            });
            let own = self.carried[which].seen[place.0][place.1];
            let (mut left, mut mixture) = (depth_before(state, place, stage), Mixture::NOTHING);
            for (leaving, coming) in over_sides.chain(over_faces) {
                left -= leaving.max(0.0);
                mixture = mixture.with(-leaving, coming);
            }
            (place, mixture.with(left, own))
        })
    }

    /// Adds what passes the rim in so many seconds to the balance.
    fn book(&mut self, which: usize, state: &State, carried: f64) {
        let (mut inflow, mut outflow) = (0.0, 0.0);
        for face in &self.rim {
            let (slot, inside) = (face.slot, face.inside);
            let rate = face.sign * state.flux[slot.row][slot.direction].mass[slot.column];
            let volume = carried * state.spacing[inside.0] * rate;
            if volume > 0.0 {
                outflow += volume * self.leaving(which, inside, (slot.direction, face.sign));
            } else if volume < 0.0 {
                let line = self.beyond.get(&(slot.row, slot.direction, slot.column));
                let given = line.and_then(|&line| self.carried[which].given.boundaries.get(line));
                inflow -= volume * given.copied().unwrap_or(0.0);
            }
        }
        let balance = &mut self.carried[which].balance;
        balance.inflow += inflow;
        balance.outflow += outflow;
    }

    /// Notes the start of the step, of cells that only take part in its second stage, too.
    fn begin(&mut self, state: &State, active: &ActiveSet, stage: Stage) {
        let Tracers { carried, start_depth, first, .. } = self;
        for row in active.at_hand() {
            let work = &active.work[row];
            let is_new = |column: usize| {
                let next = first[row].partition_point(|run| run.end <= column);
                stage == Stage::First || first[row].get(next).is_none_or(|run| run.start > column)
            };
            for column in work.iter().cloned().flatten().filter(|&column| is_new(column)) {
                start_depth[row][column] = state.water[row].depth[column];
                carried.iter_mut().for_each(|carried| carried.start[row][column] = carried.seen[row][column]);
            }
            if stage == Stage::First {
                first[row].clone_from(work);
            }
        }
    }

    /// Takes over what the stage made of the active cells.
    fn end(&mut self, active: &ActiveSet) {
        for row in active.at_hand() {
            for run in &active.work[row] {
                for Carried { seen, next, .. } in &mut self.carried {
                    seen[row][run.clone()].copy_from_slice(&next[row][run.clone()]);
                }
            }
        }
    }
}

/// The slopes of a wet cell over half of it (M111), as far as what stays of its water keeps within the bounds (M112).
fn slopes_at(
    seen: &[Vec<f64>],
    state: &State,
    place: Place,
    (stage, dry_depth): (Stage, f64),
    leaving: [f64; 4],
) -> [f64; 2] {
    let (differences, bounds) = about(seen, state, place, (stage, dry_depth));
    let [east, west, north, south] = differences;
    let slopes = [at_face(-west, east), at_face(-south, north)];
    let (mut left, mut beyond) = (depth_before(state, place, stage), 0.0);
    for (leaving, (direction, sign)) in leaving.into_iter().zip(SIDES).filter(|(leaving, _)| *leaving > 0.0) {
        left -= leaving;
        beyond += leaving * sign * slopes[direction];
    }
    let share = share_of_slopes(seen[place.0][place.1], bounds, left, beyond);
    slopes.map(|slope| share * slope)
}
