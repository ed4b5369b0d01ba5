//! Roughness by raster, table and polygons.

#![expect(clippy::float_cmp, reason = "made values are met exactly")]

use super::scene::{Scene, Tiff, sourced, vector};
use crate::error::{Problem, Severity};
use crate::math::Vec2;
use crate::prepare::{Prepared, prepare};
use crate::scenario::{CrsChoice, Rain, RainAmount, RainUnit, Roughness};

/// A sound scene with a raster of classes 1 (west) and 2 (east), and a hole without data of 2 by 3 cells.
fn classes(table: Option<&str>, default: Option<f64>) -> Scene {
    let mut scene = Scene::sound();
    let value = |column, row| if column < 2 && row < 3 { -1.0 } else { 1.0 + f32::from(column >= 20) };
    Tiff { no_data: Some(-1.0), ..Tiff::default() }.write(&scene.path("cover.tif"), value);
    let raster = Some(sourced("roughness.raster", scene.path("cover.tif")));
    let file = table.map(|text| {
        scene.write("manning.csv", text);
        sourced("roughness.table", scene.path("manning.csv"))
    });
    scene.scenario.roughness = Roughness { manning: default, raster, table: file, ..Roughness::uniform(0.0) };
    scene
}

fn only(prepared: &Prepared) -> &Problem {
    assert_eq!(prepared.problems.len(), 1, "{:#?}", prepared.problems);
    &prepared.problems[0]
}

/// n at a place of a scene without errors.
fn n_at(prepared: &Prepared, x: f64, y: f64) -> f64 {
    let lattice = &prepared.scene().lattice;
    prepared.setup().bed.manning[lattice.cell_at(lattice.to_local(Vec2::new(x, y))).unwrap()]
}

#[test]
fn classes_get_their_roughness_and_polygons_lie_on_top() {
    let mut scene = classes(Some("class,name,n\n1,meadow,0.03\n2,forest,0.1\n"), Some(0.05));
    scene.polygon_with("areas.geojson", &[(1150.0, 2000.0), (1200.0, 2000.0), (1200.0, 2050.0)], r#"{"n": 0.2}"#);
    scene.scenario.roughness.polygons = Some(vector("roughness.polygons", scene.path("areas.geojson")));
    let prepared = prepare(&scene.scenario);
    let problem = only(&prepared);
    assert_eq!((problem.severity, problem.code), (Severity::Warning, "roughness-default"));
    assert!(problem.message.ends_with("no data (150.0 m²)"), "{}", problem.message);
    let places = [(1050.0, 2050.0, 0.03), (1150.0, 2100.0, 0.1), (1002.0, 2148.0, 0.05), (1190.0, 2010.0, 0.2)];
    for (x, y, n) in places {
        assert_eq!(n_at(&prepared, x, y), n, "at {x}, {y}");
    }
    assert_eq!(prepared.inputs.len(), 6, "raster, table and polygons have their checksums");
}

#[test]
fn a_factor_multiplies_every_roughness() {
    let mut scene = classes(Some("class,name,n\n1,meadow,0.03\n2,forest,0.1\n"), Some(0.05));
    scene.polygon_with("areas.geojson", &[(1150.0, 2000.0), (1200.0, 2000.0), (1200.0, 2050.0)], r#"{"n": 0.2}"#);
    scene.scenario.roughness.polygons = Some(vector("roughness.polygons", scene.path("areas.geojson")));
    scene.scenario.roughness.factor = 2.0;
    let prepared = prepare(&scene.scenario);
    let places = [(1050.0, 2050.0, 0.06), (1150.0, 2100.0, 0.2), (1002.0, 2148.0, 0.1), (1190.0, 2010.0, 0.4)];
    for (x, y, n) in places {
        assert_eq!(n_at(&prepared, x, y), n, "at {x}, {y}");
    }
}

#[test]
fn classes_without_a_value_are_listed_with_their_area() {
    let prepared = prepare(&classes(Some("class;name;n\n1;meadow;0.03\n"), None).scenario);
    let problem = only(&prepared);
    assert_eq!(
        (problem.severity, problem.code, problem.key.as_str()),
        (Severity::Error, "roughness-gap", "roughness.raster")
    );
    // 20 by 30 cells of 25 m², and 2 by 3.
    assert!(problem.message.ends_with("class 2 (1.50 ha), no data (150.0 m²)"), "{}", problem.message);
    assert!(problem.remedy.as_deref().unwrap().contains("add these classes to the table"));
}

#[test]
fn a_raster_of_n_is_taken_as_it_is_and_one_of_classes_needs_its_table() {
    let scene = classes(None, Some(0.05));
    Tiff::default().write(&scene.path("cover.tif"), |column, _| if column < 20 { 0.02 } else { 0.04 });
    let prepared = prepare(&scene.scenario);
    assert_eq!(prepared.problems, []);
    assert_eq!((n_at(&prepared, 1010.0, 2010.0), n_at(&prepared, 1190.0, 2010.0)), (0.02, 0.04));
    let refused = prepare(&classes(None, Some(0.05)).scenario);
    let problem = refused.problems.iter().find(|problem| problem.severity == Severity::Error).unwrap();
    assert_eq!(problem.code, "roughness-range");
    assert!(problem.remedy.as_deref().unwrap().contains("table: FILE.csv"));
}

#[test]
fn faults_of_the_table_are_located() {
    for (table, code, words) in [
        ("class,name\n1,meadow\n", "missing-column", "no column `n`"),
        ("class,n\n1,0.03\n2,rough\n", "not-a-number", "line 3"),
        ("class,n\n1,0.03\n2,30\n", "roughness-range", "line 3"),
        ("class,n\n1,0.03\n1,0.04\n2,0.1\n", "duplicate-class", "line 3"),
    ] {
        let prepared = prepare(&classes(Some(table), Some(0.05)).scenario);
        let problem = only(&prepared);
        assert_eq!((problem.code, problem.key.as_str()), (code, "roughness.table"));
        assert!(problem.message.contains(words), "{}", problem.message);
    }
}

#[test]
fn polygons_without_a_roughness_are_refused() {
    for (properties, code) in [("{}", "no-roughness"), (r#"{"n": 0.9}"#, "roughness-range")] {
        let mut scene = Scene::sound();
        scene.polygon_with("areas.geojson", &[(1150.0, 2000.0), (1200.0, 2000.0), (1200.0, 2050.0)], properties);
        scene.scenario.roughness.polygons = Some(vector("roughness.polygons", scene.path("areas.geojson")));
        assert_eq!(only(&prepare(&scene.scenario)).code, code);
    }
}

#[test]
fn polygons_beside_the_terrain_are_refused() {
    let mut scene = Scene::sound();
    scene.polygon_with("areas.geojson", &[(9150.0, 2000.0), (9200.0, 2000.0), (9200.0, 2050.0)], r#"{"n": 0.2}"#);
    scene.scenario.roughness.polygons = Some(vector("roughness.polygons", scene.path("areas.geojson")));
    let prepared = prepare(&scene.scenario);
    let problem = only(&prepared);
    assert_eq!((problem.code, problem.key.as_str()), ("outside-terrain", "roughness.polygons"));
}

#[test]
fn the_cell_that_holds_a_place_counts_where_the_raster_has_another_system() {
    // Cells of some 40 m by 44 m in degrees over a terrain of 5 m; each has a value of its own.
    const COLUMNS: usize = 12;
    let (west, north, step_x, step_y) = (8.9975, 45.103, 0.0005, 0.0004);
    let value = |column: usize, row: usize| 0.01 + 0.001 * (row * COLUMNS + column) as f64;
    let mut scene = Scene::sound();
    let ground = Some([499_900.0, 5.0, 0.0, 4_994_150.0, 0.0, -5.0]);
    Tiff { geo_transform: ground, crs: Some("EPSG:32632"), ..Tiff::default() }
        .write(&scene.path("dem.tif"), |_, _| 7.0_f32);
    let degrees = Some([west, step_x, 0.0, north, 0.0, -step_y]);
    Tiff { size: (COLUMNS, 14), geo_transform: degrees, crs: Some("EPSG:4326"), ..Tiff::default() }
        .write(&scene.path("cover.tif"), value);
    scene.write("list.csv", "time_s,file\n0,cover.tif\n10,cover.tif\n");
    scene.scenario.crs.value = CrsChoice::FromTerrain;
    scene.scenario.reproject = true;
    scene.scenario.initial.clear();
    scene.scenario.outputs.gauges = None;
    let raster = Some(sourced("roughness.raster", scene.path("cover.tif")));
    scene.scenario.roughness = Roughness { manning: None, raster, ..Roughness::uniform(0.0) };
    let amount = RainAmount::Series {
        file: vector("rain.raster_series", scene.path("list.csv")),
        unit: Some(("mm/s".to_string(), RainUnit::Intensity(1e-3))),
        stamp: None,
        start: None,
    };
    scene.scenario.rain = Some(sourced("rain", Rain { amount, duration: None, initial_loss: 0.0, constant_loss: 0.0 }));
    let prepared = prepare(&scene.scenario);
    assert!(!prepared.has_errors(), "{:#?}", prepared.problems);
    let lattice = &prepared.scene().lattice;
    let mut places: Vec<Vec2> = (0..lattice.len()).map(|cell| lattice.to_map(lattice.centre(cell))).collect();
    let crs = |code| crate::geodata::spatial_ref(code).unwrap();
    crate::geodata::transform(&mut places, &crs("EPSG:32632"), &crs("EPSG:4326")).unwrap();
    let rain = prepared.scene().forcing.rain.as_ref().unwrap();
    assert_eq!(places.len(), 1200);
    for (cell, place) in places.iter().enumerate() {
        let expected = value(((place.x - west) / step_x) as usize, ((north - place.y) / step_y) as usize);
        let (n, fallen) = (prepared.setup().bed.manning[cell], rain.depth(cell, 0.0, 1.0) * 1e3);
        assert!((n - expected).abs() < 1e-12, "n of cell {cell} is {n} and not {expected}");
        assert!((fallen - expected).abs() < 1e-12, "rain on cell {cell} is {fallen} and not {expected}");
    }
}
