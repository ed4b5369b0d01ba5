//! Experiments and floods with measurements: scenarios that run as any other, and what their gauges say against those of the experiment.
//!
//! ```text
//! Experiment ── its scenario, a resolution, methods ──→ pipeline::run ──→ run folder ── judge ──→ Row, panels of a figure
//! ```
//!
//! The scenarios are in the program itself. The data lie in the folder that `FLOODSIM_DATA` names; a case whose data are not there is left out,
//! and says so. What is read of a run is what a planner reads: `tables/gauges.csv` and `tables/gauge_series.csv`.

mod experiments;
mod gauges;
mod obstacle;
mod rajar;
mod run;
mod scenarios;
mod wet_bed;

pub use experiments::{all, named};
pub use gauges::{Series, root_mean_square};
pub use run::{DATA, ExperimentResult, Skipped, run_experiment};

use crate::maps::GaugePanel;
use crate::validation::Suite;
use gauges::Run;

/// An experiment or a flood with measurements.
pub struct Experiment {
    /// The name on the command line.
    pub name: &'static str,
    /// The file of its scenario, in `scenarios` (carried by `scenarios.rs`).
    pub scenario: &'static str,
    /// The suite.
    pub suite: Suite,
    /// One sentence: what it tests, and against what.
    pub about: &'static str,
    /// The folders of its data, that of the measurements first; none where it needs none.
    pub data: &'static [&'static str],
    /// Resolutions (m), the coarsest first; the first one is that of tests.
    pub resolutions: [f64; 2],
    /// Why Lagrangian particles are left out; empty where they run it.
    pub rests_because: &'static str,
    /// What must hold at the finer resolution, in words; empty where there is nothing to hold it to.
    pub acceptance_limit: &'static str,
    /// Looks at a run.
    pub judge: fn(&Run) -> Result<Finding, String>,
}

/// What was found of a run.
#[derive(Clone, Debug, Default)]
pub struct Finding {
    /// How the error is averaged, such as `rmse_gauges`.
    pub norm: &'static str,
    /// Error of depth or level (m).
    pub error: Option<f64>,
    /// Whether the acceptance limit is met; none without an acceptance limit.
    pub is_met: Option<bool>,
    /// Single figures, in words.
    pub note: String,
    /// Measured and computed lines, one panel for each gauge.
    pub panels: Vec<GaugePanel>,
}
