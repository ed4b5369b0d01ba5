//! What each cell has seen of the tracers: the greatest concentration, and when a tracer arrived.
//!
//! Water no deeper than [`WET_DEPTH`] counts as dry ground, as in all maps. A tracer arrives in a cell when its concentration there reaches
//! a share of the greatest one of its sources. In water it is taken as linear in time between two steps, and where both water and tracer come within one
//! step they come when the depth passes [`WET_DEPTH`]. The amount d C is linear in a frame between two steps, as the depth is.

use bytemuck::allocation::zeroed_vec;

use super::WET_DEPTH;
use super::frames::share_of_step;
use super::grid::filled;
use super::maxima::Maxima;
use crate::lattice::{Lattice, WaterInCell, WaterOnLattice};

/// A tracer, as the outputs name it.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TracerPlan {
    /// Name.
    pub name: String,
    /// Unit of its concentrations.
    pub unit: String,
    /// The greatest concentration of its sources.
    pub greatest: f64,
    /// Share of that at which it has arrived.
    pub arrival_threshold: f64,
}

/// The balance of a tracer at one moment: amounts, which are concentrations times cubic metres.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TracerBalance {
    /// Name.
    pub name: String,
    /// Unit of the amounts.
    pub unit: String,
    /// Time (s).
    pub time_s: f64,
    /// At the start.
    pub initial: f64,
    /// Came in since.
    #[serde(rename = "in")]
    pub inflow: f64,
    /// Left since.
    #[serde(rename = "out")]
    pub outflow: f64,
    /// Decayed since.
    pub decayed: f64,
    /// In the water.
    pub stored: f64,
    /// Error of the balance over the first two (dimensionless).
    pub error_relative: f64,
}

/// The maps of a tracer, `[rows * columns]`, row 0 in the north; [`FILL`](super::FILL) where there is no value.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TracerGrids {
    /// The tracer.
    pub plan: TracerPlan,
    /// Greatest concentration; no value where always dry.
    pub greatest: Vec<f32>,
    /// The same over the greatest one of the sources.
    pub dilution: Vec<f32>,
    /// Time of arrival (s); no value where it never came.
    pub arrival: Vec<f32>,
}

/// What a cell has seen of a tracer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TracerSeen {
    /// Greatest concentration; NaN where always dry.
    pub greatest: f64,
    /// Time of arrival (s); NaN where it never came.
    pub arrival: f64,
}

/// Follows one tracer in all cells.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
struct Followed {
    /// C at the step before.
    previous: Vec<f64>,
    greatest: Vec<f64>,
    arrival: Vec<f64>,
}

/// Follows all tracers.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Tracers {
    plans: Vec<TracerPlan>,
    columns: usize,
    followed: Vec<Followed>,
}

impl Tracers {
    pub(super) fn new(plans: Vec<TracerPlan>, lattice: &Lattice) -> Self {
        let followed = |_: &TracerPlan| Followed {
            previous: zeroed_vec(lattice.len()),
            greatest: vec![f64::NAN; lattice.len()],
            arrival: vec![f64::NAN; lattice.len()],
        };
        Tracers { followed: plans.iter().map(followed).collect(), plans, columns: lattice.columns }
    }

    /// The tracers.
    pub(super) fn plans(&self) -> &[TracerPlan] {
        &self.plans
    }

    /// Takes the water at the end of a step from `before` to `after` (s); `maxima` still holds that of the step before.
    pub(super) fn step(&mut self, before: f64, after: f64, maxima: &Maxima, water: &WaterOnLattice<'_>) {
        for (which, (plan, followed)) in self.plans.iter().zip(&mut self.followed).enumerate() {
            let wanted = plan.arrival_threshold * plan.greatest;
            for span in water.spans {
                let row = span.row as usize;
                let (depths, own) = (water.rows.row(row).depth, water.rows.concentration(which, row));
                for column in span.from as usize..span.to as usize {
                    let index = row * self.columns + column;
                    let earlier = (maxima.previous(index).depth, followed.previous[index]);
                    let now = (depths[column], own[column]);
                    followed.previous[index] = now.1;
                    if now.0 <= WET_DEPTH {
                        continue;
                    }
                    let greatest = &mut followed.greatest[index];
                    *greatest = if *greatest >= now.1 { *greatest } else { now.1 };
                    if followed.arrival[index].is_nan() && now.1 >= wanted && now.1 > 0.0 {
                        let share = share_of_arrival(earlier, now, wanted);
                        followed.arrival[index] = before + share * (after - before);
                    }
                }
            }
        }
    }

    /// What a cell has seen of a tracer.
    pub(super) fn seen(&self, which: usize, index: usize) -> TracerSeen {
        let followed = &self.followed[which];
        TracerSeen { greatest: followed.greatest[index], arrival: followed.arrival[index] }
    }

    /// The water of a cell `share` of the way from the step before to this one: its depth, and in place of the discharge to the east the amount d C.
    pub(super) fn between(&self, which: usize, index: usize, share: f64, before: f64, now: (f64, f64)) -> WaterInCell {
        let earlier = before * self.followed[which].previous[index];
        let mix = |a: f64, b: f64| a + (b - a) * share;
        WaterInCell { depth: mix(before, now.0), discharge_x: mix(earlier, now.0 * now.1), discharge_y: 0.0 }
    }
}

impl Tracers {
    /// The maps on the pixels of the terrain, given the source of the water of each and the wet cell of a source; dry pixels have none.
    pub(super) fn on_pixels(&self, sources: &[u32], cell_of: impl Fn(u32) -> Option<usize>) -> Vec<TracerGrids> {
        let of = |(which, plan): (usize, &TracerPlan)| {
            let value = |of: &dyn Fn(TracerSeen) -> f64| {
                let seen = |source: u32| cell_of(source).map_or(f64::NAN, |cell| of(self.seen(which, cell)));
                sources.iter().map(|&source| filled(seen(source))).collect()
            };
            TracerGrids {
                greatest: value(&|seen| seen.greatest),
                dilution: value(&|seen| seen.greatest / plan.greatest),
                arrival: value(&|seen| seen.arrival),
                plan: plan.clone(),
            }
        };
        self.plans.iter().enumerate().map(of).collect()
    }
}

/// The share of a step at which a tracer arrives: depth (m) and concentration at both ends.
fn share_of_arrival(earlier: (f64, f64), now: (f64, f64), wanted: f64) -> f64 {
    if earlier.0 > WET_DEPTH {
        share_of_step(wanted, earlier.1, now.1)
    } else {
        share_of_step(WET_DEPTH, earlier.0, now.0)
    }
}

/// The concentration of a tracer in a cell, and its depth (m).
pub(super) fn concentration_at(water: &WaterOnLattice<'_>, which: usize, index: usize) -> (f64, f64) {
    let (column, row) = water.lattice.column_row(index);
    (water.rows.row(row).depth[column], water.rows.concentration(which, row)[column])
}
