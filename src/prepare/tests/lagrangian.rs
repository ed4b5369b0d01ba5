//! What Lagrangian particles get wrong: a warning of each, with its place, and none where they are right.

use super::scene::{Scene, Tiff};
use crate::error::{Problem, Severity};
use crate::prepare::prepare;
use crate::scenario::resolve;

const EVERYWHERE: &[(f64, f64)] = &[(1000.0, 2000.0), (1200.0, 2000.0), (1200.0, 2150.0), (1000.0, 2150.0)];

/// A terrain of 200 m by 150 m in cells of 5 m, from (1000, 2000) on, of a height by column and row from the north.
fn scene(height: impl Fn(usize, usize) -> f64) -> Scene {
    let scene = Scene::sound();
    Tiff { no_data: Some(-9999.0), ..Tiff::default() }.write(&scene.path("dem.tif"), |c, r| height(c, r) as f32);
    scene.polygon("all.geojson", EVERYWHERE);
    scene.polygon("west.geojson", &[(1000.0, 2000.0), (1100.0, 2000.0), (1100.0, 2150.0), (1000.0, 2150.0)]);
    scene.polygon("east.geojson", &[(1100.0, 2000.0), (1200.0, 2000.0), (1200.0, 2150.0), (1100.0, 2150.0)]);
    scene
}

/// The warnings about Lagrangian particles of a scenario with these lines, for both motions.
fn warnings(scene: &Scene, lines: &str) -> [Vec<Problem>; 2] {
    ["eulerian", "lagrangian"].map(|motion| {
        let text = format!(
            "floodsim: 1\ncrs: local\nterrain: dem.tif\nroughness: {{manning: 0.03}}\nresolution: 5 m\ntime: {{end: 60 s}}\n{lines}\n"
        );
        let motion = format!("numerics.motion={motion}");
        let loaded = resolve(&text, &scene.path("s.yaml"), &[motion]).unwrap();
        let problems = prepare(&loaded.scenario).problems;
        assert!(problems.iter().all(|problem| problem.severity == Severity::Warning), "{problems:#?}");
        problems.into_iter().filter(|problem| problem.code.starts_with("lagrangian-")).collect()
    })
}

/// Code, key and place of the only warning; none for Eulerian particles.
fn only(scene: &Scene, lines: &str) -> Option<(&'static str, String, (f64, f64))> {
    let [eulerian, lagrangian] = warnings(scene, lines);
    assert!(eulerian.is_empty(), "{eulerian:#?}");
    assert!(lagrangian.len() <= 1, "{lagrangian:#?}");
    let problem = lagrangian.into_iter().next()?;
    assert!(problem.remedy.unwrap().contains("leave `numerics.motion` out") && problem.cause.is_some());
    let at = problem.at.unwrap();
    Some((problem.code, problem.key, (at.x, at.y)))
}

fn code(scene: &Scene, lines: &str) -> Option<&'static str> {
    only(scene, lines).map(|found| found.0)
}

#[test]
fn water_beside_lower_dry_ground_makes_a_front_that_comes_late() {
    let flat = scene(|_, _| 0.0);
    let found = only(&flat, "initial: [{reservoir: west.geojson, level: 4 m}]").unwrap();
    assert_eq!((found.0, found.1.as_str(), found.2.0), ("lagrangian-dry-front", "initial[0].reservoir", 1100.0));
    // A lake that its shores hold, and one that fills the terrain, stay where they are.
    let bowl = scene(|c, _| if (10..30).contains(&c) { 0.0 } else { 10.0 });
    assert_eq!(code(&bowl, "initial: [{reservoir: all.geojson, level: 4 m}]"), None);
    assert_eq!(code(&flat, "initial: [{sea: all.geojson, level: 4 m}]"), None);
    // Behind a wall nothing runs.
    flat.line("wall.geojson", &[(1100.0, 1990.0), (1100.0, 2160.0)]);
    let walled = "initial: [{reservoir: west.geojson, level: 4 m}]\nstructures: {walls: [{lines: wall.geojson}]}";
    assert_eq!(code(&flat, walled), None);
    // What comes in over dry ground does.
    let inflow = only(&flat, "boundaries: [{side: west, discharge: 50 m3/s}]").unwrap();
    assert_eq!((inflow.0, inflow.1.as_str(), inflow.2.0), ("lagrangian-dry-front", "boundaries[0]", 1000.0));
    assert_eq!(code(&flat, "sources: [{at: [1101, 2051], discharge: 5 m3/s}]"), Some("lagrangian-dry-front"));
}

#[test]
fn rain_on_a_slope_runs_too_fast() {
    let rain = "rain: {rate: 80 mm/h}\nboundaries: [{side: east, type: open}]";
    // Steeper in the middle.
    let slope = |steep: f64| scene(move |c, _| if c < 20 { 10.0 - 0.001 * c as f64 } else { 10.0 - steep * c as f64 });
    let found = only(&slope(0.01), rain).unwrap();
    assert_eq!((found.0, found.1.as_str(), found.2.0), ("lagrangian-rain", "rain", 1100.0));
    assert_eq!(code(&scene(|c, _| 1.0 - 0.001 * 5.0 * c as f64), rain), None);
    // A lake takes rain evenly.
    assert_eq!(code(&scene(|_, _| 0.0), &format!("{rain}\ninitial: [{{sea: all.geojson, level: 2 m}}]")), None);
}

#[test]
fn walls_that_are_askew_slow_the_water() {
    let lake = "initial: [{sea: all.geojson, level: 2 m}]";
    let flat = scene(|_, _| 0.0);
    flat.line("along.geojson", &[(1020.0, 2052.0), (1150.0, 2052.0)]);
    flat.line("askew.geojson", &[(1020.0, 2052.0), (1150.0, 2100.0)]);
    let wall = |name: &str| format!("{lake}\nstructures: {{walls: [{{lines: {name}.geojson}}]}}");
    assert_eq!(code(&flat, &wall("along")), None);
    let found = only(&flat, &wall("askew")).unwrap();
    assert_eq!(found, ("lagrangian-askew-wall", "structures.walls[0].lines".to_owned(), (1085.0, 2076.0)));
    flat.polygon("square.geojson", &[(1050.0, 2050.0), (1100.0, 2050.0), (1100.0, 2100.0), (1050.0, 2100.0)]);
    flat.polygon("turned.geojson", &[(1100.0, 2020.0), (1160.0, 2080.0), (1100.0, 2140.0), (1040.0, 2080.0)]);
    let building = |name: &str| format!("{lake}\nstructures: {{buildings: {{polygons: {name}.geojson, mode: block}}}}");
    assert_eq!(code(&flat, &building("square")), None);
    let found = only(&flat, &building("turned")).unwrap();
    assert_eq!((found.0, found.1.as_str()), ("lagrangian-askew-wall", "structures.buildings.polygons"));
}

#[test]
fn strong_jumps_are_wrong() {
    let flat = scene(|_, _| 0.0);
    let bore =
        |low: f64| format!("initial: [{{reservoir: west.geojson, level: 4 m}}, {{sea: east.geojson, level: {low} m}}]");
    assert_eq!(code(&flat, &bore(2.0)), None);
    let found = only(&flat, &bore(0.5)).unwrap();
    assert_eq!((found.0, found.1.as_str(), found.2.0), ("lagrangian-jump", "initial[0].reservoir", 1100.0));
    // 150 m wide and 1 m deep: Fr = 0.64 and 3.2.
    let inflow = |discharge: f64| {
        format!(
            "initial: [{{sea: all.geojson, level: 1 m}}]\nboundaries: [{{side: west, discharge: {discharge} m3/s, level: 1 m}}]"
        )
    };
    assert_eq!(code(&flat, &inflow(300.0)), None);
    let found = only(&flat, &inflow(1500.0)).unwrap();
    assert_eq!((found.0, found.1.as_str(), found.2.0), ("lagrangian-jump", "boundaries[0]", 1000.0));
}

#[test]
fn a_level_held_over_dry_ground_lets_in_too_much() {
    let valley = scene(|_, r| if (10..20).contains(&r) { 0.0 } else { 5.0 });
    let held = "boundaries: [{side: west, stage: 3 m}]";
    let found = only(&valley, held).unwrap();
    assert_eq!((found.0, found.1.as_str(), found.2.0), ("lagrangian-held-level", "boundaries[0]", 1000.0));
    let lake = format!("{held}\ninitial: [{{sea: all.geojson, level: 3 m}}]");
    assert_eq!(code(&valley, &lake), Some("lagrangian-stage"));
    assert_eq!(code(&valley, &lake.replace("stage", "level")), None);
}
