//! One experiment with chosen methods at its resolutions.

use std::path::{Path, PathBuf};

use super::gauges::Run;
use super::{Experiment, Finding};
use crate::error::{Error, Problem, Severity};
use crate::maps::GaugePanel;
use crate::pipeline::clock::processor_seconds;
use crate::pipeline::{self, RunOptions};
use crate::scenario::load;
use crate::scenario::methods::Motion;
use crate::validation::{Choice, Resolutions, Row, Status};

/// Where the scenarios lie, seen from the folder of the source code.
pub(super) const SCENARIOS: &str = "scenarios";
/// The environment variable that names the folder of the data.
const DATA: &str = "FLOODSIM_DATA";

/// What came out of an experiment with one choice of methods.
#[derive(Debug, Default)]
pub struct ExperimentResult {
    /// A row for each resolution.
    pub rows: Vec<Row>,
    /// Measured and computed lines: one panel for each gauge, with the lines of all resolutions.
    pub panels: Vec<GaugePanel>,
    /// Whether the bar is missed.
    pub is_missed: bool,
    /// Why it was left out, where it was.
    pub skipped: Option<String>,
}

/// Runs an experiment; `threads` are those of each run.
///
/// # Errors
/// `Error::Internal` where there is no place for the run folders.
pub fn run_experiment(
    experiment: &Experiment,
    choice: &Choice,
    resolutions: Resolutions,
    threads: usize,
) -> Result<ExperimentResult, Error> {
    let mut result = ExperimentResult::default();
    let scenario = Path::new(SCENARIOS).join(experiment.scenario);
    // What needs no measurements has all that it needs beside its scenario.
    let data = match experiment.data {
        "" => Some(Path::new(SCENARIOS).to_owned()),
        folder => std::env::var_os(DATA).map(|data| Path::new(&data).join(folder)),
    };
    result.skipped = match &data {
        None => Some(format!("{DATA} does not name the folder of the data")),
        Some(folder) if !folder.is_dir() => Some(format!("{DATA} holds no folder `{}`", experiment.data)),
        _ if !scenario.is_file() => {
            Some(format!("{} is not here: run it from the folder of the source", scenario.display()))
        }
        _ if choice.numerics.motion == Motion::Lagrangian && !experiment.can_move => Some(
            "it is for resting particles: what moving ones make of its boundaries, sources or sections has no bar yet"
                .to_owned(),
        ),
        _ => None,
    };
    let (None, Some(data)) = (&result.skipped, data) else { return Ok(result) };
    let number = match resolutions {
        Resolutions::Test => 1,
        Resolutions::Full => experiment.resolutions.len(),
    };
    let folder = std::env::temp_dir().join(format!("floodsim-{}-{}", experiment.name, std::process::id()));
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
        };
        let place = Place { experiment, choice, spacing, is_finest: k + 1 == experiment.resolutions.len() };
        let row = place.run(&scenario, &overrides, &options, (&folder, &data), &mut result);
        result.is_missed |= place.is_finest && matches!(row.status, Status::FallShort);
        result.is_missed |= row.status == Status::Fails;
        result.rows.push(row);
    }
    // What cannot be removed stays in the folder of the system for such files.
    let _ = std::fs::remove_dir_all(&folder);
    Ok(result)
}

/// What a scenario may ask for and moving particles do not have.
fn rests_alone(choice: &Choice) -> Option<String> {
    (choice.numerics.motion == Motion::Lagrangian).then(|| "numerics.turbulence=none".to_owned())
}

/// A run among those of its experiment.
struct Place<'a> {
    experiment: &'a Experiment,
    choice: &'a Choice,
    spacing: f64,
    is_finest: bool,
}

impl Place<'_> {
    fn run(
        &self,
        scenario: &Path,
        overrides: &[String],
        options: &RunOptions,
        (folder, data): (&PathBuf, &PathBuf),
        result: &mut ExperimentResult,
    ) -> Row {
        let before = processor_seconds();
        let ended = load(scenario, overrides).and_then(|loaded| pipeline::run(&loaded.scenario, options));
        let mut row = self.empty_row(processor_seconds() - before);
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
        let run =
            Run { folder: folder.clone(), data: data.clone(), spacing: self.spacing, overrides: overrides.to_vec() };
        match (self.experiment.judge)(&run) {
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

    fn empty_row(&self, cpu_s: f64) -> Row {
        let bar = match (self.experiment.bar, self.is_finest) {
            ("", _) => String::new(),
            (bar, true) => bar.to_owned(),
            (bar, false) => format!("{bar} (of the finer resolution)"),
        };
        let of = (self.experiment.suite.name(), self.experiment.name);
        Row { cpu_s, bar, ..Row::new(of, &self.choice.numerics, self.spacing) }
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
