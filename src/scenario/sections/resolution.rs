//! `resolution`: one spacing for all cells, or levels of cells nested 2:1 with the places that are to be fine.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use crate::error::{Problem, ProblemKind};
use crate::math::readable;
use crate::scenario::defaults::{COARSEST_TO_FINEST, REACH_OF_LINES};
use crate::scenario::fields::{Distance, Length, Quantity, VectorFile};
use crate::scenario::model::{Levels, Refine, RefineShape, SAME_LENGTH, Scenario, Sourced};
use crate::scenario::read::{FromNode, Reader, section};
use crate::scenario::tree::{Entry, Node, Value};
use crate::scenario::units::LENGTH;
use crate::scenario::yaml::{Section, Yaml, quantity, vector_source};

/// The resolution: a length alone, or a section with levels.
#[derive(Clone, Debug)]
pub enum Resolution {
    /// `resolution: 20 m`
    Length(Quantity<Length>),
    /// `resolution: {finest: 5 m}`
    Levels(LevelsSection),
}

impl FromNode for Resolution {
    fn example() -> String {
        Quantity::<Length>::example()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        // Text with a colon and a blank is a section with wrong indentation rather than a length.
        let is_section = match &node.value {
            Value::Section(_) => true,
            Value::Text(text) => text.contains(": "),
            Value::Empty | Value::List(_) => false,
        };
        if is_section {
            return LevelsSection::from_node(node, reader).map(Resolution::Levels);
        }
        Quantity::from_node(node, reader).map(Resolution::Length)
    }
}

impl JsonSchema for Resolution {
    fn schema_name() -> Cow<'static, str> {
        "Resolution".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let length = generator.subschema_for::<Quantity<Length>>();
        let levels = generator.subschema_for::<LevelsSection>();
        json_schema!({"anyOf": [length, levels]})
    }
}

section! {
    /// Levels of square cells nested 2:1: each level has cells of twice the edge of the next finer one. Breaches, buildings,
    /// gauges and the like get the finest level by themselves; `refine` adds places.
    LevelsSection, example "{finest: 5 m, coarsest: 40 m}", check check_levels {
        /// Edge of the finest cells. Codes: bad-resolution, resolution-too-coarse, finer-than-terrain.
        finest: Quantity<Length>,
        /// Edge of the coarsest cells: the finest times 1, 2, 4, 8, 16, 32 or 64; eight times the finest when absent. Codes:
        /// levels-not-nested.
        coarsest: Option<Quantity<Length>>,
        /// Places that are to be fine besides those that the scene needs fine; none when absent.
        refine: Option<Vec<RefineEntry>>,
    }
}

section! {
    /// A place that is to be fine: polygons, or what lies on both sides of lines.
    RefineEntry, example "{polygons: town.geojson, to: 5 m}", check check_refine {
        /// File of polygons; `lines` is required when absent.
        polygons: Option<VectorFile>,
        /// File of lines; `polygons` is required when absent.
        lines: Option<VectorFile>,
        /// Coarsest spacing wanted there, from `finest` to `coarsest`: the level is the coarsest one whose cells are not wider;
        /// the finest when absent. Codes: range.
        to: Option<Quantity<Length>>,
        /// With `lines`: distance on both sides of a line up to which cells are fine; four times `to` when absent.
        within: Option<Quantity<Distance>>,
    }
}

fn check_refine(node: &Node, reader: &mut Reader) -> Option<()> {
    let kind = reader.exactly_one(node, &["polygons", "lines"])?;
    if !node.has(kind) {
        VectorFile::when_absent(node, kind, reader);
        return None;
    }
    if let Some(within) = node.get("within").filter(|_| kind == "polygons") {
        reader.error(within, "conflict", "`within` goes with `lines`, not with `polygons`", "take it out");
        return None;
    }
    Some(())
}

/// A length as it is written (m); none where there is no positive length, which its reader reports.
fn length(node: &Node) -> Option<f64> {
    let Value::Text(text) = &node.value else { return None };
    LENGTH.parse(text).ok().filter(|length| *length > 0.0)
}

/// Refuses a coarsest spacing that is no level above the finest one, and places finer or coarser than all levels.
fn check_levels(node: &Node, reader: &mut Reader) -> Option<()> {
    let finest = node.get("finest").and_then(length)?;
    let written = node.get("coarsest").filter(|coarsest| coarsest.value != Value::Empty);
    let coarsest = written.map_or(Some(COARSEST_TO_FINEST * finest), length);
    let highest = coarsest.and_then(|coarsest| Levels::nested(finest, coarsest));
    let mut is_fit = true;
    if let (Some(written), Some(coarsest), None) = (written, coarsest, highest) {
        reader.report(written, not_nested(written, finest, coarsest));
        is_fit = false;
    }
    let entries = match node.get("refine").map(|list| &list.value) {
        Some(Value::List(entries)) => entries.as_slice(),
        _ => &[],
    };
    for to in entries.iter().filter_map(|entry| entry.get("to")) {
        if let Some(problem) = length(to).and_then(|wanted| beyond_levels(to, wanted, finest, highest)) {
            reader.report(to, problem);
            is_fit = false;
        }
    }
    is_fit.then_some(())
}

/// The problem of a coarsest spacing that is not the finest one times a power of two; its remedy has the nearest ones that are.
fn not_nested(node: &Node, finest: f64, coarsest: f64) -> Problem {
    let most = (Levels::MOST - 1) as f64;
    let doublings = (coarsest / finest).log2();
    let near = |doublings: f64| format!("`coarsest: {} m`", readable(finest * doublings.clamp(0.0, most).exp2()));
    let (below, above) = (near(doublings.floor()), near(doublings.ceil()));
    let remedy = if below == above { format!("write {below}") } else { format!("write {below} or {above}") };
    let [finest, coarsest] = [finest, coarsest].map(readable);
    let message = format!("{coarsest} m is not 1, 2, 4, 8, 16, 32 or 64 times the finest spacing of {finest} m");
    Problem::error(ProblemKind::Scenario, "levels-not-nested", node.key.clone(), message)
        .with_cause("cells of a level have twice the edge of those of the next finer one")
        .with_remedy(remedy)
}

/// The problem of a place that is to be finer or coarser than all levels; the coarsest is not known where it is wrong itself.
fn beyond_levels(node: &Node, wanted: f64, finest: f64, coarsest: Option<f64>) -> Option<Problem> {
    let (side, cause, remedy) = if wanted < finest * (1.0 - SAME_LENGTH) {
        let finest = readable(finest);
        let cause = format!("no cell is finer than `finest`, which is {finest} m");
        ("finer than all levels", cause, format!("write `to: {finest} m` or more, or a finer `finest`"))
    } else {
        let coarsest = readable(coarsest.filter(|coarsest| wanted > coarsest * (1.0 + SAME_LENGTH))?);
        let cause =
            format!("no cell is coarser than `coarsest`, which is {coarsest} m, and this entry would do nothing");
        ("coarser than all levels", cause, format!("write `to: {coarsest} m` or less, or take the entry out"))
    };
    let message = format!("{} m is {side}", readable(wanted));
    Some(
        Problem::error(ProblemKind::Scenario, "range", node.key.clone(), message).with_cause(cause).with_remedy(remedy),
    )
}

/// What says how wide the finest cells of a scenario are.
pub(super) fn finest(root: &Node) -> Option<&Node> {
    let resolution = root.get("resolution")?;
    if let Value::Section(_) = resolution.value { resolution.get("finest") } else { Some(resolution) }
}

/// Makes a section of a length alone, so that `--set resolution.coarsest='40 m'` goes with either form.
pub(in crate::scenario) fn open_length(root: &mut Node) {
    let Some(resolution) = root.get_mut("resolution") else { return };
    if let Value::Text(_) = resolution.value {
        let node = Node { key: resolution.key_of("finest"), ..resolution.clone() };
        let entry = Entry { name: "finest".to_owned(), place: node.place.clone(), node };
        resolution.value = Value::Section(vec![entry]);
    }
}

/// Refuses levels in a scenario that has none of what they need; whether it has it all.
fn refuse_levels(root: &Node, [code, message, cause, otherwise]: [&'static str; 4], reader: &mut Reader) -> bool {
    let Some(resolution) = root.get("resolution").filter(|node| matches!(node.value, Value::Section(_))) else {
        return true;
    };
    let length = match finest(root).map(|finest| &finest.value) {
        Some(Value::Text(length)) => length.as_str(),
        _ => "20 m",
    };
    let problem = Problem::error(ProblemKind::Scenario, code, resolution.key.clone(), message)
        .with_cause(cause)
        .with_remedy(format!("write `resolution: {length}`, or {otherwise}"));
    reader.report(resolution, problem);
    false
}

/// Refuses levels for particles that move.
pub(super) fn check_lagrangian(root: &Node, reader: &mut Reader) -> bool {
    let problem = [
        "levels-for-eulerian",
        "Lagrangian particles have one spacing, and no levels",
        "levels are of cells, and only Eulerian particles stay in theirs",
        "leave `numerics.motion` and `numerics.formulation` out",
    ];
    refuse_levels(root, problem, reader)
}

/// Refuses levels where there are channels alone.
pub(super) fn check_channels_alone(root: &Node, reader: &mut Reader) -> bool {
    let problem = [
        "needs-terrain",
        "levels need terrain, and this scenario has channels alone",
        "a channel has one spacing along all of its length",
        "add `terrain: {layers: [{raster: FILE}]}`",
    ];
    refuse_levels(root, problem, reader)
}

/// The finest spacing, and the levels above it where there are such.
pub(super) fn resolved(written: Resolution) -> (Sourced<f64>, Option<Levels>) {
    let section = match written {
        Resolution::Length(length) => return (length.sourced, None),
        Resolution::Levels(section) => section,
    };
    let finest = section.finest.sourced;
    let usual = Sourced { value: COARSEST_TO_FINEST * finest.value, key: "resolution.coarsest".into(), place: None };
    let mut coarsest = section.coarsest.map_or(usual, |coarsest| coarsest.sourced);
    coarsest.value = Levels::nested(finest.value, coarsest.value).unwrap_or(coarsest.value);
    let entries = section.refine.unwrap_or_default();
    let refine = entries.into_iter().filter_map(|entry| refined(entry, finest.value)).collect();
    (finest, Some(Levels { coarsest, refine }))
}

fn refined(entry: RefineEntry, finest: f64) -> Option<Sourced<Refine>> {
    let to = entry.to.map_or(finest, |to| to.value());
    let (file, within) = match (entry.polygons, entry.lines) {
        (Some(polygons), _) => (polygons.0, None),
        (None, lines) => (lines?.0, Some(entry.within.map_or(REACH_OF_LINES * to, |within| within.value()))),
    };
    let Sourced { value: source, key, place } = file;
    let shape = match within {
        None => RefineShape::Polygons(source),
        Some(within) => RefineShape::Lines { source, within },
    };
    Some(Sourced { value: Refine { to, shape }, key, place })
}

/// The resolution in the resolved scenario.
pub(super) fn written(scenario: &Scenario) -> Yaml {
    let finest = quantity(scenario.resolution.value, "m");
    let Some(levels) = &scenario.levels else { return finest };
    let entry = |Refine { to, shape }: &Refine| {
        let to = quantity(*to, "m");
        Yaml::Entry(match shape {
            RefineShape::Polygons(source) => Section::default().with("polygons", vector_source(source)).with("to", to),
            RefineShape::Lines { source, within } => Section::default()
                .with("lines", vector_source(source))
                .with("to", to)
                .with("within", quantity(*within, "m")),
        })
    };
    Section::default()
        .with("finest", finest)
        .with("coarsest", quantity(levels.coarsest.value, "m"))
        .with_list("refine", levels.refine.iter().map(|place| entry(&place.value)).collect())
        .into()
}

#[cfg(test)]
mod tests;
