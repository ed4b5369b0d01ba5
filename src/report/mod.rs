//! `floodsim report DIR`: map sheets and one page from a run folder, without a new simulation.
//!
//! Reads `maps.nc`, `fields.nc`, `run.json` and `tables/`; writes `report/*.svg` and `report/index.html`, which holds all of
//! them and needs no other file. What a folder lacks is left out of the page, save `maps.nc`, without which there is none.

pub(crate) mod html;
mod page;

#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::maps::{Classes, Mark, Panel, Series, Sheet, clock, hydrograph, map_sheet};
use crate::results::Results;

/// Most lines that one hydrograph can show and still be read.
const MOST_LINES: usize = 16;

/// What was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// The files, the page last.
    pub files: Vec<PathBuf>,
    /// Why the results are not those of a whole and sound run, as page and sheets say too; none when they are.
    pub doubt: Option<String>,
}

/// Writes the report of a run folder.
///
/// # Errors
/// [`Error::Problems`] when the folder holds no readable run, [`Error::Output`] when the report cannot be written.
pub fn report(folder: &Path) -> Result<Report, Error> {
    let run = Results::open(folder)?;
    let target = folder.join("report");
    std::fs::create_dir_all(&target).map_err(|cause| output_error(&target, &cause))?;
    let mut files = Vec::new();
    let mut write = |name: &str, text: &str| {
        let path = target.join(name);
        std::fs::write(&path, text).map_err(|cause| output_error(&path, &cause))?;
        files.push(path);
        Ok::<(), Error>(())
    };
    let figures = figures(&run)?;
    for figure in &figures {
        write(&format!("{}.svg", figure.name), &figure.svg)?;
    }
    write("index.html", &page::page(&run, &figures))?;
    Ok(Report { files, doubt: run.doubt() })
}

fn output_error(path: &Path, cause: &std::io::Error) -> Error {
    Error::Output { path: path.to_path_buf(), cause: cause.to_string() }
}

/// A picture of the report.
struct Figure {
    name: Cow<'static, str>,
    caption: Cow<'static, str>,
    svg: String,
}

/// What all sheets of a report share.
struct Common<'a> {
    run: &'a Results,
    marks: Vec<Mark>,
    note: String,
}

impl Common<'_> {
    fn sheet(&self, subtitle: &str, panels: Vec<Panel>) -> String {
        let run = self.run;
        map_sheet(&Sheet {
            title: &run.title,
            subtitle,
            grid: &run.grid,
            bed: &run.bed,
            panels,
            marks: &self.marks,
            crs: &run.crs,
            note: &self.note,
        })
    }

    /// A figure of one map.
    fn figure(&self, name: &'static str, caption: &'static str, map: Panel) -> Figure {
        Figure { name: name.into(), caption: caption.into(), svg: self.sheet(caption, vec![map]) }
    }
}

fn map_panel<'a>(values: &'a [f64], classes: &'a Classes) -> Panel<'a> {
    Panel { caption: String::new(), values, classes, under: None, wide: true }
}

fn figures(run: &Results) -> Result<Vec<Figure>, Error> {
    let marks = run.gauges.iter().map(|gauge| gauge.mark(run.gauges.len())).collect();
    let common = Common { run, marks, note: run.note() };
    let mut figures = Vec::new();

    let is_failure = run.begins_with_the_failure();
    let origin = if is_failure { "the failure" } else { "the start of the run" };
    let max_depth = run.map("max_depth")?.unwrap_or_default();
    let depth_classes = Classes::depth(greatest(&max_depth));
    if !max_depth.is_empty() {
        figures.push(common.figure(
            "max_depth",
            "Maximum water depth at any time",
            map_panel(&max_depth, &depth_classes),
        ));
    }
    let arrival = run.map("arrival_time")?.unwrap_or_default();
    let arrival_classes = Classes::arrival(&isochrones(greatest(&arrival)));
    let initial = run.initial_depth()?.unwrap_or_default();
    let still_classes = Classes {
        title: format!("Before {origin}"),
        entries: vec![(depth_classes.entries[0].0, [0xb4, 0xbc, 0xc8], "water at the start".to_string())],
    };
    let under = (!initial.is_empty()).then_some((&initial[..], &still_classes));
    let arrival_panel = (!arrival.is_empty()).then(|| Panel { under, ..map_panel(&arrival, &arrival_classes) });
    if let Some(panel) = &arrival_panel {
        let caption = if is_failure {
            "Time from the failure to the arrival of the flood"
        } else {
            "Time from the start of the run to the arrival of the flood"
        };
        figures.push(common.figure("arrival", caption, panel.clone()));
    }
    if let Some(values) = run.map("hazard_class")? {
        let classes = Classes::hazard();
        figures.push(common.figure("hazard", "Maximum hazard class (AIDR H1 to H6)", map_panel(&values, &classes)));
    }
    if let Some(values) = run.map("max_speed")? {
        let classes = Classes::speed(greatest(&values));
        figures.push(common.figure("max_speed", "Maximum speed at any time", map_panel(&values, &classes)));
    }
    figures.extend(error_figure(&common)?);
    for tracer in run.tracers() {
        figures.extend(dilution(&common, &tracer)?);
    }
    figures.extend(four_times(&common, &depth_classes, arrival_panel, origin)?);
    figures.extend(lines("gauges", "Water depth at the gauges", "depth (m)", &run.series));
    figures.extend(lines("sections", "Discharge at the cross-sections", "discharge (m³/s)", &run.discharges));
    Ok(figures)
}

/// The estimated error of the maximum depth; none where it was not asked for.
fn error_figure(common: &Common<'_>) -> Result<Option<Figure>, Error> {
    let Some(values) = common.run.map("max_depth_error")? else { return Ok(None) };
    let classes = Classes { title: "Estimated error (m)".to_owned(), ..Classes::depth(greatest(&values)) };
    let caption = "Estimated error of the maximum depth, by a second run on cells twice as wide";
    Ok(Some(common.figure("max_depth_error", caption, map_panel(&values, &classes))))
}

/// The dilution of a tracer.
fn dilution(common: &Common<'_>, tracer: &str) -> Result<Option<Figure>, Error> {
    let name = format!("dilution_{tracer}");
    let Some(values) = common.run.map(&name)? else { return Ok(None) };
    let classes = Classes::dilution(greatest(&values));
    let caption = format!("Maximum concentration of {tracer} over that of its sources");
    let svg = common.sheet(&caption, vec![map_panel(&values, &classes)]);
    Ok(Some(Figure { name: name.into(), caption: caption.into(), svg }))
}

/// The depth at four times after the origin, and the arrival where it is known; none without frames.
fn four_times(
    common: &Common<'_>,
    classes: &Classes,
    arrival: Option<Panel>,
    origin: &str,
) -> Result<Option<Figure>, Error> {
    let frames = common.run.four_frames()?;
    let mut panels: Vec<Panel> = Vec::new();
    for (time, values) in &frames {
        let caption = format!("{} after {origin}", clock(*time));
        panels.push(Panel { caption, wide: false, ..map_panel(values, classes) });
    }
    if panels.is_empty() {
        return Ok(None);
    }
    panels.extend(arrival.map(|panel| Panel { caption: "Arrival of the flood".to_string(), ..panel }));
    let caption = "The flood at four times, and its arrival";
    Ok(Some(Figure { name: "four_times".into(), caption: caption.into(), svg: common.sheet(caption, panels) }))
}

/// A hydrograph of the lines that have more than a point; none where there are none.
fn lines(name: &'static str, caption: &'static str, axis: &str, all: &[Series]) -> Option<Figure> {
    let lines: Vec<Series> = all.iter().filter(|line| line.points.len() > 1).take(MOST_LINES).cloned().collect();
    (!lines.is_empty()).then(|| Figure {
        name: name.into(),
        caption: caption.into(),
        svg: hydrograph(caption, axis, &lines),
    })
}

/// The greatest finite value, 0 where there is none.
fn greatest(values: &[f64]) -> f64 {
    values.iter().copied().filter(|value| value.is_finite()).fold(0.0, f64::max)
}

/// Round times (s) that part the arrivals up to `last` (s) into about ten classes.
pub(crate) fn isochrones(last: f64) -> Vec<f64> {
    let steps =
        [1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 900.0, 1800.0, 3600.0, 7200.0, 21600.0, 86400.0];
    let step = steps.into_iter().find(|step| last <= 11.0 * step).unwrap_or(last / 10.0);
    (1..).map(|k| f64::from(k) * step).take_while(|time| *time < last).take(12).collect()
}
