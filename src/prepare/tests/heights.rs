//! Heights that are not what they seem: in feet, warped, or no heights at all.

use super::scene::{Scene, Tiff, raster_layer, sourced};
use crate::geodata::{spatial_ref, transform};
use crate::math::Vec2;
use crate::prepare::{Prepared, prepare};
use crate::scenario::{CrsChoice, TerrainLayer};

/// A plateau of so many units in the north of Los Angeles, in feet on the map, warped to UTM.
fn in_feet(system: &str, height: f32, unit: Option<f64>) -> Prepared {
    let tiff = Tiff {
        geo_transform: Some([6_488_000.0, 100.0, 0.0, 1_927_000.0, 0.0, -100.0]),
        crs: Some(system),
        no_data: Some(-9999.0),
        ..Tiff::default()
    };
    let mut scene = Scene::sound();
    tiff.write(&scene.path("feet.tif"), |_, _| height);
    scene.scenario.layers = vec![sourced("terrain.layers[0].raster", raster_layer(scene.path("feet.tif")))];
    let TerrainLayer::Raster { unit: own, .. } = &mut scene.scenario.layers[0].value else { panic!("no raster") };
    *own = unit;
    scene.scenario.crs.value = CrsChoice::Named("EPSG:32611".to_owned());
    scene.scenario.reproject = true;
    scene.scenario.resolution.value = 30.0;
    scene.scenario.initial.clear();
    scene.scenario.outputs.gauges = None;
    prepare(&scene.scenario)
}

/// The height (m) in its middle.
fn middle(prepared: &Prepared) -> f64 {
    let mut place = [Vec2::new(6_490_000.0, 1_925_500.0)];
    transform(&mut place, &spatial_ref("EPSG:2229").unwrap(), &spatial_ref("EPSG:32611").unwrap()).unwrap();
    prepared.terrain.as_ref().unwrap().elevation(place[0]).unwrap()
}

fn codes(prepared: &Prepared) -> Vec<&'static str> {
    prepared.problems.iter().map(|problem| problem.code).collect()
}

#[test]
fn heights_beside_places_in_feet_need_a_unit() {
    let prepared = in_feet("EPSG:2229", 2000.0, None);
    assert_eq!(codes(&prepared), ["elevation-unit-unknown"]);
    assert!(prepared.problems[0].remedy.as_ref().unwrap().contains("`unit: us_ft` or `unit: m`"));
    for (unit, height) in [(1.0, 2000.0), (1200.0 / 3937.0, 2000.0 * 1200.0 / 3937.0)] {
        let prepared = in_feet("EPSG:2229", 2000.0, Some(unit));
        assert!(!prepared.has_errors(), "{:#?}", prepared.problems);
        assert!((middle(&prepared) - height).abs() < 1e-6);
    }
}

#[test]
fn a_warp_changes_no_height() {
    // Heights above NAVD 88 in US feet, in feet of the system, and in metres.
    for (vertical, unit) in [(6360, 1200.0 / 3937.0), (8228, 0.3048), (5703, 1.0)] {
        let prepared = in_feet(&format!("EPSG:2229+{vertical}"), 2000.0, Some(unit));
        assert!(!prepared.has_errors(), "{vertical}: {:#?}", prepared.problems);
        assert!((middle(&prepared) - 2000.0 * unit).abs() < 1e-6, "{vertical}: {} m", middle(&prepared));
    }
}

#[test]
fn depths_by_the_reference_system_are_refused() {
    let prepared = in_feet("EPSG:2229+5715", 20.0, Some(1.0));
    assert_eq!(codes(&prepared), ["heights-downward"]);
}

#[test]
fn marks_of_no_data_that_are_not_declared_are_refused_with_their_place() {
    for mark in [-9999.0, -32767.0, f32::MIN, 0.0, 1e20] {
        let mut scene = Scene::sound();
        let is_hole = |column: usize, row: usize| (20..23).contains(&column) && (10..12).contains(&row);
        Tiff::default().write(&scene.path("holes.tif"), |c, r| if is_hole(c, r) { mark } else { 700.0 + c as f32 });
        scene.scenario.layers = vec![sourced("terrain.layers[0].raster", raster_layer(scene.path("holes.tif")))];
        scene.scenario.initial.clear();
        scene.scenario.outputs.gauges = None;
        let prepared = prepare(&scene.scenario);
        let problem = prepared.problems.iter().find(|problem| problem.code == "undeclared-nodata");
        let problem = problem.unwrap_or_else(|| panic!("{mark}: {:#?}", prepared.problems));
        assert!(prepared.has_errors() && problem.message.starts_with("6 cells"), "{problem}");
        assert_eq!(problem.at, Some(super::scene::centre_of(20, 10)), "{problem}");
        // Declared, they are gaps.
        Tiff { no_data: Some(f64::from(mark)), ..Tiff::default() }
            .write(&scene.path("holes.tif"), |c, r| if is_hole(c, r) { mark } else { 700.0 + c as f32 });
        let declared = prepare(&scene.scenario);
        assert!(!codes(&declared).contains(&"undeclared-nodata"), "{mark}: {:#?}", declared.problems);
    }
}
