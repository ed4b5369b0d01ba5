//! The scenario as written in YAML: every section with its keys; the contract is DESIGN section 2.
//!
//! The JSON Schema of `floodsim schema` comes from these same declarations, so that it cannot disagree with the reader.
//! Not here: the defaults of keys that may be absent (`resolve.rs`).

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::breach::OneBreach;
use super::channel::ChannelEntry;
use super::channels_alone;
use super::choices::{Choice, Chosen, ElevationUnit, OpenType};
use super::fields::{
    Coordinate, Count, Courant, DateTime, Discharge, Duration, EndTime, FormatVersion, Gravity, Height, InputFile,
    Intensity, Length, Level, Manning, Memory, Offset, Quantity, RasterSeriesFile, Slope, Text, VectorFile,
};
use super::ground::{BreaklineEntry, BuildingsSection, GapsChoice, LayerMode, Wall};
use super::methods::{
    BedMethod, BedSlope, Core, Formulation, Integrator, Kernel, Method, Motion, Preset, Reconstruction, Seeding,
    Stabilisation, Turbulence, WallMethod,
};
use super::model::{OutputPart, PointInterpolation, RainUnit, Side, Sourced, Stamp};
use super::moving_bed::MovingBedEntry;
use super::read::{FromNode, NonEmpty, Reader, section};
use super::start::{FrameTime, check_alone, check_initial};
use super::timed::{Changing, RatingFile};
use super::tree::{Node, Value};
use super::units::{Dimension, INTENSITY, LENGTH, TIME};
use crate::error::{Problem, ProblemKind};

section! {
    /// A flood scenario.
    ScenarioFile, example "{...}", check check_scenario {
        /// Version of the scenario format.
        floodsim: FormatVersion,
        /// Title; the name of the scenario when absent.
        title: Option<Text>,
        /// Coordinate reference system such as EPSG:27572, or `local` for plain metres; that of the terrain when absent.
        crs: Option<Text>,
        /// Terrain: a raster file, or layers; not needed where there are channels.
        terrain: Option<Terrain>,
        /// Roughness of the ground; not needed where there are channels alone, each with its own.
        roughness: Option<Roughness>,
        /// Structures that hold or divert water.
        structures: Option<Structures>,
        /// Bodies of still water at the start; needed unless water comes by a boundary, a source or rain.
        initial: Option<NonEmpty<InitialEntry>>,
        /// Open edges, where water comes and goes; all other edges are walls.
        boundaries: Option<Vec<BoundaryEntry>>,
        /// Water that comes out of the ground.
        sources: Option<Vec<SourceEntry>>,
        /// Rain on the whole terrain.
        rain: Option<RainSection>,
        /// A dam that breaks.
        breach: Option<OneBreach>,
        /// Parts of the bed that move: ground that rises or sinks, and slides.
        moving_bed: Option<Vec<MovingBedEntry>>,
        /// Channels that are computed in one dimension.
        channels: Option<Vec<ChannelEntry>>,
        /// Distance of two particles.
        resolution: Quantity<Length>,
        /// Simulated time.
        time: Time,
        /// What to write, and where.
        outputs: Option<OutputsSection>,
        /// Methods and their numbers.
        numerics: Option<NumericsSection>,
        /// Limits that are checked before anything is computed.
        limits: Option<LimitsSection>,
    }
}

/// Terrain: a raster file alone, or a section with layers.
#[derive(Clone, Debug)]
pub enum Terrain {
    /// `terrain: dem.tif`
    Raster(InputFile),
    /// `terrain: {layers: [...]}`
    Layers(TerrainLayers),
}

impl FromNode for Terrain {
    fn example() -> String {
        InputFile::example()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        // Text with a colon and a blank is a section with wrong indentation rather than the name of a file.
        match &node.value {
            Value::Text(text) if !text.contains(": ") => InputFile::from_node(node, reader).map(Terrain::Raster),
            _ => TerrainLayers::from_node(node, reader).map(Terrain::Layers),
        }
    }
}

impl JsonSchema for Terrain {
    fn schema_name() -> Cow<'static, str> {
        "Terrain".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let (file, layers) = (generator.subschema_for::<InputFile>(), generator.subschema_for::<TerrainLayers>());
        json_schema!({"anyOf": [file, layers]})
    }
}

section! {
    /// Terrain layers.
    TerrainLayers, example "dem.tif" {
        /// Layers; later ones win where they have data.
        layers: NonEmpty<LayerEntry>,
        /// Whether terrain in another or a geographic reference system is warped to that of the run; false when absent.
        reproject: Option<bool>,
        /// Lines along which the bed is raised or lowered.
        breaklines: Option<Vec<BreaklineEntry>>,
        /// What becomes of holes in the terrain: wall, error, or filled up to a size; wall when absent.
        gaps: Option<GapsChoice>,
    }
}

section! {
    /// A terrain layer: a raster, or bare survey points.
    LayerEntry, example "{raster: dem.tif}", check check_layer {
        /// A raster file.
        raster: Option<InputFile>,
        /// Survey points: a text file with columns x, y, z, or a vector file.
        points: Option<InputFile>,
        /// Added to every elevation; 0 when absent.
        offset: Option<Quantity<Offset>>,
        /// Unit of the elevations of a raster; metres when absent.
        unit: Option<Chosen<ElevationUnit>>,
        /// Interpolation between points; inverse_distance when absent.
        interpolation: Option<Chosen<PointInterpolation>>,
        /// Distance to the nearest point beyond which there is no terrain; needed with points.
        max_gap: Option<Quantity<Length>>,
        /// File of polygons inside of which the layer counts; everywhere when absent.
        clip: Option<VectorFile>,
        /// How it meets the layers under it: replace, min or max; replace when absent.
        mode: Option<Chosen<LayerMode>>,
    }
}

fn check_layer(node: &Node, reader: &mut Reader) -> Option<()> {
    let kind = reader.exactly_one(node, &["raster", "points"])?;
    let foreign: &[&str] = if kind == "raster" { &["interpolation", "max_gap"] } else { &["unit"] };
    let mut is_fit = true;
    for name in foreign {
        if let Some(value) = node.get(name) {
            reader.error(value, "conflict", format!("`{name}` does not go with `{kind}`"), "take it out");
            is_fit = false;
        }
    }
    if kind == "points" && node.get("max_gap").is_none() {
        let remedy = "add `max_gap: 200 m`: the distance to the nearest point beyond which there is no terrain";
        reader.error(node, "missing-key", "survey points need the key `max_gap`", remedy);
        is_fit = false;
    }
    is_fit.then_some(())
}

section! {
    /// Roughness of the ground.
    Roughness, example "{manning: 0.033}", check check_roughness {
        /// Manning's n, everywhere.
        manning: Option<Quantity<Manning>>,
        /// Raster of n, or of classes when there is a table.
        raster: Option<InputFile>,
        /// CSV with the columns class, name, n.
        table: Option<InputFile>,
        /// Manning's n where the raster gives none; that is an error when absent.
        default: Option<Quantity<Manning>>,
        /// Polygons with an attribute `n`, which win over all else.
        polygons: Option<VectorFile>,
    }
}

/// Refuses what does not go together, and warns of a roughness that is possible, but hardly meant.
fn check_roughness(node: &Node, reader: &mut Reader) -> Option<()> {
    if let Some(manning) = node.get("manning")
        && let Value::Text(text) = &manning.value
        && text.parse::<f64>().is_ok_and(|n| n > 0.0 && n < 0.005)
    {
        let message = format!("a Manning roughness of `{text}` is smoother than glass");
        reader.warning(manning, "roughness", message, "natural ground has 0.02 to 0.15, smooth concrete 0.012");
    }
    let kind = reader.exactly_one(node, &["manning", "raster"])?;
    let foreign: &[&str] = if kind == "manning" { &["table", "default"] } else { &[] };
    let mut is_fit = true;
    for name in foreign {
        if let Some(value) = node.get(name) {
            let remedy = "take it out, or give a `raster` in place of `manning`";
            reader.error(value, "conflict", format!("`{name}` goes with `raster`, not with `manning`"), remedy);
            is_fit = false;
        }
    }
    is_fit.then_some(())
}

section! {
    /// Structures.
    Structures, example "{walls: [{lines: dam_line.geojson}]}" {
        /// Walls that no water crosses, such as a dam that stands, or only over their crest.
        walls: Option<Vec<Wall>>,
        /// Footprints of buildings.
        buildings: Option<BuildingsSection>,
    }
}

section! {
    /// Water at the start: a polygon with a level or a depth, a river with a depth, or the state of an earlier run.
    InitialEntry, example "{reservoir: reservoir.geojson, level: 100 m}", check check_initial {
        /// Polygon of a reservoir.
        reservoir: Option<VectorFile>,
        /// Polygon of the sea.
        sea: Option<VectorFile>,
        /// Polygon of any other water.
        water: Option<VectorFile>,
        /// Level of the water; from the attribute of the polygon when absent.
        level: Option<Quantity<Level>>,
        /// Attribute of the polygon that holds the level in metres.
        level_field: Option<Text>,
        /// Depth of the water, in place of a level.
        depth: Option<Quantity<Length>>,
        /// Axis of a river: lines.
        river: Option<VectorFile>,
        /// Width of the river; one cell when absent.
        width: Option<Quantity<Length>>,
        /// Attribute of the line that holds the width of the river in metres.
        width_field: Option<Text>,
        /// The `fields.nc` of an earlier run on the same lattice.
        fields: Option<InputFile>,
        /// Time of the earlier run, or `last`; last when absent.
        time: Option<FrameTime>,
    }
}

/// The keys of the polygon of a body of water.
pub const WATER_KINDS: [&str; 3] = ["reservoir", "sea", "water"];

section! {
    /// An open part of the edge of the terrain: where it is, and what is known of the water beyond.
    BoundaryEntry, example "{side: south, type: open}", check check_boundary {
        /// A side of the terrain.
        side: Option<Chosen<Side>>,
        /// The same as `side`.
        edge: Option<Chosen<Side>>,
        /// File with lines along the open edge; outlines of polygons count as lines.
        lines: Option<VectorFile>,
        /// The same as `lines`.
        line: Option<VectorFile>,
        /// Where nothing is known: open (water leaves, over an edge where the bed does not fall) or free (waves leave).
        r#type: Option<Chosen<OpenType>>,
        /// Discharge that comes in.
        discharge: Option<Changing<Discharge>>,
        /// Level of the water at the boundary itself, whether it comes or goes; with a discharge it counts where the inflow is supercritical.
        level: Option<Changing<Level>>,
        /// Level of still water beyond that is held, such as a tide.
        stage: Option<Changing<Level>>,
        /// Level of a wave that comes in while others leave.
        wave: Option<Changing<Level>>,
        /// Level without the wave; that of the water at the start when absent.
        still: Option<Changing<Level>>,
        /// Uniform flow goes on beyond.
        normal_depth: Option<NormalDepth>,
        /// The discharge that leaves as a function of the level.
        rating: Option<RatingFile>,
    }
}

section! {
    /// Uniform flow.
    NormalDepth, example "{slope: 0.002}" {
        /// Slope of the bed beyond the edge.
        slope: Quantity<Slope>,
    }
}

/// The keys of a boundary that say what is known there.
pub const BOUNDARY_KINDS: [&str; 7] = ["type", "discharge", "level", "stage", "wave", "normal_depth", "rating"];

fn check_boundary(node: &Node, reader: &mut Reader) -> Option<()> {
    let place = reader.exactly_one(node, &["side", "edge", "lines", "line"]);
    let kinds: Vec<&str> = BOUNDARY_KINDS.into_iter().filter(|name| node.get(name).is_some()).collect();
    match kinds[..] {
        [] => {
            let message = "nothing is said of the water beyond this edge";
            let remedy = format!("add one of the keys {}, such as `type: open`", BOUNDARY_KINDS.join(", "));
            reader.error(node, "missing-key", message, remedy);
            return None;
        }
        ["level"] => warn_of_level(node, reader),
        [_] | ["discharge", "level"] => {}
        _ => {
            let message = format!("{} exclude each other at one boundary", kinds.join(" and "));
            let remedy = "keep one of them; only `discharge` and `level` go together, for supercritical inflow";
            reader.error(node, "conflict", message, remedy);
            return None;
        }
    }
    check_still(node, reader)?;
    place.map(|_| ())
}

/// Warns of a level alone: it was that of still water beyond in earlier versions.
fn warn_of_level(node: &Node, reader: &mut Reader) {
    if let Some(level) = node.get("level") {
        let problem = Problem::warning(
            ProblemKind::Scenario,
            "level-is-at-the-boundary",
            level.key.clone(),
            "`level` holds the level of the water at the boundary itself",
        );
        let problem = problem
            .with_cause("earlier versions took it for that of still water beyond, and let in water lower by its velocity head")
            .with_remedy("right for a level measured at the boundary; for a sea, a lake or the result of an earlier version write `stage`");
        reader.report(level, problem);
    }
}

/// Refuses a level without a wave that has none.
pub(super) fn check_still(node: &Node, reader: &mut Reader) -> Option<()> {
    let Some(still) = node.get("still").filter(|_| node.get("wave").is_none()) else { return Some(()) };
    let remedy = "add `wave`, the level of the wave that comes in; for a level that is held write `stage`";
    reader.error(still, "conflict", "`still` goes with `wave`", remedy);
    None
}

section! {
    /// Water that comes out of the ground at a place or along a line.
    SourceEntry, example "{at: [712345.0, 5312345.0], discharge: 2 m3/s}", check check_source {
        /// The place: its two coordinates in the reference system of the run.
        at: Option<Vec<Quantity<Coordinate>>>,
        /// File of points.
        points: Option<VectorFile>,
        /// File of lines.
        line: Option<VectorFile>,
        /// The same as `line`.
        lines: Option<VectorFile>,
        /// Discharge at each place, or of each line.
        discharge: Changing<Discharge>,
    }
}

fn check_source(node: &Node, reader: &mut Reader) -> Option<()> {
    reader.exactly_one(node, &["at", "points", "line", "lines"])?;
    if let Some(at) = node.get("at")
        && let Value::List(items) = &at.value
        && items.len() != 2
    {
        let message = format!("a place has two coordinates, not {}", items.len());
        reader.error(at, "wrong-type", message, "write for example `at: [712345.0, 5312345.0]`");
        return None;
    }
    Some(())
}

section! {
    /// Rain on the whole terrain.
    RainSection, example "{rate: 20 mm/h}", check check_rain {
        /// Intensity, the same everywhere.
        rate: Option<Changing<Intensity>>,
        /// Raster of intensities, constant in time.
        raster: Option<InputFile>,
        /// Rasters over time: a NetCDF file, or a CSV list of times and files.
        raster_series: Option<RasterSeriesFile>,
        /// Unit of the values of the raster or the rasters; of a series that of the NetCDF variable when absent.
        unit: Option<Text>,
        /// Which end of its interval the time of a raster is; begin when absent.
        stamp: Option<Chosen<Stamp>>,
        /// Date and time, of a NetCDF file or a list of dates, at which the run begins; `time.reference` when absent.
        start: Option<DateTime>,
        /// How long it rains; up to the end of the run when absent.
        duration: Option<Quantity<Duration>>,
        /// What does not run off; nothing when absent.
        losses: Option<Losses>,
    }
}

section! {
    /// Rain that does not run off.
    Losses, example "{initial: 5 mm, constant: 2 mm/h}" {
        /// The first rain; 0 when absent.
        initial: Option<Quantity<Height>>,
        /// What is lost of the rain from then on; 0 when absent.
        constant: Option<Quantity<Intensity>>,
    }
}

fn check_rain(node: &Node, reader: &mut Reader) -> Option<()> {
    let amount = reader.exactly_one(node, &["rate", "raster", "raster_series"])?;
    let mut is_fit = true;
    for name in ["stamp", "start"] {
        if let Some(value) = node.get(name).filter(|_| amount != "raster_series") {
            reader.error(value, "conflict", format!("`{name}` goes with `raster_series`"), "take it out");
            is_fit = false;
        }
    }
    if !is_fit {
        return None;
    }
    match (amount, node.get("unit")) {
        ("raster_series", Some(unit)) => {
            let text = reader.text(unit, "a unit", "mm/h")?.trim().to_owned();
            if RainUnit::named(&text).is_none() {
                let message = format!("`{text}` is no unit of rain");
                let remedy = format!(
                    "use one of {} for intensities, or of {} for what falls within each interval",
                    INTENSITY.unit_list(),
                    LENGTH.unit_list()
                );
                reader.error(unit, "unit", message, remedy);
                return None;
            }
            Some(())
        }
        ("raster", None) => {
            let remedy = format!("add `unit: mm/h`, or one of {}", INTENSITY.unit_list());
            reader.error(node, "missing-key", "a raster of rain needs the key `unit`", remedy);
            None
        }
        ("raster", Some(unit)) => {
            let text = reader.text(unit, "a unit", "mm/h")?.trim().to_owned();
            if INTENSITY.factor_of(&text).is_none() {
                let message = format!("`{text}` is no unit of {}", INTENSITY.name);
                reader.error(unit, "unit", message, format!("use one of {}", INTENSITY.unit_list()));
                return None;
            }
            Some(())
        }
        (_, Some(unit)) => {
            let remedy = "take it out: a rate carries its unit, and a series has a `unit` of its own";
            reader.error(unit, "conflict", "`unit` goes with `raster` and `raster_series`", remedy);
            None
        }
        (_, None) => Some(()),
    }
}

/// Why Lagrangian particles do not have something, as the end of a sentence.
fn why_not(what: &str) -> &'static str {
    match what {
        "rain" => "lifts the water, and the depths of this formulation are sums over particles of fixed volume",
        "channels" => "meet the plane at the faces of cells, which these particles do not have",
        "cross-sections" => "are measured in the balanced formulation alone",
        _ => "would need particles that come and go, and those of this formulation stay the same",
    }
}

/// Whether a section says something under a key.
pub(super) fn has(section: &Node, key: &str) -> bool {
    section.get(key).is_some_and(|value| value.value != Value::Empty)
}

/// Refuses what Lagrangian particles or channels alone do not have, and a scenario without any water.
fn check_scenario(node: &Node, reader: &mut Reader) -> Option<()> {
    tell_of_outputs(node, reader);
    check_alone(node, reader)?;
    let is_placed = has(node, "terrain") || channels_alone::check(node, reader).is_some();
    let is_rough = has(node, "roughness")
        || channels_alone::are_rough(node)
        || Roughness::when_absent(node, "roughness", reader).is_some();
    let is_whole = is_placed && is_rough;
    let boundaries = match node.get("boundaries").map(|list| &list.value) {
        Some(Value::List(entries)) => entries.as_slice(),
        _ => &[],
    };
    let feeds = |entry: &Node| ["discharge", "level", "stage", "wave"].iter().any(|key| has(entry, key));
    let is_fed = has(node, "sources") || has(node, "rain") || has(node, "channels") || boundaries.iter().any(feeds);
    if !is_fed && !has(node, "initial") {
        NonEmpty::<InitialEntry>::when_absent(node, "initial", reader);
        return None;
    }
    let empty = Node { value: Value::Section(Vec::new()), ..node.clone() };
    let numerics = node.get("numerics").filter(|n| matches!(n.value, Value::Section(_))).unwrap_or(&empty);
    let formulation = meant(numerics, "formulation", Formulation::default())?;
    let usual = if formulation == Formulation::Variational { Motion::Lagrangian } else { Motion::default() };
    if meant(numerics, "motion", usual)? == Motion::Eulerian {
        return is_whole.then_some(());
    }
    // An entry that says nothing of the water beyond is refused by the reader of boundaries.
    let has_condition = |entry: &Node| {
        let is_free = entry.get("type").is_some_and(|kind| kind.value == Value::Text("free".to_owned()));
        is_free || feeds(entry) || ["normal_depth", "rating"].iter().any(|key| has(entry, key))
    };
    // Summed depths know no water beyond an edge, and none that is added.
    let is_summed = formulation == Formulation::Variational;
    let outputs = node.get("outputs").and_then(|outputs| outputs.get("sections"));
    let foreign = boundaries
        .iter()
        .filter(|entry| is_summed && matches!(entry.value, Value::Section(_)) && has_condition(entry))
        .map(|entry| (entry, "a boundary with a condition"))
        .chain(node.get("sources").filter(|_| is_summed).map(|sources| (sources, "sources")))
        .chain(node.get("rain").filter(|_| is_summed).map(|rain| (rain, "rain")))
        .chain(node.get("channels").map(|channels| (channels, "channels")))
        .chain(outputs.filter(|_| is_summed).map(|sections| (sections, "cross-sections")));
    let mut is_fit = is_whole;
    for (key, what, otherwise) in [
        ("breach", "dam that breaks", "for a dam that is gone at the start, take `breach` out"),
        ("moving_bed", "moving bed", "or take this out"),
    ] {
        let changing = node.get(key).filter(|changing| is_summed && changing.value != Value::Empty);
        let Some(changing) = changing else { continue };
        let message = format!("the particles of the variational formulation know no {what}");
        let problem = Problem::error(ProblemKind::Scenario, "method-combination", changing.key.clone(), message)
            .with_cause("its bed changes in time, and that of this formulation stays the same")
            .with_remedy(format!("leave `numerics.formulation` out (or write `formulation: balanced`); {otherwise}"));
        reader.report(changing, problem);
        is_fit = false;
    }
    for (place, what) in foreign.filter(|(place, _)| place.value != Value::Empty) {
        let who = if is_summed { "the particles of the variational formulation" } else { "Lagrangian particles" };
        let message = format!("{who} know no {}", what.trim_start_matches("a "));
        let problem = Problem::error(ProblemKind::Scenario, "method-combination", place.key.clone(), message)
            .with_cause(format!("{what} {}", why_not(what)))
            .with_remedy("leave `numerics.motion` and `numerics.formulation` out (or write `motion: eulerian`), or take this out");
        reader.report(place, problem);
        is_fit = false;
    }
    is_fit.then_some(())
}

section! {
    /// Simulated time.
    Time, example "{end: 1 h}" {
        /// End of the run, counted from its start.
        end: Quantity<EndTime>,
        /// Date and time of the start, in UTC or with an offset such as `+02:00`; 1582-10-15 or later.
        reference: Option<DateTime>,
    }
}

section! {
    /// Outputs.
    OutputsSection, example "{every: 100 s}", check check_isochrones {
        /// Run folder; `runs/` and the name of the scenario, in the current folder, when absent.
        folder: Option<Text>,
        /// What to write beside `run.json` and `scenario.resolved.yaml`: fields, maps, cog, gpkg, tables, sections, channels; all when absent.
        write: Option<Vec<Chosen<OutputPart>>>,
        /// Edge of a cell of the maps and of `fields.nc`, or `terrain`: then the maps are on the terrain's own raster and `fields.nc` at the resolution; the resolution when absent.
        cell: Option<MapCell>,
        /// Interval of the frames of `fields.nc`; a fortieth of the run, rounded, when absent.
        every: Option<Quantity<Duration>>,
        /// File of gauges: CSV with columns id, x, y, or points.
        gauges: Option<VectorFile>,
        /// File of cross-sections: lines drawn from the left to the right bank.
        sections: Option<VectorFile>,
        /// Interval of the gauge and section series; a tenth of `every`, but at least 1 s, when absent.
        gauges_every: Option<Quantity<Duration>>,
        /// What counts as arrival.
        arrival: Option<ArrivalSection>,
        /// Times of the isochrones; 5, 10, 15, 30, 45, 60, 90, 120 min and then every hour when absent.
        isochrones: Option<Vec<Quantity<Duration>>>,
    }
}

/// The cells of the maps.
#[derive(Clone, Debug)]
pub enum MapCell {
    /// `cell: terrain`
    Terrain(Sourced<()>),
    /// `cell: 20 m`
    Length(Quantity<Length>),
}

impl FromNode for MapCell {
    fn example() -> String {
        "terrain".to_owned()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        match &node.value {
            Value::Text(text) if text == "terrain" => Some(MapCell::Terrain(reader.sourced(node, ()))),
            Value::Text(text) if !text.contains(|c: char| c.is_ascii_digit()) => {
                let remedy = "write `terrain` for the raster of the terrain itself, or a length such as `20 m`";
                reader.error(node, "unknown-name", format!("`{text}` is no cell of a map"), remedy);
                None
            }
            _ => Quantity::from_node(node, reader).map(MapCell::Length),
        }
    }
}

impl JsonSchema for MapCell {
    fn schema_name() -> Cow<'static, str> {
        "MapCell".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let length = generator.subschema_for::<Quantity<Length>>();
        json_schema!({"anyOf": [{"const": "terrain"}, length]})
    }
}

section! {
    /// What counts as arrival of the water.
    ArrivalSection, example "{thresholds: [0.01 m, 0.10 m, 0.30 m]}", check check_thresholds {
        /// Depths; the first one gives `arrival_time` and the isochrones; 0.01, 0.10 and 0.30 m when absent.
        thresholds: Option<NonEmpty<Quantity<Length>>>,
        /// Rise of the level where there was water at the start; 0.10 m when absent.
        rise_on_wet: Option<Quantity<Length>>,
    }
}

/// Warns of intervals of the outputs longer than the run, and of cells finer than what was computed.
fn tell_of_outputs(node: &Node, reader: &mut Reader) {
    let Some(outputs) = node.get("outputs") else { return };
    let quantity = |node: Option<&Node>, dimension: &Dimension| match &node?.value {
        Value::Text(text) => dimension.parse(text).ok(),
        _ => None,
    };
    let end = quantity(node.get("time").and_then(|time| time.get("end")), &TIME);
    for (key, what) in [("every", "frames"), ("gauges_every", "rows of the series")] {
        if let Some(interval) = outputs.get(key)
            && quantity(Some(interval), &TIME).zip(end).is_some_and(|(interval, end)| interval > end)
        {
            let message =
                format!("this interval is longer than the run: the only {what} are those of its start and its end");
            reader.warning(interval, "longer-than-run", message, "give a shorter interval, or leave it out");
        }
    }
    let is_written = |part: &str| match outputs.get("write").map(|list| &list.value) {
        Some(Value::List(parts)) => parts.iter().any(|item| item.value == Value::Text(part.to_owned())),
        _ => true,
    };
    if let Some(isochrones) = outputs.get("isochrones").filter(|_| !is_written("gpkg")) {
        let message = "isochrones stand in results.gpkg, which `outputs.write` leaves out";
        reader.warning(isochrones, "not-written", message, "add `gpkg` to `outputs.write`, or leave `isochrones` out");
    }
    if let Some(cell) = outputs.get("cell")
        && quantity(Some(cell), &LENGTH).zip(quantity(node.get("resolution"), &LENGTH)).is_some_and(|(c, r)| c < r)
    {
        let message = "the cells of the maps are finer than the resolution, and show nothing that was not computed";
        reader.warning(cell, "finer-than-resolution", message, "leave `cell` out, or take a finer `resolution`");
    }
}

/// An isochrone bounds what was reached since the one before it.
fn check_isochrones(node: &Node, reader: &mut Reader) -> Option<()> {
    let Some(Node { value: Value::List(items), .. }) = node.get("isochrones") else { return Some(()) };
    let time = |item: &Node| if let Value::Text(text) = &item.value { TIME.parse(text).ok() } else { None };
    for pair in items.windows(2) {
        if let (Some(before), Some(after)) = (time(&pair[0]), time(&pair[1]))
            && after <= before
        {
            let message = "the times of the isochrones must rise, and this one does not lie after the one before it";
            reader.error(&pair[1], "conflict", message, "write each time once, the earliest first");
            return None;
        }
    }
    Some(())
}

fn check_thresholds(node: &Node, reader: &mut Reader) -> Option<()> {
    let Some(Node { value: Value::List(items), .. }) = node.get("thresholds") else { return Some(()) };
    let depth = |item: &Node| if let Value::Text(text) = &item.value { LENGTH.parse(text).ok() } else { None };
    for (index, item) in items.iter().enumerate() {
        if depth(item).is_some() && items[..index].iter().any(|earlier| depth(earlier) == depth(item)) {
            reader.error(item, "conflict", "this threshold stands twice in the list", "keep one of the two");
            return None;
        }
    }
    Some(())
}

section! {
    /// Methods by family, each with a default, and their numbers.
    NumericsSection, example "{cfl: 0.5}", check check_methods {
        /// A set of choices by name, of which the keys beside it change one each; the defaults are those of balanced.
        preset: Option<Chosen<Preset>>,
        /// How the equations become sums over particles; balanced when absent.
        formulation: Option<Chosen<Formulation>>,
        /// Whether particles rest on the riverbed or move; eulerian when absent, lagrangian for the variational formulation.
        motion: Option<Chosen<Motion>>,
        /// Treatment of a pair of particles; two_rarefactions for Eulerian, two_shocks for Lagrangian particles, artificial_viscosity for the variational formulation when absent.
        stabilisation: Option<Chosen<Stabilisation>>,
        /// States on both sides of a face; limited when absent, none with artificial_viscosity.
        reconstruction: Option<Chosen<Reconstruction>>,
        /// Places of Lagrangian particles at the start; lattice when absent.
        seeding: Option<Chosen<Seeding>>,
        /// Smoothing kernel; cubic_spline when absent.
        kernel: Option<Chosen<Kernel>>,
        /// Time integration; heun for Eulerian, leapfrog for Lagrangian particles when absent.
        integrator: Option<Chosen<Integrator>>,
        /// How riverbed particles get their elevation; see the methods for the default.
        bed: Option<Chosen<BedMethod>>,
        /// Effect of the bed's slope on the variational formulation; hydrostatic when absent.
        bed_slope: Option<Chosen<BedSlope>>,
        /// Mixing by turbulence in the plane; none when absent.
        turbulence: Option<Chosen<Turbulence>>,
        /// What stands for a wall beside Lagrangian particles; mirror when absent.
        wall: Option<Chosen<WallMethod>>,
        /// Courant number; 0.5 for Eulerian, 0.4 for Lagrangian particles when absent.
        cfl: Option<Quantity<Courant>>,
        /// Gravity in m/s²; 9.81 when absent.
        gravity: Option<Quantity<Gravity>>,
        /// Depth below which water does not move; 1 mm when absent.
        dry_depth: Option<Quantity<Length>>,
    }
}

/// The greatest Courant number at which Eulerian particles hold in the suite of stability (cases `cfl_02` to `cfl_16`).
const GREATEST_COURANT_OF_EULERIAN: f64 = 0.6;

/// A number as it is written; none where there is none, or something that is no number, which is reported elsewhere.
fn number(node: &Node, key: &str) -> Option<f64> {
    match &node.get(key)?.value {
        Value::Text(text) => text.parse().ok(),
        _ => None,
    }
}

/// A method as the scenario means it: the one written, or the usual one. None where the written name is unknown, which is
/// reported elsewhere and must not draw further problems after it.
fn meant<T: Choice>(node: &Node, key: &str, usual: T) -> Option<T> {
    match node.get(key).map(|value| &value.value) {
        None | Some(Value::Empty) => Some(usual),
        Some(Value::Text(text)) => T::choices().into_iter().find(|(name, _)| name == text).map(|(_, method)| method),
        Some(_) => None,
    }
}

/// Refuses combinations of methods that do not exist: no core ignores what the scenario says.
fn check_methods(node: &Node, reader: &mut Reader) -> Option<()> {
    let formulation = meant(node, "formulation", Formulation::default())?;
    let is_variational = formulation == Formulation::Variational;
    let motion = meant(node, "motion", if is_variational { Motion::Lagrangian } else { Motion::default() })?;
    let core = Core::of(formulation, motion);
    let written = written_methods(node);
    let mut is_fit = true;
    for method in written.iter().filter(|method| !method.cores.contains(&core)) {
        reader.report(method.node, refusal(core, method, &written));
        is_fit = false;
    }
    let courant = number(node, "cfl").filter(|courant| *courant > GREATEST_COURANT_OF_EULERIAN && *courant <= 1.0);
    if let (Core::Eulerian, Some(_), Some(value)) = (core, courant, node.get("cfl")) {
        let message =
            format!("Eulerian particles are unstable beyond a Courant number of {GREATEST_COURANT_OF_EULERIAN}");
        let problem = Problem::error(ProblemKind::Scenario, "method-combination", value.key.clone(), message)
            .with_cause("in two dimensions water leaves through faces of both directions: 0.5 is safe, 0.8 degrades, 1 breaks down")
            .with_remedy("write `cfl: 0.5`, or leave it out");
        reader.report(value, problem);
        is_fit = false;
    }
    is_fit.then_some(())
}

/// A method that is written under a key, and the cores that have it.
struct Written<'a> {
    key: &'static str,
    node: &'a Node,
    name: &'a str,
    cores: &'static [Core],
    why_not_elsewhere: &'static str,
}

/// The methods of the families that not all cores share, as far as they are written and known.
fn written_methods(section: &Node) -> Vec<Written<'_>> {
    let all = [
        written::<Motion>(section, "motion"),
        written::<Stabilisation>(section, "stabilisation"),
        written::<Reconstruction>(section, "reconstruction"),
        written::<Integrator>(section, "integrator"),
        written::<Seeding>(section, "seeding"),
        written::<Kernel>(section, "kernel"),
        written::<WallMethod>(section, "wall"),
        written::<BedSlope>(section, "bed_slope"),
        written::<Turbulence>(section, "turbulence"),
    ];
    all.into_iter().flatten().collect()
}

fn written<'a, T: Choice + Method>(section: &'a Node, key: &'static str) -> Option<Written<'a>> {
    let node = section.get(key)?;
    let Value::Text(name) = &node.value else { return None };
    let (_, method) = T::choices().into_iter().find(|(known, _)| known == name)?;
    Some(Written { key, node, name, cores: method.cores(), why_not_elsewhere: method.why_not_elsewhere() })
}

/// The problem of a method that a core does not have. Its remedy names the cores that have all that is written.
fn refusal(core: Core, method: &Written<'_>, written: &[Written<'_>]) -> Problem {
    let has_all = |other: &&Core| written.iter().all(|own| own.key == "motion" || own.cores.contains(other));
    let others = Core::ALL.iter().filter(has_all).map(|other| format!(", or write `{}`", other.asked_for_by()));
    // A preset has the place of what it sets.
    let written_as = method.node.key.rsplit('.').next().unwrap_or(method.key);
    let message = format!("{} have no `{}: {}`", core.particles(), method.key, method.name);
    Problem::error(ProblemKind::Scenario, "method-combination", method.node.key.clone(), message)
        .with_cause(method.why_not_elsewhere)
        .with_remedy(format!("leave `{written_as}` out{}", others.collect::<String>()))
}

section! {
    /// Limits that are checked before anything is computed.
    LimitsSection, example "{memory: 8 GB}" {
        /// Memory; 80 % of that of the machine when absent.
        memory: Option<Quantity<Memory>>,
        /// Particles, riverbed and fluid together; 50 million when absent.
        particles: Option<Quantity<Count>>,
    }
}
