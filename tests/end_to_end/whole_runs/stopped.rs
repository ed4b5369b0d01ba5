//! Runs that are stopped or killed.

use super::*;

/// Starts a long run of the demonstration and waits until it has written its first frames.
fn start_long_run(folder: &Path) -> Child {
    start_long_run_by(folder, Command::new(assert_cmd::cargo::cargo_bin("floodsim")))
}

/// The same by a command that is the program, or becomes it.
fn start_long_run_by(folder: &Path, mut command: Command) -> Child {
    let arguments = ["run", &shipped("demo"), "--out", "out", "--set", "time.end=10 h", "--set", "outputs.every=30 s"];
    command.current_dir(folder).args(arguments).stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().unwrap();
    let start = Instant::now();
    let partial = folder.join("out/fields.partial.nc");
    while !partial.metadata().is_ok_and(|metadata| metadata.len() > 30_000_000) {
        assert!(start.elapsed() < Duration::from_secs(60), "no frames after a minute");
        assert!(child.try_wait().unwrap().is_none(), "the run ended by itself");
        std::thread::sleep(Duration::from_millis(20));
    }
    child
}

#[cfg(unix)]
#[test]
fn a_terminated_run_closes_its_files_and_says_so() {
    for (signal, code) in [("TERM", 143), ("INT", 130)] {
        let folder = TempDir::new().unwrap();
        let mut child = start_long_run(folder.path());
        let kill = format!("kill -{signal} {}", child.id());
        assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(code));
        let out = folder.path().join("out");
        let record = manifest(&out);
        assert_eq!((&record["status"], &record["exit_code"]), (&"stopped".into(), &code.into()));
        let simulated = record["simulated_s"].as_f64().unwrap();
        assert!(simulated > 0.0 && simulated < 36_000.0);
        // The run may go on.
        assert!(out.join("fields.partial.nc").exists() && out.join("checkpoint.bin").exists());
        let fields = Netcdf::read(&out.join("fields.nc"));
        let times = fields.values("time");
        assert!(times.len() > 2 && times.last().is_some_and(|last| *last <= simulated + 1e-6), "{times:?}");
        assert!(Netcdf::read(&out.join("maps.nc")).variables.contains_key("arrival_time"));
        let report = floodsim(folder.path(), &["report", "out"]);
        assert_eq!(report.code, 0, "{}", report.stderr);
        assert!(report.stderr.contains("warning: the run was stopped at"), "{}", report.stderr);
        let page = std::fs::read_to_string(out.join("report/index.html")).unwrap();
        assert!(page.contains("<p class=\"status bad\"><b>the run was stopped at"));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_hang_up_stops_a_run_that_is_not_to_outlive_its_terminal() {
    let send = |signal: &str, child: &Child| {
        let kill = format!("kill -{signal} {}", child.id());
        assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    };
    for (disposition, code) in [("--default-signal=HUP", 129), ("--ignore-signal=HUP", 143)] {
        let folder = TempDir::new().unwrap();
        let mut command = Command::new("env");
        command.arg(disposition).arg(assert_cmd::cargo::cargo_bin("floodsim"));
        let mut child = start_long_run_by(folder.path(), command);
        send("HUP", &child);
        if code == 143 {
            std::thread::sleep(Duration::from_secs(1));
            assert!(child.try_wait().unwrap().is_none(), "the run under nohup ended");
            send("TERM", &child);
        }
        assert_eq!(child.wait().unwrap().code(), Some(code));
        let out = folder.path().join("out");
        assert_eq!((&manifest(&out)["status"], &manifest(&out)["exit_code"]), (&"stopped".into(), &code.into()));
        assert!(out.join("checkpoint.bin").exists() && out.join("maps.nc").exists());
    }
}

#[test]
fn a_killed_run_is_not_taken_as_whole_but_its_frames_can_be_read() {
    let folder = TempDir::new().unwrap();
    let mut child = start_long_run(folder.path());
    // While it lives, nobody else may write there.
    let mixed = floodsim(folder.path(), &["run", &shipped("ritter"), "--out", "out", "--overwrite"]);
    assert_eq!(mixed.code, 8, "{}", mixed.stderr);
    assert!(mixed.stderr.contains("error[output-folder-in-use] --out"), "{}", mixed.stderr);
    assert!(mixed.stderr.contains(&format!("process {}", child.id())), "{}", mixed.stderr);
    child.kill().unwrap();
    child.wait().unwrap();
    let out = folder.path().join("out");
    assert_eq!(manifest(&out)["status"], "running");
    assert!(!out.join("maps.nc").exists() && !out.join("fields.nc").exists());
    let partial = Netcdf::read(&out.join("fields.partial.nc"));
    let times = partial.values("time").to_vec();
    assert!(times.len() > 2 && times.windows(2).all(|pair| pair[1] > pair[0]), "{times:?}");
    // Cut off before the first checkpoint, it has nothing to be drawn.
    let report = floodsim(folder.path(), &["report", "out"]);
    assert_eq!((report.code, report.stdout.as_str()), (4, ""));
    assert!(report.stderr.contains("error[no-checkpoint]") && report.stderr.contains("remedy"), "{}", report.stderr);
    assert!(!out.join("report").exists());
    // The next run takes its place when told to, and leaves nothing of it.
    let next = ["run", &shipped("ritter"), "--out", "out", "--set", "time.end=1 s"];
    assert_eq!(floodsim(folder.path(), &next).code, 8);
    assert_eq!(floodsim(folder.path(), &[&next[..], &["--overwrite"]].concat()).code, 0);
    assert_whole(&out);
}
