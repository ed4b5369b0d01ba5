//! The riverbed as particles: elevation, roughness and curvature on the lattice, and the bed between the particles.

mod cover;
mod fence;
mod fit;
mod gap;
mod mean;
mod morphology;
mod noise;
mod pass_sill;
mod place;
mod sample;
mod sill;
mod spill;
mod store;
mod upright;

pub use cover::{CellInPart, Cover, FaceInPart};
pub use gap::ground_in_gaps;
pub use mean::plane_at_middle;
pub use noise::noise_in_cells;
pub use place::{derive_curvatures, place_bed, place_bed_with};
pub use sample::BedPoint;
pub use sill::{PassSill, PassSills, Pixels, SHUT};
pub use spill::spill_levels;
pub use store::BedParticles;
pub use upright::{NINE_CELLS, Step, highest_step, is_divided_about, least_step};

use crate::math::Vec2;
use crate::terrain::Piece;

/// A cell over which the terrain is one plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellPlane {
    /// Its mean (m).
    pub mean: f64,
    /// Its highest place (m).
    pub highest: f64,
}

/// Terrain as the riverbed needs it, whatever it is made of; map coordinates throughout.
pub trait Surface: Sync {
    /// Elevation (m) at a place, or `None` where there is no terrain.
    fn elevation(&self, map: Vec2) -> Option<f64>;

    /// Elevation (m) at a place, of which the means over cells of a spacing (m) are those of the terrain's own values; the elevation
    /// itself where it has none.
    fn mean_preserving_elevation(&self, map: Vec2, _spacing: f64) -> Option<f64> {
        self.elevation(map)
    }

    /// The plane of [`mean_preserving_elevation`](Self::mean_preserving_elevation) over a cell of the lattice, given by its centre (map) and
    /// its spacing (m), where the terrain is one plane there and its mean is known without a sum: a cell of a raster like that of the lattice.
    fn plane_of_cell(&self, _centre: Vec2, _spacing: f64) -> Option<CellPlane> {
        None
    }

    /// Appends the terrain's own points (centres of raster cells, survey points) within `radius` (m) of a place, each with
    /// its elevation (m). Points without data are left out. The order is the same at every call.
    fn samples(&self, centre: Vec2, radius: f64, out: &mut Vec<(Vec2, f64)>);

    /// Replaces `pieces` by those that a square of a width (m) around a place cuts out of the terrain, and of its surroundings where they
    /// are asked for; see [`crate::terrain::Terrain::pieces`]. A surface that is none of rasters is sampled on 4 by 4 places.
    fn pieces(&self, centre: Vec2, width: f64, with_surroundings: bool, pieces: &mut Vec<Piece>) {
        let along = if with_surroundings { 8 } else { 4 };
        let offset = |i: i32| (f64::from(i) + 0.5 - 0.5 * f64::from(along)) * (0.25 * width);
        pieces.clear();
        for i in 0..along * along {
            let offset = Vec2::new(offset(i % along), offset(i / along));
            let elevation = self.elevation(centre + offset);
            pieces.extend(elevation.map(|elevation| Piece { offset, elevation, share: 1.0 }));
        }
    }

    /// Whether the terrain at a place is known by pixels no larger than a spacing (m), and not as a surface between points or larger
    /// pixels.
    fn has_pixels(&self, _map: Vec2, _spacing: f64) -> bool {
        false
    }
}

/// What stands on the terrain and does not belong to the ground beside it, such as the houses that a survey saw.
pub trait LeftOut: Sync {
    /// Whether some of it may lie in a cell or its surroundings.
    fn is_near(&self, cell: usize) -> bool;

    /// Whether a place (map) in the surroundings of a cell belongs to it.
    fn holds(&self, cell: usize, map: Vec2) -> bool;
}

/// Nothing is left out.
#[derive(Clone, Copy, Debug)]
pub struct Nothing;

impl LeftOut for Nothing {
    fn is_near(&self, _: usize) -> bool {
        false
    }

    fn holds(&self, _: usize, _: Vec2) -> bool {
        false
    }
}

impl Surface for crate::terrain::Terrain {
    fn elevation(&self, map: Vec2) -> Option<f64> {
        crate::terrain::Terrain::elevation(self, map)
    }

    fn mean_preserving_elevation(&self, map: Vec2, spacing: f64) -> Option<f64> {
        crate::terrain::Terrain::mean_preserving_elevation(self, map, spacing)
    }

    fn plane_of_cell(&self, centre: Vec2, spacing: f64) -> Option<CellPlane> {
        crate::terrain::Terrain::plane_of_cell(self, centre, spacing).map(|(mean, highest)| CellPlane { mean, highest })
    }

    fn samples(&self, centre: Vec2, radius: f64, out: &mut Vec<(Vec2, f64)>) {
        crate::terrain::Terrain::samples(self, centre, radius, out);
    }

    fn pieces(&self, centre: Vec2, width: f64, with_surroundings: bool, pieces: &mut Vec<Piece>) {
        crate::terrain::Terrain::pieces(self, centre, width, with_surroundings, pieces);
    }

    fn has_pixels(&self, map: Vec2, spacing: f64) -> bool {
        crate::terrain::Terrain::has_pixels(self, map, spacing)
    }
}
