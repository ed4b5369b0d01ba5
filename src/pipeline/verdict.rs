//! The end of a run: its gates, its exit code and its summary.

use super::records::gate_of_discharges;
use super::{Computed, Early, Run, RunSummary};
use crate::error::Error;
use crate::gate::Gate;
use crate::output::{PassageRecord, Recording, RunManifest, VolumeBooks};
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
        Computed { ledger, recording, sections, channel_gauges, early }: Computed,
    ) -> Result<RunSummary, Error> {
        let manifest = &mut self.manifest;
        manifest.volume_m3 = volume_balance(&ledger, &recording);
        manifest.closed_edge = recording.closed_edge;
        manifest.gates = gates(&ledger, manifest, self.scenario);
        let failed_gates: Vec<String> =
            manifest.gates.iter().filter(|gate| gate.fails()).map(Gate::to_string).collect();
        self.clock.note(manifest);
        let result = match early {
            Some(Early::Failed(failure)) => Err(Error::Numerical(failure)),
            Some(Early::Signal(signal)) => {
                Err(Error::Stopped { signal, time: manifest.simulated_s, folder: self.folder.path().to_path_buf() })
            }
            None if failed_gates.is_empty() => Ok(()),
            None => Err(Error::Gate(failed_gates.join("; "))),
        };
        manifest.exit_code = Some(result.as_ref().err().map_or(0, |error| error.exit_code() as u8));
        manifest.status = match result {
            Ok(()) | Err(Error::Gate(_)) => "done",
            Err(Error::Stopped { .. }) => "stopped",
            Err(_) => "failed",
        }
        .to_owned();
        manifest.write(&self.folder)?;
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

/// Volumes at start and end, inflow and outflow, and the errors of their balance.
fn volume_balance(ledger: &Ledger, recording: &Recording) -> VolumeBooks {
    let grid_error = recording
        .mass_balance
        .iter()
        .filter(|row| row.volumes.stored > 0.0)
        .map(|row| ((row.grid_volume + row.volumes.in_channels) / row.volumes.stored - 1.0).abs())
        .fold(0.0, f64::max);
    VolumeBooks {
        initial: ledger.initial,
        inflow: ledger.inflow,
        outflow: ledger.outflow,
        last: ledger.stored,
        error_relative: ledger.relative_error(),
        grid_error_relative: grid_error,
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
