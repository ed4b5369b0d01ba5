//! Point sources among moving particles: water that comes out of the ground at a place.
//!
//! A source owes what came since its last particle. It gives one as wide as a cell, at rest, as soon as it owes its volume,
//!
//! ```text
//! (M64)  V = Δ² max(d, d_c),   d_c = (q²/g)^(1/3),   q = Q/(4 Δ)
//! ```
//!
//! with d the depth at the place and d_c that of critical flow out of a cell on all sides: so it runs on dry ground, too. Between two
//! particles the depth around the place rises by what comes, in the shares of a kernel,
//!
//! ```text
//! (M65)  dd_i/dt = Q W_i / max(Σ A_j W_j, 0.3),   W_i = W(|x_i − x_s|, 3 Δ)
//! ```
//!
//! since the depth of moving particles is carried and does not feel another one among them; they make room for it.

use crate::boundary::{PointSource, Series};
use crate::math::Vec2;
use crate::particles::{FluidParticles, Particle};
use crate::physics::dimension::Dimension;
use crate::physics::kernel::{CubicSpline, Shape, Smoothing};
use crate::solver::moving::{Rates, smoothing_factor};
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

/// One source.
#[derive(Clone, Debug)]
struct Spring {
    /// Its number in the problem.
    number: usize,
    place: Vec2,
    discharge: Series,
    /// Volume (m³) that came since the last particle.
    owed: f64,
    /// Volume (m³) that came since the start.
    came: f64,
    given: u32,
}

/// All sources.
#[derive(Clone, Debug)]
pub(super) struct Springs {
    springs: Vec<Spring>,
    dimension: Dimension,
    kernel: Smoothing<CubicSpline>,
    spacing: f64,
    gravity: f64,
    time: f64,
    /// Weights W (m^−dim) of the particles around a source.
    around: Vec<(usize, f64)>,
}

impl Springs {
    pub fn new(problem: &FlowProblem, dimension: Dimension) -> Self {
        let bed = &problem.bed;
        let sources = problem.forcing.sources.iter().enumerate().filter(|(_, source)| bed.at(source.place).is_some());
        let spring = |(number, source): (usize, &PointSource)| Spring {
            number,
            place: source.place,
            discharge: source.discharge.clone(),
            owed: 0.0,
            came: 0.0,
            given: 0,
        };
        Springs {
            springs: sources.map(spring).collect(),
            dimension,
            kernel: Smoothing::new(dimension),
            spacing: bed.lattice.spacing,
            gravity: problem.gravity,
            time: 0.0,
            around: Vec::new(),
        }
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
            way: Way::Source(spring.number),
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

    /// d_c (m) of a discharge (m³/s).
    fn critical_depth(&self, discharge: f64) -> f64 {
        let q = discharge / (4.0 * self.spacing);
        (q * q / self.gravity).cbrt()
    }

    /// A volume (m³), in one dimension per metre of width.
    fn per_width(&self, volume: f64) -> f64 {
        if self.dimension == Dimension::One { volume / self.spacing } else { volume }
    }

    /// What comes between two times; in one dimension per metre of width.
    fn volume(&self, spring: &Spring, from: f64, to: f64) -> f64 {
        self.per_width(spring.discharge.integral(from, to).max(0.0))
    }

    /// The longest step (s) in which no source gives more than one particle.
    pub fn longest_step(&self, step: f64) -> f64 {
        let longest = |spring: &Spring| {
            let most = spring.discharge.largest(self.time, self.time + step);
            let volume = self.critical_depth(most) * self.spacing * self.spacing;
            if most > 0.0 { volume / most } else { f64::INFINITY }
        };
        self.springs.iter().map(longest).fold(step, f64::min)
    }

    /// What comes in a time (s).
    pub fn flow(&mut self, particles: &mut FluidParticles, rates: &mut Vec<Rates>, dt: f64) {
        let (from, to) = (self.time, self.time + dt);
        self.time = to;
        let (h, area) = (self.width(), self.dimension.area(self.spacing));
        let mut around = std::mem::take(&mut self.around);
        for k in 0..self.springs.len() {
            let came = self.volume(&self.springs[k], from, to);
            if came <= 0.0 {
                continue;
            }
            self.springs[k].came += came;
            let place = self.springs[k].place;
            let cover = self.look_around(place, particles, &mut around);
            let depth =
                around.iter().map(|&(i, w)| w * particles.volume[i]).sum::<f64>() / cover.max(f64::MIN_POSITIVE);
            for &(i, w) in &around {
                particles.depth[i] += came * w / cover.max(LEAST_COVER);
            }
            let critical = self.critical_depth(self.springs[k].discharge.mean(from, to));
            let depth = if cover >= LEAST_COVER { depth.max(critical) } else { critical };
            let spring = &mut self.springs[k];
            spring.owed += came;
            if spring.owed >= area * depth {
                let angle = GOLDEN_ANGLE * f64::from(spring.given);
                let way = match (spring.given, self.dimension) {
                    (0, _) => Vec2::ZERO,
                    (_, Dimension::One) => Vec2::new(angle.cos(), 0.0),
                    (_, Dimension::Two) => Vec2::new(angle.cos(), angle.sin()),
                };
                spring.owed -= area * depth;
                spring.given += 1;
                particles.push(&Particle {
                    position: place + way * (SCATTER * self.spacing),
                    velocity: Vec2::ZERO,
                    volume: area * depth,
                    depth,
                    smoothing_length: h,
                });
                rates.push(Rates { reach: h, ..Rates::default() });
            }
        }
        self.around = around;
    }

    /// Lists the particles around a place with their weights; returns Σ A W.
    fn look_around(&self, place: Vec2, particles: &FluidParticles, around: &mut Vec<(usize, f64)>) -> f64 {
        let h = SPREAD * self.width();
        let (inverse_h, reach) = (1.0 / h, CubicSpline::SUPPORT * h);
        around.clear();
        for (i, position) in particles.position.iter().enumerate() {
            let squared = (*position - place).norm_squared();
            if squared < reach * reach {
                around.push((i, self.kernel.value(squared.sqrt(), inverse_h)));
            }
        }
        around.iter().map(|&(i, w)| w * particles.volume[i] / particles.depth[i]).sum()
    }

    /// Adds what the sources owe to the particles for their gridding.
    pub fn lend(&self, particles: &mut FluidParticles) {
        let area = self.dimension.area(self.spacing);
        for spring in self.springs.iter().filter(|spring| spring.owed > 0.0) {
            particles.push(&Particle {
                position: spring.place,
                velocity: Vec2::ZERO,
                volume: spring.owed,
                depth: spring.owed / area,
                smoothing_length: self.width(),
            });
        }
    }
}
