use super::*;
use crate::error::ExitCode;

fn refused(result: Result<RunFolder, Error>) -> (String, ExitCode) {
    let error = result.expect_err("the folder must be refused");
    (error.to_string(), error.exit_code())
}

#[test]
fn folder_with_files_is_refused_and_left_alone() {
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("thesis.txt"), "years of work").unwrap();
    let (message, exit_code) = refused(RunFolder::create(place.path(), false));
    assert_eq!(exit_code, ExitCode::Output);
    assert!(message.contains("already holds files") && message.contains("--overwrite"), "{message}");
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1);
}

#[test]
fn overwriting_deletes_only_what_a_run_writes() {
    let place = tempfile::tempdir().unwrap();
    let first = RunFolder::create(&place.path().join("deep/run"), false).unwrap();
    for folder in ["cog", "tables"] {
        fs::create_dir(first.file(folder)).unwrap();
    }
    for name in ["run.json", "cog/max_depth.tif", "cog/mine.tif", "thesis.txt", "tables/.unfinished.gauges.csv"] {
        fs::write(first.file(name), "x").unwrap();
    }
    drop(first);
    let again = RunFolder::create(&place.path().join("deep/run"), true).unwrap();
    let kept = |name: &str| again.file(name).exists();
    assert!(kept("thesis.txt") && kept("cog/mine.tif"));
    assert!(!kept("run.json") && !kept("cog/max_depth.tif") && !kept("tables/.unfinished.gauges.csv"));
}

#[test]
fn folder_below_a_file_is_refused() {
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("file"), "").unwrap();
    for path in ["file", "file/run"] {
        let (message, exit_code) = refused(RunFolder::create(&place.path().join(path), false));
        assert_eq!(exit_code, ExitCode::Output);
        assert!(message.contains("cannot be written") && message.contains("is a file"), "{message}");
    }
}

#[test]
fn failed_file_leaves_nothing_behind() {
    let place = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(place.path(), false).unwrap();
    let result = folder.write_with("maps.nc", |path| {
        fs::write(path, "half").unwrap();
        Err(output_error(path, "disk full"))
    });
    assert!(result.is_err());
    assert_eq!(
        fs::read_dir(place.path()).unwrap().filter(|entry| entry.as_ref().unwrap().file_name() != HOLD).count(),
        0
    );
}

#[test]
fn a_folder_is_held_until_its_run_ends_and_a_dead_one_holds_nothing() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("run");
    let first = RunFolder::create(&path, false).unwrap();
    let copy = first.clone();
    drop(first);
    for overwrite in [false, true] {
        let (message, exit_code) = refused(RunFolder::create(&path, overwrite));
        assert_eq!(exit_code, ExitCode::Output);
        assert!(message.contains("[output-folder-in-use]") && message.contains("process "), "{message}");
    }
    drop(copy);
    assert_eq!(fs::read_dir(&path).unwrap().count(), 0);
    // What a killed run leaves.
    fs::write(path.join(HOLD), "1").unwrap();
    RunFolder::create(&path, false).unwrap();
}

#[test]
fn of_several_runs_that_start_at_once_one_gets_the_folder() {
    for overwrite in [false, true] {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("run");
        let start = std::sync::Barrier::new(8);
        let results: Vec<_> = std::thread::scope(|scope| {
            let create = || {
                start.wait();
                RunFolder::create(&path, overwrite)
            };
            let threads: Vec<_> = (0..8).map(|_| scope.spawn(create)).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        let (held, others): (Vec<_>, Vec<_>) = results.into_iter().partition(Result::is_ok);
        assert_eq!(held.len(), 1);
        for result in others {
            let (message, _) = refused(result);
            assert!(message.contains("[output-folder-in-use]"), "{message}");
        }
    }
}

#[test]
fn nothing_is_written_through_a_link() {
    use std::os::unix::fs::symlink;
    let place = tempfile::tempdir().unwrap();
    let (other, path) = (place.path().join("other"), place.path().join("out"));
    let is_whole = || fs::read_to_string(&other).unwrap() == "years of work";
    fs::write(&other, "years of work").unwrap();
    fs::create_dir(&path).unwrap();
    symlink(&other, path.join(HOLD)).unwrap();
    let (message, exit_code) = refused(RunFolder::create(&path, false));
    assert!(exit_code == ExitCode::Output && is_whole(), "{message}");
    fs::remove_file(path.join(HOLD)).unwrap();
    for name in [".unfinished.probe", ".unfinished.run.json", ".unfinished.ended.json"] {
        symlink(&other, path.join(name)).unwrap();
    }
    let folder = RunFolder::create(&path, true).unwrap();
    symlink(&other, path.join(".unfinished.run.json")).unwrap();
    folder.write("run.json", b"{\n  \"status\": \"running\"\n}").unwrap();
    symlink(&other, path.join(".unfinished.ended.json")).unwrap();
    super::super::file_records::mark_ended(&path, "failed", 8);
    assert!(is_whole() && fs::read_to_string(path.join("run.json")).unwrap().contains("failed"));
    drop(folder);
    // Nor are files deleted and written in a folder elsewhere.
    fs::create_dir(place.path().join("tables")).unwrap();
    fs::write(place.path().join("tables/gauges.csv"), "mine").unwrap();
    symlink(place.path().join("tables"), path.join("tables")).unwrap();
    for result in [RunFolder::create(&path, true), RunFolder::reopen(&path)] {
        let (message, _) = refused(result);
        assert!(message.contains("`tables` in it is a link"), "{message}");
    }
    assert!(place.path().join("tables/gauges.csv").exists());
}
