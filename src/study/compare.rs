//! Two runs beside each other.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::changes::{Changes, between};
use super::files::{Head, crs_of, write_maps};
use super::maps::{DifferenceMap, Differences, differences};
use super::tables::{PlaceValue, values};
use crate::error::{Error, Problem, ProblemKind};
use crate::output::{MapClass, MapKind, MapVariable, OutputCrs, RunFolder, write_difference_table};
use crate::results::Results;

/// Which run it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunName {
    /// Its folder.
    pub folder: PathBuf,
    /// Title of its scenario.
    pub title: String,
    /// Simulated time (s).
    pub simulated_s: Option<f64>,
    /// Edge of the cells of its maps (m).
    pub cell_m: f64,
    /// Water (m³) at the start, and what came in.
    pub volume_m3: Option<f64>,
    /// CPU time (s).
    pub cpu_s: Option<f64>,
    /// Why its results are not those of a whole and sound run; none when they are.
    pub doubt: Option<String>,
}

/// What differs between two runs. A difference is the second less the first.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// The first and the second run.
    pub runs: [RunName; 2],
    /// What they were asked otherwise.
    pub changes: Changes,
    /// What differs on the maps.
    #[serde(flatten)]
    pub on_maps: Differences,
    /// Gauges and cross-sections.
    pub places: Vec<PlaceValue>,
    #[serde(skip)]
    crs: OutputCrs,
}

/// Compares two run folders.
///
/// # Errors
/// [`Error::Problems`] where one of them holds no maps of a run that has ended, and where they are of different places or reference systems.
pub fn compare(folders: [&Path; 2]) -> Result<Comparison, Error> {
    let [first, second] = folders;
    let runs = [Results::open(first)?, Results::open(second)?];
    let both = [&runs[0], &runs[1]];
    let apart = |what: String, remedy: &str| {
        let message = format!("{} and {} cannot be compared: {what}", first.display(), second.display());
        let problem = Problem::error(ProblemKind::Input, "not-comparable", "", message);
        Error::Problems(vec![problem.with_remedy(remedy)])
    };
    if both[0].crs != both[1].crs {
        let what = format!("their reference systems are {} and {}", both[0].crs, both[1].crs);
        return Err(apart(what, "run both in one reference system (`crs`)"));
    }
    let Some(on_maps) = differences(both)? else {
        return Err(apart("their maps are of different places".to_owned(), "name two runs of the same place"));
    };
    let names = [0, 1].map(|k| name(folders[k], both[k]));
    Ok(Comparison {
        runs: names,
        changes: between(folders, both.map(|run| &run.summary)),
        on_maps,
        places: values(both),
        crs: crs_of(both[0]),
    })
}

fn name(folder: &Path, run: &Results) -> RunName {
    let summary = &run.summary;
    let volume = |key: &str| summary["volume_m3"][key].as_f64();
    RunName {
        folder: folder.to_path_buf(),
        title: run.title.clone(),
        simulated_s: summary["simulated_s"].as_f64(),
        cell_m: run.grid.cell,
        volume_m3: volume("initial").map(|initial| initial + volume("in").unwrap_or(0.0)),
        cpu_s: summary["cpu_s"].as_f64(),
        doubt: run.doubt(),
    }
}

impl Comparison {
    /// Writes `differences.nc`, `cog/`, `tables/differences.csv` and `differences.json` into a folder of their own. `command` is the command line as
    /// typed.
    ///
    /// # Errors
    /// When the folder is that of one of the runs, holds files and `overwrite` is not set, or cannot be written.
    pub fn write(&self, folder: &Path, overwrite: bool, command: &str) -> Result<(), Error> {
        let real = |path: &Path| path.canonicalize().ok();
        if let Some(run) = self.runs.iter().find(|run| real(&run.folder) == real(folder) && folder.exists()) {
            let message = format!("the differences would replace the run in {}", run.folder.display());
            let problem = Problem::error(ProblemKind::Output, "input-in-output-folder", "--out", message);
            return Err(Error::Problems(vec![problem.with_remedy("choose a folder of its own with --out")]));
        }
        let folder = RunFolder::create(folder, overwrite)?;
        let [first, second] = &self.runs;
        let title = format!("{} less {}", second.title, first.title);
        let comment = format!("{} less {}", second.folder.display(), first.folder.display());
        let head = Head { title, comment, command, crs: &self.crs };
        write_maps((&folder, "differences.nc"), &self.on_maps.grid, head, &self.variables())?;
        let row = |place: &'_ PlaceValue| [place.first, place.second, place.difference()];
        let rows = self.places.iter().map(|place| ([place.kind, &place.id, place.quantity], row(place)));
        write_difference_table(&folder, rows)?;
        folder.write("differences.json", self.json().as_bytes())
    }

    /// The comparison as JSON.
    pub fn json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// The maps as variables of files.
    fn variables<'a>(&'a self) -> Vec<MapVariable<'a>> {
        let map = |name: &str, long_name: &str, units, kind, comment: String, values| MapVariable {
            name: name.to_owned(),
            long_name: long_name.to_owned(),
            standard_name: None,
            units,
            cell_methods: "",
            comment,
            threshold: None,
            kind,
            classes: Vec::new(),
            values,
        };
        let class = |(value, (name, label, colour)): (u8, (&str, &str, Option<[u8; 3]>))| MapClass {
            value,
            name: name.to_owned(),
            label: label.to_owned(),
            colour,
        };
        let classes = [
            ("dry", "dry in both", None),
            ("first_alone", "flooded in the first run alone", Some([0x21, 0x66, 0xac])),
            ("second_alone", "flooded in the second run alone", Some([0xb2, 0x18, 0x2b])),
            ("both", "flooded in both", Some([0xbd, 0xbd, 0xbd])),
        ];
        let depth = self.on_maps.extent.depth_m;
        let by_depth = format!("flooded from a maximum depth of {depth} m on");
        let extent = MapVariable {
            classes: (0..).zip(classes).map(class).collect(),
            ..map(
                "flood_extent",
                "where water came in which run",
                "1",
                MapKind::Class,
                by_depth,
                &self.on_maps.flooded[..],
            )
        };
        let difference = |one: &'_ DifferenceMap| -> String {
            let where_both =
                if one.name.starts_with("max_depth_diff") { "where one is flooded" } else { "where both are" };
            format!("second run less first, {where_both}")
        };
        let of_map = |one: &'a DifferenceMap| {
            map(&one.name, one.long_name, one.units, MapKind::Difference, difference(one), &one.values[..])
        };
        let maps = self.on_maps.maps.iter().map(of_map);
        std::iter::once(extent).chain(maps).collect()
    }
}
