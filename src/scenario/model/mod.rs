//! The resolved scenario: SI units, every default filled in, paths as given relative to the scenario file.
//!
//! Stops at `pipeline` and `prepare`, which hand each stage a small plain struct.

mod breach;
mod channel;
mod forcing;
mod ground;
mod moving_bed;
mod numerics;
mod outputs;
mod reading;
mod resolution;
mod tracers;
mod water;

use std::path::PathBuf;

use crate::calendar::UtcTime;
use crate::error::Place;

pub use floodsim_core::terrain::PointInterpolation;

pub use breach::*;
pub use channel::*;
pub use forcing::*;
pub use ground::*;
pub use moving_bed::*;
pub use numerics::*;
pub use outputs::*;
pub use reading::*;
pub use resolution::*;
pub use tracers::*;
pub use water::*;

/// A value with its key path and place in the scenario file, for messages.
#[derive(Clone, Debug, PartialEq)]
pub struct Sourced<T> {
    /// The value.
    pub value: T,
    /// Key path, such as `initial[0].level`.
    pub key: String,
    /// Place in the file, where known.
    pub place: Option<Place>,
}

/// A vector file, with the layer when the scenario says `file.gpkg:layer`.
#[derive(Clone, Debug, PartialEq)]
pub struct VectorSource {
    /// Absolute or working-directory-relative path (already joined with the folder of the scenario).
    pub path: PathBuf,
    /// Layer name; the first layer when absent.
    pub layer: Option<String>,
}

/// The coordinate reference system of the run.
#[derive(Clone, Debug, PartialEq)]
pub enum CrsChoice {
    /// That of the first terrain layer.
    FromTerrain,
    /// Plain metres without a place on Earth (`crs: local`).
    Local,
    /// As named, such as `EPSG:27572`.
    Named(String),
}

/// A scenario as the program runs it.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// The scenario file.
    pub file: PathBuf,
    /// Title.
    pub title: String,
    /// Coordinate reference system.
    pub crs: Sourced<CrsChoice>,
    /// Terrain layers, later ones win; none where there are channels alone.
    pub layers: Vec<Sourced<TerrainLayer>>,
    /// Whether terrain in another or a geographic CRS is warped to the CRS of the run.
    pub reproject: bool,
    /// Holes, breaklines and buildings.
    pub ground: Ground,
    /// Roughness of the ground.
    pub roughness: Roughness,
    /// Water at the start.
    pub initial: Vec<InitialWater>,
    /// Water at the start that has no level.
    pub start: Start,
    /// Polylines that no water crosses.
    pub walls: Vec<Sourced<VectorSource>>,
    /// Open parts of the outline through which water leaves.
    pub open: Vec<OpenBoundary>,
    /// Open parts of the outline at which more is known.
    pub boundaries: Vec<Sourced<Boundary>>,
    /// Parts of the outline at which a wall stands, as the planner says; what another entry opens stays open.
    pub closed: Vec<OpenBoundary>,
    /// Sources of water.
    pub sources: Vec<Sourced<Source>>,
    /// Rain.
    pub rain: Option<Sourced<Rain>>,
    /// A dam that breaks.
    pub breach: Option<Breach>,
    /// Parts of the bed that move.
    pub moving_bed: Vec<MovingBed>,
    /// Channels of one dimension.
    pub channels: Vec<Channel>,
    /// What is carried with the water.
    pub tracers: Vec<Tracer>,
    /// Distance of two particles (m); the finest one where there are levels.
    pub resolution: Sourced<f64>,
    /// Levels of cells above it; none where all cells are of one spacing.
    pub levels: Option<Levels>,
    /// By what the program chooses both; it is done before a run, and `resolution` is not a number until then.
    pub auto: Option<Auto>,
    /// What of the terrain is read.
    pub reading: Reading,
    /// End time (s).
    pub end_time: f64,
    /// Date and time of t = 0, if given.
    pub reference_time: Option<UtcTime>,
    /// Outputs.
    pub outputs: Outputs,
    /// Methods.
    pub numerics: Numerics,
    /// Limits.
    pub limits: Limits,
}

impl Scenario {
    /// Whether all of its water is in channels of one dimension, without any terrain.
    pub fn is_channels_alone(&self) -> bool {
        self.layers.is_empty() && !self.channels.is_empty()
    }
}
