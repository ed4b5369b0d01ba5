//! Morphology of fields of pixels by squares: erosion, dilation, opening, closing.
//!
//! A square is two runs, one along the rows and one along the columns, and the best of each run comes from the best to and from the
//! ends of blocks, whatever its width: three comparisons for each pixel. Whole rows are compared at a time; for the other direction the field is
//! turned. Method: `vanHerk1992`; openings and closings: `Soille2004`.

use crate::math::{larger, smaller};

/// Pixels along a side of the squares in which a field is turned.
const TURNED: usize = 16;

/// A field of pixels, row by row from the north.
pub(super) struct Field<T> {
    pub columns: usize,
    pub values: Vec<T>,
}

impl<T: Copy> Field<T> {
    fn rows(&self) -> usize {
        self.values.len() / self.columns.max(1)
    }

    /// The best of each square of a width (pixels), then for each pixel the other best of all squares that hold it.
    ///
    /// - `outside`: the value of all pixels beyond the field
    pub fn by_squares(
        &self,
        width: usize,
        outside: T,
        of_square: impl Fn(T, T) -> T,
        of_squares: impl Fn(T, T) -> T,
    ) -> Self {
        let around = width - 1;
        let columns = self.columns + 2 * around;
        let mut padded = Field { columns, values: vec![outside; columns * (self.rows() + 2 * around)] };
        for (row, values) in self.values.chunks(self.columns).enumerate() {
            padded.values[(row + around) * columns + around..][..values.len()].copy_from_slice(values);
        }
        // Along the columns, along the rows, and back.
        let along_columns = padded.runs(width, &of_square);
        let of_squares_turned = along_columns.turned().runs(width, &of_square).runs(width, &of_squares);
        of_squares_turned.turned().runs(width, &of_squares)
    }

    /// The best of each run of so many pixels in a column.
    fn runs(&self, width: usize, best: &impl Fn(T, T) -> T) -> Self {
        let (columns, rows) = (self.columns, self.rows());
        let row = |row: usize| &self.values[row * columns..][..columns];
        let mut values: Vec<T> = Vec::with_capacity((rows + 1 - width) * columns);
        let mut both = |one: &[T], other: &[T]| values.extend(one.iter().zip(other).map(|(a, b)| best(*a, *b)));
        // The best from each row of a block of the width to its end, and from the start of the next block to a row.
        let mut from: Vec<T> = vec![self.values[0]; width * columns];
        let mut to: Vec<T> = vec![self.values[0]; columns];
        for first in (0..rows + 1 - width).step_by(width) {
            from[(width - 1) * columns..].copy_from_slice(row(first + width - 1));
            for k in (0..width - 1).rev() {
                let (own, next) = from[k * columns..].split_at_mut(columns);
                let pixels = own.iter_mut().zip(&next[..columns]).zip(row(first + k));
                pixels.for_each(|((from, next), own)| *from = best(*own, *next));
            }
            // The first run is the block itself.
            both(&from[..columns], &from[..columns]);
            for k in 1..width.min(rows + 1 - width - first) {
                let next = row(first + width + k - 1);
                if k == 1 {
                    to.copy_from_slice(next);
                } else {
                    to.iter_mut().zip(next).for_each(|(to, next)| *to = best(*to, *next));
                }
                both(&from[k * columns..][..columns], &to);
            }
        }
        Field { columns, values }
    }

    /// The field with its rows as columns.
    fn turned(&self) -> Self {
        let (columns, rows) = (self.columns, self.rows());
        let mut values = vec![self.values[0]; columns * rows];
        for (row, column) in
            (0..rows).step_by(TURNED).flat_map(|row| (0..columns).step_by(TURNED).map(move |column| (row, column)))
        {
            for column in column..(column + TURNED).min(columns) {
                for row in row..(row + TURNED).min(rows) {
                    values[column * rows + row] = self.values[row * columns + column];
                }
            }
        }
        Field { columns: rows, values }
    }
}

impl Field<f64> {
    /// Elevations (m) without what is narrower than two cells of a width (pixels).
    pub fn without_ridges(&self, width: usize) -> Self {
        self.by_squares(2 * width, f64::INFINITY, smaller, larger)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { rng_algorithm: prop::test_runner::RngAlgorithm::ChaCha, failure_persistence: None, ..ProptestConfig::with_cases(200) })]

        #[test]
        fn the_best_of_squares_is_that_of_their_pixels(
            columns in 1usize..9, rows in 1usize..9, width in 1usize..5, seed in 0usize..1000,
        ) {
            let values: Vec<f64> = (0..columns * rows).map(|k| ((k + seed) as f64 * 12.9898).sin() * 10.0).collect();
            let field = Field { columns, values };
            let at = |row: isize, column: isize| {
                let is_in = row >= 0 && column >= 0 && row < rows as isize && column < columns as isize;
                if is_in { field.values[row as usize * columns + column as usize] } else { f64::INFINITY }
            };
            let span = || 0..width as isize;
            let lowest = |row: isize, column: isize| {
                let pixels = span().flat_map(|r| span().map(move |c| (r, c)));
                pixels.map(|(r, c)| at(row + r, column + c)).fold(f64::INFINITY, f64::min)
            };
            let opened = field.by_squares(width, f64::INFINITY, f64::min, f64::max);
            prop_assert_eq!(opened.columns, columns);
            for row in 0..rows as isize {
                for column in 0..columns as isize {
                    let squares = span().flat_map(|r| span().map(move |c| (r, c)));
                    let expected = squares.map(|(r, c)| lowest(row - r, column - c)).fold(f64::NEG_INFINITY, f64::max);
                    prop_assert_eq!(opened.values[row as usize * columns + column as usize].to_bits(), expected.to_bits());
                }
            }
        }
    }
}
