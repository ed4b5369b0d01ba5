//! Neighbours of all particles: what each one sees, itself in walls included, stored per chunk of particles.

use rayon::prelude::*;

use crate::boundary::{Image, ImageScratch, Viewpoint, Walls};
use crate::math::Vec2;
use crate::neighbours::{CellGrid, Found, Span};

/// Number of particles in a chunk: the unit of parallel work, fixed so that no result depends on the number of threads.
pub const CHUNK: usize = 128;

/// Neighbours that are worked on side by side.
pub const LANES: usize = 8;

/// What one particle sees: particles, and their images in walls.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// Particles, filled up to whole groups with the one that sees them.
    indices: &'a [u32],
    count: usize,
    /// Under which of `Walls::isometries` each of them is seen; empty far from walls, where all are seen as they are.
    transforms: &'a [u32],
}

impl<'a> Seen<'a> {
    /// The first `count` particles of a list, under their isometries or, with none of those, as they are; what follows in the list
    /// is overwritten with the particle `i` that sees them.
    #[inline]
    pub fn filled_up(list: &'a mut Vec<u32>, count: usize, transforms: &'a [u32], i: u32) -> Self {
        debug_assert!(transforms.is_empty() || transforms.len() == count);
        let whole = count.next_multiple_of(LANES);
        if list.len() < whole {
            list.resize(whole, i);
        }
        list[count..whole].fill(i);
        Seen { indices: &list[..whole], count, transforms }
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
        self.indices[..self.count].iter().zip(transforms).map(|(&index, transform)| Image { index, transform })
    }

    /// The particles in whole groups, the last one filled up.
    #[inline]
    pub fn groups(&self) -> &'a [[u32; LANES]] {
        self.indices.as_chunks().0
    }

    /// How many particles are in the last group, without what fills it up.
    #[inline]
    pub fn in_last_group(&self) -> usize {
        LANES - (self.indices.len() - self.count)
    }

    /// The same in blocks of so many at most, a multiple of a group.
    #[inline]
    pub fn blocks(self, size: usize) -> impl Iterator<Item = Seen<'a>> {
        (0..self.indices.len()).step_by(size).map(move |first| {
            let block = first..(first + size).min(self.indices.len());
            let count = block.len().min(self.count - first);
            Seen {
                indices: &self.indices[block.clone()],
                count,
                transforms: self.transforms.get(first..first + count).unwrap_or(&[]),
            }
        })
    }
}

/// What the particles of one chunk see.
#[derive(Clone, Debug, Default)]
struct ChunkNeighbours {
    /// Where the spans of each particle begin, and, beside a wall, what it sees in their place; and the ends of the last ones.
    starts: Vec<[u32; 2]>,
    spans: Vec<Span>,
    indices: Vec<u32>,
    transforms: Vec<u32>,
}

/// Scratch space of a search; one for each thread.
#[derive(Clone, Debug, Default)]
struct SearchScratch {
    spans: Vec<Span>,
    found: Found,
    seen: Vec<Image>,
    images: ImageScratch,
}

impl ChunkNeighbours {
    fn clear(&mut self) {
        self.starts.clear();
        self.indices.clear();
        self.transforms.clear();
    }

    /// Takes the spans that were found. Room is made in pieces of one size, so that what one chunk gives back serves another: there
    /// are many chunks, and all of them change when the particles are sorted.
    fn keep(&mut self, spans: &[Span]) {
        const PIECE: usize = 64;
        if self.spans.capacity() < spans.len() {
            self.spans = Vec::new();
            self.spans.reserve_exact(spans.len().next_multiple_of(PIECE));
        }
        self.spans.clear();
        self.spans.extend_from_slice(spans);
    }

    /// Ends what a particle sees, so many spans being found so far.
    fn end(&mut self, spans: usize) {
        self.starts.push([spans as u32, self.indices.len() as u32]);
    }
}

impl SearchScratch {
    /// Fills `chunk` for so many particles from `first` on.
    fn search(
        &mut self,
        chunk: &mut ChunkNeighbours,
        grid: &CellGrid,
        (first, count): (usize, usize),
        positions: &[Vec2],
        supports: &[f64],
        walls: &Walls,
    ) {
        let SearchScratch { spans, found, seen, images } = self;
        let largest_support = grid.largest_support();
        chunk.clear();
        spans.clear();
        chunk.starts.reserve_exact(count + 1);
        chunk.end(0);
        for i in first..first + count {
            let (place, support) = (positions[i], supports[i]);
            if walls.is_clear(place, largest_support) {
                grid.spans_within(place, support, i as u32, spans);
                chunk.end(spans.len());
                continue;
            }
            let found = &*grid.within(place, support, found);
            let reach = found.iter().fold(support, |reach, &j| reach.max(supports[j as usize]));
            if walls.is_clear(place, reach) {
                grid.spans_within(place, support, i as u32, spans);
            } else {
                let from = Viewpoint { place, support, particle: Some(i as u32) };
                seen.clear();
                walls.see(&from, found, positions, supports, images, seen);
                chunk.indices.reserve_exact(seen.len());
                chunk.transforms.reserve_exact(seen.len());
                chunk.indices.extend(seen.iter().map(|image| image.index));
                chunk.transforms.extend(seen.iter().map(|image| image.transform));
            }
            chunk.end(spans.len());
        }
        chunk.keep(spans);
    }
}

/// What reaches a bare place; scratch space.
#[derive(Clone, Debug, Default)]
pub struct Glance {
    found: Found,
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
            scratch.search(neighbours, grid, (first, count), positions, supports, walls);
        });
    }

    /// What a particle sees, itself excluded; `list` is overwritten.
    #[inline]
    pub fn of<'a>(&'a self, i: usize, list: &'a mut Vec<u32>) -> Seen<'a> {
        let (chunk, k) = (&self.chunks[i / CHUNK], i % CHUNK);
        let ([first_span, first], [end_of_spans, end]) = (chunk.starts[k], chunk.starts[k + 1]);
        if first < end {
            let images = first as usize..end as usize;
            list.clear();
            list.extend_from_slice(&chunk.indices[images.clone()]);
            return Seen::filled_up(list, images.len(), &chunk.transforms[images], i as u32);
        }
        let count = self.grid.list(&chunk.spans[first_span as usize..end_of_spans as usize], list).len();
        Seen::filled_up(list, count, &[], i as u32)
    }

    /// The particles and images that act at a place where no particle stands: those that reach it by their own support.
    pub fn at<'a>(&self, place: Vec2, positions: &[Vec2], walls: &Walls, glance: &'a mut Glance) -> &'a [Image] {
        glance.seen.clear();
        let found = &*self.grid.within(place, 0.0, &mut glance.found);
        let reach = found.iter().fold(0.0_f64, |reach, &j| reach.max(self.supports[j as usize]));
        if walls.is_clear(place, reach) {
            glance.seen.extend(found.iter().map(|&index| Image { index, transform: 0 }));
        } else {
            let from = Viewpoint { place, support: reach, particle: None };
            walls.see(&from, found, positions, &self.supports, &mut glance.scratch, &mut glance.seen);
        }
        &glance.seen
    }

    /// The greatest distance (m) at which a particle acts.
    pub fn largest_support(&self) -> f64 {
        self.grid.largest_support()
    }

    /// Particle indices in the order of the cells of the latest search.
    pub fn order(&self) -> &[u32] {
        self.grid.order()
    }
}
