//! A channel that is known by its cross-sections: a row of particles, each of them as wide as the water between the banks.
//!
//! A cross-section is made of strips, each level and with a bed of its own; the water stands at one level in all of them and
//! moves at one velocity. A rectangle is one strip. The strips of a section follow each other from the lowest bed upwards, and
//! strip k of one section goes on as strip k of the next.

use super::{Condition, EdgeFace};
use crate::math::Vec2;

/// A level piece of a cross-section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strip {
    /// Width (m), 0 or more.
    pub width: f64,
    /// Elevation of its bed (m).
    pub bed: f64,
}

/// The reach of one particle.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelSection {
    /// Its strips, beds rising.
    pub strips: Vec<Strip>,
    /// Depth above the lowest strip (m) and wetted perimeter (m), both rising; linear between the rows and beyond the last.
    pub perimeter: Vec<(f64, f64)>,
    /// Manning's n (s·m^(−1/3)).
    pub manning: f64,
    /// Level of the water at the start (m); dry where it is not above the bed.
    pub level: f64,
}

/// What lies beyond an end of a channel.
#[derive(Clone, Debug, PartialEq)]
pub enum ChannelEnd {
    /// Nothing.
    Wall,
    /// Water of which something is known.
    Open(Condition),
    /// The area of two dimensions: the edge faces of its opening.
    Joined(Vec<EdgeFace>),
}

impl ChannelEnd {
    /// The cells of the area of two dimensions that it joins.
    pub fn joined_cells(&self) -> impl Iterator<Item = usize> + '_ {
        let faces = if let ChannelEnd::Joined(faces) = self { faces.as_slice() } else { &[] };
        faces.iter().map(|face| face.cell)
    }
}

/// A channel, from its far end to the end that may join the area of two dimensions.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Distance of its particles (m).
    pub spacing: f64,
    /// The particles, two or more.
    pub sections: Vec<ChannelSection>,
    /// Widths of the strips (m) at the faces: the far end, between the particles, the near end.
    pub face_widths: Vec<Vec<f64>>,
    /// What lies beyond the far end; never [`ChannelEnd::Joined`].
    pub far: ChannelEnd,
    /// What lies beyond the near end.
    pub near: ChannelEnd,
}

/// The wetted perimeter (m) at a depth (m) above the lowest strip, by the rows of a section.
pub fn wetted_perimeter(rows: &[(f64, f64)], depth: f64) -> f64 {
    let upper = rows.partition_point(|row| row.0 <= depth).clamp(1, rows.len() - 1);
    let (low, high) = (rows[upper - 1], rows[upper]);
    low.1 + (depth - low.0) / (high.0 - low.0) * (high.1 - low.1)
}

impl Channel {
    /// A channel of rectangular sections from the far end: widths (m) at its faces, beds (m) and levels (m) at its particles.
    /// Closed at both ends. With `smooth_walls` only the bed resists, otherwise the walls do, too.
    pub fn rectangular(spacing: f64, widths: &[f64], bed: &[f64], level: &[f64], resistance: Resistance) -> Channel {
        let section = |i: usize| {
            let width = 0.5 * (widths[i] + widths[i + 1]);
            let per_depth = if resistance.smooth_walls { 0.0 } else { 2.0 };
            ChannelSection {
                strips: vec![Strip { width, bed: bed[i] }],
                perimeter: vec![(0.0, width), (1.0, width + per_depth)],
                manning: resistance.manning,
                level: level[i],
            }
        };
        Channel {
            spacing,
            sections: (0..bed.len()).map(section).collect(),
            face_widths: widths.iter().map(|width| vec![*width]).collect(),
            far: ChannelEnd::Wall,
            near: ChannelEnd::Wall,
        }
    }

    /// Whether an edge face with this midpoint (local coordinates, m) opens into the channel.
    pub fn joins_at(&self, midpoint: Vec2) -> bool {
        /// Far above the rounding of coordinates, far below a spacing (m).
        const TOUCH: f64 = 1e-6;
        match &self.near {
            ChannelEnd::Joined(faces) => faces.iter().any(|face| (face.middle - midpoint).norm() <= TOUCH),
            ChannelEnd::Wall | ChannelEnd::Open(_) => false,
        }
    }
}

/// What slows the water of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Resistance {
    /// Manning's n (s·m^(−1/3)).
    pub manning: f64,
    /// Whether only the bed is rough.
    pub smooth_walls: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_perimeter_is_linear_between_its_rows_and_goes_on() {
        let rows = [(0.0, 2.0), (1.0, 5.0), (3.0, 6.0)];
        for (depth, expected) in [(0.0, 2.0), (0.5, 3.5), (2.0, 5.5), (5.0, 7.0)] {
            assert!((wetted_perimeter(&rows, depth) - expected).abs() < 1e-14, "{depth}");
        }
    }

    #[test]
    fn a_rectangle_is_one_strip_with_walls_or_without() {
        let widths = [1.0, 3.0, 3.0];
        let rough = Resistance { manning: 0.02, smooth_walls: false };
        let channel = Channel::rectangular(1.0, &widths, &[0.0, 0.1], &[1.0, 1.0], rough);
        assert_eq!(channel.sections[0].strips, [Strip { width: 2.0, bed: 0.0 }]);
        assert!((wetted_perimeter(&channel.sections[1].perimeter, 0.5) - 4.0).abs() < 1e-14);
        let smooth =
            Channel::rectangular(1.0, &widths, &[0.0, 0.1], &[1.0, 1.0], Resistance { smooth_walls: true, ..rough });
        assert!((wetted_perimeter(&smooth.sections[1].perimeter, 0.5) - 3.0).abs() < 1e-14);
        assert!(!channel.joins_at(Vec2::ZERO));
    }
}
