//! Open boundaries, sources, rain and cross-sections through the whole program: what is written, and what bad inputs get.

mod moving;
mod refused;
mod series;
mod sources;

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::{Netcdf, changed, feature, floodsim, run_scene};

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
fn a_boundary_on_all_of_the_outline_leaves_holes_closed() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, content: &str| std::fs::write(folder.path().join(name), content).unwrap();
    // A bowl with a hole in its lake.
    let height = |i: i32, j: i32| match (i - 20).pow(2) + (j - 20).pow(2) {
        _ if (18..23).contains(&i) && (24..27).contains(&j) => "-9999".to_owned(),
        square => format!("{}", 0.02 * f64::from(square)),
    };
    let row = |j: i32| (0..41).map(|i| height(i, j)).collect::<Vec<_>>().join(" ");
    let ground = (0..41).map(row).collect::<Vec<_>>().join("\n");
    write(
        "dem.asc",
        &format!("ncols 41\nnrows 41\nxllcorner 0\nyllcorner 0\ncellsize 5\nNODATA_value -9999\n{ground}\n"),
    );
    let outer = "[[20,20],[185,20],[185,185],[20,185],[20,20]]";
    // Rows count from the north.
    let around_hole = "[[90,70],[115,70],[115,85],[90,85],[90,70]]";
    write("lake.geojson", &feature("Polygon", &format!("{outer},{around_hole}")));
    write("rim.geojson", &feature("MultiLineString", around_hole));
    let water = "initial: [{reservoir: lake.geojson, level: 3 m}]\nrain: {rate: 0 mm/h}";
    let rest = "crs: local\nterrain: {layers: [{raster: dem.asc}]}\nroughness: {manning: 0.03}\ntime: {end: 30 s}\noutputs: {every: 30 s}";
    write("s.yaml", &format!("floodsim: 1\n{rest}\n{water}\nresolution: 5 m\n"));
    for resolution in ["5 m", "7 m", "{finest: 5 m, coarsest: 10 m}"] {
        let speed = |boundary: &str| {
            let boundary = format!("boundaries=[{boundary}]");
            let options = ["--set", &boundary, "--set", &format!("resolution={resolution}"), "--overwrite"];
            run_scene(folder.path(), "out", &options).0["max_speed_m_s"].as_f64().unwrap()
        };
        for kind in ["type: open", "type: free", "normal_depth: {slope: 2 ‰}"] {
            let speed = speed(&format!("{{side: all, {kind}}}"));
            assert!(speed < 1e-12, "{resolution}, {kind}: {speed:e} m/s");
        }
        let speed = speed("{lines: rim.geojson, type: open}");
        assert!(speed > 1.0, "{resolution}, opened by a line: {speed:e} m/s");
    }
}
