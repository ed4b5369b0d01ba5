//! What a recorder leaves behind.

use super::closed_edge::ClosedEdge;
use super::frames::MassBalanceRow;
use super::gauges::{GaugeResult, GaugeSample};
use super::grid::GridMaps;
use super::growth::Growth;
use super::tracers::TracerPlan;

/// Everything that a run left behind.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Time up to which was recorded (s).
    pub end_time: f64,
    /// The maps on the output grid; empty where they were left out.
    pub maps: GridMaps,
    /// What each gauge saw, in the order of the plan.
    pub gauge_results: Vec<GaugeResult>,
    /// The gauge series, by time and then by gauge.
    pub gauge_samples: Vec<GaugeSample>,
    /// Of each sample the concentrations of the tracers; no number where it is dry.
    pub gauge_concentrations: Vec<Vec<f64>>,
    /// The tracers.
    pub tracers: Vec<TracerPlan>,
    /// When the water came to each cross-section (s), which is when it came to the first of its cells; none where it never did.
    pub section_arrivals: Vec<Option<f64>>,
    /// One row for each frame.
    pub mass_balance: Vec<MassBalanceRow>,
    /// What the water did at the closed edge of the terrain; nothing where maps were left out.
    pub closed_edge: Option<ClosedEdge>,
    /// How the flood still grew at the end; nothing where it did not, and where maps were left out.
    pub growth: Option<Growth>,
}

impl Recording {
    /// Greatest difference between the volume on the output grid and that of the core, over the latter (dimensionless).
    pub fn grid_error_relative(&self) -> f64 {
        let rows = self.mass_balance.iter().filter(|row| row.volumes.stored > 0.0);
        rows.map(|row| ((row.grid_volume + row.volumes.in_channels) / row.volumes.stored - 1.0).abs())
            .fold(0.0, f64::max)
    }
}
