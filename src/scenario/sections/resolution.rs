//! `resolution`: one spacing for all cells, levels of cells nested 2:1 with the places that are to be fine, or `auto`.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use crate::error::{Problem, ProblemKind};
use crate::math::readable;
use crate::scenario::defaults::{COARSEST_TO_FINEST, REACH_OF_LINES};
use crate::scenario::fields::{Distance, Duration, Length, Memory, Quantity, VectorFile};
use crate::scenario::model::{Auto, Levels, Refine, RefineShape, SAME_LENGTH, Scenario, Sourced};
use crate::scenario::read::{FromNode, Reader, section};
use crate::scenario::tree::{Entry, Node, Value};
use crate::scenario::units::LENGTH;
use crate::scenario::yaml::{Section, Yaml, quantity, vector_source};

/// The word that leaves the lengths to the program.
const AUTO: &str = "auto";

/// The resolution: a length alone, a section with levels, or lengths that the program chooses.
#[derive(Clone, Debug)]
pub enum Resolution {
    /// `resolution: auto`
    Auto(Sourced<Auto>),
    /// `resolution: 20 m`
    Length(Quantity<Length>),
    /// `resolution: {finest: 5 m}`
    Levels(Box<LevelsSection>),
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
            let section = LevelsSection::from_node(node, reader)?;
            return Some(match &section.auto {
                Some(auto) => Resolution::Auto(reader.sourced(node, auto.resolved())),
                None => Resolution::Levels(Box::new(section)),
            });
        }
        if node.value == Value::Text(AUTO.to_owned()) {
            return Some(Resolution::Auto(reader.sourced(node, Auto::default())));
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
        json_schema!({"anyOf": [{"const": AUTO}, length, levels]})
    }
}

section! {
    /// Levels of square cells nested 2:1: each level has cells of twice the edge of the next finer one. Breaches, buildings,
    /// gauges and the like get the finest level by themselves; `refine` adds places. With `auto` alone the program chooses the lengths.
    LevelsSection, example "{finest: 5 m, coarsest: 40 m}", check check_levels {
        /// What lengths that the program chooses keep to; `finest` is required when absent. Codes: conflict.
        auto: Option<AutoSection>,
        /// Edge of the finest cells; required unless there is `auto` when absent. Codes: bad-resolution, resolution-too-coarse,
        /// finer-than-terrain.
        finest: Option<Quantity<Length>>,
        /// Edge of the coarsest cells: the finest times 1, 2, 4, 8, 16, 32 or 64; eight times the finest when absent. Codes:
        /// levels-not-nested.
        coarsest: Option<Quantity<Length>>,
        /// Places that are to be fine besides those that the scene needs fine; none when absent.
        refine: Option<Vec<RefineEntry>>,
    }
}

section! {
    /// What lengths that the program chooses keep to. The coarsest cells that bring the wanted error are taken, or those that the limits
    /// allow where that is more. With limits alone the finest cells within them are taken.
    AutoSection, example "{cpu: 10 min}" {
        /// CPU time that the steps of the run may take on this machine, as expected before it; no limit when absent. Codes:
        /// auto-beyond-limit.
        cpu: Option<Quantity<Duration>>,
        /// Memory that the run may take, as expected before it; that of `limits.memory` when absent. Codes: auto-beyond-limit.
        memory: Option<Quantity<Memory>>,
        /// Wanted mean error of the maximum depth; 5 % of the mean maximum depth, where nothing else is said, when absent. Codes:
        /// auto-misses-error.
        error: Option<Quantity<Length>>,
    }
}

impl AutoSection {
    fn resolved(&self) -> Auto {
        Auto {
            cpu: self.cpu.as_ref().map(Quantity::value),
            memory: self.memory.as_ref().map(Quantity::value),
            error: self.error.as_ref().map(Quantity::value),
        }
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

/// Refuses lengths beside `auto`, which chooses them, and an empty `auto`.
fn check_auto_alone(node: &Node, auto: &Node, reader: &mut Reader) -> Option<()> {
    if auto.value == Value::Empty {
        reader.error(
            auto,
            "missing-key",
            "`auto` says nothing",
            "write `resolution: auto`, or for example `auto: {cpu: 10 min}`",
        );
        return None;
    }
    let Some(besides) = ["finest", "coarsest", "refine"].into_iter().find_map(|key| node.get(key)) else {
        return Some(());
    };
    reader.error(
        besides,
        "conflict",
        "`auto` chooses the lengths, and others stand beside it",
        "take them out, or take `auto` out",
    );
    None
}

/// Refuses a coarsest spacing that is no level above the finest one, and places finer or coarser than all levels.
fn check_levels(node: &Node, reader: &mut Reader) -> Option<()> {
    if let Some(auto) = node.get(AUTO) {
        return check_auto_alone(node, auto, reader);
    }
    if !node.has("finest") {
        Quantity::<Length>::when_absent(node, "finest", reader);
        return None;
    }
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
    let has_levels = |node: &&Node| match &node.value {
        Value::Section(_) => true,
        Value::Text(text) => text == AUTO,
        Value::Empty | Value::List(_) => false,
    };
    let Some(resolution) = root.get("resolution").filter(has_levels) else { return true };
    let length = match finest(root).map(|finest| &finest.value) {
        Some(Value::Text(length)) if length != AUTO => length.as_str(),
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
        "particles that move have one spacing, and no levels",
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

/// The finest spacing, the levels above it where there are such, and what the program is to choose by; it is not a number then.
pub(super) fn resolved(written: Resolution) -> (Sourced<f64>, Option<Levels>, Option<Auto>) {
    let section = match written {
        Resolution::Auto(Sourced { value, key, place }) => {
            return (Sourced { value: f64::NAN, key, place }, None, Some(value));
        }
        Resolution::Length(length) => return (length.sourced, None, None),
        Resolution::Levels(section) => *section,
    };
    let nothing = || Sourced { value: f64::NAN, key: "resolution.finest".into(), place: None };
    let finest = section.finest.map_or_else(nothing, |finest| finest.sourced);
    let usual = Sourced { value: COARSEST_TO_FINEST * finest.value, key: "resolution.coarsest".into(), place: None };
    let mut coarsest = section.coarsest.map_or(usual, |coarsest| coarsest.sourced);
    coarsest.value = Levels::nested(finest.value, coarsest.value).unwrap_or(coarsest.value);
    let entries = section.refine.unwrap_or_default();
    let refine = entries.into_iter().filter_map(|entry| refined(entry, finest.value)).collect();
    (finest, Some(Levels { coarsest, refine }), None)
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
