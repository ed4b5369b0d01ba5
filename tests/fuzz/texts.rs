//! Scenarios that are changed at random and only read, which is a thousand times as quick as to run them.

use std::collections::BTreeSet;
use std::panic::catch_unwind;
use std::path::Path;

use floodsim::error::{Error, Severity};
use floodsim::problems;
use floodsim::scenario::resolve;

use crate::random::Random;
use crate::scene::SCENE;
use crate::{mutate, settings};

/// What is wrong with how a text is read; nothing where it is refused with words, or can be written and read again.
fn fault(text: &str) -> Option<String> {
    let read = |text: &str| resolve(text, Path::new("/nowhere/s.yaml"), &[]);
    let Ok(answer) = catch_unwind(|| read(text)) else { return Some("panic".to_owned()) };
    let scenario = match answer {
        Ok(loaded) => loaded.scenario,
        Err(Error::Problems(problems)) => {
            let unknown = problems.iter().find(|problem| problems::find(problem.code).is_none());
            let without = problems.iter().find(|p| p.severity == Severity::Error && p.remedy.is_none());
            let has_error = problems.iter().any(|problem| problem.severity == Severity::Error);
            return match (unknown, without) {
                (Some(problem), _) => Some(format!("unknown code {}", problem.code)),
                (_, Some(problem)) => Some(format!("no remedy: {problem}")),
                _ => (!has_error).then(|| "refused without an error".to_owned()),
            };
        }
        Err(error) => return Some(format!("not a problem of the scenario: {error}")),
    };
    if scenario.auto.is_some() {
        // Its lengths are not known before its files are read.
        return None;
    }
    let written = scenario.to_yaml();
    match read(&written) {
        Ok(again) => (again.scenario.to_yaml() != written).then(|| format!("reads back otherwise:\n{written}")),
        // Where a text is refused the files are missed, too.
        Err(Error::Problems(problems)) => {
            let problems: Vec<_> =
                problems.iter().filter(|p| p.code != "missing-file").map(|p| p.to_string()).collect();
            Some(format!("does not read back: {}\n{written}", problems.join("\n")))
        }
        Err(error) => Some(format!("does not read back: {error}\n{written}")),
    }
}

#[test]
fn texts_of_scenarios() {
    let (seed, numbers) = settings(10_000);
    let others: Vec<&str> = SCENE.scenarios.iter().map(|(_, text)| text.as_str()).collect();
    let (mut faults, mut kinds) = (Vec::new(), BTreeSet::new());
    for number in numbers {
        let random = &mut Random::of(seed, number);
        let from = random.pick(&others);
        let text = String::from_utf8_lossy(&mutate::scenario(random, from, &others)).into_owned();
        if let Some(fault) = fault(&text) {
            let line = fault.lines().next().unwrap_or_default().to_owned();
            if kinds.insert(line) && kinds.len() < 20 {
                println!("{number}: {fault}\n{text}\n");
            }
            faults.push(number);
        }
    }
    assert!(faults.is_empty(), "seed {seed}, cases {faults:?}");
}
