//! A cell list by counting sort, in levels: particles of similar support share a level, whose cells are half to one
//! support wide, so that a few wide particles of thin water do not spoil the search of all others.
//!
//! A search visits every occupied level; in each, rows of cells are contiguous runs of the sorted arrays.
//! The order of what is found depends on positions, supports and indices alone, never on threads.

use std::ops::Range;

use rayon::prelude::*;

use crate::math::{Vec2, larger};

/// Levels of cells, each twice as wide as the one below.
const LEVELS: usize = 12;

/// Particles that a thread takes at least.
const PARALLEL_PARTICLES: usize = 4096;

/// Candidates that are looked at together.
const LANES: usize = 8;

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
        // Eight candidates are read at a time, also from the last ones on.
        let padded = particles + LANES;
        self.order.resize(padded, 0);
        self.x.resize(padded, 0.0);
        self.y.resize(padded, 0.0);
        self.support_squared.resize(padded, 0.0);
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
        &self.order[..self.keys.len()]
    }

    /// Appends to `found` every particle j with |x_j − position| < max(support, support_j), except for one of them where that is told.
    pub fn within(&self, position: Vec2, support: f64, except: Option<u32>, found: &mut Vec<u32>) {
        self.within_by(collect, position, support, except, found);
    }

    #[inline(always)]
    fn within_by(&self, collect: Collect, position: Vec2, support: f64, except: Option<u32>, found: &mut Vec<u32>) {
        let centre = Centre { position, support_squared: support * support, except: except.unwrap_or(u32::MAX) };
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
            let (bottom, top) = (bottom as usize, (top as usize).min(level.rows - 1));
            let block = Block { columns: left..right + 1, rows: bottom..top + 1 };
            collect(self, level, &block, &centre, found);
        }
    }

    /// The candidates in a row of a level's cells: a run of the sorted arrays.
    #[inline(always)]
    fn run(&self, level: &Level, columns: &Range<usize>, row: usize) -> Range<usize> {
        let cells = level.first + row * level.columns;
        self.starts[cells + columns.start] as usize..self.starts[cells + columns.end] as usize
    }
}

/// Cells of a level.
struct Block {
    columns: Range<usize>,
    rows: Range<usize>,
}

/// Where a search looks from.
struct Centre {
    position: Vec2,
    support_squared: f64,
    /// Particle that is not looked for.
    except: u32,
}

/// A way of appending the particles of a block of cells, columns and rows, that are near.
type Collect = fn(&CellGrid, &Level, &Block, &Centre, &mut Vec<u32>);

/// By the best instructions that the processor has.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl+popcnt"))]
fn collect(grid: &CellGrid, level: &Level, block: &Block, centre: &Centre, found: &mut Vec<u32>) {
    multiversion::target::match_target! {
        "x86_64+avx512f+avx512vl+popcnt" => lanes::collect(grid, level, block, centre, found),
        _ => collect_one_by_one(grid, level, block, centre, found),
    }
}

/// Every candidate is written and the end moves on past those that are near: no branch to mispredict.
#[inline]
fn collect_one_by_one(grid: &CellGrid, level: &Level, block: &Block, centre: &Centre, found: &mut Vec<u32>) {
    for row in block.rows.start..block.rows.end {
        let run = grid.run(level, &block.columns, row);
        let mut end = found.len();
        found.resize(end + run.len(), 0);
        let candidates = grid.x[run.clone()].iter().zip(&grid.y[run.clone()]);
        let candidates = candidates.zip(&grid.support_squared[run.clone()]).zip(&grid.order[run]);
        for (((x, y), other_squared), &j) in candidates {
            let (dx, dy) = (x - centre.position.x, y - centre.position.y);
            found[end] = j;
            let is_near = dx * dx + dy * dy < larger(*other_squared, centre.support_squared);
            end += usize::from(is_near & (j != centre.except));
        }
        found.truncate(end);
    }
}

/// The same eight candidates at a time, by instructions that pack those lanes that count.
#[cfg(target_arch = "x86_64")]
mod lanes {
    use std::arch::x86_64::{
        __m256i, __m512d, __mmask8, _CMP_LT_OQ, _mm256_mask_cmpneq_epi32_mask, _mm256_maskz_compress_epi32,
        _mm256_set1_epi32, _mm512_add_pd, _mm512_mask_cmp_pd_mask, _mm512_max_pd, _mm512_mul_pd, _mm512_set1_pd,
        _mm512_sub_pd,
    };

    use super::{Block, CellGrid, Centre, LANES, Level};

    #[target_feature(enable = "avx512f,avx512vl,popcnt")]
    #[inline]
    pub(super) fn collect(grid: &CellGrid, level: &Level, block: &Block, centre: &Centre, found: &mut Vec<u32>) {
        let (x, y) = (_mm512_set1_pd(centre.position.x), _mm512_set1_pd(centre.position.y));
        let support_squared = _mm512_set1_pd(centre.support_squared);
        let except = _mm256_set1_epi32(centre.except as i32);
        let (mut packed, mut end) = ([0; 16 * LANES], 0);
        for row in block.rows.start..block.rows.end {
            let run = grid.run(level, &block.columns, row);
            // The arrays are longer than the last run by so many lanes.
            let padded = run.start..(run.end + LANES - 1);
            let (other_x, other_y) = (grid.x[padded.clone()].as_chunks().0, grid.y[padded.clone()].as_chunks().0);
            let (other_squared, order) =
                (grid.support_squared[padded.clone()].as_chunks().0, grid.order[padded].as_chunks::<LANES>().0);
            let mut left = run.len();
            for (((other_x, other_y), other_squared), order) in
                other_x.iter().zip(other_y).zip(other_squared).zip(order)
            {
                let order: __m256i = bytemuck::must_cast(*order);
                let in_run = (0xff_u32 >> LANES.saturating_sub(left)) as __mmask8;
                left = left.wrapping_sub(LANES);
                let (dx, dy) = (_mm512_sub_pd(lanes(other_x), x), _mm512_sub_pd(lanes(other_y), y));
                let distance_squared = _mm512_add_pd(_mm512_mul_pd(dx, dx), _mm512_mul_pd(dy, dy));
                let reach_squared = _mm512_max_pd(lanes(other_squared), support_squared);
                let near = _mm512_mask_cmp_pd_mask::<_CMP_LT_OQ>(in_run, distance_squared, reach_squared);
                let near = _mm256_mask_cmpneq_epi32_mask(near, order, except);
                if end > packed.len() - LANES {
                    found.extend_from_slice(&packed[..end]);
                    end = 0;
                }
                let of_lanes: [u32; LANES] = bytemuck::must_cast(_mm256_maskz_compress_epi32(near, order));
                packed[end..end + LANES].copy_from_slice(&of_lanes);
                end += near.count_ones() as usize;
            }
        }
        found.extend_from_slice(&packed[..end]);
    }

    #[target_feature(enable = "avx512f,avx512vl,popcnt")]
    #[inline]
    fn lanes(values: &[f64; LANES]) -> __m512d {
        bytemuck::must_cast(*values)
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
            let all = within_brute_force(positions, supports, position, supports[i]);
            for except in [None, Some(i as u32)] {
                let expected: Vec<u32> = all.iter().copied().filter(|&j| Some(j) != except).collect();
                for collect in [collect, collect_one_by_one] {
                    found.clear();
                    grid.within_by(collect, position, supports[i], except, &mut found);
                    found.sort_unstable();
                    assert_eq!(found, expected, "particle {i}");
                }
            }
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
