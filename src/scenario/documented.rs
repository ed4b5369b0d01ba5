//! The scenarios in the documents: each snippet of YAML is read as the program reads a scenario.

use std::path::{Path, PathBuf};

use super::resolve;
use crate::error::Error;

/// What a snippet that shows some keys alone stands in.
const AROUND: [(&str, &str); 6] = [
    ("floodsim", "1"),
    ("terrain", "dem.tif"),
    ("roughness", "{manning: 0.033}"),
    ("initial", "[{reservoir: reservoir.geojson, level: 100 m}]"),
    ("resolution", "20 m"),
    ("time", "{end: 1 h, reference: \"2026-06-01 06:00:00\"}"),
];

fn documents() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let of_guide = std::fs::read_dir(root.join("docs/guide")).unwrap().map(|entry| entry.unwrap().path());
    let others = ["README.md", "docs/tutorial.md", "docs/scenario-rules.md"].map(|name| root.join(name));
    // Studies are read by `matrix`.
    let has_scenarios =
        |path: &PathBuf| path.extension().is_some_and(|end| end == "md") && !path.ends_with("studies.md");
    of_guide.filter(has_scenarios).chain(others).collect()
}

/// The snippets of a document.
fn snippets(text: &str) -> Vec<&str> {
    text.split("```yaml\n").skip(1).filter_map(|rest| rest.split_once("\n```").map(|(snippet, _)| snippet)).collect()
}

/// A snippet as a scenario: what it does not say stands around it.
fn whole(snippet: &str) -> String {
    let says = |key: &str| snippet.lines().any(|line| line.starts_with(&format!("{key}:")));
    let is_whole = says("floodsim");
    let around = AROUND.iter().filter(|(key, _)| !is_whole && !says(key));
    around.map(|(key, value)| format!("{key}: {value}\n")).collect::<String>()
        + &snippet.replace("${FLOODSIM_DATA}", "data")
}

#[test]
fn every_scenario_in_the_documents_is_read() {
    let (mut count, mut wrong) = (0, Vec::new());
    for document in documents() {
        let text = std::fs::read_to_string(&document).unwrap();
        for snippet in snippets(&text) {
            count += 1;
            match resolve(&whole(snippet), Path::new("scenario.yaml"), &[]) {
                Ok(_) => {}
                Err(Error::Problems(problems)) => {
                    // The files that they name are those of the reader.
                    let found = problems.iter().filter(|problem| problem.code != "missing-file");
                    wrong.extend(found.map(|problem| format!("{}: {problem:?}\n{snippet}", document.display())));
                }
                Err(error) => wrong.push(format!("{}: {error}\n{snippet}", document.display())),
            }
        }
    }
    assert!(count > 20, "{count} snippets were found");
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}
