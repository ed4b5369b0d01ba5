//! The scenario as written in YAML: every section with its keys; the contract is DESIGN section 2.
//!
//! The JSON Schema of `floodsim schema` comes from these same declarations, so that it cannot disagree with the reader.
//! Not here: the defaults of keys that may be absent (`resolve.rs`).

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::choices::{Choice, Chosen, ElevationUnit, OpenType};
use super::fields::{
    Count, Courant, DateTime, Duration, EndTime, FormatVersion, Gravity, InputFile, Length, Level, Manning, Memory,
    Offset, Quantity, Text, VectorFile,
};
use super::methods::{
    BedMethod, BedSlope, Formulation, Integrator, Kernel, Motion, Preset, Reconstruction, Seeding, Stabilisation,
    WallMethod,
};
use super::model::{PointInterpolation, Side};
use super::read::{FromNode, NonEmpty, Reader, section};
use super::tree::{Node, Value};
use super::units::LENGTH;
use crate::error::{Problem, ProblemKind};

section! {
    /// A flood scenario.
    ScenarioFile, example "{...}" {
        /// Version of the scenario format.
        floodsim: FormatVersion,
        /// Title; the name of the scenario when absent.
        title: Option<Text>,
        /// Coordinate reference system such as EPSG:27572, or `local` for plain metres; that of the terrain when absent.
        crs: Option<Text>,
        /// Terrain: a raster file, or layers.
        terrain: Terrain,
        /// Roughness of the ground.
        roughness: Roughness,
        /// Structures that hold or divert water.
        structures: Option<Structures>,
        /// Bodies of still water at the start.
        initial: NonEmpty<InitialEntry>,
        /// Open edges, where water leaves; all other edges are walls.
        boundaries: Option<Vec<BoundaryEntry>>,
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
        manning: Quantity<Manning>,
    }
}

/// Warns of a roughness that is possible, but hardly meant.
fn check_roughness(node: &Node, reader: &mut Reader) -> Option<()> {
    if let Some(manning) = node.get("manning")
        && let Value::Text(text) = &manning.value
        && text.parse::<f64>().is_ok_and(|n| n > 0.0 && n < 0.005)
    {
        let message = format!("a Manning roughness of `{text}` is smoother than glass");
        reader.warning(manning, "roughness", message, "natural ground has 0.02 to 0.15, smooth concrete 0.012");
    }
    Some(())
}

section! {
    /// Structures.
    Structures, example "{walls: [{lines: dam_line.geojson}]}" {
        /// Walls that no water crosses, such as a dam that stands.
        walls: Option<Vec<Wall>>,
    }
}

section! {
    /// A wall.
    Wall, example "{lines: dam_line.geojson}" {
        /// File with its lines.
        lines: VectorFile,
    }
}

section! {
    /// A body of still water: its polygon and its level.
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
    }
}

/// The keys of the polygon of a body of water.
pub const WATER_KINDS: [&str; 3] = ["reservoir", "sea", "water"];

fn check_initial(node: &Node, reader: &mut Reader) -> Option<()> {
    let kind = reader.exactly_one(node, &WATER_KINDS);
    let levels = ["level", "level_field"].iter().filter(|name| node.get(name).is_some()).count();
    if levels > 1 {
        reader.error(node, "conflict", "`level` and `level_field` exclude each other", "keep one of the two");
        return None;
    }
    kind.map(|_| ())
}

section! {
    /// An open part of the edge of the terrain.
    BoundaryEntry, example "{side: south, type: open}", check check_boundary {
        /// A side of the terrain.
        side: Option<Chosen<Side>>,
        /// File with lines along the open edge.
        lines: Option<VectorFile>,
        /// What happens there: water leaves.
        r#type: Chosen<OpenType>,
    }
}

fn check_boundary(node: &Node, reader: &mut Reader) -> Option<()> {
    reader.exactly_one(node, &["side", "lines"]).map(|_| ())
}

section! {
    /// Simulated time.
    Time, example "{end: 1 h}" {
        /// End of the run, counted from its start.
        end: Quantity<EndTime>,
        /// Date and time of the start (UTC).
        reference: Option<DateTime>,
    }
}

section! {
    /// Outputs.
    OutputsSection, example "{every: 100 s}" {
        /// Run folder; `runs/` and the name of the scenario, in the current folder, when absent.
        folder: Option<Text>,
        /// Edge of a cell of the maps; the resolution when absent.
        cell: Option<Quantity<Length>>,
        /// Interval of the frames of `fields.nc`; a fortieth of the run, rounded, when absent.
        every: Option<Quantity<Duration>>,
        /// File of gauges: CSV with columns id, x, y, or points.
        gauges: Option<VectorFile>,
        /// Interval of the gauge series; a tenth of `every`, but at least 1 s, when absent.
        gauges_every: Option<Quantity<Duration>>,
        /// What counts as arrival.
        arrival: Option<ArrivalSection>,
        /// Times of the isochrones; 5, 10, 15, 30, 45, 60, 90, 120 min and then every hour when absent.
        isochrones: Option<Vec<Quantity<Duration>>>,
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
        /// Treatment of a pair of particles; hllc for resting, two_shocks for moving particles, artificial_viscosity for the variational formulation when absent.
        stabilisation: Option<Chosen<Stabilisation>>,
        /// States on both sides of a face; limited when absent, none with artificial_viscosity.
        reconstruction: Option<Chosen<Reconstruction>>,
        /// Places of moving particles at the start; lattice when absent.
        seeding: Option<Chosen<Seeding>>,
        /// Smoothing kernel; cubic_spline when absent.
        kernel: Option<Chosen<Kernel>>,
        /// Time integration; heun for resting, leapfrog for moving particles when absent.
        integrator: Option<Chosen<Integrator>>,
        /// How riverbed particles get their elevation; see the methods for the default.
        bed: Option<Chosen<BedMethod>>,
        /// Effect of the bed's slope on the variational formulation; hydrostatic when absent.
        bed_slope: Option<Chosen<BedSlope>>,
        /// What stands for a wall beside moving particles; mirror when absent.
        wall: Option<Chosen<WallMethod>>,
        /// Courant number; 0.5 for resting, 0.4 for moving particles when absent.
        cfl: Option<Quantity<Courant>>,
        /// Gravity in m/s²; 9.81 when absent.
        gravity: Option<Quantity<Gravity>>,
        /// Depth below which water does not move; 1 mm when absent.
        dry_depth: Option<Quantity<Length>>,
    }
}

/// The greatest Courant number at which resting particles hold in the suite of stability (cases `cfl_02` to `cfl_16`).
const GREATEST_RESTING_COURANT: f64 = 0.6;

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
    let motion = meant(node, "motion", if is_variational { Motion::Lagrangian } else { Motion::default() });
    let mut is_fit = true;
    let mut refuse = |key: &str, message: &str, cause: &str, remedy: &str| {
        if let Some(value) = node.get(key) {
            let problem = Problem::error(ProblemKind::Scenario, "method-combination", value.key.clone(), message);
            reader.report(value, problem.with_cause(cause).with_remedy(remedy));
            is_fit = false;
        }
    };
    if is_variational && motion == Some(Motion::Eulerian) {
        refuse(
            "motion",
            "the variational formulation has no resting particles",
            "its depth is summed over particles that move",
            "write `motion: lagrangian`, or take `formulation: balanced`",
        );
    }
    let stabilisation = meant(node, "stabilisation", Stabilisation::default());
    if !is_variational && stabilisation == Some(Stabilisation::ArtificialViscosity) {
        refuse(
            "stabilisation",
            "the balanced formulation has no artificial viscosity",
            "its pairs are Riemann problems",
            "leave `stabilisation` out, or take `formulation: variational`",
        );
    }
    if !is_variational && meant(node, "bed_slope", BedSlope::Hydrostatic) == Some(BedSlope::Steep) {
        refuse(
            "bed_slope",
            "the balanced formulation has no inertia of the vertical motion",
            "its faces balance a hydrostatic pressure",
            "leave `bed_slope` out, or take `formulation: variational`",
        );
    }
    if is_variational || motion != Some(Motion::Eulerian) {
        if meant(node, "reconstruction", Reconstruction::Limited) == Some(Reconstruction::Sharp) {
            refuse(
                "reconstruction",
                "moving particles have no sharp reconstruction",
                "their faces have no sharper limiter",
                "write `reconstruction: limited`, or take `motion: eulerian`",
            );
        }
        return is_fit.then_some(());
    }
    if stabilisation == Some(Stabilisation::TwoShocks) {
        refuse(
            "stabilisation",
            "resting particles have no two-shock solver",
            "their faces rest in the middle of the waves, and it tells the state between the waves only",
            "write `stabilisation: hllc`, or take `motion: lagrangian`",
        );
    }
    if meant(node, "integrator", Integrator::Heun) == Some(Integrator::Leapfrog) {
        refuse(
            "integrator",
            "resting particles have no leapfrog",
            "their faces are upwinded, which leapfrog makes unstable",
            "write `integrator: heun`, or take `motion: lagrangian`",
        );
    }
    if number(node, "cfl").is_some_and(|courant| courant > GREATEST_RESTING_COURANT && courant <= 1.0) {
        refuse(
            "cfl",
            &format!("resting particles are unstable beyond a Courant number of {GREATEST_RESTING_COURANT}"),
            "in two dimensions water leaves through faces of both directions: 0.5 is safe, 0.8 degrades, 1 breaks down",
            "write `cfl: 0.5`, or leave it out",
        );
    }
    if meant(node, "seeding", Seeding::Lattice) == Some(Seeding::EqualVolume) {
        refuse(
            "seeding",
            "resting particles have no equal-volume filling",
            "each takes up one cell, and is as deep as the water there",
            "write `seeding: lattice`, or take `motion: lagrangian`",
        );
    }
    if meant(node, "wall", WallMethod::default()).is_some_and(|wall| wall != WallMethod::default()) {
        refuse(
            "wall",
            "resting particles have no choice of wall",
            "their faces at a wall are those of the mirror problem",
            "write `wall: mirror`, or take `motion: lagrangian`",
        );
    }
    if meant(node, "kernel", Kernel::default()).is_some_and(|kernel| kernel != Kernel::default()) {
        refuse(
            "kernel",
            "resting particles have no choice of kernel",
            "with four neighbours at one distance every kernel gives the same faces",
            "write `kernel: cubic_spline`, or take `motion: lagrangian`",
        );
    }
    is_fit.then_some(())
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
