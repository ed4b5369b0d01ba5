//! Open boundaries: the faces between terrain and no terrain at which something is known of the water beyond.
//!
//! The state at the face is that of the particle before it, carried there along limited differences to the particles behind it;
//! the state beyond comes from that and the condition of the boundary (`physics::open_boundary`). A discharge is spread over the
//! faces of its boundary by conveyance,
//!
//! ```text
//! (M45)  q_k = Q w_k / (Δ Σ ψ w)      w = cos θ d^(5/3)/n, d the depth below one level: the mean one before the faces,
//!                                     at least that of critical flow of Q
//! ```
//!
//! and each q is imposed as it is, so that what comes in is the integral of the hydrograph; both stages of a step take its mean over the
//! step. Through the strips of a section it comes in at one level and one velocity, those of the section as a whole, by which waves leave, too. All other conditions pass the flux of (M31). Where the edge runs askew to the lattice its faces are steps, each turned by θ
//! from the way that the edge faces: what comes in has the velocity of that way, and uniform flow is that of the slope along it. Boundaries
//! are few: their faces are worked off one after another.

mod conditions;
mod inside;
#[cfg(test)]
mod levels;
mod section;
mod shares;
mod step;
#[cfg(test)]
mod tests;

use std::ops::Range;

use super::cells_in_part::CellsInPart;
use super::faces::{EAST, NORTH, turned_by};
use super::stairs;
use super::state::{Slot, State, datum};
use super::walls::Walls;
use super::{EulerianMethods, Scale};
use crate::boundary::Condition;
use crate::math::{Vec2, smaller};
use crate::methods::Reconstruction;
use crate::solver::{FlowProblem, Passage, Way};
pub(super) use conditions::{Faces, pass};
pub(super) use inside::Near;
pub(super) use inside::{Inside, Passing};
pub(super) use step::Of;

/// So many parts of 1 m³ are counted where volumes are added up in any order.
const COUNTED: f64 = (1_u64 << 40) as f64;

/// A face of a boundary.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
struct Face {
    /// The cell that owns the face, and the direction in which it does.
    owner: (usize, usize),
    direction: usize,
    /// The particle before the face, and those behind it, as far as there are any before a wall.
    cell: (usize, usize),
    behind: Option<(usize, usize)>,
    further: Option<(usize, usize)>,
    /// 1 where outwards is to the east or north, −1 otherwise.
    sign: f64,
    /// The way that the edge faces about here, of length 1: its part across the face, outwards, and along it, in the direction of `tangential`.
    facing: (f64, f64),
    /// Level (m) of the water at the start, counted as in the solver; none where it was dry.
    rest: Option<f64>,
    /// Whether water may come in here while the particle is dry.
    gives: bool,
    /// Its length in spacings of its level.
    width: f64,
    /// μ of (M28) of the cell before it, by the finest spacing over its own.
    haste: f64,
    /// From the particle before it to where the terrain ends (spacings).
    reach: f64,
    /// Whether another level lies behind that particle: what is there follows from its gradients.
    is_behind_elsewhere: bool,
}

/// What comes in and what leaves: volumes (m³), or rates.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct Exchange<T = f64> {
    pub inflow: T,
    pub outflow: T,
}

/// One boundary.
#[derive(serde::Serialize, serde::Deserialize)]
struct Line {
    condition: Condition,
    faces: Vec<Face>,
    /// Those of the faces that give water or have some before them, what is known at each, and what passes.
    at_work: Vec<usize>,
    inside: Vec<Inside>,
    passing: Vec<Passing>,
    /// Volumes (m³) so far.
    booked: Exchange,
    /// The same in whole numbers, whose sums are the same in any order: mirrored water has mirrored bits.
    counted: Exchange<i128>,
}

/// All boundaries of a problem.
#[derive(serde::Serialize, serde::Deserialize)]
pub(crate) struct OpenBoundaries {
    lines: Vec<Line>,
    /// Height (m) from which the solver counts elevations.
    datum: f64,
}

impl OpenBoundaries {
    /// The boundaries of a problem; faces within `about` (spacings) of one say which way its edge faces.
    pub fn new(problem: &FlowProblem, state: &State, (walls, in_part): (&Walls, &CellsInPart), about: f64) -> Self {
        let line = |condition: &Condition| Line {
            condition: condition.clone(),
            faces: Vec::new(),
            at_work: Vec::new(),
            inside: Vec::new(),
            passing: Vec::new(),
            booked: Exchange::default(),
            counted: Exchange::default(),
        };
        let mut lines: Vec<Line> = problem.forcing.boundaries.iter().map(|b| line(&b.condition)).collect();
        if !lines.is_empty() {
            for row in 0..=state.rows {
                for column in 0..=state.columns(row) {
                    for direction in [EAST, NORTH] {
                        if let Some((line, face)) = face(problem, state, (walls, in_part), (row, column), direction) {
                            lines[line].faces.push(face);
                        }
                    }
                }
            }
        }
        lines.iter_mut().for_each(|line| line.find_facing(state, about));
        OpenBoundaries { lines, datum: datum(&problem.bed, &problem.initial_depth) }
    }

    /// The cells (row, column) of all lines.
    pub fn cells(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.lines.iter().flat_map(|line| line.faces.iter().map(|face| face.cell))
    }

    /// The faces, each with the number of its boundary.
    pub fn slots(&self) -> impl Iterator<Item = (Slot, usize)> + '_ {
        let slot = |face: &Face| Slot { row: face.owner.0, direction: face.direction, column: face.owner.1 };
        let lines = self.lines.iter().enumerate();
        lines.flat_map(move |(line, own)| own.faces.iter().map(move |face| (slot(face), line)))
    }

    /// The cells (row, column) to which water may come by a boundary while they are dry.
    pub fn inlets(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.lines.iter().flat_map(|line| line.faces.iter().filter(|face| face.gives).map(|face| face.cell))
    }

    /// Fluxes of the faces in rows at hand in a step from one time to another (s); those that are not at work stay the walls that they are to [`Walls`].
    pub fn apply(
        &mut self,
        state: &mut State,
        rows: &Range<usize>,
        scale: &Scale,
        methods: EulerianMethods,
        step: (f64, f64),
    ) {
        let datum = self.datum;
        for line in &mut self.lines {
            line.look(state, scale, methods);
            let faces = Faces::OfAnEdge { returned: line.returned() };
            pass(&line.condition, (faces, &line.inside), (scale, datum), (step, Of::Mean), &mut line.passing);
            for ((&face, inside), passing) in line.at_work.iter().zip(&line.inside).zip(&line.passing) {
                let face = &line.faces[face];
                if !rows.contains(&face.cell.0) {
                    continue;
                }
                let water = &state.primitive[face.cell.0];
                let (u, v) = (water.velocity_x[face.cell.1], water.velocity_y[face.cell.1]);
                let tangent = turned_by(face.direction, u, v).1;
                let out = &mut state.flux[face.owner.0][face.direction];
                let i = face.owner.1;
                let mass = face.sign * passing.mass;
                // What comes in moves as the edge faces.
                let coming = passing.beyond.map_or(0.0, |beyond| beyond.outwards) / face.facing.0 * face.facing.1;
                let carried = mass * if passing.mass > 0.0 { tangent } else { coming };
                let normal = inside.momentum_lost(passing, scale.gravity);
                (out.mass[i], out.tangential[i]) = (mass, carried);
                (out.normal_left[i], out.normal_right[i]) = if face.sign > 0.0 { (normal, 0.0) } else { (0.0, normal) };
                out.scale(i, face.width);
            }
        }
    }

    /// Rates (m³/s) at which water comes in and leaves now, after outflow was limited to what is there; each boundary counts its own, which
    /// `carried` (s) turns into volumes.
    pub fn book(&mut self, state: &State, rows: &Range<usize>, carried: f64) -> Exchange {
        let mut rates = Exchange::default();
        for line in &mut self.lines {
            let at_work = line.at_work.iter().map(|&face| &line.faces[face]);
            for face in at_work.filter(|face| rows.contains(&face.cell.0)) {
                let mass = state.flux[face.owner.0][face.direction].mass[face.owner.1];
                let outwards = state.spacing[face.cell.0] * (face.sign * mass);
                let volume = (carried * outwards).abs();
                #[expect(
                    clippy::cast_possible_truncation,
                    reason = "no volume on Earth comes near the greatest of these numbers"
                )]
                let counted = (volume * COUNTED) as i128;
                if outwards > 0.0 {
                    rates.outflow += outwards;
                    line.booked.outflow += volume;
                    line.counted.outflow += counted;
                } else {
                    rates.inflow -= outwards;
                    line.booked.inflow += volume;
                    line.counted.inflow += counted;
                }
            }
        }
        rates
    }

    /// Inflow and outflow by each boundary until a time (s).
    pub fn passages(&self, time: f64) -> impl Iterator<Item = Passage> + '_ {
        self.lines.iter().enumerate().map(move |(index, line)| Passage {
            way: Way::Boundary(index),
            inflow: line.booked.inflow,
            outflow: line.booked.outflow,
            asked: line.condition.asked(time),
        })
    }

    /// Finds the greatest signal speed (m/s) at the boundaries of each level in a step from one time to another (s), as [`State::fastest`] has it, and
    /// where (row, column).
    pub fn fastest(
        &mut self,
        state: &State,
        scale: &Scale,
        methods: EulerianMethods,
        step: (f64, f64),
        fastest: &mut [(f64, (usize, usize))],
    ) {
        let datum = self.datum;
        fastest.fill((0.0, (0, 0)));
        for line in &mut self.lines {
            line.look(state, scale, methods);
            let faces = Faces::OfAnEdge { returned: line.returned() };
            pass(&line.condition, (faces, &line.inside), (scale, datum), (step, Of::Largest), &mut line.passing);
            for (&face, passing) in line.at_work.iter().zip(&line.passing) {
                let (speed, cell) = (line.faces[face].haste * passing.speed, line.faces[face].cell);
                let of_level = &mut fastest[state.level_number(cell.0)];
                if speed > of_level.0 {
                    *of_level = (speed, cell);
                }
            }
        }
    }
}

/// The axis across the faces of a direction.
fn axis(direction: usize) -> Vec2 {
    if direction == EAST { Vec2::new(1.0, 0.0) } else { Vec2::new(0.0, 1.0) }
}

/// The face that a padded cell owns in a direction, and its boundary; none where it is no edge or belongs to no boundary.
fn face(
    problem: &FlowProblem,
    state: &State,
    (walls, in_part): (&Walls, &CellsInPart),
    owner: (usize, usize),
    direction: usize,
) -> Option<(usize, Face)> {
    let other = if direction == EAST { (owner.0, owner.1 + 1) } else { (owner.0 + 1, owner.1) };
    let has_terrain = |(row, column): (usize, usize)| state.has_terrain(row, column);
    let (cell, beyond, sign) = match (has_terrain(owner), has_terrain(other)) {
        (true, false) => (owner, other, 1.0),
        (false, true) => (other, owner, -1.0),
        _ => return None,
    };
    let middle = Some(state.middle(cell, beyond)).filter(|_| !state.is_elsewhere(beyond.0, beyond.1))?;
    let times = 1.0 / state.haste(cell.0);
    let line =
        problem.forcing.boundary_within(times, middle, axis(direction)).filter(|_| !problem.bed.is_sealed(middle))?;
    let inwards = (cell.1 as isize - beyond.1 as isize, cell.0 as isize - beyond.0 as isize);
    let to = |from: (usize, usize)| stairs::beside(from, inwards);
    let next = |from: (usize, usize)| (has_terrain(to(from)) && !walls.is_blocked(from, inwards)).then(|| to(from));
    let behind = next(cell);
    let is_behind_elsewhere = state.is_elsewhere(to(cell).0, to(cell).1);
    let depth = state.water[cell.0].depth[cell.1];
    let rest = (depth > problem.dry_depth).then(|| state.ground[cell.0].bed[cell.1] + depth);
    let further = behind.and_then(next);
    let condition = &problem.forcing.boundaries[line].condition;
    let gives = condition.feeds() || rest.is_some();
    let width = in_part.open(owner, direction);
    let haste = in_part.haste(cell) * state.haste(cell.0);
    let facing = (1.0, 0.0);
    let way = 2 * direction + usize::from(sign < 0.0);
    let reach = problem.bed.cover.reach(cell, way, state.lattice());
    let face = Face {
        owner,
        direction,
        cell,
        behind,
        further,
        sign,
        facing,
        rest,
        gives,
        width,
        haste,
        reach,
        is_behind_elsewhere,
    };
    Some((line, face))
}

impl Line {
    /// Finds the way that the edge faces at each of its faces: the mean of theirs and of those about them (spacings) that do not look back.
    fn find_facing(&mut self, state: &State, about: f64) {
        let place = |face: &Face| {
            let normal = axis(face.direction) * face.sign;
            let (row, column) = face.cell;
            (state.position(row, column) + normal * (0.5 * state.spacing[row]), normal)
        };
        let places: Vec<(Vec2, Vec2)> = self.faces.iter().map(place).collect();
        // Faces come row by row.
        let reach = about.ceil() as usize;
        let rows: Vec<usize> = self.faces.iter().map(|face| face.owner.0).collect();
        let spacings: Vec<f64> = self.faces.iter().map(|face| state.spacing[face.cell.0]).collect();
        let is_of_level = |spacing: f64, face: usize| (spacings[face] - spacing).abs() <= 0.0;
        for (face, &(place, normal)) in self.faces.iter_mut().zip(&places) {
            let from = rows.partition_point(|row| row + reach < face.owner.0);
            let to = rows.partition_point(|row| *row <= face.owner.0 + reach);
            let spacing = state.spacing[face.cell.0];
            let of_level = (from..to).filter(|&face| is_of_level(spacing, face)).map(|face| places[face]);
            let near = of_level.filter(|(other, _)| (*other - place).norm() <= about * spacing);
            let near = near.map(|(_, other)| other).filter(|other| other.dot(normal) >= 0.0);
            let sum = near.fold(Vec2::ZERO, |a, b| a + b);
            let way = sum * (1.0 / sum.norm());
            face.facing = (way.dot(normal), turned_by(face.direction, way.x, way.y).1);
        }
    }

    /// (M40): the share of the water that came in by the boundary which left by it again.
    fn returned(&self) -> f64 {
        let Exchange { inflow, outflow } = self.counted;
        if inflow > 0 { smaller(outflow as f64 / inflow as f64, 1.0) } else { 0.0 }
    }

    /// Reads the water before the faces.
    fn look(&mut self, state: &State, scale: &Scale, methods: EulerianMethods) {
        let is_carried = methods.reconstruction != Reconstruction::None;
        let has_water = |face: &Face| state.primitive[face.cell.0].depth[face.cell.1] > scale.dry_depth;
        let is_at_work = |&face: &usize| self.faces[face].gives || has_water(&self.faces[face]);
        self.at_work.clear();
        self.at_work.extend((0..self.faces.len()).filter(is_at_work));
        let faces = self.at_work.iter().map(|&face| &self.faces[face]);
        self.inside.clear();
        self.inside.extend(faces.map(|face| face.look(state, scale, is_carried)));
    }
}

impl Face {
    /// What lies a spacing behind the particle before the face, by its gradients.
    fn by_gradients(&self, here: Near, state: &State) -> Near {
        let (row, column) = self.cell;
        let (slope, spacing) = (&state.gradient[row], state.spacing[row]);
        let [level, depth, outwards] = if self.direction == EAST {
            [slope.surface_x[column], slope.depth_x[column], self.sign * slope.u_x[column]]
        } else {
            [slope.surface_y[column], slope.depth_y[column], self.sign * slope.v_y[column]]
        }
        .map(|change| self.sign * spacing * change);
        let behind = (here.depth - depth).max(0.0);
        Near { depth: behind, bed: here.bed + here.depth - level - behind, outwards: here.outwards - outwards, ..here }
    }

    fn look(&self, state: &State, scale: &Scale, is_carried: bool) -> Inside {
        let finest = scale.spacing;
        let scale = &scale.on(state.spacing[self.cell.0]);
        let at = |(row, column): (usize, usize)| {
            let water = &state.primitive[row];
            let (u, v) = (water.velocity_x[column], water.velocity_y[column]);
            let (normal, along) = turned_by(self.direction, u, v);
            let (depth, bed) = (water.depth[column], state.ground[row].bed[column]);
            Near { depth, bed, outwards: self.sign * normal, along }
        };
        let friction = state.ground[self.cell.0].friction[self.cell.1];
        let here = at(self.cell);
        let behind = match [self.behind, self.further].map(|place| place.filter(|_| is_carried).map(at)) {
            [None, _] if is_carried && self.is_behind_elsewhere => [Some(self.by_gradients(here, state)), None],
            found => found,
        };
        let before = Inside::before(here, behind, self.reach, scale);
        let width = self.width * (scale.spacing / finest);
        Inside { rest: self.rest, friction, facing: self.facing, width, ..before }
    }
}
