//! Lattices nested 2:1: which level stands for which part of the finest lattice.
//!
//! Level 0 is the lattice itself, a cell of level l has 2^l times its edge. Levels lie behind each other in the rows of one stack, those
//! of level 0 first, with [`BETWEEN`] rows without cells between two levels, so that no loop over neighbouring rows joins two of them.
//! Blocks of `block` by `block` cells are of one level as a whole. Blocks that touch, be it by a corner, are at most one level apart, so
//! that each level is a block wide at least between a finer and a coarser one.
//!
//! Cells that follow lines ([`Conforming`]) have rows between those of level 0 and level 1.

use super::conforming::Conforming;

/// Rows between two levels: as many as a loop looks beyond a row.
const BETWEEN: usize = 2;

/// One level of a nested lattice.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Level {
    /// The first of its rows.
    pub first_row: usize,
    /// Number of its columns.
    pub columns: usize,
    /// Number of its rows.
    pub rows: usize,
    /// Edge of its cells (m).
    pub spacing: f64,
}

impl Level {
    /// Whether a row is one of its own.
    #[inline]
    pub fn holds_row(&self, row: usize) -> bool {
        (self.first_row..self.first_row + self.rows).contains(&row)
    }
}

/// The levels of a lattice, and where each of them stands.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Nest {
    block: usize,
    levels: Vec<Level>,
    /// Blocks of the finest lattice in a row of them.
    block_columns: usize,
    /// The level that stands for each block of the finest lattice.
    of_block: Vec<u8>,
    conforming: Option<Conforming>,
}

impl Nest {
    /// The levels for a lattice of `columns` by `rows` cells of an edge `spacing` (m), in blocks of `block` cells, a power of two.
    ///
    /// `wanted` tells for a block of the finest lattice (column, row of blocks) the coarsest level that does there; no block gets a
    /// coarser one, and none coarser than `coarsest`.
    pub fn graded(
        (columns, rows): (usize, usize),
        spacing: f64,
        block: usize,
        coarsest: usize,
        wanted: impl Fn(usize, usize) -> usize,
    ) -> Self {
        assert!(block.is_power_of_two(), "blocks of {block} cells do not nest");
        let mut levels: Vec<Level> = Vec::new();
        for level in 0..=coarsest {
            let first_row = levels.last().map_or(0, |finer| finer.first_row + finer.rows + BETWEEN);
            let cells = |count: usize| count.div_ceil(1 << level);
            let spacing = spacing * (1_u64 << level) as f64;
            levels.push(Level { first_row, columns: cells(columns), rows: cells(rows), spacing });
        }
        let (block_columns, block_rows) = (columns.div_ceil(block), rows.div_ceil(block));
        let at = |wanted: usize| u8::try_from(wanted.min(coarsest)).unwrap_or(u8::MAX);
        let mut of_block = Vec::with_capacity(block_columns * block_rows);
        for row in 0..block_rows {
            of_block.extend((0..block_columns).map(|column| at(wanted(column, row))));
        }
        let mut nest = Nest { block, levels, block_columns, of_block, conforming: None };
        for level in 1..=coarsest {
            nest.make_room(level, (block_columns, block_rows));
        }
        nest
    }

    /// One level alone, for a lattice of `columns` by `rows` cells of an edge `spacing` (m).
    pub fn of_one_level((columns, rows): (usize, usize), spacing: f64) -> Self {
        Nest::graded((columns, rows), spacing, columns.max(rows).max(1).next_power_of_two(), 0, |_, _| 0)
    }

    /// The same with cells that follow lines in place of some squares of the finest level.
    #[must_use]
    pub fn with(mut self, conforming: Conforming) -> Self {
        let first_row = self.levels[0].rows + BETWEEN;
        let conforming = conforming.beginning_at(first_row);
        let more = conforming.rows().end + BETWEEN - first_row;
        self.levels[1..].iter_mut().for_each(|level| level.first_row += more);
        self.conforming = Some(conforming);
        self
    }

    /// The cells that follow lines, where there are any.
    #[inline]
    pub fn conforming(&self) -> Option<&Conforming> {
        self.conforming.as_ref()
    }

    /// Divides the blocks of a level that hold or touch blocks of a finer level than the next.
    fn make_room(&mut self, level: usize, (columns, rows): (usize, usize)) {
        let finer = u8::try_from(level - 1).unwrap_or(u8::MAX);
        let (wide, high) = (columns.div_ceil(1 << level), rows.div_ceil(1 << level));
        let parts = |from: usize, to: usize, count: usize| (from << level).min(count)..(to << level).min(count);
        let finest_within = |nest: &Nest, across: std::ops::Range<usize>, up: std::ops::Range<usize>| {
            up.flat_map(|row| across.clone().map(move |column| (column, row)))
                .map(|(column, row)| nest.of_block[row * nest.block_columns + column])
                .min()
                .unwrap_or(u8::MAX)
        };
        let of_parent: Vec<u8> = (0..wide * high)
            .map(|parent| {
                let (column, row) = (parent % wide, parent / wide);
                finest_within(self, parts(column, column + 1, columns), parts(row, row + 1, rows))
            })
            .collect();
        for parent in 0..wide * high {
            let (column, row) = (parent % wide, parent / wide);
            let near = |place: usize, count: usize| place.saturating_sub(1)..(place + 2).min(count);
            let finest_about = near(row, high)
                .flat_map(|row| near(column, wide).map(move |column| row * wide + column))
                .map(|about| of_parent[about])
                .min()
                .unwrap_or(u8::MAX);
            // A block of this level is left whole where nothing in it is finer, and nothing about it by two levels.
            if of_parent[parent] > finer && finest_about >= finer {
                continue;
            }
            for row in parts(row, row + 1, rows) {
                for column in parts(column, column + 1, columns) {
                    let place = &mut self.of_block[row * columns + column];
                    *place = (*place).min(finer);
                }
            }
        }
    }

    /// The levels, the finest first.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// The number of the level to which a row belongs; rows between two levels count to the finer one.
    #[inline]
    pub fn number_of_row(&self, row: usize) -> usize {
        self.levels.partition_point(|level| level.first_row <= row) - 1
    }

    /// Number of rows of all levels, with those between them.
    pub fn all_rows(&self) -> usize {
        let of_levels = self.levels.last().map_or(0, |level| level.first_row + level.rows);
        self.conforming().map_or(of_levels, |conforming| conforming.rows().end.max(of_levels))
    }

    /// The level that stands for a cell of the finest lattice.
    #[inline]
    pub fn level_of(&self, column: usize, row: usize) -> usize {
        usize::from(self.of_block[row / self.block * self.block_columns + column / self.block])
    }
}
