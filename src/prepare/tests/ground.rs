//! Layers, holes, breaklines and buildings on the basin of the scene: what they make of the bed, and all in which they may not fit.

#![expect(clippy::float_cmp, reason = "made values are met exactly")]

use super::scene::{Scene, Tiff, basin_elevation, centre_of, raster_layer, sourced, vector};
use crate::error::{Problem, Severity};
use crate::math::Vec2;
use crate::prepare::{Prepared, prepare};
use crate::scenario::methods::Formulation;
use crate::scenario::{
    Breakline, BreaklineMode, BuildingMode, Buildings, Gaps, LayerMode, LineLevel, OpenBoundary, PointInterpolation,
    Side, TerrainLayer,
};
use crate::solver::edge_faces;

/// The bed at a place; NaN without terrain.
fn bed_at(prepared: &Prepared, x: f64, y: f64) -> f64 {
    let bed = &prepared.setup().bed;
    bed.elevation[bed.lattice.cell_at(bed.lattice.to_local(Vec2::new(x, y))).unwrap()]
}

/// The cells of the bed that are not as in the sound scene, with their elevation.
fn changed(prepared: &Prepared) -> Vec<(usize, f64)> {
    let bed = &prepared.setup().bed;
    let sound = |cell: usize| basin_elevation(bed.lattice.to_map(bed.lattice.centre(cell)));
    (0..bed.elevation.len()).filter(|&c| bed.elevation[c] != sound(c)).map(|c| (c, bed.elevation[c])).collect()
}

fn line(scene: &Scene, mode: BreaklineMode, level: LineLevel) -> Breakline {
    Breakline { lines: vector("terrain.breaklines[0].lines", scene.path("line.geojson")), mode, level, width: None }
}

fn constant(level: f64) -> LineLevel {
    LineLevel::Constant(sourced("terrain.breaklines[0].z", level))
}

fn buildings(scene: &mut Scene, mode: BuildingMode) {
    let polygons = vector("structures.buildings.polygons", scene.path("buildings.geojson"));
    scene.scenario.ground.buildings = Some(Buildings { polygons, mode });
}

fn errors(prepared: &Prepared) -> Vec<&Problem> {
    prepared.problems.iter().filter(|problem| problem.severity == Severity::Error).collect()
}

/// A second layer over the whole terrain, higher by 100 m or so.
fn second_layer(scene: &mut Scene, clip: Option<&str>, mode: LayerMode) {
    Tiff { no_data: Some(-9999.0), ..Tiff::default() }
        .write(&scene.path("over.tif"), |c, r| basin_elevation(centre_of(c, r)) + 100.0 + c as f64);
    let mut layer = raster_layer(scene.path("over.tif"));
    if let TerrainLayer::Raster { clip: own_clip, mode: own_mode, offset, .. } = &mut layer {
        *own_clip = clip.map(|name| vector("terrain.layers[1].clip", scene.path(name)));
        (*own_mode, *offset) = (mode, -0.25);
    }
    scene.scenario.layers.push(sourced("terrain.layers[1].raster", layer));
}

#[test]
fn a_clipped_layer_counts_inside_its_polygons_and_its_offset_is_added() {
    let mut scene = Scene::sound();
    scene.scenario.initial.clear();
    // The last three columns and rows 2 to 4 from the south, and a triangle far from there whose centre of mass no cell has.
    scene.polygon("clip.geojson", &[(1186.0, 2010.0), (1300.0, 2010.0), (1300.0, 2025.0), (1186.0, 2025.0)]);
    second_layer(&mut scene, Some("clip.geojson"), LayerMode::Replace);
    let prepared = prepare(&scene.scenario);
    assert_eq!(errors(&prepared), Vec::<&Problem>::new());
    let expected: Vec<(usize, f64)> =
        (2..5).flat_map(|row| (37..40).map(move |c| (row * 40 + c, 20.0 + 100.0 + c as f64 - 0.25))).collect();
    assert_eq!(changed(&prepared), expected);
    assert!(prepared.inputs.iter().any(|input| input.path.ends_with("clip.geojson")));
    scene.polygon("clip.geojson", &[(5000.0, 2010.0), (5100.0, 2010.0), (5100.0, 2025.0)]);
    let prepared = prepare(&scene.scenario);
    let found = errors(&prepared);
    assert_eq!(
        (found.len(), found[0].code, found[0].key.as_str()),
        (1, "clip-outside-layer", "terrain.layers[1].clip")
    );
}

#[test]
fn a_clipped_survey_counts_inside_its_polygons() {
    for interpolation in [PointInterpolation::InverseDistance, PointInterpolation::NaturalNeighbour] {
        let mut scene = Scene::sound();
        scene.scenario.initial.clear();
        // The last three columns and rows 2 to 4 from the south, as in the test of a clipped raster.
        scene.polygon("clip.geojson", &[(1186.0, 2010.0), (1300.0, 2010.0), (1300.0, 2025.0), (1186.0, 2025.0)]);
        let points = (0..1200).map(|i| centre_of(i % 40, i / 40));
        let lines: Vec<String> = points.map(|p| format!("{} {} {}", p.x, p.y, basin_elevation(p) + 2.5)).collect();
        scene.write("survey.txt", &lines.join("\n"));
        let layer = TerrainLayer::Points {
            path: scene.path("survey.txt"),
            interpolation,
            max_gap: 10.0,
            offset: 0.5,
            clip: Some(vector("terrain.layers[1].clip", scene.path("clip.geojson"))),
            mode: LayerMode::Replace,
        };
        scene.scenario.layers.push(sourced("terrain.layers[1].points", layer));
        let prepared = prepare(&scene.scenario);
        assert_eq!(errors(&prepared), Vec::<&Problem>::new());
        let inside: Vec<(usize, f64)> = (2..5).flat_map(|row| (37..40).map(move |c| (row * 40 + c, 23.0))).collect();
        assert_eq!(changed(&prepared), inside, "{interpolation:?}");
        assert!(prepared.inputs.iter().any(|input| input.path.ends_with("clip.geojson")));

        scene.polygon("clip.geojson", &[(5000.0, 2010.0), (5100.0, 2010.0), (5100.0, 2025.0)]);
        let prepared = prepare(&scene.scenario);
        let found: Vec<_> = errors(&prepared).iter().map(|problem| (problem.code, problem.key.as_str())).collect();
        assert_eq!(found, [("clip-outside-layer", "terrain.layers[1].clip")]);
    }
}

#[test]
fn the_lower_or_higher_layer_counts_without_a_warning_that_they_lie_apart() {
    for (mode, cells) in [(LayerMode::Min, 0), (LayerMode::Max, 1200)] {
        let mut scene = Scene::sound();
        scene.scenario.initial.clear();
        second_layer(&mut scene, None, mode);
        let prepared = prepare(&scene.scenario);
        assert_eq!(prepared.problems, [], "{mode:?}");
        assert_eq!(changed(&prepared).len(), cells, "{mode:?}");
    }
}

/// A scene with a hole of one cell and one of three on the plateau, and a corner without data.
fn holes(gaps: Option<Gaps>) -> Scene {
    let mut scene = Scene::sound();
    let is_hole = |c: usize, r: usize| [(30, 20), (5, 5), (6, 5), (7, 6)].contains(&(c, r)) || c + r < 3;
    Tiff { no_data: Some(-9999.0), ..Tiff::default() }
        .write(&scene.path("dem.tif"), |c, r| if is_hole(c, r) { -9999.0 } else { basin_elevation(centre_of(c, r)) });
    scene.scenario.ground.gaps = gaps.map(|gaps| sourced("terrain.gaps", gaps));
    scene
}

#[test]
fn holes_are_walls_refused_or_filled() {
    for (gaps, reported) in [(None, &["terrain-gaps"][..]), (Some(Gaps::Wall), &[])] {
        let prepared = prepare(&holes(gaps).scenario);
        let codes: Vec<&str> = prepared.problems.iter().map(|problem| problem.code).collect();
        assert_eq!((codes.as_slice(), prepared.has_errors()), (reported, false));
        assert_eq!(prepared.scene().needs.bed_particles, 1200 - 4 - 6);
    }
    for (gaps, code) in [(Gaps::Refuse, "terrain-gaps"), (Gaps::Fill { max_cells: 2 }, "gap-too-large")] {
        let prepared = prepare(&holes(Some(gaps)).scenario);
        let found = errors(&prepared);
        assert_eq!((found.len(), found[0].code, found[0].key.as_str()), (1, code, "terrain.gaps"));
        assert!(found[0].message.contains("3 cells (75 m²)") && found[0].remedy.is_some(), "{}", found[0]);
        assert_eq!(found[0].at, Some(centre_of(5, 5)));
    }
    let mut scene = holes(Some(Gaps::Fill { max_cells: 3 }));
    scene.write("gauges.csv", "id,x,y\nin the hole,1152.5,2047.5\n");
    scene.scenario.initial.clear();
    let prepared = prepare(&scene.scenario);
    assert_eq!(prepared.problems.iter().map(|problem| problem.code).collect::<Vec<_>>(), ["gaps-filled"]);
    assert!((bed_at(&prepared, 1152.5, 2047.5) - 20.0).abs() < 1e-12);
    assert_eq!(prepared.scene().needs.bed_particles, 1200 - 6);
}

#[test]
fn a_raised_line_stands_on_the_bed_and_holds_the_lake() {
    let mut scene = Scene::sound();
    // A diagonal through the corners of cells, across the basin.
    scene.lines_with("line.geojson", &[(&[(1045.0, 2045.0), (1105.0, 2105.0)], r#"{"crest_m": 9.5}"#)]);
    scene.polygon("reservoir.geojson", &[(1046.0, 2046.0), (1104.0, 2104.0), (1046.0, 2104.0)]);
    scene.scenario.ground.breaklines = vec![line(&scene, BreaklineMode::Raise, LineLevel::Field("crest_m".to_owned()))];
    let prepared = prepare(&scene.scenario);
    assert_eq!(prepared.problems, [], "no leak over the rim that lies on the line");
    // Ten cells on the diagonal, nine that join them at their corners.
    assert_eq!(changed(&prepared).iter().filter(|(_, z)| *z == 9.5).count(), 19);
    let (bed, water) = (&prepared.setup().bed, &prepared.setup().still_water);
    for (cell, depth) in water.depth.iter().enumerate().filter(|(_, depth)| **depth > 0.0) {
        let centre = bed.lattice.centre(cell);
        assert!(centre.y > centre.x, "water beyond the line at {centre:?}");
        assert!((bed.elevation[cell] + depth - 5.0).abs() < 1e-12);
    }
    assert!(prepared.inputs.iter().any(|input| input.path.ends_with("line.geojson")));
}

#[test]
fn a_carved_line_lowers_what_lies_higher_and_its_width_counts() {
    let mut scene = Scene::sound();
    scene.line("line.geojson", &[(1102.0, 2052.5), (1160.0, 2052.5)]);
    scene.scenario.initial.clear();
    for (width, rows) in [(None, 1), (Some(3.0), 1), (Some(11.0), 3)] {
        let carved = Breakline { width, ..line(&scene, BreaklineMode::Carve, constant(3.0)) };
        scene.scenario.ground.breaklines = vec![carved];
        let prepared = prepare(&scene.scenario);
        assert_eq!(prepared.problems, []);
        let found = changed(&prepared);
        assert!(found.iter().all(|&(_, z)| z == 3.0));
        let rows_found: std::collections::BTreeSet<usize> = found.iter().map(|(cell, _)| cell / 40).collect();
        assert_eq!(rows_found.len(), rows, "{width:?}");
    }
}

#[test]
fn levels_come_from_the_third_coordinate_too_and_are_linear_between_vertices() {
    let mut scene = Scene::sound();
    scene.scenario.initial.clear();
    scene.line_with_heights("line.geojson", &[(1052.5, 2072.5, 4.0), (1092.5, 2072.5, 12.0)]);
    scene.scenario.ground.breaklines = vec![line(&scene, BreaklineMode::Raise, LineLevel::Vertices)];
    let prepared = prepare(&scene.scenario);
    assert_eq!(prepared.problems, []);
    for (x, z) in [(1052.5, 4.0), (1062.5, 6.0), (1092.5, 12.0), (1097.5, 0.0)] {
        assert!((bed_at(&prepared, x, 2072.5) - z).abs() < 1e-12, "{x}");
    }
}

#[test]
fn no_water_gets_into_a_blocked_building_and_no_boundary_opens_it() {
    let mut scene = Scene::sound();
    scene.polygon("buildings.geojson", &[(1060.0, 2060.0), (1070.0, 2060.0), (1070.0, 2075.0), (1060.0, 2075.0)]);
    buildings(&mut scene, BuildingMode::Block);
    scene.scenario.open = vec![OpenBoundary::Side(Side::All)];
    let prepared = prepare(&scene.scenario);
    assert_eq!(prepared.problems, [], "a building in the reservoir is no hole in the terrain");
    assert!(bed_at(&prepared, 1062.5, 2062.5).is_nan() && bed_at(&prepared, 1067.5, 2072.5).is_nan());
    let without = changed(&prepared).iter().filter(|(_, z)| z.is_nan()).count();
    assert_eq!((without, prepared.scene().needs.wet_cells), (6, 94));
    let bed = prepared.setup.unwrap().bed;
    assert_eq!(bed.sealed.len(), 6);
    let faces = edge_faces(&bed.lattice, &bed.elevation);
    let sealed = faces.iter().filter(|face| bed.is_sealed(face.middle)).count();
    assert_eq!((sealed, faces.len()), (10, 10 + 2 * (40 + 30)));
}

#[test]
fn the_water_of_a_lake_is_that_beside_its_blocked_buildings() {
    let volume = |is_built: bool| {
        let mut scene = Scene::sound();
        scene.polygon("buildings.geojson", &[(1060.0, 2060.0), (1070.0, 2060.0), (1070.0, 2075.0), (1060.0, 2075.0)]);
        if is_built {
            buildings(&mut scene, BuildingMode::Block);
        }
        prepare(&scene.scenario).setup.unwrap().still_water.volumes.swap_remove(0)
    };
    let (open, built) = (volume(false), volume(true));
    // 150 m² in a lake of 5 m.
    assert!((open.integral_m3 - built.integral_m3 - 750.0).abs() < 1e-6, "{open:?} {built:?}");
    assert!(built.relative_error().abs() <= open.relative_error().abs() + 1e-9, "{open:?} {built:?}");
}

#[test]
fn a_building_whose_cells_do_not_hang_together_is_told() {
    let oblique = |width: f64| [(1057.0, 2056.0), (1095.0, 2070.0), (1095.0, 2070.0 + width), (1057.0, 2056.0 + width)];
    for (width, is_told) in [(1.5, true), (6.0, false)] {
        let mut scene = Scene::sound();
        scene.polygon("buildings.geojson", &oblique(width));
        buildings(&mut scene, BuildingMode::Raise { height: Some(3.0), field: None });
        let codes: Vec<&str> = prepare(&scene.scenario).problems.iter().map(|problem| problem.code).collect();
        assert_eq!(codes.contains(&"building-too-narrow"), is_told, "{width} m: {codes:?}");
        scene.scenario.ground.buildings.as_mut().unwrap().mode = BuildingMode::Block;
        assert_eq!(prepare(&scene.scenario).problems, [], "cells follow a blocked one however narrow");
        scene.scenario.ground.buildings.as_mut().unwrap().mode = BuildingMode::Roughness(Some(0.2));
        assert_eq!(prepare(&scene.scenario).problems, [], "roughness needs no closed row");
    }
}

#[test]
fn buildings_raise_the_bed_or_roughen_it() {
    let footprint = [(1060.0, 2060.0), (1070.0, 2060.0), (1070.0, 2075.0), (1060.0, 2075.0)];
    let by = |height, field: Option<&str>| BuildingMode::Raise { height, field: field.map(str::to_owned) };
    for (mode, z) in [(by(Some(3.0), None), 3.0), (by(None, None), 2.0), (by(None, Some("eaves")), 7.5)] {
        let mut scene = Scene::sound();
        scene.polygon_with("buildings.geojson", &footprint, r#"{"height": 2, "eaves": "7.5"}"#);
        buildings(&mut scene, mode);
        let prepared = prepare(&scene.scenario);
        assert_eq!(prepared.problems, []);
        for (x, y) in [(1062.5, 2062.5), (1067.5, 2072.5)] {
            assert_eq!(bed_at(&prepared, x, y), z);
        }
        let wet = if z < 5.0 { 100 } else { 94 };
        assert_eq!(prepared.scene().needs.wet_cells, wet, "the lake at 5 m covers what is lower");
    }
    for (mode, n) in [(BuildingMode::Roughness(Some(0.4)), 0.4), (BuildingMode::Roughness(None), 0.25)] {
        let mut scene = Scene::sound();
        scene.polygon_with("buildings.geojson", &footprint, r#"{"n": 0.25}"#);
        buildings(&mut scene, mode);
        let prepared = prepare(&scene.scenario);
        assert_eq!(prepared.problems, []);
        assert_eq!(bed_at(&prepared, 1062.5, 2062.5), 0.0);
        let manning = prepared.setup.unwrap().bed.manning;
        assert_eq!((manning.iter().filter(|own| **own == n).count(), manning[0]), (6, 0.03));
    }
}

/// A change that makes the ground unfit, with the code and the key of what is reported.
type Unfit = (&'static str, &'static str, fn(&mut Scene));

fn with_line(scene: &mut Scene, mode: BreaklineMode, level: LineLevel) {
    scene.scenario.ground.breaklines = vec![line(scene, mode, level)];
}
const LINES: &str = "terrain.breaklines[0].lines";
const BUILDINGS: &str = "structures.buildings.polygons";

const UNFIT: [Unfit; 13] = [
    ("missing-file", LINES, |scene| with_line(scene, BreaklineMode::Raise, constant(9.0))),
    ("no-lines", LINES, |scene| {
        scene.write("line.geojson", r#"{"type":"FeatureCollection","features":[]}"#);
        with_line(scene, BreaklineMode::Raise, constant(9.0));
    }),
    ("no-level", LINES, |scene| {
        scene.lines_with("line.geojson", &[(&[(1060.0, 2060.0), (1080.0, 2060.0)], r#"{"crest": 9.0}"#)]);
        with_line(scene, BreaklineMode::Raise, LineLevel::Field("crest_m".to_owned()));
    }),
    ("no-level", LINES, |scene| {
        scene.line("line.geojson", &[(1060.0, 2060.0), (1080.0, 2060.0)]);
        with_line(scene, BreaklineMode::Raise, LineLevel::Vertices);
    }),
    ("crest-below-terrain", "terrain.breaklines[0].z", |scene| {
        scene.line("line.geojson", &[(1060.0, 2060.0), (1080.0, 2060.0)]);
        with_line(scene, BreaklineMode::Raise, constant(-0.1));
    }),
    ("invert-above-terrain", "terrain.breaklines[0].z", |scene| {
        scene.line("line.geojson", &[(1120.0, 2060.0), (1140.0, 2060.0)]);
        with_line(scene, BreaklineMode::Carve, constant(20.5));
    }),
    ("outside-terrain", LINES, |scene| {
        scene.line("line.geojson", &[(5120.0, 2060.0), (5140.0, 2060.0)]);
        with_line(scene, BreaklineMode::Carve, constant(2.0));
    }),
    ("method-combination", LINES, |scene| {
        scene.line("line.geojson", &[(1060.0, 2060.0), (1080.0, 2060.0)]);
        with_line(scene, BreaklineMode::Raise, constant(2.0));
        scene.scenario.ground.breaklines[0].width = Some(24.9);
        scene.scenario.numerics.formulation = Formulation::Variational;
    }),
    ("method-combination", LINES, |scene| {
        scene.line("line.geojson", &[(1060.0, 2060.0), (1080.0, 2060.0)]);
        scene.scenario.ground.followed = vec![line(scene, BreaklineMode::Raise, constant(2.0)).lines];
        scene.scenario.numerics.formulation = Formulation::Variational;
    }),
    ("outside-terrain", BUILDINGS, |scene| {
        scene.polygon("buildings.geojson", &[(5060.0, 2060.0), (5070.0, 2060.0), (5070.0, 2075.0)]);
        buildings(scene, BuildingMode::Block);
    }),
    ("building-value", BUILDINGS, |scene| {
        scene.polygon_with("buildings.geojson", &[(1060.0, 2060.0), (1070.0, 2060.0), (1070.0, 2075.0)], r#"{"h": 3}"#);
        buildings(scene, BuildingMode::Raise { height: None, field: None });
    }),
    ("building-range", BUILDINGS, |scene| {
        scene.polygon_with("buildings.geojson", &[(1060.0, 2060.0), (1070.0, 2060.0), (1070.0, 2075.0)], r#"{"n": 3}"#);
        buildings(scene, BuildingMode::Roughness(None));
    }),
    ("empty-polygon", BUILDINGS, |scene| {
        scene.line("buildings.geojson", &[(1060.0, 2060.0), (1070.0, 2060.0)]);
        buildings(scene, BuildingMode::Block);
    }),
];

#[test]
fn what_does_not_fit_is_refused_at_its_key() {
    for (code, key, change) in UNFIT {
        let mut scene = Scene::sound();
        change(&mut scene);
        let prepared = prepare(&scene.scenario);
        let found = errors(&prepared);
        assert_eq!(found.len(), 1, "{code}: {:#?}", prepared.problems);
        assert_eq!((found[0].code, found[0].key.as_str()), (code, key), "{}", found[0]);
        assert!(found[0].remedy.is_some(), "{}", found[0]);
    }
}

#[test]
fn several_faults_are_reported_at_once() {
    let mut scene = holes(Some(Gaps::Refuse));
    scene.line("line.geojson", &[(1060.0, 2060.0), (1080.0, 2060.0)]);
    with_line(&mut scene, BreaklineMode::Raise, constant(-0.1));
    scene.polygon("buildings.geojson", &[(5060.0, 2060.0), (5070.0, 2060.0), (5070.0, 2075.0)]);
    buildings(&mut scene, BuildingMode::Block);
    scene.scenario.initial[0].level = Some(sourced("initial[0].level", -3.0));
    let prepared = prepare(&scene.scenario);
    let found: Vec<&str> = errors(&prepared).iter().map(|problem| problem.code).collect();
    assert_eq!(found, ["terrain-gaps", "crest-below-terrain", "outside-terrain", "level-below-bed"]);
}

#[test]
fn what_is_only_in_part_unfit_is_a_warning() {
    let mut scene = Scene::sound();
    let ends: [&[(f64, f64)]; 3] = [
        &[(1060.0, 2060.0), (1080.0, 2060.0)],
        &[(1120.0, 2060.0), (1140.0, 2060.0)],
        &[(5120.0, 2060.0), (5140.0, 2060.0)],
    ];
    scene.lines_with("line.geojson", &ends.map(|places| (places, r#"{"z": 12}"#)));
    with_line(&mut scene, BreaklineMode::Raise, LineLevel::Field("z".to_owned()));
    scene.write(
        "buildings.geojson",
        r#"{"type":"FeatureCollection","features":[
        {"type":"Feature","properties":{},"geometry":{"type":"Polygon","coordinates":[[[1120,2060],[1130,2060],[1130,2070],[1120,2060]]]}},
        {"type":"Feature","properties":{},"geometry":{"type":"Polygon","coordinates":[[[1121,2081],[1122,2081],[1122,2082],[1121,2081]]]}}]}"#,
    );
    buildings(&mut scene, BuildingMode::Raise { height: Some(3.0), field: None });
    let prepared = prepare(&scene.scenario);
    assert!(!prepared.has_errors(), "{:#?}", prepared.problems);
    let found: Vec<(&str, &str)> = prepared.problems.iter().map(|p| (p.code, p.key.as_str())).collect();
    assert_eq!(found, [("outside-terrain", LINES), ("crest-below-terrain", LINES), ("building-too-small", BUILDINGS)]);
    assert!(
        prepared.problems[1].message.contains("feature 2") && prepared.problems[1].message.contains("8.00 m below")
    );
}
