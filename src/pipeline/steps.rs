//! The loop of steps, and the signals that end it.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use super::progress::{Progress, StepStatistics};
use super::recorders::Recorders;
use super::records::{balance, breach_record, moving_bed_record, tracer_balances};
use super::{Early, Run};
use crate::error::Error;
use crate::scenario::Part;
use crate::solver::{FlowSolver, StepChoice, StepLimit};

impl Run<'_> {
    /// Computes to the end of the run, or to what ends it early; breaks off with a larger part of the terrain once water comes near the edge of
    /// the one that was prepared.
    pub(super) fn compute(
        &mut self,
        solver: &mut dyn FlowSolver,
        recorders: &mut Recorders<'_>,
        progress: &mut Progress,
    ) -> Result<ControlFlow<Part, Option<Early>>, Error> {
        let signal = Arc::clone(&self.signal);
        let end = self.scenario.end_time;
        let clock = &mut self.clock;
        self.manifest.particles.initial = solver.particles();
        recorders.start(solver, clock)?;
        let mut steps = StepStatistics::default();
        let mut early = None;
        let sides = self.sides.take();
        while solver.time() < end {
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
            let received = signal.load(Ordering::Relaxed);
            if solver.is_record_due(end) || received != 0 {
                recorders.record(solver, is_frame_due, clock)?;
            }
            recorders.after_step(solver, clock)?;
            if received == 0
                && let Some(wider) = sides.as_ref().and_then(|sides| sides.beyond(solver))
            {
                progress.end();
                self.manifest.simulated_s = solver.time();
                return Ok(ControlFlow::Break(wider));
            }
            progress.show((solver.time(), solver.particles()), &choice, || balance(solver).error_relative);
            if received != 0 {
                early = Some(Early::Signal(received as i32));
                break;
            }
        }
        progress.end();
        clock.part("rest");
        for (phase, time) in solver.phases().times() {
            clock.add(phase, time.wall);
        }
        steps.note(&mut self.manifest);
        self.note_computed(solver, recorders);
        Ok(ControlFlow::Continue(early))
    }

    /// Writes into the manifest what the core did.
    fn note_computed(&mut self, solver: &dyn FlowSolver, recorders: &Recorders<'_>) {
        let (manifest, forcing) = (&mut self.manifest, &self.scene.forcing);
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

/// A cell that holds the number of SIGHUP, SIGINT or SIGTERM once it came, 0 before.
pub(super) fn watch_signals() -> Result<Arc<AtomicUsize>, Error> {
    let received = Arc::new(AtomicUsize::new(0));
    let hang_up = Some(SIGHUP).filter(|_| is_stopped_by_hang_up());
    for signal in [SIGINT, SIGTERM].into_iter().chain(hang_up) {
        signal_hook::flag::register_usize(signal, Arc::clone(&received), signal as usize)
            .map_err(|cause| Error::Internal(format!("signal {signal} cannot be watched: {cause}")))?;
    }
    Ok(received)
}

/// Whether SIGHUP is not ignored, as `nohup` has it: that run is to outlive its terminal, and to watch the signal would end it. Where
/// the system does not tell, the signal is left as it is.
fn is_stopped_by_hang_up() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask >> (SIGHUP - 1) & 1 == 0)
}
