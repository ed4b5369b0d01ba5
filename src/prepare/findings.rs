//! The list of problems while it grows: each finding gets the key and the place of the scenario value it belongs to.

use crate::error::{Place, Problem, Severity, sort_problems};
use crate::scenario::Sourced;

/// Problems found so far.
#[derive(Debug, Default)]
pub(super) struct Findings {
    problems: Vec<Problem>,
}

impl Findings {
    /// Adds a problem of a scenario value.
    pub fn add<T>(&mut self, source: &Sourced<T>, problem: Problem) {
        self.add_at(&source.key, source.place.clone(), problem);
    }

    /// Adds a problem with a key and a place in the scenario.
    pub fn add_at(&mut self, key: &str, place: Option<Place>, mut problem: Problem) {
        problem.key = key.to_string();
        self.problems.push(problem.with_place(place));
    }

    /// Adds the problem of a failed result; hands on the value of another.
    pub fn take<T, V>(&mut self, source: &Sourced<T>, result: Result<V, Problem>) -> Option<V> {
        result.map_err(|problem| self.add(source, problem)).ok()
    }

    /// Adds the problems of a failed result; hands on the value of another.
    pub fn take_all<T, V>(&mut self, source: &Sourced<T>, result: Result<V, Vec<Problem>>) -> Option<V> {
        result.map_err(|problems| self.add_all(source, problems)).ok()
    }

    /// Adds several.
    pub fn add_all<T>(&mut self, source: &Sourced<T>, problems: impl IntoIterator<Item = Problem>) {
        problems.into_iter().for_each(|problem| self.add(source, problem));
    }

    /// Whether something of a key was refused.
    pub fn has_errors_of(&self, key: &str) -> bool {
        self.problems.iter().any(|problem| problem.key == key && problem.severity == Severity::Error)
    }

    /// The errors among them that are not known yet.
    pub fn errors_beyond(&self, known: &Findings) -> Vec<Problem> {
        let is_known = |problem: &Problem| {
            known
                .problems
                .iter()
                .any(|one| (one.code, &one.key, one.severity) == (problem.code, &problem.key, problem.severity))
        };
        let errors = self.problems.iter().filter(|problem| problem.severity == Severity::Error);
        errors.filter(|problem| !is_known(problem)).cloned().collect()
    }

    /// Adds problems that have their keys and places.
    pub fn extend(&mut self, problems: impl IntoIterator<Item = Problem>) {
        self.problems.extend(problems);
    }

    /// All of them in order; see [`sort_problems`].
    pub fn into_problems(mut self) -> Vec<Problem> {
        sort_problems(&mut self.problems);
        self.problems
    }
}
