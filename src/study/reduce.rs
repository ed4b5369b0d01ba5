//! What the runs of a study say together.
//!
//! Runs that are not done are left out and named. All others count the same. Memory is that of the maps that are written, and of some rows of each run.

use std::path::Path;

use super::files::{Head, crs_of, write_maps};
use super::page;
use super::record::{StudyRecord, linked, run_of};
use super::reduced_maps::{ReducedMap, increment_maps, maps_of};
use super::reduction::{Group, Reduction, Sources};
use super::stack::Stack;
use super::state::{program_in, record_of, state};
use super::statistics::{PlaceValues, values_of};
use crate::error::{Error, Problem, ProblemKind};
use crate::output::{MapVariable, RunFolder, write_quantile_table};
use crate::results::{MapRows, Results, Table, table_of};

/// Reduces the study of a folder, and writes `reduced/` into it. `command` is the command line as typed.
///
/// # Errors
/// `no-study`, `no-members` where no member is done, `not-comparable` where they are of different places, and when a file cannot be written.
pub fn reduce(folder: &Path, command: &str) -> Result<Reduction, Error> {
    let study = StudyRecord::open(folder)?;
    if let Some(problem) = linked(folder) {
        return Err(Error::Problems(vec![problem]));
    }
    let sources = sources(folder, &study)?;
    let of_variant = |variant: &String| -> Vec<usize> {
        let runs = 0..sources.members.len();
        runs.filter(|run| study.members[sources.members[*run]].variant == *variant).collect()
    };
    let runs: Vec<Vec<usize>> = study.variants.iter().map(of_variant).collect();
    let mut groups = Vec::new();
    for (variant, runs) in study.variants.iter().zip(&runs).filter(|(_, runs)| !runs.is_empty()) {
        groups.push(sources.group(folder, variant, runs, command)?);
    }
    for (variant, others) in study.variants.iter().zip(&runs).skip(1) {
        let pairs = sources.pairs(&runs[0], others);
        if !pairs.is_empty() {
            let name = format!("{}_less_{variant}", study.variants[0]);
            groups.push(sources.increment(folder, &name, &pairs, command)?);
        }
    }
    Ok(Reduction {
        title: study.title.clone(),
        members: study.members.len(),
        left_out: sources.left_out,
        doubts: sources.doubts,
        flooded_from_m: sources.flooded_from,
        groups,
    })
}

/// Opens the members that are done.
fn sources<'a>(folder: &Path, study: &'a StudyRecord) -> Result<Sources<'a>, Error> {
    let (mut members, mut left_out) = (Vec::new(), Vec::new());
    let mut doubts = Doubts::default();
    for (index, member) in study.members.iter().enumerate() {
        let state = state(folder, member.number);
        if let Some(why) = state.lacks() {
            left_out.push((member.number, why.to_owned()));
            continue;
        }
        doubts.add(&run_of(folder, member.number));
        members.push(index);
    }
    let Some(first) = members.first() else {
        let message = format!("no member of the study in {} is done", folder.display());
        let problem = Problem::error(ProblemKind::Input, "no-members", "", message);
        return Err(Error::Problems(vec![problem.with_remedy("run them first: `floodsim matrix` with this folder")]));
    };
    // Says why there are no maps, where the members have none.
    let first = Results::open(&run_of(folder, study.members[*first].number))?;
    let maps = members.iter().map(|index| MapRows::find(&run_of(folder, study.members[*index].number)));
    let Some(stack) = Stack::of(maps.collect::<Result<_, Error>>()?) else {
        let message = format!("the maps of the members in {} are of different places", folder.display());
        let problem = Problem::error(ProblemKind::Input, "not-comparable", "", message);
        return Err(Error::Problems(vec![problem.with_remedy("vary no key that moves the terrain")]));
    };
    let crs = crs_of(&first);
    let flooded_from = first.arrival_depth().unwrap_or(0.0);
    Ok(Sources { study, stack, members, first, crs, flooded_from, left_out, doubts: doubts.end() })
}

/// What runs have that all of a study should share.
#[derive(Default)]
struct Doubts {
    programs: Vec<String>,
    inputs: Vec<(String, String)>,
    changed: Vec<String>,
}

impl Doubts {
    fn add(&mut self, run: &Path) {
        let record = record_of(run);
        let text = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
        let program = program_in(&record);
        if !self.programs.contains(&program) {
            self.programs.push(program);
        }
        for input in record["inputs"].as_array().into_iter().flatten() {
            let (path, sum) = (text(&input["path"]), text(&input["sha256"]));
            // Each member has a scenario of its own.
            match self.inputs.iter().find(|(other, _)| *other == path) {
                None => self.inputs.push((path, sum)),
                Some((_, other)) if *other != sum && !self.changed.contains(&path) => self.changed.push(path),
                Some(_) => {}
            }
        }
    }

    fn end(self) -> Vec<String> {
        let programs = (self.programs.len() > 1)
            .then(|| format!("the members were run by different programs: {}", self.programs.join(", ")));
        let changed = self.changed.iter().map(|path| format!("{path} was another file for some of the members"));
        programs.into_iter().chain(changed).collect()
    }
}

impl Sources<'_> {
    fn numbers(&self, runs: &[usize]) -> Vec<usize> {
        runs.iter().map(|run| self.study.members[self.members[*run]].number).collect()
    }

    /// Runs of the same case of two variants.
    fn pairs(&self, first: &[usize], second: &[usize]) -> Vec<(usize, usize)> {
        let case = |run: &usize| self.study.members[self.members[*run]].case;
        let other = |run: &usize| second.iter().find(|other| case(other) == case(run)).map(|other| (*run, *other));
        first.iter().filter_map(other).collect()
    }

    /// The runs of one variant: maps, tables, page.
    fn group(&self, study_folder: &Path, name: &str, runs: &[usize], command: &str) -> Result<Group, Error> {
        let folder = RunFolder::create(&study_folder.join("reduced").join(name), true)?;
        let maps = maps_of(&self.stack, runs, self.flooded_from, &self.study.depths)?;
        let numbers = self.numbers(runs);
        let table = |table: &str| -> Vec<Table> {
            numbers.iter().map(|number| table_of(&run_of(study_folder, *number), table)).collect()
        };
        let area = PlaceValues {
            kind: "map",
            id: "flooded area".to_owned(),
            quantity: "flooded_m2".to_owned(),
            values: self.stack.areas("max_depth", runs, self.flooded_from)?.into_iter().map(Some).collect(),
        };
        let values = values_of(&table("gauges.csv"), &table("sections.csv"));
        let members: Vec<usize> = runs.iter().map(|run| self.members[*run]).collect();
        let places =
            std::iter::once(&area).chain(&values).map(|values| values.statistic(self.study, &members)).collect();
        let group = Group { name: name.to_owned(), members: numbers, places, folder: folder.path().to_owned() };
        self.write(&folder, &group, &maps, command)?;
        Ok(group)
    }

    /// What one variant adds to another.
    fn increment(&self, study: &Path, name: &str, pairs: &[(usize, usize)], command: &str) -> Result<Group, Error> {
        let folder = RunFolder::create(&study.join("reduced").join(name), true)?;
        let maps = increment_maps(&self.stack, pairs)?;
        let first: Vec<usize> = pairs.iter().map(|pair| pair.0).collect();
        let (name, path) = (name.to_owned(), folder.path().to_owned());
        let group = Group { name, members: self.numbers(&first), places: Vec::new(), folder: path };
        self.write(&folder, &group, &maps, command)?;
        Ok(group)
    }

    fn write(&self, folder: &RunFolder, group: &Group, maps: &[ReducedMap], command: &str) -> Result<(), Error> {
        let variables: Vec<MapVariable<'_>> = maps.iter().map(ReducedMap::variable).collect();
        let comment = format!("{} members of the study", group.members.len());
        let head = Head { title: self.title(group), comment, command, crs: &self.crs };
        write_maps((folder, "statistics.nc"), &self.stack.grid, head, &variables)?;
        let rows = group.places.iter().map(|place| {
            let drivers = place.drivers.iter().map(|driver| (driver.variable.as_str(), driver.correlation));
            ([place.kind, &place.id, &place.quantity], [place.runs, place.reached], place.values, drivers.collect())
        });
        write_quantile_table(folder, rows)?;
        folder.write("report/index.html", page::page(self, group, maps)?.as_bytes())
    }
}
