//! The number of horizontal dimensions: two for maps, one for channels of unit width.
//!
//! In one dimension a particle's plan area is its length (area per metre of width), and water moves along x only.

/// Number of horizontal dimensions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Dimension {
    /// A channel of unit width along x.
    One,
    /// The plane.
    Two,
}

impl Dimension {
    /// 1 or 2.
    #[inline(always)]
    pub fn count(self) -> f64 {
        match self {
            Dimension::One => 1.0,
            Dimension::Two => 2.0,
        }
    }

    /// Length of the edge of a particle of the given area, A^(1/dim) (m).
    #[inline(always)]
    pub fn edge(self, area: f64) -> f64 {
        match self {
            Dimension::One => area,
            Dimension::Two => area.sqrt(),
        }
    }

    /// Area (m²) of a particle with an edge of that length (m).
    #[inline(always)]
    pub fn area(self, edge: f64) -> f64 {
        match self {
            Dimension::One => edge,
            Dimension::Two => edge * edge,
        }
    }

    /// Width of one side of a particle of the given area, A^((dim−1)/dim): 1 per metre of width in one dimension.
    #[inline(always)]
    pub fn side(self, area: f64) -> f64 {
        match self {
            Dimension::One => 1.0,
            Dimension::Two => area.sqrt(),
        }
    }
}
