//! Lines along which water comes out of the ground: what of their files is taken, and which cells get it.

use super::scene::{Scene, sourced, vector};
use crate::error::Severity;
use crate::prepare::{Prepared, prepare};
use crate::scenario::{BuildingMode, Buildings, Source, SourcePlace, Timed};

/// The scene with water from the lines of `springs.geojson`.
fn with_springs(mut scene: Scene) -> Scene {
    let place = SourcePlace::Lines(vector("sources[0].line", scene.path("springs.geojson")));
    let discharge = Timed::Constant(sourced("sources[0].discharge", 2.0));
    scene.scenario.sources = vec![sourced("sources[0]", Source { place, discharge })];
    scene
}

/// Column and row of each cell of the first line, from the south-west, and its share.
fn shares(prepared: &Prepared) -> Vec<((usize, usize), f64)> {
    let lattice = &prepared.scene().lattice;
    prepared.scene().forcing.line_sources[0]
        .cells
        .iter()
        .map(|(cell, share)| (lattice.column_row(*cell), *share))
        .collect()
}

#[test]
fn what_is_no_line_beside_lines_is_refused() {
    let line = r#"{"type":"LineString","coordinates":[[1020,2010],[1020,2040]]}"#;
    let point = r#"{"type":"Point","coordinates":[1030,2010]}"#;
    let polygon = r#"{"type":"Polygon","coordinates":[[[1030,2010],[1035,2010],[1035,2015],[1030,2010]]]}"#;
    let dot = r#"{"type":"LineString","coordinates":[[1020,2010],[1020,2010]]}"#;
    for (geometries, left_out) in [
        (vec![line], None),
        (vec![line, line], None),
        (vec![line, point, polygon], Some("feature 2, 3")),
        (vec![dot, line], Some("feature 1")),
    ] {
        let scene = with_springs(Scene::sound());
        let feature = |geometry: &&str| format!(r#"{{"type":"Feature","properties":{{}},"geometry":{geometry}}}"#);
        let features: Vec<String> = geometries.iter().map(feature).collect();
        scene.write(
            "springs.geojson",
            &format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, features.join(",")),
        );
        let prepared = prepare(&scene.scenario);
        let errors: Vec<_> = prepared.problems.iter().filter(|found| found.severity == Severity::Error).collect();
        assert_eq!(errors.len(), usize::from(left_out.is_some()), "{errors:#?}");
        if let (Some(left_out), Some(problem)) = (left_out, errors.first()) {
            assert_eq!((problem.code, problem.key.as_str()), ("not-a-line", "sources[0].line"));
            assert!(problem.message.ends_with(left_out), "{problem}");
        }
    }
}

#[test]
fn a_line_between_two_columns_or_rows_gives_half_to_each() {
    let third = 1.0 / 12.0;
    let columns = |row: usize| [((3, row), third), ((4, row), third)];
    let upright: Vec<_> = (2..8).flat_map(columns).collect();
    let lying: Vec<_> = [3, 4].into_iter().flat_map(|row| (2..8).map(move |column| ((column, row), third))).collect();
    for (line, expected) in [
        ([(1020.0, 2010.0), (1020.0, 2040.0)], &upright),
        ([(1020.0, 2040.0), (1020.0, 2010.0)], &upright),
        ([(1010.0, 2020.0), (1040.0, 2020.0)], &lying),
    ] {
        let scene = with_springs(Scene::sound());
        scene.line("springs.geojson", &line);
        let found = shares(&prepare(&scene.scenario));
        assert_eq!(found.len(), expected.len(), "{line:?}: {found:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!(found.0 == expected.0 && (found.1 - expected.1).abs() < 1e-12, "{line:?}: {found:?}");
        }
    }
}

#[test]
fn where_one_side_of_a_line_has_no_terrain_the_other_gets_it_all() {
    // The western edge of the terrain.
    let scene = with_springs(Scene::sound());
    scene.line("springs.geojson", &[(1000.0, 2010.0), (1000.0, 2020.0)]);
    assert_eq!(shares(&prepare(&scene.scenario)), [((0, 2), 0.5), ((0, 3), 0.5)]);
    // A building east of the lower half of the line, another one west of a quarter above it.
    let mut scene = with_springs(Scene::sound());
    scene.line("springs.geojson", &[(1020.0, 2010.0), (1020.0, 2030.0)]);
    let east = r"[[[1020,2010],[1030,2010],[1030,2020],[1020,2020],[1020,2010]]]";
    let west = r"[[[1010,2020],[1020,2020],[1020,2025],[1010,2025],[1010,2020]]]";
    scene.write(
        "buildings.geojson",
        &format!(
            r#"{{"type":"FeatureCollection","features":[{{"type":"Feature","properties":{{}},"geometry":{{"type":"MultiPolygon","coordinates":[{east},{west}]}}}}]}}"#
        ),
    );
    let polygons = vector("structures.buildings.polygons", scene.path("buildings.geojson"));
    scene.scenario.ground.buildings = Some(Buildings { polygons, mode: BuildingMode::Block });
    let found = shares(&prepare(&scene.scenario));
    let expected = [((3, 2), 0.25), ((3, 3), 0.25), ((4, 4), 0.25), ((3, 5), 0.125), ((4, 5), 0.125)];
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(&expected) {
        assert!(found.0 == expected.0 && (found.1 - expected.1).abs() < 1e-12, "{found:?}");
    }
}
