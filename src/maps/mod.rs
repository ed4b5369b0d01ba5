//! Pictures of results: map sheets as SVG with the rasters inside, hydrographs, charts of methods, gauges against measurements. No font or plotting library is needed.
//!
//! Works on plain slices, `[rows, columns]` with row 0 in the north and NaN where there is nothing, so that a run folder
//! read back from disk and results in memory are drawn alike. Opens no file. Not here: which maps a run gets (`report`).

mod chart;
mod colour;
mod comparison;
mod hillshade;
mod hydrograph;
mod picture;
mod sheet;
mod svg;

pub use chart::{ChartLine, ChartPeers, ChartPoint, speed_against_accuracy};
pub use colour::{Classes, Colour, clock};
pub use comparison::{GaugeLine, GaugePanel, PanelAxis, comparison};
pub use hillshade::hillshade;
pub use hydrograph::{Series, hydrograph};
pub use sheet::{Mark, Panel, Sheet, map_sheet};
pub use svg::escape;

/// Where the cells of a map lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapGrid {
    /// Number of columns.
    pub columns: usize,
    /// Number of rows.
    pub rows: usize,
    /// Map coordinate of the western edge (m).
    pub west: f64,
    /// Map coordinate of the northern edge (m).
    pub north: f64,
    /// Edge of a cell (m).
    pub cell: f64,
}

/// A window of cells: the part of a map that is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Window {
    first_column: usize,
    first_row: usize,
    columns: usize,
    rows: usize,
}
