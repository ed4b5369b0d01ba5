//! How much of the faces beside a stair counts, so that water runs along the wall as if it were straight (decision 0033).
//!
//! Uniform flow along a wall askew to the lattice does not fit its stair: what comes along a tread must go up before the step that ends
//! it, and loses its way and its momentum there. It fits when the faces are as long as the wall leaves them. With the line
//! y = y_0 + y′ x of the wall over a tread, in cells from the middle of its cell's face, 0 < y′ ≤ 1, the face at x of the lowest cell, that of
//! the cell above it, and the one between both count
//!
//! ```text
//! (M30)  w_1 = min(y_s, 2 y′ r),   w_2 = 1 + y_s − w_1,   w_3 = (w_1(−½) − w_1(½))/y′,   y_s = 1 − y_0 − y′ x
//! ```
//!
//! y_s is the height from the wall to the top of the lowest cell, r that many cells along to the step, where w_1 is 0. Then as much leaves each of
//! these cells as comes to it with a velocity along the line: w_3, and w_1 + w_2 = 1 + y_s. The cell has its own area, as the cells that a wall
//! cuts have in the mean. By the bound with r the lowest cells give their water to the ones above in time, so that no face
//! counts more than twice; without it w_3 is 1/(2 y′) at the step.

use super::stairs::{Offset, WallFace, back, beside};
use crate::constants::EulerianConstants;

/// What a stair makes of a face between two particles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aperture {
    /// One of the two cells (row, column), and the way from it to the other.
    pub cell: (usize, usize),
    pub way: Offset,
    /// Whether the wall lies to the north of a face between cells of a row, to the east of one between cells of a column.
    pub is_wall_beyond: bool,
    pub share: f64,
}

/// The line of a wall beside one of its faces, in cells from the middle of the face: along the wall, and into the water.
struct Line {
    height: f64,
    slope: f64,
}

impl Line {
    /// The line of regression through the middles of the faces on both sides that look the same way: as many on each as make a stair, or as many
    /// as there are and as lie near it.
    fn fit(
        face: WallFace,
        constants: &EulerianConstants,
        is_wall: &impl Fn((usize, usize), Offset) -> bool,
    ) -> Option<Self> {
        let longest = constants.stair_reach;
        let on_side = |start: WallFace| -> Vec<(f64, f64)> {
            let chain = std::iter::successors(Some(start), |face| face.next(is_wall)).skip(1).take(3 * longest);
            let onward = chain.take_while(|next| next.out != back(face.out));
            let alike = onward.filter(|next| next.out == face.out).take(longest);
            alike.map(|next| offset(face, next.cell)).collect()
        };
        let sides = [on_side(face), on_side(face.turned_back())];
        (2..=longest).rev().find_map(|reach| {
            let points = || sides.iter().flat_map(|side| side.iter().take(reach)).copied().chain([(0.0, 0.0)]);
            let sum = |value: &dyn Fn((f64, f64)) -> f64| points().map(value).sum::<f64>();
            let count = sum(&|_| 1.0);
            if count < constants.aperture_faces as f64 {
                return None;
            }
            let (x, y) = (sum(&|point| point.0) / count, sum(&|point| point.1) / count);
            let slope = sum(&|point| (point.0 - x) * (point.1 - y)) / sum(&|point| (point.0 - x) * (point.0 - x));
            let line = Line { height: y - slope * x, slope };
            points().all(|(x, y)| (y - line.height - slope * x).abs() < constants.aperture_distance).then_some(line)
        })
    }
}

/// Where a cell lies as seen from the one before a face (cells along the wall, and into the water).
fn offset(face: WallFace, (row, column): (usize, usize)) -> (f64, f64) {
    let (dc, dr) = (column as isize - face.cell.1 as isize, row as isize - face.cell.0 as isize);
    let towards = |way: Offset| (dc * way.0 + dr * way.1) as f64;
    (towards(face.along), -towards(face.out))
}

/// The apertures (M30) beside a face of a stair: none where its line is steeper than 45° as seen from this face, which those of the faces across
/// then know, or where the water is a cell wide.
///
/// - `(cell, out)`: the cell (row, column) before the face, and the way from it to the face
/// - `is_wall`: whether a wall stands before a cell on a way out of it
pub(super) fn apertures(
    (cell, out): ((usize, usize), Offset),
    constants: &EulerianConstants,
    is_wall: &impl Fn((usize, usize), Offset) -> bool,
) -> Vec<Aperture> {
    let face = WallFace::new(cell, out);
    let Some(line) = Line::fit(face, constants, is_wall) else { return Vec::new() };
    let (rising, slope) = if line.slope > 0.0 { (face.along, line.slope) } else { (back(face.along), -line.slope) };
    let (falling, inwards) = (back(rising), back(out));
    if slope <= 0.0 || slope > 1.0 || is_wall(cell, falling) || is_wall(cell, inwards) {
        return Vec::new();
    }
    let tread = std::iter::successors(Some(cell), |&cell| Some(beside(cell, rising))).take(2 * constants.stair_reach);
    let before_step = tread.take_while(|&cell| is_wall(cell, out)).position(|cell| is_wall(cell, rising));
    let widest = constants.aperture_widest;
    let shares = |x: f64| {
        let height = (1.0 - line.height - slope * x).clamp(0.0, widest);
        let to_step = before_step.map_or(f64::INFINITY, |cells| cells as f64 + 0.5 - x);
        let own = height.min(widest * slope * to_step);
        (own, 1.0 + height - own)
    };
    let ((own_behind, above_behind), (own_ahead, above_ahead)) = (shares(-0.5), shares(0.5));
    let upwards = ((own_behind - own_ahead) / slope).clamp(0.0, widest);
    let above = beside(cell, inwards);
    [
        (cell, falling, out, own_behind),
        (cell, rising, out, own_ahead),
        (above, falling, out, above_behind),
        (above, rising, out, above_ahead),
        (cell, inwards, rising, upwards),
    ]
    .into_iter()
    .filter(|&(cell, way, ..)| !is_wall(cell, way))
    .map(|(cell, way, wall, share)| Aperture { cell, way, is_wall_beyond: wall.0 + wall.1 > 0, share })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::super::stairs::is_stair;
    use super::*;

    const AS_THEY_ARE: &EulerianConstants = &EulerianConstants::DEFAULT;

    fn apertures(
        cell: (usize, usize),
        out: Offset,
        is_wall: &impl Fn((usize, usize), Offset) -> bool,
    ) -> Vec<Aperture> {
        super::apertures((cell, out), AS_THEY_ARE, is_wall)
    }

    /// A wall that rises by `slope` cells a cell: the southern edge of the water, of which all cells north of it with their middle above the line.
    fn wall(slope: f64) -> impl Fn((usize, usize), Offset) -> bool {
        let is_water = move |(row, column): (usize, usize)| row as f64 > 10.0 + slope * (column as f64 + 0.3);
        move |cell, out| is_water(cell) && !is_water(beside(cell, out))
    }

    /// The shares of the faces of a cell to the east, west, north and south, as the faces of the wall between some columns give them.
    fn shares((row, column): (usize, usize), is_wall: &impl Fn((usize, usize), Offset) -> bool) -> [f64; 4] {
        let mut found = Vec::new();
        for column in column - 3..=column + 3 {
            for row in row - 4..=row + 4 {
                for out in [(0, -1), (1, 0), (-1, 0)] {
                    if is_wall((row, column), out) && is_stair(((row, column), out), AS_THEY_ARE.stair_reach, is_wall) {
                        found.extend(apertures((row, column), out, is_wall));
                    }
                }
            }
        }
        [(1, 0), (-1, 0), (0, 1), (0, -1)].map(|way| {
            let there = beside((row, column), way);
            if is_wall((row, column), way) {
                return 0.0;
            }
            let at_face = found.iter().filter(|part| {
                part.cell == (row, column) && part.way == way || part.cell == there && part.way == back(way)
            });
            let shares: Vec<f64> = at_face.map(|part| part.share).collect();
            if shares.is_empty() { 1.0 } else { shares.iter().sum::<f64>() / shares.len() as f64 }
        })
    }

    #[test]
    fn as_much_leaves_a_cell_beside_a_stair_as_comes_to_it_along_the_wall() {
        for slope in [0.1, 0.25, 0.4, 0.577, 0.8, 1.0] {
            let is_wall = wall(slope);
            for column in 40..60 {
                let lowest = (0..200).find(|&row| is_wall((row, column), (0, -1))).expect("a wall below each column");
                for row in lowest..lowest + 4 {
                    let [east, west, north, south] = shares((row, column), &is_wall);
                    // Without apertures 1 or the slope.
                    let gain = (west - east) + slope * (south - north);
                    assert!(gain.abs() < 0.2, "slope {slope}, column {column}, row {row}: {gain}");
                    assert!(
                        [east, west, north, south]
                            .iter()
                            .all(|share| (0.0..=AS_THEY_ARE.aperture_widest).contains(share))
                    );
                }
            }
        }
    }

    #[test]
    fn a_straight_wall_has_no_apertures() {
        let is_wall = wall(0.0);
        assert!(apertures((11, 50), (0, -1), &is_wall).is_empty());
    }

    #[test]
    fn the_corner_of_a_house_and_water_a_cell_wide_have_no_apertures() {
        let is_water = |(row, column): (usize, usize)| row > 10 || column < 20;
        let is_wall = |cell: (usize, usize), out: Offset| is_water(cell) && !is_water(beside(cell, out));
        assert!(apertures((11, 20), (0, -1), &is_wall).is_empty() && apertures((10, 19), (1, 0), &is_wall).is_empty());
        let alley = |(row, column): (usize, usize)| row == 10 + column / 2;
        let is_wall = |cell: (usize, usize), out: Offset| alley(cell) && !alley(beside(cell, out));
        assert!(apertures((30, 41), (0, -1), &is_wall).is_empty());
    }
}
