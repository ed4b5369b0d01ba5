//! Lattice filling: one moving particle at the centre of each cell with still water.
//!
//! ```text
//! V = f d Δ²,  f = integral / Σ d Δ²
//! ```
//!
//! The factor f of each body makes the volume meet the integral exactly; it is as near to 1 as the filling of the lattice.

use super::{FluidSeed, StillWater};
use crate::lattice::Lattice;

/// The particles of lattice filling, in the order of the cells.
pub fn lattice_filling(lattice: &Lattice, still: &StillWater) -> Vec<FluidSeed> {
    let factors: Vec<f64> = still.volumes.iter().map(|volume| volume.integral_m3 / volume.seeded_m3).collect();
    let bodies = still.body.iter().enumerate().filter_map(|(cell, body)| Some((cell, (*body)?)));
    bodies
        .map(|(cell, body)| FluidSeed {
            position: lattice.centre(cell),
            volume: factors[body as usize] * still.depth[cell] * lattice.cell_area(),
            depth: still.depth[cell],
        })
        .collect()
}
