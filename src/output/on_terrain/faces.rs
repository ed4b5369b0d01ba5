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
