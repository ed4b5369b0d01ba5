//! The bed under moving particles that changes: a dam that breaks (M46), ground that moves (M47), (M48).
//!
//! Before a step the bed goes to its end, where the rates are evaluated: kick and drift then see the bed of their own time. What goes all
//! at once does so between two steps, and the rates are evaluated anew. Particles keep their depth and their velocity, so that their
//! surface moves with the bed and no volume is made or lost. The dam is a wall where it stands dry (`dam_walls`), and a ridge
//! (`bed::Ridges`) as long as it stands above the ground.
//! Not here: curvatures, which the variational formulation alone has a use for, and which knows no bed that changes.

use rayon::prelude::*;

use super::dam_walls::DamWalls;
use super::open::look::Look;
use super::{CHUNK, MovingWater};
use crate::math::Vec2;
use crate::physics::dimension::Dimension;
use crate::solver::BedBalance;
use crate::solver::changing_bed::{BreakingDam, MovingGround};

/// All of the bed that changes.
#[derive(Debug)]
pub(super) struct ChangingBed {
    dam: Option<BreakingDam>,
    walls: Option<DamWalls>,
    /// The water where the level of the dam's trigger is watched.
    watched: Option<Look>,
    ground: Option<MovingGround>,
    /// The cells of both and their bed (m).
    bed: Vec<(usize, f64)>,
}

impl ChangingBed {
    /// None where nothing changes. Sets the bed of the start, as far as no level decides about it.
    pub fn new(
        (dam, ground): (Option<BreakingDam>, Option<MovingGround>),
        water: &mut MovingWater,
        dimension: Dimension,
    ) -> Option<Self> {
        if dam.is_none() && ground.is_none() {
            return None;
        }
        let watched = dam.as_ref().and_then(BreakingDam::watched).map(|place| Look::at(place, dimension));
        let mut changing = ChangingBed { dam, walls: None, watched, ground, bed: Vec::new() };
        if let Some(dam) = &mut changing.dam {
            let standing = || dam.standing().filter(|(_, stands)| *stands).map(|(cell, _)| cell);
            water.bed.set_ridges(standing());
            changing.walls = Some(DamWalls::new(water, standing()));
            dam.watch(0.0, |_| None);
        }
        changing.follow(water, 0.0, 0.0);
        changing.release(water);
        changing.hand_out();
        Some(changing)
    }

    /// Sets the bed of the end of a step between two times (s); whether it changed.
    pub fn begin_step(&mut self, water: &mut MovingWater, from: f64, to: f64) -> bool {
        self.follow(water, to, from)
    }

    /// Sets the bed of a time (s) at the end of a step; whether it changed from that of `begin_step`.
    pub fn end_step(&mut self, water: &mut MovingWater, time: f64) -> bool {
        if let Some(dam) = &mut self.dam {
            dam.watch(time, |place| {
                let seen = self.watched.as_mut()?.look_at(place, &water.particles, &water.bed);
                let ground = water.bed.at(place)?.elevation;
                (seen.is_water() && seen.surface > ground + water.dry_depth).then_some(seen.surface)
            });
        }
        let has_jumped = self.follow(water, time, time);
        self.release(water);
        self.hand_out();
        has_jumped
    }

    fn follow(&mut self, water: &mut MovingWater, time: f64, at_once: f64) -> bool {
        let mut has_changed = false;
        if let Some(dam) = &mut self.dam
            && dam.follow(time)
        {
            dam.bed().iter().for_each(|&(cell, bed)| water.bed.elevation[cell] = bed);
            dam.standing().for_each(|(cell, stands)| water.bed.mark_ridge(cell, stands));
            has_changed = true;
        }
        if let Some(ground) = &mut self.ground
            && ground.follow(time, at_once)
        {
            let before = elevations(water);
            let bed = ground.bed();
            ground.rises().for_each(|(k, _)| water.bed.elevation[bed[k].0] = bed[k].1);
            for volume in moved(water, &before) {
                ground.book(volume);
            }
            has_changed = true;
        }
        has_changed
    }

    fn release(&mut self, water: &mut MovingWater) {
        if let (Some(walls), Some(dam)) = (&mut self.walls, &self.dam) {
            walls.release(water, dam.standing());
        }
    }

    fn hand_out(&mut self) {
        self.bed.clear();
        let dam = self.dam.iter().flat_map(|dam| dam.bed());
        self.bed.extend(dam.chain(self.ground.iter().flat_map(|ground| ground.bed())));
    }

    /// A step (s) from a time on, so short that a slide goes no further than `reach` (m), and that it ends where a change begins.
    pub fn longest_step(&self, reach: f64, time: f64, step: f64) -> f64 {
        let step = self.dam.as_ref().map_or(step, |dam| dam.step_until_change(time, step));
        self.ground.as_ref().map_or(step, |ground| ground.longest_step(reach, time, step))
    }

    /// The cells whose bed may change, and their bed (m) at the end of the latest step.
    pub fn bed(&self) -> &[(usize, f64)] {
        &self.bed
    }

    /// The time (s) at which the dam began to break, once it did.
    pub fn breach_began(&self) -> Option<f64> {
        self.dam.as_ref().and_then(BreakingDam::opened)
    }

    /// What the ground that moves has done; none where there is none.
    pub fn balance(&self) -> Option<BedBalance> {
        self.ground.as_ref().map(MovingGround::balance)
    }
}

/// The bed (m) under each particle.
fn elevations(water: &MovingWater) -> Vec<f64> {
    let elevation = |place: &Vec2| water.bed_at(*place).elevation;
    water.particles.position.par_iter().with_min_len(CHUNK).map(elevation).collect()
}

/// The volumes (m³) by which the bed lifted and lowered (negative) the water on it, since it had the elevations (m) of before.
fn moved(water: &MovingWater, before: &[f64]) -> [f64; 2] {
    let particles = &water.particles;
    let mut volumes = [0.0; 2];
    for ((i, before), now) in before.iter().enumerate().zip(elevations(water)) {
        if particles.depth[i] > water.dry_depth {
            let volume = particles.volume[i] / particles.depth[i] * (now - before);
            volumes[usize::from(volume < 0.0)] += volume;
        }
    }
    volumes
}

#[cfg(test)]
mod tests;
