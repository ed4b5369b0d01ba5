//! Concentrations of tracers on the output grid: in frames the amount over the depth of a cell, in maps what counts most.

use super::{FILL, Mean, OutputGrid};
use crate::lattice::WaterInCell;
use crate::output::WET_DEPTH;
use crate::output::tracers::{TracerGrids, TracerPlan, Tracers};

impl OutputGrid {
    /// A concentration from water whose discharge to the east is the amount d C; see [`frame`](Self::frame).
    pub(in crate::output) fn concentration(&self, bed: &[f64], water: impl Fn(usize, &mut [WaterInCell])) -> Vec<f32> {
        let mut found = vec![FILL; self.len()];
        self.for_each_mean(bed, water, |cell, Mean { water, .. }| {
            if water.depth > WET_DEPTH {
                found[cell] = (water.discharge_x / water.depth) as f32;
            }
        });
        found
    }

    /// The maps of the tracers.
    pub(in crate::output) fn maps_of_tracers(&self, bed: &[f64], tracers: &Tracers) -> Vec<TracerGrids> {
        let of = |(which, plan): (usize, &TracerPlan)| {
            let seen = |index: usize| tracers.seen(which, index);
            TracerGrids {
                greatest: self.pick(bed, |index| seen(index).greatest, f64::max),
                dilution: self.pick(bed, |index| seen(index).greatest / plan.greatest, f64::max),
                arrival: self.pick(bed, |index| seen(index).arrival, f64::min),
                plan: plan.clone(),
            }
        };
        tracers.plans().iter().enumerate().map(of).collect()
    }
}
