//! Where methods fail: the suite of stability at test resolution, as `floodsim validate --suite stability` runs it.

#[path = "../support/mod.rs"]
mod support;

use rayon::prelude::*;

use floodsim::validation::Status::{Degrades, Fails, Holds};
use floodsim::validation::{Case, CaseResult, Resolutions, Status, Suite, cases, run_case};

use support::methods;

/// A name and the entries of `numerics:`.
type Method = (&'static str, &'static [(&'static str, &'static str)]);

const EULERIAN: Method = ("eulerian", &[("motion", "eulerian")]);
const LAGRANGIAN: Method = ("lagrangian", &[("motion", "lagrangian")]);
const VARIATIONAL: Method = ("variational", &[("motion", "lagrangian"), ("formulation", "variational")]);

const FAST: Method = ("fast", &[("preset", "fast")]);
const ACCURATE: Method = ("accurate", &[("preset", "accurate")]);
const METHODS: [Method; 5] = [EULERIAN, LAGRANGIAN, VARIATIONAL, FAST, ACCURATE];

/// What does not hold today, with the method: docs/validation/stability.md says so too. Every other run holds, and what comes to hold, or
/// comes to fail, must be changed here.
const KNOWN: &[(&str, &str, Status)] = &[
    ("two_rarefactions", "eulerian", Degrades),
    ("cfl_08", "eulerian", Degrades),
    ("cfl_10", "eulerian", Fails),
    ("cfl_12", "eulerian", Fails),
    ("cfl_14", "eulerian", Fails),
    ("cfl_16", "eulerian", Fails),
    ("two_rarefactions", "lagrangian", Degrades),
    ("wide_jump_3", "lagrangian", Degrades),
    ("wide_jump_5", "lagrangian", Degrades),
    ("wide_jump_8", "lagrangian", Fails),
    ("corners", "lagrangian", Degrades),
    ("cfl_12", "lagrangian", Fails),
    ("cfl_14", "lagrangian", Fails),
    ("cfl_16", "lagrangian", Fails),
    ("over_film", "variational", Fails),
    ("ratio_1000", "variational", Fails),
    ("waterfall", "variational", Fails),
    ("calm", "variational", Fails),
    ("cfl_16", "variational", Degrades),
    ("two_rarefactions", "fast", Degrades),
    ("cfl_10", "fast", Fails),
    ("cfl_12", "fast", Fails),
    ("cfl_14", "fast", Fails),
    ("cfl_16", "fast", Fails),
    ("two_rarefactions", "accurate", Degrades),
    ("cfl_08", "accurate", Degrades),
    ("cfl_10", "accurate", Fails),
    ("cfl_12", "accurate", Fails),
    ("cfl_14", "accurate", Fails),
    ("cfl_16", "accurate", Fails),
];

/// Runs every case with a method and compares with what is known.
fn check((method, given): Method) -> Vec<CaseResult> {
    let mut different = Vec::new();
    let mut results = Vec::new();
    let cases: Vec<_> = cases::of_suite(Suite::Stability).collect();
    let run = |case: &&'static Case| run_case(case, &methods(given), Resolutions::Test);
    let all: Vec<CaseResult> = cases.par_iter().map(run).collect();
    for (case, result) in cases.into_iter().zip(all) {
        if let Some(why) = &result.skipped {
            println!("{} {method} skipped, because {why}", case.name);
        }
        let known = KNOWN.iter().find(|(name, of, _)| *name == case.name && *of == method);
        let expected = known.map_or(Holds, |(_, _, status)| *status);
        let rows = result.rows.iter().filter(|row| row.status != expected);
        different.extend(rows.map(|row| format!("{} {method} {}: {}", row.case, row.status.name(), row.note)));
        results.push(result);
    }
    assert!(different.is_empty(), "other than known:\n{}", different.join("\n"));
    results
}

#[test]
fn the_default_method_fails_nothing_at_its_own_courant_number() {
    for result in check(EULERIAN).iter().filter(|result| !result.is_stretched) {
        for row in &result.rows {
            assert_ne!(row.status, Fails, "{}: {}", row.case, row.note);
        }
    }
}

#[test]
fn presets_hold_degrade_and_fail_as_their_descriptions_say() {
    let results = [FAST, ACCURATE].into_iter().flat_map(check);
    for result in results.filter(|result| !result.is_stretched) {
        assert!(result.rows.iter().all(|row| row.status != Fails));
    }
}

#[test]
fn cells_that_move_hold_degrade_and_fail_as_known() {
    check(LAGRANGIAN);
}

#[test]
fn the_variational_formulation_holds_degrades_and_fails_as_known() {
    // What breaks must say when and where, and by what its step was limited.
    let results = check(VARIATIONAL);
    let notes = results.iter().flat_map(|result| &result.rows).filter(|row| row.note.contains("given up at t ="));
    assert!(notes.clone().count() > 0);
    for row in notes {
        assert!(row.status == Fails && row.note.contains("limited by courant at"), "{}", row.note);
    }
}

#[test]
fn what_is_known_is_about_cases_and_methods_that_exist() {
    for (name, method, status) in KNOWN {
        assert!(cases::named(name).is_some_and(|case| case.suite == Suite::Stability), "{name}");
        let is_method = METHODS.iter().any(|(known, _)| known == method);
        assert!(is_method && matches!(status, Degrades | Fails), "{name} {method}");
    }
}
