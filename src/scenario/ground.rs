//! What planners build into the terrain: how its layers meet, its holes, breaklines and buildings; as written, and as it
//! becomes in the resolved scenario.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::choices::{Choice, Chosen};
use super::fields::{CellCount, Height, Length, Level, Manning, Quantity, Text, VectorFile};
use super::model::{Sourced, VectorSource};
use super::read::{FromNode, Reader, section};
use super::tree::{Node, Value};

/// What the terrain holds beside its layers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ground {
    /// What becomes of holes; the edge of a hole is a wall when absent.
    pub gaps: Option<Sourced<Gaps>>,
    /// Lines along which the bed is raised or lowered, in their order; walls with a crest come last.
    pub breaklines: Vec<Breakline>,
    /// Buildings.
    pub buildings: Option<Buildings>,
}

/// How a terrain layer meets those under it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LayerMode {
    /// It counts alone.
    #[default]
    Replace,
    /// The lower one of the two counts, as for a river bed under a water surface.
    Min,
    /// The higher one of the two counts.
    Max,
}

/// What becomes of cells without terrain that terrain encloses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gaps {
    /// Their edge is a wall.
    Wall,
    /// The run is refused.
    Refuse,
    /// They are filled from their rim, if they have no more cells than this.
    Fill {
        /// Cells of the lattice.
        max_cells: usize,
    },
}

/// What a breakline does to the bed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BreaklineMode {
    /// Nothing under it lies lower.
    Raise,
    /// Nothing under it lies higher.
    Carve,
}

/// Lines along which the bed is raised or lowered.
#[derive(Clone, Debug, PartialEq)]
pub struct Breakline {
    /// The file with the lines.
    pub lines: Sourced<VectorSource>,
    /// Up or down.
    pub mode: BreaklineMode,
    /// Where its levels come from.
    pub level: LineLevel,
    /// Its width (m); a cell when absent.
    pub width: Option<f64>,
}

/// Where the levels of a breakline come from.
#[derive(Clone, Debug, PartialEq)]
pub enum LineLevel {
    /// The same for all its lines (m).
    Constant(Sourced<f64>),
    /// An attribute of each line.
    Field(String),
    /// The third coordinate of its vertices.
    Vertices,
}

/// Footprints of buildings.
#[derive(Clone, Debug, PartialEq)]
pub struct Buildings {
    /// The file with their polygons.
    pub polygons: Sourced<VectorSource>,
    /// What they do.
    pub mode: BuildingMode,
}

/// What a building does.
#[derive(Clone, Debug, PartialEq)]
pub enum BuildingMode {
    /// No water gets in.
    Block,
    /// The bed is higher.
    Raise {
        /// By this height (m); by an attribute of each when absent.
        height: Option<f64>,
        /// The attribute; `height_m` or `height` when absent.
        field: Option<String>,
    },
    /// The bed has this Manning roughness; the attribute `n` of each when absent.
    Roughness(Option<f64>),
}

impl Choice for LayerMode {
    const WHAT: &'static str = "a way for a layer to meet those under it";

    fn choices() -> Vec<(&'static str, Self)> {
        vec![("replace", LayerMode::Replace), ("min", LayerMode::Min), ("max", LayerMode::Max)]
    }
}

impl Choice for BreaklineMode {
    const WHAT: &'static str = "a mode of a breakline";

    fn choices() -> Vec<(&'static str, Self)> {
        vec![("raise", BreaklineMode::Raise), ("carve", BreaklineMode::Carve)]
    }
}

/// The name of what a building does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuildingKind {
    /// `block`
    Block,
    /// `raise`
    Raise,
    /// `roughness`
    Roughness,
}

impl Choice for BuildingKind {
    const WHAT: &'static str = "a mode of buildings";

    fn choices() -> Vec<(&'static str, Self)> {
        vec![("block", BuildingKind::Block), ("raise", BuildingKind::Raise), ("roughness", BuildingKind::Roughness)]
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

section! {
    /// Holes of the terrain that are filled.
    GapsSection, example "{fill: idw, max_cells: 50}" {
        /// How: idw, inverse squared distances from the rim.
        fill: Chosen<InverseDistances>,
        /// Cells of the lattice beyond which a hole is refused.
        max_cells: Quantity<CellCount>,
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
            _ => Gaps::Fill { max_cells: GapsSection::from_node(node, reader)?.max_cells.value() as usize },
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
    /// Lines along which the bed is raised or lowered.
    BreaklineEntry, example "{lines: levees.geojson, mode: raise, z_field: crest_m}", check check_breakline {
        /// File with the lines; outlines of polygons count as lines.
        lines: VectorFile,
        /// raise or carve.
        mode: Chosen<BreaklineMode>,
        /// Level of all its lines.
        z: Option<Quantity<Level>>,
        /// Attribute that holds the level of each line in metres; without `z` and `z_field` the third coordinate of the vertices counts.
        z_field: Option<Text>,
        /// Width; a cell when absent or narrower.
        width: Option<Quantity<Length>>,
    }
}

fn check_breakline(node: &Node, reader: &mut Reader) -> Option<()> {
    only_one(node, ["z", "z_field"], reader)
}

/// Refuses two keys beside each other.
fn only_one(node: &Node, [first, second]: [&str; 2], reader: &mut Reader) -> Option<()> {
    if node.get(first).is_some() && node.get(second).is_some() {
        let message = format!("`{first}` and `{second}` exclude each other");
        reader.error(node, "conflict", message, "keep one of the two");
        return None;
    }
    Some(())
}

section! {
    /// A wall: without a crest no water crosses it, with one it is overtopped.
    Wall, example "{lines: dam_line.geojson}", check check_wall {
        /// File with its lines.
        lines: VectorFile,
        /// Level of its crest: the bed of the cells that it crosses is raised to it.
        crest: Option<Quantity<Level>>,
        /// Attribute of each line that holds the crest in metres.
        crest_field: Option<Text>,
    }
}

fn check_wall(node: &Node, reader: &mut Reader) -> Option<()> {
    only_one(node, ["crest", "crest_field"], reader)
}

section! {
    /// Buildings.
    BuildingsSection, example "{polygons: buildings.geojson, mode: block}", check check_buildings {
        /// File with their footprints.
        polygons: VectorFile,
        /// block (no water gets in), raise (the bed is higher) or roughness; block when absent.
        mode: Option<Chosen<BuildingKind>>,
        /// Height by which the bed is raised.
        height: Option<Quantity<Height>>,
        /// Attribute of each polygon that holds the height in metres; height_m or height when absent.
        height_field: Option<Text>,
        /// Manning's n inside; the attribute `n` of each polygon when absent.
        n: Option<Quantity<Manning>>,
    }
}

fn check_buildings(node: &Node, reader: &mut Reader) -> Option<()> {
    only_one(node, ["height", "height_field"], reader)?;
    let mode = match node.get("mode").map(|mode| &mode.value) {
        Some(Value::Text(mode)) => mode.as_str(),
        _ => "block",
    };
    let mut is_fit = true;
    for (key, owner) in [("height", "raise"), ("height_field", "raise"), ("n", "roughness")] {
        if let Some(value) = node.get(key).filter(|_| mode != owner) {
            let message = format!("`{key}` goes with `mode: {owner}`, not with `mode: {mode}`");
            reader.error(value, "conflict", message, format!("take it out, or write `mode: {owner}`"));
            is_fit = false;
        }
    }
    is_fit.then_some(())
}

/// The breaklines of their entries, and of the walls that have a crest.
pub(super) fn breaklines(entries: Vec<BreaklineEntry>, walls: &[Wall]) -> Vec<Breakline> {
    let level = |constant: Option<Quantity<Level>>, field: Option<Text>| match (constant, field) {
        (Some(level), _) => LineLevel::Constant(level.sourced),
        (None, Some(field)) => LineLevel::Field(field.0.value),
        (None, None) => LineLevel::Vertices,
    };
    let line = |entry: BreaklineEntry| Breakline {
        lines: entry.lines.0,
        mode: entry.mode.0.value,
        level: level(entry.z, entry.z_field),
        width: entry.width.map(|width| width.value()),
    };
    let crested = walls.iter().filter(|wall| wall.has_crest()).map(|wall| Breakline {
        lines: wall.lines.0.clone(),
        mode: BreaklineMode::Raise,
        level: level(wall.crest.clone(), wall.crest_field.clone()),
        width: None,
    });
    entries.into_iter().map(line).chain(crested).collect()
}

impl Wall {
    /// Whether water flows over it.
    pub(super) fn has_crest(&self) -> bool {
        self.crest.is_some() || self.crest_field.is_some()
    }
}

/// The buildings of a section, with their defaults.
pub(super) fn buildings(section: BuildingsSection) -> Buildings {
    let mode = match section.mode.map_or(BuildingKind::Block, |mode| mode.0.value) {
        BuildingKind::Block => BuildingMode::Block,
        BuildingKind::Raise => BuildingMode::Raise {
            height: section.height.map(|height| height.value()),
            field: section.height_field.map(|field| field.0.value),
        },
        BuildingKind::Roughness => BuildingMode::Roughness(section.n.map(|n| n.value())),
    };
    Buildings { polygons: section.polygons.0, mode }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::error::{Error, Problem, ProblemKind};
    use crate::scenario::{BreaklineMode, BuildingMode, Gaps, LayerMode, LineLevel, Scenario, TerrainLayer, resolve};

    fn text(terrain: &str, structures: &str) -> String {
        format!(
            "floodsim: 1\nterrain: {terrain}\nroughness: {{manning: 0.03}}\nstructures: {structures}\n\
             initial: [{{reservoir: lake.geojson, level: 100 m}}]\nresolution: 5 m\ntime: {{end: 1 h}}\n"
        )
    }

    fn scenario(terrain: &str, structures: &str) -> Scenario {
        resolve(&text(terrain, structures), Path::new("scenario.yaml"), &[]).unwrap().scenario
    }

    fn problem(terrain: &str, structures: &str) -> Problem {
        let Err(Error::Problems(found)) = resolve(&text(terrain, structures), Path::new("scenario.yaml"), &[]) else {
            panic!("not refused: {terrain} {structures}")
        };
        found.into_iter().find(|problem| problem.kind == ProblemKind::Scenario).unwrap()
    }

    #[test]
    fn every_key_is_read() {
        let terrain = "{layers: [{raster: a.tif}, {raster: b.tif, clip: c.gpkg:area, mode: min, offset: 12 cm}], \
            breaklines: [{lines: l.gpkg, mode: raise, z_field: crest_m, width: 3 m}, {lines: d.gpkg, mode: carve, z: 4 m}, \
            {lines: three_d.gpkg, mode: raise}], gaps: {fill: idw, max_cells: 50}}";
        let structures = "{walls: [{lines: w.geojson}, {lines: crested.geojson, crest: 3 m}], \
            buildings: {polygons: b.gpkg, mode: raise, height: 2 m}}";
        let scenario = scenario(terrain, structures);
        let TerrainLayer::Raster { clip: Some(clip), mode: LayerMode::Min, .. } = &scenario.layers[1].value else {
            panic!("{:?}", scenario.layers[1])
        };
        assert_eq!((clip.value.layer.as_deref(), clip.key.as_str()), (Some("area"), "terrain.layers[1].clip"));
        let ground = scenario.ground;
        assert_eq!(ground.gaps.unwrap().value, Gaps::Fill { max_cells: 50 });
        let modes: Vec<BreaklineMode> = ground.breaklines.iter().map(|line| line.mode).collect();
        assert_eq!(modes, [BreaklineMode::Raise, BreaklineMode::Carve, BreaklineMode::Raise, BreaklineMode::Raise]);
        assert_eq!(ground.breaklines[0].level, LineLevel::Field("crest_m".to_owned()));
        assert_eq!(ground.breaklines[0].width, Some(3.0));
        assert_eq!(ground.breaklines[2].level, LineLevel::Vertices);
        assert_eq!(ground.breaklines[3].lines.key, "structures.walls[1].lines");
        assert!(
            matches!(&ground.breaklines[3].level, LineLevel::Constant(crest) if crest.key == "structures.walls[1].crest")
        );
        assert_eq!(scenario.walls.len(), 1);
        assert_eq!(ground.buildings.unwrap().mode, BuildingMode::Raise { height: Some(2.0), field: None });
    }

    #[test]
    fn gaps_and_buildings_have_short_forms() {
        for (gaps, expected) in [("wall", Gaps::Wall), ("error", Gaps::Refuse)] {
            let found = scenario(&format!("{{layers: [{{raster: a.tif}}], gaps: {gaps}}}"), "{}");
            assert_eq!(found.ground.gaps.unwrap().value, expected);
        }
        let modes = [
            ("{polygons: b.gpkg}", BuildingMode::Block),
            (
                "{polygons: b.gpkg, mode: raise, height_field: roof}",
                BuildingMode::Raise { height: None, field: Some("roof".to_owned()) },
            ),
            ("{polygons: b.gpkg, mode: roughness}", BuildingMode::Roughness(None)),
            ("{polygons: b.gpkg, mode: roughness, n: 0.3}", BuildingMode::Roughness(Some(0.3))),
        ];
        for (written, expected) in modes {
            let found = scenario("a.tif", &format!("{{buildings: {written}}}"));
            assert_eq!(found.ground.buildings.unwrap().mode, expected);
        }
    }

    #[test]
    fn what_does_not_go_together_is_refused_where_it_stands() {
        let line = |keys: &str| format!("{{layers: [{{raster: a.tif}}], breaklines: [{{lines: l.gpkg, {keys}}}]}}");
        let layer = |keys: &str| format!("{{layers: [{{raster: a.tif}}, {keys}]}}");
        let gaps = |keys: &str| format!("{{layers: [{{raster: a.tif}}], gaps: {keys}}}");
        let cases = [
            (line("z: 3 m, z_field: a, mode: raise"), "conflict", "terrain.breaklines[0]"),
            (line("z: 3 m"), "missing-key", "terrain.breaklines[0].mode"),
            (line("z: 3, mode: raise"), "missing-unit", "terrain.breaklines[0].z"),
            (line("z: 3 m, mode: raise, width: 3"), "missing-unit", "terrain.breaklines[0].width"),
            (line("z: 3 m, mode: lift"), "unknown-name", "terrain.breaklines[0].mode"),
            (layer("{raster: b.tif, offset: 0.12}"), "missing-unit", "terrain.layers[1].offset"),
            (layer("{raster: b.tif, mode: lowest}"), "unknown-name", "terrain.layers[1].mode"),
            (layer("{points: b.txt, max_gap: 3 m, unit: ft}"), "conflict", "terrain.layers[1].unit"),
            (gaps("fill"), "unknown-name", "terrain.gaps"),
            (gaps("{fill: idw}"), "missing-key", "terrain.gaps.max_cells"),
            (gaps("{fill: spline, max_cells: 3}"), "unknown-name", "terrain.gaps.fill"),
        ];
        for (terrain, code, key) in cases {
            let found = problem(&terrain, "{}");
            assert_eq!((found.code, found.key.as_str()), (code, key), "{terrain}: {found}");
            assert!(found.remedy.is_some() && found.place.is_some(), "{found}");
        }
        let structures = [
            ("{walls: [{lines: w.gpkg, crest: 3 m, crest_field: z}]}", "conflict", "structures.walls[0]"),
            ("{walls: [{lines: w.gpkg, crest: 3}]}", "missing-unit", "structures.walls[0].crest"),
            ("{buildings: {polygons: b.gpkg, height: 3 m}}", "conflict", "structures.buildings.height"),
            ("{buildings: {polygons: b.gpkg, mode: raise, n: 0.3}}", "conflict", "structures.buildings.n"),
            ("{buildings: {polygons: b.gpkg, mode: raised}}", "unknown-name", "structures.buildings.mode"),
            ("{buildings: {mode: block}}", "missing-key", "structures.buildings.polygons"),
        ];
        for (written, code, key) in structures {
            let found = problem("a.tif", written);
            assert_eq!((found.code, found.key.as_str()), (code, key), "{written}: {found}");
        }
    }
}
