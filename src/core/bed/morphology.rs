//! Morphology of fields of pixels by squares: erosion, dilation, opening, closing.
//!
//! A square is two runs, one along the rows and one along the columns, and the best of each run comes from the best to and from the
//! ends of blocks, whatever its width: three comparisons for each pixel. Method: `vanHerk1992`; openings and closings: `Soille2004`.

use crate::math::{larger, smaller};

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
        for _ in 0..2 {
            padded = padded.run(width, &of_square);
        }
        for _ in 0..2 {
            padded = padded.run(width, &of_squares);
        }
        padded
    }

    /// The best of each run of so many pixels in a row, transposed.
    fn run(&self, width: usize, best: &impl Fn(T, T) -> T) -> Self {
        let (columns, rows) = (self.columns, self.rows());
        let count = columns + 1 - width;
        let mut values: Vec<T> = vec![self.values[0]; count * rows];
        // The best from the start of a block of the width to a pixel, and from a pixel to the end of its block.
        let mut to = vec![self.values[0]; columns];
        let mut from = to.clone();
        for (row, line) in self.values.chunks(columns).enumerate() {
            for k in 0..columns {
                to[k] = if k % width == 0 { line[k] } else { best(to[k - 1], line[k]) };
            }
            for k in (0..columns).rev() {
                from[k] = if (k + 1) % width == 0 || k + 1 == columns { line[k] } else { best(line[k], from[k + 1]) };
            }
            for k in 0..count {
                values[k * rows + row] = best(from[k], to[k + width - 1]);
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
