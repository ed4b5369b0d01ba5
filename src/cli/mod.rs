//! The command line: `floodsim scenario.yaml` and its companions.
//!
//! stdout carries results, stderr progress and errors; there are no colours and no questions.

mod args;
mod breach;
mod chart;
mod check;
mod documents;
mod explain;
mod plan;
mod reference;
mod validate;

use std::io::Write;

use clap::Parser;
use clap::error::ErrorKind;

use crate::error::{Error, ExitCode, Problem, say, without_controls};
use crate::matrix::{MatrixOptions, folder_of_study, matrix};
use crate::pipeline::{Plan, PlanOptions, ResumeOptions, RunOptions};
use crate::scenario::{self, Scenario};
use args::{Arguments, Command, CompareArguments, MatrixArguments, ResumeArguments, RunArguments};

/// The stages that the command line calls, given by `main` so that this module knows none of them.
pub struct Stages {
    /// Opens every input of a scenario and lists every problem.
    pub prepare: fn(&Scenario) -> Vec<Problem>,
    /// Finds out what a run will need.
    pub plan: fn(&Scenario, &PlanOptions) -> Result<Plan, Error>,
    /// Does a whole run; the text is its summary for stdout.
    pub run: fn(&Scenario, &RunOptions) -> Result<String, Error>,
    /// Goes on with a run that was cut off, or writes its results so far.
    pub resume: fn(&ResumeOptions) -> Result<String, Error>,
}

/// Reads the command line, does what it says, and reports errors on stderr.
pub fn main(stages: &Stages) -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // Help and version are results and go to stdout; clap knows which is which. A closed pipe is no fault.
            let _ = error.print();
            let is_help = matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion);
            return if is_help { ExitCode::Done } else { ExitCode::Usage };
        }
    };
    let result = match arguments.command {
        Some(Command::Run(run)) => run_scenario(&run, stages),
        Some(Command::Check(check)) => return check::check(&check, stages),
        Some(Command::Plan(plan)) => return plan::plan(&plan, stages),
        Some(Command::Resume(resume)) => resume_run(&resume, stages),
        Some(Command::Verify { folder }) => verify_folder(&folder),
        Some(Command::Compare(compare)) => compare_runs(&compare),
        Some(Command::Matrix(matrix)) => run_matrix(&matrix),
        Some(Command::Reduce { study, json }) => reduce_study(&study, json),
        Some(Command::Report { folder }) => report_folder(&folder, stages),
        Some(Command::Validate(arguments)) => validate::validate(&arguments),
        Some(Command::Chart(arguments)) => chart::chart(&arguments),
        Some(Command::Breach(arguments)) => breach::breach(&arguments),
        Some(Command::Explain(arguments)) => explain::explain(&arguments),
        Some(Command::New { file }) => documents::write_starter(&file),
        Some(Command::Schema { markdown }) => documents::schema(markdown),
        Some(Command::Completions { shell }) => documents::completions(shell),
        Some(Command::Man) => documents::manual(),
        None => match arguments.run {
            Some(run) => run_scenario(&run, stages),
            None => Err(Error::Usage("name a scenario; `floodsim --help` says more".to_owned())),
        },
    };
    exit_code(result)
}

fn exit_code(result: Result<(), Error>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::Done,
        Err(error) => {
            report(&error);
            error.exit_code()
        }
    }
}

/// Writes an error to stderr; problems carry their own `error` in front.
fn report(error: &Error) {
    match error {
        Error::Problems(_) => say(error),
        _ => say(format!("error: {error}")),
    }
}

fn run_scenario(run: &RunArguments, stages: &Stages) -> Result<(), Error> {
    let loaded = scenario::load(&run.scenario, &run.overrides)?;
    for warning in &loaded.warnings {
        say(warning);
    }
    let options = RunOptions {
        out: run.out.clone(),
        threads: run.threads.map(std::num::NonZero::get),
        overwrite: run.overwrite,
        quiet: run.quiet,
        command: command_line(),
        overrides: run.overrides.clone(),
    };
    tell(&(stages.run)(&loaded.scenario, &options)?);
    Ok(())
}

fn resume_run(resume: &ResumeArguments, stages: &Stages) -> Result<(), Error> {
    let summary = (stages.resume)(&ResumeOptions {
        folder: resume.folder.clone(),
        threads: resume.threads.map(std::num::NonZero::get),
        overrides: resume.overrides.clone(),
        quiet: resume.quiet,
        is_for_outputs: false,
    })?;
    tell(&summary);
    Ok(())
}

/// Compares what a run read and wrote with its checksums.
fn verify_folder(folder: &std::path::Path) -> Result<(), Error> {
    let verified = crate::output::verify(folder)?;
    if !verified.problems.is_empty() {
        return Err(Error::Problems(verified.problems));
    }
    tell(&format!("{} files are as the run read and wrote them\n", verified.same));
    Ok(())
}

/// Shows what differs between two runs, and writes maps of it where they are asked for.
fn compare_runs(arguments: &CompareArguments) -> Result<(), Error> {
    let comparison = crate::study::compare([&arguments.first, &arguments.second])?;
    if let Some(folder) = &arguments.out {
        comparison.write(folder, arguments.overwrite, &command_line())?;
    }
    if arguments.json { print(&comparison.json()) } else { print(&comparison.to_string()) }
}

/// Writes the scenarios of a study and runs its members; exit code 7 where some fail.
fn run_matrix(arguments: &MatrixArguments) -> Result<(), Error> {
    let summary = matrix(
        &arguments.study,
        &MatrixOptions {
            jobs: arguments.jobs.map(std::num::NonZero::get),
            threads: arguments.threads.map(std::num::NonZero::get),
            only: arguments.only.clone(),
            is_written_only: arguments.write_only,
            retry: arguments.retry,
            overwrite: arguments.overwrite,
            quiet: arguments.quiet,
        },
    )?;
    tell(&summary.to_string());
    if summary.failed.is_empty() { Ok(()) } else { Err(Error::Members(summary.failed.len(), summary.members)) }
}

/// Shows what the runs of a study say together.
fn reduce_study(study: &std::path::Path, as_json: bool) -> Result<(), Error> {
    let reduction = crate::study::reduce(&folder_of_study(study)?, &command_line())?;
    tell(&if as_json { reduction.json() } else { reduction.to_string() });
    Ok(())
}

/// Draws the report of a run folder and lists its files; of a run that was cut off the results so far are written before.
fn report_folder(folder: &std::path::Path, stages: &Stages) -> Result<(), Error> {
    if crate::output::is_cut_off(folder) {
        let folder = folder.to_path_buf();
        (stages.resume)(&ResumeOptions {
            folder,
            threads: None,
            overrides: Vec::new(),
            quiet: true,
            is_for_outputs: true,
        })?;
    }
    let report = crate::report::report(folder)?;
    if let Some(doubt) = report.doubt {
        say(format!("warning: {doubt}"));
    }
    tell(&report.files.iter().map(|file| format!("{}\n", file.display())).collect::<String>());
    Ok(())
}

/// The command line as it could be typed again.
fn command_line() -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
    let word = |word: std::ffi::OsString| {
        let word = word.to_string_lossy().into_owned();
        if !word.is_empty() && word.chars().all(is_plain) { word } else { format!("'{}'", word.replace('\'', r"'\''")) }
    };
    // The path by which the shell found the program is of no interest.
    std::iter::once("floodsim".to_owned()).chain(std::env::args_os().skip(1).map(word)).collect::<Vec<_>>().join(" ")
}

/// Writes to stdout what is a result beside others: that it can't be written changes no exit code.
fn tell(text: &str) {
    if let Err(error) = print(text) {
        report(&error);
    }
}

/// Writes a result to stdout. A reader that has heard enough (`floodsim man | head`) is no fault.
fn print(text: &str) -> Result<(), Error> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(without_controls(text).as_bytes()).and_then(|()| stdout.flush()) {
        Err(cause) if cause.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::Output { path: "standard output".into(), cause: cause.to_string() })
        }
        _ => Ok(()),
    }
}
