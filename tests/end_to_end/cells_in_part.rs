//! Terrain that ends inside of cells, through the whole program: a resolution that does not divide the raster, rasters of unlike origin.

use std::fmt::Write;
use std::path::PathBuf;

use serde_json::Value;
use tempfile::TempDir;

use crate::{Netcdf, floodsim};

struct Scene(TempDir);

impl Scene {
    fn new(scenario: &str) -> Scene {
        let scene = Scene(TempDir::new().unwrap());
        std::fs::write(scene.path("s.yaml"), scenario).unwrap();
        scene
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Level ground at 0 m in cells of half a metre, from a south-western corner on, so many metres wide and high.
    fn raster(&self, name: &str, (west, south): (f64, f64), (width, height): (f64, f64)) {
        let (columns, rows) = ((2.0 * width) as usize, (2.0 * height) as usize);
        let mut text = format!("ncols {columns}\nnrows {rows}\nxllcorner {west}\nyllcorner {south}\ncellsize 0.5\n");
        let row = vec!["0"; columns].join(" ");
        (0..rows).for_each(|_| writeln!(text, "{row}").unwrap());
        std::fs::write(self.path(name), text).unwrap();
    }

    /// Rectangles of water, from a south-western to a north-eastern corner, with one level.
    fn water(&self, name: &str, rectangles: &[[f64; 4]], level: f64) {
        let feature = |&[west, south, east, north]: &[f64; 4]| {
            let ring =
                format!("[[{west},{south}],[{east},{south}],[{east},{north}],[{west},{north}],[{west},{south}]]");
            let geometry = format!(r#"{{"type":"Polygon","coordinates":[{ring}]}}"#);
            format!(r#"{{"type":"Feature","properties":{{"level_m":{level}}},"geometry":{geometry}}}"#)
        };
        let features: Vec<String> = rectangles.iter().map(feature).collect();
        let text = format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, features.join(","));
        std::fs::write(self.path(name), text).unwrap();
    }

    #[track_caller]
    fn run(&self) -> (Netcdf, Value) {
        let answer = floodsim(self.0.path(), &["run", "s.yaml", "--out", "out", "--quiet", "--overwrite"]);
        assert_eq!(answer.code, 0, "{}", answer.stderr);
        let text = std::fs::read_to_string(self.path("out/run.json")).unwrap();
        (Netcdf::read(&self.path("out/fields.nc")), serde_json::from_str(&text).unwrap())
    }
}

const SCENARIO: &str = "\
floodsim: 1
crs: local
terrain: {layers: [{raster: dem.asc}]}
roughness: {manning: 0.02}
initial: [{reservoir: water.geojson}]
resolution: 1 m
time: {end: 6 s}
outputs: {every: 2 s}
";

#[test]
fn a_row_that_is_half_covered_flows_as_the_others() {
    let scene = Scene::new(SCENARIO);
    scene.raster("dem.asc", (0.0, 0.0), (60.0, 17.5));
    scene.water("water.geojson", &[[0.0, 0.0, 20.0, 17.5]], 2.0);
    let (fields, run) = scene.run();
    let (columns, rows) = (60, 18);
    for (time, depths) in fields.values("depth").chunks(columns * rows).enumerate() {
        for column in 0..columns {
            let spread =
                (0..rows).map(|row| (depths[row * columns + column] - depths[column]).abs()).fold(0.0, f64::max);
            assert!(spread < 1e-6, "frame {time}, column {column}: {spread} m, single precision");
        }
    }
    let volume = &run["volume_m3"];
    let expected = 20.0 * 17.5 * 2.0;
    assert!((volume["initial"].as_f64().unwrap() / expected - 1.0).abs() < 1e-12, "{volume}");
    assert!(volume["grid_error_relative"].as_f64().unwrap() < 1e-6, "{volume}");
    assert_eq!(run["cells_in_part"], serde_json::json!({"cells": 60, "least": 0.5, "greatest": 0.5}));
    assert!(run["still_water"][0]["at_edge_m3"].as_f64().unwrap().abs() < 1e-9, "{}", run["still_water"]);
}

#[test]
fn a_lake_on_rasters_of_unlike_origin_has_the_area_of_both_and_rests() {
    // Where it may rain no water sleeps.
    let rain = "rain: {rate: 0 mm/h}\n";
    let scene = Scene::new(&(SCENARIO.replace("{raster: dem.asc}", "{raster: dem.asc}, {raster: other.asc}") + rain));
    scene.raster("dem.asc", (0.0, 0.0), (40.0, 17.5));
    scene.raster("other.asc", (35.7, 4.3), (20.0, 20.5));
    scene.water("water.geojson", &[[0.0, 0.0, 40.0, 17.5], [35.7, 4.3, 55.7, 24.8]], 2.0);
    let (_, run) = scene.run();
    let area = 40.0 * 17.5 + 20.0 * 20.5 - 4.3 * 13.2;
    let volume = &run["volume_m3"];
    assert!((volume["initial"].as_f64().unwrap() / (2.0 * area) - 1.0).abs() < 1e-9, "{volume} for {area} m2");
    assert!(run["max_speed_m_s"].as_f64().unwrap() < 1e-12, "{}", run["max_speed_m_s"]);
    let part = &run["cells_in_part"];
    let share = |name: &str| part[name].as_f64().unwrap();
    assert!(share("least") >= 0.25 && share("greatest") <= 2.25 && share("greatest") > 1.0, "{part}");
}

#[test]
fn a_raster_that_the_resolution_divides_has_no_cells_in_part() {
    let scene = Scene::new(&SCENARIO.replace("1 m", "2.5 m"));
    scene.raster("dem.asc", (0.0, 0.0), (60.0, 17.5));
    scene.water("water.geojson", &[[0.0, 0.0, 20.0, 17.5]], 2.0);
    assert_eq!(scene.run().1.get("cells_in_part"), None);
}

const STREAM: &str = "\
floodsim: 1
crs: local
terrain: {layers: [{raster: dem.asc}]}
roughness: {manning: 0.03}
sources: [{line: in.geojson, discharge: 8 m3/s}]
resolution: 1 m
time: {end: 150 s}
outputs: {every: 150 s}
boundaries:
";

/// A slope of one in a hundred, 16 m wide, in pixels (m); 0.5 m²/s come in above and leave by its eastern end, by a type of boundary. Depths (m)
/// along its middle in the last frame, as far as there is water.
fn stream(columns: usize, pixel: f64, boundary: &str, resolution: &str) -> Vec<f64> {
    let scene = Scene::new(&format!("{STREAM}  - {{side: east, type: {boundary}}}\n"));
    let heights: Vec<String> = (0..columns).map(|k| format!("{:.5}", 10.0 - 0.01 * (k as f64 + 0.5) * pixel)).collect();
    let row = heights.join(" ");
    let text = format!("ncols {columns}\nnrows 16\nxllcorner 0\nyllcorner 0\ncellsize {pixel}\n");
    std::fs::write(scene.path("dem.asc"), text + &vec![row; 16].join("\n") + "\n").unwrap();
    let line = r#"{"type":"LineString","coordinates":[[3,0.5],[3,15.5]]}"#;
    let ring = "[[[40,0.5],[62.5,0.5],[62.5,15],[40,15],[40,0.5]]]";
    let polygon = format!(r#"{{"type":"Polygon","coordinates":{ring}}}"#);
    for (name, geometry) in [("in.geojson", line), ("fine.geojson", &polygon)] {
        let feature = format!(r#"{{"type":"Feature","properties":{{}},"geometry":{geometry}}}"#);
        std::fs::write(scene.path(name), feature).unwrap();
    }
    let set = format!("resolution={resolution}");
    let answer = floodsim(scene.0.path(), &["run", "s.yaml", "--out", "out", "--quiet", "--set", &set]);
    assert_eq!(answer.code, 0, "{}", answer.stderr);
    let fields = Netcdf::read(&scene.path("out/fields.nc"));
    let (depth, width, height) = (fields.values("depth"), fields.values("x").len(), fields.values("y").len());
    let last = &depth[depth.len() - width * height..];
    (0..width).map(|column| last[height / 2 * width + column]).filter(|depth| *depth > 0.0).collect()
}

#[test]
fn a_stream_leaves_by_cells_in_part_as_it_runs_before_them() {
    // Uniform flow: 0.5 m²/s, n = 0.03, 1 : 100.
    let normal = (0.5_f64 * 0.03 / 0.1).powf(0.6);
    let levels = "{finest: 1 m, coarsest: 2 m, refine: [{polygons: fine.geojson, to: 1 m}]}";
    for (boundary, terrains) in [("free", &[(64, 1.0), (65, 1.0), (65, 0.9997)][..]), ("open", &[(65, 0.9997)])] {
        for &(columns, pixel) in terrains {
            for resolution in ["1.5 m", "1.8 m", "2 m", levels] {
                let depths = stream(columns, pixel, boundary, resolution);
                let last = &depths[depths.len() - 8..];
                let off = last.iter().map(|depth| (depth / normal - 1.0).abs()).fold(0.0, f64::max);
                assert!(off < 0.01, "{columns} columns of {pixel} m, {boundary}, {resolution}: {last:?}, {normal} m");
            }
        }
    }
}
