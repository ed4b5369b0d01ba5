//! The faces of cells that follow lines, found from their polygons.

use super::shape::Shape;
use super::{Beyond, Cell, ConformingFaces, Face, Side};
use crate::boundary::Pieces;
use crate::lattice::{Conforming, NEIGHBOURS, Side as Of};
use crate::math::Vec2;
use crate::solver::FlowProblem;
use crate::solver::eulerian::general_faces::{Passing, Place, Seen};
use crate::solver::eulerian::mixing::Surroundings;
use crate::solver::eulerian::passes::Passes;
use crate::solver::eulerian::rows::sides;
use crate::solver::eulerian::stairs::beside;
use crate::solver::eulerian::state::{Slot, State, datum};
use crate::solver::eulerian::walls::Walls;

/// The least distance of a particle from a face that counts (spacings): a cell with corners that point inward may have its centre beyond one
/// of its faces.
const LEAST_DISTANCE: f64 = 0.1;

impl ConformingFaces {
    /// The faces of a problem; the steps of the bed over them are counted in `state`.
    pub fn new(problem: &FlowProblem, state: &mut State, (walls, passes): (&Walls, &Passes)) -> Self {
        let mut found = ConformingFaces {
            faces: Vec::new(),
            passing: Vec::new(),
            cells: Vec::new(),
            around: Vec::new(),
            places: Vec::new(),
            seen: Vec::new(),
            slots: Vec::new(),
        };
        let lattice = state.lattice().clone();
        let Some(made) = lattice.conforming() else { return found };
        found.cells = cells(made, state);
        let pieces: Pieces = problem.walls.iter().copied().collect();
        let datum = datum(&problem.bed, &problem.initial_depth);
        for (number, face) in made.faces().iter().enumerate() {
            let sill = problem.bed.passes.along_face(number) - datum;
            found.faces.extend(found.face(state, face, (sill, &pieces)));
        }
        for (number, face) in found.faces.iter().enumerate() {
            for (which, side) in face.sides.iter().enumerate() {
                if let Some(side) = side {
                    found.cells[side.cell].faces.push((number, which));
                }
            }
        }
        found.find_others();
        found.find_closing();
        found.count_steps(state);
        found.find_surroundings(state);
        found.find_ways(state, walls, passes);
        found.find_slots();
        found.passing = vec![Passing::default(); found.faces.len()];
        found.around = vec![super::Around::default(); found.cells.len()];
        found.seen = vec![Seen::default(); found.places.len()];
        found
    }

    /// The places that water reaches from each other in one step: those on the two sides of a face, and of two faces of one cell.
    pub fn linked(&self) -> Vec<[Place; 2]> {
        let mut linked = Vec::new();
        for cell in &self.cells {
            let beyond = |&(face, which): &(usize, usize)| {
                let face = &self.faces[face];
                face.sides[1 - which].filter(|_| !face.is_wall).map(|side| self.cells[side.cell].place)
            };
            let mut beside: Vec<Place> = cell.faces.iter().filter_map(beyond).collect();
            beside.sort_unstable();
            beside.dedup();
            for (k, &place) in beside.iter().enumerate() {
                linked
                    .extend(beside[..k].iter().chain([&cell.place]).map(|&other| [other.min(place), other.max(place)]));
            }
        }
        linked.retain(|[a, b]| a != b);
        linked.sort_unstable();
        linked.dedup();
        linked
    }

    /// A face of the solver; none between places without terrain.
    fn face(&self, state: &State, face: &crate::lattice::Face, (sill, walls): (f64, &Pieces)) -> Option<Face> {
        let (middle, normal) = (face.middle(), face.normal());
        let side = |of: Of, sign: f64| {
            let place = match of {
                Of::Cell(cell) => place_of(state, state.lattice().conforming()?.place(cell)),
                Of::Lattice(square) => place_of(state, square),
                Of::Wall | Of::Nothing => return None,
            };
            let cell = self.number(place)?;
            let away = middle - state.position(place.0, place.1);
            let of_square = matches!(of, Of::Lattice(_)).then(|| {
                let out = normal * sign;
                let facing = |k: &usize| {
                    let (dc, dr) = NEIGHBOURS[*k];
                    out.dot(Vec2::new(dc as f64, dr as f64))
                };
                (0..4).max_by(|a, b| facing(a).total_cmp(&facing(b))).unwrap_or(0)
            });
            let slot = sides(place)[of_square.unwrap_or(0)];
            Some(Side { cell, aside: away - normal * away.dot(normal), of_square, slot })
        };
        let sides = [side(face.sides[0], 1.0), side(face.sides[1], -1.0)];
        let at = |side: Side| {
            let (row, column) = self.cells[side.cell].place;
            state.position(row, column)
        };
        let is_wall = sides.iter().any(|side| side.is_none_or(|side| walls.cross([at(side), middle])));
        let distance = |side: Option<Side>, normal: Vec2| {
            side.map_or(0.0, |side| (middle - at(side)).dot(normal).max(LEAST_DISTANCE * state.lattice().spacing))
        };
        let (first, second) = (distance(sides[0], normal), distance(sides[1], normal * -1.0));
        let way = first + second;
        let face = Face {
            sides,
            normal,
            length: face.length(),
            way,
            reach: first / way,
            is_wall,
            closes: [1.0; 2],
            steps: [0.0; 2],
            sill,
            surroundings: Surroundings::default(),
        };
        sides.iter().any(Option::is_some).then_some(face)
    }

    /// Finds the sides of squares that have none of the faces.
    fn find_others(&mut self) {
        let ConformingFaces { faces, cells, .. } = self;
        for cell in cells.iter_mut().filter(|cell| cell.is_square) {
            let of_side = |&(face, which): &(usize, usize)| faces[face].sides[which].and_then(|side| side.of_square);
            let is_other = |side: &usize| !cell.faces.iter().any(|face| of_side(face) == Some(*side));
            cell.others = (0..4).filter(is_other).collect();
        }
    }

    /// Finds how much of their cells walls close.
    fn find_closing(&mut self) {
        let ConformingFaces { faces, cells, .. } = self;
        for cell in cells.iter().filter(|cell| !cell.is_square) {
            let out = |face: &Face, which: usize| face.normal * if which == 0 { 1.0 } else { -1.0 };
            let mut shape = Shape::default();
            for &(face, which) in &cell.faces {
                shape.add(out(&faces[face], which), faces[face].length, faces[face].is_wall);
            }
            for &(face, which) in &cell.faces {
                faces[face].closes[which] = shape.closes(out(&faces[face], which));
            }
        }
    }

    /// Counts the steps of the bed over the faces.
    fn count_steps(&mut self, state: &mut State) {
        for face in self.faces.iter().filter(|face| !face.is_wall) {
            let [Some(a), Some(b)] = face.sides.map(|side| side.map(|side| self.cells[side.cell].place)) else {
                continue;
            };
            let step = (state.ground[a.0].bed[a.1] - state.ground[b.0].bed[b.1]).abs();
            for (row, column) in [a, b] {
                let own = &mut state.ground[row].step[column];
                *own = own.max(step);
            }
        }
        let ConformingFaces { faces, cells, .. } = self;
        for face in faces {
            let step = |side: Option<Side>| {
                side.map_or(0.0, |side| state.ground[cells[side.cell].place.0].step[cells[side.cell].place.1])
            };
            face.steps = face.sides.map(step);
        }
    }

    /// Finds what the stress on the faces takes from their surroundings.
    fn find_surroundings(&mut self, state: &State) {
        let ConformingFaces { faces, cells, .. } = self;
        for face in faces.iter_mut().filter(|face| !face.is_wall) {
            let beside = |side: Option<Side>| side.map(|side| &cells[side.cell]);
            let [Some(a), Some(b)] = face.sides.map(beside) else { continue };
            let count = [a, b].map(|cell| cell.faces.len() + cell.others.len());
            face.surroundings = Surroundings::new(state, [a.place, b.place], count, (face.way, face.length));
        }
    }

    /// What each cell sees beyond its faces, with the vectors of (M97).
    fn find_ways(&mut self, state: &State, walls: &Walls, passes: &Passes) {
        let mut places: Vec<Place> = self.cells.iter().map(|cell| cell.place).collect();
        for number in 0..self.cells.len() {
            let cell = &self.cells[number];
            let here = state.position(cell.place.0, cell.place.1);
            // What is beyond, the way there and the length of the face.
            let mut ways: Vec<(Beyond, Vec2, f64)> = Vec::new();
            for &(face, which) in &cell.faces {
                let Face { sides, normal, length, is_wall, sill, way, .. } = self.faces[face];
                let beyond = sides[1 - which].filter(|_| !is_wall).map(|side| side.cell);
                let to_wall = way * self.faces[face].reach_on(which);
                let out = normal * if which == 0 { 1.0 } else { -1.0 };
                ways.push(match beyond {
                    Some(number) => {
                        let (row, column) = self.cells[number].place;
                        let way = state.position(row, column) - here;
                        (Beyond::Particle(number, sill, way - normal * way.dot(normal)), way, length)
                    }
                    None => (Beyond::Mirror(normal), out * (2.0 * to_wall), length),
                });
            }
            let spacing = state.spacing[cell.place.0];
            let sills = passes.sills(cell.place.0, cell.place.1);
            for &k in &cell.others {
                let offset = NEIGHBOURS[k];
                let out = Vec2::new(offset.0 as f64, offset.1 as f64);
                let place = beside(cell.place, offset);
                let is_seen = state.has_terrain(place.0, place.1) && !walls.is_blocked(cell.place, offset);
                let beyond =
                    if is_seen { Beyond::Particle(places.len(), sills[k], Vec2::ZERO) } else { Beyond::Mirror(out) };
                places.extend(is_seen.then_some(place));
                ways.push((beyond, out * spacing, spacing));
            }
            let vectors = vectors(&ways);
            self.cells[number].ways = ways.iter().map(|(beyond, ..)| *beyond).zip(vectors).collect();
        }
        self.places = places;
    }

    /// The places in the rows that take what passes.
    fn find_slots(&mut self) {
        let slot = |side: &Side| side.slot.0;
        let key = |slot: &Slot| (slot.row, slot.direction, slot.column);
        let mut slots: Vec<Slot> = self.faces.iter().flat_map(|face| face.sides.iter().flatten()).map(slot).collect();
        slots.sort_unstable_by_key(key);
        slots.dedup();
        self.slots = slots;
    }
}

/// The padded place of a cell of the stack.
fn place_of(state: &State, cell: usize) -> Place {
    let (column, row) = state.lattice().column_row(cell);
    (row + 1, column + 1)
}

/// The cells that follow lines and the squares beside them, as far as they have terrain, by row and column.
fn cells(made: &Conforming, state: &State) -> Vec<Cell> {
    let of_side = |side: &Of| match *side {
        Of::Cell(cell) => Some((place_of(state, made.place(cell)), false)),
        Of::Lattice(square) => Some((place_of(state, square), true)),
        Of::Wall | Of::Nothing => None,
    };
    let mut places: Vec<(Place, bool)> =
        made.faces().iter().flat_map(|face| face.sides.iter()).filter_map(of_side).collect();
    places.sort_unstable();
    places.dedup();
    let with_terrain = places.into_iter().filter(|&((row, column), _)| state.has_terrain(row, column));
    with_terrain
        .map(|(place, is_square)| Cell { place, ways: Vec::new(), faces: Vec::new(), others: Vec::new(), is_square })
        .collect()
}

/// The vectors of (M97): what a difference to what is beyond each face adds to the gradient.
fn vectors(ways: &[(Beyond, Vec2, f64)]) -> Vec<Vec2> {
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (_, way, length) in ways {
        let weight = length / way.norm();
        xx += weight * way.x * way.x;
        xy += weight * way.x * way.y;
        yy += weight * way.y * way.y;
    }
    let determinant = xx * yy - xy * xy;
    let vector = |(_, way, length): &(Beyond, Vec2, f64)| {
        let weight = length / (way.norm() * determinant);
        Vec2::new(yy * way.x - xy * way.y, xx * way.y - xy * way.x) * weight
    };
    // All ways along one line: no gradient.
    if determinant > 1e-9 * (xx + yy) * (xx + yy) {
        ways.iter().map(vector).collect()
    } else {
        vec![Vec2::ZERO; ways.len()]
    }
}
