//! The studies in the guide, each read as the program reads a study.

use std::path::Path;

use super::file::Study;

#[test]
fn every_study_in_the_guide_is_read() {
    let guide = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/guide/studies.md")).unwrap();
    let snippets = guide.split("```yaml\n").skip(1).filter_map(|rest| rest.split_once("\n```"));
    let folder = tempfile::TempDir::new().unwrap();
    let mut count = 0;
    for (snippet, _) in snippets {
        let head = if snippet.contains("study: 1") { "" } else { "study: 1\nbase: scenario.yaml\n" };
        let file = folder.path().join("study.yaml");
        std::fs::write(&file, format!("{head}{snippet}\n")).unwrap();
        let study = Study::read(&file).unwrap_or_else(|error| panic!("{error}\n{snippet}"));
        assert!(!study.variables.is_empty() || study.variants.len() > 1);
        count += 1;
    }
    assert_eq!(count, 2);
}
