//! `floodsim check`: every problem of a scenario and its inputs at once, for people or as JSON.

use serde_json::{Value, json};

use super::Stages;
use super::args::CheckArguments;
use crate::error::{Error, ExitCode, Problem, ProblemKind, Severity, sort_problems};
use crate::scenario;
use crate::scenario::methods::Motion;

/// What cells that move cost, and what they are for.
const MOVING: &str = "`motion: lagrangian` takes 5 to 12 times the CPU time of resting cells; it pays for swinging basins and marked water (docs/guide/motions.md)\n";

/// Checks a scenario and prints its problems to stdout; the exit code is that of a run that stops at them.
pub fn check(arguments: &CheckArguments, stages: &Stages) -> ExitCode {
    let mut moves = false;
    let mut problems: Vec<Problem> = match scenario::load(&arguments.scenario, &arguments.overrides) {
        Ok(loaded) => {
            let numerics = &loaded.scenario.numerics;
            moves = numerics.has_cells() && numerics.motion == Motion::Lagrangian;
            loaded.warnings.into_iter().chain((stages.prepare)(&loaded.scenario)).collect()
        }
        Err(Error::Problems(problems)) => problems,
        Err(other) => return super::exit_code(Err(other)),
    };
    sort_problems(&mut problems);
    let text = listing(&arguments.scenario.display().to_string(), &problems, arguments.json);
    let text = if moves && !arguments.json { text + MOVING } else { text };
    super::tell(&text);
    if error_count(&problems) == 0 { ExitCode::Done } else { Error::Problems(problems).exit_code() }
}

fn error_count(problems: &[Problem]) -> usize {
    problems.iter().filter(|problem| problem.severity == Severity::Error).count()
}

/// All problems of a scenario and how many there are, for people or as JSON.
pub(super) fn listing(scenario: &str, problems: &[Problem], as_json: bool) -> String {
    let errors = error_count(problems);
    let warnings = problems.len() - errors;
    if as_json {
        let all = json!({"scenario": scenario, "errors": errors, "warnings": warnings, "problems": findings(problems)});
        format!("{all:#}\n")
    } else {
        let count = |number: usize, name: &str| format!("{number} {name}{}", if number == 1 { "" } else { "s" });
        let list: String = problems.iter().map(|problem| format!("{problem}\n")).collect();
        format!("{list}{scenario}: {}, {}\n", count(errors, "error"), count(warnings, "warning"))
    }
}

/// Problems as JSON.
pub(super) fn findings(problems: &[Problem]) -> Vec<Value> {
    problems.iter().map(finding).collect()
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
