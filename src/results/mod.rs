//! A run folder, read back: maps, frames, tables, summary.

use std::path::Path;

mod grids;
mod rows;

use crate::csv::as_meant;
use crate::error::{Error, Problem, ProblemKind};
use crate::geodata::netcdf_file;
use crate::maps::{MapGrid, Mark, Series, clock};
use crate::plain_file;

pub(crate) use grids::onto;
pub(crate) use rows::MapRows;

/// The columns and the rows of a table.
pub(crate) type Table = (Vec<String>, Vec<Vec<String>>);

/// A gauge with its row of `tables/gauges.csv`.
pub(crate) struct GaugeRow {
    pub cells: Vec<String>,
    id: String,
    name: Option<String>,
    place: (f64, f64),
}

impl GaugeRow {
    /// Its mark on a map: with its full name where there are few gauges.
    pub fn mark(&self, gauges: usize) -> Mark {
        let name = match &self.name {
            Some(name) if gauges <= 12 => format!("{} {name}", self.id),
            _ => self.id.clone(),
        };
        Mark { name, place: self.place }
    }
}

/// What a run folder holds.
pub(crate) struct Results {
    pub title: String,
    pub crs: String,
    pub grid: MapGrid,
    pub bed: Vec<f64>,
    pub summary: serde_json::Value,
    pub gauge_columns: Vec<String>,
    pub gauges: Vec<GaugeRow>,
    pub series: Vec<Series>,
    /// `tables/sections.csv`: columns and rows.
    pub sections: Table,
    /// `tables/boundaries.csv`: columns and rows.
    pub boundaries: Table,
    /// The size of the discharge over time at each section.
    pub discharges: Vec<Series>,
    maps: netcdf::File,
    /// With the grid of the frames.
    fields: Option<(netcdf::File, MapGrid)>,
}

impl Results {
    /// Whether the dam is gone at the start: none breaks later, no water comes from elsewhere, and no earlier run had its beginning.
    pub fn begins_with_the_failure(&self) -> bool {
        self.summary["breach"].is_null()
            && self.summary["hot_start"].is_null()
            && self.summary["volume_m3"]["in"].as_f64().is_none_or(|volume| volume <= 0.0)
    }

    /// Opens the folder of a finished run; one that is under way or was killed is refused, whatever it holds.
    pub fn open(folder: &Path) -> Result<Results, Error> {
        let summary = plain_file::read_to_string(folder.join("run.json")).ok();
        let summary = summary.and_then(|text| serde_json::from_str(&text).ok()).unwrap_or(serde_json::Value::Null);
        if summary["status"] == "running" {
            return Err(unfinished(folder));
        }
        if summary["bed_particles"] == 0 {
            return Err(without_maps(folder));
        }
        if left_out(&summary).any(|part| part == "maps") && !folder.join("maps.nc").exists() {
            return Err(maps_left_out(folder));
        }
        let maps = open(&folder.join("maps.nc"))?;
        let fields_path = folder.join("fields.nc");
        let open_fields = || {
            let fields = open(&fields_path)?;
            let grid = read_grid(&fields, &fields_path)?;
            Ok::<_, Error>((fields, grid))
        };
        let fields = fields_path.exists().then(open_fields).transpose()?;
        let grid = read_grid(&maps, &folder.join("maps.nc"))?;
        let bed = variable(&maps, "bed_elevation", None)?
            .ok_or_else(|| unreadable(&folder.join("maps.nc"), "it has no variable `bed_elevation`".to_string()))?;
        let text = |name: &str| match maps.attribute(name).map(|attribute| attribute.value()) {
            Some(Ok(netcdf::AttributeValue::Str(text))) => Some(text),
            _ => None,
        };
        let (gauge_columns, gauges) = read_gauges(&folder.join("tables/gauges.csv"));
        let table = |name: &str| table_of(folder, name);
        let sections = table("sections.csv");
        Ok(Results {
            title: text("title").unwrap_or_else(|| "Flood".to_string()),
            crs: crs_name(&maps),
            series: read_series(&folder.join("tables/gauge_series.csv"), &gauges),
            discharges: read_discharges(&folder.join("tables/section_series.csv"), &sections.1),
            sections,
            boundaries: table("boundaries.csv"),
            grid,
            bed,
            summary,
            gauge_columns,
            gauges,
            maps,
            fields,
        })
    }

    /// A map of `maps.nc`, NaN where it has no value.
    pub fn map(&self, name: &str) -> Result<Option<Vec<f64>>, Error> {
        variable(&self.maps, name, None)
    }

    /// The least depth (m) that has a map of arrival.
    pub fn arrival_depth(&self) -> Option<f64> {
        let coordinate = text_of(&self.maps, "arrival_time", "coordinates")?;
        variable(&self.maps, &coordinate, None).ok()??.first().copied()
    }

    /// The reference system of the maps as text, and its code; none of plain metres.
    pub fn reference_system(&self) -> Option<(String, Option<String>)> {
        Some((text_of(&self.maps, "crs", "crs_wkt")?, text_of(&self.maps, "crs", "epsg_code")))
    }

    /// The names of the tracers.
    pub fn tracers(&self) -> Vec<String> {
        let names = self.maps.variables().map(|variable| variable.name());
        names.filter_map(|name| name.strip_prefix("dilution_").map(str::to_owned)).collect()
    }

    /// Depth in the first frame.
    pub fn initial_depth(&self) -> Result<Option<Vec<f64>>, Error> {
        self.fields.as_ref().map_or(Ok(None), |(fields, grid)| self.depth(fields, grid, 0))
    }

    /// Depth in a frame on the grid of the maps.
    fn depth(&self, fields: &netcdf::File, grid: &MapGrid, frame: usize) -> Result<Option<Vec<f64>>, Error> {
        Ok(variable(fields, "depth", Some(frame))?.map(|depth| onto(&self.grid, grid, depth)))
    }

    /// Time (s) and depth of the frames nearest to an eighth, a quarter, a half and the whole of the run.
    pub fn four_frames(&self) -> Result<Vec<(f64, Vec<f64>)>, Error> {
        let Some((fields, grid)) = &self.fields else { return Ok(Vec::new()) };
        let Some(times) = variable(fields, "time", None)? else { return Ok(Vec::new()) };
        let end = times.last().copied().unwrap_or(0.0);
        let nearest = |wanted: f64| {
            (0..times.len()).min_by(|a, b| (times[*a] - wanted).abs().total_cmp(&(times[*b] - wanted).abs()))
        };
        let mut chosen: Vec<usize> = [0.125, 0.25, 0.5, 1.0].iter().filter_map(|part| nearest(part * end)).collect();
        chosen.dedup();
        let mut frames = Vec::new();
        for frame in chosen {
            if let Some(depth) = self.depth(fields, grid, frame)? {
                frames.push((times[frame], depth));
            }
        }
        Ok(frames)
    }

    /// Why the results are not those of a whole and sound run; none when they are.
    pub fn doubt(&self) -> Option<String> {
        let time = self.summary["simulated_s"].as_f64().map_or("an unknown time".to_string(), clock);
        match (self.summary["status"].as_str(), self.summary["exit_code"].as_i64()) {
            (Some("done"), Some(0)) => None,
            (Some("done"), _) => Some("the run ended, but failed a quality gate".to_string()),
            (Some("stopped"), _) => Some(format!("the run was stopped at {time}; what came later is missing")),
            (Some("failed"), _) => Some(format!("the run broke down at {time}; what came later is missing")),
            _ => Some("there is no run.json that says how the run ended".to_string()),
        }
    }

    /// Version, methods and resolution in one line; a doubt comes first.
    pub fn note(&self) -> String {
        let version = self.summary["version"].as_str().unwrap_or(env!("CARGO_PKG_VERSION"));
        let methods = &self.summary["methods"];
        let named = ["formulation", "motion"].iter().filter_map(|family| methods[family].as_str());
        let parts = std::iter::once(format!("floodsim {version}")).chain(named.map(str::to_string));
        self.doubt().into_iter().chain(parts).collect::<Vec<_>>().join(" · ")
    }
}

fn unreadable(path: &Path, cause: String) -> Error {
    let message = format!("{} cannot be read as the result of a run", path.display());
    Error::Problems(vec![
        Problem::error(ProblemKind::Input, "not-a-run", "", message)
            .with_cause(cause)
            .with_remedy("name the folder of a finished run, which holds maps.nc"),
    ])
}

fn unfinished(folder: &Path) -> Error {
    let message = format!("the run in {} is not finished: its run.json says `running`", folder.display());
    Error::Problems(vec![
        Problem::error(ProblemKind::Input, "unfinished-run", "", message)
            .with_cause("it is still under way, or it was killed")
            .with_remedy("wait for its end; of a run that was killed, go on with `floodsim resume`, or run the scenario again with --overwrite"),
    ])
}

fn without_maps(folder: &Path) -> Error {
    let message = format!("the run in {} has channels alone, and a report shows maps", folder.display());
    Error::Problems(vec![
        Problem::error(ProblemKind::Input, "no-maps", "", message)
            .with_cause("its scenario has no terrain")
            .with_remedy("draw its profiles from channels.nc or tables/channels.csv"),
    ])
}

/// The parts of the folder that `outputs.write` of its scenario left out, by a summary of the run.
pub(crate) fn left_out(summary: &serde_json::Value) -> impl Iterator<Item = &str> {
    summary["not_written"].as_array().into_iter().flatten().filter_map(serde_json::Value::as_str)
}

fn maps_left_out(folder: &Path) -> Error {
    let message = format!("the run in {} wrote no maps.nc, and a report shows its maps", folder.display());
    Error::Problems(vec![
        Problem::error(ProblemKind::Input, "not-written", "outputs.write", message)
            .with_cause("`outputs.write` of its scenario leaves `maps` out")
            .with_remedy("add `maps` to `outputs.write`, or take the key out, and run the scenario again"),
    ])
}

fn open(path: &Path) -> Result<netcdf::File, Error> {
    plain_file::open(path).map_err(|cause| unreadable(path, cause.to_string()))?;
    if let Some(damaged) = netcdf_file::impossible(path) {
        return Err(unreadable(path, damaged.cause.unwrap_or(damaged.message)));
    }
    netcdf_file::open(path).map_err(|cause| unreadable(path, cause.to_string()))
}

/// All values of a variable, or those of one frame, with NaN in place of the fill value.
fn variable(file: &netcdf::File, name: &str, frame: Option<usize>) -> Result<Option<Vec<f64>>, Error> {
    let Some(variable) = file.variable(name) else { return Ok(None) };
    let values = match frame {
        Some(frame) => variable.get_values::<f64, _>((frame, .., ..)),
        None => variable.get_values::<f64, _>(..),
    };
    let path = file.path().unwrap_or_default();
    let mut values = values.map_err(|cause| unreadable(&path, format!("variable `{name}`: {cause}")))?;
    if let Some(fill) = fill_of(&variable) {
        // A fill value is stored, not computed: equal bits mean missing.
        values.iter_mut().filter(|value| value.to_bits() == fill.to_bits()).for_each(|value| *value = f64::NAN);
    }
    Ok(Some(values))
}

/// The number that stands for no value in a variable.
fn fill_of(variable: &netcdf::Variable<'_>) -> Option<f64> {
    variable.attribute_value("_FillValue").and_then(Result::ok).and_then(|fill| f64::try_from(fill).ok())
}

/// The grid from the coordinate variables, which hold the centres of the cells, y descending.
fn read_grid(maps: &netcdf::File, path: &Path) -> Result<MapGrid, Error> {
    let (x, y) = (variable(maps, "x", None)?.unwrap_or_default(), variable(maps, "y", None)?.unwrap_or_default());
    let (Some(first_x), Some(last_x), Some(first_y), Some(last_y)) = (x.first(), x.last(), y.first(), y.last()) else {
        return Err(unreadable(path, "it has no coordinates `x` and `y`".to_string()));
    };
    let cell = match (x.len(), y.len()) {
        (1, 1) => return Err(unreadable(path, "its grid has a single cell".to_string())),
        (1, rows) => (first_y - last_y) / (rows - 1) as f64,
        (columns, _) => (last_x - first_x) / (columns - 1) as f64,
    };
    Ok(MapGrid { columns: x.len(), rows: y.len(), west: first_x - 0.5 * cell, north: first_y + 0.5 * cell, cell })
}

/// A text that a variable has as an attribute.
fn text_of(file: &netcdf::File, variable: &str, name: &str) -> Option<String> {
    match file.variable(variable)?.attribute_value(name)?.ok()? {
        netcdf::AttributeValue::Str(text) => Some(text),
        _ => None,
    }
}

fn crs_name(maps: &netcdf::File) -> String {
    let attribute = |name: &str| text_of(maps, "crs", name);
    let name_in_wkt = || attribute("crs_wkt")?.split('"').nth(1).map(str::to_string);
    attribute("epsg_code").or_else(name_in_wkt).unwrap_or_else(|| "local metres".to_string())
}

/// A table of a run folder; empty where it is absent.
pub(crate) fn table_of(folder: &Path, name: &str) -> Table {
    let mut rows = read_csv(&folder.join("tables").join(name)).into_iter();
    (rows.next().unwrap_or_default(), rows.collect())
}

/// The lines of a table, each split at commas outside quotes; none where the file is absent.
fn read_csv(path: &Path) -> Vec<Vec<String>> {
    let text = plain_file::read_to_string(path).unwrap_or_default();
    let meant = |cells: Vec<String>| cells.iter().map(|cell| as_meant(cell).to_owned()).collect();
    text.lines().filter(|line| !line.trim().is_empty()).map(|line| meant(split_csv(line))).collect()
}

fn split_csv(line: &str) -> Vec<String> {
    let (mut cells, mut quoted) = (vec![String::new()], false);
    let mut characters = line.chars().peekable();
    while let Some(character) = characters.next() {
        let last = cells.len() - 1;
        match character {
            '"' if quoted && characters.peek() == Some(&'"') => {
                characters.next();
                cells[last].push('"');
            }
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            _ => cells[last].push(character),
        }
    }
    cells
}

fn read_gauges(path: &Path) -> (Vec<String>, Vec<GaugeRow>) {
    let mut rows = read_csv(path).into_iter();
    let columns = rows.next().unwrap_or_default();
    let column = |name: &str| columns.iter().position(|column| column == name);
    let (Some(id), Some(x), Some(y)) = (column("id"), column("x"), column("y")) else { return (columns, Vec::new()) };
    let name = column("name");
    let gauges = rows.filter_map(|cells| {
        let number = |k: usize| cells.get(k)?.parse::<f64>().ok();
        let place = (number(x)?, number(y)?);
        let name = name.and_then(|k| cells.get(k)).filter(|name| !name.is_empty()).cloned();
        Some(GaugeRow { id: cells.get(id)?.clone(), name, place, cells })
    });
    let gauges = gauges.collect();
    (columns, gauges)
}

/// The depth over time at each gauge, in the order of the gauges.
fn read_series(path: &Path, gauges: &[GaugeRow]) -> Vec<Series> {
    let count = gauges.len();
    let mut series: Vec<Series> =
        gauges.iter().map(|gauge| Series { name: gauge.mark(count).name, points: Vec::new() }).collect();
    let mut rows = read_csv(path).into_iter();
    let columns = rows.next().unwrap_or_default();
    let column = |name: &str| columns.iter().position(|column| column == name);
    let (Some(id), Some(time), Some(depth)) = (column("id"), column("time_s"), column("depth_m")) else {
        return series;
    };
    for cells in rows {
        let number = |k: usize| cells.get(k)?.parse::<f64>().ok();
        let gauge = gauges.iter().position(|gauge| Some(&gauge.id) == cells.get(id));
        if let (Some(gauge), Some(time), Some(depth)) = (gauge, number(time), number(depth)) {
            series[gauge].points.push((time, depth));
        }
    }
    series
}

/// The size of the discharge over time at each section, in the order of the sections.
fn read_discharges(path: &Path, sections: &[Vec<String>]) -> Vec<Series> {
    let name = |row: &Vec<String>| row.first().cloned().unwrap_or_default();
    let mut series: Vec<Series> = sections.iter().map(|row| Series { name: name(row), points: Vec::new() }).collect();
    let mut rows = read_csv(path).into_iter();
    let columns = rows.next().unwrap_or_default();
    let column = |name: &str| columns.iter().position(|column| column == name);
    let (Some(id), Some(time), Some(discharge)) = (column("id"), column("time_s"), column("discharge_m3_s")) else {
        return series;
    };
    for cells in rows {
        let number = |k: usize| cells.get(k)?.parse::<f64>().ok();
        let line = series.iter().position(|line| Some(&line.name) == cells.get(id));
        if let (Some(line), Some(time), Some(discharge)) = (line, number(time), number(discharge)) {
            series[line].points.push((time, discharge.abs()));
        }
    }
    series
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quoted_commas_do_not_part_cells() {
        assert_eq!(split_csv(r#"G1,"a, ""b""",3"#), ["G1", r#"a, "b""#, "3"]);
    }
}
