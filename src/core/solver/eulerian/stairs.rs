//! Walls askew to the lattice, which are stairs on it.
//!
//! Water that runs along such a wall meets each of its steps head on. They are of the lattice and not of the wall, and with the thrust
//! of the mirror problem on all of them the wall would brake it like a saw (decision 0032).

/// An offset (column, row) to a neighbour.
pub(super) type Offset = (isize, isize);

/// The place at an offset (column, row) from a place (row, column).
pub(super) fn beside((row, column): (usize, usize), (dc, dr): Offset) -> (usize, usize) {
    ((row as isize + dr) as usize, (column as isize + dc) as usize)
}

pub(super) fn back((dc, dr): Offset) -> Offset {
    (-dc, -dr)
}

/// A face of a wall: the cell (row, column) before it, the way out of it, and one of the two ways along the wall.
#[derive(Clone, Copy)]
pub(super) struct WallFace {
    pub cell: (usize, usize),
    pub out: Offset,
    pub along: Offset,
}

impl WallFace {
    pub fn new(cell: (usize, usize), out: Offset) -> Self {
        WallFace { cell, out, along: (out.1, out.0) }
    }

    /// The next face on the way along the wall, round a corner where there is one.
    pub fn next(self, is_wall: &impl Fn((usize, usize), Offset) -> bool) -> Option<Self> {
        let WallFace { cell, out, along } = self;
        let ahead = beside(cell, along);
        let next = if is_wall(cell, along) {
            WallFace { cell, out: along, along: back(out) }
        } else if is_wall(ahead, out) {
            WallFace { cell: ahead, ..self }
        } else {
            WallFace { cell: beside(ahead, out), out: back(along), along: out }
        };
        is_wall(next.cell, next.out).then_some(next)
    }

    pub fn turned_back(self) -> Self {
        WallFace { along: back(self.along), ..self }
    }

    /// Whether the wall turns before this face and turns back behind it.
    fn is_step(self, is_wall: &impl Fn((usize, usize), Offset) -> bool) -> bool {
        match (self.next(is_wall), self.turned_back().next(is_wall)) {
            (Some(next), Some(last)) => next.out == last.out && next.out != self.out,
            _ => false,
        }
    }
}

/// Whether a face of a wall belongs to a stair: it is a step of a single face, or there is one near it on the wall.
///
/// - `(cell, out)`: the cell (row, column) before the face, and the way from it to the face
/// - `reach`: faces along the wall, to either side, among which a step makes it a stair
/// - `is_wall`: whether a wall stands before a cell on a way out of it
pub(super) fn is_stair(
    (cell, out): ((usize, usize), Offset),
    reach: usize,
    is_wall: &impl Fn((usize, usize), Offset) -> bool,
) -> bool {
    let face = WallFace::new(cell, out);
    [face, face.turned_back()].into_iter().any(|face| {
        let mut along = std::iter::successors(Some(face), |face| face.next(is_wall)).take(reach + 1);
        along.any(|face| face.is_step(is_wall))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::EulerianConstants;

    /// For each southern face of the water of a plan, row by row from the north, whether it belongs to a stair.
    fn southern_faces(plan: &[&str]) -> String {
        let is_water = |(row, column): (usize, usize)| {
            let line = row.checked_add(1).and_then(|next| plan.get(plan.len().checked_sub(next)?));
            line.and_then(|cells| cells.as_bytes().get(column)) == Some(&b'~')
        };
        let is_wall = |cell: (usize, usize), out: Offset| is_water(cell) && !is_water(beside(cell, out));
        let mut found = String::new();
        for row in (0..plan.len()).rev() {
            for column in (0..plan[0].len()).filter(|&column| is_wall((row, column), (0, -1))) {
                found.push(if is_stair(((row, column), (0, -1)), EulerianConstants::DEFAULT.stair_reach, &is_wall) {
                    '/'
                } else {
                    '_'
                });
            }
        }
        found
    }

    #[test]
    fn walls_askew_are_stairs_and_straight_ones_and_their_corners_are_not() {
        let at_45_degrees = ["~~~~~~~", "~~~~~~#", "~~~~~##", "~~~~###"];
        assert_eq!(southern_faces(&at_45_degrees), "///////");
        let at_18_degrees = ["~~~~~~~~~", "~~~~~~###", "~~~######"];
        assert_eq!(southern_faces(&at_18_degrees), "/////////");
        let one_step = ["~~~~~~~~~~~~~~~~", "~~~#############"];
        assert_eq!(southern_faces(&one_step), "////////_____///");
        let house = ["~~~~~~~~", "~~~##~~~", "~~~##~~~", "~~~~~~~~"];
        assert_eq!(southern_faces(&house), "__________");
        let niche = ["~~~~~~~~~", "##~~~~~##", "##~~~~~##"];
        assert_eq!(southern_faces(&niche), "_________");
    }
}
