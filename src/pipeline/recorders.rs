//! All that follows the water of a run from step to step: maps, frames and gauges, sections, channels, discharges.

use serde::{Deserialize, Serialize};

use super::Run;
use super::channels::Channels;
use super::clock::Clock;
use super::discharges::Discharges;
use super::records::{balance, tracer_balances};
use super::stages::recorder_of;
use crate::error::Error;
use crate::output::{FieldsWriter, FileHead, Provenance, Recorder, RecorderPlan, SectionRecorder, TracerBalance};
use crate::scenario::{OutputPart, Scenario};
use crate::solver::FlowSolver;

/// Parts of the steps in `run.json`: the sum of all water, and what the recorder of maps, frames and gauges does.
const BALANCE: &str = "water balance";

const RECORDING: &str = "recording";

/// The recorders of a run.
#[derive(Deserialize, Serialize)]
pub(super) struct Recorders {
    /// Maps, frames and gauges of the plane.
    pub plane: Recorder,
    /// `fields.nc`; none where it is left out.
    #[serde(skip)]
    pub fields: Option<FieldsWriter>,
    /// The cross-sections.
    pub sections: SectionRecorder,
    /// The channels, where there are any.
    pub channels: Option<Channels>,
    /// Whether the particles carry what passes between them.
    pub discharges: Discharges,
    /// The balance of the tracers at the frames.
    pub tracers: Vec<TracerBalance>,
}

impl Recorders {
    /// Opens the files that grow during the run; takes the water of the channels.
    pub fn open(
        run: &Run<'_>,
        provenance: &Provenance,
        plan: RecorderPlan,
        solver: &dyn FlowSolver,
    ) -> Result<Self, Error> {
        let Run { scenario, scene, folder, .. } = run;
        let (outputs, head) = (&scenario.outputs, FileHead { crs: &scene.crs, provenance });
        let plane = recorder_of(scenario, plan);
        let start_fields = || FieldsWriter::start(folder, plane.grid(), head, plane.tracers(), 0);
        let fields = Self::has_fields(&plane, scenario).then(start_fields).transpose()?;
        let sections = SectionRecorder::new(scene.sections.len(), outputs.gauges_every, scenario.end_time);
        let channels = Channels::start(scenario, &scene.channels, solver, folder, head)?;
        Ok(Recorders {
            plane,
            fields,
            sections,
            channels,
            discharges: Discharges::new(&scene.lattice),
            tracers: Vec::new(),
        })
    }

    /// Opens the files again of a run that goes on from a checkpoint.
    pub fn reopen(&mut self, run: &Run<'_>, provenance: &Provenance) -> Result<(), Error> {
        let Run { scenario, scene, folder, .. } = run;
        let head = || FileHead { crs: &scene.crs, provenance };
        let plane = &self.plane;
        let start = || FieldsWriter::start(folder, plane.grid(), head(), plane.tracers(), plane.frames());
        self.fields = Self::has_fields(plane, scenario).then(start).transpose()?;
        self.channels.as_mut().map_or(Ok(()), |channels| channels.reopen(scenario, folder, head()))
    }

    fn has_fields(plane: &Recorder, scenario: &Scenario) -> bool {
        !plane.grid().is_empty() && scenario.outputs.writes(OutputPart::Fields)
    }

    /// Waits until all that was handed to files is on the disk.
    pub fn settle(&mut self) -> Result<(), Error> {
        self.fields.as_mut().map_or(Ok(()), FieldsWriter::settle)?;
        self.channels.as_ref().map_or(Ok(()), Channels::settle)
    }

    /// Takes the water of the plane at the start.
    pub fn start(&mut self, solver: &mut dyn FlowSolver, clock: &mut Clock) -> Result<(), Error> {
        let Recorders { plane, fields, tracers, .. } = self;
        plane.set_bed(solver.bed_now());
        tracers.extend(tracer_balances(solver, plane.tracers()));
        let mut push = |frame| fields.as_mut().map_or(Ok(()), |fields| fields.push(frame));
        let volumes = balance(solver);
        // What the core measured of its own start.
        clock.part("start");
        clock.add("start", -solver.phases().times().iter().map(|(_, time)| time.wall).sum::<f64>());
        plane.start(&solver.water(), volumes, &mut push)?;
        clock.part(RECORDING);
        Ok(())
    }

    /// Takes the volume balance before a step of this length (s), where a frame lies within it; whether the record after the step needs it.
    pub fn before_step(&mut self, time_step: f64, solver: &dyn FlowSolver, clock: &mut Clock) -> bool {
        // Frames lie between two records, and need the water balance of both.
        let is_each_step_recorded = solver.steps_of_a_record() == 1;
        let is_frame_due = !is_each_step_recorded || self.plane.is_frame_due(solver.time() + time_step);
        if is_frame_due && is_each_step_recorded {
            self.plane.set_balance(balance(solver));
            clock.part(BALANCE);
        }
        is_frame_due
    }

    /// Takes the water after a step; that of the plane where it is recorded, with or without its balance.
    pub fn after(
        &mut self,
        solver: &mut dyn FlowSolver,
        is_recorded: Option<bool>,
        clock: &mut Clock,
    ) -> Result<(), Error> {
        let recorded = is_recorded.map_or(Ok(()), |needs_balance| self.record(solver, needs_balance, clock));
        let stepped = self.after_step(solver, clock);
        recorded.and(stepped)
    }

    /// Takes the water of the plane at a record.
    pub fn record(&mut self, solver: &mut dyn FlowSolver, needs_balance: bool, clock: &mut Clock) -> Result<(), Error> {
        let Recorders { plane, fields, discharges, tracers, .. } = self;
        let time = solver.time();
        plane.set_bed(solver.bed_now());
        clock.part("rest");
        let volumes = needs_balance.then(|| balance(solver));
        if plane.is_frame_due(time) {
            discharges.add(time, solver.discharges());
            tracers.extend(tracer_balances(solver, plane.tracers()));
        }
        clock.part(BALANCE);
        let water = solver.water();
        clock.skip();
        let mut push = |frame| fields.as_mut().map_or(Ok(()), |fields| fields.push(frame));
        plane.step(time, &water, volumes, &mut push)?;
        clock.part(RECORDING);
        Ok(())
    }

    /// Takes what passed the sections and the water of the channels after a step.
    fn after_step(&mut self, solver: &dyn FlowSolver, clock: &mut Clock) -> Result<(), Error> {
        let passed = solver.sections().iter().map(|flow| (flow.discharge, flow.volume));
        self.sections.step(solver.time(), passed);
        if let Some(channels) = &mut self.channels {
            channels.step(solver)?;
        }
        clock.part("sections and channels");
        Ok(())
    }
}
