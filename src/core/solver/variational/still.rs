//! What still water would do in the place of a particle: the level of its water, and the slope of the bed that balances still water.
//!
//! Still water of a level L on the cells b of the lattice sums up to a depth and pushes a particle as the particles of that water would.
//! L_i is the level at which that depth is the particle's own; what that water pushes is taken from what the water around it does (M116).
//! ```text
//! d_i = L_i − z_i + Σ_b A e_b W,   e_b = z_i + ∇z_b·x_ib − z_b + [z_b − L_i]₊
//! a_still = g ∇z_b − (g/λ) Σ_b A e_b ∇W,   λ = −Σ A r W'/dim of the lattice
//! ```
//! e is over the tangent plane of the bed at i, whose own water is that of a whole lattice, plus that of what walls show beyond one.
//! Over a plane bed under water this is g ∇z_b. Where particles j stand on ground above L_i, their A_j [z_j − L_i]₊ are taken off e: what is wet
//! there is no bank. So a film on a slope is driven by the whole slope, and a lake rests at its shore. A particle whose own ground stands out of
//! that water is a film without a lake about it: by 1 + (L_i − z_i)/d_i, between 0 and 1, all of this gives way to L_i = z_i + d_i and g ∇z_b.

use rayon::prelude::*;

use super::{CHUNK, Density, MovingWater, Seen, Variational, inverse_of_pair, with_kernel};
use crate::bed::BedPoint;
use crate::boundary::{Edge, Image, ImageScratch, Viewpoint};
use crate::gridding::cells_within;
use crate::math::{Vec2, segments_cross};
use crate::physics::dimension::Dimension;
use crate::physics::kernel::{Shape, Smoothing};

/// β over that of still water is held within this factor of 1: a lonely particle has no β.
const MOST_GRAD_H: f64 = 3.0;
/// Newton's steps for the level. The sums are linear between the heights of cells.
const MOST_ROUNDS: usize = 30;
/// Less than this of a lattice is taken for this much.
const LEAST_SHARE: f64 = 0.1;

/// A cell or a particle near a particle.
#[derive(Clone, Copy, Debug)]
struct Near {
    height: f64,
    /// A W.
    share: f64,
    /// A W' e (1/m), e from the particle to it.
    slope: Vec2,
    /// A r W'.
    moment: f64,
}

/// Scratch space of a thread.
#[derive(Debug, Default)]
struct Around {
    indices: Vec<u32>,
    found: Vec<u32>,
    seen: Vec<Image>,
    images: ImageScratch,
    cells: Vec<Near>,
    others: Vec<Near>,
    /// What walls show of the lattice beyond what a whole one has.
    surplus: Sums,
    near_walls: Vec<u32>,
}

/// Sums of e over what is near a particle.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    share: f64,
    slope: Vec2,
    moment: f64,
}

impl Sums {
    fn add(&mut self, near: &Near, height: f64) {
        self.share += near.share * height;
        self.slope += near.slope * height;
        self.moment += near.moment * height;
    }
}

impl Variational {
    /// Sets level, push of still water and β over that of still water in `densities`.
    pub(super) fn compare_with_still_water(&mut self, water: &MovingWater) {
        let mut densities = std::mem::take(&mut self.densities);
        let of_chunk = |around: &mut Around, (chunk, densities): (usize, &mut [Density])| {
            for (k, density) in densities.iter_mut().enumerate() {
                let i = chunk * CHUNK + k;
                with_kernel!(&self.kernel, kernel => self.compare(kernel, water, i, density, around));
            }
        };
        densities.par_chunks_mut(CHUNK).enumerate().for_each_init(Around::default, of_chunk);
        self.densities = densities;
    }

    fn compare<S: Shape>(
        &self,
        kernel: &Smoothing<S>,
        water: &MovingWater,
        i: usize,
        density: &mut Density,
        around: &mut Around,
    ) {
        let (ground, place) = (self.grounds[i], water.particles.position[i]);
        if !ground.elevation.is_finite() {
            (density.level, density.still, density.grad_h) =
                (density.depth, Vec2::ZERO, 1.0 / density.raw_beta.max(1.0 / MOST_GRAD_H));
            return;
        }
        let mut sums = Sums::default();
        let highest = self.list_cells(kernel, water, (place, &ground), density, (around, &mut sums));
        let mut list = std::mem::take(&mut around.indices);
        let seen = water.neighbours.of(i, &mut list);
        let highest = highest.max(self.list_others(kernel, water, i, seen, &mut around.others));
        around.indices = list;
        let whole = (1.0 + around.surplus.share).max(LEAST_SHARE);
        let mut level = ground.elevation + (density.depth - sums.share) / whole;
        if level < highest {
            level = level_of(level, whole, around);
            for cell in around.cells.iter().filter(|cell| cell.height > level) {
                sums.add(cell, cell.height - level);
            }
            for other in around.others.iter().filter(|other| other.height > level) {
                sums.add(other, level - other.height);
            }
        }
        let still = level - ground.elevation;
        let part = part_of_still_water(still, density.depth);
        sums.slope += around.surplus.slope * still;
        sums.moment += around.surplus.moment * still;
        let depth = density.depth + part * (still - density.depth);
        density.level = ground.elevation + depth;
        density.still = ground.slope * water.gravity + sums.slope * (part * water.gravity / self.lattice_moment);
        let beta = (self.lattice_moment * depth - part * sums.moment / self.dimension.count()) / density.depth;
        density.grad_h = grad_h(beta, density.raw_beta) / self.lattice_moment;
    }

    /// Lists the cells near a place, and sums what their heights differ from the plane bed of the place. Returns the greatest height.
    fn list_cells<S: Shape>(
        &self,
        kernel: &Smoothing<S>,
        water: &MovingWater,
        (place, ground): (Vec2, &BedPoint),
        density: &Density,
        (around, sums): (&mut Around, &mut Sums),
    ) -> f64 {
        let lattice = &water.bed.lattice;
        let inverse_h = inverse_of_pair(density.inverse_h.powi(-2), (self.factor * lattice.spacing).powi(2));
        let reach = kernel.support() / inverse_h;
        around.cells.clear();
        around.surplus = Sums::default();
        let area = self.dimension.area(lattice.spacing);
        let mut highest = f64::NEG_INFINITY;
        let mut take = |cell: usize, offset: Vec2| {
            let r = offset.norm();
            if r >= reach {
                return;
            }
            let (height, weight) = (water.bed.elevation[cell], area * kernel.slope(r, inverse_h));
            let share = area * kernel.value(r, inverse_h);
            let near = Near { height, share, slope: offset * (weight / r.max(f64::MIN_POSITIVE)), moment: weight * r };
            sums.add(&near, ground.elevation + ground.slope.dot(offset) - height);
            highest = highest.max(height);
            around.cells.push(near);
        };
        let (south, north) = match self.dimension {
            Dimension::One => (0, 1),
            Dimension::Two => cells_within(place.y, reach, lattice.spacing, lattice.rows),
        };
        let (west, east) = cells_within(place.x, reach, lattice.spacing, lattice.columns);
        let cells = (south..north).flat_map(|row| (west..east).map(move |column| (column, row)));
        let with_terrain =
            cells.map(|(column, row)| lattice.index(column, row)).filter(|&cell| water.bed.has_terrain(cell));
        if water.walls.is_clear(place, reach) {
            for cell in with_terrain {
                take(cell, self.along(lattice.centre(cell) - place));
            }
        } else {
            around.found.clear();
            around.found.extend(with_terrain.map(|cell| cell as u32));
            around.seen.clear();
            let from = Viewpoint { place, support: reach, particle: None };
            let (centres, supports) = (&water.cell_centres, &water.cell_supports);
            water.walls.see(&from, &around.found, centres, supports, &mut around.images, &mut around.seen);
            for image in &around.seen {
                let centre = centres[image.index as usize];
                let centre = water.walls.isometries()[image.transform as usize].point(centre);
                take(image.index as usize, self.along(centre - place));
            }
            self.compare_with_whole_lattice(kernel, water, (place, ground.slope), inverse_h, (around, sums));
        }
        highest
    }

    /// Beside walls, where the lattice and its images may have more or less than a whole lattice: sets what they have beyond it, and takes
    /// that of the tangent plane out of the sums. What is missing beyond an open edge is left out: no water is there.
    fn compare_with_whole_lattice<S: Shape>(
        &self,
        kernel: &Smoothing<S>,
        water: &MovingWater,
        (place, tilt): (Vec2, Vec2),
        inverse_h: f64,
        (around, sums): (&mut Around, &mut Sums),
    ) {
        let (lattice, reach) = (&water.bed.lattice, kernel.support() / inverse_h);
        let area = self.dimension.area(lattice.spacing);
        let Around { seen, surplus, near_walls, .. } = around;
        let mut add = |offset: Vec2, sign: f64| {
            let r = offset.norm();
            if r < reach {
                let weight = area * kernel.slope(r, inverse_h);
                let slope = offset * (weight / r.max(f64::MIN_POSITIVE));
                let share = area * kernel.value(r, inverse_h);
                let near = Near { height: 0.0, share, slope, moment: weight * r };
                surplus.add(&near, sign);
                sums.add(&near, -sign * tilt.dot(offset));
            }
        };
        for image in seen.iter() {
            let centre = water.cell_centres[image.index as usize];
            add(self.along(water.walls.isometries()[image.transform as usize].point(centre) - place), 1.0);
        }
        water.walls.near(place, reach, near_walls);
        near_walls.retain(|&edge| water.walls.edges()[edge as usize].is_open);
        let is_left = |centre: Vec2| {
            let crosses = |edge: &Edge| segments_cross([place, centre], [edge.start, edge.end]);
            near_walls.iter().any(|&edge| crosses(&water.walls.edges()[edge as usize]))
        };
        let along_axis = |from: f64| {
            let (first, last) = ((from - reach) / lattice.spacing, (from + reach) / lattice.spacing);
            (first.floor() as i64..=last.floor() as i64).map(|cell| (cell as f64 + 0.5) * lattice.spacing)
        };
        for y in along_axis(place.y) {
            if self.dimension == Dimension::One && (y - place.y).abs() >= 0.5 * lattice.spacing {
                continue;
            }
            for centre in along_axis(place.x).map(|x| Vec2::new(x, y)).filter(|&centre| !is_left(centre)) {
                add(self.along(centre - place), -1.0);
            }
        }
    }

    /// An offset, along the channel alone in one dimension.
    fn along(&self, offset: Vec2) -> Vec2 {
        match self.dimension {
            Dimension::One => Vec2::new(offset.x, 0.0),
            Dimension::Two => offset,
        }
    }

    /// Lists the particles near a particle, itself included. Returns the greatest height of their bed.
    fn list_others<S: Shape>(
        &self,
        kernel: &Smoothing<S>,
        water: &MovingWater,
        i: usize,
        seen: Seen<'_>,
        others: &mut Vec<Near>,
    ) -> f64 {
        let particles = &water.particles;
        let h_squared = |j: usize| particles.smoothing_length[j].powi(2);
        others.clear();
        let area = |j: usize| particles.volume[j] / particles.depth[j];
        let height = self.grounds[i].elevation;
        let share = area(i) * kernel.value(0.0, 1.0 / particles.smoothing_length[i]);
        others.push(Near { height, share, slope: Vec2::ZERO, moment: 0.0 });
        let mut highest = height;
        for image in seen.iter() {
            let j = image.index as usize;
            let height = self.grounds[j].elevation;
            if !height.is_finite() {
                continue;
            }
            let other = water.walls.isometries()[image.transform as usize].point(particles.position[j]);
            let offset = other - particles.position[i];
            let r = offset.norm();
            let of_pair = inverse_of_pair(h_squared(i), h_squared(j));
            let (share, weight) = (area(j) * kernel.value(r, of_pair), area(j) * kernel.slope(r, of_pair));
            highest = highest.max(height);
            others.push(Near {
                height,
                share,
                slope: offset * (weight / r.max(f64::MIN_POSITIVE)),
                moment: weight * r,
            });
        }
        highest
    }
}

/// The level at which still water has the depth of the particle, from the one that it would have if nothing stood above it.
///
/// `whole` is Σ A W of the lattice and its images, 1 but beside walls.
fn level_of(submerged: f64, whole: f64, around: &Around) -> f64 {
    let mut level = submerged;
    for _ in 0..MOST_ROUNDS {
        // What the sums are above the level, and how they change with it.
        let (mut excess, mut slope) = (0.0, whole);
        for (near, sign) in
            around.cells.iter().map(|near| (near, 1.0)).chain(around.others.iter().map(|near| (near, -1.0)))
        {
            if near.height > level {
                excess += sign * near.share * (near.height - level);
                slope -= sign * near.share;
            }
        }
        let change = (whole * (submerged - level) - excess) / slope.max(LEAST_SHARE);
        level += change;
        if change.abs() <= 1e-14 * level.abs().max(1.0) {
            break;
        }
    }
    level
}

/// By how much still water is the measure of a particle: 1 where its ground is under that water, 0 where its ground stands out of it by
/// the depth of the particle. `still` is the depth (m) of that water over the ground, below 0 where the ground stands out.
fn part_of_still_water(still: f64, depth: f64) -> f64 {
    (1.0 + still / depth).clamp(0.0, 1.0)
}

/// β of still water over that of the particle.
fn grad_h(still: f64, own: f64) -> f64 {
    let (most, least) = (MOST_GRAD_H * own.abs(), own.abs() / MOST_GRAD_H);
    if most > 0.0 { still.clamp(least, most) / own.abs() } else { 1.0 }
}
