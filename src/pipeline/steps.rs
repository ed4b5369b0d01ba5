//! The loop of steps, and its end at a signal.

use std::ops::ControlFlow;

use super::cores::Core;
use super::progress::{Progress, StepStatistics};
use super::recorders::Recorders;
use super::records::{balance, breach_record, moving_bed_record, tracer_balances};
use super::verdict::stopped;
use super::{Early, Run};
use crate::scenario::Part;
use crate::solver::{FlowSolver, StepChoice, StepLimit};

impl Run<'_> {
    /// Computes to the end of the run, or to what ends it early; breaks off with a larger part of the terrain once water comes near the edge of
    /// the one that was prepared.
    pub(super) fn compute(
        &mut self,
        core: &mut Core,
        recorders: &mut Recorders,
        mut steps: StepStatistics,
        progress: &mut Progress,
    ) -> ControlFlow<Part, Option<Early>> {
        let end = self.scenario.end_time;
        self.before.particles.get_or_insert_with(|| core.as_flow().particles());
        let mut early = self.is_for_outputs.then_some(Early::NoStep);
        let sides = self.sides.take();
        while early.is_none() && core.as_flow().time() < end {
            let (solver, clock) = (core.flow(), &mut self.clock);
            clock.part("rest");
            let choice = step_towards(end, solver);
            clock.skip();
            let is_frame_due = recorders.before_step(choice.time_step, solver, clock);
            if let Err(failure) = solver.advance(choice.time_step) {
                early = Some(Early::Failed(failure));
                break;
            }
            clock.skip();
            steps.count(&choice, solver.particles());
            let is_record_due = solver.is_record_due(end);
            if let Err(error) = recorders.after(solver, is_record_due.then_some(is_frame_due), clock) {
                early = Some(Early::Unwritten(error));
                break;
            }
            if let Some(error) = self.room.shortage(is_frame_due) {
                early = Some(Early::Unwritten(error));
                break;
            }
            let received = self.signals.received();
            if received == 0
                && let Some(wider) = sides.as_ref().and_then(|sides| sides.beyond(solver))
            {
                progress.end();
                self.manifest.simulated_s = solver.time();
                return ControlFlow::Break(wider);
            }
            progress.show((solver.time(), solver.particles()), &choice, || balance(solver).error_relative);
            if received != 0 || self.checkpoints.is_due() {
                self.keep(core, recorders, &steps);
                self.clock.part("checkpoints");
            }
            if received != 0 {
                early = Some(self.stop(core, recorders, (is_record_due, received)));
            }
        }
        progress.end();
        self.manifest.volume_m3.held_back = self.pits.as_ref().map(|pits| pits.now(core.flow()));
        let (solver, clock) = (core.as_flow(), &mut self.clock);
        clock.part("rest");
        for (phase, time) in solver.phases().times() {
            clock.add(phase, time.wall);
        }
        steps.note(&mut self.manifest);
        self.note_computed(solver, recorders);
        ControlFlow::Continue(early)
    }

    /// Stops at a signal, once the checkpoint is written: says so in `run.json`, and takes the water of now for the maps.
    fn stop(&mut self, core: &mut Core, recorders: &mut Recorders, (is_recorded, received): (bool, usize)) -> Early {
        let solver = core.flow();
        self.manifest.simulated_s = solver.time();
        let stopped = stopped(&self.folder, solver.time(), received as i32);
        self.manifest.ended("stopped", stopped.exit_code() as u8);
        let written = self.manifest.write(&self.folder).and_then(|()| {
            // Not in the checkpoint: a run that is never stopped does not record here.
            if is_recorded { Ok(()) } else { recorders.record(solver, true, &mut self.clock) }
        });
        written.map_or_else(Early::Unwritten, |()| Early::Signal(received as i32))
    }

    /// Writes into the manifest what the core did.
    fn note_computed(&mut self, solver: &dyn FlowSolver, recorders: &Recorders) {
        let (manifest, forcing) = (&mut self.manifest, &self.scene.forcing);
        manifest.particles.initial = self.before.particles.unwrap_or_default();
        manifest.particles.peak = manifest.particles.peak.max(manifest.particles.initial);
        manifest.steps = solver.steps();
        manifest.particle_evaluations = solver.particle_evaluations();
        manifest.particles.last = solver.particles();
        manifest.simulated_s = solver.time();
        manifest.discharges = recorders.discharges.record();
        manifest.tracers = tracer_balances(solver, recorders.plane.tracers());
        manifest.breach = forcing.breach.as_ref().map(|breach| breach_record(breach, solver.breach_began()));
        manifest.moving_bed = moving_bed_record(&forcing.moving_bed, solver);
    }
}

/// The step that the core chooses, cut at the end of the run (s).
pub(super) fn step_towards(end: f64, solver: &mut dyn FlowSolver) -> StepChoice {
    let choice = solver.choose_step();
    if solver.time() + choice.time_step >= end {
        return StepChoice { time_step: end - solver.time(), limit: StepLimit::EndOfRun, ..choice };
    }
    choice
}
