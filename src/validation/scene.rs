//! Made problems: beds that follow a function, lattices and disordered arrangements of particles.

use crate::bed::BedParticles;
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::particles::FluidSeed;
use crate::scenario::GRAVITY;
use crate::solver::{FlowProblem, Forcing, OpenEdges};

/// Depth (m) below which water does not move in the made problems, unless they say otherwise: far below what any of them resolves.
const DRY_DEPTH: f64 = 1e-6;
/// Particles that would be shallower (m) are not seeded.
const SHALLOWEST_SEED: f64 = 1e-4;

/// A dry problem on a lattice whose bed follows a function of the place; walls all around, no friction.
pub fn problem(columns: usize, rows: usize, spacing: f64, bed: impl Fn(Vec2) -> f64) -> FlowProblem {
    // Away from the origin, so that a mix-up of map and local coordinates shows.
    let lattice = Lattice::new(Vec2::new(1000.0, 2000.0), columns, rows, spacing);
    let elevation = (0..lattice.len()).map(|index| bed(lattice.centre(index))).collect();
    FlowProblem {
        initial_depth: vec![0.0; lattice.len()],
        bed: BedParticles::from_elevation(lattice, elevation, 0.0),
        walls: Vec::new(),
        open_edges: OpenEdges::default(),
        forcing: Forcing::default(),
        gravity: GRAVITY,
        courant: 0.4,
        dry_depth: DRY_DEPTH,
    }
}

/// A channel along x: a lattice of one row, `length` (m) long.
pub fn flat_strip(length: f64, spacing: f64, bed: impl Fn(f64) -> f64) -> FlowProblem {
    problem((length / spacing).round() as usize, 1, spacing, |place| bed(place.x))
}

/// One particle on each wet cell of a channel; its volume is per metre of width (m²).
pub fn line_seeds(problem: &FlowProblem) -> Vec<FluidSeed> {
    let lattice = &problem.bed.lattice;
    let wet = (0..lattice.len()).filter(|&cell| problem.initial_depth[cell] > 0.0);
    wet.map(|cell| {
        let depth = problem.initial_depth[cell];
        FluidSeed { position: lattice.centre(cell), volume: depth * lattice.spacing, depth }
    })
    .collect()
}

/// Seeds where `level` lies above the bed: one at each place, its volume `area` (m²) times its depth.
pub fn seeds_at(problem: &FlowProblem, places: &[Vec2], area: f64, level: impl Fn(Vec2) -> f64) -> Vec<FluidSeed> {
    let seed = |&position: &Vec2| {
        let depth = level(position) - problem.bed.at(position)?.elevation;
        (depth > SHALLOWEST_SEED).then_some(FluidSeed { position, volume: area * depth, depth })
    };
    places.iter().filter_map(seed).collect()
}

/// Places on a square lattice over a rectangle from the origin, each moved by up to `jitter` spacings in each direction, always
/// in the same way.
pub fn jittered_lattice(width: f64, height: f64, spacing: f64, jitter: f64) -> Vec<Vec2> {
    let mut state = 7_u64;
    let mut next = move || {
        // Knuth's linear congruential generator: the same arrangement on every machine.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let (columns, rows) = ((width / spacing).round() as usize, (height / spacing).round() as usize);
    (0..columns * rows)
        .map(|index| {
            let centre = Vec2::new((index % columns) as f64 + 0.5, (index / columns) as f64 + 0.5);
            (centre + Vec2::new(next(), next()) * (2.0 * jitter)) * spacing
        })
        .collect()
}
