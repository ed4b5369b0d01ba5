//! Water at the start.

use std::path::PathBuf;

use super::{Sourced, VectorSource};

/// A body of still water at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct InitialWater {
    /// The polygon file.
    pub polygons: Sourced<VectorSource>,
    /// The level (m); from the attribute `level_field` of the file when absent.
    pub level: Option<Sourced<f64>>,
    /// Attribute that holds the level; `level_m`, `level` or their first ten letters when absent.
    pub level_field: Option<String>,
}

/// Water of the start beside the bodies with a level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Start {
    /// Water with a depth; later entries win over earlier ones.
    pub depths: Vec<WaterOfDepth>,
    /// The state of an earlier run; there is no other water then.
    pub earlier: Option<EarlierRun>,
}

/// Water of one depth.
#[derive(Clone, Debug, PartialEq)]
pub struct WaterOfDepth {
    /// The file with polygons, or with the lines of a river.
    pub place: Sourced<VectorSource>,
    /// The depth (m).
    pub depth: Sourced<f64>,
    /// The width of a river; none for polygons.
    pub river: Option<RiverWidth>,
}

/// How wide a river is.
#[derive(Clone, Debug, PartialEq)]
pub enum RiverWidth {
    /// One cell.
    Cell,
    /// Everywhere the same (m).
    Constant(f64),
    /// By an attribute of each line.
    Field(String),
}

/// A moment of an earlier run.
#[derive(Clone, Debug, PartialEq)]
pub struct EarlierRun {
    /// Its `fields.nc`.
    pub fields: Sourced<PathBuf>,
    /// The time (s); the last one when absent.
    pub time: Option<Sourced<f64>>,
}
