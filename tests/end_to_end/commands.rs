//! The commands around a run: usage, starter scenario, schema, completions, manual, version.

use assert_cmd::Command;
use predicates::prelude::{PredicateBooleanExt, predicate};
use tempfile::TempDir;

fn floodsim() -> Command {
    Command::cargo_bin("floodsim").unwrap()
}

#[test]
fn wrong_usage_exits_with_2_and_says_so_on_stderr() {
    for arguments in
        [&[][..], &["--threads", "0", "s.yaml"], &["check"], &["s.yaml", "--fast"], &["completions", "tcl"]]
    {
        floodsim().args(arguments).assert().code(2).stdout("").stderr(predicate::str::contains("--help"));
    }
}

#[test]
fn the_help_lists_commands_and_exit_codes_without_colours() {
    let help = predicate::str::contains("Exit codes:")
        .and(predicate::str::contains("check"))
        .and(predicate::str::contains("\x1b").not());
    floodsim().arg("--help").env("CLICOLOR_FORCE", "1").assert().code(0).stdout(help).stderr("");
}

#[test]
fn the_version_names_the_commit() {
    let expected = predicate::str::is_match(r"^floodsim \d+\.\d+\.\d+ \(([0-9a-f]{12}|unknown)\)\n$").unwrap();
    floodsim().arg("--version").assert().code(0).stdout(expected);
}

#[test]
fn the_starter_is_written_once_and_never_replaced() {
    let folder = TempDir::new().unwrap();
    floodsim().current_dir(&folder).arg("new").assert().code(0).stdout(predicate::str::contains("scenario.yaml"));
    let file = folder.path().join("scenario.yaml");
    let written = std::fs::read_to_string(&file).unwrap();
    assert!(written.contains("\nfloodsim: 1 "));
    std::fs::write(&file, "mine").unwrap();
    floodsim().current_dir(&folder).arg("new").assert().code(8).stderr(predicate::str::contains("exists already"));
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "mine");
    floodsim().current_dir(&folder).args(["new", "no/such/folder.yaml"]).assert().code(8);
}

#[test]
fn the_schema_is_json_that_knows_the_format() {
    let output = floodsim().arg("schema").output().unwrap();
    let schema: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(schema["additionalProperties"], false);
    assert_eq!(schema.pointer("/properties/resolution/allOf/0/$ref").unwrap(), "#/definitions/Length");
    assert!(schema["required"].as_array().unwrap().contains(&"terrain".into()));
}

#[test]
fn completions_and_manual_are_printed() {
    for shell in ["bash", "zsh", "fish"] {
        floodsim().args(["completions", shell]).assert().code(0).stdout(predicate::str::contains("floodsim"));
    }
    floodsim().arg("man").assert().code(0).stdout(predicate::str::contains(".TH floodsim"));
}
