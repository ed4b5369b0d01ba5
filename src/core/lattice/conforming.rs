//! Cells that follow lines, in place of some squares of the finest level, and their faces.
//!
//! In the stack of rows they have rows of their own behind those of the finest level ([`super::Nest`]). There they stand on every second
//! place, in odd rows shifted by one, so that no two of them are neighbours in the rows: what joins them are their faces alone.

use crate::math::{Rectangle, Vec2};

/// How far (spacings) beyond the sides of a cell a place still lies in it: the round-off of coordinates.
const EDGE: f64 = 1e-8;

/// What is on one side of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Side {
    /// A cell that follows lines, by its number.
    Cell(usize),
    /// A cell of the lattice that keeps its square, by its index.
    Lattice(usize),
    /// A wall: nothing passes.
    Wall,
    /// The edge of the lattice, or a cell that does not exist.
    Nothing,
}

/// A straight face.
///
/// Side 0 is a cell, or a square before a wall, to the left on the way from `from` to `to`: the normal from side 0 to side 1 points to the
/// right, and the faces of a cell run counter-clockwise around it where it is side 0.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Face {
    /// What is on either side.
    pub sides: [Side; 2],
    /// Where it begins, in local coordinates (m).
    pub from: Vec2,
    /// Where it ends (m).
    pub to: Vec2,
    /// The line on which it lies, by its index in the input.
    pub line: Option<usize>,
}

impl Face {
    /// Its length (m).
    pub fn length(&self) -> f64 {
        (self.to - self.from).norm()
    }

    /// Its middle (m).
    pub fn middle(&self) -> Vec2 {
        (self.from + self.to) * 0.5
    }

    /// The unit normal from side 0 to side 1.
    pub fn normal(&self) -> Vec2 {
        let along = (self.to - self.from) * (1.0 / self.length());
        Vec2::new(along.y, -along.x)
    }
}

/// A cell that replaces cells of the lattice, or parts of them.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Cell {
    /// Centre of gravity, in local coordinates (m).
    pub centre: Vec2,
    /// Area (m²).
    pub area: f64,
    /// The convex polygons of which it consists, counter-clockwise, without gaps and overlaps (m).
    pub parts: Vec<Vec<Vec2>>,
}

/// All cells that follow lines.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Conforming {
    cells: Vec<Cell>,
    faces: Vec<Face>,
    /// The squares that are no longer there, ascending, and the cell that holds the centre of each.
    replaced: Vec<(usize, Option<usize>)>,
    /// Square, cell and its part, of all that overlap, ascending.
    overlaps: Vec<(u32, u32, u32)>,
    spacing: f64,
    columns: usize,
    /// The first of their rows in the stack.
    first_row: usize,
}

impl Conforming {
    /// The cells on a lattice of so many columns, rows and metres of spacing, in the squares of which `replaced` are no longer there.
    pub fn new(
        (columns, rows, spacing): (usize, usize, f64),
        (cells, faces): (Vec<Cell>, Vec<Face>),
        replaced: &[usize],
    ) -> Self {
        let mut overlaps = Vec::new();
        let square = |place: f64, count: usize| ((place / spacing).max(0.0) as usize).min(count.saturating_sub(1));
        for (number, cell) in cells.iter().enumerate() {
            for (part, corners) in cell.parts.iter().enumerate() {
                let Some(Rectangle { low, high }) = Rectangle::about(corners.iter().copied()) else { continue };
                for row in square(low.y, rows)..=square(high.y, rows) {
                    let of_row = square(low.x, columns)..=square(high.x, columns);
                    overlaps.extend(of_row.map(|column| ((row * columns + column) as u32, number as u32, part as u32)));
                }
            }
        }
        overlaps.sort_unstable();
        let mut conforming =
            Conforming { cells, faces, replaced: Vec::new(), overlaps, spacing, columns, first_row: 0 };
        let centre =
            |square: usize| Vec2::new((square % columns) as f64 + 0.5, (square / columns) as f64 + 0.5) * spacing;
        conforming.replaced =
            replaced.iter().map(|&square| (square, conforming.cell_at(square, centre(square)))).collect();
        conforming
    }

    /// The same with its rows from a row of the stack on.
    #[must_use]
    pub(super) fn beginning_at(self, first_row: usize) -> Self {
        Conforming { first_row, ..self }
    }

    /// The cells, by number.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// Their faces.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// Their rows in the stack.
    pub fn rows(&self) -> std::ops::Range<usize> {
        self.first_row..self.first_row + self.cells.len().div_ceil(self.in_a_row())
    }

    fn in_a_row(&self) -> usize {
        (self.columns / 2).max(1)
    }

    /// The place in the stack of a cell.
    pub fn place(&self, number: usize) -> usize {
        let row = number / self.in_a_row();
        (self.first_row + row) * self.columns + 2 * (number % self.in_a_row()) + row % 2
    }

    /// The places in the stack of all cells, by number.
    pub fn places(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.cells.len()).map(|number| self.place(number))
    }

    /// The cell that stands at a place of the stack.
    pub fn number_at(&self, place: usize) -> Option<usize> {
        let (column, row) = (place % self.columns, (place / self.columns).checked_sub(self.first_row)?);
        let column = column.checked_sub(row % 2)?;
        let number = row * self.in_a_row() + column / 2;
        (column.is_multiple_of(2) && column / 2 < self.in_a_row() && number < self.cells.len()).then_some(number)
    }

    /// Whether a square is no longer there, and which cell holds its centre.
    #[inline]
    pub fn instead_of(&self, square: usize) -> Option<Option<usize>> {
        let found = self.replaced.binary_search_by_key(&square, |(square, _)| *square);
        found.ok().map(|found| self.replaced[found].1)
    }

    /// Of each square that is no longer there the cell that holds its centre.
    pub fn standing_in(&self) -> impl Iterator<Item = usize> + '_ {
        self.replaced.iter().filter_map(|(_, cell)| *cell)
    }

    /// The cell that holds a place (local coordinates, m) in a square; a place on a face belongs to one of its two cells.
    pub fn cell_at(&self, square: usize, place: Vec2) -> Option<usize> {
        let first = self.overlaps.partition_point(|(known, ..)| (*known as usize) < square);
        let within = self.overlaps[first..].iter().take_while(|(known, ..)| *known as usize == square);
        let depth = |&(_, cell, part): &(u32, u32, u32)| {
            (depth_within(&self.cells[cell as usize].parts[part as usize], place), cell as usize)
        };
        let deepest = within.map(depth).reduce(|best, other| if other.0 > best.0 { other } else { best })?;
        (deepest.0 >= -EDGE * self.spacing).then_some(deepest.1)
    }
}

/// Distance of a place from the nearest side of a polygon; below 0 outside.
///
/// Short sides may turn inward by the round-off, so that a place counts as inside by the sides north of it that it lies between.
pub fn depth_within(corners: &[Vec2], place: Vec2) -> f64 {
    let (mut distance, mut is_inside) = (f64::INFINITY, false);
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let along = b - a;
        let share = ((place - a).dot(along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        distance = distance.min((a + along * share - place).norm());
        if (a.x > place.x) != (b.x > place.x) {
            let y = a.y + (b.y - a.y) * ((place.x - a.x) / (b.x - a.x));
            is_inside ^= y > place.y;
        }
    }
    if is_inside { distance } else { -distance }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_in_the_stack_are_found_again_and_never_neighbours() {
        let cell = Cell { centre: Vec2::ZERO, area: 1.0, parts: Vec::new() };
        for columns in [2, 3, 8, 9] {
            let made = Conforming::new((columns, 4, 1.0), (vec![cell.clone(); 23], Vec::new()), &[]).beginning_at(6);
            let places: Vec<usize> = (0..23).map(|number| made.place(number)).collect();
            for (number, &place) in places.iter().enumerate() {
                assert_eq!(made.number_at(place), Some(number));
                let is_neighbour = |other: &usize| {
                    let apart = place.abs_diff(*other);
                    apart == columns || apart == 1 && place / columns == other / columns
                };
                assert!(made.rows().contains(&(place / columns)) && !places.iter().any(is_neighbour));
            }
            let found = (0..made.rows().end * columns).filter(|&place| made.number_at(place).is_some());
            assert_eq!(found.count(), 23);
        }
    }

    #[test]
    fn a_place_is_found_in_the_part_that_holds_it() {
        let square = |x: f64, width: f64| {
            [(x, 0.0), (x + width, 0.0), (x + width, 1.0), (x, 1.0)].map(|(x, y)| Vec2::new(x, y)).to_vec()
        };
        let cell = |x: f64, width: f64| Cell {
            centre: Vec2::new(x + 0.5 * width, 0.5),
            area: width,
            parts: vec![square(x, width)],
        };
        let made = Conforming::new((2, 1, 1.0), (vec![cell(0.0, 0.7), cell(0.7, 1.3)], Vec::new()), &[0, 1]);
        assert_eq!((made.instead_of(0), made.instead_of(1), made.instead_of(2)), (Some(Some(0)), Some(Some(1)), None));
        assert_eq!(made.cell_at(0, Vec2::new(0.8, 0.5)), Some(1));
        assert_eq!(made.cell_at(0, Vec2::new(-0.1, 0.5)), None);
    }
}
