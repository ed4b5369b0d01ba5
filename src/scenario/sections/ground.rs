//! What planners build into the terrain: how its layers meet, its holes, breaklines and buildings; as written, and as it
//! becomes in the resolved scenario.

use crate::scenario::choices::{Choice, Chosen};
use crate::scenario::fields::{Height, Length, Level, Manning, Quantity, Text, VectorFile};
use crate::scenario::model::{
    Breakline, BreaklineMode, BuildingMode, Buildings, LineLevel, Scenario, Sourced, VectorSource,
};
use crate::scenario::read::{Reader, section};
use crate::scenario::tree::{Node, Value};
use crate::scenario::yaml::{Section, Yaml, quantity, quoted, vector};

/// The name of what a breakline does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BreaklineKind {
    /// `raise`
    Raise,
    /// `carve`
    Carve,
    /// `follow`
    Follow,
}

impl Choice for BreaklineKind {
    const WHAT: &'static str = "a mode of a breakline";

    fn choices() -> Vec<(&'static str, Self)> {
        vec![("raise", BreaklineKind::Raise), ("carve", BreaklineKind::Carve), ("follow", BreaklineKind::Follow)]
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

section! {
    /// Lines along which the bed is raised (levees) or carved (channels), a cell wide at least; or that the sides of cells follow (banks, toes
    /// and crests of dikes).
    BreaklineEntry, example "{lines: levees.geojson, mode: raise, z_field: crest_m}", check check_breakline {
        /// File of lines; outlines of polygons count as lines. Codes: outside-terrain, no-lines, left-out, crest-below-terrain,
        /// invert-above-terrain, method-combination.
        lines: VectorFile,
        /// `raise`: nothing under the line lies lower than its level; `carve`: nothing lies higher; `follow`: the ground stays, and cells
        /// beside the line have sides on it. Codes: crest-below-terrain, invert-above-terrain, method-combination.
        mode: Chosen<BreaklineKind>,
        /// Level of all its lines; that of `z_field` when absent. Codes: implausible-level, doubtful-level.
        z: Option<Quantity<Level>>,
        /// Attribute that holds the level of each line (m); the third coordinate of the vertices, linear between them, without
        /// `z` when absent. Codes: no-level, unit-of-attribute, implausible-level, doubtful-level.
        z_field: Option<Text>,
        /// Cells whose centres lie within half of it belong to the line, too; one cell when absent. Codes: method-combination.
        width: Option<Quantity<Length>>,
    }
}

fn check_breakline(node: &Node, reader: &mut Reader) -> Option<()> {
    only_one(node, ["z", "z_field"], reader)?;
    let is_followed = matches!(node.get("mode").map(|mode| &mode.value), Some(Value::Text(mode)) if mode == "follow");
    let mut is_fit = true;
    for key in ["z", "z_field", "width"] {
        if let Some(value) = node.get(key).filter(|_| is_followed) {
            let message = format!("`{key}` goes with `mode: raise` or `carve`, not with `mode: follow`");
            reader.error(value, "conflict", message, "take it out, or write another `mode`");
            is_fit = false;
        }
    }
    is_fit.then_some(())
}

/// Refuses two keys beside each other.
fn only_one(node: &Node, [first, second]: [&str; 2], reader: &mut Reader) -> Option<()> {
    if node.has(first) && node.has(second) {
        let message = format!("`{first}` and `{second}` exclude each other");
        reader.error(node, "conflict", message, "keep one of the two");
        return None;
    }
    Some(())
}

section! {
    /// A wall of no width: no water crosses it, or only over its crest.
    Wall, example "{lines: dam_line.geojson}", check check_wall {
        /// File of lines that no water crosses; outlines of polygons count as lines. Codes: gap-on-lattice, narrow-gap,
        /// outside-terrain, no-lines, wall-in-breach.
        lines: VectorFile,
        /// Level of the crest, over which water flows: a raised breakline of one cell; that of `crest_field` when absent. Codes:
        /// crest-below-terrain, doubtful-level, implausible-level, method-combination.
        crest: Option<Quantity<Level>>,
        /// Attribute that holds the crest of each line (m); no water crosses the wall, without `crest`, when absent. Codes:
        /// no-level, unit-of-attribute, crest-below-terrain, doubtful-level.
        crest_field: Option<Text>,
    }
}

fn check_wall(node: &Node, reader: &mut Reader) -> Option<()> {
    only_one(node, ["crest", "crest_field"], reader)
}

section! {
    /// Buildings by their footprints: blocked, raised, or rougher ground.
    BuildingsSection, example "{polygons: buildings.geojson, mode: block}", check check_buildings {
        /// File of footprints; cells follow the outlines of blocked buildings, and a cell belongs to another one when its centre lies in
        /// it. Codes: building-too-small, building-too-narrow, outside-terrain, empty-polygon, self-crossing.
        polygons: VectorFile,
        /// `block` (no water gets in, there is no terrain), `raise` (the bed is higher) or `roughness` (another n inside); block
        /// when absent.
        mode: Option<Chosen<BuildingKind>>,
        /// With `raise`: height above the ground, at most 1000 m; that of `height_field` when absent. Codes: building-range,
        /// doubtful-height.
        height: Option<Quantity<Height>>,
        /// With `raise`: attribute of each polygon that holds its height (m); `height_m` or `height` when absent. Codes:
        /// building-value, unit-of-attribute, building-range, doubtful-height.
        height_field: Option<Text>,
        /// With `roughness`: Manning's n inside; the attribute `n`, `manning` or `manning_n` of each polygon when absent. Codes:
        /// building-value, building-range.
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

/// The breaklines of their entries, and of the walls that have a crest; and the files of lines that cells follow.
pub(super) fn breaklines(entries: Vec<BreaklineEntry>, walls: &[Wall]) -> (Vec<Breakline>, Vec<Sourced<VectorSource>>) {
    let level = |constant: Option<Quantity<Level>>, field: Option<Text>| match (constant, field) {
        (Some(level), _) => LineLevel::Constant(level.sourced),
        (None, Some(field)) => LineLevel::Field(field.0.value),
        (None, None) => LineLevel::Vertices,
    };
    let (mut shaping, mut followed) = (Vec::new(), Vec::new());
    for entry in entries {
        let mode = match entry.mode.0.value {
            BreaklineKind::Follow => {
                followed.push(entry.lines.0);
                continue;
            }
            BreaklineKind::Raise => BreaklineMode::Raise,
            BreaklineKind::Carve => BreaklineMode::Carve,
        };
        shaping.push(Breakline {
            lines: entry.lines.0,
            mode,
            level: level(entry.z, entry.z_field),
            width: entry.width.map(|width| width.value()),
        });
    }
    let crested = walls.iter().filter(|wall| wall.has_crest()).map(|wall| Breakline {
        lines: wall.lines.0.clone(),
        mode: BreaklineMode::Raise,
        level: level(wall.crest.clone(), wall.crest_field.clone()),
        width: None,
    });
    shaping.extend(crested);
    (shaping, followed)
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

section! {
    /// Structures that hold or divert water.
    Structures, example "{walls: [{lines: dam_line.geojson}]}" {
        /// Walls that no water crosses, such as a dam that stands, or only over their crest; none when absent.
        walls: Option<Vec<Wall>>,
        /// Footprints of buildings; none when absent.
        buildings: Option<BuildingsSection>,
    }
}

pub(super) fn written(scenario: &Scenario) -> Section {
    let walls = scenario.walls.iter().map(|wall| Yaml::Entry(Section::default().with("lines", vector(wall))));
    let crested = scenario.ground.breaklines.iter().filter(|line| is_wall(line)).map(|wall| {
        let lines = Section::default().with("lines", vector(&wall.lines));
        Yaml::Entry(lines.and(level(["crest", "crest_field"], &wall.level)))
    });
    let buildings = scenario.ground.buildings.as_ref().map(|buildings| {
        let mode = match &buildings.mode {
            BuildingMode::Block => Section::default().with("mode", "block"),
            BuildingMode::Raise { height, field } => Section::default()
                .with("mode", "raise")
                .with_some("height", height.map(|height| quantity(height, "m")))
                .with_some("height_field", field.as_deref().filter(|_| height.is_none()).map(quoted)),
            BuildingMode::Roughness(n) => Section::default().with("mode", "roughness").with_some("n", *n),
        };
        Yaml::Entry(Section::default().with("polygons", vector(&buildings.polygons)).and(mode))
    });
    Section::default().with_list("walls", walls.chain(crested).collect()).with_some("buildings", buildings)
}

/// Whether a breakline is a wall with a crest.
pub(super) fn is_wall(line: &Breakline) -> bool {
    line.lines.key.starts_with("structures.")
}
/// The level of a breakline, by the keys of a constant and of an attribute.
pub(super) fn level([constant, field]: [&'static str; 2], level: &LineLevel) -> Section {
    match level {
        LineLevel::Constant(level) => Section::default().with(constant, quantity(level.value, "m")),
        LineLevel::Field(name) => Section::default().with(field, quoted(name)),
        LineLevel::Vertices => Section::default(),
    }
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
