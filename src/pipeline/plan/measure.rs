//! The first steps of a run, taken and timed.

use std::time::{Duration, Instant};

use crate::error::Error;
use crate::output::Recorder;
use crate::pipeline::records::balance;
use crate::scenario::Scenario;
use crate::solver::FlowSolver;

/// How long the steps are measured; a step that has begun is ended.
const MEASURED: Duration = Duration::from_millis(1500);
/// Fewest steps that are measured, however long they take.
const FEWEST_STEPS: u64 = 3;

/// The first steps of the run, as they were taken.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// Time to open the inputs, lay the bed and fill it (s).
    pub preparation: f64,
    /// Number of steps.
    pub steps: u64,
    /// Simulated time (s).
    pub simulated: f64,
    /// Wall-clock time of the steps, recording included (s).
    pub seconds: f64,
    /// Evaluations of the rates of one particle.
    pub evaluations: u64,
    /// Whether this was the whole run.
    pub is_whole: bool,
    /// The step that still water allows (s).
    pub first_step: f64,
    /// The shortest step (s).
    pub shortest_step: f64,
    /// Particles with water before the first step.
    pub particles_at_start: usize,
    /// Particles with water after the last step.
    pub particles: usize,
    /// The most particles with water of all steps.
    pub most_particles: usize,
    /// Evaluations of the last step.
    pub last_evaluations: u64,
}

/// Takes the first steps of a run.
pub fn measure(scenario: &Scenario, solver: &mut dyn FlowSolver, recorder: &mut Recorder) -> Result<Measured, Error> {
    let mut no_sink = |_| Ok(());
    let first = balance(solver);
    let particles = solver.particles();
    let mut measured =
        Measured { particles_at_start: particles, particles, most_particles: particles, ..Measured::default() };
    let evaluated_before = solver.particle_evaluations();
    let start = Instant::now();
    recorder.start(&solver.water(), first, &mut no_sink)?;
    let (mut shortest, mut before) = (f64::INFINITY, evaluated_before);
    while solver.time() < scenario.end_time && (measured.steps < FEWEST_STEPS || start.elapsed() < MEASURED) {
        let step = solver.choose_step().time_step;
        if measured.steps == 0 {
            measured.first_step = step;
        }
        shortest = shortest.min(step);
        solver.advance(step.min(scenario.end_time - solver.time()))?;
        if solver.is_record_due(scenario.end_time) {
            let time = solver.time();
            let balance = recorder.is_frame_due(time).then(|| balance(solver));
            recorder.step(time, &solver.water(), balance, &mut no_sink)?;
        }
        measured.steps += 1;
        measured.last_evaluations = solver.particle_evaluations() - before;
        before = solver.particle_evaluations();
        measured.particles = solver.particles();
        measured.most_particles = measured.most_particles.max(measured.particles);
    }
    measured.seconds = start.elapsed().as_secs_f64();
    measured.simulated = solver.time();
    measured.evaluations = before - evaluated_before;
    measured.shortest_step = shortest;
    measured.is_whole = solver.time() >= scenario.end_time;
    Ok(measured)
}
