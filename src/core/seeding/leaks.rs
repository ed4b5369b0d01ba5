//! Where still water would run out of its polygon: pockets that it fills and stays in, and gaps through which it leaves.
//!
//! Water passes from a cell to any of its eight neighbours whose bed lies below the level, unless a wall lies between the
//! two centres, a ridge inside the two cells ([`PassSills`](crate::bed::PassSills)) stands up to the level, or the step leads over the corner at which two cells of a dam meet: cells pass no corner. Particles of the variational formulation reach all eight; cells fewer, and what is at rest for eight is at rest for them.
//!
//! Ground below the level that goes on for some cells beyond the polygon ([`SeedingConstants`]) is open: there a dam is taken away, or the
//! polygon leaks. All else below the level outside the polygon that the water reaches is a pocket, which a rim drawn with
//! other points than those of the lattice leaves out.

use std::collections::BTreeSet;

use super::scan::BodyScan;
use crate::bed::BedParticles;
use crate::constants::SeedingConstants;
use crate::math::{Vec2, segments_cross};

/// A gap in the rim of a body of still water.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leak {
    /// Its lowest place, in map coordinates (m).
    pub position: Vec2,
    /// Bed elevation there (m).
    pub bed_elevation: f64,
    /// How far the level stands above it (m).
    pub depth: f64,
    /// Number of cells outside the body that the water reaches first; times the spacing about the width of the gap.
    pub cells: usize,
}

/// What keeps still water from a cell beside it, whatever the bed of that.
#[derive(Clone, Copy, Debug, Default)]
pub struct Barriers<'a> {
    /// Straight pieces (m, local) through which no water passes.
    pub walls: &'a [[Vec2; 2]],
    /// Cells of a dam that stands, ascending: no water passes between two of them that meet at a corner.
    pub dam: &'a [usize],
}

/// The cells of the lattice while bodies of still water are filled.
pub(super) struct Filling<'a> {
    pub bed: &'a mut BedParticles,
    barriers: Barriers<'a>,
    pub constants: SeedingConstants,
    /// The body that fills a cell.
    pub body: Vec<Option<u32>>,
}

impl<'a> Filling<'a> {
    pub fn new(bed: &'a mut BedParticles, barriers: Barriers<'a>, constants: SeedingConstants) -> Self {
        let cells = bed.lattice.len();
        Filling { bed, barriers, constants, body: vec![None; cells] }
    }

    /// Whether there is terrain at a cell, and the level stands above it.
    pub fn is_below(&self, cell: usize, level: f64) -> bool {
        // False for not-a-number.
        self.bed.elevation[cell] < level
    }

    /// The up to eight neighbours of a cell, walls or not.
    fn around(&self, cell: usize) -> impl Iterator<Item = usize> + '_ {
        let lattice = &self.bed.lattice;
        let (column, row) = lattice.column_row(cell);
        let columns = column.saturating_sub(1)..(column + 2).min(lattice.columns);
        let rows = row.saturating_sub(1)..(row + 2).min(lattice.rows);
        let block = rows.flat_map(move |row| columns.clone().map(move |column| lattice.index(column, row)));
        block.filter(move |&other| other != cell)
    }

    fn is_walled(&self, cell: usize, other: usize) -> bool {
        let path = [self.bed.lattice.centre(cell), self.bed.lattice.centre(other)];
        self.barriers.walls.iter().any(|wall| segments_cross(path, *wall))
    }

    /// Whether two cells meet at a corner at which two cells of the dam do, too.
    fn is_across_dam(&self, cell: usize, other: usize) -> bool {
        let lattice = &self.bed.lattice;
        let ((column, row), (other_column, other_row)) = (lattice.column_row(cell), lattice.column_row(other));
        let is_dam = |column: usize, row: usize| self.barriers.dam.binary_search(&lattice.index(column, row)).is_ok();
        column != other_column && row != other_row && is_dam(column, other_row) && is_dam(other_column, row)
    }

    /// Whether a ridge of the terrain stands between two cells up to a level (m). Round a corner the water needs a way by one of the two
    /// cells there.
    fn is_over_sill(&self, cell: usize, other: usize, level: f64) -> bool {
        let (lattice, passes) = (&self.bed.lattice, &self.bed.passes);
        if passes.is_empty() {
            return false;
        }
        let holds = |a: usize, b: usize| passes.between(a, b) >= level;
        let ((column, row), (other_column, other_row)) = (lattice.column_row(cell), lattice.column_row(other));
        if column == other_column || row == other_row {
            return holds(cell, other);
        }
        let corners = [lattice.index(column, other_row), lattice.index(other_column, row)];
        let is_held = |corner: usize| holds(cell, corner) || holds(corner, other);
        corners.into_iter().any(is_held)
            && corners.into_iter().all(|corner| is_held(corner) || !self.is_below(corner, level))
    }

    /// Whether no water passes from a cell to one of its neighbours at a level (m), whatever their beds.
    fn is_barred(&self, cell: usize, other: usize, level: f64) -> bool {
        self.is_across_dam(cell, other) || self.is_over_sill(cell, other, level) || self.is_walled(cell, other)
    }

    /// The neighbours to which water of a cell can pass at a level (m), as far as walls, ridges and the corners of a dam go.
    pub fn neighbours(&self, cell: usize, level: f64) -> impl Iterator<Item = usize> + '_ {
        self.around(cell).filter(move |&other| !self.is_barred(cell, other, level))
    }

    /// Whether a wall stands between a cell and one of its neighbours.
    pub fn is_at_wall(&self, cell: usize) -> bool {
        self.around(cell).any(|other| self.is_walled(cell, other))
    }

    /// The neighbours into which a filled cell would run out.
    pub fn gaps(&self, cell: usize, level: f64) -> impl Iterator<Item = usize> + '_ {
        // Most neighbours are none, and walls are many.
        self.around(cell).filter(move |&other| self.is_gap(other, level) && !self.is_barred(cell, other, level))
    }

    fn is_gap(&self, cell: usize, level: f64) -> bool {
        self.body[cell].is_none() && self.is_below(cell, level)
    }

    /// Open ground near the polygon of a body: cells below its level, without water, in connection with such cells farther out.
    pub fn open_ground(&self, level: f64, scan: &BodyScan) -> BTreeSet<usize> {
        let mut beyond: BTreeSet<usize> = BTreeSet::new();
        let mut covered = vec![false; self.bed.lattice.len()];
        scan.cells.iter().for_each(|&(cell, _)| covered[cell] = true);
        let is_covered = |cell: usize| covered[cell];
        let mut outermost: Vec<usize> = scan.cells.iter().map(|&(cell, _)| cell).collect();
        let SeedingConstants { pocket_reach, pocket_steps, .. } = self.constants;
        for _ in 0..=pocket_reach {
            let mut next = Vec::new();
            for other in outermost.iter().flat_map(|&cell| self.around(cell)) {
                if !is_covered(other) && beyond.insert(other) {
                    next.push(other);
                }
            }
            outermost = next;
        }
        let is_near = |cell: usize| beyond.contains(&cell) || is_covered(cell);
        let mut newest: Vec<usize> = outermost.into_iter().filter(|&cell| self.is_gap(cell, level)).collect();
        let mut open: BTreeSet<usize> = newest.iter().copied().collect();
        for _ in 0..pocket_reach + pocket_steps {
            let next = newest.iter().flat_map(|&cell| self.gaps(cell, level));
            newest = next.filter(|&other| is_near(other) && open.insert(other)).collect();
        }
        open
    }

    /// Takes the water of a body out of slivers of its polygon beyond a wall or a ridge: cells that all lie on its rim, cut off from the
    /// rest by walls and ridges, from which the water would run out.
    pub fn leave_out_slivers(&mut self, number: u32, level: f64, scan: &BodyScan, open: &mut BTreeSet<usize>) {
        if self.barriers.walls.is_empty() && self.bed.passes.is_empty() {
            return;
        }
        let holds = |filling: &Self, cell: usize| filling.body[cell] == Some(number);
        let filled: Vec<usize> = scan.cells.iter().map(|&(cell, _)| cell).filter(|&cell| holds(self, cell)).collect();
        let mut seen: BTreeSet<usize> = BTreeSet::new();
        for &start in &filled {
            if !seen.insert(start) {
                continue;
            }
            let mut part = vec![start];
            let mut next = 0;
            while let Some(&cell) = part.get(next) {
                next += 1;
                part.extend(self.neighbours(cell, level).filter(|&other| holds(self, other) && seen.insert(other)));
            }
            let is_at_rim = part.iter().all(|&cell| scan.part(cell).is_cut());
            let runs_out = || part.iter().any(|&cell| self.neighbours(cell, level).any(|other| open.contains(&other)));
            if is_at_rim && part.len() < filled.len() && runs_out() {
                for cell in part {
                    self.body[cell] = None;
                    open.insert(cell);
                }
            }
        }
    }

    /// Fills the pockets that the water of a body reaches from the given cells. Returns their cells.
    pub fn fill_pockets(&mut self, number: u32, level: f64, cells: &[usize], open: &BTreeSet<usize>) -> Vec<usize> {
        let mut pockets: Vec<usize> = Vec::new();
        // Most cells lie amid others.
        for &cell in cells {
            if self.gaps(cell, level).next().is_none() {
                continue;
            }
            let mut wet = vec![cell];
            while let Some(cell) = wet.pop() {
                let reached: Vec<usize> = self.gaps(cell, level).filter(|other| !open.contains(other)).collect();
                for other in reached {
                    self.body[other] = Some(number);
                    pockets.push(other);
                    wet.push(other);
                }
            }
        }
        pockets
    }

    /// The cells of a body before the places where it would run out into open ground or meets another body.
    ///
    /// - `reached`: the cells that its polygon touches and those of its pockets
    pub fn approach(&self, number: u32, level: f64, reached: &[usize]) -> BTreeSet<usize> {
        let holds = |cell: usize| self.body[cell] == Some(number);
        let is_open = |other: usize| self.is_gap(other, level) || self.body[other].is_some_and(|body| body != number);
        let is_at_opening = |&cell: &usize| {
            holds(cell) && self.around(cell).any(|other| is_open(other) && !self.is_barred(cell, other, level))
        };
        let mut newest: Vec<usize> = reached.iter().copied().filter(is_at_opening).collect();
        let mut approach: BTreeSet<usize> = newest.iter().copied().collect();
        for _ in 1..self.constants.approach {
            let next = newest.iter().flat_map(|&cell| self.neighbours(cell, level));
            newest = next.filter(|&other| holds(other) && approach.insert(other)).collect();
        }
        approach
    }

    /// The gaps of a body with the given filled cells, deepest first.
    pub fn leaks(&self, level: f64, cells: &[usize]) -> Vec<Leak> {
        let mut outside: Vec<usize> = cells.iter().flat_map(|&cell| self.gaps(cell, level)).collect();
        outside.sort_unstable();
        outside.dedup();
        let mut is_taken = vec![false; outside.len()];
        let mut leaks = Vec::new();
        for start in 0..outside.len() {
            if std::mem::replace(&mut is_taken[start], true) {
                continue;
            }
            let mut gap = vec![outside[start]];
            let mut next = 0;
            while let Some(&cell) = gap.get(next) {
                next += 1;
                for other in self.neighbours(cell, level) {
                    if let Ok(place) = outside.binary_search(&other)
                        && !std::mem::replace(&mut is_taken[place], true)
                    {
                        gap.push(other);
                    }
                }
            }
            let z_b = &self.bed.elevation;
            let lowest = gap.iter().copied().fold(gap[0], |a, b| if z_b[b] < z_b[a] { b } else { a });
            leaks.push(Leak {
                position: self.bed.lattice.to_map(self.bed.lattice.centre(lowest)),
                bed_elevation: z_b[lowest],
                depth: level - z_b[lowest],
                cells: gap.len(),
            });
        }
        leaks.sort_by(|a, b| b.depth.total_cmp(&a.depth));
        leaks
    }
}
