//! Neighbours of all particles: what each one sees, itself in walls included, stored per chunk of particles.

use rayon::prelude::*;

use crate::boundary::{Image, ImageScratch, Viewpoint, Walls};
use crate::math::Vec2;
use crate::neighbours::CellGrid;

/// Number of particles in a chunk: the unit of parallel work, fixed so that no result depends on the number of threads.
pub const CHUNK: usize = 128;

/// What one particle sees: particles, and their images in walls.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// Particles.
    pub indices: &'a [u32],
    /// Under which of `Walls::isometries` each of them is seen; empty far from walls, where all are seen as they are.
    transforms: &'a [u32],
}

impl<'a> Seen<'a> {
    /// Particles, under their isometries or, with none of those, as they are.
    pub fn new(indices: &'a [u32], transforms: &'a [u32]) -> Self {
        debug_assert!(transforms.is_empty() || transforms.len() == indices.len());
        Seen { indices, transforms }
    }

    /// Whether images may be among what is seen.
    #[inline]
    pub fn has_images(&self) -> bool {
        !self.transforms.is_empty()
    }

    /// Under which of `Walls::isometries` the one at place `k` is seen; 0 is the particle itself.
    #[inline]
    pub fn transform(&self, k: usize) -> u32 {
        self.transforms.get(k).copied().unwrap_or(0)
    }

    /// All that is seen.
    pub fn iter(self) -> impl Iterator<Item = Image> + 'a {
        let transforms = self.transforms.iter().copied().chain(std::iter::repeat(0));
        self.indices.iter().zip(transforms).map(|(&index, transform)| Image { index, transform })
    }

    /// The same in blocks of so many at most.
    pub fn blocks(self, size: usize) -> impl Iterator<Item = Seen<'a>> {
        let all = self.indices.len();
        (0..all).step_by(size).map(move |first| {
            let block = first..(first + size).min(all);
            Seen::new(&self.indices[block.clone()], self.transforms.get(block).unwrap_or(&[]))
        })
    }
}

/// What the particles of one chunk see.
#[derive(Clone, Debug, Default)]
pub struct ChunkNeighbours {
    /// Where the indices of each particle begin, and its transforms, if it has any; and the ends of the last ones.
    starts: Vec<[u32; 2]>,
    indices: Vec<u32>,
    transforms: Vec<u32>,
}

/// Scratch space of a search; one for each thread.
#[derive(Clone, Debug, Default)]
struct SearchScratch {
    /// What a chunk sees, before it is known how much memory that needs.
    chunk: ChunkNeighbours,
    found: Vec<u32>,
    seen: Vec<Image>,
    images: ImageScratch,
}

impl ChunkNeighbours {
    /// What the particle at place `k` of the chunk sees, itself excluded.
    #[inline]
    pub fn of(&self, k: usize) -> Seen<'_> {
        let ([first, first_transform], [end, end_transform]) = (self.starts[k], self.starts[k + 1]);
        Seen::new(
            &self.indices[first as usize..end as usize],
            &self.transforms[first_transform as usize..end_transform as usize],
        )
    }

    fn clear(&mut self) {
        self.starts.clear();
        self.indices.clear();
        self.transforms.clear();
    }

    /// Takes over another one, with little more memory than that needs.
    fn copy_from(&mut self, other: &ChunkNeighbours) {
        fn copy<T: Copy>(values: &mut Vec<T>, others: &[T]) {
            values.clear();
            if values.capacity() < others.len() {
                values.reserve_exact(others.len() + others.len() / 8);
            }
            values.extend_from_slice(others);
        }
        copy(&mut self.starts, &other.starts);
        copy(&mut self.indices, &other.indices);
        copy(&mut self.transforms, &other.transforms);
    }
}

impl SearchScratch {
    /// Fills `chunk` for so many particles from `first` on.
    fn search(
        &mut self,
        grid: &CellGrid,
        (first, count): (usize, usize),
        positions: &[Vec2],
        supports: &[f64],
        walls: &Walls,
    ) {
        let SearchScratch { chunk, found, seen, images } = self;
        chunk.clear();
        chunk.starts.push([0, 0]);
        for i in first..first + count {
            let (place, support) = (positions[i], supports[i]);
            if walls.is_clear(place, grid.largest_support()) {
                grid.within(place, support, Some(i as u32), &mut chunk.indices);
            } else {
                found.clear();
                grid.within(place, support, None, found);
                let reach = found.iter().fold(support, |reach, &j| reach.max(supports[j as usize]));
                if walls.is_clear(place, reach) {
                    chunk.indices.extend(found.iter().filter(|&&j| j as usize != i));
                } else {
                    let from = Viewpoint { place, support, particle: Some(i as u32) };
                    seen.clear();
                    walls.see(&from, found, positions, supports, images, seen);
                    chunk.indices.extend(seen.iter().map(|image| image.index));
                    chunk.transforms.extend(seen.iter().map(|image| image.transform));
                }
            }
            chunk.starts.push([chunk.indices.len() as u32, chunk.transforms.len() as u32]);
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
        self.chunks.par_iter_mut().enumerate().for_each_init(SearchScratch::default, |scratch, (chunk, neighbours)| {
            let first = chunk * CHUNK;
            let count = CHUNK.min(positions.len() - first);
            scratch.search(grid, (first, count), positions, supports, walls);
            neighbours.copy_from(&scratch.chunk);
        });
    }

    /// The particles and images that act at a place where no particle stands: those that reach it by their own support.
    pub fn at<'a>(&self, place: Vec2, positions: &[Vec2], walls: &Walls, glance: &'a mut Glance) -> &'a [Image] {
        glance.found.clear();
        glance.seen.clear();
        self.grid.within(place, 0.0, None, &mut glance.found);
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
