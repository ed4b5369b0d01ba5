//! The program: hands the stages of a run to the command line and its exit code to the system.

use floodsim::cli::{self, Stages};

fn main() -> std::process::ExitCode {
    let stages = Stages {
        prepare: floodsim::pipeline::check,
        plan: floodsim::pipeline::plan,
        run: |scenario, options| floodsim::pipeline::run(scenario, options).map(|summary| summary.to_string()),
        resume: |options| floodsim::pipeline::resume(options).map(|summary| summary.to_string()),
    };
    std::process::ExitCode::from(cli::main(&stages) as u8)
}
