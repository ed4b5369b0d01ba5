//! Where still water can go at most: every cell below its level to which it can run, and how far away that is.
//!
//! Without inflow no water rises above the level from which it comes, but for the swash of a wave; the cells below that level which
//! are joined to a body are an upper bound of the flooded area. Water passes from a cell to any of its eight neighbours with
//! terrain below the level, unless a wall stands between their centres. Higher bodies go first; lower ones take what is left.
//!
//! Left out: how much water there is, and friction. The bound is wide where a small body lies above a wide plain.

use std::collections::VecDeque;

use super::StillWater;
use crate::bed::BedParticles;
use crate::math::{Vec2, segments_cross};

/// The cells that the water of a start can reach.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reach {
    /// How many cells are so many steps away from the water of the start: the first number counts the cells of the start.
    pub cells_at: Vec<usize>,
}

impl Reach {
    /// All cells together.
    pub fn cells(&self) -> usize {
        self.cells_at.iter().sum()
    }

    /// Mean number of cells with water over a run of `end` (s), when the water advances at `speed` (m/s) in every direction from
    /// the start on, over cells of edge `spacing` (m).
    ///
    /// A step to a diagonal neighbour counts as one edge, so that no cell is reached later here than in the plane.
    pub fn mean_cells(&self, spacing: f64, speed: f64, end: f64) -> f64 {
        let share = |steps: usize| (1.0 - steps as f64 * spacing / (speed * end)).clamp(0.0, 1.0);
        self.cells_at.iter().enumerate().map(|(steps, &cells)| cells as f64 * share(steps)).sum()
    }
}

/// Finds the cells that still water can reach from its bodies, whose `levels` (m) are given in their order.
pub fn reach(bed: &BedParticles, still: &StillWater, levels: &[f64], walls: &[[Vec2; 2]]) -> Reach {
    let lattice = &bed.lattice;
    let wet = |cell: usize| still.depth[cell] > 0.0;
    let mut steps: Vec<Option<u32>> = (0..lattice.len()).map(|cell| wet(cell).then_some(0)).collect();
    let mut descending: Vec<(usize, f64)> = levels.iter().copied().enumerate().collect();
    descending.sort_by(|a, b| b.1.total_cmp(&a.1));
    for (number, level) in descending {
        let belongs = |cell: usize| still.body[cell].is_some_and(|body| body as usize == number);
        let mut open: VecDeque<usize> = (0..lattice.len()).filter(|&cell| belongs(cell)).collect();
        let mut passed = vec![false; lattice.len()];
        open.iter().for_each(|&cell| passed[cell] = true);
        while let Some(cell) = open.pop_front() {
            for other in around(bed, cell) {
                let is_walled = || {
                    let path = [lattice.centre(cell), lattice.centre(other)];
                    walls.iter().any(|&wall| segments_cross(path, wall))
                };
                if passed[other] || bed.elevation[other] >= level || is_walled() {
                    continue;
                }
                passed[other] = true;
                let next = steps[cell].map_or(0, |steps| steps + 1);
                steps[other] = Some(steps[other].map_or(next, |known| known.min(next)));
                open.push_back(other);
            }
        }
    }
    let mut reach = Reach::default();
    for steps in steps.into_iter().flatten().map(|steps| steps as usize) {
        if reach.cells_at.len() <= steps {
            reach.cells_at.resize(steps + 1, 0);
        }
        reach.cells_at[steps] += 1;
    }
    reach
}

/// The up to eight neighbours of a cell that have terrain.
fn around(bed: &BedParticles, cell: usize) -> impl Iterator<Item = usize> + '_ {
    let lattice = &bed.lattice;
    let (column, row) = lattice.column_row(cell);
    let near = (0..9).filter(|&k| k != 4).filter_map(move |k| {
        let (column, row) = ((column + k % 3).checked_sub(1)?, (row + k / 3).checked_sub(1)?);
        (column < lattice.columns && row < lattice.rows).then(|| lattice.index(column, row))
    });
    near.filter(|&other| bed.has_terrain(other))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Lattice;

    /// A strip of eight cells of 2 m with these elevations and 1 m of water above the first two.
    fn strip(elevation: [f64; 8]) -> (BedParticles, StillWater) {
        let lattice = Lattice::new(Vec2::ZERO, 8, 1, 2.0);
        let depth = (0..8).map(|cell| if cell < 2 { 1.0 } else { 0.0 }).collect();
        let body = (0..8).map(|cell| (cell < 2).then_some(0)).collect();
        (
            BedParticles::from_elevation(lattice, elevation.to_vec(), 0.0),
            StillWater { depth, body, volumes: Vec::new() },
        )
    }

    #[test]
    fn water_runs_below_its_level_and_no_further_than_a_ridge_a_wall_or_the_data() {
        let cells = |elevation, walls: &[[Vec2; 2]]| {
            let (bed, still) = strip(elevation);
            reach(&bed, &still, &[1.0], walls).cells_at
        };
        let flat = [0.0; 8];
        assert_eq!(cells(flat, &[]), [2, 1, 1, 1, 1, 1, 1]);
        assert_eq!(cells(flat, &[[Vec2::new(10.0, -1.0), Vec2::new(10.0, 3.0)]]), [2, 1, 1, 1]);
        assert_eq!(cells([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0], &[]), [2, 1]);
        assert_eq!(cells([0.0, 0.0, 0.0, 0.0, f64::NAN, 0.0, 0.0, 0.0], &[]), [2, 1, 1]);
    }

    #[test]
    fn the_mean_grows_with_the_speed_up_to_all_cells() {
        let (bed, still) = strip([0.0; 8]);
        let reach = reach(&bed, &still, &[1.0], &[]);
        // 6 m in 6 s: cells 2, 4 and 6 m away are reached after 2, 4 and 6 s.
        assert!((reach.mean_cells(2.0, 1.0, 6.0) - (2.0 + 2.0 / 3.0 + 1.0 / 3.0)).abs() < 1e-12);
        assert!(reach.mean_cells(2.0, 2.0, 6.0) > reach.mean_cells(2.0, 1.0, 6.0));
        assert!((reach.mean_cells(2.0, 1e9, 6.0) - 8.0).abs() < 1e-6);
    }
}
