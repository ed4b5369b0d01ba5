//! Boundaries, sources and sections that are refused, each with its place.

use super::*;

#[test]
fn units_are_asked_for_and_checked() {
    let scene = Scene::with(&[("unit: m3/s, time_unit: min", "time_unit: min")]);
    scene.assert_refused(4, &["missing-unit", "the column `q`", "`q_m3_s`", "l/s"]);
    let scene = Scene::sound();
    scene.write("q.csv", "t_h,q\n0,0\n3,4\n");
    scene.assert_refused(4, &["contradicting-units", "the column `t_h`", "another unit than the scenario, `min`"]);
    let scene = Scene::with(&[("column: q", "column: h_cm")]);
    scene.write("q.csv", "t,h_cm\n0,0\n180,4\n");
    scene.assert_refused(4, &["contradicting-units", "the column `h_cm`", "another unit than the scenario, `m3/s`"]);
    let scene = Scene::with(&[("unit: m3/s, time_unit: min", "unit: kg/s, time_unit: m3/s")]);
    scene.assert_refused(3, &["`kg/s` is no unit of a discharge", "`m3/s` is no unit of a time", "s.yaml:6:"]);
    let scene = Scene::with(&[("discharge: {series: q.csv, column: q, unit: m3/s, time_unit: min}", "discharge: 30")]);
    scene.assert_refused(3, &["missing-unit", "`30 m3/s`"]);
}

#[test]
fn kinds_that_exclude_each_other_are_refused_at_once() {
    let scene = Scene::with(&[
        (
            "normal_depth: {slope: 0.04}}",
            "normal_depth: {slope: 0.04}, stage: 3 m}\n  - {side: north}\n  - {side: south, edge: west, type: free}",
        ),
        (
            "time: {end: 2 min}",
            "time: {end: 2 min}\nsources: [{at: [1, 2, 3], discharge: 1 m3/s}]\nrain: {rate: 1 mm/h, raster: a.tif}",
        ),
    ]);
    scene.assert_refused(
        3,
        &[
            "stage and normal_depth exclude each other at one boundary",
            "boundaries[1]",
            "nothing is said of the water beyond this edge",
            "side and edge exclude each other",
            "a place has two coordinates, not 3",
            "rate and raster exclude each other",
        ],
    );
}

#[test]
fn places_that_do_not_fit_are_told_with_their_coordinates() {
    let scene = Scene::sound();
    scene.line("inflow.geojson", &[(5000.0, 2020.0), (5000.0, 2040.0)], "in");
    scene.line("sections.geojson", &[(0.0, 0.0), (10.0, 0.0)], "far");
    scene.assert_refused(
        4,
        &["outside-terrain", "5000.0, 2020.0", "section-outside", "the section `far` lies on no terrain"],
    );
    scene.line("inflow.geojson", &[(1100.0, 2020.0), (1100.0, 2040.0)], "in");
    scene.assert_refused(
        4,
        &["opens-nothing", "touches no edge of the terrain", "water that comes in elsewhere is a source"],
    );
    let both = ("  - {edge: east", "  - {side: west, stage: 3 m}\n  - {edge: east");
    let sources = ("time: {end", "sources: [{at: [900, 2000], discharge: 1 m3/s}]\ntime: {end");
    let scene = Scene::with(&[both, sources]);
    scene.assert_refused(
        4,
        &[
            "overlapping-boundaries",
            "overlaps `boundaries[0]`",
            "boundary-dry",
            "3 m, is not above the lowest ground along it, 10.00 m",
            "source-outside",
            "900.0, 2000.0",
        ],
    );
    let scene = Scene::sound();
    scene.line("inflow.geojson", &[(1000.0, 2052.0), (1000.0, 2060.0)], "in");
    scene.assert_warned(&["lower-ground-beside", "may miss the river bed"]);
    // The ground falls to the east along the sides that begin where this one ends: no bank.
    let scene = Scene::with(&[("{line: inflow.geojson", "{side: west")]);
    let row = (0..40).map(|column| format!("{}", 10.0 - 0.2 * f64::from(column))).collect::<Vec<_>>().join(" ");
    let dem = std::fs::read_to_string(scene.path("dem.asc")).unwrap();
    let header: Vec<&str> = dem.lines().take(6).collect();
    scene.write("dem.asc", &format!("{}\n{}", header.join("\n"), format!("{row}\n").repeat(12)));
    let check = floodsim(scene.folder.path(), &["check", "s.yaml"]);
    assert!(check.code == 0 && !check.stdout.contains("lower-ground-beside"), "{}", check.stdout);
    let scene = Scene::sound();
    scene.line("sections.geojson", &[(1100.0, 2030.0), (1100.0, 2160.0)], "long");
    scene.assert_warned(&["section-outside", "100 m of the section `long` lie on no terrain"]);
}

#[test]
fn a_section_in_a_blocked_building_is_told_to_lie_there() {
    let blocked = "structures: {buildings: {polygons: houses.geojson}}\ntime: {end";
    let scene = Scene::with(&[("time: {end", blocked)]);
    let corners = "[[1080,2015],[1120,2015],[1120,2045],[1080,2045],[1080,2015]]";
    let house =
        format!(r#"{{"type":"Feature","properties":{{}},"geometry":{{"type":"Polygon","coordinates":[{corners}]}}}}"#);
    scene.write("houses.geojson", &house);
    scene.line("sections.geojson", &[(1100.0, 2020.0), (1100.0, 2040.0)], "indoors");
    scene
        .assert_refused(4, &["section-outside", "the section `indoors` lies in a blocked building", "where water can"]);
    // From one bank through the house to the other it measures beside it, and nothing is odd about that.
    scene.line("sections.geojson", &[(1100.0, 2002.0), (1100.0, 2058.0)], "across");
    let check = floodsim(scene.folder.path(), &["check", "s.yaml"]);
    assert!(check.code == 0 && !check.stdout.contains("section-outside"), "{}", check.stdout);
}

#[test]
fn rating_curves_and_roughness_are_checked() {
    let scene = Scene::with(&[("normal_depth: {slope: 0.04}", "rating: {table: weir.csv}")]);
    scene.write("weir.csv", "level_m,discharge_m3_s\n8,1\n9,0.5\n9,3\n");
    scene.assert_refused(
        4,
        &["not-rising", "line 4", "falling-discharge", "line 3", "rating-start", "begins with 1 m3/s"],
    );
    scene.write("weir.csv", "level_m,discharge_m3_s\n8,0\n9,5\n8.5,3\n");
    scene.assert_refused(4, &["not-rising", "line 4", "of a loop with a rising and a falling limb the mean of both"]);
    let scene = Scene::with(&[("manning: 0.03", "manning: 0")]);
    scene.assert_refused(3, &["no-roughness", "boundaries[1].normal_depth.slope"]);
}

#[test]
fn a_boundary_without_a_condition_is_told_once() {
    let motion = "numerics: {motion: lagrangian}\nresolution: 5 m";
    let scene = Scene::with(&[
        ("resolution: 5 m", motion),
        ("{edge: east, normal_depth: {slope: 0.04}}", "{edge: east}"),
        (", sections: sections.geojson", ""),
    ]);
    scene.assert_refused(3, &["boundaries[1]"]);
    scene.assert_silent_on(&["method-combination"]);
}

#[test]
fn a_scenario_without_any_water_is_refused() {
    let scene = Scene::with(&[(
        "  - {line: inflow.geojson, discharge: {series: q.csv, column: q, unit: m3/s, time_unit: min}}\n",
        "",
    )]);
    scene.assert_refused(3, &["the required key `initial` is missing"]);
}
