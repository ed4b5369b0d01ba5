//! What a run will need, before it: particles, memory, steps, time, disk, the resolution of the flooded area, and the motion.
//!
//! Everything that a run opens is opened, and the first steps of the real problem are taken and recorded for a second or two: they
//! give the cost of an evaluation on this machine, now. A run on coarser cells goes to the end ([`look`]): it knows where water comes by
//! breach, inflow and rain, and how fast. What it says of the run on its own cells is within a factor of [`bounds`].
//!
//! Where the scene can't be put on coarser cells, two bounds are drawn from the first steps.
//!
//! - Lower bound: the water covers no more than it does at the end of the measurement.
//! - Upper bound: it spreads from the start on at 2 √(g d), the speed of the front of a dam break (`Ritter1892`), over every cell below
//!   the initial levels that it can reach by gravity ([`crate::seeding::reach`]).
//!
//! The length of the steps follows the fastest signal, which starts as √(g d) of the deepest water, may double in the front and falls
//! as the lake drains. A run that ends within the measurement is reported as measured.
//!
//! Left out: work on the machine by other programs (a plan made on a busy machine says what a run takes on a busy machine).

mod advice;
mod bounds;
mod look;
mod measure;

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::budget::{self, Chosen};
use super::clock::memory_mib;
use super::disk::Cells;
use super::memory::MemoryWatch;
use super::seeding::seeding_warnings;
use super::stages::{flow_problem, recorder_of, recorder_plan};
use super::{admit, cores, part, room, thread_pool};
use crate::error::{Error, Problem, ProblemKind};
use crate::output::{ChoiceRecord, LevelRecord, OutputGrid, PartRecord, write_level_layer};
use crate::prepare::{Runnable, Setup, prepare};
use crate::scenario::Scenario;
use crate::scenario::methods::Motion;
use crate::seeding::{StillWater, reach};
pub use advice::Advice;
use bounds::draw;
use look::{look, of_levels};
pub use measure::Measured;
use measure::measure;

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
    /// Its size (MB) when it is largest, with the files that the run needs on its way.
    pub disk_on_the_way_mb: Range<f64>,
    /// Distance of the particles (m) in the flooded area: where it is as deep as at the start, and where it is thinnest.
    pub resolution: Range<f64>,
    /// How their distance was chosen, where the scenario left it to the program.
    pub choice: Option<ChoiceRecord>,
    /// The part of the terrain that is prepared, where that is not all of it.
    pub part: Option<PartRecord>,
    /// Its levels, the finest first; nothing of one spacing everywhere.
    pub levels: Vec<LevelRecord>,
    /// The motion of the scenario.
    pub motion: Motion,
    /// The motion that fits this scene better, and why.
    pub advice: Advice,
    /// Edge (m) of the cells of the run that went before, where one did.
    pub look: Option<f64>,
    /// What the estimate rests on.
    pub measured: Measured,
    /// Number of threads.
    pub threads: usize,
    /// Warnings.
    pub warnings: Vec<Problem>,
}

/// What the planner asks of a plan beyond the scenario.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlanOptions {
    /// Number of threads; all of the machine when absent.
    pub threads: Option<usize>,
    /// GeoPackage for the layer of levels; none is written when absent.
    pub layer: Option<PathBuf>,
}

/// Plans a run.
///
/// # Errors
/// `Error::Problems` where a run would be refused, a stated limit included; `Error::Numerical` where the first steps break down;
/// `Error::Usage` and `Error::Output` where the layer cannot be written.
pub fn plan(scenario: &Scenario, options: &PlanOptions) -> Result<Plan, Error> {
    if let Some(layer) = &options.layer {
        check_layer(layer)?;
    }
    admit(scenario)?;
    thread_pool(options.threads)?.install(|| plan_on_threads(scenario, options.layer.as_deref()))
}

/// Refuses a file for the layer that is no GeoPackage, or exists: it might be an input.
fn check_layer(layer: &Path) -> Result<(), Error> {
    let name = layer.display();
    if !layer.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gpkg")) {
        return Err(Error::Usage(format!(
            "--layer {name}: the layer is a GeoPackage; give a name that ends with .gpkg"
        )));
    }
    if layer.exists() {
        return Err(Error::Usage(format!("--layer {name}: the file exists; give another name, or remove it")));
    }
    Ok(())
}

fn plan_on_threads(scenario: &Scenario, layer: Option<&Path>) -> Result<Plan, Error> {
    let start = Instant::now();
    let _watch = MemoryWatch::begin(scenario.limits.memory)?;
    let Chosen { scenario, record: choice, warnings: of_choice } =
        budget::choose(&part::choose(scenario).map_err(Error::Problems)?)?;
    let scenario = &scenario;
    let Runnable { setup, mut warnings, .. } = prepare(scenario).into_runnable()?;
    let reach = {
        let (still, heads) = with_flowing_water(&setup, scenario.numerics.gravity);
        reach(&setup.bed, &still, &heads, &setup.scene.walls)
    };
    let (setup, settled) = super::levels::settle(scenario, setup);
    let levels = settled.records(scenario, &setup.bed);
    if let Some(layer) = layer {
        let (bed, spacing) = (&setup.bed, setup.scene.lattice.spacing);
        let grid = OutputGrid::new(&bed.lattice, spacing, &bed.elevation);
        write_level_layer(layer, &grid, &setup.scene.crs, &settled.areas(bed), &levels)?;
    }
    let cut_off = super::edges::cut_off(scenario, &setup);
    warnings.extend(of_choice.into_iter().chain(cut_off).chain(seeding_warnings(scenario, &setup)));
    let problem = flow_problem(scenario, &setup, setup.bed.clone());
    let seeds = cores::seeds(scenario, &problem, &setup.still_water, &setup.scene.levels());
    let mut solver = cores::build(scenario, problem, seeds, &setup.initial_velocity);
    warnings.extend(super::nothing_moves(scenario, solver.as_ref()));
    let cells = Cells::of(scenario, &setup);
    let Setup { bed, still_water: still, pixels, scene, .. } = setup;
    let mut recorder = recorder_of(scenario, recorder_plan(scenario, &scene, bed.clone(), pixels));
    let preparation = start.elapsed().as_secs_f64();
    let measured = Measured { preparation, ..measure(scenario, solver.as_mut(), &mut recorder)? };
    let memory_now = memory_mib();
    drop((solver, recorder));
    let expected = match of_levels(&levels) {
        _ if measured.is_whole || !scenario.numerics.has_cells() => None,
        Some(expected) => Some(expected),
        None => look(scenario, &bed),
    };
    let (estimate, disk) = draw(scenario, &scene, (&still, &reach), (measured, expected), (cells, memory_now));
    let folder = &scenario.outputs.folder.value;
    let (full, may_fill) = (room::problem(scenario, folder, &disk), room::doubt(scenario, folder, &disk));
    warnings.extend(may_fill.filter(|_| full.is_none()));
    let plan = Plan { warnings, choice, part: part::record(scenario), levels, ..estimate };
    let limit = scenario.limits.memory / MIB;
    let too_much = (plan.memory_mib.start > limit).then(|| memory_problem(&plan, scenario, limit));
    let refused: Vec<Problem> = too_much.into_iter().chain(full).collect();
    if refused.is_empty() { Ok(plan) } else { Err(Error::Problems(refused.into_iter().chain(plan.warnings).collect())) }
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

/// The problem of a run that needs more memory (MiB) than its limit.
fn memory_problem(plan: &Plan, scenario: &Scenario, limit: f64) -> Problem {
    let resolution = &scenario.resolution;
    let message =
        format!("the run needs {:.0} MiB of memory or more; the limit is {limit:.0} MiB", plan.memory_mib.start);
    Problem::error(ProblemKind::Limit, "memory-limit", resolution.key.clone(), message)
        .with_remedy("take a coarser resolution, cut the terrain to the valley, or raise `limits.memory`")
        .with_place(resolution.place.clone())
}
