//! From water on the lattice to the run folder: maxima, arrival, frames, gauges, and the writers of every file.

mod to_grid;

pub use to_grid::{Gridder, MovingWater};

use crate::math::Vec2;

/// A place at which the run reports water over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Gauge {
    /// Name.
    pub id: String,
    /// Map coordinates (m).
    pub position: Vec2,
    /// Further columns of the gauge file, kept as they were: name and value.
    pub attributes: Vec<(String, String)>,
}

/// The coordinate reference system of the results, as writers need it.
#[derive(Clone, Debug, PartialEq)]
pub enum OutputCrs {
    /// Plain metres.
    Local,
    /// A projected system.
    Projected {
        /// WKT2:2019 text, the truth.
        wkt2: String,
        /// `EPSG:n` where the system has a code.
        authority: Option<String>,
    },
}
