//! One whole run: scenario → prepared inputs → bed → still water → solver → recorder → run folder.
//!
//! The only place that knows both the scenario and the stages; each stage gets a small plain struct.

mod at_end;
mod budget;
mod by_level;
mod channels;
mod checkpoints;
pub(crate) mod clock;
pub(crate) mod cores;
mod discharges;
mod disk;
mod downstream;
mod edges;
mod held;
mod leave;
mod levels;
mod looks;
mod memory;
mod one_run;
mod origin;
mod outputs;
mod part;
mod plan;
mod progress;
mod recorders;
mod records;
mod resume;
mod room;
mod scout;
mod second_run;
mod seeding;
mod signals;
mod stages;
mod steps;
mod summary;
mod unseen_flow;
mod verdict;

use std::path::{Path, PathBuf};

use crate::error::{Error, NumericalFailure, Problem, ProblemKind, say, sort_problems};
use crate::output::{ChannelGaugeResult, Recording, RunFolder, RunManifest, SectionResult};
use crate::prepare::{Prepared, Runnable, Scene, Setup, in_folder, prepare, refused};
use crate::scenario::methods::Motion;
use crate::scenario::{Part, Scenario};
use crate::seeding::SeededVolume;
use crate::solver::{FlowSolver, Ledger};
use budget::Chosen;
use checkpoints::{Before, Checkpoints, State};
use clock::Clock;
use disk::{Cells, disk};
use held::Pits;
pub use leave::out_of_memory;
use memory::MemoryWatch;
use origin::Origin;
use part::Sides;
pub use plan::{Advice, Measured, Plan, PlanOptions, plan};
use records::{first_manifest, still_water_records};
use resume::Resumed;
pub use resume::{ResumeOptions, resume};
use room::Room;
use second_run::SecondRun;
use seeding::seeding_warnings;
use signals::Signals;
pub(crate) use signals::is_stopped_by_hang_up;
pub(crate) use stages::flow_problem;
use stages::recorder_plan;
pub use summary::RunSummary;

/// What the planner asks of a run beyond the scenario.
#[derive(Clone, Debug, Default, PartialEq)]
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
    /// What was set beside the scenario file, as `key=value`.
    pub overrides: Vec<String>,
}

/// The phase of the steps in `run.json`; its parts are those of the core, and the recording.
const COMPUTE: &str = "compute";

/// What is wrong with a scenario, its inputs, and the place of its output folder, errors first.
pub fn check(scenario: &Scenario) -> Vec<Problem> {
    let refused = refused(scenario);
    if !refused.is_empty() {
        return refused;
    }
    let scenario = match part::choose(scenario) {
        Ok(scenario) => scenario,
        Err(problems) => return problems,
    };
    // Where memory can't be watched, a check goes on without.
    let _watch = MemoryWatch::begin(scenario.limits.memory);
    let scenario = budget::provisional(&scenario);
    let prepared = prepare(&scenario);
    let folder = &scenario.outputs.folder.value;
    let mut problems = in_folder(&prepared.inputs, folder);
    problems.extend(of_folder(&scenario, &prepared, folder));
    problems.extend(prepared.setup.iter().flat_map(|setup| edges::cut_off(&scenario, setup)));
    problems.extend(prepared.problems);
    sort_problems(&mut problems);
    problems
}

/// What stands in the way of results in a folder, whatever is in it now: a run that replaces an earlier one is asked for when it begins.
fn of_folder(scenario: &Scenario, prepared: &Prepared, folder: &Path) -> Vec<Problem> {
    let options = RunOptions { overwrite: true, ..RunOptions::default() };
    let cannot_be = RunFolder::inspect(folder, true).map(|problem| as_written(problem, scenario, &options));
    cannot_be.into_iter().chain(room_for(scenario, prepared, folder)).collect()
}

/// What stands in the way of a run that takes more of the disk than there is, with the water that it begins with alone.
fn room_for(scenario: &Scenario, prepared: &Prepared, folder: &Path) -> Option<Problem> {
    let setup = prepared.setup.as_ref()?;
    let wet = setup.scene.needs.wet_cells as f64;
    room::problem(scenario, folder, &disk(scenario, &setup.scene, Cells::of(scenario, setup), (wet..wet, false)))
}

/// Runs a scenario and writes its run folder.
///
/// # Errors
/// `Error::Problems` before anything is written when the scenario or its data are refused; later `Error::Numerical`,
/// `Error::Stopped`, `Error::Gate` with the results up to there in the folder, and `Error::Output`.
pub fn run(scenario: &Scenario, options: &RunOptions) -> Result<RunSummary, Error> {
    thread_pool(options.threads)?.install(|| run_on_threads(scenario, options, None))
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

/// Refuses a scenario with an input that is not to be opened.
fn admit(scenario: &Scenario) -> Result<(), Error> {
    let refused = refused(scenario);
    if refused.is_empty() { Ok(()) } else { Err(Error::Problems(refused)) }
}

/// Runs a scenario, from its start or from where it was cut off.
fn run_on_threads(scenario: &Scenario, options: &RunOptions, resumed: Option<Resumed>) -> Result<RunSummary, Error> {
    let mut clock = Clock::start();
    admit(scenario)?;
    let _watch = MemoryWatch::begin(scenario.limits.memory)?;
    let mut chosen = match &resumed {
        Some(Resumed { origin, state: Some(state), .. }) => Chosen {
            scenario: state.decided.apply(scenario),
            record: origin.choice.clone(),
            warnings: origin.warnings.clone(),
        },
        _ => budget::choose(&part::choose(scenario).map_err(Error::Problems)?)?,
    };
    clock.lap("part of the terrain and resolution");
    let (mut options, mut session) =
        (options.clone(), Session { reported: Vec::new(), signals: Signals::watch()?, resumed });
    loop {
        match run_once(&chosen, &options, &mut session, clock)? {
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

/// What goes through the runs of one command.
struct Session {
    /// The warnings that were reported.
    reported: Vec<Problem>,
    signals: Signals,
    /// From where the first of them goes on, where it does.
    resumed: Option<Resumed>,
}

impl Session {
    /// Reports the warnings that were not reported before.
    fn report(&mut self, warnings: &[Problem]) {
        for problem in warnings {
            if !self.reported.contains(problem) {
                say(problem);
                self.reported.push(problem.clone());
            }
        }
    }
}

/// Runs a scenario on the part of its terrain, or on all of it; reports the warnings that were not reported before.
fn run_once(chosen: &Chosen, options: &RunOptions, session: &mut Session, mut clock: Clock) -> Result<Outcome, Error> {
    let Chosen { scenario, record: choice, warnings: of_choice } = chosen;
    let resumed = session.resumed.take();
    let Runnable { setup, mut warnings, inputs } = runnable(scenario, options, resumed.as_ref())?;
    let (setup, settled) = levels::settle(scenario, setup);
    let of_levels = settled.records(scenario, &setup.bed);
    clock.lap("inputs, bed and seeding");
    warnings.extend(of_choice.iter().cloned().chain(seeding_warnings(scenario, &setup)));
    session.report(&warnings);
    let Resumed { folder, origin, mut state, is_for_outputs } = match resumed {
        Some(resumed) => resumed,
        None => {
            let folder = make_folder(scenario, options)?;
            let origin = Origin::new(scenario, options, &inputs, (choice, of_choice));
            Resumed::at_start(folder, (origin, scenario.limits.checkpoint.is_some()))?
        }
    };
    leave::writes_to(folder.path());
    let second = match state.as_mut().and_then(|state| state.second.take()) {
        Some(second) => Some(second),
        None => error_estimate(scenario, &mut warnings),
    };
    let problem = flow_problem(scenario, &setup, setup.bed.clone());
    let seeds = cores::seeds(scenario, &problem, &setup.still_water, &setup.scene.levels());
    let moving = summary::MovingAtStart::of(&seeds);
    let at_start = || cores::with_velocity(scenario, problem, seeds, &setup.initial_velocity);
    let State { core, recorders, before, steps, .. } = state.unwrap_or_else(|| State::at_start(scenario, at_start()));
    warnings.extend(nothing_moves(scenario, core.as_flow()));
    session.report(&warnings);
    let mut manifest = first_manifest(scenario, &origin, &warnings, (&setup, of_levels));
    let (sides, pits) = (Sides::of(scenario, &setup.bed), Pits::of(scenario, &setup));
    let on_disk = disk(scenario, &setup.scene, Cells::of(scenario, &setup), (0.0..0.0, false));
    let Setup { bed, still_water, pixels, scene, .. } = setup;
    let seeded = still_water.into_volumes();
    manifest.resolution = choice.clone();
    manifest.terrain_part = part::record(scenario);
    manifest.still_water = still_water_records(&scene.waters, &seeded);
    let plan = recorder_plan(scenario, &scene, bed, pixels);
    let room = Room::new(scenario, folder.path(), &on_disk);
    let run = Run {
        room,
        origin,
        checkpoints: Checkpoints::new(scenario.limits.checkpoint),
        before,
        is_for_outputs,
        manifest,
        scenario,
        folder,
        scene,
        warnings,
        seeded,
        pits,
        moving,
        clock,
        second,
        sides,
        signals: &session.signals,
    };
    run.execute(core, (recorders, steps), plan, !options.quiet)
}

/// What a run is prepared from, without errors: neither in the scene, nor with its folder, nor, where it goes on, with inputs that have changed.
fn runnable(scenario: &Scenario, options: &RunOptions, resumed: Option<&Resumed>) -> Result<Runnable, Error> {
    let out = folder_of(scenario, options);
    let mut prepared = prepare(scenario);
    prepared.problems.extend(match resumed {
        Some(resumed) => resume::changed(&resumed.origin, &prepared.inputs),
        None => RunFolder::inspect(&out, options.overwrite).map(|p| as_written(p, scenario, options)),
    });
    prepared.problems.extend(in_folder(&prepared.inputs, &out));
    let has_room =
        room_for(scenario, &prepared, &out).map(|problem| problem.with_place(scenario.outputs.folder.place.clone()));
    prepared.problems.extend(has_room);
    let cut_off = prepared.setup.iter().flat_map(|setup| edges::cut_off(scenario, setup));
    prepared.problems.extend(cut_off.collect::<Vec<_>>());
    sort_problems(&mut prepared.problems);
    prepared.into_runnable()
}

fn folder_of(scenario: &Scenario, options: &RunOptions) -> PathBuf {
    options.out.clone().unwrap_or_else(|| scenario.outputs.folder.value.clone())
}

/// The folder of a run that begins.
fn make_folder(scenario: &Scenario, options: &RunOptions) -> Result<RunFolder, Error> {
    RunFolder::create(&folder_of(scenario, options), options.overwrite).map_err(|error| match error {
        Error::Problems(found) => {
            Error::Problems(found.into_iter().map(|problem| as_written(problem, scenario, options)).collect())
        }
        other => other,
    })
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
    /// The pits of the ground, where rain falls.
    pits: Option<Pits>,
    moving: Option<summary::MovingAtStart>,
    manifest: RunManifest,
    clock: Clock,
    second: Option<SecondRun>,
    sides: Option<Sides>,
    signals: &'a Signals,
    room: Room,
    origin: Origin,
    checkpoints: Checkpoints,
    before: Before,
    /// Whether no step is taken.
    is_for_outputs: bool,
}

/// Why the loop of steps ended before its time.
enum Early {
    Failed(NumericalFailure),
    Signal(i32),
    /// A file that grows could not be written.
    Unwritten(Error),
    /// No step was asked for.
    NoStep,
}

impl Early {
    /// Whether the run may go on later.
    fn may_go_on(&self) -> bool {
        !matches!(self, Early::Failed(_))
    }
}

/// What a run came to.
struct Computed {
    ledger: Ledger,
    recording: Recording,
    sections: Vec<SectionResult>,
    channel_gauges: Vec<ChannelGaugeResult>,
    early: Option<Early>,
    /// The first file that could not be written.
    unwritten: Option<Error>,
}
