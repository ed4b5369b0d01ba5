//! Tracers in the files: their fields as variables, and their balance as a table.

use super::super::folder::{RunFolder, write_lines};
use super::super::tracers::{TracerBalance, TracerPlan};
use super::tables::{number, row, text};
use crate::error::Error;

/// Name, long name and unit of the concentration of a tracer in `fields.nc`.
pub(super) fn field(plan: &TracerPlan) -> (String, String, String) {
    let long_name = format!("depth-averaged concentration of {}", plan.name);
    (format!("concentration_{}", plan.name), long_name, plan.unit.clone())
}

/// Writes `tracers.csv` into `tables/`: the balance of each tracer at each frame; nothing where there are none.
///
/// # Errors
/// When it cannot be written.
pub fn write_tracers(folder: &RunFolder, balances: &[TracerBalance]) -> Result<(), Error> {
    if balances.is_empty() {
        return Ok(());
    }
    let amount = |value: f64| format!("{value:.9e}");
    let rows = balances.iter().map(|balance| {
        row([
            number(Some(balance.time_s), 3),
            text(&balance.name),
            text(&balance.unit),
            amount(balance.stored),
            amount(balance.initial),
            amount(balance.inflow),
            amount(balance.outflow),
            amount(balance.decayed),
            format!("{:.3e}", balance.error_relative),
        ])
    });
    let header = "time_s,tracer,unit,amount,initial,in,out,decayed,error_relative";
    write_lines(folder, "tables/tracers.csv", header, rows)
}
