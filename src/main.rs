//! The program: hands the stages of a run to the command line and its exit code to the system.

use std::io::Write;

use floodsim::cli::{self, Stages};

fn main() {
    let stages = Stages {
        prepare: floodsim::pipeline::check,
        plan: floodsim::pipeline::plan,
        run: |scenario, options| floodsim::pipeline::run(scenario, options).map(|summary| summary.to_string()),
        resume: |options| floodsim::pipeline::resume(options).map(|summary| summary.to_string()),
    };
    let code = cli::main(&stages);
    // All is written and closed. What the libraries do at an exit would meet the files that could not be closed, and crash.
    let _ = std::io::stdout().flush();
    signal_hook::low_level::exit(code as i32)
}
