//! One experiment with chosen methods at its resolutions.

use std::fmt;
use std::path::{Path, PathBuf};

use super::gauges::Run;
use super::{Experiment, Finding, scenarios};
use crate::error::{Error, Problem, Severity};
use crate::maps::GaugePanel;
use crate::pipeline::clock::processor_seconds;
use crate::pipeline::{self, RunOptions};
use crate::scenario::load;
use crate::scenario::methods::Motion;
use crate::validation::{Choice, Resolutions, Row, Status};

/// The environment variable that names the folder of the data.
pub const DATA: &str = "FLOODSIM_DATA";

/// What came out of an experiment with one choice of methods.
#[derive(Debug, Default)]
pub struct ExperimentResult {
    /// A row for each resolution.
    pub rows: Vec<Row>,
    /// Measured and computed lines: one panel for each gauge, with the lines of all resolutions.
    pub panels: Vec<GaugePanel>,
    /// Whether the acceptance limit is missed.
    pub is_missed: bool,
    /// Why it was left out, where it was.
    pub skipped: Option<Skipped>,
}

/// Why an experiment was left out, in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Skipped {
    /// Its data are not there.
    Data(String),
    /// The methods are not for it.
    Methods(String),
}

impl fmt::Display for Skipped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Skipped::Data(why) | Skipped::Methods(why) => f.write_str(why),
        }
    }
}

/// Runs an experiment; `threads` are those of each run.
///
/// # Errors
/// `Error::Output` where there is no place for the scenarios.
pub fn run_experiment(
    experiment: &Experiment,
    choice: &Choice,
    resolutions: Resolutions,
    threads: usize,
) -> Result<ExperimentResult, Error> {
    let mut result = ExperimentResult::default();
    let data = match (data_of(experiment), choice.numerics.motion) {
        (Err(why), _) => {
            result.skipped = Some(Skipped::Data(why));
            return Ok(result);
        }
        (Ok(_), Motion::Lagrangian) if !experiment.rests_because.is_empty() => {
            let why = format!("it is for Eulerian particles: {}", experiment.rests_because);
            result.skipped = Some(Skipped::Methods(why));
            return Ok(result);
        }
        (Ok(data), _) => data,
    };
    let number = match resolutions {
        Resolutions::Test => 1,
        Resolutions::Full => experiment.resolutions.len(),
    };
    let place = std::env::temp_dir().join(format!("floodsim-{}-{}", experiment.name, std::process::id()));
    let (folder, scenarios) = (place.join("run"), place.join("scenarios"));
    scenarios::write_all(&scenarios)?;
    for (k, &spacing) in experiment.resolutions[..number].iter().enumerate() {
        let overrides: Vec<String> = std::iter::once(format!("resolution={spacing} m"))
            .chain(rests_alone(choice))
            .chain(choice.given.iter().map(|(family, member)| format!("numerics.{family}={member}")))
            .collect();
        let options = RunOptions {
            out: Some(folder.clone()),
            threads: Some(threads),
            overwrite: true,
            quiet: true,
            command: format!("floodsim validate {}", experiment.name),
            overrides: Vec::new(),
        };
        let one = One { experiment, choice, is_finest: k + 1 == experiment.resolutions.len() };
        let (scenarios, data) = (scenarios.clone(), data.clone());
        let run = Run { folder: folder.clone(), scenarios, data, spacing, overrides };
        let row = one.run(&run, &options, &mut result);
        result.is_missed |= one.is_finest && matches!(row.status, Status::FallShort);
        result.is_missed |= row.status == Status::Fails;
        result.rows.push(row);
    }
    // What cannot be removed stays in the folder of the system for such files.
    let _ = std::fs::remove_dir_all(&place);
    Ok(result)
}

/// The folder of the measurements of an experiment, empty where it needs no data; why it is left out where data are missing.
fn data_of(experiment: &Experiment) -> Result<PathBuf, String> {
    let Some(measurements) = experiment.data.first() else { return Ok(PathBuf::new()) };
    let root = std::env::var_os(DATA).ok_or_else(|| format!("{DATA} does not name the folder of the data"))?;
    match experiment.data.iter().find(|folder| !Path::new(&root).join(folder).is_dir()) {
        Some(missing) => Err(format!("{DATA} holds no folder `{missing}`")),
        None => Ok(Path::new(&root).join(measurements)),
    }
}

/// What a scenario may ask for and particles that move do not have.
fn rests_alone(choice: &Choice) -> Option<String> {
    (choice.numerics.motion == Motion::Lagrangian).then(|| "numerics.turbulence=none".to_owned())
}

/// A run among those of its experiment.
struct One<'a> {
    experiment: &'a Experiment,
    choice: &'a Choice,
    is_finest: bool,
}

impl One<'_> {
    fn run(&self, run: &Run, options: &RunOptions, result: &mut ExperimentResult) -> Row {
        let before = processor_seconds();
        let scenario = run.scenarios.join(self.experiment.scenario);
        let ended = load(&scenario, &run.overrides).and_then(|loaded| pipeline::run(&loaded.scenario, options));
        let mut row = self.empty_row(run.spacing, processor_seconds() - before);
        let summary = match ended {
            Ok(summary) => summary,
            Err(error) => {
                (row.status, row.note) = (Status::Fails, in_one_line(&error));
                return row;
            }
        };
        row.particles = summary.manifest.particles.peak;
        row.particle_evaluations = summary.manifest.particle_evaluations;
        row.max_speed_m_s = summary.manifest.max_speed_m_s;
        match (self.experiment.judge)(run) {
            Ok(finding) => self.fill(&mut row, finding, result),
            Err(cause) => (row.status, row.note) = (Status::Fails, cause),
        }
        row
    }

    /// The figures of a finding into its row, its lines into the panels.
    fn fill(&self, row: &mut Row, finding: Finding, result: &mut ExperimentResult) {
        row.norm = finding.norm.to_owned();
        row.error_depth = finding.error;
        row.note = self.choice.without_column().chain([finding.note]).collect::<Vec<_>>().join("; ");
        row.status = match finding.is_met {
            Some(true) => Status::Pass,
            Some(false) => Status::FallShort,
            None => Status::Holds,
        };
        if result.panels.is_empty() {
            result.panels = finding.panels;
        } else {
            for (panel, more) in result.panels.iter_mut().zip(finding.panels) {
                panel.computed.extend(more.computed);
            }
        }
    }

    fn empty_row(&self, spacing: f64, cpu_s: f64) -> Row {
        let acceptance_limit = match (self.experiment.acceptance_limit, self.is_finest) {
            ("", _) => String::new(),
            (acceptance_limit, true) => acceptance_limit.to_owned(),
            (acceptance_limit, false) => format!("{acceptance_limit} (of the finer resolution)"),
        };
        let of = (self.experiment.suite.name(), self.experiment.name);
        Row { cpu_s, acceptance_limit, ..Row::new(of, &self.choice.numerics, spacing) }
    }
}

/// An error as a note: of several problems the first error.
fn in_one_line(error: &Error) -> String {
    let first =
        |problems: &[Problem]| problems.iter().find(|p| p.severity == Severity::Error).map(|p| p.message.clone());
    match error {
        Error::Problems(problems) => first(problems).unwrap_or_default(),
        other => other.to_string().lines().next().unwrap_or_default().to_owned(),
    }
}
