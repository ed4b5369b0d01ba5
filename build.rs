//! Tells the program the commit it was built from; a tarball without git builds as well, without the commit.

use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // A repository around an unpacked tarball is not ours: its top folder is another one.
    let is_ours =
        git(&["rev-parse", "--show-toplevel"]).map(std::path::PathBuf::from).and_then(|top| top.canonicalize().ok())
            == std::path::PathBuf::from(".").canonicalize().ok();
    if !is_ours {
        return;
    }
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"]).filter(|log| std::path::Path::new(log).exists()) {
        println!("cargo::rerun-if-changed={log}");
    }
    if let Some(commit) = git(&["rev-parse", "--short=12", "HEAD"]) {
        println!("cargo::rustc-env=FLOODSIM_COMMIT={commit}");
    }
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}
