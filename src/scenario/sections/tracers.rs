//! `tracers`: what is carried with the water.

#[cfg(test)]
mod tests;

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::numerics;
use crate::error::{Problem, ProblemKind};
use crate::scenario::fields::{Duration, EntryNumber, Quantity, ShareOfSource, Text, VectorFile};
use crate::scenario::methods::Formulation;
use crate::scenario::model::{Scenario, Tracer, TracerFrom, TracerPlace};
use crate::scenario::read::{FromNode, NonEmpty, Reader, section};
use crate::scenario::tree::{Node, Value};
use crate::scenario::yaml::{Section, Yaml, quantity, quoted, vector};

section! {
    /// Something that is carried with the water: marked water, a contaminant, debris that floats along.
    TracerEntry, example "{name: spill, from: [{water: spill.geojson, concentration: 100 mg/l}]}", check check_tracer {
        /// Its name, as a part of the names of variables and columns: letters, digits and underscores. Codes: tracer-name.
        name: Text,
        /// Where it comes from; all concentrations of a tracer have one unit. Codes: unit.
        from: NonEmpty<FromEntry>,
        /// Time in which half of it decays; it does not decay when absent.
        half_life: Option<Quantity<Duration>>,
        /// Share of the greatest concentration under `from` at which it counts as arrived; 0.01 when absent.
        arrival_threshold: Option<Quantity<ShareOfSource>>,
    }
}

section! {
    /// Water that has a tracer; one of `water`, `boundary`, `source` and `rain` is required.
    FromEntry, example "{water: spill.geojson, concentration: 100 mg/l}", check check_from {
        /// File with polygons: the water in them at the start; `boundary`, `source` or `rain` is required when absent. Codes:
        /// marks-no-water, empty-polygon.
        water: Option<VectorFile>,
        /// Number of an entry of `boundaries`, the first is 1: the water that comes in there; `water`, `source` or `rain` is
        /// required when absent. Codes: no-such-entry.
        boundary: Option<Quantity<EntryNumber>>,
        /// Number of an entry of `sources`, the first is 1; `water`, `boundary` or `rain` is required when absent. Codes:
        /// no-such-entry.
        source: Option<Quantity<EntryNumber>>,
        /// `true`: the rain; `water`, `boundary` or `source` is required when absent. Codes: no-such-entry.
        rain: Option<bool>,
        /// Concentration of that water with its unit, or a share without one. Codes: unit.
        concentration: Concentration,
    }
}

/// A concentration with its unit, which is only handed on.
#[derive(Clone, Debug)]
pub struct Concentration {
    value: f64,
    unit: String,
}

impl Concentration {
    /// Number and unit of a text; none where it is no such thing.
    fn read(text: &str) -> Option<Self> {
        let text = text.trim();
        let is_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | '+' | '-' | 'e' | 'E');
        // The `e` of a unit is none of the number.
        let ends = text.char_indices().map(|(at, _)| at).chain([text.len()]).rev();
        let split = ends.map(|at| text.split_at(at)).find(|(number, _)| number.parse::<f64>().is_ok());
        let (number, unit) = split.filter(|(number, _)| number.chars().all(is_number))?;
        let unit = unit.trim();
        let fits = |c: char| c.is_alphanumeric() || matches!(c, '/' | '%' | '^' | '-' | '.' | '*' | ' ' | '_');
        let value: f64 = number.parse().ok()?;
        let is_sound = value.is_finite() && value >= 0.0 && unit.len() <= LONGEST_UNIT && unit.chars().all(fits);
        is_sound.then(|| Concentration { value, unit: if unit.is_empty() { "1" } else { unit }.to_owned() })
    }
}

/// Bytes of a unit at most.
const LONGEST_UNIT: usize = 24;

impl FromNode for Concentration {
    fn example() -> String {
        "100 mg/l".to_owned()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let text = reader.text(node, "a concentration", "100 mg/l")?;
        let found = Concentration::read(text);
        if found.is_none() {
            let remedy = "write a number of 0 or more and a unit, such as `100 mg/l`, or a share alone, such as `1`";
            reader.error(node, "unit", format!("`{text}` is no concentration"), remedy);
        }
        found
    }
}

impl JsonSchema for Concentration {
    fn schema_name() -> Cow<'static, str> {
        "Concentration".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": ["string", "number"],
            "description": "A concentration with its unit, which is only handed on; a share without one.",
            "x-kind": "concentration with its unit, 0 or more",
            "examples": ["100 mg/l"],
        })
    }
}

/// Whether a name can be part of those of variables.
fn is_name(name: &str) -> bool {
    let mut letters = name.chars();
    letters.next().is_some_and(|c| c.is_ascii_alphabetic()) && letters.all(|c| c.is_ascii_alphanumeric() || c == '_')
}

fn check_tracer(node: &Node, reader: &mut Reader) -> Option<()> {
    let mut is_fit = true;
    if let Some(name) = node.get("name")
        && let Value::Text(text) = &name.value
        && !is_name(text)
    {
        let remedy = "begin with a letter, and take letters, digits and underscores, such as `spill_north`";
        reader.error(name, "tracer-name", format!("`{text}` cannot be part of the name of a variable"), remedy);
        is_fit = false;
    }
    let concentration = |entry: &Node| match &entry.get("concentration")?.value {
        Value::Text(text) => Concentration::read(text).map(|read| read.unit),
        _ => None,
    };
    if let Some(Value::List(entries)) = node.get("from").map(|list| &list.value) {
        let first = entries.iter().find_map(concentration);
        for entry in entries {
            let (Some(own), Some(first)) = (concentration(entry), &first) else { continue };
            if own != *first {
                let message = format!("this concentration is in `{own}`, and the first one of the tracer in `{first}`");
                let at = entry.get("concentration").unwrap_or(entry);
                reader.error(at, "unit", message, "write all concentrations of a tracer in one unit");
                is_fit = false;
            }
        }
    }
    is_fit.then_some(())
}

fn check_from(node: &Node, reader: &mut Reader) -> Option<()> {
    let kind = reader.exactly_one(node, &["water", "boundary", "source", "rain"])?;
    if let Some(rain) = node.get("rain").filter(|rain| kind == "rain" && rain.value == Value::Text("false".into())) {
        reader.error(rain, "conflict", "`rain: false` names no water", "write `rain: true`, or take the entry out");
        return None;
    }
    Some(())
}

/// Refuses what does not go with tracers, and entries of other sections that are not there.
pub(super) fn check(root: &Node, reader: &mut Reader) -> Option<()> {
    let Some(tracers) = root.get("tracers").filter(|tracers| tracers.value != Value::Empty) else { return Some(()) };
    let mut is_fit = refuse_methods(root, tracers, reader);
    let Value::List(entries) = &tracers.value else { return is_fit.then_some(()) };
    let mut names: Vec<String> = Vec::new();
    for entry in entries {
        if let Some(name) = entry.get("name")
            && let Value::Text(text) = &name.value
        {
            let plain = text.to_lowercase();
            if names.contains(&plain) {
                reader.error(name, "tracer-name", format!("two tracers are called `{text}`"), "give each its own name");
                is_fit = false;
            }
            names.push(plain);
        }
        if let Some(Value::List(from)) = entry.get("from").map(|list| &list.value) {
            for from in from {
                is_fit &= check_named(root, from, reader);
            }
        }
    }
    is_fit.then_some(())
}

/// Reports a boundary, source or rain under `from` that the scenario does not have; whether all is there.
fn check_named(root: &Node, from: &Node, reader: &mut Reader) -> bool {
    let count = |list: &str| match root.get(list).map(|list| &list.value) {
        Some(Value::List(entries)) => entries.len(),
        _ => 0,
    };
    let mut is_fit = true;
    for (key, list) in [("boundary", "boundaries"), ("source", "sources")] {
        let Some(number) = from.get(key) else { continue };
        let Value::Text(text) = &number.value else { continue };
        let Ok(which) = text.trim().parse::<usize>() else { continue };
        let remedy = format!("give the number of an entry of `{list}`; the first is 1");
        if which == 0 || which > count(list) {
            let message = format!("there is no entry {which} of `{list}`: it has {}", count(list));
            reader.error(number, "no-such-entry", message, remedy);
            is_fit = false;
        } else if key == "boundary"
            && let Some(Value::List(entries)) = root.get(list).map(|list| &list.value)
            && !super::scenario::lets_in(&entries[which - 1])
        {
            let message = format!("no water comes in by entry {which} of `boundaries`");
            reader.error(number, "no-such-entry", message, "name one with `discharge`, `stage` or `wave`, or `free`");
            is_fit = false;
        }
    }
    if let Some(rain) = from.get("rain").filter(|_| !root.has("rain")) {
        let remedy = "add `rain`, or take this entry out";
        reader.error(rain, "no-such-entry", "the scenario has no rain", remedy);
        is_fit = false;
    }
    is_fit
}

/// Refuses methods that carry no tracers.
fn refuse_methods(root: &Node, tracers: &Node, reader: &mut Reader) -> bool {
    let is_section = |node: &&Node| matches!(node.value, Value::Section(_));
    let numerics = root.get("numerics").filter(is_section);
    let formulation = numerics.and_then(|numerics| numerics::meant(numerics, "formulation", Formulation::default()));
    let resolution = root.get("resolution");
    let has_levels = resolution.is_some_and(|resolution| match &resolution.value {
        Value::Section(_) => true,
        Value::Text(text) => text == "auto",
        _ => false,
    });
    let has_channels = root.get("channels").is_some_and(|channels| channels.value != Value::Empty);
    let refused = [
        (
            formulation == Some(Formulation::Variational),
            "the particles of the variational formulation carry no tracers",
            "tracers go with what passes the faces of cells, which these particles do not have",
            "leave `numerics.formulation` out (or write `formulation: balanced`), or take `tracers` out",
        ),
        (
            has_levels,
            "levels of cells carry no tracers",
            "what passes from coarse to fine cells within a step is not known for tracers",
            "give one length as the `resolution`, such as `20 m`, or take `tracers` out",
        ),
        (
            has_channels,
            "channels of one dimension carry no tracers",
            "the sections of a channel have no concentration",
            "model that reach on the terrain, or take `tracers` out",
        ),
    ];
    let mut is_fit = true;
    for (_, message, cause, remedy) in refused.into_iter().filter(|(is_refused, ..)| *is_refused) {
        let problem = Problem::error(ProblemKind::Scenario, "method-combination", tracers.key.clone(), message);
        reader.report(tracers, problem.with_cause(cause).with_remedy(remedy));
        is_fit = false;
    }
    is_fit
}

/// The tracers of the sections, with their defaults.
pub(super) fn resolved(entries: Vec<TracerEntry>) -> Vec<Tracer> {
    let number = |quantity: &Quantity<EntryNumber>| quantity.value() as usize - 1;
    let one = |entry: TracerEntry| {
        let unit = entry.from.0.first().map_or_else(String::new, |from| from.concentration.unit.clone());
        let from = entry.from.0.into_iter().filter_map(|from| {
            let place = match (from.water, from.boundary, from.source) {
                (Some(water), ..) => TracerPlace::Water(water.0),
                (None, Some(boundary), _) => TracerPlace::Boundary(number(&boundary)),
                (None, None, Some(source)) => TracerPlace::Source(number(&source)),
                (None, None, None) => from.rain.filter(|rain| *rain).map(|_| TracerPlace::Rain)?,
            };
            Some(TracerFrom { place, concentration: from.concentration.value })
        });
        Tracer {
            name: entry.name.0,
            unit,
            from: from.collect(),
            half_life: entry.half_life.map(|half_life| half_life.value()),
            arrival_threshold: entry.arrival_threshold.map_or(ARRIVAL_THRESHOLD, |share| share.value()),
        }
    };
    entries.into_iter().map(one).collect()
}

/// The share at which a tracer counts as arrived, where none is given.
const ARRIVAL_THRESHOLD: f64 = 0.01;

/// A tracer in the resolved scenario, which has its open edges before other boundaries.
pub(super) fn written(tracer: &Tracer, scenario: &Scenario) -> Yaml {
    let entry = |which: usize| 1 + scenario.open.len() + scenario.boundary_of_entry(which).unwrap_or(which);
    let from = tracer.from.iter().map(|from| {
        let section = match &from.place {
            TracerPlace::Water(polygons) => Section::default().with("water", vector(polygons)),
            TracerPlace::Boundary(which) => Section::default().with("boundary", entry(*which) as f64),
            TracerPlace::Source(which) => Section::default().with("source", (which + 1) as f64),
            TracerPlace::Rain => Section::default().with("rain", true),
        };
        Yaml::Entry(section.with("concentration", quoted(&format!("{} {}", from.concentration, tracer.unit))))
    });
    Yaml::Section(
        Section::default()
            .with("name", quoted(&tracer.name.value))
            .with_list("from", from.collect())
            .with_some("half_life", tracer.half_life.map(|half_life| quantity(half_life, "s")))
            .with("arrival_threshold", tracer.arrival_threshold),
    )
}
