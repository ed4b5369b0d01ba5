//! Neighbours of all particles: what each one sees, itself in walls included, stored per chunk of particles.

use std::ops::Range;

use rayon::prelude::*;

use crate::boundary::{Image, ImageScratch, Viewpoint, Walls};
use crate::math::Vec2;
use crate::neighbours::{CellGrid, Found, Span};
use crate::solver::scratch::Scratch;

/// Number of particles in a chunk: the unit of parallel work, fixed so that no result depends on the number of threads.
pub const CHUNK: usize = 128;

/// Chunks that a thread takes in one go, at most: what it has taken no other thread can take off it, which waits in the end.
pub const CHUNKS_AT_ONCE: usize = 16;

/// What one particle sees: particles, and their images in walls.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    indices: &'a [u32],
    /// Under which of `Walls::isometries` each of them is seen; empty far from walls, where all are seen as they are.
    transforms: &'a [u32],
}

impl<'a> Seen<'a> {
    /// All that is seen.
    pub fn iter(self) -> impl Iterator<Item = Image> + 'a {
        let transforms = self.transforms.iter().copied().chain(std::iter::repeat(0));
        self.indices.iter().zip(transforms).map(|(&index, transform)| Image { index, transform })
    }
}

/// What the particles of one chunk see.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
struct ChunkNeighbours {
    /// Where the spans of each particle end, and those of the next one begin.
    ends: Vec<u32>,
    spans: Vec<Span>,
    /// The particles beside walls, ascending by their places in the chunk, with the ends of what they see in place of spans.
    beside_walls: Vec<[u32; 2]>,
    indices: Vec<u32>,
    transforms: Vec<u32>,
}

/// Scratch space of a search; one for each thread.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
struct SearchScratch {
    /// As in `ChunkNeighbours`.
    chunk: ChunkNeighbours,
    found: Found,
    seen: Vec<Image>,
    images: ImageScratch,
}

/// Replaces what a chunk keeps. Room is made in pieces of one size, so that what one chunk gives back serves another: there are many
/// chunks, and all of them change when the particles are sorted. Room that one needed beside a wall is given back when it has left.
fn keep<T: Copy>(kept: &mut Vec<T>, found: &[T]) {
    const PIECE: usize = 64;
    kept.clear();
    let room = found.len().next_multiple_of(PIECE);
    if kept.capacity() < room {
        kept.reserve_exact(room);
    } else if kept.capacity() > room + room / 4 + PIECE {
        kept.shrink_to(room);
    }
    kept.extend_from_slice(found);
}

impl ChunkNeighbours {
    /// Where lies what the particle at place `k` of the chunk sees beside a wall; none for a particle that is clear of walls.
    #[inline]
    fn images_of(&self, k: usize) -> Option<Range<usize>> {
        if self.beside_walls.is_empty() {
            return None;
        }
        let place = self.beside_walls.binary_search_by_key(&(k as u32), |&[k, _]| k).ok()?;
        let first = place.checked_sub(1).map_or(0, |before| self.beside_walls[before][1]);
        Some(first as usize..self.beside_walls[place][1] as usize)
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
        supports: &[f32],
        walls: &Walls,
    ) {
        let SearchScratch { chunk: ChunkNeighbours { ends, spans, beside_walls, indices, transforms }, .. } = self;
        let (found, seen, images) = (&mut self.found, &mut self.seen, &mut self.images);
        let largest_support = grid.largest_support();
        ends.clear();
        spans.clear();
        beside_walls.clear();
        indices.clear();
        transforms.clear();
        for i in first..first + count {
            let (place, support) = (positions[i], f64::from(supports[i]));
            if walls.is_clear(place, largest_support) {
                grid.spans_within(place, support, i as u32, spans);
                ends.push(spans.len() as u32);
                continue;
            }
            let (near, found) = grid.spans_and_list_within(place, support, found);
            let reach = found.iter().fold(support, |reach, &j| reach.max(f64::from(supports[j as usize])));
            if walls.is_clear(place, reach) {
                // Nothing wide is near after all.
                grid.append_without(near, i as u32, spans);
            } else {
                let from = Viewpoint { place, support, particle: Some(i as u32) };
                seen.clear();
                walls.see(&from, found, positions, supports, images, seen);
                indices.extend(seen.iter().map(|image| image.index));
                transforms.extend(seen.iter().map(|image| image.transform));
                beside_walls.push([(i - first) as u32, indices.len() as u32]);
            }
            ends.push(spans.len() as u32);
        }
        keep(&mut chunk.ends, ends);
        keep(&mut chunk.spans, spans);
        keep(&mut chunk.beside_walls, beside_walls);
        keep(&mut chunk.indices, indices);
        keep(&mut chunk.transforms, transforms);
    }
}

/// The neighbours of all particles.
#[derive(Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Neighbours {
    grid: CellGrid,
    /// In single precision: a sliver of that size at the rim of a support is left out of the search anyway.
    supports: Vec<f32>,
    chunks: Vec<ChunkNeighbours>,
    scratch: Scratch<SearchScratch>,
}

impl Neighbours {
    /// Searches anew: j is seen by i when it is nearer than `reach` times the larger of the two smoothing lengths.
    pub fn search(&mut self, positions: &[Vec2], smoothing_lengths: &[f64], reach: f64, walls: &Walls) {
        let supports = smoothing_lengths.par_iter().with_min_len(CHUNK).map(|h| (reach * h) as f32);
        supports.collect_into_vec(&mut self.supports);
        self.grid.build(positions, &self.supports);
        self.chunks.resize_with(positions.len().div_ceil(CHUNK), ChunkNeighbours::default);
        let (grid, supports) = (&self.grid, &self.supports);
        let chunks = self.chunks.par_iter_mut().enumerate().with_max_len(CHUNKS_AT_ONCE);
        chunks.for_each(|(chunk, neighbours)| {
            let first = chunk * CHUNK;
            let count = CHUNK.min(positions.len() - first);
            let search = |scratch: &mut SearchScratch| {
                scratch.search(neighbours, grid, (first, count), positions, supports, walls)
            };
            self.scratch.with(search);
        });
    }

    /// What a particle sees, itself excluded; `list` is overwritten.
    #[inline]
    pub fn of<'a>(&'a self, i: usize, list: &'a mut Vec<u32>) -> Seen<'a> {
        let (chunk, k) = (&self.chunks[i / CHUNK], i % CHUNK);
        if let Some(images) = chunk.images_of(k) {
            return Seen { indices: &chunk.indices[images.clone()], transforms: &chunk.transforms[images] };
        }
        let first = k.checked_sub(1).map_or(0, |before| chunk.ends[before]);
        let spans = &chunk.spans[first as usize..chunk.ends[k] as usize];
        Seen { indices: self.grid.list(spans, list), transforms: &[] }
    }

    /// Particle indices in the order of the cells of the latest search.
    pub fn order(&self) -> &[u32] {
        self.grid.order()
    }
}
