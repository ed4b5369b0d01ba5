//! One line of the results: a case, its methods, its resolution, what it cost and what came out.

use serde::Serialize;

use crate::scenario::Numerics;

/// How a row came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// Its acceptance limit is met.
    Pass,
    /// Its acceptance limit is missed.
    FallShort,
    /// It has no acceptance limit and came to its end.
    Holds,
    /// It came to its end, worse than it should have.
    Degrades,
    /// It broke down.
    Fails,
}

impl Status {
    /// Every status.
    pub const ALL: [Status; 5] = [Status::Pass, Status::FallShort, Status::Holds, Status::Degrades, Status::Fails];

    /// The name in tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Status::Pass => "pass",
            Status::FallShort => "fall-short",
            Status::Holds => "holds",
            Status::Degrades => "degrades",
            Status::Fails => "fails",
        }
    }
}

/// A row of `floodsim validate --json`; the names of its fields are a contract.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Suite.
    pub suite: String,
    /// Case.
    pub case: String,
    /// Formulation.
    pub formulation: String,
    /// Motion.
    pub motion: String,
    /// Kernel.
    pub kernel: String,
    /// Stabilisation: what happens between two particles.
    pub flux: String,
    /// Integrator.
    pub integrator: String,
    /// Spacing (m).
    pub spacing_m: f64,
    /// Particles that carried water.
    pub particles: usize,
    /// Evaluations of the rates of one particle.
    pub particle_evaluations: u64,
    /// Processor time (s).
    pub cpu_s: f64,
    /// How the errors are averaged: `mean_abs_particles` or `mean_abs_grid`.
    pub norm: String,
    /// Error of the depth (m).
    pub error_depth: Option<f64>,
    /// Error of the velocity (m/s).
    pub error_velocity: Option<f64>,
    /// Order of the depth from the next coarser spacing.
    pub order_depth: Option<f64>,
    /// Order of the velocity.
    pub order_velocity: Option<f64>,
    /// Greatest speed (m/s) at any step.
    pub max_speed_m_s: f64,
    /// How it came out.
    pub status: Status,
    /// What it is held to; empty where it is held to nothing.
    #[serde(rename = "bar")]
    pub acceptance_limit: String,
    /// What else there is to say: other methods that were asked for, checks, the breakdown.
    pub note: String,
}

/// The names of the fields, in the order of [`Row::fields`].
pub const FIELDS: [&str; 20] = [
    "suite",
    "case",
    "formulation",
    "motion",
    "kernel",
    "flux",
    "integrator",
    "spacing_m",
    "particles",
    "particle_evaluations",
    "cpu_s",
    "norm",
    "error_depth",
    "error_velocity",
    "order_depth",
    "order_velocity",
    "max_speed_m_s",
    "status",
    "bar",
    "note",
];

impl Row {
    /// The row of a run that has not been made: suite and case, methods, spacing (m).
    pub fn new((suite, case): (&str, &str), numerics: &Numerics, spacing: f64) -> Self {
        Row {
            suite: suite.to_owned(),
            case: case.to_owned(),
            formulation: numerics.formulation.name().to_owned(),
            motion: numerics.motion.name().to_owned(),
            kernel: numerics.kernel.name().to_owned(),
            flux: numerics.stabilisation.name().to_owned(),
            integrator: numerics.integrator.name().to_owned(),
            spacing_m: spacing,
            particles: 0,
            particle_evaluations: 0,
            cpu_s: 0.0,
            norm: String::new(),
            error_depth: None,
            error_velocity: None,
            order_depth: None,
            order_velocity: None,
            max_speed_m_s: 0.0,
            status: Status::Fails,
            acceptance_limit: String::new(),
            note: String::new(),
        }
    }

    /// The values as text, empty where there is none.
    pub fn fields(&self) -> [String; 20] {
        let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.4e}"));
        [
            self.suite.clone(),
            self.case.clone(),
            self.formulation.clone(),
            self.motion.clone(),
            self.kernel.clone(),
            self.flux.clone(),
            self.integrator.clone(),
            self.spacing_m.to_string(),
            self.particles.to_string(),
            self.particle_evaluations.to_string(),
            format!("{:.4}", self.cpu_s),
            self.norm.clone(),
            number(self.error_depth),
            number(self.error_velocity),
            self.order_depth.map_or(String::new(), |order| format!("{order:.3}")),
            self.order_velocity.map_or(String::new(), |order| format!("{order:.3}")),
            format!("{:.4e}", self.max_speed_m_s),
            self.status.name().to_owned(),
            self.acceptance_limit.clone(),
            self.note.clone(),
        ]
    }
}

/// Rows as comma-separated values with a heading, quoted where needed.
pub fn rows_as_csv(rows: &[Row]) -> String {
    let quoted = |text: &str| {
        if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
    };
    let line = |fields: &[String]| fields.iter().map(|field| quoted(field)).collect::<Vec<_>>().join(",") + "\n";
    let heading = FIELDS.map(str::to_owned);
    std::iter::once(line(&heading)).chain(rows.iter().map(|row| line(&row.fields()))).collect()
}

/// Reads what [`rows_as_csv`] wrote.
///
/// # Errors
/// A message that names the line.
pub fn rows_from_csv(text: &str) -> Result<Vec<Row>, String> {
    let mut lines = records(text).into_iter();
    if lines.next().is_none_or(|heading| heading != FIELDS) {
        return Err("the heading is not that of `floodsim validate --csv`".to_owned());
    }
    lines.enumerate().map(|(k, record)| row(&record).ok_or(format!("line {} is not a row", k + 2))).collect()
}

fn row(record: &[String]) -> Option<Row> {
    let [suite, case, formulation, motion, kernel, flux, integrator, numbers @ .., status, acceptance_limit, note] =
        record
    else {
        return None;
    };
    let [spacing, particles, evaluations, cpu, norm, errors @ .., speed] = numbers else { return None };
    let optional: Vec<Option<f64>> = errors.iter().map(|text| text.parse().ok()).collect();
    let [error_depth, error_velocity, order_depth, order_velocity] = optional[..] else { return None };
    Some(Row {
        suite: suite.clone(),
        case: case.clone(),
        formulation: formulation.clone(),
        motion: motion.clone(),
        kernel: kernel.clone(),
        flux: flux.clone(),
        integrator: integrator.clone(),
        spacing_m: spacing.parse().ok()?,
        particles: particles.parse().ok()?,
        particle_evaluations: evaluations.parse().ok()?,
        cpu_s: cpu.parse().ok()?,
        norm: norm.clone(),
        error_depth,
        error_velocity,
        order_depth,
        order_velocity,
        max_speed_m_s: speed.parse().ok()?,
        status: Status::ALL.into_iter().find(|one| one.name() == status)?,
        acceptance_limit: acceptance_limit.clone(),
        note: note.clone(),
    })
}

/// A field of a table and where it begins.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Field {
    pub text: String,
    /// Line and column, from 1.
    pub place: (usize, usize),
}

/// The fields of each line; a quoted one may hold commas, quotes and line ends.
pub(super) fn fields_of(text: &str) -> Vec<Vec<Field>> {
    let (mut records, mut record, mut is_quoted) = (Vec::new(), Vec::new(), false);
    let mut field = Field { text: String::new(), place: (1, 1) };
    let (mut line, mut column) = (1, 1);
    let mut letters = text.chars().peekable();
    while let Some(letter) = letters.next() {
        column += 1;
        match letter {
            '"' if is_quoted && letters.peek() == Some(&'"') => {
                column += 1;
                field.text.extend(letters.next());
            }
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => {
                let next = Field { text: String::new(), place: (line, column) };
                record.push(std::mem::replace(&mut field, next));
            }
            '\n' => {
                (line, column) = (line + 1, 1);
                if is_quoted {
                    field.text.push(letter);
                    continue;
                }
                let next = Field { text: String::new(), place: (line, column) };
                record.push(std::mem::replace(&mut field, next));
                records.push(std::mem::take(&mut record));
            }
            '\r' if !is_quoted => {}
            other => field.text.push(other),
        }
    }
    if !record.is_empty() || !field.text.is_empty() {
        record.push(field);
        records.push(record);
    }
    records
}

fn records(text: &str) -> Vec<Vec<String>> {
    fields_of(text).into_iter().map(|record| record.into_iter().map(|field| field.text).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_survive_the_way_through_a_file() {
        let row = Row {
            suite: "analytic".to_owned(),
            case: "ritter".to_owned(),
            formulation: "balanced".to_owned(),
            motion: "lagrangian".to_owned(),
            kernel: "cubic_spline".to_owned(),
            flux: "riemann".to_owned(),
            integrator: "leapfrog".to_owned(),
            spacing_m: 2.5,
            particles: 400,
            particle_evaluations: 123_456,
            cpu_s: 0.25,
            norm: "mean_abs_particles".to_owned(),
            error_depth: Some(0.0125),
            error_velocity: Some(0.5),
            order_depth: Some(1.25),
            order_velocity: None,
            max_speed_m_s: 16.0,
            status: Status::FallShort,
            acceptance_limit: "depth <= 0.021 m".to_owned(),
            note: "a \"quoted\" word, and a comma".to_owned(),
        };
        let rows = vec![row.clone(), Row { status: Status::Fails, error_depth: None, ..row }];
        assert_eq!(rows_from_csv(&rows_as_csv(&rows)).unwrap(), rows);
        assert!(rows_from_csv("a,b\n").is_err());
    }

    #[test]
    fn the_names_of_the_fields_are_those_of_the_json() {
        let heading = rows_as_csv(&[]);
        assert_eq!(heading.trim_end().split(',').collect::<Vec<_>>(), FIELDS);
    }
}
