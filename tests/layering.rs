//! Who may import whom, and whether every formula and source that the code cites is in the documents.
//!
//! The rules are those of docs/ARCHITECTURE.md: data flows one way, input and output stay at the rim. The check is textual: it
//! reads what stands after `crate::` in the code of a module, up to its tests.

#![expect(clippy::unwrap_used, reason = "a test that cannot read the sources of its own package must fail")]

#[path = "layering/circles.rs"]
mod circles;
#[path = "layering/rules.rs"]
mod rules;
#[path = "layering/sizes.rs"]
mod sizes;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use rules::{MAY_IMPORT, PURE};

/// Modules that join the others and may import all.
const JOINING: &[&str] = &["cli", "pipeline", "prepare", "laboratory", "main", "lib"];

const OUTSIDE_WORLD: &[&str] = &[
    "std::fs",
    "std::io",
    "println!",
    "eprintln!",
    "print!",
    "eprint!",
    "serde_yaml",
    "serde_json",
    "gdal::",
    "netcdf::",
];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Every source file below a folder.
fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Every source file below `src` with its module: the first part of its path, the second in `core`.
fn sources() -> Vec<(String, PathBuf, String)> {
    let mut found = Vec::new();
    for path in rust_files(&root().join("src")) {
        let relative = path.strip_prefix(root().join("src")).unwrap().to_path_buf();
        let mut parts = relative.iter().map(|part| part.to_string_lossy());
        let module = parts.find(|part| part != "core").unwrap().trim_end_matches(".rs").to_string();
        found.push((module, relative, std::fs::read_to_string(&path).unwrap()));
    }
    found.sort();
    let tests: BTreeSet<PathBuf> = found.iter().flat_map(|(_, path, text)| test_modules(path, text)).collect();
    found.retain(|(_, path, _)| !tests.contains(path));
    found
}

/// The files of the modules that a file declares for its tests alone.
fn test_modules(path: &Path, text: &str) -> Vec<PathBuf> {
    let is_folder = path.ends_with("mod.rs") || path.ends_with("lib.rs");
    let folder = if is_folder { path.with_file_name("") } else { path.with_extension("") };
    let declared = text.split("#[cfg(test)]\nmod ").skip(1);
    declared.filter_map(|rest| Some(folder.join(rest.split_once(';')?.0).with_extension("rs"))).collect()
}

/// The code of a file without comments and without its tests.
fn code(path: &Path, text: &str) -> String {
    // Tests on the valley of Malpasset have a file of their own.
    let is_test = |name: &str| ["tests", "tests.rs", "malpasset.rs"].contains(&name);
    if path.components().any(|part| part.as_os_str().to_str().is_some_and(is_test)) {
        return String::new();
    }
    let lines = text.lines().take_while(|line| line.trim() != "mod tests {");
    lines.map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// What is imported from this crate: `bed`, or two parts for `scenario`; braces are opened.
fn imports(code: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
        let end = rest.find([';', '(', ')', '<', '>', ',', ' ']).unwrap_or(rest.len());
        match rest.split_once('{').filter(|(before, _)| before.len() <= end) {
            Some(("", inside)) => {
                let names = inside.split('}').next().unwrap_or_default().split(',');
                found.extend(names.map(|name| name.trim().to_string()).filter(|name| !name.is_empty()));
            }
            Some((before, inside)) => {
                let names = inside.split('}').next().unwrap_or_default().split(',');
                found.extend(names.map(|name| format!("{before}{}", name.trim())).filter(|name| !name.ends_with(':')));
            }
            None => {
                found.insert(rest[..end].to_string());
            }
        }
    }
    found
}

#[test]
fn data_flows_one_way() {
    let mut wrong = Vec::new();
    for (module, path, text) in sources() {
        if JOINING.contains(&module.as_str()) {
            continue;
        }
        let Some((_, allowed)) = MAY_IMPORT.iter().find(|(name, _)| *name == module) else {
            wrong.push(format!("src/{} belongs to a module without a rule", path.display()));
            continue;
        };
        for import in imports(&code(&path, &text)) {
            let fits = |allowed: &&str| import == **allowed || import.starts_with(&format!("{allowed}::"));
            let own = import == module || import.starts_with(&format!("{module}::"));
            if !own && !allowed.iter().any(fits) {
                wrong.push(format!("src/{} imports crate::{import}", path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "against the rules of docs/ARCHITECTURE.md:\n{}", wrong.join("\n"));
}

#[test]
fn input_and_output_stay_at_the_rim() {
    let mut wrong = Vec::new();
    for (module, path, text) in sources() {
        let code = code(&path, &text);
        for name in OUTSIDE_WORLD.iter().filter(|name| PURE.contains(&module.as_str()) && code.contains(**name)) {
            wrong.push(format!("src/{} uses {name}", path.display()));
        }
    }
    assert!(wrong.is_empty(), "these modules must not touch the outside world:\n{}", wrong.join("\n"));
}

#[test]
fn every_cited_source_is_listed() {
    let listed = std::fs::read_to_string(root().join("docs/references.md")).unwrap().to_lowercase();
    let mut missing = BTreeSet::new();
    for (_, path, text) in sources() {
        for key in text.split('`').filter(|word| is_citation(word)) {
            if !listed.contains(&format!("`{}`", key.to_lowercase())) {
                missing.insert(format!("{key} in src/{}", path.display()));
            }
        }
    }
    assert!(missing.is_empty(), "add to docs/references.md: {missing:?}");
}

/// Whether a word has the form `Name2005`.
fn is_citation(word: &str) -> bool {
    let letters = word.trim_end_matches(|c: char| c.is_ascii_digit());
    let digits = &word[letters.len()..];
    digits.len() == 4
        && (digits.starts_with("18") || digits.starts_with("19") || digits.starts_with("20"))
        && letters.len() > 2
        && letters.chars().all(|c| c.is_ascii_alphabetic())
}

#[test]
fn every_cited_equation_is_in_the_theory() {
    let theory = std::fs::read_to_string(root().join("docs/theory.md")).unwrap();
    let mut missing = BTreeSet::new();
    for (_, path, text) in sources() {
        for rest in text.split("(M").skip(1) {
            let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
            if digits > 0 && rest[digits..].starts_with(')') && !theory.contains(&format!("**(M{})**", &rest[..digits]))
            {
                missing.insert(format!("(M{}) in src/{}", &rest[..digits], path.display()));
            }
        }
    }
    assert!(missing.is_empty(), "not in docs/theory.md: {missing:?}");
}

#[test]
fn the_labels_of_formulas_run_in_order() {
    let theory = std::fs::read_to_string(root().join("docs/theory.md")).unwrap();
    let label = |rest: &str| rest.split_once(")**").and_then(|(number, _)| number.parse().ok());
    let labels: Vec<usize> = theory.split("**(M").skip(1).filter_map(label).collect();
    assert!(labels.len() > 50, "the labels were not found");
    assert_eq!(labels, (1..=labels.len()).collect::<Vec<_>>());
}

/// The words in backticks of a text.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// The rows of the table below a heading of docs/ARCHITECTURE.md, as their cells.
fn table<'a>(text: &'a str, heading: &str) -> Vec<Vec<&'a str>> {
    let below = text.split_once(heading).unwrap().1;
    let rows = below.lines().skip_while(|line| !line.starts_with("| --- ")).skip(1).take_while(|l| l.starts_with('|'));
    rows.map(|row| row.trim_matches('|').split(" | ").map(str::trim).collect()).collect()
}

fn architecture() -> String {
    std::fs::read_to_string(root().join("docs/ARCHITECTURE.md")).unwrap()
}

#[test]
fn the_document_has_the_rules_that_are_checked() {
    let text = architecture();
    let rows = table(&text, "## Who may import whom");
    let written: Vec<(&str, Vec<&str>)> =
        rows.iter().map(|row| (quoted(row[0]).next().unwrap(), quoted(row[1]).collect())).collect();
    let checked: Vec<(&str, Vec<&str>)> = MAY_IMPORT.iter().map(|(module, may)| (*module, may.to_vec())).collect();
    assert_eq!(written, checked);
}

#[test]
fn every_module_is_in_the_document() {
    let text = architecture();
    let listed: BTreeSet<&str> = table(&text, "## Modules").iter().flat_map(|row| quoted(row[0])).collect();
    let present: BTreeSet<String> = sources().into_iter().map(|(module, ..)| module).collect();
    let present: BTreeSet<&str> = present.iter().map(String::as_str).filter(|m| !["main", "lib"].contains(m)).collect();
    assert_eq!(listed, present);
}

#[test]
fn every_path_in_the_document_exists() {
    let text = architecture();
    let mut missing = Vec::new();
    for line in text.lines() {
        // After `src/pipeline/mod.rs` a bare `steps.rs` lies in the same folder.
        let mut folder = root().join("docs");
        for word in quoted(line).filter(|word| !word.contains([' ', ':'])) {
            let is_path = word.ends_with(".rs") || word.ends_with(".md") || word.ends_with('/');
            let from_root = ["src/", "docs/", "tests/", "data/", "scenarios/"].iter().any(|top| word.starts_with(top));
            let from_source = root().join("src").join(word);
            let path = match word {
                _ if from_root => root().join(word),
                _ if from_source.exists() => from_source,
                _ => folder.join(word),
            };
            if from_root {
                folder = if path.is_dir() { path.clone() } else { path.with_file_name("") };
            }
            if is_path && !path.exists() {
                missing.push(word.to_owned());
            }
        }
    }
    assert!(missing.is_empty(), "docs/ARCHITECTURE.md names what is not there: {missing:?}");
    assert!(quoted(&text).any(|word| word == "src/pipeline/mod.rs"), "the paths were not found in the document");
}

#[test]
fn every_command_of_cargo_in_the_readme_exists() {
    let [readme, config] =
        ["README.md", ".cargo/config.toml"].map(|file| std::fs::read_to_string(root().join(file)).unwrap());
    let own = ["build", "run", "test", "install"];
    let aliases: Vec<&str> = config.lines().filter_map(|line| line.split_once(" = ")).map(|(name, _)| name).collect();
    let named: Vec<&str> =
        readme.split("cargo ").skip(1).filter_map(|rest| rest.split([' ', '`', '\n']).next()).collect();
    assert!(named.contains(&"fast"), "{named:?}");
    let missing: Vec<&&str> = named.iter().filter(|name| !own.contains(name) && !aliases.contains(name)).collect();
    assert!(
        missing.is_empty(),
        "README.md names commands that are neither cargo's nor in .cargo/config.toml: {missing:?}"
    );
    let unnamed: Vec<&&str> = aliases.iter().filter(|alias| !named.contains(alias)).collect();
    assert!(unnamed.is_empty(), "README.md does not name {unnamed:?}");
}

#[test]
fn the_checks_can_fail() {
    let code = "use crate::solver::{FlowProblem, Ledger};\nuse crate::math::Vec2;\nfn f(x: crate::scenario::Limits) {}";
    let expected = ["math::Vec2", "scenario::Limits", "solver::FlowProblem", "solver::Ledger"];
    assert_eq!(imports(code), expected.map(String::from).into());
    assert_eq!(imports("use crate::{bed, lattice};"), ["bed", "lattice"].map(String::from).into());
    assert!(
        is_citation("Audusse2004") && is_citation("vanLeer1974") && !is_citation("EPSG32632") && !is_citation("Vec2")
    );
}
