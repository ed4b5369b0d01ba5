//! The members of a study: each a scenario of its own, with every default filled in.

use std::collections::BTreeMap;

use super::design;
use super::file::{Sampling, Study, Values, Variable, Variant};
use crate::error::{Error, Problem, ProblemKind, Severity};
use crate::scenario;
use crate::scenario::tree::{Node, Value, find, parse};
use crate::study::{Amount, MemberRecord, StudyRecord, VariableRecord, run_of};

/// Members of a study at most.
const MOST_MEMBERS: usize = 10_000;

/// A member and the text of its scenario.
pub(super) struct Member {
    pub record: MemberRecord,
    pub scenario: String,
}

/// All members of a study, and its record.
///
/// # Errors
/// With all problems of all members; those of the same cause count once.
pub(super) fn members(study: &Study) -> Result<(StudyRecord, Vec<Member>), Error> {
    let all = design::count(study).and_then(|cases| cases.checked_mul(study.variants.len()));
    if all.is_none_or(|all| all > MOST_MEMBERS) {
        let count = all.map_or("more than can be counted".to_owned(), |all| all.to_string());
        let message = format!("the study has {count} members, and {MOST_MEMBERS} are allowed");
        let problem = Problem::error(ProblemKind::Scenario, "too-many-members", "samples", message);
        let remedy = "draw values by `range` in place of lists, each of which multiplies the members";
        return Err(Error::Problems(vec![problem.with_remedy(remedy)]));
    }
    // What is wrong with the base is reported once.
    scenario::load(&study.base, &[])?;
    let mut found = Found::default();
    let bases: Vec<Option<Base>> = study.variants.iter().map(|variant| found.base(study, variant)).collect();
    let mut members = Vec::new();
    for (case, values) in design::cases(study).iter().enumerate() {
        for (variant, base) in study.variants.iter().zip(&bases) {
            let number = members.len() + 1;
            let texts =
                base.as_ref().map_or_else(|| vec![None; values.len()], |base| base.values(study, variant, values));
            let scenario = base.as_ref().and_then(|_| found.scenario(study, variant, number, &texts));
            let record = MemberRecord { number, case: case + 1, variant: variant.name.clone(), values: texts };
            members.push(Member { record, scenario: scenario.unwrap_or_default() });
        }
    }
    found.end()?;
    let record = StudyRecord {
        title: study.title.clone(),
        base: study.base.clone(),
        sampling: sampling(study),
        depths: study.depths.clone(),
        variables: study.variables.iter().map(described).collect(),
        variants: study.variants.iter().map(|variant| variant.name.clone()).collect(),
        members: members.iter().map(|member| member.record.clone()).collect(),
    };
    Ok((record, members))
}

fn sampling(study: &Study) -> String {
    let is_drawn = study.variables.iter().any(Variable::is_drawn);
    let how = match study.sampling {
        Sampling::Sobol => "Owen-scrambled Sobol sequence",
        Sampling::LatinHypercube => "Latin hypercube",
    };
    if is_drawn { format!("{how}, {} samples, seed {}", study.samples, study.seed) } else { String::new() }
}

fn described(variable: &Variable) -> VariableRecord {
    let spread = match &variable.values {
        Values::Listed(values) => values.join(", "),
        Values::Drawn(law, unit) => law.words(unit),
    };
    let times = if variable.is_factor { "the value of the base times " } else { "" };
    VariableRecord { key: variable.key.clone(), name: variable.name.clone(), spread: format!("{times}{spread}") }
}

/// The base as a variant has it: the values that factors multiply, one for each variable.
struct Base {
    amounts: Vec<Option<Amount>>,
}

impl Base {
    /// What each variable is in a case of a variant; none where the variant decides on it.
    fn values(&self, study: &Study, variant: &Variant, case: &[String]) -> Vec<Option<String>> {
        let text = |((variable, amount), value): ((&Variable, &Option<Amount>), &String)| {
            if variant.decides(&variable.key) {
                return None;
            }
            let product = |base: &Amount| {
                let number = base.number * Amount::read(value).map_or(f64::NAN, |factor| factor.number);
                Amount { number, unit: base.unit.clone() }.text()
            };
            Some(amount.as_ref().map_or_else(|| value.clone(), product))
        };
        study.variables.iter().zip(&self.amounts).zip(case).map(text).collect()
    }
}

/// Problems of members, each with the first member that has it and how many do.
#[derive(Default)]
struct Found(BTreeMap<String, (Problem, String, usize)>);

impl Found {
    fn add(&mut self, problem: Problem, whose: &str) {
        // Messages have the value, which is another one in each member.
        let what = if problem.key.is_empty() { &problem.message } else { &problem.key };
        let name = format!("{} {what} {}", problem.code, problem.remedy.as_deref().unwrap_or_default());
        self.0.entry(name).or_insert((problem, whose.to_owned(), 0)).2 += 1;
    }

    fn add_error(&mut self, error: Error, whose: &str) {
        match error {
            Error::Problems(problems) => {
                let errors = problems.into_iter().filter(|problem| problem.severity == Severity::Error);
                errors.for_each(|problem| self.add(problem, whose));
            }
            other => {
                let problem = Problem::error(ProblemKind::Scenario, "member-refused", "", other.to_string());
                self.add(problem.with_remedy("correct the key in the study; it is that of `--set`"), whose);
            }
        }
    }

    /// The base of a variant.
    fn base(&mut self, study: &Study, variant: &Variant) -> Option<Base> {
        let whose = if variant.name.is_empty() { "the base".to_owned() } else { format!("variant {}", variant.name) };
        let text = match scenario::load(&study.base, &variant.set) {
            Ok(loaded) => loaded.scenario.to_yaml(),
            Err(error) => {
                self.add_error(error, &whose);
                return None;
            }
        };
        let root = parse(&text, &study.base).ok().map(|(root, _)| root)?;
        let mut amount = |variable: &Variable| -> Option<Amount> {
            if !variable.is_factor || variant.decides(&variable.key) {
                return None;
            }
            let amount = find(&root, &variable.key).and_then(amount_of);
            if amount.is_none() {
                let message = format!("the base has no number at `{}` that could be multiplied", variable.key);
                let problem =
                    Problem::error(ProblemKind::Scenario, "nothing-to-multiply", variable.key.clone(), message);
                let remedy = "write the key into the base with a number, or give values without `times`";
                self.add(problem.with_remedy(remedy), &whose);
            }
            amount
        };
        Some(Base { amounts: study.variables.iter().map(&mut amount).collect() })
    }

    /// The scenario of a member.
    fn scenario(
        &mut self,
        study: &Study,
        variant: &Variant,
        number: usize,
        values: &[Option<String>],
    ) -> Option<String> {
        let quoted = |text: &str| serde_json::Value::from(text).to_string();
        let mut overrides = variant.set.clone();
        let mut said = Vec::new();
        for (variable, value) in study.variables.iter().zip(values) {
            let Some(value) = value else { continue };
            overrides.push(format!("{}={}", variable.key, quoted(value)));
            said.push(format!("{} = {value}", variable.key));
        }
        overrides.push(format!("outputs.folder={}", quoted(&run_of(&study.folder, number).to_string_lossy())));
        match scenario::load(&study.base, &overrides) {
            Ok(loaded) => Some(loaded.scenario.to_yaml()),
            Err(error) => {
                self.add_error(error, &format!("member {number} ({})", said.join(", ")));
                None
            }
        }
    }

    /// All that was found.
    fn end(self) -> Result<(), Error> {
        let said = |(problem, whose, count): (Problem, String, usize)| {
            let others = if count > 1 { format!(", and {} more", count - 1) } else { String::new() };
            problem.with_cause(format!("in {whose}{others}"))
        };
        let problems: Vec<Problem> = self.0.into_values().map(said).collect();
        if problems.is_empty() { Ok(()) } else { Err(Error::Problems(problems)) }
    }
}

fn amount_of(node: &Node) -> Option<Amount> {
    match &node.value {
        Value::Text(text) => Amount::read(text),
        _ => None,
    }
}
