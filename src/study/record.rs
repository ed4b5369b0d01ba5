//! `study.json`: what a study varies, and its members. It is all that stands between the study file and what is made of its runs.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::error::{Error, Problem, ProblemKind, plain_name};
use crate::plain_file;

/// What varies, in words.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VariableRecord {
    /// Its key in the scenario.
    pub key: String,
    /// Its name in tables.
    pub name: String,
    /// Its values or their distribution.
    pub spread: String,
}

/// One run of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MemberRecord {
    /// Its number, from 1.
    pub number: usize,
    /// The number of its values: members of the same case differ by their variant alone.
    pub case: usize,
    /// Its variant; empty where there is one alone.
    pub variant: String,
    /// What each variable is in it; none where its variant decides on it.
    pub values: Vec<Option<String>>,
}

/// A study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StudyRecord {
    /// Title.
    pub title: String,
    /// The scenario that varies.
    pub base: PathBuf,
    /// How values were drawn; empty where none were.
    pub sampling: String,
    /// Depths (m) whose exceedance is mapped.
    pub depths: Vec<f64>,
    /// What varies.
    pub variables: Vec<VariableRecord>,
    /// Names of the variants; one empty name where there is one alone.
    pub variants: Vec<String>,
    /// The runs.
    pub members: Vec<MemberRecord>,
}

/// Whether a text can be the name of a variant, which becomes that of a folder: of letters, digits, `_` and `-`.
pub fn is_folder_name(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c))
}

/// A folder of a study that is a link, through which files elsewhere would be written.
pub fn linked(folder: &Path) -> Option<Problem> {
    let name = ["scenarios", "runs", "logs", "reduced"].into_iter().find(|name| folder.join(name).is_symlink())?;
    let message = format!("the folder {} of the study cannot be written", folder.join(name).display());
    let problem = Problem::error(ProblemKind::Output, "output-folder-unwritable", "folder", message);
    Some(
        problem
            .with_cause("it is a link that leads elsewhere")
            .with_remedy("choose another `folder`, or remove the link"),
    )
}

/// The scenario of a member, in the folder of its study.
pub fn scenario_of(folder: &Path, member: usize) -> PathBuf {
    folder.join(format!("scenarios/{member:04}.yaml"))
}

/// The run folder of a member, in the folder of its study.
pub fn run_of(folder: &Path, member: usize) -> PathBuf {
    folder.join(format!("runs/{member:04}"))
}

impl StudyRecord {
    /// Name of its file.
    pub const FILE: &str = "study.json";

    /// Reads the record of a study folder.
    ///
    /// # Errors
    /// `no-study` where there is none, or none that can be read.
    pub fn open(folder: &Path) -> Result<StudyRecord, Error> {
        let read = || -> Result<StudyRecord, String> {
            let text = plain_file::read_to_string(folder.join(StudyRecord::FILE)).map_err(|cause| cause.to_string())?;
            let record: StudyRecord = serde_json::from_str(&text).map_err(|cause| cause.to_string())?;
            match record.variants.iter().find(|name| !is_folder_name(name)) {
                Some(name) if record.variants.len() > 1 || !name.is_empty() => {
                    Err(format!("`{}` is no name of a variant", plain_name(name)))
                }
                _ => Ok(record),
            }
        };
        read().map_err(|cause| {
            let message = format!("{} is not the folder of a study", folder.display());
            let problem = Problem::error(ProblemKind::Input, "no-study", "", message);
            let remedy = "name a folder that `floodsim matrix STUDY.yaml` made, which holds study.json";
            Error::Problems(vec![problem.with_cause(cause).with_remedy(remedy)])
        })
    }
}
