//! Beds that move.

use std::path::PathBuf;

use super::{Sourced, TableFile, Timed, VectorSource};

/// A part of the bed that moves.
#[derive(Clone, Debug, PartialEq)]
pub struct MovingBed {
    /// Raster of the final change of ground that moves in place, or of the thickness of a slide at the start.
    pub raster: Sourced<PathBuf>,
    /// Factor from its unit to metres.
    pub unit: f64,
    /// When it begins (s).
    pub at: Sourced<f64>,
    /// How it moves.
    pub law: BedMovement,
}

/// How a part of the bed moves.
#[derive(Clone, Debug, PartialEq)]
pub enum BedMovement {
    /// In place: by a share of its change over the time since it began, or all at once.
    InPlace(Option<TableFile>),
    /// As a rigid slide.
    Slide {
        /// The file with its line.
        path: Sourced<VectorSource>,
        /// Velocity along it over the time since it began (m/s).
        velocity: Timed,
    },
}
