//! What bad data and bad output folders get: exit code, a located message with a remedy, and no result left looking whole.
//!
//! Every test goes through the real program, `check` and `run` alike, on a basin in a plateau: see [`Scene`].

mod output_folder;
mod water;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use gdal::DriverManager;
use gdal::raster::Buffer;
use gdal::spatial_ref::SpatialRef;
use tempfile::TempDir;

use crate::{Answer, changed, floodsim};

/// Columns and rows of the terrain, its cell (m) and its south-western corner.
const COLUMNS: usize = 40;
const ROWS: usize = 30;
const CELL: f64 = 5.0;
const WEST: f64 = 1000.0;
const SOUTH: f64 = 2000.0;
/// Upper left corner and cell as GDAL has them.
const GEO_TRANSFORM: [f64; 6] = [WEST, CELL, 0.0, SOUTH + ROWS as f64 * CELL, 0.0, -CELL];

/// The lines of this scenario are counted on by the tests.
const SCENARIO: &str = "\
floodsim: 1
title: A basin in a plateau
crs: local
terrain: {layers: [{raster: dem.asc}]}
roughness: {manning: 0.03}
initial:
  - {reservoir: reservoir.geojson, level: 5 m}
resolution: 5 m
time: {end: 4 s}
outputs: {every: 2 s, gauges: gauges.csv}
";

/// Corners of the reservoir, on the plateau around the basin.
const RESERVOIR: &str = "[[[1045,2045],[1105,2045],[1105,2105],[1045,2105],[1045,2045]]]";

/// A plateau at 20 m with a basin of 50 m by 50 m, floor at 0 m; column and row from the upper left.
fn elevation(column: usize, row: usize) -> f64 {
    if (10..20).contains(&column) && (10..20).contains(&row) { 0.0 } else { 20.0 }
}

/// A folder with a scenario without fault and its data.
struct Scene {
    folder: TempDir,
}

impl Scene {
    fn sound() -> Scene {
        let scene = Scene { folder: TempDir::new().unwrap() };
        scene.write("s.yaml", SCENARIO);
        scene.terrain(|column, row| elevation(column, row).to_string());
        scene.polygon(RESERVOIR, "{}");
        scene.write("gauges.csv", "id,x,y\nA,1075,2075\n");
        scene
    }

    /// The scenario with one text replaced by another.
    fn with(from: &str, to: &str) -> Scene {
        let scene = Scene::sound();
        scene.write("s.yaml", &changed(SCENARIO, &[(from, to)]));
        scene
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: &str) {
        std::fs::write(self.path(name), content).unwrap();
    }

    /// Writes `dem.asc` from the text of each value.
    fn terrain(&self, value: impl Fn(usize, usize) -> String) {
        let row = |row: usize| (0..COLUMNS).map(|column| value(column, row)).collect::<Vec<_>>().join(" ");
        let rows: Vec<String> = (0..ROWS).map(row).collect();
        let header = format!(
            "ncols {COLUMNS}\nnrows {ROWS}\nxllcorner {WEST}\nyllcorner {SOUTH}\ncellsize {CELL}\nNODATA_value -9999\n"
        );
        self.write("dem.asc", &(header + &rows.join("\n") + "\n"));
    }

    /// Writes `reservoir.geojson` from the coordinates and properties of one polygon.
    fn polygon(&self, coordinates: &str, properties: &str) {
        let geometry = format!(r#"{{"type":"Polygon","coordinates":{coordinates}}}"#);
        let feature = format!(r#"{{"type":"Feature","properties":{properties},"geometry":{geometry}}}"#);
        self.write("reservoir.geojson", &format!(r#"{{"type":"FeatureCollection","features":[{feature}]}}"#));
    }

    /// Writes the terrain as a GeoTIFF.
    fn geotiff(&self, name: &str, geo_transform: [f64; 6], crs: Option<&str>) {
        let driver = DriverManager::get_driver_by_name("GTiff").unwrap();
        let mut dataset = driver.create_with_band_type::<f64, _>(self.path(name), COLUMNS, ROWS, 1).unwrap();
        dataset.set_geo_transform(&geo_transform).unwrap();
        if let Some(crs) = crs {
            dataset.set_spatial_ref(&SpatialRef::from_definition(crs).unwrap()).unwrap();
        }
        let values = (0..COLUMNS * ROWS).map(|index| elevation(index % COLUMNS, index / COLUMNS)).collect();
        let mut band = dataset.rasterband(1).unwrap();
        band.write((0, 0), (COLUMNS, ROWS), &mut Buffer::new((COLUMNS, ROWS), values)).unwrap();
        dataset.close().unwrap();
    }

    /// Asserts that `check` and `run` refuse the scene with this exit code, and say all these texts.
    #[track_caller]
    fn assert_refused(&self, code: i32, expected: &[&str]) {
        let before = everything_below(self.folder.path());
        let check = floodsim(self.folder.path(), &["check", "s.yaml"]);
        assert_eq!((check.code, check.stderr.as_str()), (code, ""), "{}", check.stdout);
        let run = floodsim(self.folder.path(), &["s.yaml", "--out", "out"]);
        assert_refusal(&run, code, expected);
        for text in expected {
            assert!(check.stdout.contains(text), "check does not say `{text}`, but\n{}", check.stdout);
        }
        assert!(everything_below(self.folder.path()) == before, "a refused run or check changed the folder");
    }

    /// Asserts that `run` with this output folder is refused with exit code 8 and these texts, and changes nothing.
    #[track_caller]
    fn assert_output_refused(&self, out: &str, expected: &[&str]) {
        let before = everything_below(self.folder.path());
        assert_refusal(&floodsim(self.folder.path(), &["s.yaml", "--out", out]), 8, expected);
        assert!(everything_below(self.folder.path()) == before, "a refused run changed the folder");
    }
}

/// Asserts how a refused run answers: its code, nothing on stdout, every text, and a cause or remedy for every error.
#[track_caller]
fn assert_refusal(run: &Answer, code: i32, expected: &[&str]) {
    assert_eq!((run.code, run.stdout.as_str()), (code, ""), "{}", run.stderr);
    for text in expected {
        assert!(run.stderr.contains(text), "run does not say `{text}`, but\n{}", run.stderr);
    }
    for problem in run.stderr.split("error[").skip(1) {
        assert!(
            problem.contains("\n  cause   ") || problem.contains("\n  remedy  "),
            "neither cause nor remedy: {problem}"
        );
    }
    assert!(!run.stderr.contains("panicked"), "{}", run.stderr);
}

/// Every file below a folder with its bytes, and every folder, in the order of their names.
fn everything_below(folder: &Path) -> Vec<(PathBuf, Option<Vec<u8>>)> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(everything_below(&path));
            found.push((path, None));
        } else {
            let bytes = std::fs::read(&path).unwrap();
            found.push((path, Some(bytes)));
        }
    }
    found.sort();
    found
}

#[test]
fn the_sound_scene_runs() {
    let scene = Scene::sound();
    let check = floodsim(scene.folder.path(), &["check", "s.yaml"]);
    assert_eq!((check.code, check.stdout.as_str()), (0, "s.yaml: 0 errors, 0 warnings\n"));
    let run = floodsim(scene.folder.path(), &["s.yaml", "--out", "out"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(scene.path("out/maps.nc").exists());
}

#[test]
fn missing_files_are_all_named_with_their_lines() {
    let scene = Scene::sound();
    for name in ["dem.asc", "reservoir.geojson", "gauges.csv"] {
        std::fs::remove_file(scene.path(name)).unwrap();
    }
    scene.assert_refused(
        4,
        &[
            "error[missing-file] terrain.layers[0].raster (s.yaml:4:29)\n  the file `dem.asc` does not exist",
            "error[missing-file] initial[0].reservoir (s.yaml:7:17)",
            "error[missing-file] outputs.gauges (s.yaml:10:31)",
            "remedy",
        ],
    );
}

#[test]
fn a_file_that_is_no_raster_is_refused_in_the_words_of_gdal() {
    let scene = Scene::sound();
    scene.write("dem.asc", "This is a letter to the surveyor.\n");
    scene.assert_refused(
        4,
        &["error[not-a-raster] terrain.layers[0].raster (s.yaml:4:29)", "is not a raster that GDAL can read", "cause"],
    );
    let truncated = std::fs::read(Scene::sound().path("dem.asc")).unwrap();
    std::fs::write(scene.path("dem.asc"), &truncated[..truncated.len() / 2]).unwrap();
    scene.assert_refused(4, &["error[unreadable-raster] terrain.layers[0].raster (s.yaml:4:29)"]);
}

#[test]
fn an_empty_raster_file_is_refused() {
    let scene = Scene::sound();
    scene.write("dem.asc", "");
    scene.assert_refused(4, &["error[empty-file] terrain.layers[0].raster (s.yaml:4:29)", "dem.asc"]);
}

#[test]
fn a_raster_without_data_is_refused() {
    let scene = Scene::sound();
    scene.terrain(|_, _| "-9999".to_owned());
    scene.assert_refused(4, &["error[all-nodata] terrain.layers[0].raster (s.yaml:4:29)"]);
}

#[test]
fn terrain_without_a_reference_system_needs_a_word_in_the_scenario() {
    let scene = Scene::with("crs: local\n", "");
    scene.assert_refused(
        4,
        &[
            "error[no-crs] terrain.layers[0].raster (s.yaml:3:29)",
            "add `crs: EPSG:...`",
            "`crs: local` for plain metres",
        ],
    );
}

#[test]
fn two_reference_systems_are_refused() {
    let scene = Scene::with("crs: local\n", "");
    let scenario =
        SCENARIO.replace("crs: local\n", "").replace("{raster: dem.asc}", "{raster: a.tif}, {raster: b.tif}");
    scene.write("s.yaml", &scenario);
    scene.geotiff("a.tif", GEO_TRANSFORM, Some("EPSG:25832"));
    scene.geotiff("b.tif", GEO_TRANSFORM, Some("EPSG:25833"));
    scene.assert_refused(
        4,
        &[
            "error[different-crs] terrain.layers[1].raster (s.yaml:3:46)",
            "EPSG:25833",
            "EPSG:25832",
            "remedy  set `terrain.reproject: true`",
        ],
    );
}

#[test]
fn terrain_in_degrees_is_refused_with_the_system_to_take() {
    let scene = Scene::sound();
    scene.write("s.yaml", &SCENARIO.replace("crs: local\n", "").replace("dem.asc", "dem.tif"));
    scene.geotiff("dem.tif", [9.0, 0.0025, 0.0, 45.15, 0.0, -0.0025], Some("EPSG:4326"));
    scene.assert_refused(
        4,
        &["error[geographic-crs] terrain.layers[0].raster (s.yaml:3:29)", "degrees", "reproject: true", "EPSG:32632"],
    );
}

#[test]
fn a_resolution_of_zero_is_refused() {
    Scene::with("resolution: 5 m", "resolution: 0 m")
        .assert_refused(3, &["error[range] resolution (s.yaml:8:13)", "remedy"]);
}

#[test]
fn a_resolution_wider_than_the_terrain_is_refused() {
    Scene::with("resolution: 5 m", "resolution: 10 km").assert_refused(
        3,
        &["error[resolution-too-coarse] resolution (s.yaml:8:13)", "200 m by 150 m", "remedy  choose at most"],
    );
}

#[test]
fn a_polygon_that_ends_within_its_water_is_told_as_each_formulation_has_it() {
    // 30 m by 40 m of a basin of 50 m by 50 m, at 5 m: 6000 m³ over the polygon, and more in the cells beside it that are filled.
    let narrower = "[[[1055,2055],[1085,2055],[1085,2095],[1055,2095],[1055,2055]]]";
    for (methods, expected, is_held) in [
        ("motion: lagrangian", "off the integral of level minus terrain; the level of 5 m is held", true),
        (
            "formulation: variational",
            "the level of 5 m is not held: the particles get the 6.00000e3 m³ of the integral of level minus terrain",
            false,
        ),
    ] {
        let scene = Scene::with("time: {end: 4 s}", &format!("numerics: {{{methods}}}\ntime: {{end: 1 s}}"));
        scene.polygon(narrower, "{}");
        let run = floodsim(scene.folder.path(), &["s.yaml", "--out", "out"]);
        assert_eq!(run.code, 0, "{}", run.stderr);
        let cause = "the polygon ends within the water: 18 cells beside it";
        assert!(run.stderr.contains(expected) && run.stderr.contains(cause), "{methods}: {}", run.stderr);
        let gauges = std::fs::read_to_string(scene.path("out/tables/gauge_series.csv")).unwrap();
        let level: f64 = gauges.lines().nth(1).unwrap().split(',').nth(3).unwrap().parse().unwrap();
        assert!(level <= 5.0 && (level > 4.999) == is_held && (level < 4.5) != is_held, "{methods}: {gauges}");
    }
}

#[test]
fn too_fine_a_resolution_is_refused_before_anything_is_allocated() {
    let start = Instant::now();
    Scene::with("resolution: 5 m", "resolution: 0.01 mm").assert_refused(
        5,
        &[
            "error[memory-limit] resolution (s.yaml:8:13)",
            "cells of 0.00001 m need about",
            "GB of memory; the limit is",
            "remedy  take a resolution of",
        ],
    );
    Scene::with("resolution: 5 m", "limits: {particles: 1000}\nresolution: 5 m").assert_refused(
        5,
        &["error[particle-limit] resolution (s.yaml:9:13)", "1200 riverbed", "exceed the limit of 1000", "remedy"],
    );
    // Cells for the first of these would take years to be filled.
    assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
}

#[test]
fn whole_numbers_of_a_grid_of_text_are_read_as_they_stand() {
    let scene = Scene::sound();
    // As a 32-bit integer it would be 64771072.
    let value = |column, row| {
        if (column, row) == (3, 4) { "-30000000000".to_owned() } else { format!("{:.0}", elevation(column, row)) }
    };
    scene.terrain(value);
    scene.assert_refused(4, &["error[undeclared-nodata] terrain.layers[0].raster", "have the value -3e10"]);
}

#[test]
fn a_raster_larger_than_the_memory_is_refused_before_it_is_read() {
    // Rain falls on all of it.
    let scene = Scene::with("raster: dem.asc}]}", "raster: dem.vrt}]}\nrain: {rate: 10 mm/h}");
    let geo_transform = "<GeoTransform>1000, 5, 0, 2150, 0, -5</GeoTransform>";
    scene.write(
        "dem.vrt",
        &format!(
            r#"<VRTDataset rasterXSize="1000000" rasterYSize="1000000">{geo_transform}<VRTRasterBand dataType="Float32" band="1"/></VRTDataset>"#
        ),
    );
    let start = Instant::now();
    scene.assert_refused(5, &["error[memory-limit] terrain.layers[0].raster (s.yaml:4:29)", "remedy"]);
    assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
}

#[test]
fn values_that_are_no_numbers_in_the_raster_are_refused_with_the_first_place() {
    let scene = Scene::sound();
    scene.terrain(|column, row| match (column, row) {
        (3, 2) => "nan".to_owned(),
        (7, 9) => "inf".to_owned(),
        (8, 9) => "n/a".to_owned(),
        _ => elevation(column, row).to_string(),
    });
    scene.assert_refused(
        4,
        &[
            "error[not-a-number] terrain.layers[0].raster (s.yaml:4:29)",
            "3 values",
            "column 4, row 3 from the upper left",
            "at      1017.5, 2137.5",
            "remedy",
        ],
    );
}

#[test]
fn gauges_that_all_lie_outside_the_terrain_are_refused_and_a_single_one_is_warned_of() {
    let scene = Scene::sound();
    scene.write("gauges.csv", "id,x,y\nA,2075,1075\nB,2080,1075\n");
    scene.assert_refused(
        4,
        &["error[gauges-outside-terrain] outputs.gauges (s.yaml:10:31)", "at      2075.0, 1075.0", "remedy"],
    );
    scene.write("gauges.csv", "id,x,y\nA,1075,2075\nB,2080,1075\n");
    let check = floodsim(scene.folder.path(), &["check", "s.yaml"]);
    assert_eq!(check.code, 0, "{}", check.stdout);
    assert!(check.stdout.contains("warning[gauge-outside-terrain] outputs.gauges (s.yaml:10:31)"), "{}", check.stdout);
    assert!(check.stdout.contains("gauge `B`") && !check.stdout.contains("gauge `A`"), "{}", check.stdout);
    assert!(check.stdout.contains("remedy  correct its coordinates, take it out, or"), "{}", check.stdout);
}

#[test]
fn a_bad_line_in_the_gauges_is_refused_with_its_number() {
    let scene = Scene::sound();
    scene.write("gauges.csv", "id,x,y\nA,1075,2075\nB,1075,north\n");
    scene.assert_refused(
        4,
        &["error[bad-gauge-line] outputs.gauges (s.yaml:10:31)", "line 3 of gauges.csv", "it reads `B,1075,north`"],
    );
}
