//! What cells do not see of the flow: how much its velocity head changes within one of them.
//!
//! Where the depth changes along a cell, the speed changes with it, and the scheme loses of the velocity head about what changes over
//! half a cell:
//!
//! ```text
//! (M101)  ε = ½ Fr² Δ ⟨|∇d|²⟩^½,   Fr² = q²/(g d³),   ∇d = ∇η − ∇z_b
//! ```
//!
//! with d and q the greatest depth and the greatest discharge per metre of width about a block, the mean over its cells of the finest level
//! that lie under water, η the highest level in a run on the coarsest level and z_b the bed of the finest one. With q constant
//! v²/2g = q²/(2 g d²) has the slope Fr² |∇d|. Water at rest, and a stream as deep all along however steep its bed, ask for nothing.

use crate::bed::BedParticles;
use crate::lattice::Lattice;
use crate::math::Vec2;

/// Depth (m) in the run on the coarsest level from which a cell counts as reached.
pub(super) const REACHED: f64 = 0.05;

/// The greatest depths and discharges of the cells of a run.
#[derive(Clone, Debug)]
pub(super) struct Greatest {
    /// Depth (m).
    pub depth: Vec<f64>,
    /// Discharge per metre of width (m²/s).
    pub discharge: Vec<f64>,
}

impl Greatest {
    /// Mean of the depths (m) of the cells that were reached; 0 without any.
    pub fn mean_depth(&self) -> f64 {
        let reached = self.depth.iter().filter(|depth| **depth >= REACHED);
        let (sum, count) = reached.fold((0.0, 0.0), |(sum, count), depth| (sum + depth, count + 1.0));
        sum / f64::max(count, 1.0)
    }
}

/// How the depth changes from place to place, by the highest levels on a coarse lattice above the bed of the finest one.
pub(super) struct Shape<'a> {
    finest: &'a BedParticles,
    /// Level (m) and its slope in each cell of the coarse lattice; none where it stays dry.
    levels: Vec<Option<(f64, Vec2)>>,
    columns: usize,
    /// The coarse lattice is this level.
    number: usize,
}

impl<'a> Shape<'a> {
    /// By the greatest depths (m) on level `number`, whose bed is `coarse`.
    pub fn new(finest: &'a BedParticles, (number, coarse): (usize, &BedParticles), depths: &[f64]) -> Self {
        let lattice = &coarse.lattice;
        let level = |cell: usize| (depths[cell] >= REACHED).then(|| coarse.elevation[cell] + depths[cell]);
        let levels = (0..lattice.columns * lattice.rows).map(|cell| with_slope(lattice, &level, cell)).collect();
        Shape { finest, levels, columns: lattice.columns, number }
    }

    /// The root mean square of |∇d| over those of some finest cells (columns and rows) that lie under water; 0 without any.
    pub fn change_of_depth(&self, columns: std::ops::Range<usize>, rows: std::ops::Range<usize>) -> f64 {
        let lattice = &self.finest.lattice;
        let bed = |cell: usize| Some(self.finest.elevation[cell]).filter(|bed| !bed.is_nan());
        let (mut sum, mut count) = (0.0, 0.0);
        for row in rows {
            for column in columns.clone() {
                let of_coarse = (row >> self.number) * self.columns + (column >> self.number);
                let Some((level, surface)) = self.levels[of_coarse] else { continue };
                let Some((bed, ground)) = with_slope(lattice, &bed, lattice.index(column, row)) else { continue };
                if level - bed >= REACHED {
                    sum += (surface - ground).norm_squared();
                    count += 1.0;
                }
            }
        }
        f64::sqrt(sum / f64::max(count, 1.0))
    }
}

/// A value in a cell and its slope, from the neighbours that have one.
fn with_slope(lattice: &Lattice, value: &dyn Fn(usize) -> Option<f64>, cell: usize) -> Option<(f64, Vec2)> {
    let here = value(cell)?;
    let (column, row) = lattice.column_row(cell);
    let at = |is_there: bool, beside: usize| if is_there { value(beside) } else { None };
    let west = at(column > 0, cell.wrapping_sub(1));
    let east = at(column + 1 < lattice.columns, cell + 1);
    let south = at(row > 0, cell.wrapping_sub(lattice.columns));
    let north = at(row + 1 < lattice.rows, cell + lattice.columns);
    let slope = |before: Option<f64>, beyond: Option<f64>| {
        let cells = f64::from(u8::from(before.is_some()) + u8::from(beyond.is_some()));
        (beyond.unwrap_or(here) - before.unwrap_or(here)) / (cells.max(1.0) * lattice.spacing)
    };
    Some((here, Vec2::new(slope(west, east), slope(south, north))))
}

/// ε of (M101) for each metre of a cell, from a discharge per metre of width (m²/s), a depth (m, above 0) and |∇d|.
pub(super) fn unseen_head((discharge, depth): (f64, f64), change_of_depth: f64, gravity: f64) -> f64 {
    0.5 * discharge * discharge / (gravity * depth * depth * depth) * change_of_depth
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bed (m) on cells of an edge (m) that begin at the origin.
    fn bed(columns: usize, spacing: f64, of: impl Fn(Vec2) -> f64) -> BedParticles {
        let lattice = Lattice::new(Vec2::ZERO, columns, columns, spacing);
        let elevation = (0..lattice.len()).map(|cell| of(lattice.centre(cell))).collect();
        BedParticles::from_elevation(lattice, elevation, 0.03)
    }

    /// |∇d| over a block of 8 fine cells under water as deep (m) as `depth` on coarse cells of 4 m.
    fn change(ground: impl Fn(Vec2) -> f64, depth: f64) -> f64 {
        let (finest, coarse) = (bed(32, 1.0, &ground), bed(8, 4.0, &ground));
        Shape::new(&finest, (2, &coarse), &[depth; 64]).change_of_depth(8..16, 8..16)
    }

    #[test]
    fn streams_as_deep_all_along_ask_for_nothing_however_steep() {
        assert!(change(|place| 0.3 * place.x - 0.1 * place.y, 2.0) < 1e-12);
        assert!(change(|_| 0.0, 0.01) < 1e-12, "dry");
    }

    #[test]
    fn banks_change_the_depth() {
        // Level water in a valley along y.
        let ground = |place: Vec2| 0.5 * (place.x - 16.0).abs();
        let (finest, coarse) = (bed(32, 1.0, ground), bed(8, 4.0, ground));
        let depths: Vec<f64> = coarse.elevation.iter().map(|bed| 10.0 - bed).collect();
        let shape = Shape::new(&finest, (2, &coarse), &depths);
        assert!((shape.change_of_depth(8..12, 8..16) - 0.5).abs() < 1e-12);
        // Critical flow 2 m deep: Fr = 1.
        let critical = (9.81_f64 * 8.0).sqrt();
        assert!((unseen_head((critical, 2.0), 0.5, 9.81) - 0.25).abs() < 1e-12);
        assert!(unseen_head((0.0, 2.0), 0.5, 9.81).abs() < 1e-12);
    }
}
