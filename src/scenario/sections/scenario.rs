//! The scenario as a whole: its sections, what must go together, and its parts that are single values.

use std::path::Path;

use super::boundaries::BoundaryEntry;
use super::breach::OneBreach;
use super::channel::ChannelEntry;
use super::ground::Structures;
use super::initial::InitialEntry;
use super::limits::LimitsSection;
use super::moving_bed::MovingBedEntry;
use super::numerics::NumericsSection;
use super::outputs::OutputsSection;
use super::rain::RainSection;
use super::resolution::Resolution;
use super::roughness::RoughnessSection;
use super::sources::SourceEntry;
use super::terrain::Terrain;
use super::tracers::TracerEntry;
use super::{
    boundaries, breach, channel, channels_alone, ground, initial, limits, moving_bed, numerics, outputs, rain,
    resolution, roughness, sources, terrain, tracers,
};
use crate::error::{Problem, ProblemKind, plain_name};
use crate::scenario::fields::{DateTime, EndTime, FormatVersion, Quantity, Text};
use crate::scenario::methods::{Formulation, Motion};
use crate::scenario::model::{CrsChoice, Reading, Scenario, Sourced};
use crate::scenario::read::{FromNode, NonEmpty, Reader, section};
use crate::scenario::tree::{Node, Value};
use crate::scenario::yaml::{Section, Yaml, filled, quantity, quoted};

section! {
    /// A flood scenario: ground, water, what comes in and goes out, and how it is computed.
    ScenarioFile, example "{...}", check check_scenario {
        /// Version of the scenario format. Codes: version.
        floodsim: FormatVersion,
        /// Heading of maps and reports; the name of the scenario when absent.
        title: Option<Text>,
        /// Coordinate reference system of the run in metres, such as `EPSG:27572`, or `local` for plain metres; that of the
        /// terrain, `local` without terrain, when absent. Codes: unknown-crs, no-crs, distorted-crs, geographic-crs,
        /// not-metric-crs, crs-set-aside.
        crs: Option<Text>,
        /// Terrain: one raster file, or layers and what shapes them; required unless all water is in `channels` when absent.
        /// Codes: no-terrain.
        terrain: Option<Terrain>,
        /// Manning's n of the ground; required unless there are channels alone, each with its own, when absent.
        roughness: Option<RoughnessSection>,
        /// Walls and buildings; none when absent.
        structures: Option<Structures>,
        /// Water at the start; required unless water comes in by a boundary, a source, rain or a channel when absent. Codes:
        /// bed-of-earlier-run, moving-bed-of-earlier-run, water-without-terrain, drawn-fields, unfinished-run.
        initial: Option<NonEmpty<InitialEntry>>,
        /// Parts of the edge of the terrain that let water through; all edges are walls when absent.
        boundaries: Option<Vec<BoundaryEntry>>,
        /// Places and lines at which a given discharge comes out of the ground; none when absent.
        sources: Option<Vec<SourceEntry>>,
        /// Rain on the whole terrain, which makes every cell active; none when absent. Codes: not-a-row, no-variable, rain-held-back.
        rain: Option<RainSection>,
        /// A dam that stands at the start and breaks, one in a run; none when absent. Codes: one-breach, method-combination.
        breach: Option<OneBreach>,
        /// Parts of the bed that move as prescribed: ground that rises or sinks, and slides; none when absent. Codes: method-combination.
        moving_bed: Option<Vec<MovingBedEntry>>,
        /// Reaches that are computed in one dimension, for Eulerian particles; none when absent. Codes: method-combination,
        /// channels-of-earlier-run, no-maps.
        channels: Option<Vec<ChannelEntry>>,
        /// What is carried with the water, in the balanced formulation on cells of one spacing; none when absent. Codes:
        /// method-combination.
        tracers: Option<Vec<TracerEntry>>,
        /// Spacing: the distance of two neighbouring particles and the edge of a cell; levels of cells, fine where it matters; or
        /// `auto`, by which the program chooses. Codes: bad-resolution, resolution-too-coarse, finer-than-terrain, ridge-in-cell, steps-in-cells, levels-for-eulerian.
        resolution: Resolution,
        /// Simulated time.
        time: Time,
        /// What is written, where and how often; all outputs to `runs/NAME` when absent.
        outputs: Option<OutputsSection>,
        /// Methods and their numbers; those of the preset `balanced` when absent.
        numerics: Option<NumericsSection>,
        /// Limits of memory and particles; 80 % of the machine's memory and 50 million particles when absent.
        limits: Option<LimitsSection>,
    }
}

/// Why the variational formulation does not have something, as the end of a sentence.
fn why_not(what: &str) -> &'static str {
    match what {
        "rain" => "lifts the water, and the depths of this formulation are sums over particles of fixed volume",
        "channels" => "meet the plane at the faces of cells, which these particles do not have",
        "cross-sections" => "are measured at the faces of cells, which these particles do not have",
        "a dam that breaks" | "a moving bed" => "changes the bed in time, and that of this formulation stays the same",
        _ => "would need particles that come and go, and those of this formulation stay the same",
    }
}

/// Refuses what particles that move or channels alone do not have, and a scenario without any water.
fn check_scenario(node: &Node, reader: &mut Reader) -> Option<()> {
    outputs::tell_of_outputs(node, reader);
    initial::check_alone(node, reader)?;
    let is_placed = node.has("terrain") || channels_alone::check(node, reader).is_some();
    let is_rough = node.has("roughness")
        || channels_alone::are_rough(node)
        || RoughnessSection::when_absent(node, "roughness", reader).is_some();
    let is_whole = is_placed && is_rough;
    let entries = match node.get("boundaries").map(|list| &list.value) {
        Some(Value::List(entries)) => entries.as_slice(),
        _ => &[],
    };
    boundaries::check_closed(entries, reader);
    let is_fed = node.has("sources") || node.has("rain") || node.has("channels") || entries.iter().any(feeds);
    if !is_fed && !node.has("initial") {
        NonEmpty::<InitialEntry>::when_absent(node, "initial", reader);
        return None;
    }
    let has_methods = check_moving_particles(node, entries, reader)?;
    let has_tracers = tracers::check(node, reader).is_some();
    (is_whole && has_methods && has_tracers).then_some(())
}

/// What says something of the water that comes in.
fn feeds(entry: &Node) -> bool {
    ["discharge", "level", "stage", "wave"].iter().any(|key| entry.has(key))
}

/// What may let water in.
pub(super) fn lets_in(entry: &Node) -> bool {
    feeds(entry) || entry.get("type").is_some_and(|kind| kind.value == Value::Text("free".to_owned()))
}

/// Whether the particles have all that the scenario asks for, where they move; refuses what they do not have. None where a method has no
/// known name, which is reported elsewhere.
fn check_moving_particles(node: &Node, boundaries: &[Node], reader: &mut Reader) -> Option<bool> {
    let empty = Node { value: Value::Section(Vec::new()), ..node.clone() };
    let numerics = node.get("numerics").filter(|n| matches!(n.value, Value::Section(_))).unwrap_or(&empty);
    let formulation = numerics::meant(numerics, "formulation", Formulation::default())?;
    let usual = formulation.usual_motion();
    if numerics::meant(numerics, "motion", usual)? == Motion::Eulerian {
        return Some(true);
    }
    let mut is_fit = resolution::check_lagrangian(node, reader);
    if formulation == Formulation::Balanced {
        let alone = node.get("channels").filter(|channels| channels.value != Value::Empty && !node.has("terrain"));
        let Some(channels) = alone else { return Some(is_fit) };
        let problem = Problem::error(
            ProblemKind::Scenario,
            "method-combination",
            channels.key.clone(),
            "nothing moves in channels alone",
        )
        .with_cause("the sections of a channel of one dimension rest, whatever the motion")
        .with_remedy("leave `numerics.motion` out (or write `motion: eulerian`), or add `terrain`");
        reader.report(channels, problem);
        return Some(false);
    }
    // An entry that says nothing of the water beyond is refused by the reader of boundaries.
    let has_condition = |entry: &Node| {
        let is_free = entry.get("type").is_some_and(|kind| kind.value == Value::Text("free".to_owned()));
        is_free || feeds(entry) || ["normal_depth", "rating"].iter().any(|key| entry.has(key))
    };
    let sections = node.get("outputs").and_then(|outputs| outputs.get("sections"));
    let foreign = boundaries
        .iter()
        .filter(|entry| matches!(entry.value, Value::Section(_)) && has_condition(entry))
        .map(|entry| (Some(entry), "a boundary with a condition"))
        .chain([
            (node.get("sources"), "sources"),
            (node.get("rain"), "rain"),
            (node.get("channels"), "channels"),
            (node.get("breach"), "a dam that breaks"),
            (node.get("moving_bed"), "a moving bed"),
            (sections, "cross-sections"),
        ]);
    for (place, what) in foreign {
        let Some(place) = place.filter(|place| place.value != Value::Empty) else { continue };
        let message = format!("the particles of the variational formulation know no {}", what.trim_start_matches("a "));
        let otherwise = if what == "a dam that breaks" {
            "; for a dam that is gone at the start, take `breach` out"
        } else {
            ", or take this out"
        };
        let problem = Problem::error(ProblemKind::Scenario, "method-combination", place.key.clone(), message)
            .with_cause(format!("{what} {}", why_not(what)))
            .with_remedy(format!("leave `numerics.formulation` out (or write `formulation: balanced`){otherwise}"));
        reader.report(place, problem);
        is_fit = false;
    }
    Some(is_fit)
}

section! {
    /// Simulated time.
    Time, example "{end: 1 h}" {
        /// End of the run, counted from its start.
        end: Quantity<EndTime>,
        /// Date and time of t = 0, from which dates in series count: UTC, or with an offset such as `+02:00`, from 1582-10-15 on;
        /// none when absent. Codes: date, dates-as-times, two-starts.
        reference: Option<DateTime>,
    }
}

pub(in crate::scenario) fn fill_in(written: ScenarioFile, file: &Path) -> Scenario {
    let name = plain_name(&scenario_name(file));
    let end_time = written.time.end.value();
    let (resolution, levels, auto) = resolution::resolved(written.resolution);
    let has_terrain = written.terrain.is_some();
    let numerics = numerics::resolved(written.numerics.as_ref());
    let follows_banks = numerics.has_cells();
    let (layers, reproject, mut ground) =
        written.terrain.map(|terrain| terrain::resolved(terrain, follows_banks)).unwrap_or_default();
    let (walls, buildings) = written.structures.map_or((None, None), |found| (found.walls, found.buildings));
    let walls = walls.unwrap_or_default();
    ground.breaklines.extend(ground::breaklines(Vec::new(), &walls).0);
    ground.buildings = buildings.map(ground::buildings);
    let (bodies, start) = initial::split(written.initial.map_or_else(Vec::new, |entries| entries.0));
    let edges = boundaries::resolved(written.boundaries.unwrap_or_default());
    Scenario {
        file: file.to_owned(),
        title: written.title.map_or_else(|| name.clone(), |title| title.0.value),
        crs: match written.crs {
            None => {
                let value = if has_terrain { CrsChoice::FromTerrain } else { CrsChoice::Local };
                Sourced { value, key: "crs".to_owned(), place: None }
            }
            Some(crs) => {
                let value = match crs.0.value.trim() {
                    "local" => CrsChoice::Local,
                    "terrain" => CrsChoice::FromTerrain,
                    named => CrsChoice::Named(named.to_owned()),
                };
                Sourced { value, key: crs.0.key, place: crs.0.place }
            }
        },
        layers,
        reproject,
        ground,
        roughness: written.roughness.map(roughness::resolved).unwrap_or_default(),
        initial: bodies.into_iter().filter_map(initial::resolved).collect(),
        start,
        walls: walls.into_iter().filter(|wall| !wall.has_crest()).map(|wall| wall.lines.0).collect(),
        open: edges.open,
        boundaries: edges.known,
        closed: edges.closed,
        sources: sources::resolved(written.sources.unwrap_or_default()),
        rain: written.rain.and_then(rain::resolved),
        breach: written.breach.and_then(|breach| breach::resolved(breach.0)),
        moving_bed: moving_bed::resolved(written.moving_bed.unwrap_or_default()),
        channels: channel::resolved(written.channels.unwrap_or_default()),
        tracers: tracers::resolved(written.tracers.unwrap_or_default()),
        outputs: outputs::resolved(written.outputs, &name, file, resolution.value, end_time),
        resolution,
        levels,
        auto,
        reading: Reading::default(),
        end_time,
        reference_time: written.time.reference.map(|reference| reference.0),
        numerics,
        limits: limits::resolved(written.limits),
    }
}

/// The name of a scenario: that of its folder if the file is called `scenario`, that of the file otherwise.
fn scenario_name(file: &Path) -> String {
    let stem = file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let stem = stem.trim_end_matches(".resolved").to_owned();
    if stem != "scenario" {
        return stem;
    }
    let absolute = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
    absolute.parent().and_then(Path::file_name).map_or(stem, |folder| folder.to_string_lossy().into_owned())
}

/// Title, ground, and water at the start.
fn place(scenario: &Scenario) -> Section {
    let crs = match &scenario.crs.value {
        CrsChoice::FromTerrain => "terrain".into(),
        CrsChoice::Local => "local".into(),
        CrsChoice::Named(name) => quoted(name),
    };
    Section::default()
        .with("floodsim", 1.0)
        .with("title", quoted(&scenario.title))
        .with("crs", crs)
        .with_some("terrain", (!scenario.is_channels_alone()).then(|| terrain::written(scenario)))
        .with_some("roughness", filled(roughness::written(scenario)))
        .with_some("structures", filled(ground::written(scenario)))
        .with_list("initial", initial::written(scenario))
}

/// Resolution, time, outputs, methods and limits.
fn run(scenario: &Scenario) -> Section {
    let reference = scenario.reference_time.map(|reference| quoted(&reference.to_string()));
    Section::default()
        .with("resolution", resolution::written(scenario))
        .with(
            "time",
            Section::default().with("end", quantity(scenario.end_time, "s")).with_some("reference", reference),
        )
        .with("outputs", outputs::written(scenario))
        .with("numerics", numerics::written(scenario))
        .with("limits", Yaml::Entry(limits::written(&scenario.limits)))
}

impl Scenario {
    /// The text of `scenario.resolved.yaml`: every default filled in, paths absolute, quantities in SI units with all their
    /// digits. Running it gives the same run.
    pub fn to_yaml(&self) -> String {
        let section = place(self)
            .with_list("boundaries", boundaries::written(self))
            .with_list("sources", sources::written(self))
            .with_some("rain", self.rain.as_ref().map(|rain| rain::written(&rain.value)))
            .with_some("breach", self.breach.as_ref().map(breach::written))
            .with_list("moving_bed", self.moving_bed.iter().map(moving_bed::written).collect())
            .with_list("channels", self.channels.iter().map(channel::written).collect())
            .with_list("tracers", self.tracers.iter().map(|tracer| tracers::written(tracer, self)).collect())
            .and(run(self));
        format!("# The scenario with every default filled in; running it gives the same run.\n{}", section.text())
    }
}
