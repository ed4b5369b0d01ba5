//! Helpers of the tests: runs of the library's cases, and solvers stepped by hand.

#![allow(dead_code, reason = "every test binary uses its own part")]
#![allow(clippy::unwrap_used, reason = "a failed step is a failed test")]

use floodsim::solver::FlowSolver;
use floodsim::solver::variational::VariationalSolver;
use floodsim::validation::{Choice, Outcome, Setup, run};

/// The methods of `numerics:` with the given entries.
pub fn methods(given: &[(&str, &str)]) -> Choice {
    Choice::new(given).unwrap()
}

/// Cells that move.
pub fn moving() -> Choice {
    methods(&[("motion", "lagrangian")])
}

/// Cells at rest.
pub fn resting() -> Choice {
    methods(&[("motion", "eulerian")])
}

/// Runs a setup to its end.
pub fn outcome(setup: &Setup, choice: &Choice) -> Outcome {
    let outcome = run(setup, choice).1.unwrap();
    assert!(outcome.volume_error.abs() < 1e-12, "volume error {:e}", outcome.volume_error);
    outcome
}

/// Mean errors of depth (m) and velocity (m/s).
pub fn errors(setup: &Setup, choice: &Choice) -> (f64, f64) {
    let errors = outcome(setup, choice).errors;
    (errors.depth, errors.velocity)
}

/// Runs a number of steps.
pub fn run_steps(solver: &mut VariationalSolver, steps: usize) {
    for _ in 0..steps {
        let step = solver.choose_step().time_step;
        solver.advance(step).unwrap();
    }
}

/// Greatest speed of any particle (m/s).
pub fn max_speed(solver: &VariationalSolver) -> f64 {
    solver.state().particles.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max)
}

/// Checks a pair of errors (depth, velocity) against a pair of bounds.
pub fn assert_below(errors: (f64, f64), bounds: (f64, f64)) {
    assert!(errors.0 < bounds.0 && errors.1 < bounds.1, "errors {errors:?} against bounds {bounds:?}");
}
