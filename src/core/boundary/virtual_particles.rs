//! Virtual boundary particles: walls as rows of fixed particles in which each particle is mirrored through points.
//!
//! ```text
//! x' = 2 x_w − x_i + k Δ n,   v' = −v_i,   k = 0, 1, 2
//! ```
//!
//! with x_w a particle of the wall, two to a spacing Δ, and n the normal of the wall away from particle i: three rows of fictitious particles as
//! far apart as the lattice, after the modified virtual boundary particles of `VacondioRogers2012`. They act on particle i alone, have its depth,
//! bed and surface, and its velocity turned round, tangentially too. **Weak spot**: they copy one particle instead of continuing the
//! arrangement of all, and corners are covered twice in part, not at all elsewhere.

use super::isometry::{Image, Isometry, Viewpoint};
use super::wall::{VirtualParticles, Walls};
use crate::math::Vec2;

/// Wall particles to a spacing: the rows that they show are then one spacing wide.
const PER_SPACING: f64 = 2.0;
/// Transforms of a wall particle: the first row, and the second and third one to either side.
const TRANSFORMS: u32 = 5;

impl Walls {
    /// The same walls with virtual particles, for particles that start `spacing` (m) apart.
    pub fn with_virtual_particles(mut self, spacing: f64) -> Self {
        let mut virtuals =
            VirtualParticles { places: Vec::new(), starts: vec![0], first_transform: self.isometries().len() as u32 };
        let mut transforms = Vec::new();
        for edge in self.edges().iter() {
            let piece = edge.end - edge.start;
            let count = if edge.is_open { 0 } else { (PER_SPACING * piece.norm() / spacing).round().max(1.0) as usize };
            let normal = edge.direction().perpendicular() * spacing;
            for k in 0..count {
                let place = edge.start + piece * ((k as f64 + 0.5) / count as f64);
                let rows = [0.0, 1.0, -1.0, 2.0, -2.0];
                transforms.extend(rows.map(|row| Isometry {
                    image_of_x: Vec2::new(-1.0, 0.0),
                    image_of_y: Vec2::new(0.0, -1.0),
                    shift: place * 2.0 + normal * row,
                }));
                virtuals.places.push(place);
            }
            virtuals.starts.push(virtuals.places.len() as u32);
        }
        self.add_virtual_particles(virtuals, transforms);
        self
    }

    /// Appends to `seen` the particles `found` that no wall hides, and the fictitious ones of the particle that looks.
    pub(super) fn see_virtual(
        &self,
        virtuals: &VirtualParticles,
        (from, particle): (&Viewpoint, u32),
        found: &[u32],
        positions: &[Vec2],
        near: &mut Vec<u32>,
        seen: &mut Vec<Image>,
    ) {
        let (place, reach_squared) = (from.place, from.support * from.support);
        let edges = self.edges();
        self.near(place, from.support, near);
        let others = found.iter().filter(|&&j| j != particle && !self.is_walled(place, positions[j as usize]));
        seen.extend(others.map(|&index| Image { index, transform: 0 }));
        for &member in near.iter() {
            // The rows lie on the other side of the wall.
            let rows = if edges[member as usize].turn(place) > 0.0 { [0, 2, 4] } else { [0, 1, 3] };
            for w in virtuals.starts[member as usize]..virtuals.starts[member as usize + 1] {
                let target = virtuals.places[w as usize];
                let is_hidden = || {
                    near.iter().any(|&other| {
                        let share = edges[other as usize].crossing(place, target, 0.0);
                        other != member && share.is_some_and(|share| share < 1.0 - 1e-9)
                    })
                };
                if 4.0 * (target - place).norm_squared() > reach_squared || is_hidden() {
                    continue;
                }
                let transforms = rows.map(|row| virtuals.first_transform + TRANSFORMS * w + row);
                let is_near = |transform: &u32| {
                    (self.isometries()[*transform as usize].point(place) - place).norm_squared() < reach_squared
                };
                seen.extend(
                    transforms.into_iter().filter(is_near).map(|transform| Image { index: particle, transform }),
                );
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::{Edge, ImageScratch};

    fn wall(start: Vec2, end: Vec2) -> Edge {
        Edge { start, end, is_open: false }
    }

    /// Places of the fictitious particles that the first particle sees.
    fn fictitious(edges: Vec<Edge>, positions: &[Vec2], support: f64) -> Vec<Vec2> {
        let walls = Walls::new(edges, 1.0).with_virtual_particles(1.0);
        let found: Vec<u32> = (0..positions.len() as u32).collect();
        let from = Viewpoint { place: positions[0], support, particle: Some(0) };
        let (mut scratch, mut seen) = (ImageScratch::default(), Vec::new());
        walls.see(&from, &found, positions, &vec![support as f32; positions.len()], &mut scratch, &mut seen);
        let turned = seen.iter().filter(|image| image.transform != 0);
        turned
            .map(|image| {
                assert_eq!(image.index, 0, "a particle sees the fictitious ones of its own alone");
                let isometry = &walls.isometries()[image.transform as usize];
                assert!((isometry.vector(Vec2::new(0.3, -0.4)) - Vec2::new(-0.3, 0.4)).norm() < 1e-15);
                isometry.point(positions[0])
            })
            .collect()
    }

    #[test]
    fn rows_behind_a_straight_wall_continue_the_lattice() {
        let floor = wall(Vec2::new(-20.0, 0.0), Vec2::new(20.0, 0.0));
        for side in [1.0, -1.0] {
            let places = fictitious(vec![floor], &[Vec2::new(0.25, 0.5 * side)], 3.1);
            let mut expected = 0;
            for (row, column) in (1..=3).flat_map(|row| (-3..=3).map(move |column| (row, column))) {
                let offset = Vec2::new(f64::from(column), -side * f64::from(row));
                // Wall particles stand at quarters of the spacing, so that one lies right below the particle.
                if offset.norm() < 3.1 && (f64::from(column).powi(2) + 1.0).sqrt() <= 3.1 {
                    expected += 1;
                    let place = Vec2::new(0.25, 0.5 * side) + offset;
                    assert!(places.iter().any(|found| (*found - place).norm() < 1e-9), "{place:?} in {places:?}");
                }
            }
            assert_eq!(places.len(), expected, "{places:?}");
        }
    }

    #[test]
    fn walls_hide_the_particles_and_the_walls_behind_them() {
        let walls =
            [wall(Vec2::new(-20.0, 0.0), Vec2::new(20.0, 0.0)), wall(Vec2::new(-20.0, -0.4), Vec2::new(20.0, -0.4))];
        let one = fictitious(walls[..1].to_vec(), &[Vec2::new(0.25, 0.5), Vec2::new(0.25, -0.2)], 3.1);
        let two = fictitious(walls.to_vec(), &[Vec2::new(0.25, 0.5), Vec2::new(0.25, -0.2)], 3.1);
        assert_eq!(one, two);
    }
}
