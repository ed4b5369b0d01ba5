//! Water at the start: bodies of still water become depths of cells, or particles of the variational formulation.

mod equal_volume;
mod lattice;
mod leaks;
mod reach;
mod scan;
mod scan_line;
mod shore;
mod still_water;

pub use crate::particles::FluidSeed;
pub use equal_volume::{equal_volume_filling, mean_cell_volume};
pub use lattice::lattice_filling;
pub use leaks::{Barriers, Leak};
pub use reach::{Reach, reach};
pub use still_water::{SeededVolume, StillWater, VOLUME_TOLERANCE, fill_still_water};

/// Still water inside a polygon.
#[derive(Clone, Debug, PartialEq)]
pub struct StillBody {
    /// Its outline in map coordinates (m); holes and several parts are allowed.
    pub polygon: geo::MultiPolygon<f64>,
    /// Level of its surface η (m).
    pub level: f64,
}
