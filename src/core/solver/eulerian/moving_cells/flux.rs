//! What passes the faces of cells that move (M106, M107).

use rayon::prelude::*;

use super::super::faces::{HALF_WAY, Half};
use super::super::general_faces::{Meeting, Passing, Seen, changes_along, pass};
use super::super::mixing::{Mixing, Surroundings};
use super::super::{EulerianMethods, Scale};
use super::geometry::Face;
use super::{MovingCells, Slopes};
use crate::math::Vec2;

/// What is known of the cells.
#[derive(Clone, Copy)]
struct Known<'a> {
    seen: &'a [Seen],
    slopes: &'a [Slopes],
    motion: &'a [Vec2],
    friction: &'a [f64],
    area: &'a [f64],
}

impl MovingCells {
    /// Fluxes of all faces in a step (s).
    pub fn evaluate_fluxes(&mut self, scale: &Scale, methods: EulerianMethods, time_step: f64) {
        let MovingCells { chunks, passing, seen, slopes, motion, friction, area, .. } = self;
        let known = Known { seen, slopes, motion, friction, area };
        let mixing = Mixing::new(scale, methods, time_step);
        passing.par_iter_mut().zip(chunks.par_iter()).for_each(|(passing, chunk)| {
            passing.clear();
            passing.resize(chunk.faces.len(), Passing::default());
            let meetings = chunk.faces.iter().map(|face| face.meeting(known, (scale, mixing.as_ref())));
            pass(meetings.zip(passing.iter_mut()), scale, methods);
            for (passing, face) in passing.iter_mut().zip(&chunk.faces) {
                let carried = face.speed(motion) * passing.mass;
                passing.lost += carried;
                passing.gained += carried;
            }
        });
    }
}

impl Face {
    /// w_f of (M106) (m/s).
    #[inline]
    pub fn speed(&self, motion: &[Vec2]) -> f64 {
        let [i, j] = self.ends.map(|end| motion[end as usize]);
        let aside = self.along / self.distance;
        0.5 * (i + j).dot(self.normal) + (i - j).dot(self.normal.perpendicular()) * aside
    }

    /// How its particles meet in its own frame.
    fn meeting(&self, known: Known<'_>, (scale, mixing): (&Scale, Option<&Mixing>)) -> Meeting {
        let seen = self.ends.map(|end| known.seen[end as usize]);
        if seen.iter().all(|seen| seen.depth <= scale.dry_depth) {
            return Meeting::Apart(Passing::default());
        }
        let speed = self.speed(known.motion);
        let slopes = self.ends.map(|end| &known.slopes[end as usize]);
        // A film gives nothing, and a face that comes over it does not push it on.
        let seen =
            seen.map(|seen| if speed != 0.0 && seen.depth <= scale.dry_depth { seen.without_film() } else { seen });
        let half = |side: usize| {
            let along = (self.normal, self.distance);
            let half = seen[side].half(&slopes[side].of, along, slopes[side].step, HALF_WAY);
            // What is pressed together along a face mixes over faces in a row (M32), and these are in none.
            Half { u: half.u - speed, stretch_t: 0.0, ..half }
        };
        let halves = [half(0), half(1)];
        let halves = on_banks(halves, scale.dry_depth);
        Meeting::pair(halves, self.distance, f64::NEG_INFINITY, [0.0; 2], |halves| {
            mixing.map_or([0.0; 2], |mixing| {
                let changes = changes_along(slopes.map(|slopes| &slopes.of), self.normal);
                let halves = halves.map(|half| Half { u: half.u + speed, ..half });
                mixing.stress(&halves, self.distance, changes, self.surroundings(known))
            })
        })
    }

    /// What the stress takes from both cells; a cell has about six faces.
    fn surroundings(&self, known: Known<'_>) -> Surroundings {
        let [i, j] = self.ends.map(|end| end as usize);
        let area = known.area[i].min(known.area[j]);
        Surroundings {
            friction: 0.5 * (known.friction[i] + known.friction[j]),
            bears: self.distance * area / (3.0 * FACES * self.length),
        }
    }
}

/// Where a bank rises out of the water, its level goes on beyond the face with the slope that it has.
#[inline]
fn on_banks([i, j]: [Half; 2], dry_depth: f64) -> [Half; 2] {
    let is_bank =
        |bank: &Half, water: &Half| bank.d <= dry_depth && water.d > dry_depth && bank.z + bank.d > water.z + water.d;
    let on =
        |half: Half, other: &Half| if is_bank(other, &half) { Half { on_bank: half.rise_eta, ..half } } else { half };
    [on(i, &j), on(j, &i)]
}

/// Faces of a cell, in the mean.
const FACES: f64 = 6.0;
