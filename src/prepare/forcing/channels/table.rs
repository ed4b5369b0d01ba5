//! The table of cross-sections of a channel: read, and checked against the length of the channel.

use std::path::PathBuf;

use super::section::{Row, Table};
use crate::error::{Problem, ProblemKind, input_error};
use crate::prepare::findings::Findings;
use crate::prepare::tables::dates::Origin;
use crate::prepare::tables::rows::implausible;
use crate::prepare::tables::series;
use crate::scenario::units::LENGTH;
use crate::scenario::{ColumnUnit, Sourced};

/// Sections that reach beyond their channel by more than so many particles are worth a warning.
const BEYOND: f64 = 1.0;

/// The sections of a file, checked against the length (m) of the channel and the spacing (m) of its particles.
pub fn sections(file: &Sourced<PathBuf>, length: f64, spacing: f64, findings: &mut Findings) -> Option<Vec<Table>> {
    let columns = ["distance", "elevation", "width"].map(|_| ColumnUnit { name: None, unit: None });
    let example = "distance_m,elevation_m,width_m";
    let rows = findings.take_all(file, series::rows_of(&file.value, &columns, [&LENGTH; 3], (example, Origin::Own)))?;
    let name = file.value.display().to_string();
    let mut faults: Vec<Problem> = implausible(&rows, 1, &name).into_iter().collect();
    let mut tables: Vec<Table> = Vec::new();
    for row in &rows {
        let [distance, elevation, width] = row.numbers;
        let at = format!("line {} of {name}", row.line);
        faults.extend(append(&mut tables, distance, Row { elevation, width }, &at));
        if width < 0.0 {
            let problem = input_error("negative-value", format!("{at} has a width below 0"));
            faults.push(problem.with_remedy("give widths of 0 or more"));
        }
    }
    faults.extend([odd_rows(&tables, &name), closed(&tables, &name)].into_iter().flatten());
    let reach = Reach { first: tables[0].distance, last: tables[tables.len() - 1].distance, length };
    faults.extend(reach.short(&name));
    let is_sound = faults.is_empty();
    if is_sound {
        faults.extend(reach.beyond(&name, spacing));
    }
    findings.add_all(file, faults);
    is_sound.then_some(tables)
}

/// Adds a row at a distance (m) to the last section, or begins the next one; the fault of a row out of order.
fn append(tables: &mut Vec<Table>, distance: f64, row: Row, at: &str) -> Option<Problem> {
    match tables.last_mut() {
        Some(last) if (distance - last.distance).abs() <= 1e-9 => {
            let below = last.rows[last.rows.len() - 1];
            last.rows.push(row);
            (row.elevation < below.elevation || row.width < below.width).then(|| {
                input_error("section-not-rising", format!("{at} is lower or narrower than the row before"))
                    .with_cause("the rows of a section go from its bed upwards, and a channel does not close above")
                    .with_remedy("sort the rows of each section by elevation; give an overhang the width below it")
            })
        }
        Some(last) if distance < last.distance => Some(
            input_error("not-rising", format!("{at} goes back to {distance} m"))
                .with_remedy("sort the sections by their distance from the far end"),
        ),
        _ => {
            tables.push(Table { distance, rows: vec![row] });
            None
        }
    }
}

/// The fault of a section with another number of rows than the first one.
fn odd_rows(tables: &[Table], name: &str) -> Option<Problem> {
    let odd = tables.iter().find(|table| table.rows.len() != tables[0].rows.len())?;
    let message = format!(
        "the section at {} m of {name} has {} rows, the first one {}",
        odd.distance,
        odd.rows.len(),
        tables[0].rows.len()
    );
    let problem = input_error("section-rows", message)
        .with_cause("row for row, a section goes on as the next one")
        .with_remedy("give every section as many rows");
    Some(problem)
}

/// The fault of a section without a width.
fn closed(tables: &[Table], name: &str) -> Option<Problem> {
    let closed = tables.iter().find(|table| table.rows[table.rows.len() - 1].width <= 0.0)?;
    let message = format!("the section at {} m of {name} has no width", closed.distance);
    Some(input_error("section-closed", message).with_remedy("give its last row a width above 0"))
}

/// Where the first and the last section lie along a channel (m from its far end), and the length (m) of that.
struct Reach {
    first: f64,
    last: f64,
    length: f64,
}

impl Reach {
    /// The fault of sections that do not reach the ends of the channel.
    fn short(&self, name: &str) -> Option<Problem> {
        let Reach { first, last, length } = *self;
        let slack = 1e-6 * length;
        (first > slack || last < length - slack).then(|| {
            let message =
                format!("the sections of {name} reach from {first} m to {last} m, the channel from 0 to {length} m");
            let remedy = "add a section at either end, or correct `length`; distances count from the far end";
            input_error("sections-short", message).with_remedy(remedy)
        })
    }

    /// The warning of sections beyond the channel by more than its particles (`spacing`, m) account for.
    fn beyond(&self, name: &str, spacing: f64) -> Option<Problem> {
        let Reach { first, last, length } = *self;
        (first < -BEYOND * spacing || last > length + BEYOND * spacing).then(|| {
            let message = format!(
                "the sections of {name} reach from {first} m to {last} m, beyond the channel from 0 to {length} m"
            );
            Problem::warning(ProblemKind::Input, "sections-beyond", "", message)
                .with_cause("what lies before 0 or beyond `length` is left out")
                .with_remedy(
                    "correct `length` or the distances, which count from the far end; or take those sections out",
                )
        })
    }
}
