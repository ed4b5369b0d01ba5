//! Tracers in cells that move: what passes the faces takes the concentration of the side it comes from (M111), the rest goes with the cells.

use rayon::prelude::*;

use super::super::concentrations::{Given, Tracers};
use super::super::state::State;
use super::super::update::Stage;
use super::geometry::{IN_ROWS, Way};
use super::{CHUNK, Cell, MovingCells};
use crate::math::Vec2;
use crate::physics::tracer::{Mixture, at_face, share_of_slopes};
use crate::solver::TracerLedger;

/// One tracer in all cells of the partition, by number.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct OfTracer {
    /// C as the faces see it.
    pub seen: Vec<f64>,
    /// C at the start of the step.
    start: Vec<f64>,
    /// ∇C, and what the share θ of it is.
    slopes: Vec<(Vec2, f64)>,
    rain: f64,
    decay: f64,
    balance: TracerLedger,
}

/// What of the tracers all cells have in common.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct OfAll {
    pub each: Vec<OfTracer>,
    /// Volume at the start of the step (m³), and whether that is noted.
    start_volume: Vec<f64>,
    is_begun: Vec<bool>,
}

impl OfAll {
    /// Makes room for so many cells.
    pub fn grow(&mut self, count: usize) {
        if self.each.is_empty() {
            return;
        }
        self.start_volume.resize(count, 0.0);
        self.is_begun.resize(count, false);
        for tracer in &mut self.each {
            tracer.seen.resize(count, 0.0);
            tracer.start.resize(count, 0.0);
            tracer.slopes.resize(count, (Vec2::ZERO, 0.0));
        }
    }

    /// Mixes a volume (m³) of one cell to that of another.
    pub fn mix(&mut self, to: u32, held: f64, from: u32, volume: f64) {
        for OfTracer { seen, .. } in &mut self.each {
            let (own, other) = (seen[to as usize], seen[from as usize]);
            seen[to as usize] = Mixture::NOTHING.with(held, own).with(volume, other).concentration_or(own);
        }
    }

    /// Fills a new cell with volumes (m³) of others.
    pub fn join(&mut self, new: usize, parts: &[(u32, f64)]) {
        for OfTracer { seen, .. } in &mut self.each {
            let with = |mixture: Mixture, &(from, volume): &(u32, f64)| mixture.with(volume, seen[from as usize]);
            seen[new] = parts.iter().fold(Mixture::NOTHING, with).concentration_or(0.0);
        }
    }

    /// Mixes rain to what a cell holds (m³).
    pub fn rain(&mut self, i: usize, held: f64, fallen: f64) {
        for OfTracer { seen, rain, balance, .. } in &mut self.each {
            seen[i] = Mixture::NOTHING.with(held, seen[i]).with(fallen, *rain).concentration_or(seen[i]);
            balance.inflow += *rain * fallen;
        }
    }
}

impl MovingCells {
    /// Takes the concentrations at the start from the rows.
    pub fn take_tracers(&mut self, tracers: &Tracers, places: impl Iterator<Item = (usize, usize)> + Clone) {
        let of = |which: usize| OfTracer {
            seen: places.clone().map(|(row, column)| tracers.seen(which, row)[column]).collect(),
            rain: tracers.given(which, Given::Rain),
            decay: tracers.decay_rate(which),
            ..OfTracer::default()
        };
        self.tracers.each = (0..tracers.len()).map(of).collect();
        let count = self.mesh.len();
        self.tracers.grow(count);
    }

    /// Looks at the squares beside the pinned cells.
    pub(super) fn look_at_tracers(&mut self, state: &State) {
        for (which, OfTracer { seen, .. }) in self.tracers.each.iter_mut().enumerate() {
            for &k in &self.fixed {
                let Cell::Fixed((row, column)) = self.cells[k as usize] else { continue };
                seen[k as usize] = state.tracers.seen(which, row)[column];
            }
        }
    }

    /// Puts the concentrations of the pinned cells into the rows.
    pub(super) fn show_tracers(&self, state: &mut State) {
        for (which, OfTracer { seen, .. }) in self.tracers.each.iter().enumerate() {
            self.pinned_places().for_each(|(k, place)| state.tracers.set(which, place, seen[k]));
        }
    }

    /// Carries the tracers through a stage of a step (s), by what passes the faces.
    pub(super) fn carry(&mut self, state: &State, (stage, time_step): (Stage, f64), dry_depth: f64) {
        if self.tracers.each.is_empty() {
            return;
        }
        self.begin_tracers(stage);
        for which in 0..self.tracers.each.len() {
            self.find_tracer_slopes(which, state, time_step, dry_depth);
            let this = &*self;
            let mixed = |&i: &u32| {
                let i = i as usize;
                let tracer = &this.tracers.each[which];
                let mixture = this.mixed(which, state, i, time_step, dry_depth);
                let own = mixture.concentration_or(tracer.seen[i]);
                match stage {
                    Stage::First => own,
                    Stage::Second => {
                        let both = Mixture::NOTHING.with(this.tracers.start_volume[i], tracer.start[i]);
                        both.with(mixture.volume(), own).concentration_or(own)
                    }
                }
            };
            let next: Vec<f64> = self.active.par_iter().with_min_len(CHUNK).map(mixed).collect();
            let seen = &mut self.tracers.each[which].seen;
            self.active.iter().zip(next).for_each(|(&i, next)| seen[i as usize] = next);
        }
    }

    /// Notes the start of the step, of cells that only take part in its second stage, too.
    fn begin_tracers(&mut self, stage: Stage) {
        let OfAll { each, start_volume, is_begun } = &mut self.tracers;
        if stage == Stage::First {
            is_begun.fill(false);
        }
        for i in self.active.iter().map(|&i| i as usize) {
            if !std::mem::replace(&mut is_begun[i], true) {
                start_volume[i] = self.next[i].volume;
                each.iter_mut().for_each(|tracer| tracer.start[i] = tracer.seen[i]);
            }
        }
    }

    /// What leaves a cell over its faces and over its sides in the rows in a step (s), in m³ and less than 0 where it comes, with the concentration
    /// there.
    fn passing_tracer<'a>(
        &'a self,
        which: usize,
        state: &'a State,
        i: usize,
        (time_step, dry_depth): (f64, f64),
    ) -> impl Iterator<Item = (f64, f64)> + 'a {
        let seen = &self.tracers.each[which].seen;
        let own = self.ways_and_faces(i).filter(|(_, (_, face))| *face != IN_ROWS);
        let over_faces = own.map(move |(way, (chunk, face))| {
            let mass = self.passing[chunk][face as usize].mass;
            let leaving = time_step * way.length * if way.is_own { mass } else { -mass };
            let j = way.to as usize;
            let there = if leaving > 0.0 {
                self.concentration_at_face(which, (i, j), way.normal * way.distance, dry_depth)
            } else {
                self.concentration_at_face(which, (j, i), way.normal * -way.distance, dry_depth)
            };
            (leaving, there)
        });
        let spacing = self.ground.lattice().spacing;
        let over_sides = self.sides(i).iter().map(move |&(slot, sign)| {
            let leaving = time_step * spacing * Self::over_side(state, (slot, sign)).0;
            let owner = (slot.row, slot.column);
            let fixed = if sign > 0.0 { super::super::rows::other(owner, slot.direction) } else { owner };
            let coming = || state.tracers.leaving(which, fixed, (slot.direction, -sign));
            (leaving, if leaving > 0.0 { seen[i] } else { coming() })
        });
        over_faces.chain(over_sides)
    }

    /// The concentration of what leaves a cell towards another, a way (m) apart (M111).
    fn concentration_at_face(&self, which: usize, (from, to): (usize, usize), way: Vec2, dry_depth: f64) -> f64 {
        let OfTracer { seen, slopes, .. } = &self.tracers.each[which];
        let (slope, share) = slopes[from];
        let is_wet = self.seen[from].depth > dry_depth && self.seen[to].depth > dry_depth;
        let difference = if is_wet { seen[to] - seen[from] } else { 0.0 };
        seen[from] + share * at_face(2.0 * slope.dot(way) - difference, difference)
    }

    /// The water of a cell after an Euler step.
    fn mixed(&self, which: usize, state: &State, i: usize, time_step: f64, dry_depth: f64) -> Mixture {
        let own = self.tracers.each[which].seen[i];
        let (mut left, mut beyond, mut coming) = (self.next[i].volume, 0.0, Mixture::NOTHING);
        for (leaving, there) in self.passing_tracer(which, state, i, (time_step, dry_depth)) {
            if leaving > 0.0 {
                left -= leaving;
                beyond += leaving * (there - own);
            } else {
                coming = coming.with(-leaving, there);
            }
        }
        let [least, greatest] = self.bounds_about(which, i, dry_depth);
        let kept = if left > 0.0 { (own - beyond / left).clamp(least, greatest) } else { own };
        coming.with(left, kept)
    }

    /// The least and the greatest concentration of a cell and the wet ones about it.
    fn bounds_about(&self, which: usize, i: usize, dry_depth: f64) -> [f64; 2] {
        let seen = &self.tracers.each[which].seen;
        let wet = self.ways(i).filter(|way| self.seen[way.to as usize].depth > dry_depth);
        wet.map(|way| seen[way.to as usize])
            .fold([seen[i]; 2], |[least, greatest], there| [least.min(there), greatest.max(there)])
    }

    /// The ways of a cell to its neighbours.
    fn ways(&self, i: usize) -> impl Iterator<Item = &Way> {
        self.chunks[i / CHUNK].ways(i % CHUNK).iter()
    }

    /// Finds the gradients (M105) of the active cells that move, and their shares (M112).
    fn find_tracer_slopes(&mut self, which: usize, state: &State, time_step: f64, dry_depth: f64) {
        let this = &*self;
        let slope = |&i: &u32| {
            let i = i as usize;
            let seen = &this.tracers.each[which].seen;
            if this.cells[i] != Cell::Free || this.seen[i].depth <= dry_depth {
                return Vec2::ZERO;
            }
            let wet = this.ways(i).filter(|way| this.seen[way.to as usize].depth > dry_depth);
            let sum = wet.map(|way| way.weight() * (seen[way.to as usize] - seen[i])).fold(Vec2::ZERO, |a, b| a + b);
            sum * (1.0 / this.area[i])
        };
        let slopes: Vec<Vec2> = self.active.par_iter().with_min_len(CHUNK).map(slope).collect();
        let of = &mut self.tracers.each[which].slopes;
        of.iter_mut().for_each(|slope| *slope = (Vec2::ZERO, 0.0));
        self.active.iter().zip(slopes).for_each(|(&i, slope)| {
            of[i as usize] = (slope, if self.cells[i as usize] == Cell::Free { 1.0 } else { 0.0 });
        });
        let this = &*self;
        let share = |&i: &u32| {
            let i = i as usize;
            let (own, volume) = (this.tracers.each[which].seen[i], this.next[i].volume);
            let leaving =
                this.passing_tracer(which, state, i, (time_step, dry_depth)).filter(|(leaving, _)| *leaving > 0.0);
            let sum = |(left, beyond): (f64, f64), (leaving, there): (f64, f64)| {
                (left - leaving, beyond + leaving * (there - own))
            };
            let (left, beyond) = leaving.fold((volume, 0.0), sum);
            share_of_slopes(own, this.bounds_about(which, i, dry_depth), left, beyond)
        };
        let shares: Vec<f64> = self.active.par_iter().with_min_len(CHUNK).map(share).collect();
        let of = &mut self.tracers.each[which].slopes;
        self.active.iter().zip(shares).for_each(|(&i, share)| of[i as usize].1 *= share);
    }

    /// Lets the tracers decay over a step (s).
    pub fn decay_tracers(&mut self, time_step: f64) {
        for which in 0..self.tracers.each.len() {
            let rate = self.tracers.each[which].decay;
            if rate > 0.0 {
                let kept = (-rate * time_step).exp();
                let stored = self.tracer_ledger(which).stored;
                let tracer = &mut self.tracers.each[which];
                tracer.balance.decayed += (1.0 - kept) * stored;
                tracer.seen.iter_mut().for_each(|seen| *seen *= kept);
            }
        }
    }

    /// What rained and decayed of a tracer in these cells, and what is there.
    pub fn tracer_ledger(&self, which: usize) -> TracerLedger {
        let OfTracer { seen, balance, .. } = &self.tracers.each[which];
        let own = self.held.iter().zip(&self.cells).zip(seen).filter(|((_, cell), _)| !cell.is_fixed());
        TracerLedger { stored: own.map(|((held, _), seen)| held.volume * seen).sum(), ..*balance }
    }

    /// The integral of C² of a tracer over the water of these cells.
    #[cfg(test)]
    pub fn tracer_square(&self, which: usize) -> f64 {
        let own = self.held.iter().zip(&self.cells).zip(&self.tracers.each[which].seen);
        own.filter(|((_, cell), _)| !cell.is_fixed()).map(|((held, _), seen)| held.volume * seen * seen).sum()
    }
}
