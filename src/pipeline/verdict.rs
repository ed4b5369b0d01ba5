//! The end of a run: its gates, its exit code and its summary.

use super::RunSummary;
use super::records::gate_of_discharges;
use super::{Computed, Early, Run};
use crate::error::{Error, say};
use crate::gate::Gate;
use crate::output::{HeldBack, PassageRecord, Recording, RunFolder, RunManifest, VolumeBooks, output_files};
use crate::scenario::Scenario;
use crate::solver::Ledger;

/// What the volume balance may be off, relative.
const LEDGER_TOLERANCE: f64 = 1e-9;

/// What the volume balance of a boundary, a source or rain may differ from the integral of what was asked for, relative.
const ASKED_TOLERANCE: f64 = 1e-9;

/// What the volume on the output grid may differ from that of the particles, relative.
const GRID_TOLERANCE: f64 = 5e-3;

impl Run<'_> {
    /// Fills in the manifest, closes the run, and says how it went.
    pub(super) fn finish(
        mut self,
        Computed { ledger, recording, sections, channel_gauges, early, unwritten }: Computed,
    ) -> Result<RunSummary, Error> {
        let manifest = &mut self.manifest;
        manifest.volume_m3 = volume_balance(&ledger, &recording, manifest.volume_m3.held_back);
        (manifest.closed_edge, manifest.growth_at_end) = (recording.closed_edge, recording.growth);
        manifest.gates = gates(&ledger, manifest, self.scenario);
        let failed_gates: Vec<String> =
            manifest.gates.iter().filter(|gate| gate.fails()).map(Gate::to_string).collect();
        self.clock.note(manifest, (self.before.wall_s, self.before.cpu_s));
        manifest.checkpoints = Some(self.before.checkpoints).filter(|checkpoints| checkpoints.count > 0);
        manifest.resumed_at_s = self.before.resumed_at_s.clone();
        let goes_on = early.as_ref().is_some_and(Early::may_go_on);
        let is_whole = early.is_none();
        let unwritten = match output_files(&self.folder) {
            Ok(files) => {
                manifest.outputs = files;
                unwritten
            }
            Err(error) => unwritten.or(Some(error)),
        };
        let result = match (early, unwritten) {
            (Some(Early::Failed(failure)), _) => Err(Error::Numerical(failure)),
            (Some(Early::Unwritten(error)), _) | (_, Some(error)) => Err(error),
            (Some(Early::Signal(signal)), None) => Err(stopped(&self.folder, manifest.simulated_s, signal)),
            (Some(Early::NoStep), None) => Ok(()),
            (None, None) if failed_gates.is_empty() => Ok(()),
            (None, None) => Err(Error::Gate(failed_gates.join("; "))),
        };
        let status = match result {
            Ok(()) | Err(Error::Gate(_)) if is_whole => "done",
            Ok(()) | Err(Error::Stopped { .. }) => "stopped",
            Err(_) => "failed",
        };
        manifest.ended(status, result.as_ref().err().map_or(0, |error| error.exit_code() as u8));
        let result = match (result, manifest.write(&self.folder)) {
            (result, Ok(())) => result,
            (Err(first), Err(_)) => Err(manifest.failed(&self.folder, first)),
            (Ok(()), Err(unwritten)) => Err(manifest.failed(&self.folder, unwritten)),
        };
        let goes_on = goes_on || matches!(result, Err(Error::Output { .. }));
        if !goes_on || !self.checkpoints.are_kept() {
            // What stays of them takes room, and does no harm.
            if let Err(error) = self.folder.delete_way() {
                say(format!("warning: {error}"));
            }
        } else if !self.is_for_outputs {
            say(format!("note: `floodsim resume {}` goes on with the run", self.folder.path().display()));
        }
        result.map(|()| RunSummary {
            folder: self.folder.path().to_path_buf(),
            manifest: self.manifest,
            seeded: self.seeded,
            moving: self.moving,
            gauges: self.scene.gauges.into_iter().zip(recording.gauge_results).collect(),
            sections: self.scene.sections.into_iter().zip(sections).collect(),
            channel_gauges,
        })
    }
}

/// That a signal stopped a run at a time (s).
pub(super) fn stopped(folder: &RunFolder, time: f64, signal: i32) -> Error {
    Error::Stopped { signal, time, folder: folder.path().to_path_buf() }
}

/// Volumes at start and end, inflow and outflow, and the errors of their balance.
fn volume_balance(ledger: &Ledger, recording: &Recording, held_back: Option<HeldBack>) -> VolumeBooks {
    VolumeBooks {
        initial: ledger.initial,
        inflow: ledger.inflow,
        outflow: ledger.outflow,
        last: ledger.stored,
        error_relative: ledger.relative_error(),
        grid_error_relative: recording.grid_error_relative(),
        held_back,
    }
}

/// The quality gates of a run whose volumes are in the manifest.
fn gates(ledger: &Ledger, manifest: &RunManifest, scenario: &Scenario) -> Vec<Gate> {
    let mut gates = vec![Gate::binding("volume balance", ledger.relative_error().abs(), LEDGER_TOLERANCE)];
    if !scenario.is_channels_alone() {
        gates.push(Gate::binding("volume on the grid", manifest.volume_m3.grid_error_relative, GRID_TOLERANCE));
    }
    let asked = manifest.boundaries.iter().filter_map(PassageRecord::error_relative);
    gates.extend(
        asked
            .reduce(f64::max)
            .map(|worst| Gate::binding("counted inflow against what was asked for", worst, ASKED_TOLERANCE)),
    );
    gates.extend(manifest.discharges.as_ref().map(gate_of_discharges));
    gates
}
