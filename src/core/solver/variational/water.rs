//! The particles of the variational formulation and what is under and around them: bed and walls.

use rayon::prelude::*;

use super::neighbours::Neighbours;
use super::{CHUNK, MovingMethods, Rates};

use crate::bed::{BedParticles, BedPoint, derive_curvatures};
use crate::boundary::{Edge, Walls, outline};
use crate::math::{Sym2, Vec2};
use crate::methods::{BedSlope, WallMethod};
use crate::particles::{FluidParticles, FluidSeed};
use crate::physics::dimension::Dimension;
use crate::solver::FlowProblem;
use crate::solver::phases::Phases;
use crate::solver::scratch::Scratch;

/// Moving particles and their surroundings.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
pub struct MovingWater {
    /// One or two dimensions.
    pub dimension: Dimension,
    /// Gravity (m/s²).
    pub gravity: f64,
    /// Depth (m) below which water does not move.
    pub dry_depth: f64,
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
    #[serde(skip)]
    pub phases: Phases,
    /// Centres of the cells of the bed (m), as walls mirror them; their supports are nothing.
    pub(super) cell_centres: Vec<Vec2>,
    pub(super) cell_supports: Vec<f32>,
    /// Scratch space: the walls near a particle.
    pub(super) near_walls: Scratch<Vec<u32>>,
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
        let is_open = |place: Vec2, normal: Vec2| problem.open_edges.is_open(place, normal);
        let mut edges = match dimension {
            Dimension::One => channel_ends(&problem, is_open),
            Dimension::Two => outline(&problem.bed, is_open),
        };
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
        let mut bed = problem.bed;
        let mut manning = std::mem::take(&mut bed.manning);
        if manning.iter().all(|n| n.to_bits() == manning[0].to_bits()) {
            manning.truncate(1);
            manning.shrink_to_fit();
        }
        if methods.bed_slope == BedSlope::Steep {
            derive_curvatures(&mut bed);
        }
        let cells = bed.lattice.len();
        MovingWater {
            cell_centres: (0..cells).map(|cell| bed.lattice.centre(cell)).collect(),
            cell_supports: vec![0.0; cells],
            dimension,
            gravity: problem.gravity,
            dry_depth: problem.dry_depth,
            particles: FluidParticles::from_seeds(seeds),
            rates: Vec::new(),
            neighbours: Neighbours::default(),
            walls,
            bed,
            manning,
            phases: Phases::default(),
            near_walls: Scratch::default(),
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

    /// Passes the bed under every particle to `take`, chunk by chunk.
    pub fn sample_bed<T: Send>(&self, values: &mut [T], take: impl Fn(&mut T, BedPoint) + Sync) {
        values.par_chunks_mut(CHUNK).zip(self.particles.position.par_chunks(CHUNK)).for_each(|(values, positions)| {
            for (value, &position) in values.iter_mut().zip(positions) {
                take(value, self.bed_at(position));
            }
        });
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
