//! One time step of moving particles: leapfrog (kick, drift, kick) or Heun.
//!
//! Depth stays positive. With r its relative rate, at the depth for which that was found, Heun's method multiplies it by exp(r Δt);
//! leapfrog by 1 + x + x²/2 where it grows and divides it by that where it falls, x = |r| Δt. Both are of second order, unlike
//! d (1 + r Δt), with which the error at bores doubles; with leapfrog's longer steps exp would leave nothing of a film that runs off a
//! steep bank. Friction acts implicitly at the end of the step. Walls reflect ways and velocities; who crosses an open edge is taken out.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::{CHUNK, CHUNKS_AT_ONCE, Formulation, MovingWater};
use crate::boundary::Path;
use crate::math::Vec2;
use crate::particles::retain_marked;
use crate::physics::friction::manning::{after_friction, resistance};

/// What a step with leapfrog keeps of a particle until its end: its state half a step later.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct HalfStep {
    velocity: Vec2,
    depth: f64,
}

/// What a step of Heun's method keeps: state and rates at its beginning.
#[derive(Clone, Copy, Debug, Default)]
pub struct Beginning {
    position: Vec2,
    velocity: Vec2,
    depth: f64,
    motion: Vec2,
    acceleration: Vec2,
    growth: f64,
}

/// State that a sub-step changes.
#[derive(Clone, Copy, Debug)]
struct Now {
    position: Vec2,
    velocity: Vec2,
    depth: f64,
}

/// Where a sub-step begins, what comes of the state, and the state half a step later where that is kept.
struct Drift {
    from: Vec2,
    to: Now,
    half: HalfStep,
}

/// Depth (m) after `time_step` (s) at a relative rate (1/s), never below the least depth unless it was; by fractions.
#[inline]
fn depth_by_fraction(depth: f64, relative_rate: f64, time_step: f64, least: f64) -> f64 {
    let x = (relative_rate * time_step).abs();
    let factor = 1.0 + x + 0.5 * x * x;
    let after = if relative_rate >= 0.0 { depth * factor } else { depth / factor };
    after.max(least.min(depth))
}

/// The same by the exponential.
#[inline]
fn depth_by_exponential(depth: f64, relative_rate: f64, time_step: f64, least: f64) -> f64 {
    (depth * (relative_rate * time_step).exp()).max(least.min(depth))
}

/// Takes one leapfrog step; returns the volume (m³) that left.
pub fn leapfrog<F: Formulation>(
    formulation: &mut F,
    water: &mut MovingWater,
    halves: &mut Vec<HalfStep>,
    dt: f64,
) -> f64 {
    let left = drift::<F>(water, halves, |water, i, now| {
        let (rates, least) = (&water.rates[i], water.least_depth(i));
        let growth = rates.depth_rate / now.depth;
        let half_velocity = now.velocity + rates.acceleration * (0.5 * dt);
        let friction = Friction::under(water, now);
        let to = Now {
            position: now.position + (friction.slow(half_velocity, 0.5 * dt) + rates.shift) * dt,
            velocity: friction.slow(now.velocity + rates.acceleration * dt, dt),
            depth: depth_by_fraction(now.depth, growth, dt, least),
        };
        let half_depth = depth_by_fraction(now.depth, growth, 0.5 * dt, least);
        Drift { from: now.position, to, half: HalfStep { velocity: half_velocity, depth: half_depth } }
    });
    // Before those that leave join it: they have gone their way.
    water.open.drift(dt);
    let outflow = take_out(water, halves, &left);
    formulation.evaluate(water);
    let halves = &*halves;
    finish::<F>(water, dt, |water, i, now| {
        let (rates, half) = (&water.rates[i], &halves[i]);
        // The rate belongs to the depth at which it was found, not to that of the half step.
        let growth = rates.depth_rate / now.depth;
        (
            half.velocity + rates.acceleration * (0.5 * dt),
            depth_by_fraction(half.depth, growth, 0.5 * dt, water.least_depth(i)),
        )
    });
    outflow
}

/// Takes one step of Heun's method; returns the volume (m³) that left.
pub fn heun<F: Formulation>(
    formulation: &mut F,
    water: &mut MovingWater,
    (halves, beginnings): (&mut Vec<HalfStep>, &mut Vec<Beginning>),
    dt: f64,
) -> f64 {
    let (particles, rates) = (&water.particles, &water.rates);
    let begin = |i: usize| {
        let (velocity, depth) = (particles.velocity[i], particles.depth[i]);
        Beginning {
            position: particles.position[i],
            velocity,
            depth,
            motion: velocity + rates[i].shift,
            acceleration: rates[i].acceleration,
            growth: rates[i].depth_rate / depth,
        }
    };
    (0..particles.len()).into_par_iter().with_min_len(CHUNK).map(begin).collect_into_vec(beginnings);
    let beginnings = &*beginnings;
    drift::<F>(water, halves, |water, i, now| {
        let Beginning { position, velocity, depth, motion, acceleration, growth } = beginnings[i];
        let to = Now {
            position: position + motion * dt,
            velocity: Friction::under(water, now).slow(velocity + acceleration * dt, dt),
            depth: depth_by_exponential(depth, growth, dt, water.least_depth(i)),
        };
        Drift { from: position, to, half: HalfStep::default() }
    });
    water.open.drift(dt);
    formulation.evaluate(water);
    let left = drift::<F>(water, halves, |water, i, now| {
        let (rates, first) = (&water.rates[i], &beginnings[i]);
        let growth = 0.5 * (first.growth + rates.depth_rate / now.depth);
        let to = Now {
            position: first.position + (first.motion + now.velocity + rates.shift) * (0.5 * dt),
            velocity: first.velocity + (first.acceleration + rates.acceleration) * (0.5 * dt),
            depth: depth_by_exponential(first.depth, growth, dt, water.least_depth(i)),
        };
        Drift { from: first.position, to, half: HalfStep::default() }
    });
    let outflow = take_out(water, halves, &left);
    finish::<F>(water, dt, |_, _, now| (now.velocity, now.depth));
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

/// Moves every particle along its way, past the walls; its smoothing length follows its area. Returns those that left by open edges,
/// in ascending order.
fn drift<F: Formulation>(
    water: &mut MovingWater,
    halves: &mut Vec<HalfStep>,
    advance: impl Fn(&MovingWater, usize, &Now) -> Drift + Sync,
) -> Vec<u32> {
    let count = water.particles.len();
    halves.resize(count, HalfStep::default());
    let mut position = std::mem::take(&mut water.particles.position);
    let mut velocity = std::mem::take(&mut water.particles.velocity);
    let mut depth = std::mem::take(&mut water.particles.depth);
    let mut smoothing_length = std::mem::take(&mut water.particles.smoothing_length);
    let around = &*water;
    let places = position.par_chunks_mut(CHUNK).zip(velocity.par_chunks_mut(CHUNK));
    let sizes = depth.par_chunks_mut(CHUNK).zip(smoothing_length.par_chunks_mut(CHUNK));
    let chunks = places.zip(sizes).zip(halves.par_chunks_mut(CHUNK)).enumerate().with_max_len(CHUNKS_AT_ONCE);
    let move_chunk = |(chunk, (((position, velocity), (depth, smoothing_length)), halves)), near: &mut Vec<u32>| {
        let (position, velocity): (&mut [Vec2], &mut [Vec2]) = (position, velocity);
        let (depth, smoothing_length): (&mut [f64], &mut [f64]) = (depth, smoothing_length);
        let halves: &mut [HalfStep] = halves;
        let mut left = Vec::new();
        for k in 0..position.len() {
            let i = chunk * CHUNK + k;
            let now = Now { position: position[k], velocity: velocity[k], depth: depth[k] };
            let Drift { from, to, half } = advance(around, i, &now);
            let path: Path = around.walls.travel(from, to.position, near);
            if path.has_left {
                left.push(i as u32);
            }
            position[k] = path.position;
            velocity[k] = path.turned(to.velocity);
            depth[k] = to.depth;
            let half_velocity = if path.is_held { Vec2::ZERO } else { path.turned(half.velocity) };
            halves[k] = HalfStep { velocity: half_velocity, ..half };
            if F::CARRIES_DEPTH {
                smoothing_length[k] *= around.dimension.edge(now.depth / to.depth);
            }
        }
        left
    };
    let left: Vec<Vec<u32>> = chunks.map(|chunk| around.near_walls.with(|near| move_chunk(chunk, near))).collect();
    let particles = &mut water.particles;
    (particles.position, particles.velocity) = (position, velocity);
    (particles.depth, particles.smoothing_length) = (depth, smoothing_length);
    left.concat()
}

/// Takes out the particles that left; returns their volume (m³).
fn take_out(water: &mut MovingWater, halves: &mut Vec<HalfStep>, left: &[u32]) -> f64 {
    let particles = &mut water.particles;
    water.sections.count(&particles.volume, |i| particles.position[i]);
    if left.is_empty() {
        return 0.0;
    }
    let mut outflow = 0.0;
    let mut is_kept = vec![true; particles.len()];
    for i in left.iter().map(|&i| i as usize) {
        is_kept[i] = false;
        outflow += water.open.receive(&particles.at(i));
    }
    particles.retain(&is_kept);
    retain_marked(halves, &is_kept);
    outflow
}

/// Sets velocity and depth at the end of the step, friction and dry particles included.
fn finish<F: Formulation>(
    water: &mut MovingWater,
    dt: f64,
    end_of_step: impl Fn(&MovingWater, usize, &Now) -> (Vec2, f64) + Sync,
) {
    let mut velocity = std::mem::take(&mut water.particles.velocity);
    let mut depth = std::mem::take(&mut water.particles.depth);
    let around = &*water;
    let chunks = velocity.par_chunks_mut(CHUNK).zip(depth.par_chunks_mut(CHUNK)).enumerate();
    chunks.with_max_len(CHUNKS_AT_ONCE).for_each(|(chunk, (velocity, depth))| {
        for k in 0..velocity.len() {
            let i = chunk * CHUNK + k;
            let mut now = Now { position: around.particles.position[i], velocity: velocity[k], depth: depth[k] };
            let (v, d) = end_of_step(around, i, &now);
            if F::CARRIES_DEPTH {
                now.depth = d;
            }
            depth[k] = now.depth;
            let is_dry = now.depth <= around.dry_depth;
            velocity[k] = if is_dry { Vec2::ZERO } else { Friction::under(around, &now).slow(v, dt) };
        }
    });
    water.particles.velocity = velocity;
    water.particles.depth = depth;
}
