//! Results as a table for people.

use super::case::Case;
use super::missed::KNOWN_MISSES;
use super::row::Row;

const HEADING: [&str; 12] = [
    "case",
    "methods",
    "spacing m",
    "particles",
    "evaluations",
    "CPU s",
    "depth m",
    "order",
    "velocity m/s",
    "order",
    "max m/s",
    "status",
];

/// The rows as a table; what is not the default of the columns is named under `methods`.
pub fn table_of_rows(rows: &[Row]) -> String {
    let cells: Vec<[String; 12]> = rows.iter().map(cells).collect();
    let mut widths = HEADING.map(str::len);
    for row in &cells {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let line = |row: &[String; 12], rest: &str| {
        let mut text = String::new();
        for (k, (cell, width)) in row.iter().zip(widths).enumerate() {
            let is_text = k < 2 || k == 11;
            text += &if is_text { format!("{cell:<width$}  ") } else { format!("{cell:>width$}  ") };
        }
        format!("{}\n", (text + rest).trim_end())
    };
    let mut table = line(&HEADING.map(str::to_owned), "acceptance limit; note");
    for (row, cells) in rows.iter().zip(&cells) {
        let rest: Vec<&str> =
            [row.acceptance_limit.as_str(), row.note.as_str()].into_iter().filter(|text| !text.is_empty()).collect();
        table += &line(cells, &rest.join("; "));
    }
    table
}

fn cells(row: &Row) -> [String; 12] {
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.3e}"));
    let order = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
    [
        row.case.clone(),
        [&row.formulation, &row.motion, &row.flux, &row.kernel, &row.integrator].map(String::as_str).join(" "),
        row.spacing_m.to_string(),
        row.particles.to_string(),
        row.particle_evaluations.to_string(),
        format!("{:.3}", row.cpu_s),
        number(row.error_depth),
        order(row.order_depth),
        number(row.error_velocity),
        order(row.order_velocity),
        number(Some(row.max_speed_m_s)),
        row.status.name().to_owned(),
    ]
}

/// The cases with one sentence each.
pub fn list_of_cases<'a>(cases: impl Iterator<Item = &'a Case>) -> String {
    cases
        .map(|case| {
            let held_out = if case.is_tuned { "" } else { " Not used to choose constants." };
            let spacings: Vec<String> = case.spacings.iter().map(f64::to_string).collect();
            let known = KNOWN_MISSES.iter().filter(|known| known.case == case.name);
            let known: String =
                known.map(|known| format!("    known to miss a limit, {}: {}\n", known.whose(), known.why)).collect();
            format!(
                "{}\n    {}{held_out}\n    suite {}; spacings {} m, the first {} at test resolution\n{known}",
                case.name,
                case.about,
                case.suite.name(),
                spacings.join(", "),
                case.tested
            )
        })
        .collect()
}
