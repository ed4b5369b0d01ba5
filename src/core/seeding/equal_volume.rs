//! Equal-volume filling: particles that all carry the same volume, closer together where the water is deep.
//!
//! 1. The water is cut into samples smaller than a particle, in the order of Hilbert's curve, along which neighbours stay
//!    together. Pieces of the curve with equal volumes give the first places: their centroids.
//! 2. Some sweeps of Lloyd's relaxation even out the distances: every sample joins the nearest particle, every particle moves
//!    to the centroid of its samples, weighted by d². In the plane, centroidal cells get a density of particles in
//!    proportion to the square root of the weight (`DuFaberGunzburger1999`), and equal volumes need one in proportion to d.
//!
//! No chance is involved, and the order of all sums is fixed: the same bits for any number of threads.

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

use super::{FluidSeed, StillWater};
use crate::bed::BedParticles;
use crate::math::Vec2;

/// Samples along the edge of the square that a particle takes up where the water is deepest.
const SAMPLES_PER_EDGE: f64 = 3.0;
/// Fewest samples along the edge of a cell, so that the shore inside it is seen.
const FEWEST_SAMPLES_PER_CELL_EDGE: usize = 2;
/// Sweeps of relaxation: the distances hardly change after that.
const SWEEPS: usize = 12;

/// A place is as deep as this share of the mean of its own samples, at least.
const LEAST_SHARE_OF_MEAN: f64 = 0.7;

/// A piece of the water, smaller than a particle.
#[derive(Clone, Copy)]
struct Sample {
    position: Vec2,
    depth: f64,
}

/// One body of still water on the lattice.
struct Wet<'a> {
    number: u32,
    level: f64,
    bed: &'a BedParticles,
    still: &'a StillWater,
}

/// The volume (m³) of a particle for which there are as many particles as wet cells: the mean over the cells of all bodies.
///
/// ```text
/// V = Σ d Δ² / N
/// ```
///
/// 0 where there is no water.
pub fn mean_cell_volume(still: &StillWater) -> f64 {
    let cells: usize = still.volumes.iter().map(|volume| volume.cells).sum();
    still.volumes.iter().map(|volume| volume.seeded_m3).sum::<f64>() / cells.max(1) as f64
}

/// The particles of equal-volume filling, body after body; `levels` (m) are those of the bodies.
///
/// `particle_volume` (m³, above 0): the volume aimed at; that of a body's particles is its volume over the nearest whole number
/// of particles, so that their sum meets the integral exactly.
pub fn equal_volume_filling(
    levels: &[f64],
    bed: &BedParticles,
    still: &StillWater,
    particle_volume: f64,
) -> Vec<FluidSeed> {
    debug_assert!(particle_volume > 0.0);
    let mut seeds = Vec::new();
    for (number, (&level, balance)) in levels.iter().zip(&still.volumes).enumerate() {
        let count = (balance.integral_m3 / particle_volume).round().max(1.0);
        let volume = balance.integral_m3 / count;
        let wet = Wet { number: number as u32, level, bed, still };
        let samples = wet.samples(volume);
        if samples.is_empty() {
            continue;
        }
        let mut places = along_curve(&samples, count as usize);
        for _ in 0..SWEEPS {
            places = relax(&samples, places);
        }
        let wet_places = wet.off_the_shallows(&samples, places);
        seeds.extend(wet_places.into_iter().map(|(position, depth)| FluidSeed { position, volume, depth }));
    }
    seeds
}

impl Wet<'_> {
    /// Depth (m) at a place, if it lies in a cell of this body and below its level.
    fn depth_at(&self, position: Vec2) -> Option<f64> {
        let cell = self.bed.lattice.cell_at(position).filter(|&cell| self.still.body[cell] == Some(self.number))?;
        debug_assert!(self.bed.has_terrain(cell));
        let depth = self.level - self.bed.at(position)?.elevation;
        (depth > 0.0).then_some(depth)
    }

    /// The samples of the body, along Hilbert's curve.
    fn samples(&self, particle_volume: f64) -> Vec<Sample> {
        let lattice = &self.bed.lattice;
        let cells: Vec<usize> = (0..lattice.len()).filter(|&cell| self.still.body[cell] == Some(self.number)).collect();
        let deepest = cells.iter().map(|&cell| self.still.depth[cell]).fold(0.0, f64::max);
        let particles_per_edge = (deepest * lattice.cell_area() / particle_volume).sqrt();
        let per_edge = ((SAMPLES_PER_EDGE * particles_per_edge).ceil() as usize).max(FEWEST_SAMPLES_PER_CELL_EDGE);
        let step = lattice.spacing / per_edge as f64;
        let bits = usize::BITS - (lattice.columns.max(lattice.rows) * per_edge).leading_zeros();
        let mut samples: Vec<(u64, Sample)> = cells
            .par_iter()
            .flat_map_iter(|&cell| {
                let (column, row) = lattice.column_row(cell);
                (0..per_edge * per_edge).filter_map(move |piece| {
                    let (x, y) = (column * per_edge + piece % per_edge, row * per_edge + piece / per_edge);
                    let position = Vec2::new((x as f64 + 0.5) * step, (y as f64 + 0.5) * step);
                    let depth = self.depth_at(position)?;
                    Some((along_hilbert_curve(x as u64, y as u64, bits), Sample { position, depth }))
                })
            })
            .collect();
        samples.par_sort_unstable_by_key(|&(place_on_curve, _)| place_on_curve);
        samples.into_iter().map(|(_, sample)| sample).collect()
    }

    /// The places and their depths. A place much shallower than the water of its own samples is moved to the nearest of them
    /// that is deep enough: the centroid of the water around an island may lie on the island, or on its beach, where
    /// the volume of a particle would stand for an area V/d without bounds.
    fn off_the_shallows(&self, samples: &[Sample], places: Vec<Vec2>) -> Vec<(Vec2, f64)> {
        let mut own = vec![Vec::new(); places.len()];
        for (sample, particle) in samples.iter().zip(assign(samples, &places).unwrap_or_default()) {
            own[particle].push(*sample);
        }
        let settle = |(place, own): (Vec2, Vec<Sample>)| {
            let own = if own.is_empty() { samples } else { &own };
            let mean = own.iter().map(|sample| sample.depth).sum::<f64>() / own.len() as f64;
            if let Some(depth) = self.depth_at(place).filter(|&depth| depth >= LEAST_SHARE_OF_MEAN * mean) {
                return (place, depth);
            }
            let distance = |sample: &&Sample| (sample.position - place).norm_squared();
            let deep = own.iter().filter(|sample| sample.depth >= LEAST_SHARE_OF_MEAN * mean);
            let nearest = deep.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(&samples[0]);
            (nearest.position, nearest.depth)
        };
        places.into_par_iter().zip(own).map(settle).collect()
    }
}

/// Centroids of `count` pieces of the curve with equal volumes.
fn along_curve(samples: &[Sample], count: usize) -> Vec<Vec2> {
    let total: f64 = samples.iter().map(|sample| sample.depth).sum();
    let piece = total / count as f64;
    let mut moments = vec![(0.0, Vec2::ZERO); count];
    let mut before = 0.0;
    for sample in samples {
        let after = before + sample.depth;
        // A sample may reach over the ends of pieces: each takes its share.
        let first = ((before / piece) as usize).min(count - 1);
        let last = ((after / piece) as usize).min(count - 1);
        for (index, (share, moment)) in moments.iter_mut().enumerate().take(last + 1).skip(first) {
            let part = after.min((index + 1) as f64 * piece) - before.max(index as f64 * piece);
            *share += part.max(0.0);
            *moment += sample.position * part.max(0.0);
        }
        before = after;
    }
    moments.into_iter().map(|(share, moment)| moment / share).collect()
}

/// The particle nearest to each sample; none where a place is no number, which the tree refuses.
fn assign(samples: &[Sample], places: &[Vec2]) -> Option<Vec<usize>> {
    let corners: Vec<[f64; 2]> = places.iter().map(|place| [place.x, place.y]).collect();
    let tree = ImmutableKdTree::<f64, 2>::new_from_slice(&corners).ok()?;
    let nearest = |Sample { position, .. }: &Sample| {
        tree.query(&[position.x, position.y]).nearest_one::<SquaredEuclidean<f64>>().execute().item as usize
    };
    Some(samples.par_iter().map(nearest).collect())
}

/// One sweep of Lloyd's relaxation. A particle without samples stays where it is.
fn relax(samples: &[Sample], places: Vec<Vec2>) -> Vec<Vec2> {
    let Some(nearest) = assign(samples, &places) else { return places };
    let mut moments = vec![(0.0, Vec2::ZERO); places.len()];
    for (sample, &particle) in samples.iter().zip(&nearest) {
        let weight = sample.depth * sample.depth;
        moments[particle].0 += weight;
        moments[particle].1 += sample.position * weight;
    }
    let moved = |(place, (weight, moment)): (Vec2, (f64, Vec2))| if weight > 0.0 { moment / weight } else { place };
    places.into_iter().zip(moments).map(moved).collect()
}

/// Place of a point with coordinates below 2^bits along Hilbert's curve.
fn along_hilbert_curve(mut x: u64, mut y: u64, bits: u32) -> u64 {
    let mut place = 0;
    for bit in (0..bits).rev() {
        let (east, north) = ((x >> bit) & 1, (y >> bit) & 1);
        place = (place << 2) | ((3 * east) ^ north);
        // Turn the quadrant so that the curve enters and leaves it at the right corners.
        if north == 0 {
            if east == 1 {
                let mask = (1 << bit) - 1;
                (x, y) = (!x & mask, !y & mask);
            }
            (x, y) = (y, x);
        }
    }
    place
}

#[cfg(test)]
mod tests;
