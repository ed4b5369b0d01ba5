//! Cells in part, where the terrain ends inside a cell (M13).

use super::change::Shaped;
use crate::bed::{BedParticles, Cover};
use crate::scenario::Scenario;
use crate::scenario::methods::Motion;
use crate::terrain::Terrain;

/// The cells in part. Lagrangian particles know none: they keep to whole cells.
pub fn find(scenario: &Scenario, terrain: &Terrain, surface: &Shaped<'_>, bed: &BedParticles) -> Cover {
    match scenario.numerics.motion {
        Motion::Eulerian => Cover::find(terrain, surface, bed),
        Motion::Lagrangian => Cover::default(),
    }
}
