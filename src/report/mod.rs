//! `floodsim report DIR`: map sheets and one page from a run folder, without a new simulation.
//!
//! Reads `maps.nc`, `fields.nc`, `run.json` and `tables/`; writes `report/*.svg` and `report/index.html`, which holds all of
//! them and needs no other file. What a folder lacks is left out of the page, save `maps.nc`, without which there is none.

mod page;
mod read;

use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::maps::{Classes, Mark, Panel, Series, Sheet, clock, hydrograph, map_sheet};
use read::RunFolder;

/// Most lines that one hydrograph can show and still be read.
const MOST_LINES: usize = 16;

/// Writes the report of a run folder and returns its files, the page last.
///
/// # Errors
/// [`Error::Problems`] when the folder holds no readable run, [`Error::Output`] when the report cannot be written.
pub fn report(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let run = RunFolder::open(folder)?;
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
    Ok(files)
}

fn output_error(path: &Path, cause: &std::io::Error) -> Error {
    Error::Output { path: path.to_path_buf(), cause: cause.to_string() }
}

/// A picture of the report.
struct Figure {
    name: &'static str,
    caption: &'static str,
    svg: String,
}

fn figures(run: &RunFolder) -> Result<Vec<Figure>, Error> {
    let marks: Vec<Mark> = run.gauges.iter().map(|gauge| gauge.mark(run.gauges.len())).collect();
    let note = run.note();
    let sheet = |subtitle: &'static str, panels: Vec<Panel>| {
        map_sheet(&Sheet {
            title: &run.title,
            subtitle,
            grid: &run.grid,
            bed: &run.bed,
            panels,
            marks: &marks,
            crs: &run.crs,
            note: &note,
        })
    };
    let panel = |caption: String, values, classes, under| Panel { caption, values, classes, under, wide: true };
    let mut figures = Vec::new();

    let max_depth = run.map("max_depth")?;
    let depth_classes = max_depth.as_deref().map(|values| Classes::depth(greatest(values)));
    let initial = run.initial_depth()?;
    let still_classes = depth_classes.as_ref().map(|classes| Classes {
        title: "Before the failure".to_string(),
        entries: vec![(classes.entries[0].0, [0xb4, 0xbc, 0xc8], "water at the start".to_string())],
    });
    let under = initial.as_deref().zip(still_classes.as_ref());
    if let (Some(values), Some(classes)) = (&max_depth, &depth_classes) {
        let svg = sheet("Greatest water depth at any time", vec![panel(String::new(), values, classes, None)]);
        figures.push(Figure { name: "max_depth", caption: "Greatest water depth at any time", svg });
    }
    let arrival = run.map("arrival_time")?;
    let arrival_classes = arrival.as_deref().map(|values| Classes::arrival(&isochrones(greatest(values))));
    if let (Some(values), Some(classes)) = (&arrival, &arrival_classes) {
        let svg = sheet(
            "Time from the failure to the arrival of the flood",
            vec![panel(String::new(), values, classes, under)],
        );
        figures.push(Figure { name: "arrival", caption: "Arrival of the flood", svg });
    }
    if let Some(values) = run.map("hazard_class")? {
        let classes = Classes::hazard();
        let svg = sheet("Greatest momentary hazard class", vec![panel(String::new(), &values, &classes, None)]);
        figures.push(Figure { name: "hazard", caption: "Greatest momentary hazard class", svg });
    }
    if let Some(values) = run.map("max_speed")? {
        let classes = Classes::speed(greatest(&values));
        let svg = sheet("Greatest speed at any time", vec![panel(String::new(), &values, &classes, None)]);
        figures.push(Figure { name: "max_speed", caption: "Greatest speed at any time", svg });
    }
    let frames = run.four_frames()?;
    if let Some(classes) = depth_classes.as_ref().filter(|_| !frames.is_empty()) {
        let mut panels: Vec<Panel> = frames
            .iter()
            .map(|(time, values)| Panel {
                wide: false,
                ..panel(format!("{} after the failure", clock(*time)), values, classes, None)
            })
            .collect();
        if let (Some(values), Some(classes)) = (&arrival, &arrival_classes) {
            panels.push(panel("Arrival of the flood".to_string(), values, classes, under));
        }
        let svg = sheet("Water depth at four times, and arrival of the flood", panels);
        figures.push(Figure { name: "four_times", caption: "The flood at four times, and its arrival", svg });
    }
    let series: Vec<Series> =
        run.series.iter().filter(|line| line.points.len() > 1).take(MOST_LINES).cloned().collect();
    if !series.is_empty() {
        let svg = hydrograph("Water depth at the gauges", "depth (m)", &series);
        figures.push(Figure { name: "gauges", caption: "Water depth at the gauges", svg });
    }
    Ok(figures)
}

/// The greatest finite value, 0 where there is none.
fn greatest(values: &[f64]) -> f64 {
    values.iter().copied().filter(|value| value.is_finite()).fold(0.0, f64::max)
}

/// Round times (s) that part the arrivals up to `last` (s) into about ten classes.
fn isochrones(last: f64) -> Vec<f64> {
    let steps =
        [1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 900.0, 1800.0, 3600.0, 7200.0, 21600.0, 86400.0];
    let step = steps.into_iter().find(|step| last <= 11.0 * step).unwrap_or(last / 10.0);
    (1..).map(|k| f64::from(k) * step).take_while(|time| *time < last).take(12).collect()
}
