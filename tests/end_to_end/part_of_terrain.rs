//! Terrain much larger than the flood: the run prepares the part that the water comes to.

use std::path::Path;

use gdal::DriverManager;
use gdal::raster::Buffer;
use serde_json::Value;
use tempfile::TempDir;

use crate::{Netcdf, floodsim, run_scene};

/// Pixels of 2 m, so many that the terrain is not prepared whole.
const COLUMNS: usize = 2400;
const ROWS: usize = 2000;
const PIXEL: f64 = 2.0;

const SCENARIO: &str = "\
floodsim: 1
crs: local
terrain: {layers: [{raster: dem.tif}]}
structures: {walls: [{lines: far.geojson}]}
roughness: {manning: 0.03}
initial: [{reservoir: lake.geojson, level: 26 m}]
resolution: 2 m
time: {end: 100 s}
outputs: {every: 50 s, gauges: gauges.csv, write: [maps, tables]}
";

/// Elevation (m) of a place: a valley 24 m wide that falls to the east, and across it a ridge with a slot of one pixel, which coarse cells
/// do not see.
fn elevation(x: f64, y: f64) -> f64 {
    let flank = ((y - 2001.0).abs() - 12.0).max(0.0);
    let ridge = if (1000.0..1020.0).contains(&x) && (y - 2001.0).abs() > 1.0 { 12.0 } else { 0.0 };
    20.0 - 0.005 * (x - 1000.0) + flank.min(40.0) + ridge
}

fn write_raster(path: &Path, (west, north): (f64, f64), (columns, rows): (usize, usize)) {
    let place = |cell: usize| {
        let (column, row) = (cell % columns, cell / columns);
        (west + (column as f64 + 0.5) * PIXEL, north - (row as f64 + 0.5) * PIXEL)
    };
    let values = (0..columns * rows).map(place).map(|(x, y)| elevation(x, y) as f32).collect();
    let driver = DriverManager::get_driver_by_name("GTiff").unwrap();
    let mut file = driver.create_with_band_type::<f32, _>(path, columns, rows, 1).unwrap();
    file.set_geo_transform(&[west, PIXEL, 0.0, north, 0.0, -PIXEL]).unwrap();
    let mut band = file.rasterband(1).unwrap();
    band.write((0, 0), (columns, rows), &mut Buffer::new((columns, rows), values)).unwrap();
}

fn scene() -> TempDir {
    let folder = TempDir::new().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write_raster(&folder.path().join("dem.tif"), (0.0, ROWS as f64 * PIXEL), (COLUMNS, ROWS));
    let feature = |kind: &str, coordinates: &str| {
        let geometry = format!(r#"{{"type":"{kind}","coordinates":{coordinates}}}"#);
        format!(r#"{{"type":"Feature","properties":{{}},"geometry":{geometry}}}"#)
    };
    write("lake.geojson", &feature("Polygon", "[[[900,1989],[1000,1989],[1000,2013],[900,2013],[900,1989]]]"));
    // A wall that no water comes to, kilometres away.
    write("far.geojson", &feature("LineString", "[[4000,3500],[4500,3600]]"));
    write("gauges.csv", "id,x,y\nlake,950,2001\n");
    write("s.yaml", SCENARIO);
    folder
}

/// A side of the part of a run (m).
fn side(record: &Value, name: &str) -> f64 {
    record["terrain_part"][name].as_f64().unwrap()
}

#[test]
fn a_run_on_a_part_grows_with_its_water_and_is_that_on_the_same_part_of_the_raster() {
    let folder = scene();
    let (record, answer) = run_scene(folder.path(), "part", &[]);
    // The slot lets water through that the coarse cells held back.
    assert!(answer.stderr.contains("larger-part"), "{}", answer.stderr);
    let [west, south, east, north] = ["west", "south", "east", "north"].map(|name| side(&record, name));
    println!("part {west} {south} {east} {north}");
    assert!(west > 300.0 && east < 2000.0 && south > 1500.0 && north < 2500.0, "{}", record["terrain_part"]);
    assert!((record["terrain_part"]["terrain_m"][0].as_f64().unwrap() - 4800.0).abs() < 1e-9);
    assert!(record["volume_m3"]["error_relative"].as_f64().unwrap().abs() < 1e-12);

    // The same part as a raster of its own, which is small enough to be prepared whole.
    let count = |from: f64, to: f64| ((to - from) / PIXEL).round() as usize;
    write_raster(&folder.path().join("dem.tif"), (west, north), (count(west, east), count(south, north)));
    std::fs::write(folder.path().join("s.yaml"), SCENARIO.replace("structures: {walls: [{lines: far.geojson}]}\n", ""))
        .unwrap();
    let (whole, answer) = run_scene(folder.path(), "whole", &[]);
    assert!(whole.get("terrain_part").is_none() && !answer.stderr.contains("larger-part"), "{}", answer.stderr);
    let [part, whole] = ["part", "whole"].map(|out| Netcdf::read(&folder.path().join(out).join("maps.nc")));
    for name in ["x", "y", "max_depth", "max_speed", "arrival_time"] {
        let [part, whole] = [&part, &whole].map(|maps| maps.values(name));
        assert!(part.len() == whole.len() && part.iter().zip(whole).all(|(a, b)| a.to_bits() == b.to_bits()), "{name}");
    }
    let reached = part.values("max_depth").iter().filter(|depth| **depth > 0.1).count();
    assert!(reached > 1000, "{reached}");
}

#[test]
fn faults_of_a_large_terrain_are_told_of_the_whole_of_it() {
    let folder = scene();
    let text = SCENARIO.replace("lake.geojson", "nowhere.geojson");
    std::fs::write(folder.path().join("s.yaml"), text).unwrap();
    let answer = floodsim(folder.path(), &["check", "s.yaml"]);
    assert_eq!(answer.code, 4, "{}", answer.stderr);
    assert!(answer.stdout.contains("missing-file"), "{}", answer.stdout);
    // A gauge beside all of the terrain, and one on the terrain far from the part.
    std::fs::write(folder.path().join("s.yaml"), SCENARIO).unwrap();
    std::fs::write(folder.path().join("gauges.csv"), "id,x,y\nlake,950,2001\nbeside,950,9000\n").unwrap();
    let answer = floodsim(folder.path(), &["check", "s.yaml"]);
    assert_eq!(answer.code, 0, "{}", answer.stderr);
    assert!(answer.stdout.contains("gauge `beside` lies outside the terrain"), "{}", answer.stdout);
}

#[test]
fn a_run_that_goes_on_has_the_part_of_the_earlier_one_and_what_the_scenario_names_beside_it() {
    let folder = scene();
    let text = SCENARIO.replace(", write: [maps, tables]", "");
    let first = text.replace("end: 100 s", "end: 30 s").replace("every: 50 s", "every: 30 s");
    std::fs::write(folder.path().join("s.yaml"), first).unwrap();
    let (before, _) = run_scene(folder.path(), "before", &[]);
    let on = |end: &str| {
        let start = "{fields: before/fields.nc}";
        text.replace("{reservoir: lake.geojson, level: 26 m}", start).replace("end: 100 s", &format!("end: {end}"))
    };
    std::fs::write(folder.path().join("s.yaml"), on("5 s")).unwrap();
    // An inflow at the edge of the terrain, far from the earlier part, is part of the scene.
    let line = r#"{"type":"LineString","coordinates":[[0,1992],[0,2010]]}"#;
    let feature = format!(r#"{{"type":"Feature","properties":{{}},"geometry":{line}}}"#);
    std::fs::write(folder.path().join("inflow.geojson"), feature).unwrap();
    let inflow = "boundaries: [{line: inflow.geojson, discharge: 20 m3/s}]\n";
    std::fs::write(folder.path().join("s.yaml"), on("5 s") + inflow).unwrap();
    let (with_inflow, _) = run_scene(folder.path(), "inflow", &[]);
    let entered = with_inflow["volume_m3"]["in"].as_f64().unwrap();
    assert!((entered - 100.0).abs() < 1.0 && side(&with_inflow, "west") < 1.0, "{entered} m3");
    std::fs::write(folder.path().join("s.yaml"), on("60 s")).unwrap();
    let (larger, _) = run_scene(folder.path(), "larger", &[]);
    for (name, sign) in [("west", -1.0), ("south", -1.0), ("east", 1.0), ("north", 1.0)] {
        let grown = sign * (side(&larger, name) - side(&before, name));
        assert!(grown >= 0.0 && (grown / PIXEL).fract().abs() < 1e-9, "{name}: {grown}");
    }
    let volume = |record: &Value, key: &str| record["volume_m3"][key].as_f64().unwrap();
    let share = volume(&larger, "final") / volume(&before, "final") - 1.0;
    assert!(share.abs() < 1e-6, "{share}");
}
