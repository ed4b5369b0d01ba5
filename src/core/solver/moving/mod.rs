//! What both formulations with moving particles share: the particles, the bed and walls under and around them, the search
//! for neighbours, the integrators and the books.
//!
//! A formulation turns the present state into rates (`Formulation::evaluate`); everything else is here, once.

mod bed_motion;
mod correction;
mod dam_walls;
mod kernel;
mod merge;
mod neighbours;
mod open;
mod rain;
#[cfg(test)]
mod scene;
mod sections;
mod solver;
mod springs;
mod step;

pub use correction::{correction, is_inverted};
pub(super) use kernel::with_kernel;
pub use kernel::{ChosenKernel, smoothing_factor};
pub use neighbours::{CHUNK, CHUNKS_AT_ONCE, Glance, LANES, Neighbours, Seen};
pub use solver::MovingSolver;

use bytemuck::{Pod, Zeroable};
use open::OpenBoundaries;
use rain::Rainfall;
use rayon::prelude::*;
use sections::Sections;
use springs::Springs;

use crate::bed::{BedParticles, BedPoint, derive_curvatures};
use crate::boundary::{Edge, Walls, outline};
use crate::math::{Sym2, Vec2};
use crate::methods::{BedSlope, Integrator, Kernel, Reconstruction, Stabilisation, WallMethod};
use crate::particles::{FluidParticles, FluidSeed, Line};
use crate::physics::dimension::Dimension;
use crate::solver::phases::Phases;
use crate::solver::scratch::Scratch;
use crate::solver::{FlowProblem, Passage, Way};

/// The largest area of a particle over the largest one at the start: twelve times as wide in the plane.
const LARGEST_SPREAD: f64 = 144.0;
/// A film begins to run at so many times the depth below which water does not move.
const FILM: f64 = 2.0;

/// The methods of moving particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MovingMethods {
    /// Time integration.
    pub integrator: Integrator,
    /// Smoothing kernel.
    pub kernel: Kernel,
    /// Treatment of pairs.
    pub stabilisation: Stabilisation,
    /// What a pair takes for the states on both sides of its face.
    pub reconstruction: Reconstruction,
    /// Effect of the bed's slope.
    pub bed_slope: BedSlope,
    /// What stands for walls.
    pub wall: WallMethod,
}

impl MovingMethods {
    /// An integrator and a treatment of pairs, and the usual choice of everything else.
    pub fn new(integrator: Integrator, stabilisation: Stabilisation) -> Self {
        let reconstruction = stabilisation.usual_reconstruction();
        MovingMethods {
            integrator,
            kernel: Kernel::default(),
            stabilisation,
            reconstruction,
            bed_slope: BedSlope::default(),
            wall: WallMethod::default(),
        }
    }
}

/// The rates of one particle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Rates {
    /// dv/dt (m/s²) without friction.
    pub acceleration: Vec2,
    /// dd/dt (m/s); not used where the depth is summed.
    pub depth_rate: f64,
    /// Added to the velocity with which the position moves (m/s).
    pub shift: Vec2,
    /// Greatest speed (m/s) at which a neighbour approaches or leaves.
    pub approach: f64,
    /// Length (m) that a signal must not outrun in a step: the smoothing length, or less where the pair faces act harder.
    pub reach: f64,
}

/// A way of turning the state of moving particles into rates.
pub trait Formulation: Send {
    /// Whether the depth is carried and integrated, instead of being summed over neighbours.
    const CARRIES_DEPTH: bool;

    /// Chooses the first smoothing lengths; called once, before the first evaluation.
    fn prepare(&mut self, water: &mut MovingWater);

    /// Fills `water.rates`, and `smoothing_length` (and `depth` where it is summed) of the particles, for their present state.
    fn evaluate(&mut self, water: &mut MovingWater);

    /// Memory that is free until the next evaluation, if any: twice a line for each of so many particles.
    fn spare_memory(&mut self, _particles: usize) -> Option<[&mut [Line]; 2]> {
        None
    }
}

/// Moving particles and their surroundings.
#[derive(Debug)]
pub struct MovingWater {
    /// One or two dimensions.
    pub dimension: Dimension,
    /// Gravity (m/s²).
    pub gravity: f64,
    /// Depth (m) below which water does not move.
    pub dry_depth: f64,
    /// Plan area (m²; in one dimension length, m) over which a particle spreads at most.
    pub largest_area: f64,
    /// Width (m) of the smallest particle at the start, of a cell where water comes in.
    pub finest: f64,
    /// The particles.
    pub particles: FluidParticles,
    /// Their rates, from the latest evaluation.
    pub rates: Vec<Rates>,
    /// Who is near whom.
    pub neighbours: Neighbours,
    /// The riverbed, without its roughness.
    pub bed: BedParticles,
    /// Manning roughness (s·m^(−1/3)) of each riverbed particle, or a single number where it is the same everywhere.
    manning: Vec<f64>,
    /// Walls and open edges.
    pub walls: Walls,
    /// Where the time of the steps goes.
    pub phases: Phases,
    /// What comes and goes.
    open: OpenBoundaries,
    springs: Springs,
    sections: Sections,
    rainfall: Rainfall,
    /// Scratch space: the walls near a particle.
    near_walls: Scratch<Vec<u32>>,
}

/// How far walls stand aside of where they are drawn, in spacings: a particle on a wall would be seen from both of its sides, and let
/// the water through. It belongs to the northern side, as in [`crate::math::segments_cross`].
const ASIDE: Vec2 = Vec2 { x: 1e-8, y: -1e-6 };

impl MovingWater {
    /// Particles at rest on the bed of a problem.
    ///
    /// In one dimension the point of a wall and its mirror show the same: there walls are mirrors whatever `wall` says.
    pub fn new(problem: FlowProblem, seeds: &[FluidSeed], dimension: Dimension, methods: MovingMethods) -> Self {
        let lattice = &problem.bed.lattice;
        let is_open = |place: Vec2, normal: Vec2| {
            problem.open_edges.is_open(place, normal) || problem.forcing.boundary_at(place, normal).is_some()
        };
        let mut edges = match dimension {
            Dimension::One => channel_ends(&problem, is_open),
            Dimension::Two => outline(&problem.bed, is_open),
        };
        let support = ChosenKernel::new(methods.kernel, dimension).support();
        let (open, guides) = OpenBoundaries::new(&problem, &edges, dimension, support);
        edges.extend(guides);
        let aside = |place: Vec2| place + ASIDE * lattice.spacing;
        edges.extend(problem.walls.iter().map(|&[start, end]| Edge {
            start: aside(start),
            end: aside(end),
            is_open: false,
        }));
        if dimension == Dimension::One {
            edges.retain(|edge| (edge.end - edge.start).x.abs() < 1e-6 * (edge.end - edge.start).norm());
        }
        let walls = Walls::new(edges, lattice.spacing);
        let walls = match (methods.wall, dimension) {
            (WallMethod::Mirror, _) | (_, Dimension::One) => walls,
            (WallMethod::VirtualParticles, Dimension::Two) => walls.with_virtual_particles(lattice.spacing),
        };
        let (springs, sections) = (Springs::new(&problem, dimension), Sections::new(&problem, dimension));
        let rainfall = Rainfall::new(&problem, dimension);
        let mut bed = problem.bed;
        let mut manning = std::mem::take(&mut bed.manning);
        if manning.iter().all(|n| n.to_bits() == manning[0].to_bits()) {
            manning.truncate(1);
            manning.shrink_to_fit();
        }
        if methods.bed_slope == BedSlope::Steep {
            derive_curvatures(&mut bed);
        }
        // Water that comes in is as wide as a cell.
        let cell = (!problem.forcing.is_still()).then(|| dimension.area(bed.lattice.spacing));
        let areas = || seeds.iter().map(|seed| seed.volume / seed.depth).chain(cell);
        MovingWater {
            dimension,
            gravity: problem.gravity,
            dry_depth: problem.dry_depth,
            largest_area: LARGEST_SPREAD * areas().fold(0.0, f64::max),
            finest: dimension.edge(areas().fold(f64::INFINITY, f64::min)),
            particles: FluidParticles::from_seeds(seeds),
            rates: Vec::new(),
            neighbours: Neighbours::default(),
            walls,
            bed,
            manning,
            phases: Phases::default(),
            open,
            springs,
            sections,
            rainfall,
            near_walls: Scratch::default(),
        }
    }

    /// Puts the buffer particles of open boundaries behind the water, for the time of an evaluation; returns how many particles
    /// are water.
    pub fn admit(&mut self) -> usize {
        let fluid = self.particles.len();
        if !self.open.is_empty() {
            self.open.admit(&mut self.particles, &self.bed);
        }
        fluid
    }

    /// Takes the buffer particles out again, behind the first `fluid` ones.
    pub fn dismiss(&mut self, fluid: usize) {
        if !self.open.is_empty() {
            self.open.dismiss(fluid, &mut self.particles, &mut self.rates);
        }
    }

    /// Makes water of the buffer particles that came in, and of what sources and rain gave in a time (s).
    pub(super) fn enter(&mut self, time: f64) {
        let fluid = self.particles.len();
        let ground = (&self.bed, &self.walls);
        self.open.enter(&mut self.particles, &mut self.rates, ground);
        self.sections.close(&self.particles, fluid, time);
        self.springs.flow(&mut self.particles, &mut self.rates, ground, time);
        self.rainfall.fall(&mut self.particles, &mut self.rates, ground, time);
    }

    /// Whether water comes and goes.
    pub(super) fn is_fed(&self) -> bool {
        !self.open.is_empty() || !self.springs.is_empty() || !self.rainfall.is_none()
    }

    /// Volume (m³) that boundaries and sources owe, and that of rain on dry ground.
    pub(super) fn owed(&self) -> f64 {
        self.open.owed() + self.springs.owed() + self.rainfall.owed(&self.bed)
    }

    /// Volumes (m³) that came and left by boundaries, sources and rain.
    pub(super) fn passed(&self) -> (f64, f64) {
        (self.open.inflow() + self.springs.inflow() + self.rainfall.inflow(), self.open.outflow())
    }

    /// What came and left by each way; `over_edges` (m³) by open edges without a condition.
    pub(super) fn passages(&self, over_edges: f64) -> Vec<Passage> {
        let over_edges = Passage { way: Way::OpenEdges, inflow: 0.0, outflow: over_edges, asked: None };
        let plain = self.open.has_plain_edges().then_some(over_edges);
        let of_rain = self.rainfall.passage(&self.bed);
        plain.into_iter().chain(self.open.passages()).chain(self.springs.passages()).chain(of_rain).collect()
    }

    /// Puts what boundaries and sources owe into the water for its gridding; returns how many particles are water.
    pub(super) fn lend(&mut self) -> usize {
        let fluid = self.particles.len();
        if !self.open.is_empty() {
            self.open.lend(&mut self.particles);
        }
        self.springs.lend(&mut self.particles);
        fluid
    }

    /// Depth (m) of the rain on each cell that is in no particle; empty where it never rains.
    pub(super) fn on_dry_ground(&self) -> &[f64] {
        self.rainfall.gathered()
    }

    /// Undoes `lend`.
    pub(super) fn take_back(&mut self, fluid: usize) {
        if self.is_fed() {
            self.open.take_back(fluid, &mut self.particles);
        }
    }

    /// The bed at a place (m), by the same function everywhere; beside the terrain the tangent plane of the nearest riverbed
    /// particle, and infinitely high where none is within two cells.
    pub fn bed_at(&self, place: Vec2) -> BedPoint {
        if let Some(point) = self.bed.at(place) {
            return point;
        }
        let lattice = &self.bed.lattice;
        let (column, row) = ((place.x / lattice.spacing).floor(), (place.y / lattice.spacing).floor());
        let mut nearest = (f64::INFINITY, None);
        for offset in 0..25 {
            let centre =
                Vec2::new(column + f64::from(offset % 5) - 1.5, row + f64::from(offset / 5) - 1.5) * lattice.spacing;
            let Some(index) = lattice.cell_at(centre).filter(|&index| self.bed.has_terrain(index)) else { continue };
            let distance = (place - centre).norm();
            if distance < nearest.0 {
                nearest = (distance, Some((index, place - centre)));
            }
        }
        nearest.1.map_or(BedPoint { elevation: f64::INFINITY, slope: Vec2::ZERO }, |(index, offset)| {
            let slope = self.bed.slope(index);
            BedPoint { elevation: self.bed.elevation[index] + slope.dot(offset), slope }
        })
    }

    /// Passes the bed under every particle to `take`, chunk by chunk; that under buffer particles, which stand behind the water, is what
    /// their boundary says.
    pub fn sample_bed<T: Send>(&self, values: &mut [T], take: impl Fn(&mut T, BedPoint) + Sync) {
        let (water, buffer) = values.split_at_mut(self.particles.len() - self.open.count());
        water.par_chunks_mut(CHUNK).zip(self.particles.position.par_chunks(CHUNK)).for_each(|(values, positions)| {
            for (value, &position) in values.iter_mut().zip(positions) {
                take(value, self.bed_at(position));
            }
        });
        buffer.iter_mut().zip(self.open.bed_points()).for_each(|(value, beyond)| take(value, beyond));
    }

    /// Depth (m) below which particle `i` does not thin: the dry depth, or its volume over the largest area.
    ///
    /// The carried depth of a film that runs off a steep bank falls without end, and with it the area V/d grows beyond the
    /// bank, the valley and every neighbourhood. A particle does not stand for water wider than that.
    #[inline]
    pub fn least_depth(&self, i: usize) -> f64 {
        self.dry_depth.max(self.particles.volume[i] / self.largest_area)
    }

    /// Curvature of the bed (1/m) at a place, that of its riverbed particle; kept for steep beds only.
    pub fn curvature_at(&self, place: Vec2) -> Sym2 {
        self.bed.lattice.cell_at(place).map_or(Sym2::default(), |cell| self.bed.curvature[cell])
    }

    /// Manning roughness (s·m^(−1/3)) at a place.
    pub fn manning_at(&self, place: Vec2) -> f64 {
        let of_cell = |cell: usize| if let [everywhere] = self.manning[..] { everywhere } else { self.manning[cell] };
        self.bed.lattice.cell_at(place).map_or(0.0, of_cell)
    }
}

/// The two ends of a channel of one dimension.
fn channel_ends(problem: &FlowProblem, is_open: impl Fn(Vec2, Vec2) -> bool) -> Vec<Edge> {
    let size = problem.bed.lattice.size();
    [0.0, size.x]
        .into_iter()
        .map(|x| {
            let is_open = is_open(Vec2::new(x, 0.5 * size.y), Vec2::new(1.0, 0.0));
            Edge { start: Vec2::new(x, -size.y), end: Vec2::new(x, 2.0 * size.y), is_open }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::scene::{problem, solver};
    use super::*;
    use crate::methods::Integrator;
    use crate::solver::testing::run_steps;

    #[test]
    fn a_lake_behind_walls_through_its_particles_stays_at_rest() {
        // Particles at 0.5 m, 1.5 m, ...: the walls go through those of a row, of a column and of a diagonal, and meet on particles.
        let places = [(12.5, 0.0), (12.5, 6.5), (8.5, 10.5), (0.0, 10.5)].map(|(x, y)| Vec2::new(x, y));
        let pieces = [[places[0], places[1]], [places[2], places[1]], [places[2], places[3]]];
        let is_lake = |p: Vec2| p.x < 12.6 && p.y < 10.4 && p.x + p.y < 18.9;
        for is_turned in [false, true] {
            let mut problem = problem((20, 16), 1.0, |_| 0.0, |p| if is_lake(p) { 2.0 } else { 0.0 });
            problem.walls = pieces.map(|[start, end]| if is_turned { [end, start] } else { [start, end] }).to_vec();
            let mut solver = solver(problem, Dimension::Two, Integrator::Leapfrog);
            let fastest = run_steps(&mut solver, 100);
            assert!(fastest < 1e-9, "{is_turned}: {fastest:e} m/s");
        }
    }
}
