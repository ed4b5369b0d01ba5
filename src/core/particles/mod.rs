//! Particles that carry water. Knows no physics.

mod fluid;

pub use fluid::{FluidParticles, FluidSeed, Line, Particle, retain_marked};
