//! The riverbed as particles: elevation, roughness and curvature on the lattice, and the bed between the particles.

mod noise;
mod pass_sill;
mod place;
mod ridge;
mod sample;
mod store;

pub use noise::noise_in_cells;
pub use pass_sill::{PassSill, PassSills, Pixels, SHUT};
pub use place::{derive_curvatures, place_bed};
pub use ridge::Ridges;
pub use sample::BedPoint;
pub use store::BedParticles;

use crate::math::Vec2;

/// Terrain as the riverbed needs it, whatever it is made of; map coordinates throughout.
pub trait Surface: Sync {
    /// Elevation (m) at a place, or `None` where there is no terrain.
    fn elevation(&self, map: Vec2) -> Option<f64>;

    /// Elevation (m) at a place, of which the means over cells of a spacing (m) are those of the terrain's own values; the elevation
    /// itself where it has none.
    fn mean_preserving_elevation(&self, map: Vec2, _spacing: f64) -> Option<f64> {
        self.elevation(map)
    }

    /// Appends the terrain's own points (centres of raster cells, survey points) within `radius` (m) of a place, each with
    /// its elevation (m). Points without data are left out. The order is the same at every call.
    fn samples(&self, centre: Vec2, radius: f64, out: &mut Vec<(Vec2, f64)>);
}

impl Surface for crate::terrain::Terrain {
    fn elevation(&self, map: Vec2) -> Option<f64> {
        crate::terrain::Terrain::elevation(self, map)
    }

    fn mean_preserving_elevation(&self, map: Vec2, spacing: f64) -> Option<f64> {
        crate::terrain::Terrain::mean_preserving_elevation(self, map, spacing)
    }

    fn samples(&self, centre: Vec2, radius: f64, out: &mut Vec<(Vec2, f64)>) {
        crate::terrain::Terrain::samples(self, centre, radius, out);
    }
}
