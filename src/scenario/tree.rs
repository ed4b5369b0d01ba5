//! The scenario as a tree of texts, lists and sections in which everything knows its key path and its line and column.
//!
//! Reading into an untyped tree first lets `read.rs` report every problem of a file at once; a typed reader stops at the
//! first. The limits on size, depth, nodes and aliases end hostile files at once. Overrides (`--set`) change this tree.

use std::fmt;
use std::path::Path;

use serde::de::{Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_yaml::options::DuplicateKeyPolicy;
use serde_yaml::{Location, Spanned};

use crate::error::{Place, Problem, ProblemKind};

/// Deepest nesting of a scenario; the format itself needs four levels.
const MAX_DEPTH: usize = 32;
/// Most values in a scenario; the largest one by hand has some hundred.
const MAX_NODES: usize = 100_000;

/// What stands at a place of the file.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Nothing: the key stands alone, or `null`.
    Empty,
    /// A scalar of any kind, as text.
    Text(String),
    /// A list.
    List(Vec<Node>),
    /// A section: names and values in the order of the file.
    Section(Vec<Entry>),
}

/// A value with its key path and place.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The value.
    pub value: Value,
    /// Key path, such as `initial[0].level`; empty at the root.
    pub key: String,
    /// Place in the file; none where the value comes from an override.
    pub place: Option<Place>,
}

/// A name in a section and its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The name.
    pub name: String,
    /// Place of the name; none where it comes from an override.
    pub place: Option<Place>,
    /// The value.
    pub node: Node,
}

impl Node {
    /// Whether the section says something under a key.
    pub fn has(&self, key: &str) -> bool {
        self.get(key).is_some_and(|value| value.value != Value::Empty)
    }

    /// The key path of a name below this node.
    pub fn key_of(&self, name: &str) -> String {
        if self.key.is_empty() { name.to_owned() } else { format!("{}.{name}", self.key) }
    }

    /// The value below a name, if this is a section that has it.
    pub fn get(&self, name: &str) -> Option<&Node> {
        let Value::Section(entries) = &self.value else { return None };
        entries.iter().find(|entry| entry.name == name).map(|entry| &entry.node)
    }

    /// The same, to be changed.
    pub fn get_mut(&mut self, name: &str) -> Option<&mut Node> {
        let Value::Section(entries) = &mut self.value else { return None };
        entries.iter_mut().find(|entry| entry.name == name).map(|entry| &mut entry.node)
    }

    fn build(raw: Spanned<Raw>, key: String, file: Option<&Path>) -> Node {
        let place = file.and_then(|file| place_in(file, raw.referenced));
        let mut node = Node { value: Value::Empty, key, place };
        node.value = match raw.value {
            Raw::Empty => Value::Empty,
            Raw::Text(text) => Value::Text(text),
            Raw::List(items) => Value::List(
                items
                    .into_iter()
                    .enumerate()
                    .map(|(index, item)| Node::build(item, format!("{}[{index}]", node.key), file))
                    .collect(),
            ),
            Raw::Section(entries) => Value::Section(
                entries
                    .into_iter()
                    .map(|(name, value)| Entry {
                        node: Node::build(value, node.key_of(&name.value), file),
                        place: file.and_then(|file| place_in(file, name.referenced)),
                        name: name.value,
                    })
                    .collect(),
            ),
        };
        node
    }
}

/// Reads the text of a scenario into a tree.
///
/// A duplicate key is reported beside the tree, of which it keeps the first value, so that the rest can be checked too.
///
/// # Errors
/// When the text is not YAML, or exceeds the limits.
pub fn parse(text: &str, file: &Path) -> Result<(Node, Vec<Problem>), Box<Problem>> {
    let mut problems = Vec::new();
    let raw = match read_raw(text, DuplicateKeyPolicy::Error) {
        Err(error) if is_duplicate_key(&error) => {
            problems.push(syntax_problem(&error, text, file));
            read_raw(text, DuplicateKeyPolicy::FirstWins)
        }
        other => other,
    };
    let raw = raw.map_err(|error| Box::new(syntax_problem(&error, text, file)))?;
    Ok((Node::build(raw, String::new(), Some(file)), problems))
}

fn read_raw(text: &str, duplicate_keys: DuplicateKeyPolicy) -> Result<Spanned<Raw>, serde_yaml::Error> {
    let options = serde_yaml::options! {
        budget: serde_yaml::budget! {
            max_depth: MAX_DEPTH,
            max_nodes: MAX_NODES,
            max_events: 4 * MAX_NODES,
            flow_nesting_limit: MAX_DEPTH,
        },
        alias_limits: serde_yaml::alias_limits! { max_total_replayed_events: MAX_NODES / 10 },
        duplicate_keys: duplicate_keys,
        strict_booleans: true,
        non_finite_float_policy: serde_yaml::options::NonFiniteFloatPolicy::AsString,
        with_snippet: false,
    };
    serde_yaml::from_str_with_options(text, options)
}

fn is_duplicate_key(error: &serde_yaml::Error) -> bool {
    matches!(error.without_snippet(), serde_yaml::Error::DuplicateMappingKey { .. })
}

fn syntax_problem(error: &serde_yaml::Error, text: &str, file: &Path) -> Problem {
    let place = error.location().and_then(|location| place_in(file, location));
    let said = error.without_snippet().to_string();
    // The place is reported once, in front.
    let said = said.split(" at line ").next().unwrap_or_default().to_owned();
    let problem = |code, message: String| Problem::error(ProblemKind::Scenario, code, "", message);
    let problem = match error.without_snippet() {
        serde_yaml::Error::DuplicateMappingKey { key, .. } => problem(
            "duplicate-key",
            match key {
                Some(key) => format!("the key `{key}` stands twice in the same section"),
                None => "a key stands twice in the same section".to_owned(),
            },
        )
        .with_remedy("keep one of the two"),
        _ if ["limit", "budget", "nesting"].iter().any(|word| said.contains(word)) => {
            problem("too-complex", "this is too large or too deeply nested for a scenario".to_owned())
                .with_cause(said)
                .with_remedy("write the scenario out plainly, without aliases")
        }
        _ if place.as_ref().is_some_and(|place| is_bare_variable(text, place)) => {
            problem("syntax", "this is not valid YAML".to_owned())
                .with_cause("within braces or brackets, `{` of a `${NAME}` without quotes begins a section")
                .with_remedy("put the whole path in quotes, as in `\"${NAME}/dem.tif\"`")
        }
        _ => problem("syntax", "this is not valid YAML".to_owned())
            .with_cause(said)
            .with_remedy("look at the indentation, brackets and quotes here and in the line above"),
    };
    problem.with_place(place)
}

/// Whether a text has the brace of an environment variable at a place.
fn is_bare_variable(text: &str, place: &Place) -> bool {
    let line = text.lines().nth(place.line - 1).unwrap_or_default();
    place.column > 1 && line.chars().skip(place.column - 2).take(2).eq("${".chars())
}

fn place_in(file: &Path, location: Location) -> Option<Place> {
    (location.line() > 0).then(|| Place {
        file: file.to_owned(),
        line: location.line() as usize,
        column: location.column() as usize,
    })
}

/// Applies an override `key.path=value` to the tree; the value is YAML.
///
/// Missing sections on the way are made; list items must exist.
///
/// # Errors
/// With a sentence for the user when the override is malformed or its path does not fit the tree.
pub fn apply_override(root: &mut Node, text: &str) -> Result<(), String> {
    let fault = |why: &str| format!("the override `{text}` cannot be applied: {why}");
    let (path, value) = text.split_once('=').ok_or_else(|| fault("it is not of the form key.path=value"))?;
    let raw = read_raw(value, DuplicateKeyPolicy::Error)
        .map_err(|error| fault(&format!("its value is not valid YAML ({})", error.without_snippet())))?;
    let mut node = root;
    for step in path.trim().split('.') {
        let (name, indices) = split_step(step).ok_or_else(|| fault(&format!("`{step}` is not a key")))?;
        node = enter_section(node, name).map_err(|why| fault(&why))?;
        for index in indices {
            node = enter_list(node, index).map_err(|why| fault(&why))?;
        }
    }
    *node = Node::build(raw, node.key.clone(), None);
    Ok(())
}

/// The value at a key path, if the tree has it.
pub fn find<'a>(root: &'a Node, path: &str) -> Option<&'a Node> {
    let mut node = root;
    for step in path.trim().split('.') {
        let (name, indices) = split_step(step)?;
        node = node.get(name)?;
        for index in indices {
            let Value::List(items) = &node.value else { return None };
            node = items.get(index)?;
        }
    }
    Some(node)
}

/// Splits `layers[0][1]` into the name and its indices.
fn split_step(step: &str) -> Option<(&str, Vec<usize>)> {
    let (name, brackets) = step.split_at(step.find('[').unwrap_or(step.len()));
    let mut indices = Vec::new();
    let mut rest = brackets;
    while !rest.is_empty() {
        let (index, after) = rest.strip_prefix('[')?.split_once(']')?;
        indices.push(index.parse().ok()?);
        rest = after;
    }
    let is_name = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    is_name.then_some((name, indices))
}

fn enter_section<'a>(node: &'a mut Node, name: &str) -> Result<&'a mut Node, String> {
    if node.value == Value::Empty {
        node.value = Value::Section(Vec::new());
    }
    let key = node.key_of(name);
    let Value::Section(entries) = &mut node.value else {
        // `terrain: dem.tif` is short for a section.
        let long =
            if node.key == "terrain" { "; write it as one first: `terrain: {layers: [{raster: FILE}]}`" } else { "" };
        return Err(format!("`{}` is not a section{long}", node.key));
    };
    let index = entries.iter().position(|entry| entry.name == name).unwrap_or(entries.len());
    if index == entries.len() {
        let node = Node { value: Value::Empty, key, place: None };
        entries.push(Entry { name: name.to_owned(), place: None, node });
    }
    Ok(&mut entries[index].node)
}

fn enter_list(node: &mut Node, index: usize) -> Result<&mut Node, String> {
    let Value::List(items) = &mut node.value else {
        return Err(format!("`{}` is not a list", node.key));
    };
    let count = items.len();
    items.get_mut(index).ok_or_else(|| format!("`{}` has {count} entries, counted from 0", node.key))
}

/// A YAML node of any kind, before its places and key paths are known.
enum Raw {
    Empty,
    Text(String),
    List(Vec<Spanned<Raw>>),
    Section(Vec<(Spanned<String>, Spanned<Raw>)>),
}

impl<'de> Deserialize<'de> for Raw {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(RawVisitor)
    }
}

struct RawVisitor;

impl<'de> Visitor<'de> for RawVisitor {
    type Value = Raw;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("any YAML value")
    }

    fn visit_unit<E>(self) -> Result<Raw, E> {
        Ok(Raw::Empty)
    }

    fn visit_str<E>(self, text: &str) -> Result<Raw, E> {
        Ok(Raw::Text(text.to_owned()))
    }

    fn visit_bool<E>(self, value: bool) -> Result<Raw, E> {
        Ok(Raw::Text(value.to_string()))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Raw, E> {
        Ok(Raw::Text(value.to_string()))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Raw, E> {
        Ok(Raw::Text(value.to_string()))
    }

    fn visit_i128<E>(self, value: i128) -> Result<Raw, E> {
        Ok(Raw::Text(value.to_string()))
    }

    fn visit_u128<E>(self, value: u128) -> Result<Raw, E> {
        Ok(Raw::Text(value.to_string()))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Raw, E> {
        Ok(Raw::Text(value.to_string()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Raw, A::Error> {
        let mut list = Vec::new();
        while let Some(item) = items.next_element()? {
            list.push(item);
        }
        Ok(Raw::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Raw, A::Error> {
        let mut section = Vec::new();
        while let Some(entry) = entries.next_entry()? {
            section.push(entry);
        }
        Ok(Raw::Section(section))
    }
}

#[cfg(test)]
mod tests;
