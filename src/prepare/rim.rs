//! The leak test of a reservoir: where its water, at its level, would run out over the rim of its polygon.
//!
//! A face between a wet cell inside the polygon and a cell outside leaks when the higher of the two beds lies below the
//! level, no other body of water lies there, and no wall stands between the two centres. The dam that is to break leaks
//! by intention; so this is a warning, with the places to look at.

use super::polygons::segments_meet;
use crate::lattice::Lattice;
use crate::math::Vec2;

/// Differences (m) of level and rim below this are the error of elevation data, not a leak.
const NEGLIGIBLE_DEPTH: f64 = 0.1;
/// Number of low places that are listed.
const LISTED: usize = 5;
/// Listed places lie at least this many cells apart.
const APART: f64 = 10.0;

/// Where a reservoir would run out.
#[derive(Clone, Debug, PartialEq)]
pub struct Leak {
    /// Length of the rim that lies below the level (m).
    pub length: f64,
    /// Elevation of its lowest places (m) and where they are (map coordinates), lowest first.
    pub lowest: Vec<(f64, Vec2)>,
}

/// The lattice as the leak test sees it.
pub(super) struct Rim<'a> {
    pub lattice: &'a Lattice,
    /// Bed elevation at each cell (m), NaN without terrain.
    pub bed: &'a [f64],
    /// Walls in local coordinates (m).
    pub walls: &'a [[Vec2; 2]],
    /// Whether a cell belongs to any body of water, the tested one included.
    pub in_water: &'a [bool],
}

impl Rim<'_> {
    /// The leak of a body that holds the given cells and stands at `level` (m).
    pub fn leak(&self, cells: &[usize], level: f64) -> Option<Leak> {
        let lattice = self.lattice;
        let mut faces: Vec<(f64, Vec2)> = Vec::new();
        for &cell in cells.iter().filter(|&&cell| self.bed[cell] < level) {
            for neighbour in neighbours(lattice, cell) {
                // Without terrain the bed is not a number, and the comparison is false: a wall stands there.
                let rim = self.bed[cell].max(self.bed[neighbour]);
                let below = !self.bed[neighbour].is_nan() && level - rim > NEGLIGIBLE_DEPTH;
                if !below || self.in_water[neighbour] {
                    continue;
                }
                let (from, to) = (lattice.centre(cell), lattice.centre(neighbour));
                if !self.walls.iter().any(|wall| segments_meet([from, to], *wall)) {
                    faces.push((rim, (from + to) * 0.5));
                }
            }
        }
        if faces.is_empty() {
            return None;
        }
        let length = faces.len() as f64 * lattice.spacing;
        faces.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut lowest: Vec<(f64, Vec2)> = Vec::new();
        for (rim, place) in faces {
            let place = lattice.to_map(place);
            if lowest.len() < LISTED && lowest.iter().all(|(_, p)| (*p - place).norm() >= APART * lattice.spacing) {
                lowest.push((rim, place));
            }
        }
        Some(Leak { length, lowest })
    }
}

/// The up to four cells that share a face with a cell.
pub(super) fn neighbours(lattice: &Lattice, cell: usize) -> impl Iterator<Item = usize> + use<> {
    let (column, row) = lattice.column_row(cell);
    let (columns, rows) = (lattice.columns, lattice.rows);
    [
        (column > 0).then(|| cell - 1),
        (column + 1 < columns).then(|| cell + 1),
        (row > 0).then(|| cell - columns),
        (row + 1 < rows).then(|| cell + columns),
    ]
    .into_iter()
    .flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A basin of 6 by 6 cells at 0 m inside a plateau at 10 m, with a notch of one cell at 4 m in its eastern rim.
    struct Basin {
        lattice: Lattice,
        bed: Vec<f64>,
        cells: Vec<usize>,
        in_water: Vec<bool>,
    }

    const NOTCH: usize = 48;

    impl Basin {
        fn new() -> Self {
            let lattice = Lattice { origin: Vec2::new(500.0, 700.0), columns: 10, rows: 10, spacing: 5.0 };
            let cells: Vec<usize> = (2..8).flat_map(|row| (2..8).map(move |column| row * 10 + column)).collect();
            let (mut bed, mut in_water) = (vec![10.0; 100], vec![false; 100]);
            for &cell in &cells {
                bed[cell] = 0.0;
                in_water[cell] = true;
            }
            bed[NOTCH] = 4.0;
            Basin { lattice, bed, cells, in_water }
        }

        fn leak(&self, walls: &[[Vec2; 2]], level: f64) -> Option<Leak> {
            Rim { lattice: &self.lattice, bed: &self.bed, walls, in_water: &self.in_water }.leak(&self.cells, level)
        }
    }

    #[test]
    fn a_notch_below_the_level_is_found_with_its_elevation_place_and_length() {
        let basin = Basin::new();
        let leak = basin.leak(&[], 6.0).unwrap();
        assert_eq!((leak.length, leak.lowest), (5.0, vec![(4.0, Vec2::new(540.0, 722.5))]));
        assert_eq!(basin.leak(&[], 4.05), None);
        assert_eq!(basin.leak(&[], 12.0).unwrap().length, 24.0 * 5.0);
    }

    #[test]
    fn a_wall_other_water_and_missing_terrain_close_the_notch() {
        let wall = [[Vec2::new(40.0, 15.0), Vec2::new(40.0, 30.0)]];
        assert_eq!(Basin::new().leak(&wall, 6.0), None);
        let mut basin = Basin::new();
        basin.in_water[NOTCH] = true;
        assert_eq!(basin.leak(&[], 6.0), None);
        let mut basin = Basin::new();
        basin.bed[NOTCH] = f64::NAN;
        assert_eq!(basin.leak(&[], 6.0), None);
    }
}
