//! Rain on moving particles: what falls on water lifts it, what falls on dry ground gathers until it is a film that runs.
//!
//! A cell c holds water where a particle stands in it, or where particles whose surface is above its bed cover it,
//!
//! ```text
//! (M74)  S_c = Σ_j A_j W(|x_c − x_j|),   C_c = S_c / Σ_c' Δ² W(|x_c − x_c'|) ≥ 0.6
//! ```
//!
//! with the kernel and the bounds of the gridding (`COVERED`). The depth r_c that gathered on it goes to these particles in the shares of
//! S_c, and lifts them: by r where they cover the ground, so that a lake stays level, and as far as leaves their areas where they do not,
//!
//! ```text
//! (M75)  ΔV_i = A_i Σ_c W_ic Δ² r_c / S_c,   v_i ← v_i V_i / (V_i + ΔV_i)
//!        Δd_i = Σ_c t_c W_ic l_ic / Σ_c W_ic + Σ_c (1 − t_c) W_ic Δ² r_c / S_c,   t_c = clamp((C_c − 0.6)/0.2, 0, 1)
//!        l_ic = min(r_c + d_i max(C_c − 1.003, 0), 2 r_c)
//! ```
//!
//! Where particles crowd, their depths are less than their volumes say, and rain lifts up to twice as much: films that run together in a
//! hollow would otherwise lie too low in it (decision 0036).
//!
//! A particle of less than a quarter of a cell that others cover (C ≥ 0.8 without it) goes up in its cell: its volume counts as rain there,
//! and its momentum goes along. On any other cell rain gathers, and becomes a particle at rest, as wide as the cell, as soon as it is twice
//! as deep as water that does not move: one as deep as that would never leave, since it stops as soon as it spreads.

use rayon::prelude::*;

use super::{CHUNK, FILM, Rates, smoothing_factor};
use crate::bed::BedParticles;
use crate::boundary::{Rain, Walls};
use crate::gridding::{self, COVERED};
use crate::math::Vec2;
use crate::particles::{FluidParticles, Particle, retain_marked};
use crate::physics::dimension::Dimension;
use crate::physics::kernel::{CubicSpline, Shape, Smoothing};
use crate::solver::{FlowProblem, Passage, Way};

/// A particle is small that covers less of a cell: the film that came down a slope is a crumb in the lake, and would set the step.
const SMALL: f64 = 0.25;

/// Particles crowd where they cover a cell more than so many times. What rain itself does to particles beside a wall is less.
const CROWDED: f64 = 1.003;

/// The rain of a problem, and what of it lies on dry ground.
#[derive(Debug)]
pub(super) struct Rainfall {
    rain: Option<Rain>,
    dimension: Dimension,
    kernel: Smoothing<CubicSpline>,
    /// Depth (m) of a film that runs.
    film: f64,
    time: f64,
    /// Volume (m³) that fell since the start.
    came: f64,
    /// What falls within a step (m) at each place of rain by frames.
    falling: Vec<f64>,
    /// Σ Δ² W around each cell, over cells with terrain; 0 where there is none.
    whole: Vec<f64>,
    /// Depth (m) that lies on each cell and is in no particle.
    gathered: Vec<f64>,
    cover: Vec<Cover>,
}

/// What a cell gives to the particles that cover it.
#[derive(Clone, Copy, Debug, Default)]
struct Cover {
    /// S.
    sum: f64,
    /// Whether a particle stands in the cell.
    is_held: bool,
    /// Whether it holds water.
    is_wet: bool,
    /// r (m), and t.
    gives: f64,
    lifts: f64,
    /// Depth (m) of the particles that went up in it, and that times their velocity (m²/s).
    takes: f64,
    takes_flow: Vec2,
}

impl Rainfall {
    pub fn new(problem: &FlowProblem, dimension: Dimension) -> Self {
        let rain = problem.forcing.rain.clone();
        let places = if let Some(Rain::Frames(frames)) = &rain { frames.from.len() } else { 0 };
        let cells = if rain.is_some() { problem.bed.lattice.len() } else { 0 };
        let mut rainfall = Rainfall {
            rain,
            dimension,
            kernel: Smoothing::new(dimension),
            film: FILM * problem.dry_depth,
            time: 0.0,
            came: 0.0,
            falling: vec![0.0; places],
            whole: Vec::new(),
            gathered: vec![0.0; cells],
            cover: vec![Cover::default(); cells],
        };
        let spacing = problem.bed.lattice.spacing;
        let around = |cell: usize| {
            let mut sum = 0.0;
            if problem.bed.has_terrain(cell) {
                let (place, width) = (problem.bed.lattice.centre(cell), smoothing_factor(dimension) * spacing);
                rainfall.for_each_cell(&problem.bed, place, width, |_, weight| sum += dimension.area(spacing) * weight);
            }
            sum
        };
        rainfall.whole = (0..cells).into_par_iter().map(around).collect();
        rainfall
    }

    /// Whether it rains at all.
    pub fn is_none(&self) -> bool {
        self.rain.is_none()
    }

    /// Volume (m³) that fell since the start.
    pub fn inflow(&self) -> f64 {
        self.came
    }

    /// Depth (m) on each cell that is in no particle; empty where it never rains.
    pub fn gathered(&self) -> &[f64] {
        &self.gathered
    }

    /// Volume (m³) that fell and is in no particle.
    pub fn owed(&self, bed: &BedParticles) -> f64 {
        self.gathered.iter().sum::<f64>() * self.dimension.area(bed.lattice.spacing)
    }

    /// What fell; in one dimension per metre of width.
    pub fn passage(&self, bed: &BedParticles) -> Option<Passage> {
        let rain = self.rain.as_ref()?;
        let cells = (0..bed.lattice.len()).filter(|&cell| bed.has_terrain(cell));
        let fell: f64 = cells.map(|cell| rain.depth(cell, 0.0, self.time)).sum();
        let asked = Some(fell * self.dimension.area(bed.lattice.spacing));
        Some(Passage { way: Way::Rain, inflow: self.came, outflow: 0.0, asked })
    }

    /// Lets it rain for a time (s).
    pub fn fall(
        &mut self,
        particles: &mut FluidParticles,
        rates: &mut Vec<Rates>,
        ground: (&BedParticles, &Walls),
        dt: f64,
    ) {
        let bed = ground.0;
        self.gather(bed, dt);
        if self.is_none() {
            return;
        }
        self.find_cover(particles, ground);
        self.take_up(particles, rates, ground);
        self.share_out(bed);
        self.lift(particles, ground);
        self.make_films(particles, rates, bed);
    }

    /// Adds what falls to what lies on the cells.
    fn gather(&mut self, bed: &BedParticles, dt: f64) {
        let (from, to) = (self.time, self.time + dt);
        self.time = to;
        let Some(rain) = &self.rain else { return };
        let everywhere = if let Rain::Uniform(series) = rain { series.integral(from, to) } else { 0.0 };
        if let Rain::Frames(frames) = rain {
            let falling = self.falling.iter_mut().enumerate();
            falling.for_each(|(place, depth)| *depth = frames.depth(place, from, to));
        }
        let falling = &self.falling;
        let chunks = self.gathered.par_chunks_mut(CHUNK).enumerate().map(|(chunk, gathered)| {
            let mut fallen = 0.0;
            for (cell, gathered) in (chunk * CHUNK..).zip(gathered).filter(|(cell, _)| bed.has_terrain(*cell)) {
                let depth = match rain {
                    Rain::Uniform(_) => everywhere,
                    Rain::Map { .. } => rain.depth(cell, from, to),
                    Rain::Frames(frames) => falling[frames.place[cell] as usize],
                };
                *gathered += depth;
                fallen += depth;
            }
            fallen
        });
        let fallen: f64 = chunks.collect::<Vec<f64>>().iter().sum();
        self.came += fallen * self.dimension.area(bed.lattice.spacing);
    }

    /// Calls `act` for each cell with terrain under the kernel of a particle, with the kernel's value (m^−dim).
    fn for_each_cell(&self, bed: &BedParticles, place: Vec2, smoothing_length: f64, mut act: impl FnMut(usize, f64)) {
        let (lattice, spacing) = (&bed.lattice, bed.lattice.spacing);
        let support = gridding::support(smoothing_length, spacing);
        let inverse_h = CubicSpline::SUPPORT / support;
        let within = |place: f64, count: usize| {
            let (first, end) = gridding::cells_within(place, support, spacing, count);
            first..end
        };
        for row in within(place.y, lattice.rows) {
            for column in within(place.x, lattice.columns) {
                let cell = lattice.index(column, row);
                let offset = lattice.centre(cell) - place;
                let distance = if self.dimension == Dimension::One { offset.x.abs() } else { offset.norm() };
                if distance < support && bed.has_terrain(cell) {
                    act(cell, self.kernel.value(distance, inverse_h));
                }
            }
        }
    }

    /// The same for each cell that a particle covers.
    fn for_each_covered(
        &self,
        particles: &FluidParticles,
        i: usize,
        (bed, walls): (&BedParticles, &Walls),
        mut act: impl FnMut(usize, f64),
    ) {
        let place = particles.position[i];
        let here = bed.lattice.cell_at(place);
        let level = bed.at(place).map_or(f64::NEG_INFINITY, |point| point.elevation + particles.depth[i]);
        self.for_each_cell(bed, place, particles.smoothing_length[i], |cell, weight| {
            if here == Some(cell)
                || (level > bed.elevation[cell]
                    && bed.is_in_sight(place, level, cell)
                    && !walls.is_walled(place, bed.lattice.centre(cell)))
            {
                act(cell, weight);
            }
        });
    }

    /// Finds S of every cell, particle by particle, so that the threads do not matter.
    fn find_cover(&mut self, particles: &FluidParticles, ground: (&BedParticles, &Walls)) {
        let mut cover = std::mem::take(&mut self.cover);
        cover.fill(Cover::default());
        for i in 0..particles.len() {
            let area = particles.volume[i] / particles.depth[i];
            self.for_each_covered(particles, i, ground, |cell, weight| cover[cell].sum += area * weight);
            if let Some(cell) = ground.0.lattice.cell_at(particles.position[i]) {
                cover[cell].is_held = true;
            }
        }
        self.cover = cover;
    }

    /// Takes up the particles that have become small among others, one after the other: the cells under them have their water now.
    fn take_up(&mut self, particles: &mut FluidParticles, rates: &mut Vec<Rates>, ground: (&BedParticles, &Walls)) {
        let bed = ground.0;
        let cell_area = self.dimension.area(bed.lattice.spacing);
        let mut cover = std::mem::take(&mut self.cover);
        let mut is_kept = vec![true; particles.len()];
        for (i, is_kept) in is_kept.iter_mut().enumerate() {
            let area = particles.volume[i] / particles.depth[i];
            let cell = bed.lattice.cell_at(particles.position[i]).filter(|_| area < SMALL * cell_area);
            let own = cell.map_or(0.0, |cell| {
                let mut own = 0.0;
                self.for_each_covered(particles, i, ground, |other, weight| {
                    own += if other == cell { area * weight } else { 0.0 };
                });
                own
            });
            let taken = cell.filter(|&cell| cover[cell].sum - own >= COVERED.1 * self.whole[cell] && own > 0.0);
            if let Some(cell) = taken {
                self.for_each_covered(particles, i, ground, |other, weight| cover[other].sum -= area * weight);
                let depth = particles.volume[i] / cell_area;
                cover[cell].takes += depth;
                cover[cell].takes_flow += particles.velocity[i] * depth;
                *is_kept = false;
            }
        }
        particles.retain(&is_kept);
        retain_marked(rates, &is_kept);
        self.cover = cover;
    }

    /// Takes what lies on cells that hold water from there.
    fn share_out(&mut self, bed: &BedParticles) {
        let cells = self.cover.par_iter_mut().zip(&mut self.gathered).zip(&self.whole).enumerate();
        cells.with_min_len(CHUNK).for_each(|(cell, ((cover, gathered), whole))| {
            let covered = cover.sum / whole.max(f64::MIN_POSITIVE);
            // What went up in a cell is held by those that cover it, not by the particle that stood there.
            let is_held = cover.is_held && cover.takes <= 0.0;
            if !(bed.has_terrain(cell) && cover.sum > 0.0 && (is_held || covered >= COVERED.0)) {
                *gathered += cover.takes;
            } else {
                cover.is_wet = true;
                cover.gives = std::mem::take(gathered) + cover.takes;
                cover.lifts = ((covered - COVERED.0) / (COVERED.1 - COVERED.0)).clamp(0.0, 1.0);
            }
        });
    }

    /// Gives the particles what the cells under them gave.
    fn lift(&self, particles: &mut FluidParticles, ground: (&BedParticles, &Walls)) {
        let cell_area = self.dimension.area(ground.0.lattice.spacing);
        let given: Vec<(f64, f64, Vec2)> = (0..particles.len())
            .into_par_iter()
            .with_min_len(CHUNK)
            .map(|i| {
                let (mut volume, mut kept, mut lifted, mut weights, mut flow) = (0.0, 0.0, 0.0, 0.0, Vec2::ZERO);
                self.for_each_covered(particles, i, ground, |cell, weight| {
                    let Cover { sum, is_wet, gives, lifts, takes_flow, .. } = self.cover[cell];
                    if is_wet {
                        let share = weight * cell_area * gives / sum;
                        volume += share;
                        flow += takes_flow * (weight * cell_area / sum);
                        kept += (1.0 - lifts) * share;
                        let crowd = particles.depth[i] * (sum / self.whole[cell] - CROWDED).max(0.0);
                        lifted += lifts * weight * (gives + crowd).min(2.0 * gives);
                        weights += weight;
                    }
                });
                let lifted = if weights > 0.0 { lifted / weights } else { 0.0 };
                let area = particles.volume[i] / particles.depth[i];
                (area * volume, lifted + kept, flow * area)
            })
            .collect();
        for (i, (volume, depth, flow)) in given.into_iter().enumerate().filter(|(_, (volume, ..))| *volume > 0.0) {
            let all = particles.volume[i] + volume;
            particles.velocity[i] = (particles.velocity[i] * particles.volume[i] + flow) * (1.0 / all);
            particles.volume[i] += volume;
            particles.depth[i] += depth;
        }
    }

    /// Makes particles of the films that run.
    fn make_films(&mut self, particles: &mut FluidParticles, rates: &mut Vec<Rates>, bed: &BedParticles) {
        let (spacing, area) = (bed.lattice.spacing, self.dimension.area(bed.lattice.spacing));
        let smoothing_length = smoothing_factor(self.dimension) * spacing;
        for (cell, gathered) in self.gathered.iter_mut().enumerate().filter(|(_, depth)| **depth >= self.film) {
            let depth = std::mem::take(gathered);
            let position = bed.lattice.centre(cell);
            particles.push(&Particle { position, velocity: Vec2::ZERO, volume: depth * area, depth, smoothing_length });
            rates.push(Rates { reach: smoothing_length, ..Rates::default() });
        }
    }
}

#[cfg(test)]
mod tests;
