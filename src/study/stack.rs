//! The maps of many runs on one grid, some rows at a time.

use std::ops::Range;

use rayon::prelude::*;

use super::maps::common;
use crate::error::Error;
use crate::maps::MapGrid;
use crate::output::FILL;
use crate::results::MapRows;

/// Bytes of the values that are read at once.
const BLOCK: usize = 128 << 20;

/// What is made of the values of a cell, which stand in ascending order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Measure {
    /// The value that this share of the runs does not exceed.
    Quantile(f64),
    /// The share of runs with at least this much, and more than none.
    AtLeast(f64),
    /// The share of runs above this.
    Above(f64),
    /// The least.
    Least,
    /// The greatest.
    Greatest,
    /// The distance of two quantiles.
    Between(f64, f64),
}

impl Measure {
    /// Of the values of one cell; infinite ones are those of runs in which it never came.
    fn of(self, ascending: &[f32]) -> f32 {
        let quantile = |p| super::quantile::quantile(ascending, p).unwrap_or(f32::NAN);
        let share = |count: usize| count as f32 / ascending.len() as f32;
        match self {
            Measure::Quantile(p) => quantile(p),
            Measure::AtLeast(least) => {
                share(ascending.iter().filter(|value| **value > 0.0 && f64::from(**value) >= least).count())
            }
            Measure::Above(least) => share(ascending.iter().filter(|value| f64::from(**value) > least).count()),
            Measure::Least => ascending.first().copied().unwrap_or(f32::NAN),
            Measure::Greatest => ascending.last().copied().unwrap_or(f32::NAN),
            Measure::Between(low, high) => quantile(high) - quantile(low),
        }
    }
}

/// The maps of runs.
pub(super) struct Stack {
    /// Their common grid.
    pub grid: MapGrid,
    runs: Vec<MapRows>,
}

impl Stack {
    /// Of several runs; none where they are of different places.
    pub fn of(runs: Vec<MapRows>) -> Option<Stack> {
        let mut grids = runs.iter().map(|run| run.grid);
        let first = grids.next()?;
        let grid = grids.try_fold(first, |all, grid| common(&all, &grid))?;
        Some(Stack { grid, runs })
    }

    /// Rows that are read at once, one block after the other.
    fn blocks(&self, runs: usize) -> impl Iterator<Item = Range<usize>> {
        let rows = (BLOCK / (size_of::<f32>() * self.grid.columns.max(1) * runs.max(1))).max(1);
        let all = self.grid.rows;
        (0..all).step_by(rows).map(move |first| first..(first + rows).min(all))
    }

    /// Rows of a map of some runs; a run without that map has no value.
    fn read(&self, name: &str, runs: &[usize], rows: &Range<usize>) -> Result<Vec<Vec<f32>>, Error> {
        let nothing = || vec![f32::NAN; rows.len() * self.grid.columns];
        let one = |run: &usize| Ok(self.runs[*run].read(name, &self.grid, rows)?.unwrap_or_else(nothing));
        runs.iter().map(one).collect()
    }

    /// A map of one run.
    pub fn map(&self, name: &str, run: usize) -> Result<Vec<f32>, Error> {
        Ok(self.read(name, &[run], &(0..self.grid.rows))?.swap_remove(0))
    }

    /// Of each run the area (m²) in which a map has at least so much.
    pub fn areas(&self, name: &str, runs: &[usize], least: f64) -> Result<Vec<f64>, Error> {
        let is_there = |value: &&f32| **value > 0.0 && f64::from(**value) >= least;
        let mut counts = vec![0_usize; runs.len()];
        for rows in self.blocks(1) {
            for (count, run) in counts.iter_mut().zip(runs) {
                *count += self.read(name, &[*run], &rows)?[0].iter().filter(is_there).count();
            }
        }
        Ok(counts.into_iter().map(|count| count as f64 * self.grid.cell.powi(2)).collect())
    }

    /// Measures of a map over some runs, one map each. A run without a value at a cell counts there as `missing`; a cell at which no run has
    /// one, and a measure that is not finite, has the fill value.
    pub fn measures(
        &self,
        name: &str,
        runs: &[usize],
        missing: f32,
        measures: &[Measure],
    ) -> Result<Vec<Vec<f32>>, Error> {
        self.of_cells(runs.len(), measures, |rows| {
            let values = self.read(name, runs, rows)?;
            Ok(move |cell: usize, own: &mut Vec<f32>| {
                own.extend(values.iter().map(|values| values[cell]));
                let is_there = own.iter().any(|value| !value.is_nan());
                own.iter_mut().filter(|value| value.is_nan()).for_each(|value| *value = missing);
                is_there
            })
        })
    }

    /// Measures of the differences of a map between runs, first less second of each pair; ground that is dry in all of them has none.
    pub fn increments(
        &self,
        name: &str,
        pairs: &[(usize, usize)],
        measures: &[Measure],
    ) -> Result<Vec<Vec<f32>>, Error> {
        let (first, second): (Vec<usize>, Vec<usize>) = pairs.iter().copied().unzip();
        self.of_cells(2 * pairs.len(), measures, |rows| {
            let values = [self.read(name, &first, rows)?, self.read(name, &second, rows)?];
            Ok(move |cell: usize, own: &mut Vec<f32>| {
                let value = |values: &Vec<f32>| Some(values[cell]).filter(|value| !value.is_nan()).unwrap_or(0.0);
                let is_wet = values.iter().flatten().any(|values| value(values) > 0.0);
                own.extend(values[0].iter().zip(&values[1]).map(|(one, other)| value(one) - value(other)));
                is_wet
            })
        })
    }

    /// Measures of the values that `block` gives for the cells of some rows; it says of each cell whether it has any.
    fn of_cells<Cell: Fn(usize, &mut Vec<f32>) -> bool + Sync>(
        &self,
        values: usize,
        measures: &[Measure],
        block: impl Fn(&Range<usize>) -> Result<Cell, Error>,
    ) -> Result<Vec<Vec<f32>>, Error> {
        let mut maps = vec![Vec::with_capacity(self.grid.rows * self.grid.columns); measures.len()];
        for rows in self.blocks(values) {
            let cell_values = block(&rows)?;
            let mut measured = vec![FILL; rows.len() * self.grid.columns * measures.len()];
            let cells = measured.par_chunks_mut(measures.len()).enumerate();
            cells.for_each_init(Vec::new, |own, (cell, measured)| {
                own.clear();
                if !cell_values(cell, own) {
                    return;
                }
                own.sort_unstable_by(f32::total_cmp);
                for (value, measure) in measured.iter_mut().zip(measures) {
                    *value = Some(measure.of(own)).filter(|value| value.is_finite()).unwrap_or(FILL);
                }
            });
            for (which, map) in maps.iter_mut().enumerate() {
                map.extend(measured.iter().skip(which).step_by(measures.len()));
            }
        }
        Ok(maps)
    }
}
