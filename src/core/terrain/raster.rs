//! A georeferenced raster in memory, row 0 in the north, NaN where there is no data.

use crate::math::{Rectangle, Vec2, minmod};

/// A north-up raster.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// Number of columns.
    pub columns: usize,
    /// Number of rows.
    pub rows: usize,
    /// Map coordinate of the western edge (m).
    pub west: f64,
    /// Map coordinate of the northern edge (m).
    pub north: f64,
    /// Width of a cell (m).
    pub cell_x: f64,
    /// Height of a cell (m), positive.
    pub cell_y: f64,
    /// Values `[rows, columns]`, row 0 in the north; NaN is no data.
    pub values: Vec<f64>,
}

impl Raster {
    /// The value of a cell.
    #[inline]
    pub fn value(&self, column: usize, row: usize) -> f64 {
        self.values[row * self.columns + column]
    }

    /// Map coordinates of the centre of a cell.
    #[inline]
    pub fn centre(&self, column: usize, row: usize) -> Vec2 {
        Vec2::new(self.west + (column as f64 + 0.5) * self.cell_x, self.north - (row as f64 + 0.5) * self.cell_y)
    }

    /// Map coordinate of the eastern edge (m).
    pub fn east(&self) -> f64 {
        self.west + self.columns as f64 * self.cell_x
    }

    /// Map coordinate of the southern edge (m).
    pub fn south(&self) -> f64 {
        self.north - self.rows as f64 * self.cell_y
    }
}

/// The plane of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    /// Value at the centre of the cell, and mean over it.
    pub own: f64,
    /// Rise over a cell to the east, and to the north.
    east: f64,
    north: f64,
    /// The centre (map coordinates).
    centre: Vec2,
}

impl Plane {
    /// The greatest value in the cell.
    pub fn highest(self) -> f64 {
        self.own + 0.5 * (self.east.abs() + self.north.abs())
    }
}

/// Distance from a cell centre, in cells, within which a place counts as that centre: the round-off of map coordinates.
const CENTRE_TOLERANCE: f64 = 1e-6;

impl Raster {
    /// Column and row of the cell that holds a place (map coordinates).
    ///
    /// A place on the outermost edge belongs to the last cell.
    pub fn cell_at(&self, map: Vec2) -> Option<(usize, usize)> {
        let column = (map.x - self.west) / self.cell_x;
        let row = (self.north - map.y) / self.cell_y;
        let inside = column >= 0.0 && row >= 0.0 && column <= self.columns as f64 && row <= self.rows as f64;
        inside.then(|| ((column as usize).min(self.columns - 1), (row as usize).min(self.rows - 1)))
    }

    /// Bilinear elevation (m) between cell centres; none where the cell that holds the place has no data.
    ///
    /// Beside the edge and cells without data, where there is no centre beyond the place, the elevation goes on as it does on the other
    /// side of the cell, by the lesser of the two differences there, so that it is flat beside a lone step. Beside cells without data it
    /// does not rise: a lake there holds what the cells say. At a cell centre the value is exactly that of the cell.
    pub fn elevation(&self, map: Vec2) -> Option<f64> {
        let (column, row) = self.cell_at(map)?;
        let own = self.value(column, row);
        if own.is_nan() {
            return None;
        }
        let from_centre_x = (map.x - self.west) / self.cell_x - (column as f64 + 0.5);
        let from_centre_y = (self.north - map.y) / self.cell_y - (row as f64 + 0.5);
        if from_centre_x.abs() < CENTRE_TOLERANCE && from_centre_y.abs() < CENTRE_TOLERANCE {
            return Some(own);
        }
        let (weight_x, weight_y) = (from_centre_x.abs(), from_centre_y.abs());
        let to_east = if from_centre_x < 0.0 { -1 } else { 1 };
        let to_south = if from_centre_y < 0.0 { -1 } else { 1 };
        // The cell so many cells further in the direction of the place, as far as the raster goes, and its value.
        let place = |across: isize, down: isize| {
            let (c, r) = (column.checked_add_signed(to_east * across)?, row.checked_add_signed(to_south * down)?);
            (c < self.columns && r < self.rows).then_some((c, r))
        };
        let further = |across: isize, down: isize| {
            place(across, down).map(|(c, r)| self.value(c, r)).filter(|value| !value.is_nan())
        };
        let beside = |across: isize, down: isize| {
            further(across, down).unwrap_or_else(|| {
                let behind = further(-across, -down).zip(further(-2 * across, -2 * down));
                let gone_on = own + behind.map_or(0.0, |(behind, before)| minmod(own - behind, behind - before));
                if place(across, down).is_some() { gone_on.min(own) } else { gone_on }
            })
        };
        let (beside_x, beside_y) = (beside(1, 0), beside(0, 1));
        let across = further(1, 1).unwrap_or(beside_x + beside_y - own);
        let towards = |from: f64, to: f64, share: f64| (1.0 - share) * from + share * to;
        Some(towards(towards(own, beside_x, weight_x), towards(beside_y, across, weight_x), weight_y))
    }

    /// Elevation (m) of planes whose means over the cells are the values; none where the cell that holds the place has no data.
    ///
    /// ```text
    /// z = z_c + γ·ξ,   γ_x = minmod(z_c − z_west, z_east − z_c)/Δx,   γ_y alike      (M9)
    /// ```
    ///
    /// A plane is exact. Beside an upright step it is level, as far as the step and no further, where a bilinear elevation cuts half of
    /// a cell off what lies below; beside cells without data, too, so that a lake there holds what the cells say. At the edge of the
    /// raster the differences are those on the other side of the cell.
    pub fn mean_preserving_elevation(&self, map: Vec2) -> Option<f64> {
        let Plane { own, east, north, centre } = self.plane_at(map)?;
        let offset = map - centre;
        Some(own + east * offset.x / self.cell_x + north * offset.y / self.cell_y)
    }

    /// Whether a square of a spacing (m) around a place (map) is a cell.
    pub(super) fn has_cell(&self, centre: Vec2, spacing: f64) -> bool {
        let is_near = |a: f64, b: f64| (a - b).abs() <= CENTRE_TOLERANCE * spacing;
        let is_alike = is_near(self.cell_x, spacing) && is_near(self.cell_y, spacing);
        is_alike
            && self.cell_at(centre).is_some_and(|(column, row)| {
                let own = self.centre(column, row);
                is_near(own.x, centre.x) && is_near(own.y, centre.y)
            })
    }

    /// The plane (M9) of the cell that holds a place; none where it has no data.
    pub(super) fn plane_at(&self, map: Vec2) -> Option<Plane> {
        let (column, row) = self.cell_at(map)?;
        let own = self.value(column, row);
        if own.is_nan() {
            return None;
        }
        // A cell without data counts as level with this one.
        let value = |east: isize, south: isize| {
            let (c, r) = (column.checked_add_signed(east)?, row.checked_add_signed(south)?);
            let value = (c < self.columns && r < self.rows).then(|| self.value(c, r))?;
            Some(if value.is_nan() { own } else { value })
        };
        let rise = |east: isize, south: isize| match (value(-east, -south), value(east, south)) {
            (Some(before), Some(after)) => minmod(own - before, after - own),
            (None, Some(after)) => value(2 * east, 2 * south).map_or(0.0, |next| minmod(after - own, next - after)),
            (Some(before), None) => {
                value(-2 * east, -2 * south).map_or(0.0, |next| minmod(own - before, before - next))
            }
            (None, None) => 0.0,
        };
        Some(Plane { own, east: rise(1, 0), north: rise(0, -1), centre: self.centre(column, row) })
    }

    /// The cells whose centres lie within a rectangle (map coordinates), as ranges of columns and rows.
    pub fn cells_within(&self, min: Vec2, max: Vec2) -> (std::ops::Range<usize>, std::ops::Range<usize>) {
        let index = |value: f64, limit: usize| (value.ceil().max(0.0) as usize).min(limit);
        let columns = index((min.x - self.west) / self.cell_x - 0.5, self.columns)
            ..index(((max.x - self.west) / self.cell_x - 0.5).floor() + 1.0, self.columns);
        let rows = index((self.north - max.y) / self.cell_y - 0.5, self.rows)
            ..index(((self.north - min.y) / self.cell_y - 0.5).floor() + 1.0, self.rows);
        (columns, rows)
    }

    /// The rectangle around the cells with data.
    pub fn data_extent(&self) -> Option<Rectangle> {
        let has_data = |row: usize| self.values[row * self.columns..][..self.columns].iter().any(|v| !v.is_nan());
        let first_row = (0..self.rows).find(|&row| has_data(row))?;
        let last_row = (0..self.rows).rfind(|&row| has_data(row))?;
        let (mut first_column, mut last_column) = (self.columns, 0);
        for row in first_row..=last_row {
            let values = &self.values[row * self.columns..][..self.columns];
            let first = values.iter().position(|v| !v.is_nan());
            let last = values.iter().rposition(|v| !v.is_nan());
            first_column = first_column.min(first.unwrap_or(self.columns));
            last_column = last_column.max(last.unwrap_or(0));
        }
        Some(Rectangle {
            low: Vec2::new(
                self.west + first_column as f64 * self.cell_x,
                self.north - (last_row + 1) as f64 * self.cell_y,
            ),
            high: Vec2::new(
                self.west + (last_column + 1) as f64 * self.cell_x,
                self.north - first_row as f64 * self.cell_y,
            ),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane() -> Raster {
        let (columns, rows) = (4, 3);
        let mut raster = Raster {
            columns,
            rows,
            west: 1000.0,
            north: 2000.0,
            cell_x: 10.0,
            cell_y: 20.0,
            values: vec![0.0; columns * rows],
        };
        for row in 0..rows {
            for column in 0..columns {
                let centre = raster.centre(column, row);
                raster.values[row * columns + column] = 0.5 * centre.x - 0.25 * centre.y;
            }
        }
        raster
    }

    #[test]
    fn a_plane_is_met_between_the_centres_and_centres_are_exact() {
        let raster = plane();
        let place = Vec2::new(1012.5, 1973.0);
        assert!((raster.elevation(place).unwrap() - (0.5 * place.x - 0.25 * place.y)).abs() < 1e-10);
        for row in 0..3 {
            for column in 0..4 {
                assert_eq!(raster.elevation(raster.centre(column, row)), Some(raster.value(column, row)));
            }
        }
    }

    #[test]
    fn outside_and_in_holes_there_is_no_elevation_and_beside_them_it_goes_on_as_it_does_on_the_other_side() {
        let mut raster = plane();
        assert_eq!(raster.elevation(Vec2::new(999.9, 1990.0)), None);
        for corner in [Vec2::new(1000.0, 2000.0), Vec2::new(1040.0, 1940.0), Vec2::new(1040.0, 1987.0)] {
            assert!((raster.elevation(corner).unwrap() - (0.5 * corner.x - 0.25 * corner.y)).abs() < 1e-10);
        }
        // Beside a hole it falls as before it, and does not rise.
        let mut torn = plane();
        torn.values[7] = f64::NAN;
        let before = torn.centre(2, 1);
        assert!((torn.elevation(before + Vec2::new(4.0, 0.0)).unwrap() - torn.value(2, 1)).abs() < 1e-12);
        torn.values.iter_mut().for_each(|value| *value = -*value);
        assert!((torn.elevation(before + Vec2::new(4.0, 0.0)).unwrap() - torn.value(2, 1) + 2.0).abs() < 1e-10);
        // Flat beside a step of one cell, and beside a top.
        let mut step = plane();
        step.values[1] -= 50.0;
        let west = step.centre(0, 0) - Vec2::new(4.0, 0.0);
        assert!((step.elevation(west).unwrap() - step.value(0, 0)).abs() < 1e-12);
        raster.values[5] = f64::NAN;
        assert_eq!(raster.elevation(raster.centre(1, 1)), None);
        // Halfway from cell (0, 1) towards the hole in cell (1, 1) only the own cell counts on that row.
        let beside_hole = raster.centre(0, 1) + Vec2::new(4.0, 0.0);
        assert!((raster.elevation(beside_hole).unwrap() - raster.value(0, 1)).abs() < 1e-12);
    }

    #[test]
    fn planes_that_keep_the_means_are_exact_for_a_plane_and_level_beside_a_step_and_a_hole() {
        let mut raster = plane();
        let expected = |place: Vec2| 0.5 * place.x - 0.25 * place.y;
        for corner in [Vec2::new(1000.0, 2000.0), Vec2::new(1040.0, 1940.0), Vec2::new(1017.0, 1981.0)] {
            assert!((raster.mean_preserving_elevation(corner).unwrap() - expected(corner)).abs() < 1e-10);
        }
        assert_eq!(raster.mean_preserving_elevation(Vec2::new(999.9, 1990.0)), None);
        let mean = |raster: &Raster, column: usize, row: usize| {
            let piece = |i: usize| Vec2::new((i % 4) as f64 - 1.5, (i / 4) as f64 - 1.5) * 2.5;
            let at = |i: usize| raster.mean_preserving_elevation(raster.centre(column, row) + piece(i)).unwrap();
            (0..16).map(at).sum::<f64>() / 16.0
        };
        raster.values[5] -= 50.0;
        for (column, row) in [(0, 1), (1, 1), (2, 1), (1, 0)] {
            assert!((mean(&raster, column, row) - raster.value(column, row)).abs() < 1e-10);
        }
        // At the edge of the trench, and all over its bottom.
        let bottom = raster.centre(1, 1);
        assert!(
            (raster.mean_preserving_elevation(bottom + Vec2::new(4.9, 9.9)).unwrap() - raster.value(1, 1)).abs()
                < 1e-10
        );
        raster.values[5] = f64::NAN;
        assert_eq!(raster.mean_preserving_elevation(bottom), None);
        let beside = raster.centre(2, 1);
        assert!(
            (raster.mean_preserving_elevation(beside + Vec2::new(4.0, 0.0)).unwrap() - raster.value(2, 1)).abs()
                < 1e-10
        );
    }

    #[test]
    fn cells_within_a_rectangle_are_those_with_their_centre_in_it() {
        let raster = plane();
        let (columns, rows) = raster.cells_within(Vec2::new(1005.0, 1955.0), Vec2::new(1026.0, 2100.0));
        assert_eq!((columns, rows), (0..3, 0..2));
        let (columns, rows) = raster.cells_within(Vec2::new(0.0, 0.0), Vec2::new(1.0, 1.0));
        assert!(columns.is_empty() || rows.is_empty());
    }

    #[test]
    fn the_extent_of_the_data_leaves_out_empty_edges() {
        let mut raster = plane();
        for column in 0..4 {
            raster.values[column] = f64::NAN;
        }
        for row in 0..3 {
            raster.values[row * 4 + 3] = f64::NAN;
        }
        assert_eq!(
            raster.data_extent(),
            Some(Rectangle { low: Vec2::new(1000.0, 1940.0), high: Vec2::new(1030.0, 1980.0) })
        );
        raster.values.fill(f64::NAN);
        assert_eq!(raster.data_extent(), None);
    }
}
