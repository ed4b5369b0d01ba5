//! What other codes made of the same cases, read from a table that somebody else measured: points for a chart.

use std::path::Path;

use super::row::{Field, fields_of};
use crate::error::{Place, Problem, ProblemKind};

/// One run of another code.
#[derive(Clone, Debug, PartialEq)]
pub struct Peer {
    /// Name of one of our cases.
    pub case: String,
    /// How its errors are averaged, in the names of our rows.
    pub norm: String,
    /// The code.
    pub code: String,
    /// Spacing (m).
    pub spacing: f64,
    /// Processor time (s).
    pub cpu_s: f64,
    /// Error of the depth (m).
    pub error_depth: Option<f64>,
    /// Error of the velocity (m/s).
    pub error_velocity: Option<f64>,
}

/// The columns that are read; others may stand beside them, in any order.
pub const PEER_COLUMNS: [&str; 7] = ["case", "norm", "code", "spacing_m", "cpu_s", "error_depth", "error_velocity"];

/// Reads a table with a heading; lines that begin with `#` are remarks.
///
/// # Errors
/// Every problem with its line and column: a column that is missing, a number that is none or not above 0.
pub fn peers_from_csv(text: &str, file: &Path) -> Result<Vec<Peer>, Vec<Problem>> {
    let mut records = fields_of(text).into_iter().filter(|record| !record[0].text.starts_with('#'));
    let heading = records.next().unwrap_or_default();
    let is_missing = |name: &&str| !heading.iter().any(|field| field.text.trim() == *name);
    let missing: Vec<&str> = PEER_COLUMNS.into_iter().filter(is_missing).collect();
    let mut problems = Vec::new();
    let mut report = |(line, column): (usize, usize), code, message: String, remedy: &str| {
        let place = Place { file: file.to_owned(), line, column };
        let problem = Problem::error(ProblemKind::Input, code, "", message).with_place(Some(place));
        problems.push(problem.with_remedy(remedy));
    };
    let place = heading.first().map_or((1, 1), |field| field.place);
    for name in &missing {
        let remedy = format!("the heading names the columns {}", PEER_COLUMNS.join(", "));
        report(place, "missing-column", format!("the column `{name}` is missing"), &remedy);
    }
    if !missing.is_empty() {
        return Err(problems);
    }
    let columns = PEER_COLUMNS.map(|name| heading.iter().position(|field| field.text.trim() == name).unwrap_or(0));
    let mut peers = Vec::new();
    for record in records {
        if record.len() != heading.len() {
            let message = format!("a line of {} fields under a heading of {}", record.len(), heading.len());
            report(record[0].place, "table", message, "put text with commas in double quotes");
            continue;
        }
        let field = |k: usize| &record[columns[k]];
        let mut number = |field: &Field, may_be_empty: bool| {
            let text = field.text.trim();
            let value = text.parse().ok().filter(|value: &f64| value.is_finite() && *value > 0.0);
            if value.is_none() && !(may_be_empty && text.is_empty()) {
                report(
                    field.place,
                    "table",
                    format!("`{text}` is not a number above 0"),
                    "correct it, or take the line out",
                );
            }
            value
        };
        let (spacing, cpu_s) = (number(field(3), false), number(field(4), false));
        let (error_depth, error_velocity) = (number(field(5), true), number(field(6), true));
        if let (Some(spacing), Some(cpu_s)) = (spacing, cpu_s) {
            let name = |k: usize| field(k).text.trim().to_owned();
            let (case, norm, code) = (name(0), name(1), name(2));
            peers.push(Peer { case, norm, code, spacing, cpu_s, error_depth, error_velocity });
        }
    }
    if problems.is_empty() { Ok(peers) } else { Err(problems) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADING: &str = "# from elsewhere\ncode,case,norm,version,spacing_m,cpu_s,error_velocity,error_depth\n";

    #[test]
    fn columns_are_found_by_name() {
        let text = format!("{HEADING}\"some, code\",ritter,mean_abs_grid,1.0,7.8125,0.005,,0.0131\n# end");
        let peers = peers_from_csv(&text, Path::new("p.csv")).unwrap();
        let expected = Peer {
            case: "ritter".to_owned(),
            norm: "mean_abs_grid".to_owned(),
            code: "some, code".to_owned(),
            spacing: 7.8125,
            cpu_s: 0.005,
            error_depth: Some(0.0131),
            error_velocity: None,
        };
        assert_eq!(peers, [expected]);
    }

    #[test]
    fn every_problem_has_its_line_and_column() {
        let found = |text: &str| -> Vec<(&str, usize, usize)> {
            let problems = peers_from_csv(text, Path::new("p.csv")).unwrap_err();
            let of = |problem: &Problem| problem.place.as_ref().map(|place| (problem.code, place.line, place.column));
            problems.iter().map(|problem| of(problem).unwrap()).collect()
        };
        assert_eq!(found("case,norm,code,spacing_m,cpu_s,error_depth\n"), [("missing-column", 1, 1)]);
        assert_eq!(found("").len(), PEER_COLUMNS.len());
        let text = format!("{HEADING}a,b,c,,ten,0,,\na,b,c\n");
        assert_eq!(found(&text), [("table", 3, 8), ("table", 3, 12), ("table", 4, 1)]);
    }
}
