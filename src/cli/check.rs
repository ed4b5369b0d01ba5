//! `floodsim check`: every problem of a scenario and its inputs at once, for people or as JSON.

use serde_json::{Value, json};

use super::Stages;
use super::args::CheckArguments;
use crate::error::{Error, ExitCode, Problem, ProblemKind, Severity};
use crate::scenario;

/// Checks a scenario and prints its problems to stdout; the exit code is that of a run that stops at them.
pub fn check(arguments: &CheckArguments, stages: &Stages) -> ExitCode {
    let problems = match scenario::load(&arguments.scenario, &arguments.overrides) {
        Ok(loaded) => loaded.warnings.into_iter().chain((stages.prepare)(&loaded.scenario)).collect(),
        Err(Error::Problems(problems)) => problems,
        Err(other) => return super::exit_code(Err(other)),
    };
    let errors = problems.iter().filter(|problem| problem.severity == Severity::Error).count();
    let warnings = problems.len() - errors;
    let scenario = arguments.scenario.display();
    let text = if arguments.json {
        let findings: Vec<Value> = problems.iter().map(finding).collect();
        let all =
            json!({"scenario": scenario.to_string(), "errors": errors, "warnings": warnings, "problems": findings});
        format!("{all:#}\n")
    } else {
        let count = |number: usize, name: &str| format!("{number} {name}{}", if number == 1 { "" } else { "s" });
        let list: String = problems.iter().map(|problem| format!("{problem}\n")).collect();
        format!("{list}{scenario}: {}, {}\n", count(errors, "error"), count(warnings, "warning"))
    };
    match super::print(&text) {
        Ok(()) if errors == 0 => ExitCode::Done,
        Ok(()) => Error::Problems(problems).exit_code(),
        Err(error) => super::exit_code(Err(error)),
    }
}

fn finding(problem: &Problem) -> Value {
    let severity = match problem.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    let kind = match problem.kind {
        ProblemKind::Scenario => "scenario",
        ProblemKind::Input => "input",
        ProblemKind::Limit => "limit",
        ProblemKind::Output => "output",
    };
    json!({
        "severity": severity,
        "kind": kind,
        "code": problem.code,
        "file": problem.place.as_ref().map(|place| place.file.display().to_string()),
        "line": problem.place.as_ref().map(|place| place.line),
        "column": problem.place.as_ref().map(|place| place.column),
        "key": problem.key,
        "message": problem.message,
        "cause": problem.cause,
        "remedy": problem.remedy,
        "at": problem.at.map(|at| [at.x, at.y]),
    })
}
