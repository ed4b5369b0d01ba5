//! Ground that moves as prescribed: the bed of a time (M47), (M48), and the volumes by which it rose and sank.
//!
//! Its step lets a slide cross no more of a cell than a wave.

use crate::boundary::{BedLaw, BedMotion};
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::solver::{BedBalance, FlowProblem};

/// All parts of the bed that move.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(in crate::solver) struct MovingGround {
    motions: Vec<BedMotion>,
    /// For each motion the index of each of its cells in the lists below.
    places: Vec<Vec<usize>>,
    /// Centre (m) and bed at the start (m) of each cell.
    cells: Vec<(Vec2, f64)>,
    /// The bed (m) of the cells now.
    bed: Vec<(usize, f64)>,
    /// By how much (m) each cell rose at the latest change.
    rises: Vec<f64>,
    area: f64,
    /// Volume (m³) by which the bed has lifted and lowered the water on it.
    lifted: f64,
    lowered: f64,
}

impl MovingGround {
    /// None where nothing moves.
    pub fn new(problem: &FlowProblem) -> Option<Self> {
        let (lattice, motions) = (&problem.bed.lattice, problem.forcing.moving_bed.clone());
        if motions.is_empty() {
            return None;
        }
        let mut union: Vec<usize> = motions.iter().flat_map(|motion| motion.cells.iter().map(|cell| cell.0)).collect();
        union.retain(|&cell| problem.bed.has_terrain(cell));
        union.sort_unstable();
        union.dedup();
        let place = |(cell, _): &(usize, f64)| union.binary_search(cell).unwrap_or(usize::MAX);
        let places = motions.iter().map(|motion| motion.cells.iter().map(place).collect()).collect();
        Some(MovingGround {
            places,
            cells: union.iter().map(|&cell| (lattice.centre(cell), problem.bed.elevation[cell])).collect(),
            bed: union.iter().map(|&cell| (cell, problem.bed.elevation[cell])).collect(),
            rises: vec![0.0; union.len()],
            area: Lattice::cell_area(lattice),
            lifted: 0.0,
            lowered: 0.0,
            motions,
        })
    }

    /// Sets the bed of a time (s), in which parts that move all at once have done so if they began by `at_once`; whether it changed.
    pub fn follow(&mut self, time: f64, at_once: f64) -> bool {
        for (next, (_, start)) in self.rises.iter_mut().zip(&self.cells) {
            *next = *start;
        }
        for (motion, places) in self.motions.iter().zip(&self.places) {
            let progress = motion.progress(if motion.law == BedLaw::AtOnce { at_once } else { time });
            for (k, &place) in places.iter().enumerate() {
                if let Some(next) = self.rises.get_mut(place) {
                    *next += motion.change(k, self.cells[place].0, progress);
                }
            }
        }
        let mut has_moved = false;
        for (now, next) in self.bed.iter_mut().zip(&mut self.rises) {
            let rise = *next - now.1;
            if rise.abs() > 0.0 {
                now.1 = *next;
                has_moved = true;
            }
            *next = rise;
        }
        has_moved
    }

    /// The cells that changed at the latest change: index in the list of all that may, and the rise (m).
    pub fn rises(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.rises.iter().copied().enumerate().filter(|(_, rise)| rise.abs() > 0.0)
    }

    /// Books water that lay on the bed and was lifted by a volume (m³), or lowered where it is negative.
    pub fn book(&mut self, volume: f64) {
        self.lifted += volume.max(0.0);
        self.lowered -= volume.min(0.0);
    }

    /// A step (s) from a time on, so short that a slide goes no further than `reach` (m), and that it ends where a part of the bed
    /// begins to move.
    pub fn longest_step(&self, reach: f64, time: f64, step: f64) -> f64 {
        let mut longest = step;
        for motion in &self.motions {
            let speed = motion.fastest(time, time + longest);
            if speed * longest > reach {
                longest = reach / speed;
            }
            if motion.begin > time && motion.begin < time + longest {
                longest = motion.begin - time;
            }
        }
        longest
    }

    /// The cells whose bed may move, and their bed (m) now.
    pub fn bed(&self) -> &[(usize, f64)] {
        &self.bed
    }

    /// What the bed has moved so far.
    pub fn balance(&self) -> BedBalance {
        let changes = || self.bed.iter().zip(&self.cells).map(|(now, cell)| self.area * (now.1 - cell.1));
        BedBalance {
            raised: changes().map(|volume| volume.max(0.0)).sum(),
            sunk: changes().map(|volume| (-volume).max(0.0)).sum(),
            lifted: self.lifted,
            lowered: self.lowered,
        }
    }
}
