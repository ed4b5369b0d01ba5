//! Faces of the lattice by the cell to their west or south, and whether the other cell lies to the north.

use std::collections::BTreeSet;

use crate::lattice::Lattice;
use crate::math::{Vec2, segments_cross};

/// The faces of a lattice that walls (local coordinates, m) cross.
pub(super) fn crossed_faces(lattice: &Lattice, walls: &[[Vec2; 2]]) -> BTreeSet<(usize, bool)> {
    let mut crossed = BTreeSet::new();
    for &wall in walls {
        let along = wall[1] - wall[0];
        let pieces = (along.norm() / lattice.spacing).ceil().max(1.0) as usize;
        let near: BTreeSet<usize> = (0..=pieces)
            .filter_map(|piece| lattice.cell_of(wall[0] + along * (piece as f64 / pieces as f64)))
            .flat_map(|cell| around(lattice, cell))
            .collect();
        for cell in near {
            let (column, row) = lattice.column_row(cell);
            let east = (column + 1 < lattice.columns).then(|| (cell + 1, false));
            let north = (row + 1 < lattice.rows).then(|| (cell + lattice.columns, true));
            let others = [east, north].into_iter().flatten();
            let is_crossed =
                |other: &(usize, bool)| segments_cross([lattice.centre(cell), lattice.centre(other.0)], wall);
            crossed.extend(others.filter(is_crossed).map(|(_, is_north)| (cell, is_north)));
        }
    }
    crossed
}

/// A cell and the cells around it.
fn around(lattice: &Lattice, cell: usize) -> impl Iterator<Item = usize> {
    let (column, row) = lattice.column_row(cell);
    let (columns, last_row, width) = (lattice.columns, lattice.rows - 1, lattice.columns);
    let rows = row.saturating_sub(1)..=(row + 1).min(last_row);
    rows.flat_map(move |row| {
        (column.saturating_sub(1)..=(column + 1).min(columns - 1)).map(move |column| row * width + column)
    })
}

/// The face between two cells beside each other.
pub(super) fn face(a: usize, b: usize) -> (usize, bool) {
    (a.min(b), a.abs_diff(b) != 1)
}

/// The cells beside a cell at a step (column, row): one, or two of the next finer level.
pub(super) fn beside(lattice: &Lattice, cell: usize, step: (isize, isize)) -> Vec<usize> {
    if let Some(other) = lattice.neighbour(cell, step).filter(|&other| lattice.is_leaf(other)) {
        return vec![other];
    }
    let spacing = lattice.spacing_of(cell);
    let out = Vec2::new(step.0 as f64, step.1 as f64);
    // Just beyond the face, a quarter of it to either side of its middle.
    let middle = lattice.centre(cell) + out * (0.5 * spacing + 0.25 * lattice.spacing);
    let aside = out.perpendicular() * (0.25 * spacing);
    let mut beside: Vec<usize> =
        [-1.0, 1.0].iter().filter_map(|&side| lattice.cell_at(middle + aside * side)).collect();
    beside.dedup();
    beside
}

/// Two cells beside each other at a step (column, row), or where they are of two levels the finer one and the cell of its level on the other side.
pub(super) fn on_one_level(
    lattice: &Lattice,
    (own, other): (usize, usize),
    (across, up): (isize, isize),
) -> [usize; 2] {
    let is_finer = |a: usize, b: usize| lattice.spacing_of(a) < lattice.spacing_of(b);
    if is_finer(own, other) {
        [own, lattice.neighbour(own, (across, up)).unwrap_or(other)]
    } else if is_finer(other, own) {
        [other, lattice.neighbour(other, (-across, -up)).unwrap_or(own)]
    } else {
        [own, other]
    }
}
