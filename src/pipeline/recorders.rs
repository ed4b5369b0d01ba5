//! All that follows the water of a run from step to step: maps, frames and gauges, sections, channels, discharges.

use super::Run;
use super::channels::Channels;
use super::clock::Clock;
use super::discharges::Discharges;
use super::records::{balance, tracer_balances};
use super::stages::recorder_of;
use crate::error::Error;
use crate::output::{
    ChannelProfile, FieldsWriter, FileHead, Provenance, Recorder, RecorderPlan, SectionRecorder, TracerBalance,
};
use crate::scenario::OutputPart;
use crate::solver::FlowSolver;

/// Parts of the steps in `run.json`: the sum of all water, and what the recorder of maps, frames and gauges does.
const BALANCE: &str = "water balance";

const RECORDING: &str = "recording";

/// The recorders of a run.
pub(super) struct Recorders<'a> {
    /// Maps, frames and gauges of the plane.
    pub plane: Recorder,
    /// `fields.nc`; none where it is left out.
    pub fields: Option<FieldsWriter>,
    /// The cross-sections.
    pub sections: SectionRecorder,
    /// The channels, where there are any.
    pub channels: Option<Channels<'a>>,
    /// Whether the particles carry what passes between them.
    pub discharges: Discharges,
    /// The balance of the tracers at the frames.
    pub tracers: Vec<TracerBalance>,
}

impl<'a> Recorders<'a> {
    /// Opens the files that grow during the run; takes the water of the channels.
    pub fn open(
        run: &Run<'_>,
        profiles: &'a [ChannelProfile],
        provenance: &Provenance,
        plan: RecorderPlan,
        solver: &dyn FlowSolver,
    ) -> Result<Self, Error> {
        let Run { scenario, scene, folder, .. } = run;
        let (outputs, head) = (&scenario.outputs, FileHead { crs: &scene.crs, provenance });
        let plane = recorder_of(scenario, plan);
        let is_written = !plane.grid().is_empty() && outputs.writes(OutputPart::Fields);
        let start_fields = || FieldsWriter::start(folder, plane.grid(), head, plane.tracers());
        let fields = is_written.then(start_fields).transpose()?;
        let sections = SectionRecorder::new(scene.sections.len(), outputs.gauges_every, scenario.end_time);
        let channels = Channels::start(scenario, profiles, solver, folder, head)?;
        Ok(Recorders {
            plane,
            fields,
            sections,
            channels,
            discharges: Discharges::new(&scene.lattice),
            tracers: Vec::new(),
        })
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
    pub fn after_step(&mut self, solver: &dyn FlowSolver, clock: &mut Clock) -> Result<(), Error> {
        let passed = solver.sections().iter().map(|flow| (flow.discharge, flow.volume));
        self.sections.step(solver.time(), passed);
        if let Some(channels) = &mut self.channels {
            channels.step(solver)?;
        }
        clock.part("sections and channels");
        Ok(())
    }
}
