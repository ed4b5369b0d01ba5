//! Riverbed particles, one for each cell of the lattice, one `Vec` for each quantity.

use super::cover::Cover;
use super::sill::PassSills;
use crate::constants::BedConstants;
use crate::lattice::Lattice;
use crate::math::{Sym2, Vec2};

/// The riverbed particles of a lattice. Vectors with a number for each particle have `lattice.len()` entries.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct BedParticles {
    /// Where the particles lie: at the centres of the cells.
    pub lattice: Lattice,
    /// Bed elevation z_b (m); NaN where there is no terrain: the edge of such an area is a wall.
    pub elevation: Vec<f64>,
    /// Whether the bed goes on as its particles slope ([`BedParticles::slope`]) where one of them is missing; a made bed may go on level.
    pub is_sloped: bool,
    /// Curvature, the Hessian of z_b (1/m); empty until somebody needs it: steep beds alone do.
    pub curvature: Vec<Sym2>,
    /// Manning roughness n (s·m^(−1/3)).
    pub manning: Vec<f64>,
    /// Cells without terrain whose edge no boundary opens, such as buildings; ascending.
    pub sealed: Vec<usize>,
    /// Ridges of the terrain that are narrower than a cell.
    pub passes: PassSills,
    /// Cells that stand for a part of their cell, or for more.
    pub cover: Cover,
    /// The constants by which it is made, and by which its steps, ridges and gaps are found.
    pub constants: BedConstants,
}

impl BedParticles {
    /// Whether there is terrain at a cell.
    #[inline]
    pub fn has_terrain(&self, index: usize) -> bool {
        !self.elevation[index].is_nan()
    }

    /// Area (m²) for which a cell stands.
    pub fn area(&self, index: usize) -> f64 {
        self.cover.cell(index).area * self.lattice.area_of(index)
    }

    /// Whether a face, given by its midpoint (local coordinates, m), is one of a sealed cell.
    pub fn is_sealed(&self, midpoint: Vec2) -> bool {
        let quarter = 0.25 * self.lattice.spacing;
        let steps =
            [Vec2::new(quarter, 0.0), Vec2::new(-quarter, 0.0), Vec2::new(0.0, quarter), Vec2::new(0.0, -quarter)];
        let is_sealed = |cell: usize| self.sealed.binary_search(&cell).is_ok();
        !self.sealed.is_empty()
            && steps.into_iter().any(|step| self.lattice.cell_at(midpoint + step).is_some_and(is_sealed))
    }

    /// Sets the elevation (m) of cells.
    #[cfg(test)]
    pub fn set(&mut self, elevations: &[(usize, f64)]) {
        elevations.iter().for_each(|&(cell, z_b)| self.elevation[cell] = z_b);
    }

    /// A bed from elevations alone, which goes on level beside its particles, with one roughness: for tests and made cases.
    pub fn from_elevation(lattice: Lattice, elevation: Vec<f64>, manning: f64) -> Self {
        debug_assert_eq!(lattice.len(), elevation.len());
        let cells = lattice.len();
        BedParticles {
            lattice,
            elevation,
            is_sloped: false,
            curvature: Vec::new(),
            manning: vec![manning; cells],
            sealed: Vec::new(),
            passes: PassSills::default(),
            cover: Cover::default(),
            constants: BedConstants::DEFAULT,
        }
    }
}
