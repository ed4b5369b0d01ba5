//! Particles that carry water. Knows no physics.

mod fluid;

pub use fluid::{FluidParticles, FluidSeed, Particle, retain_marked};
