//! What is written, and where.

use std::path::PathBuf;

use super::{Sourced, VectorSource};

/// A part of the run folder that can be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum OutputPart {
    /// `fields.nc`.
    Fields,
    /// `maps.nc`.
    Maps,
    /// `cog/`.
    Cog,
    /// `results.gpkg`.
    Gpkg,
    /// `tables/`.
    Tables,
    /// `sections.nc`.
    Sections,
    /// `channels.nc`.
    Channels,
}

impl OutputPart {
    /// All parts.
    pub const ALL: [OutputPart; 7] = [
        OutputPart::Fields,
        OutputPart::Maps,
        OutputPart::Cog,
        OutputPart::Gpkg,
        OutputPart::Tables,
        OutputPart::Sections,
        OutputPart::Channels,
    ];

    /// The name in `outputs.write`.
    pub fn name(self) -> &'static str {
        match self {
            OutputPart::Fields => "fields",
            OutputPart::Maps => "maps",
            OutputPart::Cog => "cog",
            OutputPart::Gpkg => "gpkg",
            OutputPart::Tables => "tables",
            OutputPart::Sections => "sections",
            OutputPart::Channels => "channels",
        }
    }
}

/// What to write.
#[derive(Clone, Debug, PartialEq)]
pub struct Outputs {
    /// Run folder, unless `--out` says otherwise; its key is empty where the scenario names none.
    pub folder: Sourced<PathBuf>,
    /// The parts to write, ascending; the others are not computed.
    pub write: Vec<OutputPart>,
    /// Edge of a cell of the output grids (m); of the frames alone where the maps are on the terrain's own raster.
    pub cell: f64,
    /// Where the scenario asks for maps on the terrain's own raster.
    pub maps_on_terrain: Option<Sourced<()>>,
    /// Interval of the frames of `fields.nc` (s).
    pub every: f64,
    /// Interval of the gauge series (s).
    pub gauges_every: f64,
    /// File of cross-sections.
    pub sections: Option<Sourced<VectorSource>>,
    /// Gauge file.
    pub gauges: Option<Sourced<VectorSource>>,
    /// Depths (m) for which arrival and duration are mapped; the first one gives `arrival_time` and the isochrones.
    pub thresholds: Vec<f64>,
    /// Rise above the initial level (m) that counts as arrival where there was water at the start.
    pub rise_on_wet: f64,
    /// Times of the isochrones (s).
    pub isochrones: Vec<f64>,
    /// Whether a second run on wider cells estimates the error of the maps.
    pub error_estimate: bool,
}

impl Outputs {
    /// Whether a part is to be written.
    pub fn writes(&self, part: OutputPart) -> bool {
        self.write.contains(&part)
    }

    /// The parts that are left out.
    pub fn left_out(&self) -> impl Iterator<Item = OutputPart> + '_ {
        OutputPart::ALL.into_iter().filter(|&part| !self.writes(part))
    }

    /// Whether a second run estimates the error of maps that are written.
    pub fn wants_errors(&self) -> bool {
        self.error_estimate && (self.writes(OutputPart::Maps) || self.writes(OutputPart::Cog))
    }

    /// Whether anything is to be written for which each cell keeps its maxima.
    pub fn needs_maxima(&self) -> bool {
        [OutputPart::Maps, OutputPart::Cog, OutputPart::Gpkg].into_iter().any(|part| self.writes(part))
    }
}
