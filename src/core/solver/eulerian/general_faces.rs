//! General faces: those between particles that are no neighbours of one lattice.
//!
//! Where a level of a nested lattice meets the next finer one, two *hanging* faces stand side by side on each cell of the coarser level.
//! Each is one pair of (M19) to (M31), with other distances. Of the way s between the particles, along the normal, 2/3 lies in the coarse
//! cell: its share w of the limited difference is 2/3, that of the fine particle 1/3. The coarse particle is looked at where it meets the
//! fine one, a quarter of its cell aside.
//!
//! ```text
//! (M87)  X' = X_i ± ¼ Λ(X_i − X_b, X_a − X_i),  X = η, d, v     z' = η' − d'
//! (M88)  a_1 = w Λ_i(2 s ∂η_i/∂n − D η, D η),  |a_1| ≤ |D η|     D η = η_j − η'
//! (M89)  Φ_i ← Φ_i + ½ g (d_i + d') (η' − η_i)
//! ```
//!
//! with a and b its neighbours along the face, Λ van Leer's limiter, and no shift where one of them is dry or missing. (M89) makes the
//! brackets of all faces of the coarse particle count from its own level: on a flat bed they telescope as on one lattice. At rest all differences
//! of levels are 0, whatever the bed, so that water rests across levels.
//!
//! What passes a face is one number, with which both sides are updated: volume is as exact as on one lattice. The fluxes go into the rows of the
//! lattice, at the places that the sides of the cells have there ([`Slot`](super::state::Slot)); a side of a coarse cell gets the mean of its two faces. Nobody
//! else needs to know of levels. Levels that step by themselves: `BergerOliger1984`, without their corrections
//! afterwards, because there is no second flux to correct.

mod face;
mod hanging;
mod outflow;

use std::ops::Range;

use rayon::prelude::*;

use super::faces::{EAST, turned_by};
use super::passes::Passes;
use super::spans::ActiveSet;
use super::state::{GroundRow, PrimitiveRow, State};
use super::update::Stage;
use super::walls::{Differences, SpecialCell, Walls, correct};
use super::{EulerianMethods, Scale};
use crate::solver::FlowProblem;
use face::{Face, WAY};
pub(super) use face::{Passing, Place, Seen};
use hanging::hanging_faces;

/// A cell with general faces: those on each of its sides, in the order of [`NEIGHBOURS`].
#[derive(Clone, Debug)]
struct Cell {
    place: Place,
    faces: [Vec<usize>; 4],
}

/// What is known of a face besides its place.
#[derive(Clone, Copy, Debug, Default)]
struct Now {
    /// The particles on its two sides as the other side sees them: now, or where they step by themselves as they will be or were by now.
    own: [Seen; 2],
    /// The coarse one where it meets the fine one.
    coarse: Seen,
    /// What passes.
    passing: Passing,
    /// What passed in the coarse level's step so far, times seconds.
    booked: Passing,
    /// The fine particle at the start of that step.
    fine_at_start: Seen,
}

/// A coarse particle whose water is followed while finer levels step.
#[derive(Clone, Copy, Debug)]
struct Followed {
    place: Place,
    /// Depth (m) and discharges (m²/s) at the start of its step.
    before: [f64; 3],
    /// What they changed in a second of its last step and of the one before, and how long (s) the last one was.
    rate: [f64; 3],
    rate_before: [f64; 3],
    step: f64,
}

/// All general faces of a problem, what passes them, and the cells beside them by row and column.
pub(crate) struct GeneralFaces {
    faces: Vec<Face>,
    now: Vec<Now>,
    /// The faces between each level and the next coarser one, and those of them beside water.
    of_level: Vec<Range<usize>>,
    live: Vec<Vec<usize>>,
    is_live: Vec<bool>,
    /// The coarse particles of all faces and those along the faces from them, by place, and of each face which of them it needs.
    followed: Vec<Followed>,
    /// Those of each level.
    followed_of: Vec<Range<usize>>,
    needed: Vec<(usize, Option<[usize; 2]>)>,
    cells: Vec<Cell>,
    /// The cells of each padded row.
    of_row: Vec<Range<usize>>,
}

impl GeneralFaces {
    /// The faces of a problem; the steps of the bed over them are counted in `state`.
    pub fn new(problem: &FlowProblem, state: &mut State) -> Self {
        let faces = hanging_faces(problem, state);
        for face in faces.iter().filter(|face| !face.is_wall) {
            let [a, b] = face.places;
            let step = (state.ground[a.0].bed[a.1] - state.ground[b.0].bed[b.1]).abs();
            for (row, column) in face.places {
                let own = &mut state.ground[row].step[column];
                *own = own.max(step);
            }
        }
        let cells = cells_beside(&faces, state);
        let first = |row: usize| cells.partition_point(|cell| cell.place.0 < row);
        let of_row = (0..state.rows + 2).map(|row| first(row)..first(row + 1)).collect();
        let from = |level: usize| faces.partition_point(|face| face.level < level);
        let of_level = (0..state.lattice().level_count()).map(|level| from(level)..from(level + 1)).collect();
        let coarse = |face: &Face| face.places[face.coarse];
        let mut places: Vec<Place> =
            faces.iter().flat_map(|face| face.along.into_iter().flatten().chain([coarse(face)])).collect();
        places.sort_unstable();
        places.dedup();
        let number = |place: Place| places.partition_point(|known| *known < place);
        let followed_of = |level: usize| {
            let rows = state.rows_of(&(level..level + 1));
            places.partition_point(|place| place.0 < rows.start)..places.partition_point(|place| place.0 < rows.end)
        };
        let needed = faces.iter().map(|face| (number(coarse(face)), face.along.map(|along| along.map(number))));
        GeneralFaces {
            needed: needed.collect(),
            followed_of: (0..state.lattice().level_count()).map(followed_of).collect(),
            live: vec![Vec::new(); state.lattice().level_count()],
            is_live: vec![false; faces.len()],
            followed: places.iter().map(|&place| Followed::new(place)).collect(),
            now: vec![Now::default(); faces.len()],
            of_level,
            faces,
            cells,
            of_row,
        }
    }

    /// The places on the two sides of each face through which water passes.
    pub fn linked(&self) -> Vec<[Place; 2]> {
        self.faces.iter().filter(|face| !face.is_wall).map(|face| face.places).collect()
    }

    /// The places on the two sides of each face.
    pub fn places(&self) -> impl Iterator<Item = [Place; 2]> + '_ {
        self.faces.iter().map(|face| face.places)
    }

    /// What passes a face now (m³/s); none where it was not computed with these levels, because its fine side steps by itself.
    pub fn discharge(&self, face: usize, levels: &Range<usize>) -> Option<f64> {
        let is_theirs = levels.contains(&self.faces[face].level);
        is_theirs.then(|| self.faces[face].length * self.now[face].passing.mass)
    }

    /// Whether a padded cell has general faces.
    pub fn is_beside(&self, place: Place) -> bool {
        let cells = &self.cells[self.of_row[place.0].clone()];
        cells.binary_search_by_key(&place, |cell| cell.place).is_ok()
    }

    /// Begins a step of some levels, with the steps of the finer ones within it. Only faces beside water count in it.
    pub fn begin(&mut self, state: &mut State, levels: &Range<usize>, dry_depth: f64) {
        let below = levels.start.checked_sub(1).map_or(0..0, |level| self.of_level[level].clone());
        self.now[below.clone()].iter_mut().for_each(|now| now.booked = Passing::default());
        for level in levels.start.saturating_sub(1)..levels.end {
            self.find_live(state, level, dry_depth);
        }
        let known = (&state.primitive[..], &state.ground[..]);
        for (face, now) in self.faces[below.clone()].iter().zip(&mut self.now[below]) {
            now.fine_at_start = Seen::at(known, face.places[1 - face.coarse]);
        }
        let followed = self.followed_of[levels.start].start..self.followed_of[levels.end - 1].end;
        for followed in &mut self.followed[followed] {
            followed.before = conserved(state, followed.place);
        }
    }

    /// Finds the faces beside water between a level and the next coarser one; through the others nothing flows. What is booked is kept, though
    /// the fine side may have run dry since.
    fn find_live(&mut self, state: &mut State, level: usize, dry_depth: f64) {
        let GeneralFaces { faces, now, live, is_live, of_level, .. } = self;
        live[level].clear();
        for k in of_level[level].clone() {
            let face = &faces[k];
            let is_beside_water =
                face.places.iter().any(|&(row, column)| state.primitive[row].depth[column] > dry_depth);
            let is_booked = now[k].booked.mass.abs() > 0.0;
            if is_beside_water || is_booked {
                live[level].push(k);
            } else if is_live[k] {
                now[k] = Now { fine_at_start: now[k].fine_at_start, ..Now::default() };
                face.slots.iter().for_each(|slot| state.flux[slot.row][slot.direction].clear(slot.column));
            }
            is_live[k] = is_beside_water || is_booked;
        }
    }

    /// The coarse cells that get water which passed a face from the level below these.
    pub fn getting(&self, levels: &Range<usize>) -> impl Iterator<Item = Place> + '_ {
        let below = levels.start.checked_sub(1).map_or(&[][..], |level| &self.live[level]);
        let booked = below.iter().filter(|&&k| self.now[k].booked.mass.abs() > 0.0);
        booked.map(|&k| self.faces[k].places[self.faces[k].coarse])
    }

    /// The numbers of the faces beside water of which a side belongs to one of these levels: first those whose fine sides have stepped by
    /// themselves.
    fn live_of(&self, levels: &Range<usize>) -> impl Iterator<Item = usize> + '_ {
        self.live[levels.start.saturating_sub(1)..levels.end].iter().flatten().copied()
    }

    /// Takes what the water of these levels changed in their step (s).
    pub fn end(&mut self, state: &State, levels: &Range<usize>, time_step: f64) {
        let followed = self.followed_of[levels.start].start..self.followed_of[levels.end - 1].end;
        for followed in &mut self.followed[followed] {
            let (after, before) = (conserved(state, followed.place), followed.before);
            followed.rate_before = followed.rate;
            followed.rate = [0, 1, 2].map(|q: usize| (after[q] - before[q]) / time_step);
            followed.step = time_step;
        }
    }

    /// Looks at the particles on both sides of the faces of some levels, before a stage of a step of theirs. Coarse particles that step later are
    /// looked at `ahead` (s) of their own time, fine ones that have stepped before as they were at the start of the step, in its first stage.
    pub fn look(&mut self, state: &State, levels: &Range<usize>, (stage, ahead): (Stage, f64), dry_depth: f64) {
        let known = (&state.primitive[..], &state.ground[..]);
        let GeneralFaces { faces, now, followed, needed, live, .. } = self;
        for &k in live[levels.start.saturating_sub(1)..levels.end].iter().flatten() {
            let face = &faces[k];
            let at = |number: usize| {
                let followed = &followed[number];
                if face.level + 1 < levels.end {
                    Seen::at(known, followed.place)
                } else {
                    followed.ahead(known, ahead, dry_depth)
                }
            };
            let (coarse, along) = needed[k];
            let is_past = face.level < levels.start && stage == Stage::First;
            let fine = Seen::at(known, face.places[1 - face.coarse]);
            let here = at(coarse);
            now[k].own[face.coarse] = here;
            now[k].own[1 - face.coarse] = if is_past { now[k].fine_at_start } else { fine };
            now[k].coarse = here.aside(along.map(|along| along.map(at)), dry_depth);
        }
    }

    /// Gradients of the cells beside general faces, after those beside walls and sills.
    pub fn correct_gradients(
        &self,
        state: &mut State,
        active: &ActiveSet,
        (walls, passes): (&Walls, &Passes),
        scale: &Scale,
    ) {
        let (primitive, ground, spacing) = (&state.primitive, &state.ground, &state.spacing);
        active.rows_of(&mut state.gradient).for_each(|(row, gradient)| {
            let scale = &scale.on(spacing[row]);
            for cell in &self.cells[self.of_row[row].clone()] {
                let column = cell.place.1;
                if primitive[row].depth[column] <= scale.dry_depth {
                    continue;
                }
                let special =
                    SpecialCell { column, beside: walls.beside(row, column), sills: passes.sills(row, column) };
                let here = Seen::at((primitive, ground), cell.place);
                let beyond = |side: usize| self.beyond(here, cell, side, scale.dry_depth);
                correct((primitive, ground), row, &special, scale, &beyond, gradient);
            }
        });
    }

    /// Mean differences over the general faces on a side of a cell, and the distance of the particles beyond in spacings of the cell.
    fn beyond(&self, here: Seen, cell: &Cell, side: usize, dry_depth: f64) -> Option<(Differences, f64)> {
        let faces = &cell.faces[side];
        let first = self.faces[*faces.first()?];
        // Sides to the east and north are the first ones of their faces.
        let own = side % 2;
        let is_coarse = first.coarse == own;
        let distance = if is_coarse { WAY } else { 2.0 * WAY };
        let mut sum = [0.0; 4];
        for (face, now) in
            faces.iter().filter(|&&face| self.is_live[face]).map(|&face| (&self.faces[face], &self.now[face]))
        {
            let found = if face.is_wall {
                // The mirror image is a spacing away.
                let (normal, _) = turned_by(face.direction, here.u, here.v);
                let (x, y) = turned_by(face.direction, -2.0 * distance * normal, 0.0);
                [0.0, 0.0, x, y]
            } else {
                let there = if is_coarse { &now.own[1 - own] } else { &now.coarse };
                here.differences(there, face.sill, dry_depth)
            };
            sum.iter_mut().zip(found).for_each(|(sum, found)| *sum += found);
        }
        Some((sum.map(|sum| sum / faces.len() as f64), distance))
    }

    /// Fluxes of the faces of some levels in a stage of a step of theirs (s).
    pub fn apply(
        &mut self,
        state: &mut State,
        levels: &Range<usize>,
        scale: &Scale,
        methods: EulerianMethods,
        time_step: f64,
    ) {
        let GeneralFaces { faces, now, live, .. } = self;
        if levels.start > 0 {
            for &k in &live[levels.start - 1] {
                now[k].passing = Passing::default();
                let booked = now[k].booked;
                now[k].passing.add(1.0 / time_step, &booked);
            }
        }
        for live in &live[levels.clone()] {
            let of_face = |&k: &usize| faces[k].pass(state, now[k].own, now[k].coarse, scale, methods);
            let found: Vec<Passing> = live.par_iter().with_min_len(1024).map(of_face).collect();
            live.iter().zip(found).for_each(|(&k, passing)| now[k].passing = passing);
        }
        self.put(state, levels);
    }

    /// Puts what passes the faces into the rows of these levels.
    fn put(&self, state: &mut State, levels: &Range<usize>) {
        let is_theirs = |face: &Face, side: usize| levels.contains(&(face.level + usize::from(side == face.coarse)));
        for face in self.live_of(levels).map(|k| &self.faces[k]) {
            for side in [0, 1].into_iter().filter(|&side| is_theirs(face, side)) {
                let slot = face.slots[side];
                state.flux[slot.row][slot.direction].clear(slot.column);
            }
        }
        for (face, passing) in self.live_of(levels).map(|k| (&self.faces[k], &self.now[k].passing)) {
            for side in [0, 1].into_iter().filter(|&side| is_theirs(face, side)) {
                let (slot, share) = (face.slots[side], face.share(side));
                let out = &mut state.flux[slot.row][slot.direction];
                out.mass[slot.column] += share * passing.mass;
                out.tangential[slot.column] += share * passing.tangential;
                let normal = if side == 0 { &mut out.normal_left } else { &mut out.normal_right };
                normal[slot.column] += share * if side == 0 { passing.lost } else { passing.gained };
            }
        }
    }

    /// Books what passed to coarser levels that step later, in a stage of a step (s) of these.
    pub fn book(&mut self, levels: &Range<usize>, time_step: f64) {
        for &k in &self.live[levels.end - 1] {
            let passing = self.now[k].passing;
            self.now[k].booked.add(0.5 * time_step, &passing);
        }
    }
}

impl Followed {
    fn new(place: Place) -> Self {
        Followed { place, before: [0.0; 3], rate: [0.0; 3], rate_before: [0.0; 3], step: 0.0 }
    }

    /// As it will be so many seconds after the start of its step, if it goes on as in its last two (M91).
    fn ahead(&self, known: (&[PrimitiveRow], &[GroundRow]), seconds: f64, dry_depth: f64) -> Seen {
        let now = Seen::at(known, self.place);
        let bend = if self.step > 0.0 { 0.5 * seconds * (seconds / self.step + 1.0) } else { 0.0 };
        let [depth, x, y] = [0, 1, 2].map(|q: usize| {
            let (last, before) = (self.rate[q], self.rate_before[q]);
            // A rate that changes its sign, or by more than itself, has come to a front or an end.
            let is_smooth = last * before > 0.0 && (last - before).abs() <= last.abs();
            let change = if is_smooth { last - before } else { 0.0 };
            self.before[q] + seconds * last + bend * change
        });
        if self.before[0] <= dry_depth || depth <= dry_depth {
            return now;
        }
        Seen { depth, u: x / depth, v: y / depth, ..now }
    }
}

/// Depth (m) and discharges (m²/s) of a cell.
fn conserved(state: &State, (row, column): Place) -> [f64; 3] {
    let water = &state.water[row];
    [water.depth[column], water.discharge_x[column], water.discharge_y[column]]
}

/// The cells with general faces, by row and column.
fn cells_beside(faces: &[Face], state: &State) -> Vec<Cell> {
    let mut beside: Vec<(Place, usize, usize)> = Vec::new();
    for (number, face) in faces.iter().enumerate() {
        let sides = if face.direction == EAST { [0, 1] } else { [2, 3] };
        beside.extend(face.places.into_iter().zip(sides).map(|(place, side)| (place, side, number)));
    }
    beside.retain(|(place, ..)| state.has_terrain(place.0, place.1));
    beside.sort_unstable();
    let cell = |beside: &[(Place, usize, usize)]| {
        let on = |side: usize| beside.iter().filter(|(_, of, _)| *of == side).map(|(.., face)| *face).collect();
        Cell { place: beside[0].0, faces: [0, 1, 2, 3].map(on) }
    };
    beside.chunk_by(|a, b| a.0 == b.0).map(cell).collect()
}

#[cfg(test)]
mod tests;
