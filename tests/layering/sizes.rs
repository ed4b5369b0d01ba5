//! Small pieces: no long function and no long file, but for those that are listed with the reason.

use std::collections::BTreeSet;
use std::path::Path;

use super::{root, rust_files};

/// Lines of a function and of a file, at most.
const FUNCTION: usize = 60;
const FILE: usize = 400;

/// What may be longer: a room or a file, a function of it where only that is long, and why.
const LONG: &[(&str, &str)] = &[
    ("src/core/gridding.rs", "the gridding of the variational formulation, to be parted with it"),
    ("src/output/write/projection.rs: method_attributes", "one match: a map projection of CF a line or two"),
    ("src/core/seeding/shore.rs: fit_bed_to_water", "one rule with its exceptions, in one pass over the cells"),
    ("src/core/seeding/still_water/tests.rs", "scenes of still water, 37 lines too many"),
    ("src/core/solver/eulerian/faces.rs", "the face of a pair is one formula, in the order of its terms"),
    ("src/core/solver/eulerian/walls.rs", "parted with the faces of any length that replace it"),
    ("tests/end_to_end/bad_scenarios.rs: methods_that_do_not_exist", "one table of cases"),
    ("tests/end_to_end/doubtful_inputs.rs: boundaries_that_are_hardly_meant_so", "one table of cases"),
    ("tests/end_to_end/hot_start/refused.rs: what_does_not_fit_the_earlier_run", "one table of cases"),
];

fn indent(line: &str) -> usize {
    line.len() - line.trim_start().len()
}

/// The functions of a file with their numbers of lines.
fn functions(text: &str) -> Vec<(String, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let begins = |line: &str| {
        let words: Vec<&str> = line.split_whitespace().take_while(|word| !word.contains('"')).collect();
        let at = words.iter().position(|word| *word == "fn")?;
        let is_head =
            words[..at].iter().all(|word| word.starts_with("pub") || ["const", "unsafe", "in"].contains(word));
        let name = words.get(at + 1)?.split(['(', '<']).next()?;
        is_head.then(|| name.to_owned())
    };
    let function = |(first, line): (usize, &&str)| {
        let name = begins(line)?;
        if line.ends_with([';', '}']) {
            return Some((name, 1));
        }
        let end = format!("{}}}", " ".repeat(indent(line)));
        Some((name, lines[first..].iter().position(|line| line.starts_with(&end))? + 1))
    };
    lines.iter().enumerate().filter_map(function).collect()
}

/// What is too long in a file.
fn long_in(relative: &str, text: &str) -> Vec<String> {
    let lines = text.lines().count();
    let file = (lines > FILE).then(|| format!("{relative} has {lines} lines"));
    let functions = functions(text).into_iter().filter(|(_, length)| *length > FUNCTION);
    let functions = functions.map(|(name, length)| format!("{relative}: {name} has {length} lines"));
    file.into_iter().chain(functions).collect()
}

#[test]
fn functions_and_files_are_short() {
    let files = ["src", "tests"].into_iter().flat_map(|folder| rust_files(&root().join(folder)));
    let long: Vec<String> = files
        .flat_map(|path| {
            let relative = path.strip_prefix(root()).unwrap_or(Path::new("")).to_string_lossy().into_owned();
            long_in(&relative, &std::fs::read_to_string(&path).unwrap())
        })
        .collect();
    let is_listed = |found: &&String| LONG.iter().any(|(place, _)| found.starts_with(place));
    let (listed, unlisted): (Vec<&String>, Vec<&String>) = long.iter().partition(is_listed);
    assert!(unlisted.is_empty(), "part these by what they do, or list them with the reason: {unlisted:#?}");
    let needed: BTreeSet<&str> = LONG.iter().map(|(place, _)| *place).collect();
    let unneeded: Vec<&&str> =
        needed.iter().filter(|place| !listed.iter().any(|found| found.starts_with(**place))).collect();
    assert!(unneeded.is_empty(), "nothing is long there, take it out of the list: {unneeded:?}");
}

#[test]
fn lengths_are_counted_from_head_to_brace() {
    let text = "pub fn a() -> u8 {\n    1\n}\n\nimpl B {\n    fn c(\n    ) {\n    }\n    fn d() {}\n}\n";
    let expected = [("a", 3), ("c", 3), ("d", 1)].map(|(name, length)| (name.to_owned(), length));
    assert_eq!(functions(text), expected);
}
