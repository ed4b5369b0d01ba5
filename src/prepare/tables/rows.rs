//! Rows of tables, and how their faults are named.

use crate::error::{Problem, input_error};
use crate::scenario::units::{DISCHARGE, Dimension};

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

/// The factor of the unit at the end of a column's name: `q [m3/s]`, `q (m3/s)` or `q_m3_s`.
pub fn unit_in_name(name: &str, dimension: &Dimension) -> Option<f64> {
    let inside = name.strip_suffix([']', ')']).and_then(|rest| rest.rsplit_once(['[', '(']));
    if let Some((_, unit)) = inside {
        return dimension.factor_of(unit.trim());
    }
    let ends = |unit: &&(&str, f64)| name.ends_with(&format!("_{}", unit.0.replace('/', "_")));
    dimension.units.iter().filter(ends).max_by_key(|unit| unit.0.len()).map(|unit| unit.1)
}
