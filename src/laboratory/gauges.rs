//! Series at gauges: of the run, from its tables, and of the experiment.

use std::path::{Path, PathBuf};

use crate::geodata::{Table, read_text};
use crate::maps::{GaugeLine, GaugePanel, PanelAxis};

/// Time (s) and a value, times ascending.
pub type Series = Vec<(f64, f64)>;

/// A run that came to its end, and where the measurements lie.
pub struct Run {
    /// The run folder.
    pub folder: PathBuf,
    /// The folder of the scenarios.
    pub scenarios: PathBuf,
    /// The folder of the data of the case.
    pub data: PathBuf,
    /// Spacing (m).
    pub spacing: f64,
    /// What the run had in place of what its scenario says, as `key.path=value`.
    pub overrides: Vec<String>,
}

impl Run {
    /// The spacing in words.
    pub fn resolution(&self) -> String {
        // A whole number of hundredths of a millimetre: 100 times 0.028 is not 2.8.
        let centimetres = (1e5 * self.spacing).round() / 1e3;
        if self.spacing < 1.0 { format!("{centimetres} cm") } else { format!("{} m", self.spacing) }
    }

    /// The series of a column of `tables/gauge_series.csv` at a gauge.
    ///
    /// # Errors
    /// A message where the file lacks it.
    pub fn series(&self, gauge: &str, column: &str) -> Result<Series, String> {
        let table = table(&self.folder.join("tables/gauge_series.csv"))?;
        let (id, time, value) = (column_of(&table, "id")?, column_of(&table, "time_s")?, column_of(&table, column)?);
        let points: Series = table
            .rows
            .iter()
            .filter(|(_, fields)| fields[id] == gauge)
            .filter_map(|(_, fields)| Some((fields[time].parse().ok()?, fields[value].parse().ok()?)))
            .collect();
        if points.is_empty() { Err(format!("the run has no gauge `{gauge}`")) } else { Ok(points) }
    }

    /// A number of `tables/gauges.csv`; none where the water never came.
    ///
    /// # Errors
    /// A message where the file lacks it.
    pub fn result(&self, gauge: &str, column: &str) -> Result<Option<f64>, String> {
        let table = table(&self.folder.join("tables/gauges.csv"))?;
        let (id, value) = (column_of(&table, "id")?, column_of(&table, column)?);
        let row = table.rows.iter().find(|(_, fields)| fields[id] == gauge);
        row.map(|(_, fields)| fields[value].parse().ok()).ok_or_else(|| format!("the run has no gauge `{gauge}`"))
    }

    /// The gauges of `tables/gauges.csv`, each with its x (m).
    ///
    /// # Errors
    /// A message where the file lacks them.
    pub fn places(&self) -> Result<Vec<(String, f64)>, String> {
        let table = table(&self.folder.join("tables/gauges.csv"))?;
        let (id, x) = (column_of(&table, "id")?, column_of(&table, "x")?);
        let place = |fields: &Vec<String>| Some((fields.get(id)?.clone(), fields.get(x)?.parse().ok()?));
        Ok(table.rows.iter().filter_map(|(_, fields)| place(fields)).collect())
    }

    /// The rows of a map of `maps.nc`, those of the north first; NaN where it has no value.
    ///
    /// # Errors
    /// A message where the file lacks it.
    pub fn map(&self, name: &str) -> Result<Vec<Vec<f64>>, String> {
        let path = self.folder.join("maps.nc");
        let failed = |cause: netcdf::Error| format!("`{name}` of {} cannot be read: {cause}", path.display());
        let file = netcdf::open(&path).map_err(failed)?;
        let variable = file.variable(name).ok_or_else(|| format!("there is no map `{name}`"))?;
        let values = variable.get_values::<f64, _>(..).map_err(failed)?;
        let fill =
            variable.attribute_value("_FillValue").and_then(Result::ok).and_then(|fill| f64::try_from(fill).ok());
        // A fill value is stored, not computed: equal bits mean missing.
        let value = |value: &f64| if Some(value.to_bits()) == fill.map(f64::to_bits) { f64::NAN } else { *value };
        let columns = variable.dimensions().last().map_or(1, netcdf::Dimension::len).max(1);
        Ok(values.chunks(columns).map(|row| row.iter().map(value).collect()).collect())
    }

    /// A measured series: two columns of a file of the data.
    ///
    /// # Errors
    /// A message where the file lacks one.
    pub fn measured(&self, file: &str, time: &str, column: &str) -> Result<Series, String> {
        let table = table(&self.data.join(file))?;
        let (time, value) = (column_of(&table, time)?, column_of(&table, column)?);
        let point = |fields: &Vec<String>| Some((fields.get(time)?.parse().ok()?, fields.get(value)?.parse().ok()?));
        Ok(table.rows.iter().filter_map(|(_, fields)| point(fields)).collect())
    }

    /// A measured number of the row with an id in `gauges.csv` of the data.
    ///
    /// # Errors
    /// A message where it is not there.
    pub fn mark(&self, gauge: &str, column: &str) -> Result<f64, String> {
        let table = table(&self.data.join("gauges.csv"))?;
        let (id, value) = (column_of(&table, "id")?, column_of(&table, column)?);
        let row = table.rows.iter().find(|(_, fields)| fields[id] == gauge);
        row.and_then(|(_, fields)| fields[value].parse().ok()).ok_or_else(|| format!("no `{column}` of `{gauge}`"))
    }
}

fn table(path: &Path) -> Result<Table, String> {
    let text = read_text(path).map_err(|cause| format!("{} cannot be read: {cause}", path.display()))?;
    Ok(Table::parse(&text, |_| true))
}

fn column_of(table: &Table, name: &str) -> Result<usize, String> {
    table.column(&[name]).ok_or_else(|| format!("there is no column `{name}`"))
}

/// The value of a series at a time (s), linear between its points and constant beyond them; none of an empty one.
pub fn value_at(series: &Series, time: f64) -> Option<f64> {
    let after = series.partition_point(|point| point.0 <= time);
    let (first, last) = (series.first()?, series.last()?);
    Some(match after {
        0 => first.1,
        k if k == series.len() => last.1,
        k => {
            let [(t_0, v_0), (t_1, v_1)] = [series[k - 1], series[k]];
            v_0 + (time - t_0) / (t_1 - t_0) * (v_1 - v_0)
        }
    })
}

/// Root of the mean square of computed less measured values, at the measured times from one time to another (s); none without any.
pub fn root_mean_square(computed: &Series, measured: &Series, (from, to): (f64, f64)) -> Option<f64> {
    let inside = measured.iter().filter(|(time, _)| (from..=to).contains(time));
    let differences: Option<Vec<f64>> = inside.map(|(time, value)| Some(value_at(computed, *time)? - value)).collect();
    let differences = differences.filter(|all| !all.is_empty())?;
    Some((differences.iter().map(|d| d * d).sum::<f64>() / differences.len() as f64).sqrt())
}

/// Mean of a series from one time to another (s), of its points.
pub fn mean(series: &Series, (from, to): (f64, f64)) -> f64 {
    let inside = || series.iter().filter(|(time, _)| (from..=to).contains(time));
    inside().map(|point| point.1).sum::<f64>() / inside().count().max(1) as f64
}

/// The first time (s) at which a series is above its first value by a rise (m); none where it never is.
pub fn arrival(series: &Series, rise: f64) -> Option<f64> {
    let start = series.first()?.1;
    series.iter().find(|(_, value)| value - start > rise).map(|point| point.0)
}

/// How far a map is from its mirror image about its middle row, |a/b − 1| of each cell a and its image b: at most, and on average. Infinite
/// where one of the two has a value alone, and for a map without values.
pub fn asymmetry(rows: &[Vec<f64>]) -> [f64; 2] {
    let pairs = rows.iter().zip(rows.iter().rev()).flat_map(|(row, image)| row.iter().zip(image));
    let apart = pairs.filter(|(a, b)| !(a.is_nan() && b.is_nan())).map(|(a, b)| {
        let off = if (a - b).abs() <= 0.0 { 0.0 } else { (a / b - 1.0).abs() };
        if off.is_nan() { f64::INFINITY } else { off }
    });
    let apart: Vec<f64> = apart.collect();
    if apart.is_empty() { [f64::INFINITY; 2] } else { [apart.iter().copied().fold(0.0, f64::max), mean_of(&apart)] }
}

/// A panel with what was measured and what a run makes of it.
pub fn panel(run: &Run, title: &str, measured: Series, computed: Series) -> GaugePanel {
    let computed = vec![GaugeLine { name: run.resolution(), points: computed }];
    GaugePanel { title: title.to_owned(), axis: PanelAxis::Time, measured, computed }
}

/// Joins notes.
pub fn listed(items: &[String]) -> String {
    items.join(", ")
}

/// The mean of numbers.
pub fn mean_of(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_taken_at_measured_times() {
        let computed = vec![(0.0, 0.0), (10.0, 10.0)];
        let measured = vec![(-1.0, 0.0), (2.5, 2.5), (5.0, 8.0), (7.5, 3.5), (20.0, 0.0)];
        // 0, −3 and 4 inside; the ends are outside the window.
        let error = root_mean_square(&computed, &measured, (0.0, 10.0)).unwrap();
        assert!((error - (25.0_f64 / 3.0).sqrt()).abs() < 1e-12);
        assert_eq!(root_mean_square(&computed, &measured, (11.0, 12.0)), None);
        assert_eq!((value_at(&computed, 20.0), value_at(&Vec::new(), 1.0)), (Some(10.0), None));
    }

    #[test]
    fn one_cell_off_its_mirror_image_makes_a_map_unsymmetric() {
        let map = |cell: f64| [vec![2.0, f64::NAN], vec![5.0, 0.0], vec![cell, f64::NAN]];
        assert!(asymmetry(&map(2.0)).iter().all(|off| off.abs() <= 0.0));
        let [worst, mean] = asymmetry(&map(2.5));
        // 0.25 and 0.2, and the middle row is its own image.
        assert!((worst - 0.25).abs() < 1e-15 && (mean - 0.45 / 4.0).abs() < 1e-15, "{worst} {mean}");
        assert_eq!((asymmetry(&map(f64::NAN))[0], asymmetry(&[vec![f64::NAN]])[0]), (f64::INFINITY, f64::INFINITY));
    }

    #[test]
    fn a_front_arrives_when_the_series_has_risen() {
        let series = vec![(0.0, 0.02), (1.0, 0.024), (2.0, 0.03)];
        assert_eq!((arrival(&series, 0.005), arrival(&series, 0.5)), (Some(2.0), None));
        assert!((mean(&series, (0.5, 2.0)) - 0.027).abs() < 1e-12);
    }
}
