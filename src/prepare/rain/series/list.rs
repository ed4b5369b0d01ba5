//! A CSV list of times and raster files.

use std::path::{Path, PathBuf};

use super::Asked;
use super::units::unit_remedy;
use crate::calendar::UtcTime;
use crate::error::{Problem, input_error};
use crate::geodata::cf_axes::{is_netcdf, split_variable};
use crate::geodata::{Table, read_text, readable_file};
use crate::prepare::rain::times::Start;
use crate::prepare::tables::dates::{self, Dates, Origin};
use crate::prepare::tables::rows::{in_lines, rows_are};
use crate::prepare::tables::series::choose;
use crate::scenario::units::TIME;
use crate::scenario::{ColumnUnit, RainUnit};

/// A list of rasters as it is read.
pub struct List {
    /// Times (s).
    pub times: Vec<f64>,
    pub files: Vec<PathBuf>,
    pub unit: RainUnit,
    /// Whether the times are dates in the file.
    pub is_dated: bool,
}

/// A CSV list: a column of times, dates or numbers with their unit at the end of its name, and one of files.
pub fn list_series(asked: &Asked, reference: Option<UtcTime>) -> Result<List, Vec<Problem>> {
    let path = &asked.file.value.path;
    let name = path.display().to_string();
    let mut faults = Vec::new();
    if let Some(layer) = &asked.file.value.layer {
        let message = format!("{name} is a list of files, which has no variable `{layer}`");
        faults.push(input_error("no-variable", message).with_remedy("take the colon and the name behind it out"));
    }
    if asked.unit.is_none() {
        let message = format!("the unit of the rasters that {name} lists is not known");
        faults.push(input_error("missing-unit", message).with_remedy(unit_remedy()));
    }
    let text = match read_text(path) {
        Ok(text) => text,
        Err(error) => {
            let problem = input_error("not-a-list", format!("{name} is neither NetCDF nor a list of rasters"));
            let remedy = "name a NetCDF file, or a CSV file whose first line is `time_min,file`";
            faults.push(problem.with_cause(error.to_string()).with_remedy(remedy));
            return Err(faults);
        }
    };
    let parsed = Table::parse(&text, |_| true);
    let reading = list_times(&parsed, asked, reference, &mut faults);
    let Some(reading) = reading else { return Err(faults) };
    let folder = path.parent().unwrap_or(Path::new(""));
    let (mut times, mut files, mut faulty) = (Vec::new(), Vec::new(), Vec::new());
    for (line, fields) in &parsed.rows {
        let time = fields.first().and_then(|field| reading.seconds(field));
        match (time, fields.get(1).filter(|field| !field.is_empty())) {
            (Some(time), Some(file)) => {
                times.push(time);
                files.push(folder.join(file));
            }
            _ => faulty.push((*line, fields.join(","))),
        }
    }
    faults.extend(in_lines(
        faulty.into_iter(),
        "not-a-row",
        |count, lines| format!("{} no time and file in {name}: {lines}", rows_are(count)),
        "write a date or a number with a point as decimal sign, a comma and the path of a raster, which counts from the folder of the list",
    ));
    let missing = files.iter().filter_map(|file| readable_file(&split_variable(file).0).err());
    let here = "the paths of a list count from its own folder; check the spelling";
    faults.extend(missing.map(|problem| problem.with_cause(format!("{name} lists it")).with_remedy(here)));
    match (asked.unit, faults.is_empty()) {
        (Some(unit), true) => Ok(List { times, files, unit, is_dated: matches!(reading, ListTimes::Dates(_)) }),
        _ => Err(faults),
    }
}

/// How the times of a list are read.
enum ListTimes {
    /// As dates, from the start of the run on.
    Dates(Origin),
    /// As numbers, with the factor of their unit.
    Numbers(f64),
}

impl ListTimes {
    /// The time of a field (s); 0 of a date that cannot be read, which is reported with the others.
    fn seconds(&self, text: &str) -> Option<f64> {
        match self {
            ListTimes::Dates(_) if text.is_empty() => None,
            ListTimes::Dates(origin) => Some(origin.seconds_to(text).unwrap_or(0.0)),
            ListTimes::Numbers(factor) => {
                text.parse::<f64>().ok().map(|time| time * factor).filter(|time| time.abs() <= TIME.most)
            }
        }
    }
}

/// How the times of a list are to be read, and what is wrong with its first line and its dates; none where it has no such column.
fn list_times(
    parsed: &Table,
    asked: &Asked,
    reference: Option<UtcTime>,
    faults: &mut Vec<Problem>,
) -> Option<ListTimes> {
    let name = asked.file.value.path.display().to_string();
    let header = parsed.header.clone().unwrap_or_default();
    let time = ColumnUnit { name: None, unit: None };
    let begin = "begin the list with a line such as `time_min,file`: the unit of the times ends their name";
    if header.len() < 2 {
        let problem = input_error("no-header", format!("the first line of {name} does not name two columns"));
        faults.push(problem.with_remedy(begin));
        return None;
    }
    if dates::are_dates(&parsed.rows, 0) {
        let start = Start { own: asked.start, reference }.moment().map_err(|problem| faults.push(problem)).ok()?;
        let dates = Dates { rows: &parsed.rows, column: 0, header: &header[0], name: &name };
        faults.extend(dates::faults(&dates, &time, Origin::Start(start)));
        return Some(ListTimes::Dates(Origin::Start(start)));
    }
    if asked.start.is_some() {
        let message = format!("the times of the list {name} count from the start of the run");
        faults.push(input_error("start-without-date", message).with_remedy("take `start` out"));
    }
    match choose(&time, 0, &header, &TIME, &name) {
        Ok((_, factor)) => Some(ListTimes::Numbers(factor)),
        Err(problem) => {
            faults.push(problem.with_remedy(begin));
            None
        }
    }
}

/// The files of a list, for the record of inputs.
pub fn listed_files(path: &Path) -> Vec<PathBuf> {
    if is_netcdf(path) {
        return Vec::new();
    }
    let Ok(text) = read_text(path) else { return Vec::new() };
    let folder = path.parent().unwrap_or(Path::new(""));
    let rows = Table::parse(&text, |_| true).rows.into_iter();
    rows.filter_map(|(_, fields)| fields.get(1).map(|file| folder.join(file))).collect()
}
