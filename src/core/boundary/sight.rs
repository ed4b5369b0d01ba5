//! What a wall hides from a place.

use super::edge::Edge;
use super::wall::Walls;
use crate::lattice::Lattice;
use crate::math::Vec2;

/// A wall as it stands before a place.
pub(super) struct WallBefore {
    place: Vec2,
    start: Vec2,
    piece: Vec2,
    length_squared: f64,
    /// Margin times length (m²).
    stretch: f64,
    own_turn: f64,
    /// Where the place lies along the wall (m²).
    along: f64,
}

impl WallBefore {
    /// The ends of the wall are stretched by `margin` (m).
    #[inline(always)]
    pub(super) fn new(place: Vec2, edge: &Edge, margin: f64) -> Self {
        let (start, piece) = (edge.start, edge.end - edge.start);
        let own_turn = piece.x * (place.y - start.y) - piece.y * (place.x - start.x);
        let along = piece.x * (place.x - start.x) + piece.y * (place.y - start.y);
        let length_squared = piece.norm_squared();
        WallBefore { place, start, piece, length_squared, stretch: margin * length_squared.sqrt(), own_turn, along }
    }

    /// Positive where (x, y) lies on the side of the place, negative beyond the line of the wall.
    #[inline(always)]
    pub(super) fn side(&self, x: f64, y: f64) -> f64 {
        self.own_turn * self.turn(x, y)
    }

    #[inline(always)]
    fn turn(&self, x: f64, y: f64) -> f64 {
        self.piece.x * (y - self.start.y) - self.piece.y * (x - self.start.x)
    }

    /// Whether the straight way to (x, y) goes through the wall; see `Edge::crossing`.
    #[inline(always)]
    pub(super) fn is_on_the_way(&self, x: f64, y: f64) -> bool {
        let (to_x, to_y) = (x - self.place.x, y - self.place.y);
        let share = self.own_turn / (self.own_turn - self.turn(x, y));
        let along = self.along + (self.piece.x * to_x + self.piece.y * to_y) * share;
        (self.side(x, y) < 0.0) & (along >= -self.stretch) & (along <= self.length_squared + self.stretch)
    }
}

impl Walls {
    /// Sets the numbers of those cells to zero that a wall among the edges `near` hides from a place; open edges hide nothing.
    ///
    /// - `first`: column and row of the first cell
    /// - `numbers`: those of the first cell and of the cells that follow in its row
    pub fn hide(&self, near: &[u32], from: Vec2, lattice: &Lattice, first: (usize, usize), numbers: &mut [f32]) {
        for edge in near.iter().map(|&member| &self.edges()[member as usize]).filter(|edge| !edge.is_open) {
            hide(&WallBefore::new(from, edge, self.margin()), lattice.spacing, first, numbers);
        }
    }
}

#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn hide(wall: &WallBefore, spacing: f64, (column, row): (usize, usize), numbers: &mut [f32]) {
    let y = (row as f64 + 0.5) * spacing;
    for (k, number) in numbers.iter_mut().enumerate() {
        // Whole numbers of four bytes become floating in one instruction.
        let x = (f64::from((column + k) as u32) + 0.5) * spacing;
        *number = if wall.is_on_the_way(x, y) { 0.0 } else { *number };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hides_what_ways_cannot_reach() {
        let lattice = Lattice::new(Vec2::ZERO, 12, 9, 0.7);
        let edge = |x0: f64, y0: f64, x1: f64, y1: f64, is_open: bool| Edge {
            start: Vec2::new(x0, y0),
            end: Vec2::new(x1, y1),
            is_open,
        };
        let edges = vec![
            edge(2.1, 0.3, 3.3, 4.9, false),
            edge(3.3, 4.9, 7.0, 5.1, false),
            edge(0.0, 3.0, 2.0, 3.1, true),
            edge(5.0, 0.0, 5.0, 1.4, false),
        ];
        let walls = Walls::new(edges, lattice.spacing);
        let near: Vec<u32> = (0..walls.edges().len() as u32).collect();
        let mut counts = [0, 0];
        for from in [Vec2::new(0.9, 1.7), Vec2::new(4.05, 2.3), Vec2::new(6.6, 6.1)] {
            for row in 0..lattice.rows {
                let mut numbers = vec![1.5; lattice.columns - 1];
                walls.hide(&near, from, &lattice, (1, row), &mut numbers);
                for (k, number) in numbers.into_iter().enumerate() {
                    let is_walled = walls.is_walled(from, lattice.centre(lattice.index(k + 1, row)));
                    let is_hidden = number < 1.5;
                    assert_eq!(is_hidden, is_walled, "cell {} of row {row} from {from:?}", k + 1);
                    counts[usize::from(is_walled)] += 1;
                }
            }
        }
        assert!(counts.iter().all(|&count| count > 50), "{counts:?}");
    }
}
