//! The bed between the riverbed particles: bilinear between their elevations, plane where some of them are missing.

use super::BedParticles;
use crate::math::Vec2;

/// The bed at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BedPoint {
    /// Bed elevation z_b (m).
    pub elevation: f64,
    /// Bed slope ∇z_b (dimensionless), the gradient of that same elevation.
    pub slope: Vec2,
}

impl BedParticles {
    /// The bed at a place in local coordinates (m), or `None` where the cell that holds it has no terrain.
    ///
    /// Bilinear between the four particles around the place. One of them that is missing continues the tangent planes of those beside
    /// it, so that a plane stays exact up to edges and nodata, and a channel of one row has no slope across.
    pub fn at(&self, local: Vec2) -> Option<BedPoint> {
        let lattice = &self.lattice;
        lattice.cell_at(local).filter(|&home| self.has_terrain(home))?;
        let west = (local.x / lattice.spacing - 0.5).floor();
        let south = (local.y / lattice.spacing - 0.5).floor();
        let known = |east: f64, north: f64| {
            let (column, row) = (west + east, south + north);
            let on_lattice =
                column >= 0.0 && row >= 0.0 && column < lattice.columns as f64 && row < lattice.rows as f64;
            on_lattice.then(|| lattice.index(column as usize, row as usize)).filter(|&index| self.has_terrain(index))
        };
        let continued =
            |index: usize, steps: Vec2| self.elevation[index] + self.slope[index].dot(steps * lattice.spacing);
        let corner = |east: f64, north: f64| {
            if let Some(index) = known(east, north) {
                return self.elevation[index];
            }
            let (across, along) = (2.0 * east - 1.0, 2.0 * north - 1.0);
            let in_row = known(1.0 - east, north).map(|index| continued(index, Vec2::new(across, 0.0)));
            let in_column = known(east, 1.0 - north).map(|index| continued(index, Vec2::new(0.0, along)));
            match (in_row, in_column) {
                (Some(row), Some(column)) => 0.5 * (row + column),
                (Some(one), None) | (None, Some(one)) => one,
                // The cell that holds the place has terrain: it is the corner opposite.
                (None, None) => {
                    let opposite = known(1.0 - east, 1.0 - north);
                    opposite.map_or(f64::NAN, |index| continued(index, Vec2::new(across, along)))
                }
            }
        };
        let (z_sw, z_se, z_nw, z_ne) = (corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.0));
        let (x, y) = (local.x / lattice.spacing - 0.5 - west, local.y / lattice.spacing - 0.5 - south);
        let (rise_south, rise_north) = (z_se - z_sw, z_ne - z_nw);
        let (rise_west, rise_east) = (z_nw - z_sw, z_ne - z_se);
        Some(BedPoint {
            elevation: z_sw + x * rise_south + y * rise_west + x * y * (rise_north - rise_south),
            slope: Vec2::new(rise_south + y * (rise_north - rise_south), rise_west + x * (rise_east - rise_west))
                / lattice.spacing,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Lattice;

    /// A plane on a lattice with a hole in it.
    fn plane_with_hole() -> BedParticles {
        let lattice = Lattice { origin: Vec2::ZERO, columns: 6, rows: 5, spacing: 2.0 };
        let mut elevation: Vec<f64> = (0..lattice.len()).map(|i| plane(lattice.centre(i))).collect();
        elevation[lattice.index(3, 2)] = f64::NAN;
        let mut bed = BedParticles::from_elevation(lattice, elevation, 0.03);
        bed.slope.fill(Vec2::new(0.5, -0.25));
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
        let lattice = Lattice { origin: Vec2::ZERO, columns: 6, rows: 1, spacing: 2.0 };
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
