//! The maps of a run as grids.

use crate::output::ground_source::SourceGrid;
use crate::output::tracers::TracerGrids;

/// The maps for one threshold on the output grid.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ThresholdGrids {
    /// The threshold (m).
    pub threshold: f64,
    /// Time of arrival (s); [`FILL`](super::FILL) where the water never came.
    pub arrival: Vec<f32>,
    /// Time under water (s).
    pub duration: Vec<f32>,
    /// Time of the last fall below the threshold (s); [`FILL`](super::FILL) where there was none.
    pub recession: Vec<f32>,
}

/// The maps of a run on the output grid, `[rows * columns]`, row 0 in the north.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct GridMaps {
    /// Bed elevation (m).
    pub bed_elevation: Vec<f32>,
    /// Greatest depth (m).
    pub max_depth: Vec<f32>,
    /// Greatest water level (m); [`FILL`](super::FILL) where always dry.
    pub max_water_level: Vec<f32>,
    /// Greatest speed (m/s).
    pub max_speed: Vec<f32>,
    /// Greatest depth times speed of one moment (m²/s).
    pub max_depth_velocity: Vec<f32>,
    /// Time of the greatest depth (s); [`FILL`](super::FILL) where always dry.
    pub time_of_max_depth: Vec<f32>,
    /// Hazard class, 0 (dry) to 6; [`FILL`](super::FILL) outside the terrain.
    pub hazard_class: Vec<f32>,
    /// Edge of the cells of the run (m); empty where it is the same everywhere, [`FILL`](super::FILL) outside the terrain.
    pub resolution: Vec<f32>,
    /// Estimated error of the greatest depth (m); empty where none is asked for, [`FILL`](super::FILL) outside the terrain.
    pub max_depth_error: Vec<f32>,
    /// Estimated error of the first arrival (s); empty where none is asked for, [`FILL`](super::FILL) where it is not known.
    pub arrival_time_error: Vec<f32>,
    /// Who set the ground last.
    pub ground_source: SourceGrid,
    /// One entry for each threshold.
    pub thresholds: Vec<ThresholdGrids>,
    /// One entry for each tracer.
    pub tracers: Vec<TracerGrids>,
}
