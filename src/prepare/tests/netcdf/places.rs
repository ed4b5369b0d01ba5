//! What the attributes and axes of NetCDF files say of heights and places besides units and bounds.

use super::{Made, SOUND, refused, terrain_cells};
use crate::prepare::prepare;
use crate::prepare::tests::scene::Scene;

/// The sound scene after a change of its variables.
fn changed(change: impl FnOnce(&mut netcdf::FileMut)) -> Scene {
    let mut scene = SOUND.scene();
    let mut file = netcdf::append(scene.path("dem.nc")).unwrap();
    change(&mut file);
    file.close().unwrap();
    scene.scenario.initial.clear();
    scene
}

#[test]
fn all_marks_of_no_data_count_as_numbers_or_as_text() {
    type Mark = fn(&mut netcdf::VariableMut);
    let marks: [Mark; 4] = [
        |elevation| {
            elevation.put_attribute("missing_value", -77.5_f32).unwrap();
        },
        |elevation| {
            elevation.put_attribute("missing_value", vec![-5.0_f64, -77.5]).unwrap();
        },
        |elevation| {
            elevation.put_attribute("missing_value", "-77.5").unwrap();
        },
        |elevation| {
            elevation.put_attribute("missing_value", -77.5_f64).unwrap();
        },
    ];
    for (number, mark) in marks.into_iter().enumerate() {
        let scene = changed(|file| {
            let mut elevation = file.variable_mut("elevation").unwrap();
            mark(&mut elevation);
            elevation.put_value(-77.5_f32, [3, 3]).unwrap();
        });
        let prepared = prepare(&scene.scenario);
        assert_eq!(terrain_cells(&prepared), 1199, "mark {number}: {:#?}", prepared.problems);
    }
    // A number of the double type that data of the single type hold rounded.
    let scene = changed(|file| {
        let mut elevation = file.variable_mut("elevation").unwrap();
        elevation.put_attribute("missing_value", -99.9_f64).unwrap();
        elevation.put_value(-99.9_f32, [3, 3]).unwrap();
    });
    assert_eq!(terrain_cells(&prepare(&scene.scenario)), 1199);
}

#[test]
fn a_mark_beyond_the_bounds_is_declared_by_them() {
    let scene = Made { bounds: vec![("valid_min", vec![-500.0])], corners: [-9999.0, 20.0], ..SOUND }.scene();
    let prepared = prepare(&scene.scenario);
    assert_eq!(terrain_cells(&prepared), 1199, "{:#?}", prepared.problems);
    assert!(!prepared.has_errors());
}

#[test]
fn depths_are_refused() {
    for (name, text) in [("positive", "down"), ("positive", "DOWN"), ("standard_name", "sea_floor_depth_below_geoid")] {
        let scene = changed(|file| {
            file.variable_mut("elevation").unwrap().put_attribute(name, text).unwrap();
        });
        let problem = refused(&scene, "heights-downward");
        assert!(problem.message.contains(name) && problem.remedy.unwrap().contains("ncap2"), "{name} {text}");
    }
    let scene = changed(|file| {
        let mut elevation = file.variable_mut("elevation").unwrap();
        elevation.put_attribute("positive", "up").unwrap();
        elevation.put_attribute("standard_name", "sea_floor_depth_below_geoid").unwrap();
    });
    assert_eq!(terrain_cells(&prepare(&scene.scenario)), 1200);
}

#[test]
fn places_that_are_not_evenly_spaced_are_refused() {
    for (axis, place, shift) in [("x", 20, 50.0), ("x", 39, 5.0), ("y", 10, -2.5), ("y", 0, -40.0), ("x", 5, f64::NAN)]
    {
        let scene = changed(|file| {
            let mut axis = file.variable_mut(axis).unwrap();
            let mut places: Vec<f64> = axis.get_values(..).unwrap();
            places[place..].iter_mut().take(if place == 0 { 1 } else { 99 }).for_each(|value| *value += shift);
            axis.put_values(&places, ..).unwrap();
        });
        let problem = refused(&scene, "axis-uneven");
        assert!(problem.message.contains(&format!("`{axis}`")), "{problem}");
    }
    // Rounding to single precision is none.
    let scene = changed(|file| {
        let mut axis = file.variable_mut("x").unwrap();
        let places: Vec<f64> = axis.get_values(..).unwrap();
        let rounded: Vec<f64> = places.iter().map(|place| f64::from((place + 0.1) as f32) - 0.1).collect();
        axis.put_values(&rounded, ..).unwrap();
    });
    assert_eq!(terrain_cells(&prepare(&scene.scenario)), 1200);
}
