//! Blocks of water at rest asleep: still water costs no work until something reaches it.
//!
//! After the first step a block sleeps where the speed of its water is that of rounding (M102), and that of the blocks about it, and no
//! water comes and no bed changes there. Its cells leave the work as they are. It wakes for good when water moves in a block beside it or
//! beside that one, so that what a step carries over the edge of a sleeping block is rounding, too.

use std::collections::HashSet;

use super::super::state::{State, WaterRow};
use super::{Run, within};

/// Cells of a block along a side, at least.
const BLOCK: usize = 16;

/// Speed (m/s) up to which water counts as still: a thousand times the rounding of a lake at rest, and 1e-12 of a volume.
const STILL: f64 = 1e-11;

/// A padded place (row, column).
type Place = (usize, usize);

/// The blocks of one level.
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

/// A block that sleeps: what it takes out of the work, as (padded row, run of columns).
struct Sleeper {
    block: usize,
    own: Vec<(usize, Run)>,
    wet: Vec<(usize, Run)>,
}

/// What sleeps, and where that is looked at.
#[derive(Default)]
pub(super) struct Asleep {
    levels: Vec<Blocks>,
    /// Pairs of blocks that general faces join, both ways, in order.
    joined: Vec<[usize; 2]>,
    /// In the order of their blocks.
    sleepers: Vec<Sleeper>,
    /// Blocks awake that would wake others.
    watched: Vec<usize>,
    /// The wet runs that sleep, of each padded row.
    runs: Vec<Vec<Run>>,
}

impl Asleep {
    /// Lets sleep what can: `own` and `wet` are the runs of each padded row that are in the work, and lose what sleeps; `restless` places
    /// (row, column) where something happens by itself, `links` the places on the two sides of general faces.
    pub fn new(
        state: &State,
        (own, wet): (&mut [Vec<Run>], &mut [Vec<Run>]),
        restless: impl Iterator<Item = Place>,
        links: impl Iterator<Item = [Place; 2]>,
    ) -> Self {
        let mut asleep = Asleep { levels: blocks_of(state), ..Asleep::default() };
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
        let numbers = || (0..asleep.levels.iter().map(Blocks::count).sum()).collect::<Vec<usize>>();
        awake.extend(numbers().into_iter().filter(|&block| asleep.moves(state, wet, block)));
        let awake = asleep.near(awake);
        for block in numbers().into_iter().filter(|block| !awake.contains(block)) {
            let sleeper = asleep.sleeper(block, own, wet);
            if !sleeper.wet.is_empty() {
                asleep.sleepers.push(sleeper);
            }
        }
        for sleeper in &asleep.sleepers {
            sleeper.own.iter().for_each(|(row, run)| cut(&mut own[*row], run));
            sleeper.wet.iter().for_each(|(row, run)| cut(&mut wet[*row], run));
        }
        asleep.watched =
            asleep.near(asleep.sleepers.iter().map(|sleeper| sleeper.block).collect()).into_iter().collect();
        asleep.settle(state.rows + 2);
        asleep
    }

    /// Whether nothing sleeps.
    pub fn is_empty(&self) -> bool {
        self.sleepers.is_empty()
    }

    /// The wet runs of a padded row that sleep.
    pub fn in_row(&self, row: usize) -> &[Run] {
        self.runs.get(row).map_or(&[], Vec::as_slice)
    }

    /// The number of wet cells that sleep.
    pub fn wet_cells(&self) -> usize {
        self.runs.iter().flatten().map(Run::len).sum()
    }

    /// Wakes the blocks near which water moves in the rows at hand; their runs go back to `own` and `wet`. Returns the rows where that is.
    pub fn wake(&mut self, state: &State, at_hand: &Run, (own, wet): (&mut [Vec<Run>], &mut [Vec<Run>])) -> Vec<usize> {
        let is_at_hand =
            |block: &usize| self.level(*block).is_some_and(|of| at_hand.contains(&of.cells(*block)[0].start));
        let watched = self.watched.iter().copied().filter(is_at_hand);
        let moving: HashSet<usize> = watched.filter(|&block| self.moves(state, wet, block)).collect();
        if moving.is_empty() {
            return Vec::new();
        }
        let reached = self.near(moving);
        let (woken, sleepers) =
            std::mem::take(&mut self.sleepers).into_iter().partition(|s: &Sleeper| reached.contains(&s.block));
        let woken: Vec<Sleeper> = woken;
        self.sleepers = sleepers;
        let mut rows = Vec::new();
        for sleeper in &woken {
            for (row, run) in &sleeper.own {
                own[*row].push(run.clone());
                rows.push(*row);
            }
            sleeper.wet.iter().for_each(|(row, run)| wet[*row].push(run.clone()));
        }
        rows.sort_unstable();
        rows.dedup();
        for row in &rows {
            own[*row].sort_unstable_by_key(|run| run.start);
            wet[*row].sort_unstable_by_key(|run| run.start);
        }
        self.watched.extend(woken.iter().map(|sleeper| sleeper.block));
        self.settle(state.rows + 2);
        rows
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

    /// Whether water moves in a block.
    fn moves(&self, state: &State, wet: &[Vec<Run>], block: usize) -> bool {
        let Some([mut rows, columns]) = self.level(block).map(|level| level.cells(block)) else { return false };
        rows.any(|row| within(&wet[row], columns.clone()).any(|run| is_moving(&state.water[row], run)))
    }

    /// What a block would take out of the work.
    fn sleeper(&self, block: usize, own: &[Vec<Run>], wet: &[Vec<Run>]) -> Sleeper {
        let [rows, columns] = self.level(block).map_or([0..0, 0..0], |level| level.cells(block));
        let of = |runs: &[Vec<Run>]| {
            let in_row =
                |row: usize| within(&runs[row], columns.clone()).map(move |run| (row, run)).collect::<Vec<_>>();
            rows.clone().flat_map(in_row).collect()
        };
        Sleeper { block, own: of(own), wet: of(wet) }
    }

    /// Brings what is kept of the sleepers up to date.
    fn settle(&mut self, rows: usize) {
        let asleep: HashSet<usize> = self.sleepers.iter().map(|sleeper| sleeper.block).collect();
        let near = self.near(asleep.clone());
        self.watched.retain(|block| near.contains(block) && !asleep.contains(block));
        self.watched.sort_unstable();
        self.runs = vec![Vec::new(); rows];
        for (row, run) in self.sleepers.iter().flat_map(|sleeper| &sleeper.wet) {
            self.runs[*row].push(run.clone());
        }
        self.runs.iter_mut().for_each(|runs| runs.sort_unstable_by_key(|run| run.start));
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

/// Whether water of a run is faster than still water, or no number.
fn is_moving(water: &WaterRow, run: Run) -> bool {
    let discharges = water.discharge_x[run.clone()].iter().zip(&water.discharge_y[run.clone()]);
    let is_still = |((qx, qy), depth): ((&f64, &f64), &f64)| qx.abs().max(qy.abs()) <= STILL * depth;
    !discharges.zip(&water.depth[run]).all(is_still)
}

/// Takes a run out of sorted ones.
fn cut(runs: &mut Vec<Run>, out: &Run) {
    let pieces = runs.iter().flat_map(|run| {
        let before = run.start..run.end.min(out.start);
        let behind = run.start.max(out.end)..run.end;
        [before, behind].into_iter().filter(|piece| !piece.is_empty())
    });
    *runs = pieces.collect();
}
