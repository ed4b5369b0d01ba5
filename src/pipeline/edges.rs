//! The edge of the terrain: where water passes it, where it does not, and the water that stands at it there.

use super::progress::clock_time;
use crate::bed::BedParticles;
use crate::boundary::{Boundary, ChannelEnd};
use crate::error::{Problem, input_warning};
use crate::lattice::NEIGHBOURS;
use crate::math::Vec2;
use crate::output::{ClosedEdge, ClosedFace};
use crate::prepare::{Scene, Setup};
use crate::scenario::Scenario;

/// Depth (m) of still water at a closed edge from which it is reported.
const TOLD_DEPTH: f64 = 0.1;

/// What to do about water at a closed edge.
const REMEDY: &str =
    "open the edge by `boundaries`, or take more terrain; where a wall stands there, say so by `type: closed`";

/// What is beyond a face of the edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Beyond {
    /// Water passes.
    Open,
    /// Nobody says what.
    Unsaid,
    /// A wall, as the scenario says.
    Wall,
}

/// The faces between terrain and none, each with the leaf that has it; buildings are none.
fn faces(scene: &Scene, bed: &BedParticles) -> impl Iterator<Item = (ClosedFace, Beyond)> {
    let lattice = &bed.lattice;
    let (forcing, is_built) = (&scene.forcing, |cell: usize| bed.sealed.binary_search(&cell).is_ok());
    let mouths = mouths(scene);
    let squares = lattice.levels().flat_map(|level| (0..level.columns * level.rows).map(move |cell| (level, cell)));
    // A square of the finest level may have cells in its place that follow lines; one of them stands for it.
    let standing = move |(level, cell)| {
        let square = lattice.in_stack(level, cell);
        let leaf = if level.first_row == 0 { lattice.leaf_of(square) } else { square };
        let is_its = leaf == square || lattice.conforming_at(leaf).is_some();
        (is_its && lattice.is_leaf(leaf) && bed.has_terrain(leaf)).then_some((square, leaf))
    };
    squares.filter_map(standing).flat_map(move |(square, cell)| {
        let (length, is_mouth) = (lattice.spacing_of(square), mouths.contains(&cell));
        NEIGHBOURS.into_iter().filter_map(move |offset| {
            let normal = Vec2::new(offset.0 as f64, offset.1 as f64);
            let (centre, times) = (lattice.centre(square), length / lattice.spacing);
            let beyond = lattice.cell_at(centre + normal * length);
            if beyond.is_some_and(|beyond| bed.has_terrain(beyond) || is_built(beyond)) {
                return None;
            }
            let middle = centre + normal * (0.5 * length);
            let gives = |boundary: &Boundary| {
                boundary.pieces.distance_to_face(times * forcing.reach, (middle, normal)).is_some()
            };
            let beyond = if is_mouth
                || scene.open_edges.is_open_within(times, middle, normal)
                || forcing.boundaries.iter().any(gives)
            {
                Beyond::Open
            } else if scene.closed_edges.outline.is_some() || scene.closed_edges.is_open_within(times, middle, normal) {
                Beyond::Wall
            } else {
                Beyond::Unsaid
            };
            Some((ClosedFace { cell, length, middle: lattice.to_map(middle) }, beyond))
        })
    })
}

/// The cells at which channels join.
fn mouths(scene: &Scene) -> Vec<usize> {
    let ends = scene.forcing.channels.iter().flat_map(|channel| [&channel.far, &channel.near]);
    ends.flat_map(ChannelEnd::joined_cells).collect()
}

/// The faces of the edge that no water passes, and of which the scenario does not say so.
pub(super) fn closed_faces(scene: &Scene, bed: &BedParticles) -> Vec<ClosedFace> {
    faces(scene, bed).filter(|(_, beyond)| *beyond == Beyond::Unsaid).map(|(face, _)| face).collect()
}

/// The cells from which water leaves the terrain.
pub(super) fn outlets(scene: &Scene, bed: &BedParticles) -> Vec<usize> {
    let at_edge = faces(scene, bed).filter(|(_, beyond)| *beyond == Beyond::Open).map(|(face, _)| face.cell);
    at_edge.chain(mouths(scene)).collect()
}

/// Warns of each body of still water that a closed edge cuts off.
pub(super) fn cut_off(scenario: &Scenario, setup: &Setup) -> Vec<Problem> {
    let (still, bed) = (&setup.still_water, &setup.bed);
    if !still.depth.iter().any(|depth| *depth >= TOLD_DEPTH) {
        return Vec::new();
    }
    // Of each body: the length of its faces, and the deepest of them.
    let mut found: Vec<(f64, f64, Vec2)> = vec![(0.0, 0.0, Vec2::ZERO); setup.scene.waters.len()];
    for face in closed_faces(&setup.scene, bed) {
        let depth = still.depth[face.cell];
        let Some(body) = still.body[face.cell].filter(|_| depth >= TOLD_DEPTH) else { continue };
        let Some((length, deepest, place)) = found.get_mut(body as usize) else { continue };
        *length += face.length;
        if depth > *deepest {
            (*deepest, *place) = (depth, face.middle);
        }
    }
    let told = setup.scene.waters.iter().zip(found).filter(|(_, (length, ..))| *length > 0.0);
    let warning = |(water, (length, deepest, place)): (&crate::prepare::StillBody, (f64, f64, Vec2))| {
        let message = format!(
            "this water is cut off by the edge of the terrain over {length:.0} m, and stands up to {deepest:.2} m deep there"
        );
        let place_of = scenario.initial.iter().find(|initial| initial.polygons.key == water.key);
        let problem = input_warning("closed-edge", message)
            .with_cause("an edge without an entry in `boundaries` is a wall: water that would go on beyond stays here")
            .with_remedy(REMEDY)
            .with_at(place)
            .with_place(place_of.and_then(|initial| initial.polygons.place.clone()));
        Problem { key: water.key.clone(), ..problem }
    };
    told.map(warning).collect()
}

/// The warning of a flood that came to a closed edge.
pub(super) fn reached(edge: &ClosedEdge) -> Problem {
    let message = format!(
        "the water came to {:.0} m of the closed edge of the terrain, first at {}, and stood up to {:.2} m deep there",
        edge.length_m,
        clock_time(edge.first_s),
        edge.deepest_m
    );
    let problem = input_warning("closed-edge", message)
        .with_cause(
            "an edge without an entry in `boundaries` is a wall: no flood ends there, and levels near it are too high",
        )
        .with_remedy(REMEDY)
        .with_at(Vec2::new(edge.x, edge.y));
    Problem { key: "boundaries".to_owned(), ..problem }
}
