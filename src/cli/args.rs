//! The arguments of the command line.

use std::num::NonZero;
use std::path::PathBuf;
use std::sync::LazyLock;

use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;

use crate::scenario::methods::Preset;
use crate::scenario::units::{Dimension, LENGTH, VOLUME};

const EXIT_CODES: &str = "\
Exit codes:
    0  done
    1  internal fault
    2  wrong usage
    3  scenario not valid
    4  input data missing, unreadable or unfit
    5  a stated limit (memory, particles) would be exceeded
    6  numerical failure
    7  finished, but a quality gate failed
    8  output could not be written
  129  stopped by SIGHUP, with the results so far closed; under nohup a run goes on
  130  stopped by SIGINT, with the results so far closed
  143  stopped by SIGTERM, with the results so far closed

stdout carries results, stderr progress and errors.";

/// Inundation maps from terrain rasters and reservoir polygons.
#[derive(Debug, Parser)]
#[command(name = "floodsim", version = version(), after_help = EXIT_CODES, color = clap::ColorChoice::Never)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true, arg_required_else_help = true)]
pub struct Arguments {
    /// What to do; a scenario alone is run.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// The arguments of a run.
    #[command(flatten)]
    pub run: Option<RunArguments>,
}

fn version() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(crate::version::with_commit);
    &TEXT
}

/// The presets with what they are for and what they lose, from the registry.
fn presets() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(|| {
        let line = |preset: &Preset| format!("\n    {:<9} {}", preset.name(), preset.summary());
        format!("Presets (--set numerics.preset=NAME):{}", Preset::ALL.iter().map(line).collect::<String>())
    });
    &TEXT
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a scenario and write its maps (the same as `floodsim SCENARIO`)
    #[command(after_help = presets())]
    Run(RunArguments),
    /// Open every input of a scenario and report every problem at once; write nothing
    Check(CheckArguments),
    /// Explain codes of problems, such as `no-crs`: severity, meaning, remedy; without a code, list all
    Explain(ExplainArguments),
    /// Take the first steps for a second or two and tell what the run will need: particles, memory, steps, time, disk, resolution, motion
    Plan(PlanArguments),
    /// Go on with a run that was cut off (killed, stopped, out of disk) from its last checkpoint, to the same results
    Resume(ResumeArguments),
    /// Compare the results in a run folder, and the inputs of the run, with the checksums in its run.json
    Verify {
        /// The run folder
        folder: PathBuf,
    },
    /// Show what differs between two runs: keys of the scenario, inputs, flooded area, maps, gauges, cross-sections
    Compare(CompareArguments),
    /// Run one scenario with many values: write a scenario for each, and run those that are not done
    Matrix(MatrixArguments),
    /// Show what the runs of a study say together: probabilities, quantiles, spread, increments, what drives them; written to reduced/ in its folder
    Reduce {
        /// The folder of the study, or its file
        study: PathBuf,
        /// Print it as JSON
        #[arg(long)]
        json: bool,
    },
    /// Draw map sheets and one page from a run folder, without a new simulation; of a run that was cut off, what it had at its last checkpoint
    Report {
        /// The run folder
        folder: PathBuf,
    },
    /// Run the built-in cases with known answers: error, order, cost, pass or fail; exit code 7 if the default methods miss an acceptance limit that is not known to be missed
    Validate(ValidateArguments),
    /// Chart speed against accuracy of chosen methods on the built-in cases: CSV, and an SVG for each case and error
    Chart(ChartArguments),
    /// Print what common formulas say of the breach of an embankment dam, beside each other
    Breach(BreachArguments),
    /// Write a commented scenario to start from
    New {
        /// The new file; an existing one is never replaced
        #[arg(default_value = "scenario.yaml")]
        file: PathBuf,
    },
    /// Print the JSON Schema of scenarios, for completion in editors
    Schema {
        /// Print docs/scenario-format.md, the page of all keys
        #[arg(long)]
        markdown: bool,
    },
    /// Print the completions for a shell
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Print the manual page
    Man,
}

/// The arguments of a run that goes on.
#[derive(Args, Debug)]
pub struct ResumeArguments {
    /// The run folder
    pub folder: PathBuf,
    /// Number of threads [default: all]; the results are the same for any number
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZero<usize>>,
    /// Set a limit, such as --set limits.memory='8 GB'; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
    /// No progress
    #[arg(long)]
    pub quiet: bool,
}

/// Two runs that are compared.
#[derive(Args, Debug)]
pub struct CompareArguments {
    /// The folder of the first run
    pub first: PathBuf,
    /// The folder of the second run; a difference is the second less the first
    pub second: PathBuf,
    /// Write maps of the differences (NetCDF, and GeoTIFF with styles for QGIS) and tables into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace what an earlier comparison or run left in that folder
    #[arg(long, requires = "out")]
    pub overwrite: bool,
    /// Print the comparison as JSON
    #[arg(long)]
    pub json: bool,
}

/// A study, and which of its members are run.
#[derive(Args, Debug)]
pub struct MatrixArguments {
    /// The study file, or the folder of a study to go on with
    pub study: PathBuf,
    /// Members that run at once [default: the number of cores]
    #[arg(long, value_name = "N")]
    pub jobs: Option<NonZero<usize>>,
    /// Threads of each member [default: the cores over the jobs]; the results are the same for any number
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZero<usize>>,
    /// Run this member alone, from the folder as it stands; may be repeated
    #[arg(long, value_name = "MEMBER")]
    pub only: Vec<usize>,
    /// Write the scenarios and run nothing
    #[arg(long, conflicts_with_all = ["only", "jobs", "threads", "retry"])]
    pub write_only: bool,
    /// Run members again that failed
    #[arg(long)]
    pub retry: bool,
    /// Replace scenarios of an earlier call that differ, and run these members again
    #[arg(long, conflicts_with = "only")]
    pub overwrite: bool,
    /// No progress
    #[arg(long)]
    pub quiet: bool,
}

/// The arguments of a run.
#[derive(Args, Debug)]
pub struct RunArguments {
    /// The scenario file
    pub scenario: PathBuf,
    /// Run folder, instead of that of the scenario
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Number of threads [default: all]; the results are the same for any number
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZero<usize>>,
    /// Set a key of the scenario, such as --set resolution='10 m' or --set initial[0].level='95 m'; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
    /// Replace an earlier run in the folder
    #[arg(long)]
    pub overwrite: bool,
    /// No progress
    #[arg(long)]
    pub quiet: bool,
}

/// The arguments of a check.
#[derive(Args, Debug)]
pub struct CheckArguments {
    /// The scenario file
    pub scenario: PathBuf,
    /// Print the findings as JSON
    #[arg(long)]
    pub json: bool,
    /// Set a key of the scenario, as in a run; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
}

/// Which codes are explained, and in which form.
#[derive(Args, Debug)]
pub struct ExplainArguments {
    /// Codes as `check` prints them in brackets; all when none is named
    #[arg(value_name = "CODE")]
    pub codes: Vec<String>,
    /// Print them as JSON
    #[arg(long)]
    pub json: bool,
    /// Print all as the tables of docs/problems.md
    #[arg(long, conflicts_with_all = ["codes", "json"])]
    pub markdown: bool,
}

/// The arguments of a plan.
#[derive(Args, Debug)]
pub struct PlanArguments {
    /// The scenario file
    pub scenario: PathBuf,
    /// Print the plan as JSON
    #[arg(long)]
    pub json: bool,
    /// Write the cells as a layer for QGIS: polygons by level and reason, with what each level costs; FILE is a new GeoPackage
    #[arg(long, value_name = "FILE")]
    pub layer: Option<PathBuf>,
    /// Number of threads of the run [default: all]
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZero<usize>>,
    /// Set a key of the scenario, as in a run; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
}

/// Which of the built-in cases are run, and with which methods.
#[derive(Args, Debug)]
pub struct CaseArguments {
    /// Cases by name; all of the suite when none is named (`floodsim validate --list` lists them)
    #[arg(value_name = "CASE")]
    pub cases: Vec<String>,
    /// The suite [default: analytic and stability; laboratory and field need the data that FLOODSIM_DATA names]
    #[arg(long)]
    pub suite: Option<String>,
    /// Try members of a family of methods, any key of `numerics:` such as --vary integrator=heun,leapfrog or
    /// --vary preset=fast,balanced,accurate; may be repeated, all combinations are run [default: motion=eulerian,lagrangian]
    #[arg(long = "vary", value_name = "FAMILY=A,B,C")]
    pub vary: Vec<String>,
    /// Number of threads; the results are the same for any number, the CPU seconds are not
    #[arg(long, value_name = "N", default_value = "1")]
    pub threads: NonZero<usize>,
}

/// Which spacings of each case are run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ResolutionsArgument {
    /// The coarse ones that the tests take: seconds
    Test,
    /// All: minutes
    Full,
}

/// How a dam fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ModeArgument {
    /// Water runs over the crest
    Overtopping,
    /// Water runs through the dam
    Piping,
}

/// The dam of which `breach` tells.
#[derive(Args, Debug)]
pub struct BreachArguments {
    /// Water above the bottom of the breach: m³, or with a unit such as "10 Mm3"
    #[arg(long, value_name = "VOLUME", value_parser = |text: &str| amount(text, &VOLUME), allow_hyphen_values = true)]
    pub volume: f64,
    /// Height of the breach, from its bottom to the crest: m, or with a unit such as "30 m"
    #[arg(long, value_name = "HEIGHT", value_parser = |text: &str| amount(text, &LENGTH), allow_hyphen_values = true)]
    pub height: f64,
    /// How the dam fails
    #[arg(long, value_enum, default_value = "overtopping")]
    pub mode: ModeArgument,
}

/// A number in SI units, or a quantity with its unit.
fn amount(text: &str, dimension: &Dimension) -> Result<f64, String> {
    let plain = text.parse::<f64>().ok();
    plain.map_or_else(|| dimension.parse(text).map_err(|error| format!("{}; {}", error.message, error.remedy)), Ok)
}

/// The arguments of a validation.
#[derive(Args, Debug)]
pub struct ValidateArguments {
    /// The cases and methods
    #[command(flatten)]
    pub cases: CaseArguments,
    /// Which spacings of each case
    #[arg(long, value_enum, default_value = "test")]
    pub resolutions: ResolutionsArgument,
    /// Write the rows as a JSON array, one object a row
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the rows as comma-separated values
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Draw measured against computed for each case of the suites laboratory and field: SVG, into this folder
    #[arg(long, value_name = "DIR")]
    pub figures: Option<PathBuf>,
    /// List the cases, one sentence each; run nothing
    #[arg(long)]
    pub list: bool,
}

/// The arguments of a chart.
#[derive(Args, Debug)]
pub struct ChartArguments {
    /// The cases and methods
    #[command(flatten)]
    pub cases: CaseArguments,
    /// Which spacings of each case
    #[arg(long, value_enum, default_value = "full")]
    pub resolutions: ResolutionsArgument,
    /// Draw the rows of such a file (`chart.csv`, or one of `validate --csv`) instead of running anything
    #[arg(long, value_name = "FILE", conflicts_with_all = ["vary", "threads", "resolutions"])]
    pub from: Option<PathBuf>,
    /// Lay what other codes made of the same cases on the figures: a table with the columns case, norm, code, spacing_m, cpu_s,
    /// error_depth and error_velocity; drawn where case and norm agree with a row
    #[arg(long, value_name = "FILE")]
    pub peers: Option<PathBuf>,
    /// The folder for `chart.csv` and the figures; it is made if need be
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_arguments_are_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn the_help_of_a_run_tells_every_preset() {
        let mut command = Arguments::command();
        let run = command.find_subcommand_mut("run").unwrap();
        let help = run.render_help().to_string().split_whitespace().collect::<Vec<_>>().join(" ");
        for preset in Preset::ALL {
            assert!(help.contains(&format!("{} {}", preset.name(), preset.summary())), "{help}");
        }
    }

    #[test]
    fn a_scenario_alone_is_a_run() {
        let arguments = Arguments::try_parse_from(["floodsim", "s.yaml", "--set", "a=1", "--set", "b=2"]).unwrap();
        let run = arguments.run.unwrap();
        assert_eq!((run.scenario, run.overrides), ("s.yaml".into(), vec!["a=1".to_owned(), "b=2".to_owned()]));
        assert!(arguments.command.is_none());
        let arguments = Arguments::try_parse_from(["floodsim", "run", "s.yaml", "--threads", "2"]).unwrap();
        let Some(Command::Run(run)) = arguments.command else { panic!("not a run") };
        assert_eq!(run.threads, NonZero::new(2));
        for wrong in
            [vec!["floodsim"], vec!["floodsim", "s.yaml", "--threads", "0"], vec!["floodsim", "s.yaml", "t.yaml"]]
        {
            assert!(Arguments::try_parse_from(wrong).is_err());
        }
    }
}
