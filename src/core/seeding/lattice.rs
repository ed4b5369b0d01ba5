//! Lattice filling: one particle at the centre of each cell with still water.
//!
//! ```text
//! V = (d + s)₊ Δ²,  Σ V = integral
//! ```
//!
//! The shift s of each body meets the integral exactly, and its water stays level; it is as near to 0 as the filling of the lattice is good.
//! Water that belongs to no body has s = 0.

use super::{FluidSeed, StillWater};
use crate::lattice::Lattice;

/// Rounds by which a shift that dries cells out is found.
const ROUNDS: usize = 20;

/// The particles of lattice filling, in the order of the cells.
pub fn lattice_filling(lattice: &Lattice, still: &StillWater) -> Vec<FluidSeed> {
    let bodies = 0..still.volumes.len() as u32;
    let shifts: Vec<f64> = bodies.map(|body| shift(lattice, still, body)).collect();
    let seed = |(cell, &depth): (usize, &f64)| {
        let depth = depth + still.body[cell].map_or(0.0, |body| shifts[body as usize]);
        let volume = depth * lattice.cell_area();
        (depth > 0.0).then(|| FluidSeed { position: lattice.centre(cell), volume, depth })
    };
    still.depth.iter().enumerate().filter_map(seed).collect()
}

/// What the level of a body (m) is shifted by.
fn shift(lattice: &Lattice, still: &StillWater, body: u32) -> f64 {
    let sum = still.volumes[body as usize].integral_m3 / lattice.cell_area();
    let mut shift = 0.0;
    for _ in 0..ROUNDS {
        let own = still.depth.iter().zip(&still.body).filter(|&(_, of)| *of == Some(body));
        let wet = own.map(|(depth, _)| depth + shift).filter(|&depth| depth > 0.0);
        let (held, cells) = wet.fold((0.0, 0.0), |(held, cells), depth| (held + depth, cells + 1.0));
        if cells == 0.0 {
            return 0.0;
        }
        shift += (sum - held) / cells;
    }
    shift
}
