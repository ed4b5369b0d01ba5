//! Still water that the terrain does not hold.

use super::*;

#[test]
fn polygons_that_cross_themselves_or_are_empty_are_located() {
    let scene = Scene::sound();
    scene.polygon("reservoir.geojson", &[(1050.0, 2050.0), (1100.0, 2100.0), (1100.0, 2050.0), (1050.0, 2100.0)]);
    let prepared = prepare(&scene.scenario);
    let problem = only(&prepared);
    assert_error(problem, ProblemKind::Input, "self-crossing", "initial[0].reservoir");
    assert_eq!(problem.at, Some(Vec2::new(1075.0, 2075.0)));
    scene.polygon("reservoir.geojson", &[(1050.0, 2050.0), (1100.0, 2050.0), (1075.0, 2050.0)]);
    assert_error(only(&prepare(&scene.scenario)), ProblemKind::Input, "empty-polygon", "initial[0].reservoir");
    scene.write("reservoir.geojson", r#"{"type":"FeatureCollection","features":[]}"#);
    assert_error(only(&prepare(&scene.scenario)), ProblemKind::Input, "empty-polygon", "initial[0].reservoir");
    scene.line("reservoir.geojson", &[(1050.0, 2050.0), (1100.0, 2050.0)]);
    assert_error(only(&prepare(&scene.scenario)), ProblemKind::Input, "empty-polygon", "initial[0].reservoir");
}

#[test]
fn a_polygon_outside_the_terrain_and_one_partly_outside_are_refused() {
    let scene = Scene::sound();
    scene.polygon("reservoir.geojson", &[(5000.0, 2050.0), (5100.0, 2050.0), (5100.0, 2100.0)]);
    assert_error(only(&prepare(&scene.scenario)), ProblemKind::Input, "outside-terrain", "initial[0].reservoir");
    scene.polygon("reservoir.geojson", &[(1050.0, 2050.0), (1100.0, 2050.0), (1100.0, 2300.0), (1050.0, 2300.0)]);
    let prepared = prepare(&scene.scenario);
    let problem = only(&prepared);
    assert_error(problem, ProblemKind::Input, "nodata-in-water", "initial[0].reservoir");
    assert!(problem.message.contains("7500 m²"), "{problem}"); // 50 m by 150 m beyond the northern edge
}

#[test]
fn a_hole_in_the_terrain_under_the_water_is_an_error_and_a_frayed_edge_a_warning() {
    let hole = |c: usize, r: usize| if (c, r) == (14, 14) { -9999.0 } else { basin_elevation(centre_of(c, r)) };
    let mut scene = with_terrain(&Tiff { no_data: Some(-9999.0), ..Tiff::default() }, hole);
    scene.scenario.ground.gaps = Some(sourced("terrain.gaps", Gaps::Wall));
    let prepared = prepare(&scene.scenario);
    let problem = only(&prepared);
    assert_error(problem, ProblemKind::Input, "nodata-in-water", "initial[0].reservoir");
    assert!(problem.message.contains("25 m²") && problem.message.contains("1 cells"), "{problem}");
    assert_eq!(problem.at, Some(centre_of(14, 14)));
    let frayed = |c: usize, r: usize| if (c, r) == (9, 9) { -9999.0 } else { basin_elevation(centre_of(c, r)) };
    let mut scene = with_terrain(&Tiff { no_data: Some(-9999.0), ..Tiff::default() }, frayed);
    scene.scenario.ground.gaps = Some(sourced("terrain.gaps", Gaps::Wall));
    let prepared = prepare(&scene.scenario);
    assert_eq!((only(&prepared).code, prepared.has_errors()), ("polygon-beyond-data", false));
}

#[test]
fn levels_that_are_missing_or_below_the_bed_are_refused() {
    let mut scene = Scene::sound();
    scene.scenario.initial[0].level = Some(sourced("initial[0].level", -3.0));
    let prepared = prepare(&scene.scenario);
    let problem = only(&prepared);
    assert_error(problem, ProblemKind::Input, "level-below-bed", "initial[0].reservoir");
    assert!(problem.cause.as_ref().unwrap().contains("0.00 m"));
    scene.scenario.initial[0].level = None;
    assert_error(only(&prepare(&scene.scenario)), ProblemKind::Input, "no-level", "initial[0].reservoir");
}

#[test]
fn the_level_comes_from_the_attribute_when_the_scenario_gives_none() {
    let mut scene = Scene::sound();
    let corners = [(1045.0, 2045.0), (1100.0, 2045.0), (1100.0, 2105.0), (1045.0, 2105.0)];
    scene.scenario.initial[0].level = None;
    scene.polygon_with("reservoir.geojson", &corners, r#"{"level_m": 4.5, "stage_1959": 5.5}"#);
    assert_eq!(prepare(&scene.scenario).scene().waters[0].level, 4.5);
    scene.scenario.initial[0].level_field = Some("stage_1959".to_string());
    assert_eq!(prepare(&scene.scenario).scene().waters[0].level, 5.5);
    scene.scenario.initial[0].level_field = None;
    scene.scenario.initial[0].level = Some(sourced("initial[0].level", 5.0));
    let prepared = prepare(&scene.scenario);
    assert_eq!((only(&prepared).code, prepared.scene().waters[0].level), ("two-levels", 5.0));
}

#[test]
fn overlapping_water_is_refused_at_different_levels_and_shared_out_at_equal_ones() {
    let mut scene = Scene::sound();
    scene.polygon("second.geojson", &[(1070.0, 2045.0), (1100.0, 2045.0), (1100.0, 2105.0), (1070.0, 2105.0)]);
    scene.fill("second.geojson", Some(4.0));
    let prepared = prepare(&scene.scenario);
    assert_error(only(&prepared), ProblemKind::Input, "overlapping-water", "initial[1].reservoir");
    scene.scenario.initial[1].level = Some(sourced("initial[1].level", 5.0));
    let prepared = prepare(&scene.scenario);
    assert_eq!((prepared.problems.len(), prepared.scene().needs.wet_cells), (0, 100));
    assert!(prepared.scene().waters[1].polygon.0.is_empty());
}

#[test]
fn a_leaking_rim_is_a_warning_with_its_lowest_place_and_a_wall_closes_it() {
    let mut scene = Scene::sound();
    scene.scenario.initial[0].level = Some(sourced("initial[0].level", 8.0));
    let prepared = prepare(&scene.scenario);
    let problem = only(&prepared);
    assert_eq!(
        (problem.severity, problem.code, problem.at),
        (Severity::Warning, "leaking-rim", Some(Vec2::new(1102.5, 2072.5)))
    );
    assert!(problem.cause.as_ref().unwrap().contains("6.00 m at 110"), "{problem}");
    assert_eq!(prepared.setup.unwrap().still_water.volumes[0].leaks.len(), 1);
    scene.line("dam.geojson", &[(1100.0, 2060.0), (1100.0, 2085.0)]);
    scene.scenario.walls = vec![vector("structures.walls[0].lines", scene.path("dam.geojson"))];
    let prepared = prepare(&scene.scenario);
    assert_eq!(prepared.problems, []);
    assert_eq!(prepared.scene().walls, [[Vec2::new(100.0, 60.0), Vec2::new(100.0, 85.0)]]);
}
