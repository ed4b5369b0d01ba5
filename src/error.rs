//! What can go wrong, as the user meets it: problems of the input with place, cause and remedy; failures of a run; exit codes.

use std::fmt;
use std::io::Write;
use std::path::PathBuf;

pub use floodsim_core::failure::{FailurePlace, NumericalFailure};

use crate::math::Vec2;

/// The exit codes of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum ExitCode {
    /// Done.
    Done = 0,
    /// Internal fault.
    Internal = 1,
    /// Wrong usage of the command line.
    Usage = 2,
    /// The scenario is not valid.
    Scenario = 3,
    /// Input data is missing, unreadable or unfit.
    Input = 4,
    /// A stated limit (memory, particles) would be exceeded.
    Limit = 5,
    /// The numerics broke down.
    Numerical = 6,
    /// Finished, but a quality gate failed.
    Gate = 7,
    /// Output could not be written.
    Output = 8,
    /// Stopped by SIGHUP with its results closed.
    HungUp = 129,
    /// Stopped by SIGINT with its results closed.
    Interrupted = 130,
    /// Stopped by SIGTERM with its results closed.
    Terminated = 143,
}

/// How bad a problem is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum Severity {
    /// The run goes on; the planner should know.
    Warning,
    /// The run is refused.
    Error,
}

/// Which exit code a problem leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum ProblemKind {
    /// In the scenario file itself: exit 3.
    Scenario,
    /// In the data that the scenario names: exit 4.
    Input,
    /// Over a limit: exit 5.
    Limit,
    /// With the output folder: exit 8.
    Output,
}

/// A place in a text file.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Place {
    /// The file.
    pub file: PathBuf,
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1.
    pub column: usize,
}

/// A short name of a problem.
pub type Code = &'static str;

/// One finding of the check: what is wrong, where, why, and what to do.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Problem {
    /// Error or warning.
    pub severity: Severity,
    /// Which exit code it leads to.
    pub kind: ProblemKind,
    /// A short stable name, such as `unknown-key`, by which tests and scripts know it.
    #[serde(deserialize_with = "lasting")]
    pub code: Code,
    /// Where in the scenario file.
    pub place: Option<Place>,
    /// The key path in the scenario, such as `terrain.layers[1].raster`; empty where none applies.
    pub key: String,
    /// What is wrong, in lower case, without a full stop.
    pub message: String,
    /// Why it is so, as far as it can be known.
    pub cause: Option<String>,
    /// What to do about it.
    pub remedy: Option<String>,
    /// Where on the map (map coordinates), when the problem has such a place.
    pub at: Option<Vec2>,
}

/// Writes a line to stderr. Nobody may be there to read it, or the disk behind it be full: that changes nothing.
pub fn say(line: impl fmt::Display) {
    let line = without_controls(&line.to_string()) + "\n";
    let _ = std::io::stderr().write_all(line.as_bytes());
}

/// A text without what a terminal takes for orders, as names and values of input files may have it.
pub fn without_controls(text: &str) -> String {
    text.chars().map(|c| if is_order(c) && !"\n\t".contains(c) { char::REPLACEMENT_CHARACTER } else { c }).collect()
}

/// A name as it stands in results: on one line, without what orders a terminal, a page or a table.
pub fn plain_name(text: &str) -> String {
    let plain = |c: char| match c {
        '\n' | '\r' | '\t' => ' ',
        c if is_order(c) => char::REPLACEMENT_CHARACTER,
        c => c,
    };
    text.chars().map(plain).collect()
}

/// Whether a character is an order and no letter: control characters, ends of lines and paragraphs, turns of the direction of writing.
fn is_order(c: char) -> bool {
    c.is_control() || matches!(c, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Brings problems into the order in which a planner works them off: errors first, each kind by its place in the scenario. What has none,
/// such as a value from the command line, comes before.
pub fn sort_problems(problems: &mut [Problem]) {
    problems.sort_by_key(|problem| {
        let at = problem.place.as_ref().map(|place| (place.line, place.column));
        (problem.severity == Severity::Warning, at)
    });
}

impl Problem {
    /// An error of the given kind; add the rest by the `with_` functions.
    pub fn error(kind: ProblemKind, code: &'static str, key: impl Into<String>, message: impl Into<String>) -> Self {
        Problem {
            severity: Severity::Error,
            kind,
            code,
            place: None,
            key: key.into(),
            message: message.into(),
            cause: None,
            remedy: None,
            at: None,
        }
    }

    /// A warning.
    pub fn warning(kind: ProblemKind, code: &'static str, key: impl Into<String>, message: impl Into<String>) -> Self {
        Problem { severity: Severity::Warning, ..Problem::error(kind, code, key, message) }
    }

    /// Adds the cause.
    pub fn with_cause(mut self, cause: impl Into<String>) -> Self {
        self.cause = Some(cause.into());
        self
    }

    /// Adds the remedy.
    pub fn with_remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = Some(remedy.into());
        self
    }

    /// Adds the place in the scenario file.
    pub fn with_place(mut self, place: Option<Place>) -> Self {
        self.place = place;
        self
    }

    /// Adds the place on the map.
    pub fn with_at(mut self, at: Vec2) -> Self {
        self.at = Some(at);
        self
    }
}

/// What is wrong with an input file.
pub fn input_error(code: &'static str, message: String) -> Problem {
    Problem::error(ProblemKind::Input, code, "", message)
}

/// What is doubtful about an input file.
pub fn input_warning(code: &'static str, message: String) -> Problem {
    Problem::warning(ProblemKind::Input, code, "", message)
}

/// The code of a problem that was written down. Codes are few, and last as long as the program.
fn lasting<'de, D: serde::Deserializer<'de>>(code: D) -> Result<&'static str, D::Error> {
    <String as serde::Deserialize>::deserialize(code).map(|code| &*code.leak())
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let severity = match self.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        write!(f, "{severity}[{}]", self.code)?;
        if !self.key.is_empty() {
            write!(f, " {}", self.key)?;
        }
        if let Some(place) = &self.place {
            write!(f, " ({}:{}:{})", place.file.display(), place.line, place.column)?;
        }
        write!(f, "\n  {}", self.message)?;
        if let Some(at) = self.at {
            write!(f, "\n  at      {:.1}, {:.1}", at.x, at.y)?;
        }
        if let Some(cause) = &self.cause {
            write!(f, "\n  cause   {cause}")?;
        }
        if let Some(remedy) = &self.remedy {
            write!(f, "\n  remedy  {remedy}")?;
        }
        Ok(())
    }
}

/// Any reason for which the program ends without a result, or with a doubtful one.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Wrong command line.
    #[error("{0}")]
    Usage(String),
    /// The scenario or its data were refused.
    #[error("{}", list(.0))]
    Problems(Vec<Problem>),
    /// The numerics broke down.
    #[error("{0}")]
    Numerical(#[from] NumericalFailure),
    /// A quality gate failed after the run.
    #[error("the run finished, but did not pass: {0}")]
    Gate(String),
    /// Output could not be written.
    #[error("failed to write {}: {cause}", .path.display())]
    Output {
        /// The file or folder.
        path: PathBuf,
        /// What the system or library said.
        cause: String,
    },
    /// A signal stopped the run; what was computed is closed and readable.
    #[error("stopped by signal {signal} at t = {time:.1} s; the results up to there are complete in {}", .folder.display())]
    Stopped {
        /// 1 (SIGHUP), 2 (SIGINT) or 15 (SIGTERM).
        signal: i32,
        /// Simulated time reached (s).
        time: f64,
        /// The run folder.
        folder: PathBuf,
    },
    /// A signal stopped the runs of a study.
    #[error("stopped by signal {signal}: {done} of {members} members are done in {}; the same command goes on", .folder.display())]
    StudyStopped {
        /// 1 (SIGHUP), 2 (SIGINT) or 15 (SIGTERM).
        signal: i32,
        /// Members that are done.
        done: usize,
        /// Members of the study.
        members: usize,
        /// The folder of the study.
        folder: PathBuf,
    },
    /// Members of a study failed.
    #[error("{0} of {1} members failed; `floodsim reduce` leaves them out")]
    Members(usize, usize),
    /// A fault of the program itself.
    #[error("internal fault: {0} (please report it with the scenario)")]
    Internal(String),
}

fn list(problems: &[Problem]) -> String {
    problems.iter().map(|problem| problem.to_string()).collect::<Vec<_>>().join("\n")
}

impl Error {
    /// The exit code that this error leads to.
    ///
    /// Problems of several kinds give the code of the first kind in the order scenario, input, limit, output.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Error::Usage(_) => ExitCode::Usage,
            Error::Problems(problems) => {
                let has = |kind| problems.iter().any(|p| p.severity == Severity::Error && p.kind == kind);
                if has(ProblemKind::Scenario) {
                    ExitCode::Scenario
                } else if has(ProblemKind::Input) {
                    ExitCode::Input
                } else if has(ProblemKind::Limit) {
                    ExitCode::Limit
                } else if has(ProblemKind::Output) {
                    ExitCode::Output
                } else {
                    ExitCode::Internal
                }
            }
            Error::Numerical(_) => ExitCode::Numerical,
            Error::Gate(_) | Error::Members(..) => ExitCode::Gate,
            Error::Output { .. } => ExitCode::Output,
            Error::Stopped { signal, .. } | Error::StudyStopped { signal, .. } => match signal {
                1 => ExitCode::HungUp,
                15 => ExitCode::Terminated,
                _ => ExitCode::Interrupted,
            },
            Error::Internal(_) => ExitCode::Internal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn problems_come_in_the_order_of_their_lines_errors_first() {
        let place = |line, column| Some(Place { file: "s.yaml".into(), line, column });
        let error = |code, place| Problem::error(ProblemKind::Scenario, code, "", "").with_place(place);
        let warning = |code, place| Problem::warning(ProblemKind::Scenario, code, "", "").with_place(place);
        let mut problems = [
            warning("third line", place(3, 1)),
            error("nowhere", None),
            error("second line, later", place(2, 9)),
            error("second line", place(2, 3)),
            error("second line, found after it", place(2, 3)),
            warning("first line", place(1, 1)),
        ];
        sort_problems(&mut problems);
        let codes = problems.map(|problem| problem.code);
        let errors = ["nowhere", "second line", "second line, found after it", "second line, later"];
        assert_eq!(codes[..4], errors);
        assert_eq!(codes[4..], ["first line", "third line"]);
    }
}
