//! Particles laid into the cells of their levels by counting, in bands of cells side by side.

use rayon::prelude::*;

use super::levels::{LEVELS, Taken};
use super::{CellGrid, LANES, PARALLEL_PARTICLES, reach_squared_of};
use crate::math::Vec2;

/// Bands of cells that are filled side by side, at most.
const BANDS: usize = 32;

/// How many particles of a block are in each band of cells.
pub(super) type Census = [u32; BANDS];

/// A band of cells and the places of its particles, to be filled.
struct Band<'a> {
    index: usize,
    /// Number of particles in the cells before it.
    before: u32,
    starts: &'a mut [u32],
    order: &'a mut [u32],
    x: &'a mut [i32],
    y: &'a mut [i32],
    reach_squared: &'a mut [f32],
}

/// The particles with the cell of each, and how many of each block are in each band.
struct Particles<'a> {
    positions: &'a [Vec2],
    supports: &'a [f32],
    keys: &'a [u32],
    censuses: &'a [Census],
    /// See [`CellGrid::band_shift`].
    shift: u32,
    origin: Vec2,
    scale: f64,
}

impl Band<'_> {
    /// Takes its particles out of those blocks that have any.
    fn fill(self, from: &Particles<'_>) {
        let blocks = || {
            let of_band = from.censuses.iter().enumerate().filter(|(_, census)| census[self.index] > 0);
            let particles = of_band.flat_map(|(block, _)| {
                let first = block * PARALLEL_PARTICLES;
                first..(first + PARALLEL_PARTICLES).min(from.keys.len())
            });
            particles.filter(|&j| (from.keys[j] >> from.shift) as usize == self.index)
        };
        let first_cell = (self.index << from.shift) as u32;
        self.starts.fill(0);
        for j in blocks() {
            self.starts[(from.keys[j] - first_cell) as usize] += 1;
        }
        let mut end = self.before;
        for start in self.starts.iter_mut() {
            end += *start;
            *start = end - *start;
        }
        for j in blocks() {
            let slot = &mut self.starts[(from.keys[j] - first_cell) as usize];
            let k = (*slot - self.before) as usize;
            *slot += 1;
            let place = (from.positions[j] - from.origin) * from.scale;
            self.order[k] = j as u32;
            (self.x[k], self.y[k]) = (place.x as i32, place.y as i32);
            self.reach_squared[k] = reach_squared_of(f64::from(from.supports[j]) * from.scale);
        }
        // Placing moved every start to the end of its cell, which is the start of the next one: shift back.
        let cells = self.starts.len();
        if cells > 0 {
            self.starts.copy_within(..cells - 1, 1);
            self.starts[0] = self.before;
        }
    }
}

impl CellGrid {
    /// The number of a cell, shifted to the right so far, is that of its band.
    fn band_shift(&self) -> u32 {
        self.starts.len().div_ceil(BANDS).next_power_of_two().trailing_zeros()
    }

    pub(super) fn find_cells(&mut self, positions: &[Vec2], supports: &[f32]) {
        let shift = self.band_shift();
        let (levels, origin) = (&self.levels, self.origin);
        let last = levels.len().saturating_sub(1);
        let level_of =
            |support: f64| levels[..last].iter().position(|level| 0.5 * support <= level.width).unwrap_or(last);
        self.keys.resize(positions.len(), 0);
        self.censuses.resize(positions.len().div_ceil(PARALLEL_PARTICLES), [0; BANDS]);
        let blocks = self.keys.par_chunks_mut(PARALLEL_PARTICLES).zip(&mut self.censuses);
        let blocks = blocks.zip(positions.par_chunks(PARALLEL_PARTICLES).zip(supports.par_chunks(PARALLEL_PARTICLES)));
        let blocks = blocks.with_max_len(1);
        let taken = blocks.map(|((keys, census), (positions, supports))| {
            let mut taken = [Taken::NOTHING; LEVELS];
            *census = [0; BANDS];
            for ((key, position), &support) in keys.iter_mut().zip(positions).zip(supports) {
                let support = f64::from(support);
                let index = level_of(support);
                let level = &levels[index];
                let column = (((position.x - origin.x) * level.per_column) as usize).min(level.columns - 1);
                let row = (((position.y - origin.y) * level.per_row) as usize).min(level.rows - 1);
                *key = (level.first + row * level.columns + column) as u32;
                census[(*key >> shift) as usize] += 1;
                let place = (column, row);
                taken[index] = taken[index].and(Taken { largest_support: support, low: place, high: place });
            }
            taken
        });
        let none = || [Taken::NOTHING; LEVELS];
        let taken = taken.reduce(none, |a, b| std::array::from_fn(|level| a[level].and(b[level])));
        self.levels.iter_mut().zip(taken).for_each(|(level, taken)| level.taken = taken);
    }

    /// Lays the particles into their cells. Each band of cells takes its own out of those blocks that have any: few, because particles
    /// are nearly in the order of the cells.
    pub(super) fn place(&mut self, positions: &[Vec2], supports: &[f32]) {
        // Sixteen candidates are read at a time, also from the last ones on.
        let padded = positions.len() + LANES;
        self.order.resize(padded, 0);
        self.x.resize(padded, 0);
        self.y.resize(padded, 0);
        self.reach_squared.resize(padded, 0.0);
        let (shift, origin, scale) = (self.band_shift(), self.origin, self.scale);
        let (keys, censuses) = (&self.keys, &self.censuses);
        let (mut starts, mut order) = (&mut self.starts[..], &mut self.order[..]);
        let (mut x, mut y, mut reach_squared) = (&mut self.x[..], &mut self.y[..], &mut self.reach_squared[..]);
        let mut before = 0;
        let bands: [Band<'_>; BANDS] = std::array::from_fn(|index| {
            let count = censuses.iter().map(|census| census[index]).sum::<u32>();
            let (cells, particles) = (starts.len().min(1 << shift), count as usize);
            before += count;
            Band {
                index,
                before: before - count,
                starts: starts.split_off_mut(..cells).unwrap_or_default(),
                order: order.split_off_mut(..particles).unwrap_or_default(),
                x: x.split_off_mut(..particles).unwrap_or_default(),
                y: y.split_off_mut(..particles).unwrap_or_default(),
                reach_squared: reach_squared.split_off_mut(..particles).unwrap_or_default(),
            }
        });
        let from = Particles { positions, supports, keys, censuses, shift, origin, scale };
        bands.into_par_iter().with_max_len(1).for_each(|band| band.fill(&from));
    }
}
