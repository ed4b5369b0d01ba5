//! From what passes the faces to what the cells hold and where they are (M108), in the two stages of Heun's method (M33).

use rayon::prelude::*;

use super::super::Scale;
use super::super::state::State;
use super::super::update::{Stage, counted, take};
use super::geometry::{IN_ROWS, Way};
use super::{CHUNK, Cell, Held, MovingCells};
use crate::math::Vec2;
use crate::physics::friction::manning::kept_by_friction;

impl MovingCells {
    /// What leaves a cell: volume per second over each of its faces that lets some out.
    fn leaving(&self, state: &State, i: usize) -> f64 {
        let over = |(way, (chunk, face)): (&Way, (usize, u32))| {
            let mass = self.passing[chunk][face as usize].mass;
            way.length * if way.is_own { mass } else { -mass }.max(0.0)
        };
        let spacing = self.ground.lattice().spacing;
        let over_sides = self.sides(i).iter().map(|&side| spacing * Self::over_side(state, side).0.max(0.0));
        let own = self.ways_and_faces(i).filter(|(_, (_, face))| *face != IN_ROWS);
        own.map(over).sum::<f64>() + over_sides.sum::<f64>()
    }

    /// Scales the outflow of cells that would give more water than they have in this stage of a step (s).
    pub fn limit_outflow(&mut self, state: &mut State, stage: Stage, time_step: f64) {
        let (this, known) = (&*self, &*state);
        let share = |&i: &u32| {
            let i = i as usize;
            let volume = match stage {
                Stage::First => this.held[i].volume,
                Stage::Second => this.seen[i].depth * this.area[i],
            };
            let wanted = time_step * this.leaving(known, i);
            (wanted > volume).then(|| (i, volume.max(0.0) / wanted))
        };
        let short: Vec<(usize, f64)> = self.active.par_iter().with_min_len(CHUNK).filter_map(share).collect();
        if short.is_empty() {
            return;
        }
        for &(i, share) in &short {
            self.share[i] = share;
            let velocity = [self.seen[i].u, self.seen[i].v];
            self.sides(i).iter().for_each(|&(slot, sign)| {
                let mass = |state: &State| state.flux[slot.row][slot.direction].mass[slot.column];
                let before = mass(state);
                state.reduce((slot, sign), share);
                // What does not pass keeps the velocity of its cell.
                let carried = velocity[slot.direction] * (before - mass(state));
                let flux = &mut state.flux[slot.row][slot.direction];
                flux.normal_left[slot.column] -= carried;
                flux.normal_right[slot.column] -= carried;
            });
        }
        let MovingCells { chunks, passing, share, seen, .. } = self;
        for (passing, face) in
            passing.iter_mut().zip(chunks.iter()).flat_map(|(all, chunk)| all.iter_mut().zip(&chunk.faces))
        {
            let giver = face.ends[usize::from(passing.mass < 0.0)];
            if share[giver as usize] < 1.0 {
                let before = passing.mass;
                passing.reduce(share[giver as usize]);
                // What does not pass keeps the velocity of its cell.
                let velocity = Vec2::new(seen[giver as usize].u, seen[giver as usize].v);
                let carried = velocity.dot(face.normal) * (before - passing.mass);
                passing.lost -= carried;
                passing.gained -= carried;
            }
        }
        short.iter().for_each(|&(i, _)| share[i] = 1.0);
    }

    /// What a cell gains in a second: volume and momentum.
    fn gain(&self, state: &State, i: usize) -> (f64, Vec2) {
        let (mut volume, mut momentum) = (0.0, Vec2::ZERO);
        let spacing = self.ground.lattice().spacing;
        for &side in self.sides(i) {
            let (mass, out) = Self::over_side(state, side);
            volume -= spacing * mass;
            momentum = momentum - out * spacing;
        }
        for (way, (chunk, face)) in self.ways_and_faces(i).filter(|(_, (_, face))| *face != IN_ROWS) {
            let passing = &self.passing[chunk][face as usize];
            // The tangent of the face is that of its first cell.
            let tangent = way.normal.perpendicular() * passing.tangential;
            if way.is_own {
                volume -= way.length * passing.mass;
                momentum = momentum - (way.normal * passing.lost + tangent) * way.length;
            } else {
                volume += way.length * passing.mass;
                momentum += (way.normal * -passing.gained - tangent) * way.length;
            }
        }
        (volume, momentum)
    }

    /// Takes a stage of a step (s): volumes, momenta and places, and the partition of these.
    pub fn update(&mut self, state: &State, scale: &Scale, stage: Stage, time_step: f64) {
        if self.is_lost {
            return;
        }
        let half = 0.5 * time_step;
        self.wake_beside_films(state);
        self.carry(state, (stage, time_step), scale.dry_depth);
        let this = &*self;
        let taken = |&i: &u32| {
            let i = i as usize;
            let (volume, momentum) = this.gain(state, i);
            let held = this.held[i];
            let (left_volume, volume) = take(held.volume, half * volume, stage.ahead());
            let (left_x, x) = take(held.momentum.x, half * momentum.x, stage.ahead());
            let (left_y, y) = take(held.momentum.y, half * momentum.y, stage.ahead());
            let moved = this.motion[i] * half;
            let left_place = held.place + moved;
            let place = left_place + moved * stage.ahead();
            let left = Held { volume: left_volume, momentum: Vec2::new(left_x, left_y), place: left_place };
            // What is not a number stays, so that the watch sees it.
            let volume = if volume < 0.0 { 0.0 } else { volume };
            (left, Held { volume, momentum: Vec2::new(x, y), place })
        };
        let all: Vec<(Held, Held)> = self.active.par_iter().with_min_len(CHUNK).map(taken).collect();
        let mut ways: Vec<(u32, Vec2)> = Vec::with_capacity(self.active.len());
        for (&i, (left, next)) in self.active.iter().zip(all) {
            let i = i as usize;
            self.held[i] = left;
            self.next[i] = next;
            // Where there is no number nothing moves: the watch sees it after the step.
            let is_place = next.place.x.is_finite() && next.place.y.is_finite();
            if self.cells[i] == Cell::Free && is_place && next.place != self.mesh.place(i as u32) {
                ways.push((i as u32, next.place));
                self.has_moved[i] = true;
            }
        }
        if !ways.is_empty() {
            let has_moved = &self.has_moved;
            let moved = self.mesh.advance(&ways, |place| has_moved[place as usize]);
            self.counts.renewals += u64::from(moved.is_renewed);
            self.sink();
            self.is_lost = moved.is_lost;
            if moved.is_lost {
                self.next[ways[0].0 as usize].volume = f64::NAN;
            } else {
                self.partition(true);
            }
            ways.iter().for_each(|&(i, _)| self.has_moved[i as usize] = false);
        }
        self.slow(scale, time_step);
        if stage == Stage::Second {
            for &i in &self.active {
                self.held[i as usize] = self.next[i as usize];
            }
        }
    }

    /// Makes those pinned cells active from or to which the rows let a film pass.
    fn wake_beside_films(&mut self, state: &State) {
        let has_passed = |k: usize| self.sides(k).iter().any(|&side| Self::over_side(state, side).0 != 0.0);
        let idle = self.pinned.iter().copied().filter(|&k| !self.is_active[k as usize] && has_passed(k as usize));
        for k in idle.collect::<Vec<u32>>() {
            self.wake(k);
            self.is_stale[k as usize / CHUNK] = true;
        }
    }

    /// The bed under the cells that moved.
    fn sink(&mut self) {
        let MovingCells { seen, friction, is_active, has_moved, mesh, ground, .. } = self;
        let (is_active, has_moved, mesh, ground) = (&*is_active, &*has_moved, &*mesh, &*ground);
        let chunks = seen.par_chunks_mut(CHUNK).zip(friction.par_chunks_mut(CHUNK));
        chunks.enumerate().for_each(|(number, (seen, friction))| {
            for (k, (seen, friction)) in seen.iter_mut().zip(friction).enumerate() {
                let i = number * CHUNK + k;
                if is_active[i] && has_moved[i] {
                    (seen.bed, *friction) = ground.at(mesh.place(i as u32));
                }
            }
        });
    }

    /// Friction of a step (s) on what the active cells hold next.
    fn slow(&mut self, scale: &Scale, time_step: f64) {
        for &i in &self.active {
            let i = i as usize;
            let next = &mut self.next[i];
            let depth = next.volume / self.area[i];
            let speed = next.momentum.norm() / next.volume;
            let slowed = kept_by_friction(speed, depth, self.friction[i] * time_step);
            let kept = if depth <= scale.dry_depth { 0.0 } else { slowed };
            next.momentum = Vec2::new(counted(kept * next.momentum.x), counted(kept * next.momentum.y));
        }
    }

    /// What a stage leaves for the next one: cells are exchanged at the end of a step, and what the faces see is found.
    pub fn settle(&mut self, scale: &Scale, stage: Stage) {
        if self.is_lost {
            return self.see(scale.dry_depth);
        }
        if stage == Stage::Second {
            self.exchange();
            for &i in &self.active {
                self.next[i as usize] = self.held[i as usize];
            }
        }
        self.see(scale.dry_depth);
        // Cells may have got neighbours that were too far away to be active, or have become active beside films.
        let is_stale = || self.is_stale.contains(&true) || self.has_idle_beside(scale.dry_depth);
        if stage == Stage::Second || is_stale() {
            self.find_active(scale.dry_depth);
            self.partition(false);
        }
        self.find_motion(scale);
        if stage == Stage::Second {
            self.find_pace(scale);
        }
    }

    /// Whether a cell beside water is not active.
    fn has_idle_beside(&self, dry_depth: f64) -> bool {
        self.active.iter().any(|&i| self.is_beside_idle[i as usize] && self.seen[i as usize].depth > dry_depth)
    }

    /// Adds rain: its depth (m) by cell of the lattice; returns its volume (m³).
    pub fn rain(&mut self, depth: impl Fn(usize) -> f64) -> f64 {
        let (mut fallen, mut is_new) = (0.0, false);
        for i in 0..self.cells.len() {
            if matches!(self.cells[i], Cell::Fixed(_) | Cell::Gone) {
                continue;
            }
            let Some(cell) = self.ground.lattice().cell_at(self.mesh.place(i as u32)) else { continue };
            let volume = depth(cell) * self.area[i];
            self.tracers.rain(i, self.held[i].volume, volume);
            self.held[i].volume += volume;
            fallen += volume;
            if !self.is_active[i] && volume > 0.0 {
                self.wake(i as u32);
                is_new = true;
            }
        }
        if is_new {
            self.is_stale.fill(true);
        }
        fallen
    }
}
