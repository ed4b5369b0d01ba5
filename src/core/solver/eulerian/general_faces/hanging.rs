//! Hanging faces: where a level of a nested lattice meets the next finer one.

use super::super::faces::{EAST, NORTH};
use super::super::mixing::Surroundings;
use super::super::state::{State, datum, sides};
use super::face::{Face, Place};
use crate::boundary::Pieces;
use crate::lattice::NEIGHBOURS;
use crate::math::smaller;
use crate::solver::FlowProblem;

/// What stands around the faces of a problem.
struct Around<'a> {
    problem: &'a FlowProblem,
    walls: Pieces,
    /// Height (m) from which the solver counts elevations.
    datum: f64,
}

/// The faces between all levels.
pub(super) fn hanging_faces(problem: &FlowProblem, state: &State) -> Vec<Face> {
    let lattice = state.lattice();
    let mut found = Vec::new();
    if lattice.nest().is_none() {
        return found;
    }
    let walls = problem.walls.iter().copied().collect();
    let around = Around { problem, walls, datum: datum(&problem.bed, &problem.initial_depth) };
    for number in 1..lattice.level_count() {
        let (level, finer) = (lattice.level(number), lattice.level(number - 1));
        for cell in 0..level.columns * level.rows {
            let (column, row) = (cell % level.columns, cell / level.columns);
            let place = (level.first_row + row + 1, column + 1);
            if !lattice.is_leaf(lattice.index(column, level.first_row + row)) || !state.has_terrain(place.0, place.1) {
                continue;
            }
            for (dc, dr) in NEIGHBOURS {
                let beside = (place.0.wrapping_add_signed(dr), place.1.wrapping_add_signed(dc));
                if !state.is_elsewhere(beside.0, beside.1) {
                    continue;
                }
                for half in [0, 1] {
                    // The fine cell next to the coarse one, in the half of its side that comes first or second.
                    let near = |cell: usize, step: isize| match step {
                        1 => 2 * cell + 2,
                        -1 => (2 * cell).wrapping_sub(1),
                        _ => 2 * cell + half,
                    };
                    let (fine_column, fine_row) = (near(column, dc), near(row, dr));
                    let is_within = fine_column < finer.columns && fine_row < finer.rows;
                    let fine = (finer.first_row + fine_row + 1, fine_column + 1);
                    let is_finer = !is_within || lattice.is_leaf(lattice.index(fine_column, fine.0 - 1));
                    if is_finer {
                        let face = hanging_face(&around, state, (place, fine), (dc, dr), half);
                        found.push(Face { level: number - 1, ..face });
                    }
                }
            }
        }
    }
    // The faces of a coarse cell follow each other.
    let coarse: Vec<Place> = found.iter().map(|face| face.places[face.coarse]).collect();
    let counts = coarse.chunk_by(PartialEq::eq).flat_map(|faces| std::iter::repeat_n(faces.len(), faces.len()));
    for (face, count) in found.iter_mut().zip(counts) {
        (face.of_coarse, face.around) = (count, surroundings(face, state));
    }
    found
}

/// What the stress on a face takes from its surroundings; a coarse cell has eight faces at most.
fn surroundings(face: &Face, state: &State) -> Surroundings {
    let faces = [0, 1].map(|side| if side == face.coarse { 8 } else { 4 });
    Surroundings::new(state, face.places, faces, (face.way(), face.length))
}

/// The face between a coarse and a fine cell that stands at an offset (column, row) from it.
fn hanging_face(
    Around { problem, walls, datum }: &Around<'_>,
    state: &State,
    (coarse, fine): (Place, Place),
    (dc, dr): (isize, isize),
    half: usize,
) -> Face {
    let direction = if dc != 0 { EAST } else { NORTH };
    let is_first = dc + dr > 0;
    let places = if is_first { [coarse, fine] } else { [fine, coarse] };
    // East and west, or north and south.
    let slots = [0, 1].map(|side: usize| sides(places[side])[2 * direction + side].0);
    let has_terrain = |(row, column): Place| state.has_terrain(row, column);
    let middle = |place: Place| state.position(place.0, place.1);
    let is_whole = places.into_iter().all(has_terrain);
    let way = |a: Place, b: Place| [middle(a), middle(b)];
    let towards = if half == 1 { 1_isize } else { -1 };
    let aside = |sign: isize| {
        let (up, across) = if direction == EAST { (sign, 0) } else { (0, sign) };
        let place = (coarse.0.wrapping_add_signed(up), coarse.1.wrapping_add_signed(across));
        (has_terrain(place) && state.level(place.0) == state.level(coarse.0) && !walls.cross(way(coarse, place)))
            .then_some(place)
    };
    let along = aside(towards).zip(aside(-towards)).map(|(ahead, behind)| [ahead, behind]);
    Face {
        places,
        slots,
        direction,
        coarse: usize::from(!is_first),
        along,
        is_wall: !is_whole || walls.cross(way(coarse, fine)),
        sill: sill(problem, *datum, fine, (-dc, -dr)),
        length: smaller(state.spacing[coarse.0], state.spacing[fine.0]),
        level: 0,
        of_coarse: 1,
        around: Surroundings::default(),
    }
}

/// The sill (m), counted as in the solver, between a fine cell and the cell of its own level for which the coarse one stands, at an offset
/// (column, row) from it.
fn sill(problem: &FlowProblem, datum: f64, (row, column): Place, (dc, dr): (isize, isize)) -> f64 {
    let columns = problem.bed.lattice.columns;
    let Some(cell) = (row - 1).checked_mul(columns).map(|first| first + column - 1) else { return f64::NEG_INFINITY };
    let beside = cell.wrapping_add_signed(dc).wrapping_add_signed(dr * columns as isize);
    problem.bed.passes.between(cell, beside) - datum
}
