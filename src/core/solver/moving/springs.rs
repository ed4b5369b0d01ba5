//! Sources among moving particles: water that comes out of the ground at a place or along a line.
//!
//! A line has an outlet in each cell that it crosses, with the part Q_o of the discharge Q that its length there gives; a point has one, with
//! Q_o = Q. A source owes what came since its last particle. As soon as it owes the volume of one, the outlet to which most is owed gives
//! it, as wide as a cell and at rest,
//!
//! ```text
//! (M70)  V = Δ² max(d, d_c, 2 d_dry),   d_c = (q²/g)^(1/3),   q = Q_o/(4 Δ)
//! ```
//!
//! with d the depth at the outlet, d_c that of critical flow out of a cell on all sides and 2 d_dry that of a film that runs: so it runs on
//! dry ground, too. Between two particles the depth around each outlet rises by what comes, in the shares of a kernel,
//!
//! ```text
//! (M71)  dd_i/dt = Q_o W_i / max(Σ A_j W_j, 0.3),   W_i = W(|x_i − x_s|, 3 Δ)
//! ```
//!
//! since the depth of moving particles is carried and does not feel another one among them; they make room for it. Water behind a wall or
//! a levee does not rise.

use rayon::prelude::*;

use crate::bed::BedParticles;
use crate::boundary::{LineSource, PointSource, Series, Walls};
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::particles::{FluidParticles, Particle};
use crate::physics::dimension::Dimension;
use crate::physics::kernel::{CubicSpline, Shape, Smoothing};
use crate::solver::moving::{CHUNK, FILM, Rates, smoothing_factor};
use crate::solver::{FlowProblem, Passage, Way};

/// Σ A W around a place from which on there is water to interpolate.
const LEAST_COVER: f64 = 0.3;
/// The depth rises in so many supports of a particle as wide as a cell. In a lake 1 m deep that a source fills for 6000 s its level was off
/// by 0.017 m with 1, by 0.012 m with 2 and by 0.036 m with 3.
const SPREAD: f64 = 2.0;
/// Particles come out so far (in spacings) from the place, each in another direction, so that no two stand in one place.
const SCATTER: f64 = 0.25;
/// The golden angle (radians): directions that never repeat.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
/// The golden ratio less 1: parts of a line that come after each other lie far apart.
const GOLDEN_RATIO: f64 = 0.618_033_988_749_895;

/// A place at which water of a source comes out.
#[derive(Clone, Debug)]
struct Outlet {
    place: Vec2,
    cell: usize,
    /// Share of the discharge of its source.
    share: f64,
    /// Depth (m) of the particle that it would give now.
    depth: f64,
    /// Volume (m³) that came here less that of its particles.
    debt: f64,
    given: u32,
}

impl Outlet {
    fn new(lattice: &Lattice, place: Vec2, share: f64) -> Option<Self> {
        Some(Outlet { place, cell: lattice.cell_at(place)?, share, depth: 0.0, debt: 0.0, given: 0 })
    }
}

/// One source.
#[derive(Clone, Debug)]
struct Spring {
    way: Way,
    discharge: Series,
    outlets: Vec<Outlet>,
    /// Volume (m³) that came since the last particle.
    owed: f64,
    /// Volume (m³) that came since the start.
    came: f64,
}

impl Spring {
    /// The greatest share of an outlet.
    fn largest_share(&self) -> f64 {
        self.outlets.iter().map(|outlet| outlet.share).fold(0.0, f64::max)
    }

    /// The outlet that gives the next particle: the one to which most is owed, the first of several.
    fn next(&self) -> usize {
        let debt = |k: &usize| self.outlets[*k].debt;
        (1..self.outlets.len()).fold(0, |best, k| if debt(&k) > debt(&best) { k } else { best })
    }
}

/// A particle near a source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Near {
    cell: u32,
    particle: u32,
}

/// All sources.
#[derive(Clone, Debug)]
pub(super) struct Springs {
    springs: Vec<Spring>,
    dimension: Dimension,
    kernel: Smoothing<CubicSpline>,
    spacing: f64,
    gravity: f64,
    /// Depth (m) of a film that runs.
    film: f64,
    time: f64,
    /// Whether the water in each cell of the lattice may lie within reach of a source; empty without sources.
    is_near: Vec<bool>,
    /// The particles in these cells, in the order of the cells.
    near: Vec<Near>,
    /// Weights W (m^−dim) of the particles around a source.
    around: Vec<(usize, f64)>,
}

impl Springs {
    pub fn new(problem: &FlowProblem, dimension: Dimension) -> Self {
        let (bed, forcing) = (&problem.bed, &problem.forcing);
        let lattice = &bed.lattice;
        let spring = |way: Way, discharge: &Series, outlets: Vec<Outlet>| Spring {
            way,
            discharge: discharge.clone(),
            outlets: outlets.into_iter().filter(|outlet| bed.has_terrain(outlet.cell)).collect(),
            owed: 0.0,
            came: 0.0,
        };
        let at_point = |(number, source): (usize, &PointSource)| {
            let outlet = Outlet::new(lattice, source.place, 1.0);
            spring(Way::Source(number), &source.discharge, outlet.into_iter().collect())
        };
        let along_line = |(number, source): (usize, &LineSource)| {
            let outlets = scattered(&source.cells);
            let outlets = outlets.filter_map(|(cell, share)| Outlet::new(lattice, lattice.centre(cell), share));
            spring(Way::LineSource(number), &source.discharge, outlets.collect())
        };
        let points = forcing.sources.iter().enumerate().map(at_point);
        let lines = forcing.line_sources.iter().enumerate().map(along_line);
        let springs: Vec<Spring> = points.chain(lines).filter(|spring| !spring.outlets.is_empty()).collect();
        let mut springs = Springs {
            is_near: vec![false; if springs.is_empty() { 0 } else { lattice.len() }],
            springs,
            dimension,
            kernel: Smoothing::new(dimension),
            spacing: lattice.spacing,
            gravity: problem.gravity,
            film: FILM * problem.dry_depth,
            time: 0.0,
            near: Vec::new(),
            around: Vec::new(),
        };
        let mut is_near = std::mem::take(&mut springs.is_near);
        for outlet in springs.springs.iter().flat_map(|spring| &spring.outlets) {
            for (from, to) in springs.rows_around(lattice, outlet.place) {
                is_near[from..to].fill(true);
            }
        }
        springs.is_near = is_near;
        springs
    }

    pub fn is_empty(&self) -> bool {
        self.springs.is_empty()
    }

    /// Volume (m³) that came in since the start.
    pub fn inflow(&self) -> f64 {
        self.springs.iter().map(|spring| spring.came).sum()
    }

    /// What came by each source; in one dimension per metre of width, as what was asked for.
    pub fn passages(&self) -> impl Iterator<Item = Passage> + '_ {
        self.springs.iter().map(|spring| Passage {
            way: spring.way,
            inflow: spring.came,
            outflow: 0.0,
            asked: Some(self.per_width(spring.discharge.integral(0.0, self.time))),
        })
    }

    /// Volume (m³) that came in and is no particle yet.
    pub fn owed(&self) -> f64 {
        self.springs.iter().map(|spring| spring.owed).sum()
    }

    /// Smoothing length (m) of a particle as wide as a cell.
    fn width(&self) -> f64 {
        smoothing_factor(self.dimension) * self.spacing
    }

    /// Smoothing length (m) in which the depth rises.
    fn spread(&self) -> f64 {
        SPREAD * self.width()
    }

    /// Least depth (m) of a particle that comes out with a discharge (m³/s): d_c, but never a film that stays where it is.
    fn least_depth(&self, discharge: f64) -> f64 {
        let q = discharge / (4.0 * self.spacing);
        (q * q / self.gravity).cbrt().max(self.film)
    }

    /// A volume (m³), in one dimension per metre of width.
    fn per_width(&self, volume: f64) -> f64 {
        if self.dimension == Dimension::One { volume / self.spacing } else { volume }
    }

    /// What comes between two times; in one dimension per metre of width.
    fn volume(&self, spring: &Spring, from: f64, to: f64) -> f64 {
        self.per_width(spring.discharge.integral(from, to).max(0.0))
    }

    /// The longest step (s) in which no outlet gives more than one particle.
    pub fn longest_step(&self, step: f64) -> f64 {
        let longest = |spring: &Spring| {
            let most = spring.discharge.largest(self.time, self.time + step) * spring.largest_share();
            let volume = self.least_depth(most) * self.spacing * self.spacing;
            if most > 0.0 { volume / most } else { f64::INFINITY }
        };
        self.springs.iter().map(longest).fold(step, f64::min)
    }

    /// What comes in a time (s).
    pub fn flow(
        &mut self,
        particles: &mut FluidParticles,
        rates: &mut Vec<Rates>,
        ground: (&BedParticles, &Walls),
        dt: f64,
    ) {
        let (from, to) = (self.time, self.time + dt);
        self.time = to;
        if self.is_empty() {
            return;
        }
        self.find_near(&ground.0.lattice, particles);
        let mut springs = std::mem::take(&mut self.springs);
        for spring in &mut springs {
            let came = self.volume(spring, from, to);
            if came <= 0.0 {
                continue;
            }
            let came = came * spring.outlets.iter().map(|outlet| outlet.share).sum::<f64>();
            spring.came += came;
            spring.owed += came;
            let mean = spring.discharge.mean(from, to);
            for outlet in &mut spring.outlets {
                self.lift_around(outlet, particles, ground, (came * outlet.share, mean * outlet.share));
            }
            self.give(spring, particles, rates);
        }
        self.springs = springs;
    }

    /// Lifts the water around an outlet by the volume (m³) that came, and finds the depth of the particle that it would give at a
    /// discharge (m³/s).
    fn lift_around(
        &mut self,
        outlet: &mut Outlet,
        particles: &mut FluidParticles,
        ground: (&BedParticles, &Walls),
        (came, discharge): (f64, f64),
    ) {
        let least = self.least_depth(discharge);
        let mut around = std::mem::take(&mut self.around);
        let cover = self.look_around(outlet, least, particles, ground, &mut around);
        let depth = around.iter().map(|&(i, w)| w * particles.volume[i]).sum::<f64>() / cover.max(f64::MIN_POSITIVE);
        for &(i, w) in &around {
            particles.depth[i] += came * w / cover.max(LEAST_COVER);
        }
        outlet.debt += came;
        outlet.depth = if cover >= LEAST_COVER { depth.max(least) } else { least };
        self.around = around;
    }

    /// Makes particles of what a source owes, at most one for each outlet.
    fn give(&self, spring: &mut Spring, particles: &mut FluidParticles, rates: &mut Vec<Rates>) {
        let (h, area) = (self.width(), self.dimension.area(self.spacing));
        for _ in 0..spring.outlets.len() {
            let next = spring.next();
            let outlet = &mut spring.outlets[next];
            let volume = area * outlet.depth;
            if spring.owed < volume {
                break;
            }
            let angle = GOLDEN_ANGLE * f64::from(outlet.given);
            let way = match (outlet.given, self.dimension) {
                (0, _) => Vec2::ZERO,
                (_, Dimension::One) => Vec2::new(angle.cos(), 0.0),
                (_, Dimension::Two) => Vec2::new(angle.cos(), angle.sin()),
            };
            spring.owed -= volume;
            outlet.debt -= volume;
            outlet.given += 1;
            particles.push(&Particle {
                position: outlet.place + way * (SCATTER * self.spacing),
                velocity: Vec2::ZERO,
                volume,
                depth: outlet.depth,
                smoothing_length: h,
            });
            rates.push(Rates { reach: h, ..Rates::default() });
        }
    }

    /// Finds the particles near sources: one look at each particle, however many the sources are.
    fn find_near(&mut self, lattice: &Lattice, particles: &FluidParticles) {
        let (is_near, positions) = (&self.is_near, &particles.position);
        let near = |(i, place): (usize, &Vec2)| {
            let cell = lattice.cell_at(*place).filter(|&cell| is_near[cell])?;
            Some(Near { cell: cell as u32, particle: i as u32 })
        };
        self.near.clear();
        self.near.par_extend(positions.par_iter().enumerate().with_min_len(CHUNK).filter_map(near));
        self.near.sort_unstable();
    }

    /// The cells that hold what lies within reach of a place: first and one past the last of each row.
    fn rows_around(&self, lattice: &Lattice, place: Vec2) -> impl Iterator<Item = (usize, usize)> + use<> {
        let reach = CubicSpline::SUPPORT * self.spread();
        let (spacing, columns) = (self.spacing, lattice.columns);
        let within = |place: f64, count: usize| {
            let first = ((place - reach) / spacing).max(0.0) as usize;
            (first.min(count), (((place + reach) / spacing).max(0.0) as usize + 1).min(count))
        };
        let ((west, east), (south, north)) = (within(place.x, columns), within(place.y, lattice.rows));
        (south..north).map(move |row| (row * columns + west, row * columns + east))
    }

    /// Lists the particles that see an outlet with their weights; returns Σ A W. Nothing sees it across a wall, or across ground above
    /// both the particle's level and that of water of the least depth (m) at the outlet.
    fn look_around(
        &self,
        outlet: &Outlet,
        least: f64,
        particles: &FluidParticles,
        ground: (&BedParticles, &Walls),
        around: &mut Vec<(usize, f64)>,
    ) -> f64 {
        let bed = ground.0;
        let h = self.spread();
        let (inverse_h, reach) = (1.0 / h, CubicSpline::SUPPORT * h);
        let own_level = bed.elevation[outlet.cell] + least;
        around.clear();
        for (from, to) in self.rows_around(&bed.lattice, outlet.place) {
            let first = self.near.partition_point(|near| (near.cell as usize) < from);
            for near in self.near[first..].iter().take_while(|near| (near.cell as usize) < to) {
                let i = near.particle as usize;
                let place = particles.position[i];
                let squared = (place - outlet.place).norm_squared();
                if squared >= reach * reach {
                    continue;
                }
                let level = bed.at(place).map_or(own_level, |point| point.elevation + particles.depth[i]);
                let is_walled = squared > 0.0 && ground.1.is_walled(place, outlet.place);
                if !is_walled && bed.is_in_sight(place, level.max(own_level), outlet.cell) {
                    around.push((i, self.kernel.value(squared.sqrt(), inverse_h)));
                }
            }
        }
        around.iter().map(|&(i, w)| w * particles.volume[i] / particles.depth[i]).sum()
    }

    /// Adds what the sources owe to the particles for their gridding.
    pub fn lend(&self, particles: &mut FluidParticles) {
        let area = self.dimension.area(self.spacing);
        for spring in self.springs.iter().filter(|spring| spring.owed > 0.0) {
            let whole: f64 = spring.outlets.iter().map(|outlet| outlet.share).sum();
            for outlet in &spring.outlets {
                let volume = spring.owed * (outlet.share / whole);
                particles.push(&Particle {
                    position: outlet.place,
                    velocity: Vec2::ZERO,
                    volume,
                    depth: volume / area,
                    smoothing_length: self.width(),
                });
            }
        }
    }
}

/// The cells of a line with their shares, in an order in which those that follow each other lie far apart: equal shares give their
/// particles in this order.
fn scattered(cells: &[(usize, f64)]) -> impl Iterator<Item = (usize, f64)> + use<> {
    let mut places: Vec<(f64, (usize, f64))> =
        cells.iter().enumerate().map(|(k, cell)| ((k as f64 * GOLDEN_RATIO).fract(), *cell)).collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    places.into_iter().map(|(_, cell)| cell)
}

#[cfg(test)]
mod tests;
