//! Open boundaries, sources, rain and cross-sections through the whole program: what is written, and what bad inputs get.

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::{Netcdf, changed, floodsim};

/// A channel that falls to the east by 4 %, 200 m long and 60 m wide, with a bed lower by 1 m in its middle third. Times in the
/// hydrograph are minutes. The lines of this scenario are counted on by the tests.
const SCENARIO: &str = "\
floodsim: 1
crs: local
terrain: dem.asc
roughness: {manning: 0.03}
boundaries:
  - {line: inflow.geojson, discharge: {series: q.csv, column: q, unit: m3/s, time_unit: min}}
  - {edge: east, normal_depth: {slope: 0.04}}
resolution: 5 m
time: {end: 2 min}
outputs: {every: 30 s, sections: sections.geojson}
";

const HYDROGRAPH: &str = "t,q\n0,0\n0.5,12\n1.5,4\n3,4\n";

struct Scene {
    folder: TempDir,
}

impl Scene {
    fn sound() -> Scene {
        let scene = Scene { folder: TempDir::new().unwrap() };
        let cell = |column: usize, row: usize| {
            let low = if (4..8).contains(&row) { 0.0 } else { 1.0 };
            format!("{}", 10.0 - 0.2 * column as f64 + low)
        };
        let rows: Vec<String> =
            (0..12).map(|row| (0..40).map(|column| cell(column, row)).collect::<Vec<_>>().join(" ")).collect();
        let header = "ncols 40\nnrows 12\nxllcorner 1000\nyllcorner 2000\ncellsize 5\nNODATA_value -9999\n";
        scene.write("dem.asc", &(header.to_owned() + &rows.join("\n") + "\n"));
        scene.write("s.yaml", SCENARIO);
        scene.write("q.csv", HYDROGRAPH);
        scene.line("inflow.geojson", &[(1000.0, 2020.0), (1000.0, 2040.0)], "in");
        scene.line("sections.geojson", &[(1100.0, 2060.0), (1102.0, 2000.0)], "bridge");
        scene
    }

    fn with(changes: &[(&str, &str)]) -> Scene {
        let scene = Scene::sound();
        scene.write("s.yaml", &changed(SCENARIO, changes));
        scene
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: &str) {
        std::fs::write(self.path(name), content).unwrap();
    }

    fn line(&self, name: &str, places: &[(f64, f64)], id: &str) {
        let places: Vec<String> = places.iter().map(|(x, y)| format!("[{x},{y}]")).collect();
        let geometry = format!(r#"{{"type":"LineString","coordinates":[{}]}}"#, places.join(","));
        let feature = format!(r#"{{"type":"Feature","properties":{{"id":"{id}"}},"geometry":{geometry}}}"#);
        self.write(name, &format!(r#"{{"type":"FeatureCollection","features":[{feature}]}}"#));
    }

    /// Runs the scene; returns `run.json` and the folder of the run.
    #[track_caller]
    fn run(&self) -> (serde_json::Value, PathBuf) {
        let answer = floodsim(self.folder.path(), &["run", "s.yaml", "--out", "out", "--quiet"]);
        assert_eq!(answer.code, 0, "{}", answer.stderr);
        let out = self.path("out");
        let text = std::fs::read_to_string(out.join("run.json")).unwrap();
        (serde_json::from_str(&text).unwrap(), out)
    }

    /// Asserts that the check refuses the scene with this exit code, and says all these texts.
    #[track_caller]
    fn assert_refused(&self, code: i32, expected: &[&str]) {
        let check = floodsim(self.folder.path(), &["check", "s.yaml"]);
        for text in expected {
            assert!(check.stdout.contains(text), "check does not say `{text}`, but\n{}", check.stdout);
        }
        assert_eq!(check.code, code, "{}", check.stdout);
        for problem in check.stdout.split("error[").skip(1) {
            assert!(problem.contains("\n  cause   ") || problem.contains("\n  remedy  "), "no way out of: {problem}");
        }
    }

    /// Asserts that the check says none of these texts.
    #[track_caller]
    fn assert_silent_on(&self, unwanted: &[&str]) {
        let check = floodsim(self.folder.path(), &["check", "s.yaml"]);
        for text in unwanted {
            assert!(!check.stdout.contains(text), "check says `{text}`:\n{}", check.stdout);
        }
    }

    /// Asserts that the check warns with all these texts, and refuses nothing.
    #[track_caller]
    fn assert_warned(&self, expected: &[&str]) {
        let check = floodsim(self.folder.path(), &["check", "s.yaml"]);
        for text in expected {
            assert!(check.stdout.contains(text), "check does not say `{text}`, but\n{}", check.stdout);
        }
        assert_eq!(check.code, 0, "{}", check.stdout);
    }
}

fn volume(run: &serde_json::Value, key: &str) -> f64 {
    run["volume_m3"][key].as_f64().unwrap()
}

fn table(path: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

/// Asserts that `sections.nc` holds the numbers of both tables, and where `bridge` and `bank` lie.
#[track_caller]
fn assert_sections_nc(file: &Netcdf, sections: &[Vec<String>], series: &[Vec<String>]) {
    assert_eq!((file.dimensions["section"], file.dimensions["time"]), (2, (series.len() - 1) / 2));
    for (column, name) in [(2, "discharge"), (3, "volume")] {
        for (row, value) in series[1..].iter().zip(file.values(name)) {
            // As many decimals as the table has.
            assert!((row[column].parse::<f64>().unwrap() - value).abs() < 5.1e-4, "{name} of {row:?}: {value}");
        }
    }
    let columns = [(1, "length"), (2, "arrival_time"), (3, "peak_discharge"), (4, "time_of_peak"), (5, "total_volume")];
    for (column, name) in columns {
        assert_eq!(file.values(name).len(), 2);
        for (row, value) in sections[1..].iter().zip(file.values(name)) {
            // An empty field is the fill value.
            let decimals = row[column].split_once('.').map_or(0, |(_, decimals)| decimals.len());
            let wanted = if row[column].is_empty() { -9999.0 } else { row[column].parse().unwrap() };
            assert!((wanted - value).abs() <= 0.51 * 0.1_f64.powi(decimals as i32), "{name} of {row:?}: {value}");
        }
        let about = &file.variables[name].0;
        for wanted in ["_FillValue", "units", "long_name", "section_id x y"] {
            assert!(about.contains(wanted), "{name} lacks {wanted}: {about}");
        }
        assert!(!about.contains("grid_mapping"), "{about}");
    }
    let places = ["left_x", "left_y", "x", "y", "right_x", "right_y"].map(|name| file.values(name));
    // The middle of the second line is a metre beyond its bend.
    let wanted =
        [[1100.0, 1100.0], [2060.0, 2060.0], [1101.0, 1099.0], [2030.0, 2054.0], [1102.0, 1092.0], [2000.0, 2054.0]];
    for (found, wanted) in places.iter().zip(wanted) {
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}, not {wanted:?}");
    }
}

#[test]
fn a_hydrograph_comes_in_passes_its_section_and_leaves() {
    let scene = Scene::sound();
    // The bank lies a metre above the channel and stays dry.
    let line = |id: &str, line: &str| {
        format!(
            r#"{{"type":"Feature","properties":{{"id":"{id}"}},"geometry":{{"type":"LineString","coordinates":{line}}}}}"#
        )
    };
    let lines = [line("bridge", "[[1100,2060],[1102,2000]]"), line("bank", "[[1100,2060],[1100,2054],[1092,2054]]")];
    let lines = format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, lines.join(","));
    scene.write("sections.geojson", &lines);
    let check = floodsim(scene.folder.path(), &["check", "s.yaml"]);
    assert!(check.stdout.contains("0 errors, 0 warnings"), "{}", check.stdout);
    let (run, out) = scene.run();
    // 30 s of a triangle to 12, 60 s down to 4, 30 s of 4 m3/s.
    let wanted = 180.0 + 480.0 + 120.0;
    assert!((volume(&run, "in") / wanted - 1.0).abs() < 1e-9, "{} m3", volume(&run, "in"));
    assert!(volume(&run, "error_relative").abs() < 1e-9 && volume(&run, "out") > 100.0, "{run:#}");
    assert!(run["inputs"].as_array().unwrap().iter().any(|input| input["path"].as_str().unwrap().ends_with("q.csv")));
    let sections = table(&out.join("tables/sections.csv"));
    assert_eq!(sections[0].join(","), "id,length_m,arrival_s,peak_discharge_m3_s,time_of_peak_s,volume_m3");
    assert_eq!(sections[1][0], "bridge");
    let number = |column: usize| sections[1][column].parse::<f64>().unwrap();
    assert!((10.0..60.0).contains(&number(2)), "arrives at {} s", number(2));
    // 12 m3/s came in at most. The front crosses cells of 5 m in jumps, which adds some per cent; at 2.5 m it adds nothing.
    assert!((4.0..14.0).contains(&number(3)) && number(4) > number(2), "peak {} m3/s", number(3));
    assert!(number(5) > volume(&run, "out") && number(5) < wanted, "{} m3 passed", number(5));
    let series = table(&out.join("tables/section_series.csv"));
    assert_eq!(series[0].join(","), "id,time_s,discharge_m3_s,volume_m3");
    let last = series.iter().rfind(|row| row[0] == "bridge").unwrap();
    assert_eq!((last[1].as_str(), last[3].as_str()), ("120.000", sections[1][5].as_str()));
    assert_eq!(sections[2].join(","), "bank,14.00,,0.000000,,0.000");
    assert_sections_nc(&Netcdf::read(&out.join("sections.nc")), &sections, &series);
    let layers = gdal::Dataset::open(out.join("results.gpkg")).unwrap();
    let mut layer = layers.layer_by_name("sections").unwrap();
    let feature = gdal::vector::LayerAccess::features(&mut layer).next().unwrap();
    let index = feature.field_index("volume_m3").unwrap();
    assert!((feature.field_as_double(index).unwrap().unwrap() - number(5)).abs() < 1e-3);
    // The resolved scenario gives the same run.
    let resolved = out.join("scenario.resolved.yaml").display().to_string();
    let again = floodsim(scene.folder.path(), &["run", &resolved, "--out", "again", "--quiet", "--threads", "3"]);
    assert_eq!(again.code, 0, "{}", again.stderr);
    for name in ["tables/sections.csv", "tables/section_series.csv", "tables/mass_balance.csv"] {
        let read = |run: &str| std::fs::read_to_string(scene.path(run).join(name)).unwrap();
        assert_eq!(read("out"), read("again"), "{name}");
    }
}

#[test]
fn rain_and_sources_fill_a_closed_basin() {
    let rain = "sources: [{at: [1100, 2030], discharge: 250 l/s}]\nrain: {rate: 72 mm/h, duration: 1 min, losses: {initial: 0.2 mm, constant: 36 mm/h}}\n";
    let scene = Scene::with(&[("resolution: 5 m", &format!("{rain}resolution: 5 m"))]);
    let text = std::fs::read_to_string(scene.path("s.yaml")).unwrap();
    let without: String = text
        .lines()
        .filter(|line| !line.starts_with("  - ") && !line.starts_with("boundaries"))
        .map(|line| format!("{line}\n"))
        .collect();
    scene.write("s.yaml", &without);
    let (run, _) = scene.run();
    // 0.2 mm take 10 s of 0.02 mm/s; 50 s of 0.01 mm/s are left, on 12 000 m2.
    let wanted = 0.25 * 120.0 + 50.0 * 1e-5 * 12_000.0;
    assert!((volume(&run, "in") / wanted - 1.0).abs() < 1e-9, "{} of {wanted} m3", volume(&run, "in"));
    assert!(volume(&run, "error_relative").abs() < 1e-9 && volume(&run, "out").abs() < 1e-12);
}

#[test]
fn every_way_of_the_water_is_booked_against_what_was_asked_for() {
    let more = "sources: [{at: [1100, 2030], discharge: 250 l/s}, {line: toe.geojson, discharge: 1 m3/s}]\n\
                rain: {rate: 72 mm/h, duration: 1 min}\nresolution: 5 m";
    let scene = Scene::with(&[("resolution: 5 m", more), ("\nsources", "\n  - {edge: south, type: open}\nsources")]);
    scene.line("toe.geojson", &[(1100.0, 2010.0), (1100.0, 2050.0)], "toe");
    let (run, out) = scene.run();
    let rows = table(&out.join("tables/boundaries.csv"));
    assert_eq!(rows[0].join(","), "name,in_m3,out_m3,asked_m3,error_relative");
    let names: Vec<&str> = rows[1..].iter().map(|row| row[0].as_str()).collect();
    let expected =
        ["open edges", "boundaries[0]", "boundaries[1]", "source at 1100.00 2030.00", "sources[1] feature 1", "rain"];
    assert_eq!(names, expected);
    let asked: Vec<&str> = rows[1..].iter().map(|row| row[3].as_str()).collect();
    assert_eq!(asked, ["", "780.000", "", "30.000", "120.000", "14.400"]);
    for row in rows[1..].iter().filter(|row| !row[3].is_empty()) {
        assert!(row[1] == row[3] && row[4].parse::<f64>().unwrap() < 1e-11, "{row:?}");
    }
    let sum =
        |key: &str| run["boundaries"].as_array().unwrap().iter().map(|way| way[key].as_f64().unwrap()).sum::<f64>();
    assert!((sum("in_m3") / volume(&run, "in") - 1.0).abs() < 1e-12, "{run:#}");
    assert!((sum("out_m3") / volume(&run, "out") - 1.0).abs() < 1e-12 && sum("out_m3") > 100.0);
    let gates = run["gates"].as_array().unwrap();
    assert!(
        gates.iter().any(|gate| gate["name"].as_str().unwrap().starts_with("counted inflow") && gate["passed"] == true),
        "{gates:?}"
    );
}

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

#[test]
fn a_raster_of_rain_falls_where_it_says() {
    let scene = Scene::with(&[("resolution: 5 m", "rain: {raster: rain.asc, unit: mm/h}\nresolution: 5 m")]);
    let row = format!("{}{}", "72 ".repeat(20), "0 ".repeat(20));
    let header = "ncols 40\nnrows 12\nxllcorner 1000\nyllcorner 2000\ncellsize 5\nNODATA_value -9999\n";
    scene.write("rain.asc", &(header.to_owned() + &vec![row; 12].join("\n") + "\n"));
    let (run, _) = scene.run();
    let wanted = 780.0 + 120.0 * 2e-5 * 6000.0;
    assert!((volume(&run, "in") / wanted - 1.0).abs() < 1e-9, "{} of {wanted} m3", volume(&run, "in"));
    let short = header.replace("ncols 40", "ncols 20");
    scene.write("rain.asc", &(short + &vec!["72 ".repeat(20); 12].join("\n") + "\n"));
    scene.assert_refused(4, &["rain-gap", "50.0 % of the terrain"]);
}

#[test]
fn a_tide_and_a_rating_curve_move_the_water_of_a_lake() {
    let lake = "initial:\n  - {water: lake.geojson, level: 12 m}\nresolution: 5 m";
    let edges = ("  - {edge: east, normal_depth: {slope: 0.04}}", "  - {edge: east, rating: {table: weir.csv}}");
    let tide = ("discharge: {series: q.csv, column: q, unit: m3/s, time_unit: min}", "stage: {series: tide.csv}");
    let scene = Scene::with(&[("resolution: 5 m", lake), edges, tide]);
    // All of the side: through a narrow mouth the lake would swing.
    scene.line("inflow.geojson", &[(1000.0, 2007.0), (1000.0, 2053.0)], "in");
    scene.write("tide.csv", "time [min];level [cm]\n0;1200\n2;1230\n");
    scene.write("weir.csv", "level_m,discharge_m3_s\n11,0\n12,3\n13,20\n");
    let ring = "[[[1000,2000],[1200,2000],[1200,2060],[1000,2060],[1000,2000]]]";
    scene.write("lake.geojson", &format!(r#"{{"type":"FeatureCollection","features":[{{"type":"Feature","properties":{{}},"geometry":{{"type":"Polygon","coordinates":{ring}}}}}]}}"#));
    let (run, _) = scene.run();
    assert!(volume(&run, "in") > 1200.0 && volume(&run, "out") > 100.0, "{run:#}");
    assert!(volume(&run, "error_relative").abs() < 1e-9);
    let rise = (volume(&run, "final") - volume(&run, "initial")) / 12_000.0;
    assert!((0.1..0.45).contains(&rise), "the lake rose by {rise} m");
}

#[test]
fn a_lake_behind_edges_at_its_level_stays_at_rest() {
    let scene = Scene::with(&[
        ("resolution: 5 m", "initial:\n  - {water: lake.geojson, level: 12 m}\nresolution: 5 m"),
        ("discharge: {series: q.csv, column: q, unit: m3/s, time_unit: min}", "level: 12 m"),
        ("normal_depth: {slope: 0.04}", "type: free"),
    ]);
    let ring = "[[[1000,2000],[1200,2000],[1200,2060],[1000,2060],[1000,2000]]]";
    scene.write("lake.geojson", &format!(r#"{{"type":"FeatureCollection","features":[{{"type":"Feature","properties":{{}},"geometry":{{"type":"Polygon","coordinates":{ring}}}}}]}}"#));
    let (run, _) = scene.run();
    let speed = run["max_speed_m_s"].as_f64().unwrap();
    assert!(speed < 1e-12, "{speed:e} m/s");
}

#[test]
fn faults_of_a_hydrograph_are_told_by_line() {
    let scene = Scene::sound();
    scene.write("q.csv", "t,q\n0,0\n0.5,a lot\n1,\n3,4\n");
    scene.assert_refused(
        4,
        &["not-a-number", "2 rows have no two numbers in", "line 3 (`0.5 | a lot`), line 4 (`1 | `)", "s.yaml:6:"],
    );
    scene.write("q.csv", "t,q\n0,0\n1,5\n0.5,3\n3,-4\n");
    scene.assert_refused(4, &["not-rising", "line 4", "negative-value", "line 5 (`-4`)"]);
    scene.write("q.csv", "t,q\n0.5,0\n1,5\n1.5,3\n");
    scene.assert_refused(
        4,
        &[
            "series-starts-late",
            "begins 30 s after",
            "series-ends-early",
            "ends at 90 s (line 4), before the run does at 120 s",
            "`after_end: hold`",
        ],
    );
    scene.write("q.csv", "0,0\n3,4\n");
    scene.assert_refused(4, &["no-header", "time_h,q_m3_s"]);
    scene.write("q.csv", "t,inflow\n0,0\n3,4\n");
    scene.assert_refused(4, &["missing-column", "no column `q`", "its columns are t, inflow"]);
    scene.write("q.csv", "t,q\n");
    scene.assert_refused(4, &["empty-table"]);
    std::fs::remove_file(scene.path("q.csv")).unwrap();
    scene.assert_refused(4, &["missing-file", "q.csv"]);
    scene.write("q.csv", "t,q\n0,0\n0.1,1\n0.2,1\n0.3,2\n0.4,2\n2,3\n");
    scene.assert_warned(&["series-gap", "from 24 s (line 6) to 120 s (line 7)", "a step of 6 s is usual"]);
    // Decimal commas between semicolons.
    scene.write("q.csv", "t;q\n0;0\n3;4,5\n");
    scene.assert_refused(4, &["not-a-number", "line 3 (`3 | 4,5`)"]);
}

#[test]
fn a_code_for_a_missing_level_is_refused() {
    let scene = Scene::with(&[("normal_depth: {slope: 0.04}", "stage: {series: stage.csv}")]);
    scene.write("stage.csv", "time_min,level_m\n0,3\n1,-9999\n2,3.1\n");
    scene.assert_refused(4, &["implausible-level", "one row has a level that is none on Earth", "line 3 (`-9999`)"]);
    // In the unit of the file.
    scene.write("stage.csv", "time_min,level_cm\n0,300\n1,2000000\n2,310\n");
    scene.assert_refused(4, &["implausible-level", "line 3 (`2000000`)"]);
    let scene = Scene::with(&[("normal_depth: {slope: 0.04}", "rating: {table: weir.csv}")]);
    scene.write("weir.csv", "level_m,discharge_m3_s\n-9999,0\n8,1\n");
    let place = "error[implausible-level] boundaries[1].rating.table (s.yaml:7:";
    scene.assert_refused(4, &[place, "one row has a level that is none on Earth, in", "line 2 (`-9999`)"]);
    scene.write("weir.csv", "level_m,discharge_m3_s\n2,0\n5,-9999\n8,1\n");
    scene
        .assert_refused(4, &["error[negative-value] boundaries[1].rating.table", "line 3 (`-9999`)", "missing values"]);
}

#[test]
fn rows_that_are_missing_and_times_in_another_unit_are_told() {
    let scene = Scene::sound();
    let row = |k: usize| format!("{},{}\n", 0.1 * k as f64, k % 5);
    let rows = |is_kept: fn(usize) -> bool| (0..25).filter(|k| is_kept(*k)).map(row).collect::<String>();
    scene.write("q.csv", &format!("t,q\n{}", rows(|k| !(4..12).contains(&k))));
    let place = "warning[series-gap] boundaries[0].discharge.series (s.yaml:6:";
    scene.assert_warned(&[place, "has a gap from 18 s (line 5) to 72 s (line 6), where a step of 6 s is usual"]);
    scene.write("q.csv", &format!("t,q\n{}", rows(|k| k != 4)));
    scene.assert_silent_on(&["series-gap"]);
    scene.write("q.csv", "t,q\n0,0\n30,12\n90,4\n130,4\n");
    let place = "warning[series-far-beyond] boundaries[0].discharge.series (s.yaml:6:";
    let texts = ["the run takes 1 of 4 rows", "is the unit of its times right? 130 is taken for 7800 s", "remedy"];
    scene.assert_warned(&[&[place][..], &texts].concat());
    scene.write("q.csv", "t,q\n0,0\n30,12\n39,4\n");
    scene.assert_silent_on(&["series-far-beyond"]);
}

#[test]
fn rain_below_0_is_told_in_the_unit_of_its_file() {
    let scene = Scene::with(&[("resolution: 5 m", "rain: {rate: {series: rain.csv}}\nresolution: 5 m")]);
    scene.write("rain.csv", "time_min,rain_mm_h\n0,5\n1,-20\n2,5\n");
    let place = "error[negative-value] rain.rate.series (s.yaml:8:";
    scene.assert_refused(4, &[place, "line 3 (`-20`)", "what the ground takes of the rain is `losses`"]);
}

#[test]
fn the_last_value_of_a_series_holds_on_where_the_scenario_says_so() {
    let held = ("time_unit: min}", "time_unit: min, after_end: hold}");
    let spring = (
        "resolution: 5 m",
        "sources: [{at: [1100, 2030], discharge: {series: s.csv, after_end: hold}}]\nresolution: 5 m",
    );
    let scene = Scene::with(&[held, spring]);
    scene.write("q.csv", "t,q\n0,0\n0.5,12\n1.5,4\n");
    scene.write("s.csv", "time_s,q_l_s\n0,100\n60,300\n");
    scene.assert_warned(&[
        "0 errors, 2 warnings",
        "series-held",
        "ends at 90 s (line 4), before the run does at 120 s; its last value holds on for 30 s",
        "ends at 60 s (line 3), before the run does at 120 s; its last value holds on for 60 s",
    ]);
    let (run, out) = scene.run();
    // 30 s of a triangle to 12, 60 s down to 4, 30 s of 4 m3/s; from the spring 60 s of 0.2 and 60 s of 0.3 m3/s.
    let wanted = 180.0 + 480.0 + 120.0 + 12.0 + 18.0;
    assert!((volume(&run, "in") / wanted - 1.0).abs() < 1e-9, "{} m3", volume(&run, "in"));
    let resolved = std::fs::read_to_string(out.join("scenario.resolved.yaml")).unwrap();
    assert_eq!(resolved.matches("after_end: hold").count(), 2, "{resolved}");
    // What comes before the first row, and what no rows are known of, is said nothing of by this key.
    scene.write("q.csv", "t,q\n0.5,12\n1.5,4\n");
    scene.assert_refused(4, &["series-starts-late", "series-held"]);
    let scene = Scene::with(&[("time_unit: min}", "time_unit: min, after_end: cycle}")]);
    scene.assert_refused(3, &["`cycle` is not a way on after the end of a series", "use one of hold", "s.yaml:6:"]);
}

#[test]
fn a_tide_by_dates_is_that_in_seconds() {
    let tide = ("discharge: {series: q.csv, column: q, unit: m3/s, time_unit: min}", "stage: {series: tide.csv}");
    let end = ("time: {end: 2 min}", "time: {end: 2 min, reference: \"2026-06-01 06:00:00\"}");
    let scene = Scene::with(&[tide, end]);
    let fields = |rows: &str| {
        scene.write("tide.csv", rows);
        let (run, out) = scene.run();
        assert!(volume(&run, "in") > 10.0, "{run:#}");
        let (fields, maps) = (Netcdf::read(&out.join("fields.nc")), Netcdf::read(&out.join("maps.nc")));
        let tables = std::fs::read(out.join("tables/boundaries.csv")).unwrap();
        std::fs::remove_dir_all(out).unwrap();
        let bits = |file: Netcdf| -> Vec<(String, Vec<u64>)> {
            let of = |(name, (_, values)): (String, (String, Vec<f64>))| {
                (name, values.iter().map(|v| v.to_bits()).collect())
            };
            file.variables.into_iter().map(of).collect()
        };
        (bits(fields), bits(maps), tables)
    };
    // From 30 s before the start on, when the run begins between two rows.
    let by_seconds = fields("time_s,level_m\n-30,11\n10,11.5\n61,12\n180,12.25\n");
    let dates = ["2026-06-01 05:59:30", "2026-06-01T08:00:10+02:00", "2026-06-01T06:01:01Z", "2026-06-01 06:03"];
    let levels = ["11", "11.5", "12", "12.25"];
    let rows: String = dates.iter().zip(levels).map(|(date, level)| format!("{date};{level}\n")).collect();
    assert!(
        fields(&format!("time;level_m\n{rows}")) == by_seconds,
        "fields, maps or the book of the boundaries differ"
    );
    let others = fields("time_s,level_m\n-30,11\n10,11.5\n62,12\n180,12.25\n");
    assert!(others != by_seconds, "a tide a second later is the same");
}

#[test]
fn faults_of_dates_are_told_all_at_once_by_line() {
    let bare = ("unit: m3/s, time_unit: min", "unit: m3/s");
    let scene = Scene::with(&[bare]);
    for (first, second) in [("2026-06-01 06:00:00", "2026-06-01 09:00:00"), ("2026-06-01", "2026-06-02")] {
        scene.write("q.csv", &format!("time,q\n{first},12\n{second},4\n"));
        let texts = ["dates-as-times", &format!("line 2 (`{first}`)"), "add `time.reference`", "`time_h`", "s.yaml:6:"];
        scene.assert_refused(4, &texts);
        scene.assert_silent_on(&["missing-unit"]);
    }
    let dated = ("time: {end: 2 min}", "time: {end: 2 min, reference: \"2026-06-01 06:00\"}");
    let scene = Scene::with(&[dated]);
    scene.write(
        "q.csv",
        "t,q\n2026-06-01 06:00,0\n2026-06-31 06:01,12\n01.06.2026 06:02,4\n180,4\n2026-06-01 06:04,a\n",
    );
    let place = "boundaries[0].discharge.series (s.yaml:6:";
    let texts = [
        "unit-beside-dates",
        "the unit `min`",
        "one row has no date that exists, or one in a form that is not read, in",
        "line 3 (`2026-06-31 06:01`)",
        "line 3: there is no such day",
        "ambiguous-date",
        "line 4 (`01.06.2026 06:02`)",
        "`2026-06-01T06:00:00Z`",
        "mixed-times",
        "line 5 (`180`)",
    ];
    scene.assert_refused(4, &[&[place, "5 errors"][..], &texts, &["line 6 (`2026-06-01 06:04 | a`)"]].concat());
    let scene = Scene::with(&[bare, dated]);
    scene.write("q.csv", "t,q\n2026-06-01 07:00,0\n2026-06-01 09:00,12\n");
    scene.assert_refused(
        4,
        &["series-starts-late", "begins 3600 s after the start of the run (line 2)", "`time.reference`"],
    );
    scene.write("q.csv", "t,q\n2026-06-01 05:00,0\n2026-06-01 06:00,12\n");
    scene.assert_refused(4, &["series-ends-early", "correct `time.reference`"]);
}

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
fn moving_particles_refuse_what_they_do_not_know() {
    let more = "sources: [{at: [1100, 2030], discharge: 1 m3/s}, {line: springs.geojson, discharge: 1 m3/s}]\nrain: {rate: 1 mm/h}\nresolution: 5 m";
    let moving = format!("numerics: {{motion: lagrangian}}\n{more}");
    let scene = Scene::with(&[("resolution: 5 m", &moving.replace("resolution", "channels: []\nresolution"))]);
    scene.assert_refused(3, &["method-combination", "Lagrangian particles know no channels", "motion: eulerian"]);
    scene.assert_silent_on(&["with a condition", "know no source", "cross-sections", "know no rain"]);
    let variational = format!("numerics: {{formulation: variational}}\n{more}");
    let scene = Scene::with(&[("resolution: 5 m", &variational)]);
    scene.assert_refused(
        3,
        &[
            "boundaries[0]",
            "the particles of the variational formulation know no boundary with a condition",
            "the particles of the variational formulation know no sources",
            "the particles of the variational formulation know no rain",
            "the particles of the variational formulation know no cross-sections",
        ],
    );
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
fn a_river_of_moving_particles_comes_in_and_leaves() {
    let motion = "numerics: {motion: lagrangian}\nsources: [{at: [1100, 2030], discharge: 1 m3/s}]\nresolution: 5 m";
    let scene =
        Scene::with(&[("resolution: 5 m", motion), ("\nnumerics", "\n  - {edge: south, type: open}\nnumerics")]);
    let (run, out) = scene.run();
    // 180 m3 to 30 s, 480 to 90 s, 120 to 120 s; the source 120.
    assert!((volume(&run, "in") / 900.0 - 1.0).abs() < 1e-9, "{}", volume(&run, "in"));
    assert!(volume(&run, "error_relative").abs() < 1e-12 && volume(&run, "out") > 100.0);
    assert!(volume(&run, "grid_error_relative").abs() < 1e-4, "{}", volume(&run, "grid_error_relative"));
    assert!(table(&out.join("tables/mass_balance.csv")).len() > 4);
    let rows = table(&out.join("tables/boundaries.csv"));
    let names: Vec<&str> = rows[1..].iter().map(|row| row[0].as_str()).collect();
    assert_eq!(names, ["open edges", "boundaries[0]", "boundaries[1]", "source at 1100.00 2030.00"]);
    let asked: Vec<&str> = rows[1..].iter().map(|row| row[3].as_str()).collect();
    assert_eq!(asked, ["", "780.000", "", "120.000"]);
    for row in rows[1..].iter().filter(|row| !row[3].is_empty()) {
        assert!(row[1] == row[3] && row[4].parse::<f64>().unwrap() < 1e-9, "{row:?}");
    }
    let sum =
        |key: &str| run["boundaries"].as_array().unwrap().iter().map(|way| way[key].as_f64().unwrap()).sum::<f64>();
    assert!((sum("in_m3") / volume(&run, "in") - 1.0).abs() < 1e-12, "{run:#}");
    assert!((sum("out_m3") / volume(&run, "out") - 1.0).abs() < 1e-12);
    let gates = run["gates"].as_array().unwrap();
    assert!(
        gates.iter().any(|gate| gate["name"].as_str().unwrap().starts_with("counted inflow") && gate["passed"] == true),
        "{gates:?}"
    );
}

#[test]
fn moving_particles_pass_a_section_as_resting_ones_do() {
    let found = ["lagrangian", "eulerian"].map(|motion| {
        let numerics = format!("numerics: {{motion: {motion}}}\nresolution: 5 m");
        let scene = Scene::with(&[("resolution: 5 m", &numerics)]);
        let (_, out) = scene.run();
        let sections = table(&out.join("tables/sections.csv"));
        let series = table(&out.join("tables/section_series.csv"));
        assert_eq!((sections[1][0].as_str(), series.last().unwrap()[3].as_str()), ("bridge", sections[1][5].as_str()));
        [2, 3, 4, 5].map(|column| sections[1][column].parse::<f64>().unwrap())
    });
    let [[arrival, peak, time_of_peak, passed], [resting_arrival, resting_peak, resting_time, resting_passed]] = found;
    println!("{found:?}");
    assert!((arrival - resting_arrival).abs() < 5.0, "{found:?}");
    // The peak is that of the front on dry ground, which rises no more above uniform flow with Eulerian particles (M79, M95) and still
    // does with Lagrangian ones: 1.165 of it.
    assert!((peak / resting_peak - 1.0).abs() < 0.2 && (time_of_peak - resting_time).abs() < 20.0, "{found:?}");
    assert!((passed / resting_passed - 1.0).abs() < 0.05, "{found:?}");
}

#[test]
fn rain_on_moving_particles_runs_off_and_is_booked() {
    let rain = "numerics: {motion: lagrangian}\nrain: {rate: 720 mm/h, duration: 1 min, losses: {initial: 2 mm, constant: 360 mm/h}}\nresolution: 5 m";
    let scene = Scene::with(&[("resolution: 5 m", rain)]);
    let (run, out) = scene.run();
    // 2 mm take 10 s of 0.2 mm/s; 50 s of 0.1 mm/s are left, on 12 000 m2.
    let rows = table(&out.join("tables/boundaries.csv"));
    let row = rows.iter().find(|row| row[0] == "rain").unwrap();
    assert_eq!((row[1].as_str(), row[3].as_str()), ("60.000", "60.000"));
    assert!(row[4].parse::<f64>().unwrap() < 1e-11, "{row:?}");
    assert!((volume(&run, "in") / 840.0 - 1.0).abs() < 1e-9, "{} m3", volume(&run, "in"));
    assert!(
        volume(&run, "error_relative").abs() < 1e-12 && volume(&run, "grid_error_relative").abs() < 1e-3,
        "{run:#}"
    );
    // All terrain got wet.
    let wet = Netcdf::read(&out.join("maps.nc")).values("max_depth").iter().filter(|depth| **depth > 1e-3).count();
    assert_eq!(wet, 480);
    let again = floodsim(scene.folder.path(), &["run", "s.yaml", "--out", "again", "--quiet", "--threads", "3"]);
    assert_eq!(again.code, 0, "{}", again.stderr);
    for name in ["tables/sections.csv", "tables/boundaries.csv", "tables/mass_balance.csv"] {
        let read = |run: &str| std::fs::read_to_string(scene.path(run).join(name)).unwrap();
        assert_eq!(read("out"), read("again"), "{name}");
    }
}

#[test]
fn a_scenario_without_any_water_is_refused() {
    let scene = Scene::with(&[(
        "  - {line: inflow.geojson, discharge: {series: q.csv, column: q, unit: m3/s, time_unit: min}}\n",
        "",
    )]);
    scene.assert_refused(3, &["the required key `initial` is missing"]);
}
