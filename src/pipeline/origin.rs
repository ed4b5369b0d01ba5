//! Which run it is that a checkpoint is of.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::RunOptions;
use crate::checksum;
use crate::error::Problem;
use crate::output::{ChoiceRecord, InputFile};
use crate::plain_file;
use crate::scenario::Scenario;
use crate::version;

/// Which run a checkpoint is of.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Origin {
    /// Version and commit of the program.
    pub program: String,
    /// The command line, and the folder in which it was given.
    pub command: String,
    pub working_folder: PathBuf,
    /// The scenario file, what stood in it, and what was set beside it.
    pub scenario: PathBuf,
    pub text: String,
    pub overrides: Vec<String>,
    pub scenario_sha256: String,
    pub inputs: Vec<InputFile>,
    /// How the lengths were chosen, where the program chose them, and its warnings.
    pub choice: Option<ChoiceRecord>,
    pub warnings: Vec<Problem>,
    /// Simulated time (s).
    pub simulated_s: f64,
}

impl Origin {
    /// That of a run at its start.
    pub fn new(
        scenario: &Scenario,
        options: &RunOptions,
        inputs: &[crate::prepare::InputFile],
        (choice, warnings): (&Option<ChoiceRecord>, &[Problem]),
    ) -> Self {
        let input = |file: &crate::prepare::InputFile| InputFile {
            path: file.path.display().to_string(),
            sha256: file.sha256.clone(),
        };
        Origin {
            program: version::with_commit(),
            command: options.command.clone(),
            working_folder: std::env::current_dir().unwrap_or_default(),
            scenario: scenario.file.clone(),
            text: plain_file::read_to_string(&scenario.file).unwrap_or_default(),
            overrides: options.overrides.clone(),
            scenario_sha256: checksum::of_file(&scenario.file).map_or_else(|_| String::new(), |(_, sha256)| sha256),
            inputs: inputs.iter().map(input).collect(),
            choice: choice.clone(),
            warnings: warnings.to_vec(),
            simulated_s: 0.0,
        }
    }
}
