//! Output folders that cannot or must not be written.

use super::*;

#[test]
fn a_file_in_the_place_of_the_output_folder_is_refused() {
    let scene = Scene::sound();
    scene.write("out", "a file");
    scene.assert_output_refused(
        "out",
        &["error[output-folder-unwritable] --out\n", "out cannot be written", "it is a file", "--out"],
    );
    scene.assert_output_refused("out/deeper", &["out/deeper cannot be written", "out is a file", "remedy"]);
}

#[test]
fn an_output_folder_that_may_not_be_written_is_refused() {
    let scene = Scene::sound();
    let expected = ["error[output-folder-unwritable] --out\n", "cause", "remedy  choose a folder with --out"];
    if Path::new("/proc/self").exists() {
        // Nobody makes folders here, not even root.
        scene.assert_output_refused("/proc/floodsim", &expected);
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let folder = scene.path("mine");
        std::fs::create_dir(&folder).unwrap();
        std::fs::set_permissions(&folder, std::fs::Permissions::from_mode(0o555)).unwrap();
        if std::fs::write(folder.join("probe"), "").is_ok() {
            std::fs::remove_file(folder.join("probe")).unwrap();
            eprintln!("skipped: this user may write to read-only folders");
        } else {
            scene.assert_output_refused("mine", &expected);
            scene.assert_output_refused("mine/deeper", &expected);
        }
        std::fs::set_permissions(&folder, std::fs::Permissions::from_mode(0o755)).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn a_run_whose_files_find_no_room_says_so_in_its_summary() {
    let scene = Scene::sound();
    // No file may grow beyond 20 blocks of 512 bytes, which `run.json` does not.
    let limited = "trap '' XFSZ; ulimit -f 20; exec \"$0\" s.yaml --out out";
    let program = assert_cmd::cargo::cargo_bin("floodsim");
    let mut shell = std::process::Command::new("sh");
    let output = shell.args(["-c", limited]).arg(program).current_dir(scene.folder.path()).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(8) && said.contains("error: failed to write out/"), "{said}");
    let summary = std::fs::read_to_string(scene.path("out/run.json")).unwrap();
    assert!(summary.contains(r#""status": "failed""#) && summary.contains(r#""exit_code": 8"#), "{summary}");
}

#[test]
fn an_output_folder_with_files_is_left_alone_without_overwrite() {
    let scene = Scene::sound();
    std::fs::create_dir(scene.path("out")).unwrap();
    scene.write("out/thesis.txt", "years of work");
    scene.assert_output_refused(
        "out",
        &["error[output-folder-not-empty] --out\n", "out already holds files", "cause", "add --overwrite"],
    );
    let run = floodsim(scene.folder.path(), &["s.yaml", "--out", "out", "--overwrite"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(std::fs::read_to_string(scene.path("out/thesis.txt")).unwrap(), "years of work");
}

#[test]
fn a_bad_output_folder_is_located_where_it_was_written() {
    let scene = Scene::sound();
    let scenario = std::fs::read_to_string(scene.path("s.yaml")).unwrap();
    assert!(scenario.contains("outputs: {"), "{scenario}");
    for taken in ["taken", "runs/s"] {
        std::fs::create_dir_all(scene.path(taken)).unwrap();
        scene.write(&format!("{taken}/thesis.txt"), "years of work");
    }
    scene.write("file", "");
    let line = 1 + scenario.lines().position(|line| line.starts_with("outputs: {")).unwrap();
    for (folder, code) in [("taken", "output-folder-not-empty"), ("file", "output-folder-unwritable")] {
        scene.write("s.yaml", &scenario.replace("outputs: {", &format!("outputs: {{folder: {folder}, ")));
        let located = format!("error[{code}] outputs.folder (s.yaml:{line}:19)");
        assert_refusal(&floodsim(scene.folder.path(), &["s.yaml"]), 8, &[&located, "cause", "remedy"]);
        // The command line wins, and is named then.
        let run = floodsim(scene.folder.path(), &["s.yaml", "--out", "taken"]);
        assert_refusal(&run, 8, &["error[output-folder-not-empty] --out\n"]);
    }
    scene.write("s.yaml", &scenario);
    let set = floodsim(scene.folder.path(), &["s.yaml", "--set", "outputs.folder=file"]);
    assert_refusal(&set, 8, &["error[output-folder-unwritable] --set outputs.folder\n", "it is a file"]);
    let unnamed = floodsim(scene.folder.path(), &["s.yaml"]);
    assert_refusal(&unnamed, 8, &["error[output-folder-not-empty] outputs.folder, by default\n", "runs/s already"]);
}

#[test]
fn a_refused_run_with_overwrite_leaves_the_earlier_run_as_it_was() {
    let scene = Scene::sound();
    assert_eq!(floodsim(scene.folder.path(), &["s.yaml", "--out", "out"]).code, 0);
    let before = everything_below(&scene.path("out"));
    std::fs::remove_file(scene.path("dem.asc")).unwrap();
    let refused = floodsim(scene.folder.path(), &["s.yaml", "--out", "out", "--overwrite"]);
    assert_eq!(refused.code, 4, "{}", refused.stderr);
    assert!(everything_below(&scene.path("out")) == before, "the earlier run was changed");
}

#[test]
fn problems_of_data_and_output_folder_come_together() {
    let scene = Scene::sound();
    std::fs::remove_file(scene.path("dem.asc")).unwrap();
    scene.polygon("[[[1050,2050],[1100,2100],[1100,2050],[1050,2100],[1050,2050]]]", "{}");
    scene.write("out", "a file");
    let run = floodsim(scene.folder.path(), &["s.yaml", "--out", "out"]);
    assert_refusal(
        &run,
        4,
        &["error[missing-file]", "error[self-crossing]", "error[output-folder-unwritable] --out\n"],
    );
}
