//! The way from places of the run to the cells of a raster in another system, or rotated.

use std::path::Path;

use gdal::GeoTransform;
use gdal::spatial_ref::SpatialRef;

use crate::error::{Problem, input_error};
use crate::geodata::{describe, same_horizontal, transform};
use crate::math::Vec2;

/// The way from places of the run to the cells of a raster in another system, or rotated, that is read as it stands.
#[derive(Clone, Debug)]
pub struct Placing {
    /// Systems of the run and of the file, where they differ.
    pub(super) systems: Option<(SpatialRef, SpatialRef)>,
    pub(super) geo_transform: GeoTransform,
}

impl Placing {
    /// Turns map coordinates of the run to those of the raster, in which a cell is 1 by 1 and the upper left corner (0, 0).
    ///
    /// # Errors
    /// The problem, without key and place.
    pub fn apply(&self, places: &mut [Vec2], path: &Path) -> Result<(), Problem> {
        if let Some((run, own)) = &self.systems {
            transform(places, run, own).map_err(|cause| {
                input_error(
                    "warp-failed",
                    format!("the run has places that {} in {} does not know", path.display(), describe(own)),
                )
                .with_cause(cause)
                .with_remedy("check that `crs:` covers this place on Earth")
            })?;
        }
        let [x, a, b, y, d, e] = self.geo_transform;
        let determinant = a * e - b * d;
        for place in places {
            let (east, north) = (place.x - x, place.y - y);
            *place = Vec2::new((e * east - b * north) / determinant, (d * east - a * north) / determinant);
        }
        Ok(())
    }

    /// Whether both lead to the same place, to within a share of a cell.
    pub fn is_same(&self, other: &Placing, share: f64) -> bool {
        let [_, a, b, _, d, e] = self.geo_transform;
        let near = |k: usize, step: f64| (self.geo_transform[k] - other.geo_transform[k]).abs() <= share * step;
        let (x, y) = (a.hypot(b), d.hypot(e));
        let same_system = match (&self.systems, &other.systems) {
            (Some((_, own)), Some((_, other))) => same_horizontal(own, other),
            (None, None) => true,
            _ => false,
        };
        same_system && [(0, x), (1, x), (2, x), (3, y), (4, y), (5, y)].into_iter().all(|(k, step)| near(k, step))
    }
}
