//! How much of a cell its walls close: what thrust they have, and which step the cell takes.
//!
//! A wall that closes a cell across is the mirror problem: it throws waves back. A post that is small against its cell, or one of two walls
//! between which the cell lies, throws back none; as a mirror it would hold up the whole cell, with d c u for d u²/2:
//!
//! ```text
//! (M100)  T = w T_mirror + (1 − w) ½ d |v| (v·n)     w = clamp(2 φ − 1, 0, 1),   φ = (Σ_walls l_k n_k·n) / (½ Σ_faces l_k |n_k·n|)
//!         Δt ≤ CFL Δ/(μ (|v| + c))                        μ = max(1, p/(4 A)),        p = max(Σ_open l_k, 4/3 λ(Σ_faces a_k l_k n_k n_kᵀ))
//! ```
//!
//! with the normal n of the wall away from the cell, lengths and areas in spacings, λ the greater eigenvalue and a_k = 1 for open faces,
//! ¼ (1 + 3 w_k) for walls; where no face is open μ is 1. A ring of walls within a cell has the drag of a square post, C_D = 2. The step is
//! that of the perimeter where no walls are; walls count by what they take from the momentum.

use crate::math::Vec2;
use crate::solver::eulerian::general_faces::Seen;
use crate::solver::eulerian::walls::mirrored;

/// Ratio of the greatest rate at which momentum is taken to the one that doubles a step's change of sign.
const MARGIN: f64 = 4.0 / 3.0;

/// What a wall that throws nothing back counts of one that does.
const OF_DRAG: f64 = 0.25;

/// The normal momentum that a particle loses to a wall, beyond the pressure of still water (M100).
///
/// - `normal`: away from the cell
/// - `closes`: w
pub(super) fn thrust(here: Seen, normal: Vec2, closes: f64, g: f64) -> f64 {
    let velocity = Vec2::new(here.u, here.v);
    let towards = velocity.dot(normal);
    let drag = 0.5 * here.depth * velocity.norm() * towards;
    closes * mirrored(here.depth, towards, g) + (1.0 - closes) * drag
}

/// The faces of a cell: each normal away from it times the length, and whether it is a wall.
#[derive(Clone, Debug, Default)]
pub(in crate::solver::eulerian) struct Shape(Vec<(Vec2, bool)>);

impl Shape {
    /// Takes in a face by its normal away from the cell and its length.
    pub fn add(&mut self, normal: Vec2, length: f64, is_wall: bool) {
        self.0.push((normal * length, is_wall));
    }

    /// w of (M100) for a wall with a normal away from the cell.
    pub fn closes(&self, normal: Vec2) -> f64 {
        let walls: f64 = self.0.iter().filter(|(_, is_wall)| *is_wall).map(|(face, _)| face.dot(normal)).sum();
        let width: f64 = self.0.iter().map(|(face, _)| 0.5 * face.dot(normal).abs()).sum();
        (2.0 * walls / width - 1.0).clamp(0.0, 1.0)
    }

    /// μ of (M100) with the area of the cell, both in the same unit of length.
    pub fn haste(&self, area: f64, spacing: f64) -> f64 {
        let (mut open, mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0, 0.0);
        for &(face, is_wall) in &self.0 {
            let length = face.norm();
            if length <= 0.0 {
                continue;
            }
            open += if is_wall { 0.0 } else { length };
            let weight = if is_wall { OF_DRAG + (1.0 - OF_DRAG) * self.closes(face / length) } else { 1.0 };
            xx += weight * face.x * face.x / length;
            xy += weight * face.x * face.y / length;
            yy += weight * face.y * face.y / length;
        }
        // Nothing moves where nothing gets in or out.
        if open <= 0.0 {
            return 1.0;
        }
        let greatest = 0.5 * (xx + yy) + (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt();
        (open.max(MARGIN * greatest) * spacing / (4.0 * area)).max(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(walls: [bool; 4], ring: f64) -> Shape {
        let mut shape = Shape::default();
        let normals = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)].map(|(x, y)| Vec2::new(x, y));
        normals.into_iter().zip(walls).for_each(|(normal, is_wall)| shape.add(normal, 1.0, is_wall));
        normals.into_iter().for_each(|normal| shape.add(normal, ring, true));
        shape
    }

    #[test]
    fn a_wall_across_a_cell_is_a_mirror_and_a_post_in_it_is_none() {
        let east = Vec2::new(1.0, 0.0);
        let closes = |walls: [bool; 4], ring: f64| shape(walls, ring).closes(east);
        assert!((closes([true, false, false, false], 0.0) - 1.0).abs() < 1e-15);
        assert!(closes([true, true, false, false], 0.0).abs() < 1e-15, "between two walls");
        assert!(closes([false; 4], 0.3).abs() < 1e-15, "a post");
        let mut half = Shape::default();
        [(1.0, 0.7, true), (1.0, 0.3, false), (-1.0, 1.0, false)]
            .into_iter()
            .for_each(|(side, length, is_wall)| half.add(east * side, length, is_wall));
        assert!((half.closes(east) - 0.4).abs() < 1e-15);
    }

    #[test]
    fn walls_that_throw_nothing_back_hardly_shorten_the_step() {
        assert!((shape([false; 4], 0.0).haste(1.0, 1.0) - 1.0).abs() < 1e-15);
        assert!((shape([true, false, false, false], 0.0).haste(1.0, 1.0) - 1.0).abs() < 1e-15);
        // A small cell, and a long slit that opens into a cell.
        assert!((shape([false; 4], 0.0).haste(0.5, 1.0) - 2.0).abs() < 1e-15);
        let mut slit = shape([false; 4], 0.0);
        [1.0, -1.0].into_iter().for_each(|side| slit.add(Vec2::new(0.0, side), 5.0, true));
        assert!(slit.haste(1.05, 1.0) < 1.5, "{}", slit.haste(1.05, 1.0));
    }
}
