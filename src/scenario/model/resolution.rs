//! Levels of square cells nested 2:1, and the places that are to be fine.

use super::{Scenario, Sourced, VectorSource};

/// What lengths that the program chooses keep to; where nothing is said, an error of 5 % of the depth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Auto {
    /// CPU time of the steps (s).
    pub cpu: Option<f64>,
    /// Memory of the run (bytes).
    pub memory: Option<f64>,
    /// Mean error of the maximum depth (m).
    pub error: Option<f64>,
}

/// Levels of cells: those of a level have twice the edge of those of the next finer one. The finest spacing is
/// `Scenario::resolution`.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    /// Edge of the coarsest cells (m): the finest spacing times 1, 2, 4, up to 64.
    pub coarsest: Sourced<f64>,
    /// Places that are to be finer than the scene asks by itself; key and place are those of the file.
    pub refine: Vec<Sourced<Refine>>,
}

/// A place that is to be fine.
#[derive(Clone, Debug, PartialEq)]
pub struct Refine {
    /// Coarsest spacing wanted there (m); see [`Levels::level_of`].
    pub to: f64,
    /// Where.
    pub shape: RefineShape,
}

/// Where cells are to be fine.
#[derive(Clone, Debug, PartialEq)]
pub enum RefineShape {
    /// Inside polygons.
    Polygons(VectorSource),
    /// On both sides of lines.
    Lines {
        /// The file of lines.
        source: VectorSource,
        /// Distance from the lines (m); 0 for the cells that they cross.
        within: f64,
    },
}

/// Relative difference up to which two lengths are the same: files and messages have lengths of six digits.
pub const SAME_LENGTH: f64 = 1e-5;

impl Scenario {
    /// The scenario with lengths (m) that were chosen: the finest one, and the coarsest where there are levels.
    #[must_use]
    pub fn with_lengths(&self, finest: f64, coarsest: f64) -> Scenario {
        let mut scenario = self.clone();
        let Sourced { key, place, .. } = self.resolution.clone();
        scenario.auto = None;
        scenario.resolution.value = finest;
        let coarsest = Sourced { value: coarsest, key, place };
        let has_levels = coarsest.value > finest * (1.0 + SAME_LENGTH);
        scenario.levels = has_levels.then(|| Levels { coarsest, refine: Vec::new() });
        // A map without a cell of its own has that of the run.
        if scenario.outputs.cell.is_nan() {
            scenario.outputs.cell = finest;
        }
        scenario
    }
}

impl Levels {
    /// Most levels of a scenario: the coarsest cells are as wide as 64 of the finest.
    pub const MOST: usize = 7;

    /// The coarsest spacing (m) that a length (m) stands for above a finest spacing (m, above 0): that times a power of two. None
    /// where there is no such level.
    pub fn nested(finest: f64, coarsest: f64) -> Option<f64> {
        let doublings = (coarsest / finest).log2().round();
        let spacing = finest * doublings.exp2();
        let is_level = (0.0..Self::MOST as f64).contains(&doublings);
        (is_level && (coarsest - spacing).abs() <= SAME_LENGTH * spacing).then_some(spacing)
    }

    /// Number of levels above a finest spacing (m), with its own; 1 where all cells are of it.
    pub fn count(&self, finest: f64) -> usize {
        1 + (self.coarsest.value / finest).log2().round() as usize
    }

    /// The coarsest level whose cells are not wider than a length `to` (m); level 0 has the finest spacing (m).
    pub fn level_of(&self, finest: f64, to: f64) -> usize {
        let doublings = (to / finest * (1.0 + SAME_LENGTH)).log2().floor().max(0.0) as usize;
        doublings.min(self.count(finest) - 1)
    }
}
