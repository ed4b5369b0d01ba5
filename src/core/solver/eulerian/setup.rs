//! What the parts of a scene ask of its cells: where water comes from elsewhere, and which cells may move.

use super::Scale;
use super::breach::Breaking;
use super::cells_in_part::CellsInPart;
use super::conforming::ConformingFaces;
use super::inputs::Inputs;
use super::moving_bed::MovingBed;
use super::moving_cells::MovingCells;
use super::open::OpenBoundaries;
use super::passes::Passes;
use super::reach::Reaches;
use super::sections::Sections;
use super::spans::Run;
use super::state::State;
use super::walls::Walls;

/// The cells that move: none beside walls, sills, lines, cells in part, sections, dams and ground that moves, nor near boundaries, sources,
/// channels and the place whose level opens a dam.
pub(super) fn moving_cells(
    state: &mut State,
    scale: &Scale,
    (open, inputs, reaches): (&OpenBoundaries, &Inputs, &Reaches),
    (walls, passes, conforming, in_part, sections): (&Walls, &Passes, &ConformingFaces, &CellsInPart, &Sections),
    (breaking, moving_bed): (&Option<Breaking>, &Option<MovingBed>),
) -> Option<MovingCells> {
    let beside = [walls.places(), passes.places(), in_part.places(), sections.places()].concat();
    let of_dam = breaking.iter().flat_map(Breaking::places);
    let of_bed = moving_bed.iter().flat_map(MovingBed::places);
    let watched = breaking.iter().filter_map(Breaking::watched);
    let near = open.cells().chain(inputs.cells()).chain(reaches.cells()).chain(watched);
    let beside = beside.into_iter().chain(conforming.cells()).chain(of_dam).chain(of_bed);
    MovingCells::new(state, (beside, near), scale)
}

/// For every padded row the cells to which water comes from elsewhere than their neighbours: all terrain where it rains.
pub(super) fn fed(state: &State, open: &OpenBoundaries, inputs: &Inputs, reaches: &Reaches) -> Vec<Vec<Run>> {
    let mut fed: Vec<Vec<Run>> = vec![Vec::new(); state.rows + 2];
    if inputs.is_wetted {
        for (row, runs) in fed.iter_mut().enumerate() {
            runs.extend(state.bounds(row).map(|[_, columns]| columns));
        }
        return fed;
    }
    for (row, column) in open.inlets().chain(inputs.cells()).chain(reaches.cells()) {
        fed[row].push(column..column + 1);
    }
    fed
}
