//! A dam that breaks, through the whole program, before cells that rest and cells that move.

use std::path::PathBuf;

use tempfile::TempDir;

use crate::{Netcdf, floodsim};

const COLUMNS: usize = 60;
const ROWS: usize = 25;

const SCENARIO: &str = "\
floodsim: 1
crs: EPSG:25832
terrain: dem.asc
roughness: {manning: 0.03}
initial: [{reservoir: lake.geojson, level: 109 m}]
breach:
  dam: dam.geojson
  crest: 110.5 m
  trigger: {at: 20 s}
  shape: {bottom_width: 20 m, side_slope: 1.0, invert: 105.5 m}
  growth: {law: linear, duration: 20 s}
resolution: 5 m
time: {end: 80 s}
outputs: {every: 10 s}
";

/// A valley that falls to the east by 1 %, with a lake behind a dam in its upper part.
fn scene() -> TempDir {
    let folder = TempDir::new().unwrap();
    let cell = |column: usize, row: usize| {
        let (x, y) = (column as f64 * 5.0, row as f64 * 5.0 - 60.0);
        format!("{:.4}", 105.0 - 0.01 * x + 0.0035 * y * y + 0.2 * (0.07 * x).sin() * (0.11 * y).cos())
    };
    let row = |row: usize| (0..COLUMNS).map(|column| cell(column, row)).collect::<Vec<_>>().join(" ");
    let header = "ncols 60\nnrows 25\nxllcorner 500000\nyllcorner 5300000\ncellsize 5\nNODATA_value -9999\n";
    let dem = header.to_owned() + &(0..ROWS).map(row).collect::<Vec<_>>().join("\n") + "\n";
    let feature = |kind: &str, coordinates: &str| {
        format!(r#"{{"type":"Feature","properties":{{}},"geometry":{{"type":"{kind}","coordinates":{coordinates}}}}}"#)
    };
    let lake = "[[[500003,5300003],[500101,5300003],[500101,5300122],[500003,5300122],[500003,5300003]]]";
    for (name, text) in [
        ("dem.asc", dem),
        ("lake.geojson", feature("Polygon", lake)),
        // Askew to the lattice.
        ("dam.geojson", feature("LineString", "[[500098,5300002],[500112,5300123]]")),
        ("s.yaml", SCENARIO.to_owned()),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// Runs the scene with a setting; returns `run.json` and the folder of the run.
#[track_caller]
fn run(folder: &TempDir, out: &str, setting: &str) -> (serde_json::Value, PathBuf) {
    let answer = floodsim(folder.path(), &["run", "s.yaml", "--out", out, "--quiet", "--set", setting]);
    assert_eq!(answer.code, 0, "{}", answer.stderr);
    let out = folder.path().join(out);
    let text = std::fs::read_to_string(out.join("run.json")).unwrap();
    (serde_json::from_str(&text).unwrap(), out)
}

#[test]
fn a_dam_breaks_before_resting_and_moving_particles() {
    let folder = scene();
    let mut volumes = Vec::new();
    for motion in ["eulerian", "lagrangian"] {
        let (run, out) = run(&folder, motion, &format!("numerics.motion={motion}"));
        let record = &run["breach"];
        assert!((record["began_s"].as_f64().unwrap() - 20.0).abs() < 1e-12, "{record}");
        assert!((record["invert_m"].as_f64().unwrap() - 105.5).abs() < 1e-12, "{record}");
        assert!(run["gates"].as_array().unwrap().iter().all(|gate| gate["passed"] == true));
        let volume = |key: &str| run["volume_m3"][key].as_f64().unwrap();
        assert!(volume("error_relative").abs() < 1e-12 && (volume("final") / volume("initial") - 1.0).abs() < 1e-12);
        let fields = Netcdf::read(&out.join("fields.nc"));
        let (depth, x) = (fields.values("depth"), fields.values("x"));
        let cells = COLUMNS * ROWS;
        let below = |frame: usize| {
            let of = |&cell: &usize| x[cell % COLUMNS] > 500_116.0 && depth[frame * cells + cell].is_finite();
            25.0 * (0..cells).filter(of).map(|cell| depth[frame * cells + cell]).sum::<f64>()
        };
        let y = fields.values("y");
        let above = |frame: usize| {
            // To the left of the dam as the file draws it; the dam itself is askew.
            let of = |&cell: &usize| {
                let (x, y) = (x[cell % COLUMNS] - 500_098.0, y[cell / COLUMNS] - 5_300_002.0);
                14.0 * y - 121.0 * x > 0.0 && depth[frame * cells + cell].is_finite()
            };
            25.0 * (0..cells).filter(of).map(|cell| depth[frame * cells + cell]).sum::<f64>()
        };
        for frame in 0..=2 {
            assert!(below(frame).abs() <= 0.0, "{motion}: {} m3 beyond a dam that stands", below(frame));
        }
        volumes.push([below(4), below(8), volume("initial")]);
        let sections = std::fs::read_to_string(out.join("tables/sections.csv")).unwrap();
        let row: Vec<&str> = sections.lines().find(|line| line.starts_with("breach,")).unwrap().split(',').collect();
        let number = |column: usize| row[column].parse::<f64>().unwrap();
        let lost = volume("initial") - above(8);
        println!("{motion}: through the dam {} m3, lost by the lake {lost} m3", number(5));
        assert!(number(2) >= 20.0 && number(3) > 0.0 && number(4) > 20.0, "{row:?}");
        assert!((number(5) / lost - 1.0).abs() < if motion == "eulerian" { 1e-6 } else { 0.02 }, "{row:?}");
        let arrival = Netcdf::read(&out.join("maps.nc")).values("arrival_time").to_vec();
        let first = (0..cells).filter(|cell| x[cell % COLUMNS] > 500_116.0 && arrival[*cell] > 0.0);
        assert!(first.map(|cell| arrival[cell]).fold(f64::INFINITY, f64::min) > 20.0);
    }
    println!("beyond the dam after 40 s, after 80 s, initial (m3): {volumes:?}");
    let [resting, moving] = volumes[..] else { panic!("two runs") };
    assert!((moving[2] / resting[2] - 1.0).abs() < 1e-2 && resting[1] > 0.2 * resting[2]);
    assert!((moving[1] / resting[1] - 1.0).abs() < 0.2, "{volumes:?}");
}

/// The scene with a dam from a place at its southern edge to one at its northern edge (m from the western edge), the lake ending so far
/// before the line of the dam (m), and a cross-section below.
fn scene_with_dam(from: f64, to: f64, before: f64) -> TempDir {
    let folder = scene();
    let feature = |kind: &str, coordinates: String| {
        format!(r#"{{"type":"Feature","properties":{{}},"geometry":{{"type":"{kind}","coordinates":{coordinates}}}}}"#)
    };
    let (x, end) = (|x: f64| 500_000.0 + x, |x: f64| 500_000.0 + x - before);
    let ends = [(x(from), 5_300_000.5), (x(to), 5_300_124.5)].map(|(x, y)| format!("[{x},{y}]"));
    let lake = [(x(3.0), 0.5), (end(from), 0.5), (end(to), 124.5), (x(3.0), 124.5), (x(3.0), 0.5)];
    let lake = lake.map(|(x, y)| format!("[{x},{}]", 5_300_000.0 + y));
    for (name, text) in [
        ("dam.geojson", feature("LineString", format!("[{}]", ends.join(",")))),
        ("lake.geojson", feature("Polygon", format!("[[{}]]", lake.join(",")))),
        ("below.geojson", feature("LineString", "[[500200,5300001],[500200,5300124]]".to_owned())),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let without = SCENARIO.split("breach:").next().unwrap().to_owned()
        + "resolution: 5 m\ntime: {end: 60 s}\noutputs: {every: 60 s, sections: below.geojson}\n";
    let dam = "breach: {dam: dam.geojson, crest: 110.5 m, growth: instantaneous}\n";
    for (name, text) in [
        ("without.yaml", without.clone()),
        ("gone.yaml", without.clone() + dam),
        ("stands.yaml", without + &dam.replace("growth", "trigger: {at: 0.001 s}, growth")),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// What a run of the scene found: the volume at its start (m³), the greatest discharge below (m³/s), the depths of the maps.
fn found(folder: &TempDir, scenario: &str, motion: &str) -> (f64, f64, Vec<u64>) {
    let setting = format!("numerics.motion={motion}");
    let file = format!("{scenario}.yaml");
    let answer =
        floodsim(folder.path(), &["run", &file, "--out", scenario, "--overwrite", "--quiet", "--set", &setting]);
    assert_eq!(answer.code, 0, "{}", answer.stderr);
    let out = folder.path().join(scenario);
    let run: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(out.join("run.json")).unwrap()).unwrap();
    let sections = std::fs::read_to_string(out.join("tables/sections.csv")).unwrap();
    let row: Vec<&str> = sections.lines().nth(1).unwrap().split(',').collect();
    let maps = Netcdf::read(&out.join("maps.nc"));
    let bits = ["max_depth", "arrival_time", "bed_elevation"].map(|name| maps.values(name).to_vec()).concat();
    let volume = run["volume_m3"]["initial"].as_f64().unwrap();
    (volume, row[3].parse::<f64>().unwrap().abs(), bits.into_iter().map(f64::to_bits).collect())
}

#[test]
fn a_whole_dam_that_goes_at_the_start_is_the_run_without_it() {
    // Along the lattice through the middle of cells, along an edge of theirs, and askew.
    for (from, to) in [(102.5, 102.5), (100.0, 100.0), (80.0, 120.0)] {
        let folder = scene_with_dam(from, to, 0.0);
        let [without, gone] = ["without", "gone"].map(|scenario| found(&folder, scenario, "eulerian"));
        assert_eq!(without, gone, "{from} m to {to} m");
        assert!(without.1 > 100.0, "{} m3/s", without.1);
        // Cells that could move rest where a dam was, so that the water goes on otherwise than without it.
        let [without, gone] = ["without", "gone"].map(|scenario| found(&folder, scenario, "lagrangian"));
        println!("{from} m to {to} m: peaks {} and {} m3/s", without.1, gone.1);
        assert!((gone.0 / without.0 - 1.0).abs() < 1e-12 && (gone.1 / without.1 - 1.0).abs() < 0.03);
    }
}

#[test]
fn the_shore_before_a_dam_is_no_sill_in_its_opening() {
    // The lake ends 4 m before the line of the dam, within a cell; along the lattice and askew.
    for (from, to) in [(102.5, 102.5), (98.0, 112.0)] {
        let folder = scene_with_dam(from, to, 4.0);
        let [without, stands] = ["without", "stands"].map(|scenario| found(&folder, scenario, "eulerian"));
        let (volume, peak) = (stands.0 / without.0 - 1.0, stands.1 / without.1 - 1.0);
        println!("{from} m to {to} m: volume {volume:+.4}, peak {peak:+.4} of that without a dam");
        // A dam takes the room of its cells from the lake, where the rim of the lake runs through them. With the sill the peak was 30 % low.
        assert!(volume.abs() < 0.03 && peak.abs() < 0.03, "{volume}, {peak}");
    }
}

#[test]
fn what_leaks_beside_a_dam_that_goes_at_the_start_is_told_and_its_opening_is_not() {
    let folder = scene_with_dam(102.5, 102.5, 0.0);
    let reported = |scenario: &str| floodsim(folder.path(), &["check", scenario]).stdout.contains("leaking-rim");
    assert!(reported("without.yaml") && !reported("gone.yaml"));
    // A dam that ends in the middle of the valley.
    let short = r#"{"type":"Feature","properties":{},"geometry":{"type":"LineString","coordinates":[[500102.5,5300000.5],[500102.5,5300062.5]]}}"#;
    std::fs::write(folder.path().join("dam.geojson"), short).unwrap();
    assert!(reported("gone.yaml"));
}

#[test]
fn a_dam_with_bends_holds_and_its_lake_is_not_told_to_leak() {
    let folder = scene();
    let line = [(98.0, 2.0), (120.0, 50.0), (100.0, 80.0), (112.0, 123.0)];
    let place = |(x, y): (f64, f64)| format!("[{},{}]", 500_000.0 + x, 5_300_000.0 + y);
    let write = |name: &str, kind: &str, coordinates: String| {
        let text = format!(
            r#"{{"type":"Feature","properties":{{}},"geometry":{{"type":"{kind}","coordinates":{coordinates}}}}}"#
        );
        std::fs::write(folder.path().join(name), text).unwrap();
    };
    write("dam.geojson", "LineString", format!("[{}]", line.map(place).join(",")));
    // At its bends the dam has cells that meet at a corner only. The lake ends at its line, then up to two cells before it.
    for before in [0.0, 4.0, 8.0] {
        let rim = line.map(|(x, y)| (x - before, y));
        let corners = [&[(3.0, 2.0)][..], &rim, &[(3.0, 123.0), (3.0, 2.0)]].concat();
        let corners: Vec<String> = corners.into_iter().map(place).collect();
        write("lake.geojson", "Polygon", format!("[[{}]]", corners.join(",")));
        let check = floodsim(folder.path(), &["check", "s.yaml"]);
        assert!(check.code == 0 && !check.stdout.contains("leaking-rim"), "{before} m: {}", check.stdout);
        let (run, out) = run(&folder, &format!("to_{before}"), "breach.trigger={at: 60 s}");
        // Drawn short of the dam the lake reaches up to it all the same, but for the share of cells that its rim cuts at the foot of the dam.
        let volume = run["volume_m3"]["initial"].as_f64().unwrap();
        println!("{before} m before the dam: {volume} m3");
        assert!((volume / 22_690.0 - 1.0).abs() < 0.03, "{before} m: {volume} m3");
        // Nothing stirs while it stands.
        let fields = Netcdf::read(&out.join("fields.nc"));
        let cells = COLUMNS * ROWS;
        let (speeds, depths) = (fields.values("velocity_x"), fields.values("depth"));
        for cell in 0..5 * cells {
            assert!(!speeds[cell].is_finite() || speeds[cell].abs() < 1e-9, "{before} m: {} m/s", speeds[cell]);
            assert!(depths[cell].to_bits() == depths[cell % cells].to_bits(), "{before} m: {} m", depths[cell]);
        }
    }
}

#[test]
fn a_list_of_breaches_is_refused_in_words_of_its_own() {
    let folder = scene();
    let text = SCENARIO.split("breach:").next().unwrap();
    let dam = "{dam: dam.geojson, crest: 110.5 m}";
    for (list, said) in [
        (format!("[{dam}, {dam}]"), "`breach` is a list of 2, and one dam breaks in a run"),
        (format!("[{dam}]"), "write its keys without the dash or the brackets"),
    ] {
        let text = format!("{text}breach: {list}\nresolution: 5 m\ntime: {{end: 80 s}}\n");
        std::fs::write(folder.path().join("s.yaml"), text).unwrap();
        crate::assert_check(folder.path(), 3, &["error[one-breach] breach (s.yaml:6:9)", said, "remedy"]);
    }
}

#[test]
fn a_breach_that_grows_begins_at_the_same_time_on_every_lattice() {
    let folder = TempDir::new().unwrap();
    let scenario = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/breach/scenario.yaml");
    let arrivals = ["20 m", "25 m", "30 m", "40 m"].map(|resolution| {
        let (resolution, scenario) = (format!("resolution={resolution}"), scenario.to_str().unwrap());
        let settings = [&resolution, "time.end=480 s", "outputs.every=480 s", "outputs.isochrones=[5 min]"];
        let settings = settings.iter().flat_map(|setting| ["--set", setting]);
        let command: Vec<&str> =
            ["run", scenario, "--out", "out", "--overwrite", "--quiet"].into_iter().chain(settings).collect();
        let answer = floodsim(folder.path(), &command);
        assert_eq!(answer.code, 0, "{}", answer.stderr);
        let sections = std::fs::read_to_string(folder.path().join("out/tables/sections.csv")).unwrap();
        let row = sections.lines().find(|line| line.starts_with("breach,")).unwrap();
        row.split(',').nth(2).unwrap().parse::<f64>().unwrap()
    });
    let [first, last] =
        [arrivals.iter().copied().fold(f64::INFINITY, f64::min), arrivals.iter().copied().fold(0.0, f64::max)];
    assert!(first > 400.0 && last < first + 10.0, "{arrivals:?} s");
}

#[test]
fn the_variational_formulation_knows_no_dam_that_breaks() {
    let folder = scene();
    let check = floodsim(folder.path(), &["check", "s.yaml", "--set", "numerics={formulation: variational}"]);
    assert!(check.stdout.contains("error[method-combination] breach") && check.code == 3, "{}", check.stdout);
}

#[test]
fn a_crest_written_as_a_text_is_told_as_such() {
    let folder = scene();
    let text = std::fs::read_to_string(folder.path().join("dam.geojson")).unwrap();
    std::fs::write(folder.path().join("dam.geojson"), text.replace("{}", r#"{"crest_m":"110,5"}"#)).unwrap();
    std::fs::write(folder.path().join("s.yaml"), SCENARIO.replace("  crest: 110.5 m\n", "")).unwrap();
    let check = floodsim(folder.path(), &["check", "s.yaml"]);
    assert_eq!(check.code, 4, "{}", check.stdout);
    for part in ["error[no-crest] breach.dam", "crest_m (the text `110,5`, which is no number)"] {
        assert!(check.stdout.contains(part), "check does not say `{part}`:\n{}", check.stdout);
    }
}
