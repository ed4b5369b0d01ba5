//! Water at the start: bodies of still water become depths of resting particles, or moving particles.

mod equal_volume;
mod lattice;
mod leaks;
mod scan_line;
mod still_water;

pub use equal_volume::equal_volume_filling;
pub use lattice::lattice_filling;
pub use leaks::Leak;
pub use still_water::{SeededVolume, StillWater, VOLUME_TOLERANCE, fill_still_water};

use crate::math::Vec2;

/// Still water inside a polygon.
#[derive(Clone, Debug, PartialEq)]
pub struct StillBody {
    /// Its outline in map coordinates (m); holes and several parts are allowed.
    pub polygon: geo::MultiPolygon<f64>,
    /// Level of its surface η (m).
    pub level: f64,
}

/// A fluid particle to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FluidSeed {
    /// Place in local coordinates (m).
    pub position: Vec2,
    /// Volume of water V (m³).
    pub volume: f64,
    /// Depth d (m): the level of its body minus the bed there.
    pub depth: f64,
}
