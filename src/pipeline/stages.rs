//! The plain structs that the stages get: the problem of the core, and what the recorder follows.

use super::edges::closed_faces;
use crate::bed::BedParticles;
use crate::output::{Recorder, RecorderPlan, TerrainPixels, TracerPlan};
use crate::prepare::{Scene, Setup};
use crate::scenario::{OutputPart, Scenario, Tracer};
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
    let outputs = &scenario.outputs;
    let (more_area, closed_edge) = (more_area(&bed), closed_faces(scene, &bed));
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
        followed: scene.followed.clone(),
        raised: scene.raised.clone(),
        at_banks: scene.at_banks.clone(),
        constants: scenario.numerics.constants.output,
        gauges_every: outputs.gauges_every,
        sections: scene.crossed.clone(),
        closed_edge,
        tracers: scenario.tracers.iter().map(tracer_plan).collect(),
    }
}

/// A tracer as the outputs name it.
fn tracer_plan(tracer: &Tracer) -> TracerPlan {
    TracerPlan {
        name: tracer.name.value.clone(),
        unit: tracer.unit.clone(),
        greatest: tracer.greatest(),
        arrival_threshold: tracer.arrival_threshold,
    }
}

/// The cells whose water has another area than the finest cells that they stand for, ascending, and how much more (m²): cells in part, and
/// coarse cells that reach over the edge of the lattice.
pub(super) fn more_area(bed: &BedParticles) -> Vec<(usize, f64)> {
    let lattice = &bed.lattice;
    let mut more = Vec::new();
    for level in lattice.levels() {
        let times = (level.spacing / lattice.spacing).round() as usize;
        for cell in lattice.places_of(level) {
            if lattice.conforming().is_some_and(|conforming| conforming.instead_of(cell).is_some()) {
                continue;
            }
            let (column, row) = (cell % lattice.columns, cell / lattice.columns - level.first_row);
            let inside = |from: usize, count: usize| times.min(count.saturating_sub(from * times));
            let finest = inside(column, lattice.columns) * inside(row, lattice.rows);
            let is_whole = finest == times * times && !bed.cover.holds(cell);
            if !is_whole && bed.has_terrain(cell) && lattice.is_leaf(cell) {
                more.push((cell, bed.area(cell) - finest as f64 * lattice.cell_area()));
            }
        }
    }
    if let Some(conforming) = lattice.conforming() {
        let mut squares = vec![0.0; conforming.cells().len()];
        conforming.standing_in().for_each(|number| squares[number] += 1.0);
        let own = squares.iter().enumerate().map(|(number, count)| (conforming.place(number), *count));
        let own = own.filter(|&(cell, _)| bed.has_terrain(cell));
        more.extend(own.map(|(cell, count)| (cell, bed.area(cell) - count * lattice.cell_area())));
        more.sort_unstable_by_key(|(cell, _)| *cell);
    }
    more
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
