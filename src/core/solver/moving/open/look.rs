//! The water before the faces of open boundaries, as the moving particles tell it.
//!
//! A quantity X of the particles p that reach the face x_f by twice their own support goes there along the plane that fits them best,
//!
//! ```text
//! (M66)  X_f = X̄ + ∇X·(x_f − x̄),   ∇X = M⁺ Σ w (x − x̄)(X − X̄) / Σ w,   M = Σ w (x − x̄)(x − x̄)ᵀ / Σ w,   w = A W(|x_p − x_f|, 2 h_p)
//! ```
//!
//! with bars for means with the weights w: exact for a plane. M⁺ is the inverse of M where the particles tell a slope, and falls
//! to nothing where they stand in one place or one line.

use rayon::prelude::*;

use super::faces::Face;
use crate::bed::BedParticles;
use crate::math::{Sym2, Vec2};
use crate::neighbours::{CellGrid, Found};
use crate::particles::FluidParticles;
use crate::physics::dimension::Dimension;
use crate::physics::kernel::{CubicSpline, Shape, Smoothing};

/// Σ A W at a face from which on there is water before it; before the straight edge of a water it is a half.
const LEAST_COVER: f64 = 0.1;
/// The kernels of particles are so many times as wide as in their forces: with one side of a support alone there are moments in which
/// one particle tells all.
const WIDTH: f64 = 2.0;
/// The particles tell a slope along a direction in which they scatter by this share of their mean area, at least.
const LEAST_SCATTER: f64 = 0.05;

/// The water before a face.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::solver::moving) struct Seen {
    /// Σ A W.
    pub cover: f64,
    /// Level (m) at the face, and its gradient.
    pub surface: f64,
    pub gradient: Vec2,
    /// Velocity (m/s) at the face, and the gradients of its components (1/s).
    pub velocity: Vec2,
    pub along_u: Vec2,
    pub along_v: Vec2,
    /// Mean area of the particles (m²; in one dimension length, m).
    pub area: f64,
}

impl Seen {
    pub fn is_water(&self) -> bool {
        self.cover > LEAST_COVER
    }
}

/// Looks at the faces again and again with the same buffers.
#[derive(Debug)]
pub(in crate::solver::moving) struct Look {
    dimension: Dimension,
    kernel: Smoothing<CubicSpline>,
    /// Corners of the boxes around the faces of each boundary (m).
    boxes: Vec<[Vec2; 2]>,
    positions: Vec<Vec2>,
    supports: Vec<f32>,
    indices: Vec<u32>,
    samples: Vec<Sample>,
    grid: CellGrid,
}

/// A particle near a boundary.
#[derive(Clone, Copy, Debug)]
struct Sample {
    position: Vec2,
    velocity: Vec2,
    surface: f64,
    area: f64,
    inverse_h: f64,
}

impl Look {
    pub(super) fn new(faces: &[Face], lines: usize, dimension: Dimension) -> Self {
        let nothing = [Vec2::new(f64::INFINITY, f64::INFINITY), Vec2::new(f64::NEG_INFINITY, f64::NEG_INFINITY)];
        let mut boxes = vec![nothing; lines];
        for face in faces {
            let [low, high] = &mut boxes[face.line];
            for end in face.ends {
                *low = Vec2::new(low.x.min(end.x), low.y.min(end.y));
                *high = Vec2::new(high.x.max(end.x), high.y.max(end.y));
            }
        }
        Self::around(boxes, dimension)
    }

    /// Looks at one place (m).
    pub fn at(place: Vec2, dimension: Dimension) -> Self {
        Self::around(vec![[place, place]], dimension)
    }

    fn around(boxes: Vec<[Vec2; 2]>, dimension: Dimension) -> Self {
        Look {
            dimension,
            kernel: Smoothing::new(dimension),
            boxes,
            positions: Vec::new(),
            supports: Vec::new(),
            indices: Vec::new(),
            samples: Vec::new(),
            grid: CellGrid::default(),
        }
    }

    /// Lists the particles that reach a box by `widths` times their support.
    fn list(&mut self, particles: &FluidParticles, widths: f64) {
        self.positions.clear();
        self.supports.clear();
        self.indices.clear();
        for i in 0..particles.len() {
            let (place, support) =
                (particles.position[i], widths * CubicSpline::SUPPORT * particles.smoothing_length[i]);
            let is_near = |[low, high]: &[Vec2; 2]| {
                place.x > low.x - support
                    && place.x < high.x + support
                    && place.y > low.y - support
                    && place.y < high.y + support
            };
            if self.boxes.iter().any(is_near) {
                self.positions.push(place);
                self.supports.push(support as f32);
                self.indices.push(i as u32);
            }
        }
        self.grid.build(&self.positions, &self.supports);
    }

    /// The particles near a place of those that were listed last, by their index.
    pub fn near<'a>(&self, place: Vec2, reach: f64, found: &'a mut Found) -> &'a [u32] {
        let near = self.grid.within(place, reach, found);
        near.iter_mut().for_each(|k| *k = self.indices[*k as usize]);
        near
    }

    /// The particles up to a distance (m) from a place, the nearest first, of those that `gather` listed.
    pub fn nearest_first<'a>(&self, place: Vec2, reach: f64, found: &'a mut Found) -> &'a [u32] {
        let near = self.grid.within(place, reach, found);
        let squared = |k: u32| (self.positions[k as usize] - place).norm_squared();
        let index = |k: u32| self.indices[k as usize];
        near.sort_unstable_by(|&a, &b| squared(a).total_cmp(&squared(b)).then(index(a).cmp(&index(b))));
        let count = near.partition_point(|&k| squared(k) < reach * reach);
        near.iter_mut().for_each(|k| *k = index(*k));
        &near[..count]
    }

    /// Lists the particles near the boundaries for `nearest_first`.
    pub fn gather(&mut self, particles: &FluidParticles) {
        self.list(particles, 1.0);
    }

    /// Fills `seen` with the water before each face.
    pub(super) fn look(
        &mut self,
        faces: &[Face],
        particles: &FluidParticles,
        bed: &BedParticles,
        seen: &mut Vec<Seen>,
    ) {
        self.sample(particles, bed, |_, _| true);
        seen.resize(faces.len(), Seen::default());
        let this = &*self;
        seen.par_iter_mut().zip(faces).with_min_len(8).for_each_init(Found::default, |found, (seen, face)| {
            *seen = this.fit(face.middle, this.grid.within(face.middle, 0.0, found));
        });
    }

    /// The water at a place, that beyond ridges above its level left out.
    pub fn look_at(&mut self, place: Vec2, particles: &FluidParticles, bed: &BedParticles) -> Seen {
        self.sample(particles, bed, |position, surface| bed.sill(place, position) < surface);
        let mut found = Found::default();
        let found = self.grid.within(place, 0.0, &mut found).iter().copied();
        let counted: Vec<u32> = found.filter(|&k| self.samples[k as usize].area > 0.0).collect();
        self.fit(place, &counted)
    }

    /// Fills `samples` with the particles near the boxes; those that do not count, by place and level, have no area.
    fn sample(&mut self, particles: &FluidParticles, bed: &BedParticles, counts: impl Fn(Vec2, f64) -> bool) {
        self.list(particles, WIDTH);
        self.samples.clear();
        for &i in &self.indices {
            let (i, place) = (i as usize, particles.position[i as usize]);
            // Beside the terrain no level is known: such a particle counts nothing.
            let point = bed.at(place);
            let surface = point.map_or(0.0, |point| point.elevation) + particles.depth[i];
            let has_area = point.is_some() && counts(place, surface);
            self.samples.push(Sample {
                position: place,
                velocity: particles.velocity[i],
                surface,
                area: if has_area { particles.volume[i] / particles.depth[i] } else { 0.0 },
                inverse_h: 1.0 / (WIDTH * particles.smoothing_length[i]),
            });
        }
    }

    fn fit(&self, place: Vec2, found: &[u32]) -> Seen {
        let Some(&first) = found.first() else { return Seen::default() };
        // Levels count from that of one particle, so that a high datum costs no digits.
        let datum = self.samples[first as usize].surface;
        let samples = || {
            found.iter().map(|&p| {
                let sample = &self.samples[p as usize];
                let offset = sample.position - place;
                (sample, offset, sample.area * self.kernel.value(offset.norm(), sample.inverse_h))
            })
        };
        let mut mean = Means::default();
        for (sample, offset, w) in samples() {
            mean.weight += w;
            mean.area += w * sample.area;
            mean.offset += offset * w;
            mean.surface += w * (sample.surface - datum);
            mean.velocity += sample.velocity * w;
        }
        let whole = mean.weight;
        if whole <= 0.0 {
            return Seen::default();
        }
        let (offset, surface, velocity) = (mean.offset / whole, mean.surface / whole, mean.velocity / whole);
        let mut scatter = Sym2::default();
        let (mut rise, mut rise_u, mut rise_v) = (Vec2::ZERO, Vec2::ZERO, Vec2::ZERO);
        for (sample, at, w) in samples() {
            let way = at - offset;
            scatter.xx += w * way.x * way.x;
            scatter.xy += w * way.x * way.y;
            scatter.yy += w * way.y * way.y;
            rise += way * (w * (sample.surface - datum - surface));
            rise_u += way * (w * (sample.velocity.x - velocity.x));
            rise_v += way * (w * (sample.velocity.y - velocity.y));
        }
        let area = mean.area / whole;
        let least = LEAST_SCATTER * self.dimension.edge(area) * self.dimension.edge(area);
        let share = 1.0 / whole;
        let scatter = Sym2 { xx: scatter.xx * share, xy: scatter.xy * share, yy: scatter.yy * share };
        let inverse = inverse(scatter, least);
        let slope = |rise: Vec2| inverse.apply(rise * share);
        let (gradient, along_u, along_v) = (slope(rise), slope(rise_u), slope(rise_v));
        Seen {
            cover: whole,
            surface: datum + surface - gradient.dot(offset),
            gradient,
            velocity: velocity - Vec2::new(along_u.dot(offset), along_v.dot(offset)),
            along_u,
            along_v,
            area,
        }
    }
}

/// Sums over the particles before a face.
#[derive(Default)]
struct Means {
    weight: f64,
    area: f64,
    offset: Vec2,
    surface: f64,
    velocity: Vec2,
}

/// The inverse of a symmetric matrix along the directions in which its eigenvalue is at least `least`; below that, λ/least².
fn inverse(matrix: Sym2, least: f64) -> Sym2 {
    let (small, large) = matrix.eigenvalues();
    let invert = |lambda: f64| if lambda >= least { 1.0 / lambda } else { lambda.max(0.0) / (least * least) };
    let (f_small, f_large) = (invert(small), invert(large));
    let spread = large - small;
    let b = if spread > 1e-12 * large { (f_large - f_small) / spread } else { 0.0 };
    let a = f_small - b * small;
    Sym2 { xx: a + b * matrix.xx, xy: b * matrix.xy, yy: a + b * matrix.yy }
}
