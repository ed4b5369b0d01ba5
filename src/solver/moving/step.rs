//! One time step of moving particles: leapfrog (kick, drift, kick) or Heun.
//!
//! Depth stays positive. Heun's method multiplies it by exp(Δt r), r its relative rate, which is of second order, unlike
//! d (1 + Δt r), with which the error at bores doubles. Leapfrog takes d (1 + Δt r) for growth and d / (1 − Δt r) for loss,
//! which halves the error of long oscillations against exp. Friction acts implicitly at the end of the step. Walls reflect ways and velocities; who crosses an open edge is taken out.

use rayon::prelude::*;

use super::{CHUNK, Formulation, MovingWater};
use crate::boundary::Path;
use crate::math::Vec2;
use crate::particles::Particle;
use crate::physics::friction::manning::after_friction;

/// A particle between two sub-steps.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moved {
    position: Vec2,
    velocity: Vec2,
    depth: f64,
    /// State kept for the end of the step.
    kept_position: Vec2,
    kept_velocity: Vec2,
    kept_depth: f64,
    /// Rates kept for the end of the step.
    kept_motion: Vec2,
    kept_acceleration: Vec2,
    kept_growth: f64,
    /// New smoothing length over the one before (dimensionless).
    spread: f64,
    has_left: bool,
}

/// Depth (m) after `time_step` (s) at a rate (m/s), never below the least depth unless it was.
#[inline]
fn depth_by_fraction(depth: f64, rate: f64, time_step: f64, least: f64) -> f64 {
    let growth = rate / depth * time_step;
    let after = if growth >= 0.0 { depth * (1.0 + growth) } else { depth / (1.0 - growth) };
    after.max(least.min(depth))
}

/// The same at a relative rate (1/s), by the exponential.
#[inline]
fn depth_by_exponential(depth: f64, relative_rate: f64, time_step: f64, least: f64) -> f64 {
    (depth * (relative_rate * time_step).exp()).max(least.min(depth))
}

/// Takes one leapfrog step; returns the volume (m³) that left.
pub fn leapfrog<F: Formulation>(formulation: &mut F, water: &mut MovingWater, moved: &mut Vec<Moved>, dt: f64) -> f64 {
    drift::<F>(water, moved, |water, i| {
        let rates = &water.rates[i];
        let (v, d) = (water.particles.velocity[i], water.particles.depth[i]);
        let half_velocity = v + rates.acceleration * (0.5 * dt);
        Moved {
            position: water.particles.position[i] + (slowed(water, i, half_velocity, 0.5 * dt) + rates.shift) * dt,
            velocity: slowed(water, i, v + rates.acceleration * dt, dt),
            depth: depth_by_fraction(d, rates.depth_rate, dt, water.least_depth(i)),
            kept_velocity: half_velocity,
            kept_depth: depth_by_fraction(d, rates.depth_rate, 0.5 * dt, water.least_depth(i)),
            ..Moved::default()
        }
    });
    let outflow = take_over(water, moved, true);
    water.open.drift(dt);
    formulation.evaluate(water);
    finish::<F>(water, moved, dt, |rates, moved, least| {
        (
            moved.kept_velocity + rates.acceleration * (0.5 * dt),
            depth_by_fraction(moved.kept_depth, rates.depth_rate, 0.5 * dt, least),
        )
    });
    outflow
}

/// Takes one step of Heun's method; returns the volume (m³) that left.
pub fn heun<F: Formulation>(formulation: &mut F, water: &mut MovingWater, moved: &mut Vec<Moved>, dt: f64) -> f64 {
    drift::<F>(water, moved, |water, i| {
        let rates = &water.rates[i];
        let (x, v, d) = (water.particles.position[i], water.particles.velocity[i], water.particles.depth[i]);
        Moved {
            position: x + (v + rates.shift) * dt,
            velocity: slowed(water, i, v + rates.acceleration * dt, dt),
            depth: depth_by_exponential(d, rates.depth_rate / d, dt, water.least_depth(i)),
            kept_position: x,
            kept_velocity: v,
            kept_depth: d,
            kept_motion: v + rates.shift,
            kept_acceleration: rates.acceleration,
            kept_growth: rates.depth_rate / d,
            ..Moved::default()
        }
    });
    take_over(water, moved, false);
    water.open.drift(dt);
    formulation.evaluate(water);
    let first = std::mem::take(moved);
    drift_from::<F>(
        water,
        moved,
        |i| first[i].kept_position,
        |water, i| {
            let (rates, kept) = (&water.rates[i], &first[i]);
            let growth = 0.5 * (kept.kept_growth + rates.depth_rate / water.particles.depth[i]);
            Moved {
                position: kept.kept_position
                    + (kept.kept_motion + water.particles.velocity[i] + rates.shift) * (0.5 * dt),
                velocity: kept.kept_velocity + (kept.kept_acceleration + rates.acceleration) * (0.5 * dt),
                depth: depth_by_exponential(kept.kept_depth, growth, dt, water.least_depth(i)),
                ..Moved::default()
            }
        },
    );
    let outflow = take_over(water, moved, true);
    finish::<F>(water, moved, dt, |_, moved, _| (moved.velocity, moved.depth));
    formulation.evaluate(water);
    outflow
}

/// The velocity (m/s) of particle `i` after friction of a time (s) at its present place and depth.
#[inline]
fn slowed(water: &MovingWater, i: usize, velocity: Vec2, time: f64) -> Vec2 {
    let n = water.manning_at(water.particles.position[i]);
    if n > 0.0 { after_friction(velocity, water.particles.depth[i], n, water.gravity, time) } else { velocity }
}

fn drift<F: Formulation>(
    water: &MovingWater,
    moved: &mut Vec<Moved>,
    advance: impl Fn(&MovingWater, usize) -> Moved + Sync,
) {
    drift_from::<F>(water, moved, |i| water.particles.position[i], advance);
}

/// Moves every particle along its way from `start(i)`, past the walls; its smoothing length follows its area.
fn drift_from<F: Formulation>(
    water: &MovingWater,
    moved: &mut Vec<Moved>,
    start: impl Fn(usize) -> Vec2 + Sync,
    advance: impl Fn(&MovingWater, usize) -> Moved + Sync,
) {
    moved.resize(water.particles.len(), Moved::default());
    moved.par_chunks_mut(CHUNK).enumerate().for_each_init(Vec::new, |near, (chunk, moved)| {
        for (k, moved) in moved.iter_mut().enumerate() {
            let i = chunk * CHUNK + k;
            *moved = advance(water, i);
            let path: Path = water.walls.travel(start(i), moved.position, near);
            moved.position = path.position;
            moved.velocity = path.turned(moved.velocity);
            moved.kept_velocity = if path.is_held { Vec2::ZERO } else { path.turned(moved.kept_velocity) };
            moved.has_left = path.has_left;
            let stretch = water.particles.depth[i] / moved.depth;
            moved.spread = if F::CARRIES_DEPTH { water.dimension.edge(stretch) } else { 1.0 };
        }
    });
}

/// Writes the moved state into the particles; takes out those that left when `removes`, and returns their volume (m³).
fn take_over(water: &mut MovingWater, moved: &mut Vec<Moved>, removes: bool) -> f64 {
    if removes {
        water.sections.count(&water.particles.volume, |i| moved[i].position);
    }
    let outflow = if removes && moved.par_iter().with_min_len(CHUNK).any(|moved| moved.has_left) {
        take_out(water, moved)
    } else {
        0.0
    };
    let particles = &mut water.particles;
    let places = particles.position.par_iter_mut().zip(&mut particles.velocity);
    let sizes = particles.depth.par_iter_mut().zip(&mut particles.smoothing_length);
    let all = places.zip(sizes).zip(&*moved).with_min_len(CHUNK);
    all.for_each(|(((position, velocity), (depth, smoothing_length)), moved)| {
        (*position, *velocity, *depth) = (moved.position, moved.velocity, moved.depth);
        *smoothing_length *= moved.spread;
    });
    outflow
}

/// Takes out the particles that left; returns their volume (m³).
fn take_out(water: &mut MovingWater, moved: &mut Vec<Moved>) -> f64 {
    let particles = &mut water.particles;
    let mut outflow = 0.0;
    let mut kept = 0;
    for i in 0..moved.len() {
        if moved[i].has_left {
            outflow += water.open.receive(&Particle {
                position: moved[i].position,
                velocity: moved[i].velocity,
                volume: particles.volume[i],
                depth: moved[i].depth,
                smoothing_length: particles.smoothing_length[i] * moved[i].spread,
            });
            continue;
        }
        moved[kept] = moved[i];
        particles.volume[kept] = particles.volume[i];
        particles.smoothing_length[kept] = particles.smoothing_length[i];
        kept += 1;
    }
    moved.truncate(kept);
    particles.truncate(kept);
    outflow
}

/// Sets velocity and depth at the end of the step, friction and dry particles included.
fn finish<F: Formulation>(
    water: &mut MovingWater,
    moved: &[Moved],
    dt: f64,
    end_of_step: impl Fn(&super::Rates, &Moved, f64) -> (Vec2, f64) + Sync,
) {
    let mut velocity = std::mem::take(&mut water.particles.velocity);
    let mut depth = std::mem::take(&mut water.particles.depth);
    let water_ref = &*water;
    velocity.par_chunks_mut(CHUNK).zip(depth.par_chunks_mut(CHUNK)).enumerate().for_each(
        |(chunk, (velocity, depth))| {
            for k in 0..velocity.len() {
                let i = chunk * CHUNK + k;
                let (v, d) = end_of_step(&water_ref.rates[i], &moved[i], water_ref.least_depth(i));
                if F::CARRIES_DEPTH {
                    depth[k] = d;
                }
                let n = water_ref.manning_at(water_ref.particles.position[i]);
                velocity[k] = if depth[k] <= water_ref.dry_depth {
                    Vec2::ZERO
                } else if n > 0.0 {
                    after_friction(v, depth[k], n, water_ref.gravity, dt)
                } else {
                    v
                };
            }
        },
    );
    water.particles.velocity = velocity;
    water.particles.depth = depth;
}
