//! Follows a run step by step and keeps what becomes its maps, frames, gauge series and mass balance.

use std::collections::BTreeMap;

use super::closed_edge::{ClosedEdge, ClosedFace};
use super::frames::{Frame, MassBalanceRow, Schedule, Volumes, share_of_step};
use super::gauges::{ArrivalRule, GaugeRecorder, Parting};
use super::grid::{GridMaps, OutputGrid, greatest_level};
use super::growth::GrowthRecorder;
use super::maxima::Maxima;
use super::on_terrain::{OnTerrain, WaterOfCells};
use super::recording::Recording;
use super::tracers::{TracerPlan, Tracers, concentration_at};
use super::{Gauge, TerrainPixels, WET_DEPTH};
use crate::bed::PassSills;
use crate::constants::OutputConstants;
use crate::error::Error;
use crate::lattice::{Lattice, Span, WaterInCell, WaterOnLattice};
use crate::math::Vec2;

/// What to record, and where.
#[derive(Clone, Debug)]
pub struct RecorderPlan {
    /// The lattice of the run.
    pub lattice: Lattice,
    /// Bed elevation (m) of its cells; NaN where there is no terrain.
    pub bed_elevation: Vec<f64>,
    /// Cells whose water has another area than a cell has, ascending, and how much more (m²).
    pub more_area: Vec<(usize, f64)>,
    /// Edge of a cell of the output grid (m).
    pub cell: f64,
    /// The terrain's own raster and the pass sills of the lattice, where the maps are on that raster.
    pub terrain: Option<(TerrainPixels, PassSills)>,
    /// Depths (m) for which arrival, duration and recession are followed; at least one.
    pub thresholds: Vec<f64>,
    /// Rise above the initial level (m) that counts as arrival on ground that was wet at the start.
    pub rise_on_wet: f64,
    /// Interval of the frames (s).
    pub every: f64,
    /// End of the run (s).
    pub end_time: f64,
    /// Gauges.
    pub gauges: Vec<Gauge>,
    /// Walls as straight pieces in local coordinates (m): a gauge does not read beyond them.
    pub walls: Vec<[Vec2; 2]>,
    /// Lines that cells follow (local coordinates, m): a gauge reads on its own side of them.
    pub followed: Vec<[Vec2; 2]>,
    /// Cells that stand out of their terrain, such as those of a levee; ascending. A gauge reads them alone or the ground alone.
    pub raised: Vec<usize>,
    /// Cells of gauges about which the terrain has an upright bank; ascending. A gauge reads the cells on it or those at its foot.
    pub at_banks: Vec<usize>,
    /// The constants of the readings.
    pub constants: OutputConstants,
    /// Interval of the gauge series (s).
    pub gauges_every: f64,
    /// Of each cross-section the cells that it crosses.
    pub sections: Vec<Vec<usize>>,
    /// The closed edge of the terrain.
    pub closed_edge: Vec<ClosedFace>,
    /// What is carried with the water.
    pub tracers: Vec<TracerPlan>,
}

/// Where frames go: usually [`FieldsWriter::push`](super::FieldsWriter::push).
pub type FrameSink<'a> = dyn FnMut(Frame) -> Result<(), Error> + 'a;

/// Records a run; see the fields of [`Recording`] for what comes out.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
pub struct Recorder {
    bed_elevation: Vec<f64>,
    lattice: Lattice,
    more_area: Vec<(usize, f64)>,
    grid: OutputGrid,
    /// Where the maps are on the terrain's own raster.
    terrain: Option<OnTerrain>,
    /// Cells whose bed may change, and the greatest level (m) that they saw.
    highest: BTreeMap<usize, f64>,
    /// Their bed (m) at the start.
    bed_at_start: BTreeMap<usize, f64>,
    maxima: Maxima,
    tracers: Tracers,
    frames: Schedule,
    gauges: GaugeRecorder,
    sections: Vec<Vec<usize>>,
    closed_edge: Vec<ClosedFace>,
    growth: GrowthRecorder,
    mass_balance: Vec<MassBalanceRow>,
    previous_volumes: Volumes,
    time: f64,
    has_frames: bool,
    has_maps: bool,
}

impl Recorder {
    /// A recorder that has seen nothing yet.
    pub fn new(plan: RecorderPlan) -> Self {
        let RecorderPlan { lattice, bed_elevation, cell, terrain, thresholds, rise_on_wet, .. } = plan;
        let gauge_schedule = Schedule::new(plan.gauges_every, plan.end_time);
        Recorder {
            more_area: plan.more_area,
            grid: OutputGrid::new(&lattice, cell, &bed_elevation),
            terrain: terrain.map(|(pixels, passes)| OnTerrain::new(lattice.clone(), pixels, passes, &plan.walls)),
            highest: BTreeMap::new(),
            bed_at_start: BTreeMap::new(),
            maxima: Maxima::new(lattice.len(), lattice.columns, &thresholds, rise_on_wet),
            tracers: Tracers::new(plan.tracers, &lattice),
            frames: Schedule::new(plan.every, plan.end_time),
            gauges: GaugeRecorder::new(
                &plan.gauges,
                (&lattice, plan.constants.gauge_smoothing),
                &bed_elevation,
                Parting { walls: [&plan.walls, &plan.followed], raised: &plan.raised, at_banks: &plan.at_banks },
                ArrivalRule { threshold: thresholds[0], rise_on_wet },
                gauge_schedule,
            ),
            sections: plan.sections,
            closed_edge: plan.closed_edge,
            growth: GrowthRecorder::new(plan.end_time),
            mass_balance: Vec::new(),
            previous_volumes: Volumes::default(),
            bed_elevation,
            lattice,
            time: 0.0,
            has_frames: true,
            has_maps: true,
        }
    }

    /// Draws no frames: the water balance has the volume on the grid alone.
    pub fn leave_out_frames(&mut self) {
        self.has_frames = false;
    }

    /// Keeps no maxima and draws no maps. To be called before the start.
    pub fn leave_out_maps(&mut self) {
        self.has_maps = false;
        // The water arrives at a section when it arrives at its cells.
        if self.sections.is_empty() {
            self.maxima.leave_out();
        }
    }

    /// The tracers.
    pub fn tracers(&self) -> &[TracerPlan] {
        self.tracers.plans()
    }

    /// How many frames fell due, and were handed out unless frames are left out.
    pub fn frames(&self) -> usize {
        self.mass_balance.len()
    }

    /// The grid of the frames.
    pub fn grid(&self) -> &OutputGrid {
        &self.grid
    }

    /// The grid of the maps.
    pub fn grid_of_maps(&self) -> &OutputGrid {
        self.terrain.as_ref().map_or(&self.grid, OnTerrain::grid)
    }

    /// Whether a frame lies at or before a time (s): then [`step`](Self::step) needs the balances at both ends of the step to it.
    pub fn is_frame_due(&self, time: f64) -> bool {
        self.frames.next_until(time).is_some()
    }

    /// Takes the water balance of the moment up to which was recorded, before a step for which a frame is due.
    pub fn set_balance(&mut self, volumes: Volumes) {
        self.previous_volumes = volumes;
    }

    /// Takes the bed (m) of the cells where it may change. To be called before the water of the same moment is taken; a level
    /// within the step before counts from the bed at its end.
    pub fn set_bed(&mut self, cells: &[(usize, f64)]) {
        // The same cells come with every step.
        if self.highest.len() < cells.len() {
            self.highest.extend(cells.iter().map(|(cell, _)| (*cell, f64::NEG_INFINITY)));
            let before = cells.iter().map(|(cell, _)| (*cell, self.bed_elevation[*cell]));
            self.bed_at_start.extend(before);
        }
        for &(cell, elevation) in cells {
            if self.bed_elevation[cell].to_bits() != elevation.to_bits() {
                self.bed_elevation[cell] = elevation;
                self.gauges.set_bed(cell, &self.bed_elevation);
            }
        }
    }

    /// Follows the greatest level where the bed may change.
    fn follow_levels(&mut self, water: &WaterOnLattice<'_>) {
        for (&cell, highest) in &mut self.highest {
            let depth = water.at(cell).depth;
            if depth > WET_DEPTH {
                *highest = highest.max(self.bed_elevation[cell] + depth);
            }
        }
    }

    /// Takes the water at time 0 and hands out the first frame.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn start(
        &mut self,
        water: &WaterOnLattice<'_>,
        volumes: Volumes,
        sink: &mut FrameSink<'_>,
    ) -> Result<(), Error> {
        self.maxima.start(0.0, water);
        if self.has_maps {
            self.growth.start(&self.maxima, &self.lattice);
        }
        self.tracers.step(0.0, 0.0, &self.maxima, water);
        self.follow_levels(water);
        self.previous_volumes = volumes;
        self.gauges.step((0.0, 0.0), &self.bed_elevation, (&self.maxima, &self.tracers), water);
        self.hand_out_frames(0.0, water, Some(volumes), sink)
    }

    /// Takes the water after one compute step that ended at `time_after` (s), and the water balance of that moment where a frame
    /// is due; hands out the frames that fell due.
    ///
    /// # Errors
    /// Those of the sink, and an internal one where a frame is due without a balance.
    pub fn step(
        &mut self,
        time_after: f64,
        water: &WaterOnLattice<'_>,
        volumes: impl Into<Option<Volumes>>,
        sink: &mut FrameSink<'_>,
    ) -> Result<(), Error> {
        let volumes = volumes.into();
        self.gauges.step((self.time, time_after), &self.bed_elevation, (&self.maxima, &self.tracers), water);
        // A frame that cannot be written costs no maxima.
        let handed_out = self.hand_out_frames(time_after, water, volumes, sink);
        self.tracers.step(self.time, time_after, &self.maxima, water);
        self.maxima.step(self.time, time_after, water);
        if self.has_maps {
            self.growth.step(time_after, &self.maxima, &self.lattice);
        }
        self.follow_levels(water);
        self.previous_volumes = volumes.unwrap_or(self.previous_volumes);
        self.time = time_after;
        handed_out
    }

    /// What the run left behind, up to the last step taken.
    pub fn finish(self) -> Recording {
        let (gauge_results, gauge_samples, gauge_concentrations) = self.gauges.finish();
        let arrivals = |cells: &Vec<usize>| {
            let arrivals = cells.iter().map(|&cell| self.maxima.seen_of_threshold(cell, 0, self.time).arrival);
            arrivals.filter(|arrival| !arrival.is_nan()).min_by(f64::total_cmp)
        };
        let section_arrivals = self.sections.iter().map(arrivals).collect();
        let faces = if self.has_maps { &self.closed_edge[..] } else { &[] };
        let closed_edge = ClosedEdge::seen(faces, &self.maxima, self.time);
        let growth = if self.has_maps { self.growth.at_end(self.time, &self.maxima, &self.lattice) } else { None };
        let maps = match self.terrain {
            _ if !self.has_maps => GridMaps::default(),
            None => GridMaps {
                tracers: self.grid.maps_of_tracers(&self.bed_elevation, &self.tracers),
                ..self.grid.maps(&self.maxima, self.time, &self.bed_elevation, &self.highest)
            },
            Some(terrain) => terrain.maps(&WaterOfCells {
                bed: &self.bed_elevation,
                bed_at_start: &self.bed_at_start,
                level: &|cell| greatest_level(&self.maxima, &self.bed_elevation, &self.highest, cell),
                seen: &|cell| self.maxima.seen(cell),
                thresholds: self.maxima.thresholds(),
                seen_of_threshold: &|cell, which| self.maxima.seen_of_threshold(cell, which, self.time),
                tracers: &self.tracers,
            }),
        };
        Recording {
            end_time: self.time,
            maps,
            gauge_results,
            gauge_samples,
            gauge_concentrations,
            tracers: self.tracers.plans().to_vec(),
            section_arrivals,
            mass_balance: self.mass_balance,
            closed_edge,
            growth,
        }
    }

    fn hand_out_frames(
        &mut self,
        time_after: f64,
        water: &WaterOnLattice<'_>,
        volumes: Option<Volumes>,
        sink: &mut FrameSink<'_>,
    ) -> Result<(), Error> {
        while let Some(time) = self.frames.due(time_after) {
            let volumes =
                volumes.ok_or_else(|| Error::Internal(format!("the frame at {time} s has no water balance")))?;
            let share = share_of_step(time, self.time, time_after);
            let rows = |row: usize, cells: &mut [WaterInCell]| self.row_between(share, water, row, cells);
            let frame = self.has_frames.then(|| Frame {
                concentrations: self.concentrations(share, water),
                ..self.grid.frame(time, &self.bed_elevation, rows)
            });
            let grid_volume = match &frame {
                Some(frame) => self.grid.volume(&frame.depth),
                None => self.grid.volume_of(&self.bed_elevation, rows),
            };
            let grid_volume = grid_volume + self.volume_in_part(share, water);
            let volumes = self.previous_volumes.between(&volumes, share);
            self.mass_balance.push(MassBalanceRow { time, volumes, grid_volume });
            frame.map_or(Ok(()), &mut *sink)?;
        }
        Ok(())
    }

    /// The concentrations of the tracers on the grid, `share` of the way from the step before to this one.
    fn concentrations(&self, share: f64, water: &WaterOnLattice<'_>) -> Vec<Vec<f32>> {
        let of = |which: usize| {
            let rows = |row: usize, cells: &mut [WaterInCell]| {
                for (column, cell) in cells.iter_mut().enumerate() {
                    let leaf = self.lattice.leaf(column, row);
                    let (of_leaf, now) = (self.lattice.column_row(leaf), concentration_at(water, which, leaf));
                    let is_followed = holds(water.spans_of_row(of_leaf.1), of_leaf.0);
                    let before = if is_followed { self.maxima.previous(leaf).depth } else { now.0 };
                    let share = if is_followed { share } else { 1.0 };
                    *cell = self.tracers.between(which, leaf, share, before, now);
                }
            };
            self.grid.concentration(&self.bed_elevation, rows)
        };
        (0..self.tracers.plans().len()).map(of).collect()
    }

    /// What cells in part hold more (m³) than whole cells of their depth would, `share` of the way from the step before to this one.
    fn volume_in_part(&self, share: f64, water: &WaterOnLattice<'_>) -> f64 {
        let more = |&(cell, area): &(usize, f64)| {
            let (column, row) = self.lattice.column_row(cell);
            let is_followed = holds(water.spans_of_row(row), column);
            let now = water.at(cell);
            area * if is_followed { self.maxima.previous(cell).towards(now, share).depth } else { now.depth }
        };
        self.more_area.iter().map(more).sum()
    }

    /// The water of a row of the lattice `share` of the way from the step before to this one.
    fn row_between(&self, share: f64, water: &WaterOnLattice<'_>, row: usize, cells: &mut [WaterInCell]) {
        if self.lattice.nest().is_some() {
            let leaves = (0..cells.len()).map(|column| self.lattice.leaf(column, row));
            cells.iter_mut().zip(leaves).for_each(|(cell, leaf)| *cell = self.leaf_between(share, water, leaf));
            return;
        }
        let now = water.rows.row(row);
        // Films that were left behind lie outside the spans: over a wide plain they are a share of the volume that counts.
        for (cell, &depth) in cells.iter_mut().zip(now.depth) {
            *cell = WaterInCell { depth, ..WaterInCell::default() };
        }
        for span in water.spans_of_row(row) {
            let (from, to) = (span.from as usize, span.to as usize);
            for (column, cell) in (from..to).zip(&mut cells[from..to]) {
                *cell = self.maxima.previous(row * self.lattice.columns + column).towards(now.at(column), share);
            }
        }
    }

    /// The water of a cell of any level `share` of the way from the step before to this one.
    fn leaf_between(&self, share: f64, water: &WaterOnLattice<'_>, cell: usize) -> WaterInCell {
        let (column, row) = self.lattice.column_row(cell);
        let now = water.at(cell);
        if holds(water.spans_of_row(row), column) {
            self.maxima.previous(cell).towards(now, share)
        } else {
            WaterInCell { depth: now.depth, ..WaterInCell::default() }
        }
    }
}

/// Whether a column lies in one of some spans in ascending order.
fn holds(spans: &[Span], column: usize) -> bool {
    let next = spans.partition_point(|span| span.to as usize <= column);
    spans.get(next).is_some_and(|span| span.from as usize <= column)
}

#[cfg(test)]
mod tests;
