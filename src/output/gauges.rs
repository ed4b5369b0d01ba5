//! Water over time at gauges, and what each gauge has seen in the end.
//!
//! A gauge has the value of the lattice cell that holds it: no interpolation between cells, since the neighbours may lie
//! on the other side of a wall or on dry ground. Samples are interpolated in time between compute steps; maxima and
//! arrival are those of the maps.

use super::frames::{Schedule, share_of_step};
use super::maxima::{LatticeMaps, Maxima, PreviousWater};
use super::{Gauge, WET_DEPTH};
use crate::lattice::{Lattice, WaterOnLattice};

/// The water at one gauge at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaugeSample {
    /// Index of the gauge in the plan.
    pub gauge: usize,
    /// Time (s).
    pub time: f64,
    /// Depth (m).
    pub depth: f64,
    /// Water level (m); none on dry ground.
    pub level: Option<f64>,
    /// Velocity to the east (m/s).
    pub velocity_x: f64,
    /// Velocity to the north (m/s).
    pub velocity_y: f64,
}

/// What a gauge has seen; everything is empty for a gauge outside the terrain.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GaugeResult {
    /// Bed elevation of the cell (m).
    pub bed: Option<f64>,
    /// Arrival for the first threshold (s).
    pub arrival: Option<f64>,
    /// Greatest depth (m); 0 where the water never came.
    pub max_depth: Option<f64>,
    /// Greatest water level (m); none where the water never came.
    pub max_level: Option<f64>,
    /// Time of the greatest depth (s); none where the water never came.
    pub time_of_max: Option<f64>,
    /// Greatest speed (m/s).
    pub max_speed: Option<f64>,
}

/// Samples the gauges of a run.
#[derive(Debug)]
pub(super) struct GaugeRecorder {
    /// Cell of each gauge and its bed elevation (m), when there is terrain.
    cells: Vec<Option<(usize, f64)>>,
    schedule: Schedule,
    samples: Vec<GaugeSample>,
}

impl GaugeRecorder {
    pub(super) fn new(gauges: &[Gauge], lattice: &Lattice, bed_elevation: &[f64], schedule: Schedule) -> Self {
        let cell_of = |gauge: &Gauge| {
            let cell = lattice.cell_at(lattice.to_local(gauge.position))?;
            (!bed_elevation[cell].is_nan()).then_some((cell, bed_elevation[cell]))
        };
        GaugeRecorder { cells: gauges.iter().map(cell_of).collect(), schedule, samples: Vec::new() }
    }

    /// Takes the samples that fall due between `before` and `after` (s); `maxima` still holds the step before.
    pub(super) fn step(&mut self, before: f64, after: f64, maxima: &Maxima, water: &WaterOnLattice<'_>) {
        while let Some(time) = self.schedule.due(after) {
            let share = share_of_step(time, before, after);
            for (gauge, cell) in self.cells.iter().enumerate() {
                if let Some((cell, bed)) = *cell {
                    let (depth, velocity_x, velocity_y) = between(&maxima.previous(cell), water, cell, share);
                    let level = (depth > WET_DEPTH).then_some(bed + depth);
                    self.samples.push(GaugeSample { gauge, time, depth, level, velocity_x, velocity_y });
                }
            }
        }
    }

    pub(super) fn results(&self, maps: &LatticeMaps) -> Vec<GaugeResult> {
        let result_of = |cell: &Option<(usize, f64)>| match *cell {
            None => GaugeResult::default(),
            Some((cell, bed)) => {
                let was_wet = maps.max_depth[cell] > WET_DEPTH;
                GaugeResult {
                    bed: Some(bed),
                    arrival: Some(maps.thresholds[0].arrival[cell]).filter(|time| !time.is_nan()),
                    max_depth: Some(maps.max_depth[cell]),
                    max_level: was_wet.then_some(bed + maps.max_depth[cell]),
                    time_of_max: was_wet.then_some(maps.time_of_max_depth[cell]),
                    max_speed: Some(maps.max_speed[cell]),
                }
            }
        };
        self.cells.iter().map(result_of).collect()
    }

    pub(super) fn into_samples(self) -> Vec<GaugeSample> {
        self.samples
    }
}

/// Depth and velocity of a cell between two steps.
fn between(previous: &PreviousWater, water: &WaterOnLattice<'_>, cell: usize, share: f64) -> (f64, f64, f64) {
    let mix = |a: f64, b: f64| a + (b - a) * share;
    let depth = mix(previous.depth, water.depth[cell]);
    if depth > WET_DEPTH {
        let velocity_x = mix(previous.discharge_x, water.discharge_x[cell]) / depth;
        let velocity_y = mix(previous.discharge_y, water.discharge_y[cell]) / depth;
        (depth, velocity_x, velocity_y)
    } else {
        (depth, 0.0, 0.0)
    }
}
