//! Neighbours of all particles: what each one sees, itself in walls included, stored per chunk of particles.

use rayon::prelude::*;

use crate::boundary::{Image, ImageScratch, Viewpoint, Walls};
use crate::math::Vec2;
use crate::neighbours::CellGrid;

/// Number of particles in a chunk: the unit of parallel work, fixed so that no result depends on the number of threads.
pub const CHUNK: usize = 128;

/// What the particles of one chunk see.
#[derive(Clone, Debug, Default)]
pub struct ChunkNeighbours {
    starts: Vec<u32>,
    seen: Vec<Image>,
    found: Vec<u32>,
    scratch: ImageScratch,
}

impl ChunkNeighbours {
    /// What the particle at place `k` of the chunk sees, itself excluded.
    #[inline]
    pub fn of(&self, k: usize) -> &[Image] {
        &self.seen[self.starts[k] as usize..self.starts[k + 1] as usize]
    }

    /// Fills the chunk whose first particle is `first`.
    fn search(
        &mut self,
        grid: &CellGrid,
        first: usize,
        count: usize,
        positions: &[Vec2],
        supports: &[f64],
        walls: &Walls,
    ) {
        self.starts.clear();
        self.seen.clear();
        self.starts.push(0);
        for i in first..first + count {
            self.found.clear();
            grid.within(positions[i], supports[i], &mut self.found);
            let reach = || self.found.iter().fold(supports[i], |reach, &j| reach.max(supports[j as usize]));
            if walls.is_clear(positions[i], grid.largest_support()) || walls.is_clear(positions[i], reach()) {
                let others = self.found.iter().filter(|&&j| j as usize != i);
                self.seen.extend(others.map(|&index| Image { index, transform: 0 }));
            } else {
                let from = Viewpoint { place: positions[i], support: supports[i], particle: Some(i as u32) };
                walls.see(&from, &self.found, positions, supports, &mut self.scratch, &mut self.seen);
            }
            self.starts.push(self.seen.len() as u32);
        }
    }
}

/// What reaches a bare place; scratch space.
#[derive(Clone, Debug, Default)]
pub struct Glance {
    found: Vec<u32>,
    seen: Vec<Image>,
    scratch: ImageScratch,
}

/// The neighbours of all particles.
#[derive(Clone, Debug, Default)]
pub struct Neighbours {
    grid: CellGrid,
    supports: Vec<f64>,
    chunks: Vec<ChunkNeighbours>,
}

impl Neighbours {
    /// Searches anew: j is seen by i when it is nearer than `reach` times the larger of the two smoothing lengths.
    pub fn search(&mut self, positions: &[Vec2], smoothing_lengths: &[f64], reach: f64, walls: &Walls) {
        self.supports.clear();
        self.supports.extend(smoothing_lengths.iter().map(|h| reach * h));
        self.grid.build(positions, &self.supports);
        self.chunks.resize_with(positions.len().div_ceil(CHUNK), ChunkNeighbours::default);
        let (grid, supports) = (&self.grid, &self.supports);
        self.chunks.par_iter_mut().enumerate().for_each(|(chunk, neighbours)| {
            let first = chunk * CHUNK;
            let count = CHUNK.min(positions.len() - first);
            neighbours.search(grid, first, count, positions, supports, walls);
        });
    }

    /// The particles and images that act at a place where no particle stands: those that reach it by their own support.
    pub fn at<'a>(&self, place: Vec2, positions: &[Vec2], walls: &Walls, glance: &'a mut Glance) -> &'a [Image] {
        glance.found.clear();
        glance.seen.clear();
        self.grid.within(place, 0.0, &mut glance.found);
        let reach = glance.found.iter().fold(0.0_f64, |reach, &j| reach.max(self.supports[j as usize]));
        if walls.is_clear(place, reach) {
            glance.seen.extend(glance.found.iter().map(|&index| Image { index, transform: 0 }));
        } else {
            let from = Viewpoint { place, support: reach, particle: None };
            walls.see(&from, &glance.found, positions, &self.supports, &mut glance.scratch, &mut glance.seen);
        }
        &glance.seen
    }

    /// The greatest distance (m) at which a particle acts.
    pub fn largest_support(&self) -> f64 {
        self.grid.largest_support()
    }

    /// The chunks, in the order of the particles.
    pub fn chunks(&self) -> &[ChunkNeighbours] {
        &self.chunks
    }

    /// Particle indices in the order of the cells of the latest search.
    pub fn order(&self) -> &[u32] {
        self.grid.order()
    }
}
