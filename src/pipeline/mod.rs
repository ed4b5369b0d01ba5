//! One whole run: scenario → prepared inputs → bed → still water → solver → recorder → run folder.
//!
//! The only place that knows both the scenario and the stages; each stage gets a small plain struct.

mod budget;
mod by_level;
mod channels;
pub(crate) mod clock;
pub(crate) mod cores;
mod discharges;
mod downstream;
mod levels;
mod looks;
mod outputs;
mod part;
mod plan;
mod progress;
mod recorders;
mod records;
mod scout;
mod second_run;
mod seeding;
mod stages;
mod steps;
mod summary;
mod unseen_flow;
mod verdict;

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

use crate::calendar::utc_now;
use crate::error::{Error, NumericalFailure, Problem, ProblemKind, sort_problems};
use crate::output::{
    ChannelGaugeResult, FieldsWriter, Provenance, RecorderPlan, Recording, RunFolder, RunManifest, SectionResult,
};
use crate::prepare::{Runnable, Scene, Setup, in_folder, prepare};
use crate::scenario::methods::Motion;
use crate::scenario::{Part, Scenario};
use crate::seeding::SeededVolume;
use crate::solver::{FlowSolver, Ledger};
use crate::version;
use budget::Chosen;
use clock::Clock;
use part::Sides;
pub use plan::{Advice, Measured, Plan, PlanOptions, plan};
use progress::Progress;
use recorders::Recorders;
use records::{first_manifest, passages, still_water_records};
use second_run::SecondRun;
use seeding::seeding_warnings;
pub(crate) use stages::flow_problem;
use stages::recorder_plan;
use steps::watch_signals;
pub use summary::RunSummary;

/// What the planner asks of a run beyond the scenario.
#[derive(Clone, Debug, PartialEq)]
pub struct RunOptions {
    /// Run folder; that of the scenario when absent.
    pub out: Option<PathBuf>,
    /// Number of threads; all of the machine when absent.
    pub threads: Option<usize>,
    /// Whether an earlier run in the folder may be replaced.
    pub overwrite: bool,
    /// Whether progress stays silent.
    pub quiet: bool,
    /// The command line as typed, for the record of the run.
    pub command: String,
}

/// The phase of the steps in `run.json`; its parts are those of the core, and the recording.
const COMPUTE: &str = "compute";

/// What is wrong with a scenario, its inputs, and the place of its output folder, errors first.
pub fn check(scenario: &Scenario) -> Vec<Problem> {
    let scenario = match part::choose(scenario) {
        Ok(scenario) => scenario,
        Err(problems) => return problems,
    };
    let prepared = prepare(&budget::provisional(&scenario));
    let mut problems = in_folder(&prepared.inputs, &scenario.outputs.folder.value);
    problems.extend(prepared.problems);
    sort_problems(&mut problems);
    problems
}

/// Runs a scenario and writes its run folder.
///
/// # Errors
/// `Error::Problems` before anything is written when the scenario or its data are refused; later `Error::Numerical`,
/// `Error::Stopped`, `Error::Gate` with the results up to there in the folder, and `Error::Output`.
pub fn run(scenario: &Scenario, options: &RunOptions) -> Result<RunSummary, Error> {
    thread_pool(options.threads)?.install(|| run_on_threads(scenario, options))
}

/// More threads than this no machine has; to start them would take minutes.
const MOST_THREADS: usize = 1024;

/// So many threads, or all of the machine.
pub(crate) fn thread_pool(threads: Option<usize>) -> Result<rayon::ThreadPool, Error> {
    if let Some(threads) = threads.filter(|&threads| threads > MOST_THREADS) {
        let most = format!("{MOST_THREADS} are the most, and no more than the machine has cores are of use");
        return Err(Error::Usage(format!("--threads {threads}: {most}")));
    }
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .build()
        .map_err(|cause| Error::Internal(format!("the threads could not be started: {cause}")))
}

fn run_on_threads(scenario: &Scenario, options: &RunOptions) -> Result<RunSummary, Error> {
    let mut clock = Clock::start();
    let mut chosen = budget::choose(&part::choose(scenario).map_err(Error::Problems)?)?;
    clock.lap("part of the terrain and resolution");
    let (mut options, mut reported, signal) = (options.clone(), Vec::new(), watch_signals()?);
    loop {
        match run_once(&chosen, (&options, &mut reported, &signal), clock)? {
            Outcome::Done(summary) => return Ok(*summary),
            Outcome::Beyond { wider, clock: so_far, why } => {
                clock = so_far;
                chosen.warnings.push(*why);
                chosen.scenario.reading.part = Some(wider);
                // What is in the folder is of this run.
                options.overwrite = true;
            }
        }
    }
}

/// What became of a run on a part of the terrain, or on all of it.
enum Outcome {
    Done(Box<RunSummary>),
    /// Water came near the edge of the part.
    Beyond {
        wider: Part,
        clock: Clock,
        /// The warning of it.
        why: Box<Problem>,
    },
}

/// Runs a scenario on the part of its terrain, or on all of it; reports the warnings that were not reported before.
fn run_once(
    chosen: &Chosen,
    (options, reported, signal): (&RunOptions, &mut Vec<Problem>, &Arc<AtomicUsize>),
    mut clock: Clock,
) -> Result<Outcome, Error> {
    let Chosen { scenario, record: choice, warnings: of_choice } = chosen;
    let out = options.out.clone().unwrap_or_else(|| scenario.outputs.folder.value.clone());
    let mut prepared = prepare(scenario);
    prepared.problems.extend(RunFolder::inspect(&out, options.overwrite).map(|p| as_written(p, scenario, options)));
    prepared.problems.extend(in_folder(&prepared.inputs, &out));
    sort_problems(&mut prepared.problems);
    let Runnable { setup, mut warnings, inputs } = prepared.into_runnable()?;
    let (setup, settled) = levels::settle(scenario, setup);
    let of_levels = settled.records(scenario, &setup.bed);
    clock.lap("inputs, bed and seeding");
    warnings.extend(of_choice.iter().cloned().chain(seeding_warnings(scenario, &setup)));
    let second = error_estimate(scenario, &mut warnings);
    for problem in &warnings {
        if !reported.contains(problem) {
            eprintln!("{problem}");
            reported.push(problem.clone());
        }
    }

    let folder = RunFolder::create(&out, options.overwrite).map_err(|error| match error {
        Error::Problems(found) => {
            Error::Problems(found.into_iter().map(|problem| as_written(problem, scenario, options)).collect())
        }
        other => other,
    })?;
    let problem = flow_problem(scenario, &setup, setup.bed.clone());
    let seeds = cores::seeds(scenario, &problem, &setup.still_water, &setup.scene.levels());
    let moving = summary::MovingAtStart::of(&seeds);
    let solver = cores::build(scenario, problem, seeds, &setup.initial_velocity);
    let in_vain = nothing_moves(scenario, solver.as_ref());
    in_vain.iter().for_each(|problem| eprintln!("{problem}"));
    warnings.extend(in_vain);
    let mut manifest = first_manifest(scenario, options, (&inputs, &warnings), (&setup, of_levels));
    let sides = Sides::of(scenario, &setup.bed);
    let Setup { bed, still_water, pixels, scene, .. } = setup;
    let seeded = still_water.into_volumes();
    manifest.resolution = choice.clone();
    manifest.terrain_part = part::record(scenario);
    manifest.still_water = still_water_records(&scene.waters, &seeded);
    let plan = recorder_plan(scenario, &scene, bed, pixels);
    let run = Run {
        manifest,
        scenario,
        folder,
        scene,
        warnings,
        seeded,
        moving,
        clock,
        second,
        sides,
        signal: Arc::clone(signal),
    };
    run.execute(solver, plan, !options.quiet)
}

/// Warns where cells are to move and none does.
pub(in crate::pipeline) fn nothing_moves(scenario: &Scenario, solver: &dyn FlowSolver) -> Option<Problem> {
    let is_in_vain = scenario.numerics.motion == Motion::Lagrangian && !solver.has_moving();
    is_in_vain.then(|| {
        let message = "no cell moves, and the run is that of `motion: eulerian`";
        Problem::warning(ProblemKind::Scenario, "nothing-moves", "numerics.motion", message)
            .with_cause("cells rest beside walls, edges, sills, boundaries, sources, sections and dams, and here all are as near to one of these")
            .with_remedy("leave `numerics.motion` out, or choose a finer `resolution`")
    })
}

/// The second run that estimates errors, where it is wanted; warns where there is none.
fn error_estimate(scenario: &Scenario, warnings: &mut Vec<Problem>) -> Option<SecondRun> {
    match scenario.outputs.wants_errors().then(|| second_run::run(scenario))? {
        Ok(second) => Some(second),
        Err(problem) => {
            warnings.push(problem);
            None
        }
    }
}

/// A problem with the output folder, at the place where the planner wrote the folder.
fn as_written(mut problem: Problem, scenario: &Scenario, options: &RunOptions) -> Problem {
    let folder = &scenario.outputs.folder;
    let (key, place) = match &options.out {
        Some(_) => ("--out".to_owned(), None),
        None if folder.key.is_empty() => ("outputs.folder, by default".to_owned(), None),
        None if folder.place.is_none() => (format!("--set {}", folder.key), None),
        None => (folder.key.clone(), folder.place.clone()),
    };
    problem.key = key;
    problem.with_place(place)
}

/// A run on its way.
struct Run<'a> {
    scenario: &'a Scenario,
    folder: RunFolder,
    scene: Scene,
    warnings: Vec<Problem>,
    seeded: Vec<SeededVolume>,
    moving: Option<summary::MovingAtStart>,
    manifest: RunManifest,
    clock: Clock,
    second: Option<SecondRun>,
    sides: Option<Sides>,
    signal: Arc<AtomicUsize>,
}

/// Why the loop of steps ended before its time.
enum Early {
    Failed(NumericalFailure),
    Signal(i32),
}

/// What a run came to.
struct Computed {
    ledger: Ledger,
    recording: Recording,
    sections: Vec<SectionResult>,
    channel_gauges: Vec<ChannelGaugeResult>,
    early: Option<Early>,
}

impl Run<'_> {
    /// Computes, writes everything, and judges the result; `run.json` says so where files cannot be written.
    fn execute(mut self, solver: Box<dyn FlowSolver>, plan: RecorderPlan, show: bool) -> Result<Outcome, Error> {
        match self.compute_and_write(solver, plan, show) {
            Ok(ControlFlow::Break(wider)) => {
                let why = part::larger(wider, self.manifest.simulated_s);
                // Where the larger part is refused, this run has failed.
                let _ = self.manifest.failed(&self.folder, Error::Problems(vec![why.clone()]));
                self.clock.join_phases("on a smaller part of the terrain");
                Ok(Outcome::Beyond { wider, clock: self.clock, why: Box::new(why) })
            }
            Ok(ControlFlow::Continue(computed)) => {
                self.finish(computed).map(|summary| Outcome::Done(Box::new(summary)))
            }
            Err(error) => Err(self.manifest.failed(&self.folder, error)),
        }
    }

    /// Computes, and writes all results but `run.json`; breaks off with a larger part of the terrain where the water asks for it.
    fn compute_and_write(
        &mut self,
        mut solver: Box<dyn FlowSolver>,
        plan: RecorderPlan,
        show: bool,
    ) -> Result<ControlFlow<Part, Computed>, Error> {
        self.folder.write("scenario.resolved.yaml", self.scenario.to_yaml().as_bytes())?;
        self.manifest.write(&self.folder)?;
        let provenance = self.provenance();
        let mut progress = Progress::new(self.scenario.end_time, &self.scene.lattice, show);
        let of_channels = self.scene.channels.clone();
        let mut recorders = Recorders::open(self, &of_channels, &provenance, plan, solver.as_ref())?;
        let early = match self.compute(solver.as_mut(), &mut recorders, &mut progress)? {
            ControlFlow::Continue(early) => early,
            ControlFlow::Break(wider) => return Ok(ControlFlow::Break(wider)),
        };
        let ledger = solver.ledger();
        self.manifest.boundaries = passages(solver.as_ref(), self.scenario, &self.scene);
        // The outputs take memory of their own.
        drop(solver);
        self.clock.part("rest");
        self.clock.lap(COMPUTE);

        let Recorders { plane, fields, sections, channels, tracers, .. } = recorders;
        let (has_plane, grid) = (!plane.grid().is_empty(), plane.grid_of_maps().clone());
        let mut recording = plane.finish();
        if self.scenario.outputs.needs_maxima() {
            recording.maps.ground_source = grid.ground_source(&self.scene.ground_source);
            recording.maps.resolution = levels::resolution(&self.scene.lattice, &grid, &recording.maps);
            if let Some(second) = self.second.take() {
                self.manifest.error_estimate = Some(second.compare(&grid, &mut recording.maps));
            }
        }
        self.clock.part("grids of the maps");
        let sections = sections.finish(&recording.section_arrivals);
        fields.map_or(Ok(()), FieldsWriter::finish)?;
        self.clock.part("fields");
        if has_plane {
            self.write_plane(&grid, &provenance, &recording, &sections)?;
        }
        self.write_sections(&provenance, &sections)?;
        let in_channels = channels.map(|channels| channels.finish(&self.folder)).transpose()?.unwrap_or_default();
        self.manifest.above_banks = in_channels.above_banks;
        self.write_tables(&recording, &sections, &tracers)?;
        self.clock.part("tables");
        self.clock.lap("outputs");
        let channel_gauges = in_channels.gauge_results;
        Ok(ControlFlow::Continue(Computed { ledger, recording, sections: sections.results, channel_gauges, early }))
    }

    fn provenance(&self) -> Provenance {
        let now = utc_now();
        Provenance {
            title: self.scenario.title.clone(),
            institution: String::new(),
            source: format!("floodsim {} ({})", version::VERSION, version::COMMIT),
            history: format!("{now} {}", self.manifest.command),
            references: String::new(),
            comment: String::new(),
            date_created: now,
            reference_time: self.scenario.reference_time,
        }
    }
}
