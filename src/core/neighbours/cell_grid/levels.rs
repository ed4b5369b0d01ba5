//! Levels of cells, each twice as wide as the one below, laid by the supports of the particles.

use rayon::prelude::*;

use super::{CellGrid, PARALLEL_PARTICLES};
use crate::math::Vec2;

/// Levels of cells, each twice as wide as the one below.
pub(super) const LEVELS: usize = 12;

/// Columns and rows of cells, in units of the width of their level: long low runs hold few candidates that are not near, and each of
/// them is no longer than what is looked at together.
const COLUMN: f64 = 0.5;
const ROW: f64 = 4.0 / 3.0;

/// Units in twice what all particles span with their supports: places beside the particles have to be told apart, too.
const UNITS: f64 = (1_u32 << 30) as f64;

/// Bits of a support that its class in a census leaves out: what remains is the exponent, and eighths of the octave.
const CENSUS_SHIFT: u32 = 20;

/// Classes of supports to an octave.
const CLASSES_TO_AN_OCTAVE: usize = 1 << (f32::MANTISSA_DIGITS - 1 - CENSUS_SHIFT);

/// Classes of supports, from that of the smallest one on; the last one takes all that are larger.
const CLASSES: usize = 16 * CLASSES_TO_AN_OCTAVE;

/// So many percent of the particles are below the upper end of the level that is laid for them.
const MOST_PERCENT: usize = 90;

/// A level below another is laid for so many percent of the particles.
const ENOUGH_PERCENT: usize = 3;

#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Level {
    /// Width of particles that are at home here: half to one support (m).
    pub(super) width: f64,
    pub(super) per_column: f64,
    pub(super) per_row: f64,
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Where the level's cells begin in `starts`.
    pub(super) first: usize,
    pub(super) taken: Taken,
}

/// What the particles of a level take: their largest support (m), 0 without any, and the cells in which they stand, first and last.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Taken {
    pub(super) largest_support: f64,
    pub(super) low: (usize, usize),
    pub(super) high: (usize, usize),
}

impl Taken {
    pub(super) const NOTHING: Taken = Taken { largest_support: 0.0, low: (usize::MAX, usize::MAX), high: (0, 0) };

    #[inline]
    pub(super) fn and(self, other: Taken) -> Taken {
        Taken {
            largest_support: self.largest_support.max(other.largest_support),
            low: (self.low.0.min(other.low.0), self.low.1.min(other.low.1)),
            high: (self.high.0.max(other.high.0), self.high.1.max(other.high.1)),
        }
    }
}

/// What particles span: the rectangle of their places (m), and their smallest and largest support (m).
#[derive(Clone, Copy, Debug)]
struct Extent {
    low: Vec2,
    high: Vec2,
    smallest: f64,
    largest: f64,
}

impl Default for Extent {
    /// That of no particle.
    fn default() -> Self {
        let (low, high) = (f64::INFINITY, f64::NEG_INFINITY);
        Extent { low: Vec2::new(low, low), high: Vec2::new(high, high), smallest: low, largest: 0.0 }
    }
}

impl Extent {
    fn of(position: Vec2, support: f64) -> Self {
        Extent { low: position, high: position, smallest: support, largest: support }
    }

    fn around(self, other: Extent) -> Extent {
        Extent {
            low: Vec2::new(self.low.x.min(other.low.x), self.low.y.min(other.low.y)),
            high: Vec2::new(self.high.x.max(other.high.x), self.high.y.max(other.high.y)),
            smallest: self.smallest.min(other.smallest),
            largest: self.largest.max(other.largest),
        }
    }
}

impl CellGrid {
    pub(super) fn lay_out_levels(&mut self, positions: &[Vec2], supports: &[f32]) {
        let extent = positions.par_iter().zip(supports).with_min_len(PARALLEL_PARTICLES);
        let extent = extent.fold(Extent::default, |extent, (&p, &s)| extent.around(Extent::of(p, f64::from(s))));
        let Extent { low, high, smallest, largest } = extent.reduce(Extent::default, Extent::around);
        self.levels.clear();
        if positions.is_empty() {
            self.starts.clear();
            return;
        }
        self.origin = low;
        let (width, height) = (high.x - low.x, high.y - low.y);
        self.scale = UNITS / (width.max(height) + largest);
        let allowed_cells = 4.0 * positions.len() as f64;
        // Never more cells than about four per particle, however small the smallest support.
        let mut cell = (0.5 * end_of_lowest_level(supports, smallest))
            .max((width * height / (COLUMN * ROW * allowed_cells)).sqrt())
            .max(width.max(height) / (COLUMN * allowed_cells))
            .max(1e-3 * largest);
        let mut first = 0;
        for level in 0..LEVELS {
            let is_last = level + 1 == LEVELS || cell >= 0.5 * largest;
            let columns = (width / (COLUMN * cell)) as usize + 1;
            let rows = (height / (ROW * cell)) as usize + 1;
            self.levels.push(Level {
                width: cell,
                per_column: 1.0 / (COLUMN * cell),
                per_row: 1.0 / (ROW * cell),
                columns,
                rows,
                first,
                taken: Taken::NOTHING,
            });
            first += columns * rows;
            if is_last {
                break;
            }
            cell *= 2.0;
        }
        self.starts.resize(first + 1, 0);
    }
}

/// Upper end (m) of the supports for which the lowest level is laid. `MOST_PERCENT` of the particles are below the end of one level; others follow below
/// in steps of an octave for as long as there are `ENOUGH_PERCENT` of them.
fn end_of_lowest_level(supports: &[f32], smallest: f64) -> f64 {
    let class = |support: f32| (support.to_bits() >> CENSUS_SHIFT) as usize;
    let first = class(smallest as f32);
    let none = || [0_usize; CLASSES];
    let census = supports.par_chunks(PARALLEL_PARTICLES).map(|supports| {
        let mut census = none();
        supports.iter().for_each(|&support| census[(class(support) - first).min(CLASSES - 1)] += 1);
        census
    });
    let mut up_to = census.reduce(none, |a, b| std::array::from_fn(|class| a[class] + b[class]));
    for class in 1..CLASSES {
        up_to[class] += up_to[class - 1];
    }
    let mut last = up_to.partition_point(|&count| 100 * count < MOST_PERCENT * supports.len());
    while last >= CLASSES_TO_AN_OCTAVE && 100 * up_to[last - CLASSES_TO_AN_OCTAVE] >= ENOUGH_PERCENT * supports.len() {
        last -= CLASSES_TO_AN_OCTAVE;
    }
    f64::from(f32::from_bits(((first + last + 1) as u32) << CENSUS_SHIFT))
}
