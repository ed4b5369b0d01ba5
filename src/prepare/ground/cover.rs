//! Cells in part, where the terrain ends inside a cell (M13).

use super::change::Shaped;
use crate::bed::{BedParticles, Cover};
use crate::scenario::Scenario;
use crate::terrain::Terrain;

/// The cells in part. The variational formulation knows none: its particles keep to whole cells.
pub fn find(scenario: &Scenario, terrain: &Terrain, surface: &Shaped<'_>, bed: &BedParticles) -> Cover {
    if scenario.numerics.has_cells() { Cover::find(terrain, surface, bed) } else { Cover::default() }
}
