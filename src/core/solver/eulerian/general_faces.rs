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

mod coarse_water;
mod face;
mod hanging;
mod in_rows;
mod meeting;
mod outflow;

use std::ops::Range;

use rayon::prelude::*;

use super::faces::turned_by;
use super::mixing::Mixing;
use super::passes::Passes;
use super::spans::ActiveSet;
use super::state::State;
use super::update::Stage;
use super::walls::{Differences, SpecialCell, Walls, correct};
use super::{EulerianMethods, Scale};
use crate::solver::FlowProblem;
use coarse_water::CoarseWater;
use face::{Face, WAY};
pub(super) use face::{Place, Seen, changes_along};
use hanging::hanging_faces;
use in_rows::{ByRow, Cell, SideOfCell, cells_beside, sides_of_cells};
pub(super) use meeting::{Meeting, Passing, pass};

/// Faces that a thread takes at least: fewer are done sooner than another thread wakes.
pub(super) const AT_ONCE: usize = 512;

/// What is known of a face besides its place.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
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

/// All general faces of a problem, what passes them, and the cells beside them by row and column.
#[derive(serde::Serialize, serde::Deserialize)]
pub(crate) struct GeneralFaces {
    faces: Vec<Face>,
    now: Vec<Now>,
    /// Whether a face is beside water or has passed some in the coarse level's step.
    is_live: Vec<bool>,
    /// The faces between each level and the next coarser one.
    of_level: Vec<Range<usize>>,
    coarse_water: CoarseWater,
    /// Of each face the numbers of its coarse particle and of those along the face from it.
    coarse: Vec<(usize, Option<[usize; 2]>)>,
    cells: ByRow<Cell>,
    sides: ByRow<SideOfCell>,
    /// Those of each row with a face beside water, by their numbers in the row.
    live_sides: Vec<Vec<usize>>,
}

impl GeneralFaces {
    /// The faces of a problem; the steps of the bed over them are counted in `state`.
    pub fn new(problem: &FlowProblem, walls: &Walls, state: &mut State) -> Self {
        let faces = hanging_faces(problem, state);
        for face in faces.iter().filter(|face| !face.is_wall) {
            let [a, b] = face.places;
            let step = (state.ground[a.0].bed[a.1] - state.ground[b.0].bed[b.1]).abs();
            for (row, column) in face.places {
                let own = &mut state.ground[row].step[column];
                *own = own.max(step);
            }
        }
        let from = |level: usize| faces.partition_point(|face| face.level < level);
        let of_level = (0..state.lattice().level_count()).map(|level| from(level)..from(level + 1)).collect();
        let coarse = |face: &Face| face.places[face.coarse];
        let mut places: Vec<Place> =
            faces.iter().flat_map(|face| face.along.into_iter().flatten().chain([coarse(face)])).collect();
        places.sort_unstable();
        places.dedup();
        let number = |place: Place| places.partition_point(|known| *known < place);
        let numbers = faces.iter().map(|face| (number(coarse(face)), face.along.map(|along| along.map(number))));
        GeneralFaces {
            coarse: numbers.collect(),
            coarse_water: CoarseWater::new(&places, state),
            is_live: vec![false; faces.len()],
            now: vec![Now::default(); faces.len()],
            cells: cells_beside(&faces, state, walls),
            sides: sides_of_cells(&faces, state),
            live_sides: vec![Vec::new(); state.rows + 2],
            of_level,
            faces,
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
        self.cells.of_row(place.0).binary_search_by_key(&place, |cell| cell.place).is_ok()
    }

    /// Begins a step of some levels, with the steps of the finer ones within it. Only faces beside water count in it.
    pub fn begin(&mut self, state: &mut State, levels: &Range<usize>, dry_depth: f64) {
        let known = (&state.primitive[..], &state.ground[..]);
        let below = self.below(levels);
        let (faces, is_live) = (&self.faces[below.clone()], &self.is_live[below.clone()]);
        for (face, now) in live(faces, &mut self.now[below], is_live) {
            now.booked = Passing::default();
            now.fine_at_start = Seen::at(known, face.places[1 - face.coarse]);
        }
        for level in levels.start.saturating_sub(1)..levels.end {
            self.find_live(state, level, dry_depth);
        }
        self.coarse_water.begin(state, levels);
    }

    /// Takes what the water of these levels changed in their step (s).
    pub fn end(&mut self, state: &State, levels: &Range<usize>, time_step: f64) {
        self.coarse_water.end(state, levels, time_step);
    }

    /// Finds the faces beside water between a level and the next coarser one; through the others nothing flows. What is booked is kept, though
    /// the fine side may have run dry since.
    fn find_live(&mut self, state: &mut State, level: usize, dry_depth: f64) {
        let GeneralFaces { faces, now, is_live, of_level, coarse, coarse_water, sides, live_sides, .. } = self;
        let all = of_level[level].clone();
        let has_turned = |&k: &usize| {
            let is_water = |&(row, column): &Place| state.primitive[row].depth[column] > dry_depth;
            let is_live_now = faces[k].places.iter().any(is_water) || (is_live[k] && now[k].booked.mass.abs() > 0.0);
            is_live_now != is_live[k]
        };
        let turned: Vec<usize> = all.into_par_iter().with_min_len(AT_ONCE).filter(has_turned).collect();
        let mut rows: Vec<usize> = turned.iter().flat_map(|&k| faces[k].slots.map(|slot| slot.row)).collect();
        for k in turned {
            let face = &faces[k];
            is_live[k] = !is_live[k];
            let (at, along) = coarse[k];
            along.into_iter().flatten().chain([at]).for_each(|number| coarse_water.count(number, is_live[k]));
            now[k] = Now::default();
            if is_live[k] {
                // Water comes in steps of the finer levels too: before it the fine side had the film that it has now.
                let known = (&state.primitive[..], &state.ground[..]);
                now[k].fine_at_start = Seen::at(known, face.places[1 - face.coarse]);
            } else {
                face.slots.iter().for_each(|slot| state.flux[slot.row][slot.direction].clear(slot.column));
            }
        }
        rows.sort_unstable();
        rows.dedup();
        for row in rows {
            let of_row = sides.of_row(row);
            let is_beside_water = |&side: &usize| of_row[side].faces.iter().any(|&face| is_live[face]);
            live_sides[row] = (0..of_row.len()).filter(is_beside_water).collect();
        }
    }

    /// The faces from the level below these to them.
    fn below(&self, levels: &Range<usize>) -> Range<usize> {
        levels.start.checked_sub(1).map_or(0..0, |level| self.of_level[level].clone())
    }

    /// The faces of which a side belongs to one of these levels.
    fn all_of(&self, levels: &Range<usize>) -> Range<usize> {
        self.of_level[levels.start.saturating_sub(1)].start..self.of_level[levels.end - 1].end
    }

    /// The coarse cells that get water which passed a face from the level below these.
    pub fn getting(&self, levels: &Range<usize>) -> impl Iterator<Item = Place> + '_ {
        let booked = self.below(levels).filter(|&k| self.is_live[k] && self.now[k].booked.mass.abs() > 0.0);
        booked.map(|k| self.faces[k].places[self.faces[k].coarse])
    }

    /// Looks at the particles on both sides of the faces of some levels, before a stage of a step of theirs. Coarse particles that step later are
    /// looked at `ahead` (s) of their own time, fine ones that have stepped before as they were at the start of the step, in its first stage.
    pub fn look(&mut self, state: &State, levels: &Range<usize>, (stage, ahead): (Stage, f64), dry_depth: f64) {
        self.coarse_water.look(state, levels, ahead, dry_depth);
        let all = self.all_of(levels);
        let known = (&state.primitive[..], &state.ground[..]);
        let coarse_water = &self.coarse_water;
        let faces = self.faces[all.clone()].par_iter().zip(self.now[all.clone()].par_iter_mut());
        let faces = faces.zip(&self.coarse[all.clone()]).zip(&self.is_live[all]);
        let faces = faces.with_min_len(AT_ONCE).filter(|(_, is_live)| **is_live);
        faces.for_each(|(((face, now), &(at, along)), _)| {
            let is_past = face.level < levels.start && stage == Stage::First;
            let fine = if is_past { now.fine_at_start } else { Seen::at(known, face.places[1 - face.coarse]) };
            let here = coarse_water.seen(at);
            now.own[face.coarse] = here;
            now.own[1 - face.coarse] = fine;
            now.coarse = here.aside(along.map(|along| along.map(|number| coarse_water.seen(number))), dry_depth);
        });
    }

    /// Gradients of the cells beside general faces, after those beside walls and sills.
    pub fn correct_gradients(&self, state: &mut State, active: &ActiveSet, passes: &Passes, scale: &Scale) {
        let (primitive, ground, spacing) = (&state.primitive, &state.ground, &state.spacing);
        active.rows_of(&mut state.gradient).for_each(|(row, gradient)| {
            let scale = &scale.on(spacing[row]);
            for cell in active.among(row, self.cells.of_row(row), |cell| cell.place.1) {
                let column = cell.place.1;
                if primitive[row].depth[column] <= scale.dry_depth {
                    continue;
                }
                let special = SpecialCell { column, beside: cell.beside, sills: passes.sills(row, column) };
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
        (active, levels): (&ActiveSet, &Range<usize>),
        (scale, methods): (&Scale, EulerianMethods),
        time_step: f64,
    ) {
        let mixing = Mixing::new(scale, methods, time_step);
        let all = self.all_of(levels);
        let faces = self.faces[all.clone()].par_chunks(AT_ONCE).zip(self.now[all.clone()].par_chunks_mut(AT_ONCE));
        let known = &*state;
        faces.zip(self.is_live[all].par_chunks(AT_ONCE)).for_each(|((faces, now), is_live)| {
            let found = live(faces, now, is_live).map(|(face, now)| {
                let meeting = if face.level < levels.start {
                    let mut passing = Passing::default();
                    passing.add(1.0 / time_step, &now.booked);
                    Meeting::Apart(passing)
                } else {
                    face.meeting(known, (now.own, now.coarse), (scale, mixing.as_ref()))
                };
                (meeting, &mut now.passing)
            });
            pass(found, scale, methods);
        });
        self.put(state, active);
    }

    /// Puts what passes the faces into the rows at hand.
    fn put(&self, state: &mut State, active: &ActiveSet) {
        active.rows_of(&mut state.flux).for_each(|(row, flux)| {
            let sides = self.sides.of_row(row);
            for SideOfCell { slot, side, faces } in self.live_sides[row].iter().map(|&side| &sides[side]) {
                let (out, column) = (&mut flux[slot.direction], slot.column);
                out.clear(column);
                for &k in faces.iter().filter(|&&k| self.is_live[k]) {
                    let (share, passing) = (self.faces[k].share(*side), &self.now[k].passing);
                    out.mass[column] += share * passing.mass;
                    out.tangential[column] += share * passing.tangential;
                    let (normal, momentum) = match side {
                        0 => (&mut out.normal_left, passing.lost),
                        _ => (&mut out.normal_right, passing.gained),
                    };
                    normal[column] += share * momentum;
                }
            }
        });
    }

    /// Books what passed to coarser levels that step later, in a stage of a step (s) of these.
    pub fn book(&mut self, levels: &Range<usize>, time_step: f64) {
        let last = self.of_level[levels.end - 1].clone();
        for (_, now) in live(&self.faces[last.clone()], &mut self.now[last.clone()], &self.is_live[last]) {
            let passing = now.passing;
            now.booked.add(0.5 * time_step, &passing);
        }
    }
}

/// Some faces beside water, and what is known of them.
fn live<'a>(
    faces: &'a [Face],
    now: &'a mut [Now],
    is_live: &'a [bool],
) -> impl Iterator<Item = (&'a Face, &'a mut Now)> + 'a {
    let all = faces.iter().zip(now).zip(is_live);
    all.filter(|(_, is_live)| **is_live).map(|(face, _)| face)
}

#[cfg(test)]
mod tests;
