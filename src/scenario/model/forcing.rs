//! What comes in over time: boundaries, sources, rain, and the series and tables behind them.

use std::path::PathBuf;

use super::{Sourced, VectorSource};
use crate::calendar::UtcTime;
use crate::error::Place;
use crate::scenario::units::{INTENSITY, LENGTH};

/// Which part of the outline of the terrain is open.
#[derive(Clone, Debug, PartialEq)]
pub enum OpenBoundary {
    /// A side of the raster rectangle.
    Side(Side),
    /// Edge faces near these lines.
    Lines(Sourced<VectorSource>),
}

/// A quantity that may change over time, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub enum Timed {
    /// One value at all times.
    Constant(Sourced<f64>),
    /// Times and values in a table.
    Series(TableFile),
}

impl Timed {
    /// The key path and the place in the scenario.
    pub fn source(&self) -> (&str, Option<&Place>) {
        match self {
            Timed::Constant(value) => (&value.key, value.place.as_ref()),
            Timed::Series(table) => (&table.file.key, table.file.place.as_ref()),
        }
    }
}

/// Two columns of a CSV file.
#[derive(Clone, Debug, PartialEq)]
pub struct TableFile {
    /// The file.
    pub file: Sourced<PathBuf>,
    /// The columns, the one that rises first.
    pub columns: [ColumnUnit; 2],
    /// What holds after the last row of a series; it must reach the end of the run when absent.
    pub after_end: Option<AfterEnd>,
}

/// How a series goes on after its last row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AfterEnd {
    /// With its last value.
    Hold,
}

/// A column and its unit, as far as the scenario says them.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnUnit {
    /// Its name; by its place in the table when absent.
    pub name: Option<String>,
    /// Its unit and the factor to SI; from the end of its name when absent.
    pub unit: Option<(String, f64)>,
}

/// An open part of the edge of the terrain at which something is known of the water beyond.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    /// Where.
    pub place: OpenBoundary,
    /// What is known.
    pub condition: BoundaryCondition,
}

/// What is known of the water beyond a boundary.
#[derive(Clone, Debug, PartialEq)]
pub enum BoundaryCondition {
    /// Waves leave.
    Free,
    /// A discharge comes in (m³/s), at a level (m) where it comes in faster than waves run.
    Discharge {
        /// Discharge (m³/s).
        discharge: Timed,
        /// Level (m).
        level: Option<Timed>,
    },
    /// The level of still water beyond is held (m).
    Stage(Timed),
    /// The level of the water at the boundary is held (m).
    Level(Timed),
    /// A wave comes in, and waves leave.
    Wave {
        /// Level of the wave (m).
        level: Timed,
        /// Level without it (m); that of the water at the start when absent.
        still: Option<Timed>,
    },
    /// Uniform flow on a slope (dimensionless).
    NormalDepth(Sourced<f64>),
    /// The discharge that leaves follows from the level.
    Rating(TableFile),
}

/// Water that comes out of the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Where.
    pub place: SourcePlace,
    /// The discharge at each place, or of each line (m³/s).
    pub discharge: Timed,
}

/// The places of a source.
#[derive(Clone, Debug, PartialEq)]
pub enum SourcePlace {
    /// One place in the coordinates of the run (m).
    At(Sourced<[f64; 2]>),
    /// The points of a file.
    Points(Sourced<VectorSource>),
    /// The lines of a file.
    Lines(Sourced<VectorSource>),
}

/// Rain on the whole terrain.
#[derive(Clone, Debug, PartialEq)]
pub struct Rain {
    /// How much.
    pub amount: RainAmount,
    /// Its end (s); that of the run when absent.
    pub duration: Option<f64>,
    /// The first rain that runs off nowhere (m).
    pub initial_loss: f64,
    /// What of the rain runs off nowhere from then on (m/s).
    pub constant_loss: f64,
}

/// How much rain falls.
#[derive(Clone, Debug, PartialEq)]
pub enum RainAmount {
    /// The same everywhere (m/s).
    Rate(Timed),
    /// A raster of constant intensities.
    Raster {
        /// The file.
        file: Sourced<PathBuf>,
        /// Unit of its values and the factor to m/s.
        unit: (String, f64),
    },
    /// Rasters, each of which holds for an interval of time.
    Series {
        /// NetCDF file, with its variable where the scenario names one, or a list of files.
        file: Sourced<VectorSource>,
        /// Unit of their values, as written; that of the NetCDF variable when absent.
        unit: Option<(String, RainUnit)>,
        /// Which end of its interval the time of a raster is, where the scenario says it.
        stamp: Option<Stamp>,
        /// Date and time of the file at which the run begins; the reference time of the run when absent.
        start: Option<UtcTime>,
    },
}

/// What the numbers of a raster of rain are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RainUnit {
    /// Intensities; the factor to m/s.
    Intensity(f64),
    /// What falls within the interval of the raster; the factor to metres.
    Depth(f64),
}

impl RainUnit {
    /// The unit of a name, such as `mm/h` or `mm`.
    pub fn named(name: &str) -> Option<Self> {
        let intensity = INTENSITY.factor_of(name).map(RainUnit::Intensity);
        intensity.or_else(|| LENGTH.factor_of(name).map(RainUnit::Depth))
    }
}

/// Which end of its interval the time of a raster is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stamp {
    /// It holds from its time to that of the next one.
    #[default]
    Begin,
    /// It holds from the time of the one before to its own.
    End,
}

/// A side of the rectangle of the terrain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Greatest y.
    North,
    /// Greatest x.
    East,
    /// Least y.
    South,
    /// Least x.
    West,
    /// The whole outline of the terrain, no-data edges included.
    All,
}
