//! Cells in part, where the terrain ends inside a cell (M102).

use super::shaped::Shaped;
use crate::bed::{BedParticles, Cover};
use crate::scenario::Scenario;
use crate::scenario::methods::Motion;
use crate::terrain::Terrain;

/// Finds the cells in part. Lagrangian particles know none: they keep to whole cells.
pub(super) fn find(scenario: &Scenario, terrain: &Terrain, surface: &Shaped<'_>, bed: &mut BedParticles) {
    if scenario.numerics.motion == Motion::Eulerian {
        bed.cover = Cover::find(terrain, surface, bed);
    }
}
