//! What of the terrain a run reads: all of it, or the part that the water comes to.

use super::Side;
use crate::math::Vec2;

/// What of the terrain is read; the program sets it before anything is prepared (`pipeline/part.rs`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// The part that is read; none for all of it.
    pub part: Option<Part>,
    /// Edge of the pixels (m) that do; none for those of the files.
    pub pixel: Option<f64>,
}

/// A part of the terrain, in map coordinates (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Its south-western corner.
    pub low: Vec2,
    /// Its north-eastern corner.
    pub high: Vec2,
    /// The south-western corner of all of the terrain.
    pub whole_low: Vec2,
    /// Its north-eastern corner.
    pub whole_high: Vec2,
}

impl Part {
    /// Whether the terrain goes on beyond a side of it.
    pub fn is_cut(&self, side: Side) -> bool {
        match side {
            Side::North => self.high.y < self.whole_high.y,
            Side::East => self.high.x < self.whole_high.x,
            Side::South => self.low.y > self.whole_low.y,
            Side::West => self.low.x > self.whole_low.x,
            Side::All => false,
        }
    }

    /// Whether a rectangle (map coordinates, m) has a place in common with it.
    pub fn meets(&self, [low, high]: [Vec2; 2]) -> bool {
        low.x <= self.high.x && low.y <= self.high.y && high.x >= self.low.x && high.y >= self.low.y
    }

    /// What of a straight piece (map coordinates, m) lies in it; the piece as it stands where that is all of it.
    pub fn cut(&self, piece: [Vec2; 2]) -> Option<[Vec2; 2]> {
        let [from, to] = piece;
        let way = to - from;
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        for (start, step, low, high) in
            [(from.x, way.x, self.low.x, self.high.x), (from.y, way.y, self.low.y, self.high.y)]
        {
            // Along a side the piece is in between or not, all of it.
            if step.abs() < f64::MIN_POSITIVE {
                if start < low || start > high {
                    return None;
                }
                continue;
            }
            let (a, b) = ((low - start) / step, (high - start) / step);
            (first, last) = (first.max(a.min(b)), last.min(a.max(b)));
        }
        let at = |share: f64, end: Vec2| if share > 0.0 && share < 1.0 { from + way * share } else { end };
        (first < last).then(|| [at(first, from), at(last, to)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_cut_at_the_sides_of_a_part() {
        let at = Vec2::new;
        let part =
            Part { low: at(0.0, 0.0), high: at(10.0, 5.0), whole_low: at(-90.0, -90.0), whole_high: at(90.0, 90.0) };
        let whole = [at(1.0, 1.0), at(9.0, 4.0)];
        assert_eq!(part.cut(whole), Some(whole));
        assert_eq!(part.cut([at(-10.0, 2.0), at(20.0, 2.0)]), Some([at(0.0, 2.0), at(10.0, 2.0)]));
        assert_eq!(part.cut([at(5.0, -5.0), at(5.0, 1.0)]), Some([at(5.0, 0.0), at(5.0, 1.0)]));
        assert_eq!(part.cut([at(-1.0, 4.0), at(4.0, 9.0)]), None);
        assert_eq!(part.cut([at(11.0, 0.0), at(11.0, 5.0)]), None);
        assert!(part.meets([at(9.0, 4.0), at(30.0, 30.0)]) && !part.meets([at(11.0, 0.0), at(12.0, 5.0)]));
    }
}
