//! What a run will need, before it: particles, memory, steps, time, disk, the resolution of the flooded area, and the motion.
//!
//! Everything that a run opens is opened, and the first steps of the real problem are taken and recorded for a second or two: they
//! give the cost of an evaluation on this machine, now. From there two bounds are drawn.
//!
//! - Lower bound: the water covers no more than it does at the end of the measurement.
//! - Upper bound: it spreads from the start on at 2 √(g d), the speed of the front of a dam break (`Ritter1892`), over every cell below
//!   the initial levels that it can reach by gravity ([`crate::seeding::reach`]).
//!
//! The length of the steps follows the fastest signal, which starts as √(g d) of the deepest water, may double in the front and falls
//! as the lake drains. A run that ends within the measurement is reported as measured.
//!
//! Left out: rain on the machine by other programs (a plan made on a busy machine says what a run takes on a busy machine), and
//! waves that run up above their level.

use std::ops::Range;
use std::time::{Duration, Instant};

use super::clock::memory_mib;
use super::records::balance;
use super::seeding::seeding_warnings;
use super::stages::{flow_problem, recorder_of, recorder_plan};
use super::{cores, thread_pool};
use crate::error::{Error, Problem, ProblemKind};
use crate::output::Recorder;
use crate::prepare::{Runnable, Scene, Setup, prepare};
use crate::scenario::methods::{Formulation, Motion};
use crate::scenario::{OutputPart, Outputs, Scenario};
use crate::seeding::{Reach, StillWater, reach};
use crate::solver::FlowSolver;

/// How long the steps are measured; a step that has begun is ended.
const MEASURED: Duration = Duration::from_millis(1500);
/// Fewest steps that are measured, however long they take.
const FEWEST_STEPS: u64 = 3;
/// The mean of the fastest signal over a run, over √(g d) of the deepest water at the start: from half of that depth up to the front
/// of a dam break.
const SIGNAL: Range<f64> = 0.7..2.0;
/// An evaluation of Lagrangian particles costs up to so many times what it does at the start: wide particles of thin water have many
/// neighbours, and walls show images of each (0.8 million evaluations a CPU second on a plane, 0.2 at Malpasset: decision 0003).
const DEARER_WHEN_SPREAD: f64 = 4.0;
/// A Lagrangian particle spreads to so many times its width at most (`LARGEST_SPREAD` of the solver).
const WIDEST: f64 = 12.0;
/// Eulerian particles are advised where moving ones would get wider than this many spacings.
const STILL_RESOLVED: f64 = 2.0;
/// Bytes of the maps per cell of the output grid (NetCDF and COG together, compressed): the demonstration 11, Malpasset at 40 m 19.
const MAP_BYTES: Range<f64> = 8.0..24.0;
/// Bytes of one frame per cell with water (compressed): the demonstration 21, Malpasset at 40 m 17.
const FRAME_BYTES: Range<f64> = 12.0..26.0;
/// Bytes of a sample of a gauge series.
const SAMPLE_BYTES: f64 = 60.0;
/// Bytes of a particle of a channel at a moment: a row of `channels.csv`, and four numbers of `channels.nc` (compressed ones take less).
const PROFILE_BYTES: Range<f64> = 50.0..110.0;
/// Bytes that `channels.nc` takes besides: names and places of few or many stations.
const CHANNELS_FILE: Range<f64> = 2e4..6e4;
/// Time (s) to write the maps per cell of the output grid: 2.5e-6 in the demonstration, 5e-6 at Malpasset at 40 m.
const MAP_SECONDS: Range<f64> = 1.5e-6..6e-6;
/// Memory (bytes) that a plan takes per cell of the lattice and a run does not: the water of the start, which the core has by then,
/// and how far it reaches.
const PLAN_BYTES: f64 = 40.0;
/// Memory (MiB) that the writers of a run take at most behind its first steps, whatever its size; they begin when the core is gone.
const WRITERS_MIB: f64 = 80.0;
/// Memory (bytes) that they take per cell of the lattice and of the output grid beyond that, at most.
const WRITERS_BYTES: f64 = 100.0;
/// Memory (bytes) that a Lagrangian particle adds as it gets more neighbours.
const NEIGHBOUR_BYTES: f64 = 400.0;

/// Bytes of a MiB.
const MIB: f64 = 1_048_576.0;

/// What a run will need.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Riverbed particles.
    pub bed_particles: usize,
    /// Particles of channels of one dimension.
    pub channel_particles: usize,
    /// Particles that carry water at the start.
    pub particles_at_start: usize,
    /// Particles that carry water at once: lower and upper bound of the greatest number.
    pub particles_at_most: Range<f64>,
    /// Area (m²) under water at the start, and below the initial levels where water can run.
    pub area: Range<f64>,
    /// Greatest memory (MiB).
    pub memory_mib: Range<f64>,
    /// Steps.
    pub steps: Range<f64>,
    /// Wall-clock time (s) of the whole run.
    pub run_time: Range<f64>,
    /// Size of the run folder (MB), without a report.
    pub disk_mb: Range<f64>,
    /// Distance of the particles (m) in the flooded area: where it is as deep as at the start, and where it is thinnest.
    pub resolution: Range<f64>,
    /// The motion of the scenario.
    pub motion: Motion,
    /// The motion that fits this scene better, and why.
    pub advice: (Motion, String),
    /// What the estimate rests on.
    pub measured: Measured,
    /// Number of threads.
    pub threads: usize,
    /// Warnings.
    pub warnings: Vec<Problem>,
}

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
    /// Particles with water after the last step, and the most of all steps.
    pub particles: (usize, usize),
    /// Evaluations of the last step.
    pub last_evaluations: u64,
}

/// Plans a run on the given number of threads, or on all.
///
/// # Errors
/// `Error::Problems` where a run would be refused, a stated limit included; `Error::Numerical` where the first steps break down.
pub fn plan(scenario: &Scenario, threads: Option<usize>) -> Result<Plan, Error> {
    thread_pool(threads)?.install(|| plan_on_threads(scenario))
}

fn plan_on_threads(scenario: &Scenario) -> Result<Plan, Error> {
    let start = Instant::now();
    let Runnable { setup, mut warnings, .. } = prepare(scenario).into_runnable()?;
    warnings.extend(seeding_warnings(scenario, &setup));
    let problem = flow_problem(scenario, &setup, setup.bed.clone());
    let reach = {
        let (still, levels) = with_flowing_water(&setup, scenario.numerics.gravity);
        reach(&setup.bed, &still, &levels, &problem.walls, scenario.numerics.dry_depth)
    };
    let seeds = cores::seeds(scenario, &problem, &setup.still_water, &setup.scene.levels());
    let mut solver = cores::build(scenario, problem, seeds, &setup.initial_velocity);
    let Setup { bed, still_water: still, pixels, scene, .. } = setup;
    let mut recorder = recorder_of(scenario, recorder_plan(scenario, &scene, bed, pixels));
    let preparation = start.elapsed().as_secs_f64();
    let measured = Measured { preparation, ..measure(scenario, solver.as_mut(), &mut recorder)? };
    let cells = [recorder.grid().len(), recorder.grid_of_maps().len()];
    let memory_now = memory_mib();
    let plan = Plan { warnings, ..draw(scenario, &scene, (&still, &reach), measured, (cells, memory_now)) };
    let limit = scenario.limits.memory / MIB;
    if plan.memory_mib.start > limit {
        return Err(Error::Problems(with_memory_problem(plan, scenario, limit)));
    }
    Ok(plan)
}

/// The bodies of water, and as one more of them the water that belongs to none, with the greatest head z + d + v²/(2 g) of its cells
/// (m): it gets no higher without inflow.
fn with_flowing_water(setup: &Setup, gravity: f64) -> (StillWater, Vec<f64>) {
    let (bed, velocity) = (&setup.bed, &setup.initial_velocity);
    let (mut still, mut levels) = (setup.still_water.clone(), setup.scene.levels());
    let number = levels.len() as u32;
    let mut highest = f64::NEG_INFINITY;
    for cell in 0..still.depth.len() {
        if still.depth[cell] > 0.0 && still.body[cell].is_none() {
            let speed = velocity.get(cell).map_or(0.0, |velocity| velocity.norm());
            highest = highest.max(bed.elevation[cell] + still.depth[cell] + speed * speed / (2.0 * gravity));
            still.body[cell] = Some(number);
        }
    }
    if highest > f64::NEG_INFINITY {
        levels.push(highest);
    }
    (still, levels)
}

/// Takes the first steps of a run.
fn measure(scenario: &Scenario, solver: &mut dyn FlowSolver, recorder: &mut Recorder) -> Result<Measured, Error> {
    let mut no_sink = |_| Ok(());
    let first = balance(solver);
    let particles = solver.particles();
    let mut measured =
        Measured { particles_at_start: particles, particles: (particles, particles), ..Measured::default() };
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
        let now = solver.particles();
        measured.particles = (now, measured.particles.1.max(now));
    }
    measured.seconds = start.elapsed().as_secs_f64();
    measured.simulated = solver.time();
    measured.evaluations = before - evaluated_before;
    measured.shortest_step = shortest;
    measured.is_whole = solver.time() >= scenario.end_time;
    Ok(measured)
}

/// The shares of maps, frames, profiles of channels and `channels.nc` that are written: NetCDF and COG take half of the maps each, and the
/// profiles are in `channels.nc` and in a table.
fn written_shares(outputs: &Outputs) -> [f64; 4] {
    let share =
        |parts: &[OutputPart]| parts.iter().filter(|part| outputs.writes(**part)).count() as f64 / parts.len() as f64;
    [
        share(&[OutputPart::Maps, OutputPart::Cog]),
        share(&[OutputPart::Fields]),
        share(&[OutputPart::Channels, OutputPart::Tables]),
        share(&[OutputPart::Channels]),
    ]
}

/// Draws the bounds from the measurement; cells of the frames and of the maps, and the greatest memory so far (MiB).
fn draw(
    scenario: &Scenario,
    scene: &Scene,
    (still, reach): (&StillWater, &Reach),
    measured: Measured,
    ([cells, map_cells], memory_now): ([usize; 2], f64),
) -> Plan {
    let spacing = scenario.resolution.value;
    let moves = is_moving(scenario);
    let wet = reach.cells_at.first().copied().unwrap_or(0);
    let growth = growth(scenario, still, reach, measured.particles.0);
    let (now, peak) = (measured.particles.0 as f64, measured.particles.1 as f64);
    let particles_at_most = match (moves, measured.is_whole) {
        (true, _) | (_, true) => peak..peak,
        (false, false) => peak..peak.max((reach.cells() + scene.needs.channel_particles) as f64),
    };
    let steps = steps(scenario, &measured);
    let run_time = run_time(&steps, &measured, if moves { DEARER_WHEN_SPREAD } else { growth }, map_cells);
    let frames = (scenario.end_time / scenario.outputs.every).ceil() + 1.0;
    let gauges = scene.gauges.len() + scene.channels.iter().map(|channel| channel.gauges.len()).sum::<usize>();
    let has_tables = scenario.outputs.writes(OutputPart::Tables);
    let samples =
        if has_tables { gauges as f64 * (scenario.end_time / scenario.outputs.gauges_every).ceil() } else { 0.0 };
    let profiles = scene.needs.channel_particles as f64 * frames;
    let lattice_cells = scene.lattice.len();
    let share = cells as f64 / lattice_cells.max(1) as f64;
    let has_channels = if scene.channels.is_empty() { 0.0 } else { 1.0 };
    let disk = |[map, frame, profile, file]: [f64; 4], wet: f64| {
        let of_channels = profile * profiles + file * has_channels;
        (map * map_cells as f64 + frame * frames * wet * share + SAMPLE_BYTES * samples + of_channels) / 1e6
    };
    let ranges = [MAP_BYTES, FRAME_BYTES, PROFILE_BYTES, CHANNELS_FILE];
    let shares = written_shares(&scenario.outputs);
    let least = [0, 1, 2, 3].map(|k: usize| shares[k] * ranges[k].start);
    let most = [0, 1, 2, 3].map(|k: usize| shares[k] * ranges[k].end);
    let cells_at_end = if moves { reach.cells() as f64 } else { now * growth };
    let written = WRITERS_BYTES * (map_cells + lattice_cells) as f64 / MIB;
    let neighbours = if moves { NEIGHBOUR_BYTES * peak / MIB } else { 0.0 };
    let spread = (reach.cells() as f64 / wet.max(1) as f64).sqrt().min(WIDEST);
    Plan {
        bed_particles: scene.needs.bed_particles,
        channel_particles: scene.needs.channel_particles,
        particles_at_start: measured.particles_at_start,
        particles_at_most,
        area: wet as f64 * spacing * spacing..reach.cells() as f64 * spacing * spacing,
        memory_mib: memory_now - PLAN_BYTES * lattice_cells as f64 / MIB
            ..memory_now + WRITERS_MIB + written + neighbours,
        steps,
        run_time,
        disk_mb: disk(least, wet as f64)..disk(most, cells_at_end),
        resolution: spacing..if moves { spacing * spread } else { spacing },
        motion: scenario.numerics.motion,
        advice: if !scene.forcing.channels.is_empty() {
            (Motion::Eulerian, "channels of one dimension have Eulerian particles alone".to_owned())
        } else if !scene.forcing.is_still() {
            let why = "water that comes in goes where Eulerian particles follow it evenly";
            (Motion::Eulerian, why.to_owned())
        } else if scene.forcing.breach.is_some() || !scene.forcing.moving_bed.is_empty() {
            let why = "how far the water of a bed that changes can run is not known before, and Eulerian particles keep their spacing";
            (Motion::Eulerian, why.to_owned())
        } else {
            advice(reach, spread, spacing)
        },
        measured,
        threads: rayon::current_num_threads(),
        warnings: Vec::new(),
    }
}

fn is_moving(scenario: &Scenario) -> bool {
    scenario.numerics.motion == Motion::Lagrangian || scenario.numerics.formulation == Formulation::Variational
}

/// The mean number of cells with water over the run, at most, over that after the measurement.
fn growth(scenario: &Scenario, still: &StillWater, reach: &Reach, now: usize) -> f64 {
    let deepest = still.depth.iter().copied().fold(0.0, f64::max);
    let front = 2.0 * (scenario.numerics.gravity * deepest).sqrt();
    if front <= 0.0 || now == 0 {
        return 1.0;
    }
    (reach.mean_cells(scenario.resolution.value, front, scenario.end_time) / now as f64).max(1.0)
}

/// Steps of the whole run.
fn steps(scenario: &Scenario, measured: &Measured) -> Range<f64> {
    let done = measured.steps as f64;
    let left = (scenario.end_time - measured.simulated).max(0.0);
    if measured.is_whole || left <= 0.0 {
        return done..done;
    }
    let fewest = left * SIGNAL.start / measured.first_step;
    let most = left * (SIGNAL.end / measured.first_step).max(1.0 / measured.shortest_step);
    (done + fewest).ceil()..(done + most).ceil()
}

/// Time (s) of the whole run, when an evaluation or their number grows by a factor at most.
fn run_time(steps: &Range<f64>, measured: &Measured, growth: f64, cells: usize) -> Range<f64> {
    let done = measured.steps as f64;
    let per_step = measured.seconds / measured.evaluations.max(1) as f64 * measured.last_evaluations as f64;
    let time = |steps: f64, growth: f64, write: f64| {
        measured.preparation + measured.seconds + (steps - done).max(0.0) * per_step * growth + write * cells as f64
    };
    time(steps.start, 1.0, MAP_SECONDS.start)..time(steps.end, growth, MAP_SECONDS.end)
}

/// The motion that fits a scene, and why: the rule of decision 0003, with the numbers of the scene.
fn advice(reach: &Reach, spread: f64, spacing: f64) -> (Motion, String) {
    if reach.pockets > 0 {
        let why = format!(
            "the water can reach {} pockets of the ground, in which Lagrangian particles slosh and Eulerian ones do not",
            reach.pockets
        );
        (Motion::Eulerian, why)
    } else if spread > STILL_RESOLVED {
        let why = format!(
            "spread over all that it can reach, the water would leave Lagrangian particles {:.3} m apart, {spread:.1} spacings; Eulerian ones keep {spacing} m",
            spread * spacing
        );
        (Motion::Eulerian, why)
    } else {
        let why = format!(
            "no pocket holds water back, and spread over all that it can reach the water leaves Lagrangian particles {:.3} m apart at most",
            spread * spacing
        );
        (Motion::Lagrangian, why)
    }
}

/// The problem of a run that needs more memory than its limit, behind the warnings.
fn with_memory_problem(plan: Plan, scenario: &Scenario, limit: f64) -> Vec<Problem> {
    let resolution = &scenario.resolution;
    let message =
        format!("the run needs {:.0} MiB of memory or more; the limit is {limit:.0} MiB", plan.memory_mib.start);
    let problem = Problem::error(ProblemKind::Limit, "memory-limit", resolution.key.clone(), message)
        .with_remedy("take a coarser resolution, cut the terrain to the valley, or raise `limits.memory`")
        .with_place(resolution.place.clone());
    std::iter::once(problem).chain(plan.warnings).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_goes_with_steps_and_with_growth() {
        let measured = Measured {
            preparation: 1.0,
            steps: 10,
            seconds: 2.0,
            evaluations: 1000,
            last_evaluations: 100,
            ..Measured::default()
        };
        // 0.2 s a step, 90 steps to go; written maps take 2e-6 s a cell or so.
        let time = run_time(&(100.0..190.0), &measured, 3.0, 0);
        assert!((time.start - 21.0).abs() < 1e-12 && (time.end - (3.0 + 180.0 * 0.2 * 3.0)).abs() < 1e-12, "{time:?}");
        assert!(run_time(&(10.0..10.0), &measured, 3.0, 1_000_000).end > 8.0);
    }

    #[test]
    fn the_motion_follows_pockets_and_spread() {
        let reach = |pockets| Reach { cells_at: vec![4, 4], pockets };
        assert_eq!(advice(&reach(0), 1.4, 1.0).0, Motion::Lagrangian);
        assert_eq!(advice(&reach(0), 2.1, 1.0).0, Motion::Eulerian);
        assert_eq!(advice(&reach(1), 1.4, 1.0).0, Motion::Eulerian);
    }
}
