//! `floodsim validate`: the built-in cases with chosen methods, as a table, JSON or CSV.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::args::{CaseArguments, ResolutionsArgument, ValidateArguments};
use super::print;
use crate::error::{Error, Problem, ProblemKind, say};
use crate::laboratory::{self, DATA, Experiment, Skipped, run_experiment};
use crate::maps::comparison;
use crate::pipeline::thread_pool;
use crate::scenario::read::nearest;
use crate::validation::{
    Case, CaseRun, Choice, KNOWN_MISSES, Missed, Resolutions, Row, Suite, Varied, cases, choices, known_miss,
    list_of_cases, missed_limits, rows_as_csv, run_case, table_of_rows,
};

/// Runs the cases, prints and writes their rows.
///
/// # Errors
/// `Error::Usage` for wrong names, `Error::Output` for files, and `Error::Gate` where the default methods miss an acceptance limit and
/// [`KNOWN_MISSES`](crate::validation::KNOWN_MISSES) does not list it; `Error::Problems` where the data of no experiment were there, and
/// `Error::Usage` where nothing was run for another reason.
pub fn validate(arguments: &ValidateArguments) -> Result<(), Error> {
    let (chosen, experiments) = chosen_of_all(&arguments.cases)?;
    if arguments.list {
        return print(&(list_of_cases(chosen.into_iter()) + &list_of_experiments(&experiments)));
    }
    arguments.json.iter().chain(&arguments.csv).try_for_each(|file| check_writable(file))?;
    arguments.figures.iter().try_for_each(|folder| make_folder(folder))?;
    let results = run_cases(&chosen, &arguments.cases, arguments.resolutions)?;
    let mut rows: Vec<Row> = results.iter().flat_map(|result| result.result.rows.iter().cloned()).collect();
    let mut missed = missed_limits(&results);
    let mut left_out: Vec<(&Experiment, Skipped)> = Vec::new();
    for &experiment in &experiments {
        let found = run_in_laboratory(experiment, arguments)?;
        rows.extend(found.rows);
        missed.extend(found.missed);
        left_out.extend(found.skipped.map(|why| (experiment, why)));
    }
    print(&table_of_rows(&rows))?;
    if let Some(file) = &arguments.json {
        write(file, &as_json(&rows)?)?;
    }
    if let Some(file) = &arguments.csv {
        write(file, &rows_as_csv(&rows))?;
    }
    for known in KNOWN_MISSES.iter().filter(|known| known.missed().any(|one| missed.contains(&one))) {
        say(format!("known to miss an acceptance limit: {} ({}): {}", known.case, known.whose(), known.why));
    }
    all_known(&missed)?;
    has_run(&experiments, &left_out, rows.is_empty())?;
    match results.iter().find_map(|run| run.result.skipped.as_ref().map(|why| (run.case.name, why))) {
        Some((name, why)) if rows.is_empty() => Err(nothing_was_run(name, why)),
        _ => Ok(()),
    }
}

/// Refuses misses of acceptance limits that are not known.
fn all_known(missed: &[Missed]) -> Result<(), Error> {
    let unknown = missed.iter().filter(|missed| known_miss(**missed).is_none());
    let names: BTreeSet<String> = unknown.map(Missed::to_string).collect();
    if names.is_empty() {
        return Ok(());
    }
    let names = names.into_iter().collect::<Vec<_>>().join(", ");
    Err(Error::Gate(format!("the default methods miss an acceptance limit of {names}")))
}

fn nothing_was_run(name: &str, why: impl std::fmt::Display) -> Error {
    Error::Usage(format!("nothing was run: {name} is left out, because {why}"))
}

/// Whether experiments came to judge anything: not where the data of none were there, nor where none is for the methods.
fn has_run(experiments: &[&Experiment], left_out: &[(&Experiment, Skipped)], is_empty: bool) -> Result<(), Error> {
    let with_data = experiments.iter().filter(|experiment| !experiment.data.is_empty()).count();
    let without: Vec<&str> = left_out
        .iter()
        .filter(|(_, why)| matches!(why, Skipped::Data(_)))
        .map(|(experiment, _)| experiment.name)
        .collect();
    if !without.is_empty() && without.len() == with_data {
        let message = format!("the measurements of no experiment were there: {} not run", without.join(", "));
        let cause = match std::env::var_os(DATA) {
            Some(folder) => format!("`{}`, which {DATA} names, has no folders of theirs", Path::new(&folder).display()),
            None => format!("{DATA} is not set"),
        };
        let remedy =
            format!("set {DATA} to the folder of the data; scenarios/laboratory/README.md says what it must hold");
        let problem = Problem::error(ProblemKind::Input, "no-data", DATA, message);
        return Err(Error::Problems(vec![problem.with_cause(cause).with_remedy(remedy)]));
    }
    match left_out.last() {
        Some((experiment, why)) if is_empty => Err(nothing_was_run(experiment.name, why)),
        _ => Ok(()),
    }
}

/// The built-in cases and the experiments that are named, or all of the suite; experiments only where they or their suite are named.
fn chosen_of_all(arguments: &CaseArguments) -> Result<(Vec<&'static Case>, Vec<&'static Experiment>), Error> {
    let experiment = |name: &String| laboratory::named(&name.replace('-', "_"));
    let named: Vec<&Experiment> = arguments.cases.iter().filter_map(experiment).collect();
    let others: Vec<String> = arguments.cases.iter().filter(|name| experiment(name).is_none()).cloned().collect();
    if !arguments.cases.is_empty() {
        let mut chosen: Vec<&Case> = Vec::new();
        for name in &others {
            // A channel of one row hides what goes wrong in the plane: whoever asks for the one sees the other, each once.
            for case in cases::with_companions(case_named(name)?.name) {
                if !chosen.iter().any(|known| known.name == case.name) {
                    chosen.push(case);
                }
            }
        }
        return Ok((chosen, named));
    }
    let suite = arguments.suite.as_deref().map(suite_named).transpose()?;
    let of_suite = laboratory::all().filter(|experiment| Some(experiment.suite) == suite).collect();
    Ok((chosen_cases(arguments)?, of_suite))
}

fn list_of_experiments(experiments: &[&Experiment]) -> String {
    let one = |experiment: &&Experiment| {
        let [coarse, fine] = experiment.resolutions;
        format!(
            "{}\n    {}\n    suite {}; resolutions {coarse}, {fine} m, the first at test resolution\n",
            experiment.name,
            experiment.about,
            experiment.suite.name()
        )
    };
    experiments.iter().map(one).collect()
}

/// What an experiment with every choice of methods gave.
#[derive(Default)]
struct Found {
    rows: Vec<Row>,
    /// What the default methods miss of its acceptance limit.
    missed: Vec<Missed>,
    /// Why the last choice that was left out was.
    skipped: Option<Skipped>,
}

/// Runs an experiment with every choice of methods.
fn run_in_laboratory(experiment: &Experiment, arguments: &ValidateArguments) -> Result<Found, Error> {
    let mut found = Found::default();
    for choice in chosen_methods(&arguments.cases)? {
        say(format!("{}: {}", experiment.name, choice.label()));
        let threads = arguments.cases.threads.get();
        let result = run_experiment(experiment, &choice, resolutions_of(arguments.resolutions), threads)?;
        if let Some(why) = result.skipped {
            say(format!("{}: {} skipped, because {why}", experiment.name, choice.label()));
            found.skipped = Some(why);
            continue;
        }
        if let Some(folder) = &arguments.figures {
            let methods: Vec<&str> = choice.given.iter().map(|(_, member)| member.as_str()).collect();
            let title = format!("{}, {}", experiment.name.replace('_', " "), methods.join(", "));
            let figure = comparison(&title, "depth or level (m)", &result.panels);
            write(&folder.join(format!("{}_{}.svg", experiment.name, methods.join("_"))), &figure)?;
        }
        if choice.is_default && result.is_missed {
            let motion = Some(choice.numerics.motion);
            found.missed.push(Missed { case: experiment.name, motion, limit: None });
        }
        found.rows.extend(result.rows);
    }
    Ok(found)
}

/// The cases that are named, or all of the suite.
pub fn chosen_cases(arguments: &CaseArguments) -> Result<Vec<&'static Case>, Error> {
    let suite = arguments.suite.as_deref().map(suite_named).transpose()?;
    if arguments.cases.is_empty() {
        return Ok(cases::all().filter(|case| suite.is_none_or(|suite| case.suite == suite)).collect());
    }
    arguments.cases.iter().map(|name| case_named(name)).collect()
}

fn suite_named(name: &str) -> Result<Suite, Error> {
    let names = || Suite::ALL.iter().map(|suite| suite.name());
    let found = Suite::ALL.iter().copied().find(|suite| suite.name() == name);
    found.ok_or_else(|| Error::Usage(format!("`{name}` is not a suite; {}", remedy(name, names()))))
}

fn case_named(name: &str) -> Result<&'static Case, Error> {
    // Scenarios and cases are named with either sign.
    let plain = name.replace('-', "_");
    if laboratory::named(&plain).is_some() {
        let what = format!("`{name}` is an experiment without an exact answer");
        return Err(Error::Usage(format!("{what}; run it with `floodsim validate {plain} --figures DIR`")));
    }
    let names = || cases::all().map(|case| case.name).chain(laboratory::all().map(|experiment| experiment.name));
    cases::named(&plain).ok_or_else(|| Error::Usage(format!("`{name}` is not a case; {}", remedy(name, names()))))
}

fn remedy<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.collect();
    match nearest(name, known.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("use one of {}", known.join(", ")),
    }
}

/// Runs every case with every choice, on so many threads; says on stderr where it is and what it leaves out.
pub fn run_cases(
    cases: &[&'static Case],
    arguments: &CaseArguments,
    resolutions: ResolutionsArgument,
) -> Result<Vec<CaseRun>, Error> {
    if cases.is_empty() {
        return Ok(Vec::new());
    }
    let choices = chosen_methods(arguments)?;
    let resolutions = resolutions_of(resolutions);
    let threads = thread_pool(Some(arguments.threads.get()))?;
    let mut runs = Vec::new();
    for &case in cases {
        for choice in &choices {
            say(format!("{}: {}", case.name, choice.label()));
            let result = threads.install(|| run_case(case, choice, resolutions));
            if let Some(why) = &result.skipped {
                say(format!("{}: {} skipped, because {why}", case.name, choice.label()));
            }
            runs.push(CaseRun { case, choice: choice.clone(), result });
        }
    }
    Ok(runs)
}

/// Every choice of methods that is asked for; says on stderr which do not exist.
fn chosen_methods(arguments: &CaseArguments) -> Result<Vec<Choice>, Error> {
    let varied: Result<Vec<Varied>, String> = arguments.vary.iter().map(|text| Varied::read(text)).collect();
    let (choices, refused) = choices(&varied.map_err(|message| Error::Usage(format!("--vary: {message}")))?)?;
    for line in refused {
        say(format!("left out: {line}"));
    }
    Ok(choices)
}

fn resolutions_of(argument: ResolutionsArgument) -> Resolutions {
    match argument {
        ResolutionsArgument::Test => Resolutions::Test,
        ResolutionsArgument::Full => Resolutions::Full,
    }
}

fn as_json(rows: &[Row]) -> Result<String, Error> {
    let line = |row: &Row| serde_json::to_string(row).map_err(|cause| Error::Internal(cause.to_string()));
    let lines: Result<Vec<String>, Error> = rows.iter().map(line).collect();
    Ok(format!("[\n{}\n]\n", lines?.join(",\n")))
}

/// Writes a file that is complete when it has its name.
pub fn write(file: &Path, text: &str) -> Result<(), Error> {
    let partial = partial(file);
    std::fs::write(&partial, text).and_then(|()| std::fs::rename(&partial, file)).map_err(|cause| failed(file, cause))
}

/// Refuses a file that [`write`] could not write, before what it is to hold is computed.
fn check_writable(file: &Path) -> Result<(), Error> {
    if file.exists() && !file.is_file() {
        return Err(failed(file, "there is something else than a file"));
    }
    let partial = partial(file);
    let tried = std::fs::File::create(&partial).and_then(|_| std::fs::remove_file(&partial));
    tried.map_err(|cause| failed(file, cause))
}

/// Makes a folder in which files can be written.
pub fn make_folder(folder: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(folder).map_err(|cause| failed(folder, cause))?;
    check_writable(&folder.join("figure"))
}

/// The name of a file until it is complete.
fn partial(file: &Path) -> PathBuf {
    let mut partial = file.as_os_str().to_owned();
    partial.push(".part");
    partial.into()
}

fn failed(path: &Path, cause: impl std::fmt::Display) -> Error {
    Error::Output { path: path.to_owned(), cause: cause.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::ExitCode;
    use crate::scenario::methods::Motion;

    #[test]
    fn a_miss_that_is_not_known_ends_with_the_code_of_gates_and_names_it_once() {
        let known = KNOWN_MISSES[0].missed().next().unwrap();
        assert!(all_known(&[known]).is_ok() && all_known(&[]).is_ok());
        let of = |motion, limit| Missed { case: "made", motion, limit };
        let by = Some(Motion::Eulerian);
        let failed = all_known(&[of(by, Some(0)), of(None, Some(1)), known, of(by, None)]).unwrap_err();
        assert_eq!(failed.exit_code(), ExitCode::Gate);
        assert!(failed.to_string().ends_with("made (eulerian), made (the better motion)"), "{failed}");
    }
}
