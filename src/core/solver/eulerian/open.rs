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
//! step. Through the strips of a section it comes in at one level and one velocity, those of the section as a whole, by which waves leave, too. All other conditions pass the flux of (M16). Where the edge runs askew to the lattice its faces are steps, each turned by θ
//! from the way that the edge faces: what comes in has the velocity of that way, and uniform flow is that of the slope along it. Boundaries
//! are few: their faces are worked off one after another.

use super::cells_in_part::CellsInPart;
use super::faces::{EAST, NORTH, through_face, turned_by};
use super::gradient::surface_difference;
use super::state::{State, datum};
use super::walls::Walls;
use super::{EulerianMethods, Scale};
use crate::boundary::{Condition, Rating};
use crate::math::{Vec2, clamp, smaller};
use crate::methods::Reconstruction;
use crate::physics::limiter::van_leer;
use crate::physics::open_boundary::{
    EdgeState, HALVINGS, Section, at_depth, inflow, overfall, uniform_flow, wave_enters, waves_leave,
};
use crate::solver::{FlowProblem, Passage, Way};

/// So many parts of 1 m³ are counted where volumes are added up in any order.
const COUNTED: f64 = (1_u64 << 40) as f64;

/// A face of a boundary.
#[derive(Clone, Debug)]
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
    /// Its length in spacings.
    width: f64,
    /// μ of (M104) of the cell before it.
    haste: f64,
}

/// A particle near a face: its depth (m), bed (m) and velocity outwards and along the face (m/s).
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    pub depth: f64,
    pub bed: f64,
    pub outwards: f64,
    pub along: f64,
}

/// What is known at a face.
#[derive(Clone, Copy, Debug)]
pub(in crate::solver) struct Inside {
    /// Depth of the particle (m) and at the face; level at the face less that of the particle.
    depth: f64,
    face: EdgeState,
    rise: f64,
    /// Elevation of the bed at the face and at the particle (m), counted as in the solver.
    sill: f64,
    bed: f64,
    /// g n² (m^(1/3)).
    friction: f64,
    invariant: f64,
    is_wet: bool,
    /// Level (m) of the water at the start, counted as in the solver; none where it was dry.
    rest: Option<f64>,
    /// Width of the face in spacings.
    width: f64,
    /// The way that the edge faces: its part across the face, cos θ, and along it.
    facing: (f64, f64),
    /// Velocity along the face (m/s).
    along: f64,
}

/// What passes a face, outwards, the signal speed there, and the state beyond; none where the face is as a wall.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::solver) struct Passing {
    pub mass: f64,
    pub momentum: f64,
    pub speed: f64,
    pub beyond: Option<EdgeState>,
}

/// One boundary.
struct Line {
    condition: Condition,
    faces: Vec<Face>,
    /// Those of the faces that give water or have some before them, what is known at each, and what passes.
    at_work: Vec<usize>,
    inside: Vec<Inside>,
    passing: Vec<Passing>,
    /// Volume (m³) that came in and left.
    booked: (f64, f64),
    /// The same in whole numbers, whose sums are the same in any order: mirrored water has mirrored bits.
    counted: (i128, i128),
}

/// All boundaries of a problem.
pub(crate) struct OpenBoundaries {
    lines: Vec<Line>,
    /// Height (m) from which the solver counts elevations.
    datum: f64,
}

/// What the faces of a condition are.
#[derive(Clone, Copy, PartialEq)]
pub(in crate::solver) enum Faces {
    /// Those of an edge of the plane, each with its own water; with the share of what came in by the boundary that left by it again.
    OfAnEdge { returned: f64 },
    /// Those before which buffer particles of moving water stand: a level is held both ways there (decision 0028).
    BeforeBuffers,
    /// Strips of one section with one level and one velocity, the lowest ones first.
    OfASection,
}

/// Discharge and level of a boundary: the mean of a step, or the largest in it.
#[derive(Clone, Copy)]
pub(in crate::solver) enum Of {
    Mean,
    Largest,
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
            booked: (0.0, 0.0),
            counted: (0, 0),
        };
        let mut lines: Vec<Line> = problem.forcing.boundaries.iter().map(|b| line(&b.condition)).collect();
        if !lines.is_empty() {
            for row in 0..=state.rows {
                for column in 0..=state.columns {
                    for direction in [EAST, NORTH] {
                        if let Some((line, face)) = face(problem, state, (walls, in_part), (row, column), direction) {
                            lines[line].faces.push(face);
                        }
                    }
                }
            }
        }
        lines.iter_mut().for_each(|line| line.find_facing(problem.bed.lattice.spacing, about));
        OpenBoundaries { lines, datum: datum(&problem.bed, &problem.initial_depth) }
    }

    /// The cells (row, column) to which water may come by a boundary while they are dry.
    pub fn inlets(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.lines.iter().flat_map(|line| line.faces.iter().filter(|face| face.gives).map(|face| face.cell))
    }

    /// Fluxes of the faces in a step from one time to another (s); those that are not at work stay the walls that they are to [`Walls`].
    pub fn apply(&mut self, state: &mut State, scale: &Scale, methods: EulerianMethods, step: (f64, f64)) {
        let datum = self.datum;
        for line in &mut self.lines {
            line.look(state, scale, methods);
            let faces = Faces::OfAnEdge { returned: line.returned() };
            pass(&line.condition, (faces, &line.inside), (scale, datum), (step, Of::Mean), &mut line.passing);
            for ((&face, inside), passing) in line.at_work.iter().zip(&line.inside).zip(&line.passing) {
                let face = &line.faces[face];
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

    /// Rates at which water comes in and leaves now (m²/s, per metre of face), after outflow was limited to what is there; each
    /// boundary counts its own, which `carried` (m·s) turns into volumes.
    pub fn book(&mut self, state: &State, carried: f64) -> (f64, f64) {
        let (mut coming, mut leaving) = (0.0, 0.0);
        for line in &mut self.lines {
            for face in line.at_work.iter().map(|&face| &line.faces[face]) {
                let outwards = face.sign * state.flux[face.owner.0][face.direction].mass[face.owner.1];
                let volume = (carried * outwards).abs();
                #[expect(
                    clippy::cast_possible_truncation,
                    reason = "no volume on Earth comes near the greatest of these numbers"
                )]
                let counted = (volume * COUNTED) as i128;
                if outwards > 0.0 {
                    leaving += outwards;
                    line.booked.1 += volume;
                    line.counted.1 += counted;
                } else {
                    coming -= outwards;
                    line.booked.0 += volume;
                    line.counted.0 += counted;
                }
            }
        }
        (coming, leaving)
    }

    /// Inflow and outflow by each boundary until a time (s).
    pub fn passages(&self, time: f64) -> impl Iterator<Item = Passage> + '_ {
        self.lines.iter().enumerate().map(move |(index, line)| Passage {
            way: Way::Boundary(index),
            inflow: line.booked.0,
            outflow: line.booked.1,
            asked: line.condition.asked(time),
        })
    }

    /// The greatest signal speed (m/s) at the boundaries in a step from one time to another (s), and where (row, column).
    pub fn fastest(
        &mut self,
        state: &State,
        scale: &Scale,
        methods: EulerianMethods,
        step: (f64, f64),
    ) -> (f64, (usize, usize)) {
        let datum = self.datum;
        let mut fastest = (0.0, (0, 0));
        for line in &mut self.lines {
            line.look(state, scale, methods);
            let faces = Faces::OfAnEdge { returned: line.returned() };
            pass(&line.condition, (faces, &line.inside), (scale, datum), (step, Of::Largest), &mut line.passing);
            for (&face, passing) in line.at_work.iter().zip(&line.passing) {
                let (speed, cell) = (line.faces[face].haste * passing.speed, line.faces[face].cell);
                if speed > fastest.0 {
                    fastest = (speed, cell);
                }
            }
        }
        fastest
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
    let has_terrain = |(row, column): (usize, usize)| {
        row <= state.rows + 1 && column <= state.columns + 1 && state.has_terrain(row, column)
    };
    let (cell, beyond, sign) = match (has_terrain(owner), has_terrain(other)) {
        (true, false) => (owner, other, 1.0),
        (false, true) => (other, owner, -1.0),
        _ => return None,
    };
    let spacing = problem.bed.lattice.spacing;
    let middle = (State::position(owner.0, owner.1, spacing) + State::position(other.0, other.1, spacing)) * 0.5;
    let line = problem.forcing.boundary_at(middle, axis(direction)).filter(|_| !problem.bed.is_sealed(middle))?;
    let inwards = (cell.1 as isize - beyond.1 as isize, cell.0 as isize - beyond.0 as isize);
    let next = |from: (usize, usize)| {
        let to = ((from.0 as isize + inwards.1) as usize, (from.1 as isize + inwards.0) as usize);
        (has_terrain(to) && !walls.is_blocked(from, inwards)).then_some(to)
    };
    let behind = next(cell);
    let depth = state.water[cell.0].depth[cell.1];
    let rest = (depth > problem.dry_depth).then(|| state.ground[cell.0].bed[cell.1] + depth);
    let further = behind.and_then(next);
    let condition = &problem.forcing.boundaries[line].condition;
    let gives = condition.feeds() || rest.is_some();
    let (width, haste) = (in_part.open(owner, direction), in_part.haste(cell));
    let facing = (1.0, 0.0);
    Some((line, Face { owner, direction, cell, behind, further, sign, facing, rest, gives, width, haste }))
}

impl Line {
    /// Finds the way that the edge faces at each of its faces: the mean of theirs and of those about them (spacings) that do not look back.
    fn find_facing(&mut self, spacing: f64, about: f64) {
        let place = |face: &Face| {
            let normal = axis(face.direction) * face.sign;
            (State::position(face.cell.0, face.cell.1, spacing) + normal * (0.5 * spacing), normal)
        };
        let places: Vec<(Vec2, Vec2)> = self.faces.iter().map(place).collect();
        // Faces come row by row.
        let reach = about.ceil() as usize;
        let rows: Vec<usize> = self.faces.iter().map(|face| face.owner.0).collect();
        for (face, &(place, normal)) in self.faces.iter_mut().zip(&places) {
            let from = rows.partition_point(|row| row + reach < face.owner.0);
            let to = rows.partition_point(|row| *row <= face.owner.0 + reach);
            let near = places[from..to].iter().filter(|(other, _)| (*other - place).norm() <= about * spacing);
            let near = near.map(|(_, other)| *other).filter(|other| other.dot(normal) >= 0.0);
            let sum = near.fold(Vec2::ZERO, |a, b| a + b);
            let way = sum * (1.0 / sum.norm());
            face.facing = (way.dot(normal), turned_by(face.direction, way.x, way.y).1);
        }
    }

    /// (M93): the share of the water that came in by the boundary which left by it again.
    fn returned(&self) -> f64 {
        let (came, left) = self.counted;
        if came > 0 { smaller(left as f64 / came as f64, 1.0) } else { 0.0 }
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

/// What passes faces in a step from one time to another (s), by what is known of the water beyond; levels of a condition count from
/// `datum` (m) less than those of the faces.
pub(in crate::solver) fn pass(
    condition: &Condition,
    (faces, inside): (Faces, &[Inside]),
    (scale, datum): (&Scale, f64),
    ((from, to), of): ((f64, f64), Of),
    passing: &mut Vec<Passing>,
) {
    let g = scale.gravity;
    let value = |series: &crate::boundary::Series| match of {
        Of::Mean => series.mean(from, to),
        Of::Largest => series.largest(from, to),
    };
    passing.clear();
    match condition {
        Condition::Discharge { discharge, level } => {
            let total = value(discharge).max(0.0) / scale.spacing;
            let given = level.as_ref().map(|level| value(level) - datum);
            if faces == Faces::OfASection {
                through_section(total, given, inside, g, passing);
                return;
            }
            // Buffer particles have widths of their own.
            let width = |inside: &Inside| if faces == Faces::BeforeBuffers { 1.0 } else { inside.width };
            let shares = Shares::new((inside, &width), total, g);
            passing.extend(inside.iter().map(|inside| {
                let q = shares.of(inside) * total * inside.facing.0;
                let held = given.map(|level| (level - inside.sill).max(0.0));
                let beyond = inflow(q, held, inside.invariant, g);
                Passing { mass: -q, ..Passing::of(beyond, g) }
            }));
        }
        Condition::Level(series) if faces == Faces::OfASection => {
            hold_section(value(series) - datum, inside, scale, passing);
        }
        Condition::Stage(series) | Condition::Level(series) => {
            let level = value(series) - datum;
            let paid = match (condition, faces) {
                (_, Faces::BeforeBuffers) => 0.0,
                (Condition::Level(_), Faces::OfAnEdge { returned }) => returned,
                _ => 1.0,
            };
            passing.extend(inside.iter().map(|inside| inside.held(level, paid, scale)));
        }
        Condition::Wave { level, still } => {
            let wave = value(level) - datum;
            // Less still water beyond makes the wave faster.
            let still = still.as_ref().map(|still| still.mean(from, to) - datum);
            if faces == Faces::OfASection {
                let rest = still.or(wide(inside).next().and_then(|lowest| lowest.rest));
                waves_leave_section(Some((wave, rest.unwrap_or(f64::NEG_INFINITY))), inside, scale, passing);
                return;
            }
            passing.extend(inside.iter().map(|inside| inside.with_wave(wave, still, scale)));
        }
        Condition::NormalDepth { slope } => passing.extend(inside.iter().map(|inside| {
            // A part of the velocity is as much of its square in the slope.
            let across = slope * inside.facing.0 * inside.facing.0;
            inside.leaving(|| uniform_flow(across, inside.friction, inside.invariant, g), g)
        })),
        Condition::Rating(rating) => {
            let level = rated_level(rating, inside, datum, scale);
            passing.extend(inside.iter().map(|inside| inside.leaving(|| inside.below(level, g), g)));
        }
        Condition::Free if faces == Faces::OfASection => {
            let rest = wide(inside).next().and_then(|lowest| lowest.rest);
            waves_leave_section(rest.map(|rest| (rest, rest)), inside, scale, passing);
        }
        Condition::Free => passing.extend(inside.iter().map(|inside| {
            match inside.rest.map(|level| level - inside.sill).filter(|depth| *depth > scale.dry_depth) {
                Some(rest) if inside.is_wet => inside.between(waves_leave(rest, inside.face, inside.along, g), g),
                Some(rest) => Passing::of(waves_leave(rest, inside.face, 0.0, g), g),
                None => inside.going_on(g),
            }
        })),
    }
}

impl Face {
    fn look(&self, state: &State, scale: &Scale, is_carried: bool) -> Inside {
        let at = |(row, column): (usize, usize)| {
            let water = &state.primitive[row];
            let (u, v) = (water.velocity_x[column], water.velocity_y[column]);
            let (normal, along) = turned_by(self.direction, u, v);
            let (depth, bed) = (water.depth[column], state.ground[row].bed[column]);
            Near { depth, bed, outwards: self.sign * normal, along }
        };
        let friction = state.ground[self.cell.0].friction[self.cell.1];
        let behind = [self.behind, self.further].map(|place| place.filter(|_| is_carried).map(at));
        let before = Inside::before(at(self.cell), behind, scale);
        Inside { rest: self.rest, friction, facing: self.facing, width: self.width, ..before }
    }
}

impl Inside {
    /// The water at a face of one spacing before which there is a particle, and behind it up to two others.
    pub(super) fn before(here: Near, behind: [Option<Near>; 2], scale: &Scale) -> Self {
        let Near { depth, bed, outwards, along } = here;
        let is_wet = depth > scale.dry_depth;
        let dry = Inside {
            depth,
            face: EdgeState { depth: 0.0, outwards: 0.0 },
            rise: 0.0,
            sill: bed,
            bed,
            friction: 0.0,
            invariant: 0.0,
            is_wet,
            rest: None,
            width: 1.0,
            facing: (1.0, 0.0),
            along,
        };
        if !is_wet {
            return dry;
        }
        let [behind, further] = behind.map(|near| near.filter(|near| near.depth > scale.dry_depth));
        let (rise, rise_d, rise_u) = match (behind, further) {
            (None, _) => (0.0, 0.0, 0.0),
            (Some(b), further) => {
                let jump_of = |from: Near, to: Near| {
                    let levels = surface_difference((from.depth, from.bed), (to.depth, to.bed), scale.dry_depth);
                    (levels, to.depth - from.depth, to.outwards - from.outwards)
                };
                let jump = jump_of(b, here);
                let before = further.map_or(jump, |f| jump_of(f, b));
                let half = |a: f64, b: f64| 0.5 * van_leer(a, b);
                (half(jump.0, before.0), half(jump.1, before.1), half(jump.2, before.2))
            }
        };
        let at_face = (depth + rise_d).clamp(0.0, 2.0 * depth);
        let face = EdgeState { depth: at_face, outwards: outwards + rise_u };
        let sill = bed + (depth - at_face) + rise;
        Inside { face, rise, sill, invariant: face.invariant(scale.gravity), ..dry }
    }

    /// The water at a face as an interpolation finds it, with its velocity `along` the face (m/s), over a bed at `sill` (m); dry where it finds
    /// none.
    pub(in crate::solver) fn at_face(face: Option<EdgeState>, along: f64, sill: f64, gravity: f64) -> Self {
        let water = face.unwrap_or(EdgeState { depth: 0.0, outwards: 0.0 });
        Inside {
            depth: water.depth,
            face: water,
            rise: 0.0,
            sill,
            bed: sill,
            friction: 0.0,
            invariant: if face.is_some() { water.invariant(gravity) } else { 0.0 },
            is_wet: face.is_some(),
            rest: None,
            width: 1.0,
            facing: (1.0, 0.0),
            along,
        }
    }

    /// The water at the face.
    pub(in crate::solver) fn state(&self) -> EdgeState {
        self.face
    }

    /// Width of the face in spacings.
    pub(in crate::solver) fn width(&self) -> f64 {
        self.width
    }

    /// The same face with another width (spacings), roughness g n² (m^(1/3)) and level at rest (m).
    pub(in crate::solver) fn with(self, width: f64, friction: f64, rest: Option<f64>) -> Self {
        Inside { width, friction, rest, ..self }
    }

    /// Normal momentum (m³/s²) that the particle before the face loses, beyond the pressure of still water.
    pub(super) fn momentum_lost(&self, passing: &Passing, g: f64) -> f64 {
        let at_face = self.face.depth;
        passing.momentum - 0.5 * g * at_face * at_face + 0.5 * g * (self.depth + at_face) * self.rise
    }

    /// What passes between the water before the face and a state beyond it.
    fn between(&self, beyond: EdgeState, g: f64) -> Passing {
        let face = self.face;
        let (mass, momentum) = through_face(face.depth, face.outwards, beyond.depth, beyond.outwards, g);
        Passing { mass, momentum, ..Passing::of(beyond, g) }
    }

    /// The same where nothing may come in.
    fn leaving(&self, beyond: impl FnOnce() -> EdgeState, g: f64) -> Passing {
        if !self.is_wet || self.invariant <= 0.0 {
            return self.closed(g);
        }
        let passing = self.between(beyond(), g);
        if passing.mass > 0.0 { passing } else { self.closed(g) }
    }

    /// What passes where the flow goes on as it arrives, outwards only.
    fn going_on(&self, g: f64) -> Passing {
        if self.is_wet && self.face.outwards > 0.0 { Passing::of(self.face, g) } else { self.closed(g) }
    }

    /// Depth (m) at the face under a level (m).
    fn depth_at(&self, level: f64) -> f64 {
        (level - self.sill).max(0.0)
    }

    /// What passes where a level (m) is held; water that comes in pays for a share of the head of its velocity.
    fn held(&self, level: f64, paid: f64, scale: &Scale) -> Passing {
        let (held, how, g) = (self.depth_at(level), (self.facing.0, paid), scale.gravity);
        if self.is_wet {
            self.between(at_depth(held, how, self.invariant, g), g)
        } else if held > scale.dry_depth {
            Passing::of(at_depth(held, how, 0.0, g), g)
        } else {
            self.closed(g)
        }
    }

    /// What passes where a wave of a level (m) comes in over still water of another one, that of the start where none is given.
    fn with_wave(&self, wave: f64, still: Option<f64>, scale: &Scale) -> Passing {
        let g = scale.gravity;
        let depths = (self.depth_at(wave), still.or(self.rest).map_or(0.0, |level| self.depth_at(level)));
        let state = || wave_enters(depths, self.facing, (self.face, if self.is_wet { self.along } else { 0.0 }), g);
        if depths.0.max(depths.1) <= scale.dry_depth {
            self.going_on(g)
        } else if self.is_wet {
            self.between(state(), g)
        } else if depths.0 > scale.dry_depth {
            Passing::of(state(), g)
        } else {
            self.closed(g)
        }
    }

    /// The face as a wall.
    fn closed(&self, g: f64) -> Passing {
        let face = self.face;
        let momentum = through_face(face.depth, face.outwards, face.depth, -face.outwards, g).1;
        Passing { momentum, ..Passing::default() }
    }

    /// The state beyond at a level (m), between critical outflow and rest.
    fn below(&self, level: f64, g: f64) -> EdgeState {
        let fall = overfall(self.invariant, g);
        let still = 0.25 * self.invariant * self.invariant / g;
        at_depth(clamp(level - self.sill, smaller(fall.depth, still), still), (1.0, 1.0), self.invariant, g)
    }
}

impl Passing {
    /// The flux of a state alone.
    fn of(state: EdgeState, g: f64) -> Self {
        let EdgeState { depth, outwards } = state;
        Passing {
            mass: depth * outwards,
            momentum: depth * outwards * outwards + 0.5 * g * depth * depth,
            speed: outwards.abs() + (g * depth).sqrt(),
            beyond: Some(state),
        }
    }
}

/// The strips of a section that have a width.
fn wide(inside: &[Inside]) -> impl Iterator<Item = &Inside> + Clone {
    inside.iter().filter(|strip| strip.width > 0.0)
}

/// The section at a face.
fn section(inside: &[Inside]) -> Section<impl Iterator<Item = (f64, f64)> + Clone> {
    Section(wide(inside).map(|strip| (strip.width, strip.sill)))
}

/// Level (m) and velocity outwards (m/s) of the water before a section, if there is any.
fn before_section(inside: &[Inside]) -> Option<(f64, f64)> {
    let lowest = wide(inside).find(|strip| strip.is_wet);
    lowest.map(|strip| (strip.sill + strip.face.depth, strip.face.outwards))
}

/// A discharge `total` (m²/s times spacings) that comes in through the strips of a section, with the level (m) that counts where it is
/// faster than waves.
fn through_section(total: f64, given: Option<f64>, inside: &[Inside], g: f64, passing: &mut Vec<Passing>) {
    let (strips, before) = (section(inside), before_section(inside));
    let level = strips.inflow(total, given, before, g);
    let area: f64 = inside.iter().map(|strip| strip.width * strip.depth_at(level)).sum();
    let outwards = if area > 0.0 { -total / area } else { 0.0 };
    passing.extend(as_one(inside, (level, outwards), g));
}

/// Waves that leave a section as a whole (M76) into water of a level (m), that at rest or that of a wave that comes in, with the level at rest;
/// where there is none the flow goes on as it arrives.
fn waves_leave_section(levels: Option<(f64, f64)>, inside: &[Inside], scale: &Scale, passing: &mut Vec<Passing>) {
    let g = scale.gravity;
    let (strips, before) = (section(inside), before_section(inside));
    let is_deep = |level: f64| wide(inside).next().is_some_and(|lowest| level - lowest.sill > scale.dry_depth);
    let levels = levels.filter(|(level, rest)| is_deep(level.max(*rest)));
    let Some(levels) = levels.filter(|_| before.is_none_or(|before| !strips.is_swept(before, g))) else {
        passing.extend(inside.iter().map(|strip| strip.going_on(g)));
        return;
    };
    passing.extend(as_one(inside, strips.wave_enters(levels, before, g), g));
}

/// (M92): a level (m) is held over a section as a whole; strip by strip where what leaves is faster than waves.
fn hold_section(level: f64, inside: &[Inside], scale: &Scale, passing: &mut Vec<Passing>) {
    let g = scale.gravity;
    let (strips, before) = (section(inside), before_section(inside));
    let is_dry = before.is_none() && wide(inside).all(|strip| strip.depth_at(level) <= scale.dry_depth);
    if is_dry || before.is_some_and(|before| strips.is_swept(before, g)) {
        passing.extend(inside.iter().map(|strip| strip.held(level, 0.0, scale)));
        return;
    }
    passing.extend(as_one(inside, strips.at_level(level, before, g), g));
}

/// What passes the strips of a section at one level (m) and one velocity outwards (m/s).
fn as_one(inside: &[Inside], (level, outwards): (f64, f64), g: f64) -> impl Iterator<Item = Passing> {
    inside.iter().map(move |strip| Passing::of(EdgeState { depth: strip.depth_at(level), outwards }, g))
}

/// The shares of a discharge (M45).
struct Shares {
    /// Level (m) of the water.
    level: f64,
    counts_roughness: bool,
    sum: f64,
}

impl Shares {
    /// Of a discharge `total` (m²/s, over all faces) among these faces.
    fn new((inside, width): (&[Inside], &impl Fn(&Inside) -> f64), total: f64, g: f64) -> Self {
        let lowest = inside.iter().map(|i| i.bed).fold(f64::INFINITY, f64::min);
        let critical =
            |level: f64| inside.iter().map(|i| width(i) * (g * (level - i.bed).max(0.0).powi(3)).sqrt()).sum::<f64>();
        // All through the lowest face alone stands highest.
        let (mut low, mut high) = (lowest, lowest + (total * total / g).cbrt());
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if critical(middle) < total {
                low = middle;
            } else {
                high = middle;
            }
        }
        let counts_roughness = inside.iter().all(|i| i.friction > 0.0);
        let wet = inside.iter().filter(|i| i.is_wet).map(|i| (width(i) * i.depth, i.bed + i.depth));
        let (area, moment) = wet.fold((0.0, 0.0), |(area, sum), (depth, level)| (area + depth, sum + depth * level));
        let level = if area > 0.0 { high.max(moment / area) } else { high };
        let mut shares = Shares { level, counts_roughness, sum: 0.0 };
        shares.sum = inside.iter().map(|i| width(i) * i.facing.0 * shares.weight(i)).sum();
        shares
    }

    fn weight(&self, inside: &Inside) -> f64 {
        let depth = (self.level - inside.bed).max(0.0);
        let conveyance = depth * depth.cbrt() * depth.cbrt();
        if self.counts_roughness { conveyance / inside.friction.sqrt() } else { conveyance }
    }

    fn of(&self, inside: &Inside) -> f64 {
        if self.sum > 0.0 { self.weight(inside) / self.sum } else { 0.0 }
    }
}

/// The level (m), counted as in the solver, at which what leaves through the faces is what the rating says.
fn rated_level(rating: &Rating, inside: &[Inside], datum: f64, scale: &Scale) -> f64 {
    let g = scale.gravity;
    let wet = || inside.iter().filter(|i| i.is_wet && i.invariant > 0.0);
    let mut low = wet().map(|i| i.sill).fold(f64::INFINITY, f64::min);
    let mut high = wet().map(|i| i.sill + 0.25 * i.invariant * i.invariant / g).fold(f64::NEG_INFINITY, f64::max);
    if low > high {
        return 0.0;
    }
    for _ in 0..HALVINGS {
        let level = 0.5 * (low + high);
        let leaves: f64 = wet()
            .map(|i| {
                let s = i.below(level, g);
                i.width * (s.depth * s.outwards)
            })
            .sum::<f64>()
            * scale.spacing;
        if leaves > rating.discharge(level + datum) {
            low = level;
        } else {
            high = level;
        }
    }
    high
}

#[cfg(test)]
mod levels;
#[cfg(test)]
mod tests;
