//! Still water that the terrain does not hold.

use super::*;

#[test]
fn nodata_inside_the_reservoir_is_refused_with_its_place() {
    let scene = Scene::sound();
    scene.terrain(|column, row| if (column, row) == (15, 15) { -9999.0 } else { elevation(column, row) }.to_string());
    scene.assert_refused(
        4,
        &["error[nodata-in-water] initial[0].reservoir (s.yaml:7:17)", "25 m²", "at      1077.5, 2072.5", "remedy"],
    );
}

#[test]
fn a_reservoir_without_any_terrain_below_is_refused() {
    let scene = Scene::sound();
    scene.terrain(|column, _| if column < 30 { "-9999".to_owned() } else { "3".to_owned() });
    scene.assert_refused(4, &["error[outside-terrain] initial[0].reservoir (s.yaml:7:17)", "remedy"]);
}

#[test]
fn a_reservoir_outside_the_terrain_is_refused() {
    let scene = Scene::sound();
    scene.polygon("[[[9045,2045],[9105,2045],[9105,2105],[9045,2045]]]", "{}");
    scene.assert_refused(
        4,
        &["error[outside-terrain] initial[0].reservoir (s.yaml:7:17)", "at      9045.0, 2045.0", "same CRS"],
    );
}

#[test]
fn a_level_below_the_bed_is_refused_with_the_lowest_bed() {
    Scene::with("5 m}", "-2 m}").assert_refused(
        4,
        &[
            "error[level-below-bed] initial[0].reservoir (s.yaml:7:17)",
            "level of -2 m",
            "lowest bed is 0.00 m",
            "remedy",
        ],
    );
}

#[test]
fn a_self_crossing_polygon_is_refused_where_it_crosses() {
    let scene = Scene::sound();
    scene.polygon("[[[1050,2050],[1100,2100],[1100,2050],[1050,2100],[1050,2050]]]", "{}");
    scene.assert_refused(
        4,
        &["error[self-crossing] initial[0].reservoir (s.yaml:7:17)", "at      1075.0, 2075.0", "remedy"],
    );
}

#[test]
fn polygons_that_are_empty_are_refused() {
    let scene = Scene::sound();
    scene.write("reservoir.geojson", r#"{"type":"FeatureCollection","features":[]}"#);
    scene.assert_refused(4, &["error[empty-polygon] initial[0].reservoir (s.yaml:7:17)", "holds no polygon", "remedy"]);
    scene.polygon("[[[1050,2050],[1100,2050],[1075,2050],[1050,2050]]]", "{}");
    scene.assert_refused(4, &["error[empty-polygon] initial[0].reservoir (s.yaml:7:17)", "has no area", "remedy"]);
    scene.write("reservoir.geojson", "");
    scene.assert_refused(4, &["error[empty-file] initial[0].reservoir (s.yaml:7:17)", "remedy"]);
    scene.write("reservoir.geojson", "not JSON at all");
    scene.assert_refused(4, &["error[not-a-vector] initial[0].reservoir (s.yaml:7:17)"]);
}

#[test]
fn a_polygon_with_a_coordinate_that_is_no_number_is_refused() {
    let scene = Scene::sound();
    scene.polygon("[[[1050,2050],[1100,NaN],[1075,2100],[1050,2050]]]", "{}");
    scene.assert_refused(4, &["initial[0].reservoir (s.yaml:7:17)"]);
}

#[test]
fn water_without_a_level_anywhere_is_refused() {
    let scene = Scene::with(", level: 5 m}", "}");
    scene.polygon(RESERVOIR, r#"{"name": "upper lake"}"#);
    scene.assert_refused(
        4,
        &[
            "error[no-level] initial[0].reservoir (s.yaml:7:17)",
            "looked for level_m, level; its attributes: name",
            "add `level: 100 m`",
        ],
    );
}
