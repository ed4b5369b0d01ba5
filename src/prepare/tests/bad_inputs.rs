//! Every kind of bad input: its code, its kind, its key, its words and its place.

#![expect(clippy::float_cmp, reason = "made values are met exactly")]

mod water;

use super::scene::{Scene, Tiff, basin_elevation, centre_of, raster_layer, sourced, vector};
use crate::error::{Problem, ProblemKind, Severity};
use crate::math::Vec2;
use crate::output::OutputCrs;
use crate::prepare::{Prepared, prepare};
use crate::scenario::{CrsChoice, Gaps, LayerMode, OpenBoundary, PointInterpolation, Side, TerrainLayer};

/// The only finding.
fn only(prepared: &Prepared) -> &Problem {
    assert_eq!(prepared.problems.len(), 1, "{:#?}", prepared.problems);
    &prepared.problems[0]
}

fn codes(prepared: &Prepared) -> Vec<&str> {
    prepared.problems.iter().map(|problem| problem.code).collect()
}

fn assert_error(problem: &Problem, kind: ProblemKind, code: &str, key: &str) {
    assert_eq!(
        (problem.severity, problem.kind, problem.code, problem.key.as_str()),
        (Severity::Error, kind, code, key),
        "{problem}"
    );
}

/// Replaces the terrain of a sound scene.
fn with_terrain<T: gdal::raster::GdalType + Copy>(tiff: &Tiff, value: impl Fn(usize, usize) -> T) -> Scene {
    let scene = Scene::sound();
    tiff.write(&scene.path("dem.tif"), value);
    scene
}

#[test]
fn a_sound_scene_has_no_findings_and_everything_a_run_needs() {
    let scene = Scene::sound();
    let prepared = prepare(&scene.scenario);
    assert_eq!(prepared.problems, []);
    let lattice = &prepared.scene().lattice;
    assert_eq!(
        (lattice.origin, lattice.columns, lattice.rows, lattice.spacing),
        (Vec2::new(1000.0, 2000.0), 40, 30, 5.0)
    );
    assert_eq!((prepared.scene().needs.bed_particles, prepared.scene().needs.wet_cells), (1200, 100));
    assert_eq!((prepared.scene().waters.len(), prepared.scene().waters[0].level), (1, 5.0));
    assert_eq!(prepared.scene().gauges[1].id, "B, below");
    assert_eq!(prepared.scene().gauges[0].attributes, [("kind".to_string(), "lake".to_string())]);
    assert_eq!(prepared.inputs.len(), 3);
    assert_eq!(prepared.scene().crs, OutputCrs::Local);
    assert_eq!(prepared.terrain.unwrap().elevation(Vec2::new(1052.5, 2052.5)), Some(0.0));
}

#[test]
fn a_scenario_without_terrain_is_refused() {
    let mut scene = Scene::sound();
    scene.scenario.layers.clear();
    assert_error(&prepare(&scene.scenario).problems[0], ProblemKind::Scenario, "no-terrain", "terrain.layers");
}

#[test]
fn any_data_type_nodata_scale_and_offset_give_the_same_terrain() {
    let scaled = Tiff { scale_offset: Some((0.5, -10.0)), no_data: Some(255.0), ..Tiff::default() };
    // Stored value 20 to 60 for 0 to 20 m; a corner far from the water is nodata.
    let byte =
        with_terrain(
            &scaled,
            |c, r| if c + r == 0 { 255u8 } else { ((basin_elevation(centre_of(c, r)) + 10.0) * 2.0) as u8 },
        );
    let short = with_terrain(&Tiff { no_data: Some(-32768.0), ..Tiff::default() }, |c, r| {
        if c + r == 0 { i16::MIN } else { basin_elevation(centre_of(c, r)) as i16 }
    });
    let double = with_terrain(&Tiff { no_data: Some(f64::NAN), ..Tiff::default() }, |c, r| {
        if c + r == 0 { f64::NAN } else { basin_elevation(centre_of(c, r)) }
    });
    let single = with_terrain(&Tiff { no_data: Some(-3.4e38), ..Tiff::default() }, |c, r| {
        if c + r == 0 { -3.4e38f32 } else { basin_elevation(centre_of(c, r)) as f32 }
    });
    for scene in [byte, short, double, single] {
        let prepared = prepare(&scene.scenario);
        assert_eq!(prepared.problems, []);
        let terrain = prepared.terrain.unwrap();
        for (c, r) in [(1, 0), (20, 15), (22, 15), (39, 29)] {
            assert_eq!(terrain.elevation(centre_of(c, r)), Some(basin_elevation(centre_of(c, r))));
        }
        assert_eq!(terrain.elevation(centre_of(0, 0)), None);
    }
}

#[test]
fn unit_and_offset_of_the_scenario_come_after_those_of_the_file() {
    let mut scene = Scene::sound();
    if let TerrainLayer::Raster { offset, unit, .. } = &mut scene.scenario.layers[0].value {
        (*offset, *unit) = (3.0, Some(0.3048));
    }
    scene.scenario.initial.clear();
    let prepared = prepare(&scene.scenario);
    assert_eq!(prepared.terrain.unwrap().elevation(Vec2::new(1002.5, 2002.5)), Some(20.0 * 0.3048 + 3.0));
}

#[test]
fn a_raster_that_counts_from_the_south_is_turned_round() {
    let south_up = Tiff { geo_transform: Some([1000.0, 5.0, 0.0, 2000.0, 0.0, 5.0]), ..Tiff::default() };
    let scene = with_terrain(&south_up, |c, r| basin_elevation(centre_of(c, 29 - r)));
    let prepared = prepare(&scene.scenario);
    assert_eq!(prepared.problems, []);
    assert_eq!(prepared.scene().needs.wet_cells, 100);
}

#[test]
fn a_rotated_raster_is_refused_or_resampled() {
    let rotated =
        Tiff { geo_transform: Some([1000.0, 5.0, 0.5, 2150.0, 0.5, -5.0]), no_data: Some(-1.0), ..Tiff::default() };
    let mut scene = with_terrain(&rotated, |_, _| 7.0);
    scene.scenario.initial.clear();
    scene.scenario.outputs.gauges = None;
    let prepared = prepare(&scene.scenario);
    assert_error(only(&prepared), ProblemKind::Input, "rotated-raster", "terrain.layers[0].raster");
    scene.scenario.reproject = true;
    let prepared = prepare(&scene.scenario);
    assert_eq!(prepared.problems, []);
    assert_eq!(prepared.terrain.unwrap().elevation(Vec2::new(1100.0, 2100.0)), Some(7.0));
}

#[test]
fn files_that_are_missing_empty_or_no_rasters_are_all_reported_at_once() {
    let mut scene = Scene::sound();
    scene.write("empty.tif", "");
    scene.write("text.tif", "this is no raster");
    let layer = |i: usize, name: &str| sourced(&format!("terrain.layers[{i}].raster"), raster_layer(scene.path(name)));
    scene.scenario.layers = vec![layer(0, "missing.tif"), layer(1, "empty.tif"), layer(2, "text.tif")];
    scene.scenario.initial[0].polygons = vector("initial[0].reservoir", scene.path("missing.geojson"));
    scene.scenario.outputs.gauges = Some(vector("outputs.gauges", scene.path("missing.csv")));
    let prepared = prepare(&scene.scenario);
    assert_eq!(codes(&prepared), ["missing-file", "empty-file", "not-a-raster", "missing-file", "missing-file"]);
    assert!(prepared.has_errors() && prepared.terrain.is_none() && prepared.setup.is_none());
    assert!(
        prepared.problems[2].cause.as_ref().unwrap().contains("not recognized as a supported file format"),
        "{}",
        prepared.problems[2]
    );
}

#[test]
fn values_that_are_no_numbers_are_counted_and_located() {
    // Beside a nodata value, to declare others would make elevations of it.
    for (no_data, remedy) in [(Some(-9999.0), "write -9999 in their place"), (None, "`gdal_edit.py -a_nodata nan`")] {
        let scene = with_terrain(&Tiff { no_data, ..Tiff::default() }, |c, r| match (c, r) {
            (3, 2) => f32::NAN,
            (5, 7) => f32::INFINITY,
            _ => 1.0,
        });
        let prepared = prepare(&scene.scenario);
        let problem = only(&prepared);
        assert_error(problem, ProblemKind::Input, "not-a-number", "terrain.layers[0].raster");
        assert!(problem.message.contains("2 values") && problem.message.contains("column 4, row 3"), "{problem}");
        assert!(problem.remedy.as_ref().is_some_and(|said| said.contains(remedy)), "{problem}");
        assert_eq!(problem.at, Some(centre_of(3, 2)));
    }
}

#[test]
fn doubtful_elevations_and_several_bands_are_warned_of() {
    let tiff = Tiff { bands: 2, ..Tiff::default() };
    let scene = with_terrain(&tiff, |c, r| if (c, r) == (1, 1) { -800.0 } else { basin_elevation(centre_of(c, r)) });
    let prepared = prepare(&scene.scenario);
    assert_eq!(codes(&prepared), ["several-bands", "doubtful-elevation"]);
    assert!(!prepared.has_errors());
    assert_eq!(prepared.problems[1].at, Some(centre_of(1, 1)));
}

#[test]
fn a_raster_of_nodata_only_or_without_georeference_is_refused() {
    let scene = with_terrain(&Tiff { no_data: Some(0.0), ..Tiff::default() }, |_, _| 0.0f32);
    assert_error(only(&prepare(&scene.scenario)), ProblemKind::Input, "all-nodata", "terrain.layers[0].raster");
    let scene = with_terrain(&Tiff { geo_transform: None, ..Tiff::default() }, |_, _| 0.0f32);
    assert_error(only(&prepare(&scene.scenario)), ProblemKind::Input, "no-georeference", "terrain.layers[0].raster");
}

#[test]
fn no_crs_at_all_is_refused_and_a_named_one_assumed() {
    let mut scene = Scene::sound();
    scene.scenario.crs.value = CrsChoice::FromTerrain;
    let prepared = prepare(&scene.scenario);
    let problem = only(&prepared);
    assert_error(problem, ProblemKind::Input, "no-crs", "terrain.layers[0].raster");
    assert!(problem.remedy.as_ref().unwrap().contains("crs: local"));
    scene.scenario.crs.value = CrsChoice::Named("EPSG:25832".to_string());
    let prepared = prepare(&scene.scenario);
    assert_eq!(codes(&prepared), ["assumed-crs", "assumed-crs"]);
    assert!(
        matches!(&prepared.scene().crs, OutputCrs::Projected { authority: Some(code), .. } if code == "EPSG:25832")
    );
}

#[test]
fn an_unknown_crs_and_one_in_degrees_are_faults_of_the_scenario() {
    let mut scene = Scene::sound();
    scene.scenario.crs.value = CrsChoice::Named("EPSG:999999".to_string());
    assert_error(only(&prepare(&scene.scenario)), ProblemKind::Scenario, "unknown-crs", "crs");
    scene.scenario.crs.value = CrsChoice::Named("EPSG:4326".to_string());
    assert_error(only(&prepare(&scene.scenario)), ProblemKind::Scenario, "geographic-crs", "crs");
}

#[test]
fn two_layers_of_different_crs_are_refused_unless_reprojected() {
    let mut scene = Scene::sound();
    let metres = Tiff {
        geo_transform: Some([500_000.0, 20.0, 0.0, 5_000_000.0, 0.0, -20.0]),
        crs: Some("EPSG:25832"),
        no_data: Some(-1.0),
        ..Tiff::default()
    };
    metres.write(&scene.path("a.tif"), |_, _| 5.0f32);
    // The same place in the neighbouring zone: about 45.15° N, 9° E.
    let other =
        Tiff { geo_transform: Some([27_400.0, 20.0, 0.0, 5_016_000.0, 0.0, -20.0]), crs: Some("EPSG:25833"), ..metres };
    other.write(&scene.path("b.tif"), |_, _| 6.0f32);
    scene.scenario.crs.value = CrsChoice::FromTerrain;
    scene.scenario.layers = vec![
        sourced("terrain.layers[0].raster", raster_layer(scene.path("a.tif"))),
        sourced("terrain.layers[1].raster", raster_layer(scene.path("b.tif"))),
    ];
    scene.scenario.initial.clear();
    scene.scenario.outputs.gauges = None;
    scene.scenario.resolution.value = 20.0;
    let prepared = prepare(&scene.scenario);
    let problem = only(&prepared);
    assert_error(problem, ProblemKind::Input, "different-crs", "terrain.layers[1].raster");
    assert!(problem.message.contains("EPSG:25833") && problem.message.contains("EPSG:25832"), "{problem}");
    scene.scenario.reproject = true;
    let prepared = prepare(&scene.scenario);
    assert_eq!(prepared.problems, []);
    assert_eq!(prepared.terrain.unwrap().layers().len(), 2);
}

#[test]
fn layers_that_lie_metres_apart_where_they_overlap_are_warned_of() {
    let mut scene = Scene::sound();
    Tiff { no_data: Some(-9999.0), ..Tiff::default() }
        .write(&scene.path("b.tif"), |c, r| if c < 20 { -9999.0 } else { basin_elevation(centre_of(c, r)) + 1.8 });
    scene.scenario.layers.push(sourced("terrain.layers[1].raster", raster_layer(scene.path("b.tif"))));
    let prepared = prepare(&scene.scenario);
    let problem = only(&prepared);
    assert_eq!(
        (problem.severity, problem.code, problem.key.as_str()),
        (Severity::Warning, "layers-apart", "terrain.layers[1].raster")
    );
    assert!(problem.message.contains("1.80 m above"), "{problem}");
}

#[test]
fn terrain_in_degrees_is_refused_with_the_utm_zone_and_warped_when_asked_for() {
    // 0.1° by 0.075° around 9.05° E, 45.1° N, a plane that rises to the east by 1 m for each 0.001°.
    let degrees = Tiff {
        geo_transform: Some([9.0, 0.0025, 0.0, 45.15, 0.0, -0.0025]),
        crs: Some("EPSG:4326"),
        no_data: Some(-9999.0),
        ..Tiff::default()
    };
    let mut scene = with_terrain(&degrees, |c, _| 2.5 * (c as f32 + 0.5));
    scene.scenario.crs.value = CrsChoice::FromTerrain;
    scene.scenario.initial.clear();
    scene.scenario.outputs.gauges = None;
    scene.scenario.resolution.value = 50.0;
    let prepared = prepare(&scene.scenario);
    let problem = only(&prepared);
    assert_error(problem, ProblemKind::Input, "geographic-crs", "terrain.layers[0].raster");
    assert!(problem.remedy.as_ref().unwrap().contains("crs: EPSG:32632"), "{problem}");
    scene.scenario.reproject = true;
    scene.scenario.crs.value = CrsChoice::Named("EPSG:32632".to_string());
    let prepared = prepare(&scene.scenario);
    assert_eq!(codes(&prepared), ["finer-than-terrain"]);
    let mut place = [Vec2::new(9.05, 45.1)];
    let crs = |code| crate::geodata::spatial_ref(code).unwrap();
    crate::geodata::transform(&mut place, &crs("EPSG:4326"), &crs("EPSG:32632")).unwrap();
    let terrain = prepared.terrain.as_ref().unwrap();
    // 0.05° are 50 m of the plane; half a cell of round-off of the bilinear warp would be 1.25 m.
    assert!((terrain.elevation(place[0]).unwrap() - 50.0).abs() < 0.1);
    let lattice = &prepared.scene().lattice;
    assert!(lattice.origin.x.rem_euclid(50.0) == 0.0 && lattice.origin.y.rem_euclid(50.0) == 0.0);
}

#[test]
fn limits_are_kept_before_anything_is_allocated() {
    let mut scene = Scene::sound();
    scene.scenario.resolution.value = 1e-4;
    let prepared = prepare(&scene.scenario);
    let problem = &prepared.problems[0];
    assert_error(problem, ProblemKind::Limit, "memory-limit", "resolution");
    assert!(problem.remedy.as_ref().unwrap().contains("0.056 m or more"), "{problem}"); // √(30 000 m² · 400 B / 3.915 GB)
    scene.scenario.resolution.value = 5.0;
    scene.scenario.limits.particles = 1000.0;
    assert_error(only(&prepare(&scene.scenario)), ProblemKind::Limit, "particle-limit", "resolution");
    scene.scenario.limits.memory = 1000.0;
    assert_error(only(&prepare(&scene.scenario)), ProblemKind::Limit, "memory-limit", "terrain.layers[0].raster");
}

#[test]
fn impossible_and_coarse_resolutions_are_refused() {
    for resolution in [0.0, -5.0, f64::NAN, f64::INFINITY] {
        let mut scene = Scene::sound();
        scene.scenario.resolution.value = resolution;
        assert_error(&prepare(&scene.scenario).problems[0], ProblemKind::Scenario, "bad-resolution", "resolution");
    }
    let mut scene = Scene::sound();
    scene.scenario.resolution.value = 500.0;
    assert_error(only(&prepare(&scene.scenario)), ProblemKind::Scenario, "resolution-too-coarse", "resolution");
    scene.scenario.resolution.value = 20.0;
    assert!(codes(&prepare(&scene.scenario)).contains(&"resolution-too-coarse"));
    scene.scenario.resolution.value = 1.0;
    assert!(codes(&prepare(&scene.scenario)).contains(&"finer-than-terrain"));
}

#[test]
fn lines_outside_the_terrain_and_files_without_lines_are_refused() {
    let mut scene = Scene::sound();
    scene.line("dam.geojson", &[(9100.0, 2060.0), (9100.0, 2085.0)]);
    scene.scenario.walls = vec![vector("structures.walls[0].lines", scene.path("dam.geojson"))];
    assert_error(only(&prepare(&scene.scenario)), ProblemKind::Input, "outside-terrain", "structures.walls[0].lines");
    scene.write("dam.geojson", r#"{"type":"FeatureCollection","features":[]}"#);
    assert_error(only(&prepare(&scene.scenario)), ProblemKind::Input, "no-lines", "structures.walls[0].lines");
}

#[test]
fn open_edges_come_from_sides_and_lines_and_a_line_that_opens_nothing_is_told() {
    let mut scene = Scene::sound();
    scene.line("sea.geojson", &[(1200.0, 2020.0), (1200.0, 2060.0)]);
    scene.scenario.open = vec![
        OpenBoundary::Side(Side::West),
        OpenBoundary::Lines(vector("boundaries.open[1]", scene.path("sea.geojson"))),
    ];
    let prepared = prepare(&scene.scenario);
    assert_eq!(prepared.problems, []);
    assert_eq!((prepared.scene().open_edges.pieces.len(), prepared.scene().open_edges.reach), (2, 7.5));
    scene.line("sea.geojson", &[(1150.0, 2020.0), (1150.0, 2060.0)]);
    assert_eq!(only(&prepare(&scene.scenario)).code, "opens-nothing");
    scene.scenario.open = vec![OpenBoundary::Side(Side::All)];
    assert!(prepare(&scene.scenario).scene().open_edges.outline.is_some());
}

#[test]
fn gauges_off_the_terrain_are_warned_of_and_bad_tables_located() {
    let scene = Scene::sound();
    scene.write("gauges.csv", "id;x;y\nA;1075;2075\nB;100;100\n");
    let prepared = prepare(&scene.scenario);
    assert_eq!((only(&prepared).code, only(&prepared).at), ("gauge-outside-terrain", Some(Vec2::new(100.0, 100.0))));
    scene.write("gauges.csv", "id,x,y\nA,1075,north\n");
    let problem = prepare(&scene.scenario).problems.remove(0);
    assert_error(&problem, ProblemKind::Input, "bad-gauge-line", "outputs.gauges");
    assert!(problem.message.contains("line 2"));
    scene.write("gauges.csv", "id,lon,lat\nA,1,2\n");
    assert_error(only(&prepare(&scene.scenario)), ProblemKind::Input, "missing-column", "outputs.gauges");
    scene.write("gauges.csv", "id,x,y\nA,1075,2075\nA,1076,2075\n");
    assert_error(only(&prepare(&scene.scenario)), ProblemKind::Input, "duplicate-gauge", "outputs.gauges");
    let hole = |c: usize, r: usize| if (c, r) == (30, 15) { -9999.0 } else { basin_elevation(centre_of(c, r)) };
    let mut scene = with_terrain(&Tiff { no_data: Some(-9999.0), ..Tiff::default() }, hole);
    scene.scenario.ground.gaps = Some(sourced("terrain.gaps", Gaps::Wall));
    scene.write("gauges.csv", "id,x,y\nA,1152.5,2072.5\n");
    assert_eq!(only(&prepare(&scene.scenario)).code, "gauge-on-nodata");
}

#[test]
fn survey_points_are_terrain_with_their_gaps_reported() {
    let mut scene = Scene::sound();
    let lines: Vec<String> = (0..1200)
        .map(|i| (centre_of(i % 40, i / 40), i))
        .map(|(p, _)| format!("{} {} {}", p.x, p.y, basin_elevation(p)))
        .collect();
    scene.write("survey.txt", &lines.join("\n"));
    for interpolation in [PointInterpolation::InverseDistance, PointInterpolation::NaturalNeighbour] {
        let layer = TerrainLayer::Points {
            path: scene.path("survey.txt"),
            interpolation,
            max_gap: 10.0,
            offset: 100.0,
            clip: None,
            mode: LayerMode::default(),
        };
        scene.scenario.layers = vec![sourced("terrain.layers[0].points", layer)];
        scene.scenario.initial[0].level = Some(sourced("initial[0].level", 105.0));
        let prepared = prepare(&scene.scenario);
        assert_eq!(prepared.problems, []);
        // Lattice cells count from zero here: their centres are the survey points themselves.
        let gap = prepared.setup().gap.unwrap();
        assert!(gap.largest < 1e-9, "{gap:?}");
        assert_eq!(prepared.scene().needs.wet_cells, 100);
        assert_eq!(prepared.terrain.unwrap().elevation(Vec2::new(1052.5, 2052.5)), Some(100.0));
    }
    scene.write("survey.txt", "1 2 3\n4 5 6\n");
    assert_error(only(&prepare(&scene.scenario)), ProblemKind::Input, "no-surface", "terrain.layers[0].points");
}
