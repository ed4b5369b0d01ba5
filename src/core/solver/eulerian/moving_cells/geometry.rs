//! The partition of a moment: cells with their areas, and their faces.
//!
//! A face of length l between particles i and j at a distance r has the normal n = (x_j − x_i)/r; its middle lies a way c beside that of both, along the
//! face. A_i = Σ l r/4 over its faces. Faces shorter than a rounding error are none.

use rayon::prelude::*;

use super::{CHUNK, MovingCells};
use crate::math::Vec2;

/// Faces shorter than this (in spacings) are rounding.
const ROUNDING: f64 = 1e-9;

/// No face of its own.
pub(super) const IN_ROWS: u32 = u32::MAX;

/// The way from a cell to one of its neighbours, over the face between both.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Way {
    /// The neighbour.
    pub to: u32,
    /// The number of the face in the chunk of the cell that owns it, [`IN_ROWS`] where the rows have it.
    pub face: u32,
    /// Whether the cell owns it.
    pub is_own: bool,
    /// The unit normal away from the cell.
    pub normal: Vec2,
    /// The length of the face, the distance of the neighbour, and the way along the face from the middle of both to its own (m).
    pub length: f64,
    pub distance: f64,
    pub along: f64,
}

impl Way {
    /// What multiplies a difference in a gradient (M105), over the area.
    #[inline]
    pub fn weight(&self) -> Vec2 {
        (self.normal * 0.5 + self.normal.perpendicular() * (self.along / self.distance)) * self.length
    }
}

/// A face, owned by its first cell.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Face {
    pub ends: [u32; 2],
    pub normal: Vec2,
    pub length: f64,
    pub distance: f64,
    pub along: f64,
}

/// Ways and faces of the cells of a chunk.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct Chunk {
    /// Where the ways of each cell begin.
    starts: Vec<u32>,
    ways: Vec<Way>,
    pub faces: Vec<Face>,
}

impl Chunk {
    /// The ways of a cell, by its number in the chunk; none where it is not active.
    #[inline]
    pub fn ways(&self, k: usize) -> &[Way] {
        match (self.starts.get(k), self.starts.get(k + 1)) {
            (Some(&from), Some(&to)) => &self.ways[from as usize..to as usize],
            _ => &[],
        }
    }

    fn clear(&mut self) {
        self.starts.clear();
        self.ways.clear();
        self.faces.clear();
    }
}

impl MovingCells {
    /// Finds areas, ways and faces of the active cells: of all, or where cells have become active or were exchanged.
    pub(super) fn partition(&mut self, is_all: bool) {
        let shortest = ROUNDING * self.ground.lattice().spacing;
        let MovingCells { chunks, cells, mesh, is_active, is_stale, area, centroid, is_beside_idle, .. } = self;
        let (mesh, cells, is_active) = (&*mesh, &*cells, &*is_active);
        let arrays = (area.par_chunks_mut(CHUNK), centroid.par_chunks_mut(CHUNK), is_beside_idle.par_chunks_mut(CHUNK));
        let all = (chunks, arrays.0, arrays.1, arrays.2, is_stale).into_par_iter();
        all.enumerate().for_each(|(number, (chunk, area, centroid, is_beside_idle, is_stale))| {
            if !std::mem::take(is_stale) && !is_all {
                return;
            }
            chunk.clear();
            let first = number * CHUNK;
            if !is_active[first..first + area.len()].contains(&true) {
                return;
            }
            for k in 0..area.len() {
                chunk.starts.push(chunk.ways.len() as u32);
                let i = first + k;
                if !is_active[i] {
                    continue;
                }
                let own = mesh.place(i as u32);
                is_beside_idle[k] = false;
                let (mut sum, mut moment) = (0.0, Vec2::ZERO);
                let mut right: Option<Vec2> = None;
                for spoke in mesh.around(i as u32) {
                    is_beside_idle[k] |= !is_active[spoke.to as usize] && !cells[spoke.to as usize].is_fixed();
                    let right_centre = right.unwrap_or_else(|| mesh.centre(spoke.sides[0]));
                    let left_centre = mesh.centre(spoke.sides[1]);
                    right = Some(left_centre);
                    let way = mesh.place(spoke.to) - own;
                    let distance = way.norm();
                    let normal = way / distance;
                    let tangent = normal.perpendicular();
                    let length = (left_centre - right_centre).dot(tangent);
                    if length <= shortest {
                        continue;
                    }
                    let (from, to) = (right_centre - own, left_centre - own);
                    let along = 0.5 * (from + to).dot(tangent);
                    let part = length * distance;
                    sum += part;
                    moment += (from + to) * part;
                    let to = spoke.to as usize;
                    let is_own = !cells[to].is_fixed() && (!is_active[to] || i < to);
                    let face = if is_own { chunk.faces.len() as u32 } else { IN_ROWS };
                    if is_own {
                        chunk.faces.push(Face { ends: [i as u32, spoke.to], normal, length, distance, along });
                    }
                    chunk.ways.push(Way { to: spoke.to, face, is_own, normal, length, distance, along });
                }
                area[k] = 0.25 * sum;
                centroid[k] = if sum > 0.0 { own + moment / (3.0 * sum) } else { own };
            }
            chunk.starts.push(chunk.ways.len() as u32);
        });
        self.link();
    }

    /// Finds the faces of the ways that do not own theirs.
    fn link(&mut self) {
        let MovingCells { chunks, links, .. } = self;
        let chunks = &*chunks;
        links.par_iter_mut().zip(chunks.par_iter()).enumerate().for_each(|(number, (links, chunk))| {
            links.clear();
            for k in 0..chunk.starts.len().saturating_sub(1) {
                let i = (number * CHUNK + k) as u32;
                for way in chunk.ways(k) {
                    let (of, at) = (way.to as usize / CHUNK, way.to as usize % CHUNK);
                    // Cells that rest in the rows have no ways back.
                    let back = || chunks[of].ways(at).iter().find(|back| back.to == i);
                    let face = if way.is_own { way.face } else { back().map_or(IN_ROWS, |back| back.face) };
                    links.push(face);
                }
            }
        });
    }

    /// The ways of a cell, each with the chunk and the number of its face; no number where the rows have it or there is none.
    #[inline]
    pub(super) fn ways_and_faces(&self, i: usize) -> impl Iterator<Item = (&Way, (usize, u32))> {
        let (number, k) = (i / CHUNK, i % CHUNK);
        let chunk = &self.chunks[number];
        let from = chunk.starts.get(k).map_or(0, |&from| from as usize);
        let links = &self.links[number];
        chunk.ways(k).iter().enumerate().map(move |(n, way)| {
            let of = if way.is_own { number } else { way.to as usize / CHUNK };
            (way, (of, links[from + n]))
        })
    }
}
