//! Whether the registry of problems has every code of the sources and no other, and whether a test names each of them.
//!
//! The check is textual. Where code is: every text in kebab case, `"no-crs"`, and every first text of a call that makes a problem.
//! Where tests are: `tests/`, files and folders named `tests` below `src`, and what follows `mod tests {`.

#![expect(clippy::unwrap_used, reason = "a test that cannot read the sources of its own package must fail")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use floodsim::problems::{self, Reported};

/// Texts in kebab case that are no codes: units, words of messages, a status of a row, a rule of serde.
const NO_CODES: &[&str] =
    &["acre-ft", "us-ft", "cross-sections", "fall-short", "kebab-case", "x-example", "x-keys", "x-kind"];

/// What makes a problem, and as what it is reported where that can be read.
const MAKERS: &[(&str, Option<Reported>)] = &[
    ("Problem::error(", Some(Reported::Error)),
    ("Problem::warning(", Some(Reported::Warning)),
    ("input_error(", Some(Reported::Error)),
    ("input_warning(", Some(Reported::Warning)),
    ("reader.error(", Some(Reported::Error)),
    ("reader.warning(", Some(Reported::Warning)),
    ("self.error(", Some(Reported::Error)),
    ("refused(", None),
    ("report(", None),
    ("problem(", None),
    ("code: ", None),
];

/// Every source file of a folder with its path from the root of the repository.
fn files(folder: &str) -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut found, mut folders) = (Vec::new(), vec![root.join(folder)]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = std::fs::read_to_string(&path).unwrap();
                found.push((path.strip_prefix(root).unwrap().to_owned(), text));
            }
        }
    }
    found.sort();
    found
}

/// The code of a source file without comments, and its tests.
fn parts(path: &Path, text: &str) -> (String, String) {
    if path.components().any(|part| part.as_os_str() == "tests" || part.as_os_str() == "tests.rs") {
        return (String::new(), text.to_owned());
    }
    let (code, tests) = text.split_once("mod tests {").unwrap_or((text, ""));
    let lines = code.lines().map(|line| line.split("//").next().unwrap_or_default());
    (lines.collect::<Vec<_>>().join("\n"), tests.to_owned())
}

fn is_kebab(text: &str) -> bool {
    let mut parts = text.split('-');
    parts.all(|part| !part.is_empty() && part.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit()))
}

/// The texts of a line of code in kebab case.
fn texts(line: &str) -> impl Iterator<Item = &str> {
    line.split('"').skip(1).step_by(2).filter(|text| text.contains('-') && is_kebab(text) && !NO_CODES.contains(text))
}

/// The codes that the calls of a maker have as their first text.
fn made<'a>(code: &'a str, maker: &str) -> impl Iterator<Item = &'a str> {
    code.split(maker).skip(1).filter_map(|rest| {
        let (before, after) = rest.split_once('"')?;
        let text = after.split('"').next()?;
        (!before.contains([')', ';', '!', '{', '}']) && is_kebab(text)).then_some(text)
    })
}

/// What the sources say of a code.
#[derive(Debug, Default)]
struct Found {
    /// The files that have it.
    files: BTreeSet<PathBuf>,
    /// As what it is reported, as far as that can be read.
    is_error: bool,
    is_warning: bool,
}

/// Every code of the sources.
fn found() -> BTreeMap<String, Found> {
    let mut found: BTreeMap<String, Found> = BTreeMap::new();
    for (path, text) in files("src").into_iter().filter(|(path, _)| !path.starts_with("src/problems")) {
        let (code, _) = parts(&path, &text);
        for text in code.lines().flat_map(texts) {
            found.entry(text.to_owned()).or_default().files.insert(path.clone());
        }
        for (maker, reported) in MAKERS {
            for text in made(&code, maker) {
                let entry = found.entry(text.to_owned()).or_default();
                entry.files.insert(path.clone());
                entry.is_error |= *reported == Some(Reported::Error);
                entry.is_warning |= *reported == Some(Reported::Warning);
            }
        }
    }
    found
}

#[test]
fn the_registry_has_every_code_of_the_sources_and_no_other() {
    let found = found();
    let unknown: Vec<_> = found.iter().filter(|(code, _)| problems::find(code).is_none()).collect();
    assert!(unknown.is_empty(), "not in src/problems (or NO_CODES of this test): {unknown:#?}");
    let dead: Vec<&str> =
        problems::all().map(|problem| problem.code).filter(|code| !found.contains_key(*code)).collect();
    assert!(dead.is_empty(), "in src/problems, and nothing reports them: {dead:?}");
    let idle: Vec<_> = NO_CODES.iter().filter(|code| problems::find(code).is_some()).collect();
    assert!(idle.is_empty(), "codes after all: {idle:?}");
}

#[test]
fn a_code_is_reported_as_the_registry_says() {
    let found = found();
    let is_wrong = |problem: &&problems::KnownProblem| match problem.severity {
        Reported::Error => found[problem.code].is_warning,
        Reported::Warning => found[problem.code].is_error,
        Reported::Either => false,
    };
    let wrong: Vec<&str> =
        problems::all().filter(|problem| found.contains_key(problem.code)).filter(is_wrong).map(|p| p.code).collect();
    assert!(wrong.is_empty(), "reported otherwise than src/problems says: {wrong:?}");
}

#[test]
fn a_test_provokes_every_code() {
    let of_sources = files("src").into_iter().filter(|(path, _)| !path.starts_with("src/problems"));
    let of_sources = of_sources.map(|(path, text)| parts(&path, &text).1);
    let of_tests = files("tests").into_iter().filter(|(path, _)| !path.ends_with("problems.rs")).map(|(_, text)| text);
    let tests: String = of_sources.chain(of_tests).collect();
    // Codes of one word, such as `date`, stand in quotes as keys, too.
    let forms = |code: &str| match code.contains('-') {
        true => vec![format!("[{code}]"), format!("\"{code}\"")],
        false => vec![format!("[{code}]"), format!("code, \"{code}\""), format!("[(\"{code}\", ")],
    };
    let has = |code: &str| forms(code).iter().any(|form| tests.contains(form.as_str()));
    let without: Vec<&str> = problems::all().map(|problem| problem.code).filter(|code| !has(code)).collect();
    assert!(
        without.is_empty(),
        "no test provokes {without:?}; tests/end_to_end/smallest_inputs.rs is a place for them"
    );
}

#[test]
fn the_checks_can_fail() {
    let code = "input_error(\n    \"no-crs\",\n    format!(\"a-b\")); reader.error(&pair[1], \"conflict\", text); \
                reader.error(node, error.code, error.message);\nProblem::error(kind, code, \"\", message)";
    assert_eq!(made(code, "input_error(").collect::<Vec<_>>(), ["no-crs"]);
    assert_eq!(made(code, "reader.error(").collect::<Vec<_>>(), ["conflict"]);
    assert_eq!(made(code, "Problem::error(").count(), 0);
    assert_eq!(code.lines().flat_map(texts).collect::<Vec<_>>(), ["no-crs", "a-b"]);
    assert!(is_kebab("a-b2") && !is_kebab("A-b") && !is_kebab("a--b") && !is_kebab(""));
}
