//! Maps of two runs on one grid, and the differences between them.
//!
//! The grid has the cells of the finer run and holds both. A value is that of the cell of its run that holds the middle of a cell of the grid: nothing
//! is mixed, and wide cells stand for all that lies in them.

use serde::Serialize;

use crate::error::Error;
use crate::maps::MapGrid;
use crate::output::FILL;
use crate::results::{Results, onto};

/// The grid of a comparison is at most so many times as large as those of the two runs: others are of different places.
const MOST_TIMES: f64 = 4.0;
/// Share of the cells whose difference is given as usual.
const USUAL: f64 = 0.9;

/// Where water came, by the lowest depth that has a map of arrival.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Extent {
    /// The depth (m) from which on a cell counts as flooded.
    pub depth_m: f64,
    /// Area (m²) flooded in the first run.
    pub first_m2: f64,
    /// Area (m²) flooded in the second run.
    pub second_m2: f64,
    /// Area (m²) flooded in both.
    pub both_m2: f64,
}

impl Extent {
    /// The area in both over that in either; 1 where no run has any.
    pub fn overlap(&self) -> f64 {
        let either = self.first_m2 + self.second_m2 - self.both_m2;
        if either > 0.0 { self.both_m2 / either } else { 1.0 }
    }
}

/// How far two maps are apart where both have a value: second less first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Cells with a value in both.
    pub cells: usize,
    /// Mean of the differences.
    pub mean: f64,
    /// Nine tenths of the differences are not greater, whatever their sign.
    pub usual: f64,
    /// The difference of the greatest size.
    pub greatest: f64,
    /// Where it is (map coordinates, m).
    pub x: f64,
    /// As `x`.
    pub y: f64,
}

/// A map of differences.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DifferenceMap {
    /// Its name in files, that of the two maps with `_difference`.
    pub name: String,
    /// Its name for people.
    #[serde(skip)]
    pub long_name: &'static str,
    /// Unit.
    pub units: &'static str,
    /// The differences in numbers; none where no cell has a value in both.
    pub spread: Option<Spread>,
    /// Values, `[rows, cols]`, row 0 in the north; the fill value where one of the runs has none.
    #[serde(skip)]
    pub values: Vec<f32>,
}

/// All maps of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Differences {
    /// Their grid.
    #[serde(skip)]
    pub grid: MapGrid,
    /// Where water came.
    pub extent: Extent,
    /// Of each cell 0 where no water came, 1 in the first run alone, 2 in the second alone, 3 in both; the fill value where there is no terrain.
    #[serde(skip)]
    pub flooded: Vec<f32>,
    /// Differences of depth, level, speed, depth times speed, and arrival.
    pub maps: Vec<DifferenceMap>,
}

/// Maps that are compared: name, name for people of the difference, unit, and whether ground that stays dry has a value.
const COMPARED: [(&str, &str, &str); 5] = [
    ("max_depth", "difference of maximum depth", "m"),
    ("max_water_level", "difference of maximum water level", "m"),
    ("max_speed", "difference of maximum speed", "m s-1"),
    ("max_depth_velocity", "difference of maximum depth times speed", "m2 s-1"),
    ("arrival_time", "difference of time of arrival", "s"),
];

/// A grid with the cells of the finer one that holds both; none where they are of different places.
pub(super) fn common(first: &MapGrid, second: &MapGrid) -> Option<MapGrid> {
    let fine = if second.cell < first.cell { second } else { first };
    let east = |grid: &MapGrid| grid.west + grid.columns as f64 * grid.cell;
    let south = |grid: &MapGrid| grid.north - grid.rows as f64 * grid.cell;
    // Whole cells beyond the finer grid, each way; a cell that rounding alone would add is none.
    let beyond = |length: f64| (length / fine.cell - 1e-6).ceil().max(0.0);
    let [west, north] =
        [fine.west - first.west.min(second.west), first.north.max(second.north) - fine.north].map(beyond);
    let [right, below] =
        [east(first).max(east(second)) - east(fine), south(fine) - south(first).min(south(second))].map(beyond);
    let [columns, rows] = [fine.columns as f64 + west + right, fine.rows as f64 + north + below];
    let own = |grid: &MapGrid| grid.columns as f64 * grid.rows as f64 * (grid.cell / fine.cell).powi(2);
    (columns * rows <= MOST_TIMES * (own(first) + own(second))).then_some(MapGrid {
        columns: columns as usize,
        rows: rows as usize,
        west: fine.west - west * fine.cell,
        north: fine.north + north * fine.cell,
        cell: fine.cell,
    })
}

/// The differences between the maps of two runs; none where these are of different places.
pub(super) fn differences(runs: [&Results; 2]) -> Result<Option<Differences>, Error> {
    let [first, second] = runs;
    let Some(grid) = common(&first.grid, &second.grid) else { return Ok(None) };
    let on_grid = |run: &Results, name: &str| -> Result<Option<Vec<f64>>, Error> {
        Ok(run.map(name)?.map(|values| onto(&grid, &run.grid, values)))
    };
    let depth_m = runs.iter().filter_map(|run| run.arrival_depth()).fold(0.0, f64::max);
    let mut depths = Vec::new();
    for run in runs {
        depths.push(on_grid(run, "max_depth")?.unwrap_or_default());
    }
    let is_wet = |depth: f64| is_flooded(depth, depth_m);
    let (extent, flooded) = extent(&grid, [&depths[0], &depths[1]], depth_m);
    let mut maps = Vec::new();
    for (name, long_name, units) in COMPARED {
        let (Some(one), Some(other)) = (on_grid(first, name)?, on_grid(second, name)?) else { continue };
        // Where no water came in one run it has neither a level nor a speed; a depth it has, 0.
        let is_compared = |cell: usize| match name {
            "max_depth" => is_wet(depths[0][cell]) || is_wet(depths[1][cell]),
            _ => is_wet(depths[0][cell]) && is_wet(depths[1][cell]),
        };
        let difference = |cell: usize| if is_compared(cell) { other[cell] - one[cell] } else { f64::NAN };
        let values: Vec<f64> = (0..one.len()).map(difference).collect();
        let spread = spread(&grid, &values);
        let values = values.iter().map(|value| if value.is_nan() { FILL } else { *value as f32 }).collect();
        maps.push(DifferenceMap { name: format!("{name}_difference"), long_name, units, spread, values });
    }
    Ok(Some(Differences { grid, extent, flooded, maps }))
}

/// Whether a cell with such a maximum depth (m) counts as flooded.
fn is_flooded(depth: f64, least: f64) -> bool {
    depth > 0.0 && depth >= least
}

/// Areas and classes of where water came.
fn extent(grid: &MapGrid, [first, second]: [&[f64]; 2], depth_m: f64) -> (Extent, Vec<f32>) {
    let area = grid.cell * grid.cell;
    let mut counts = [0_usize; 4];
    let class = |(one, other): (&f64, &f64)| {
        if one.is_nan() && other.is_nan() {
            return FILL;
        }
        let class = usize::from(is_flooded(*one, depth_m)) + 2 * usize::from(is_flooded(*other, depth_m));
        counts[class] += 1;
        class as f32
    };
    let flooded = first.iter().zip(second).map(class).collect();
    let [_, first_alone, second_alone, both] = counts.map(|count| count as f64 * area);
    let extent = Extent { depth_m, first_m2: first_alone + both, second_m2: second_alone + both, both_m2: both };
    (extent, flooded)
}

/// Differences in numbers; NaN stands for no value.
fn spread(grid: &MapGrid, differences: &[f64]) -> Option<Spread> {
    let there = || differences.iter().enumerate().filter(|(_, value)| !value.is_nan());
    // Of equal ones the first counts.
    let (cell, greatest) = there().fold(None, |most: Option<(usize, f64)>, (cell, value)| match most {
        Some((_, most_value)) if value.abs() <= most_value.abs() => most,
        _ => Some((cell, *value)),
    })?;
    let mut sizes: Vec<f64> = there().map(|(_, value)| value.abs()).collect();
    let cells = sizes.len();
    let place = ((USUAL * cells as f64).ceil() as usize).clamp(1, cells) - 1;
    let (_, usual, _) = sizes.select_nth_unstable_by(place, f64::total_cmp);
    let usual = *usual;
    let mean = there().map(|(_, value)| value).sum::<f64>() / cells as f64;
    let (column, row) = (cell % grid.columns, cell / grid.columns);
    let x = grid.west + (column as f64 + 0.5) * grid.cell;
    let y = grid.north - (row as f64 + 0.5) * grid.cell;
    Some(Spread { cells, mean, usual, greatest, x, y })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_common_grid_holds_both_and_has_the_finer_cells() {
        let wide = MapGrid { columns: 10, rows: 8, west: 100.0, north: 580.0, cell: 10.0 };
        let fine = MapGrid { columns: 30, rows: 20, west: 120.0, north: 590.0, cell: 5.0 };
        let both = MapGrid { columns: 34, rows: 18, west: 100.0, north: 590.0, cell: 5.0 };
        // From 100 to 270 m east, from 490 (of the fine grid) to 590 m north.
        assert_eq!(common(&wide, &fine), Some(MapGrid { rows: 20, ..both }));
        assert_eq!(common(&fine, &wide), common(&wide, &fine));
        assert_eq!(common(&wide, &wide), Some(wide));
        assert_eq!(common(&wide, &MapGrid { west: 1e6, ..wide }), None);
    }

    #[test]
    fn a_spread_is_that_of_its_values() {
        let grid = MapGrid { columns: 4, rows: 3, west: 0.0, north: 30.0, cell: 10.0 };
        let mut values = vec![f64::NAN; 12];
        assert_eq!(spread(&grid, &values), None);
        values.iter_mut().zip(-9..=0).for_each(|(value, number)| *value = f64::from(number));
        // 0 to −9: nine of ten are within 8.
        let expected = Spread { cells: 10, mean: -4.5, usual: 8.0, greatest: -9.0, x: 5.0, y: 25.0 };
        assert_eq!(spread(&grid, &values), Some(expected));
    }
}
