//! What `scripts/package.sh` gives to others: files that find each other.

use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

/// Links of a page to other files.
fn links(page: &str) -> Vec<&str> {
    let targets = page.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
    targets.filter(|target| !target.is_empty() && !target.contains("://")).collect()
}

/// The pages that users read. Records and studies name figures and tables that do not go along.
fn pages(archive: &Path) -> Vec<PathBuf> {
    let entries = [".", "docs", "docs/tutorial", "docs/guide"].map(|folder| archive.join(folder).read_dir());
    let found = entries.into_iter().flatten().flatten().map(|entry| entry.unwrap().path());
    found.filter(|path| path.extension().is_some_and(|extension| extension == "md")).collect()
}

#[test]
fn the_archive_has_the_files_of_its_scenarios_and_pages() {
    let folder = TempDir::new().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/package.sh");
    let mut stage = Command::new(script);
    stage.arg("stage").arg(folder.path()).env("FLOODSIM_BINARY", assert_cmd::cargo::cargo_bin("floodsim"));
    let answer = stage.output().unwrap();
    assert!(answer.status.success(), "{}", String::from_utf8_lossy(&answer.stderr));

    for scenario in [
        "demo/scenario",
        "tutorial/scenario",
        "tutorial/breach",
        "tutorial/levee",
        "river_flood/scenario",
        "spill/scenario",
    ] {
        let mut check = Command::new(folder.path().join("floodsim"));
        check.current_dir(folder.path()).args(["check", &format!("scenarios/{scenario}.yaml")]);
        let answer = check.output().unwrap();
        assert!(answer.status.success(), "{scenario}: {}", String::from_utf8_lossy(&answer.stdout));
    }
    for page in pages(folder.path()) {
        for link in links(&std::fs::read_to_string(&page).unwrap()) {
            let target = page.with_file_name(link);
            assert!(target.exists(), "{} names {link}, which scripts/package.sh leaves out", page.display());
        }
    }
    for file in
        ["floodsim.1", "completions/floodsim.bash", "completions/_floodsim", "completions/floodsim.fish", "LICENSE-MIT"]
    {
        assert!(folder.path().join(file).metadata().unwrap().len() > 100, "{file} is empty");
    }
}
