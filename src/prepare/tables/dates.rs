//! Times of a table that are dates, as gauges deliver them: read from the start of the run on, and what is wrong with them.
//!
//! How a date is written: [`crate::calendar`]. Not here: times that are numbers with a unit ([`crate::prepare::tables::series`]), and NetCDF files
//! ([`crate::prepare::rain::times`]).

use crate::calendar::UtcTime;
use crate::error::{Problem, input_error};
use crate::prepare::tables::rows::{in_lines, rows_are, unit_in_name};
use crate::scenario::units::TIME;
use crate::scenario::{ColumnUnit, Scenario};

/// From what the times of a table count.
#[derive(Clone, Copy, Debug)]
pub enum Origin {
    /// The start of the run, where the scenario has its date.
    Start(Option<UtcTime>),
    /// A beginning of their own that has no date, such as the trigger of a breach.
    Own,
}

impl Origin {
    /// The start of the run.
    pub fn of_run(scenario: &Scenario) -> Self {
        Origin::Start(scenario.reference_time)
    }

    /// Seconds from it to a date; none of a text that is none. From an origin without a date they count from 1970,
    /// which [`faults`] refuses.
    pub fn seconds_to(self, text: &str) -> Option<f64> {
        let origin = match self {
            Origin::Start(start) => start.unwrap_or_default(),
            Origin::Own => UtcTime::default(),
        };
        UtcTime::read(text).ok().map(|date| date.seconds_since(origin))
    }
}

/// A column of dates.
pub struct Dates<'a> {
    /// Rows of the table with their lines.
    pub rows: &'a [(usize, Vec<String>)],
    /// Its number.
    pub column: usize,
    /// Its name in the first line of the file.
    pub header: &'a str,
    /// The file.
    pub name: &'a str,
}

/// What to write in place of a date that is not understood.
const FORM: &str = "write dates as `2026-06-01 06:00` or `2026-06-01T06:00:00Z`, the year first, those that are not UTC with their offset (`+02:00`); or all times as numbers in a column with a unit, such as `time_h`";

/// What to do about dates where none can be.
const NUMBERS: &str = "write times as numbers in a column with a unit, such as `time_h`";

fn is_number(text: &str) -> bool {
    text.parse::<f64>().is_ok()
}

/// Whether a text has the three parts of a date, in whatever order, existing or not.
fn has_a_day(text: &str) -> bool {
    let day = text.split(['T', ' ']).next().unwrap_or_default();
    let parts: Vec<&str> = day.split(['-', '.', '/']).collect();
    parts.len() == 3 && parts.iter().all(|part| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit()))
}

/// Whether a text is meant as a date or a time of day.
pub fn is_moment(text: &str) -> bool {
    !is_number(text) && (has_a_day(text) || text.contains(':') || UtcTime::read(text).is_ok())
}

/// Whether the times of a column are dates or times of day: at least as many as are numbers.
pub fn are_dates(rows: &[(usize, Vec<String>)], column: usize) -> bool {
    let fields = || rows.iter().filter_map(|(_, fields)| fields.get(column));
    let moments = fields().filter(|text| is_moment(text)).count();
    moments > 0 && moments >= fields().filter(|text| is_number(text)).count()
}

/// All that is wrong with a column of dates; empty fields are left to the reader of rows.
pub fn faults(dates: &Dates, asked: &ColumnUnit, origin: Origin) -> Vec<Problem> {
    let mut found = beside_unit(dates, asked);
    found.extend(without_start(dates, origin));
    let name = dates.name;
    let reported = || {
        let field = |(line, fields): &(usize, Vec<String>)| Some((*line, fields.get(dates.column)?.clone()));
        dates.rows.iter().filter_map(field).filter(|(_, text)| !text.is_empty())
    };
    found.extend(in_lines(
        reported().filter(|(_, text)| is_number(text)),
        "mixed-times",
        |count, lines| format!("{} a number among the dates of {name}: {lines}", rows_are(count)),
        "write all times as dates, or all as numbers in a column with a unit, such as `time_h`",
    ));
    let is_day_first = |text: &str| has_a_day(text) && text.split('-').next().is_none_or(|year| year.len() != 4);
    let unknown = || reported().filter(|(_, text)| !is_number(text) && UtcTime::read(text).is_err());
    let ambiguous = in_lines(
        unknown().filter(|(_, text)| is_day_first(text)),
        "ambiguous-date",
        |count, lines| format!("{} a date of which day and month can be confused, in {name}: {lines}", rows_are(count)),
        FORM,
    );
    found.extend(ambiguous);
    let fault = |(line, text): (usize, String)| Some(format!("line {line}: {}", UtcTime::read(&text).err()?));
    let cause = unknown().filter(|(_, text)| !is_day_first(text)).find_map(fault).unwrap_or_default();
    let unread = in_lines(
        unknown().filter(|(_, text)| !is_day_first(text)),
        "bad-date",
        |count, lines| {
            format!("{} no date that exists, or one in a form that is not read, in {name}: {lines}", rows_are(count))
        },
        FORM,
    );
    found.extend(unread.map(|problem| problem.with_cause(cause)));
    found
}

/// The problems of a unit of dates, in the scenario and in the name of the column.
fn beside_unit(dates: &Dates, asked: &ColumnUnit) -> Vec<Problem> {
    let (name, header) = (dates.name, dates.header);
    let written = asked.unit.as_ref().map(|(unit, _)| {
        let message = format!("the times of {name} are dates, and the scenario gives them the unit `{unit}`");
        input_error("unit-beside-dates", message).with_remedy("take `time_unit` out")
    });
    let named = unit_in_name(header, &TIME).map(|_| {
        let message = format!("the times of {name} are dates, and the name of their column has a unit: `{header}`");
        input_error("unit-beside-dates", message).with_remedy("name the column without a unit, such as `time`")
    });
    written.into_iter().chain(named).collect()
}

/// The problem of dates where the date from which times count is not known.
fn without_start(dates: &Dates, origin: Origin) -> Option<Problem> {
    let field = |(line, fields): &(usize, Vec<String>)| Some((*line, fields.get(dates.column)?.clone()));
    let (line, text) = dates.rows.iter().filter_map(field).find(|(_, text)| has_a_day(text))?;
    let are = format!("the times of {} are dates: line {line} (`{text}`)", dates.name);
    match origin {
        Origin::Start(Some(_)) => None,
        Origin::Start(None) => Some(
            input_error("dates-as-times", are).with_cause("the date of the start of the run is not known").with_remedy(
                format!("add `time.reference`, that date in UTC, such as \"2026-06-01 06:00:00\"; or {NUMBERS}"),
            ),
        ),
        Origin::Own => Some(
            input_error("dates-as-times", are)
                .with_cause("they count from the beginning of the motion or the growth, which has no date")
                .with_remedy(NUMBERS),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_and_times_of_day_are_told_from_numbers() {
        for text in
            ["2026-06-01", "2026-06-31 06:00", "01.06.2026 06:00", "6/1/2026", "06:00", "2026-06-01T06", "1-2-3"]
        {
            assert!(is_moment(text), "{text}");
        }
        for text in ["5", "-0.5", "1e-3", "1.5e-3", "", "q", "12-13", "1,5", "nan"] {
            assert!(!is_moment(text), "{text}");
        }
    }

    #[test]
    fn faults_of_dates_are_told_by_line_all_at_once() {
        let fields = ["2026-06-01 06:00", "2026-06-31 06:00", "01.06.2026", "7200", "", "2026-06-01T08:00:00+02:00"];
        let rows: Vec<(usize, Vec<String>)> =
            fields.iter().enumerate().map(|(k, text)| (k + 2, vec![(*text).to_owned()])).collect();
        let dates = Dates { rows: &rows, column: 0, header: "time_h", name: "x" };
        let asked = ColumnUnit { name: None, unit: Some(("min".to_owned(), 60.0)) };
        let found: Vec<(&str, String)> = faults(&dates, &asked, Origin::Start(None))
            .into_iter()
            .map(|problem| (problem.code, problem.message))
            .collect();
        let expected = [
            ("unit-beside-dates", "gives them the unit `min`"),
            ("unit-beside-dates", "`time_h`"),
            ("dates-as-times", "line 2 (`2026-06-01 06:00`)"),
            ("mixed-times", "line 5 (`7200`)"),
            ("ambiguous-date", "line 4 (`01.06.2026`)"),
            ("bad-date", "line 3 (`2026-06-31 06:00`)"),
        ];
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for ((code, message), (wanted, text)) in found.iter().zip(expected) {
            assert!(*code == wanted && message.contains(text), "{code}: {message}");
        }
    }
}
