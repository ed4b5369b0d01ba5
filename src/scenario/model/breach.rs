//! The breach of a dam.

use super::{Sourced, TableFile, VectorSource};

/// A dam that breaks.
#[derive(Clone, Debug, PartialEq)]
pub struct Breach {
    /// The file with its line.
    pub dam: Sourced<VectorSource>,
    /// Level of its crest (m); from the attribute `crest_field` of the line when absent.
    pub crest: Option<Sourced<f64>>,
    /// Attribute that holds the crest; `crest_m` or `crest` when absent.
    pub crest_field: Option<String>,
    /// When it begins.
    pub trigger: BreachTrigger,
    /// The final opening; the whole dam when absent.
    pub shape: Option<BreachShape>,
    /// How it grows.
    pub law: GrowthLaw,
    /// How long it grows (s); none where it opens at once.
    pub duration: Option<Sourced<f64>>,
    /// Share of the final opening against the time since the trigger, where the law is a series.
    pub share: Option<TableFile>,
    /// The formula that gives shape and duration in place of the scenario.
    pub method: Option<BreachMethod>,
}

/// A breach by a formula for embankment dams.
#[derive(Clone, Debug, PartialEq)]
pub struct BreachMethod {
    /// The formula.
    pub formula: BreachFormula,
    /// How the dam fails.
    pub mode: BreachMode,
    /// Water above the bottom of the breach when it begins (m³).
    pub volume: Sourced<f64>,
    /// Level of the bottom (m).
    pub invert: Sourced<f64>,
    /// A place in its middle in the coordinates of the run (m); the middle of the dam when absent.
    pub position: Option<Sourced<[f64; 2]>>,
    /// By which the mean width of the formula is multiplied.
    pub width_factor: f64,
    /// By which its time is multiplied.
    pub time_factor: f64,
}

/// A formula that gives both width and time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BreachFormula {
    /// `Froehlich2008`.
    Froehlich2008,
    /// `Froehlich1995`.
    Froehlich1995,
}

/// How a dam fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BreachMode {
    /// Water runs over the crest.
    Overtopping,
    /// Water runs through the dam.
    Piping,
}

/// When a breach begins.
#[derive(Clone, Debug, PartialEq)]
pub enum BreachTrigger {
    /// At a time (s).
    At(Sourced<f64>),
    /// When the water at a place reaches a level.
    Level {
        /// The level (m).
        level: Sourced<f64>,
        /// The place in the coordinates of the run (m).
        place: Sourced<[f64; 2]>,
    },
}

/// A trapezoid in the long profile of a dam.
#[derive(Clone, Debug, PartialEq)]
pub struct BreachShape {
    /// Width of its bottom (m).
    pub bottom_width: Sourced<f64>,
    /// Slope of its sides, horizontal to vertical.
    pub side_slope: f64,
    /// Level of its bottom (m).
    pub invert: Sourced<f64>,
    /// A place in its middle in the coordinates of the run (m); the middle of the dam when absent.
    pub position: Option<Sourced<[f64; 2]>>,
}

/// How a breach grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GrowthLaw {
    /// All at once.
    Instantaneous,
    /// In proportion to the time.
    Linear,
    /// Slow at the beginning and at the end.
    Sine,
    /// By a series of shares.
    Series,
}
