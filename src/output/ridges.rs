//! Ridges of the terrain that are narrower than a cell, as lines along the faces that carry them.

use crate::math::Vec2;

/// A face between two cells that carries a ridge which neither of them sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ridge {
    /// The face in map coordinates (m).
    pub line: [Vec2; 2],
    /// The lowest level (m) at which water passes it; none where there is none.
    pub sill: Option<f64>,
    /// The share of the face that lies in a gap, whose level is the sill; 1 without a gap.
    pub open: f64,
    /// The level (m) at which water passes the rest; none where there is none.
    pub crest: Option<f64>,
    /// Bed elevation (m) of the cells to the left and to the right of the line.
    pub beds: [f64; 2],
}

impl Ridge {
    /// How far it rises above the higher of both beds (m), beside its gap; none where no water passes at any level.
    pub fn rise(&self) -> Option<f64> {
        self.crest.map(|crest| crest - self.beds[0].max(self.beds[1]))
    }
}
