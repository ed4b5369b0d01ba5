//! Gridding: the water of moving particles onto the lattice, with volume and momentum conserved.
//!
//! Particle j gives its volume to the cells c under its kernel W, in proportion to the water column that its level leaves
//! there, and its momentum in the same shares:
//!
//! ```text
//! s_jc = f_c W(|x_c − x_j|) max(η_j − z_c, 0) / Σ_c' (the same),   η_j = z_b(x_j) + d_j
//! d_c = Σ_j V_j s_jc / Δ²,    (d v)_c = Σ_j V_j v_j s_jc / Δ²
//! ```
//!
//! So nothing lands on ground above the surface of the particle nor beyond it or a wall, as seen straight from the particle, nor
//! where there is no terrain, and a level lake stays level over a sloping bed. The support of W is 4/3 h, two spacings where h is 1.5
//! spacings: the sum of such kernels over a lattice of particles is even within 0.3 %, and has no holes where their distances
//! are up to twice as wide. It is never less than 1.5 cells, so that particles closer together than cells leave none, either.
//!
//! Moving particles are never evenly spaced, and where they crowd together or stand apart cells would be too full or too empty
//! by a tenth or more: maxima would gather that noise. So some sweeps bring the factors f_c, 1 at first, nearer to what gives
//! every cell the mean column over it, D_c = Σ_j A_j W max(η_j − z_c, 0) / S_c with S_c = Σ_j A_j W:
//!
//! ```text
//! f_c ← f_c D_c / d_c       where d_c > D_c, and where the particles cover the cell (S_c near 1)
//! ```
//!
//! At a front, where S_c falls to zero, the grid stays as the kernels draw it.
//!
//! What a particle has to say about its cells is computed once and kept for all sweeps. Bands of rows are filled side by
//! side, each by its particles in ascending order: the same bits for any number of threads.

use std::ops::Range;

use rayon::prelude::*;

use crate::bed::BedParticles;
use crate::boundary::Walls;
use crate::lattice::{FlatWater, Lattice, Span, WaterOnLattice};
use crate::math::Vec2;
use crate::particles::FluidParticles;
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
/// ω of each sweep that evens out the grid after the first filling. A sweep takes 1 − ω (1 − Ŵ²) of an unevenness that the kernel smooths
/// by Ŵ: the first ω is for that of single cells, the last ones are for what is wide.
const RELAXATIONS: [f64; 5] = [1.0, 1.2, 1.7, 2.6, 5.0];
/// Bounds of the change of a factor in one sweep, so that no weight vanishes or runs away.
const FACTOR_BOUNDS: (f64, f64) = (0.25, 2.0);
/// Coverage S_c up to which cells are not made fuller, and from which on they are wholly. A straight front has 0.5.
pub(crate) const COVERED: (f64, f64) = (0.6, 0.8);

/// The shares of a chunk of particles: what each one says about the cells of its support, in ascending order of cells. The sweeps
/// read cells and weights alone, which therefore lie apart.
#[derive(Clone, Debug, Default)]
struct Shares {
    cells: Vec<u32>,
    /// W √max(η − z, 0), to be multiplied with the factor of the cell.
    weights: Vec<f64>,
    /// Where the entries of each particle begin, and the end of those of the last one.
    starts: Vec<u32>,
    /// η of each particle (m); zero where its area is.
    levels: Vec<f64>,
    /// A / κ of each particle (m²); zero where it gives all of its water to one cell.
    areas: Vec<f64>,
    /// V_j / (Δ² Σ f_c W √max(η − z, 0)) of each particle (m^½).
    scales: Vec<f64>,
}

impl Shares {
    /// Entries of the particle at place `k` of the chunk.
    fn of(&self, k: usize) -> Range<usize> {
        self.starts[k] as usize..self.starts[k + 1] as usize
    }

    /// Lists the cells of each particle from `first` on.
    fn fill(&mut self, measures: &Measures, ground: (&BedParticles, &Walls), particles: &FluidParticles, first: usize) {
        self.cells.clear();
        self.weights.clear();
        self.levels.clear();
        self.areas.clear();
        self.starts.clear();
        self.starts.push(0);
        for j in first..(first + CHUNK).min(particles.len()) {
            self.add(measures, ground, particles, j);
            self.starts.push(self.cells.len() as u32);
        }
    }

    fn add(
        &mut self,
        measures: &Measures,
        (bed, walls): (&BedParticles, &Walls),
        particles: &FluidParticles,
        j: usize,
    ) {
        let (lattice, place, depth) = (&bed.lattice, particles.position[j], particles.depth[j]);
        let support = support(particles.smoothing_length[j], lattice.spacing);
        let inverse_h = CubicSpline::SUPPORT / support;
        let mut level = bed.at(place).map_or(f64::NEG_INFINITY, |point| point.elevation + depth);
        let mut area = if depth > 0.0 { particles.volume[j] / depth } else { 0.0 };
        let begin = self.cells.len();
        let (mut sum, mut lowest, mut is_lake) = (0.0, (f64::INFINITY, None), true);
        let (from, to) = cells_within(place.y, support, lattice.spacing, lattice.rows);
        for row in from..to {
            let north = (row as f64 + 0.5) * lattice.spacing - place.y;
            let reach = (support * support - north * north).max(0.0).sqrt();
            let (west, east) = cells_within(place.x, reach, lattice.spacing, lattice.columns);
            for column in west..east {
                let cell = lattice.index(column, row);
                let elevation = bed.elevation[cell];
                if elevation < lowest.0 {
                    lowest = (elevation, Some(cell as u32));
                }
                // Not a number (no terrain) compares as false.
                is_lake &= level > elevation;
                if level > elevation && bed.sill(place, lattice.centre(cell)) < level {
                    let offset = Vec2::new((column as f64 + 0.5) * lattice.spacing - place.x, north);
                    let kernel = measures.kernel.value(offset.norm(), inverse_h);
                    let weight = kernel * (level - elevation).sqrt();
                    sum += weight;
                    self.cells.push(cell as u32);
                    self.weights.push(weight);
                }
            }
        }
        if !is_lake || !walls.is_clear(place, support) {
            sum = self.keep_in_sight(begin, place, level, bed, walls);
            area /= self.seen(begin, level, bed) * measures.cell_area;
            lowest.1 =
                lattice.cell_at(place).filter(|&cell| bed.has_terrain(cell)).map(|cell| cell as u32).or(lowest.1);
        }
        // A film so thin that the reciprocal overflows counts as none: its water goes to the lowest cell.
        if !(1.0 / (sum * measures.cell_area)).is_finite() {
            self.cells.truncate(begin);
            self.weights.truncate(begin);
            if let Some(cell) = lowest.1 {
                self.cells.push(cell);
                self.weights.push(1.0);
            }
            (level, area) = (0.0, 0.0);
        }
        self.levels.push(level);
        self.areas.push(area);
    }

    /// Takes out the cells beyond walls, and beyond ground above the level (m) of the particle whose entries begin at `begin`; returns Σ of
    /// the weights left.
    fn keep_in_sight(&mut self, begin: usize, place: Vec2, level: f64, bed: &BedParticles, walls: &Walls) -> f64 {
        let (mut sum, mut kept) = (0.0, begin);
        for k in begin..self.cells.len() {
            if is_in_sight((bed, walls), place, level, self.cells[k] as usize) {
                (self.cells[kept], self.weights[kept]) = (self.cells[k], self.weights[k]);
                sum += self.weights[k];
                kept += 1;
            }
        }
        self.cells.truncate(kept);
        self.weights.truncate(kept);
        sum
    }

    /// Σ W of the particle whose entries begin at `begin`.
    fn seen(&self, begin: usize, level: f64, bed: &BedParticles) -> f64 {
        let entries = self.cells[begin..].iter().zip(&self.weights[begin..]);
        entries.map(|(&cell, weight)| weight / (level - bed.elevation[cell as usize]).sqrt()).sum()
    }

    /// Finds the scales under the factors of the cells.
    fn scale(&mut self, measures: &Measures, particles: &FluidParticles, factors: &[f64], first: usize) {
        let mut scales = std::mem::take(&mut self.scales);
        scales.clear();
        scales.extend((0..self.starts.len() - 1).map(|k| {
            let (cells, weights) = (&self.cells[self.of(k)], &self.weights[self.of(k)]);
            let sum: f64 = cells.iter().zip(weights).map(|(&cell, weight)| factors[cell as usize] * weight).sum();
            particles.volume[first + k] / (measures.cell_area * sum)
        }));
        self.scales = scales;
    }
}

/// What turns volumes into depths.
#[derive(Clone, Copy, Debug)]
struct Measures {
    kernel: Smoothing<CubicSpline>,
    /// Area of a cell (m²; in one dimension its length, m).
    cell_area: f64,
}

/// What decides how full a cell may be.
#[derive(Clone, Copy, Debug)]
struct Balance {
    /// Σ A w (m^½).
    weight: f64,
    /// Σ A w (η − z) (m^3/2).
    column: f64,
}

impl Balance {
    const EMPTY: Balance = Balance { weight: 0.0, column: 0.0 };

    /// Brings the factor of a cell nearer to the one that gives it the mean column.
    fn improve(self, factor: &mut f64, depth: f64, relaxation: f64) {
        if depth <= 0.0 || self.weight <= 0.0 {
            return;
        }
        let mean = self.column / self.weight;
        let coverage = self.weight / mean.sqrt();
        let part = ((coverage - COVERED.0) / (COVERED.1 - COVERED.0)).clamp(0.0, 1.0);
        let change = relaxation * (mean / depth - 1.0);
        *factor *= (1.0 + if change < 0.0 { change } else { part * change }).clamp(FACTOR_BOUNDS.0, FACTOR_BOUNDS.1);
    }
}

/// One band of rows: the columns touched in each row, now and at the call before, and the spans that result.
#[derive(Clone, Debug, Default)]
struct Band {
    touched: Vec<(usize, usize)>,
    touched_before: Vec<(usize, usize)>,
    particles: Vec<InBand>,
    spans: Vec<Span>,
}

/// A particle that reaches into a band, and its entries in the cells there.
#[derive(Clone, Copy, Debug)]
struct InBand {
    particle: u32,
    from: u32,
    to: u32,
}

/// Grids moving particles again and again with the same buffers.
#[derive(Clone, Debug)]
pub struct Gridder {
    measures: Measures,
    lattice: Lattice,
    water: FlatWater,
    balance: Vec<Balance>,
    /// f_c.
    factors: Vec<f64>,
    /// Whether a cell had water after the call before.
    was_wet: Vec<bool>,
    /// Depth (m) of each cell that is in no particle; empty where there is none.
    beside: Vec<f64>,
    shares: Vec<Shares>,
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
            balance: vec![Balance::EMPTY; cells],
            factors: vec![1.0; cells],
            was_wet: vec![false; cells],
            beside: Vec::new(),
            shares: Vec::new(),
            bands: bands.collect(),
            spans: Vec::new(),
            stray_volume: 0.0,
        }
    }

    /// Takes water at rest that is in no particle, a depth (m) for each cell or none at all, for the calls of `grid` to come.
    pub fn put_beside(&mut self, depth: &[f64]) {
        debug_assert!(depth.is_empty() || depth.len() == self.lattice.len());
        self.beside.clear();
        self.beside.extend_from_slice(depth);
    }

    /// Grids the particles over the bed, between the walls. The spans hold every cell with water now or after the call before.
    pub fn grid(&mut self, bed: &BedParticles, walls: &Walls, particles: &FluidParticles) -> WaterOnLattice<'_> {
        debug_assert_eq!(bed.lattice, self.lattice);
        let measures = self.measures;
        self.shares.resize_with(particles.len().div_ceil(CHUNK), Shares::default);
        let shares = self.shares.par_iter_mut().enumerate();
        shares.for_each(|(chunk, shares)| shares.fill(&measures, (bed, walls), particles, chunk * CHUNK));
        self.sort_into_bands(&bed.lattice, particles);
        for sweep in 0..=RELAXATIONS.len() {
            let factors = &self.factors;
            let shares = self.shares.par_iter_mut().enumerate();
            shares.for_each(|(chunk, shares)| shares.scale(&measures, particles, factors, chunk * CHUNK));
            self.fill_bands(bed, particles, sweep);
        }
        self.spans.clear();
        self.bands.iter().for_each(|band| self.spans.extend_from_slice(&band.spans));
        self.water()
    }

    /// The water at the latest call of `grid`; dry before the first one.
    pub fn water(&self) -> WaterOnLattice<'_> {
        WaterOnLattice { rows: &self.water, lattice: &self.lattice, spans: &self.spans }
    }

    fn fill_bands(&mut self, bed: &BedParticles, particles: &FluidParticles, sweep: usize) {
        let (shares, beside, columns) = (&self.shares, &self.beside, bed.lattice.columns);
        let cells = BAND * columns.max(1);
        self.bands
            .par_iter_mut()
            .zip(self.water.depth.par_chunks_mut(cells))
            .zip(self.water.discharge_x.par_chunks_mut(cells).zip(self.water.discharge_y.par_chunks_mut(cells)))
            .zip(self.balance.par_chunks_mut(cells).zip(self.factors.par_chunks_mut(cells)))
            .zip(self.was_wet.par_chunks_mut(cells))
            .enumerate()
            .for_each(|(number, ((((band, depth), (discharge_x, discharge_y)), (balance, factors)), was_wet))| {
                let first_row = number * BAND;
                let mut fields = Fields { first_row, columns, depth, discharge_x, discharge_y, balance, factors };
                band.empty(&mut fields, sweep);
                if sweep == 0 {
                    band.cover(&mut fields, shares, &bed.elevation);
                }
                if let Some(&relaxation) = RELAXATIONS.get(sweep) {
                    band.fill(&mut fields, shares);
                    band.improve(&mut fields, relaxation);
                } else {
                    band.fill_with_discharges(&mut fields, particles, shares);
                    band.add_beside(&mut fields, beside);
                    band.collect_spans(&fields, was_wet);
                }
            });
    }

    /// Volume (m³) that found no cell with terrain at the last call: particles off the terrain by more than their support.
    pub fn stray_volume(&self) -> f64 {
        self.stray_volume
    }

    /// Lists, for each band, the particles that reach into it, in ascending order; sums the stray volume; forgets the factors
    /// of the call before.
    fn sort_into_bands(&mut self, lattice: &Lattice, particles: &FluidParticles) {
        let (all, columns) = (&self.shares, lattice.columns);
        let reaches = all.par_iter().enumerate().map(|(chunk, shares)| {
            let mut reach = Reach { first: u32::MAX, last: 0, stray_volume: 0.0 };
            for k in 0..shares.starts.len() - 1 {
                match shares.cells[shares.of(k)] {
                    [] => reach.stray_volume += particles.volume[chunk * CHUNK + k],
                    [first, .., last] => (reach.first, reach.last) = (reach.first.min(first), reach.last.max(last)),
                    [only] => (reach.first, reach.last) = (reach.first.min(only), reach.last.max(only)),
                }
            }
            reach
        });
        let reaches: Vec<Reach> = reaches.collect();
        self.stray_volume = reaches.iter().map(|reach| reach.stray_volume).sum();
        let band_cells = BAND * columns.max(1);
        self.bands
            .par_iter_mut()
            .zip(self.balance.par_chunks_mut(band_cells).zip(self.factors.par_chunks_mut(band_cells)))
            .enumerate()
            .for_each(|(number, (band, (balance, factors)))| {
                band.take_particles(number * band_cells..number * band_cells + balance.len(), all, &reaches);
                for (i, &(from, to)) in band.touched.iter().enumerate() {
                    balance[i * columns + from..i * columns + to].fill(Balance::EMPTY);
                    factors[i * columns + from..i * columns + to].fill(1.0);
                }
            });
    }
}

/// The cells that a chunk of particles reaches, and the volume (m³) that reaches none.
struct Reach {
    /// First cell.
    first: u32,
    /// Last cell; before the first one where the chunk reaches none.
    last: u32,
    stray_volume: f64,
}

/// The part of the grids that belongs to one band.
struct Fields<'a> {
    first_row: usize,
    columns: usize,
    depth: &'a mut [f64],
    discharge_x: &'a mut [f64],
    discharge_y: &'a mut [f64],
    balance: &'a mut [Balance],
    factors: &'a mut [f64],
}

impl Fields<'_> {
    /// The cells of the band.
    fn cells(&self) -> Range<usize> {
        let first = self.first_row * self.columns;
        first..first + self.depth.len()
    }
}

impl Band {
    /// Lists the particles that reach into the cells of the band, in ascending order, with their entries there.
    fn take_particles(&mut self, cells: Range<usize>, shares: &[Shares], reaches: &[Reach]) {
        self.particles.clear();
        let (start, end) = (cells.start as u32, cells.end as u32);
        let near = reaches.iter().enumerate().filter(|(_, reach)| reach.first < end && reach.last >= start);
        for (chunk, shares) in near.map(|(chunk, _)| (chunk, &shares[chunk])) {
            for k in 0..shares.starts.len() - 1 {
                let entries = shares.of(k);
                let all = &shares.cells[entries.clone()];
                let (Some(first), Some(last)) = (all.first(), all.last()) else { continue };
                if *first >= end || *last < start {
                    continue;
                }
                let is_inside = *first >= start && *last < end;
                let place = |cell: u32| entries.start + all.partition_point(|&other| other < cell);
                let (from, to) = if is_inside { (entries.start, entries.end) } else { (place(start), place(end)) };
                self.particles.push(InBand { particle: (chunk * CHUNK + k) as u32, from: from as u32, to: to as u32 });
            }
        }
    }

    /// Calls `act` for each particle: particle, its chunk, its entries in the cells of the band.
    fn for_each(&self, shares: &[Shares], mut act: impl FnMut(usize, &Shares, Range<usize>)) {
        for &InBand { particle, from, to } in &self.particles {
            let j = particle as usize;
            act(j, &shares[j / CHUNK], from as usize..to as usize);
        }
    }

    /// Empties the cells that the last filling touched; in the first sweep also forgets where that was.
    fn empty(&mut self, fields: &mut Fields, sweep: usize) {
        for (i, &(from, to)) in self.touched.iter().enumerate() {
            let row = i * fields.columns + from..i * fields.columns + to;
            fields.depth[row.clone()].fill(0.0);
            if sweep == 0 {
                fields.discharge_x[row.clone()].fill(0.0);
                fields.discharge_y[row].fill(0.0);
            }
        }
        if sweep == 0 {
            std::mem::swap(&mut self.touched, &mut self.touched_before);
            self.touched.fill((0, 0));
        }
    }

    /// Sums coverage and mean columns of the cells, and notes which cells are touched.
    fn cover(&mut self, fields: &mut Fields, shares: &[Shares], elevation: &[f64]) {
        let mut touched = std::mem::take(&mut self.touched);
        let cells = fields.cells();
        self.for_each(shares, |j, chunk, entries| {
            let (area, level) = (chunk.areas[j % CHUNK], chunk.levels[j % CHUNK]);
            for (&cell, weight) in chunk.cells[entries.clone()].iter().zip(&chunk.weights[entries]) {
                let place = cell as usize - cells.start;
                let balance = &mut fields.balance[place];
                balance.weight += area * weight;
                balance.column += area * weight * (level - elevation[cell as usize]);
                touch(&mut touched[place / fields.columns], place % fields.columns);
            }
        });
        self.touched = touched;
    }

    /// Fills the band with the water of its particles.
    fn fill(&self, fields: &mut Fields, shares: &[Shares]) {
        let cells = fields.cells();
        self.for_each(shares, |j, chunk, entries| {
            let scale = chunk.scales[j % CHUNK];
            for (&cell, weight) in chunk.cells[entries.clone()].iter().zip(&chunk.weights[entries]) {
                let place = cell as usize - cells.start;
                fields.depth[place] += scale * fields.factors[place] * weight;
            }
        });
    }

    /// The same with the momentum of its particles.
    fn fill_with_discharges(&self, fields: &mut Fields, particles: &FluidParticles, shares: &[Shares]) {
        let cells = fields.cells();
        self.for_each(shares, |j, chunk, entries| {
            let (scale, velocity) = (chunk.scales[j % CHUNK], particles.velocity[j]);
            for (&cell, weight) in chunk.cells[entries.clone()].iter().zip(&chunk.weights[entries]) {
                let place = cell as usize - cells.start;
                let depth = scale * fields.factors[place] * weight;
                fields.depth[place] += depth;
                fields.discharge_x[place] += velocity.x * depth;
                fields.discharge_y[place] += velocity.y * depth;
            }
        });
    }

    /// Adds the water that is in no particle.
    fn add_beside(&mut self, fields: &mut Fields, beside: &[f64]) {
        let Some(depths) = beside.get(fields.cells()) else { return };
        for (place, depth) in depths.iter().enumerate().filter(|(_, depth)| **depth > 0.0) {
            fields.depth[place] += depth;
            touch(&mut self.touched[place / fields.columns], place % fields.columns);
        }
    }

    /// Improves the factors of the cells that were filled.
    fn improve(&self, fields: &mut Fields, relaxation: f64) {
        for (i, &(from, to)) in self.touched.iter().enumerate() {
            for place in i * fields.columns + from..i * fields.columns + to {
                fields.balance[place].improve(&mut fields.factors[place], fields.depth[place], relaxation);
            }
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
            let row = (fields.first_row + i) as u32;
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

/// Widens a range of columns by one of them.
fn touch(range: &mut (usize, usize), column: usize) {
    *range = if range.0 == range.1 { (column, column + 1) } else { (range.0.min(column), range.1.max(column + 1)) };
}

/// Cells of a line of `count` cells whose centres lie within `reach` of a place on it: first, and one past the last.
pub(crate) fn cells_within(place: f64, reach: f64, spacing: f64, count: usize) -> (usize, usize) {
    // A cast to an unsigned integer saturates at zero.
    let first = (((place - reach) / spacing - 0.5).ceil().max(0.0) as usize).min(count);
    let end = (((place + reach) / spacing - 0.5).floor() + 1.0).max(0.0) as usize;
    (first, end.min(count).max(first))
}

/// Radius (m) of the kernel by which a particle covers cells, from its smoothing length (m).
pub(crate) fn support(smoothing_length: f64, spacing: f64) -> f64 {
    (SUPPORT * smoothing_length).max(SMALLEST_SUPPORT * spacing)
}

/// Whether neither ground above a level (m) nor a wall stands between a place and the centre of a cell.
pub(crate) fn is_in_sight((bed, walls): (&BedParticles, &Walls), place: Vec2, level: f64, cell: usize) -> bool {
    bed.is_in_sight(place, level, cell) && !walls.is_walled(place, bed.lattice.centre(cell))
}

#[cfg(test)]
mod tests;
