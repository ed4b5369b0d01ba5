//! Opens every input of a scenario and checks it: all problems at once, nothing computed, nothing written.
//!
//! What a run needs is handed on in [`Prepared`]: the riverbed and the still water on it, walls and open edges for the
//! solver, gauges and the reference system for the outputs.

mod blocked;
mod breach;
mod burn;
mod channel_places;
mod channels;
mod cover;
mod crests;
mod earlier;
mod earlier_fields;
mod earlier_structures;
mod findings;
mod fine_maps;
mod forcing;
mod gaps;
mod grid;
mod ground;
mod inputs;
mod lagrangian;
mod layers;
mod levels;
mod moving_bed;
mod outside;
mod places;
mod plausible;
mod polygons;
mod rain;
mod rain_frames;
mod rain_series;
mod rain_times;
mod raster;
mod ridges;
mod roughness;
mod series;
mod series_dates;
mod series_times;
mod shaped;
mod sources;
mod start;
mod steps;
mod wall_gaps;
mod water;
mod waves;

use std::collections::BTreeSet;
use std::path::Path;

use sha2::{Digest, Sha256};

use crate::bed::{BedParticles, place_bed};
use crate::error::{Problem, ProblemKind, Severity};
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::output::{ChannelProfile, Gauge, OutputCrs, Ridge, Section, TerrainPixels};
use crate::scenario::methods::Motion;
use crate::scenario::{OpenBoundary, Scenario};
use crate::seeding::StillWater;
use crate::solver::{Channel, Forcing, OpenEdges};
use crate::terrain::Terrain;
use findings::Findings;
pub use grid::{BYTES_PER_CELL, BYTES_PER_FLUID_PARTICLE};
pub use inputs::{InputFile, in_folder};
use shaped::Changes;
use water::SourcedBody;

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

/// Everything that a scenario names, opened and checked. Without an error in `problems`, every part is complete.
#[derive(Debug)]
pub struct Prepared {
    /// What was found, errors first.
    pub problems: Vec<Problem>,
    /// The terrain.
    pub terrain: Option<Terrain>,
    /// The lattice of the riverbed particles.
    pub lattice: Option<Lattice>,
    /// The reference system of the outputs.
    pub crs: OutputCrs,
    /// Walls as straight pieces in local coordinates (m).
    pub walls: Vec<[Vec2; 2]>,
    /// Where water may leave, in local coordinates.
    pub open_edges: OpenEdges,
    /// Cells that a dam, a levee, a wall with a crest or a building raises; ascending.
    pub raised: Vec<usize>,
    /// What brings water in or takes it out, in local coordinates.
    pub forcing: Forcing,
    /// The riverbed.
    pub bed: Option<BedParticles>,
    /// The ridges of the terrain that its cells do not see.
    pub ridges: Vec<Ridge>,
    /// The terrain by its pixels, where the maps are on them.
    pub pixels: Option<TerrainPixels>,
    /// Bodies of still water at the start.
    pub waters: Vec<StillBody>,
    /// The bodies on the lattice: depths, volumes, leaks.
    pub still_water: Option<StillWater>,
    /// Velocity (m/s) of the water of each cell at the start; empty where it rests.
    pub initial_velocity: Vec<Vec2>,
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
    /// Every input file, each once, in the order of the scenario.
    pub inputs: Vec<InputFile>,
    /// The gaps of a survey, where one is used.
    pub gap: Option<GapReport>,
    /// The estimate of particles and memory.
    pub needs: Needs,
}

impl Prepared {
    /// Whether a run must be refused.
    pub fn has_errors(&self) -> bool {
        self.problems.iter().any(|problem| problem.severity == Severity::Error)
    }
}

/// SHA-256 of a file in hexadecimal digits, if it can be read.
pub fn sha256(path: &Path) -> Option<String> {
    /// Takes bytes into the checksum; `sha2` itself is no longer a writer.
    struct Checksum(Sha256);
    impl std::io::Write for Checksum {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.update(bytes);
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let mut checksum = Checksum(Sha256::new());
    std::io::copy(&mut std::fs::File::open(path).ok()?, &mut checksum).ok()?;
    Some(checksum.0.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Opens and checks everything that a scenario names. Never fails: what is wrong is in `problems`.
pub fn prepare(scenario: &Scenario) -> Prepared {
    let mut findings = Findings::default();
    let spacing = scenario.resolution.value;
    if !(spacing.is_finite() && spacing > 0.0) {
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
    let (crs, terrain) = layers::open(scenario, &mut findings);
    // Every file is opened even where the terrain failed, so that one check reports all that is missing.
    let walls: Vec<_> =
        scenario.walls.iter().map(|source| places::pieces(source, crs.as_ref(), scenario, &mut findings)).collect();
    let open_lines: Vec<_> = scenario
        .open
        .iter()
        .map(|boundary| match boundary {
            OpenBoundary::Side(_) => None,
            OpenBoundary::Lines(source) => places::pieces(source, crs.as_ref(), scenario, &mut findings),
        })
        .collect();
    let bodies = scenario.initial.iter().flat_map(|water| {
        let bodies = water::bodies(water, crs.as_ref(), scenario, &mut findings);
        bodies.into_iter().map(|body| SourcedBody { source: &water.polygons, body })
    });
    let bodies: Vec<SourcedBody> = bodies.collect();
    let gauges = scenario
        .outputs
        .gauges
        .as_ref()
        .map(|source| places::gauges(source, crs.as_ref(), scenario.reproject, &mut findings))
        .unwrap_or_default();
    let rough = roughness::open(scenario, crs.as_ref(), &mut findings);
    let mut opened = forcing::open(scenario, crs.as_ref(), &mut findings);
    let dam = breach::open(scenario, crs.as_ref(), &mut findings);
    let moving = moving_bed::open(scenario, crs.as_ref(), &mut findings);
    let start = start::open(scenario, crs.as_ref(), &mut findings);
    let ground = ground::open(scenario, crs.as_ref(), &mut findings);
    let reaches = channels::open(scenario, crs.as_ref(), &mut findings);
    let mut prepared = Prepared {
        problems: Vec::new(),
        terrain,
        lattice: None,
        crs: crs
            .and_then(|crs| crs.written())
            .map_or(OutputCrs::Local, |(wkt2, authority)| OutputCrs::Projected { wkt2, authority }),
        walls: Vec::new(),
        open_edges: OpenEdges::default(),
        raised: Vec::new(),
        forcing: Forcing::default(),
        bed: None,
        ridges: Vec::new(),
        pixels: None,
        waters: Vec::new(),
        still_water: None,
        initial_velocity: Vec::new(),
        earlier_time: None,
        sections: Vec::new(),
        crossed: Vec::new(),
        channels: Vec::new(),
        gauges,
        inputs: inputs::all(scenario),
        gap: None,
        needs: Needs::default(),
    };
    let is_possible = spacing.is_finite() && spacing > 0.0;
    if is_possible && scenario.is_channels_alone() {
        place_channels_alone(scenario, &mut prepared, reaches, &mut findings);
    } else if is_possible {
        let lines = (walls, open_lines);
        let files = Files {
            forcing: &mut opened,
            rough: &rough,
            dam: dam.as_ref(),
            ground: &ground,
            start: &start,
            reaches,
            moving,
        };
        place_on_lattice(scenario, &mut prepared, lines, files, bodies, &mut findings);
    }
    prepared.sections.splice(0..0, opened.sections);
    prepared.problems = findings.into_problems();
    prepared
}

/// Of several files what they draw, as far as they could be read.
type Lines = Vec<Option<places::Drawn>>;

/// Files that are open, before what they hold is put on the lattice.
struct Files<'a> {
    forcing: &'a mut forcing::Opened,
    rough: &'a roughness::Opened,
    dam: Option<&'a breach::Opened>,
    ground: &'a ground::Opened,
    start: &'a start::Opened,
    reaches: Vec<Option<channels::Opened>>,
    moving: Vec<Option<moving_bed::Opened>>,
}

/// The lattice, and everything that is checked on it.
fn place_on_lattice(
    scenario: &Scenario,
    prepared: &mut Prepared,
    (walls, open_lines): (Lines, Lines),
    Files { forcing: opened, rough, dam, ground, start, reaches, moving }: Files<'_>,
    mut bodies: Vec<SourcedBody>,
    findings: &mut Findings,
) {
    let Some(terrain) = &prepared.terrain else {
        return;
    };
    let lattice = grid::lattice(terrain, scenario.resolution.value, &scenario.limits);
    let Some(lattice) = findings.take(&scenario.resolution, lattice) else {
        return;
    };
    let manning = scenario.roughness.manning.unwrap_or(0.0);
    let blocked = blocked::Blocked::new(ground.blocked(scenario), terrain, &lattice);
    let mut bed = place_bed(terrain, &lattice, scenario.numerics.bed, &blocked, manning);
    steps::check(scenario, terrain, (&bed, &blocked), findings);
    let mut changes = Changes::default();
    gaps::treat(scenario, &mut bed, &mut changes, findings);
    gaps::check_seams(scenario, &bed, findings);
    ridges::lower_gaps(scenario, &changes.on(terrain, &lattice), &mut bed);
    bed.manning = roughness::on_lattice(rough, &scenario.roughness, &lattice, &bed.elevation, findings);
    ground::on_lattice(ground, scenario, &mut bed, &mut changes, findings);
    let mut breach = breach::on_lattice(dam, scenario, &mut bed, findings);
    let mut walls_of_each = Vec::new();
    for (source, drawn) in scenario.walls.iter().zip(walls) {
        let drawn = drawn.unwrap_or_default();
        walls_of_each.push(places::on_lattice(source, &drawn, &bed, places::NOT_HELD, findings));
    }
    prepared.walls = walls_of_each.concat();
    wall_gaps::check(scenario, &prepared.walls, &bed, findings);
    if let Some(breach) = &breach {
        breach::check_way(scenario, breach, &bed, &prepared.walls, findings);
    }
    prepared.open_edges = places::open_edges(scenario, &open_lines, &bed, findings);
    prepared.forcing = forcing::on_lattice(opened, scenario, &bed, findings);
    (prepared.forcing.channels, prepared.channels) = channels::on_lattice(reaches, scenario, &bed, findings);
    water::check(&mut bodies, &bed, findings);
    ridges::find(scenario, &changes.on(terrain, &lattice), &mut bed);
    cover::find(scenario, terrain, &changes.on(terrain, &lattice), &mut bed);
    let is_complete = scenario.breach.is_some() == breach.is_some();
    let before = bed.elevation.clone();
    let ground = (terrain, &prepared.walls[..], is_complete);
    let mut still_water = breach::fill_behind(breach.as_ref(), &bodies, ground, (&mut bed, &mut changes), findings);
    prepared.raised = changes.raised().collect();
    let surface = changes.on(terrain, &lattice);
    ridges::find_again(scenario, &surface, &before, &mut bed);
    start::wet(start, scenario, (&bed, &changes), &mut still_water, findings);
    let without_earlier = bed.elevation.clone();
    let earlier =
        earlier::take_over(scenario, &prepared.crs, (breach.as_ref(), &changes), &mut bed, &mut still_water, findings);
    prepared.earlier_time = earlier.as_ref().map(|state| state.time);
    if let (Some(dam), Some(breach)) = (dam, &mut breach) {
        breach::settle(dam, breach, &before, &bed);
    }
    prepared.initial_velocity = earlier.map(|state| state.velocity).unwrap_or_default();
    let on_lattice = (&bed, &still_water, &prepared.walls[..]);
    plausible::check(&mut opened.placed, &prepared.forcing, scenario, on_lattice, findings);
    if let Some(breach) = &breach {
        breach::check_level(scenario, breach, &bed, &still_water, findings);
    }
    if let (Some(dam), Some(breach)) = (dam, &breach) {
        let section = breach::section(dam, breach, &opened.sections, &bed, &still_water);
        prepared.forcing.sections.push(forcing::pieces_of(&section, &lattice));
        prepared.sections.push(section);
    }
    let crossed = |pieces: &Vec<[Vec2; 2]>| {
        let cells: BTreeSet<usize> = pieces.iter().flat_map(|piece| burn::crossed(piece, &lattice)).collect();
        cells.into_iter().collect()
    };
    prepared.crossed = prepared.forcing.sections.iter().map(crossed).collect();
    prepared.forcing.breach = breach;
    prepared.forcing.moving_bed = moving_bed::on_lattice(moving, scenario, (&bed, &prepared.forcing), findings);
    let is_open = |middle: Vec2, normal: Vec2| {
        prepared.open_edges.is_open(middle, normal) || prepared.forcing.boundary_at(middle, normal).is_some()
    };
    let scene = lagrangian::Scene {
        bed: &bed,
        still: &still_water,
        bodies: bodies.iter().map(|body| body.source).collect(),
        velocity: &prepared.initial_velocity,
        walls: walls_of_each,
        is_open: &is_open,
        placed: &opened.placed,
        forcing: &prepared.forcing,
    };
    lagrangian::check(&scene, scenario, findings);
    if let Some(source) = &scenario.outputs.gauges {
        places::check_gauges(source, &prepared.gauges, terrain.extent(), (&surface, &bed), findings);
    }
    prepared.ridges = ridges::report(scenario, &surface, &bed, findings);
    // An earlier run fitted the bed to its shores, too: only one in which ground moved counts for the terrain itself.
    let own = if earlier::has_moved_bed(scenario) { &without_earlier } else { &bed.elevation };
    prepared.pixels = fine_maps::pixels(scenario, (&surface, terrain), (own, &bed), findings);
    let pixels = prepared.pixels.as_ref().map_or(0, |pixels| pixels.elevation.len());
    prepared.needs = needs(scenario, (&bed, &still_water), (&prepared.forcing.channels, pixels), findings);
    prepared.gap = grid::gap_report(terrain, &lattice);
    prepared.waters = bodies.into_iter().map(|body| body.body).collect();
    prepared.bed = Some(bed);
    prepared.still_water = Some(still_water);
    prepared.lattice = Some(lattice);
}

/// A plane without any cell, and the channels: what is asked of each cell of the plane is then asked of none.
fn place_channels_alone(
    scenario: &Scenario,
    prepared: &mut Prepared,
    reaches: Vec<Option<channels::Opened>>,
    findings: &mut Findings,
) {
    let lattice = Lattice { origin: Vec2::ZERO, columns: 0, rows: 0, spacing: scenario.resolution.value };
    let bed = BedParticles::from_elevation(lattice.clone(), Vec::new(), 0.0);
    let still_water = StillWater { depth: Vec::new(), body: Vec::new(), volumes: Vec::new() };
    (prepared.forcing.channels, prepared.channels) = channels::on_lattice(reaches, scenario, &bed, findings);
    prepared.needs = needs(scenario, (&bed, &still_water), (&prepared.forcing.channels, 0), findings);
    prepared.bed = Some(bed);
    prepared.still_water = Some(still_water);
    prepared.lattice = Some(lattice);
}

/// Particles and memory of a run; refuses more of them than their limits.
fn needs(
    scenario: &Scenario,
    (bed, still_water): (&BedParticles, &StillWater),
    (channels, pixels): (&[Channel], usize),
    findings: &mut Findings,
) -> Needs {
    let wet_cells = still_water.depth.iter().filter(|&&depth| depth > 0.0).count();
    let bed_particles = bed.elevation.iter().filter(|z| !z.is_nan()).count();
    let moving = scenario.numerics.motion == Motion::Lagrangian;
    let fluid = if moving { wet_cells } else { 0 };
    let channel_particles = channels.iter().map(|channel| channel.sections.len()).sum();
    let strips = |channel: &Channel| channel.sections.len() * channel.face_widths.first().map_or(0, Vec::len);
    let channel_strips = channels.iter().map(strips).sum();
    // A strip takes no more than a cell.
    let memory = (bed.lattice.len() + channel_strips) as f64 * BYTES_PER_CELL
        + fluid as f64 * BYTES_PER_FLUID_PARTICLE
        + pixels as f64 * fine_maps::BYTES_PER_PIXEL;
    let counts = [bed_particles, fluid, channel_strips];
    let (spacing, limits) = (bed.lattice.spacing, &scenario.limits);
    let beyond = grid::check_particles(counts, spacing, limits).or_else(|| grid::check_memory(memory, spacing, limits));
    if let Some(problem) = beyond {
        findings.add(&scenario.resolution, problem);
    }
    Needs { bed_particles, channel_particles, channel_strips, wet_cells, memory }
}

#[cfg(test)]
mod tests;
