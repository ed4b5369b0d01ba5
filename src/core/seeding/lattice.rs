//! Lattice filling: one particle at the centre of each cell with still water.
//!
//! ```text
//! V = f d Δ²,  f = integral / Σ d Δ²
//! ```
//!
//! The factor f of each body makes the volume meet the integral exactly; it is as near to 1 as the filling of the lattice. Water that
//! belongs to no body has f = 1.

use super::{FluidSeed, StillWater};
use crate::lattice::Lattice;

/// The particles of lattice filling, in the order of the cells.
pub fn lattice_filling(lattice: &Lattice, still: &StillWater) -> Vec<FluidSeed> {
    let factors: Vec<f64> = still.volumes.iter().map(|volume| volume.integral_m3 / volume.seeded_m3).collect();
    let seed = |(cell, &depth): (usize, &f64)| {
        let factor = still.body[cell].map_or(1.0, |body| factors[body as usize]);
        let volume = factor * depth * lattice.cell_area();
        (still.body[cell].is_some() || depth > 0.0).then(|| FluidSeed { position: lattice.centre(cell), volume, depth })
    };
    still.depth.iter().enumerate().filter_map(seed).collect()
}
