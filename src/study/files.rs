//! Maps of several runs as files: NetCDF, and GeoTIFF with styles.

use crate::calendar::utc_now;
use crate::error::Error;
use crate::lattice::Lattice;
use crate::maps::MapGrid;
use crate::math::Vec2;
use crate::output::{FileHead, MapVariable, OutputCrs, OutputGrid, Provenance, RunFolder, write_cogs, write_map_file};
use crate::results::Results;
use crate::version;

/// What the files say of themselves.
pub(super) struct Head<'a> {
    pub title: String,
    /// Of which runs they are.
    pub comment: String,
    /// The command line as typed.
    pub command: &'a str,
    pub crs: &'a OutputCrs,
}

/// The reference system of the maps of a run.
pub(super) fn crs_of(run: &Results) -> OutputCrs {
    let system = run.reference_system();
    system.map_or(OutputCrs::Local, |(wkt2, authority)| OutputCrs::Projected { wkt2, authority })
}

/// Writes maps on a grid as variables of one NetCDF file of the folder, and as `cog/`.
pub(super) fn write_maps(
    (folder, name): (&RunFolder, &str),
    grid: &MapGrid,
    Head { title, comment, command, crs }: Head<'_>,
    variables: &[MapVariable<'_>],
) -> Result<(), Error> {
    let MapGrid { columns, rows, west, north, cell } = *grid;
    let south = north - rows as f64 * cell;
    let lattice = Lattice::new(Vec2::new(west, south), columns, rows, cell);
    let grid = OutputGrid::new(&lattice, cell, &vec![0.0; columns * rows]);
    let now = utc_now();
    let provenance = Provenance {
        title,
        source: format!("floodsim {}", version::with_commit()),
        history: format!("{now} {command}"),
        comment,
        date_created: now,
        ..Provenance::default()
    };
    let head = FileHead { crs, provenance: &provenance };
    write_map_file((folder, name), &grid, head, variables)?;
    write_cogs(folder, &grid, head, variables)
}
