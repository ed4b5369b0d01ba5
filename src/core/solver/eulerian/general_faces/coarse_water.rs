//! Water of the coarse particles beside finer levels, and of those along the faces from them: where they stand, and where they will be while the
//! finer levels step.

use std::ops::Range;

use rayon::prelude::*;

use super::super::state::{GroundRow, PrimitiveRow, State};
use super::face::{Place, Seen};

/// Particles that a thread takes at least: fewer are done sooner than another thread wakes.
const AT_ONCE: usize = 1024;

/// A coarse particle whose water is followed while finer levels step.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
struct Followed {
    place: Place,
    /// Depth (m) and discharges (m²/s) at the start of its step.
    before: [f64; 3],
    /// What they changed in a second of its last step and of the one before, and how long (s) the last one was.
    rate: [f64; 3],
    rate_before: [f64; 3],
    step: f64,
}

/// All coarse particles that general faces look at, by place.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct CoarseWater {
    particles: Vec<Followed>,
    /// Those of each level.
    of_level: Vec<Range<usize>>,
    /// How many faces beside water look at each of them.
    lookers: Vec<u32>,
    seen: Vec<Seen>,
}

impl CoarseWater {
    /// Particles at sorted places.
    pub fn new(places: &[Place], state: &State) -> Self {
        let of_level = |level: usize| {
            let rows = state.rows_of(&(level..level + 1));
            places.partition_point(|place| place.0 < rows.start)..places.partition_point(|place| place.0 < rows.end)
        };
        let still = |&place| Followed { place, before: [0.0; 3], rate: [0.0; 3], rate_before: [0.0; 3], step: 0.0 };
        CoarseWater {
            of_level: (0..state.lattice().level_count()).map(of_level).collect(),
            particles: places.iter().map(still).collect(),
            lookers: vec![0; places.len()],
            seen: vec![Seen::default(); places.len()],
        }
    }

    /// A face looks at a particle from now on, or does so no more.
    pub fn count(&mut self, number: usize, is_live: bool) {
        let lookers = &mut self.lookers[number];
        *lookers = if is_live { *lookers + 1 } else { *lookers - 1 };
    }

    /// A particle that some face looks at, as it was at the latest [`CoarseWater::look`].
    pub fn seen(&self, number: usize) -> Seen {
        self.seen[number]
    }

    /// Begins a step of some levels.
    pub fn begin(&mut self, state: &State, levels: &Range<usize>) {
        let own = self.of_levels(levels);
        let particles = self.particles[own].par_iter_mut().with_min_len(AT_ONCE);
        particles.for_each(|followed| followed.before = conserved(state, followed.place));
    }

    /// Takes what the water of these levels changed in their step (s).
    pub fn end(&mut self, state: &State, levels: &Range<usize>, time_step: f64) {
        let own = self.of_levels(levels);
        self.particles[own].par_iter_mut().with_min_len(AT_ONCE).for_each(|followed| {
            let (after, before) = (conserved(state, followed.place), followed.before);
            followed.rate_before = followed.rate;
            followed.rate = [0, 1, 2].map(|q: usize| (after[q] - before[q]) / time_step);
            followed.step = time_step;
        });
    }

    /// Looks at the particles of some levels now, and at those of the next coarser one `ahead` (s) of their own time.
    pub fn look(&mut self, state: &State, levels: &Range<usize>, ahead: f64, dry_depth: f64) {
        let known = (&state.primitive[..], &state.ground[..]);
        let later = self.of_level.get(levels.end).map_or(usize::MAX, |later| later.start);
        let all = self.of_levels(&(levels.start..(levels.end + 1).min(self.of_level.len())));
        let first = all.start;
        let (particles, lookers) = (self.particles[all.clone()].par_iter(), self.lookers[all.clone()].par_iter());
        let seen = self.seen[all].par_iter_mut();
        let looked_at = seen.zip(particles).zip(lookers).enumerate().with_min_len(AT_ONCE);
        looked_at.for_each(|(k, ((seen, followed), &lookers))| {
            if lookers > 0 {
                let is_later = first + k >= later;
                *seen =
                    if is_later { followed.ahead(known, ahead, dry_depth) } else { Seen::at(known, followed.place) };
            }
        });
    }

    fn of_levels(&self, levels: &Range<usize>) -> Range<usize> {
        self.of_level[levels.start].start..self.of_level[levels.end - 1].end
    }
}

impl Followed {
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
