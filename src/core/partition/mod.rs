//! Part of a square lattice as cells that follow lines: geometry alone.
//!
//! Flow along a wall or bank askew to a lattice meets stairs. Where the faces of cells lie on the line, uniform flow along it is exact.
//! So cells of the lattice near lines are replaced by polygons; all others keep their exact square.
//!
//! # Rules
//!
//! All lengths are in spacings of the lattice, areas in spacings squared.
//!
//! 1. **Pairs.** Between two nodes (ends, corners, crossings) a line gets as many pairs of seeds as spacings fit, spread evenly from its
//!    middle, 0.4 from the line on either side. The bisector of a pair is the line. The breaklines of HEC-RAS are the model.
//! 2. **Nodes.** Around a node seeds stand on a circle through the first seeds of its lines, √(0.5² + 0.4²) = 0.64. The node is equally
//!    far from all of them, and so a corner of their cells. Between two lines that leave it at less than 133 degrees there is one seed. On
//!    the outer side of a corner there is one more, around a free end two more, so that the row goes on beyond the end.
//! 3. **Streets.** Between lines nearer than 1.31 to each other there is one row of seeds in the middle. Between lines nearer than 1.6
//!    there is a row along each, a quarter of the width from it.
//! 4. **Too near.** A seed less than 0.6 from an earlier one on the same side of all lines is left out. Nodes come before lines, lines in
//!    the order of the input. Inside an outline lines have no seeds.
//! 5. **Squares.** A square keeps the seed in its centre where that is 0.79 from lines and 0.6 from other seeds. It also does where it is
//!    0.32 from lines and 0.8 from other seeds: beside corners no hole is left.
//! 6. **Voronoi.** The polygon of a seed is what is nearer to it than to any other seed (`DuFaberGunzburger1999`). Where that is the square
//!    of the lattice, the lattice keeps its cell.
//! 7. **Cuts.** Lines cut every polygon that they reach into, and so do the sides of cells that do not exist. What lies inside an outline
//!    is left out. So faces lie on lines whatever the seeds do, and no face crosses one. Only a cell around the end of a wall has water on
//!    both sides of it.
//! 8. **Joins.** Parts of a polygon that no line separates are one cell. A part without its seed below 0.5, and any cell below 0.3, becomes
//!    part of a neighbour: the one with the longest common face that lies on no line. The smallest ones come first. So cells may have
//!    corners that point inward, and holes.
//!    What is left below 0.1 between lines that water passes is joined over them.
//! 9. **Blocked.** A part below 0.001 without such a neighbour is left out, and its faces are walls ([`Partition::blocked`]). A larger one
//!    stays a cell, however small: the water between two walls that meet, or inside a small ring.
//! 10. **Slivers.** A cell that a wall cuts off beside squares that stay ([`Partition::beside`]) has none to be joined to. Where its area is
//!     below 0.3 of the width that it shares with squares, |Σ l n| over their sides, it would rule the step. It is left out, and the wall is
//!     that of the squares.
//!
//! A scene in a mirror gives the mirrored cells, to rounding: seeds are laid out from the middle of a line, and neighbours chosen by
//! length. Exact ties between two neighbours are the exception.
//!
//! Places nearer than 1e-9 to each other are one, and so are lines. A wider gap in a wall is a gap.
//!
//! Units: metres in and out, in local coordinates with the origin in the south-western corner of the lattice.
//!
//! Deliberately absent: water, terrain, files, threads; walls with a thickness (draw an outline); cells that move. Lines are neither
//! simplified nor snapped to each other: that is for the caller. A line with points much denser than the lattice gives as many faces.
//!
//! Files in the order of the work: `lines` and `nodes` (what is drawn), `seeds` (rules 1 to 5), `voronoi` (6), `cut` (7), `mesh` (corners
//! and edges in common), `join` (8, 9), `faces`; `assemble` calls them.

mod assemble;
mod cut;
mod faces;
mod inside;
mod join;
mod kept;
mod lines;
mod mesh;
mod nodes;
mod seeds;
mod segment;
mod voronoi;
mod weld;
mod window;

#[cfg(test)]
mod tests;

pub use crate::lattice::{Cell, Face, Side};
use crate::lattice::{Conforming, Lattice};
use crate::math::Vec2;
pub use mesh::area_and_centre;
pub use voronoi::keep_left;

/// Places nearer to each other than this (spacings) are one.
const TOLERANCE: f64 = 1e-9;

/// Parts without a neighbour on their side are left out below this area (spacings squared).
const BLOCKED: f64 = 1e-3;

/// What a line means for the water.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineKind {
    /// Water never crosses it; it has no thickness.
    Wall,
    /// A ring around what is not there: a building, a blocked area. Its faces are walls. Outlines that overlap run the same way; one that runs
    /// the other way inside of another is a courtyard.
    Outline,
    /// Water passes; faces lie on it all the same: a bank, a dike, a breakline.
    Follow,
}

/// A line that cells shall follow.
#[derive(Clone, Debug)]
pub struct Line {
    /// Its points, in local coordinates (m).
    pub points: Vec<Vec2>,
    /// Whether its last point is joined to the first; an outline always is.
    pub is_closed: bool,
    /// What it means.
    pub kind: LineKind,
}

impl Line {
    /// Its straight pieces (local coordinates, m), with the one that closes it.
    pub fn pieces(&self) -> impl Iterator<Item = [Vec2; 2]> + '_ {
        let closing = match self.points[..] {
            [first, .., last] if self.is_closed && first != last => Some([last, first]),
            _ => None,
        };
        self.points.windows(2).map(|ends| [ends[0], ends[1]]).chain(closing)
    }
}

/// Cells that follow lines, and their faces.
#[derive(Clone, Debug)]
pub struct Partition {
    /// The cells, row by row.
    pub cells: Vec<Cell>,
    /// Their faces. Those between two cells of the lattice are not among them.
    pub faces: Vec<Face>,
    /// Cells of the lattice that are no longer there, ascending: replaced by cells, or inside an outline.
    pub replaced: Vec<usize>,
    /// Number of parts that were left out, for they were tiny and had no neighbour on their side of the lines.
    pub blocked: usize,
    /// Faces at which the partition has a gap or an overlap; 0 unless places lie apart by just the tolerance.
    pub faults: usize,
}

impl Partition {
    /// The partition of a lattice along some lines.
    ///
    /// - `is_cell`: whether the lattice has a cell, by its index
    /// - `lines`: in local coordinates (m); what lies outside the lattice has no effect
    pub fn new(lattice: &Lattice, is_cell: impl Fn(usize) -> bool, lines: &[Line]) -> Self {
        assemble::assemble(lattice, &is_cell, lines)
    }

    /// Its cells and faces in place of some squares of the lattice.
    pub fn on(self, lattice: &Lattice) -> Conforming {
        let size = (lattice.columns, lattice.rows, lattice.spacing);
        Conforming::new(size, (self.cells, self.faces), &self.replaced)
    }
}
