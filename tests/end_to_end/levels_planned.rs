//! What `floodsim plan` says of levels, and the layer that it writes of them.

use gdal::vector::LayerAccess;
use serde_json::Value;

use crate::floodsim;
use crate::levels::{Scene, cells};

fn evaluations(level: &Value) -> f64 {
    level["expected_evaluations"].as_f64().unwrap()
}

#[test]
fn a_plan_tells_the_levels_of_the_run_with_reasons_and_cost() {
    let scene = Scene::new();
    let answer = floodsim(scene.folder.path(), &["plan", "s.yaml", "--json", "--layer", "levels.gpkg"]);
    assert_eq!(answer.code, 0, "{}", answer.stderr);
    let plan: Value = serde_json::from_str(&answer.stdout).unwrap();
    let run = scene.run("run", &[]);
    assert_eq!(cells(&plan), cells(&run));
    assert_eq!(plan["levels"], run["levels"]);
    let levels = plan["levels"].as_array().unwrap();
    assert!(levels[0]["area_m2"]["gauges"].as_f64().unwrap() > 1e3, "{}", levels[0]);
    let for_terrain = |level: &Value| level["area_m2"]["terrain under the water"].as_f64();
    assert!(levels.iter().filter_map(for_terrain).sum::<f64>() > 1e3, "{levels:?}");
    let area = |level: &Value| level["area_m2"].as_object().unwrap().values().filter_map(Value::as_f64).sum::<f64>();
    let all: f64 = levels.iter().map(area).sum();
    assert!((all - 1280.0 * 480.0).abs() < 1e-3, "{all}");
    let (expected, actual) =
        (levels.iter().map(evaluations).sum::<f64>(), run["particle_evaluations"].as_f64().unwrap());
    println!("expected evaluations over those of the run: {}", expected / actual);
    assert!((0.5..2.0).contains(&(expected / actual)), "{expected} of {actual}");
    assert_layer(&scene, all);
}

/// Asserts that the layer covers an area (m²) without overlap, and knows cells and reasons.
fn assert_layer(scene: &Scene, all: f64) {
    let file = gdal::Dataset::open(scene.path("levels.gpkg")).unwrap();
    let mut layer = file.layer_by_name("levels").unwrap();
    let (mut area, mut said) = (0.0, Vec::new());
    for feature in layer.features() {
        area += feature.geometry().unwrap().area();
        let index = |name: &str| feature.field_index(name).unwrap();
        let edge = feature.field_as_double(index("spacing_m")).unwrap().unwrap();
        said.push((edge as u32, feature.field_as_string(index("because")).unwrap().unwrap()));
    }
    assert!((area - all).abs() < 1e-3, "{area} of {all}");
    assert!(said.contains(&(5, "gauges".to_owned())), "{said:?}");
    assert!(said.iter().any(|(edge, _)| *edge > 5), "{said:?}");
}

#[test]
fn a_layer_replaces_no_file_and_stands_for_one_spacing_too() {
    let scene = Scene::new();
    let plan = |layer: &str| {
        let settings = ["--set", "resolution=5 m", "--set", "time.end=5 s"];
        floodsim(scene.folder.path(), &[&["plan", "s.yaml", "--layer", layer], &settings[..]].concat())
    };
    let answer = plan("one.gpkg");
    assert_eq!(answer.code, 0, "{}", answer.stderr);
    assert!(!answer.stdout.contains("levels  "), "{}", answer.stdout);
    let again = plan("one.gpkg");
    assert_eq!(again.code, 2);
    assert!(again.stderr.contains("--layer one.gpkg: the file exists"), "{}", again.stderr);
    assert_eq!(plan("dem.asc").code, 2);
    let file = gdal::Dataset::open(scene.path("one.gpkg")).unwrap();
    assert_eq!(file.layer_by_name("levels").unwrap().feature_count(), 1);
}
