//! Terrain as planners build it, through the whole program: layers that are cut, holes, levees, walls with a crest, buildings,
//! and what is refused of them.

use std::path::PathBuf;

use gdal::DriverManager;
use gdal::raster::Buffer;
use tempfile::TempDir;

use crate::{Netcdf, changed, floodsim};

/// Columns and rows of the terrain, its cell (m) and its south-western corner.
const COLUMNS: usize = 50;
const ROWS: usize = 30;
const CELL: f64 = 4.0;
const WEST: f64 = 1000.0;
const SOUTH: f64 = 2000.0;
const NO_DATA: f64 = -9999.0;

/// The lines of this scenario are counted on by the tests.
const SCENARIO: &str = "\
floodsim: 1
crs: local
terrain:
  layers:
    - {raster: dem.tif}
    - {raster: fine.tif, clip: clip.geojson, offset: 50 cm}
  gaps: {fill: idw, max_cells: 2}
  breaklines:
    - {lines: levee.geojson, mode: raise, z_field: crest_m}
roughness: {manning: 0.03}
structures: {buildings: {polygons: houses.geojson}}
initial: [{reservoir: reservoir.geojson, level: 3 m}]
boundaries: [{side: all, type: open}]
resolution: 4 m
time: {end: 20 s}
outputs: {every: 5 s}
";

struct Scene {
    folder: TempDir,
}

impl Scene {
    /// A plane at 0 m with a hole of one cell. Water at 3 m fills the corner in the north-west; a levee at 6 m goes from the
    /// southern to the northern edge, diagonally through the corners of cells, and a house stands before it.
    fn sound() -> Scene {
        let scene = Scene { folder: TempDir::new().unwrap() };
        scene.raster("dem.tif", |column, row| if (column, row) == (45, 3) { NO_DATA } else { 0.0 });
        scene.raster("fine.tif", |_, _| 0.25);
        scene.write("s.yaml", SCENARIO);
        scene.lines("levee.geojson", &[(1060.0, 2000.0), (1180.0, 2120.0)], r#"{"crest_m": 6}"#);
        scene.polygon("clip.geojson", &[(1160.0, 2000.0), (1200.0, 2000.0), (1200.0, 2020.0), (1160.0, 2020.0)]);
        scene.polygon("houses.geojson", &[(1064.0, 2072.0), (1080.0, 2072.0), (1080.0, 2084.0), (1064.0, 2084.0)]);
        scene.polygon("reservoir.geojson", &[(1000.0, 2040.0), (1040.0, 2040.0), (1040.0, 2120.0), (1000.0, 2120.0)]);
        scene
    }

    fn with(changes: &[(&str, &str)]) -> Scene {
        let scene = Scene::sound();
        scene.write("s.yaml", &changed(SCENARIO, changes));
        scene
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: &str) {
        std::fs::write(self.path(name), content).unwrap();
    }

    /// Writes a GeoTIFF; column and row count from the upper left.
    fn raster(&self, name: &str, value: impl Fn(usize, usize) -> f64) {
        let driver = DriverManager::get_driver_by_name("GTiff").unwrap();
        let mut dataset = driver.create_with_band_type::<f64, _>(self.path(name), COLUMNS, ROWS, 1).unwrap();
        dataset.set_geo_transform(&[WEST, CELL, 0.0, SOUTH + ROWS as f64 * CELL, 0.0, -CELL]).unwrap();
        let values = (0..COLUMNS * ROWS).map(|index| value(index % COLUMNS, index / COLUMNS)).collect();
        let mut band = dataset.rasterband(1).unwrap();
        band.set_no_data_value(Some(NO_DATA)).unwrap();
        band.write((0, 0), (COLUMNS, ROWS), &mut Buffer::new((COLUMNS, ROWS), values)).unwrap();
        dataset.close().unwrap();
    }

    fn lines(&self, name: &str, places: &[(f64, f64)], properties: &str) {
        self.feature(name, "LineString", &coordinates(places), properties);
    }

    fn polygon(&self, name: &str, corners: &[(f64, f64)]) {
        let ring: Vec<(f64, f64)> = corners.iter().chain(corners.first()).copied().collect();
        self.feature(name, "Polygon", &format!("[{}]", coordinates(&ring)), "{}");
    }

    fn feature(&self, name: &str, kind: &str, coordinates: &str, properties: &str) {
        let geometry = format!(r#"{{"type":"{kind}","coordinates":{coordinates}}}"#);
        let feature = format!(r#"{{"type":"Feature","properties":{properties},"geometry":{geometry}}}"#);
        self.write(name, &format!(r#"{{"type":"FeatureCollection","features":[{feature}]}}"#));
    }

    /// Runs the scene; returns its maps and the relative error of its volumes.
    #[track_caller]
    fn run(&self, more: &[&str]) -> (Netcdf, serde_json::Value) {
        let arguments = [&["run", "s.yaml", "--out", "out", "--quiet", "--overwrite"], more].concat();
        let answer = floodsim(self.folder.path(), &arguments);
        assert_eq!(answer.code, 0, "{}", answer.stderr);
        let text = std::fs::read_to_string(self.path("out/run.json")).unwrap();
        (Netcdf::read(&self.path("out/maps.nc")), serde_json::from_str(&text).unwrap())
    }
}

fn coordinates(places: &[(f64, f64)]) -> String {
    let places: Vec<String> = places.iter().map(|(x, y)| format!("[{x},{y}]")).collect();
    format!("[{}]", places.join(","))
}

/// The value of a map at a place.
fn at(maps: &Netcdf, name: &str, x: f64, y: f64) -> f64 {
    let (column, row) = (((x - WEST) / CELL) as usize, ROWS - 1 - ((y - SOUTH) / CELL) as usize);
    maps.values(name)[row * COLUMNS + column]
}

/// How many cells beyond the diagonal of the levee were ever wet, and the greatest depth there (m).
fn wet_beyond(maps: &Netcdf) -> (usize, f64) {
    let beyond = (0..COLUMNS * ROWS).filter(|index| {
        let (column, from_south) = (index % COLUMNS, ROWS - 1 - index / COLUMNS);
        // One cell behind the strip of the levee.
        column > 15 + from_south + 1
    });
    let depths: Vec<f64> = beyond.map(|index| maps.values("max_depth")[index]).filter(|depth| *depth > 0.0).collect();
    (depths.len(), depths.iter().copied().fold(0.0, f64::max))
}

#[test]
fn a_levee_diagonal_to_the_lattice_holds_the_wave_and_the_maps_show_what_was_built() {
    let scene = Scene::sound();
    let check = floodsim(scene.folder.path(), &["check", "s.yaml"]);
    assert_eq!(check.code, 0, "{}", check.stdout);
    assert!(check.stdout.contains("warning[gaps-filled] terrain.gaps (s.yaml:7:9)"), "{}", check.stdout);
    let (maps, run) = scene.run(&[]);
    assert_eq!(wet_beyond(&maps), (0, 0.0));
    assert!(at(&maps, "max_depth", 1090.0, 2060.0) > 0.3, "the wave reached the levee");
    // The levee along its diagonal, the clipped layer with its offset, the filled hole, the house.
    for step in 0..30 {
        let place = 2.0 + 4.0 * f64::from(step);
        assert!((at(&maps, "bed_elevation", 1060.0 + place, 2000.0 + place) - 6.0).abs() < 1e-6);
    }
    assert!((at(&maps, "bed_elevation", 1170.0, 2010.0) - 0.75).abs() < 1e-6);
    assert!(at(&maps, "bed_elevation", 1170.0, 2030.0).abs() < 1e-6);
    assert!(at(&maps, "bed_elevation", 1182.0, 2106.0).abs() < 1e-6);
    assert!(at(&maps, "bed_elevation", 1070.0, 2080.0) < -9000.0, "no terrain in the house");
    let volume = |key: &str| run["volume_m3"][key].as_f64().unwrap();
    assert!(volume("error_relative").abs() < 1e-12, "{run}");
    assert!(volume("initial") > 9000.0);
    // Without the levee the water is far beyond it.
    let open = Scene::with(&[("  breaklines:\n    - {lines: levee.geojson, mode: raise, z_field: crest_m}\n", "")]);
    assert!(wet_beyond(&open.run(&[]).0).0 > 50);
}

#[test]
fn a_lake_rests_behind_a_levee_and_around_a_house() {
    let scene = Scene::with(&[("boundaries: [{side: all, type: open}]\n", "")]);
    scene.polygon(
        "reservoir.geojson",
        &[(1000.0, 2000.0), (1062.0, 2000.0), (1180.0, 2118.0), (1180.0, 2120.0), (1000.0, 2120.0)],
    );
    // Where it may rain no water sleeps.
    let (maps, run) = scene.run(&["--set", "rain={rate: 0 mm/h}"]);
    assert!((at(&maps, "max_depth", 1090.0, 2060.0) - 3.0).abs() < 1e-6);
    let fastest = maps.values("max_speed").iter().copied().fold(0.0, f64::max);
    assert!(fastest < 1e-12, "{fastest:e} m/s");
    assert_eq!(wet_beyond(&maps), (0, 0.0));
    assert!(run["volume_m3"]["error_relative"].as_f64().unwrap().abs() < 1e-14);
}

#[test]
fn moving_particles_stay_behind_a_wide_levee_and_a_narrow_one_is_refused() {
    let moving = ["--set", "numerics.formulation=variational"];
    let narrow = floodsim(Scene::sound().folder.path(), &[&["check", "s.yaml"][..], &moving].concat());
    assert_eq!(narrow.code, 3, "{}", narrow.stdout);
    for text in ["error[method-combination] terrain.breaklines[0].lines (s.yaml:9:15)", "narrower than 20 m"] {
        assert!(narrow.stdout.contains(text), "{}", narrow.stdout);
    }
    let (maps, run) = Scene::with(&[("z_field: crest_m", "z_field: crest_m, width: 20 m")]).run(&moving);
    // Half of the width, along the diagonal, less what the strip of one cell has.
    let beyond = (0..COLUMNS * ROWS).filter(|index| index % COLUMNS > 15 + (ROWS - 1 - index / COLUMNS) + 4);
    let wet = beyond.filter(|&index| maps.values("max_depth")[index] > 0.0).count();
    assert_eq!(wet, 0);
    assert!(at(&maps, "max_depth", 1080.0, 2060.0) > 0.3, "the wave reached the levee");
    assert!(run["volume_m3"]["error_relative"].as_f64().unwrap().abs() < 1e-9);
}

#[test]
fn a_wall_with_a_crest_is_overtopped_and_one_without_is_not() {
    let levee = "  breaklines:\n    - {lines: levee.geojson, mode: raise, z_field: crest_m}\n";
    let beyond = |wall: &str| {
        let buildings = "structures: {buildings: {polygons: houses.geojson}}";
        let scene = Scene::with(&[(levee, ""), (buildings, &format!("structures: {{walls: [{wall}]}}"))]);
        wet_beyond(&scene.run(&[]).0).0
    };
    assert!(beyond("{lines: levee.geojson, crest: 20 cm}") > 20);
    assert_eq!(beyond("{lines: levee.geojson, crest_field: crest_m}"), 0);
    assert_eq!(beyond("{lines: levee.geojson}"), 0);
}

#[test]
fn the_resolved_scenario_gives_the_same_bed() {
    let scene = Scene::sound();
    let (maps, _) = scene.run(&[]);
    let resolved = std::fs::read_to_string(scene.path("out/scenario.resolved.yaml")).unwrap();
    for text in ["clip: \"", "gaps: {fill: idw, max_cells: 2}", "mode: raise, z_field: \"crest_m\"", "mode: block"] {
        assert!(resolved.contains(text), "no `{text}` in\n{resolved}");
    }
    scene.write("s.yaml", &resolved);
    let (again, _) = scene.run(&[]);
    assert_eq!(maps.values("bed_elevation"), again.values("bed_elevation"));
}

#[test]
fn faults_of_the_ground_are_all_located_with_a_way_out() {
    let scene = Scene::with(&[
        ("clip: clip.geojson", "clip: far.geojson"),
        ("{fill: idw, max_cells: 2}", "error"),
        ("z_field: crest_m", "z_field: crest"),
    ]);
    scene.polygon("far.geojson", &[(9000.0, 2000.0), (9040.0, 2000.0), (9040.0, 2020.0)]);
    scene.polygon("houses.geojson", &[(9000.0, 2000.0), (9040.0, 2000.0), (9040.0, 2020.0)]);
    let check = |expected: &[&str]| {
        let check = floodsim(scene.folder.path(), &["check", "s.yaml"]);
        assert_eq!(check.code, 4, "{}", check.stdout);
        for text in expected {
            assert!(check.stdout.contains(text), "check does not say `{text}`, but\n{}", check.stdout);
        }
        for problem in check.stdout.split("error[").skip(1) {
            assert!(problem.contains("\n  remedy  "), "no way out of: {problem}");
        }
    };
    check(&[
        "error[clip-outside-layer] terrain.layers[1].clip (s.yaml:6:32)",
        "error[no-level] terrain.breaklines[0].lines (s.yaml:9:15)",
        "levee.geojson has no level",
        "cause   looked for a number in the attribute crest; its attributes: crest_m",
    ]);
    // With a terrain, what lies on it is found as well.
    scene.polygon("far.geojson", &[(1160.0, 2000.0), (1200.0, 2000.0), (1200.0, 2020.0)]);
    check(&[
        "error[terrain-gaps] terrain.gaps (s.yaml:7:9)",
        "1 cell (16 m²) at 1182.0, 2106.0",
        "error[no-level] terrain.breaklines[0].lines (s.yaml:9:15)",
        "error[outside-terrain] structures.buildings.polygons (s.yaml:11:36)",
    ]);
}

#[test]
fn faults_of_the_keys_are_faults_of_the_scenario() {
    let scene = Scene::with(&[
        ("offset: 50 cm", "offset: 50"),
        ("z_field: crest_m", "z: 6 m, width: 3"),
        ("mode: raise", "mode: rise"),
        ("{fill: idw, max_cells: 2}", "{fill: idw}"),
        ("{polygons: houses.geojson}", "{polygons: houses.geojson, height: 3 m}"),
    ]);
    let check = floodsim(scene.folder.path(), &["check", "s.yaml"]);
    assert_eq!(check.code, 3, "{}", check.stdout);
    for text in [
        "error[missing-unit] terrain.layers[1].offset (s.yaml:6:54)",
        "error[missing-unit] terrain.breaklines[0].width (s.yaml:9:57)",
        "error[unknown-name] terrain.breaklines[0].mode (s.yaml:9:36)\n  `rise` is not a mode of a breakline\n  remedy  did you mean `raise`?",
        "error[missing-key] terrain.gaps.max_cells (s.yaml:7:9)",
        "error[conflict] structures.buildings.height (s.yaml:11:60)",
    ] {
        assert!(check.stdout.contains(text), "check does not say `{text}`, but\n{}", check.stdout);
    }
}
