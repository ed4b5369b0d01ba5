//! Gridding: the water of the particles of the variational formulation onto the lattice, with volume and momentum conserved.
//!
//! Particle j gives its volume to the cells c under its kernel W, in proportion to the root of the water column that its level leaves
//! there, and its momentum in the same shares:
//!
//! ```text
//! ŵ_jc = m_c w_jc / Σ_c' m_c' w_jc',   w_jc = W(|x_c − x_j|) √max(η_j − z_c, 0),   η_j = z_b(x_j) + d_j
//! d_c = Σ_j V_j ŵ_jc / Δ²,    (d v)_c = Σ_j V_j v_j ŵ_jc / Δ²
//! ```
//!
//! So nothing lands on ground above the surface of the particle nor beyond it or a wall, as seen straight from the particle, nor
//! where there is no terrain. The root draws a lake at rest level over a curved bed: with S the smoothing by W, d_c = √d S(d / S √d) is d
//! to second order in the width of W. (Shares by the column itself are off by half the second moment of W times ∇²d.) The support of W is
//! 4/3 h, two spacings where h is 1.5 spacings: the sum of such kernels over a lattice of particles is even within 0.3 %, and has no holes
//! where their distances are up to twice as wide. It is never less than 1.5 cells, so that particles closer together than cells leave
//! none, either.
//!
//! Such particles are never evenly spaced, and where they crowd together or stand apart, and beside walls, cells would be too full or
//! too empty by some percent: maxima would gather that noise. So some sweeps bring the factors m_c, 1 at first, nearer to what gives every
//! cell the mean column over it, D_c, where the particles cover the cell (S_c near 1):
//!
//! ```text
//! D_c = Σ_j A_j w_jc (η_j − z_c) / Σ_j A_j w_jc,   S_c = Σ_j A_j w_jc / (κ_j √D_c),   κ_j = Σ_c Δ² W(|x_c − x_j|)
//! m_c ← m_c [1 + ω t_c (D_c / d_c − 1)],   t_c = clamp((S_c − 0.6) / 0.2, 0, 1) where d_c < D_c, else 1
//! ```
//!
//! with κ over the cells that get water from j and those of ground above its level: 1 but beside walls, where A_j / κ_j stands for A_j in
//! the mean columns, too. At a front, where S_c falls to zero, the grid stays as the kernels draw it. The sweeps are those of matrix
//! scaling, which leave Ŵ² of an unevenness that W smooths by Ŵ; growing ω reach as far in five sweeps as twelve do with ω = 1.
//!
//! What a particle has to say about its cells is computed once and kept for all sweeps, for a rectangle of the lattice: four cells of a row
//! are worked on side by side. Bands of rows are filled side by side as well, each by its particles in ascending
//! order: the same bits for any number of threads.

use std::array::from_fn;
use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use crate::bed::BedParticles;
use crate::boundary::Walls;
use crate::lattice::{FlatWater, Lattice, Span, WaterOnLattice};
use crate::math::{Vec2, larger, smaller};
use crate::particles::{FluidParticles, Line};
use crate::physics::dimension::Dimension;
use crate::physics::kernel::{CubicSpline, Shape, Smoothing};

/// Support radius over smoothing length.
const SUPPORT: f64 = 4.0 / 3.0;
/// Smallest support radius, in cells.
const SMALLEST_SUPPORT: f64 = 1.5;
/// Rows of a band. Fixed, since it decides the order of the sums.
const BAND: usize = 16;
/// Particles whose shares are kept together.
const CHUNK: usize = 256;
/// Chunks that a thread takes in one go, at most: what it has taken no other thread can take off it, which waits in the end.
const CHUNKS_AT_ONCE: usize = 8;
/// ω of each sweep that evens out the grid after the first filling. A sweep leaves 1 − ω (1 − Ŵ²) of an unevenness that the kernel smooths
/// by Ŵ: the first ω is for that of single cells, the last ones are for what is wide.
const RELAXATIONS: [f64; 5] = [1.0, 1.2, 1.7, 2.6, 5.0];
/// Width of the rim of a kernel, as a share of its radius, where it is next to nothing.
const RIM: f64 = 1e-9;
/// Bounds of the change of a factor in one sweep, so that no weight vanishes or runs away.
const FACTOR_BOUNDS: (f64, f64) = (0.25, 2.0);
/// Coverage S_c up to which cells are not made fuller, and from which on they are wholly. A straight front has 0.5.
pub(crate) const COVERED: (f64, f64) = (0.6, 0.8);

/// What a particle says about a cell. Shares are sums of such numbers: they lose no volume by being short.
type Weight = f32;
/// Cells of a row that are worked on side by side.
const LANES: usize = 4;
/// Numbers of as many cells. Sums are taken of whole lanes: the compiler makes one instruction of four only where nothing is stored between.
type Lanes = [f64; LANES];

/// The cells about a particle: a rectangle of the lattice.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
struct Patch {
    row: u32,
    column: u32,
    rows: u32,
    columns: u32,
    /// Where its weights begin, row by row.
    start: u32,
    spare: u32,
}

/// What a particle says about the cells of its patch, beside their weights.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
struct Share {
    patch: Patch,
    /// η (m); zero where the area is.
    level: f64,
    /// A W(0) / κ; zero where the particle gives all of its water to one cell.
    area: f64,
    /// V / (Δ² Σ m_c w) (m^½).
    scale: f64,
}

impl Patch {
    /// The cells about a place (m) as far as a kernel reaches (m), in whole runs of lanes where the lattice is wide enough: these are faster,
    /// and what is not under the kernel gets nothing.
    #[inline(always)]
    fn under(place: Vec2, support: f64, lattice: &Lattice) -> Patch {
        // The kernel is zero at its rim.
        let inner = (1.0 - RIM) * support;
        let (south, north) = cells_within(place.y, inner, lattice.spacing, lattice.rows);
        let (west, east) = cells_within(place.x, inner, lattice.spacing, lattice.columns);
        let columns = (east - west).next_multiple_of(LANES);
        let east = (west + columns).min(lattice.columns);
        let west = west.min(east.saturating_sub(columns));
        Patch {
            row: south as u32,
            column: west as u32,
            rows: (north - south) as u32,
            columns: (east - west) as u32,
            start: 0,
            spare: 0,
        }
    }

    /// Number of cells.
    fn len(&self) -> usize {
        self.rows as usize * self.columns as usize
    }

    /// Its rows, clipped to those of a band.
    fn rows_within(&self, first: usize, end: usize) -> Range<usize> {
        let row = self.row as usize;
        row.max(first)..(row + self.rows as usize).min(end)
    }
}

/// The shares of a chunk of particles.
#[derive(Debug)]
struct Shares<'a> {
    of: &'a mut [Share],
    /// w = f(|x_c − x_j|) √max(η − z, 0) with f = W/W(0), to be multiplied with the factor of the cell; 0 where nothing goes. Those of the
    /// patches for which there is room.
    weights: &'a mut [Weight],
    /// Those of all other patches, as soon as it is known how many these are.
    overflow: &'a mut [Weight],
    overflowing: usize,
    /// The walls near a particle.
    near: &'a mut Vec<u32>,
}

/// What the weights of a patch come down to.
struct Summed {
    weights: f64,
    /// Cells under the kernel that are not below the level, or without terrain.
    dry: f64,
}

impl Shares<'_> {
    /// Calls `act` for each of the rows of a patch that lies in a range of them: its number and its weights.
    #[inline(always)]
    fn for_each_row(&self, patch: &Patch, (first, end): (usize, usize), mut act: impl FnMut(usize, &[Weight])) {
        let (rows, columns) = (patch.rows_within(first, end), patch.columns as usize);
        let from = patch.start as usize;
        let all = match from.checked_sub(self.weights.len()) {
            None => &self.weights[from..from + patch.len()],
            Some(from) => &self.overflow[from..from + patch.len()],
        };
        let mut left = &all[(rows.start - patch.row as usize) * columns..];
        for row in rows {
            let (weights, next) = left.split_at(columns);
            left = next;
            act(row, weights);
        }
    }

    /// The weights of a patch.
    #[inline(always)]
    fn of_patch(&mut self, patch: &Patch) -> &mut [Weight] {
        let from = patch.start as usize;
        match from.checked_sub(self.weights.len()) {
            None => &mut self.weights[from..from + patch.len()],
            Some(from) => &mut self.overflow[from..from + patch.len()],
        }
    }

    /// Lays out the patches of the particles from `first` on, and counts the weights for which there is no room.
    fn lay_out(&mut self, lattice: &Lattice, particles: &FluidParticles, first: usize) {
        let (room, mut used) = (self.weights.len(), 0);
        self.overflowing = 0;
        for (k, share) in self.of.iter_mut().enumerate() {
            let (place, h) = (particles.position[first + k], particles.smoothing_length[first + k]);
            share.patch = Patch::under(place, support(h, lattice.spacing), lattice);
            let count = share.patch.len();
            if used + count <= room {
                share.patch.start = used as u32;
                used += count;
            } else {
                share.patch.start = (room + self.overflowing) as u32;
                self.overflowing += count;
            }
        }
    }

    /// The share of particle `j`, with the weights of its patch.
    #[inline(always)]
    fn share_of(
        &mut self,
        measures: &Measures,
        (bed, walls): (&BedParticles, &Walls),
        particles: &FluidParticles,
        (mut patch, j): (Patch, usize),
    ) -> Share {
        let (place, depth) = (particles.position[j], particles.depth[j]);
        let support = support(particles.smoothing_length[j], bed.lattice.spacing);
        let mut level = bed.at(place).map_or(f64::NEG_INFINITY, |point| point.elevation + depth);
        let inverse_h = CubicSpline::SUPPORT / support;
        let mut area = if depth > 0.0 { particles.volume[j] / depth * measures.kernel.at_zero(inverse_h) } else { 0.0 };
        let sight = Sight { place, level, support };
        let mut sum = self.weigh(measures, bed, &patch, &sight);
        if sum.dry > 0.0 || !walls.is_clear(place, support) {
            let seen = self.keep_in_sight(measures, &patch, &sight, (bed, walls), &mut sum);
            area /= seen * measures.kernel.at_zero(inverse_h) * measures.cell_area;
        }
        // A film so thin that the reciprocal overflows counts as none: its water goes to the lowest cell.
        let mut scale = particles.volume[j] / (measures.cell_area * sum.weights);
        if !(1.0 / (sum.weights * measures.cell_area)).is_finite() {
            (level, area) = (0.0, 0.0);
            patch = match home_or_lowest(bed, &patch, &sight) {
                Some(cell) => {
                    let (column, row) = bed.lattice.column_row(cell);
                    Patch { row: row as u32, column: column as u32, rows: 1, columns: 1, ..patch }
                }
                None => Patch { rows: 0, columns: 0, ..patch },
            };
            self.of_patch(&patch).fill(1.0);
            scale = particles.volume[j] / measures.cell_area;
        }
        Share { patch, level, area, scale }
    }

    /// Adds the weights of a patch, wherever walls and ridges are.
    #[inline(always)]
    fn weigh(&mut self, measures: &Measures, bed: &BedParticles, patch: &Patch, sight: &Sight) -> Summed {
        let (lattice, place) = (&bed.lattice, sight.place);
        let inverse_h = CubicSpline::SUPPORT / sight.support;
        let (mut sums, mut dry) = ([0.0; LANES], [0.0; LANES]);
        let columns = patch.columns as usize;
        let mut out = self.of_patch(patch);
        let west = (f64::from(patch.column) + 0.5) * lattice.spacing - place.x;
        for row in 0..patch.rows as usize {
            let north = ((patch.row as usize + row) as f64 + 0.5) * lattice.spacing - place.y;
            let first = (patch.row as usize + row) * lattice.columns + patch.column as usize;
            for from in (0..columns).step_by(LANES) {
                let count = (columns - from).min(LANES);
                // Lanes without a cell are out of reach.
                let mut elevation = [f64::INFINITY; LANES];
                let from_west = west + from as f64 * lattice.spacing;
                let mut east: Lanes = from_fn(|k| from_west + k as f64 * lattice.spacing);
                let ground = &bed.elevation[first + from..][..count];
                if let Ok(four) = <&Lanes>::try_from(ground) {
                    elevation = *four;
                } else {
                    elevation[..count].copy_from_slice(ground);
                    east[count..].fill(f64::INFINITY);
                }
                let distance: Lanes = from_fn(|k| (east[k] * east[k] + north * north).sqrt());
                let share: Lanes = from_fn(|k| measures.kernel.share(distance[k], inverse_h));
                let column: Lanes = from_fn(|k| larger(sight.level - elevation[k], 0.0));
                let weights: [Weight; LANES] = from_fn(|k| (share[k] * column[k].sqrt()) as Weight);
                sums = plus(sums, widened(&weights));
                // Not a number (no terrain) compares as false.
                let is_dry = |k: usize| (share[k] > 0.0) & (column[k] <= 0.0);
                dry = plus(dry, from_fn(|k| if is_dry(k) { 1.0 } else { 0.0 }));
                let (here, next) = out.split_at_mut(count);
                out = next;
                if let Ok(four) = <&mut [Weight; LANES]>::try_from(&mut *here) {
                    *four = weights;
                } else {
                    here.copy_from_slice(&weights[..count]);
                }
            }
        }
        Summed { weights: total(sums), dry: total(dry) }
    }

    /// Takes out the cells beyond walls and ridges, and beyond ground above the level; returns Σ W/W(0)
    /// of those left and of dry ground, and sets the sum of the weights.
    #[cold]
    fn keep_in_sight(
        &mut self,
        measures: &Measures,
        patch: &Patch,
        sight: &Sight,
        (bed, walls): (&BedParticles, &Walls),
        sum: &mut Summed,
    ) -> f64 {
        let (mut weights, mut seen) = (0.0, 0.0);
        let lattice = &bed.lattice;
        let first = (patch.column as usize, patch.row as usize);
        let mut near = std::mem::take(self.near);
        walls.near(sight.place, sight.support, &mut near);
        let cells_of = |row: usize| {
            let start = (first.1 + row) * lattice.columns + first.0;
            start..start + patch.columns as usize
        };
        // Not a number (no terrain) compares as false.
        let is_under_water = |row: usize| bed.elevation[cells_of(row)].iter().all(|&ground| ground < sight.level);
        let is_open = (0..patch.rows as usize).all(is_under_water);
        for (row, row_of_weights) in self.of_patch(patch).chunks_mut((patch.columns as usize).max(1)).enumerate() {
            walls.hide(&near, sight.place, lattice, (first.0, first.1 + row), row_of_weights);
            for (cell, weight) in cells_of(row).zip(row_of_weights) {
                if *weight <= 0.0 {
                    // A film on a slope, most of whose cells are dry, covers no more than it does on level ground.
                    if bed.elevation[cell] >= sight.level {
                        let distance = (lattice.centre(cell) - sight.place).norm();
                        seen += measures.kernel.share(distance, CubicSpline::SUPPORT / sight.support);
                    }
                    continue;
                }
                if is_open || bed.is_in_sight(sight.place, sight.level, cell) {
                    weights += f64::from(*weight);
                    seen += f64::from(*weight) / (sight.level - bed.elevation[cell]).sqrt();
                } else {
                    *weight = 0.0;
                }
            }
        }
        *self.near = near;
        sum.weights = weights;
        seen
    }

    /// Finds the scales under the factors of the cells.
    fn scale(
        &mut self,
        measures: &Measures,
        particles: &FluidParticles,
        (factors, columns): (&[f64], usize),
        first: usize,
    ) {
        let mut sums = [0.0; CHUNK];
        let sums = &mut sums[..self.of.len()];
        add_up(self, factors, columns, sums);
        for ((share, sum), volume) in self.of.iter_mut().zip(sums).zip(&particles.volume[first..]) {
            share.scale = volume / (measures.cell_area * *sum);
        }
    }
}

/// Gives each chunk room for the weights that overflow: in the pieces that are lent, one after the other, and the last chunks in memory
/// of our own, one piece that grows by little more than is needed.
fn make_room<'a>(chunks: &mut [Shares<'a>], mut spare: &'a mut [Weight], own: &'a mut Vec<Weight>) {
    let mut placed = 0;
    while let Some(chunk) = chunks.get_mut(placed).filter(|chunk| chunk.overflowing <= spare.len()) {
        chunk.overflow = spare.split_off_mut(..chunk.overflowing).unwrap_or_default();
        placed += 1;
    }
    let rest = &mut chunks[placed..];
    let count = rest.iter().map(|chunk| chunk.overflowing).sum::<usize>();
    if own.capacity() < count {
        own.reserve_exact(count + count / 16 - own.len());
    }
    own.resize(count.max(own.len()), 0.0);
    let mut left = &mut own[..];
    for chunk in rest {
        chunk.overflow = left.split_off_mut(..chunk.overflowing).unwrap_or_default();
    }
}

/// From where a particle sees cells.
struct Sight {
    place: Vec2,
    /// Its level (m).
    level: f64,
    /// Radius (m) of its kernel.
    support: f64,
}

/// The cell in which a particle stands, or the lowest one under its kernel; none where there is no terrain.
#[cold]
fn home_or_lowest(bed: &BedParticles, patch: &Patch, sight: &Sight) -> Option<usize> {
    let lattice = &bed.lattice;
    let (row, column) = (patch.row as usize, patch.column as usize);
    let rows = row..row + patch.rows as usize;
    let columns = column..column + patch.columns as usize;
    let cells = rows.flat_map(|row| columns.clone().map(move |column| lattice.index(column, row)));
    let under = cells.filter(|&cell| {
        bed.has_terrain(cell) && (lattice.centre(cell) - sight.place).norm_squared() <= sight.support * sight.support
    });
    let lowest = under.min_by(|&a, &b| bed.elevation[a].total_cmp(&bed.elevation[b]));
    lattice.cell_at(sight.place).filter(|&cell| bed.has_terrain(cell)).or(lowest)
}

/// Weights as numbers to reckon with.
#[inline(always)]
fn widened(weights: &[Weight; LANES]) -> Lanes {
    from_fn(|k| f64::from(weights[k]))
}

#[inline(always)]
fn plus(a: Lanes, b: Lanes) -> Lanes {
    from_fn(|k| a[k] + b[k])
}

#[inline(always)]
fn times(a: Lanes, b: Lanes) -> Lanes {
    from_fn(|k| a[k] * b[k])
}

#[inline(always)]
fn total(lanes: Lanes) -> f64 {
    // One after another: sums of pairs make the compiler take two lanes at a time all the way up.
    lanes[0] + lanes[1] + lanes[2] + lanes[3]
}

/// Weighs the cells of each particle from `first` on, and finds its scale under factors of 1.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn weigh_chunk(
    shares: &mut Shares<'_>,
    measures: &Measures,
    ground: (&BedParticles, &Walls),
    particles: &FluidParticles,
    first: usize,
) {
    for k in 0..shares.of.len() {
        shares.of[k] = shares.share_of(measures, ground, particles, (shares.of[k].patch, first + k));
    }
}

/// Σ m_c w of each particle.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn add_up(shares: &Shares<'_>, factors: &[f64], columns: usize, sums: &mut [f64]) {
    for (Share { patch, .. }, sum) in shares.of.iter().zip(sums) {
        let mut lanes = [0.0; LANES];
        let mut rest = 0.0;
        shares.for_each_row(patch, (0, usize::MAX), |row, weights| {
            let (weights, last) = weights.as_chunks::<LANES>();
            let from = row * columns + patch.column as usize;
            let (factors, last_factors) = factors[from..from + patch.columns as usize].as_chunks::<LANES>();
            for (weights, factors) in weights.iter().zip(factors) {
                lanes = plus(lanes, times(*factors, widened(weights)));
            }
            rest += last.iter().zip(last_factors).map(|(weight, factor)| factor * f64::from(*weight)).sum::<f64>();
        });
        *sum = total(lanes) + rest;
    }
}

/// What turns volumes into depths.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
struct Measures {
    kernel: Smoothing<CubicSpline>,
    /// Area of a cell (m²; in one dimension its length, m).
    cell_area: f64,
}

/// Coverage and mean column of a cell from its sums.
fn balance(weight: &mut f64, column: &mut f64) {
    let mean = *column / *weight;
    let coverage = *weight / mean.sqrt();
    *weight = ((coverage - COVERED.0) / (COVERED.1 - COVERED.0)).clamp(0.0, 1.0);
    *column = mean;
}

/// The factor of a cell, brought nearer to the one that gives it the mean column, with its depth under a factor of 1.
#[inline(always)]
fn improved(factor: f64, depth: f64, (part, mean): (f64, f64), relaxation: f64) -> f64 {
    let change = relaxation * (mean / (factor * depth) - 1.0);
    let change = if change < 0.0 { change } else { part * change };
    // Not a number (no water, or none that counts) compares as false.
    if change.abs() < f64::INFINITY {
        factor * smaller(larger(1.0 + change, FACTOR_BOUNDS.0), FACTOR_BOUNDS.1)
    } else {
        factor
    }
}

/// Improves the factors of cells that were filled.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn improve(factors: &mut [f64], depth: &[f64], (part, mean): (&[f64], &[f64]), relaxation: f64) {
    let n = factors.len();
    let (depth, part, mean) = (&depth[..n], &part[..n], &mean[..n]);
    for k in 0..n {
        factors[k] = improved(factors[k], depth[k], (part[k], mean[k]), relaxation);
    }
}

/// One band of rows: the columns touched in each row, now and at the call before, and the spans that result.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
struct Band {
    touched: Vec<(usize, usize)>,
    touched_before: Vec<(usize, usize)>,
    /// Those that reach into the band, in ascending order.
    particles: Vec<u32>,
    spans: Vec<Span>,
}

/// Grids particles again and again with the same buffers.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Gridder {
    measures: Measures,
    lattice: Lattice,
    water: FlatWater,
    /// Whether a cell had water after the call before.
    was_wet: Vec<bool>,
    /// The weights for which there is no room in what is lent.
    overflow: Vec<Weight>,
    /// Scratch space of each chunk: the walls near a particle.
    near: Vec<Vec<u32>>,
    /// Room of its own, where it is given none.
    own: ([Vec<Line>; 2], Vec<f64>),
    bands: Vec<Band>,
    spans: Vec<Span>,
    stray_volume: f64,
}

impl Gridder {
    /// A gridder for the lattice of a bed; in one dimension a lattice of one row, whose particles carry volumes per width.
    pub fn new(lattice: &Lattice, dimension: Dimension) -> Self {
        let cells = lattice.len();
        let bands = (0..lattice.rows.div_ceil(BAND)).map(|band| {
            let rows = BAND.min(lattice.rows - band * BAND);
            Band { touched: vec![(0, 0); rows], touched_before: vec![(0, 0); rows], ..Band::default() }
        });
        let cell_area = match dimension {
            Dimension::One => lattice.spacing,
            Dimension::Two => lattice.cell_area(),
        };
        Gridder {
            measures: Measures { kernel: Smoothing::new(dimension), cell_area },
            lattice: lattice.clone(),
            water: FlatWater::dry(lattice),
            was_wet: vec![false; cells],
            overflow: Vec::new(),
            near: Vec::new(),
            own: Default::default(),
            bands: bands.collect(),
            spans: Vec::new(),
            stray_volume: 0.0,
        }
    }

    /// Grids the particles over the bed, between the walls. The spans hold every cell with water now or after the call before.
    pub fn grid(&mut self, bed: &BedParticles, walls: &Walls, particles: &FluidParticles) -> WaterOnLattice<'_> {
        debug_assert_eq!(bed.lattice, self.lattice);
        let ([mut shares, mut weights], mut factors) = std::mem::take(&mut self.own);
        for lines in [&mut shares, &mut weights] {
            lines.resize(particles.len(), Line::default());
        }
        factors.resize(self.lattice.len(), 1.0);
        let measures = self.measures;
        let (mut overflow, mut near) = (std::mem::take(&mut self.overflow), std::mem::take(&mut self.near));
        near.resize_with(particles.len().div_ceil(CHUNK), Vec::default);
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut shares);
        let (of, beside) = bytes.split_at_mut(particles.len() * size_of::<Share>());
        let of: &mut [Share] = bytemuck::cast_slice_mut(of);
        let chunks = of.par_chunks_mut(CHUNK).zip(weights.par_chunks_mut(CHUNK)).zip(&mut near).enumerate();
        let mut all: Vec<Shares<'_>> = chunks
            .map(|(chunk, ((of, weights), near))| {
                let weights = bytemuck::cast_slice_mut(weights);
                let mut shares = Shares { of, weights, overflow: &mut [], overflowing: 0, near };
                shares.lay_out(&bed.lattice, particles, chunk * CHUNK);
                shares
            })
            .collect();
        make_room(&mut all, bytemuck::cast_slice_mut(beside), &mut overflow);
        all.par_iter_mut()
            .enumerate()
            .with_max_len(CHUNKS_AT_ONCE)
            .for_each(|(chunk, shares)| weigh_chunk(shares, &measures, (bed, walls), particles, chunk * CHUNK));
        self.sort_into_bands(&all, particles);
        for sweep in 0..=RELAXATIONS.len() {
            if sweep > 0 {
                let factors = (&factors[..], bed.lattice.columns);
                let all = all.par_iter_mut().enumerate().with_max_len(CHUNKS_AT_ONCE);
                all.for_each(|(chunk, shares)| shares.scale(&measures, particles, factors, chunk * CHUNK));
            }
            self.fill_bands(&all, bed, (particles, &mut factors), sweep);
        }
        (self.overflow, self.near) = (overflow, near);
        self.own = ([shares, weights], factors);
        self.spans.clear();
        self.bands.iter().for_each(|band| self.spans.extend_from_slice(&band.spans));
        self.water()
    }

    /// The water at the latest call of `grid`; dry before the first one.
    pub fn water(&self) -> WaterOnLattice<'_> {
        WaterOnLattice { rows: &self.water, lattice: &self.lattice, spans: &self.spans }
    }

    fn fill_bands(
        &mut self,
        shares: &[Shares<'_>],
        bed: &BedParticles,
        (particles, factors): (&FluidParticles, &mut [f64]),
        sweep: usize,
    ) {
        let columns = bed.lattice.columns;
        let cells = BAND * columns.max(1);
        self.bands
            .par_iter_mut()
            .zip(self.water.depth.par_chunks_mut(cells))
            .zip(self.water.discharge_x.par_chunks_mut(cells).zip(self.water.discharge_y.par_chunks_mut(cells)))
            .zip(factors.par_chunks_mut(cells).zip(self.was_wet.par_chunks_mut(cells)))
            .enumerate()
            .with_max_len(1)
            .for_each(|(number, (((band, depth), (weight_or_flow_x, column_or_flow_y)), (factors, was_wet)))| {
                let rows = number * BAND..number * BAND + depth.len() / columns.max(1);
                let mut fields = Fields { rows, columns, depth, weight_or_flow_x, column_or_flow_y, factors };
                band.empty(&mut fields, sweep);
                if sweep == 0 {
                    band.touch_all(&mut fields, shares);
                    cover(&band.particles, &mut fields, shares, &bed.elevation);
                } else if sweep < RELAXATIONS.len() {
                    fill(&band.particles, &mut fields, shares);
                }
                if sweep < RELAXATIONS.len() {
                    band.improve(&mut fields, sweep);
                } else {
                    fill_with_discharges(&band.particles, &mut fields, particles, shares);
                    band.weight_by_factors(&mut fields);
                    band.collect_spans(&fields, was_wet);
                }
            });
    }

    /// Volume (m³) that found no cell with terrain at the last call: particles off the terrain by more than their support.
    pub fn stray_volume(&self) -> f64 {
        self.stray_volume
    }

    /// Lists, for each band, the particles that reach into it, in ascending order; sums the stray volume.
    fn sort_into_bands(&mut self, all: &[Shares<'_>], particles: &FluidParticles) {
        let reaches = all.par_iter().enumerate().map(|(chunk, shares)| {
            let mut reach = Reach { first: usize::MAX, end: 0, stray_volume: 0.0 };
            for (Share { patch, .. }, volume) in shares.of.iter().zip(&particles.volume[chunk * CHUNK..]) {
                if patch.rows == 0 {
                    reach.stray_volume += volume;
                } else {
                    let rows = patch.rows_within(0, usize::MAX);
                    (reach.first, reach.end) = (reach.first.min(rows.start), reach.end.max(rows.end));
                }
            }
            reach
        });
        let reaches: Vec<Reach> = reaches.collect();
        self.stray_volume = reaches.iter().map(|reach| reach.stray_volume).sum();
        self.bands
            .par_iter_mut()
            .enumerate()
            .with_max_len(1)
            .for_each(|(number, band)| band.take_particles(number * BAND..(number + 1) * BAND, all, &reaches));
    }
}

/// The rows that a chunk of particles reaches, and the volume (m³) that reaches none.
struct Reach {
    /// First row, and one past the last; the other way round where the chunk reaches none.
    first: usize,
    end: usize,
    stray_volume: f64,
}

/// The part of the grids that belongs to one band.
struct Fields<'a> {
    /// Rows of the band.
    rows: Range<usize>,
    columns: usize,
    depth: &'a mut [f64],
    /// What decides how full each cell may be, Σ A w (m^½) at first, then how far the particles cover the cell, from 0 to 1; in the last
    /// sweep the discharge to the east (m²/s).
    weight_or_flow_x: &'a mut [f64],
    /// Σ A w (η − z) (m^3/2) at first, then the mean column D_c (m), not a number where there is none; in the last sweep the discharge to
    /// the north (m²/s).
    column_or_flow_y: &'a mut [f64],
    factors: &'a mut [f64],
}

impl Fields<'_> {
    /// The cells of the band.
    fn cells(&self) -> Range<usize> {
        let first = self.rows.start * self.columns;
        first..first + self.depth.len()
    }
}

/// Calls `act` for each row of each of the particles in the band: particle, its share, its weights in that row, and where they go.
#[inline(always)]
fn for_each_row(
    particles: &[u32],
    (rows, columns): (Range<usize>, usize),
    shares: &[Shares<'_>],
    mut act: impl FnMut(usize, &Share, &[Weight], usize),
) {
    for &particle in particles {
        let j = particle as usize;
        let chunk = &shares[j / CHUNK];
        let share = &chunk.of[j % CHUNK];
        chunk.for_each_row(&share.patch, (rows.start, rows.end), |row, weights| {
            act(j, share, weights, (row - rows.start) * columns + share.patch.column as usize);
        });
    }
}

/// Fills the band with the water of its particles under factors of 1; sums weights and columns of the cells.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn cover(particles: &[u32], fields: &mut Fields, shares: &[Shares<'_>], elevation: &[f64]) {
    let elevation = &elevation[fields.cells()];
    for_each_row(particles, (fields.rows.clone(), fields.columns), shares, |_, share, weights, place| {
        let Share { scale, area, level, .. } = *share;
        let cells = place..place + weights.len();
        let (depth, sum) = (&mut fields.depth[cells.clone()], &mut fields.weight_or_flow_x[cells.clone()]);
        let (column, elevation) = (&mut fields.column_or_flow_y[cells.clone()], &elevation[cells]);
        let (fours, rest) = weights.as_chunks::<LANES>();
        let (depths, last_depths) = depth.as_chunks_mut::<LANES>();
        let (sums, last_sums) = sum.as_chunks_mut::<LANES>();
        let (columns, last_columns) = column.as_chunks_mut::<LANES>();
        let (elevations, last_elevations) = elevation.as_chunks::<LANES>();
        for ((((weight, depth), sum), column), elevation) in
            fours.iter().zip(depths).zip(sums).zip(columns).zip(elevations)
        {
            let weight = widened(weight);
            let covered = times([area; LANES], weight);
            let height: Lanes = from_fn(|k| larger(level - elevation[k], 0.0));
            (*depth, *sum, *column) = (
                plus(*depth, times([scale; LANES], weight)),
                plus(*sum, covered),
                plus(*column, times(covered, height)),
            );
        }
        for (k, weight) in rest.iter().enumerate() {
            let weight = f64::from(*weight);
            last_depths[k] += scale * weight;
            last_sums[k] += area * weight;
            last_columns[k] += area * weight * larger(level - last_elevations[k], 0.0);
        }
    });
}

/// Fills the band with Σ_j V_j / (Δ² Σ_c' m_c' w_jc') w_jc, which is d_c / m_c.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn fill(particles: &[u32], fields: &mut Fields, shares: &[Shares<'_>]) {
    for_each_row(
        particles,
        (fields.rows.clone(), fields.columns),
        shares,
        |_, &Share { scale, .. }, weights, place| {
            let cells = place..place + weights.len();
            let (depths, last_depths) = fields.depth[cells].as_chunks_mut::<LANES>();
            let (weights, rest) = weights.as_chunks::<LANES>();
            for (weight, depth) in weights.iter().zip(depths) {
                *depth = plus(*depth, times([scale; LANES], widened(weight)));
            }
            for (weight, depth) in rest.iter().zip(last_depths) {
                *depth += scale * f64::from(*weight);
            }
        },
    );
}

/// The same with the momentum of its particles.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2"))]
fn fill_with_discharges(particles: &[u32], fields: &mut Fields, fluid: &FluidParticles, shares: &[Shares<'_>]) {
    for_each_row(
        particles,
        (fields.rows.clone(), fields.columns),
        shares,
        |j, &Share { scale, .. }, weights, place| {
            let velocity = fluid.velocity[j];
            let cells = place..place + weights.len();
            let (depths, last_depths) = fields.depth[cells.clone()].as_chunks_mut::<LANES>();
            let (flows_x, last_flows_x) = fields.weight_or_flow_x[cells.clone()].as_chunks_mut::<LANES>();
            let (flows_y, last_flows_y) = fields.column_or_flow_y[cells].as_chunks_mut::<LANES>();
            let (weights, rest) = weights.as_chunks::<LANES>();
            for (((weight, depth), flow_x), flow_y) in weights.iter().zip(depths).zip(flows_x).zip(flows_y) {
                let share = times([scale; LANES], widened(weight));
                let (with_x, with_y) = (times([velocity.x; LANES], share), times([velocity.y; LANES], share));
                (*depth, *flow_x, *flow_y) = (plus(*depth, share), plus(*flow_x, with_x), plus(*flow_y, with_y));
            }
            for (k, weight) in rest.iter().enumerate() {
                let share = scale * f64::from(*weight);
                last_depths[k] += share;
                last_flows_x[k] += velocity.x * share;
                last_flows_y[k] += velocity.y * share;
            }
        },
    );
}

impl Band {
    /// Lists the particles that reach into the rows of the band, in ascending order.
    fn take_particles(&mut self, rows: Range<usize>, shares: &[Shares<'_>], reaches: &[Reach]) {
        self.particles.clear();
        let is_near = |reach: &Reach| reach.first < rows.end && reach.end > rows.start;
        for (chunk, _) in reaches.iter().enumerate().filter(|(_, reach)| is_near(reach)) {
            let of_chunk = shares[chunk].of.iter().enumerate();
            let inside = of_chunk.filter(|(_, share)| !share.patch.rows_within(rows.start, rows.end).is_empty());
            self.particles.extend(inside.map(|(k, _)| (chunk * CHUNK + k) as u32));
        }
    }

    /// Notes which columns the particles touch, and begins there with factors of 1.
    fn touch_all(&mut self, fields: &mut Fields, shares: &[Shares<'_>]) {
        for &particle in &self.particles {
            let patch = &shares[particle as usize / CHUNK].of[particle as usize % CHUNK].patch;
            let (from, to) = (patch.column as usize, patch.column as usize + patch.columns as usize);
            for row in patch.rows_within(fields.rows.start, fields.rows.end) {
                let touched = &mut self.touched[row - fields.rows.start];
                *touched = if touched.0 == touched.1 { (from, to) } else { (touched.0.min(from), touched.1.max(to)) };
            }
        }
        for (i, &(from, to)) in self.touched.iter().enumerate() {
            fields.factors[i * fields.columns + from..i * fields.columns + to].fill(1.0);
        }
    }

    /// Empties the cells that the last filling touched, before the last one also of what decided how full they may be; in the first sweep
    /// forgets where that was.
    fn empty(&mut self, fields: &mut Fields, sweep: usize) {
        for (i, &(from, to)) in self.touched.iter().enumerate() {
            let row = i * fields.columns + from..i * fields.columns + to;
            fields.depth[row.clone()].fill(0.0);
            if sweep == 0 || sweep == RELAXATIONS.len() {
                fields.weight_or_flow_x[row.clone()].fill(0.0);
                fields.column_or_flow_y[row].fill(0.0);
            }
        }
        if sweep == 0 {
            std::mem::swap(&mut self.touched, &mut self.touched_before);
            self.touched.fill((0, 0));
        }
    }

    /// Brings what the particles gave under their scales to the factors of the cells.
    fn weight_by_factors(&self, fields: &mut Fields) {
        for (i, &(from, to)) in self.touched.iter().enumerate() {
            let row = i * fields.columns + from..i * fields.columns + to;
            let factors = &fields.factors[row.clone()];
            for water in [&mut fields.depth, &mut fields.weight_or_flow_x, &mut fields.column_or_flow_y] {
                water[row.clone()].iter_mut().zip(factors).for_each(|(water, factor)| *water *= factor);
            }
        }
    }

    /// Improves the factors of the cells that were filled.
    fn improve(&self, fields: &mut Fields, sweep: usize) {
        for (i, &(from, to)) in self.touched.iter().enumerate() {
            let row = i * fields.columns + from..i * fields.columns + to;
            let part = &mut fields.weight_or_flow_x[row.clone()];
            let mean = &mut fields.column_or_flow_y[row.clone()];
            if sweep == 0 {
                part.iter_mut().zip(mean.iter_mut()).for_each(|(part, mean)| balance(part, mean));
            }
            improve(&mut fields.factors[row.clone()], &fields.depth[row], (part, mean), RELAXATIONS[sweep]);
        }
    }

    /// Runs of cells that have water or had some before; remembers the former for the next call.
    fn collect_spans(&mut self, fields: &Fields, was_wet: &mut [bool]) {
        self.spans.clear();
        for (i, (now, before)) in self.touched.iter().zip(&self.touched_before).enumerate() {
            let (from, to) = match (now.0 == now.1, before.0 == before.1) {
                (true, _) => *before,
                (false, true) => *now,
                (false, false) => (now.0.min(before.0), now.1.max(before.1)),
            };
            let row = (fields.rows.start + i) as u32;
            let mut is_open = false;
            for column in from..to {
                let place = i * fields.columns + column;
                let is_wet = fields.depth[place] > 0.0;
                if is_wet || was_wet[place] {
                    match self.spans.last_mut() {
                        Some(span) if is_open => span.to += 1,
                        _ => self.spans.push(Span { row, from: column as u32, to: column as u32 + 1 }),
                    }
                    is_open = true;
                } else {
                    is_open = false;
                }
                was_wet[place] = is_wet;
            }
        }
    }
}

/// Cells of a line of `count` cells whose centres lie within `reach` of a place on it: first, and one past the last.
pub(crate) fn cells_within(place: f64, reach: f64, spacing: f64, count: usize) -> (usize, usize) {
    // Casts to unsigned integers saturate at zero; they are faster than rounding where the processor is not known.
    let low = (place - reach) / spacing - 0.5;
    let first = low as u32;
    let first = first as usize + usize::from(f64::from(first) < low);
    let end = ((place + reach) / spacing + 0.5) as u32 as usize;
    let end = end.min(count);
    (first.min(end), end)
}

/// Radius (m) of the kernel by which a particle covers cells, from its smoothing length (m).
pub(crate) fn support(smoothing_length: f64, spacing: f64) -> f64 {
    (SUPPORT * smoothing_length).max(SMALLEST_SUPPORT * spacing)
}

#[cfg(test)]
mod tests;
