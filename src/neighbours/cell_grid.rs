//! A cell list by counting sort, in levels: particles of similar support share a level, whose cells are half to one
//! support wide, so that a few wide particles of thin water do not spoil the search of all others.
//!
//! A search visits every occupied level; in each, rows of cells are contiguous runs of the sorted arrays.
//! The order of what is found depends on positions, supports and indices alone, never on threads.

use rayon::prelude::*;

use crate::math::Vec2;

/// Levels of cells, each twice as wide as the one below.
const LEVELS: usize = 12;

/// Particles that a thread takes at least.
const PARALLEL_PARTICLES: usize = 4096;

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

#[derive(Clone, Copy, Debug)]
struct Level {
    inverse_cell: f64,
    columns: usize,
    rows: usize,
    /// Where the level's cells begin in `starts`.
    first: usize,
    largest_support: f64,
    is_occupied: bool,
}

/// Particles sorted by level and cell.
#[derive(Clone, Debug, Default)]
pub struct CellGrid {
    origin: Vec2,
    levels: Vec<Level>,
    starts: Vec<u32>,
    keys: Vec<u32>,
    order: Vec<u32>,
    x: Vec<f64>,
    y: Vec<f64>,
    support_squared: Vec<f64>,
}

impl CellGrid {
    /// Sorts particles anew; all memory is reused.
    ///
    /// - `positions` (m), finite
    /// - `supports` (m), above 0: a pair counts as near when its distance is below the larger support
    pub fn build(&mut self, positions: &[Vec2], supports: &[f64]) {
        debug_assert_eq!(positions.len(), supports.len());
        self.lay_out_levels(positions, supports);
        self.count(positions, supports);
        self.place(positions, supports);
    }

    fn lay_out_levels(&mut self, positions: &[Vec2], supports: &[f64]) {
        let extent = positions.par_iter().zip(supports).with_min_len(PARALLEL_PARTICLES);
        let extent = extent.fold(Extent::default, |extent, (&p, &s)| extent.around(Extent::of(p, s)));
        let Extent { low, high, smallest, largest } = extent.reduce(Extent::default, Extent::around);
        self.levels.clear();
        if positions.is_empty() {
            return;
        }
        self.origin = low;
        let (width, height) = (high.x - low.x, high.y - low.y);
        let allowed_cells = 4.0 * positions.len() as f64;
        // Never more cells than about four per particle, however small the smallest support.
        let mut cell = (0.5 * smallest)
            .max((width * height / allowed_cells).sqrt())
            .max(width.max(height) / allowed_cells)
            .max(1e-3 * largest);
        let mut first = 0;
        for level in 0..LEVELS {
            let is_last = level + 1 == LEVELS || cell >= 0.5 * largest;
            let columns = (width / cell) as usize + 1;
            let rows = (height / cell) as usize + 1;
            self.levels.push(Level {
                inverse_cell: 1.0 / cell,
                columns,
                rows,
                first,
                largest_support: 0.0,
                is_occupied: false,
            });
            first += columns * rows;
            if is_last {
                break;
            }
            cell *= 2.0;
        }
        self.starts.clear();
        self.starts.resize(first + 1, 0);
    }

    fn count(&mut self, positions: &[Vec2], supports: &[f64]) {
        let (levels, origin) = (&self.levels, self.origin);
        let last = levels.len().saturating_sub(1);
        let level_of = |support: f64| {
            levels[..last].iter().position(|level| 0.5 * support * level.inverse_cell <= 1.0).unwrap_or(last)
        };
        let key_of = |(&position, &support): (&Vec2, &f64)| {
            let level = &levels[level_of(support)];
            let column = (((position.x - origin.x) * level.inverse_cell) as usize).min(level.columns - 1);
            let row = (((position.y - origin.y) * level.inverse_cell) as usize).min(level.rows - 1);
            (level.first + row * level.columns + column) as u32
        };
        let all = positions.par_iter().zip(supports).with_min_len(PARALLEL_PARTICLES);
        all.clone().map(key_of).collect_into_vec(&mut self.keys);
        let largest = all.fold(
            || [0.0_f64; LEVELS],
            |mut largest, (_, &support)| {
                let level = &mut largest[level_of(support)];
                *level = level.max(support);
                largest
            },
        );
        let largest = largest.reduce(|| [0.0; LEVELS], |a, b| std::array::from_fn(|level| a[level].max(b[level])));
        for (level, largest) in self.levels.iter_mut().zip(largest) {
            (level.is_occupied, level.largest_support) = (largest > 0.0, largest);
        }
        for &key in &self.keys {
            self.starts[key as usize + 1] += 1;
        }
        for cell in 1..self.starts.len() {
            self.starts[cell] += self.starts[cell - 1];
        }
    }

    fn place(&mut self, positions: &[Vec2], supports: &[f64]) {
        let particles = positions.len();
        self.order.resize(particles, 0);
        self.x.resize(particles, 0.0);
        self.y.resize(particles, 0.0);
        self.support_squared.resize(particles, 0.0);
        for j in 0..particles {
            let slot = &mut self.starts[self.keys[j] as usize];
            let k = *slot as usize;
            *slot += 1;
            self.order[k] = j as u32;
            self.x[k] = positions[j].x;
            self.y[k] = positions[j].y;
            self.support_squared[k] = supports[j] * supports[j];
        }
        // Placing moved every start to the end of its cell, which is the start of the next one: shift back.
        for cell in (1..self.starts.len()).rev() {
            self.starts[cell] = self.starts[cell - 1];
        }
        if let Some(start) = self.starts.first_mut() {
            *start = 0;
        }
    }

    /// The largest support (m) of all particles; 0 without any.
    pub fn largest_support(&self) -> f64 {
        self.levels.iter().fold(0.0, |largest, level| level.largest_support.max(largest))
    }

    /// Particle indices in the order of levels and cells: memory order for fast gathering.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Appends to `found` every particle j with |x_j − position| < max(support, support_j), the particle itself included.
    pub fn within(&self, position: Vec2, support: f64, found: &mut Vec<u32>) {
        let support_squared = support * support;
        for level in self.levels.iter().filter(|level| level.is_occupied) {
            let reach = support.max(level.largest_support);
            let local = position - self.origin;
            let cell_of = |coordinate: f64| coordinate * level.inverse_cell;
            let (left, right) = (cell_of(local.x - reach), cell_of(local.x + reach));
            let (bottom, top) = (cell_of(local.y - reach), cell_of(local.y + reach));
            if right < 0.0 || top < 0.0 || left >= level.columns as f64 || bottom >= level.rows as f64 {
                continue;
            }
            // A cast of a negative number to usize gives 0.
            let (left, right) = (left as usize, (right as usize).min(level.columns - 1));
            for row in (bottom as usize)..=(top as usize).min(level.rows - 1) {
                let cells = level.first + row * level.columns;
                let (from, to) = (self.starts[cells + left] as usize, self.starts[cells + right + 1] as usize);
                // Every candidate is written and the end moves on past those that are near: no branch to mispredict.
                let mut end = found.len();
                found.resize(end + (to - from), 0);
                let candidates = self.x[from..to].iter().zip(&self.y[from..to]);
                let candidates = candidates.zip(&self.support_squared[from..to]).zip(&self.order[from..to]);
                for (((x, y), other_squared), &j) in candidates {
                    let (dx, dy) = (x - position.x, y - position.y);
                    found[end] = j;
                    end += usize::from(dx * dx + dy * dy < support_squared.max(*other_squared));
                }
                found.truncate(end);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighbours::within_brute_force;

    /// A repeatable sequence of numbers in [0, 1).
    fn numbers(mut state: u64) -> impl FnMut() -> f64 {
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    fn check(positions: &[Vec2], supports: &[f64]) {
        let mut grid = CellGrid::default();
        grid.build(positions, supports);
        let mut found = Vec::new();
        for (i, &position) in positions.iter().enumerate() {
            found.clear();
            grid.within(position, supports[i], &mut found);
            found.sort_unstable();
            assert_eq!(found, within_brute_force(positions, supports, position, supports[i]), "particle {i}");
        }
    }

    #[test]
    fn finds_what_the_plain_loop_finds() {
        let mut next = numbers(1);
        for (count, spread) in [(1, 1.0_f64), (2, 60.0), (300, 1.0), (300, 60.0), (300, 3000.0)] {
            let positions: Vec<Vec2> = (0..count).map(|_| Vec2::new(100.0 * next() - 50.0, 40.0 * next())).collect();
            let supports: Vec<f64> = (0..count).map(|_| 0.05 * spread.powf(next()) + 0.5).collect();
            check(&positions, &supports);
        }
    }

    #[test]
    fn works_on_a_line_and_in_a_heap() {
        let mut next = numbers(2);
        let line: Vec<Vec2> = (0..200).map(|_| Vec2::new(1000.0 * next(), 3.0)).collect();
        check(&line, &[12.0; 200]);
        let heap = [Vec2::new(1.0, 1.0); 20];
        check(&heap, &[1.0; 20]);
        check(&[], &[]);
    }

    #[test]
    fn few_wide_particles_do_not_spoil_the_others() {
        let mut next = numbers(3);
        let mut positions: Vec<Vec2> = (0..10_000).map(|k| Vec2::new(f64::from(k % 100), f64::from(k / 100))).collect();
        let mut supports = vec![3.0; 10_000];
        for _ in 0..10 {
            positions.push(Vec2::new(100.0 * next(), 100.0 * next()));
            supports.push(180.0);
        }
        let mut grid = CellGrid::default();
        grid.build(&positions, &supports);
        assert!(grid.starts.len() < 60_000, "about four cells a particle and level");
        let narrow = &grid.levels[0];
        assert!(1.0 / narrow.inverse_cell <= 3.0 && narrow.largest_support <= 3.0);
    }
}
