//! A cell list by counting sort, in levels: particles of similar support share a level, whose cells are half to one
//! support wide, so that a few wide particles of thin water do not spoil the search of all others.
//!
//! A search visits every occupied level; in each, rows of cells are contiguous runs of the sorted arrays.
//! The order of what is found depends on positions, supports and indices alone, never on threads.

use crate::math::Vec2;

/// Levels of cells, each twice as wide as the one below.
const LEVELS: usize = 12;

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
        let mut low = Vec2::new(f64::INFINITY, f64::INFINITY);
        let mut high = Vec2::new(f64::NEG_INFINITY, f64::NEG_INFINITY);
        for p in positions {
            low = Vec2::new(low.x.min(p.x), low.y.min(p.y));
            high = Vec2::new(high.x.max(p.x), high.y.max(p.y));
        }
        let (smallest, largest) =
            supports.iter().fold((f64::INFINITY, 0.0_f64), |(small, large), &s| (small.min(s), large.max(s)));
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
        self.keys.clear();
        for (&position, &support) in positions.iter().zip(supports) {
            let last = self.levels.len() - 1;
            let level =
                self.levels[..last].iter().position(|level| 0.5 * support * level.inverse_cell <= 1.0).unwrap_or(last);
            let level = &mut self.levels[level];
            level.is_occupied = true;
            level.largest_support = level.largest_support.max(support);
            let column = (((position.x - self.origin.x) * level.inverse_cell) as usize).min(level.columns - 1);
            let row = (((position.y - self.origin.y) * level.inverse_cell) as usize).min(level.rows - 1);
            let key = level.first + row * level.columns + column;
            self.keys.push(key as u32);
            self.starts[key + 1] += 1;
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
