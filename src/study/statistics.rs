//! Gauges, cross-sections and flooded area over the runs of a study: quantiles, and what drives them.

use serde::Serialize;

use super::amount::Amount;
use super::quantile::{correlation_ratio, quantile, rank_correlation};
use super::record::{StudyRecord, VariableRecord};
use super::tables::{OF_GAUGES, OF_SECTIONS, cell, column, ids};
use crate::results::Table;

/// Runs from which a rank correlation says anything.
const FEWEST: usize = 5;

/// A value of every run at a place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PlaceValues {
    /// `map`, `gauge` or `section`.
    pub kind: &'static str,
    pub id: String,
    pub quantity: String,
    /// By run; infinite where the water never came, none where there is no value.
    pub values: Vec<Option<f64>>,
}

/// What drives a value at a place: the rank correlation with a variable.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Driver {
    /// Name of the variable.
    pub variable: String,
    /// Rank correlation from -1 to 1; of a variable without numbers the correlation ratio, from 0 to 1.
    pub correlation: f64,
    /// Whether it is a correlation ratio, which has no sign.
    pub is_ratio: bool,
}

/// A value at a place over the runs of a study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlaceStatistic {
    /// `map`, `gauge` or `section`.
    pub kind: &'static str,
    /// Its name.
    pub id: String,
    /// What it is, as the column of the table calls it.
    pub quantity: String,
    /// Runs that have it.
    pub runs: usize,
    /// Of these, runs in which the water came.
    pub reached: usize,
    /// The least value, the quantiles of 5, 50 and 95 %, and the greatest; none where the water never came.
    pub values: [Option<f64>; 5],
    /// What drives it, the strongest first.
    pub drivers: Vec<Driver>,
}

/// All values of the tables of the runs, in the order of the first.
pub(super) fn values_of(gauges: &[Table], sections: &[Table]) -> Vec<PlaceValues> {
    let mut values = of_tables("gauge", &OF_GAUGES, gauges);
    values.extend(of_tables("section", &OF_SECTIONS, sections));
    values
}

fn of_tables(kind: &'static str, quantities: &[&str], tables: &[Table]) -> Vec<PlaceValues> {
    let number = |table: &Table, id: &str, quantity: &str| -> Option<f64> {
        let text = cell(table, id, quantity)?;
        // Where the water never came: later than any time, and lower than any level.
        let never = match quantity {
            "arrival_s" | "time_of_peak_s" => Some(f64::INFINITY),
            "max_level_m" => Some(f64::NEG_INFINITY),
            _ => None,
        };
        text.parse().ok().or(never.filter(|_| text.is_empty()))
    };
    let Some(first) = tables.first() else { return Vec::new() };
    let of_place = |id: &String| -> Vec<PlaceValues> {
        let of_quantity = |quantity: &&str| PlaceValues {
            kind,
            id: id.clone(),
            quantity: (*quantity).to_owned(),
            values: tables.iter().map(|table| number(table, id, quantity)).collect(),
        };
        quantities.iter().filter(|quantity| column(first, quantity).is_some()).map(of_quantity).collect()
    };
    ids(first).flat_map(of_place).collect()
}

impl PlaceValues {
    /// Its statistic over the runs, which are members of the study.
    pub fn statistic(&self, study: &StudyRecord, members: &[usize]) -> PlaceStatistic {
        let mut there: Vec<f64> = self.values.iter().flatten().copied().collect();
        there.sort_by(f64::total_cmp);
        let of = |value: Option<f64>| value.filter(|value| value.is_finite());
        let values = [0.0, 0.05, 0.5, 0.95, 1.0].map(|p| of(quantile(&there, p)));
        PlaceStatistic {
            kind: self.kind,
            id: self.id.clone(),
            quantity: self.quantity.clone(),
            runs: there.len(),
            reached: there.iter().filter(|value| self.is_reached(**value)).count(),
            values,
            drivers: self.drivers(study, members),
        }
    }

    /// Whether water came, by its value: times and levels are there, depths, speeds, discharges and areas are not 0.
    fn is_reached(&self, value: f64) -> bool {
        let is_place = ["arrival_s", "time_of_peak_s", "max_level_m"].contains(&self.quantity.as_str());
        value.is_finite() && (is_place || value.abs() > 0.0)
    }

    fn drivers(&self, study: &StudyRecord, members: &[usize]) -> Vec<Driver> {
        let driver = |(which, variable): (usize, &VariableRecord)| {
            let pair = |(member, value): (&usize, &Option<f64>)| {
                Some((study.members.get(*member)?.values.get(which)?.as_deref()?, (*value)?))
            };
            let (texts, values): (Vec<&str>, Vec<f64>) = members.iter().zip(&self.values).filter_map(pair).unzip();
            let (correlation, is_ratio) = correlation(&texts, &values).filter(|_| texts.len() >= FEWEST)?;
            Some(Driver { variable: variable.name.clone(), correlation, is_ratio })
        };
        let mut drivers: Vec<Driver> = study.variables.iter().enumerate().filter_map(driver).collect();
        drivers.sort_by(|one, other| other.correlation.abs().total_cmp(&one.correlation.abs()));
        drivers
    }
}

/// How closely values follow a variable, and whether by the correlation ratio: by its numbers where it has them, all in one unit.
fn correlation(texts: &[&str], values: &[f64]) -> Option<(f64, bool)> {
    let amounts: Option<Vec<Amount>> = texts.iter().map(|text| Amount::read(text)).collect();
    match amounts {
        Some(amounts) if amounts.iter().all(|amount| amount.unit == amounts[0].unit) => {
            let numbers: Vec<f64> = amounts.iter().map(|amount| amount.number).collect();
            rank_correlation(&numbers, values).map(|correlation| (correlation, false))
        }
        _ => correlation_ratio(texts, values).map(|ratio| (ratio, true)),
    }
}

impl Driver {
    /// Its name and its correlation, with a sign where it has one.
    pub fn words(&self) -> String {
        if self.is_ratio {
            format!("{} {:.2} (ratio)", self.variable, self.correlation)
        } else {
            format!("{} {:+.2}", self.variable, self.correlation)
        }
    }
}
