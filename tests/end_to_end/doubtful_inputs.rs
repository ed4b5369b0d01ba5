//! Inputs that a run could take and a planner would want a word about: a message with its place in the scenario and on the map, its
//! cause and a remedy; and the sound ones beside them, of which nothing is said.

mod files;

use tempfile::TempDir;

use crate::floodsim;

/// A valley from 5 m down to 1 m, from west to east, in a plateau at 20 m, 200 m by 150 m, and a pond in it.
const SCENARIO: &str = "\
floodsim: 1
title: A valley in a plateau
crs: local
terrain: {layers: [{raster: dem.asc}]}
roughness: {manning: 0.03}
initial: [{water: pond.geojson, level: 2.9 m}]
resolution: 5 m
time: {end: 10 min}
boundaries: [{side: all, type: closed}]
";

struct Scene {
    folder: TempDir,
}

impl Scene {
    /// The scenario with further lines, which stand in for those of the same key.
    fn with(lines: &str) -> Scene {
        let scene = Scene { folder: TempDir::new().unwrap() };
        let key = |line: &str| line.split(':').next().unwrap_or_default().to_owned();
        let keys: Vec<String> = lines.lines().map(key).collect();
        let kept: String =
            SCENARIO.lines().filter(|line| !keys.contains(&key(line))).map(|line| format!("{line}\n")).collect();
        scene.write("s.yaml", &format!("{kept}{lines}\n"));
        let value = |column: usize, row: usize| match row {
            10..20 => 5.0 - 4.0 * column as f64 / 39.0,
            _ => 20.0,
        };
        let row = |row: usize| (0..40).map(|column| value(column, row).to_string()).collect::<Vec<_>>().join(" ");
        let rows: Vec<String> = (0..30).map(row).collect();
        let header = "ncols 40\nnrows 30\nxllcorner 1000\nyllcorner 2000\ncellsize 5\nNODATA_value -9999\n";
        scene.write("dem.asc", &format!("{header}{}\n", rows.join("\n")));
        let east = [[1100, 2050], [1200, 2050], [1200, 2100], [1100, 2100], [1100, 2050]];
        scene.features("pond.geojson", &[("Polygon", &format!("[{east:?}]"), "{}")]);
        let across = |x: f64, from: f64, to: f64| format!("[[{x},{from}],[{x},{to}]]");
        for (name, line) in [
            ("inflow", across(1000.0, 2052.0, 2098.0)),
            ("south", across(1200.0, 2050.0, 2075.0)),
            ("north", across(1200.0, 2075.0, 2100.0)),
            ("across", across(1130.0, 2045.0, 2105.0)),
            ("beyond", across(1130.0, 2045.0, 2300.0)),
            ("overshoot", across(1130.0, 2045.0, 2160.0)),
            ("far", across(9130.0, 2045.0, 2105.0)),
            ("edge", across(1200.0, 2045.0, 2400.0)),
        ] {
            scene.features(&format!("{name}.geojson"), &[("LineString", &line, r#"{"crest": -9999}"#)]);
        }
        scene.features("along.geojson", &[("LineString", "[[1000,2075],[1200,2075]]", "{}")]);
        let lines = [across(1130.0, 2045.0, 2105.0), across(9130.0, 2045.0, 2105.0)];
        scene.features("two.geojson", &[("LineString", &lines[0], "{}"), ("LineString", &lines[1], "{}")]);
        let house = "[[[1010,2060],[1030,2060],[1030,2080],[1010,2080],[1010,2060]]]";
        scene.features("house.geojson", &[("Polygon", house, "{}")]);
        scene.features("lock.geojson", &[("LineString", "[[1180,2075],[1210,2075]]", "{}")]);
        let outline = "[[[1199,2052],[1400,2052],[1400,2098],[1199,2098],[1199,2052]]]";
        scene.features("outlet.geojson", &[("Polygon", outline, "{}")]);
        scene.features(
            "mixed.geojson",
            &[("LineString", &across(1130.0, 2045.0, 2105.0), "{}"), ("Point", "[1100,2070]", "{}")],
        );
        scene.features("nan.geojson", &[("LineString", "[[1130,NaN],[1130,2105]]", "{}")]);
        scene.write(
            "uplift.asc",
            &format!("ncols 10\nnrows 2\nxllcorner 1150\nyllcorner 2060\ncellsize 10\n{}", "0.5 ".repeat(20)),
        );
        scene.write("high.csv", "level_m,discharge_m3_s\n101,0\n103,50\n");
        scene.write("shut.csv", "level_m,discharge_m3_s\n1,0\n3,0\n");
        scene.write("weir.csv", "level_m,discharge_m3_s\n1,0\n3,50\n");
        scene
    }

    fn write(&self, name: &str, content: &str) {
        std::fs::write(self.folder.path().join(name), content).unwrap();
    }

    /// Writes a GeoJSON of features, each of a kind, with coordinates and attributes.
    fn features(&self, name: &str, features: &[(&str, &str, &str)]) {
        let feature = |(kind, coordinates, properties): &(&str, &str, &str)| {
            format!(
                r#"{{"type":"Feature","properties":{properties},"geometry":{{"type":"{kind}","coordinates":{coordinates}}}}}"#
            )
        };
        let features: Vec<String> = features.iter().map(feature).collect();
        self.write(name, &format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, features.join(",")));
    }
}

/// Asserts that the check of each scenario says one thing, `error[code] key` or `warning[code] key`, with its place, a cause or a
/// remedy, and all these texts; or nothing at all where none is expected.
#[track_caller]
fn assert_said(cases: &[(&str, &str, &[&str])]) {
    for (lines, expected, texts) in cases {
        let scene = Scene::with(lines);
        let check = floodsim(scene.folder.path(), &["check", "s.yaml"]);
        // The pond ends at an edge that most of these leave shut.
        let heads = check.stdout.lines().filter(|line| line.starts_with("error[") || line.starts_with("warning["));
        let said: Vec<&str> = heads.filter(|line| !line.starts_with("warning[closed-edge] initial[0]")).collect();
        let expected: &[&str] = if expected.is_empty() { &[] } else { &[expected] };
        assert_eq!(said.len(), expected.len(), "{lines}\n{}", check.stdout);
        for (said, expected) in said.iter().zip(expected) {
            assert!(said.starts_with(&format!("{expected} (s.yaml:")), "{lines}\n{}", check.stdout);
            assert!(check.stdout.contains("\n  remedy  "), "{lines}\n{}", check.stdout);
        }
        for text in *texts {
            assert!(check.stdout.contains(text), "{lines}: `{text}` is not in\n{}", check.stdout);
        }
        let code = if expected.iter().any(|said| said.starts_with("error")) { 4 } else { 0 };
        assert_eq!(check.code, code, "{lines}\n{}", check.stdout);
    }
}

#[test]
fn lines_that_leave_the_terrain_are_told_with_the_length_that_does() {
    let length: &[&str] =
        &["150 m of the lines of beyond.geojson lie on no terrain", "at      1130.0, 2150.0", "cause"];
    let wall = "structures: {walls: [{lines: beyond.geojson}]}";
    let levee = "terrain: {layers: [{raster: dem.asc}], breaklines: [{lines: beyond.geojson, mode: raise, z: 21 m}]}";
    let river = "initial: [{river: beyond.geojson, depth: 1 m}]";
    let edge: &[&str] = &["250 m of the lines of edge.geojson lie on no terrain", "opens nothing there"];
    assert_said(&[
        ("", "", &[]),
        (wall, "warning[outside-terrain] structures.walls[0].lines", length),
        (levee, "warning[outside-terrain] terrain.breaklines[0].lines", length),
        (river, "warning[outside-terrain] initial[0].river", length),
        ("boundaries: [{line: edge.geojson, stage: 3.5 m}]", "warning[outside-terrain] boundaries[0].line", edge),
        ("boundaries: [{line: edge.geojson, type: open}]", "warning[outside-terrain] boundaries[0].line", edge),
        // A stroke beyond the edge, and what is drawn around something, is how one draws.
        ("structures: {walls: [{lines: overshoot.geojson}]}", "", &[]),
        (&levee.replace("beyond", "overshoot"), "", &[]),
        ("boundaries: [{line: outlet.geojson, stage: 3.5 m}]", "", &[]),
        ("structures: {walls: [{lines: outlet.geojson}]}", "", &[]),
    ]);
    assert_said(&[
        (&wall.replace("beyond", "far"), "error[outside-terrain] structures.walls[0].lines", &["9130.0, 2045.0"]),
        (&levee.replace("beyond", "far"), "error[outside-terrain] terrain.breaklines[0].lines", &["9130.0, 2045.0"]),
    ]);
}

#[test]
fn a_bed_that_moves_beyond_the_terrain_is_told() {
    let texts: &[&str] = &["50 % of the volume that uplift.asc moves, on 1000 m², lie outside the terrain", "cause"];
    assert_said(&[(
        "moving_bed: [{change: uplift.asc}]",
        "warning[moves-without-terrain] moving_bed[0].change",
        texts,
    )]);
}

#[test]
fn walls_in_a_hole_of_the_terrain_lie_outside_of_it() {
    let scene = Scene::with("structures: {walls: [{lines: across.geojson}]}");
    let holed = std::fs::read_to_string(scene.folder.path().join("dem.asc")).unwrap();
    let rows =
        holed.lines().map(|line| if line.starts_with("20 ") { line.replace("20", "-9999") } else { line.to_owned() });
    scene.write("dem.asc", &rows.collect::<Vec<_>>().join("\n"));
    scene.features("across.geojson", &[("LineString", "[[1130,2010],[1130,2030]]", "{}")]);
    let check = floodsim(scene.folder.path(), &["check", "s.yaml"]);
    assert!(check.stdout.contains("error[outside-terrain] structures.walls[0].lines"), "{}", check.stdout);
}

#[test]
fn boundaries_that_are_hardly_meant_so_are_told() {
    let stages = |north: &str, more: &str| {
        format!("boundaries: [{{line: south.geojson, stage: 3.5 m}}, {{line: north.geojson, stage: {north}}}]{more}")
    };
    let lock = "\nstructures: {walls: [{lines: lock.geojson}]}";
    let dry = "\ninitial: [{river: inflow.geojson, depth: 1 m}]";
    let inflow = |q: &str| format!("boundaries: [{{line: inflow.geojson, discharge: {q}}}]");
    assert_said(&[
        (
            &stages("4 m", ""),
            "warning[step-of-level] boundaries[1]",
            &["holds 4 m and `boundaries[0]`, beside it, 3.5 m", "at      1200.0, 2", "runs along the edge"],
        ),
        (&stages("3.51 m", ""), "", &[]),
        (&stages("4 m", lock), "", &[]),
        (
            &format!("boundaries: [{{side: east, rating: {{table: high.csv}}}}]{dry}"),
            "warning[high-weir] boundaries[0]",
            &["begins at 101 m, 100.00 m above the lowest ground", "at      1200.0, 2"],
        ),
        // A weir over which a reservoir will run.
        ("boundaries: [{side: east, rating: {table: high.csv}}]", "", &[]),
        (&format!("boundaries: [{{side: east, rating: {{table: weir.csv}}}}]{dry}"), "", &[]),
        (
            "boundaries: [{side: east, rating: {table: shut.csv}}]",
            "warning[rating-without-discharge] boundaries[0]",
            &["the boundary is a wall"],
        ),
        (
            "boundaries: [{side: west, normal_depth: {slope: 1 %}}]",
            "warning[rising-ground] boundaries[0]",
            &["down a slope of 0.01, and the ground rises towards the edge: 1.03 m over the last 50 m", "`type: open`"],
        ),
        ("boundaries: [{side: east, normal_depth: {slope: 1 %}}]", "", &[]),
        ("boundaries: [{side: north, normal_depth: {slope: 1 %}}]", "", &[]),
        (
            &inflow("1e6 m3/s"),
            "warning[huge-discharge] boundaries[0]",
            &["1000000 m3/s come in over 50 m of this boundary: critical flow would be 344 m deep"],
        ),
        (&inflow("100000 m3/s"), "", &[]),
        (
            "boundaries: [{side: east, stage: 300 m}]",
            "warning[drowned-terrain] boundaries[0]",
            &["300 m, 280 m above all terrain and all water of the start"],
        ),
        (
            "sources: [{at: [1100, 2070], discharge: 1e6 m3/s}]",
            "warning[huge-discharge] sources[0]",
            &["over 20 m of the edges of the cell of this source"],
        ),
        (
            "sources: [{line: across.geojson, discharge: 1e7 m3/s}]",
            "warning[huge-discharge] sources[0]",
            &["of feature 1"],
        ),
    ]);
    let channel = "{id: a, length: 100 m, width: 5 m, bed: 1 m, joins: {side: east, from: 2060, to: 2065}";
    assert_said(&[(
        &format!("channels: [{channel}, upstream: {{discharge: 100000 m3/s}}}}]"),
        "warning[huge-discharge] channels[0].upstream.discharge",
        &["over 5 m of the far end of this channel"],
    )]);
}

#[test]
fn rain_that_brings_nothing_or_more_than_any_rain_is_told() {
    let lost = "nothing of the rain runs off before the run ends";
    let code = "warning[rain-without-water] rain";
    assert_said(&[
        ("rain: {rate: 5 mm/h, losses: {constant: 8 mm/h}}", code, &[lost, "`losses` takes all of it"]),
        ("rain: {rate: 5 mm/h, losses: {initial: 8 mm}}", code, &[lost]),
        ("rain: {rate: 60 mm/h, losses: {initial: 8 mm}}", "", &[]),
        ("rain: {rate: 0 mm/h}", code, &["no rain falls before the run ends"]),
        ("rain: {rate: 5000 mm/h}", "warning[rain-doubtful] rain.rate", &["5000 mm/h of rain are more than 1000 mm/h"]),
    ]);
}

#[test]
fn levels_and_depths_as_none_are_told() {
    let line = |level: &str| {
        format!(
            "terrain: {{layers: [{{raster: dem.asc}}], breaklines: [{{lines: across.geojson, mode: raise, {level}}}]}}"
        )
    };
    let carved = line("z: -9999 m").replace("raise", "carve");
    let water = |what: &str| format!("initial: [{{{what}}}]");
    assert_said(&[
        (&carved, "error[implausible-level] terrain.breaklines[0].z", &["-9999 m, as none on Earth"]),
        (&line("z_field: crest"), "error[implausible-level] terrain.breaklines[0].lines", &["feature 1 of across"]),
        (
            &line("z: 2700 m"),
            "warning[doubtful-level] terrain.breaklines[0].z",
            &["m above the terrain", "at      1132.5"],
        ),
        // In feet: 24 m are 78.7 ft.
        (
            &line("z: 78.7 m"),
            "warning[doubtful-level] terrain.breaklines[0].z",
            &["feature 1 of across.geojson lies 59 m or more above the terrain all along", "cause"],
        ),
        (&line("z: 65 m"), "", &[]),
        (&line("z: 21 m"), "", &[]),
        (&water("river: across.geojson, depth: 150 m"), "warning[deep-water] initial[0].depth", &["a river of 150 m"]),
        (&water("water: pond.geojson, depth: 9999 m"), "warning[deep-water] initial[0].depth", &["water of 9999 m"]),
        (&water("water: pond.geojson, level: 15000 m"), "error[implausible-level] initial[0].level", &["15000 m"]),
        (
            "structures: {buildings: {polygons: pond.geojson, mode: raise, height: 3000 m}}",
            "error[building-range] structures.buildings.polygons",
            &["with 3000"],
        ),
        (
            "structures: {buildings: {polygons: house.geojson, mode: raise, height: 300 m}}",
            "warning[doubtful-height] structures.buildings.polygons",
            &["1 of 1 polygons of house.geojson are higher than 200 m, the first is feature 1 with 300 m"],
        ),
        ("structures: {buildings: {polygons: house.geojson, mode: raise, height: 200 m}}", "", &[]),
    ]);
}

#[test]
fn levees_that_lie_below_the_ground_in_part_are_told_with_the_length_that_does() {
    let levee = |file: &str, z: &str| {
        format!(
            "terrain: {{layers: [{{raster: dem.asc}}], breaklines: [{{lines: {file}.geojson, mode: raise, z: {z}}}]}}"
        )
    };
    let wall = |crest: &str| format!("structures: {{walls: [{{lines: along.geojson, crest: {crest}}}]}}");
    let code = "warning[crest-below-terrain]";
    // The ground falls from 5 m to 1 m; that of 28 of 40 cells lies higher than 2.2 m.
    let reported: &[&str] = &[
        "140 m of 200 m of feature 1 of along.geojson lie below the terrain, by up to 3.00 m",
        "at      1002.5",
        "cause",
    ];
    assert_said(&[
        (&levee("along", "2 m"), &format!("{code} terrain.breaklines[0].z"), reported),
        (&wall("2 m"), &format!("{code} structures.walls[0].crest"), reported),
        (&wall("4.8 m"), "", &[]),
        // Both ends lie in the plateau.
        (&levee("across", "8 m"), "", &[]),
        (
            &levee("two", "8 m"),
            "warning[outside-terrain] terrain.breaklines[0].lines",
            &["1 of 2 lines of two.geojson lie outside the terrain, the first is feature 2", "cause", "correct their"],
        ),
    ]);
}

#[test]
fn gauges_on_the_edges_of_the_terrain_are_read_as_its_last_cells() {
    let scene = Scene::with("outputs: {gauges: g.csv}");
    scene.write("g.csv", "id,x,y\ne,1200,2075\nn,1100,2150\nne,1200,2150\nw,1000,2075\ns,1100,2000\n");
    assert!(floodsim(scene.folder.path(), &["check", "s.yaml"]).stdout.contains("0 errors, 0 warnings"));
    let run = floodsim(scene.folder.path(), &["run", "s.yaml", "--out", "o", "--quiet", "--set", "time.end=5 s"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let table = std::fs::read_to_string(scene.folder.path().join("o/tables/gauges.csv")).unwrap();
    let cells: Vec<Vec<&str>> = table.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let number = |row: usize, column: usize| cells[row][column].parse::<f64>().unwrap();
    for (row, bed) in [1.0, 20.0, 20.0, 5.0, 20.0].into_iter().enumerate() {
        assert!((number(row, 3) - bed).abs() < 0.05, "bed of {}: {table}", cells[row][0]);
    }
    assert!((number(0, 6) - 2.9).abs() < 1e-3 && number(1, 5).abs() <= 0.0, "{table}");
    // Cells of 7 m: the terrain ends 2 m before the middle of those in the north.
    let check = floodsim(scene.folder.path(), &["check", "s.yaml", "--set", "resolution=7 m"]).stdout;
    let said = "gauge `n` lies at the edge of the terrain, in a cell whose centre has none,";
    assert!(check.contains("warning[gauge-on-nodata] outputs.gauges") && check.contains(said), "{check}");
}

#[test]
fn a_section_along_an_edge_of_the_terrain_is_told_to_measure_nothing() {
    for (edge, line) in [
        ("east", "[[1200,2050],[1200,2100]]"),
        ("west", "[[1000,2050],[1000,2100]]"),
        ("north", "[[1000,2150],[1200,2150]]"),
        ("south", "[[1000,2000],[1200,2000]]"),
    ] {
        let scene = Scene::with("outputs: {sections: s.geojson}");
        scene.features("s.geojson", &[("LineString", line, "{}")]);
        let check = floodsim(scene.folder.path(), &["check", "s.yaml"]);
        assert!(
            check.code == 4 && check.stdout.contains("error[section-on-edge] outputs.sections"),
            "{edge}: {}",
            check.stdout
        );
        // From one edge to the other it measures.
        scene.features(
            "s.geojson",
            &[("LineString", "[[1100,2000],[1100,2150]]", "{}"), ("LineString", "[[1000,2075],[1200,2075]]", "{}")],
        );
        let check = floodsim(scene.folder.path(), &["check", "s.yaml"]);
        assert!(check.stdout.contains("0 errors, 0 warnings"), "{}", check.stdout);
    }
}
