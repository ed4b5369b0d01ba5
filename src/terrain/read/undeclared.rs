//! Numbers that stand for no data in files which do not say so.

use super::PLAUSIBLE_ELEVATION;

/// Numbers that programs write where there is no data, beside all of more than [`HUGE`] in size.
const MARKS: [f64; 9] = [-9999.0, -99999.0, -32767.0, -32768.0, -999.0, -99.0, 9999.0, 32767.0, 0.0];
const HUGE: f64 = 1e6;
/// A mark is one where all data beside it differ by more than this, in the unit of the file: higher than walls and cliffs all around are.
const APART: f64 = 50.0;

/// Cells with a mark.
#[derive(Debug, PartialEq)]
pub(super) struct Undeclared {
    pub value: f64,
    pub count: usize,
    /// The first of them.
    pub first: usize,
    /// Whether it may be the height of ground on Earth.
    pub is_of_ground: bool,
}

/// Finds the mark that the values of a grid hold most often; `is_out` tells of a cell and its value whether it is known as no data.
pub(super) fn find(
    values: &[f64],
    (columns, rows): (usize, usize),
    is_out: impl Fn(usize, f64) -> bool,
) -> Option<Undeclared> {
    let is_data = |cell: usize| !values[cell].is_nan() && !is_out(cell, values[cell]);
    let beside = |cell: usize| {
        let (column, row) = (cell % columns, cell / columns);
        let sides = [(column > 0, cell.wrapping_sub(1)), (column + 1 < columns, cell + 1)];
        let ends = [(row > 0, cell.wrapping_sub(columns)), (row + 1 < rows, cell + columns)];
        sides.into_iter().chain(ends).filter(|(is_there, _)| *is_there).map(|(_, cell)| cell)
    };
    let mut found: Vec<(f64, Option<Undeclared>)> = Vec::new();
    for (cell, &value) in values.iter().enumerate() {
        let is_huge = value.abs() >= HUGE;
        if !(is_huge || MARKS.contains(&value)) || !is_data(cell) {
            continue;
        }
        let is_of_ground = value == 0.0;
        let seen = match found.iter_mut().position(|(mark, _)| mark.to_bits() == value.to_bits()) {
            Some(place) => &mut found[place].1,
            None => {
                found.push((value, Some(Undeclared { value, count: 0, first: cell, is_of_ground })));
                &mut found.last_mut()?.1
            }
        };
        let Some(mark) = seen else { continue };
        mark.count += 1;
        let near = |other: usize| values[other].to_bits() != value.to_bits() && (values[other] - value).abs() <= APART;
        if beside(cell).any(|other| is_data(other) && near(other)) {
            *seen = None;
        }
    }
    let found = found.into_iter().filter_map(|(_, mark)| mark).max_by_key(|mark| mark.count)?;
    // What most cells have may be the ground, with something high on it.
    if !PLAUSIBLE_ELEVATION.contains(&found.value) {
        return (found.count < values.len()).then_some(found);
    }
    let count = (0..values.len()).filter(|&cell| is_data(cell)).count();
    (2 * found.count < count).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(values: &[f64], columns: usize) -> Option<(f64, usize, usize)> {
        find(values, (columns, values.len() / columns), |_, value| value < -0.5 && value > -1.5)
            .map(|found| (found.value, found.count, found.first))
    }

    #[test]
    fn marks_stand_far_from_all_that_lies_beside_them() {
        let hill = |mark: f64| [700.0, 701.0, 702.0, 700.0, mark, mark, 702.0, 703.0, -1.0];
        for mark in [0.0, -99.0, -999.0, -9999.0, -32767.0, -32768.0, 9999.0, f64::from(f32::MIN), 1e20] {
            assert_eq!(found(&hill(mark), 3), Some((mark, 2, 4)));
        }
        // A number that no program writes for nothing is ground, and so is a shore, a pit of 40 m, and the deep sea.
        assert_eq!(found(&hill(12.0), 3), None);
        assert_eq!(found(&[0.0, 0.0, 3.0, 60.0], 2), None);
        assert_eq!(found(&[0.0, 40.0, 41.0, 60.0], 2), None);
        assert_eq!(found(&[-9998.0, -9999.0, -10_000.0, -9990.0], 2), None);
        // Nor is what is declared a mark, or all of a raster.
        assert_eq!(found(&[-1.0, 700.0, 700.0, 700.0], 2), None);
        assert_eq!(found(&[0.0; 4], 2), None);
        assert_eq!(found(&[-9999.0; 4], 2), None);
        assert_eq!(found(&[-9999.0, -9999.0, -9999.0, 700.0], 2), Some((-9999.0, 3, 0)));
        // A tower on a plain at 0.
        assert_eq!(found(&[0.0, 0.0, 0.0, 0.0, 80.0, 0.0, 0.0, 0.0, 0.0], 3), None);
    }
}
