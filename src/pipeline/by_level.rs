//! The levels of a run one by one: their cells, why they stand where they do, and what they will cost.
//!
//! The cost comes from the run on the coarsest level. Where that has water, the cells of the run have it as far as their bed lies
//! below its level. Each level steps as the fastest of its water allows, by the rule of the solver:
//!
//! ```text
//! (M90)  Δt_l = 2^(k_l) Δt_0,   k_l = min(k_(l−1) + 1, floor(log2(min_(m≥l) Δt_m / Δt_0)))
//! ```

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::scout::{Moment, Scout};
use crate::bed::BedParticles;
use crate::lattice::{Lattice, Nest};
use crate::output::{LevelArea, LevelRecord};
use crate::prepare::{BLOCK, BYTES_PER_CELL, Because, Wanted};
use crate::scenario::Scenario;
use crate::solver::halvings;

/// Evaluations of a cell in a step: one for each of its two stages.
const STAGES: f64 = 2.0;
/// The core works on cells about the water, too: so many for each with water (decision 0059).
const ABOUT: f64 = 1.1;
/// Water on fine cells is so many times faster than a coarse run shows (decision 0059).
const FASTER: f64 = 1.25;
/// Bytes of a MiB.
const MIB: f64 = 1_048_576.0;

/// What settled the levels of a run; nothing of one lattice alone.
#[derive(Debug, Default)]
pub(super) struct Settled {
    /// What each place asked for.
    pub wanted: Option<Wanted>,
    /// The run on the coarsest level.
    pub scout: Option<Scout>,
}

impl Settled {
    /// Why each cell of the finest lattice, row by row from the south, is of its level; none of one lattice alone.
    fn because(&self, lattice: &Lattice) -> Option<Vec<(usize, Because)>> {
        let (wanted, nest) = (self.wanted.as_ref()?, lattice.nest()?);
        let of_cell = |cell: usize| reason(wanted, nest, (cell % lattice.columns, cell / lattice.columns));
        Some((0..lattice.columns * lattice.rows).map(of_cell).collect())
    }

    /// The levels of a bed, the finest first; nothing of one lattice alone.
    pub fn records(&self, scenario: &Scenario, bed: &BedParticles) -> Vec<LevelRecord> {
        let lattice = &bed.lattice;
        let Some(because) = self.because(lattice) else { return Vec::new() };
        let mut records: Vec<LevelRecord> = lattice
            .levels()
            .map(|level| LevelRecord {
                spacing_m: level.spacing,
                cells: lattice.leaves_of(level).filter(|&cell| bed.has_terrain(cell)).count(),
                memory_mib: lattice.places_of(level).len() as f64 * BYTES_PER_CELL / MIB,
                ..LevelRecord::default()
            })
            .collect();
        for (cell, (level, because)) in because.into_iter().enumerate() {
            if bed.has_terrain(lattice.leaf_of(cell)) {
                *records[level].area_m2.entry(because.words()).or_insert(0.0) += lattice.cell_area();
            }
        }
        for (record, cost) in records.iter_mut().zip(self.scout.iter().flat_map(|scout| costs(scenario, bed, scout))) {
            record.expected_wet_cells = cost.wet;
            record.expected_steps = cost.steps;
            record.expected_evaluations = cost.evaluations;
        }
        records
    }

    /// The parts of the terrain by level and reason, for a layer; one part of one lattice alone.
    pub fn areas(&self, bed: &BedParticles) -> Vec<LevelArea> {
        let lattice = &bed.lattice;
        let count = lattice.columns * lattice.rows;
        let because = self.because(lattice).unwrap_or_else(|| vec![(0, Because::Nothing); count]);
        let mut parts: BTreeMap<(usize, Because), Vec<bool>> = BTreeMap::new();
        for (cell, key) in because.into_iter().enumerate() {
            if bed.has_terrain(lattice.leaf_of(cell)) {
                let (column, row) = (cell % lattice.columns, lattice.rows - 1 - cell / lattice.columns);
                parts.entry(key).or_insert_with(|| vec![false; count])[row * lattice.columns + column] = true;
            }
        }
        let area = |((level, because), inside): ((usize, Because), Vec<bool>)| LevelArea {
            spacing: lattice.level(level).spacing,
            because: because.words(),
            inside,
        };
        parts.into_iter().map(area).collect()
    }
}

/// The level of a cell of the finest lattice, and why.
fn reason(wanted: &Wanted, nest: &Nest, (column, row): (usize, usize)) -> (usize, Because) {
    let level = nest.level_of(column, row);
    let block = row / BLOCK * wanted.columns + column / BLOCK;
    let is_asked_for = level == usize::from(wanted.levels[block]);
    (level, if is_asked_for { wanted.because[block] } else { Because::Transition })
}

/// What a level is expected to cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Cost {
    /// The most cells with water at once.
    pub wet: f64,
    /// Steps.
    pub steps: f64,
    /// Evaluations of the rates of one particle.
    pub evaluations: f64,
}

/// A cell that may get wet: its cell of the coarse run, and its bed (m).
#[derive(Clone, Copy)]
struct Ground {
    coarse: usize,
    bed: f64,
}

/// The expected cost of each level of a bed, by the record of a coarse run.
pub(super) fn costs(scenario: &Scenario, bed: &BedParticles, scout: &Scout) -> Vec<Cost> {
    let lattice = &bed.lattice;
    // Of each level the cells that count: their cell of the coarse run and their bed.
    let cells: Vec<Vec<Ground>> = lattice
        .levels()
        .map(|level| {
            let places = lattice.leaves_of(level).filter(|&cell| bed.has_terrain(cell));
            places
                .filter_map(|cell| Some(Ground { coarse: coarse_at(scout, lattice, cell)?, bed: bed.elevation[cell] }))
                .collect()
        })
        .collect();
    let spacings: Vec<f64> = lattice.levels().map(|level| level.spacing).collect();
    let of_moment = |moment: &Moment| cost_of(moment, (&cells, &spacings), scout.lattice.len(), scenario.numerics.cfl);
    let of_moments: Vec<Vec<Cost>> = scout.moments.par_iter().map(of_moment).collect();
    let mut sums = vec![Cost::default(); spacings.len()];
    for (level, cost) in of_moments.iter().flat_map(|costs| costs.iter().enumerate()) {
        let sum = &mut sums[level];
        sum.wet = sum.wet.max(cost.wet);
        sum.steps += cost.steps;
        sum.evaluations += cost.evaluations;
    }
    sums
}

/// The cell of a coarse run in which a cell of a lattice lies; both may begin at other places.
fn coarse_at(scout: &Scout, lattice: &Lattice, cell: usize) -> Option<usize> {
    scout.lattice.cell_at(scout.lattice.to_local(lattice.to_map(lattice.centre(cell))))
}

/// The cost of each level during a part of the run.
fn cost_of(
    moment: &Moment,
    (cells, spacings): (&[Vec<Ground>], &[f64]),
    coarse_cells: usize,
    courant: f64,
) -> Vec<Cost> {
    let mut water = vec![(f64::NEG_INFINITY, 0.0); coarse_cells];
    let mut fastest = 0.0_f64;
    for wet in &moment.wet {
        water[wet.cell] = (wet.level, wet.signal);
        fastest = fastest.max(wet.signal);
    }
    // What comes in over boundaries may be faster than the water there.
    let haste = FASTER * if fastest > 0.0 { (moment.fastest / fastest).max(1.0) } else { 1.0 };
    let of_level = |cells: &Vec<Ground>| {
        cells.iter().fold((0.0, 0.0_f64), |(count, signal), ground| {
            let (level, own) = water[ground.coarse];
            if level > ground.bed { (count + 1.0, signal.max(own)) } else { (count, signal) }
        })
    };
    let wet: Vec<(f64, f64)> = cells.iter().map(of_level).collect();
    let allowed: Vec<f64> =
        wet.iter().zip(spacings).map(|(&(_, signal), spacing)| courant * spacing / (haste * signal)).collect();
    let cost = |(&(wet, _), step): (&(f64, f64), f64)| {
        let steps = if wet > 0.0 { moment.duration / step } else { 0.0 };
        Cost { wet, steps, evaluations: STAGES * ABOUT * wet * steps }
    };
    wet.iter().zip(steps(&allowed)).map(cost).collect()
}

/// The steps (s) of the levels, the finest first, by those that their water allows (M90).
fn steps(allowed: &[f64]) -> Vec<f64> {
    let shortest = allowed.iter().copied().fold(f64::INFINITY, f64::min);
    let mut doublings = vec![0; allowed.len()];
    halvings(allowed, &mut doublings);
    doublings.into_iter().map(|k| shortest * f64::from(k).exp2()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_double_from_level_to_level_where_the_water_lets_them() {
        assert_eq!(steps(&[1.0, 2.5, 3.0, 9.0]), [1.0, 2.0, 2.0, 4.0]);
        // No level takes a longer step than a coarser one.
        assert_eq!(steps(&[4.0, 1.0]), [1.0, 1.0]);
        // One without water steps with the next finer one.
        assert_eq!(steps(&[1.0, f64::INFINITY]), [1.0, 1.0]);
        assert_eq!(steps(&[1.0, 2.5, f64::INFINITY]), [1.0, 2.0, 2.0]);
        assert_eq!(steps(&[f64::INFINITY, 2.0]), [2.0, 2.0]);
    }
}
