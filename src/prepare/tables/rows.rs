//! Rows of tables, and how their faults are named.

use crate::error::{Problem, input_error};
use crate::scenario::units::{DISCHARGE, Dimension};
use crate::terrain::PLAUSIBLE_ELEVATION;

/// So many faulty rows are named one by one.
const NAMED_ROWS: usize = 5;

/// What the values of a series may be.
#[derive(Clone, Copy, Debug)]
pub struct Meaning {
    /// Their dimension.
    pub dimension: &'static Dimension,
    /// What to do about values below 0; none of levels, which may be negative.
    pub negative: Option<&'static str>,
}

/// Discharges that come in.
pub const COMING: Meaning = Meaning {
    dimension: &DISCHARGE,
    negative: Some("give what comes in as a positive number; water that leaves needs a boundary of its own"),
};

/// A row of a table: its line in the file and its numbers.
pub struct Row<const COLUMNS: usize = 2> {
    pub line: usize,
    /// In SI units.
    pub numbers: [f64; COLUMNS],
    /// As the file has them; dates as in `numbers`.
    pub written: [f64; COLUMNS],
    /// Whether its time is a date.
    pub is_dated: bool,
}

pub fn rows_are(count: usize) -> String {
    if count == 1 { "one row has".to_owned() } else { format!("{count} rows have") }
}

/// One problem for all faulty rows, the first of them by line.
pub fn in_lines(
    faulty: impl Iterator<Item = (usize, String)>,
    code: &'static str,
    message: impl FnOnce(usize, &str) -> String,
    remedy: &str,
) -> Option<Problem> {
    let faulty: Vec<(usize, String)> = faulty.collect();
    if faulty.is_empty() {
        return None;
    }
    let one = |(line, text): &(usize, String)| {
        if text.is_empty() { format!("line {line}") } else { format!("line {line} (`{text}`)") }
    };
    let mut lines = faulty.iter().take(NAMED_ROWS).map(one).collect::<Vec<_>>().join(", ");
    if faulty.len() > NAMED_ROWS {
        lines += &format!(" and {} more", faulty.len() - NAMED_ROWS);
    }
    Some(input_error(code, message(faulty.len(), &lines)).with_remedy(remedy))
}

/// The problem of rows with a value below 0 in their second column.
pub fn negative(rows: &[Row], name: &str, remedy: &str) -> Option<Problem> {
    let below = rows.iter().filter(|row| row.numbers[1] < 0.0);
    in_lines(
        below.map(|row| (row.line, row.written[1].to_string())),
        "negative-value",
        |count, lines| format!("{} a value below 0 in {name}: {lines}", rows_are(count)),
        remedy,
    )
}

/// The problem of rows with a level in one of their columns that no ground and no water has.
pub fn implausible<const COLUMNS: usize>(rows: &[Row<COLUMNS>], column: usize, name: &str) -> Option<Problem> {
    let odd = rows.iter().filter(|row| !PLAUSIBLE_ELEVATION.contains(&row.numbers[column]));
    in_lines(
        odd.map(|row| (row.line, row.written[column].to_string())),
        "implausible-level",
        |count, lines| format!("{} a level that is none on Earth, in {name}: {lines}", rows_are(count)),
        "leave out the rows of a code for missing values, or correct the unit or the datum",
    )
}

/// The problem of rows with a number in one of their columns that is greater than any of its kind.
pub fn beyond_earth<const COLUMNS: usize>(
    rows: &[Row<COLUMNS>],
    column: usize,
    dimension: &Dimension,
    name: &str,
) -> Option<Problem> {
    let beyond = rows.iter().filter(|row| row.numbers[column].abs() > dimension.most);
    in_lines(
        beyond.map(|row| (row.line, format!("{:e}", row.written[column]))),
        "implausible-value",
        |count, lines| {
            let unit = dimension.units.iter().find(|unit| (unit.1 - 1.0).abs() <= 0.0).map_or("", |unit| unit.0);
            let most = dimension.most;
            let bound = if most < 1e4 { most.to_string() } else { format!("{most:e}") };
            let what = format!("{} beyond {bound} {unit}", dimension.name);
            format!("{} {what}, in {name}: {lines}", rows_are(count))
        },
        "leave out the rows of a code for missing values, or correct the unit",
    )
}

/// The factor of the unit at the end of a column's name: `q [m3/s]`, `q (m3/s)` or `q_m3_s`.
pub fn unit_in_name(name: &str, dimension: &Dimension) -> Option<f64> {
    let inside = name.strip_suffix([']', ')']).and_then(|rest| rest.rsplit_once(['[', '(']));
    if let Some((_, unit)) = inside {
        return dimension.factor_of(unit.trim());
    }
    let ends = |unit: &&(&str, f64)| name.ends_with(&format!("_{}", unit.0.replace('/', "_")));
    dimension.units.iter().filter(ends).max_by_key(|unit| unit.0.len()).map(|unit| unit.1)
}
