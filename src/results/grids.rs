//! Values of one grid on another.

use crate::maps::MapGrid;

/// The column and the row of one grid that hold the middle of each column and row of another; none where there is none.
pub(super) fn places(grid: &MapGrid, own: &MapGrid) -> (Vec<Option<usize>>, Vec<Option<usize>>) {
    let middle = |index: usize| (index as f64 + 0.5) * grid.cell;
    let index = |offset: f64, count: usize| {
        let index = (offset / own.cell).floor();
        (index >= 0.0 && index < count as f64).then_some(index as usize)
    };
    let columns = (0..grid.columns).map(|column| index(grid.west + middle(column) - own.west, own.columns)).collect();
    let rows = (0..grid.rows).map(|row| index(own.north - grid.north + middle(row), own.rows)).collect();
    (columns, rows)
}

/// Values of one grid on another: those of the cell that holds the middle of each of its cells, NaN where there is none.
pub(crate) fn onto(grid: &MapGrid, own: &MapGrid, values: Vec<f64>) -> Vec<f64> {
    if grid == own {
        return values;
    }
    let (columns, rows) = places(grid, own);
    let value = |row: Option<usize>, column: Option<usize>| match (row, column) {
        (Some(row), Some(column)) => values[row * own.columns + column],
        _ => f64::NAN,
    };
    rows.into_iter()
        .flat_map(|row| columns.iter().map(move |&column| (row, column)))
        .map(|(row, column)| value(row, column))
        .collect()
}
