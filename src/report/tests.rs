use std::path::Path;

use super::*;

const COLUMNS: usize = 40;
const ROWS: usize = 25;

/// A run folder as the writers of results leave it, with made values: water of depth 2 m that spreads eastwards.
fn run_folder(folder: &Path) {
    let bed: Vec<f32> =
        (0..COLUMNS * ROWS).map(|i| if i == 0 { -9999.0 } else { 100.0 - (i % COLUMNS) as f32 }).collect();
    let reached = |i: usize, columns: usize| (10..15).contains(&(i / COLUMNS)) && i % COLUMNS < columns;
    let depth =
        |columns: usize| (0..COLUMNS * ROWS).map(|i| if reached(i, columns) { 2.0 } else { 0.0 }).collect::<Vec<f32>>();
    let arrival: Vec<f32> =
        (0..COLUMNS * ROWS).map(|i| if reached(i, 30) { 10.0 * (i % COLUMNS) as f32 } else { -9999.0 }).collect();

    let mut maps = file(&folder.join("maps.nc"));
    for (name, values) in
        [("bed_elevation", &bed), ("max_depth", &depth(30)), ("arrival_time", &arrival), ("dilution_spill", &depth(12))]
    {
        let mut variable = maps.add_variable::<f32>(name, &["y", "x"]).unwrap();
        variable.set_fill_value(-9999f32).unwrap();
        variable.put_values(values, ..).unwrap();
    }
    let mut fields = file(&folder.join("fields.nc"));
    fields.add_unlimited_dimension("time").unwrap();
    fields.add_variable::<f64>("time", &["time"]).unwrap();
    fields.add_variable::<f32>("depth", &["time", "y", "x"]).unwrap();
    for (frame, columns) in [5usize, 10, 15, 20, 30].into_iter().enumerate() {
        fields.variable_mut("depth").unwrap().put_values(&depth(columns), (frame, .., ..)).unwrap();
        fields.variable_mut("time").unwrap().put_value(75.0 * frame as f64, frame).unwrap();
    }
    std::fs::create_dir(folder.join("tables")).unwrap();
    std::fs::write(
        folder.join("tables/gauges.csv"),
        "id,x,y,bed_m,arrival_s,max_depth_m,name\nG1,1055,2125,95,50,2,\"Mill, upper\"\nG2,1355,2125,65,,0,Inn\n",
    )
    .unwrap();
    std::fs::write(
        folder.join("tables/gauge_series.csv"),
        "id,time_s,depth_m,level_m\nG1,0,0,95\nG1,60,2,97\nG2,0,0,65\nG2,60,0,65\n",
    )
    .unwrap();
    std::fs::write(
        folder.join("run.json"),
        r#"{"version": "9.9", "steps": 1234, "status": "done", "exit_code": 0, "volume_m3": {"initial": 50000.0}}"#,
    )
    .unwrap();
}

fn file(path: &Path) -> netcdf::FileMut {
    let mut file = netcdf::create(path).unwrap();
    file.add_attribute("title", "Made valley").unwrap();
    file.add_dimension("y", ROWS).unwrap();
    file.add_dimension("x", COLUMNS).unwrap();
    let x: Vec<f64> = (0..COLUMNS).map(|k| 1005.0 + 10.0 * k as f64).collect();
    let y: Vec<f64> = (0..ROWS).map(|k| 2245.0 - 10.0 * k as f64).collect();
    file.add_variable::<f64>("x", &["x"]).unwrap().put_values(&x, ..).unwrap();
    file.add_variable::<f64>("y", &["y"]).unwrap().put_values(&y, ..).unwrap();
    file
}

#[test]
fn a_run_folder_is_read_back_as_it_was_written() {
    let folder = tempfile::tempdir().unwrap();
    run_folder(folder.path());
    let run = crate::results::Results::open(folder.path()).unwrap();
    assert_eq!((run.grid.columns, run.grid.rows), (COLUMNS, ROWS));
    assert!((run.grid.west - 1000.0).abs() < 1e-9 && (run.grid.north - 2250.0).abs() < 1e-9);
    assert!(run.bed[0].is_nan() && (run.bed[1] - 99.0).abs() < 1e-9);
    assert!(run.map("max_speed").unwrap().is_none());
    let times: Vec<f64> = run.four_frames().unwrap().iter().map(|frame| frame.0).collect();
    assert_eq!(times, [0.0, 75.0, 150.0, 300.0]); // nearest to 37.5, 75, 150 and 300 s
    assert_eq!(run.series[0].points, [(0.0, 0.0), (60.0, 2.0)]);
}

#[test]
fn the_report_holds_every_figure_and_needs_no_other_file() {
    let folder = tempfile::tempdir().unwrap();
    run_folder(folder.path());
    let Report { files, doubt } = report(folder.path()).unwrap();
    assert_eq!(doubt, None);
    let names: Vec<_> = files.iter().filter_map(|path| path.file_name()?.to_str()).collect();
    let drawn = ["max_depth.svg", "arrival.svg", "dilution_spill.svg", "four_times.svg", "gauges.svg", "index.html"];
    assert_eq!(names, drawn);
    let page = std::fs::read_to_string(files.last().unwrap()).unwrap();
    for text in [
        "Made valley",
        "Mill, upper",
        "1234",
        "50000.0 m³",
        "2 min 30 s after the failure",
        "Maximum concentration of spill",
    ] {
        assert!(page.contains(text), "the page lacks {text}");
    }
    let outside =
        page.split("href=\"").skip(1).filter(|rest| !rest.starts_with('#') && !rest.starts_with("data:")).count();
    assert_eq!(outside, 0, "the page refers to other files");
}

#[test]
fn where_the_dam_breaks_later_times_count_from_the_start_of_the_run() {
    let folder = tempfile::tempdir().unwrap();
    run_folder(folder.path());
    let summary = r#"{"status": "done", "volume_m3": {"initial": 50000.0, "in": 0.0},
        "breach": {"began_s": 60.0, "crest_m": 112.5, "invert_m": 98.0, "bottom_width_m": 40.0, "side_slope": 1.0, "duration_s": 2100.0},
        "warnings": [{"code": "narrow-breach", "key": "breach.shape", "message": "the opening is <5 cells wide", "at": [1055.0, 2125.0]}],
        "above_banks": [{"channel": "upper", "height_m": 0.4, "distance_m": 120.0, "time_s": 90.0}]}"#;
    std::fs::write(folder.path().join("run.json"), summary).unwrap();
    let boundaries = "name,in_m3,out_m3,asked_m3,error_relative\nboundaries[0].line,725400.0,0,725400.0,1e-15\n";
    std::fs::write(folder.path().join("tables/boundaries.csv"), boundaries).unwrap();
    let Report { files, .. } = report(folder.path()).unwrap();
    let page = std::fs::read_to_string(files.last().unwrap()).unwrap();
    assert!(page.contains("2 min 30 s after the start of the run") && !page.contains("the failure"));
    assert!(page.contains("boundaries[0].line") && page.contains("725400.0"));
    let reported =
        ["112.50 m", "40.00 m", "1.00 to 1", "35.0 min", "the opening is &lt;5 cells wide (at 1055.0, 2125.0)"];
    for text in reported.into_iter().chain(["channel upper", "0.40 m above the last row"]) {
        assert!(page.contains(text), "the page lacks {text}");
    }
}

#[test]
fn after_a_hot_start_times_count_from_the_start_of_the_run() {
    let folder = tempfile::tempdir().unwrap();
    run_folder(folder.path());
    let earlier = r#"{"path": "first/fields.nc", "time_s": null}"#;
    let summary =
        format!(r#"{{"status": "done", "hot_start": {earlier}, "volume_m3": {{"initial": 5e4, "in": 0.0}}}}"#);
    std::fs::write(folder.path().join("run.json"), summary).unwrap();
    let Report { files, .. } = report(folder.path()).unwrap();
    let page = std::fs::read_to_string(files.last().unwrap()).unwrap();
    assert!(page.contains("2 min 30 s after the start of the run") && !page.contains("the failure"));
}

#[test]
fn what_a_run_left_out_is_named_with_its_key() {
    let folder = tempfile::tempdir().unwrap();
    run_folder(folder.path());
    let summary = |parts: &str| format!(r#"{{"status": "done", "exit_code": 0, "not_written": [{parts}]}}"#);
    std::fs::write(folder.path().join("run.json"), summary(r#""fields", "tables""#)).unwrap();
    for part in ["fields.nc", "tables/gauges.csv", "tables/gauge_series.csv"] {
        std::fs::remove_file(folder.path().join(part)).unwrap();
    }
    let Report { files, doubt } = report(folder.path()).unwrap();
    assert_eq!(doubt, None);
    let page = std::fs::read_to_string(files.last().unwrap()).unwrap();
    assert!(page.contains("fields, tables, left out of `outputs.write`"));
    std::fs::write(folder.path().join("run.json"), summary(r#""maps""#)).unwrap();
    std::fs::remove_file(folder.path().join("maps.nc")).unwrap();
    let error = report(folder.path()).unwrap_err().to_string();
    assert!(error.contains("[not-written]") && error.contains("add `maps` to `outputs.write`"), "{error}");
}

#[test]
fn a_folder_without_a_run_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let error = report(folder.path()).unwrap_err();
    assert_eq!(error.exit_code(), crate::error::ExitCode::Input);
    assert!(error.to_string().starts_with("error[not-a-run]") && error.to_string().contains("maps.nc"), "{error}");
    assert!(!folder.path().join("report").exists());
}

#[test]
fn a_run_that_is_under_way_is_refused_and_one_that_ended_early_is_marked() {
    let folder = tempfile::tempdir().unwrap();
    run_folder(folder.path());
    let summary = |status: &str, code: u8| {
        let text = format!(r#"{{"status": "{status}", "exit_code": {code}, "simulated_s": 90.0}}"#);
        std::fs::write(folder.path().join("run.json"), text).unwrap();
    };
    summary("running", 0);
    let error = report(folder.path()).unwrap_err();
    assert!(error.to_string().contains("error[unfinished-run]") && error.to_string().contains("remedy"), "{error}");
    assert!(!folder.path().join("report").exists());
    for (status, code, expected) in
        [("failed", 6, "broke down at 90 s"), ("stopped", 143, "stopped at 90 s"), ("done", 7, "quality gate")]
    {
        summary(status, code);
        let written = report(folder.path()).unwrap();
        assert!(written.doubt.unwrap().contains(expected));
        for file in [&written.files[0], written.files.last().unwrap()] {
            assert!(std::fs::read_to_string(file).unwrap().contains(expected), "{} does not tell", file.display());
        }
    }
}
