//! From the text of a scenario to a `Scenario`: all checks, all problems at once, all defaults.

use std::io::Read;
use std::path::Path;

use super::fields::split_layer;
use super::model::Scenario;
use super::read::{FromNode, Reader, folder_of};
use super::sections::{ScenarioFile, fill_in, open_length};
use super::{preset, tree};
use crate::error::{Error, Place, Problem, ProblemKind, sort_problems};
use crate::plain_file::odd_kind;

/// Largest scenario file (bytes); data belongs into files of its own.
const MAX_FILE_BYTES: u64 = 1 << 20;

/// A scenario that can be run, and what the planner should know about it.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scenario.
    pub scenario: Scenario,
    /// Problems that do not stop it.
    pub warnings: Vec<Problem>,
}

/// Reads and resolves a scenario file, with overrides of the form `key.path=value`.
///
/// # Errors
/// `Error::Usage` for an override whose path does not fit, `Error::Problems` with every problem otherwise.
pub fn load(file: &Path, overrides: &[String]) -> Result<Loaded, Error> {
    resolve(&read_text(file)?, file, overrides)
}

/// Resolves the text of a scenario that stands in the given file.
///
/// # Errors
/// As for `load`.
pub fn resolve(text: &str, file: &Path, overrides: &[String]) -> Result<Loaded, Error> {
    let (mut root, duplicates) = tree::parse(text, file).map_err(|problem| Error::Problems(vec![*problem]))?;
    for change in overrides {
        if change.trim_start().starts_with("resolution.") {
            open_length(&mut root);
        }
        tree::apply_override(&mut root, change).map_err(Error::Usage)?;
    }
    preset::expand(&mut root);
    let mut reader = Reader::new(&folder_of(file));
    reader.problems = duplicates;
    let written = ScenarioFile::from_node(&root, &mut reader);
    if let Some(problem) =
        reader.problems.iter().find(|problem| problem.code == "unknown-key" && problem.place.is_none())
    {
        let remedy = problem.remedy.as_deref().unwrap_or_default();
        return Err(Error::Usage(format!("--set {}: {}; {remedy}", problem.key, problem.message)));
    }
    match written {
        Some(written) if !reader.has_errors() => {
            let scenario = fill_in(written, file);
            Ok(Loaded { scenario, warnings: reader.problems })
        }
        _ => {
            list_missing_files(&mut reader);
            sort_problems(&mut reader.problems);
            Err(Error::Problems(reader.problems))
        }
    }
}

/// Reads the file; what keeps it from being a text of moderate size is an error of the scenario.
fn read_text(file: &Path) -> Result<String, Error> {
    let name = file.display();
    let refused = |code, message: String, remedy: &str, place, cause| {
        let problem = Problem::error(ProblemKind::Scenario, code, "", message).with_remedy(remedy).with_place(place);
        Error::Problems(vec![Problem { cause, ..problem }])
    };
    let unreadable = |cause: std::io::Error| {
        let code = if cause.kind() == std::io::ErrorKind::NotFound { "missing-file" } else { "unreadable-file" };
        let remedy = "give the path of a scenario file; `floodsim new` writes one to start from";
        refused(code, format!("the scenario file `{name}` cannot be read"), remedy, None, Some(cause.to_string()))
    };
    if file.is_dir() {
        let inside = file.join("scenario.yaml");
        let is_there = inside.is_file();
        let remedy = if is_there { format!("did you mean `{}`?", inside.display()) } else { "name a file".to_owned() };
        return Err(refused("folder", format!("`{name}` is a folder, not a scenario file"), &remedy, None, None));
    }
    if let Some(kind) = std::fs::metadata(file).ok().as_ref().and_then(odd_kind) {
        let message = format!("`{name}` is {kind}, not a scenario file");
        return Err(refused("not-a-file", message, "write what it gives to a file, and name that", None, None));
    }
    let mut bytes = Vec::new();
    let opened = std::fs::File::open(file).map_err(unreadable)?;
    opened.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        let remedy = "a scenario names its data; rasters, polygons and tables stay in files of their own";
        return Err(refused(
            "too-large",
            format!("the scenario file `{name}` is larger than 1 MiB"),
            remedy,
            None,
            None,
        ));
    }
    String::from_utf8(bytes).map_err(|error| {
        let good = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + good.iter().filter(|byte| **byte == b'\n').count();
        let line_start = good.iter().rposition(|byte| *byte == b'\n').map_or(0, |index| index + 1);
        let column = 1 + String::from_utf8_lossy(&good[line_start..]).chars().count();
        let place = Place { file: file.to_owned(), line, column };
        let message = "the scenario file is not UTF-8 text".to_owned();
        refused("encoding", message, "save it as UTF-8 in the editor", Some(place), None)
    })
}

/// Lists the named files that do not exist, since a scenario with errors is not opened any further.
fn list_missing_files(reader: &mut Reader) {
    for file in std::mem::take(&mut reader.files) {
        // Paths such as `/vsizip/...` exist only for GDAL.
        let name = file.value.to_string_lossy();
        // What stands behind a colon is a variable of the file.
        if name.starts_with("/vsi") || file.value.exists() || Path::new(split_layer(&name).0).exists() {
            continue;
        }
        let message = format!("the file `{}` does not exist", file.value.display());
        let problem = Problem::error(ProblemKind::Input, "missing-file", file.key, message)
            .with_place(file.place)
            .with_remedy("correct the path; it counts from the folder of the scenario");
        reader.problems.push(problem);
    }
}

#[cfg(test)]
mod tests;
