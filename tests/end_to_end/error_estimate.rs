//! `outputs.error_estimate`: what a second run on wider cells says of the error, beside a dam break whose solution is known.

use serde_json::Value;
use tempfile::TempDir;

use crate::{Netcdf, floodsim};

/// Cells of 10 m along and across the channel.
const COLUMNS: usize = 200;
const ROWS: usize = 16;
/// Depth behind the dam (m).
const DEPTH: f64 = 10.0;
/// Gravity (m/s²).
const GRAVITY: f64 = 9.81;
/// End of the run (s).
const END: f64 = 50.0;
/// Place of the dam (m).
const DAM: f64 = 1000.0;

const SCENARIO: &str = "\
floodsim: 1
crs: local
terrain: dem.asc
roughness: {manning: 0}
initial: [{reservoir: lake.geojson, level: 10 m}]
resolution: 10 m
time: {end: 50 s}
outputs: {error_estimate: true, every: 50 s}
";

fn scene() -> TempDir {
    let folder = TempDir::new().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let row = vec!["0"; COLUMNS].join(" ");
    let header = format!("ncols {COLUMNS}\nnrows {ROWS}\nxllcorner 0\nyllcorner 0\ncellsize 10\n");
    write("dem.asc", &(header + &vec![row; ROWS].join("\n") + "\n"));
    let lake = "[[[0,0],[1000,0],[1000,160],[0,160],[0,0]]]";
    let geometry = format!(r#"{{"type":"Polygon","coordinates":{lake}}}"#);
    write("lake.geojson", &format!(r#"{{"type":"Feature","properties":{{}},"geometry":{geometry}}}"#));
    write("s.yaml", SCENARIO);
    folder
}

/// The maximum depth (m) up to the end of the run at a distance (m): `Ritter1892`, whose depth below the dam rises in time.
fn exact(x: f64) -> f64 {
    let celerity = (GRAVITY * DEPTH).sqrt();
    let speed = (x - DAM) / END;
    if speed <= 0.0 { DEPTH } else { (2.0 * celerity - speed).max(0.0).powi(2) / (9.0 * GRAVITY) }
}

#[test]
fn the_estimate_covers_the_true_error_in_most_wet_cells() {
    let scene = scene();
    let answer = floodsim(scene.path(), &["run", "s.yaml", "--out", "run", "--quiet"]);
    assert_eq!(answer.code, 0, "{}", answer.stderr);
    assert!(answer.stdout.contains("estimated error, by a run on cells of 20 m"), "{}", answer.stdout);
    let run = scene.path().join("run");
    let record: Value = serde_json::from_str(&std::fs::read_to_string(run.join("run.json")).unwrap()).unwrap();
    let told = &record["error_estimate"];
    let evaluations = |record: &Value| record["particle_evaluations"].as_f64().unwrap();
    assert!(evaluations(told) < 0.3 * evaluations(&record), "{told}");
    let maps = Netcdf::read(&run.join("maps.nc"));
    let (depth, error) = (maps.values("max_depth"), maps.values("max_depth_error"));
    let (mut wet, mut covered, mut true_sum, mut told_sum) = (0.0, 0.0, 0.0, 0.0);
    for (cell, (depth, error)) in depth.iter().zip(error).enumerate() {
        let exact = exact(10.0 * (cell % COLUMNS) as f64 + 5.0);
        if depth.max(exact) >= 0.01 {
            let off = (depth - exact).abs();
            wet += 1.0;
            // Maps are in single precision, and a lake that no wave has reached has its level to a tenth of a millimetre.
            covered += f64::from(u8::from(*error + 1e-4 >= off));
            (true_sum, told_sum) = (true_sum + off, told_sum + error);
        }
    }
    println!(
        "covered {} of {wet} wet cells; mean error {} m, told {} m",
        covered / wet,
        true_sum / wet,
        told_sum / wet
    );
    assert!(covered / wet > 0.9, "{}", covered / wet);
    assert!(told_sum < 8.0 * true_sum, "{told_sum} m of {true_sum} m");
    assert!((told["mean_depth_m"].as_f64().unwrap() - told_sum / wet).abs() < 0.2 * told_sum / wet, "{told}");
    let arrivals = maps.values("arrival_time_error");
    assert!(arrivals.iter().any(|error| (0.0..10.0).contains(error)), "arrivals below the dam");
    let report = floodsim(scene.path(), &["report", "run"]);
    assert!(report.code == 0 && report.stdout.contains("max_depth_error.svg"), "{}{}", report.stdout, report.stderr);
    let resolved = std::fs::read_to_string(run.join("scenario.resolved.yaml")).unwrap();
    assert!(resolved.contains("error_estimate: true"), "{resolved}");
}

#[test]
fn without_a_second_run_there_is_a_warning_and_no_estimate() {
    let scene = scene();
    // Cells of 100 m would leave less than three across the channel.
    let arguments = ["run", "s.yaml", "--out", "run", "--quiet", "--set", "resolution=50 m"];
    let answer = floodsim(scene.path(), &arguments);
    assert_eq!(answer.code, 0, "{}", answer.stderr);
    assert!(answer.stderr.contains("warning[no-error-estimate] outputs.error_estimate"), "{}", answer.stderr);
    let maps = Netcdf::read(&scene.path().join("run/maps.nc"));
    assert!(!maps.variables.contains_key("max_depth_error"));
}
