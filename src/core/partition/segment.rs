//! Straight pieces of lines.

use crate::math::Vec2;

/// A straight piece of a line.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Its ends.
    pub ends: [Vec2; 2],
    /// Index of its line.
    pub line: usize,
}

impl Segment {
    /// From the first end to the second.
    pub fn along(&self) -> Vec2 {
        self.ends[1] - self.ends[0]
    }

    /// The nearest place of the segment.
    pub fn nearest(&self, place: Vec2) -> Vec2 {
        let along = self.along();
        let share = ((place - self.ends[0]).dot(along) / along.norm_squared()).clamp(0.0, 1.0);
        // From the nearer end, so that a line drawn the other way gives the same place.
        if share <= 0.5 { self.ends[0] + along * share } else { self.ends[1] - along * (1.0 - share) }
    }

    /// Distance of a place from the segment.
    pub fn distance(&self, place: Vec2) -> f64 {
        (self.nearest(place) - place).norm()
    }

    /// Shares of the way along this and another segment at which their straight lines cross; none where they are parallel.
    pub fn crossing(&self, other: &Segment) -> Option<(f64, f64)> {
        let (a, b) = (self.along(), other.along());
        let area = a.cross(b);
        let offset = other.ends[0] - self.ends[0];
        (area.abs() > 1e-12 * a.norm() * b.norm()).then(|| (offset.cross(b) / area, offset.cross(a) / area))
    }

    /// The places where two segments meet, `tolerance` apart at most: the ends of one on the other, or their crossing.
    pub fn meetings(&self, other: &Segment, tolerance: f64) -> Vec<Vec2> {
        let mut found: Vec<Vec2> = Vec::new();
        found.extend(self.ends.iter().filter(|end| other.distance(**end) <= tolerance));
        found.extend(other.ends.iter().filter(|end| self.distance(**end) <= tolerance));
        if let (true, Some((t, u))) = (found.is_empty(), self.crossing(other))
            && (0.0..=1.0).contains(&t)
            && (0.0..=1.0).contains(&u)
        {
            found.push(self.ends[0] + self.along() * t);
        }
        found
    }

    /// Whether two segments touch, `tolerance` apart at most.
    pub fn touches(&self, other: &Segment, tolerance: f64) -> bool {
        match self.crossing(other) {
            Some((t, u)) => {
                let [slack_t, slack_u] = [self, other].map(|s| tolerance / s.along().norm());
                (-slack_t..=1.0 + slack_t).contains(&t) && (-slack_u..=1.0 + slack_u).contains(&u)
            }
            None => !self.meetings(other, tolerance).is_empty(),
        }
    }
}
