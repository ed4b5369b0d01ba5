//! The water beyond a corner where two open boundaries meet: that beyond the one and beyond the other, going on.
//!
//! Beyond such a corner lies a wedge that no row of buffer particles reaches. Empty, it is a free edge to the particles before it: they
//! leave into it, and those left behind are thought to stand too far apart. A particle of it belongs to one row of either face,
//!
//! ```text
//! (M69)  x_c = x_0 + ρ_1 n_1 + ρ_2 n_2,   A_c = l_1 l_2 |n_1 × n_2|,   η_c = (η_1 + η_2)/2,   d_c = (d_1 + d_2)/2
//!        v_c = v_0 + ½ Σ_k ∇v_k·(x_c − x_k),   v_0·n_k = v_k·n_k
//! ```
//!
//! with x_0 the corner, n_1 and n_2 the normals outwards, ρ_1 and ρ_2 the distances of both rows from their faces, l_1 and l_2 their lengths,
//! v_k the velocity beyond either face, ∇v_k its gradient, x_k the middle of the face, and η_k by (M67) at x_c. They carry no water: they are made anew for every evaluation and never come in.

use super::faces::Face;
use super::{Beyond, BufferParticle};
use crate::bed::BedPoint;
use crate::math::Vec2;
use crate::particles::Particle;
use crate::physics::dimension::Dimension;
use crate::solver::moving::smoothing_factor;

/// n_1 × n_2 from which on a corner is filled, a turn of 30 degrees: beyond a flatter one there is no room for a particle.
const SHARP: f64 = 0.5;

/// A corner of the terrain between two faces.
#[derive(Debug)]
struct Corner {
    place: Vec2,
    faces: [usize; 2],
    /// n_1 × n_2.
    turn: f64,
    /// Distances (m) of the rows from either face, and their lengths (m).
    rows: [Vec<(f64, f64)>; 2],
}

/// All such corners.
#[derive(Debug, Default)]
pub(super) struct Corners {
    corners: Vec<Corner>,
    /// Of each face the corners that it ends in, and which of their two faces it is.
    of_face: Vec<Vec<(usize, usize)>>,
    particles: Vec<(Particle, BedPoint)>,
}

impl Corners {
    /// The corners between faces that meet within a margin (m).
    pub fn new(faces: &[Face], margin: f64) -> Self {
        let mut all = Corners { of_face: vec![Vec::new(); faces.len()], ..Corners::default() };
        for (first, before) in faces.iter().enumerate() {
            let place = before.ends[1];
            let turn = |after: &Face| before.outwards.cross(after.outwards);
            let follows = |after: &Face| (after.ends[0] - place).norm() <= margin && turn(after) > SHARP;
            if let Some(second) = faces.iter().position(follows) {
                for (side, face) in [first, second].into_iter().enumerate() {
                    all.of_face[face].push((all.corners.len(), side));
                }
                let turn = turn(&faces[second]);
                all.corners.push(Corner { place, faces: [first, second], turn, rows: Default::default() });
            }
        }
        all
    }

    /// Makes the particles beyond all corners out of the rows beside them.
    pub fn fill(&mut self, faces: &[Face], beyond: &[Option<Beyond>], buffer: &[BufferParticle], dimension: Dimension) {
        self.particles.clear();
        for corner in &mut self.corners {
            corner.rows.iter_mut().for_each(Vec::clear);
        }
        for particle in buffer {
            let index = particle.face as usize;
            for &(corner, side) in &self.of_face[index] {
                let face = &faces[index];
                self.corners[corner].rows[side].push((face.beyond(particle.position), particle.area / face.width));
            }
        }
        for Corner { place, faces: indices, turn, rows } in &self.corners {
            let [Some(one), Some(other)] = indices.map(|index| beyond[index]) else { continue };
            let [first, second] = indices.map(|index| &faces[index]);
            let (n_1, n_2) = (first.outwards, second.outwards);
            let velocity = (n_1.perpendicular() * other.outwards - n_2.perpendicular() * one.outwards) * (1.0 / turn);
            let depth = 0.5 * (one.depth + other.depth);
            for &(a, length) in &rows[0] {
                for &(b, width) in &rows[1] {
                    let position = *place + n_1 * a + n_2 * b;
                    let offsets = [position - first.middle, position - second.middle];
                    let area = length * width * turn;
                    let change = one.change_of_velocity(offsets[0]) + other.change_of_velocity(offsets[1]);
                    let level = 0.5 * (one.level(offsets[0]) + other.level(offsets[1]));
                    let particle = Particle {
                        position,
                        velocity: velocity + change * 0.5,
                        volume: area * depth,
                        depth,
                        smoothing_length: smoothing_factor(dimension) * dimension.edge(area),
                    };
                    let slope = (first.slope + second.slope) * 0.5;
                    self.particles.push((particle, BedPoint { elevation: level - depth, slope }));
                }
            }
        }
    }

    /// The particles, each with the bed under it.
    pub fn particles(&self) -> &[(Particle, BedPoint)] {
        &self.particles
    }
}
