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

mod fill;
mod levels;
mod near;

use std::ops::Range;

use crate::math::Vec2;
use fill::Census;
use levels::{Level, Taken};
use near::{Block, Centre, Collect, collect, list};

/// Particles of a block, which a thread takes as a whole.
const PARALLEL_PARTICLES: usize = 4096;

/// Candidates that are looked at together.
const LANES: usize = 16;

/// Share of a support that the rounding of its square and of a distance may take.
const ROUNDING: f64 = 5e-7;

/// Sixteen candidates side by side in the order of the cells, and which of them are near.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[repr(C, packed(2))]
pub struct Span {
    first: u32,
    /// One bit for each of them.
    near: u16,
}

/// What a search finds; scratch space.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Found {
    spans: Vec<Span>,
    list: Vec<u32>,
}

/// Particles sorted by level and cell.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
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

    /// The largest support (m) of all particles; 0 without any.
    pub fn largest_support(&self) -> f64 {
        self.levels.iter().fold(0.0, |largest, level| level.taken.largest_support.max(largest))
    }

    /// Particle indices in the order of levels and cells: memory order for fast gathering.
    pub fn order(&self) -> &[u32] {
        &self.order[..self.keys.len()]
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

/// The square of a support in units, less what rounding may add to a distance.
#[inline]
fn reach_squared_of(units: f64) -> f32 {
    let sure = (units * (1.0 - ROUNDING) - 2.0).max(0.0);
    (sure * sure) as f32
}

#[cfg(test)]
mod tests;
