//! A quantity that may change over time: one value, or columns of a CSV file with their units.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::choices::Chosen;
use super::fields::{CsvFile, Kind, Quantity, Text};
use super::model::{AfterEnd, ColumnUnit, TableFile, Timed};
use super::read::{FromNode, Reader, section};
use super::tree::{Node, Value};
use super::units::{self, Dimension};
use crate::error::{Problem, ProblemKind};
use crate::scenario::yaml::{Section, Yaml, file, quantity, quoted};

section! {
    /// A series of values over time in a CSV file; values are linear between its rows.
    SeriesSection, example "{series: hydrograph.csv, column: q, unit: m3/s}" {
        /// CSV file whose first line names its columns, one of times from the start of the run and one of values. Codes:
        /// series-starts-late, series-ends-early, series-gap, series-far-beyond, not-rising, negative-value.
        series: CsvFile,
        /// Name of the column of values; the second column when absent. Codes: which-column, missing-column, duplicate-column.
        column: Option<Text>,
        /// Unit of the values; that at the end of the column's name, as in `q_m3_s` or `q [m3/s]`, when absent. Codes:
        /// missing-unit, contradicting-units, which-column.
        unit: Option<Text>,
        /// Name of the column of times, as numbers or dates; the first column when absent. Codes: dates-as-times, bad-date,
        /// ambiguous-date, mixed-times, missing-column.
        time: Option<Text>,
        /// Unit of the times; that at the end of the column's name, as in `time_h` or `t [min]`, when absent. Codes:
        /// missing-unit, contradicting-units, unit-beside-dates, series-far-beyond.
        time_unit: Option<Text>,
        /// `hold`: the last value holds on after the last row; a series that ends before the run is refused when absent. Codes:
        /// series-held, series-ends-early.
        after_end: Option<Chosen<AfterEnd>>,
    }
}

section! {
    /// A rating curve in a CSV file: it begins with the level of discharge 0, and goes on beyond its last row as between the last two.
    RatingSection, example "{table: rating.csv}" {
        /// CSV file whose first line names its columns, one of levels and one of discharges. Codes: rating-start,
        /// falling-discharge, short-table, not-rising, high-weir, rating-without-discharge.
        table: CsvFile,
        /// Name of the column of levels; the first column when absent. Codes: missing-column, duplicate-column, implausible-level.
        level: Option<Text>,
        /// Unit of the levels; that at the end of the column's name when absent. Codes: missing-unit, contradicting-units.
        level_unit: Option<Text>,
        /// Name of the column of discharges; the second column when absent. Codes: missing-column, duplicate-column, which-column.
        discharge: Option<Text>,
        /// Unit of the discharges; that at the end of the column's name when absent. Codes: missing-unit, contradicting-units.
        discharge_unit: Option<Text>,
    }
}

/// A constant quantity, or a series.
#[derive(Clone, Debug)]
pub struct Changing<K> {
    /// The quantity in SI units.
    pub timed: Timed,
    /// What it is a quantity of.
    kind: std::marker::PhantomData<K>,
}

impl<K: Kind> FromNode for Changing<K> {
    fn example() -> String {
        K::EXAMPLE.to_owned()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let kind = std::marker::PhantomData;
        if !matches!(node.value, Value::Section(_)) {
            let quantity = Quantity::<K>::from_node(node, reader)?;
            return Some(Changing { timed: Timed::Constant(quantity.sourced), kind });
        }
        let section = SeriesSection::from_node(node, reader)?;
        let time = column(section.time, section.time_unit, &units::TIME, reader);
        let values = column(section.column, section.unit, K::DIMENSION, reader);
        let after_end = section.after_end.map(|chosen| chosen.0.value);
        let table = TableFile { file: section.series.0.0, columns: [time?, values?], after_end };
        Some(Changing { timed: Timed::Series(table), kind })
    }
}

impl<K: Kind> JsonSchema for Changing<K> {
    fn schema_name() -> Cow<'static, str> {
        format!("Changing{}", K::NAME).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let constant = generator.subschema_for::<Quantity<K>>();
        let series = generator.subschema_for::<SeriesSection>();
        json_schema!({"anyOf": [constant, series]})
    }
}

/// A share that grows in time: always a series.
#[derive(Clone, Debug)]
pub struct ShareSeries(pub TableFile);

impl FromNode for ShareSeries {
    fn example() -> String {
        "{series: growth.csv}".to_owned()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let section = SeriesSection::from_node(node, reader)?;
        let time = column(section.time, section.time_unit, &units::TIME, reader);
        let share = column(section.column, section.unit, &units::SHARE, reader);
        if let Some(after_end) = node.get("after_end").filter(|_| section.after_end.is_some()) {
            reader.error(after_end, "conflict", "a share ends at 1 and stays there", "take `after_end` out");
            return None;
        }
        Some(ShareSeries(TableFile { file: section.series.0.0, columns: [time?, share?], after_end: None }))
    }
}

impl JsonSchema for ShareSeries {
    fn schema_name() -> Cow<'static, str> {
        "ShareSeries".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        generator.subschema_for::<SeriesSection>()
    }
}

/// A column as the scenario names it; none where the unit is none of its dimension.
fn column(
    name: Option<Text>,
    unit: Option<Text>,
    dimension: &'static Dimension,
    reader: &mut Reader,
) -> Option<ColumnUnit> {
    let factor = match unit {
        None => None,
        Some(Text(unit)) => {
            let Some(factor) = dimension.factor_of(unit.value.trim()) else {
                let message = format!("`{}` is no unit of {}", unit.value, dimension.name);
                let problem = Problem::error(ProblemKind::Scenario, "unit", unit.key.clone(), message);
                let remedy = format!("use one of {}", dimension.unit_list());
                reader.problems.push(problem.with_remedy(remedy).with_place(unit.place));
                return None;
            };
            Some((unit.value.trim().to_owned(), factor))
        }
    };
    Some(ColumnUnit { name: name.map(|name| name.0.value), unit: factor })
}

/// A rating curve.
#[derive(Clone, Debug)]
pub struct RatingFile(pub TableFile);

impl FromNode for RatingFile {
    fn example() -> String {
        RatingSection::example()
    }

    fn from_node(node: &Node, reader: &mut Reader) -> Option<Self> {
        let section = RatingSection::from_node(node, reader)?;
        let level = column(section.level, section.level_unit, &units::LENGTH, reader);
        let discharge = column(section.discharge, section.discharge_unit, &units::DISCHARGE, reader);
        Some(RatingFile(TableFile { file: section.table.0.0, columns: [level?, discharge?], after_end: None }))
    }
}

impl JsonSchema for RatingFile {
    fn schema_name() -> Cow<'static, str> {
        "RatingFile".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        generator.subschema_for::<RatingSection>()
    }
}

/// A quantity over time; `unit` is that of SI.
pub(super) fn written(timed: &Timed, unit: &str) -> Yaml {
    match timed {
        Timed::Constant(value) => quantity(value.value, unit),
        Timed::Series(table) => series_written(table),
    }
}
/// A series in a table.
pub(super) fn series_written(table: &TableFile) -> Yaml {
    let after_end = table.after_end.map(|AfterEnd::Hold| "hold");
    Yaml::Entry(
        Section::default()
            .with("series", file(&table.file.value))
            .and(columns(table, [["time", "time_unit"], ["column", "unit"]]))
            .with_some("after_end", after_end),
    )
}
/// The columns of a table and their units, as far as they are given, by the keys of both.
pub(super) fn columns(table: &TableFile, names: [[&'static str; 2]; 2]) -> Section {
    table.columns.iter().zip(names).fold(Section::default(), |section, (column, [name, unit])| {
        section
            .with_some(name, column.name.as_deref().map(quoted))
            .with_some(unit, column.unit.as_ref().map(|(unit, _)| quoted(unit)))
    })
}
