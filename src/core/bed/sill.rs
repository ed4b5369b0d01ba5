//! Pass sills of a lattice, what gaps leave open of them, and the pixels that they are found in.

use crate::lattice::{Lattice, Level};
use crate::math::Vec2;
use crate::terrain::{PixelBlock, PixelGrid, Terrain};

/// A level (m) that no water reaches, so that the arithmetic of a face needs no branch: that of a sill between two cells that no pixel with
/// data joins, and that of the bed in the rows of the solver where there is no terrain (in all other arrays that is not-a-number).
pub const SHUT: f64 = 1e6;

/// Terrain by its pixels, the cells of its rasters; map coordinates throughout.
pub trait Pixels: Sync {
    /// The grid of the finest raster in a rectangle, if its pixels are smaller than `spacing` (m).
    fn grid(&self, low: Vec2, high: Vec2, spacing: f64) -> Option<PixelGrid>;

    /// Appends the elevations (m) of a block of pixels that belong to a cell of the lattice, row by row, NaN without data.
    fn read(&self, grid: &PixelGrid, block: &PixelBlock, cell: usize, out: &mut Vec<f64>);
}

impl Pixels for Terrain {
    fn grid(&self, low: Vec2, high: Vec2, spacing: f64) -> Option<PixelGrid> {
        self.pixel_grid(low, high, spacing)
    }

    fn read(&self, grid: &PixelGrid, block: &PixelBlock, _cell: usize, out: &mut Vec<f64>) {
        for row in block.rows.clone() {
            out.extend(block.columns.clone().map(|column| self.pixel(grid, column, row)));
        }
    }
}

/// What a gap leaves of a face.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(super) struct Opening {
    /// The cell to the west or south of the face.
    pub cell: usize,
    /// Whether the other cell lies to the north of it; to the east otherwise.
    pub is_north: bool,
    /// The share of the face that is open at the level of the gap.
    pub share: f64,
    /// The level (m) of the rest.
    pub crest: f64,
}

impl Opening {
    /// What faces are ordered by.
    pub fn face(&self) -> (usize, bool) {
        (self.cell, self.is_north)
    }
}

/// The sill of one face.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PassSill {
    /// The cell to the west or south of the face.
    pub cell: usize,
    /// Whether the other cell lies to the north of it; to the east otherwise.
    pub is_north: bool,
    /// Its level P (m); [`SHUT`] where nothing joins the two cells, minus infinity where a gap leads down to the beds.
    pub level: f64,
    /// The share of the face that it holds, 1 without a gap (M12);
    pub share: f64,
    /// the rest has this level (m), that of the crest.
    pub crest: f64,
}

impl PassSill {
    /// A sill that takes the whole face.
    pub fn whole(cell: usize, is_north: bool, level: f64) -> Self {
        PassSill { cell, is_north, level, share: 1.0, crest: level }
    }

    /// What faces are ordered by.
    pub(super) fn face(&self) -> (usize, bool) {
        (self.cell, self.is_north)
    }

    /// The other cell.
    pub fn other(&self, lattice: &Lattice) -> usize {
        self.cell + if self.is_north { lattice.columns } else { 1 }
    }
}

/// The pass sills of a lattice: those of all faces that carry a ridge which their cells do not see.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PassSills {
    /// By cell and direction, ascending.
    pub(super) sills: Vec<PassSill>,
    /// The cells with a gap, ascending.
    pub(super) gaps: Vec<usize>,
    /// What gaps leave open, by cell and direction.
    pub(super) openings: Vec<Opening>,
    /// The level (m) of the lowest ground along each face of the cells that follow lines, by number.
    pub(super) along_faces: Vec<f64>,
}

impl PassSills {
    /// These sills, in any order.
    pub fn new(sills: Vec<PassSill>) -> Self {
        let mut sills = PassSills { sills, ..PassSills::default() };
        sills.sort();
        sills
    }

    /// Those of all levels of a nested lattice, each of which was found on a lattice of its own.
    pub(crate) fn stacked<'a>(
        levels: impl Iterator<Item = (&'a PassSills, Level)>,
        cell_of: impl Fn(Level, usize) -> usize,
    ) -> PassSills {
        let of_level = |(sills, level): (&'a PassSills, Level)| {
            let in_stack = |sill: &PassSill| PassSill { cell: cell_of(level, sill.cell), ..*sill };
            sills.iter().map(in_stack).collect::<Vec<_>>()
        };
        PassSills::new(levels.flat_map(of_level).collect())
    }

    /// The same with the level (m) of the lowest ground along each face of the cells that follow lines, minus infinity where it is not known.
    #[must_use]
    pub fn with_faces(self, along_faces: Vec<f64>) -> Self {
        PassSills { along_faces, ..self }
    }

    /// The level (m) of the lowest ground along a face of cells that follow lines; minus infinity where it is not known.
    pub fn along_face(&self, face: usize) -> f64 {
        self.along_faces.get(face).copied().unwrap_or(f64::NEG_INFINITY)
    }

    pub(super) fn sort(&mut self) {
        self.sills.sort_by_key(PassSill::face);
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.sills.is_empty()
    }

    /// All of them, by cell and direction.
    pub fn iter(&self) -> impl Iterator<Item = &PassSill> {
        self.sills.iter()
    }

    /// The level (m) of the sill between two cells beside each other; minus infinity where there is none.
    pub fn between(&self, a: usize, b: usize) -> f64 {
        let key = (a.min(b), a.abs_diff(b) != 1);
        let found = self.sills.binary_search_by_key(&key, PassSill::face);
        found.map_or(f64::NEG_INFINITY, |place| self.sills[place].level)
    }
}
