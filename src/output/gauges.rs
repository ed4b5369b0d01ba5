//! Water over time at gauges, and what each gauge has seen in the end.
//!
//! A gauge reads the water as SPH reads any field at a point: the kernel mean over the riverbed particles around it (M83),
//!
//! ```text
//! d = Σ W d_j / Σ W        q = Σ W q_j / Σ W        η = Σ_wet W η_j / Σ_wet W        z_b = Σ W z_j / Σ W
//! ```
//!
//! and η not below z_b, where a gauge on a bank sees only the lower of its particles wet,
//! with the cubic B-spline of h = 0.75 spacings (support 1.5 spacings, at least the four nearest particles), the particles
//! beyond a wall left out, and so those of a levee, a dam or a raised building where the gauge stands beside it, or those beside it
//! where the gauge stands on it: water at its foot is none on its crest. So are the cells below an upright bank of the terrain itself, a
//! quay, on which the gauge stands, as long as their water stands below its ground. There is one where the terrain's pixels step upright
//! in the square of three cells about the gauge, by the rule of the bed (M5); the largest step among the ground of these nine cells, all
//! with terrain, parts its top from its foot. The other way round, at the foot of the bank, d, q and z_b are those of the cells at the foot
//! alone, and η takes in the cells on the bank once the water of the gauge's
//! cell stands above their ground: the ground of a quay is no part of the depth of the harbour. A gauge between two cells does not depend on which of them
//! happens to hold it, and particles that move and that rest are read alike. Samples are interpolated in time between compute steps; maxima and arrival follow every
//! compute step, by the rules of the maps.

use super::frames::{Schedule, share_of_step};
use super::maxima::{Maxima, arrival_depth};
use super::tracers::{Tracers, concentration_at};
use super::{Gauge, WET_DEPTH};
use crate::lattice::{Lattice, WaterInCell, WaterOnLattice};
use crate::math::{Vec2, segments_cross};

/// The water at one gauge at one moment.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
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
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct GaugeResult {
    /// Bed elevation (m).
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
#[derive(Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct GaugeRecorder {
    readings: Vec<Option<Reading>>,
    arrival_rule: ArrivalRule,
    schedule: Schedule,
    samples: Vec<GaugeSample>,
    /// Of each sample the concentrations of the tracers.
    concentrations: Vec<Vec<f64>>,
}

/// The depth that counts as arrival: the first threshold, or a rise where there was water at the start.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct ArrivalRule {
    pub threshold: f64,
    pub rise_on_wet: f64,
}

/// What keeps a gauge from the water of a cell beside it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parting<'a> {
    /// Walls, and lines that cells follow, as straight pieces in local coordinates (m).
    pub walls: [&'a [[Vec2; 2]]; 2],
    /// Cells that stand out of their terrain; ascending.
    pub raised: &'a [usize],
    /// Cells of gauges beside which the terrain has an upright bank; ascending.
    pub at_banks: &'a [usize],
}

impl Parting<'_> {
    /// Whether the way between two cells (local coordinates, m) leads over a wall, or onto what is raised or down from it.
    fn parts(self, cells: [usize; 2], way: [Vec2; 2]) -> bool {
        let [here, there] = cells.map(|cell| self.raised.binary_search(&cell).is_ok());
        here != there || self.walls.into_iter().flatten().any(|&wall| segments_cross(way, wall))
    }
}

/// Where a gauge reads, and what it has seen so far.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
struct Reading {
    /// Cells and their weights, which sum to 1.
    weights: Vec<(usize, f64)>,
    /// The cell that holds the gauge.
    home: usize,
    /// Whether the terrain has an upright bank there.
    is_at_bank: bool,
    /// Level (m) below which the ground of a cell lies beneath the bank on which the gauge stands; lowest of all where there is none.
    foot: f64,
    /// Level (m) above which the ground of a cell lies on a bank at whose foot the gauge stands; highest of all where there is none.
    brink: f64,
    initial_depth: f64,
    last_depth: f64,
    result: GaugeResult,
}

/// Kernel means at one moment.
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    depth: f64,
    level: Option<f64>,
    velocity: Vec2,
}

impl GaugeRecorder {
    pub(super) fn new(
        gauges: &[Gauge],
        (lattice, smoothing): (&Lattice, f64),
        bed_elevation: &[f64],
        parting: Parting<'_>,
        arrival_rule: ArrivalRule,
        schedule: Schedule,
    ) -> Self {
        let reading = |gauge: &Gauge| {
            Reading::new(lattice.to_local(gauge.position), (lattice, smoothing), bed_elevation, parting)
        };
        GaugeRecorder {
            readings: gauges.iter().map(reading).collect(),
            arrival_rule,
            schedule,
            samples: Vec::new(),
            concentrations: Vec::new(),
        }
    }

    /// Takes a bed (m) that has changed in a cell.
    pub(super) fn set_bed(&mut self, cell: usize, bed_elevation: &[f64]) {
        for reading in self.readings.iter_mut().flatten() {
            if reading.weights.iter().any(|(near, _)| *near == cell) {
                reading.set_bed(bed_elevation);
            }
        }
    }

    /// Takes the water over a bed (m) after a compute step from one time to another (s); `maxima` still holds the step before. The
    /// first call, at time 0, has no length.
    pub(super) fn step(
        &mut self,
        (before, after): (f64, f64),
        bed: &[f64],
        (maxima, tracers): (&Maxima, &Tracers),
        water: &WaterOnLattice<'_>,
    ) {
        let now = |cell: usize| water.at(cell);
        while let Some(time) = self.schedule.due(after) {
            let share = share_of_step(time, before, after);
            let between = |cell: usize| maxima.previous(cell).towards(now(cell), share);
            let amounts = |which: usize, cell: usize| {
                let (before, now) = (maxima.previous(cell).depth, concentration_at(water, which, cell));
                tracers.between(which, cell, share, before, now)
            };
            for (gauge, reading) in self.readings.iter().enumerate() {
                if let Some(reading) = reading {
                    let mean = reading.mean(bed, between);
                    let (velocity_x, velocity_y) = (mean.velocity.x, mean.velocity.y);
                    self.samples.push(GaugeSample {
                        gauge,
                        time,
                        depth: mean.depth,
                        level: mean.level,
                        velocity_x,
                        velocity_y,
                    });
                    // The amount takes the place of the discharge to the east.
                    let mean = |which: usize| reading.mean(bed, |cell| amounts(which, cell));
                    let read = |mean: Mean| if mean.level.is_some() { mean.velocity.x } else { f64::NAN };
                    self.concentrations.push((0..tracers.plans().len()).map(|which| read(mean(which))).collect());
                }
            }
        }
        for reading in self.readings.iter_mut().flatten() {
            let mean = reading.mean(bed, now);
            reading.follow(before, after, mean, self.arrival_rule);
        }
    }

    /// What each gauge saw, the samples, and the concentrations of each of these.
    pub(super) fn finish(self) -> (Vec<GaugeResult>, Vec<GaugeSample>, Vec<Vec<f64>>) {
        let result = |reading: Option<Reading>| reading.map(|reading| reading.result).unwrap_or_default();
        (self.readings.into_iter().map(result).collect(), self.samples, self.concentrations)
    }
}

impl Reading {
    /// The cells around a place (local coordinates, m), read with a smoothing length (spacings); none without terrain there.
    fn new(
        place: Vec2,
        (lattice, smoothing): (&Lattice, f64),
        bed_elevation: &[f64],
        parting: Parting<'_>,
    ) -> Option<Self> {
        let home = lattice.cell_of(place).filter(|&cell| !bed_elevation[cell].is_nan())?;
        let square = |place: f64, count: usize| ((place / lattice.spacing).max(0.0) as usize).min(count - 1);
        // A gauge is read on the finest level.
        let (column, row) = (square(place.x, lattice.columns), square(place.y, lattice.rows));
        let mut near = vec![home];
        for near_row in row.saturating_sub(1)..=(row + 1).min(lattice.rows - 1) {
            let columns = column.saturating_sub(1)..=(column + 1).min(lattice.columns - 1);
            near.extend(columns.map(|near_column| lattice.leaf(near_column, near_row)));
        }
        near.sort_unstable();
        near.dedup();
        let h = smoothing * lattice.spacing;
        let mut weights = Vec::new();
        for cell in near {
            let centre = lattice.centre(cell);
            let is_parted = || parting.parts([home, cell], [place, centre]);
            if !bed_elevation[cell].is_nan() && (cell == home || !is_parted()) {
                weights.push((cell, weight((centre - place).norm() / h)));
            }
        }
        let sum: f64 = weights.iter().map(|(_, weight)| weight).sum();
        for (_, weight) in &mut weights {
            *weight /= sum;
        }
        let result = GaugeResult { max_depth: Some(0.0), max_speed: Some(0.0), ..GaugeResult::default() };
        let (foot, brink) = (f64::NEG_INFINITY, f64::INFINITY);
        let is_at_bank = parting.at_banks.binary_search(&home).is_ok();
        let mut reading =
            Reading { weights, home, is_at_bank, foot, brink, initial_depth: 0.0, last_depth: 0.0, result };
        reading.set_bed(bed_elevation);
        Some(reading)
    }

    /// Takes the bed (m) of its cells.
    fn set_bed(&mut self, bed_elevation: &[f64]) {
        let own = bed_elevation[self.home];
        let grounds = || self.weights.iter().map(|&(cell, _)| bed_elevation[cell]).collect();
        (self.foot, self.brink) = (f64::NEG_INFINITY, f64::INFINITY);
        if let Some([foot, top]) = self.is_at_bank.then(|| largest_step(grounds())).flatten() {
            if own >= top {
                self.foot = top;
            } else {
                self.brink = foot;
            }
        }
        let (mut bed, mut left_out) = (0.0, 0.0);
        for &(cell, weight) in &self.weights {
            if bed_elevation[cell] > self.brink {
                left_out += weight;
            } else {
                bed += weight * bed_elevation[cell];
            }
        }
        self.result.bed = Some(if left_out > 0.0 { bed / (1.0 - left_out) } else { bed });
    }

    fn bed(&self) -> f64 {
        self.result.bed.unwrap_or(f64::NEG_INFINITY)
    }

    /// The kernel means of the water that `at` gives for a cell.
    fn mean(&self, bed_elevation: &[f64], at: impl Fn(usize) -> WaterInCell) -> Mean {
        let (mut depth, mut discharge) = (0.0, Vec2::ZERO);
        let (mut level, mut wet, mut left_out) = (0.0, 0.0, 0.0);
        let own = bed_elevation[self.home];
        let here = own + at(self.home).depth;
        for &(cell, weight) in &self.weights {
            let (water, ground) = (at(cell), bed_elevation[cell]);
            let is_at_foot = ground < self.foot && ground + water.depth < own;
            let is_on_bank = ground > self.brink;
            if is_at_foot || is_on_bank {
                left_out += weight;
            } else {
                depth += weight * water.depth;
                discharge += Vec2::new(water.discharge_x, water.discharge_y) * weight;
            }
            let is_of_level = !is_at_foot && (!is_on_bank || here >= ground);
            if is_of_level && water.depth > WET_DEPTH {
                level += weight * (ground + water.depth);
                wet += weight;
            }
        }
        if left_out > 0.0 {
            (depth, discharge) = (depth / (1.0 - left_out), discharge / (1.0 - left_out));
        }
        let is_wet = depth > WET_DEPTH && wet > 0.0;
        Mean {
            depth,
            level: is_wet.then(|| (level / wet).max(self.bed())),
            velocity: if is_wet { discharge / depth } else { Vec2::ZERO },
        }
    }

    /// Keeps maxima and arrival.
    fn follow(&mut self, before: f64, after: f64, now: Mean, rule: ArrivalRule) {
        let is_start = after <= before;
        if is_start {
            self.initial_depth = now.depth;
            self.last_depth = now.depth;
        }
        let result = &mut self.result;
        let wanted = arrival_depth(rule.threshold, self.initial_depth, rule.rise_on_wet);
        if result.arrival.is_none() && now.depth >= wanted {
            let share = share_of_step(wanted, self.last_depth, now.depth);
            result.arrival = Some(before + share * (after - before));
        }
        if now.depth > WET_DEPTH && result.max_depth.is_none_or(|greatest| now.depth > greatest) {
            result.max_depth = Some(now.depth);
            result.time_of_max = Some(after);
        }
        if let Some(level) = now.level {
            result.max_level = Some(result.max_level.map_or(level, |greatest| greatest.max(level)));
        }
        let speed = now.velocity.norm();
        result.max_speed = result.max_speed.map(|greatest| greatest.max(speed));
        self.last_depth = now.depth;
    }
}

/// Cells around a gauge and its own.
const ALL_AROUND: usize = 9;

/// The ground (m) below and above the largest step among all around a gauge; none where it is not known all around.
fn largest_step(mut grounds: Vec<f64>) -> Option<[f64; 2]> {
    if grounds.len() < ALL_AROUND {
        return None;
    }
    grounds.sort_by(f64::total_cmp);
    let steps = grounds.windows(2).map(|pair| [pair[0], pair[1]]);
    steps.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))
}

/// The cubic B-spline over its value in the middle, at q = r/h.
fn weight(q: f64) -> f64 {
    0.25 * (2.0 - q).max(0.0).powi(3) - (1.0 - q).max(0.0).powi(3)
}
