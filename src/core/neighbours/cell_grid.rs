//! A cell list by counting sort, in levels: particles of similar support share a level, whose cells are made for
//! half to one support, so that a few wide particles of thin water do not spoil the search of all others. The levels are laid so that
//! most particles stand near the upper end of theirs, where cells are narrowest for them, and that few alone make no level below.
//!
//! A search visits every level that has particles within its reach; in each, rows of cells are contiguous runs of the sorted arrays. What
//! it finds in a run is given as spans: where sixteen candidates begin, and which of them are near.
//! The order of what is found depends on positions, supports and indices alone, never on threads.
//!
//! Places are compared as whole numbers of a small unit, their distances in single precision. What that is not sure of, a sliver
//! of some 1e-6 of a support at its rim, does not count as near: there kernels are next to nothing.

use std::ops::Range;

use rayon::prelude::*;

use crate::math::Vec2;

/// Levels of cells, each twice as wide as the one below.
const LEVELS: usize = 12;

/// Particles of a block, which a thread takes as a whole.
const PARALLEL_PARTICLES: usize = 4096;

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

/// Columns and rows of cells, in units of the width of their level: long low runs hold few candidates that are not near, and each of
/// them is no longer than what is looked at together.
const COLUMN: f64 = 0.5;
const ROW: f64 = 4.0 / 3.0;

/// Candidates that are looked at together.
const LANES: usize = 16;

/// Bands of cells that are filled side by side, at most.
const BANDS: usize = 32;

/// Units in twice what all particles span with their supports: places beside the particles have to be told apart, too.
const UNITS: f64 = (1_u32 << 30) as f64;

/// Share of a support that the rounding of its square and of a distance may take.
const ROUNDING: f64 = 5e-7;

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
    /// Width of particles that are at home here: half to one support (m).
    width: f64,
    per_column: f64,
    per_row: f64,
    columns: usize,
    rows: usize,
    /// Where the level's cells begin in `starts`.
    first: usize,
    taken: Taken,
}

/// What the particles of a level take: their largest support (m), 0 without any, and the cells in which they stand, first and last.
#[derive(Clone, Copy, Debug)]
struct Taken {
    largest_support: f64,
    low: (usize, usize),
    high: (usize, usize),
}

impl Taken {
    const NOTHING: Taken = Taken { largest_support: 0.0, low: (usize::MAX, usize::MAX), high: (0, 0) };

    fn and(self, other: Taken) -> Taken {
        Taken {
            largest_support: self.largest_support.max(other.largest_support),
            low: (self.low.0.min(other.low.0), self.low.1.min(other.low.1)),
            high: (self.high.0.max(other.high.0), self.high.1.max(other.high.1)),
        }
    }
}

/// Sixteen candidates side by side in the order of the cells, and which of them are near.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C, packed(2))]
pub struct Span {
    first: u32,
    /// One bit for each of them.
    near: u16,
}

/// What a search finds; scratch space.
#[derive(Clone, Debug, Default)]
pub struct Found {
    spans: Vec<Span>,
    list: Vec<u32>,
}

/// How many particles of a block are in each band of cells.
type Census = [u32; BANDS];

/// Particles sorted by level and cell.
#[derive(Clone, Debug, Default)]
pub struct CellGrid {
    origin: Vec2,
    /// Units in a metre.
    scale: f64,
    levels: Vec<Level>,
    starts: Vec<u32>,
    keys: Vec<u32>,
    censuses: Vec<Census>,
    order: Vec<u32>,
    /// Places from the origin on, in units.
    x: Vec<i32>,
    y: Vec<i32>,
    /// Squares of the supports, in units.
    reach_squared: Vec<f32>,
}

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

impl CellGrid {
    /// Sorts particles anew; all memory is reused.
    ///
    /// - `positions` (m), finite
    /// - `supports` (m), above 0: a pair counts as near when its distance is below the larger support
    pub fn build(&mut self, positions: &[Vec2], supports: &[f32]) {
        debug_assert_eq!(positions.len(), supports.len());
        self.lay_out_levels(positions, supports);
        self.find_cells(positions, supports);
        self.place(positions, supports);
    }

    fn lay_out_levels(&mut self, positions: &[Vec2], supports: &[f32]) {
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

    /// The number of a cell, shifted to the right so far, is that of its band.
    fn band_shift(&self) -> u32 {
        self.starts.len().div_ceil(BANDS).next_power_of_two().trailing_zeros()
    }

    fn find_cells(&mut self, positions: &[Vec2], supports: &[f32]) {
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
    fn place(&mut self, positions: &[Vec2], supports: &[f32]) {
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
        bands.into_par_iter().with_max_len(1).for_each(|band| {
            let blocks = || {
                let of_band = censuses.iter().enumerate().filter(|(_, census)| census[band.index] > 0);
                let particles = of_band.flat_map(|(block, _)| {
                    let first = block * PARALLEL_PARTICLES;
                    first..(first + PARALLEL_PARTICLES).min(keys.len())
                });
                particles.filter(|&j| (keys[j] >> shift) as usize == band.index)
            };
            let first_cell = (band.index << shift) as u32;
            band.starts.fill(0);
            for j in blocks() {
                band.starts[(keys[j] - first_cell) as usize] += 1;
            }
            let mut end = band.before;
            for start in band.starts.iter_mut() {
                end += *start;
                *start = end - *start;
            }
            for j in blocks() {
                let slot = &mut band.starts[(keys[j] - first_cell) as usize];
                let k = (*slot - band.before) as usize;
                *slot += 1;
                let place = (positions[j] - origin) * scale;
                band.order[k] = j as u32;
                (band.x[k], band.y[k]) = (place.x as i32, place.y as i32);
                band.reach_squared[k] = reach_squared_of(f64::from(supports[j]) * scale);
            }
            // Placing moved every start to the end of its cell, which is the start of the next one: shift back.
            let cells = band.starts.len();
            if cells > 0 {
                band.starts.copy_within(..cells - 1, 1);
                band.starts[0] = band.before;
            }
        });
    }

    /// The largest support (m) of all particles; 0 without any.
    pub fn largest_support(&self) -> f64 {
        self.levels.iter().fold(0.0, |largest, level| level.taken.largest_support.max(largest))
    }

    /// Particle indices in the order of levels and cells: memory order for fast gathering.
    pub fn order(&self) -> &[u32] {
        &self.order[..self.keys.len()]
    }

    /// Memory that is free when the search is over; the order stays.
    pub fn spare_memory(&mut self) -> [&mut [f32]; 4] {
        let CellGrid { starts, x, y, reach_squared, .. } = self;
        let of_cells = bytemuck::cast_slice_mut(starts);
        [of_cells, bytemuck::cast_slice_mut(x), bytemuck::cast_slice_mut(y), reach_squared]
    }

    /// Every particle j with |x_j − position| < max(support, support_j), but for a sliver at the rim.
    pub fn within<'a>(&self, position: Vec2, support: f64, found: &'a mut Found) -> &'a mut [u32] {
        self.spans_and_list_within(position, support, found).1
    }

    /// The same as spans and as a list.
    pub fn spans_and_list_within<'a>(
        &self,
        position: Vec2,
        support: f64,
        Found { spans, list }: &'a mut Found,
    ) -> (&'a [Span], &'a mut [u32]) {
        spans.clear();
        self.spans_by(collect, position, support, u32::MAX, spans);
        (spans, self.list(spans, list))
    }

    /// Appends spans that were found to others, without particle `except`: what `spans_within` finds, without a search.
    pub fn append_without(&self, found: &[Span], except: u32, spans: &mut Vec<Span>) {
        for &Span { first, near } in found {
            // What lies behind the last particle is near to none.
            let candidates = self.order[first as usize..].iter().take(LANES).enumerate();
            let others = candidates.filter(|&(_, &j)| j != except).fold(0, |others, (k, _)| others | 1 << k);
            if near & others != 0 {
                spans.push(Span { first, near: near & others });
            }
        }
    }

    /// Appends the same to `spans`, without particle `except`.
    pub fn spans_within(&self, position: Vec2, support: f64, except: u32, spans: &mut Vec<Span>) {
        self.spans_by(collect, position, support, except, spans);
    }

    #[inline(always)]
    fn spans_by(&self, collect: Collect, position: Vec2, support: f64, except: u32, spans: &mut Vec<Span>) {
        let local = position - self.origin;
        let centre = Centre {
            x: (local.x * self.scale) as i32,
            y: (local.y * self.scale) as i32,
            reach_squared: reach_squared_of(support * self.scale),
            except,
        };
        for level in &self.levels {
            let Taken { largest_support, low, high } = level.taken;
            let reach = support.max(largest_support);
            let (left, right) = ((local.x - reach) * level.per_column, (local.x + reach) * level.per_column);
            let (bottom, top) = ((local.y - reach) * level.per_row, (local.y + reach) * level.per_row);
            if right < 0.0 || top < 0.0 {
                continue;
            }
            // A cast of a negative number to usize gives 0. None is as low as the first cell of an empty level.
            let (left, right) = ((left as usize).max(low.0), (right as usize).min(high.0));
            let (bottom, top) = ((bottom as usize).max(low.1), (top as usize).min(high.1));
            if left > right || bottom > top {
                continue;
            }
            let block = Block { columns: left..right + 1, rows: bottom..top + 1 };
            collect(self, level, &block, &centre, spans);
        }
    }

    /// The particles of spans, in a buffer that is overwritten and grows where it is too short.
    #[inline]
    pub fn list<'a>(&self, spans: &[Span], buffer: &'a mut Vec<u32>) -> &'a mut [u32] {
        let most = LANES * spans.len();
        if buffer.len() < most {
            buffer.resize(most, 0);
        }
        let count = list(&self.order, spans, buffer);
        &mut buffer[..count]
    }

    /// The candidates in a row of a level's cells: a run of the sorted arrays.
    #[inline(always)]
    fn run(&self, level: &Level, columns: &Range<usize>, row: usize) -> Range<usize> {
        let cells = level.first + row * level.columns;
        self.starts[cells + columns.start] as usize..self.starts[cells + columns.end] as usize
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

/// The square of a support in units, less what rounding may add to a distance.
fn reach_squared_of(units: f64) -> f32 {
    let sure = (units * (1.0 - ROUNDING) - 2.0).max(0.0);
    (sure * sure) as f32
}

/// Cells of a level.
struct Block {
    columns: Range<usize>,
    rows: Range<usize>,
}

/// Where a search looks from.
struct Centre {
    x: i32,
    y: i32,
    reach_squared: f32,
    /// Particle that is not looked for; none has the greatest number.
    except: u32,
}

/// A way of appending the spans of a block of cells, columns and rows, in which any particle is near.
type Collect = fn(&CellGrid, &Level, &Block, &Centre, &mut Vec<Span>);

/// Sixteen candidates as they lie in the sorted arrays.
struct Candidates<'a> {
    x: &'a [i32; LANES],
    y: &'a [i32; LANES],
    reach_squared: &'a [f32; LANES],
    order: &'a [u32; LANES],
}

/// By the best instructions that the processor has.
#[multiversion::multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn collect(grid: &CellGrid, level: &Level, block: &Block, centre: &Centre, spans: &mut Vec<Span>) {
    multiversion::target::match_target! {
        "x86_64+avx512f" => lanes::collect(grid, level, block, centre, spans),
        "x86_64+avx2" => half_lanes::collect(grid, level, block, centre, spans),
        _ => collect_one_by_one(grid, level, block, centre, spans),
    }
}

/// `near` tells which of sixteen candidates are near, one bit for each.
#[inline(always)]
fn collect_by(
    near: impl Fn(&Candidates<'_>) -> u16,
    grid: &CellGrid,
    level: &Level,
    block: &Block,
    spans: &mut Vec<Span>,
) {
    /// Spans that are kept aside before they are appended.
    const ASIDE: usize = 16;
    let (mut aside, mut end) = ([Span::default(); ASIDE], 0);
    // Of one length, of which the compiler knows.
    let padded = grid.order.len();
    let (all_x, all_y, order) = (&grid.x[..padded], &grid.y[..padded], &grid.order[..padded]);
    let all_squared = &grid.reach_squared[..padded];
    for row in block.rows.start..block.rows.end {
        let run = grid.run(level, &block.columns, row);
        let mut first = run.start;
        // The arrays are longer than the last run by so many lanes.
        while first < run.end && first + LANES <= padded {
            let lanes = first..first + LANES;
            let (Some(x), Some(y), Some(reach_squared), Some(order)) = (
                all_x[lanes.clone()].first_chunk::<LANES>(),
                all_y[lanes.clone()].first_chunk::<LANES>(),
                all_squared[lanes.clone()].first_chunk::<LANES>(),
                order[lanes].first_chunk::<LANES>(),
            ) else {
                break;
            };
            let in_run = (0xffff_u32 >> LANES.saturating_sub(run.end - first)) as u16;
            let near = near(&Candidates { x, y, reach_squared, order }) & in_run;
            aside[end] = Span { first: first as u32, near };
            end += usize::from(near != 0);
            if end == ASIDE {
                spans.extend_from_slice(&aside);
                end = 0;
            }
            first += LANES;
        }
    }
    spans.extend_from_slice(&aside[..end]);
}

#[inline]
fn collect_one_by_one(grid: &CellGrid, level: &Level, block: &Block, centre: &Centre, spans: &mut Vec<Span>) {
    let near = |others: &Candidates<'_>| {
        (0..LANES).fold(0, |near, k| {
            let dx = others.x[k].wrapping_sub(centre.x) as f32;
            let dy = others.y[k].wrapping_sub(centre.y) as f32;
            let reach_squared = others.reach_squared[k].max(centre.reach_squared);
            let is_near = (dx * dx + dy * dy < reach_squared) & (others.order[k] != centre.except);
            near | u16::from(is_near) << k
        })
    };
    collect_by(near, grid, level, block, spans);
}

/// Writes the particles of spans; returns how many there are. By the best instructions that the processor has.
#[multiversion::multiversion(targets("x86_64+avx512f+popcnt", "x86_64+avx2+popcnt"))]
fn list(order: &[u32], spans: &[Span], found: &mut [u32]) -> usize {
    multiversion::target::match_target! {
        "x86_64+avx512f+popcnt" => lanes::list(order, spans, found),
        "x86_64+avx2+popcnt" => half_lanes::list(order, spans, found),
        _ => list_one_by_one(order, spans, found),
    }
}

#[inline]
fn list_one_by_one(order: &[u32], spans: &[Span], found: &mut [u32]) -> usize {
    let mut count = 0;
    for span in spans {
        let mut near = span.near;
        while near != 0 {
            found[count] = order[span.first as usize + near.trailing_zeros() as usize];
            count += 1;
            near &= near - 1;
        }
    }
    count
}

/// `pack` writes those of sixteen candidates whose bit is set to the front.
#[inline(always)]
fn list_by(
    pack: impl Fn(u16, &[u32; LANES], &mut [u32; LANES]),
    order: &[u32],
    spans: &[Span],
    found: &mut [u32],
) -> usize {
    let mut count = 0;
    for &Span { first, near } in spans {
        let (Some(candidates), Some(found)) =
            (order[first as usize..].first_chunk::<LANES>(), found[count..].first_chunk_mut::<LANES>())
        else {
            break;
        };
        pack(near, candidates, found);
        count += near.count_ones() as usize;
    }
    count
}

/// The same sixteen candidates at a time, by instructions that compare into masks and pack the lanes of a mask.
#[cfg(target_arch = "x86_64")]
mod lanes {
    use std::arch::x86_64::{
        _CMP_LT_OQ, _mm512_add_ps, _mm512_cmp_ps_mask, _mm512_cvtepi32_ps, _mm512_mask_cmpneq_epi32_mask,
        _mm512_maskz_compress_epi32, _mm512_max_ps, _mm512_mul_ps, _mm512_set1_epi32, _mm512_set1_ps, _mm512_sub_epi32,
    };

    use bytemuck::must_cast;

    use super::{Block, Candidates, CellGrid, Centre, Level, Span, collect_by, list_by};

    #[target_feature(enable = "avx512f")]
    #[inline]
    pub(super) fn collect(grid: &CellGrid, level: &Level, block: &Block, centre: &Centre, spans: &mut Vec<Span>) {
        let (x, y) = (_mm512_set1_epi32(centre.x), _mm512_set1_epi32(centre.y));
        let own_squared = _mm512_set1_ps(centre.reach_squared);
        let except = _mm512_set1_epi32(centre.except as i32);
        let near = |others: &Candidates<'_>| {
            let dx = _mm512_cvtepi32_ps(_mm512_sub_epi32(must_cast(*others.x), x));
            let dy = _mm512_cvtepi32_ps(_mm512_sub_epi32(must_cast(*others.y), y));
            let distance_squared = _mm512_add_ps(_mm512_mul_ps(dx, dx), _mm512_mul_ps(dy, dy));
            let reach_squared = _mm512_max_ps(must_cast(*others.reach_squared), own_squared);
            let near = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(distance_squared, reach_squared);
            _mm512_mask_cmpneq_epi32_mask(near, must_cast(*others.order), except)
        };
        collect_by(near, grid, level, block, spans);
    }

    #[target_feature(enable = "avx512f,popcnt")]
    #[inline]
    pub(super) fn list(order: &[u32], spans: &[Span], found: &mut [u32]) -> usize {
        list_by(
            |near, candidates, found| *found = must_cast(_mm512_maskz_compress_epi32(near, must_cast(*candidates))),
            order,
            spans,
            found,
        )
    }
}

/// The same eight and eight, by instructions that gather the signs of lanes and move lanes by a table.
#[cfg(target_arch = "x86_64")]
mod half_lanes {
    use std::arch::x86_64::{
        _CMP_LT_OQ, _mm_cvtsi64_si128, _mm256_add_ps, _mm256_andnot_ps, _mm256_castsi256_ps, _mm256_cmp_ps,
        _mm256_cmpeq_epi32, _mm256_cvtepi32_ps, _mm256_cvtepu8_epi32, _mm256_max_ps, _mm256_movemask_ps, _mm256_mul_ps,
        _mm256_permutevar8x32_epi32, _mm256_set1_epi32, _mm256_set1_ps, _mm256_sub_epi32,
    };

    use bytemuck::must_cast;

    use super::{Block, Candidates, CellGrid, Centre, LANES, Level, Span, collect_by, list_by};

    const HALF: usize = LANES / 2;

    /// Of each mask of eight the lanes whose bit is set, in their order.
    static LANES_OF: [[u8; HALF]; 1 << HALF] = lanes_of_masks();

    const fn lanes_of_masks() -> [[u8; HALF]; 1 << HALF] {
        let mut lanes_of = [[0; HALF]; 1 << HALF];
        let mut mask = 0;
        while mask < 1 << HALF {
            let (mut lane, mut count) = (0, 0);
            while lane < HALF {
                if mask >> lane & 1 == 1 {
                    lanes_of[mask][count] = lane as u8;
                    count += 1;
                }
                lane += 1;
            }
            mask += 1;
        }
        lanes_of
    }

    #[target_feature(enable = "avx2")]
    #[inline]
    pub(super) fn collect(grid: &CellGrid, level: &Level, block: &Block, centre: &Centre, spans: &mut Vec<Span>) {
        let (x, y) = (_mm256_set1_epi32(centre.x), _mm256_set1_epi32(centre.y));
        let own_squared = _mm256_set1_ps(centre.reach_squared);
        let except = _mm256_set1_epi32(centre.except as i32);
        let near_of_half = |other_x: [i32; HALF], other_y: [i32; HALF], squared: [f32; HALF], order: [u32; HALF]| {
            let dx = _mm256_cvtepi32_ps(_mm256_sub_epi32(must_cast(other_x), x));
            let dy = _mm256_cvtepi32_ps(_mm256_sub_epi32(must_cast(other_y), y));
            let distance_squared = _mm256_add_ps(_mm256_mul_ps(dx, dx), _mm256_mul_ps(dy, dy));
            let reach_squared = _mm256_max_ps(must_cast(squared), own_squared);
            let near = _mm256_cmp_ps::<_CMP_LT_OQ>(distance_squared, reach_squared);
            let excepted = _mm256_castsi256_ps(_mm256_cmpeq_epi32(must_cast(order), except));
            _mm256_movemask_ps(_mm256_andnot_ps(excepted, near)) as u16
        };
        let near = |others: &Candidates<'_>| {
            let [x_0, x_1]: [[i32; HALF]; 2] = must_cast(*others.x);
            let [y_0, y_1]: [[i32; HALF]; 2] = must_cast(*others.y);
            let [squared_0, squared_1]: [[f32; HALF]; 2] = must_cast(*others.reach_squared);
            let [order_0, order_1]: [[u32; HALF]; 2] = must_cast(*others.order);
            near_of_half(x_0, y_0, squared_0, order_0) | near_of_half(x_1, y_1, squared_1, order_1) << HALF
        };
        collect_by(near, grid, level, block, spans);
    }

    #[target_feature(enable = "avx2,popcnt")]
    #[inline]
    pub(super) fn list(order: &[u32], spans: &[Span], found: &mut [u32]) -> usize {
        let packed = |near: u8, candidates: [u32; HALF]| -> [u32; HALF] {
            let lanes = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(must_cast(LANES_OF[usize::from(near)])));
            must_cast(_mm256_permutevar8x32_epi32(must_cast(candidates), lanes))
        };
        let pack = |near: u16, candidates: &[u32; LANES], found: &mut [u32; LANES]| {
            let [low, high] = near.to_le_bytes();
            let [first, second]: [[u32; HALF]; 2] = must_cast(*candidates);
            let behind = low.count_ones() as usize;
            found[..HALF].copy_from_slice(&packed(low, first));
            found[behind..behind + HALF].copy_from_slice(&packed(high, second));
        };
        list_by(pack, order, spans, found)
    }
}

#[cfg(test)]
mod tests;
