//! The riverbed as particles: elevation, slope and curvature on the lattice.

mod store;

pub use store::BedParticles;
