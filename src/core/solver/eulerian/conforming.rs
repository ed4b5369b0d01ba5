//! Faces of cells that follow lines ([`crate::lattice::Conforming`]): of any length and any way they face.
//!
//! A face is one pair of (M19) to (M31) as well. The way s between the particles is the sum of their distances from the face along its normal n.
//! Each is looked at on the straight line through the middle of the face along n, a step t_i aside of its centre:
//!
//! ```text
//! (M97)  ∇X_i = B_i⁻¹ Σ_j (l_ij/r_ij) (X_j − X_i) r_ij     B_i = Σ_j (l_ij/r_ij) r_ij r_ijᵀ     r_ij = x_j − x_i
//! (M98)  X_i' = clamp(X_i + ∇X_i·t_i, min_j X_j, max_j X_j)    X = η, d, v      d_i' ≤ 2 d_i      z_i' = η_i' − d_i'
//! (M99)  A_i dU_i/dt = − Σ_j l_ij Φ_ij,    Φ_i ← Φ_i + ½ g (d_i + d_i') (η_i' − η_i) n
//! ```
//!
//! with j over all its faces; beyond a wall stands its mirror image. Where a bank rises out of the water, η_j − η_i counts as that of the way
//! along the face, ∇η_i·(r_ij − n n·r_ij): a bank is a wall to the surface. (M97) is exact for planes and the central difference on a lattice. (M99)
//! makes the brackets of all faces count from the particle's own level, as (M89) does. Walls have the thrust of (M100), in [`shape`]. At rest all differences of levels are 0; the
//! faces of a cell close, so that a uniform stream along a wall stays as it is, whatever way the wall runs.
//!
//! All that leaves a cell goes into the rows of the lattice at one place, the eastern side of the cell, which has no neighbour there. Squares beside
//! such cells get what passes a side as the sum of its faces. So the update, sources and the balance need not know of them.

mod geometry;
pub(super) mod shape;

use rayon::prelude::*;

use super::faces::EAST;
use super::general_faces::{AT_ONCE, Meeting, Passing, Place, Seen, changes_along, pass};
use super::gradient::without_banks;
use super::mixing::{Mixing, Surroundings};
use super::rows::sides;
use super::state::{Slot, State};
use super::update::Stage;
use super::{EulerianMethods, Scale};
use crate::math::Vec2;
use shape::thrust;

/// One side of a face.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
struct Side {
    /// Its cell, by number.
    cell: usize,
    /// The step (m) from the centre of the cell to the line through the middle of the face along its normal.
    aside: Vec2,
    /// The side of the square that the face is part of, in the order of [`NEIGHBOURS`](crate::lattice::NEIGHBOURS); none of a cell that follows lines.
    of_square: Option<usize>,
    /// Where in the rows goes what passes it, with the sign of what leaves the cell.
    slot: (Slot, f64),
}

/// A face; nothing passes where it has one side, or a wall stands on the way.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
struct Face {
    sides: [Option<Side>; 2],
    /// The unit normal from the first side to the second, and the length (m).
    normal: Vec2,
    length: f64,
    /// The way between the particles along the normal (m), and the share of it on the first side.
    way: f64,
    reach: f64,
    is_wall: bool,
    /// How much of each cell it closes where it is a wall: w of (M100).
    closes: [f64; 2],
    /// The steps of the bed (m) beside its particles.
    steps: [f64; 2],
    /// Level (m) of the lowest ground along the face, as the solver counts; minus infinity where that is not known.
    sill: f64,
    surroundings: Surroundings,
}

/// What a cell sees beyond one of its faces.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
enum Beyond {
    /// Another particle: its number among those looked at, the sill on the way (m), and the part of the way there along the face (m).
    Particle(usize, f64, Vec2),
    /// Its mirror image over a wall with this normal.
    Mirror(Vec2),
}

/// A cell with such faces: one that follows lines, or a square beside one.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
struct Cell {
    place: Place,
    /// What it sees, with the vectors of (M97).
    ways: Vec<(Beyond, Vec2)>,
    /// Its faces and which side of them it is.
    faces: Vec<(usize, usize)>,
    /// The sides of a square, in the order of [`NEIGHBOURS`](crate::lattice::NEIGHBOURS), that have none of these faces.
    others: Vec<usize>,
    is_square: bool,
}

/// The gradients of surface, depth and velocity of a cell, and the least and greatest of them about it.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
struct Around {
    slopes: [Vec2; 4],
    least: [f64; 4],
    greatest: [f64; 4],
}

/// All faces of cells that follow lines.
#[derive(serde::Serialize, serde::Deserialize)]
pub(crate) struct ConformingFaces {
    faces: Vec<Face>,
    passing: Vec<Passing>,
    /// By row and column.
    cells: Vec<Cell>,
    around: Vec<Around>,
    /// The places that are looked at: those of the cells, and behind them those of squares beside squares; and what is there.
    places: Vec<Place>,
    seen: Vec<Seen>,
    /// The places in the rows that take what passes.
    slots: Vec<Slot>,
}

impl ConformingFaces {
    /// Whether a padded cell has such faces.
    pub fn is_beside(&self, place: Place) -> bool {
        self.number(place).is_some()
    }

    /// The padded places of cells with such faces.
    pub fn cells(&self) -> impl Iterator<Item = Place> + '_ {
        self.cells.iter().map(|cell| cell.place)
    }

    /// Of each cell its place, what leaves it over each of its faces (m³/s) with the place beyond, and the sides that have none of these faces.
    pub fn exchanges(&self) -> impl Iterator<Item = (Place, impl Iterator<Item = (Option<Place>, f64)>, &[usize])> {
        self.cells.iter().map(|cell| {
            let over = |&(face, which): &(usize, usize)| {
                let leaving = if which == 0 { self.discharge(face) } else { -self.discharge(face) };
                (self.faces[face].sides[1 - which].map(|side| self.cells[side.cell].place), leaving)
            };
            (cell.place, cell.faces.iter().map(over), &cell.others[..])
        })
    }

    fn number(&self, place: Place) -> Option<usize> {
        self.cells.binary_search_by_key(&place, |cell| cell.place).ok()
    }

    /// The places on the two sides of each face; none where it has only one.
    pub fn places(&self) -> impl Iterator<Item = Option<[Place; 2]>> + '_ {
        self.faces.iter().map(|face| {
            let [a, b] = face.sides.map(|side| side.map(|side| self.cells[side.cell].place));
            a.zip(b).map(|(a, b)| [a, b])
        })
    }

    /// What passes a face now (m³/s).
    pub fn discharge(&self, face: usize) -> f64 {
        self.faces[face].length * self.passing[face].mass
    }

    /// Looks at the water on both sides of the faces, before a stage of a step.
    pub fn look(&mut self, state: &State) {
        let known = (&state.primitive[..], &state.ground[..]);
        let seen = self.seen.par_iter_mut().with_min_len(AT_ONCE).zip(self.places.par_iter());
        seen.for_each(|(seen, &place)| *seen = Seen::at(known, place));
    }

    /// Gradients of the cells, after those of all others.
    pub fn evaluate_gradients(&mut self, state: &mut State, dry_depth: f64) {
        let ConformingFaces { cells, around, seen, .. } = self;
        let seen = &seen[..];
        let found = around.par_iter_mut().with_min_len(AT_ONCE).zip(cells.par_iter()).enumerate();
        found.for_each(|(number, (around, cell))| *around = cell.around(number, seen, dry_depth));
        for (cell, around) in cells.iter().zip(around).filter(|(cell, _)| cell.is_square) {
            let ((row, i), [surface, depth, u, v]) = (cell.place, around.slopes);
            let out = &mut state.gradient[row];
            (out.surface_x[i], out.depth_x[i], out.u_x[i], out.v_x[i]) = (surface.x, depth.x, u.x, v.x);
            (out.surface_y[i], out.depth_y[i], out.u_y[i], out.v_y[i]) = (surface.y, depth.y, u.y, v.y);
        }
    }

    /// Fluxes of the faces.
    pub fn apply(&mut self, state: &mut State, scale: &Scale, methods: EulerianMethods, time_step: f64) {
        let ConformingFaces { faces, passing, around, seen, .. } = self;
        let mixing = Mixing::new(scale, methods, time_step);
        let known = (&seen[..], &around[..]);
        let all = passing.par_chunks_mut(AT_ONCE).zip(faces.par_chunks(AT_ONCE));
        all.for_each(|(passing, faces)| {
            let meetings = faces.iter().map(|face| face.meeting(known, (scale, mixing.as_ref())));
            pass(meetings.zip(passing), scale, methods);
        });
        self.put(state);
    }

    /// Puts what passes the faces into the rows.
    fn put(&self, state: &mut State) {
        for slot in &self.slots {
            state.flux[slot.row][slot.direction].clear(slot.column);
        }
        let is_passed = |passing: &Passing| passing.lost != 0.0 || passing.gained != 0.0 || passing.mass != 0.0;
        for (face, passing) in self.faces.iter().zip(&self.passing).filter(|(_, passing)| is_passed(passing)) {
            let share = face.length / state.lattice().spacing;
            let tangent = face.normal.perpendicular() * passing.tangential;
            for (which, side) in face.sides.iter().enumerate() {
                let Some(side) = side else { continue };
                // What the cell loses of volume and momentum.
                let (sign, normal) = if which == 0 { (1.0, passing.lost) } else { (-1.0, passing.gained) };
                let momentum = (face.normal * normal + tangent) * (sign * share);
                side.put(state, sign * share * passing.mass, momentum);
            }
        }
    }

    /// Scales the outflow of cells that would give more water than they have in this stage of a step (s).
    pub fn limit_outflow(&mut self, state: &mut State, stage: Stage, time_step: f64) {
        let (this, known) = (&*self, &*state);
        let cells = this.cells.par_iter().with_min_len(AT_ONCE).enumerate();
        let short: Vec<(usize, f64)> =
            cells.filter_map(|(number, cell)| Some((number, this.share(known, cell, stage, time_step)?))).collect();
        if short.is_empty() {
            return;
        }
        for (number, share) in short {
            let ConformingFaces { cells, passing, .. } = self;
            let cell = &cells[number];
            for &which in &cell.others {
                state.reduce(sides(cell.place)[which], share);
            }
            for &(face, which) in &cell.faces {
                let passing = &mut passing[face];
                if (which == 0) == (passing.mass > 0.0) {
                    passing.reduce(share);
                }
            }
        }
        self.put(state);
    }

    /// The share of its outflow that a cell can give; none where it can give all.
    fn share(&self, state: &State, cell: &Cell, stage: Stage, time_step: f64) -> Option<f64> {
        let (row, column) = cell.place;
        let depth = match stage {
            Stage::First => state.water[row].depth[column],
            Stage::Second => state.primitive[row].depth[column],
        };
        // Dry cells give nothing.
        if depth <= 0.0 {
            return None;
        }
        let over = |&(face, which): &(usize, usize)| {
            let out = if which == 0 { self.passing[face].mass } else { -self.passing[face].mass };
            self.faces[face].length * out.max(0.0)
        };
        let spacing = state.spacing[row];
        let over_others = cell.others.iter().map(|&which| {
            let (slot, sign) = sides(cell.place)[which];
            spacing * (sign * state.flux[slot.row][slot.direction].mass[slot.column]).max(0.0)
        });
        let leaving = cell.faces.iter().map(over).sum::<f64>() + over_others.sum::<f64>();
        let wanted = time_step / (spacing * spacing) * state.ground[row].per_area[column] * leaving;
        (wanted > depth).then(|| depth / wanted)
    }
}

impl Side {
    /// Adds what leaves the cell over it (m³/s and m⁴/s² per spacing) to the rows.
    fn put(&self, state: &mut State, volume: f64, momentum: Vec2) {
        let (slot, sign) = self.slot;
        let (normal, tangential) =
            if slot.direction == EAST { (momentum.x, momentum.y) } else { (momentum.y, momentum.x) };
        let out = &mut state.flux[slot.row][slot.direction];
        out.mass[slot.column] += sign * volume;
        out.tangential[slot.column] += sign * tangential;
        let of_side = if sign > 0.0 { &mut out.normal_left } else { &mut out.normal_right };
        of_side[slot.column] += sign * normal;
    }
}

impl Cell {
    /// Its gradients (M97), and the least and greatest about it.
    fn around(&self, number: usize, seen: &[Seen], dry_depth: f64) -> Around {
        let here = seen[number];
        if here.depth <= dry_depth {
            return Around::default();
        }
        let own = here.values();
        let mut found = Around { slopes: [Vec2::ZERO; 4], least: own, greatest: own };
        // What (M97) leaves of the surface's gradient where banks rise out of the water: the rows of a matrix.
        let mut kept = [Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0)];
        for &(beyond, vector) in &self.ways {
            let differences = match beyond {
                Beyond::Mirror(normal) => {
                    let turned = normal * (-2.0 * Vec2::new(here.u, here.v).dot(normal));
                    [0.0, 0.0, turned.x, turned.y]
                }
                Beyond::Particle(number, sill, along) => {
                    let there = seen[number];
                    if there.depth <= dry_depth && there.bed + there.depth > here.bed + here.depth {
                        kept = [kept[0] - along * vector.x, kept[1] - along * vector.y];
                    }
                    let is_shut = here.bed + here.depth <= sill && there.bed + there.depth <= sill;
                    if there.depth > dry_depth && !is_shut {
                        for (q, value) in there.values().into_iter().enumerate() {
                            found.least[q] = found.least[q].min(value);
                            found.greatest[q] = found.greatest[q].max(value);
                        }
                    }
                    here.differences(&there, sill, dry_depth)
                }
            };
            for (slope, difference) in found.slopes.iter_mut().zip(differences) {
                *slope += vector * difference;
            }
        }
        found.slopes[0] = without_banks(kept, found.slopes[0]);
        found
    }
}

impl Around {
    /// The particle of a cell a step (m) aside (M98).
    fn aside(&self, here: Seen, step: Vec2, dry_depth: f64) -> Seen {
        if here.depth <= dry_depth {
            return here;
        }
        let own = here.values();
        let [level, depth, u, v] =
            [0, 1, 2, 3].map(|q: usize| (own[q] + self.slopes[q].dot(step)).clamp(self.least[q], self.greatest[q]));
        let depth = depth.min(2.0 * here.depth);
        let bed = level - depth;
        // So that bed and depth make up the level to the last digit.
        Seen { depth: level - bed, bed, u, v }
    }
}

impl Face {
    /// How the particles on its two sides meet.
    fn meeting(&self, (seen, around): (&[Seen], &[Around]), (scale, mixing): (&Scale, Option<&Mixing>)) -> Meeting {
        let own = self.sides.map(|side| side.map(|side| (side, seen[side.cell])));
        if own.iter().flatten().all(|(_, seen)| seen.depth <= scale.dry_depth) {
            return Meeting::Apart(Passing::default());
        }
        let g = scale.gravity;
        let aside = own.map(|own| {
            own.map(|(side, seen)| {
                let aside = around[side.cell].aside(seen, side.aside, scale.dry_depth);
                let rise = (aside.bed + aside.depth) - (seen.bed + seen.depth);
                (aside, 0.5 * g * (seen.depth + aside.depth) * rise)
            })
        });
        let [first, second] = aside;
        if self.is_wall {
            let thrust = |side: Option<(Seen, f64)>, which: usize, normal: Vec2| {
                let wet = side.filter(|(seen, _)| seen.depth > scale.dry_depth);
                wet.map_or(0.0, |(seen, own)| thrust(seen, normal, self.closes[which], g) + own)
            };
            let (lost, gained) = (thrust(first, 0, self.normal), thrust(second, 1, self.normal * -1.0));
            return Meeting::Apart(Passing { lost, gained, ..Passing::default() });
        }
        let (Some((i, own_i)), Some((j, own_j))) = (first, second) else {
            return Meeting::Apart(Passing::default());
        };
        let slopes = self.sides.map(|side| &around[side.map_or(0, |side| side.cell)].slopes);
        let along = (self.normal, self.way);
        let half = |seen: Seen, which: usize| seen.half(slopes[which], along, self.steps[which], self.reach_on(which));
        let halves = [half(i, 0), half(j, 1)];
        Meeting::pair(halves, self.way, self.sill, [own_i, own_j], |halves| {
            let changes = changes_along(slopes, self.normal);
            mixing.map_or([0.0; 2], |mixing| mixing.stress(halves, self.way, changes, self.surroundings))
        })
    }

    /// The share of the way on a side.
    fn reach_on(&self, which: usize) -> f64 {
        if which == 0 { self.reach } else { 1.0 - self.reach }
    }
}

#[cfg(test)]
mod tests;
