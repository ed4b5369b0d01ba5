//! From the tree to typed sections, collecting every problem on the way instead of stopping at the first.
//!
//! The macro `section!` declares a section once; from that come the struct, the list of its keys, the reader that goes on
//! after a problem, and the JSON Schema.

use std::path::{Path, PathBuf};

use super::model::Sourced;
use super::tree::{Entry, Node, Value};
use crate::error::{Place, Problem, ProblemKind, Severity};

/// What reading collects: problems, and the files that the scenario names.
pub struct Reader {
    /// Folder of the scenario, from which relative paths count.
    pub folder: PathBuf,
    /// Everything found so far.
    pub problems: Vec<Problem>,
    /// Every input file named so far.
    pub files: Vec<Sourced<PathBuf>>,
}

/// A type that can be read from a node of the tree.
pub trait FromNode: Sized {
    /// An example for the remedy of a missing key.
    fn example() -> String;

    /// Reads the node; none after a problem, which the reader holds.
    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self>;

    /// What stands for a key that is absent; a problem unless the type is an `Option`.
    fn when_absent(parent: &Node, name: &str, reader: &mut Reader) -> Option<Self> {
        let mut problem = Problem::error(
            ProblemKind::Scenario,
            "missing-key",
            parent.key_of(name),
            format!("the required key `{name}` is missing"),
        );
        problem.remedy = Some(format!("add `{name}: {}`", Self::example()));
        reader.report(parent, problem);
        None
    }

    /// Reads the value below a name of a section.
    fn from_key(parent: &Node, name: &str, reader: &mut Reader) -> Option<Self> {
        match parent.get(name) {
            None => Self::when_absent(parent, name, reader),
            Some(node) => Self::from_node(node, reader),
        }
    }
}

impl<T: FromNode> FromNode for Option<T> {
    fn example() -> String {
        T::example()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        if node.value == Value::Empty { Some(None) } else { T::from_node(node, reader).map(Some) }
    }

    fn when_absent(_: &Node, _: &str, _: &mut Reader) -> Option<Self> {
        Some(None)
    }
}

impl<T: FromNode> FromNode for Vec<T> {
    fn example() -> String {
        format!("[{}]", T::example())
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let Value::List(items) = &node.value else {
            reader.wrong_type(node, "a list", "write the entries in brackets, or one a line after a dash");
            return None;
        };
        // All items are read before the first failure counts, so that every problem is found.
        let items: Vec<Option<T>> = items.iter().map(|item| T::from_node(item, reader)).collect();
        items.into_iter().collect()
    }
}

/// A list that has at least one entry.
#[derive(Clone, Debug, schemars::JsonSchema)]
#[schemars(transparent, inline)]
pub struct NonEmpty<T>(#[schemars(length(min = 1))] pub Vec<T>);

impl<T: FromNode> FromNode for NonEmpty<T> {
    fn example() -> String {
        format!("[{}]", T::example())
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        if node.value == Value::List(Vec::new()) {
            reader.error(node, "empty-list", "this list is empty", "give at least one entry");
            return None;
        }
        Vec::from_node(node, reader).map(NonEmpty)
    }
}

impl Reader {
    /// A reader for a scenario in the given folder.
    pub fn new(folder: &Path) -> Self {
        Reader { folder: folder.to_owned(), problems: Vec::new(), files: Vec::new() }
    }

    /// Adds a problem at the place of a node.
    pub fn report(&mut self, node: &Node, problem: Problem) {
        self.report_at(node.place.clone(), problem);
    }

    fn report_at(&mut self, place: Option<Place>, mut problem: Problem) {
        if place.is_none() && problem.cause.is_none() {
            problem.cause = Some("the value comes from --set".to_owned());
        }
        self.problems.push(problem.with_place(place));
    }

    /// Adds an error on a node.
    pub fn error(&mut self, node: &Node, code: &'static str, message: impl Into<String>, remedy: impl Into<String>) {
        let problem = Problem::error(ProblemKind::Scenario, code, node.key.clone(), message).with_remedy(remedy);
        self.report(node, problem);
    }

    /// Adds a warning on a node.
    pub fn warning(&mut self, node: &Node, code: &'static str, message: impl Into<String>, remedy: impl Into<String>) {
        let problem = Problem::warning(ProblemKind::Scenario, code, node.key.clone(), message).with_remedy(remedy);
        self.report(node, problem);
    }

    /// Whether an error was found.
    pub fn has_errors(&self) -> bool {
        self.problems.iter().any(|problem| problem.severity == Severity::Error)
    }

    /// Adds an error on a node of the wrong kind.
    pub fn wrong_type(&mut self, node: &Node, expected: &str, remedy: &str) {
        let found = match &node.value {
            Value::Empty => "nothing".to_owned(),
            Value::Text(text) => format!("`{}`", shorten(text)),
            Value::List(_) => "a list".to_owned(),
            Value::Section(_) => "a section".to_owned(),
        };
        let looks_misindented = matches!(&node.value, Value::Text(text) if text.contains(": ")) || found == "nothing";
        let remedy = if looks_misindented && expected == "a section" {
            "look at the indentation: the keys of a section stand on lines of their own, further to the right"
                .to_owned()
        } else {
            remedy.to_owned()
        };
        self.error(node, "wrong-type", format!("{expected} is expected here, not {found}"), remedy);
    }

    /// The text of a scalar.
    pub fn text<'a>(&mut self, node: &'a Node, expected: &str, example: &str) -> Option<&'a str> {
        if let Value::Text(text) = &node.value {
            return Some(text);
        }
        self.wrong_type(node, expected, &format!("write for example `{example}`"));
        None
    }

    /// A value with the key and place of its node.
    pub fn sourced<T>(&self, node: &Node, value: T) -> Sourced<T> {
        Sourced { value, key: node.key.clone(), place: node.place.clone() }
    }

    /// Whether the node is a section; reports each of its keys that is not among the known ones.
    pub fn is_section(&mut self, node: &Node, known: &[&str]) -> bool {
        let Value::Section(entries) = &node.value else {
            self.wrong_type(node, "a section", &format!("write a section with the keys {}", known.join(", ")));
            return false;
        };
        for Entry { name, place, .. } in entries {
            if known.contains(&name.as_str()) {
                continue;
            }
            let message = format!("unknown key `{}`", shorten(name));
            let remedy = match nearest(name, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("the keys here are {}", known.join(", ")),
            };
            let key = shorten(&node.key_of(name));
            let problem = Problem::error(ProblemKind::Scenario, "unknown-key", key, message).with_remedy(remedy);
            self.report_at(place.clone(), problem);
        }
        true
    }

    /// Of several keys of an entry, the one that is there; reports none or more than one.
    pub fn exactly_one<'a>(&mut self, node: &Node, names: &[&'a str]) -> Option<&'a str> {
        let found: Vec<&str> = names.iter().copied().filter(|name| node.has(name)).collect();
        match found[..] {
            [one] => Some(one),
            [] => {
                let message = format!("an entry here needs one of the keys {}", names.join(", "));
                // A key that is there without a value is the one that is meant.
                let meant = names.iter().find_map(|name| node.get(name)).unwrap_or(node);
                self.error(meant, "missing-key", message, format!("add for example `{}: ...`", names[0]));
                None
            }
            _ => {
                let message = format!("{} exclude each other in one entry", found.join(" and "));
                self.error(node, "conflict", message, "write one entry for each");
                None
            }
        }
    }
}

/// The folder of a scenario file, from which its paths count.
pub fn folder_of(file: &Path) -> PathBuf {
    file.parent().map(Path::to_owned).unwrap_or_default()
}

/// The start of a long text, for messages.
fn shorten(text: &str) -> String {
    const LONGEST: usize = 60;
    if text.chars().count() <= LONGEST {
        return text.to_owned();
    }
    text.chars().take(LONGEST).chain("…".chars()).collect()
}

/// The known name most like the given one, if it is like it at all: letters that are missing, too many, wrong or swapped with
/// the next one count one each (optimal string alignment).
pub fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    if name.len() > 60 {
        return None;
    }
    let plain = |text: &str| text.to_lowercase().replace(['-', ' '], "_");
    known
        .map(|candidate| (strsim::osa_distance(&plain(name), &plain(candidate)), candidate))
        .min_by_key(|(distance, _)| *distance)
        .filter(|(distance, candidate)| *distance <= 1 + candidate.len().min(name.len()) / 4)
        .map(|(_, candidate)| candidate)
}

/// Declares a section of the scenario: its documentation, an example, its keys with their types, and optionally a check
/// of how its keys fit together.
macro_rules! section {
    ($(#[$doc:meta])* $section:ident, example $example:literal $(, check $check:path)? {
        $($(#[$field_doc:meta])* $field:ident: $type:ty,)+
    }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, schemars::JsonSchema)]
        #[schemars(deny_unknown_fields, extend("x-keys" = [$(stringify!($field).trim_start_matches("r#")),+], "x-example" = $example))]
        pub struct $section {
            $($(#[$field_doc])* pub $field: $type,)+
        }

        impl $crate::scenario::read::FromNode for $section {
            fn example() -> String {
                $example.to_owned()
            }

            fn from_node(
                node: &$crate::scenario::tree::Node,
                reader: &mut $crate::scenario::read::Reader,
            ) -> Option<Self> {
                let known = [$(stringify!($field).trim_start_matches("r#")),+];
                if !reader.is_section(node, &known) {
                    return None;
                }
                $(let $field = <$type as $crate::scenario::read::FromNode>::from_key(
                    node,
                    stringify!($field).trim_start_matches("r#"),
                    reader,
                );)+
                $($check(node, reader)?;)?
                Some($section { $($field: $field?),+ })
            }
        }
    };
}
pub(crate) use section;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_suggested_only_when_near() {
        let known = ["resolution", "terrain", "time", "title"];
        assert_eq!(nearest("resoluton", known.into_iter()), Some("resolution"));
        assert_eq!(nearest("Terrian", known.into_iter()), Some("terrain"));
        assert_eq!(nearest("tim", known.into_iter()), Some("time"));
        assert_eq!(nearest("mannning", ["manning", "morning"].into_iter()), Some("manning"));
        // Two letters swapped are one slip, which a name of five letters may have twice.
        assert_eq!(nearest("lagre", ["layer", "large"].into_iter()), Some("large"));
        assert_eq!(nearest("breach", known.into_iter()), None);
    }
}
