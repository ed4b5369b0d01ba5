//! Blocks of water at rest asleep: still water costs nothing until something reaches it.
//!
//! After the first step a block sleeps where the speed of its water is that of rounding (M102), and that of the blocks about it, and no
//! water comes and no bed changes there. Its cells are no longer active. It wakes for good when water moves in a block beside it or
//! beside that one, so that what a step carries over the edge of a sleeping block is rounding, too.
//!
//! What passes a face between a cell awake and one asleep of one level is held, on whichever side the one asleep lies: so a mirror image is the
//! same to the last bit. Hanging faces are computed as ever, with the sleeping water as it was.

#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, HashSet};

use super::super::rows::{EAST, NORTH};
use super::super::state::{FluxRow, State, WaterRow};
use super::runs::{Run, hand_over, within};

/// Cells of a block along a side, at least.
const BLOCK: usize = 16;

/// Speed (m/s) up to which water counts as still: ten times the rounding of a lake at rest.
const STILL: f64 = 1e-11;

/// A padded place (row, column).
type Place = (usize, usize);

/// The blocks of one level.
#[derive(serde::Serialize, serde::Deserialize)]
struct Blocks {
    /// Padded rows and columns where blocks begin, and where the last ends.
    rows: Vec<usize>,
    columns: Vec<usize>,
    /// Blocks of the levels before.
    first: usize,
}

impl Blocks {
    /// Number of the block of a padded place, where the level has it.
    fn at(&self, (row, column): Place) -> Option<usize> {
        let (down, across) = (interval(&self.rows, row)?, interval(&self.columns, column)?);
        Some(self.first + down * (self.columns.len() - 1) + across)
    }

    fn count(&self) -> usize {
        (self.rows.len() - 1) * (self.columns.len() - 1)
    }

    /// Rows and columns of a block of the level.
    fn cells(&self, block: usize) -> [Run; 2] {
        let (down, across) = self.place(block);
        [self.rows[down]..self.rows[down + 1], self.columns[across]..self.columns[across + 1]]
    }

    fn place(&self, block: usize) -> (usize, usize) {
        let across = self.columns.len() - 1;
        ((block - self.first) / across, (block - self.first) % across)
    }

    /// A block and those that touch it.
    fn about(&self, block: usize) -> impl Iterator<Item = usize> + '_ {
        let (down, across) = self.place(block);
        let (rows, columns) = (self.rows.len() - 1, self.columns.len() - 1);
        let rows = down.saturating_sub(1)..(down + 2).min(rows);
        let of_row = move |row: usize| {
            (across.saturating_sub(1)..(across + 2).min(columns)).map(move |column| self.first + row * columns + column)
        };
        rows.flat_map(of_row)
    }
}

/// A face by row, direction and column.
type Face = (usize, usize, usize);

/// What sleeps, and where that is looked at.
#[derive(Default, serde::Serialize, serde::Deserialize)]
pub(super) struct Asleep {
    levels: Vec<Blocks>,
    /// Pairs of blocks that general faces join, both ways, in order.
    joined: Vec<[usize; 2]>,
    /// The blocks that sleep, and those awake that would wake them; in order.
    blocks: Vec<usize>,
    watched: Vec<usize>,
    /// The runs of each padded row that sleep, and the wet ones among them.
    own: Vec<Vec<Run>>,
    wet: Vec<Vec<Run>>,
    /// What passes the faces between cells awake and cells asleep.
    held: BTreeMap<Face, [f64; 4]>,
}

impl Asleep {
    /// Lets sleep what can: `own` and `wet` are the runs of each padded row that are active, and lose what sleeps; `restless` places
    /// (row, column) where something happens by itself, `links` the places on the two sides of general faces.
    pub fn new(
        state: &State,
        (own, wet): (&mut [Vec<Run>], &mut [Vec<Run>]),
        restless: impl Iterator<Item = Place>,
        links: impl Iterator<Item = [Place; 2]>,
    ) -> Self {
        let none = vec![Vec::new(); state.rows + 2];
        let mut asleep = Asleep { levels: blocks_of(state), own: none.clone(), wet: none, ..Asleep::default() };
        let mut awake: HashSet<usize> = restless.filter_map(|place| asleep.block_at(place)).collect();
        for [to, from] in links {
            match [to, from].map(|place| asleep.block_at(place)) {
                [Some(to), Some(from)] => asleep.joined.push([to, from]),
                // Cells that follow lines are in no block: those beside them stay awake.
                sides => awake.extend(sides.into_iter().flatten()),
            }
        }
        asleep.joined.sort_unstable();
        asleep.joined.dedup();
        let count = asleep.levels.iter().map(Blocks::count).sum();
        awake.extend((0..count).filter(|&block| asleep.moves(state, wet, block)));
        let awake = asleep.near(awake);
        asleep.blocks =
            (0..count).filter(|block| !awake.contains(block) && asleep.runs(wet, *block).next().is_some()).collect();
        for &block in &asleep.blocks {
            let Some([rows, columns]) = asleep.cells(block) else { continue };
            rows.for_each(|row| {
                hand_over(&mut own[row], &mut asleep.own[row], &columns);
                hand_over(&mut wet[row], &mut asleep.wet[row], &columns);
            });
        }
        asleep.settle(state, own);
        asleep
    }

    /// Whether nothing sleeps.
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// The runs of a padded row that sleep.
    pub fn in_row(&self, row: usize) -> &[Run] {
        self.own.get(row).map_or(&[], Vec::as_slice)
    }

    /// The wet runs among them.
    pub fn wet_in_row(&self, row: usize) -> &[Run] {
        self.wet.get(row).map_or(&[], Vec::as_slice)
    }

    /// The number of wet cells that sleep.
    pub fn wet_cells(&self) -> usize {
        self.wet.iter().flatten().map(Run::len).sum()
    }

    /// Keeps what passes faces between cells awake and asleep as it was when these fell asleep.
    pub fn hold(&self, flux: &mut [FluxRow], at_hand: &Run) {
        for (&(row, direction, column), passing) in self.held.range((at_hand.start, 0, 0)..(at_hand.end, 0, 0)) {
            flux[row][direction].put(column, *passing);
        }
    }

    /// Wakes the blocks near which water moves in the rows at hand; their runs go back to `own` and `wet`. Returns the rows where that is.
    pub fn wake(&mut self, state: &State, at_hand: &Run, (own, wet): (&mut [Vec<Run>], &mut [Vec<Run>])) -> Vec<usize> {
        let is_at_hand = |block: usize| self.cells(block).is_some_and(|[rows, _]| at_hand.contains(&rows.start));
        let watched = self.watched.iter().copied().filter(|&block| is_at_hand(block));
        let moving: HashSet<usize> = watched.filter(|&block| self.moves(state, wet, block)).collect();
        if moving.is_empty() {
            return Vec::new();
        }
        let reached = self.near(moving);
        let (woken, blocks): (Vec<usize>, Vec<usize>) = self.blocks.iter().partition(|block| reached.contains(*block));
        self.blocks = blocks;
        let mut changed = Vec::new();
        for block in woken {
            let Some([rows, columns]) = self.cells(block) else { continue };
            changed.extend(rows.clone());
            rows.for_each(|row| {
                hand_over(&mut self.own[row], &mut own[row], &columns);
                hand_over(&mut self.wet[row], &mut wet[row], &columns);
            });
        }
        self.settle(state, own);
        changed
    }

    /// The level of a block.
    fn level(&self, block: usize) -> Option<&Blocks> {
        self.levels[..self.levels.partition_point(|level| level.first <= block)].last()
    }

    fn block_at(&self, place: Place) -> Option<usize> {
        self.levels.iter().find_map(|level| level.at(place))
    }

    /// Blocks, those beside them and those beside these, be it over general faces.
    fn near(&self, blocks: HashSet<usize>) -> HashSet<usize> {
        let mut near = blocks;
        for _ in 0..2 {
            let beside = near.iter().flat_map(|&block| {
                let first = self.joined.partition_point(|pair| pair[0] < block);
                let joined = self.joined[first..].iter().take_while(move |pair| pair[0] == block);
                let about = self.level(block).into_iter().flat_map(move |level| level.about(block));
                about.chain(joined.map(|pair| pair[1]))
            });
            near = beside.collect();
        }
        near
    }

    /// Rows and columns of a block.
    fn cells(&self, block: usize) -> Option<[Run; 2]> {
        self.level(block).map(|level| level.cells(block))
    }

    /// Some runs of each padded row inside of a block, each with its row.
    fn runs<'a>(&self, runs: &'a [Vec<Run>], block: usize) -> impl Iterator<Item = (usize, Run)> + 'a {
        let [rows, columns] = self.cells(block).unwrap_or([0..0, 0..0]);
        rows.flat_map(move |row| within(&runs[row], columns.clone()).map(move |run| (row, run)))
    }

    /// Whether water moves in a block.
    fn moves(&self, state: &State, wet: &[Vec<Run>], block: usize) -> bool {
        self.runs(wet, block).any(|(row, run)| is_moving(state, row, run))
    }

    /// Brings what goes with the blocks that sleep up to date; `own` are the active runs.
    fn settle(&mut self, state: &State, own: &[Vec<Run>]) {
        let asleep: HashSet<usize> = self.blocks.iter().copied().collect();
        self.watched = self.near(asleep.clone()).difference(&asleep).copied().collect();
        self.watched.sort_unstable();
        let mut faces: Vec<Face> = Vec::new();
        for (row, run) in self.own.iter().enumerate().flat_map(|(row, runs)| runs.iter().map(move |run| (row, run))) {
            let awake = |row: usize, run: Run| within(&own[row], run).flatten();
            faces.extend(awake(row, run.start - 1..run.start).map(|column| (row, EAST, column)));
            faces.extend(awake(row, run.end..run.end + 1).map(|column| (row, EAST, column - 1)));
            faces.extend(awake(row - 1, run.clone()).map(|column| (row - 1, NORTH, column)));
            faces.extend(awake(row + 1, run.clone()).map(|column| (row, NORTH, column)));
        }
        let before = std::mem::take(&mut self.held);
        let passing = |(row, direction, column): Face| {
            let held = before.get(&(row, direction, column)).copied();
            held.unwrap_or_else(|| state.flux[row][direction].at(column))
        };
        self.held = faces.into_iter().map(|face| (face, passing(face))).collect();
    }
}

/// The blocks of all levels.
fn blocks_of(state: &State) -> Vec<Blocks> {
    let mut first = 0;
    let levels = state.lattice().levels().map(|level| {
        let rows = edges(level.first_row + 1, level.rows);
        let blocks = Blocks { rows, columns: edges(1, level.columns), first };
        first += blocks.count();
        blocks
    });
    levels.collect()
}

/// Where blocks of so many cells begin from a first one, and where the last ends: the same from either end, so that a mirror image sleeps
/// as what it mirrors.
fn edges(first: usize, cells: usize) -> Vec<usize> {
    let blocks = (cells / BLOCK).max(1);
    let blocks = if !cells.is_multiple_of(2) && blocks.is_multiple_of(2) { blocks - 1 } else { blocks };
    let edge = |k: usize| if 2 * k <= blocks { k * cells / blocks } else { cells - (blocks - k) * cells / blocks };
    (0..=blocks).map(|k| first + edge(k)).collect()
}

/// The interval between two of some edges where a number lies.
fn interval(edges: &[usize], at: usize) -> Option<usize> {
    let next = edges.partition_point(|edge| *edge <= at);
    (1..edges.len()).contains(&next).then(|| next - 1)
}

/// Whether water of a run, or what passes its faces, is faster than still water, or no number: water that leaves a cell on all sides alike has no
/// discharge itself.
fn is_moving(state: &State, row: usize, run: Run) -> bool {
    let WaterRow { depth, discharge_x, discharge_y } = &state.water[row];
    let ([east, north], south) = (&state.flux[row], &state.flux[row - 1][NORTH]);
    let is_still = |i: usize| {
        let moving = [discharge_x[i], discharge_y[i], east.mass[i], east.mass[i - 1], north.mass[i], south.mass[i]];
        moving.iter().all(|discharge| discharge.abs() <= STILL * depth[i])
    };
    !run.into_iter().all(is_still)
}
