//! Gauges and cross-sections of two runs, by their names.

use serde::Serialize;

use crate::results::{Results, Table};

/// A value at a gauge or a cross-section in two runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlaceValue {
    /// `gauge` or `section`.
    pub kind: &'static str,
    /// Its name.
    pub id: String,
    /// What it is, as the column of the table calls it.
    pub quantity: &'static str,
    /// In the first run; none where it has no value there.
    pub first: Option<f64>,
    /// In the second run.
    pub second: Option<f64>,
}

impl PlaceValue {
    /// Second less first, where both are there.
    pub fn difference(&self) -> Option<f64> {
        Some(self.second? - self.first?)
    }
}

/// Columns of `tables/gauges.csv` that are compared.
pub(super) const OF_GAUGES: [&str; 4] = ["arrival_s", "max_depth_m", "max_level_m", "max_speed_m_s"];
/// Columns of `tables/sections.csv` that are compared.
pub(super) const OF_SECTIONS: [&str; 4] = ["arrival_s", "peak_discharge_m3_s", "time_of_peak_s", "volume_m3"];

/// The values of all gauges and cross-sections that both runs have.
pub(super) fn values(runs: [&Results; 2]) -> Vec<PlaceValue> {
    let gauges = |run: &Results| -> Table {
        (run.gauge_columns.clone(), run.gauges.iter().map(|gauge| gauge.cells.clone()).collect())
    };
    let of_gauges = of_tables("gauge", &OF_GAUGES, runs.map(gauges));
    let of_sections = of_tables("section", &OF_SECTIONS, runs.map(|run| run.sections.clone()));
    of_gauges.into_iter().chain(of_sections).collect()
}

fn of_tables(kind: &'static str, quantities: &[&'static str], [first, second]: [Table; 2]) -> Vec<PlaceValue> {
    let place = |table: &Table, name: &str| table.0.iter().position(|column| column == name);
    let (Some(id), Some(other_id)) = (place(&first, "id"), place(&second, "id")) else { return Vec::new() };
    let number = |table: &Table, row: &[String], name: &str| row.get(place(table, name)?)?.parse::<f64>().ok();
    let mut values = Vec::new();
    for row in &first.1 {
        let Some(other) = second.1.iter().find(|other| other.get(other_id) == row.get(id)) else { continue };
        let id = row.get(id).cloned().unwrap_or_default();
        values.extend(quantities.iter().map(|&quantity| PlaceValue {
            kind,
            id: id.clone(),
            quantity,
            first: number(&first, row, quantity),
            second: number(&second, other, quantity),
        }));
    }
    values
}
