//! Which inputs are opened at all: files of this machine, and of those that a VRT names, the ones in its folder or in that of the scenario; no file
//! at which a library would crash.
//!
//! A scenario may come from anywhere. What it names itself its reader has seen; what a file of it names in turn nobody has.

use std::path::{Path, PathBuf};

use super::inputs::{self, NamedInput};
use crate::error::{Problem, input_error, sort_problems};
use crate::geodata::vrt::{Named, is_elsewhere, named_by, sources};
use crate::geodata::{netcdf_file, open, readable_file};
use crate::plain_file::odd_kind;
use crate::scenario::Scenario;

/// What is refused before any input is opened. With it come the files that are not there, since the scenario is looked at no further.
pub fn refused(scenario: &Scenario) -> Vec<Problem> {
    open::allow_remote(scenario.limits.allow_remote);
    let named = inputs::named(scenario);
    let own = real_folder(&scenario.file);
    let mut problems: Vec<Problem> = Vec::new();
    for input in &named {
        let found = faults_of(&input.path, own.as_deref(), scenario.limits.allow_remote).into_iter();
        problems.extend(found.map(|problem| at(input, problem)));
    }
    if problems.is_empty() {
        return problems;
    }
    let missing = named.iter().filter(|input| !is_elsewhere(&input.path.to_string_lossy()) && !input.path.exists());
    problems.extend(missing.filter_map(|input| Some(at(input, readable_file(&input.path).err()?))));
    sort_problems(&mut problems);
    problems
}

fn at(input: &NamedInput, mut problem: Problem) -> Problem {
    problem.key.clone_from(&input.key);
    problem.with_place(input.place.clone())
}

/// The folder of a file, without links.
fn real_folder(file: &Path) -> Option<PathBuf> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    folder.canonicalize().ok()
}

/// The same of a file that may itself be a link.
fn real_folders(file: &Path) -> impl Iterator<Item = PathBuf> {
    real_folder(file).into_iter().chain(file.canonicalize().ok().and_then(|real| real.parent().map(Path::to_owned)))
}

/// What keeps an input from being opened.
fn faults_of(path: &Path, own: Option<&Path>, is_remote_allowed: bool) -> Vec<Problem> {
    let name = path.to_string_lossy();
    if is_elsewhere(&name) {
        let is_path_of_gdal = name.starts_with("/vsi");
        return if is_remote_allowed && is_path_of_gdal {
            Vec::new()
        } else {
            vec![named_elsewhere(path, is_path_of_gdal)]
        };
    }
    if let Some(kind) = std::fs::metadata(path).ok().as_ref().and_then(odd_kind) {
        return vec![crate::geodata::not_a_file(path, kind)];
    }
    // A VRT beside the scenario has the tree of the scenario; another one, which the scenario names itself, its own, too.
    let roots: Vec<PathBuf> = own.map(Path::to_owned).into_iter().chain(real_folders(path)).collect();
    let mut problems = Vec::new();
    for file in std::iter::once(path.to_owned()).chain(sources(path)) {
        problems.extend(netcdf_file::impossible(&file));
        for named in named_by(&file).unwrap_or_default() {
            let found = fault_of(&file, &named, &roots, is_remote_allowed);
            problems.extend(found.filter(|problem| !problems.contains(problem)));
        }
    }
    /// Of the sources of a mosaic the first few say it all.
    const MOST: usize = 5;
    problems.truncate(MOST);
    problems
}

/// What is wrong with what a file names.
fn fault_of(file: &Path, named: &Named, roots: &[PathBuf], is_remote_allowed: bool) -> Option<Problem> {
    let name = file.display();
    let cause = match named {
        Named::Code => {
            let message = format!("{name} holds code that would be run to read it");
            let remedy = "write its values to a GeoTIFF where you trust it: `gdal_translate FILE OUT.tif`";
            return Some(
                input_error("code-in-file", message).with_cause("a pixel function in Python").with_remedy(remedy),
            );
        }
        Named::Elsewhere(_) if is_remote_allowed => return None,
        Named::Elsewhere(text) => format!("`{}` is on a network, in an archive or in a database", start_of(text)),
        Named::File(source) => {
            if let Some(kind) = std::fs::metadata(source).ok().as_ref().and_then(odd_kind) {
                return Some(crate::geodata::not_a_file(source, kind).with_cause(format!("{name} names it")));
            }
            if is_remote_allowed {
                return None;
            }
            let Ok(real) = source.canonicalize() else { return missing(source, file) };
            if roots.iter().any(|root| real.starts_with(root)) {
                return None;
            }
            format!(
                "`{}` is neither in the folder of the scenario nor in that of the file",
                start_of(&source.to_string_lossy())
            )
        }
    };
    let message = format!("{name} names a file from elsewhere");
    Some(input_error("foreign-file", message).with_cause(cause).with_remedy(
        "copy that file into the folder of the scenario and make this one anew; or trust it with `limits.allow_remote: true`",
    ))
}

fn missing(source: &Path, file: &Path) -> Option<Problem> {
    let problem = readable_file(source).err()?.with_cause(format!("{} names it", file.display()));
    Some(problem.with_remedy("copy it there, or make this file anew"))
}

fn named_elsewhere(path: &Path, is_path_of_gdal: bool) -> Problem {
    let remedy = if is_path_of_gdal {
        "download or unpack it, and name the file; or trust it with `limits.allow_remote: true`"
    } else {
        "download it, and name the file; or write `/vsicurl/` before the address and set `limits.allow_remote: true`"
    };
    let message = format!("{} is no file of this machine", path.display());
    input_error("foreign-file", message)
        .with_cause("it is on a network or in an archive: it may change or vanish, and has no checksum")
        .with_remedy(remedy)
}

/// The first characters of a text, on one line.
fn start_of(text: &str) -> String {
    const LENGTH: usize = 100;
    let plain = text.split_whitespace().collect::<Vec<_>>().join(" ");
    if plain.chars().count() <= LENGTH { plain } else { plain.chars().take(LENGTH).chain("...".chars()).collect() }
}
