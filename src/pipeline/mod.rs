//! One whole run: scenario → prepared inputs → bed → still water → solver → recorder → run folder.
//!
//! The only place that knows both the scenario and the stages; each stage gets a small plain struct.

mod channels;
pub(crate) mod clock;
pub(crate) mod cores;
mod discharges;
mod plan;
mod progress;
mod records;
mod summary;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use crate::bed::BedParticles;
use crate::calendar::utc_now;
use crate::error::{Error, NumericalFailure, Problem, ProblemKind, sort_problems};
use crate::gate::Gate;
use crate::math::readable;
use crate::output::{
    ChannelGaugeResult, FieldsWriter, Findings, OutputGrid, PassageRecord, Provenance, Recorder, RecorderPlan,
    Recording, RunFolder, RunManifest, SectionRecorder, SectionResult, TerrainPixels, VolumeBooks, write_cogs,
    write_gauges, write_geopackage, write_maps, write_mass_balance, write_passages, write_section_file,
    write_section_tables,
};
use crate::prepare::{Runnable, Scene, Setup, StillBody, in_folder, prepare};
use crate::scenario::methods::Motion;
use crate::scenario::{OutputPart, Scenario};
use crate::seeding::SeededVolume;
use crate::solver::{FlowProblem, FlowSolver, Ledger, StepChoice, StepLimit};
use crate::version;
use channels::Channels;
use clock::{Clock, memory_mib};
pub use plan::{Measured, Plan, plan};
use progress::Progress;
use records::{
    balance, breach_record, first_manifest, gate_of_discharges, moving_bed_record, passages, still_water_records,
};
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
/// Parts of it: the sum of all water, and what the recorder of maps, frames and gauges does.
const BALANCE: &str = "water balance";
const RECORDING: &str = "recording";
/// What the volume balance may be off, relative.
const LEDGER_TOLERANCE: f64 = 1e-9;
/// What the volume balance of a boundary, a source or rain may differ from the integral of what was asked for, relative.
const ASKED_TOLERANCE: f64 = 1e-9;
/// What the volume on the output grid may differ from that of the particles, relative.
const GRID_TOLERANCE: f64 = 5e-3;
/// The seeding may miss the integral of level minus terrain by this much, relative, before the planner is warned.
const SEEDING_TOLERANCE: f64 = crate::seeding::VOLUME_TOLERANCE;

/// What is wrong with a scenario, its inputs, and the place of its output folder, errors first.
pub fn check(scenario: &Scenario) -> Vec<Problem> {
    let prepared = prepare(scenario);
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
    let out = options.out.clone().unwrap_or_else(|| scenario.outputs.folder.value.clone());
    let mut prepared = prepare(scenario);
    prepared.problems.extend(RunFolder::inspect(&out, options.overwrite).map(|p| as_written(p, scenario, options)));
    prepared.problems.extend(in_folder(&prepared.inputs, &out));
    sort_problems(&mut prepared.problems);
    let Runnable { setup, mut warnings, inputs } = prepared.into_runnable()?;
    clock.lap("inputs, bed and seeding");
    warnings.extend(seeding_warnings(scenario, &setup));
    for problem in &warnings {
        eprintln!("{problem}");
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
    let mut manifest = first_manifest(scenario, options, (&inputs, &warnings), &setup);
    let Setup { bed, still_water, pixels, scene, .. } = setup;
    let seeded = still_water.into_volumes();
    manifest.still_water = still_water_records(&scene.waters, &seeded);
    let plan = recorder_plan(scenario, &scene, bed, pixels);
    let run = Run { manifest, scenario, folder, scene, warnings, seeded, moving, clock };
    run.execute(solver, plan, !options.quiet)
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
    fn execute(mut self, solver: Box<dyn FlowSolver>, plan: RecorderPlan, show: bool) -> Result<RunSummary, Error> {
        match self.compute_and_write(solver, plan, show) {
            Ok(computed) => self.finish(computed),
            Err(error) => Err(self.manifest.failed(&self.folder, error)),
        }
    }

    /// Computes, and writes all results but `run.json`.
    fn compute_and_write(
        &mut self,
        mut solver: Box<dyn FlowSolver>,
        plan: RecorderPlan,
        show: bool,
    ) -> Result<Computed, Error> {
        self.folder.write("scenario.resolved.yaml", self.scenario.to_yaml().as_bytes())?;
        self.manifest.write(&self.folder)?;
        let mut recorder = recorder_of(self.scenario, plan);
        let (grid, grid_of_maps) = (recorder.grid().clone(), recorder.grid_of_maps().clone());
        let provenance = self.provenance();
        let has_plane = !grid.is_empty();
        let start_fields = || FieldsWriter::start(&self.folder, &grid, &self.scene.crs, &provenance);
        let writes = |part: OutputPart| self.scenario.outputs.writes(part);
        let mut fields = (has_plane && writes(OutputPart::Fields)).then(start_fields).transpose()?;
        let mut progress = Progress::new(self.scenario.end_time, &self.scene.lattice, show);
        let outputs = &self.scenario.outputs;
        let count = self.scene.sections.len();
        let mut sections = SectionRecorder::new(count, outputs.gauges_every, self.scenario.end_time);
        let profiles = self.scene.channels.clone();
        let named = (&self.scene.crs, &provenance);
        let mut channels = Channels::start((self.scenario, &profiles), solver.as_ref(), &self.folder, named)?;
        let recorders = (&mut recorder, &mut sections, &mut channels);
        let early = self.compute(solver.as_mut(), recorders, &mut fields, &mut progress)?;
        let ledger = solver.ledger();
        self.manifest.boundaries = passages(solver.as_ref(), self.scenario, &self.scene);
        // The outputs take memory of their own.
        drop(solver);
        self.clock.part("rest");
        self.clock.lap(COMPUTE);

        let mut recording = recorder.finish();
        if self.scenario.outputs.needs_maxima() {
            recording.maps.ground_source = grid_of_maps.ground_source(&self.scene.ground_source);
        }
        self.clock.part("grids of the maps");
        let (section_results, section_samples) = sections.finish(&recording.section_arrivals);
        fields.map_or(Ok(()), FieldsWriter::finish)?;
        self.clock.part("fields");
        if has_plane {
            self.write_plane(&grid_of_maps, &provenance, &recording, &section_results)?;
        }
        let writes = |part: OutputPart| self.scenario.outputs.writes(part);
        let sections = &self.scene.sections;
        if writes(OutputPart::Sections) {
            let about = (&self.scene.crs, &provenance);
            write_section_file(&self.folder, about, sections, &section_results, &section_samples)?;
        }
        let in_channels = channels.map(|channels| channels.finish(&self.folder)).transpose()?.unwrap_or_default();
        self.manifest.above_banks = in_channels.above_banks;
        if writes(OutputPart::Tables) {
            write_section_tables(&self.folder, sections, &section_results, &section_samples)?;
            write_mass_balance(&self.folder, &recording)?;
            write_passages(&self.folder, &self.manifest.boundaries)?;
        }
        self.clock.part("tables");
        self.clock.lap("outputs");
        Ok(Computed { ledger, recording, sections: section_results, channel_gauges: in_channels.gauge_results, early })
    }

    /// The maps, and all else that is drawn or read on the plane.
    fn write_plane(
        &mut self,
        grid: &OutputGrid,
        provenance: &Provenance,
        recording: &Recording,
        sections: &[SectionResult],
    ) -> Result<(), Error> {
        let (crs, outputs) = (&self.scene.crs, &self.scenario.outputs);
        let rise_on_wet = outputs.rise_on_wet;
        let maps = &recording.maps;
        if outputs.writes(OutputPart::Maps) {
            write_maps(&self.folder, grid, crs, provenance, maps, (recording.end_time, rise_on_wet))?;
            self.clock.part("maps");
        }
        if outputs.writes(OutputPart::Cog) {
            write_cogs(&self.folder, grid, crs, provenance, maps, rise_on_wet)?;
            self.clock.part("cog");
        }
        if outputs.writes(OutputPart::Gpkg) {
            let findings = Findings {
                gauges: &self.scene.gauges,
                ridges: &self.scene.ridges,
                sections: (&self.scene.sections, sections),
                isochrones: &outputs.isochrones,
                problems: &self.warnings,
            };
            write_geopackage(&self.folder, grid, crs, recording, &findings)?;
            self.clock.part("gpkg");
        }
        if outputs.writes(OutputPart::Tables) {
            write_gauges(&self.folder, &self.scene.gauges, recording)?;
        }
        Ok(())
    }

    /// The loop of steps.
    fn compute(
        &mut self,
        solver: &mut dyn FlowSolver,
        (recorder, sections, channels): (&mut Recorder, &mut SectionRecorder, &mut Option<Channels<'_>>),
        fields: &mut Option<FieldsWriter>,
        progress: &mut Progress,
    ) -> Result<Option<Early>, Error> {
        let signal = watch_signals()?;
        let end = self.scenario.end_time;
        self.manifest.particles.initial = solver.particles();
        recorder.set_bed(solver.bed_now());
        let mut push = |frame| fields.as_mut().map_or(Ok(()), |fields| fields.push(frame));
        let books_at_start = balance(solver);
        // What the core measured of its own start.
        self.clock.part("start");
        self.clock.add("start", -solver.phases().times().iter().map(|(_, time)| time.wall).sum::<f64>());
        recorder.start(&solver.water(), books_at_start, &mut push)?;
        self.clock.part(RECORDING);
        let mut steps = progress::StepStatistics::default();
        let mut discharges = discharges::Discharges::new(&self.scene.lattice);
        let mut early = None;
        while solver.time() < end {
            self.clock.part("rest");
            let mut choice = solver.choose_step();
            if solver.time() + choice.time_step >= end {
                choice = StepChoice { time_step: end - solver.time(), limit: StepLimit::EndOfRun, ..choice };
            }
            self.clock.skip();
            // Frames lie between two records, and need the water balance of both.
            let is_each_step_recorded = solver.steps_of_a_record() == 1;
            let is_frame_due = !is_each_step_recorded || recorder.is_frame_due(solver.time() + choice.time_step);
            if is_frame_due && is_each_step_recorded {
                recorder.set_balance(balance(solver));
                self.clock.part(BALANCE);
            }
            if let Err(failure) = solver.advance(choice.time_step) {
                early = Some(Early::Failed(failure));
                break;
            }
            self.clock.skip();
            steps.count(&choice, solver.particles());
            let time = solver.time();
            let received = signal.load(Ordering::Relaxed);
            if solver.is_record_due(end) || received != 0 {
                recorder.set_bed(solver.bed_now());
                self.clock.part("rest");
                let volumes = is_frame_due.then(|| balance(solver));
                if recorder.is_frame_due(time) {
                    discharges.add(time, solver.discharges());
                }
                self.clock.part(BALANCE);
                let water = solver.water();
                self.clock.skip();
                recorder.step(time, &water, volumes, &mut push)?;
                self.clock.part(RECORDING);
            }
            sections.step(time, solver.sections().iter().map(|flow| (flow.discharge, flow.volume)));
            if let Some(channels) = channels {
                channels.step(solver)?;
            }
            self.clock.part("sections and channels");
            progress.show((time, solver.particles()), &choice, || balance(solver).error_relative);
            if received != 0 {
                early = Some(Early::Signal(received as i32));
                break;
            }
        }
        progress.end();
        self.clock.part("rest");
        for (phase, time) in solver.phases().times() {
            self.clock.add(phase, time.wall);
        }
        steps.note(&mut self.manifest);
        self.manifest.steps = solver.steps();
        self.manifest.particle_evaluations = solver.particle_evaluations();
        self.manifest.particles.last = solver.particles();
        self.manifest.simulated_s = solver.time();
        self.manifest.discharges = discharges.record();
        self.manifest.breach =
            self.scene.forcing.breach.as_ref().map(|breach| breach_record(breach, solver.breach_began()));
        self.manifest.moving_bed = moving_bed_record(&self.scene.forcing.moving_bed, solver);
        Ok(early)
    }

    /// Fills in the manifest, closes the run, and says how it went.
    fn finish(
        mut self,
        Computed { ledger, recording, sections, channel_gauges, early }: Computed,
    ) -> Result<RunSummary, Error> {
        let grid_error = recording
            .mass_balance
            .iter()
            .filter(|row| row.volumes.stored > 0.0)
            .map(|row| ((row.grid_volume + row.volumes.in_channels) / row.volumes.stored - 1.0).abs())
            .fold(0.0, f64::max);
        let manifest = &mut self.manifest;
        manifest.volume_m3 = VolumeBooks {
            initial: ledger.initial,
            inflow: ledger.inflow,
            outflow: ledger.outflow,
            last: ledger.stored,
            error_relative: ledger.relative_error(),
            grid_error_relative: grid_error,
        };
        manifest.gates = vec![Gate::binding("volume balance", ledger.relative_error().abs(), LEDGER_TOLERANCE)];
        if !self.scenario.is_channels_alone() {
            manifest.gates.push(Gate::binding("volume on the grid", grid_error, GRID_TOLERANCE));
        }
        let asked = manifest.boundaries.iter().filter_map(PassageRecord::error_relative);
        manifest.gates.extend(
            asked
                .reduce(f64::max)
                .map(|worst| Gate::binding("counted inflow against what was asked for", worst, ASKED_TOLERANCE)),
        );
        manifest.gates.extend(manifest.discharges.as_ref().map(gate_of_discharges));
        let failed_gates: Vec<String> =
            manifest.gates.iter().filter(|gate| gate.fails()).map(Gate::to_string).collect();
        self.clock.note(manifest);
        let result = match early {
            Some(Early::Failed(failure)) => Err(Error::Numerical(failure)),
            Some(Early::Signal(signal)) => {
                Err(Error::Stopped { signal, time: manifest.simulated_s, folder: self.folder.path().to_path_buf() })
            }
            None if failed_gates.is_empty() => Ok(()),
            None => Err(Error::Gate(failed_gates.join("; "))),
        };
        manifest.exit_code = Some(result.as_ref().err().map_or(0, |error| error.exit_code() as u8));
        manifest.status = match result {
            Ok(()) | Err(Error::Gate(_)) => "done",
            Err(Error::Stopped { .. }) => "stopped",
            Err(_) => "failed",
        }
        .to_owned();
        manifest.write(&self.folder)?;
        result.map(|()| RunSummary {
            folder: self.folder.path().to_path_buf(),
            manifest: self.manifest,
            seeded: self.seeded,
            moving: self.moving,
            gauges: self.scene.gauges.into_iter().zip(recording.gauge_results).collect(),
            sections: self.scene.sections.into_iter().zip(sections).collect(),
            channel_gauges,
        })
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

/// Warnings about bodies whose cells hold another volume at their level than the integral of level minus terrain: Eulerian particles keep
/// the level, moving ones the volume.
fn seeding_warnings(scenario: &Scenario, setup: &Setup) -> Vec<Problem> {
    let bodies = setup.scene.waters.iter().zip(&setup.still_water.volumes);
    let missed = bodies.filter(|(_, volume)| volume.relative_error().abs() > SEEDING_TOLERANCE);
    let keeps_volume = scenario.numerics.motion == Motion::Lagrangian;
    let area = scenario.resolution.value * scenario.resolution.value;
    let warning = |(water, volume): (&StillBody, &SeededVolume)| {
        let message = if keeps_volume {
            let rise = (volume.integral_m3 - volume.seeded_m3) / (volume.cells as f64 * area);
            format!(
                "the level of {} m is not held: Lagrangian particles get the {:.5e} m³ of the integral of level minus terrain, which stand {:.3} m {} it on the mean",
                readable(water.level),
                volume.integral_m3,
                rise.abs(),
                if rise < 0.0 { "below" } else { "above" }
            )
        } else {
            format!(
                "the seeded volume is {:.5e} m³, {:+.2} % off the integral of level minus terrain; the level of {} m is held",
                volume.seeded_m3,
                100.0 * volume.relative_error(),
                readable(water.level)
            )
        };
        let is_narrow = volume.pocket_cells > 0 && volume.seeded_m3 > volume.integral_m3;
        let (cause, remedy) = if is_narrow {
            let cause = format!(
                "the polygon ends within the water: {} cells beside it lie below the level, too, and are filled",
                volume.pocket_cells
            );
            (cause, "draw the polygon up to the shore or the wall that holds the water")
        } else {
            let cause = "the shore or the rim of this body is finer than the spacing of the particles";
            (cause.to_owned(), "choose a finer `resolution` if this matters")
        };
        Problem::warning(ProblemKind::Scenario, "seeded-volume", water.key.clone(), message)
            .with_cause(cause)
            .with_remedy(remedy)
    };
    missed.map(warning).collect()
}

/// The problem of the core on a bed, which is that of the setup.
pub(crate) fn flow_problem(scenario: &Scenario, setup: &Setup, bed: BedParticles) -> FlowProblem {
    let scene = &setup.scene;
    FlowProblem {
        bed,
        walls: scene.walls.clone(),
        open_edges: scene.open_edges.clone(),
        forcing: scene.forcing.clone(),
        initial_depth: setup.still_water.depth.clone(),
        gravity: scenario.numerics.gravity,
        courant: scenario.numerics.cfl,
        dry_depth: scenario.numerics.dry_depth,
    }
}

fn recorder_plan(scenario: &Scenario, scene: &Scene, bed: BedParticles, pixels: Option<TerrainPixels>) -> RecorderPlan {
    let (outputs, area) = (&scenario.outputs, bed.lattice.cell_area());
    let more_area = bed.cover.cells().iter().map(|part| (part.cell, (part.area - 1.0) * area)).collect();
    RecorderPlan {
        more_area,
        lattice: bed.lattice,
        bed_elevation: bed.elevation,
        cell: outputs.cell,
        terrain: pixels.map(|pixels| (pixels, bed.passes)),
        thresholds: outputs.thresholds.clone(),
        rise_on_wet: outputs.rise_on_wet,
        every: outputs.every,
        end_time: scenario.end_time,
        gauges: scene.gauges.clone(),
        walls: scene.walls.clone(),
        raised: scene.raised.clone(),
        at_banks: scene.at_banks.clone(),
        constants: scenario.numerics.constants.output,
        gauges_every: outputs.gauges_every,
        sections: scene.crossed.clone(),
    }
}

/// A recorder of what the scenario wants written.
pub(crate) fn recorder_of(scenario: &Scenario, plan: RecorderPlan) -> Recorder {
    let mut recorder = Recorder::new(plan);
    if !scenario.outputs.writes(OutputPart::Fields) {
        recorder.leave_out_frames();
    }
    if !scenario.outputs.needs_maxima() {
        recorder.leave_out_maps();
    }
    recorder
}

/// A cell that holds the number of SIGHUP, SIGINT or SIGTERM once it came, 0 before.
fn watch_signals() -> Result<Arc<AtomicUsize>, Error> {
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
