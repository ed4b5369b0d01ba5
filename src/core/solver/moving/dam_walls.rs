//! The walls of a dam that stands dry, beside moving particles: the faces between its cells and the ground.
//!
//! Deep water beside a bank as steep as a dam does not keep still by itself: a particle that leaves the bank is pressed against its
//! neighbours and rises, where it should leave a gap and sink. Images in a wall tell it so. A cell of the dam stops being a wall for
//! good as soon as water that stands above its bed reaches it, and is a ridge of the bed from then on (`bed::Ridges`).

use std::collections::{BTreeMap, BTreeSet};

use crate::bed::BedParticles;
use crate::boundary::Edge;
use crate::math::Vec2;
use crate::solver::moving::MovingWater;

/// The cells of a dam that are walls.
#[derive(Debug)]
pub(super) struct DamWalls {
    /// All other walls and open edges.
    others: Vec<Edge>,
    cells: BTreeSet<usize>,
}

impl DamWalls {
    /// Makes walls of some cells.
    pub fn new(water: &mut MovingWater, cells: impl Iterator<Item = usize>) -> Self {
        let walls = DamWalls { others: water.walls.edges().to_vec(), cells: cells.collect() };
        walls.build(water);
        walls
    }

    /// Opens the cells that stand no more, by the bed of now, and those that water reaches from beside the dam over others.
    pub fn release(&mut self, water: &mut MovingWater, standing: impl Iterator<Item = (usize, bool)>) {
        if self.cells.is_empty() {
            return;
        }
        let before = self.cells.len();
        for (cell, _) in standing.filter(|(_, stands)| !stands) {
            self.cells.remove(&cell);
        }
        let mut reached = reached(water);
        while let Some((cell, level)) = reached.pop() {
            self.cells.remove(&cell);
            let (column, row) = water.bed.lattice.column_row(cell);
            let columns = water.bed.lattice.columns;
            let beside = [
                (column > 0).then(|| cell - 1),
                (column + 1 < columns).then(|| cell + 1),
                (row > 0).then(|| cell - columns),
                Some(cell + columns),
            ];
            let lower = |other: &usize| self.cells.contains(other) && water.bed.elevation[*other] < level;
            reached.extend(beside.into_iter().flatten().filter(lower).map(|other| (other, level)));
        }
        if self.cells.len() < before {
            self.build(water);
        }
    }

    fn build(&self, water: &mut MovingWater) {
        let edges = self.others.iter().copied().chain(self.faces(&water.bed)).collect();
        water.walls = water.walls.with_edges(edges, water.bed.lattice.spacing);
    }

    /// The faces between walled and other cells, those of one line one after the other.
    fn faces(&self, bed: &BedParticles) -> Vec<Edge> {
        let lattice = &bed.lattice;
        let mut faces = Vec::new();
        for along_rows in [true, false] {
            let mut found: Vec<(usize, usize)> = Vec::new();
            for &cell in &self.cells {
                let (column, row) = lattice.column_row(cell);
                let (across, along) = if along_rows { (row, column) } else { (column, row) };
                let other = |across: Option<usize>| {
                    let (column, row) = if along_rows { (along, across?) } else { (across?, along) };
                    let is_on = column < lattice.columns && row < lattice.rows;
                    is_on.then(|| lattice.index(column, row)).filter(|cell| bed.has_terrain(*cell))
                };
                for (line, beyond) in [(across, across.checked_sub(1)), (across + 1, Some(across + 1))] {
                    if other(beyond).is_some_and(|other| !self.cells.contains(&other)) {
                        found.push((line, along));
                    }
                }
            }
            found.sort_unstable();
            faces.extend(found.into_iter().map(|(line, along)| {
                let end = |along: usize| {
                    let (line, along) = (line as f64 * lattice.spacing, along as f64 * lattice.spacing);
                    if along_rows { Vec2::new(along, line) } else { Vec2::new(line, along) }
                };
                Edge { start: end(along), end: end(along + 1), is_open: false }
            }));
        }
        faces
    }
}

/// The cells of ridges beside which a particle on lower ground stands above their bed, each with the level (m) of the highest one. Rain on
/// the crest or on the abutments reaches nothing.
fn reached(water: &MovingWater) -> Vec<(usize, f64)> {
    let (bed, particles) = (&water.bed, &water.particles);
    let mut reached: BTreeMap<usize, f64> = BTreeMap::new();
    for (place, depth) in particles.position.iter().zip(&particles.depth) {
        if !bed.has_ridge_within(*place, bed.lattice.spacing) {
            continue;
        }
        let (ground, here) = (water.bed_at(*place).elevation, bed.lattice.cell_at(*place));
        let surface = ground + depth;
        let is_reached = |cell: &usize| {
            let crest = bed.elevation[*cell];
            bed.ridges.contains(*cell) && here != Some(*cell) && ground < crest && crest < surface
        };
        for cell in beside(bed, *place).filter(is_reached) {
            let level = reached.entry(cell).or_insert(surface);
            *level = level.max(surface);
        }
    }
    reached.into_iter().collect()
}

/// The cell of a place and those around it.
fn beside(bed: &BedParticles, place: Vec2) -> impl Iterator<Item = usize> + '_ {
    (0..9).filter_map(move |k| {
        let step = Vec2::new(f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0) * bed.lattice.spacing;
        bed.lattice.cell_at(place + step)
    })
}
