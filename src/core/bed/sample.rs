//! The bed between the riverbed particles: bilinear between their elevations, plane where some of them are missing.

use super::BedParticles;
use crate::math::{Vec2, floor};

/// The bed at a place.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct BedPoint {
    /// Bed elevation z_b (m).
    pub elevation: f64,
    /// Bed slope ∇z_b (dimensionless), the gradient of that same elevation.
    pub slope: Vec2,
}

impl BedParticles {
    /// The bed at a place in local coordinates (m), or `None` where the cell that holds it has no terrain.
    ///
    /// Bilinear between the four particles around the place; one of them that is missing is replaced by the tangent plane of
    /// the particle of the cell, so that a plane stays exact up to edges and nodata. A lattice of one row is the same all across.
    pub fn at(&self, local: Vec2) -> Option<BedPoint> {
        let lattice = &self.lattice;
        let home = lattice.cell_at(local).filter(|&home| self.has_terrain(home))?;
        let west = floor(local.x / lattice.spacing - 0.5);
        let south = floor(local.y / lattice.spacing - 0.5);
        let inside =
            west >= 0.0 && south >= 0.0 && west + 1.0 < lattice.columns as f64 && south + 1.0 < lattice.rows as f64;
        let known = inside.then(|| {
            let first = lattice.index(west as usize, south as usize);
            let next = first + lattice.columns;
            [self.elevation[first], self.elevation[first + 1], self.elevation[next], self.elevation[next + 1]]
        });
        let [z_sw, z_se, z_nw, z_ne] = known
            .filter(|corners| !corners.iter().any(|elevation| elevation.is_nan()))
            .unwrap_or_else(|| self.corners(home, west, south));
        let (x, y) = (local.x / lattice.spacing - 0.5 - west, local.y / lattice.spacing - 0.5 - south);
        let (rise_south, rise_north) = (z_se - z_sw, z_ne - z_nw);
        let (rise_west, rise_east) = (z_nw - z_sw, z_ne - z_se);
        Some(BedPoint {
            elevation: z_sw + x * rise_south + y * rise_west + x * y * (rise_north - rise_south),
            slope: Vec2::new(rise_south + y * (rise_north - rise_south), rise_west + x * (rise_east - rise_west))
                / lattice.spacing,
        })
    }

    /// Elevations (m) of four riverbed particles, south-west, south-east, north-west and north-east; that of the tangent plane of `home`
    /// where there is none.
    #[cold]
    fn corners(&self, home: usize, west: f64, south: f64) -> [f64; 4] {
        let lattice = &self.lattice;
        let (home_column, home_row) = lattice.column_row(home);
        let mut slope = None;
        [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(east, north)| {
            let column = if lattice.columns == 1 { 0.0 } else { west + east };
            let row = if lattice.rows == 1 { 0.0 } else { south + north };
            let on_lattice =
                column >= 0.0 && row >= 0.0 && column < lattice.columns as f64 && row < lattice.rows as f64;
            let known = on_lattice.then(|| self.elevation[lattice.index(column as usize, row as usize)]);
            known.filter(|elevation| !elevation.is_nan()).unwrap_or_else(|| {
                let offset = Vec2::new(column - home_column as f64, row - home_row as f64) * lattice.spacing;
                self.elevation[home] + slope.get_or_insert_with(|| self.slope(home)).dot(offset)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Lattice;

    /// A plane on a lattice with a hole in it.
    fn plane_with_hole() -> BedParticles {
        let lattice = Lattice::new(Vec2::ZERO, 6, 5, 2.0);
        let mut elevation: Vec<f64> = (0..lattice.len()).map(|i| plane(lattice.centre(i))).collect();
        elevation[lattice.index(3, 2)] = f64::NAN;
        let mut bed = BedParticles::from_elevation(lattice, elevation, 0.03);
        bed.is_sloped = true;
        bed
    }

    fn plane(place: Vec2) -> f64 {
        3.0 + 0.5 * place.x - 0.25 * place.y
    }

    #[test]
    fn plane_is_exact_at_edges_and_beside_a_hole() {
        let bed = plane_with_hole();
        for step in 0..1000 {
            let place = Vec2::new(12.0 * (step as f64 * 0.618).fract(), 10.0 * (step as f64 * 0.414).fract());
            let in_hole = bed.lattice.cell_at(place) == Some(bed.lattice.index(3, 2));
            let found = bed.at(place);
            assert_eq!(found.is_none(), in_hole);
            if let Some(point) = found {
                // A dozen sums of numbers below ten.
                assert!((point.elevation - plane(place)).abs() < 1e-13);
                assert!((point.slope - Vec2::new(0.5, -0.25)).norm() < 1e-13);
            }
        }
        assert_eq!(bed.at(Vec2::new(-0.1, 1.0)), None);
    }

    #[test]
    fn channel_of_one_row_has_no_slope_across() {
        let lattice = Lattice::new(Vec2::ZERO, 6, 1, 2.0);
        let bed = BedParticles::from_elevation(lattice, vec![0.0, 1.0, 3.0, -2.0, 0.5, 0.5], 0.0);
        for step in 0..100 {
            let x = 12.0 * (step as f64 * 0.618).fract();
            let (middle, rim) = (bed.at(Vec2::new(x, 1.0)).unwrap(), bed.at(Vec2::new(x, 1.7)).unwrap());
            assert_eq!((middle.slope.y, rim.slope.y), (0.0, 0.0));
            assert!((middle.elevation - rim.elevation).abs() < 1e-14);
        }
    }

    #[test]
    fn centre_gives_the_particle_itself() {
        let bed = plane_with_hole();
        for index in (0..bed.lattice.len()).filter(|&index| bed.has_terrain(index)) {
            let point = bed.at(bed.lattice.centre(index)).unwrap();
            assert!((point.elevation - bed.elevation[index]).abs() < 1e-14);
        }
    }
}
