//! Fluid particles that move with the water: one `Vec` for each quantity, in an order that keeps near particles together.

use crate::math::Vec2;

/// Eight numbers of a particle, one cache line, whose meaning is that of whoever works with them.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable, serde::Serialize, serde::Deserialize)]
#[repr(C, align(64))]
pub struct Line([f64; 8]);

/// A fluid particle as seeding makes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FluidSeed {
    /// Local coordinates (m).
    pub position: Vec2,
    /// Volume of its water (m³; in one dimension m² per metre of width), above 0; constant in time.
    pub volume: f64,
    /// Depth (m), above 0: level minus the bed at the very position.
    pub depth: f64,
}

/// One fluid particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// Local coordinates (m).
    pub position: Vec2,
    /// Velocity (m/s).
    pub velocity: Vec2,
    /// Volume (m³).
    pub volume: f64,
    /// Depth (m).
    pub depth: f64,
    /// Smoothing length h (m).
    pub smoothing_length: f64,
    /// V̂ (m³), by which the smoothing length follows the depth.
    pub share: f64,
}

/// The moving state of all fluid particles. All vectors have the same length.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct FluidParticles {
    /// Local coordinates (m).
    pub position: Vec<Vec2>,
    /// Velocity (m/s).
    pub velocity: Vec<Vec2>,
    /// Volume (m³).
    pub volume: Vec<f64>,
    /// Depth (m).
    pub depth: Vec<f64>,
    /// Smoothing length h (m).
    pub smoothing_length: Vec<f64>,
    /// V̂ (m³), by which the smoothing length follows the depth.
    pub share: Vec<f64>,
}

/// Keeps those values only whose particles are marked, in their order.
pub fn retain_marked<T>(values: &mut Vec<T>, is_kept: &[bool]) {
    let mut marks = is_kept.iter();
    values.retain(|_| marks.next() == Some(&true));
}

impl FluidParticles {
    /// Particles at rest; smoothing lengths are left at 0 for the solver to choose.
    pub fn from_seeds(seeds: &[FluidSeed]) -> Self {
        FluidParticles {
            position: seeds.iter().map(|seed| seed.position).collect(),
            velocity: vec![Vec2::ZERO; seeds.len()],
            volume: seeds.iter().map(|seed| seed.volume).collect(),
            depth: seeds.iter().map(|seed| seed.depth).collect(),
            smoothing_length: vec![0.0; seeds.len()],
            share: seeds.iter().map(|seed| seed.volume).collect(),
        }
    }

    /// Adds a particle at the end.
    pub fn push(&mut self, particle: &Particle) {
        self.position.push(particle.position);
        self.velocity.push(particle.velocity);
        self.volume.push(particle.volume);
        self.depth.push(particle.depth);
        self.smoothing_length.push(particle.smoothing_length);
        self.share.push(particle.share);
    }

    /// Keeps those particles only that are marked, in their order.
    pub fn retain(&mut self, is_kept: &[bool]) {
        retain_marked(&mut self.position, is_kept);
        retain_marked(&mut self.velocity, is_kept);
        retain_marked(&mut self.volume, is_kept);
        retain_marked(&mut self.depth, is_kept);
        retain_marked(&mut self.smoothing_length, is_kept);
        retain_marked(&mut self.share, is_kept);
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }
}
