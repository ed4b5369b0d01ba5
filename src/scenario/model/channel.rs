//! Channels of one dimension.

use std::path::PathBuf;

use super::{BoundaryCondition, Side, Sourced, VectorSource};

/// A channel of one dimension.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name, in the tables and their files.
    pub id: Sourced<String>,
    /// Length (m).
    pub length: Sourced<f64>,
    /// Its cross-sections.
    pub shape: ChannelShape,
    /// Manning's n (s·m^(−1/3)); that of the ground when absent.
    pub manning: Option<f64>,
    /// What resists.
    pub walls: ChannelWalls,
    /// Water at the start, with the place of its level or depth; later ones win.
    pub water: Vec<Sourced<ChannelWater>>,
    /// Where it joins the terrain with its near end.
    pub joins: Option<Sourced<Joint>>,
    /// What is known beyond its far end; a wall when absent.
    pub upstream: Option<BoundaryCondition>,
    /// What is known beyond its near end where it joins nothing; a wall when absent.
    pub downstream: Option<BoundaryCondition>,
    /// Its axis on the map, for the places in `channels.nc`.
    pub line: Option<Sourced<VectorSource>>,
    /// Its gauges.
    pub gauges: Vec<ChannelGauge>,
}

/// A place of a channel at which the water is reported over time.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelGauge {
    /// Name.
    pub id: Sourced<String>,
    /// Distance from the far end (m).
    pub distance: Sourced<f64>,
}

/// The cross-sections of a channel.
#[derive(Clone, Debug, PartialEq)]
pub enum ChannelShape {
    /// The same rectangle everywhere.
    Rectangle {
        /// Width (m).
        width: f64,
        /// Elevation of the bed at the near end (m).
        bed: f64,
        /// Fall of the bed towards the near end (dimensionless).
        slope: f64,
    },
    /// A table of distance, elevation and width.
    Sections(Sourced<PathBuf>),
}

/// What of a channel resists the flow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ChannelWalls {
    /// The whole wetted perimeter.
    #[default]
    Rough,
    /// The bed alone, as in the plane.
    Smooth,
}

/// Still water in a part of a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelWater {
    /// Its level (m); `depth` where absent.
    pub level: Option<f64>,
    /// Its depth (m).
    pub depth: Option<f64>,
    /// Beginning (m from the far end).
    pub from: f64,
    /// End (m from the far end); that of the channel when absent.
    pub to: Option<f64>,
}

/// The opening in the edge of the terrain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// The side.
    pub side: Side,
    /// Its ends along the side, x or y in the reference system of the run (m); the whole side when absent.
    pub span: Option<(f64, f64)>,
}
