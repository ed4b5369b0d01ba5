//! Everything that a scenario names, put on the lattice and checked there.

use std::collections::BTreeSet;

use super::findings::Findings;
use super::following::{self, Following};
use super::forcing::{self, breach, channels, moving_bed, plausible};
use super::ground::{self, Ground, burn, wall_ends};
use super::needs::needs;
use super::tracers;
use super::water::{self, SourcedBody, earlier, start};
use super::{Scene, Setup};
use super::{grid, places, series_rows};
use crate::bed::BedParticles;
use crate::geodata::Crs;
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::output::{ChannelProfile, Gauge, GroundSource, OutputCrs, Section, TerrainPixels};
use crate::scenario::{OpenBoundary, Scenario};
use crate::seeding::StillWater;
use crate::solver::{BedMotion, Breach, Forcing, OpenEdges, Tracer};
use crate::terrain::Terrain;

/// Of several files what they draw, as far as they could be read.
type Lines = Vec<Option<places::Drawn>>;

/// Whether a cell that follows lines holds a place (map coordinates), or a building; none where squares decide.
type Holds<'a> = &'a (dyn Fn(Vec2) -> Option<bool> + Sync);

/// Files that are open, before what they hold is put on the lattice.
pub(super) struct Files<'a> {
    crs: OutputCrs,
    walls: Lines,
    open_lines: Lines,
    closed_lines: Lines,
    bodies: Vec<SourcedBody<'a>>,
    gauges: Vec<Gauge>,
    forcing: forcing::Opened,
    dam: Option<breach::Opened>,
    moving: Vec<Option<moving_bed::Opened>>,
    start: start::Opened,
    ground: ground::Opened,
    reaches: Vec<Option<channels::Opened>>,
    tracers: tracers::Opened,
    /// The lines that cells follow; none on coarser levels, which have squares alone.
    followed: Option<Vec<places::Drawn>>,
}

impl<'a> Files<'a> {
    /// The same for a level of squares alone.
    pub fn of_squares(self) -> Files<'a> {
        Files { followed: None, ..self }
    }

    /// The lines that cells follow, and what is built into the ground; none on coarser levels.
    fn drawn(&self) -> Option<(&[places::Drawn], &ground::Opened)> {
        Some((self.followed.as_deref()?, &self.ground))
    }

    /// Opens all files but those of the terrain.
    pub fn open(scenario: &'a Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Files<'a> {
        let mut pieces = |source| places::pieces(source, crs, scenario, findings);
        let walls = scenario.walls.iter().map(&mut pieces).collect();
        let mut lines = |boundary: &'a OpenBoundary| match boundary {
            OpenBoundary::Side(_) => None,
            OpenBoundary::Lines(source) => pieces(source),
        };
        let mut along = |boundaries: &'a [OpenBoundary]| boundaries.iter().map(&mut lines).collect();
        let (open_lines, closed_lines) = (along(&scenario.open), along(&scenario.closed));
        let bodies = scenario.initial.iter().flat_map(|water| {
            let bodies = water::bodies(water, crs, scenario, findings);
            bodies.into_iter().map(|body| SourcedBody { source: &water.polygons, body })
        });
        let bodies = bodies.collect();
        let mut gauges = Vec::new();
        if let Some(source) = &scenario.outputs.gauges {
            gauges = places::gauges(source, crs, findings);
            series_rows::check(source, gauges.len(), scenario, findings);
        }
        Files {
            crs: crs
                .and_then(|crs| crs.written())
                .map_or(OutputCrs::Local, |(wkt2, authority)| OutputCrs::Projected { wkt2, authority }),
            walls,
            open_lines,
            closed_lines,
            bodies,
            gauges,
            ground: ground::open(scenario, crs, findings),
            forcing: forcing::open(scenario, crs, findings),
            dam: breach::open(scenario, crs, findings),
            moving: moving_bed::open(scenario, crs, findings),
            start: start::open(scenario, crs, findings),
            reaches: channels::open(scenario, crs, findings),
            tracers: tracers::open(scenario, crs, findings),
            followed: Some(following::open(scenario, crs, findings)),
        }
    }
}

/// The finest lattice, and everything that is checked on it; none where there can be no lattice.
pub(super) fn place(
    scenario: &Scenario,
    terrain: &Terrain,
    files: Files<'_>,
    findings: &mut Findings,
) -> Option<Setup> {
    let lattice = grid::lattice(terrain, scenario.reading.part, scenario.resolution.value, &scenario.limits);
    let lattice = findings.take(&scenario.resolution, lattice)?;
    grid::check_map_cells(scenario.outputs.cell, &lattice, findings);
    place_on(scenario, terrain, files, lattice, findings)
}

/// One lattice, and everything that is checked on it.
pub(super) fn place_on(
    scenario: &Scenario,
    terrain: &Terrain,
    mut files: Files<'_>,
    lattice: Lattice,
    findings: &mut Findings,
) -> Option<Setup> {
    let mut ground = ground::build(scenario, (terrain, &lattice), &files.ground, findings);
    let mut breach = breach::on_lattice(files.dam.as_ref(), scenario, &mut ground, findings);
    let edges = Edges::on_lattice(scenario, &mut files, (&ground, breach.as_ref()), findings);
    let walls = edges.walls;
    let (mut forcing, channels) = water_brought(scenario, &mut files, ground.bed(), findings);
    water::check(&mut files.bodies, ground.bed(), findings);
    ground.find_passes_and_cover(scenario);
    let at_start = AtStart::fill(scenario, &files, (&mut breach, &walls), &mut ground, findings);
    let start = (ground.bed(), &at_start.still_water, &walls[..]);
    plausible::check(&mut files.forcing.placed, &forcing, scenario, start, findings);
    let sections =
        sections_with_breach(scenario, &mut files, breach.as_ref(), (&ground, &at_start), &mut forcing, findings);
    forcing.tracers = carried(scenario, &files, (&ground, &at_start), findings);
    forcing.breach = breach;
    forcing.moving_bed = moving_beds(scenario, &mut files, (ground.bed(), &forcing), findings);
    let stands = (&forcing, &edges.open, &walls[..], (&files.bodies[..], &at_start.still_water));
    let following = following::find(scenario, files.drawn(), &ground, stands, findings);
    let made = (terrain, &ground, following.as_ref());
    let (pixels, ground_source) = maps_of_ground(scenario, made, &at_start, &files.gauges, findings);
    let counted = (&forcing.channels[..], ground_source.of_pixels.len(), files.gauges.len());
    let scene = Scene {
        needs: needs(scenario, (ground.bed(), &at_start.still_water), counted, findings),
        crs: files.crs,
        ground_source,
        ridges: ground.ridges(scenario, findings),
        raised: at_start.raised,
        followed: Vec::new(),
        banks: Vec::new(),
        earlier_time: at_start.earlier_time,
        at_banks: places::cells_at_banks(&files.gauges, &ground.surface(), ground.bed()),
        walls,
        open_edges: edges.open,
        closed_edges: edges.closed,
        crossed: forcing.sections.iter().map(|pieces| crossed(pieces, &lattice)).collect(),
        forcing,
        waters: files.bodies.into_iter().map(|body| body.body).collect(),
        sections,
        channels,
        gauges: files.gauges,
        lattice,
    };
    Some(Setup {
        still_water: at_start.still_water,
        initial_velocity: at_start.velocity,
        pixels,
        gap: grid::gap_report(terrain, &scene.lattice),
        scene,
        bed: ground.into_bed(),
        coarser: Vec::new(),
        wanted: None,
        following,
    })
}

/// Walls and open edges.
struct Edges {
    /// The straight pieces of all walls, and what leads their ends to the edge of the terrain (local coordinates, m).
    walls: Vec<[Vec2; 2]>,
    open: OpenEdges,
    /// Where a wall is known to stand.
    closed: OpenEdges,
}

impl Edges {
    fn on_lattice(
        scenario: &Scenario,
        files: &mut Files<'_>,
        (ground, breach): (&Ground<'_>, Option<&Breach>),
        findings: &mut Findings,
    ) -> Edges {
        let bed = ground.bed();
        let mut walls = Vec::new();
        for (source, drawn) in scenario.walls.iter().zip(std::mem::take(&mut files.walls)) {
            let drawn = drawn.unwrap_or_default();
            walls.extend(places::on_lattice(source, &drawn, bed, places::NOT_HELD, findings));
        }
        let pixel = |place: Vec2| ground.terrain().finest_cell_at(bed.lattice.to_map(place)).unwrap_or(0.0);
        walls.extend(wall_ends::to_edge(&walls, bed, pixel));
        if let Some(breach) = breach {
            breach::check_way(scenario, breach, bed, &walls, findings);
        }
        let mut along = |edges, lines| places::edges_along(scenario, edges, lines, bed, findings);
        let (open, closed) = (along(&scenario.open, &files.open_lines), along(&scenario.closed, &files.closed_lines));
        Edges { walls, open, closed }
    }
}

/// What brings water in or takes it out, and the channels of one dimension.
fn water_brought(
    scenario: &Scenario,
    files: &mut Files<'_>,
    bed: &BedParticles,
    findings: &mut Findings,
) -> (Forcing, Vec<ChannelProfile>) {
    let mut forcing = forcing::on_lattice(&mut files.forcing, scenario, bed, findings);
    let channels;
    (forcing.channels, channels) = channels::on_lattice(std::mem::take(&mut files.reaches), scenario, bed, findings);
    channels::check_boundaries(&files.forcing.placed, &forcing.channels, scenario, &bed.lattice, findings);
    (forcing, channels)
}

/// What is carried with the water.
fn carried(
    scenario: &Scenario,
    files: &Files<'_>,
    (ground, at_start): (&Ground<'_>, &AtStart),
    findings: &mut Findings,
) -> Vec<Tracer> {
    let marked = (ground.bed(), &at_start.still_water);
    tracers::on_lattice(&files.tracers, scenario, marked, &files.forcing.source_counts(), findings)
}

/// The parts of the bed that move.
fn moving_beds(
    scenario: &Scenario,
    files: &mut Files<'_>,
    made: (&BedParticles, &Forcing),
    findings: &mut Findings,
) -> Vec<BedMotion> {
    moving_bed::on_lattice(std::mem::take(&mut files.moving), scenario, made, findings)
}

/// The water at the start.
struct AtStart {
    still_water: StillWater,
    /// Velocity (m/s) of each cell; empty where all water rests.
    velocity: Vec<Vec2>,
    /// The time (s) of the earlier run that this one goes on from.
    earlier_time: Option<f64>,
    /// Cells that are raised or lifted, ascending.
    raised: Vec<usize>,
    /// The bed (m) without that of an earlier run.
    without_earlier: Vec<f64>,
}

impl AtStart {
    /// Fills still water, rivers and what an earlier run left, and fits the ground to it.
    fn fill(
        scenario: &Scenario,
        files: &Files<'_>,
        (breach, walls): (&mut Option<Breach>, &[[Vec2; 2]]),
        ground: &mut Ground<'_>,
        findings: &mut Findings,
    ) -> AtStart {
        let is_complete = scenario.breach.is_some() == breach.is_some();
        let before = ground.bed().elevation.clone();
        let mut still_water =
            breach::fill_behind(breach.as_ref(), &files.bodies, (walls, is_complete), ground, findings);
        let raised = ground.changes().raised().collect();
        ground.find_passes_again(scenario, &before);
        start::wet(&files.start, scenario, (ground.bed(), ground.changes()), &mut still_water, findings);
        let without_earlier = ground.bed().elevation.clone();
        let stands = (breach.as_ref(), walls);
        let earlier = earlier::take_over(scenario, &files.crs, stands, ground, &mut still_water, findings);
        if let (Some(dam), Some(breach)) = (&files.dam, breach) {
            breach::settle(dam, breach, &before, ground.bed());
        }
        let earlier_time = earlier.as_ref().map(|state| state.time);
        let velocity = earlier.map(|state| state.velocity).unwrap_or_default();
        AtStart { still_water, velocity, earlier_time, raised, without_earlier }
    }
}

/// The cross-sections, the last of them along the dam where there is one; checks the levels of its breach.
fn sections_with_breach(
    scenario: &Scenario,
    files: &mut Files<'_>,
    breach: Option<&Breach>,
    (ground, at_start): (&Ground<'_>, &AtStart),
    forcing: &mut Forcing,
    findings: &mut Findings,
) -> Vec<Section> {
    let (bed, water) = (ground.bed(), &at_start.still_water);
    let mut sections = std::mem::take(&mut files.forcing.sections);
    let Some(breach) = breach else { return sections };
    breach::check_level(scenario, breach, bed, water, findings);
    if let Some(dam) = &files.dam {
        let section = breach::section(dam, breach, &sections, bed, water);
        forcing.sections.push(forcing::pieces_of(&section, &bed.lattice));
        sections.push(section);
    }
    sections
}

/// Reports gauges that lie where nothing is measured.
fn check_gauges(
    scenario: &Scenario,
    terrain: &Terrain,
    (ground, holds): (&Ground<'_>, Holds<'_>),
    gauges: &[Gauge],
    findings: &mut Findings,
) {
    if let Some(source) = &scenario.outputs.gauges {
        let on = (&ground.surface(), ground.bed(), holds);
        places::check_gauges(source, gauges, terrain.extent(), on, findings);
    }
}

/// The pixels of the terrain for the maps, where they are asked for, and who set the ground of cells and pixels; checks where gauges lie on it.
fn maps_of_ground(
    scenario: &Scenario,
    (terrain, ground, following): (&Terrain, &Ground<'_>, Option<&Following>),
    at_start: &AtStart,
    gauges: &[Gauge],
    findings: &mut Findings,
) -> (Option<TerrainPixels>, GroundSource) {
    let lattice = &ground.bed().lattice;
    let holds = |place: Vec2| following?.holds(lattice, lattice.to_local(place));
    check_gauges(scenario, terrain, (ground, &holds), gauges, findings);
    // An earlier run fitted the bed to its shores, too: only one in which ground moved counts for the terrain itself.
    let own = if earlier::has_moved_bed(scenario) { &at_start.without_earlier } else { &ground.bed().elevation };
    let surfaces = [ground.surface(), ground.surface_beside_buildings()];
    let pixels = ground::pixels(scenario, (&surfaces, terrain, &holds), (own, ground.bed()), findings);
    let (pixels, set_by_of_pixels) = pixels.map_or((None, Vec::new()), |(pixels, set_by)| (Some(pixels), set_by));
    (pixels, ground::sources(scenario, ground, set_by_of_pixels))
}

/// The cells that a cross-section crosses, ascending.
fn crossed(pieces: &[[Vec2; 2]], lattice: &Lattice) -> Vec<usize> {
    let cells: BTreeSet<usize> = pieces.iter().flat_map(|piece| burn::crossed(piece, lattice)).collect();
    cells.into_iter().collect()
}

/// A plane without any cell, and the channels: what is asked of each cell of the plane is then asked of none.
pub(super) fn channels_alone(scenario: &Scenario, files: Files<'_>, findings: &mut Findings) -> Setup {
    let lattice = Lattice::new(Vec2::ZERO, 0, 0, scenario.resolution.value);
    let bed = BedParticles::from_elevation(lattice, Vec::new(), 0.0);
    let still_water = StillWater { depth: Vec::new(), body: Vec::new(), volumes: Vec::new() };
    let mut forcing = Forcing::default();
    let channels;
    (forcing.channels, channels) = channels::on_lattice(files.reaches, scenario, &bed, findings);
    let gauges = channels.iter().map(|channel| channel.gauges.len()).sum();
    let needs = needs(scenario, (&bed, &still_water), (&forcing.channels, 0, gauges), findings);
    let scene = Scene {
        lattice: bed.lattice.clone(),
        crs: files.crs,
        ground_source: GroundSource::default(),
        ridges: Vec::new(),
        raised: Vec::new(),
        followed: Vec::new(),
        banks: Vec::new(),
        at_banks: Vec::new(),
        walls: Vec::new(),
        open_edges: OpenEdges::default(),
        closed_edges: OpenEdges::default(),
        waters: Vec::new(),
        earlier_time: None,
        sections: files.forcing.sections,
        crossed: Vec::new(),
        channels,
        gauges: files.gauges,
        needs,
        forcing,
    };
    Setup {
        bed,
        still_water,
        initial_velocity: Vec::new(),
        pixels: None,
        gap: None,
        scene,
        coarser: Vec::new(),
        wanted: None,
        following: None,
    }
}
