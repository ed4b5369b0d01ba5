//! What one run was asked otherwise than another: keys of the scenario, inputs, the program.

use std::path::Path;

use serde::Serialize;

use crate::plain_file;
use crate::scenario::tree::{Node, Value, parse};

/// The resolved scenario of a run folder.
const SCENARIO: &str = "scenario.resolved.yaml";
/// Keys that change no result.
const WITHOUT_EFFECT: [&str; 3] = ["title", "outputs.folder", "limits"];

/// A value that differs; none where a run does not have it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Change {
    /// Its key in the scenario, or the path of an input.
    pub what: String,
    /// In the first run.
    pub first: Option<String>,
    /// In the second run.
    pub second: Option<String>,
}

/// All that differs.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Changes {
    /// Keys of the resolved scenarios, in the order of the first.
    pub scenario: Vec<Change>,
    /// Inputs of the same path with other content, by their checksums.
    pub inputs: Vec<Change>,
    /// Version and commit of the program.
    pub program: Option<Change>,
}

impl Changes {
    /// Whether both runs were asked the same of the same.
    pub fn is_empty(&self) -> bool {
        self.scenario.is_empty() && self.inputs.is_empty() && self.program.is_none()
    }
}

/// What differs between two run folders with the given records.
pub(super) fn between(folders: [&Path; 2], records: [&serde_json::Value; 2]) -> Changes {
    let [first, second] = folders.map(leaves);
    let [first_inputs, second_inputs] = records.map(inputs);
    let of_both = |mut changes: Vec<Change>| {
        changes.retain(|change| change.first.is_some() && change.second.is_some());
        changes
    };
    let program = |record: &serde_json::Value| Some(format!("{} ({})", text(record, "version"), text(record, "git")));
    let [old, new] = records.map(program);
    Changes {
        scenario: differing(&first, &second),
        // An input that one run alone has is a change of the scenario.
        inputs: of_both(differing(&first_inputs, &second_inputs)),
        program: (old != new).then(|| Change { what: "program".to_owned(), first: old, second: new }),
    }
}

fn text<'a>(record: &'a serde_json::Value, key: &str) -> &'a str {
    record[key].as_str().unwrap_or("unknown")
}

/// Names and values of which one side has another, or none.
fn differing(first: &[(String, String)], second: &[(String, String)]) -> Vec<Change> {
    let value = |list: &[(String, String)], name: &str| list.iter().find(|own| own.0 == name).map(|own| own.1.clone());
    let mut names: Vec<&String> = first.iter().map(|own| &own.0).collect();
    names.extend(second.iter().map(|own| &own.0).filter(|name| !first.iter().any(|own| own.0 == **name)));
    let change = |name: &String| Change { what: name.clone(), first: value(first, name), second: value(second, name) };
    names.into_iter().map(change).filter(|change| change.first != change.second).collect()
}

/// Paths and checksums of the inputs of a run.
fn inputs(record: &serde_json::Value) -> Vec<(String, String)> {
    let all = record["inputs"].as_array().into_iter().flatten();
    all.map(|input| (text(input, "path").to_owned(), text(input, "sha256").to_owned())).collect()
}

/// Keys and values of the resolved scenario of a run folder; none where it cannot be read.
fn leaves(folder: &Path) -> Vec<(String, String)> {
    let file = folder.join(SCENARIO);
    let tree = plain_file::read_to_string(&file).ok().and_then(|text| parse(&text, &file).ok());
    let mut leaves = Vec::new();
    if let Some((root, _)) = tree {
        gather(&root, &mut leaves);
    }
    let has_effect = |key: &str| {
        !WITHOUT_EFFECT.iter().any(|without| key.strip_prefix(without).is_some_and(|rest| !rest.starts_with('_')))
    };
    leaves.retain(|(key, _)| has_effect(key));
    leaves
}

fn gather(node: &Node, leaves: &mut Vec<(String, String)>) {
    match &node.value {
        Value::Empty => {}
        Value::Text(text) => leaves.push((node.key.clone(), text.clone())),
        Value::List(items) => items.iter().for_each(|item| gather(item, leaves)),
        Value::Section(entries) => entries.iter().for_each(|entry| gather(&entry.node, leaves)),
    }
}
