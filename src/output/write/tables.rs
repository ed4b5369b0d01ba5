//! The tables as CSV: UTF-8, comma, decimal point, an empty field where there is no value.

use super::super::Gauge;
use super::super::PassageRecord;
use super::super::folder::{RunFolder, write_lines};
use super::super::recording::Recording;
use crate::csv::field;
use crate::error::{Error, plain_name};

/// Writes `gauges.csv` and `gauge_series.csv` into `tables/`.
///
/// # Errors
/// When one of them cannot be written.
pub fn write_gauges(folder: &RunFolder, gauges: &[Gauge], recording: &Recording) -> Result<(), Error> {
    let gauge_rows = gauges.iter().zip(&recording.gauge_results).map(|(gauge, result)| {
        row([
            text(&gauge.id),
            format!("{:.3}", gauge.position.x),
            format!("{:.3}", gauge.position.y),
            number(result.bed, 4),
            number(result.arrival, 3),
            number(result.max_depth, 4),
            number(result.max_level, 4),
            number(result.time_of_max, 3),
            number(result.max_speed, 4),
        ])
    });
    let header = "id,x,y,bed_m,arrival_s,max_depth_m,max_level_m,time_of_max_s,max_speed_m_s";
    write_lines(folder, "tables/gauges.csv", header, gauge_rows)?;

    let samples = recording.gauge_samples.iter().zip(&recording.gauge_concentrations);
    let series_rows = samples.map(|(sample, concentrations)| {
        let own = row([
            text(&gauges[sample.gauge].id),
            number(Some(sample.time), 3),
            number(Some(sample.depth), 4),
            number(sample.level, 4),
            number(Some(sample.velocity_x), 4),
            number(Some(sample.velocity_y), 4),
        ]);
        let digits = |value: &f64| if value.is_finite() { format!(",{value:.6e}") } else { ",".to_owned() };
        own + &concentrations.iter().map(digits).collect::<String>()
    });
    let named = recording.tracers.iter().map(|tracer| format!(",concentration_{}", tracer.name)).collect::<String>();
    let header = format!("id,time_s,depth_m,level_m,velocity_x_m_s,velocity_y_m_s{named}");
    write_lines(folder, "tables/gauge_series.csv", &header, series_rows)
}

/// Writes `differences.csv` into `tables/`: of each row kind, name and quantity, and the value in the first run, in the second, and the difference.
///
/// # Errors
/// When it cannot be written.
pub fn write_difference_table<'a>(
    folder: &RunFolder,
    rows: impl Iterator<Item = ([&'a str; 3], [Option<f64>; 3])>,
) -> Result<(), Error> {
    let rows =
        rows.map(|(names, values)| format!("{},{}", row(names.map(text)), row(values.map(|value| number(value, 4)))));
    write_lines(folder, "tables/differences.csv", "kind,id,quantity,first,second,difference", rows)
}

/// A row of `quantiles.csv`: kind, name and quantity, runs and those that were reached, five values, and what drives it.
pub type QuantileRow<'a> = ([&'a str; 3], [usize; 2], [Option<f64>; 5], Vec<(&'a str, f64)>);

/// Writes `quantiles.csv` into `tables/`, and `ranking.csv` with what drives each of its rows.
///
/// # Errors
/// When one of them cannot be written.
pub fn write_quantile_table<'a>(
    folder: &RunFolder,
    rows: impl Iterator<Item = QuantileRow<'a>> + Clone,
) -> Result<(), Error> {
    let quantiles = rows.clone().map(|(names, [runs, reached], values, _)| {
        let values = row(values.map(|value| number(value, 4)));
        format!("{},{runs},{reached},{values}", row(names.map(text)))
    });
    let header = "kind,id,quantity,runs,reached,least,p05,p50,p95,greatest";
    write_lines(folder, "tables/quantiles.csv", header, quantiles)?;
    let ranking = rows.flat_map(|(names, _, _, drivers)| {
        let line = move |(rank, (variable, correlation)): (usize, (&str, f64))| {
            format!("{},{},{},{correlation:.4}", row(names.map(text)), rank + 1, text(variable))
        };
        drivers.into_iter().enumerate().map(line).collect::<Vec<_>>()
    });
    write_lines(folder, "tables/ranking.csv", "kind,id,quantity,rank,variable,correlation", ranking)
}

/// Writes `mass_balance.csv` into `tables/`.
///
/// # Errors
/// When it cannot be written.
pub fn write_mass_balance(folder: &RunFolder, recording: &Recording) -> Result<(), Error> {
    let digits =
        decimals(3, recording.mass_balance.iter().map(|balance| balance.volumes.stored + balance.volumes.outflow));
    let balance_rows = recording.mass_balance.iter().map(|balance| {
        let volumes = &balance.volumes;
        row([
            number(Some(balance.time), 3),
            number(Some(volumes.stored), digits),
            number(Some(volumes.inflow), digits),
            number(Some(volumes.outflow), digits),
            format!("{:.3e}", volumes.error_relative),
            number(Some(balance.grid_volume), digits),
            number(Some(volumes.in_channels), digits),
        ])
    });
    let header = "time_s,volume_m3,in_m3,out_m3,error_relative,grid_volume_m3,channels_m3";
    write_lines(folder, "tables/mass_balance.csv", header, balance_rows)
}

/// Writes `boundaries.csv`: inflow and outflow by each boundary, source, channel and by rain; nothing where there are none.
///
/// # Errors
/// When it cannot be written.
pub fn write_passages(folder: &RunFolder, passages: &[PassageRecord]) -> Result<(), Error> {
    if passages.is_empty() {
        return Ok(());
    }
    let volumes = passages.iter().flat_map(|passage| [Some(passage.in_m3), Some(passage.out_m3), passage.asked_m3]);
    let digits = decimals(3, volumes.flatten());
    let rows = passages.iter().map(|passage| {
        row([
            text(&passage.name),
            number(Some(passage.in_m3), digits),
            number(Some(passage.out_m3), digits),
            number(passage.asked_m3, digits),
            passage.error_relative().map_or_else(String::new, |error| format!("{error:.3e}")),
        ])
    });
    write_lines(folder, "tables/boundaries.csv", "name,in_m3,out_m3,asked_m3,error_relative", rows)
}

pub(super) fn row<const COLUMNS: usize>(fields: [String; COLUMNS]) -> String {
    fields.join(",")
}

/// A number with fixed decimals; empty when there is none or it is not finite; never a negative zero.
pub(super) fn number(value: Option<f64>, decimals: usize) -> String {
    let Some(value) = value.filter(|value| value.is_finite()) else {
        return String::new();
    };
    let digits = format!("{value:.decimals$}");
    if digits.starts_with('-') && digits.bytes().all(|byte| matches!(byte, b'-' | b'0' | b'.')) {
        digits[1..].to_string()
    } else {
        digits
    }
}

/// Decimals of a column that show at least four digits of its largest number: `least` of them, more where that number is small.
pub(super) fn decimals(least: usize, values: impl Iterator<Item = f64>) -> usize {
    const DIGITS: i32 = 4;
    /// A smaller number, a microlitre of water or less, is rounding.
    const NOTHING: f64 = 1e-9;
    let largest = values.filter(|value| value.is_finite()).fold(0.0, |largest: f64, value| largest.max(value.abs()));
    if largest < NOTHING {
        return least;
    }
    let leading = largest.log10().floor() as i32;
    least.max((DIGITS - 1 - leading).max(0) as usize)
}

/// A text field that no spreadsheet computes, quoted where it must be.
pub(super) fn text(value: &str) -> String {
    field(&plain_name(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_numbers_have_more_decimals_and_large_ones_what_they_had() {
        for (values, expected) in [
            (vec![], 3),
            (vec![0.0, f64::NAN], 3),
            (vec![1e6, 1e-6], 3),
            (vec![1.0], 3),
            (vec![-0.5], 4),
            (vec![1e-4, 2.5e-5], 7),
            (vec![2e-9], 12),
            (vec![3e-13], 3),
        ] {
            assert_eq!(decimals(3, values.iter().copied()), expected, "{values:?}");
        }
        assert_eq!((decimals(6, [0.02].into_iter()), decimals(6, [1e-5].into_iter())), (6, 8));
    }

    #[test]
    fn fields_are_plain() {
        assert_eq!(number(Some(-0.000_01), 4), "0.0000");
        assert_eq!(number(Some(-1.5), 1), "-1.5");
        assert_eq!((number(Some(f64::NAN), 2), number(None, 2)), (String::new(), String::new()));
        assert_eq!(text("mill, \"old\""), "\"mill, \"\"old\"\"\"");
        assert_eq!((text("=A1").as_str(), text("a\u{1b}[31m\tb").as_str()), ("'=A1", "a\u{fffd}[31m b"));
    }
}
