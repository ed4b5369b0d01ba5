//! `floodsim explain`: what the codes of problems mean and what to do about them, for people, as JSON or as `docs/problems.md`.

use serde_json::{Value, json};

use super::args::ExplainArguments;
use crate::error::Error;
use crate::problems::{self, KnownProblem};
use crate::scenario::read::nearest;

/// How many codes that contain a word are named at most.
const NAMED: usize = 6;

/// Prints the problems of some codes, or all that are known.
pub fn explain(arguments: &ExplainArguments) -> Result<(), Error> {
    if arguments.markdown {
        return super::print(&problems::markdown());
    }
    let asked = known(&arguments.codes)?;
    super::print(&match (asked.is_empty(), arguments.json) {
        (true, false) => list(),
        (true, true) => as_json(problems::all()),
        (false, true) => as_json(asked.into_iter()),
        (false, false) => asked.into_iter().map(explained).collect::<Vec<_>>().join("\n"),
    })
}

/// The problems of some codes; wrong usage where one of them is not known.
fn known(codes: &[String]) -> Result<Vec<&'static KnownProblem>, Error> {
    let unknown: Vec<String> =
        codes.iter().filter(|code| problems::find(code).is_none()).map(|code| not_known(code)).collect();
    if unknown.is_empty() {
        return Ok(codes.iter().filter_map(|code| problems::find(code)).collect());
    }
    Err(Error::Usage(format!(
        "{}; `floodsim explain` lists all codes, `floodsim explain --help` says more",
        unknown.join("; ")
    )))
}

/// What is wrong with a code, with those that are like it.
fn not_known(code: &str) -> String {
    let all = || problems::all().map(|problem| problem.code);
    let alike: Vec<&str> = match nearest(code, all()) {
        Some(near) => vec![near],
        None => all().filter(|known| !code.is_empty() && known.contains(code)).take(NAMED).collect(),
    };
    let alike = alike.iter().map(|known| format!("`{known}`")).collect::<Vec<_>>().join(" or ");
    let ask = if alike.is_empty() { String::new() } else { format!(": did you mean {alike}?") };
    format!("`{code}` is no code of a problem{ask}")
}

/// All codes, one a line, with the first sentence of their meanings.
fn list() -> String {
    let width = problems::all().map(|problem| problem.code.len()).max().unwrap_or_default();
    problems::all().map(|problem| format!("{:<width$}  {}\n", problem.code, problem.summary())).collect()
}

/// A problem in the form in which `check` prints it.
fn explained(problem: &KnownProblem) -> String {
    let KnownProblem { code, severity, meaning, remedy } = problem;
    format!("{}[{code}]\n  {meaning}\n  remedy  {remedy}\n", severity.name())
}

fn as_json(listed: impl Iterator<Item = &'static KnownProblem>) -> String {
    let one = |problem: &KnownProblem| {
        let KnownProblem { code, severity, meaning, remedy } = problem;
        json!({"code": code, "severity": severity.name(), "meaning": meaning, "remedy": remedy})
    };
    format!("{:#}\n", Value::from(listed.map(one).collect::<Vec<Value>>()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_is_explained_in_the_form_of_the_check() {
        let text = explained(problems::find("no-crs").unwrap());
        assert!(text.starts_with("error[no-crs]\n  Neither the terrain nor the scenario"), "{text}");
        assert!(text.contains("\n  remedy  Write `crs: EPSG:...`"), "{text}");
        assert!(explained(problems::find("terrain-gaps").unwrap()).starts_with("error or warning[terrain-gaps]\n"));
    }

    #[test]
    fn codes_like_an_unknown_one_are_named() {
        for (code, alike) in [
            ("leaking-rimm", ": did you mean `leaking-rim`?"),
            ("earlier", ": did you mean `bed-of-earlier-run` or `channels-of-earlier-run` or "),
            ("nothing-like-it", ""),
        ] {
            let text = not_known(code);
            assert!(text.starts_with(&format!("`{code}` is no code of a problem{alike}")), "{text}");
        }
        let codes = ["no-crs", "no-crs-at-all", "syntaxx"].map(str::to_owned);
        let Err(Error::Usage(said)) = known(&codes) else { panic!("codes that are not known pass") };
        assert!(said.contains("no-crs-at-all") && said.contains("did you mean `syntax`?"), "{said}");
    }
}
