//! `terrain`: the raster or the layers, and what shapes them.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::ground;
use super::ground::{BreaklineEntry, is_wall, level};
use crate::scenario::choices::{Choice, Chosen, ElevationUnit};
use crate::scenario::fields::{CellCount, InputFile, Length, Offset, Quantity, VectorFile};
use crate::scenario::model::{
    BreaklineMode, Gaps, Ground, LayerMode, PointInterpolation, Scenario, Sourced, TerrainLayer,
};
use crate::scenario::read::{FromNode, NonEmpty, Reader, section};
use crate::scenario::tree::{Node, Value};
use crate::scenario::yaml::{Section, Yaml, file, name_of, quantity, vector};

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
    /// Terrain layers: rasters and survey points, and what shapes the ground that they make.
    TerrainLayers, example "dem.tif" {
        /// Layers from the lowest to the uppermost; where several have data, the later one counts. Codes: layers-apart,
        /// different-vertical-datum.
        layers: NonEmpty<LayerEntry>,
        /// Whether rasters in another or a geographic reference system are warped to that of the run; otherwise they are refused. Points,
        /// lines and polygons always are brought to it; false when absent. Codes: different-crs, geographic-crs, warp-failed, no-transformation.
        reproject: Option<bool>,
        /// Lines along which the bed is raised (levees) or carved (channels), in the order of the list; none when absent.
        breaklines: Option<Vec<BreaklineEntry>>,
        /// Whether the sides of cells follow steep banks that a raster as fine as the cells shows; `results.gpkg` has them in the layer
        /// `banks`; true when absent, but with `formulation: variational`. Codes: method-combination.
        follow_banks: Option<bool>,
        /// Cells without terrain that terrain encloses: `wall`, `error` (refused), or filled from their rim; wall, with a
        /// warning, when absent. Codes: terrain-gaps, seam-without-data.
        gaps: Option<GapsChoice>,
    }
}

section! {
    /// A terrain layer: a raster, or bare survey points.
    LayerEntry, example "{raster: dem.tif}", check check_layer {
        /// Raster of elevations; in NetCDF `file.nc:variable`; `points` is required when absent. Codes: unit-of-elevation,
        /// elevation-unit-unknown, heights-downward, undeclared-nodata, axis-uneven, doubtful-elevation, layers-apart,
        /// different-vertical-datum, no-crs, several-bands.
        raster: Option<InputFile>,
        /// Survey points: text with the columns x, y, z (also gzipped), or a vector file of points; `raster` is required when
        /// absent. Codes: not-a-survey, bad-survey-line, contradicting-points, no-elevation, no-surface, doubtful-elevation.
        points: Option<InputFile>,
        /// Length added to every elevation, such as `-0.12 m` for a change of datum; 0 m when absent. Codes:
        /// different-vertical-datum, layers-apart.
        offset: Option<Quantity<Offset>>,
        /// Unit of the elevations of a raster; metres when absent, but asked for where places count in feet.
        /// Codes: unit-of-elevation, elevation-unit-unknown, doubtful-elevation, unit-of-attribute.
        unit: Option<Chosen<ElevationUnit>>,
        /// Interpolation between survey points; inverse_distance when absent.
        interpolation: Option<Chosen<PointInterpolation>>,
        /// Distance to the nearest survey point beyond which there is no terrain; required with `points` when absent.
        max_gap: Option<Quantity<Length>>,
        /// File of polygons outside of which the layer has no data; survey points outside still shape the surface inside;
        /// everywhere when absent. Codes: clip-outside-layer, seam-without-data, empty-polygon, self-crossing.
        clip: Option<VectorFile>,
        /// How it meets the layers under it where they have data, too: it counts alone (`replace`), or the lower (`min`, as for a
        /// river bed) or higher elevation (`max`) counts; replace when absent.
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
    if kind == "points" && !node.has("max_gap") {
        let remedy = "add `max_gap: 200 m`: the distance to the nearest point beyond which there is no terrain";
        reader.error(node, "missing-key", "survey points need the key `max_gap`", remedy);
        is_fit = false;
    }
    is_fit.then_some(())
}

/// Layers, whether they are brought to the reference system of the run, and the ground.
///
/// - `follows_banks`: whether its cells follow banks where the scenario does not say
pub(super) fn resolved(terrain: Terrain, follows_banks: bool) -> (Vec<Sourced<TerrainLayer>>, bool, Ground) {
    match terrain {
        Terrain::Raster(file) => {
            let Sourced { value: path, key, place } = file.0;
            let value = TerrainLayer::Raster { path, offset: 0.0, unit: None, clip: None, mode: LayerMode::default() };
            (vec![Sourced { value, key, place }], false, Ground { follows_banks, ..Ground::default() })
        }
        Terrain::Layers(section) => {
            let layers = section.layers.0.into_iter().filter_map(layer).collect();
            let gaps = section.gaps.map(|gaps| gaps.0);
            let (breaklines, followed) = ground::breaklines(section.breaklines.unwrap_or_default(), &[]);
            let follows_banks = section.follow_banks.unwrap_or(follows_banks);
            let ground = Ground { gaps, breaklines, followed, follows_banks, buildings: None };
            (layers, section.reproject.unwrap_or(false), ground)
        }
    }
}

fn layer(entry: LayerEntry) -> Option<Sourced<TerrainLayer>> {
    let offset = entry.offset.map_or(0.0, |offset| offset.value());
    let mode = entry.mode.map_or(LayerMode::default(), |mode| mode.0.value);
    let clip = entry.clip.map(|clip| clip.0);
    if let Some(raster) = entry.raster {
        let Sourced { value: path, key, place } = raster.0;
        let unit = entry.unit.map(|unit| unit.0.value.0);
        return Some(Sourced { value: TerrainLayer::Raster { path, offset, unit, clip, mode }, key, place });
    }
    let Sourced { value: path, key, place } = entry.points?.0;
    let interpolation = entry.interpolation.map_or(PointInterpolation::InverseDistance, |chosen| chosen.0.value);
    let max_gap = entry.max_gap?.value();
    Some(Sourced { value: TerrainLayer::Points { path, interpolation, max_gap, offset, clip, mode }, key, place })
}

impl Choice for LayerMode {
    const WHAT: &'static str = "a way for a layer to meet those under it";

    fn choices() -> Vec<(&'static str, Self)> {
        vec![("replace", LayerMode::Replace), ("min", LayerMode::Min), ("max", LayerMode::Max)]
    }
}

/// The one way in which holes are filled: inverse distances.
#[derive(Clone, Copy, Debug)]
pub struct InverseDistances;

impl Choice for InverseDistances {
    const WHAT: &'static str = "a way of filling gaps";

    fn choices() -> Vec<(&'static str, Self)> {
        vec![("idw", InverseDistances)]
    }
}

/// What becomes of holes: `gaps: wall`, `gaps: error`, or a section.
#[derive(Clone, Debug)]
pub struct GapsChoice(pub Sourced<Gaps>);

impl FromNode for GapsChoice {
    fn example() -> String {
        "error".to_owned()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let gaps = match &node.value {
            Value::Text(text) => match text.as_str() {
                "wall" => Gaps::Wall,
                "error" => Gaps::Refuse,
                _ => {
                    let remedy = "write `wall`, `error`, or `{fill: idw, max_cells: 50}`";
                    reader.error(node, "unknown-name", format!("`{text}` is no way to treat gaps"), remedy);
                    return None;
                }
            },
            _ => {
                let GapsSection { fill, max_cells } = GapsSection::from_node(node, reader)?;
                // There is one way to fill.
                let InverseDistances = fill.0.value;
                Gaps::Fill { max_cells: max_cells.value() as usize }
            }
        };
        Some(GapsChoice(reader.sourced(node, gaps)))
    }
}

impl JsonSchema for GapsChoice {
    fn schema_name() -> Cow<'static, str> {
        "Gaps".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let section = generator.subschema_for::<GapsSection>();
        json_schema!({"anyOf": [{"enum": ["wall", "error"]}, section]})
    }
}

section! {
    /// Gaps of the terrain that are filled.
    GapsSection, example "{fill: idw, max_cells: 50}" {
        /// How they are filled: `idw`, by inverse squared distances from their rim. Codes: gaps-filled.
        fill: Chosen<InverseDistances>,
        /// Largest gap that is filled, in cells of the lattice; a larger one is refused. Codes: gap-too-large.
        max_cells: Quantity<CellCount>,
    }
}

pub(super) fn written(scenario: &Scenario) -> Section {
    let layers = scenario.layers.iter().map(|layer| match &layer.value {
        TerrainLayer::Raster { path, offset, unit, clip, mode } => {
            let name = |unit: f64| name_of(|candidate: &ElevationUnit| candidate.0.to_bits() == unit.to_bits());
            Yaml::Entry(
                Section::default()
                    .with("raster", file(path))
                    .with("offset", quantity(*offset, "m"))
                    .with_some("unit", unit.map(name))
                    .with_some("clip", clip.as_ref().map(vector))
                    .with("mode", name_of(|candidate: &LayerMode| candidate == mode)),
            )
        }
        TerrainLayer::Points { path, interpolation, max_gap, offset, clip, mode } => Section::default()
            .with("points", file(path))
            .with("interpolation", name_of(|candidate: &PointInterpolation| candidate == interpolation))
            .with("max_gap", quantity(*max_gap, "m"))
            .with("offset", quantity(*offset, "m"))
            .with("mode", name_of(|candidate: &LayerMode| candidate == mode))
            .with_some("clip", clip.as_ref().map(vector))
            .into(),
    });
    let gaps = scenario.ground.gaps.as_ref().map(|gaps| match gaps.value {
        Gaps::Wall => "wall".into(),
        Gaps::Refuse => "error".into(),
        Gaps::Fill { max_cells } => {
            Yaml::Entry(Section::default().with("fill", "idw").with("max_cells", max_cells as f64))
        }
    });
    let breaklines = scenario.ground.breaklines.iter().filter(|line| !is_wall(line)).map(|line| {
        Yaml::Entry(
            Section::default()
                .with("lines", vector(&line.lines))
                .with(
                    "mode",
                    match line.mode {
                        BreaklineMode::Raise => "raise",
                        BreaklineMode::Carve => "carve",
                    },
                )
                .and(level(["z", "z_field"], &line.level))
                .with_some("width", line.width.map(|width| quantity(width, "m"))),
        )
    });
    let followed = scenario
        .ground
        .followed
        .iter()
        .map(|lines| Yaml::Entry(Section::default().with("lines", vector(lines)).with("mode", "follow")));
    Section::default()
        .with_list("layers", layers.collect())
        .with("reproject", scenario.reproject)
        .with_some("gaps", gaps)
        .with_list("breaklines", breaklines.chain(followed).collect())
        .with("follow_banks", scenario.ground.follows_banks)
}
