//! The page of a report: one HTML file with the summary, the volume ledger, the gauges and all figures inside.

use serde::Deserialize;
use serde_json::Value;

use super::Figure;
use super::html::{self, END, begin, figure as figure_of, records, table};
use crate::gate::Gate;
use crate::maps::clock;
use crate::results::{Results, left_out};

/// The page as text.
pub(super) fn page(run: &Results, figures: &[Figure]) -> String {
    let mut html = begin(&run.title);
    status(&mut html, run);
    table(&mut html, "The run", &summary_rows(run));
    table(&mut html, "The cells of the run", &cell_rows(&run.summary));
    table(&mut html, "The breach", &breach_rows(&run.summary["breach"]));
    table(&mut html, "The bed that moves", &moving_bed_rows(&run.summary["moving_bed"]));
    table(&mut html, "Volume balance", &volume_rows(&run.summary["volume_m3"]));
    let boundaries: Vec<&[String]> = run.boundaries.1.iter().map(|row| &row[..]).collect();
    records(&mut html, "Inflow and outflow", &run.boundaries.0, &boundaries);
    table(&mut html, "Warnings under which it ran", &warning_rows(&run.summary));
    for figure in figures {
        figure_of(&mut html, &figure.caption, &figure.svg);
    }
    let gauges: Vec<&[String]> = run.gauges.iter().map(|gauge| &gauge.cells[..]).collect();
    records(&mut html, "Gauges", &run.gauge_columns, &gauges);
    let sections: Vec<&[String]> = run.sections.1.iter().map(|row| &row[..]).collect();
    records(&mut html, "Cross-sections", &run.sections.0, &sections);
    table(&mut html, "Methods", &pairs(&run.summary["methods"]));
    table(&mut html, "Inputs (SHA-256)", &input_rows(&run.summary["inputs"]));
    html.push_str(END);
    html
}

/// Whether the run can be relied on, before anything else.
fn status(html: &mut String, run: &Results) {
    let gates = run.summary["gates"].as_array().map(Vec::as_slice).unwrap_or_default();
    let doubt = run.doubt();
    let first = doubt.clone().unwrap_or_else(|| "done".to_owned());
    let lines: Vec<String> = std::iter::once(first).chain(gates.iter().map(gate_in_words)).collect();
    html::status(html, doubt.is_none(), &lines);
}

/// A quality gate of `run.json` in a line; those before version 0.2 are lines.
fn gate_in_words(gate: &Value) -> String {
    let line = gate.as_str().map(str::to_owned);
    line.or_else(|| Some(Gate::deserialize(gate).ok()?.to_string())).unwrap_or_else(|| gate.to_string())
}

fn summary_rows(run: &Results) -> Vec<(String, String)> {
    let summary = &run.summary;
    let mut rows = Vec::new();
    let mut add = |name: &str, value: Option<String>| rows.extend(value.map(|value| (name.to_string(), value)));
    let number = |value: &Value| value.as_f64();
    let seconds = |value: &Value| number(value).map(|s| if s < 60.0 { format!("{s:.1} s") } else { clock(s) });
    add("Program", summary["version"].as_str().map(|version| format!("floodsim {version}")));
    add("Command", summary["command"].as_str().map(str::to_string));
    let earlier = &summary["hot_start"];
    let moment = earlier["path"].as_str().zip(number(&earlier["time_s"]));
    add("Gone on from", moment.map(|(path, time)| format!("{path}, {}", clock(time))));
    add("Coordinate reference system", Some(run.crs.clone()));
    let (grid, metres) = (&run.grid, run.grid.cell);
    add("Grid of the maps", Some(format!("{} × {} cells of {metres} m", grid.columns, grid.rows)));
    add("Simulated", seconds(&summary["simulated_s"]));
    add("Riverbed particles", number(&summary["bed_particles"]).map(|n| format!("{n}")));
    add("Peak number of wet cells", number(&summary["particles"]["peak"]).map(|n| format!("{n}")));
    add("Time steps", number(&summary["steps"]).map(|n| format!("{n}")));
    let step = &summary["dt_s"];
    let steps = number(&step["min"]).zip(number(&step["median"])).zip(number(&step["max"]));
    add("Time step: minimum, median, maximum", steps.map(|((a, b), c)| format!("{a:.3} s, {b:.3} s, {c:.3} s")));
    add("Maximum speed", number(&summary["max_speed_m_s"]).map(|v| format!("{v:.3} m/s")));
    add("Wall-clock time", seconds(&summary["wall_s"]));
    add("CPU time", seconds(&summary["cpu_s"]));
    let missing: Vec<&str> = left_out(summary).collect();
    let missing = (!missing.is_empty()).then(|| format!("{}, left out of `outputs.write`", missing.join(", ")));
    add("Not written", missing);
    add("Peak memory", number(&summary["peak_rss_mb"]).map(|mb| format!("{mb:.0} MB")));
    rows
}

/// How the spacing was chosen, and the levels with the reasons for them; nothing of one spacing that the scenario has.
fn cell_rows(summary: &Value) -> Vec<(String, String)> {
    let because = summary["resolution"]["because"].as_array().map(Vec::as_slice).unwrap_or_default();
    let reason = |reason: &Value| ("Chosen".to_owned(), reason.as_str().unwrap_or_default().to_owned());
    let mut rows: Vec<(String, String)> = because.iter().map(reason).collect();
    for level in summary["levels"].as_array().map(Vec::as_slice).unwrap_or_default() {
        let Some((edge, cells)) = level["spacing_m"].as_f64().zip(level["cells"].as_u64()) else { continue };
        let areas = level["area_m2"].as_object();
        let area =
            |(because, area): (&String, &Value)| format!("{because} {:.3} km²", area.as_f64().unwrap_or(0.0) / 1e6);
        let areas: Vec<String> = areas.into_iter().flatten().map(area).collect();
        rows.push((format!("{edge} m"), format!("{cells} cells; {}", areas.join(", "))));
    }
    rows
}

/// When the dam broke and what its opening became; nothing without one.
fn breach_rows(breach: &Value) -> Vec<(String, String)> {
    if breach.is_null() {
        return Vec::new();
    }
    let began = breach["began_s"].as_f64().map_or("not in this run".to_owned(), clock);
    let metres = |key: &str| breach[key].as_f64().map(|value| format!("{value:.2} m"));
    let slope = breach["side_slope"].as_f64().map(|slope| format!("{slope:.2} to 1"));
    let grown = breach["duration_s"]
        .as_f64()
        .map(|s| if s > 0.0 { format!("{:.1} min", s / 60.0) } else { "at once".to_owned() });
    let rows = [
        ("Began", Some(began)),
        ("Crest of the dam", metres("crest_m")),
        ("Bottom of the opening in the end", metres("invert_m")),
        ("Width of the bottom in the end", metres("bottom_width_m")),
        ("Sides, horizontal to vertical", slope),
        ("Grown within", grown),
    ];
    rows.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?))).collect()
}

/// When the bed moved and by how much; nothing where it does not.
fn moving_bed_rows(bed: &Value) -> Vec<(String, String)> {
    let volume = |key: &str| bed[key].as_f64().map(|volume| format!("{volume:.1} m³"));
    let rows = [
        ("Began", bed["began_s"].as_f64().map(clock)),
        ("In the end above the bed of the start", volume("raised_m3")),
        ("In the end below it", volume("sunk_m3")),
        ("Water lifted by it", volume("lifted_m3")),
        ("Water lowered by it", volume("lowered_m3")),
    ];
    rows.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?))).collect()
}

/// What the check warned of, and what the run found that its maps do not show.
fn warning_rows(summary: &Value) -> Vec<(String, String)> {
    let list = |key: &str| summary[key].as_array().map(Vec::as_slice).unwrap_or_default().iter();
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let warning = |warning: &Value| {
        let place = warning["at"].as_array().and_then(|at| Some((at.first()?.as_f64()?, at.get(1)?.as_f64()?)));
        let place = place.map_or_else(String::new, |(x, y)| format!(" (at {x:.1}, {y:.1})"));
        let cause = warning["cause"].as_str().map_or_else(String::new, |cause| format!("; {cause}"));
        (text(&warning["key"]), format!("{}{place}{cause}", text(&warning["message"])))
    };
    let above = |above: &Value| {
        let [height, distance, time] =
            ["height_m", "distance_m", "time_s"].map(|key| above[key].as_f64().unwrap_or(f64::NAN));
        let reported = format!(
            "its water stood {height:.2} m above the last row of its sections, {distance:.0} m from its far end at {}; what would have left it there stayed in",
            clock(time)
        );
        (format!("channel {}", text(&above["channel"])), reported)
    };
    list("warnings").map(warning).chain(list("above_banks").map(above)).collect()
}

fn volume_rows(volume: &Value) -> Vec<(String, String)> {
    let lines =
        [("initial", "Water at the start"), ("in", "Inflow"), ("out", "Outflow"), ("final", "Water at the end")];
    let volumes = lines.iter().filter_map(|(key, name)| {
        volume[*key].as_f64().map(|cubic_metres| (name.to_string(), format!("{cubic_metres:.1} m³")))
    });
    let errors =
        [("error_relative", "Error of the volume balance"), ("grid_error_relative", "Error of the maps' volume")];
    let errors = errors.iter().filter_map(|(key, name)| {
        volume[*key].as_f64().map(|error| (format!("{name}, relative"), format!("{error:.1e}")))
    });
    let held =
        [("of_rain_m3", "Rain"), ("in_films_m3", "Held back in thin films"), ("in_pits_m3", "Held back in pits")];
    let held = held.iter().filter_map(|(key, name)| {
        volume["held_back"][*key].as_f64().map(|cubic_metres| (name.to_string(), format!("{cubic_metres:.1} m³")))
    });
    volumes.chain(held).chain(errors).collect()
}

fn pairs(object: &Value) -> Vec<(String, String)> {
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_string);
    object
        .as_object()
        .map(|map| map.iter().map(|(key, value)| (key.clone(), text(value))).collect())
        .unwrap_or_default()
}

fn input_rows(inputs: &Value) -> Vec<(String, String)> {
    let rows = inputs.as_array().map(Vec::as_slice).unwrap_or_default().iter();
    rows.filter_map(|input| Some((input["path"].as_str()?.to_string(), input["sha256"].as_str()?.to_string())))
        .collect()
}
