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
    let in_both = ids(&first).filter(|id| ids(&second).any(|other| other == *id));
    let of_place = |id: &String| -> Vec<PlaceValue> {
        let number = |table: &Table, quantity: &str| cell(table, id, quantity)?.parse::<f64>().ok();
        let value = |quantity: &&'static str| PlaceValue {
            kind,
            id: id.clone(),
            quantity,
            first: number(&first, quantity),
            second: number(&second, quantity),
        };
        quantities.iter().map(value).collect()
    };
    in_both.flat_map(of_place).collect()
}

/// The place of a column of a table.
pub(super) fn column(table: &Table, name: &str) -> Option<usize> {
    table.0.iter().position(|column| column == name)
}

/// The names of the rows of a table.
pub(super) fn ids(table: &Table) -> impl Iterator<Item = &String> {
    let id = column(table, "id");
    table.1.iter().filter_map(move |row| row.get(id?))
}

/// What a table has of a place in a column.
pub(super) fn cell<'a>(table: &'a Table, id: &str, name: &str) -> Option<&'a String> {
    let own = column(table, "id")?;
    let row = table.1.iter().find(|row| row.get(own).is_some_and(|other| other == id))?;
    row.get(column(table, name)?)
}
