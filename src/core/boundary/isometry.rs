//! Rotations and reflections, and what is seen through them.

use super::edge::Edge;
use crate::math::{Sym2, Vec2};

/// A rotation or reflection followed by a shift: x' = R x + t.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Isometry {
    /// Columns of R: the images of the two unit vectors.
    pub image_of_x: Vec2,
    /// See `image_of_x`.
    pub image_of_y: Vec2,
    /// t (m).
    pub shift: Vec2,
}

impl Isometry {
    /// Changes nothing.
    pub const IDENTITY: Isometry =
        Isometry { image_of_x: Vec2::new(1.0, 0.0), image_of_y: Vec2::new(0.0, 1.0), shift: Vec2::ZERO };

    /// The reflection across the line of an edge.
    pub fn reflection(edge: &Edge) -> Self {
        let n = edge.direction().perpendicular();
        let r = Sym2 { xx: 1.0 - 2.0 * n.x * n.x, xy: -2.0 * n.x * n.y, yy: 1.0 - 2.0 * n.y * n.y };
        Isometry {
            image_of_x: Vec2::new(r.xx, r.xy),
            image_of_y: Vec2::new(r.xy, r.yy),
            shift: n * (2.0 * n.dot(edge.start)),
        }
    }

    /// This one first, then `next`.
    pub fn then(&self, next: &Isometry) -> Self {
        Isometry {
            image_of_x: next.vector(self.image_of_x),
            image_of_y: next.vector(self.image_of_y),
            shift: next.point(self.shift),
        }
    }

    /// The image of a point.
    #[inline]
    pub fn point(&self, x: Vec2) -> Vec2 {
        self.vector(x) + self.shift
    }

    /// The image of a vector.
    #[inline]
    pub fn vector(&self, v: Vec2) -> Vec2 {
        self.image_of_x * v.x + self.image_of_y * v.y
    }

    /// The vector whose image is `v`.
    #[inline]
    pub fn inverse_vector(&self, v: Vec2) -> Vec2 {
        Vec2::new(self.image_of_x.dot(v), self.image_of_y.dot(v))
    }
}

/// A neighbour as seen: particle `index` itself, or its image under an isometry of the walls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Image {
    /// Index of the particle.
    pub index: u32,
    /// Index in `Walls::isometries`; 0 for the particle itself.
    pub transform: u32,
}

/// From where particles and their images are seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// The place (m).
    pub place: Vec2,
    /// Distance (m) up to which walls are seen.
    pub support: f64,
    /// The particle that looks, which does not see itself but for its images; none where nobody stands.
    pub particle: Option<u32>,
}

/// Two walls that meet, in which a particle may see an image of an image.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Corner {
    /// The line of sight meets this edge first.
    pub first: u32,
    /// The line of sight meets this edge after the first one.
    pub second: u32,
    /// Index of both reflections together in `Walls::isometries`.
    pub transform: u32,
}
