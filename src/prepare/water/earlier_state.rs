//! The water of an earlier run on the cells of this one.
//!
//! **Several in one.** A cell that holds several parts of the file has their volume and their momentum, and the mean level of the wet ones. Where
//! not all are wet these may lie higher than the rest, as at a front on a slope: the level is above the ground of the cell by twice their depth at
//! most.
//!
//! **One over several.** A cell of the earlier run is larger than one of this run where its lattice was coarser, or a coarser level of it stood
//! there. Its water lies on the ground that this run has in it, along the slope s that the levels on both sides of it have:
//!
//! ```text
//! (M103)  η_i = η + s·(x_i − x)    h_i = max(0, η_i − z_i)    d_i = f h_i + e
//!         f = min(1, d Σ A_i / Σ A_i h_i)    e = (d Σ A_i − Σ A_i h_i)/Σ' A_i, 0 at least
//! ```
//!
//! with Σ' over the cells that lie below η_i, and over all where e would be more than d. So its volume stays, and the level of a lake, and no cell is
//! dug deeper than the larger cell was. The bed is taken to lie at η_i − d_i, as it is under all water of an earlier run.
//!
//! **What is built** keeps its ground: water stands on it up to its level, and what has no room is lost.
//!
//! **Bare cells.** What a wall parts from the middle of a cell has no water of it, at an edge of the terrain larger cells may have had none, and
//! beside the crest of a dam they were all crest. Such cells stand as high as the water beside them.

use std::collections::BTreeMap;

use crate::lattice::NEIGHBOURS;
use crate::math::Vec2;
use crate::prepare::water::earlier_cells::{Between, SAME_PLACE};

/// So many times as deep as it is the water of parts may stand above the ground of their cell (M98).
const DEEPER: f64 = 2.0;

/// One frame of a file, in its own order; not a number where it has no value.
pub struct Frame {
    /// The time (s) in the earlier run.
    pub time: f64,
    pub depth: Vec<f64>,
    pub level: Vec<f64>,
    pub velocity_x: Vec<f64>,
    pub velocity_y: Vec<f64>,
}

/// The water of an earlier run at one moment, on the cells of the lattice.
pub struct State {
    /// The time of the frame in the earlier run (s).
    pub time: f64,
    /// Depth (m), NaN where the earlier run had no terrain.
    pub depth: Vec<f64>,
    /// Level (m), NaN where there was no water; on dry ground that rises out of the water of a larger cell its level.
    pub level: Vec<f64>,
    /// Velocity (m/s).
    pub velocity: Vec<Vec2>,
    /// How much (m) the bed of the earlier run lies above that of this one; not a number where cells of two sizes do not show it.
    pub rise: Vec<f64>,
    /// The volume (m³) that the file has in cells of another size; 0 in others.
    pub in_file: Vec<f64>,
}

impl Frame {
    /// Whether depth or velocity are missing in a cell of the file.
    fn is_empty(&self, index: usize) -> bool {
        (self.depth[index] + self.velocity_x[index] + self.velocity_y[index]).is_nan()
    }

    /// The cells with terrain for which the frame lacks depth or velocity.
    pub fn missing(&self, between: &Between<'_>) -> Vec<usize> {
        let (laid, bed) = (&between.laid, between.bed);
        let is_whole = laid.part >= (1.0 - SAME_PLACE) * laid.cell;
        let is_missing = |&cell: &usize| {
            let own = || laid.of_cell(&bed.lattice, cell);
            let is_cut = |index: usize| !self.depth[index].is_nan() && self.is_empty(index);
            // At an edge of the terrain a larger cell, or a part of one, may have none where this run has some.
            let lacks = |index: usize| self.is_empty(index) && !between.is_larger(index);
            let is_bare = is_whole && own().next().is_some() && own().all(lacks);
            bed.has_terrain(cell) && (is_bare || own().any(is_cut))
        };
        (0..bed.lattice.len()).filter(is_missing).collect()
    }

    /// Its water on the cells of the lattice.
    pub fn on_cells(&self, between: &Between<'_>) -> State {
        let (laid, lattice) = (&between.laid, &between.bed.lattice);
        let count = lattice.len();
        let mut state = State {
            time: self.time,
            depth: vec![0.0; count],
            level: vec![f64::NAN; count],
            velocity: vec![Vec2::ZERO; count],
            rise: vec![f64::NAN; count],
            in_file: vec![0.0; count],
        };
        let is_one_part = laid.along(lattice) == 1;
        let mut larger: BTreeMap<[usize; 2], (usize, Vec<usize>)> = BTreeMap::new();
        for cell in 0..count {
            let own = if is_one_part { laid.of_cell(lattice, cell).next() } else { between.larger_about(cell) };
            match own {
                Some(index) if between.is_larger(index) => {
                    if !between.sees(lattice.centre(cell), index) {
                        state.depth[cell] = f64::NAN;
                        continue;
                    }
                    larger.entry(between.key(index)).or_insert_with(|| (index, Vec::new())).1.push(cell);
                }
                Some(index) => self.put_same(between, (cell, index), &mut state),
                None if is_one_part => {}
                None => self.put_mean(between, cell, &mut state),
            }
        }
        for (index, cells) in larger.into_values() {
            self.put_larger(between, index, &cells, &mut state);
        }
        fill_bare(between, &mut state);
        state
    }

    fn velocity(&self, index: usize) -> Vec2 {
        let (u, v) = (self.velocity_x[index], self.velocity_y[index]);
        if u.is_finite() { Vec2::new(u, v) } else { Vec2::ZERO }
    }

    /// Gives a cell the water of the same cell.
    fn put_same(&self, between: &Between<'_>, (cell, index): (usize, usize), state: &mut State) {
        state.depth[cell] = self.depth[index];
        state.level[cell] = self.level[index];
        state.velocity[cell] = self.velocity(index);
        if self.depth[index] > 0.0 {
            state.rise[cell] = self.level[index] - self.depth[index] - between.bed.elevation[cell];
        }
    }

    /// Gives a cell what its parts have: those on its side of all walls.
    fn put_mean(&self, between: &Between<'_>, cell: usize, state: &mut State) {
        let Between { laid, bed, walls, .. } = between;
        let centre = bed.lattice.centre(cell);
        let all: Vec<(usize, Vec2)> = laid.parts_of_cell(&bed.lattice, cell).collect();
        if all.iter().all(|&(index, _)| self.depth[index] <= 0.0) {
            return;
        }
        let is_seen = |place: Vec2, index: usize| !walls.cross([centre, place]) && between.sees(place, index);
        let seen = all.iter().filter(|&&(index, place)| is_seen(place, index)).map(|(index, _)| *index);
        let seen: Vec<usize> = seen.filter(|&index| !self.depth[index].is_nan()).collect();
        let part = laid.part * laid.part;
        let in_file = all.iter().map(|&(index, _)| self.depth[index]).filter(|depth| !depth.is_nan());
        state.in_file[cell] = in_file.sum::<f64>() * part;
        if !bed.has_terrain(cell) {
            return;
        }
        if seen.is_empty() {
            state.depth[cell] = f64::NAN;
            return;
        }
        let depths: f64 = seen.iter().map(|&index| self.depth[index]).sum();
        let moment = seen.iter().fold(Vec2::ZERO, |sum, &index| sum + self.velocity(index) * self.depth[index]);
        // Beyond a wall stands water of other cells, and cells in part have their own area: there the depth of what is seen counts.
        let is_whole = (bed.cover.cell(cell).area - 1.0).abs() <= 0.0 && seen.len() == all.len();
        let parts = if is_whole { laid.along(&bed.lattice).pow(2) } else { seen.len() } as f64;
        let z = bed.elevation[cell];
        let levels: Vec<f64> = seen.iter().map(|&index| self.level[index]).filter(|level| !level.is_nan()).collect();
        let level = levels.iter().sum::<f64>() / levels.len() as f64;
        let (mut depth, is_wet) = (depths / parts, levels.len() == seen.len());
        state.level[cell] = level;
        if (between.is_built)(cell) {
            depth = if levels.is_empty() { depth } else { (level - z).max(0.0) };
            state.level[cell] = z + depth;
        } else if !is_wet && !levels.is_empty() {
            state.level[cell] = level.min(z + DEEPER * depths / levels.len() as f64);
        } else if is_whole && seen.iter().all(|&index| between.holds(cell, index)) {
            state.rise[cell] = level - depth - z;
        }
        state.depth[cell] = depth;
        if depths > 0.0 {
            state.velocity[cell] = moment * (1.0 / depths);
        }
    }

    /// Lays the water of a cell of the earlier run, about one of the file, on the cells of the lattice in it (M103).
    fn put_larger(&self, between: &Between<'_>, index: usize, cells: &[usize], state: &mut State) {
        let bed = between.bed;
        let (level, depth) = (self.level[index], self.depth[index]);
        let (built, natural): (Vec<usize>, Vec<usize>) =
            cells.iter().copied().filter(|&cell| bed.has_terrain(cell)).partition(|&cell| (between.is_built)(cell));
        if depth.is_nan() || depth <= 0.0 && !built.is_empty() {
            // It had no terrain, or was built as a whole: its other ground here may lie under water.
            natural.iter().for_each(|&cell| state.depth[cell] = f64::NAN);
            return;
        }
        if depth <= 0.0 {
            return;
        }
        let (middle, slope) = (between.middle(index), self.slope(between, index));
        let level_in = |cell: usize| level + slope.dot(bed.lattice.centre(cell) - middle);
        let below = |cell: usize| (level_in(cell) - bed.elevation[cell]).max(0.0);
        let sum = |cells: &[usize], of: &dyn Fn(usize) -> f64| {
            cells.iter().map(|&cell| bed.area(cell) * of(cell)).sum::<f64>()
        };
        let area = sum(&natural, &|_| 1.0) + sum(&built, &|_| 1.0);
        let (volume, room) = (area * depth, sum(&natural, &below));
        let left = (volume - sum(&built, &below)).max(0.0);
        for &cell in natural.iter().chain(&built) {
            state.in_file[cell] = bed.area(cell) * depth;
            state.velocity[cell] = self.velocity(index);
        }
        // Where two lines meet a larger cell is as one of them has it.
        let rise_at = |cell: usize| level - depth - bed.elevation[cell];
        let least = built.iter().map(|&cell| rise_at(cell)).min_by(|a, b| a.abs().total_cmp(&b.abs()));
        for &cell in &built {
            state.depth[cell] = below(cell);
            state.level[cell] = bed.elevation[cell] + below(cell);
            state.rise[cell] = least.unwrap_or(f64::NAN);
        }
        let (scale, excess) = (f64::min(left / room.max(f64::MIN_POSITIVE), 1.0), left - room);
        let wet = sum(&natural, &|cell| f64::from(u8::from(below(cell) > 0.0)));
        let is_spread = built.is_empty() && excess > depth * wet;
        let deeper = if is_spread { excess / area } else { excess.min(depth * wet) / wet.max(f64::MIN_POSITIVE) };
        let is_whole = (area - between.edge(index).powi(2)).abs() <= SAME_PLACE * area;
        let rise = level - depth - sum(&natural, &|cell| bed.elevation[cell]) / area;
        for &cell in &natural {
            let takes_more = excess > 0.0 && (is_spread || below(cell) > 0.0);
            (state.depth[cell], state.level[cell]) = if level.is_nan() {
                // A film.
                (depth, f64::NAN)
            } else {
                (scale * below(cell) + if takes_more { deeper } else { 0.0 }, level_in(cell))
            };
            if is_whole && built.is_empty() {
                state.rise[cell] = rise;
            }
        }
    }

    /// The slope of the level in the cell of the earlier run about one of the file: the smaller of those to both sides, 0 where they differ in
    /// sign, and where one side is dry or beyond a wall. So a lake is level up to its shore.
    fn slope(&self, between: &Between<'_>, index: usize) -> Vec2 {
        let (laid, middle, edge) = (&between.laid, between.middle(index), between.edge(index));
        let own = self.level[index];
        // The slope of the level beyond a side; two cells of the file may lie at its middle.
        let beyond = |side: Vec2| {
            let aside = Vec2::new(side.y, side.x) * (0.25 * laid.cell);
            let at = middle + side * (0.5 * (edge + laid.cell));
            let slope = |place: Vec2| {
                let there = laid.index_at(place).filter(|&there| !self.level[there].is_nan())?;
                let is_seen = !between.walls.cross([middle, between.middle(there)]);
                is_seen.then(|| (self.level[there] - own) / (0.5 * (edge + between.edge(there))))
            };
            Some(0.5 * (slope(at + aside)? + slope(at - aside)?))
        };
        let along = |side: Vec2| match (beyond(side), beyond(side * -1.0)) {
            (Some(ahead), Some(behind)) if ahead * behind < 0.0 => {
                if ahead.abs() < behind.abs() {
                    ahead
                } else {
                    -behind
                }
            }
            _ => 0.0,
        };
        Vec2::new(along(Vec2::new(1.0, 0.0)), along(Vec2::new(0.0, 1.0)))
    }
}

/// Lets the water beside bare cells stand in them, too.
fn fill_bare(Between { bed, walls, .. }: &Between<'_>, state: &mut State) {
    let lattice = &bed.lattice;
    let is_bare = |&cell: &usize| bed.has_terrain(cell) && state.depth[cell].is_nan();
    let mut bare: Vec<usize> = (0..lattice.len()).filter(is_bare).collect();
    let beside = |cell: usize| NEIGHBOURS.into_iter().filter_map(move |step| lattice.neighbour(cell, step));
    loop {
        let joins = |cell: usize, other: usize| {
            let is_wet = state.depth[other] > 0.0 && !state.level[other].is_nan();
            is_wet && !walls.cross([lattice.centre(cell), lattice.centre(other)])
        };
        // The highest of the waters beside it.
        let highest = |a: &usize, b: &usize| state.level[*a].total_cmp(&state.level[*b]);
        let water =
            |&cell: &usize| beside(cell).filter(|&other| joins(cell, other)).max_by(highest).map(|other| (cell, other));
        let found: Vec<(usize, usize)> = bare.iter().filter_map(water).collect();
        if found.is_empty() {
            return;
        }
        for (cell, other) in found {
            let z = bed.elevation[cell];
            (state.level[cell], state.velocity[cell]) = (state.level[other], state.velocity[other]);
            state.depth[cell] = (state.level[cell] - z).max(0.0);
        }
        bare.retain(|&cell| state.depth[cell].is_nan());
    }
}
