//! The plain structs that the stages get: the problem of the core, and what the recorder follows.

use crate::bed::BedParticles;
use crate::boundary::{Boundary, ChannelEnd};
use crate::lattice::NEIGHBOURS;
use crate::math::Vec2;
use crate::output::{ClosedFace, Recorder, RecorderPlan, TerrainPixels, TracerPlan};
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
    let (more_area, closed_edge) = (more_area(&bed), closed_edge(scene, &bed));
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

/// The faces of leaves between terrain and none that no water passes; buildings are none.
fn closed_edge(scene: &Scene, bed: &BedParticles) -> Vec<ClosedFace> {
    let lattice = &bed.lattice;
    let (forcing, is_built) = (&scene.forcing, |cell: usize| bed.sealed.binary_search(&cell).is_ok());
    let mouths: Vec<usize> = forcing
        .channels
        .iter()
        .flat_map(|channel| [&channel.far, &channel.near])
        .flat_map(ChannelEnd::joined_cells)
        .collect();
    let squares = lattice.levels().flat_map(|level| (0..level.columns * level.rows).map(move |cell| (level, cell)));
    let leaves = squares.map(|(level, cell)| lattice.in_stack(level, cell));
    let leaves = leaves.filter(|&cell| lattice.is_leaf(cell) && bed.has_terrain(cell) && !mouths.contains(&cell));
    let faces = leaves.flat_map(|cell| {
        let length = lattice.spacing_of(cell);
        NEIGHBOURS.into_iter().filter_map(move |offset| {
            let normal = Vec2::new(offset.0 as f64, offset.1 as f64);
            let (centre, times) = (lattice.centre(cell), length / lattice.spacing);
            let beyond = lattice.cell_at(centre + normal * length);
            let middle = centre + normal * (0.5 * length);
            let gives = |boundary: &Boundary| {
                boundary.pieces.distance_to_face(times * forcing.reach, (middle, normal)).is_some()
            };
            let is_closed = beyond.is_none_or(|beyond| !bed.has_terrain(beyond) && !is_built(beyond))
                && !scene.open_edges.is_open_within(times, middle, normal)
                && !forcing.boundaries.iter().any(gives);
            is_closed.then(|| ClosedFace { cell, length, middle: lattice.to_map(middle) })
        })
    });
    faces.collect()
}

/// The cells whose water has another area than the finest cells that they stand for, ascending, and how much more (m²): cells in part, and
/// coarse cells that reach over the edge of the lattice.
fn more_area(bed: &BedParticles) -> Vec<(usize, f64)> {
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
