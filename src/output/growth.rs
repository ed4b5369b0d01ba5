//! Whether the flood still grows when the run ends.
//!
//! The water of the greatest depths of all cells, less that of the start, is what the flood covered up to a time:
//!
//! ```text
//! V(t) = Σ A_i (max_{t' ≤ t} d_i(t') − d_i(0)),   growth = (V(T) − V(0.9 T)) / V(T)
//! ```
//!
//! A flood that ended gives 0, one that grows evenly 0.1. It is not reported where the greatest depths rose by less than a millimetre on the mean
//! of the cells that were reached: waves of a lake rise for ever.

use serde::Serialize;

use super::WET_DEPTH;
use super::maxima::Maxima;
use crate::lattice::Lattice;
use crate::math::Vec2;

/// Share of the run after which its growth counts.
const LATE: f64 = 0.9;
/// A step that ends behind this share of the run leaves too little of it to judge by.
const TOO_LATE: f64 = 0.95;
/// Growth from which it is reported.
const TOLD: f64 = 0.02;
/// Mean rise (m) of the greatest depths from which it is reported.
const TOLD_RISE: f64 = 1e-3;

/// How the flood still grew when the run ended.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Growth {
    /// Time (s) from which it is counted, to the end of the run.
    pub since_s: f64,
    /// Growth of the greatest depths since then, over that of the whole run.
    pub share: f64,
    /// When the water last reached new ground (s).
    pub last_arrival_s: f64,
    /// Where it did (map coordinates, m).
    pub x: f64,
    /// The same.
    pub y: f64,
}

/// Follows the growth of a flood.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct GrowthRecorder {
    end_time: f64,
    at_start: f64,
    /// Time (s) and volume (m³) of the first step that ended late in the run.
    late: Option<(f64, f64)>,
}

impl GrowthRecorder {
    pub(super) fn new(end_time: f64) -> Self {
        GrowthRecorder { end_time, at_start: 0.0, late: None }
    }

    /// Takes the water of the start.
    pub(super) fn start(&mut self, maxima: &Maxima, lattice: &Lattice) {
        self.at_start = covered(maxima, lattice).0;
    }

    /// Takes a step that ended at a time (s).
    pub(super) fn step(&mut self, time: f64, maxima: &Maxima, lattice: &Lattice) {
        if self.late.is_none() && time >= LATE * self.end_time {
            self.late = Some((time, covered(maxima, lattice).0));
        }
    }

    /// The growth of a run that came to its end, where it is reported.
    pub(super) fn at_end(&self, time: f64, maxima: &Maxima, lattice: &Lattice) -> Option<Growth> {
        let (since_s, before) = self.late.filter(|(since, _)| *since <= TOO_LATE * self.end_time)?;
        if time < self.end_time {
            return None;
        }
        let (covered, reached) = covered(maxima, lattice);
        let share = (covered - before) / (covered - self.at_start);
        if !(share >= TOLD && covered - before >= TOLD_RISE * reached) {
            return None;
        }
        let arrival = |cell: usize| maxima.seen_of_threshold(cell, 0, time).arrival;
        let arrivals = leaves(lattice).map(|cell| (arrival(cell), cell)).filter(|(arrival, _)| !arrival.is_nan());
        let (last_arrival_s, cell) = arrivals.max_by(|one, other| one.0.total_cmp(&other.0))?;
        let Vec2 { x, y } = lattice.to_map(lattice.centre(cell));
        Some(Growth { since_s, share, last_arrival_s, x, y })
    }
}

/// The water (m³) of the greatest depths of all cells, and the area (m²) that it covers.
fn covered(maxima: &Maxima, lattice: &Lattice) -> (f64, f64) {
    let (mut volume, mut area) = (0.0, 0.0);
    for cell in leaves(lattice) {
        let depth = maxima.seen(cell).max_depth;
        if depth > WET_DEPTH {
            volume += depth * lattice.area_of(cell);
            area += lattice.area_of(cell);
        }
    }
    (volume, area)
}

/// The cells that stand for their places.
fn leaves(lattice: &Lattice) -> impl Iterator<Item = usize> + '_ {
    lattice.levels().flat_map(|level| lattice.leaves_of(level))
}
