//! `run.json`: what was run, from what, with what, and how it ended.
//!
//! Written with `"status": "running"` before the first step, so that a folder whose run was killed never looks whole.

use std::collections::BTreeMap;

use serde::Serialize;

use super::cell_records::{ChoiceRecord, ErrorRecord, LevelRecord, PartRecord};
use super::channels::AboveBanks;
use super::closed_edge::ClosedEdge;
use super::file_records::{CheckpointRecord, InputFile, OutputFile, mark_ended};
use super::folder::RunFolder;
use super::growth::Growth;
use super::tracers::TracerBalance;
use super::volume_records::{PassageRecord, VolumeBooks};
use crate::error::{Error, Problem};
use crate::gate::Gate;

/// Numbers of particles that carry water.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ParticleCounts {
    /// At the start.
    pub initial: usize,
    /// At most.
    pub peak: usize,
    /// At the end.
    #[serde(rename = "final")]
    pub last: usize,
}

/// A body of still water at the start.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StillWaterRecord {
    /// Key of the scenario.
    pub name: String,
    /// Its level (m).
    pub level_m: f64,
    /// Integral of level minus terrain over its polygon, with the next two (m³).
    pub integral_m3: f64,
    /// What lies beside the polygon, up to the edge of the terrain (m³).
    pub at_edge_m3: f64,
    /// What the cells at upright banks hold more than the polygon has there (m³); below 0 where they hold less.
    pub at_banks_m3: f64,
    /// Volume of its cells at the level (m³).
    pub seeded_m3: f64,
}

/// Lengths of the time steps (s).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct StepLengths {
    /// Shortest.
    pub min: f64,
    /// Median.
    pub median: f64,
    /// Longest.
    pub max: f64,
}

/// The dam that broke, or stood to the end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BreachRecord {
    /// When it began (s); none where it stood.
    pub began_s: Option<f64>,
    /// Level of the crest (m).
    pub crest_m: f64,
    /// Final level of the bottom (m); none where the whole dam went, as the next two.
    pub invert_m: Option<f64>,
    /// Final width of the bottom (m).
    pub bottom_width_m: Option<f64>,
    /// Slope of the sides, horizontal to vertical.
    pub side_slope: Option<f64>,
    /// How long it grew (s); 0 where it opened at once.
    pub duration_s: f64,
}

/// Discharges of the particles beside those of their faces (M85), over the moments of the frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct DischargeRecord {
    /// Sum of their differences over the sum of the greater ones (dimensionless).
    pub apart_relative: f64,
    /// Share of the latter in particles where they differ by more than half (dimensionless).
    pub in_doubt_relative: f64,
    /// The particle of the greatest difference among these, where there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worst: Option<WorstDischarge>,
}

/// A particle whose discharge is not that of its faces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct WorstDischarge {
    /// When (s).
    pub time_s: f64,
    /// Where (map coordinates, m).
    pub x: f64,
    /// Where (map coordinates, m).
    pub y: f64,
    /// Its own discharge, depth times speed (m²/s).
    pub own_m2_s: f64,
    /// That of its faces (m²/s).
    pub at_faces_m2_s: f64,
}

/// Cells at the edge of the terrain that count for more or less than a cell (M13).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct CellsInPartRecord {
    /// How many there are.
    pub cells: usize,
    /// The least and the greatest area, over that of a cell (dimensionless).
    pub least: f64,
    /// See [`Self::least`].
    pub greatest: f64,
}

/// Steep banks of the terrain that the sides of cells follow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BanksRecord {
    /// How many there are.
    pub lines: usize,
    /// Their length (m).
    pub length_m: f64,
}

/// What a bed that moved has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MovingBedRecord {
    /// When the first part of it began to move (s).
    pub began_s: f64,
    /// Volume by which the bed lies above that of the start at the end, where it does (m³).
    pub raised_m3: f64,
    /// Volume by which it lies below (m³).
    pub sunk_m3: f64,
    /// Volume by which it lifted water that lay on it, all movements up (m³).
    pub lifted_m3: f64,
    /// Volume by which it lowered water, all movements down (m³).
    pub lowered_m3: f64,
}

/// The earlier run that this one went on from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HotStart {
    /// Its `fields.nc`, as the scenario names it.
    pub path: String,
    /// The moment of it (s); none for its last one.
    pub time_s: Option<f64>,
}

/// A warning of the check, under which the run went on, or of the run itself.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WarningRecord {
    /// Its short name.
    pub code: String,
    /// The key of the scenario.
    pub key: String,
    /// What is wrong.
    pub message: String,
    /// Why.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cause: Option<String>,
    /// What to do about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
    /// Map coordinates of its place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<[f64; 2]>,
}

impl From<&Problem> for WarningRecord {
    fn from(problem: &Problem) -> Self {
        WarningRecord {
            code: problem.code.to_owned(),
            key: problem.key.clone(),
            message: problem.message.clone(),
            cause: problem.cause.clone(),
            remedy: problem.remedy.clone(),
            at: problem.at.map(|place| [place.x, place.y]),
        }
    }
}

/// The contents of `run.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RunManifest {
    /// Version of the program.
    pub version: String,
    /// Commit of the program, where known.
    pub git: Option<String>,
    /// The command line.
    pub command: String,
    /// Number of threads.
    pub threads: usize,
    /// Vector instructions in use.
    pub simd: String,
    /// SHA-256 of the scenario file.
    pub scenario_sha256: String,
    /// The inputs.
    pub inputs: Vec<InputFile>,
    /// Method families and the chosen members.
    pub methods: BTreeMap<String, String>,
    /// Particles that carry water.
    pub particles: ParticleCounts,
    /// Riverbed particles.
    pub bed_particles: usize,
    /// The part of the terrain that was prepared, where that is not all of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub terrain_part: Option<PartRecord>,
    /// How their spacing was chosen, where the scenario left it to the program.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resolution: Option<ChoiceRecord>,
    /// Its levels, the finest first, where there are several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub levels: Vec<LevelRecord>,
    /// The estimated error of the maps, where it is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_estimate: Option<ErrorRecord>,
    /// Cells of them that count in part, where there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cells_in_part: Option<CellsInPartRecord>,
    /// Where the water came to closed edges of the terrain, if it did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub closed_edge: Option<ClosedEdge>,
    /// How the flood still grew when the run ended, if it did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub growth_at_end: Option<Growth>,
    /// Banks that cells follow, where there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub banks: Option<BanksRecord>,
    /// Steps taken.
    pub steps: u64,
    /// Evaluations of the rates of one particle.
    pub particle_evaluations: u64,
    /// Simulated time (s).
    pub simulated_s: f64,
    /// Wall-clock time (s).
    pub wall_s: f64,
    /// Processor time of all threads (s).
    pub cpu_s: f64,
    /// Wall-clock time of each phase (s).
    pub phase_s: BTreeMap<String, f64>,
    /// Greatest memory in use (MiB).
    pub peak_rss_mb: f64,
    /// The water balance.
    pub volume_m3: VolumeBooks,
    /// The bodies of still water at the start, where there are any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub still_water: Vec<StillWaterRecord>,
    /// Greatest speed of the run (m/s).
    pub max_speed_m_s: f64,
    /// Lengths of the time steps.
    pub dt_s: StepLengths,
    /// How many steps each limit cut.
    pub limiters: BTreeMap<String, u64>,
    /// Discharges of the particles beside those of their faces, where particles have faces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub discharges: Option<DischargeRecord>,
    /// The dam that breaks, where the scenario has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub breach: Option<BreachRecord>,
    /// The channels whose water stood above the last row of their sections, where there are any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub above_banks: Vec<AboveBanks>,
    /// The bed that moves, where the scenario has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub moving_bed: Option<MovingBedRecord>,
    /// The earlier run that this one went on from, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hot_start: Option<HotStart>,
    /// Inflow and outflow by each boundary, source, channel and by rain, where the scenario has any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub boundaries: Vec<PassageRecord>,
    /// The balance of each tracer at the end, where there are any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tracers: Vec<TracerBalance>,
    /// What the check warned of, and the run at its end, where there is anything.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<WarningRecord>,
    /// The parts of the run folder that `outputs.write` leaves out, where it does.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub not_written: Vec<String>,
    /// Checkpoints, where there was any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub checkpoints: Option<CheckpointRecord>,
    /// The simulated times (s) from which the run went on, where it was cut off.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub resumed_at_s: Vec<f64>,
    /// What was written besides this file.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub outputs: Vec<OutputFile>,
    /// Quality gates.
    pub gates: Vec<Gate>,
    /// `running`, `done`, `failed` or `stopped`.
    pub status: String,
    /// Exit code of the program; none while it runs.
    pub exit_code: Option<u8>,
}

impl RunManifest {
    /// Writes `run.json`, whole or not at all.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, folder: &RunFolder) -> Result<(), Error> {
        let mut text = serde_json::to_string_pretty(self).map_err(|cause| Error::Internal(cause.to_string()))?;
        text.push('\n');
        folder.write("run.json", text.as_bytes())
    }

    /// How the run ended.
    pub fn ended(&mut self, status: &str, exit_code: u8) {
        self.status = status.to_owned();
        self.exit_code = Some(exit_code);
    }

    /// Says in `run.json` that an error ended the run, as far as that can still be written; hands on the error.
    pub fn failed(&mut self, folder: &RunFolder, error: Error) -> Error {
        self.ended("failed", error.exit_code() as u8);
        if self.write(folder).is_err() {
            mark_ended(folder.path(), &self.status, i32::from(error.exit_code() as u8));
        }
        error
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_passage_is_measured_against_what_was_asked_for() {
        let passage =
            |in_m3: f64, out_m3: f64, asked_m3| PassageRecord { name: String::new(), in_m3, out_m3, asked_m3 };
        assert_eq!(passage(7.0, 1.0, None).error_relative(), None);
        assert!((passage(7.0, 1.0, Some(8.0)).error_relative().unwrap() - 0.25).abs() < 1e-15);
        assert!(passage(0.0, 0.0, Some(0.0)).error_relative().unwrap().abs() <= 0.0);
        // Water where none was asked for is no small error.
        assert!(passage(1e-9, 0.0, Some(0.0)).error_relative().unwrap().is_infinite());
    }

    #[test]
    fn keys_are_those_of_the_contract() {
        let place = tempfile::tempdir().unwrap();
        let folder = RunFolder::create(place.path(), false).unwrap();
        RunManifest { status: "running".into(), ..RunManifest::default() }.write(&folder).unwrap();
        let text = std::fs::read_to_string(folder.file("run.json")).unwrap();
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        let mut keys: Vec<_> = value.as_object().unwrap().keys().cloned().collect();
        keys.sort();
        let mut expected: Vec<&str> = "version git command threads simd scenario_sha256 inputs methods particles bed_particles \
             steps particle_evaluations simulated_s wall_s cpu_s phase_s peak_rss_mb volume_m3 max_speed_m_s dt_s limiters \
             gates status exit_code"
            .split_whitespace()
            .collect();
        expected.sort_unstable();
        assert_eq!(keys, expected);
        assert!(value["volume_m3"].get("in").is_some() && value["particles"].get("final").is_some());
        assert_eq!(value["status"], "running");
    }
}
