//! Opens every input of a scenario and checks it: all problems at once, nothing computed, nothing written.
//!
//! What a run needs is handed on in [`Prepared`]: the riverbed and the still water on it, walls and open edges for the
//! solver, gauges and the reference system for the outputs.

mod admission;
mod banks;
mod findings;
mod following;
mod forcing;
mod grain;
mod grid;
mod ground;
mod inputs;
mod levels;
mod needs;
mod on_lattice;
mod outside;
mod places;
mod polygons;
mod rain;
mod raster;
mod series_rows;
mod tables;
mod tracers;
mod water;

use crate::bed::BedParticles;
use crate::error::{Error, Problem, ProblemKind, Severity};
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::output::{ChannelProfile, Gauge, GroundSource, OutputCrs, Ridge, Section, TerrainPixels};
use crate::scenario::{Part, Scenario};
use crate::seeding::StillWater;
use crate::solver::{Forcing, OpenEdges};
use crate::terrain::Terrain;
pub use admission::refused;
use findings::Findings;
pub use following::Following;
pub use grain::{Grain, grain, outline};
pub use grid::{BYTES_OF_PROGRAM, BYTES_PER_CELL, BYTES_PER_FLUID_PARTICLE, BYTES_PER_SAMPLE};
pub use inputs::{InputFile, in_folder};
pub use levels::{BLOCK, Because, Wanted, places_of_water, scatter};
pub use water::earlier_fields::rectangle as rectangle_of_fields;

/// Water that stands still at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct StillBody {
    /// Its area in map coordinates (m). Bodies of equal level do not overlap.
    pub polygon: geo::MultiPolygon<f64>,
    /// Its level (m).
    pub level: f64,
    /// The key of the scenario that it comes from, such as `initial[0].reservoir`.
    pub key: String,
}

/// How far riverbed particles lie from the survey points that their elevation comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapReport {
    /// The largest distance (m).
    pub largest: f64,
    /// Where that is (map coordinates).
    pub place: Vec2,
    /// The distance (m) that 95 % of the particles do not exceed.
    pub percentile_95: f64,
    /// The distance (m) that half of the particles do not exceed.
    pub median: f64,
}

/// What the run will need, estimated before anything large is allocated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Needs {
    /// Riverbed particles: cells with terrain.
    pub bed_particles: usize,
    /// Particles of the channels of one dimension.
    pub channel_particles: usize,
    /// Strips of their cross-sections, all particles together.
    pub channel_strips: usize,
    /// Cells that hold water at the start; as many fluid particles are seeded when they move.
    pub wet_cells: usize,
    /// Memory (bytes).
    pub memory: f64,
}

/// What the check of a scenario found.
#[derive(Debug)]
pub struct Prepared {
    /// What was found, errors first.
    pub problems: Vec<Problem>,
    /// Every input file, each once, in the order of the scenario.
    pub inputs: Vec<InputFile>,
    /// The terrain, where all of its layers could be opened.
    pub terrain: Option<Terrain>,
    /// What a run would begin with, where there is a lattice for it; with errors among `problems` it is not to be run.
    pub setup: Option<Setup>,
}

/// All that a run begins with, but for the scenario itself.
#[derive(Debug)]
pub struct Setup {
    /// The riverbed, on its lattice.
    pub bed: BedParticles,
    /// The still water on it: depths, volumes, leaks.
    pub still_water: StillWater,
    /// Velocity (m/s) of the water of each cell at the start; empty where it rests.
    pub initial_velocity: Vec<Vec2>,
    /// The terrain by its pixels, where the maps are on them.
    pub pixels: Option<TerrainPixels>,
    /// The gaps of a survey, where one is used.
    pub gap: Option<GapReport>,
    /// What stays as it is throughout the run.
    pub scene: Scene,
    /// The same on the coarser levels of a nested lattice, until they are joined.
    pub coarser: Vec<Setup>,
    /// The level that each place asks for; none of one lattice alone.
    pub wanted: Option<Wanted>,
    /// Cells that follow lines, until they are joined.
    pub following: Option<Following>,
}

/// What stands around the water, what brings it in, and what is asked of it.
#[derive(Debug)]
pub struct Scene {
    /// The lattice of the riverbed particles.
    pub lattice: Lattice,
    /// The reference system of the outputs.
    pub crs: OutputCrs,
    /// Who set the ground of each place last.
    pub ground_source: GroundSource,
    /// The ridges of the terrain that its cells do not see.
    pub ridges: Vec<Ridge>,
    /// Cells that a dam, a levee, a wall with a crest or a building raises; ascending.
    pub raised: Vec<usize>,
    /// Pieces of the lines that cells follow (local coordinates, m).
    pub followed: Vec<[Vec2; 2]>,
    /// The steep banks of the terrain that cells follow (map coordinates, m).
    pub banks: Vec<Vec<Vec2>>,
    /// Cells of gauges about which the terrain has an upright bank, ascending.
    pub at_banks: Vec<usize>,
    /// Walls as straight pieces in local coordinates (m).
    pub walls: Vec<[Vec2; 2]>,
    /// Where water may leave, in local coordinates.
    pub open_edges: OpenEdges,
    /// Where a wall stands at the edge, as the scenario says.
    pub closed_edges: OpenEdges,
    /// What brings water in or takes it out, in local coordinates.
    pub forcing: Forcing,
    /// Bodies of still water at the start.
    pub waters: Vec<StillBody>,
    /// The time in an earlier run (s) at which this one goes on.
    pub earlier_time: Option<f64>,
    /// Cross-sections.
    pub sections: Vec<Section>,
    /// Of each of them the cells that it crosses.
    pub crossed: Vec<Vec<usize>>,
    /// Channels of one dimension.
    pub channels: Vec<ChannelProfile>,
    /// Gauges.
    pub gauges: Vec<Gauge>,
    /// The estimate of particles and memory.
    pub needs: Needs,
}

/// What can be run: its setup, with the warnings and the input files that its record names.
#[derive(Debug)]
pub struct Runnable {
    /// What the run begins with.
    pub setup: Setup,
    /// The warnings.
    pub warnings: Vec<Problem>,
    /// Every input file.
    pub inputs: Vec<InputFile>,
}

impl Prepared {
    /// Whether a run must be refused.
    pub fn has_errors(&self) -> bool {
        self.problems.iter().any(|problem| problem.severity == Severity::Error)
    }

    /// What can be run; the terrain is let go of.
    ///
    /// # Errors
    /// `Error::Problems` with all problems where one of them is an error.
    pub fn into_runnable(self) -> Result<Runnable, Error> {
        match self {
            prepared if prepared.has_errors() => Err(Error::Problems(prepared.problems)),
            Prepared { problems, inputs, setup: Some(setup), .. } => Ok(Runnable { setup, warnings: problems, inputs }),
            _ => Err(Error::Internal("prepared inputs without errors lack the bed or its water".into())),
        }
    }
}

#[cfg(test)]
impl Prepared {
    /// The setup of a scenario that has one.
    fn setup(&self) -> &Setup {
        self.setup.as_ref().unwrap()
    }

    /// The scene of a scenario that has a setup.
    fn scene(&self) -> &Scene {
        &self.setup().scene
    }
}

impl Scene {
    /// Levels (m) of the bodies of still water.
    pub fn levels(&self) -> Vec<f64> {
        self.waters.iter().map(|water| water.level).collect()
    }
}

/// Opens and checks everything that a scenario names. Never fails: what is wrong is in `problems`.
pub fn prepare(scenario: &Scenario) -> Prepared {
    let mut findings = Findings::default();
    let spacing = scenario.resolution.value;
    let is_possible = spacing.is_finite() && spacing > 0.0;
    if !is_possible {
        let problem = Problem::error(
            ProblemKind::Scenario,
            "bad-resolution",
            "",
            format!("a resolution of {spacing} m is not possible"),
        );
        findings.add(&scenario.resolution, problem.with_remedy("give a positive length, such as `20 m`"));
    }
    if scenario.layers.is_empty() && scenario.channels.is_empty() {
        let problem = Problem::error(ProblemKind::Scenario, "no-terrain", "", "the scenario names no terrain");
        findings.add_at("terrain.layers", None, problem.with_remedy("add `terrain: {layers: [{raster: FILE}]}`"));
    }
    let (crs, terrain) = ground::layers::open(scenario, &mut findings);
    // Every file is opened even where the terrain failed, so that one check reports all that is missing.
    let files = on_lattice::Files::open(scenario, crs.as_ref(), &mut findings);
    let setup = match &terrain {
        _ if !is_possible => None,
        _ if scenario.is_channels_alone() => Some(on_lattice::channels_alone(scenario, files, &mut findings)),
        Some(terrain) => on_lattice::place(scenario, terrain, files, &mut findings).and_then(|finest| {
            let Some(levels) = &scenario.levels else { return Some(finest) };
            levels::with_coarser((scenario, levels), (terrain, crs.as_ref()), finest, &mut findings)
        }),
        None => None,
    };
    let mut problems = findings.into_problems();
    if let Some(part) = scenario.reading.part {
        problems.retain(|problem| !is_beyond(problem, part));
        problems.iter_mut().filter(|problem| IN_PART.contains(&problem.code)).for_each(|problem| {
            problem.severity = Severity::Warning;
        });
    }
    let (inputs, warnings) = inputs::all(scenario);
    problems.extend(warnings);
    Prepared { problems, inputs, terrain, setup }
}

/// Errors of a file as a whole that its features in a part of the terrain do not show: the others may be where they should.
const IN_PART: [&str; 3] = ["outside-terrain", "crest-below-terrain", "invert-above-terrain"];

/// Whether a warning is of a place on the terrain that is not read: nothing was missed there.
fn is_beyond(problem: &Problem, part: Part) -> bool {
    let is_elsewhere = |place: Vec2| part.whole.holds(place) && !part.own.holds(place);
    problem.severity == Severity::Warning && problem.at.is_some_and(is_elsewhere)
}

#[cfg(test)]
mod tests;
