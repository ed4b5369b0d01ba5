//! The bed under cells that move: between the particles of the lattice their heights and curvatures say it.
//!
//! ```text
//! (M104)  z(x) = (1 − f_x)(1 − f_y) z_00 + f_x (1 − f_y) z_10 + (1 − f_x) f_y z_01 + f_x f_y z_11
//!                − ½ f_x (1 − f_x) [(1 − f_y) κ_x0 + f_y κ_x1] − ½ f_y (1 − f_y) [(1 − f_x) κ_y0 + f_x κ_y1]
//! ```
//!
//! with f the place within the square of four bed particles, in spacings. κ is the lesser in size of the second differences of the bed at the
//! two particles of a side of it, 0 where they differ in sign. z is exact for a paraboloid, continuous, and that of the particle at its place.

use super::super::state::State;
use crate::lattice::Lattice;
use crate::math::{Vec2, minmod};

/// The bed and its friction by place.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct Ground {
    lattice: Lattice,
    /// Level (m) of each bed particle as the solver counts, not a number without terrain, and its second differences (m) along a row and a column.
    points: Vec<Point>,
}

#[derive(Clone, Copy, serde::Serialize, serde::Deserialize)]
struct Point {
    level: f64,
    /// g n² (m^(1/3)).
    friction: f64,
    curves: [f64; 2],
}

impl Ground {
    /// That of a state on one lattice.
    pub fn new(state: &State) -> Self {
        let lattice = state.lattice().clone();
        let at = |row: usize, column: usize| {
            if state.has_terrain(row, column) { state.ground[row].bed[column] } else { f64::NAN }
        };
        let curve = |before: f64, here: f64, after: f64| {
            let curve = (after - here) - (here - before);
            if curve.is_nan() { 0.0 } else { curve }
        };
        let point = |cell: usize| {
            let (column, row) = lattice.column_row(cell);
            let (row, column) = (row + 1, column + 1);
            let level = at(row, column);
            let curves = [
                curve(at(row, column - 1), level, at(row, column + 1)),
                curve(at(row - 1, column), level, at(row + 1, column)),
            ];
            Point { level, friction: state.ground[row].friction[column], curves }
        };
        let points = (0..lattice.columns * lattice.rows).map(point).collect();
        Ground { points, lattice }
    }

    /// The lattice of the bed.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Level (m) of a cell of the lattice.
    pub fn level(&self, cell: usize) -> f64 {
        self.points[cell].level
    }

    /// Level (m) and g n² (m^(1/3)) at a place.
    pub fn at(&self, place: Vec2) -> (f64, f64) {
        let Lattice { columns, rows, spacing, .. } = self.lattice;
        let within = |at: f64, count: usize| {
            let at = (at / spacing - 0.5).clamp(0.0, (count - 1) as f64);
            let first = (at as usize).min(count.saturating_sub(2));
            (first, at - first as f64)
        };
        let ((column, f_x), (row, f_y)) = (within(place.x, columns), within(place.y, rows));
        let (right, up) = ((column + 1).min(columns - 1), (row + 1).min(rows - 1));
        let point = |row: usize, column: usize| &self.points[row * columns + column];
        let [p00, p10, p01, p11] = [point(row, column), point(row, right), point(up, column), point(up, right)];
        let nearest = point(if f_y < 0.5 { row } else { up }, if f_x < 0.5 { column } else { right });
        let mix = |a: f64, b: f64, f: f64| (1.0 - f) * a + f * b;
        let plane = mix(mix(p00.level, p10.level, f_x), mix(p01.level, p11.level, f_x), f_y);
        let along = |k: usize, a: &Point, b: &Point| minmod(a.curves[k], b.curves[k]);
        let of_rows = mix(along(0, p00, p10), along(0, p01, p11), f_y);
        let of_columns = mix(along(1, p00, p01), along(1, p10, p11), f_x);
        let level = plane - 0.5 * (f_x * (1.0 - f_x) * of_rows + f_y * (1.0 - f_y) * of_columns);
        (if level.is_nan() { nearest.level } else { level }, nearest.friction)
    }
}
