//! What the changed inputs are made from is sound, and names the keys of the format.

use std::collections::BTreeSet;
use std::path::Path;

use tempfile::TempDir;

use crate::judge;
use crate::scene::SCENE;

#[test]
fn the_scenarios_run() {
    let mut wrong = Vec::new();
    for (name, text) in &SCENE.scenarios {
        let folder = TempDir::new().unwrap();
        SCENE.write(folder.path());
        std::fs::write(folder.path().join("s.yaml"), text).unwrap();
        let ended = judge::run(folder.path(), "out");
        if ended.code != Some(0) || judge::fault(&ended, &folder.path().join("out")).is_some() {
            wrong.push(format!(
                "{name}: exit code {:?}, {:?}\n{}",
                ended.code,
                judge::fault(&ended, &folder.path().join("out")),
                ended.said
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_scenarios_have_the_keys_of_the_format() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/scenario-format.md");
    let page = std::fs::read_to_string(page).unwrap();
    let rows = page.lines().filter_map(|line| line.strip_prefix("| `")?.split_once("` |"));
    let keys: BTreeSet<&str> = rows.map(|(key, _)| key).collect();
    let all: String = SCENE.scenarios.iter().map(|(_, text)| text.as_str()).collect();
    let has = |key: &str| all.contains(&format!("{key}:"));
    let absent: Vec<&&str> = keys.iter().filter(|key| !has(key)).collect();
    assert!(keys.len() > 100 && absent.is_empty(), "no scenario has {absent:?}");
}
