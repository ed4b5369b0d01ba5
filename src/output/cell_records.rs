//! What `run.json` says of the cells of a run: how they were chosen, their levels, and the error that they make.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

/// A level of a nested lattice.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LevelRecord {
    /// Edge of its cells (m).
    pub spacing_m: f64,
    /// Its cells with terrain.
    pub cells: usize,
    /// Its area (m²), by why it is of that level.
    pub area_m2: BTreeMap<&'static str, f64>,
    /// Memory of its cells (MiB), before the run.
    #[serde(rename = "memory_mb")]
    pub memory_mib: f64,
    /// Its most cells with water at once, as expected before the run.
    pub expected_wet_cells: f64,
    /// Its steps, as expected before the run.
    pub expected_steps: f64,
    /// Evaluations of its particles, as expected before the run.
    pub expected_evaluations: f64,
}

/// What a second run on wider cells says of the error of the maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, serde::Deserialize)]
pub struct ErrorRecord {
    /// Edge of the finest cells of that run (m).
    pub spacing_m: f64,
    /// Order of the error in the edge of the cells.
    pub order: u32,
    /// Estimated error of the maximum depth (m), mean over flooded cells.
    pub mean_depth_m: Option<f64>,
    /// The same that 95 % of the flooded cells do not exceed (m).
    pub depth_95_m: Option<f64>,
    /// Estimated error of the arrival (s), mean over the cells that the water reaches in both runs.
    pub mean_arrival_s: Option<f64>,
    /// The same that 95 % of these cells do not exceed (s).
    pub arrival_95_s: Option<f64>,
    /// Evaluations of that run.
    pub particle_evaluations: u64,
    /// CPU time of that run (s).
    pub cpu_s: f64,
}

/// How the program chose the lengths of the cells.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct ChoiceRecord {
    /// Edge of the finest cells (m).
    pub finest_m: f64,
    /// Edge of the coarsest ones (m).
    pub coarsest_m: f64,
    /// Edge of the terrain's pixels (m).
    pub pixel_m: f64,
    /// Edges of the cells of the runs that went first (m).
    pub looked_at_m: Vec<f64>,
    /// Wanted mean error of the maximum depth (m).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wanted_error_m: Option<f64>,
    /// Expected mean error of the maximum depth (m).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_error_m: Option<f64>,
    /// Mean maximum depth (m) of the flooded ground in the finer of the runs that went first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_max_depth_m: Option<f64>,
    /// Expected evaluations of the rates of one particle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_evaluations: Option<f64>,
    /// Expected CPU time of the steps (s).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_cpu_s: Option<f64>,
    /// Why, in words.
    pub because: Vec<String>,
}

/// The part of a large terrain that was prepared.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PartRecord {
    /// Its sides (map coordinates, m).
    pub west: f64,
    /// See `west`.
    pub south: f64,
    /// See `west`.
    pub east: f64,
    /// See `west`.
    pub north: f64,
    /// Width and height (m).
    pub size_m: [f64; 2],
    /// Width and height of all of the terrain (m).
    pub terrain_m: [f64; 2],
}

impl fmt::Display for PartRecord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = |[across, up]: [f64; 2]| format!("{:.2} km by {:.2} km", across / 1000.0, up / 1000.0);
        write!(
            f,
            "{} of {} are prepared: the water of a run on coarse cells, what the scenario names, and a margin",
            size(self.size_m),
            size(self.terrain_m)
        )
    }
}
