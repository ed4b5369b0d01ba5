//! Deep water in several particles for each cell, so that none carries more than a given volume.
//!
//! A cell whose particle is too large gets k × k of them, on a lattice of its own, with equal volumes; each has the depth
//! that the level leaves over the bed at its very place, so that a lake stays at rest.

use super::FluidSeed;
use crate::bed::BedParticles;
use crate::math::Vec2;

/// Cuts every particle of lattice filling that carries more than `most` (m³).
pub fn subdivide(seeds: &[FluidSeed], bed: &BedParticles, most: f64) -> Vec<FluidSeed> {
    debug_assert!(most > 0.0);
    seeds.iter().flat_map(|seed| pieces(seed, bed, most)).collect()
}

fn pieces(seed: &FluidSeed, bed: &BedParticles, most: f64) -> Vec<FluidSeed> {
    let per_edge = (seed.volume / most).sqrt().ceil().max(1.0);
    let Some(level) = bed.at(seed.position).map(|point| point.elevation + seed.depth) else { return vec![*seed] };
    let step = bed.lattice.spacing / per_edge;
    let corner = seed.position - Vec2::new(1.0, 1.0) * (0.5 * (bed.lattice.spacing - step));
    let places = (0..(per_edge * per_edge) as usize).map(|piece| {
        let (column, row) = (piece % per_edge as usize, piece / per_edge as usize);
        corner + Vec2::new(column as f64, row as f64) * step
    });
    let wet: Vec<(Vec2, f64)> = places
        .filter_map(|place| Some((place, level - bed.at(place)?.elevation)).filter(|&(_, depth)| depth > 0.0))
        .collect();
    let sum: f64 = wet.iter().map(|&(_, depth)| depth).sum();
    wet.into_iter()
        .map(|(position, depth)| FluidSeed { position, volume: seed.volume * depth / sum, depth })
        .collect()
}
