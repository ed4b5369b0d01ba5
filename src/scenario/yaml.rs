//! Values to be written as YAML: sections in the order in which they were made, and entries of one line. How texts are quoted and
//! numbers written is left to the crate that reads them (`serde-saphyr`).

use std::path::Path;

use serde::ser::{Serialize, SerializeMap, Serializer};
use serde_yaml::{DoubleQuoted, FlowMap, FlowSeq, ser_options, to_string_with_options};

use crate::scenario::choices::Choice;
use crate::scenario::model::{Sourced, VectorSource};

/// A value of the resolved scenario.
#[derive(Clone, Debug)]
pub(super) enum Yaml {
    /// A name, or a quantity with its unit.
    Word(String),
    /// A text of the user, in quotes.
    Quoted(String),
    /// A number with all its digits.
    Number(f64),
    /// A choice of two.
    Flag(bool),
    /// A list, one entry a line.
    List(Vec<Yaml>),
    /// A list on one line.
    Row(Vec<Yaml>),
    /// A section, one key a line.
    Section(Section),
    /// A section on one line.
    Entry(Section),
}

/// Keys with their values, in their order.
#[derive(Clone, Debug, Default)]
pub(super) struct Section(Vec<(&'static str, Yaml)>);

impl Section {
    /// With one more key.
    pub fn with(mut self, key: &'static str, value: impl Into<Yaml>) -> Self {
        self.0.push((key, value.into()));
        self
    }

    /// With one more key where it has a value.
    pub fn with_some(self, key: &'static str, value: Option<impl Into<Yaml>>) -> Self {
        match value {
            Some(value) => self.with(key, value),
            None => self,
        }
    }

    /// With a list, one entry a line, where it has entries.
    pub fn with_list(self, key: &'static str, entries: Vec<Yaml>) -> Self {
        if entries.is_empty() { self } else { self.with(key, Yaml::List(entries)) }
    }

    /// With a list on one line, where it has entries.
    pub fn with_row(self, key: &'static str, entries: Vec<Yaml>) -> Self {
        if entries.is_empty() { self } else { self.with(key, Yaml::Row(entries)) }
    }

    /// With all keys of another section behind its own.
    pub fn and(mut self, other: Section) -> Self {
        self.0.extend(other.0);
        self
    }

    /// Whether it has no key.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The text of a file that has these keys.
    #[expect(clippy::expect_used, reason = "a tree of texts and numbers in memory has nothing that could fail")]
    pub fn text(&self) -> String {
        let options = ser_options! { prefer_block_scalars: false, compact_list_indent: false };
        to_string_with_options(self, options).expect("invariant: keys are texts, and the options are sound")
    }
}

impl From<Section> for Yaml {
    fn from(section: Section) -> Self {
        Yaml::Section(section)
    }
}

impl From<&str> for Yaml {
    fn from(word: &str) -> Self {
        Yaml::Word(word.to_owned())
    }
}

impl From<f64> for Yaml {
    fn from(number: f64) -> Self {
        Yaml::Number(number)
    }
}

impl From<bool> for Yaml {
    fn from(flag: bool) -> Self {
        Yaml::Flag(flag)
    }
}

/// A quantity in its unit, with all its digits.
pub(super) fn quantity(value: f64, unit: &str) -> Yaml {
    Yaml::Word(format!("{value} {unit}"))
}

/// A text of the user.
pub(super) fn quoted(text: &str) -> Yaml {
    Yaml::Quoted(text.to_owned())
}

/// A point.
pub(super) fn point([x, y]: [f64; 2]) -> Yaml {
    Yaml::Row(vec![x.into(), y.into()])
}

impl Serialize for Section {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (key, value) in &self.0 {
            map.serialize_entry(key, value)?;
        }
        map.end()
    }
}

impl Serialize for Yaml {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Yaml::Word(word) => serializer.serialize_str(word),
            Yaml::Quoted(text) => DoubleQuoted(text).serialize(serializer),
            Yaml::Number(number) => {
                let whole = *number as i64;
                let is_whole = (whole as f64).to_bits() == number.to_bits();
                if is_whole { serializer.serialize_i64(whole) } else { serializer.serialize_f64(*number) }
            }
            Yaml::Flag(flag) => serializer.serialize_bool(*flag),
            Yaml::List(entries) => entries.serialize(serializer),
            Yaml::Row(entries) => FlowSeq(entries).serialize(serializer),
            Yaml::Section(section) => section.serialize(serializer),
            Yaml::Entry(section) => FlowMap(section).serialize(serializer),
        }
    }
}

/// A section where it has a key.
pub fn filled(section: Section) -> Option<Section> {
    Some(section).filter(|section| !section.is_empty())
}
/// The name of a choice.
pub fn name_of<T: Choice>(is_it: impl Fn(&T) -> bool) -> &'static str {
    T::choices().into_iter().find(|(_, candidate)| is_it(candidate)).map_or("unknown", |(name, _)| name)
}
/// A vector file, with its layer where it has one.
pub fn vector(source: &Sourced<VectorSource>) -> Yaml {
    vector_source(&source.value)
}
/// The same without its place.
pub fn vector_source(source: &VectorSource) -> Yaml {
    let path = absolute(&source.path);
    Yaml::Quoted(match &source.layer {
        Some(layer) => format!("{path}:{layer}"),
        None => path,
    })
}
/// A file.
pub fn file(path: &Path) -> Yaml {
    Yaml::Quoted(absolute(path))
}
fn absolute(path: &Path) -> String {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned()).display().to_string()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use proptest::prelude::*;

    use super::*;
    use crate::scenario::tree::{Node, Value, parse};

    /// The texts of the values of a section that is written and read again, and of the items of its rows.
    fn read_back(section: &Section) -> Vec<String> {
        fn texts(node: &Node, found: &mut Vec<String>) {
            match &node.value {
                Value::Text(text) => found.push(text.clone()),
                Value::List(items) => items.iter().for_each(|item| texts(item, found)),
                Value::Section(entries) => entries.iter().for_each(|entry| texts(&entry.node, found)),
                Value::Empty => found.push("nothing".to_owned()),
            }
        }
        let text = section.text();
        let (node, problems) = parse(&text, Path::new("s.yaml")).unwrap_or_else(|problem| panic!("{problem}: {text}"));
        assert!(problems.is_empty(), "{problems:?}");
        let mut found = Vec::new();
        texts(&node, &mut found);
        found
    }

    #[test]
    fn the_form_is_that_of_scenarios_by_hand() {
        let entry = Section::default().with("at", point([712_345.5, -3.0])).with("discharge", quantity(0.1, "m3/s"));
        let section = Section::default()
            .with("title", quoted("a \"b\": #c"))
            .with("time", Section::default().with("end", quantity(60.0, "s")).with("is_late", false))
            .with_list("sources", vec![Yaml::Entry(entry)])
            .with_list("walls", Vec::new())
            .with("isochrones", Yaml::Row(Vec::new()))
            .with("cfl", 0.45);
        let expected = "title: \"a \\\"b\\\": #c\"\ntime:\n  end: 60 s\n  is_late: false\nsources:\n  - {at: [712345.5, -3], discharge: 0.1 m3/s}\n\
             isochrones: []\ncfl: 0.45\n";
        assert_eq!(section.text(), expected);
    }

    proptest! {
        #[test]
        fn every_text_reads_back_as_itself(text in any::<String>(), other in "[ -~\\n\\t\\u{85}\\u{2028}\\u{feff}]{0,90}") {
            let row = Yaml::Row(vec![quoted(&text), quoted(&other)]);
            let entry = Section::default().with("a", quoted(&other)).with("b", quoted(&text));
            let section =
                Section::default().with("a", quoted(&text)).with("b", row).with_list("c", vec![Yaml::Entry(entry)]);
            let expected = [&text, &text, &other, &other, &text];
            prop_assert_eq!(read_back(&section), expected.map(String::clone));
        }

        #[test]
        fn every_number_reads_back_to_the_last_bit(bits in any::<u64>(), small in -1e7..1e7) {
            for number in [f64::from_bits(bits), small, f64::trunc(small), -0.0, 1e15, 4e-6, 1e300, f64::MAX, f64::MIN_POSITIVE] {
                if !number.is_finite() {
                    continue;
                }
                let row = point([number, number]);
                let section = Section::default().with("a", number).with("b", row).with("c", quantity(number, "m"));
                let found = read_back(&section);
                let read = |text: &str| text.trim_end_matches(" m").parse::<f64>().map(f64::to_bits);
                for text in &found {
                    prop_assert_eq!(read(text), Ok(number.to_bits()), "{} of {}", text, number);
                }
            }
        }
    }
}
