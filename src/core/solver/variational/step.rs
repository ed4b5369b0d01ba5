//! One time step: leapfrog (kick, drift, kick) or Heun.
//!
//! Friction acts implicitly at the end of the step. Walls reflect ways and velocities; who crosses an open edge is taken out.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::{CHUNK, CHUNKS_AT_ONCE, MovingWater, Variational};
use crate::boundary::Path;
use crate::math::Vec2;
use crate::particles::retain_marked;
use crate::physics::friction::manning::{after_friction, resistance};

/// What a step with leapfrog keeps of a particle until its end: its velocity (m/s) half a step later.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable, serde::Serialize, serde::Deserialize)]
#[repr(C)]
pub struct HalfStep {
    velocity: Vec2,
}

/// What a step of Heun's method keeps: state and rates at its beginning.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Beginning {
    position: Vec2,
    velocity: Vec2,
    acceleration: Vec2,
}

/// State that a sub-step changes.
#[derive(Clone, Copy, Debug)]
struct Now {
    position: Vec2,
    velocity: Vec2,
    depth: f64,
}

/// Where a sub-step begins, what comes of the state, and the velocity half a step later where that is kept.
struct Drift {
    from: Vec2,
    position: Vec2,
    velocity: Vec2,
    half: Vec2,
}

/// Takes one leapfrog step; returns the volume (m³) that left.
pub fn leapfrog(formulation: &mut Variational, water: &mut MovingWater, halves: &mut Vec<HalfStep>, dt: f64) -> f64 {
    let left = drift(water, halves, |water, i, now| {
        let acceleration = water.rates[i].acceleration;
        let half = now.velocity + acceleration * (0.5 * dt);
        let friction = Friction::under(water, now);
        Drift {
            from: now.position,
            position: now.position + friction.slow(half, 0.5 * dt) * dt,
            velocity: friction.slow(now.velocity + acceleration * dt, dt),
            half,
        }
    });
    let outflow = take_out(water, halves, &left);
    formulation.evaluate(water);
    let halves = &*halves;
    finish(water, dt, |water, i, _| halves[i].velocity + water.rates[i].acceleration * (0.5 * dt));
    outflow
}

/// Takes one step of Heun's method; returns the volume (m³) that left.
pub fn heun(
    formulation: &mut Variational,
    water: &mut MovingWater,
    (halves, beginnings): (&mut Vec<HalfStep>, &mut Vec<Beginning>),
    dt: f64,
) -> f64 {
    let (particles, rates) = (&water.particles, &water.rates);
    let begin = |i: usize| Beginning {
        position: particles.position[i],
        velocity: particles.velocity[i],
        acceleration: rates[i].acceleration,
    };
    (0..particles.len()).into_par_iter().with_min_len(CHUNK).map(begin).collect_into_vec(beginnings);
    let beginnings = &*beginnings;
    drift(water, halves, |water, i, now| {
        let Beginning { position, velocity, acceleration } = beginnings[i];
        Drift {
            from: position,
            position: position + velocity * dt,
            velocity: Friction::under(water, now).slow(velocity + acceleration * dt, dt),
            half: Vec2::ZERO,
        }
    });
    formulation.evaluate(water);
    let left = drift(water, halves, |water, i, now| {
        let first = &beginnings[i];
        Drift {
            from: first.position,
            position: first.position + (first.velocity + now.velocity) * (0.5 * dt),
            velocity: first.velocity + (first.acceleration + water.rates[i].acceleration) * (0.5 * dt),
            half: Vec2::ZERO,
        }
    });
    let outflow = take_out(water, halves, &left);
    finish(water, dt, |_, _, now| now.velocity);
    formulation.evaluate(water);
    outflow
}

/// Bed friction at the place and depth of a particle.
struct Friction {
    /// (1/m)
    resistance: f64,
}

impl Friction {
    #[inline]
    fn under(water: &MovingWater, now: &Now) -> Self {
        Friction { resistance: resistance(now.depth, water.manning_at(now.position), water.gravity) }
    }

    /// A velocity (m/s) after friction of a time (s).
    #[inline]
    fn slow(&self, velocity: Vec2, time: f64) -> Vec2 {
        if self.resistance > 0.0 { after_friction(velocity, self.resistance, time) } else { velocity }
    }
}

/// Moves every particle along its way, past the walls. Returns those that left by open edges, in ascending order.
fn drift(
    water: &mut MovingWater,
    halves: &mut Vec<HalfStep>,
    advance: impl Fn(&MovingWater, usize, &Now) -> Drift + Sync,
) -> Vec<u32> {
    let count = water.particles.len();
    halves.resize(count, HalfStep::default());
    let mut position = std::mem::take(&mut water.particles.position);
    let mut velocity = std::mem::take(&mut water.particles.velocity);
    let around = &*water;
    let places = position.par_chunks_mut(CHUNK).zip(velocity.par_chunks_mut(CHUNK));
    let chunks = places.zip(halves.par_chunks_mut(CHUNK)).enumerate().with_max_len(CHUNKS_AT_ONCE);
    let move_chunk = |(chunk, ((position, velocity), halves)), near: &mut Vec<u32>| {
        let (position, velocity): (&mut [Vec2], &mut [Vec2]) = (position, velocity);
        let halves: &mut [HalfStep] = halves;
        let mut left = Vec::new();
        for k in 0..position.len() {
            let i = chunk * CHUNK + k;
            let now = Now { position: position[k], velocity: velocity[k], depth: around.particles.depth[i] };
            let to = advance(around, i, &now);
            let path: Path = around.walls.travel(to.from, to.position, near);
            if path.has_left {
                left.push(i as u32);
            }
            position[k] = path.position;
            velocity[k] = path.turned(to.velocity);
            halves[k] = HalfStep { velocity: if path.is_held { Vec2::ZERO } else { path.turned(to.half) } };
        }
        left
    };
    let left: Vec<Vec<u32>> = chunks.map(|chunk| around.near_walls.with(|near| move_chunk(chunk, near))).collect();
    (water.particles.position, water.particles.velocity) = (position, velocity);
    left.concat()
}

/// Takes out the particles that left; returns their volume (m³).
fn take_out(water: &mut MovingWater, halves: &mut Vec<HalfStep>, left: &[u32]) -> f64 {
    let particles = &mut water.particles;
    if left.is_empty() {
        return 0.0;
    }
    let mut outflow = 0.0;
    let mut is_kept = vec![true; particles.len()];
    for i in left.iter().map(|&i| i as usize) {
        is_kept[i] = false;
        outflow += particles.volume[i];
    }
    particles.retain(&is_kept);
    retain_marked(halves, &is_kept);
    outflow
}

/// Sets the velocity at the end of the step, friction and dry particles included.
fn finish(water: &mut MovingWater, dt: f64, at_end: impl Fn(&MovingWater, usize, &Now) -> Vec2 + Sync) {
    let mut velocity = std::mem::take(&mut water.particles.velocity);
    let around = &*water;
    let chunks = velocity.par_chunks_mut(CHUNK).enumerate();
    chunks.with_max_len(CHUNKS_AT_ONCE).for_each(|(chunk, velocity)| {
        for (i, velocity) in (chunk * CHUNK..).zip(velocity) {
            let (position, depth) = (around.particles.position[i], around.particles.depth[i]);
            let now = Now { position, velocity: *velocity, depth };
            let is_dry = depth <= around.dry_depth;
            *velocity =
                if is_dry { Vec2::ZERO } else { Friction::under(around, &now).slow(at_end(around, i, &now), dt) };
        }
    });
    water.particles.velocity = velocity;
}
