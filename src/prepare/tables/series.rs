//! Series and rating curves from CSV files: every row checked, each fault with its line.

use crate::boundary::{Rating, Series};
use crate::error::{Problem, Severity, input_error};
use crate::geodata::{Table, read_text, readable_file};
use crate::scenario::units::{DISCHARGE, Dimension, LENGTH, SHARE, TIME};
use crate::scenario::{ColumnUnit, TableFile, Timed};

use crate::prepare::findings::Findings;
use crate::prepare::tables::dates::{self, Dates, Origin};
use crate::prepare::tables::rows::{
    Meaning, Row, beyond_earth, implausible, in_lines, negative, rows_are, unit_in_name,
};
use crate::prepare::tables::times;

/// A column of a table, as it is read.
#[derive(Clone, Copy)]
struct Column {
    index: usize,
    /// The factor of its unit; none of dates.
    factor: Option<f64>,
    dimension: &'static Dimension,
}

impl Column {
    /// Its field as it is written, and in SI units; none where it is empty or no number. A date that cannot be read is 0: it is reported
    /// with the other dates.
    fn read(self, fields: &[String], origin: Origin) -> Option<(f64, f64)> {
        let text = fields.get(self.index)?;
        match self.factor {
            Some(factor) => {
                text.parse::<f64>().ok().filter(|value| value.is_finite()).map(|value| (value, value * factor))
            }
            None if text.is_empty() => None,
            None => Some(origin.seconds_to(text).unwrap_or(0.0)).map(|seconds| (seconds, seconds)),
        }
    }
}

/// The series of a quantity, which must hold from its origin to an end (s); none after an error.
pub fn series(
    timed: &Timed,
    meaning: Meaning,
    (end, origin): (f64, Origin),
    findings: &mut Findings,
) -> Option<Series> {
    let table = match timed {
        Timed::Constant(value) => return Some(Series::constant(value.value)),
        Timed::Series(table) => table,
    };
    let rows = findings.take_all(&table.file, rows(table, [&TIME, meaning.dimension], origin))?;
    let name = table.file.value.display();
    let mut faults = Vec::new();
    rises(&rows, &name.to_string(), ("time", SORT), &mut faults);
    faults.extend(match meaning.negative {
        Some(remedy) => negative(&rows, &name.to_string(), remedy),
        None => implausible(&rows, 1, &name.to_string()),
    });
    if faults.is_empty() {
        faults.extend(times::coverage(&rows, &name.to_string(), (end, table.after_end)));
    }
    let is_sound = faults.iter().all(|fault| fault.severity == Severity::Warning);
    findings.add_all(&table.file, faults);
    let points: Vec<(f64, f64)> = rows.iter().map(|row| (row.numbers[0], row.numbers[1])).collect();
    if is_sound { Series::new(&points) } else { None }
}

/// A rating curve; none after an error.
pub fn rating(table: &TableFile, findings: &mut Findings) -> Option<Rating> {
    let rows = findings.take_all(&table.file, rows(table, [&LENGTH, &DISCHARGE], Origin::Own))?;
    let name = table.file.value.display();
    let mut faults = Vec::new();
    let remedy = "give one discharge for each level, the levels rising: of a loop with a rising and a falling limb the mean of both, of a jump two rows a millimetre apart";
    rises(&rows, &name.to_string(), ("level", remedy), &mut faults);
    faults.extend(implausible(&rows, 0, &name.to_string()));
    faults.extend(negative(
        &rows,
        &name.to_string(),
        "give what leaves as a positive number, and leave out the rows of a code for missing values",
    ));
    faults.extend(in_lines(
        rows.windows(2).filter(|pair| pair[1].numbers[1] < pair[0].numbers[1]).map(|p| (p[1].line, String::new())),
        "falling-discharge",
        |count, lines| format!("{} less discharge at a higher level in {name}: {lines}", rows_are(count)),
        "a rating curve rises with the level, or stays",
    ));
    if rows.len() < 2 {
        faults.push(
            input_error("short-table", format!("{name} has fewer than two rows"))
                .with_remedy("give at least the level at which water begins to leave, and one above it"),
        );
    }
    if let Some(first) = rows.first().filter(|row| row.numbers[1] != 0.0) {
        faults.push(
            input_error(
                "rating-start",
                format!("the rating curve of {name} begins with {} m3/s in line {}", first.numbers[1], first.line),
            )
            .with_cause("below its first level nothing leaves: the discharge would jump there")
            .with_remedy("let it begin at the level at which the discharge is 0"),
        );
    }
    let is_sound = faults.is_empty();
    findings.add_all(&table.file, faults);
    let points: Vec<(f64, f64)> = rows.iter().map(|row| (row.numbers[0], row.numbers[1])).collect();
    if is_sound { Rating::new(&points) } else { None }
}

/// The growth of something from nothing to all of it, over the seconds since its beginning; none after an error.
pub fn growth(table: &TableFile, findings: &mut Findings) -> Option<Series> {
    let read = rows_of(&table.file.value, &table.columns, [&TIME, &SHARE], ("time_min,share", Origin::Own));
    let rows = findings.take_all(&table.file, read)?;
    let name = table.file.value.display();
    let mut faults = Vec::new();
    rises(&rows, &name.to_string(), ("time", SORT), &mut faults);
    let shrunk = rows.windows(2).filter(|pair| pair[1].numbers[1] < pair[0].numbers[1]);
    faults.extend(in_lines(
        shrunk.map(|pair| (pair[1].line, format!("{} after {}", pair[1].numbers[1], pair[0].numbers[1]))),
        "falling-share",
        |count, lines| format!("{} a smaller share than the row before, in {name}: {lines}", rows_are(count)),
        "what has gone does not come back: let the share rise, or stay",
    ));
    if rows.len() < 2 {
        let problem = input_error("short-table", format!("{name} has fewer than two rows"));
        faults.push(problem.with_remedy("give at least the beginning (time 0, share 0) and the end (share 1)"));
    } else if let (Some(first), Some(last)) = (rows.first(), rows.last()) {
        if first.numbers != [0.0, 0.0] {
            let [time, share] = first.numbers;
            let message = format!("{name} begins with a share of {share} at {time} s (line {})", first.line);
            let remedy = "begin with the time 0 and the share 0; times count from the trigger, shares from 0 to 1 (or 0 to 100 in `%`)";
            faults.push(input_error("growth-start", message).with_remedy(remedy));
        }
        if (last.numbers[1] - 1.0).abs() > 0.0 {
            let message = format!("{name} ends with a share of {} (line {})", last.numbers[1], last.line);
            let remedy = "end with the share 1 (100 in `%`): it is that of the final opening; for a smaller one, give its own `shape`";
            faults.push(input_error("growth-end", message).with_remedy(remedy));
        }
    }
    let is_sound = faults.is_empty();
    faults.extend(times::gap(&rows, &name.to_string(), 0.0).filter(|_| is_sound));
    findings.add_all(&table.file, faults);
    let points: Vec<(f64, f64)> = rows.iter().map(|row| (row.numbers[0], row.numbers[1])).collect();
    if is_sound { Series::new(&points) } else { None }
}

/// What to do about times that do not rise.
const SORT: &str = "sort the rows, and take out what stands there twice";

/// Refuses a column that does not rise from row to row; with what it is and what to do.
fn rises(rows: &[Row], name: &str, (what, remedy): (&str, &str), faults: &mut Vec<Problem>) {
    let fallen = rows.windows(2).filter(|pair| pair[1].numbers[0] <= pair[0].numbers[0]);
    faults.extend(in_lines(
        fallen.map(|pair| (pair[1].line, String::new())),
        "not-rising",
        |count, lines| {
            format!("{} a {what} that is not above that of the row before, in {name}: {lines}", rows_are(count))
        },
        remedy,
    ));
}

/// Two columns of a table in SI units, every row read.
fn rows(table: &TableFile, dimensions: [&'static Dimension; 2], origin: Origin) -> Result<Vec<Row>, Vec<Problem>> {
    rows_of(&table.file.value, &table.columns, dimensions, ("time_h,q_m3_s", origin))
}

/// The columns of a file in SI units, every row read; `example` is a first line as it may be, and times count from `origin`.
pub fn rows_of<const COLUMNS: usize>(
    path: &std::path::Path,
    columns: &[ColumnUnit; COLUMNS],
    dimensions: [&'static Dimension; COLUMNS],
    (example, origin): (&str, Origin),
) -> Result<Vec<Row<COLUMNS>>, Vec<Problem>> {
    let number_of_columns = if COLUMNS == 2 { "two".to_owned() } else { COLUMNS.to_string() };
    let name = path.display().to_string();
    readable_file(path).map_err(|problem| vec![problem])?;
    let text = read_text(path).map_err(|error| {
        let problem = input_error("not-a-table", format!("{name} is no table")).with_cause(error.to_string());
        vec![problem.with_remedy("name a CSV file whose first line holds the names of its columns")]
    })?;
    let parsed = Table::parse(&text, |_| true);
    let header = parsed.header.clone().unwrap_or_default();
    if header.len() < COLUMNS || header.iter().any(|field| field.parse::<f64>().is_ok()) {
        let problem =
            input_error("no-header", format!("the first line of {name} does not name {number_of_columns} columns"))
                .with_cause(format!("it reads `{}`", header.join(",")))
                .with_remedy(format!("begin it with a line such as `{example}`"));
        return Err(vec![problem]);
    }
    let (mut faults, mut found) = (Vec::new(), Vec::with_capacity(COLUMNS));
    for (place, (column, dimension)) in columns.iter().zip(dimensions).enumerate() {
        found.extend(find_column((column, place, dimension), (&parsed, &header, &name), origin, &mut faults));
    }
    let overlong = too_many_fields(&parsed, header.len(), &name);
    match <[Column; COLUMNS]>::try_from(found) {
        Ok(found) if overlong.is_none() => {
            let rows = read_rows(&parsed, &found, (&name, origin), &mut faults);
            if faults.is_empty() { Ok(rows) } else { Err(faults) }
        }
        _ => {
            faults.extend(overlong);
            Err(faults)
        }
    }
}

/// A column and how it is read; none after an error. Of dates every fault is reported.
fn find_column(
    (asked, place, dimension): (&ColumnUnit, usize, &'static Dimension),
    (parsed, header, name): (&Table, &[String], &str),
    origin: Origin,
    faults: &mut Vec<Problem>,
) -> Option<Column> {
    let found = index_of(asked, place, header, name).and_then(|index| {
        if dimension.name == TIME.name && dates::are_dates(&parsed.rows, index) {
            let dates = Dates { rows: &parsed.rows, column: index, header: &header[index], name };
            faults.extend(dates::faults(&dates, asked, origin));
            return Ok(Column { index, factor: None, dimension });
        }
        choose(asked, place, header, dimension, name).map(|(index, factor)| Column {
            index,
            factor: Some(factor),
            dimension,
        })
    });
    found.map_err(|problem| faults.push(*problem)).ok()
}

/// The problem of rows with more fields than the first line names.
fn too_many_fields(parsed: &Table, named: usize, name: &str) -> Option<Problem> {
    in_lines(
        parsed.overlong().map(|(line, fields)| (*line, fields.join(" | "))),
        "too-many-fields",
        |count, lines| {
            format!("{} more fields than the first line of {name}, which names {named}: {lines}", rows_are(count))
        },
        "write numbers with a point as decimal sign, or separate the columns with semicolons, and name every column",
    )
}

/// The rows of some columns; their faults go to the list.
fn read_rows<const COLUMNS: usize>(
    parsed: &Table,
    columns: &[Column; COLUMNS],
    (name, origin): (&str, Origin),
    faults: &mut Vec<Problem>,
) -> Vec<Row<COLUMNS>> {
    let is_dated = columns.iter().any(|column| column.factor.is_none());
    let (mut rows, mut faulty) = (Vec::with_capacity(parsed.rows.len()), Vec::new());
    for (line, fields) in &parsed.rows {
        let read: Vec<(f64, f64)> = columns.iter().filter_map(|column| column.read(fields, origin)).collect();
        match <[(f64, f64); COLUMNS]>::try_from(read) {
            Ok(read) => {
                let (written, numbers) = (read.map(|field| field.0), read.map(|field| field.1));
                rows.push(Row { line: *line, numbers, written, is_dated });
            }
            Err(_) => faulty.push((*line, fields)),
        }
    }
    let is_moment =
        |fields: &[String]| columns.iter().any(|c| fields.get(c.index).is_some_and(|f| dates::is_moment(f)));
    let has_moments = !is_dated && faulty.iter().any(|(_, fields)| is_moment(fields));
    let number = if COLUMNS == 2 { "two".to_owned() } else { COLUMNS.to_string() };
    let what = if is_dated { "no date and number".to_owned() } else { format!("no {number} numbers") };
    faults.extend(in_lines(
        faulty.into_iter().map(|(line, fields)| (line, fields.join(" | "))),
        "not-a-number",
        |count, lines| format!("{} {what} in {name}: {lines}", rows_are(count)),
        if has_moments {
            "write all times as numbers in a column with a unit, such as `time_h`, or all as dates"
        } else {
            "write numbers with a point as decimal sign, and leave out rows without a value"
        },
    ));
    for (place, column) in columns.iter().enumerate() {
        faults.extend(beyond_earth(&rows, place, column.dimension, name));
    }
    if rows.is_empty() && faults.is_empty() {
        faults.push(input_error("empty-table", format!("{name} has no rows")).with_remedy("give it at least one row"));
    }
    rows
}

/// The number of a column.
fn index_of(column: &ColumnUnit, place: usize, header: &[String], name: &str) -> Result<usize, Box<Problem>> {
    let Some(wanted) = &column.name else { return Ok(place) };
    let is_it = |field: &&String| field.eq_ignore_ascii_case(wanted);
    if header.iter().filter(is_it).count() > 1 {
        let problem = input_error("duplicate-column", format!("{name} has more than one column `{wanted}`"));
        return Err(Box::new(problem.with_remedy("give each column in the first line of the file its own name")));
    }
    header.iter().position(|field| is_it(&field)).ok_or_else(|| {
        let problem = input_error("missing-column", format!("{name} has no column `{wanted}`"));
        let problem = problem.with_cause(format!("its columns are {}", header.join(", ")));
        Box::new(problem.with_remedy("correct the name, or that in the first line of the file"))
    })
}

/// The number of a column and the factor of its unit.
pub fn choose(
    column: &ColumnUnit,
    place: usize,
    header: &[String],
    dimension: &'static Dimension,
    name: &str,
) -> Result<(usize, f64), Box<Problem>> {
    let index = index_of(column, place, header, name)?;
    if let Some((unit, factor)) = &column.unit {
        let contradicts = match unit_in_name(&header[index], dimension) {
            Some(own) => (own / factor - 1.0).abs() > 1e-9,
            None => dimension.name != LENGTH.name && names_a_length(&header[index]),
        };
        // Names end with `_s` that are no times, such as `q_m3_s`.
        let named = |field: &&String| dimension.name != TIME.name && unit_in_name(field, dimension).is_some();
        if column.name.is_none()
            && unit_in_name(&header[index], dimension).is_none()
            && let Some(other) = header.iter().find(named)
        {
            let message = format!("which column of {name} is meant is not known: `{}` or `{other}`", header[index]);
            return Err(Box::new(
                input_error("which-column", message)
                    .with_cause(format!(
                        "without a name column {} counts, and the unit stands at another one",
                        place + 1
                    ))
                    .with_remedy("name it in the scenario (`column`; of a rating curve `level` or `discharge`), or take the other one out of the file"),
            ));
        }
        if contradicts {
            let message =
                format!("the column `{}` of {name} names another unit than the scenario, `{unit}`", header[index]);
            let problem = input_error("contradicting-units", message);
            return Err(Box::new(
                problem.with_remedy("take the unit out of the scenario, or correct the name of the column"),
            ));
        }
        return Ok((index, *factor));
    }
    let bare = dimension.is_bare_allowed.then_some(1.0);
    unit_in_name(&header[index], dimension).or(bare).map(|factor| (index, factor)).ok_or_else(|| {
        let message = format!("the column `{}` of {name} has no unit of {}", header[index], dimension.name);
        let remedy = format!(
            "end the column's name with its unit, as in `{}_{}`, or name it in the scenario where there is a key for it (`unit`, `time_unit`; of a rating curve `level_unit`, `discharge_unit`); the units are {}",
            header[index].split(['_', ' ', '[', '(']).next().unwrap_or_default(),
            dimension.units[0].0.replace('/', "_"),
            dimension.unit_list()
        );
        Box::new(input_error("missing-unit", message).with_remedy(remedy))
    })
}

/// Whether a column's name ends with a unit of length, such as `rain_mm`; `m` and `in` end other names, too.
pub fn names_a_length(name: &str) -> bool {
    ["mm", "cm", "dm", "km", "ft"].iter().any(|unit| {
        let ends = [format!("_{unit}"), format!("[{unit}]"), format!("({unit})")];
        ends.iter().any(|end| name.ends_with(end))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_in_the_name_of_a_column_is_no_other_unit() {
        assert!(["rain_mm", "h [cm]", "depth (ft)"].iter().all(|name| names_a_length(name)));
        assert!(["rain", "q_in", "rain_mm_h", "q_m", "alarm"].iter().all(|name| !names_a_length(name)));
    }

    #[test]
    fn a_unit_is_read_from_the_name_of_a_column() {
        for (name, factor) in [("q_m3_s", 1.0), ("Q [l/s]", 1e-3), ("q (m3/s)", 1.0), ("inflow_m3_h", 1.0 / 3600.0)] {
            assert_eq!(unit_in_name(name, &DISCHARGE), Some(factor), "{name}");
        }
        assert_eq!(unit_in_name("time_min", &TIME), Some(60.0));
        assert_eq!(unit_in_name("q", &DISCHARGE), None);
        assert_eq!(unit_in_name("q [kg/s]", &DISCHARGE), None);
    }
}
