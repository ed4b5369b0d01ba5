//! A run of the program in a folder, as a process with limits, and what is wrong with how it ended.

use std::fs::File;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Address space of a run (KiB): many times what the limits of the scenarios allow.
const ADDRESS_SPACE: usize = 4 << 20;

/// Largest file (blocks of 512 bytes).
const FILE_SIZE: usize = 1 << 21;

/// How long a run may be silent.
const SILENCE: Duration = Duration::from_secs(60);

/// A run that steps is long enough when it took so long: it is asked to end.
const LONG_ENOUGH: Duration = Duration::from_secs(3);

/// What only lines of progress have.
const PROGRESS: &str = "  to go ";

/// The exit codes of a run that was not asked to end, from docs/guide/outputs.md. 1 and 2 are not among them: neither the program nor
/// the command line is wrong.
const DOCUMENTED: &[i32] = &[0, 3, 4, 5, 6, 7, 8];

/// That of SIGTERM.
const TERMINATED: i32 = 143;

/// How a run ended.
pub struct Ended {
    /// Its exit code; none where a signal ended it.
    pub code: Option<i32>,
    /// What it wrote to stderr.
    pub said: String,
    /// Whether it was asked to end.
    pub is_stopped: bool,
    /// What it did not bear: a limit of time.
    pub overdue: Option<&'static str>,
}

/// Runs `s.yaml` in a folder.
pub fn run(folder: &Path, out: &str) -> Ended {
    let stderr = folder.join("stderr");
    let limits = format!("ulimit -v {ADDRESS_SPACE} && ulimit -f {FILE_SIZE} && ulimit -c 0 && exec \"$@\"");
    let mut command = Command::new("sh");
    command.args(["-c", &limits, "sh"]).arg(assert_cmd::cargo::cargo_bin("floodsim"));
    command.args(["run", "s.yaml", "--out", out, "--threads", "1"]).current_dir(folder);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(File::create(&stderr).unwrap());
    let mut child = command.spawn().unwrap();
    let (is_stopped, overdue) = wait(&mut child, &stderr);
    let code = child.wait().unwrap().code();
    let said = String::from_utf8_lossy(&std::fs::read(&stderr).unwrap()).into_owned();
    Ended { code, said, is_stopped, overdue }
}

/// Waits for the end of a run; whether it was asked to end, and the limit of time that it did not keep.
fn wait(child: &mut Child, stderr: &Path) -> (bool, Option<&'static str>) {
    let (start, mut heard, mut length) = (Instant::now(), Instant::now(), 0);
    let mut is_stopped = false;
    let mut pause = Duration::from_millis(1);
    while child.try_wait().unwrap().is_none() {
        std::thread::sleep(pause);
        pause = (pause * 3 / 2).min(Duration::from_millis(50));
        let now = std::fs::metadata(stderr).unwrap().len();
        if now > length {
            (heard, length) = (Instant::now(), now);
        }
        if heard.elapsed() > SILENCE {
            child.kill().unwrap();
            return (
                is_stopped,
                Some(if is_stopped { "it does not end when it is asked to" } else { "60 s without a word" }),
            );
        }
        if !is_stopped
            && start.elapsed() > LONG_ENOUGH
            && std::fs::read_to_string(stderr).is_ok_and(|said| said.contains(PROGRESS))
        {
            is_stopped = Command::new("kill").arg(child.id().to_string()).status().unwrap().success();
        }
    }
    (is_stopped, None)
}

/// What is wrong with an end; nothing where it is as documented.
pub fn fault(ended: &Ended, out: &Path) -> Option<String> {
    if let Some(overdue) = ended.overdue {
        return Some(overdue.to_owned());
    }
    let Some(code) = ended.code else { return Some("ended by a signal".to_owned()) };
    if ended.said.contains("panicked at") {
        return Some("panic".to_owned());
    }
    if !(DOCUMENTED.contains(&code) || ended.is_stopped && code == TERMINATED) {
        return Some(format!("exit code {code}"));
    }
    if ended.said.contains(|c: char| c.is_control() && c != '\n' && c != '\t') {
        return Some("control characters on the terminal".to_owned());
    }
    if !matches!(code, 0 | TERMINATED) && !ended.said.lines().any(|line| line.starts_with("error")) {
        return Some(format!("exit code {code} without a word"));
    }
    of_folder(code, out)
}

/// What is wrong with the output folder of a run that ended with such a code.
fn of_folder(code: i32, out: &Path) -> Option<String> {
    if matches!(code, 3..=5) {
        return out.exists().then(|| format!("exit code {code}, and an output folder"));
    }
    let record = match std::fs::read_to_string(out.join("run.json")) {
        Ok(record) => record,
        // What cannot be written at all, and what is stopped before it has begun to write.
        Err(_) if matches!(code, 8 | TERMINATED) => return None,
        Err(cause) => return Some(format!("exit code {code}, and no run.json: {cause}")),
    };
    let record: serde_json::Value = match serde_json::from_str(&record) {
        Ok(record) => record,
        Err(cause) => return Some(format!("run.json is not JSON: {cause}")),
    };
    let expected = match code {
        0 | 7 => "done",
        TERMINATED => "stopped",
        _ => "failed",
    };
    if record["status"] != expected {
        return Some(format!("exit code {code}, and status {}", record["status"]));
    }
    // A run that does not end in time when it is asked to leaves at once, with what it has not finished.
    let is_left = |name: &str| match code {
        TERMINATED => false,
        _ => name == ".running" || name.contains(".unfinished.") || code == 0 && name.contains(".partial."),
    };
    let mut names = std::fs::read_dir(out).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    if let Some(name) = names.find(|name| is_left(name)) {
        return Some(format!("exit code {code}, and {name} is left"));
    }
    (code == 0).then(|| damaged(out)).flatten()
}

/// What `floodsim verify` finds wrong with a run folder.
fn damaged(out: &Path) -> Option<String> {
    let mut verify = Command::new(assert_cmd::cargo::cargo_bin("floodsim"));
    let (parent, name) = (out.parent().unwrap(), out.file_name().unwrap());
    let verified = verify.arg("verify").arg(name).current_dir(parent).output().unwrap();
    (!verified.status.success()).then(|| format!("verify: {}", String::from_utf8_lossy(&verified.stderr)))
}
