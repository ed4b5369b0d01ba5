//! Pass sills: ridges of the terrain that the cells of the lattice do not see, because they are narrower than a cell.
//!
//! The pass sill of a face is the lowest level at which the lowest places of its two cells join inside these two cells, over
//! pixels of the terrain that meet at an edge:
//!
//! ```text
//! (M10)  P_ij = min over ways from p_i to p_j of max z along the way,   P_ij counts where P_ij > max(z_i, z_j)
//! ```
//!
//! p_i is the pixel with the lowest elevation of cell i; of several the one nearest to the centre of the cell, and where several are
//! as near, all of them have to join. An unbroken ridge divides the pixels p into two sides. Every way from one side to the other
//! crosses it, so that P of a pair on different sides is the crest or more: no ridge leaks, at any angle and ratio.
//!
//! The level is found by a flood from p_i that takes the lowest pixel at its shore next; most pairs join at the higher of their two beds,
//! which costs no order. Method: minimax path, as `Barnes2014` fills depressions.
//!
//! Deliberately absent: terrain no finer than the lattice, survey points, and what motion makes of a sill.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use super::BedParticles;
use super::gap::Tiles;
use super::sill::{Opening, PassSill, PassSills, Pixels, SHUT};
use crate::constants::BedConstants;
use crate::math::Vec2;
use crate::terrain::{PixelBlock, PixelGrid};

/// Distances that differ by less than this share of the spacing are equal.
const EQUALLY_FAR: f64 = 1e-6;

impl PassSills {
    /// The sills of a bed whose cells see no ridge narrower than they are.
    pub fn find(pixels: &impl Pixels, bed: &BedParticles) -> Self {
        let lattice = &bed.lattice;
        let (low, high) = (lattice.origin, lattice.origin + lattice.size());
        if lattice.is_empty() || pixels.grid(low, high, lattice.spacing).is_none() {
            return PassSills::default();
        }
        let of_row = |row: usize| {
            let mut search = Search::new(pixels, bed);
            let cells = row * lattice.columns..(row + 1) * lattice.columns;
            cells.flat_map(|cell| [search.sill(cell, false), search.sill(cell, true)]).flatten().collect::<Vec<_>>()
        };
        let rows: Vec<Vec<PassSill>> = (0..lattice.rows).into_par_iter().map(of_row).collect();
        let mut sills = PassSills { sills: rows.concat(), ..PassSills::default() };
        sills.find_openings(&Tiles::all(pixels, bed), pixels, bed);
        sills
    }

    /// Finds what gaps leave open in some tiles.
    fn find_openings(&mut self, tiles: &Tiles, pixels: &impl Pixels, bed: &BedParticles) {
        let lattice = &bed.lattice;
        self.sills.retain(|sill| sill.level > f64::NEG_INFINITY);
        for sill in &mut self.sills {
            (sill.share, sill.crest) = (1.0, sill.level);
        }
        self.gaps.retain(|&cell| !tiles.hold(lattice, cell));
        self.gaps.extend(tiles.cells_with_gaps(pixels, bed).into_iter().map(|(cell, _)| cell));
        self.gaps.sort_unstable();
        let openings = tiles.openings(pixels, bed, &self.gaps, self);
        self.openings.retain(|opening| !tiles.hold(lattice, opening.cell));
        self.openings.extend(openings);
        self.openings.sort_by_key(Opening::face);
        self.open();
    }

    /// Leaves of the faces with a gap the share that is open.
    fn open(&mut self) {
        let mut new = Vec::new();
        for opening in &self.openings {
            let found = self.sills.binary_search_by_key(&opening.face(), PassSill::face);
            let without_sill = || PassSill::whole(opening.cell, opening.is_north, f64::NEG_INFINITY);
            let mut sill = found.map_or_else(|_| without_sill(), |place| self.sills[place]);
            if opening.crest > sill.level {
                (sill.share, sill.crest) = (opening.share, opening.crest);
                match found {
                    Ok(place) => self.sills[place] = sill,
                    Err(_) => new.push(sill),
                }
            }
        }
        self.sills.append(&mut new);
        self.sort();
    }

    /// Finds those of some cells (ascending) anew, whose bed is another one by now.
    pub fn find_again(&mut self, cells: &[usize], pixels: &impl Pixels, bed: &BedParticles) {
        let lattice = &bed.lattice;
        let is_among = |cell: usize| cells.binary_search(&cell).is_ok();
        self.sills.retain(|sill| !is_among(sill.cell) && !is_among(sill.other(lattice)));
        let mut search = Search::new(pixels, bed);
        let mut faces: Vec<(usize, bool)> = Vec::new();
        for &cell in cells {
            let (column, row) = lattice.column_row(cell);
            faces.extend([(cell, false), (cell, true)]);
            faces.extend((column > 0).then(|| (cell - 1, false)));
            faces.extend((row > 0).then(|| (cell - lattice.columns, true)));
        }
        faces.sort_unstable();
        faces.dedup();
        self.sills.extend(faces.into_iter().filter_map(|(cell, is_north)| search.sill(cell, is_north)));
        self.sort();
        self.find_openings(&Tiles::near(pixels, bed, cells), pixels, bed);
    }
}

/// What a search needs again and again.
struct Search<'a, P> {
    pixels: &'a P,
    bed: &'a BedParticles,
    window: Window,
    /// Pixels of one cell on a grid of their own.
    alone: Vec<f64>,
    first: Vec<usize>,
    second: Vec<usize>,
}

/// The pixels of two cells.
#[derive(Default)]
struct Window {
    columns: usize,
    values: Vec<f64>,
    joined: Vec<Joined>,
    open: Vec<usize>,
    shore: BinaryHeap<Reverse<(Order, usize)>>,
}

/// How a pixel stands to those from which the flood came.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Joined {
    No,
    AtShore,
    Yes,
}

/// An elevation that is ordered; pixels have no NaN where they are compared.
#[derive(Clone, Copy, PartialEq)]
struct Order(f64);

impl Eq for Order {}

impl PartialOrd for Order {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Order {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl<'a, P: Pixels> Search<'a, P> {
    fn new(pixels: &'a P, bed: &'a BedParticles) -> Self {
        let (alone, first, second) = (Vec::new(), Vec::new(), Vec::new());
        Search { pixels, bed, window: Window::default(), alone, first, second }
    }

    /// The corners of a cell in map coordinates.
    fn corners(&self, cell: usize) -> (Vec2, Vec2) {
        let lattice = &self.bed.lattice;
        let (column, row) = lattice.column_row(cell);
        let corner = |east: usize, north: usize| {
            lattice.to_map(Vec2::new((column + east) as f64, (row + north) as f64) * lattice.spacing)
        };
        (corner(0, 0), corner(1, 1))
    }

    fn grid_of(&self, cell: usize) -> Option<PixelGrid> {
        let (low, high) = self.corners(cell);
        self.pixels.grid(low, high, self.bed.lattice.spacing)
    }

    /// The sill of a face, if it counts.
    fn sill(&mut self, cell: usize, is_north: bool) -> Option<PassSill> {
        let lattice = &self.bed.lattice;
        let (column, row) = lattice.column_row(cell);
        let is_last = if is_north { row + 1 == lattice.rows } else { column + 1 == lattice.columns };
        if is_last {
            return None;
        }
        let mut sill = PassSill::whole(cell, is_north, 0.0);
        let other = sill.other(lattice);
        let beds = [cell, other].map(|cell| self.bed.elevation[cell]);
        if beds[0].is_nan() || beds[1].is_nan() {
            return None;
        }
        let grids = [self.grid_of(cell), self.grid_of(other)];
        let area = |grid: &PixelGrid| grid.cell().x * grid.cell().y;
        let grid = grids.into_iter().flatten().reduce(|a, b| if area(&b) < area(&a) { b } else { a })?;
        let blocks = self.fill_window(&grid, cell, other);
        let mut places = [std::mem::take(&mut self.first), std::mem::take(&mut self.second)];
        for (side, places) in places.iter_mut().enumerate() {
            self.lowest_places([cell, other][side], grids[side], (&grid, &blocks), places);
        }
        let BedConstants { sill_rise, sill_share, .. } = self.bed.constants;
        let least_rise = sill_rise.min(sill_share * lattice.spacing);
        let level = self.window.join(&places[0], &places[1], beds[0].max(beds[1]) + least_rise);
        [self.first, self.second] = places;
        (sill.level, sill.crest) = (level?, level?);
        Some(sill)
    }

    /// Reads the pixels of two cells; returns their block.
    fn fill_window(&mut self, grid: &PixelGrid, cell: usize, other: usize) -> PixelBlock {
        let [a, b] = [cell, other].map(|cell| {
            let (low, high) = self.corners(cell);
            grid.block(low, high)
        });
        let whole = PixelBlock {
            columns: a.columns.start.min(b.columns.start)..a.columns.end.max(b.columns.end),
            rows: a.rows.start.min(b.rows.start)..a.rows.end.max(b.rows.end),
        };
        let window = &mut self.window;
        window.columns = (whole.columns.end - whole.columns.start) as usize;
        let rows = (whole.rows.end - whole.rows.start) as usize;
        window.values.clear();
        window.values.resize(window.columns * rows, f64::NAN);
        for (cell, block) in [(cell, &a), (other, &b)] {
            self.alone.clear();
            self.pixels.read(grid, block, cell, &mut self.alone);
            let width = (block.columns.end - block.columns.start) as usize;
            for (k, &value) in self.alone.iter().enumerate() {
                let column = (block.columns.start - whole.columns.start) as usize + k % width;
                let row = (block.rows.start - whole.rows.start) as usize + k / width;
                let here = &mut window.values[row * window.columns + column];
                // A pixel on the edge of both is what the higher of them makes of it; `max` leaves NaN out.
                *here = here.max(value);
            }
        }
        whole
    }

    /// The lowest places of a cell as pixels of the window. They are found on the grid of the cell, so that they are the same for all
    /// of its faces.
    fn lowest_places(
        &mut self,
        cell: usize,
        own: Option<PixelGrid>,
        (grid, whole): (&PixelGrid, &PixelBlock),
        out: &mut Vec<usize>,
    ) {
        out.clear();
        let lattice = &self.bed.lattice;
        let centre = lattice.to_map(lattice.centre(cell));
        let (low, high) = self.corners(cell);
        let own = own.unwrap_or(*grid);
        let block = own.block(low, high);
        self.alone.clear();
        let is_same = own == *grid;
        if !is_same {
            self.pixels.read(&own, &block, cell, &mut self.alone);
        }
        let in_window = |column: i64, row: i64| {
            let (column, row) = (column - whole.columns.start, row - whole.rows.start);
            row as usize * self.window.columns + column as usize
        };
        let (mut lowest, mut nearest) = (f64::INFINITY, f64::INFINITY);
        let mut k = 0;
        for row in block.rows.clone() {
            for column in block.columns.clone() {
                let z = if is_same { self.window.values[in_window(column, row)] } else { self.alone[k] };
                k += 1;
                if z.is_nan() || z > lowest {
                    continue;
                }
                let distance = (own.centre(column, row) - centre).norm_squared();
                let is_better = z < lowest || distance < nearest - EQUALLY_FAR * lattice.cell_area();
                let is_alike = !is_better && distance <= nearest + EQUALLY_FAR * lattice.cell_area();
                if is_better {
                    out.clear();
                    (lowest, nearest) = (z, distance);
                }
                if is_better || is_alike {
                    let (column, row) = if is_same { (column, row) } else { grid.at(own.centre(column, row)) };
                    let is_in = whole.columns.contains(&column) && whole.rows.contains(&row);
                    let place = is_in.then(|| in_window(column, row));
                    out.extend(place.filter(|&place| !self.window.values[place].is_nan()));
                }
            }
        }
    }
}

impl Window {
    /// The lowest level at which all places join; none where that is no higher than a level (m), or where one side has no place.
    fn join(&mut self, first: &[usize], second: &[usize], floor: f64) -> Option<f64> {
        let (&start, _) = first.split_first()?;
        second.first()?;
        let places = || first.iter().chain(second).copied();
        let floor = places().map(|place| self.values[place]).fold(floor, f64::max);
        self.joined.clear();
        self.joined.resize(self.values.len(), Joined::No);
        self.shore.clear();
        // First all that joins at the floor, in any order; what stands higher is the shore.
        let mut level = floor;
        self.flood(start, level);
        while places().any(|place| self.joined[place] != Joined::Yes) {
            let Some(Reverse((Order(z), pixel))) = self.shore.pop() else { return Some(SHUT) };
            level = level.max(z);
            self.flood(pixel, level);
        }
        (level > floor).then_some(level)
    }

    /// Joins a pixel, and all that the water reaches from it at a level (m).
    fn flood(&mut self, from: usize, level: f64) {
        self.joined[from] = Joined::Yes;
        self.open.clear();
        self.open.push(from);
        while let Some(pixel) = self.open.pop() {
            self.spread(pixel, level);
        }
    }

    /// Takes the neighbours of a pixel: those below a level (m) are open, the others are its shore.
    fn spread(&mut self, pixel: usize, level: f64) {
        let column = pixel % self.columns;
        let west = (column > 0).then(|| pixel - 1);
        let east = (column + 1 < self.columns).then_some(pixel + 1);
        let north = pixel.checked_sub(self.columns);
        let south = Some(pixel + self.columns).filter(|&south| south < self.values.len());
        for next in [west, east, north, south].into_iter().flatten() {
            let z = self.values[next];
            if self.joined[next] != Joined::No || z.is_nan() {
                continue;
            }
            if z <= level {
                self.joined[next] = Joined::Yes;
                self.open.push(next);
            } else {
                self.joined[next] = Joined::AtShore;
                self.shore.push(Reverse((Order(z), next)));
            }
        }
    }
}

#[cfg(test)]
mod tests;
