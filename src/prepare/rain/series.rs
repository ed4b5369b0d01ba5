//! Rain as a series of rasters: a NetCDF variable of time, y and x, or a CSV list of times and raster files.
//!
//! Each raster holds for its interval, constant in time: from its own time to that of the next one (`stamp: begin`), from the one
//! before to its own (`stamp: end`), or as the bounds of a NetCDF file say. The raster at an end of the series that has no
//! neighbour there holds as long as the one beside it. Not here: their values and losses ([`crate::prepare::rain::frames`]), the axes
//! ([`crate::geodata::cf_axes`]) and times ([`crate::prepare::rain::times`]) of a NetCDF file.

use std::path::{Path, PathBuf};

use crate::calendar::UtcTime;
use crate::error::{Problem, ProblemKind, input_error, input_warning};
use crate::geodata::cf_axes::{check_axes_are_known, check_order, gdal_name, is_netcdf, split_variable, text_of};
use crate::geodata::{Crs, Table, read_text, readable_file};
use crate::math::readable;
use crate::prepare::findings::Findings;
use crate::prepare::rain::Losses;
use crate::prepare::rain::times::{self, SAME_TIME, Start, Times};
use crate::prepare::tables::dates::{self, Dates, Origin};
use crate::prepare::tables::rows::{in_lines, rows_are};
use crate::prepare::tables::series::choose;
use crate::prepare::tables::times::takes_little;
use crate::scenario::units::{INTENSITY, LENGTH, TIME};
use crate::scenario::{ColumnUnit, RainUnit, Scenario, Sourced, Stamp, VectorSource};
use crate::terrain::RasterFile;

/// A step of time longer than so many of the usual ones is a gap.
const GAP: f64 = 1.5;

/// Rasters with their times, their values not yet read.
#[derive(Debug)]
pub struct Opened {
    /// Beginning and end (s) of each raster.
    pub intervals: Vec<(f64, f64)>,
    pub rasters: Rasters,
    pub unit: RainUnit,
    pub losses: Losses,
    /// Reference system of the run.
    pub crs: Crs,
}

/// Where the rasters are.
#[derive(Debug)]
pub enum Rasters {
    /// Bands of one file.
    Bands(Box<RasterFile>),
    /// Files of one raster each.
    Files(Vec<PathBuf>),
}

/// What the scenario says of the series.
pub struct Asked<'a> {
    pub file: &'a Sourced<VectorSource>,
    pub unit: Option<RainUnit>,
    pub stamp: Option<Stamp>,
    /// Date of the file at which the run begins.
    pub start: Option<UtcTime>,
}

/// Opens the file and finds the interval of each raster; none after an error.
pub fn open(
    asked: &Asked,
    losses: Losses,
    scenario: &Scenario,
    crs: Option<&Crs>,
    findings: &mut Findings,
) -> Option<Opened> {
    let path = &asked.file.value.path;
    findings.take(asked.file, readable_file(path))?;
    let reference = scenario.reference_time;
    // Dates have no unit, and the times of a NetCDF file have theirs beside them.
    let (times, rasters, unit, has_unit) = if is_netcdf(path) {
        let (times, rasters, unit) = findings.take(asked.file, netcdf_series(asked, reference))?;
        (times, rasters, unit, false)
    } else {
        let List { times, files, unit, is_dated } = findings.take_all(asked.file, list_series(asked, reference))?;
        (Times { times, bounds: None }, Rasters::Files(files), unit, !is_dated)
    };
    let name = path.display().to_string();
    let intervals = findings.take(asked.file, intervals(&times, asked.stamp, &name))?;
    let gaps = coverage(&intervals, losses.until, times.bounds.is_some(), &name);
    findings.add_all(asked.file, gaps);
    if has_unit {
        findings.add_all(asked.file, far_beyond(&intervals, losses.until, &name));
    }
    Some(Opened { intervals, rasters, unit, losses, crs: crs?.clone() })
}

/// A NetCDF variable of three dimensions, the first of which is the time.
fn netcdf_series(asked: &Asked, reference: Option<UtcTime>) -> Result<(Times, Rasters, RainUnit), Problem> {
    let path = &asked.file.value.path;
    let name = path.display().to_string();
    let file = netcdf::open(path).map_err(|cause| times::not_netcdf(&name, &cause))?;
    let variable = rain_variable(&file, asked.file.value.layer.as_deref(), &name)?;
    check_order(&file, &variable, &name)?;
    check_axes_are_known(&file, &variable, &name)?;
    let times = times::read(&file, &variable, Start { own: asked.start, reference }, &name)?;
    let unit = netcdf_unit(asked, &variable, &name)?;
    let raster = RasterFile::open_as(path, &gdal_name(path, &variable.name()))?;
    if raster.bands() != times.times.len() {
        let cause = format!("it has {} rasters and {} times", raster.bands(), times.times.len());
        return Err(times::no_time(&variable.name(), &name, cause));
    }
    Ok((times, Rasters::Bands(Box::new(raster)), unit))
}

/// The variable of that name, or the only one of time, y and x.
fn rain_variable<'a>(file: &'a netcdf::File, asked: Option<&str>, name: &str) -> Result<netcdf::Variable<'a>, Problem> {
    let of_three: Vec<netcdf::Variable<'a>> = file.variables().filter(|v| v.dimensions().len() == 3).collect();
    let names = of_three.iter().map(|variable| variable.name()).collect::<Vec<_>>().join(", ");
    let listed = if names.is_empty() { "it has none".to_owned() } else { format!("it has {names}") };
    let count = of_three.len();
    let mut fitting = of_three.into_iter().filter(|variable| asked.is_none_or(|asked| variable.name() == asked));
    match (fitting.next(), asked) {
        (Some(variable), Some(_)) => Ok(variable),
        (Some(variable), None) if count == 1 => Ok(variable),
        (None, Some(asked)) => {
            let message = format!("{name} has no variable `{asked}` of time, y and x");
            Err(input_error("no-variable", message).with_cause(listed).with_remedy("correct the name behind the colon"))
        }
        (_, None) => {
            let message = format!("which variable of {name} is the rain is not known");
            let remedy = "name one behind a colon, as in `radar.nc:rainfall`; its dimensions are time, y and x";
            Err(input_error("no-variable", message).with_cause(listed).with_remedy(remedy))
        }
    }
}

/// The unit of the scenario, which must agree with that of the variable, or else the latter.
fn netcdf_unit(asked: &Asked, variable: &netcdf::Variable, name: &str) -> Result<RainUnit, Problem> {
    let written = text_of(variable, "units");
    let own = written.as_deref().and_then(unit_of_file);
    match (asked.unit, own, written) {
        (Some(asked), _, written) => {
            check_unit(asked, &written.unwrap_or_default(), &format!("`{}` of {name}", variable.name())).map(|()| asked)
        }
        (None, Some(unit), _) => Ok(unit),
        (None, None, written) => {
            let cause = written.as_deref().and_then(times_time);
            let found = match (written, &cause) {
                (None, _) => "no unit".to_owned(),
                (Some(written), None) => format!("the unit `{written}`, which is not known"),
                (Some(written), Some(_)) => format!("the unit `{written}`, which is none of rain"),
            };
            let message = format!("`{}` of {name} has {found}", variable.name());
            let problem = input_error("missing-unit", message).with_remedy(unit_remedy());
            Err(cause.into_iter().fold(problem, Problem::with_cause))
        }
    }
}

/// Refuses a file whose own unit, where it is one of rain, is another than that of the scenario.
pub fn check_unit(asked: RainUnit, written: &str, name: &str) -> Result<(), Problem> {
    match unit_of_file(written) {
        Some(own) if !is_same(asked, own) => {
            let message = format!("{name} says `{written}`, and the scenario another unit");
            let remedy =
                "let the scenario say the `unit` of the file, or correct that of the file (`ncatted` for NetCDF)";
            Err(input_error("other-unit", message).with_remedy(remedy))
        }
        _ => Ok(()),
    }
}

fn unit_remedy() -> String {
    format!(
        "add `unit: mm/h` or another one of {}; or `unit: mm` or another one of {} for what falls within each interval",
        INTENSITY.unit_list(),
        LENGTH.unit_list()
    )
}

fn is_same(a: RainUnit, b: RainUnit) -> bool {
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
    match (a, b) {
        (RainUnit::Intensity(a), RainUnit::Intensity(b)) | (RainUnit::Depth(a), RainUnit::Depth(b)) => near(a, b),
        _ => false,
    }
}

/// The unit of rain in the spellings of UDUNITS; a kilogram of water on a square metre is a millimetre.
fn unit_of_file(text: &str) -> Option<RainUnit> {
    if let Some(unit) = RainUnit::named(text.trim()) {
        return Some(unit);
    }
    let factors = factors_of(text)?;
    let (amount, rest) = match &factors[..] {
        [("kg", 1), ("m", -2), rest @ ..] => (1e-3, rest),
        [(length, 1), rest @ ..] => (LENGTH.factor_of(length)?, rest),
        _ => return None,
    };
    match rest {
        [] => Some(RainUnit::Depth(amount)),
        [(time, -1)] => seconds_of_unit(time).map(|seconds| RainUnit::Intensity(amount / seconds)),
        _ => None,
    }
}

/// The factors of a unit with their powers: `mm h-1`, `mm.h^-1`, `mm h**-1`, `mm / h`, `mm*h-1`.
fn factors_of(text: &str) -> Option<Vec<(&str, i32)>> {
    let mut factors = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        let (is_divided, begin) = match rest.find(|c: char| c.is_alphanumeric()) {
            Some(begin) if rest[..begin].chars().all(|c| " ./*".contains(c)) => (rest[..begin].contains('/'), begin),
            _ => return None,
        };
        rest = &rest[begin..];
        let (name, after) = rest.split_at(rest.find(|c: char| !c.is_alphabetic()).unwrap_or(rest.len()));
        let power = after.strip_prefix("**").or(after.strip_prefix('^')).unwrap_or(after);
        let sign = power.len() - power.trim_start_matches(['-', '+']).len();
        let end = power[sign..].find(|c: char| !c.is_ascii_digit()).map_or(power.len(), |digits| sign + digits);
        let written = &power[..end];
        let power_of_name = if end > 0 { written.parse::<i32>().ok()? } else { 1 };
        // What stands behind the name without a power is the next factor's.
        rest = if end > 0 { &power[end..] } else { after };
        factors.push((name, if is_divided { -power_of_name } else { power_of_name }));
    }
    Some(factors).filter(|factors| factors.iter().all(|(name, _)| !name.is_empty()))
}

/// Seconds of a unit of time in the spellings of UDUNITS.
fn seconds_of_unit(name: &str) -> Option<f64> {
    match name {
        "hr" | "hour" => Some(3600.0),
        "sec" | "second" => Some(1.0),
        "minute" => Some(60.0),
        "day" => Some(86_400.0),
        "ms" => None,
        _ => TIME.factor_of(name),
    }
}

/// What is wrong with a unit that is an amount of rain times a time, where one per time is meant.
fn times_time(text: &str) -> Option<String> {
    let factors = factors_of(text)?;
    let (time, _) = factors.last().filter(|(name, power)| *power == 1 && seconds_of_unit(name).is_some())?;
    let amount = text.trim().strip_suffix(time)?.trim_end_matches([' ', '.', '*']);
    unit_of_file(amount).filter(|unit| matches!(unit, RainUnit::Depth(_)))?;
    Some(format!(
        "it is `{amount}` times `{time}`, a depth times a time; an intensity is written `{amount} {time}-1` or `{amount}/{time}`"
    ))
}

/// A list of rasters as it is read.
struct List {
    /// Times (s).
    times: Vec<f64>,
    files: Vec<PathBuf>,
    unit: RainUnit,
    /// Whether the times are dates in the file.
    is_dated: bool,
}

/// A CSV list: a column of times, dates or numbers with their unit at the end of its name, and one of files.
fn list_series(asked: &Asked, reference: Option<UtcTime>) -> Result<List, Vec<Problem>> {
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
                text.parse::<f64>().ok().filter(|time| time.is_finite()).map(|time| time * factor)
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

/// The interval of each raster (s).
fn intervals(times: &Times, stamp: Option<Stamp>, name: &str) -> Result<Vec<(f64, f64)>, Problem> {
    let Times { times, bounds } = times;
    let sort = "sort the rasters by time, and take out what stands there twice";
    if let Some(pair) = times.windows(2).find(|pair| pair[1].partial_cmp(&pair[0]) != Some(std::cmp::Ordering::Greater))
    {
        let message = format!("the times of {name} do not rise: {} s stands behind {} s", pair[1], pair[0]);
        return Err(input_error("not-rising", message).with_remedy(sort));
    }
    if let Some(bounds) = bounds {
        if stamp.is_some() {
            let message = format!("the times of {name} have bounds, which say to which interval each belongs");
            return Err(input_error("stamp-beside-bounds", message).with_remedy("take `stamp` out"));
        }
        let empty = bounds.iter().find(|(from, to)| from.partial_cmp(to) != Some(std::cmp::Ordering::Less));
        if let Some((from, to)) = empty {
            let message = format!("the bounds of a time in {name} are {from} s and {to} s");
            return Err(
                input_error("bad-bounds", message).with_remedy("the second of two bounds must be the later one")
            );
        }
        let overlapping = |pair: &&[(f64, f64)]| pair[1].0 < pair[0].1 - SAME_TIME * (pair[0].1 - pair[0].0);
        if let Some(pair) = bounds.windows(2).find(overlapping) {
            let message = format!("two rasters of {name} hold at once, from {} s to {} s", pair[1].0, pair[0].1);
            return Err(input_error("bad-bounds", message).with_remedy(sort));
        }
        return Ok(bounds.clone());
    }
    let [first, .., last] = times[..] else {
        let message = format!("{name} has {} rasters, so that the interval of none is known", times.len());
        return Err(input_error("too-few-rasters", message)
            .with_remedy("give at least two, or take `raster` for rain that stays the same"));
    };
    let count = times.len();
    let mut edges = times.clone();
    match stamp.unwrap_or_default() {
        Stamp::Begin => edges.push(last + (last - times[count - 2])),
        Stamp::End => edges.insert(0, first - (times[1] - first)),
    }
    Ok(edges.windows(2).map(|pair| (pair[0], pair[1])).collect())
}

/// Whether the intervals hold from the start of the run to the end of the rain (s), and have no gap.
fn coverage(intervals: &[(f64, f64)], until: f64, has_bounds: bool, name: &str) -> Vec<Problem> {
    let mut found = Vec::new();
    let (Some(first), Some(last)) = (intervals.first(), intervals.last()) else { return found };
    let slack = SAME_TIME * (last.1 - last.0);
    if first.0 > slack {
        let message = format!("the first raster of {name} begins {} s after the start of the run", first.0);
        let remedy = "give a raster from time 0 on, with zeros where it does not rain, or correct `start`, `stamp` or the unit of the times";
        found.push(input_error("series-starts-late", message).with_remedy(remedy));
    }
    if last.1 < until - slack {
        let message = format!("the last raster of {name} ends at {} s, before the rain does at {until} s", last.1);
        let remedy = "give rasters up to the end, with zeros where it does not rain, say when the rain ends (`rain.duration`), shorten `time.end`, or correct the unit of the times";
        found.push(input_error("series-ends-early", message).with_remedy(remedy));
    }
    let mut lengths: Vec<f64> = intervals.iter().map(|(from, to)| to - from).collect();
    lengths.sort_by(f64::total_cmp);
    let usual = lengths[lengths.len() / 2];
    let matters = |from: f64, to: f64| to > 0.0 && from < until;
    let holes = intervals.windows(2).map(|pair| (pair[0].1, pair[1].0));
    if let Some((from, to)) = holes.clone().find(|(from, to)| to - from > SAME_TIME * usual && matters(*from, *to)) {
        let message = format!("{name} has no raster from {from} s to {to} s");
        found.push(input_error("series-gap", message).with_remedy("fill the gap, with zeros where it does not rain"));
    }
    let long: Vec<_> = intervals.iter().filter(|(from, to)| to - from > GAP * usual && matters(*from, *to)).collect();
    if let Some((from, to)) = long.first().filter(|_| !has_bounds) {
        let others = if long.len() > 1 { format!(", and {} more", long.len() - 1) } else { String::new() };
        let message = format!("{name} has a gap from {from} s to {to} s, where a step of {usual} s is usual{others}");
        let problem = Problem::warning(ProblemKind::Input, "series-gap", "", message);
        found.push(
            problem.with_cause("one raster holds for all of that time").with_remedy("add the rasters that are missing"),
        );
    }
    found
}

/// Warns of a list of which the rain (until a time, s) takes so little that its times may have another unit.
fn far_beyond(intervals: &[(f64, f64)], until: f64, name: &str) -> Option<Problem> {
    let last = intervals.last()?.1;
    let taken = intervals.partition_point(|(from, _)| *from < until);
    takes_little(taken, until, last).then(|| {
        let message = format!(
            "of {name} the run takes {taken} of {} rasters: the rain ends at {} s, the last raster at {} s, {:.0} times as late",
            intervals.len(),
            readable(until),
            readable(last),
            last / until
        );
        input_warning("series-far-beyond", message)
            .with_cause("is the unit of its times right? it ends the name of their column")
            .with_remedy("nothing, if the run is to see so little of it; otherwise correct that name, or `time.end`")
    })
}

#[cfg(test)]
mod tests;
