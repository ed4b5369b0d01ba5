//! A run that was cut off goes on from its checkpoint, or its results so far are written.

use std::path::{Path, PathBuf};

use super::checkpoints::{State, keep_origin};
use super::origin::Origin;
use super::{RunOptions, RunSummary, run_on_threads, thread_pool};
use crate::error::{Error, Problem, ProblemKind};
use crate::output::{Checkpoint, RunFolder};
use crate::prepare::InputFile;
use crate::scenario;
use crate::version;

/// What a planner asks of a run that goes on.
#[derive(Clone, Debug, PartialEq)]
pub struct ResumeOptions {
    /// The run folder.
    pub folder: PathBuf,
    /// Number of threads; all of the machine when absent.
    pub threads: Option<usize>,
    /// Limits that are others from now on, as `key=value`.
    pub overrides: Vec<String>,
    /// Whether progress stays silent.
    pub quiet: bool,
    /// Whether no step is taken: what was computed is written, and that is all.
    pub is_for_outputs: bool,
}

/// A run that begins or goes on.
pub(super) struct Resumed {
    pub folder: RunFolder,
    pub origin: Origin,
    /// None where it was cut off before its first checkpoint.
    pub state: Option<State>,
    pub is_for_outputs: bool,
}

impl Resumed {
    /// A run that begins; from now on it can be begun again from its folder.
    pub fn at_start(folder: RunFolder, (origin, is_kept): (Origin, bool)) -> Result<Self, Error> {
        if is_kept {
            keep_origin(&folder, &origin)?;
        }
        Ok(Resumed { folder, origin, state: None, is_for_outputs: false })
    }
}

/// Goes on with the run of a folder, to the same bytes as if it had never been cut off.
///
/// # Errors
/// Those of a run; `no-checkpoint`, `checkpoint-of-another-program` and `inputs-changed` where it can't go on.
pub fn resume(options: &ResumeOptions) -> Result<RunSummary, Error> {
    let refused = |problem: Problem| Error::Problems(vec![problem]);
    if let Some(other) = options.overrides.iter().find(|key| !key.starts_with("limits.")) {
        return Err(Error::Usage(format!(
            "--set {other}: a run goes on as it began; limits alone may be set, such as limits.memory='8 GB'"
        )));
    }
    let folder = std::path::absolute(&options.folder).unwrap_or_else(|_| options.folder.clone());
    if !folder.is_dir() {
        let message = format!("there is no folder {}", options.folder.display());
        return Err(refused(Problem::error(ProblemKind::Input, "no-checkpoint", "", message)));
    }
    let held = RunFolder::reopen(&folder)?;
    let found = Checkpoint::<Origin>::find(&folder).map_err(refused)?;
    let origin = found.run.clone();
    if origin.program != version::with_commit() {
        return Err(refused(another_program(&origin)));
    }
    std::env::set_current_dir(&origin.working_folder).map_err(|cause| {
        let message = format!("the folder {} in which the run was started", origin.working_folder.display());
        refused(Problem::error(ProblemKind::Input, "inputs-changed", "", message).with_cause(cause.to_string()))
    })?;
    let overrides = [&origin.overrides[..], &options.overrides[..]].concat();
    let loaded = scenario::resolve(&origin.text, &origin.scenario, &overrides)?;
    let run_options = RunOptions {
        out: Some(folder),
        threads: options.threads,
        overwrite: true,
        quiet: options.quiet,
        command: origin.command.clone(),
        overrides: origin.overrides.clone(),
    };
    thread_pool(options.threads)?.install(|| {
        let mut state: Option<State> = found.into_state()?;
        if state.is_none() && options.is_for_outputs {
            return Err(refused(before_the_first(&options.folder)));
        }
        if let Some(state) = state.as_mut().filter(|_| !options.is_for_outputs) {
            state.before.resumed_at_s.push(origin.simulated_s);
        }
        let resumed = Resumed { folder: held, origin, state, is_for_outputs: options.is_for_outputs };
        run_on_threads(&loaded.scenario, &run_options, Some(resumed))
    })
}

fn before_the_first(folder: &Path) -> Problem {
    let message = format!("the run in {} was cut off before its first checkpoint", folder.display());
    Problem::error(ProblemKind::Input, "no-checkpoint", "", message)
        .with_remedy("`floodsim resume` begins it again; its frames can be read in fields.partial.nc")
}

/// That another program began a run.
fn another_program(origin: &Origin) -> Problem {
    let message = format!("the run was begun by floodsim {}, and this is {}", origin.program, version::with_commit());
    Problem::error(ProblemKind::Input, "checkpoint-of-another-program", "", message)
        .with_cause("another version may compute otherwise, and half of the maps would be of each")
        .with_remedy("go on with the program that began it, or run the scenario again with --overwrite")
}

/// What of the inputs is not as it was at the start of the run.
pub(super) fn changed(origin: &Origin, inputs: &[InputFile]) -> Option<Problem> {
    let name = |path: &Path| path.display().to_string();
    let was = |path: &str| origin.inputs.iter().find(|input| input.path == path);
    let differs = |input: &&InputFile| was(&name(&input.path)).is_none_or(|was| was.sha256 != input.sha256);
    let mut differing: Vec<String> = inputs.iter().filter(differs).map(|input| name(&input.path)).collect();
    let is_there = |path: &str| inputs.iter().any(|input| name(&input.path) == path);
    differing.extend(origin.inputs.iter().filter(|input| !is_there(&input.path)).map(|input| input.path.clone()));
    (!differing.is_empty()).then(|| {
        let message = format!("inputs have changed since the run began: {}", differing.join(", "));
        Problem::error(ProblemKind::Input, "inputs-changed", "", message)
            .with_cause("the rest of the run would be of another scene than its beginning")
            .with_remedy("bring these files back as they were, or run the scenario again with --overwrite")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::write_checkpoint;

    #[test]
    fn a_run_of_another_program_is_refused() {
        let place = tempfile::tempdir().unwrap();
        let folder = RunFolder::create(place.path(), false).unwrap();
        let origin = Origin {
            program: "0.0.1 (a commit)".into(),
            command: String::new(),
            working_folder: place.path().into(),
            scenario: "s.yaml".into(),
            text: String::new(),
            overrides: Vec::new(),
            scenario_sha256: String::new(),
            inputs: Vec::new(),
            choice: None,
            warnings: vec![Problem::warning(ProblemKind::Input, "left-out", "walls", "one is left out")],
            simulated_s: 0.0,
        };
        write_checkpoint(&folder, &origin, &None::<u8>).unwrap();
        drop(folder);
        let found = Checkpoint::<Origin>::find(place.path()).unwrap();
        assert_eq!(found.run.warnings, origin.warnings);
        let options = ResumeOptions {
            folder: place.path().into(),
            threads: None,
            overrides: Vec::new(),
            quiet: true,
            is_for_outputs: false,
        };
        let Err(Error::Problems(problems)) = resume(&options) else { panic!("the run goes on") };
        assert_eq!(problems[0].code, "checkpoint-of-another-program");
        assert!(problems[0].message.contains("0.0.1 (a commit)"), "{}", problems[0]);
    }
}
