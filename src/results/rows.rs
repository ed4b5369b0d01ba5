//! Maps of a run folder read in part: some rows of one of them, on a grid that several runs share.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::grids::places;
use super::{fill_of, open, read_grid, unreadable};
use crate::error::Error;
use crate::maps::MapGrid;

/// The maps of a run. The file is open only while it is read: a study has more runs than a process may hold files.
#[derive(Clone, Debug)]
pub(crate) struct MapRows {
    path: PathBuf,
    pub grid: MapGrid,
}

impl MapRows {
    /// The maps of a run folder.
    pub fn find(folder: &Path) -> Result<MapRows, Error> {
        let path = folder.join("maps.nc");
        let grid = read_grid(&open(&path)?, &path)?;
        Ok(MapRows { path, grid })
    }

    /// Some rows of a map on another grid: each value is that of the cell that holds the middle of its cell. NaN where it has none; none where
    /// the run has no such map.
    pub fn read(&self, name: &str, grid: &MapGrid, rows: &Range<usize>) -> Result<Option<Vec<f32>>, Error> {
        // `find` has looked at it.
        let file = netcdf::open(&self.path).map_err(|cause| unreadable(&self.path, cause.to_string()))?;
        let Some(variable) = file.variable(name) else { return Ok(None) };
        let (columns, own_rows) = places(grid, &self.grid);
        let own_rows = &own_rows[rows.clone()];
        let mut values = vec![f32::NAN; rows.len() * grid.columns];
        let there = || own_rows.iter().flatten();
        let (Some(&first), Some(&last)) = (there().min(), there().max()) else { return Ok(Some(values)) };
        let read = variable.get_values::<f32, _>((first..last + 1, ..));
        let read = read.map_err(|cause| unreadable(&self.path, format!("variable `{name}`: {cause}")))?;
        let fill = fill_of(&variable).map(|fill| fill as f32);
        for (values, own) in values.chunks_exact_mut(grid.columns).zip(own_rows) {
            let Some(own) = own else { continue };
            let read = &read[(own - first) * self.grid.columns..][..self.grid.columns];
            for (value, column) in values.iter_mut().zip(&columns) {
                let stored = column.map(|column| read[column]);
                // A fill value is stored, not computed: equal bits mean missing.
                *value = stored.filter(|stored| Some(stored.to_bits()) != fill.map(f32::to_bits)).unwrap_or(f32::NAN);
            }
        }
        Ok(Some(values))
    }
}
