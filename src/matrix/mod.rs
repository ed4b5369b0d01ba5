//! Many runs of one scenario: from a study file to a folder of scenarios, and their runs.
//!
//! A member of a study is a scenario of its own, which runs alone as any other. Members run as processes of this program, here or wherever the
//! user starts them; there is no queue but that of one call. What they say together: `study`.

mod design;
mod file;
mod folder;
mod members;
mod spread;
#[cfg(test)]
mod tests;
mod work;

use std::collections::BTreeSet;
use std::fmt;
use std::path::{Path, PathBuf};
use std::thread::available_parallelism;

use crate::error::{Error, Problem, ProblemKind};
use crate::study::{State, StudyRecord, program_of, state};
use crate::version;
use file::Study;
use work::{Ended, Work};

/// What is done with a study.
#[derive(Clone, Debug, Default)]
pub struct MatrixOptions {
    /// So many members at once; one on each core when absent.
    pub jobs: Option<usize>,
    /// Threads of each; the cores over `jobs` when absent.
    pub threads: Option<usize>,
    /// The members that are run; all when empty. The folder stays as it is but for these.
    pub only: Vec<usize>,
    /// Whether nothing is run.
    pub is_written_only: bool,
    /// Whether members that failed run again.
    pub retry: bool,
    /// Whether scenarios that differ from those of an earlier call replace them.
    pub overwrite: bool,
    /// Whether progress stays silent.
    pub quiet: bool,
}

/// What became of a study.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MatrixSummary {
    /// The folder of the study.
    pub folder: PathBuf,
    /// How many members it has.
    pub members: usize,
    /// How many are done.
    pub done: usize,
    /// Members that failed, and why.
    pub failed: Vec<(usize, String)>,
}

impl fmt::Display for MatrixSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {} members, {} done", self.folder.display(), self.members, self.done)?;
        self.failed.iter().try_for_each(|(member, why)| writeln!(f, "  member {member} failed: {why}"))
    }
}

/// The folder of a study, which is given itself or by its file.
///
/// # Errors
/// With all problems of the file.
pub fn folder_of_study(path: &Path) -> Result<PathBuf, Error> {
    if path.is_dir() {
        Ok(std::path::absolute(path).unwrap_or_else(|_| path.to_owned()))
    } else {
        Ok(Study::read(path)?.folder)
    }
}

/// Writes the scenarios of a study, and runs those that are not done.
///
/// # Errors
/// With all problems of the study and its members; [`Error::StudyStopped`] after a signal. Members that fail are part of the summary.
pub fn matrix(path: &Path, options: &MatrixOptions) -> Result<MatrixSummary, Error> {
    let (folder, record, _held) = if path.is_dir() || !options.only.is_empty() {
        let folder = folder_of_study(path)?;
        let record = StudyRecord::open(&folder)?;
        (folder, record, None)
    } else {
        let study = Study::read(path)?;
        let (record, members) = members::members(&study)?;
        let held = folder::lay_out(&study.folder, &record, &members, options.overwrite)?;
        (study.folder, record, Some(held))
    };
    let members = record.members.len();
    if let Some(other) = options.only.iter().find(|member| !(1..=members).contains(*member)) {
        return Err(Error::Usage(format!("--only {other}: the study has the members 1 to {members}")));
    }
    // Of a few members that are asked for, these alone count.
    let all: Vec<usize> = if options.only.is_empty() { (1..=members).collect() } else { options.only.clone() };
    let all: Vec<usize> = all.into_iter().collect::<BTreeSet<usize>>().into_iter().collect();
    let members = all.len();
    let is_done = |member: &usize| state(&folder, *member) == State::Done;
    let (finished, rest): (Vec<usize>, Vec<usize>) = all.into_iter().partition(is_done);
    let other = |member: &&usize| program_of(&folder, **member) != version::with_commit();
    let again: Vec<usize> = finished.iter().filter(other).copied().collect();
    if let Some(member) = again.first().filter(|_| !options.overwrite) {
        return Err(run_by_another(&folder, *member));
    }
    let (finished, rest) = (finished.len() - again.len(), [&again[..], &rest[..]].concat());
    if options.is_written_only {
        return Ok(MatrixSummary { folder, members, done: finished, failed: Vec::new() });
    }
    let cores = available_parallelism().map_or(1, std::num::NonZero::get);
    let jobs = options.jobs.unwrap_or(cores).min(rest.len().max(1));
    let threads = options.threads.unwrap_or((cores / jobs).max(1));
    let work =
        Work { study: &folder, members, jobs, threads, retry: options.retry, again: &again, quiet: options.quiet };
    let ended = work.run(rest, finished)?;
    let failed = |Ended { member, failure }: &Ended| failure.clone().map(|why| (*member, why));
    let done = finished + ended.iter().filter(|one| one.failure.is_none()).count();
    Ok(MatrixSummary { members, done, failed: ended.iter().filter_map(failed).collect(), folder })
}

/// That another program ran a member.
fn run_by_another(folder: &Path, member: usize) -> Error {
    let message = format!("members of the study in {} were run by another program", folder.display());
    let cause =
        format!("member {member} by floodsim {}, and this is {}", program_of(folder, member), version::with_commit());
    let problem = Problem::error(ProblemKind::Output, "study-changed", "folder", message).with_cause(cause);
    let remedy = "go on with that program, choose another `folder`, or add --overwrite to run these members again";
    Error::Problems(vec![problem.with_remedy(remedy)])
}
