use std::path::Path;

use super::changes::between;

fn folder(scenario: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scenario.resolved.yaml"), scenario).unwrap();
    folder
}

#[test]
fn changes_of_scenario_inputs_and_program_are_named() {
    let first = folder(
        "title: a\nroughness: {manning: 0.03}\ninitial:\n  - {level: 12 m}\n  - {level: 9 m}\noutputs: {folder: x, cell: 5 m}\nlimits: {memory: 8 GB}\n",
    );
    let second = folder(
        "title: b\nroughness: {manning: 0.04}\ninitial:\n  - {level: 12 m}\nrain: {rate: 2 mm/h}\noutputs: {folder: y, cell: 5 m}\n",
    );
    let record = |version: &str, checksum: &str| {
        serde_json::json!({"version": version, "git": "c0ffee",
            "inputs": [{"path": "dem.tif", "sha256": checksum}, {"path": version, "sha256": "1"}]})
    };
    let (old, new) = (record("1.0", "aa"), record("1.1", "bb"));
    let folders: [&Path; 2] = [first.path(), second.path()];
    let changes = between(folders, [&old, &new]);
    let text = |value: &Option<String>| value.clone().unwrap_or_default();
    let named: Vec<String> = changes
        .scenario
        .iter()
        .chain(&changes.inputs)
        .chain(&changes.program)
        .map(|change| format!("{} {} {}", change.what, text(&change.first), text(&change.second)))
        .collect();
    let expected = [
        "roughness.manning 0.03 0.04",
        "initial[1].level 9 m ",
        "rain.rate  2 mm/h",
        "dem.tif aa bb",
        "program 1.0 (c0ffee) 1.1 (c0ffee)",
    ];
    assert_eq!(named, expected);
    assert!(between([first.path(); 2], [&old; 2]).is_empty());
}
