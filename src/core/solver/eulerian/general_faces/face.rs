//! One general face: its two sides, what each sees of the other, and what passes.

use super::super::Scale;
use super::super::faces::{EAST, Half, turned_by};
use super::super::gradient::difference_over_sill;
use super::super::mixing::{Mixing, Surroundings};
use super::super::state::{GroundRow, PrimitiveRow, Slot, State};
use super::super::walls::{Differences, mirrored};
use super::meeting::{Meeting, Passing};
use crate::math::Vec2;
use crate::physics::limiter::van_leer;

/// How the velocities along a normal change along the face (1/s), of the particles on both sides, by their gradients.
pub(in super::super) fn changes_along(slopes: [&[Vec2; 4]; 2], n: Vec2) -> [f64; 2] {
    let t = n.perpendicular();
    slopes.map(|[.., u, v]| n.x * u.dot(t) + n.y * v.dot(t))
}

/// A padded place (row, column).
pub(in super::super) type Place = (usize, usize);

/// Of the way between a coarse and a fine particle that part which lies in the coarse cell.
const COARSE_REACH: f64 = 2.0 / 3.0;

/// The same way (in spacings of the coarse level).
pub(super) const WAY: f64 = 0.75;

/// A hanging face; its sides are the one to the west or south and the one to the east or north.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Face {
    pub places: [Place; 2],
    pub slots: [Slot; 2],
    pub direction: usize,
    /// Which of the sides is the coarse one.
    pub coarse: usize,
    /// The particles along the face from the coarse one, the one towards the face's half of its side first; none where one is missing.
    pub along: Option<[Place; 2]>,
    /// Whether a wall stands on the way between the particles, or on one side there is no terrain.
    pub is_wall: bool,
    /// Level (m) of a sill on the way; minus infinity where there is none.
    pub sill: f64,
    /// Its length (m): the edge of a fine cell.
    pub length: f64,
    /// The finer of its two levels.
    pub level: usize,
    /// Number of hanging faces of its coarse cell.
    pub of_coarse: usize,
    pub around: Surroundings,
}

/// What is seen of a particle.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub(in super::super) struct Seen {
    pub depth: f64,
    pub bed: f64,
    pub u: f64,
    pub v: f64,
}

impl Seen {
    /// Level of the surface, depth and velocity.
    pub fn values(&self) -> [f64; 4] {
        [self.bed + self.depth, self.depth, self.u, self.v]
    }

    pub fn at((primitive, ground): (&[PrimitiveRow], &[GroundRow]), (row, column): Place) -> Self {
        let water = &primitive[row];
        Seen {
            depth: water.depth[column],
            bed: ground[row].bed[column],
            u: water.velocity_x[column],
            v: water.velocity_y[column],
        }
    }

    /// The particle in a pair whose faces have a normal, over a way (m) along it, with the gradients of surface, depth and velocity.
    #[inline]
    pub fn half(self, [surface, depth, u, v]: &[Vec2; 4], (n, way): (Vec2, f64), step: f64, reach: f64) -> Half {
        let (t, velocity) = (n.perpendicular(), Vec2::new(self.u, self.v));
        // The increment over the way along one direction of the velocity along another.
        let rise = |of: Vec2, along: Vec2| way * (of.x * u.dot(along) + of.y * v.dot(along));
        Half {
            d: self.depth,
            z: self.bed,
            step,
            u: velocity.dot(n),
            v_t: velocity.dot(t),
            rise_eta: way * surface.dot(n),
            rise_d: way * depth.dot(n),
            rise_u: rise(n, n),
            rise_t: rise(t, n),
            stretch_t: rise(t, t),
            reach,
            on_bank: 0.0,
        }
    }

    /// The same with a film that counts as bed.
    pub fn without_film(self) -> Self {
        Seen { depth: 0.0, bed: self.bed + self.depth, ..self }
    }

    /// The coarse particle of a face where it meets the fine one (M87), given it and the two along the face from it.
    pub fn aside(self, along: Option<[Seen; 2]>, dry_depth: f64) -> Self {
        let here = self;
        let Some([ahead, behind]) = along else { return here };
        if [here, ahead, behind].iter().any(|seen| seen.depth <= dry_depth) {
            return here;
        }
        let shift = |of: fn(&Seen) -> f64| {
            let own = of(&here);
            own + 0.25 * van_leer(own - of(&behind), of(&ahead) - own)
        };
        let level = shift(|seen| seen.bed + seen.depth);
        let depth = shift(|seen| seen.depth);
        let bed = level - depth;
        // So that bed and depth make up the level to the last digit.
        Seen { depth: level - bed, bed, u: shift(|seen| seen.u), v: shift(|seen| seen.v) }
    }

    pub fn differences(&self, there: &Seen, sill: f64, dry_depth: f64) -> Differences {
        let is_shut = self.bed + self.depth <= sill && there.bed + there.depth <= sill;
        let surface = difference_over_sill((self.depth, self.bed), (there.depth, there.bed), sill, dry_depth);
        if is_shut { [0.0; 4] } else { [surface, there.depth - self.depth, there.u - self.u, there.v - self.v] }
    }
}

impl Face {
    /// The part of a side of a cell that the face is.
    pub fn share(&self, side: usize) -> f64 {
        if side == self.coarse { 0.5 } else { 1.0 }
    }

    /// How the particles on its two sides meet as they are seen now; `coarse` is the coarse one of them where it meets the fine one.
    pub fn meeting(
        &self,
        state: &State,
        (own, coarse): ([Seen; 2], Seen),
        (scale, mixing): (&Scale, Option<&Mixing>),
    ) -> Meeting {
        if own.iter().all(|seen| seen.depth <= scale.dry_depth) {
            return Meeting::Apart(Passing::default());
        }
        let g = scale.gravity;
        if self.is_wall {
            let towards = |seen: &Seen| turned_by(self.direction, seen.u, seen.v).0;
            let (lost, gained) =
                (mirrored(own[0].depth, towards(&own[0]), g), mirrored(own[1].depth, -towards(&own[1]), g));
            return Meeting::Apart(Passing { lost, gained, ..Passing::default() });
        }
        let way = self.way();
        let mut halves = self.places.map(|place| Half::of_cell(state, place, self.direction, way));
        let (u, v_t) = turned_by(self.direction, coarse.u, coarse.v);
        halves[self.coarse] = Half { d: coarse.depth, z: coarse.bed, u, v_t, ..halves[self.coarse] };
        for (side, half) in halves.iter_mut().enumerate() {
            half.reach = if side == self.coarse { COARSE_REACH } else { 1.0 - COARSE_REACH };
        }
        // (M89)
        let before = own[self.coarse];
        let aside =
            0.5 * g * (before.depth + coarse.depth) * ((coarse.bed + coarse.depth) - (before.bed + before.depth));
        let own = [0, 1].map(|side| if side == self.coarse { aside } else { 0.0 });
        Meeting::pair(halves, way, self.sill, own, |halves| {
            let changes = self.places.map(|(row, column)| {
                let slope = &state.gradient[row];
                if self.direction == EAST { slope.u_y[column] } else { slope.v_x[column] }
            });
            mixing.map_or([0.0; 2], |mixing| mixing.stress(halves, way, changes, self.around))
        })
    }

    /// The way (m) between its particles along the normal.
    pub fn way(&self) -> f64 {
        WAY * 2.0 * self.length
    }
}
