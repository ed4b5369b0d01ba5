//! The plain structs that the stages get: the problem of the core, and what the recorder follows.

use crate::bed::BedParticles;
use crate::output::{Recorder, RecorderPlan, TerrainPixels};
use crate::prepare::{Scene, Setup};
use crate::scenario::{OutputPart, Scenario};
use crate::solver::FlowProblem;

/// The problem of the core on a bed, which is that of the setup.
pub(crate) fn flow_problem(scenario: &Scenario, setup: &Setup, bed: BedParticles) -> FlowProblem {
    let scene = &setup.scene;
    FlowProblem {
        bed,
        walls: scene.walls.clone(),
        open_edges: scene.open_edges.clone(),
        forcing: scene.forcing.clone(),
        initial_depth: setup.still_water.depth.clone(),
        gravity: scenario.numerics.gravity,
        courant: scenario.numerics.cfl,
        dry_depth: scenario.numerics.dry_depth,
    }
}

/// What the recorder follows of a scenario, on the bed of the run.
pub(super) fn recorder_plan(
    scenario: &Scenario,
    scene: &Scene,
    bed: BedParticles,
    pixels: Option<TerrainPixels>,
) -> RecorderPlan {
    let (outputs, lattice) = (&scenario.outputs, &bed.lattice);
    let parts = bed.cover.cells().iter().filter(|part| lattice.is_leaf(part.cell));
    let more_area = parts.map(|part| (part.cell, (part.area - 1.0) * lattice.area_of(part.cell))).collect();
    RecorderPlan {
        more_area,
        lattice: bed.lattice,
        bed_elevation: bed.elevation,
        cell: outputs.cell,
        terrain: pixels.map(|pixels| (pixels, bed.passes)),
        thresholds: outputs.thresholds.clone(),
        rise_on_wet: outputs.rise_on_wet,
        every: outputs.every,
        end_time: scenario.end_time,
        gauges: scene.gauges.clone(),
        walls: scene.walls.clone(),
        raised: scene.raised.clone(),
        at_banks: scene.at_banks.clone(),
        constants: scenario.numerics.constants.output,
        gauges_every: outputs.gauges_every,
        sections: scene.crossed.clone(),
    }
}

/// A recorder of what the scenario wants written.
pub(crate) fn recorder_of(scenario: &Scenario, plan: RecorderPlan) -> Recorder {
    let mut recorder = Recorder::new(plan);
    if !scenario.outputs.writes(OutputPart::Fields) {
        recorder.leave_out_frames();
    }
    if !scenario.outputs.needs_maxima() {
        recorder.leave_out_maps();
    }
    recorder
}
