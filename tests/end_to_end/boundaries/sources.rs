//! Sources of places and lines.

use super::*;

#[test]
fn a_line_of_springs_gives_its_hydrograph() {
    let line = "sources: [{line: toe.geojson, discharge: {series: q.csv, column: q, unit: m3/s, time_unit: min}}]\n";
    let scene = Scene::with(&[("resolution: 5 m", &format!("{line}resolution: 5 m"))]);
    // Askew across the valley, all of it on the terrain: at x 1100 to 1120.
    scene.line("toe.geojson", &[(1100.0, 2000.0), (1120.0, 2060.0)], "toe");
    let (run, out) = scene.run();
    assert!((volume(&run, "in") / 1560.0 - 1.0).abs() < 1e-9, "{} m3", volume(&run, "in"));
    assert!(volume(&run, "error_relative").abs() < 1e-9);
    let wet = Netcdf::read(&out.join("maps.nc")).values("max_depth").iter().filter(|depth| **depth > 0.0).count();
    assert!(wet > 200, "{wet} cells");
    let text = std::fs::read_to_string(scene.path("s.yaml")).unwrap();
    scene.write("s.yaml", &text.replace("resolution: 5 m", "numerics: {motion: lagrangian}\nresolution: 5 m"));
    std::fs::remove_dir_all(&out).unwrap();
    let (run, out) = scene.run();
    assert!((volume(&run, "in") / 1560.0 - 1.0).abs() < 1e-9, "{} m3", volume(&run, "in"));
    assert!(volume(&run, "error_relative").abs() < 1e-12 && volume(&run, "out") > 100.0);
    let rows = table(&out.join("tables/boundaries.csv"));
    let line = rows.iter().find(|row| row[0] == "sources[0] feature 1").unwrap();
    assert!(line[3] == "780.000" && line[1] == line[3] && line[4].parse::<f64>().unwrap() < 1e-9, "{line:?}");
    scene.write("s.yaml", &text);
    scene.line("toe.geojson", &[(1100.0, 2050.0), (1100.0, 2090.0)], "toe");
    scene.assert_refused(4, &["source-outside", "30.0 m of this line lie outside the terrain", "1100.0, 2075.0"]);
    scene.write("toe.geojson", r#"{"type":"FeatureCollection","features":[]}"#);
    scene.assert_refused(4, &["no-lines", "draw lines along which"]);
    scene.line("toe.geojson", &[(1100.0, 2005.0), (1100.0, 2055.0)], "toe");
    let house = r#"{"type":"Polygon","coordinates":[[[1090,2020],[1110,2020],[1110,2030],[1090,2030],[1090,2020]]]}"#;
    scene.write("house.geojson", &format!(r#"{{"type":"Feature","properties":{{}},"geometry":{house}}}"#));
    let text = std::fs::read_to_string(scene.path("s.yaml")).unwrap();
    scene.write("s.yaml", &(text + "structures: {buildings: {polygons: house.geojson}}\n"));
    scene.assert_refused(
        4,
        &[
            "source-outside",
            "10.0 m of this line lie where the terrain has no data or a building blocks it",
            "1102.5, 2022.5",
        ],
    );
}

#[test]
fn sources_on_the_edges_of_the_terrain_lie_on_it() {
    let places = ["[1000, 2030]", "[1200, 2030]", "[1100, 2000]", "[1100, 2060]", "[1200, 2060]"];
    let points = places.map(|place| format!("{{at: {place}, discharge: 1 m3/s}}")).join(", ");
    let sources = format!("sources: [{points}, {{line: toe.geojson, discharge: 1 m3/s}}]\nresolution: 5 m");
    let scene = Scene::with(&[("resolution: 5 m", &sources)]);
    let corners = [(1000.0, 2000.0), (1200.0, 2000.0), (1200.0, 2060.0), (1000.0, 2060.0), (1000.0, 2000.0)];
    for (edge, side) in corners.windows(2).enumerate() {
        scene.line("toe.geojson", side, "toe");
        let check = floodsim(scene.folder.path(), &["check", "s.yaml"]);
        assert!(check.code == 0 && !check.stdout.contains("source-outside"), "edge {edge}: {}", check.stdout);
    }
    scene.line("toe.geojson", &corners, "toe");
    let (run, out) = scene.run();
    let rows = table(&out.join("tables/boundaries.csv"));
    let given: Vec<&[String]> = rows.iter().filter(|row| row[0].contains("source")).map(|row| &row[1..4]).collect();
    assert_eq!(given.len(), 6);
    assert!(given.iter().all(|row| row[0] == "120.000" && row[2] == "120.000"), "{given:?}, {run:#}");
    // The edge of a hole in the data is one, too.
    let text = std::fs::read_to_string(scene.path("dem.asc")).unwrap();
    let cut = |line: &str| {
        let mut values: Vec<&str> = line.split(' ').collect();
        values[30..39].fill("-9999");
        values.join(" ")
    };
    let rows =
        text.lines().enumerate().map(|(k, line)| format!("{}\n", if k < 6 { line.to_owned() } else { cut(line) }));
    scene.write("dem.asc", &rows.collect::<String>());
    scene.write("s.yaml", &std::fs::read_to_string(scene.path("s.yaml")).unwrap().replace("1200, ", "1150, "));
    scene.line("toe.geojson", &[(1150.0, 2010.0), (1150.0, 2050.0)], "toe");
    scene.assert_silent_on(&["source-outside"]);
    scene.line("toe.geojson", &[(1150.1, 2010.0), (1150.1, 2050.0)], "toe");
    scene.assert_refused(4, &["source-outside", "40.0 m of this line lie where the terrain has no data"]);
}

#[test]
fn the_parts_of_a_feature_share_its_discharge() {
    let scene =
        Scene::with(&[("resolution: 5 m", "sources: [{line: toe.geojson, discharge: 3 m3/s}]\nresolution: 5 m")]);
    let parts = "[[[1050,2010],[1050,2030]],[[1060,2010],[1060,2020]]]";
    let whole = "[[1080,2010],[1080,2030]]";
    let feature = |kind: &str, coordinates: &str| {
        format!(r#"{{"type":"Feature","properties":{{}},"geometry":{{"type":"{kind}","coordinates":{coordinates}}}}}"#)
    };
    let file = |features: &[String]| format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, features.join(","));
    scene.write("toe.geojson", &file(&[feature("MultiLineString", parts)]));
    scene.assert_silent_on(&["several-lines"]);
    let rows = |(_, out): (serde_json::Value, PathBuf)| {
        let rows = table(&out.join("tables/boundaries.csv"));
        let sources = rows.into_iter().filter(|row| row[0].starts_with("sources"));
        sources.map(|row| (row[0].clone(), row[1].parse::<f64>().unwrap())).collect::<Vec<_>>()
    };
    // 3 m3/s for 2 min, whatever the number of parts.
    let found = rows(scene.run());
    assert!(found.len() == 1 && found[0].0 == "sources[0] feature 1" && (found[0].1 - 360.0).abs() < 1e-3, "{found:?}");
    std::fs::remove_dir_all(scene.path("out")).unwrap();
    scene.write("toe.geojson", &file(&[feature("MultiLineString", parts), feature("LineString", whole)]));
    scene.assert_warned(&["warning[several-lines] sources[0]", "2 lines of 3 m3/s each: 6 m3/s", "remedy"]);
    let found = rows(scene.run());
    assert!(found.len() == 2 && found[1].0 == "sources[0] feature 2", "{found:?}");
    assert!(found.iter().all(|(_, volume)| (volume - 360.0).abs() < 1e-3), "{found:?}");
}
