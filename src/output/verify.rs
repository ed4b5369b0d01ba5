//! Checksums of what a run wrote, and whether a folder still holds that.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::file_records::{InputFile, OutputFile};
use super::folder::{RunFolder, output_error};

use crate::checksum::of_file;
use crate::error::{Error, Problem, ProblemKind};
use crate::plain_file;

/// What of `run.json` is verified.
#[derive(Deserialize)]
struct Stated {
    status: String,
    #[serde(default)]
    outputs: Vec<OutputFile>,
    #[serde(default)]
    inputs: Vec<InputFile>,
}

/// What the files of a folder are found to be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verified {
    /// Files of the run and of its inputs that are as they were.
    pub same: usize,
    /// What is not.
    pub problems: Vec<Problem>,
}

/// All results in a run folder, in the order of their names; not what changes or says what it is: `run.json`, checkpoints, frames on their way, a
/// report.
///
/// # Errors
/// When one cannot be read.
pub fn output_files(folder: &RunFolder) -> Result<Vec<OutputFile>, Error> {
    let mut paths = folder.results().map_err(|cause| output_error(folder.path(), cause))?;
    paths.sort();
    let file = |path: PathBuf| {
        let (bytes, sha256) = of_file(&path).map_err(|cause| output_error(&path, cause))?;
        let name = path.strip_prefix(folder.path()).unwrap_or(&path).display().to_string();
        Ok(OutputFile { path: name, bytes, sha256 })
    };
    paths.into_iter().map(file).collect()
}

/// Compares the files of a run folder, and the inputs of the run, with the checksums of its `run.json`.
///
/// # Errors
/// [`Error::Problems`] where the folder has no `run.json` that can be read, or one of a run that has not ended.
pub fn verify(folder: &Path) -> Result<Verified, Error> {
    let path = folder.join("run.json");
    let unreadable = |cause: String| {
        let message = format!("{} cannot be read as the record of a run", path.display());
        Error::Problems(vec![
            Problem::error(ProblemKind::Input, "not-a-run", "", message)
                .with_cause(cause)
                .with_remedy("name the folder of a run, which holds run.json"),
        ])
    };
    let text = plain_file::read_to_string(&path).map_err(|cause| unreadable(cause.to_string()))?;
    let stated: Stated = serde_json::from_str(&text).map_err(|cause| unreadable(cause.to_string()))?;
    if stated.outputs.is_empty() {
        let cause = format!("its status is `{}`, and it states no checksums of its results", stated.status);
        return Err(unreadable(cause));
    }
    let mut verified = Verified::default();
    let mut compare = |path: &Path, name: &str, sha256: &str, code: &'static str, what: &str| {
        let found = of_file(path);
        let cause = match found {
            Ok((_, found)) if found == sha256 => {
                verified.same += 1;
                return;
            }
            Ok((bytes, _)) => format!("its {bytes} bytes have another checksum"),
            Err(cause) => cause.to_string(),
        };
        let message = format!("{name} is not {what}");
        verified.problems.push(Problem::error(ProblemKind::Input, code, "", message).with_cause(cause));
    };
    for OutputFile { path, sha256, .. } in &stated.outputs {
        compare(&folder.join(path), path, sha256, "outputs-changed", "as the run wrote it");
    }
    for InputFile { path, sha256 } in &stated.inputs {
        compare(Path::new(path), path, sha256, "inputs-changed", "as the run read it");
    }
    Ok(verified)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_changed_is_named() {
        let place = tempfile::tempdir().unwrap();
        let folder = RunFolder::create(&place.path().join("out"), false).unwrap();
        folder.write("maps.nc", b"maps").unwrap();
        folder.write("tables/gauges.csv", b"gauges").unwrap();
        folder.write("checkpoint.bin", b"state").unwrap();
        let files = output_files(&folder).unwrap();
        assert_eq!(files.iter().map(|file| file.path.as_str()).collect::<Vec<_>>(), ["maps.nc", "tables/gauges.csv"]);
        // The value of `printf gauges | sha256sum`.
        assert_eq!(&files[1].sha256[..8], "34ed013f");
        let record = serde_json::json!({"status": "done", "outputs": files, "inputs": []});
        folder.write("run.json", record.to_string().as_bytes()).unwrap();
        assert_eq!(verify(folder.path()).unwrap(), Verified { same: 2, problems: Vec::new() });
        std::fs::write(folder.file("maps.nc"), b"mapz").unwrap();
        std::fs::remove_file(folder.file("tables/gauges.csv")).unwrap();
        let Verified { same, problems } = verify(folder.path()).unwrap();
        let messages: Vec<&str> = problems.iter().map(|problem| problem.message.as_str()).collect();
        assert_eq!(same, 0);
        assert_eq!(messages, ["maps.nc is not as the run wrote it", "tables/gauges.csv is not as the run wrote it"]);
    }
}
