//! What of the terrain a run reads: all of it, or the part that the water comes to.

use super::Side;
use crate::math::{Rectangle, Vec2};

/// What of the terrain is read; the program sets it before anything is prepared (`pipeline/part.rs`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// The part that is read; none for all of it.
    pub part: Option<Part>,
    /// Edge of the pixels (m) that do; none for those of the files.
    pub pixel: Option<f64>,
}

/// A part of the terrain, in map coordinates (m).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Part {
    /// Where it is.
    pub own: Rectangle,
    /// All of the terrain.
    pub whole: Rectangle,
}

impl Part {
    /// Whether the terrain goes on beyond a side of it.
    pub fn is_cut(&self, side: Side) -> bool {
        let Part { own, whole } = self;
        match side {
            Side::North => own.high.y < whole.high.y,
            Side::East => own.high.x < whole.high.x,
            Side::South => own.low.y > whole.low.y,
            Side::West => own.low.x > whole.low.x,
            Side::All => false,
        }
    }

    /// What of a straight piece (map coordinates, m) lies in it; the piece as it stands where that is all of it.
    pub fn cut(&self, piece: [Vec2; 2]) -> Option<[Vec2; 2]> {
        let [from, to] = piece;
        let (first, last) = self.own.share_of(piece).filter(|(first, last)| first < last)?;
        let at = |share: f64, end: Vec2| if share > 0.0 && share < 1.0 { from + (to - from) * share } else { end };
        Some([at(first, from), at(last, to)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_cut_at_the_sides_of_a_part() {
        let at = Vec2::new;
        let part = Part {
            own: Rectangle { low: at(0.0, 0.0), high: at(10.0, 5.0) },
            whole: Rectangle { low: at(-90.0, -90.0), high: at(90.0, 90.0) },
        };
        let whole = [at(1.0, 1.0), at(9.0, 4.0)];
        assert_eq!(part.cut(whole), Some(whole));
        assert_eq!(part.cut([at(-10.0, 2.0), at(20.0, 2.0)]), Some([at(0.0, 2.0), at(10.0, 2.0)]));
        assert_eq!(part.cut([at(5.0, -5.0), at(5.0, 1.0)]), Some([at(5.0, 0.0), at(5.0, 1.0)]));
        assert_eq!(part.cut([at(-1.0, 4.0), at(4.0, 9.0)]), None);
        assert_eq!(part.cut([at(11.0, 0.0), at(11.0, 5.0)]), None);
        let meets = |low: Vec2, high: Vec2| part.own.meets(Rectangle { low, high });
        assert!(meets(at(9.0, 4.0), at(30.0, 30.0)) && !meets(at(11.0, 0.0), at(12.0, 5.0)));
    }
}
