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
//! So nothing lands on ground above the surface of the particle, nor where there is no terrain, and a level lake stays level
//! over a sloping bed. The support of W is 4/3 h, two spacings where h is 1.5 spacings: the sum of such kernels over a
//! lattice of particles is even within 0.3 %, and has no holes where their distances are up to twice as wide. It is never
//! less than 1.5 cells, so that particles closer together than cells leave none, either.
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
//! Bands of rows are filled side by side, each by its particles in ascending order: the same bits for any number of threads.

use rayon::prelude::*;

use crate::bed::BedParticles;
use crate::lattice::{Lattice, Span, WaterOnLattice};
use crate::math::Vec2;
use crate::physics::kernel::CubicSpline;

/// Support radius over smoothing length.
const SUPPORT: f64 = 4.0 / 3.0;
/// Smallest support radius, in cells.
const SMALLEST_SUPPORT: f64 = 1.5;
/// Rows of a band. Fixed, since it decides the order of the sums.
const BAND: usize = 16;
/// Sweeps that even out the grid after the first filling.
const SWEEPS: usize = 3;
/// Bounds of D_c / d_c in one sweep, so that no weight vanishes or runs away.
const FACTOR_BOUNDS: (f64, f64) = (0.25, 2.0);
/// Coverage S_c up to which cells are not made fuller, and from which on they are wholly. A straight front has 0.5.
const COVERED: (f64, f64) = (0.6, 0.8);
/// 10 / (7 π): makes the B-spline's integral over the plane 1 for a smoothing length of 1.
const KERNEL_NORM: f64 = 10.0 / (7.0 * std::f64::consts::PI);

/// Moving particles as the gridding sees them, in local coordinates; all slices have one entry for each particle.
#[derive(Clone, Copy, Debug)]
pub struct MovingWater<'a> {
    /// Place to the east (m).
    pub x: &'a [f64],
    /// Place to the north (m).
    pub y: &'a [f64],
    /// Volume V (m³).
    pub volume: &'a [f64],
    /// Depth d (m).
    pub depth: &'a [f64],
    /// Velocity to the east (m/s).
    pub velocity_x: &'a [f64],
    /// Velocity to the north (m/s).
    pub velocity_y: &'a [f64],
    /// Smoothing length h (m).
    pub smoothing_length: &'a [f64],
}

/// How a particle shares out its water.
#[derive(Clone, Copy, Debug, Default)]
struct Share {
    position: Vec2,
    support: f64,
    /// Level η of its surface (m).
    level: f64,
    /// 1 / (Δ² Σ W max(η − z, 0)); zero when all of its water goes to one cell.
    scale: f64,
    /// Plan area A = V/d (m²).
    area: f64,
    /// The cell that gets all of its water when `scale` is zero.
    only_cell: Option<usize>,
}

/// What decides how full a cell may be.
#[derive(Clone, Copy, Debug)]
struct Balance {
    /// Coverage S_c = Σ A W.
    weight: f64,
    /// Σ A W max(η − z, 0) (m).
    column: f64,
    /// The factor f_c.
    factor: f64,
}

impl Balance {
    const EMPTY: Balance = Balance { weight: 0.0, column: 0.0, factor: 1.0 };

    /// Brings the factor of a cell nearer to the one that gives it the mean column.
    fn improve(&mut self, depth: f64) {
        if depth <= 0.0 || self.weight <= 0.0 {
            return;
        }
        let change = (self.column / (self.weight * depth)).clamp(FACTOR_BOUNDS.0, FACTOR_BOUNDS.1) - 1.0;
        let part = ((self.weight - COVERED.0) / (COVERED.1 - COVERED.0)).clamp(0.0, 1.0);
        self.factor *= 1.0 + if change < 0.0 { change } else { part * change };
    }
}

/// One band of rows: the columns touched in each row, now and at the call before, and the spans that result.
#[derive(Clone, Debug, Default)]
struct Band {
    touched: Vec<(usize, usize)>,
    touched_before: Vec<(usize, usize)>,
    particles: Vec<u32>,
    spans: Vec<Span>,
}

/// Grids moving particles again and again with the same buffers.
#[derive(Clone, Debug)]
pub struct Gridder {
    depth: Vec<f64>,
    discharge_x: Vec<f64>,
    discharge_y: Vec<f64>,
    balance: Vec<Balance>,
    /// Whether a cell had water after the call before.
    was_wet: Vec<bool>,
    shares: Vec<Share>,
    bands: Vec<Band>,
    spans: Vec<Span>,
    stray_volume: f64,
}

impl Gridder {
    /// A gridder for the lattice of a bed.
    pub fn new(lattice: &Lattice) -> Self {
        let cells = lattice.len();
        let bands = (0..lattice.rows.div_ceil(BAND)).map(|band| {
            let rows = BAND.min(lattice.rows - band * BAND);
            Band { touched: vec![(0, 0); rows], touched_before: vec![(0, 0); rows], ..Band::default() }
        });
        Gridder {
            depth: vec![0.0; cells],
            discharge_x: vec![0.0; cells],
            discharge_y: vec![0.0; cells],
            balance: vec![Balance::EMPTY; cells],
            was_wet: vec![false; cells],
            shares: Vec::new(),
            bands: bands.collect(),
            spans: Vec::new(),
            stray_volume: 0.0,
        }
    }

    /// Grids the particles over the bed. The spans hold every cell with water now or after the call before.
    pub fn grid(&mut self, bed: &BedParticles, water: &MovingWater) -> WaterOnLattice<'_> {
        debug_assert_eq!(bed.lattice.len(), self.depth.len());
        for sweep in 0..=SWEEPS {
            let balance = &self.balance;
            let particles = (0..water.x.len()).into_par_iter();
            particles.map(|j| share(bed, water, balance, j)).collect_into_vec(&mut self.shares);
            if sweep == 0 {
                let is_stray = |j: &usize| self.shares[*j].scale == 0.0 && self.shares[*j].only_cell.is_none();
                self.stray_volume = (0..water.x.len()).filter(is_stray).map(|j| water.volume[j]).sum();
                self.sort_into_bands(&bed.lattice);
            }
            self.fill_bands(bed, water, sweep);
        }
        self.spans.clear();
        self.bands.iter().for_each(|band| self.spans.extend_from_slice(&band.spans));
        WaterOnLattice {
            depth: &self.depth,
            discharge_x: &self.discharge_x,
            discharge_y: &self.discharge_y,
            spans: &self.spans,
        }
    }

    fn fill_bands(&mut self, bed: &BedParticles, water: &MovingWater, sweep: usize) {
        let columns = bed.lattice.columns;
        let shares = &self.shares;
        let cells = BAND * columns.max(1);
        self.bands
            .par_iter_mut()
            .zip(self.depth.par_chunks_mut(cells))
            .zip(self.discharge_x.par_chunks_mut(cells).zip(self.discharge_y.par_chunks_mut(cells)))
            .zip(self.balance.par_chunks_mut(cells).zip(self.was_wet.par_chunks_mut(cells)))
            .enumerate()
            .for_each(|(number, (((band, depth), (discharge_x, discharge_y)), (balance, was_wet)))| {
                let first_row = number * BAND;
                let mut fields = Fields { first_row, columns, depth, discharge_x, discharge_y, balance };
                band.empty(&mut fields, sweep);
                band.fill(&mut fields, bed, water, shares, sweep);
                if sweep < SWEEPS {
                    band.improve(&mut fields);
                } else {
                    band.collect_spans(&fields, was_wet);
                }
            });
    }

    /// Volume (m³) that found no cell with terrain at the last call: particles off the terrain by more than their support.
    pub fn stray_volume(&self) -> f64 {
        self.stray_volume
    }

    /// Lists, for each band, the particles that reach into it, in ascending order.
    fn sort_into_bands(&mut self, lattice: &Lattice) {
        self.bands.iter_mut().for_each(|band| band.particles.clear());
        for (j, share) in self.shares.iter().enumerate() {
            let rows = match share.only_cell {
                Some(cell) => (lattice.column_row(cell).1, lattice.column_row(cell).1 + 1),
                None if share.scale > 0.0 => {
                    cells_within(share.position.y, share.support, lattice.spacing, lattice.rows)
                }
                None => continue,
            };
            for band in &mut self.bands[rows.0 / BAND..rows.1.div_ceil(BAND)] {
                band.particles.push(j as u32);
            }
        }
    }
}

/// The part of the grids that belongs to one band.
struct Fields<'a> {
    first_row: usize,
    columns: usize,
    depth: &'a mut [f64],
    discharge_x: &'a mut [f64],
    discharge_y: &'a mut [f64],
    balance: &'a mut [Balance],
}

impl Fields<'_> {
    /// Adds depth `d` (m) with a velocity to the cell at `place` of the band.
    #[inline]
    fn add(&mut self, place: usize, d: f64, velocity: Vec2) {
        self.depth[place] += d;
        self.discharge_x[place] += d * velocity.x;
        self.discharge_y[place] += d * velocity.y;
    }
}

impl Band {
    /// Empties the cells that the last filling touched.
    fn empty(&mut self, fields: &mut Fields, sweep: usize) {
        for (i, &(from, to)) in self.touched.iter().enumerate() {
            let row = i * fields.columns + from..i * fields.columns + to;
            fields.depth[row.clone()].fill(0.0);
            fields.discharge_x[row.clone()].fill(0.0);
            fields.discharge_y[row.clone()].fill(0.0);
            if sweep == 0 {
                fields.balance[row].fill(Balance::EMPTY);
            }
        }
        if sweep == 0 {
            std::mem::swap(&mut self.touched, &mut self.touched_before);
            self.touched.fill((0, 0));
        }
    }

    /// Fills the band with the shares of its particles.
    fn fill(&mut self, fields: &mut Fields, bed: &BedParticles, water: &MovingWater, shares: &[Share], sweep: usize) {
        let first_cell = fields.first_row * fields.columns;
        for &j in &self.particles {
            let (j, share) = (j as usize, &shares[j as usize]);
            let velocity = Vec2::new(water.velocity_x[j], water.velocity_y[j]);
            if let Some(cell) = share.only_cell {
                let (column, row) = bed.lattice.column_row(cell);
                fields.add(cell - first_cell, water.volume[j] / bed.lattice.cell_area(), velocity);
                touch(&mut self.touched[row - fields.first_row], column, column + 1);
                continue;
            }
            let (from, to) = cells_within(share.position.y, share.support, bed.lattice.spacing, bed.lattice.rows);
            let band_end = fields.first_row + self.touched.len();
            for row in from.max(fields.first_row)..to.min(band_end) {
                let (first, end) = columns_of_row(&bed.lattice, share, row);
                touch(&mut self.touched[row - fields.first_row], first, end);
                for column in first..end {
                    let (kernel, water_column) = kernel_and_column(bed, share, column, row);
                    let place = (row - fields.first_row) * fields.columns + column;
                    let balance = &mut fields.balance[place];
                    if sweep == 0 {
                        balance.weight += share.area * kernel;
                        balance.column += share.area * kernel * water_column;
                    }
                    let weight = balance.factor * kernel * water_column;
                    fields.add(place, water.volume[j] * share.scale * weight, velocity);
                }
            }
        }
    }

    /// Improves the factors of the cells that were filled.
    fn improve(&self, fields: &mut Fields) {
        for (i, &(from, to)) in self.touched.iter().enumerate() {
            for place in i * fields.columns + from..i * fields.columns + to {
                fields.balance[place].improve(fields.depth[place]);
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

/// Widens a range of columns.
fn touch(range: &mut (usize, usize), from: usize, to: usize) {
    let is_untouched = range.0 == range.1;
    if from < to {
        *range = if is_untouched { (from, to) } else { (range.0.min(from), range.1.max(to)) };
    }
}

/// Cells of a line of `count` cells whose centres lie within `reach` of a place on it: first, and one past the last.
fn cells_within(place: f64, reach: f64, spacing: f64, count: usize) -> (usize, usize) {
    // A cast to an unsigned integer saturates at zero.
    let first = (((place - reach) / spacing - 0.5).ceil().max(0.0) as usize).min(count);
    let end = (((place + reach) / spacing - 0.5).floor() + 1.0).max(0.0) as usize;
    (first, end.min(count).max(first))
}

/// The columns of a row that lie in the support of a particle.
fn columns_of_row(lattice: &Lattice, share: &Share, row: usize) -> (usize, usize) {
    let north = (row as f64 + 0.5) * lattice.spacing - share.position.y;
    let reach = (share.support * share.support - north * north).max(0.0).sqrt();
    cells_within(share.position.x, reach, lattice.spacing, lattice.columns)
}

/// W (1/m²) and max(η − z, 0) (m) of a particle at a cell; the latter is zero where there is no terrain.
#[inline]
fn kernel_and_column(bed: &BedParticles, share: &Share, column: usize, row: usize) -> (f64, f64) {
    let index = bed.lattice.index(column, row);
    let centre = Vec2::new((column as f64 + 0.5) * bed.lattice.spacing, (row as f64 + 0.5) * bed.lattice.spacing);
    let inverse_h = 2.0 / share.support;
    let w = KERNEL_NORM * inverse_h * inverse_h * CubicSpline::shape((centre - share.position).norm() * inverse_h);
    // The maximum of not-a-number and zero is zero.
    (w, (share.level - bed.elevation[index]).max(0.0))
}

/// The share of particle j under the factors of the cells.
fn share(bed: &BedParticles, water: &MovingWater, balance: &[Balance], j: usize) -> Share {
    let lattice = &bed.lattice;
    let position = Vec2::new(water.x[j], water.y[j]);
    let support = (SUPPORT * water.smoothing_length[j]).max(SMALLEST_SUPPORT * lattice.spacing);
    let level = bed.at(position).map_or(f64::NEG_INFINITY, |point| point.elevation + water.depth[j]);
    let area = if water.depth[j] > 0.0 { water.volume[j] / water.depth[j] } else { 0.0 };
    let mut share = Share { position, support, level, scale: 0.0, area, only_cell: None };
    let (mut sum, mut lowest) = (0.0, f64::INFINITY);
    let (from, to) = cells_within(position.y, support, lattice.spacing, lattice.rows);
    for row in from..to {
        let (first, end) = columns_of_row(lattice, &share, row);
        for column in first..end {
            let index = lattice.index(column, row);
            let (kernel, water_column) = kernel_and_column(bed, &share, column, row);
            sum += balance[index].factor * kernel * water_column;
            if bed.elevation[index] < lowest {
                lowest = bed.elevation[index];
                share.only_cell = Some(index);
            }
        }
    }
    // A film so thin that the reciprocal overflows counts as none.
    if (1.0 / (sum * lattice.cell_area())).is_finite() {
        share.scale = 1.0 / (sum * lattice.cell_area());
        share.only_cell = None;
    }
    share
}

#[cfg(test)]
mod tests;
