//! The study file: a base scenario, what varies, how often it is drawn, and which variants stand beside each other.

use std::path::{Path, PathBuf};

use super::spread::Law;
use crate::error::{Error, Problem, ProblemKind, sort_problems};
use crate::plain_file;
use crate::scenario::choices::{Choice, Chosen};
use crate::scenario::fields::{FormatVersion, Length, Quantity, SampleCount, Seed, Text};
use crate::scenario::read::{FromNode, NonEmpty, Reader, folder_of, section};
use crate::scenario::tree::{Node, Value, parse};
use crate::study::{Amount, is_folder_name};

/// Samples where values are drawn and the study does not say how many.
const SAMPLES: f64 = 32.0;
/// Depths (m) whose exceedance is mapped where the study does not say which: limits of flood maps.
const DEPTHS: [f64; 3] = [0.5, 1.0, 2.0];

/// How samples are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sampling {
    /// Owen-scrambled Sobol sequence: a study with more samples has those of one with fewer.
    Sobol,
    /// Latin hypercube: each value once in each of as many strata as there are samples.
    LatinHypercube,
}

impl Choice for Sampling {
    const WHAT: &'static str = "a way of sampling";

    fn choices() -> Vec<(&'static str, Self)> {
        vec![("sobol", Sampling::Sobol), ("latin_hypercube", Sampling::LatinHypercube)]
    }
}

section! {
    /// A study: many runs of one scenario.
    StudySection, example "{study: 1, base: scenario.yaml, vary: [{key: roughness.manning, range: [0.03, 0.05]}]}" {
        /// Version of the format.
        study: FormatVersion,
        /// Title.
        title: Option<Text>,
        /// The scenario that varies, relative to the study file.
        base: Text,
        /// Folder of the study, relative to the study file; `studies/NAME` in the current folder when absent.
        folder: Option<Text>,
        /// What varies.
        vary: Option<NonEmpty<VarySection>>,
        /// How many samples are drawn of the values that have a distribution; 32 when absent.
        samples: Option<Quantity<SampleCount>>,
        /// How they are drawn; `sobol` when absent.
        sampling: Option<Chosen<Sampling>>,
        /// Number from which they are drawn; 0 when absent.
        seed: Option<Quantity<Seed>>,
        /// Scenarios beside each other, as with and without a failure; the base alone when absent.
        variants: Option<NonEmpty<VariantSection>>,
        /// Depths whose exceedance is mapped; 0.5, 1 and 2 m when absent.
        depths: Option<NonEmpty<Quantity<Length>>>,
    }
}

section! {
    /// A key of the scenario and the values that it takes.
    VarySection, example "{key: roughness.manning, range: [0.03, 0.05]}" {
        /// The key, as with `--set`.
        key: Text,
        /// Its name in tables; the key when absent.
        name: Option<Text>,
        /// Whether the values are factors of that of the base; `false` when absent.
        times: Option<bool>,
        /// Values, each with all others.
        values: Option<NonEmpty<Text>>,
        /// Least and greatest, all between equally likely.
        range: Option<Vec<Text>>,
        /// Least, likeliest and greatest.
        triangular: Option<Vec<Text>>,
        /// Normal distribution.
        normal: Option<NormalSection>,
        /// Lognormal distribution.
        lognormal: Option<LognormalSection>,
    }
}

section! {
    /// A normal distribution.
    NormalSection, example "{mean: 0.035, deviation: 0.005}" {
        /// Mean.
        mean: Text,
        /// Standard deviation.
        deviation: Text,
    }
}

section! {
    /// A lognormal distribution.
    LognormalSection, example "{median: 35 min, factor: 1.6}" {
        /// Median.
        median: Text,
        /// Within this factor of the median lie 68 %.
        factor: Text,
    }
}

section! {
    /// A scenario beside others, with the same values of what varies.
    VariantSection, example "{name: without_failure, set: [breach=]}" {
        /// Its name, of letters, digits, `_` and `-`.
        name: Text,
        /// What is other than in the base, as with `--set`.
        set: Option<Vec<Text>>,
    }
}

/// The values that a key takes.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Values {
    /// These, each with all others.
    Listed(Vec<String>),
    /// Drawn from a distribution, in a unit.
    Drawn(Law, String),
}

/// What varies.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Variable {
    pub key: String,
    pub name: String,
    /// Whether the values are factors of that of the base.
    pub is_factor: bool,
    pub values: Values,
}

impl Variable {
    /// Whether its values are drawn from a distribution.
    pub fn is_drawn(&self) -> bool {
        matches!(self.values, Values::Drawn(..))
    }
}

/// A scenario beside others.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Variant {
    /// Empty of the base alone.
    pub name: String,
    /// What it sets, `KEY=VALUE`.
    pub set: Vec<String>,
}

impl Variant {
    /// The keys that it sets.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        self.set.iter().filter_map(|text| Some(text.split_once('=')?.0.trim()))
    }

    /// Whether it sets a key, or a section that it stands in.
    pub fn decides(&self, key: &str) -> bool {
        self.keys().any(|own| is_within(key, own))
    }
}

/// A study, all defaults filled in.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Study {
    pub title: String,
    pub base: PathBuf,
    pub folder: PathBuf,
    pub variables: Vec<Variable>,
    pub samples: usize,
    pub sampling: Sampling,
    pub seed: u32,
    pub variants: Vec<Variant>,
    pub depths: Vec<f64>,
}

impl Study {
    /// Reads a study file.
    ///
    /// # Errors
    /// With all problems of the file.
    pub fn read(file: &Path) -> Result<Study, Error> {
        let text = plain_file::read_to_string(file).map_err(|cause| {
            let message = format!("the study file `{}` cannot be read", file.display());
            let problem = Problem::error(ProblemKind::Scenario, "unreadable-file", "", message);
            let remedy = "give the path of a study file, or the folder of a study";
            Error::Problems(vec![problem.with_cause(cause.to_string()).with_remedy(remedy)])
        })?;
        let (root, duplicates) = parse(&text, file).map_err(|problem| Error::Problems(vec![*problem]))?;
        let mut reader = Reader::new(&folder_of(file));
        reader.problems = duplicates;
        let section = StudySection::from_node(&root, &mut reader);
        let study = section.and_then(|section| resolved(section, &root, file, &mut reader));
        match study {
            Some(study) if !reader.has_errors() => Ok(study),
            _ => {
                sort_problems(&mut reader.problems);
                Err(Error::Problems(reader.problems))
            }
        }
    }
}

/// The path of a place without `..` and links, as far as it is there.
fn real(path: &Path) -> Option<PathBuf> {
    let whole = std::path::absolute(path).ok()?;
    let there = whole.ancestors().find(|ancestor| ancestor.exists())?;
    let rest = whole.strip_prefix(there).ok()?;
    let there = there.canonicalize().ok()?;
    // An empty rest would add a slash.
    Some(if rest.as_os_str().is_empty() { there } else { there.join(rest) })
}

/// Whether a key is another one, or stands in its section.
fn is_within(key: &str, section: &str) -> bool {
    key.strip_prefix(section).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}

/// Reports a variable whose key cannot vary, or varies already.
fn check_key(variables: &[Variable], variable: &Variable, node: &Node, reader: &mut Reader) {
    let key = variable.key.as_str();
    let overlaps =
        |other: &&Variable| is_within(key, &other.key) || is_within(&other.key, key) || other.name == variable.name;
    if key.contains('=') || is_within(key, "outputs.folder") {
        let remedy = "name a key of the scenario alone; each member has a folder of its own";
        reader.error(node, "conflict", format!("`{key}` cannot vary"), remedy);
    } else if let Some(other) = variables.iter().find(overlaps) {
        let message = format!("`{key}` and `{}` are the same, one holds the other, or both have one name", other.key);
        reader.error(node, "conflict", message, "vary each key once, and give each its own `name`");
    }
}

/// The node of an entry of a list.
fn entry<'a>(root: &'a Node, list: &str, index: usize) -> Option<&'a Node> {
    match &root.get(list)?.value {
        Value::List(items) => items.get(index),
        _ => None,
    }
}

fn resolved(section: StudySection, root: &Node, file: &Path, reader: &mut Reader) -> Option<Study> {
    let mut variables = Vec::new();
    for (index, vary) in section.vary.map(|list| list.0).unwrap_or_default().into_iter().enumerate() {
        let node = entry(root, "vary", index).unwrap_or(root);
        if let Some(variable) = variable(vary, node, reader) {
            check_key(&variables, &variable, node, reader);
            variables.push(variable);
        }
    }
    let mut variants: Vec<Variant> = Vec::new();
    for (index, VariantSection { name, set }) in
        section.variants.map(|list| list.0).unwrap_or_default().into_iter().enumerate()
    {
        let (node, name) = (entry(root, "variants", index).unwrap_or(root), name.0.value);
        if !is_folder_name(&name) || name.contains("_less_") || variants.iter().any(|other| other.name == name) {
            let remedy = "give each variant its own name of letters, digits, `_` and `-`";
            reader.error(node, "variant-name", format!("`{name}` is no name of a variant"), remedy);
        }
        let set: Vec<String> = set.unwrap_or_default().into_iter().map(|text| text.0.value).collect();
        let variant = Variant { name, set };
        let sets_part =
            |variable: &&Variable| variant.keys().any(|own| own != variable.key && is_within(own, &variable.key));
        if let Some(variable) = variables.iter().find(sets_part) {
            let message = format!("the variant sets a part of `{}`, which varies as a whole", variable.key);
            reader.error(node, "conflict", message, "vary the part, or set the whole");
        }
        variants.push(variant);
    }
    if variables.is_empty() && variants.len() < 2 && !reader.has_errors() {
        let remedy = "add for example `vary: [{key: roughness.manning, values: [0.03, 0.04, 0.05]}]`";
        reader.error(root, "nothing-varies", "nothing varies in this study", remedy);
    }
    if variants.is_empty() {
        variants.push(Variant { name: String::new(), set: Vec::new() });
    }
    let FormatVersion = section.study;
    let is_drawn = variables.iter().any(Variable::is_drawn);
    let samples = section.samples.map_or(SAMPLES, |samples| samples.value());
    let stem = file.file_stem().unwrap_or_default();
    let folder =
        section.folder.map_or_else(|| Path::new("studies").join(stem), |text| folder_of(file).join(text.0.value));
    // One path for one place, from wherever the study is called.
    let absolute = |path: PathBuf| real(&path).unwrap_or(path);
    Some(Study {
        title: section.title.map_or_else(|| stem.to_string_lossy().into_owned(), |text| text.0.value),
        base: absolute(folder_of(file).join(section.base.0.value)),
        folder: absolute(folder),
        variables,
        samples: if is_drawn { samples as usize } else { 1 },
        sampling: section.sampling.map_or(Sampling::Sobol, |chosen| chosen.0.value),
        seed: section.seed.map_or(0, |seed| seed.value() as u32),
        variants,
        depths: section.depths.map_or(DEPTHS.to_vec(), |list| apart(list.0.iter().map(Quantity::value).collect())),
    })
}

/// Depths (m) in ascending order that differ by a tenth of a millimetre at least, as the names of their maps do.
fn apart(mut depths: Vec<f64>) -> Vec<f64> {
    const LEAST: f64 = 1e-4;
    depths.sort_by(f64::total_cmp);
    depths.dedup_by(|one, other| *one - *other < LEAST);
    depths
}

/// What varies, of an entry; a problem where it cannot be understood.
fn variable(section: VarySection, node: &Node, reader: &mut Reader) -> Option<Variable> {
    const WAYS: [&str; 5] = ["values", "range", "triangular", "normal", "lognormal"];
    let way = reader.exactly_one(node, &WAYS)?;
    let key = section.key.0.value;
    let is_factor = section.times.unwrap_or(false);
    let texts = |list: Vec<Text>| list.into_iter().map(|text| text.0.value).collect::<Vec<String>>();
    let values = match (section.values, section.range, section.triangular, section.normal, section.lognormal) {
        (Some(list), ..) => Values::Listed(texts(list.0)),
        (_, Some(range), ..) => drawn(node, way, &texts(range), reader)?,
        (_, _, Some(bounds), ..) => drawn(node, way, &texts(bounds), reader)?,
        (.., Some(normal), _) => drawn(node, way, &texts(vec![normal.mean, normal.deviation]), reader)?,
        (.., Some(log)) => drawn(node, way, &texts(vec![log.median, log.factor]), reader)?,
        _ => return None,
    };
    let has_unit = match &values {
        Values::Listed(list) => list.iter().any(|text| Amount::read(text).is_none_or(|amount| !amount.unit.is_empty())),
        Values::Drawn(_, unit) => !unit.is_empty(),
    };
    if is_factor && has_unit {
        let remedy = "write plain numbers, such as `range: [0.8, 1.25]`";
        reader.error(node, "not-an-amount", "factors (`times: true`) have no unit", remedy);
        return None;
    }
    let name = section.name.map_or_else(|| key.clone(), |text| text.0.value);
    Some(Variable { key, name, is_factor, values })
}

/// The distribution of a key, from the texts of its numbers; a problem where they are none, or do not go together.
fn drawn(node: &Node, way: &str, texts: &[String], reader: &mut Reader) -> Option<Values> {
    let node = node.get(way).unwrap_or(node);
    let amounts: Vec<Amount> = texts.iter().filter_map(|text| Amount::read(text)).collect();
    if amounts.len() != texts.len() {
        let text = texts.iter().find(|text| Amount::read(text).is_none()).map_or("", String::as_str);
        let remedy =
            "write one number and one unit, such as `90 min` for `1 h 30 min`; names of files go under `values`";
        reader.error(node, "not-an-amount", format!("`{text}` is not one number with at most one unit"), remedy);
        return None;
    }
    let unit = amounts.first().map(|amount| amount.unit.clone()).unwrap_or_default();
    let numbers: Vec<f64> = amounts.iter().map(|amount| amount.number).collect();
    let (law, units) = match (way, &numbers[..]) {
        ("range", &[from, to]) if from < to => (Law::Uniform { from, to }, 2),
        ("triangular", &[from, mode, to]) if from <= mode && mode <= to && from < to => {
            (Law::Triangular { from, mode, to }, 3)
        }
        ("normal", &[mean, deviation]) if deviation > 0.0 => (Law::Normal { mean, deviation }, 2),
        // The factor has no unit.
        ("lognormal", &[median, factor]) if median > 0.0 && factor > 1.0 => (Law::Lognormal { median, factor }, 1),
        _ => {
            let remedy = match way {
                "range" => "write the least and the greatest value, as in `range: [0.03, 0.05]`",
                "triangular" => "write three values in their order, as in `triangular: [20 min, 35 min, 60 min]`",
                "normal" => "the standard deviation is greater than 0",
                _ => "the median is greater than 0, and the factor greater than 1",
            };
            reader.error(node, "not-a-distribution", format!("these numbers are no `{way}` distribution"), remedy);
            return None;
        }
    };
    if amounts[..units].iter().any(|amount| amount.unit != unit)
        || amounts[units..].iter().any(|one| !one.unit.is_empty())
    {
        let remedy = "write all its numbers in the same unit; a factor has none";
        reader.error(node, "not-a-distribution", "the numbers of this distribution have different units", remedy);
        return None;
    }
    Some(Values::Drawn(law, unit))
}
