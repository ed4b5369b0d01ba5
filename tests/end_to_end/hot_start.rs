//! Runs that begin with the state of an earlier one, with rivers and with areas of a depth.

mod other_cells;
mod refused;

use std::path::PathBuf;

use tempfile::TempDir;

use crate::{Netcdf, floodsim};

/// Columns and rows of the terrain.
const COLUMNS: usize = 60;
const ROWS: usize = 25;

/// The lines of this scenario are counted on by the tests.
const SCENARIO: &str = "\
floodsim: 1
crs: EPSG:25832
terrain: dem.asc
roughness: {manning: 0.03}
initial: [{reservoir: lake.geojson, level: 109 m}]
boundaries: [{side: west, discharge: 40 m3/s}, {side: east, normal_depth: {slope: 0.01}}]
resolution: 5 m
time: {end: 60 s}
outputs: {every: 10 s}
";

struct Scene {
    folder: TempDir,
}

impl Scene {
    /// A valley that falls to the east by 1 %, with a lake in its upper part that is let go.
    fn sound() -> Scene {
        let scene = Scene { folder: TempDir::new().unwrap() };
        let cell = |column: usize, row: usize| {
            let (x, y) = (column as f64 * 5.0, row as f64 * 5.0 - 60.0);
            let bumps = 0.4 * (0.07 * x).sin() * (0.11 * y).cos();
            format!("{:.4}", 105.0 - 0.01 * x + 0.0035 * y * y + bumps)
        };
        let rows: Vec<String> =
            (0..ROWS).map(|row| (0..COLUMNS).map(|column| cell(column, row)).collect::<Vec<_>>().join(" ")).collect();
        let header = "ncols 60\nnrows 25\nxllcorner 500000\nyllcorner 5300000\ncellsize 5\nNODATA_value -9999\n";
        scene.write("dem.asc", &(header.to_owned() + &rows.join("\n") + "\n"));
        scene.feature(
            "lake.geojson",
            "Polygon",
            "[[[500003,5300003],[500101,5300003],[500101,5300122],[500003,5300122],[500003,5300003]]]",
        );
        scene.write("s.yaml", SCENARIO);
        scene
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: &str) {
        std::fs::write(self.path(name), content).unwrap();
    }

    fn feature(&self, name: &str, kind: &str, coordinates: &str) {
        let geometry = format!(r#"{{"type":"{kind}","coordinates":{coordinates}}}"#);
        let feature = format!(r#"{{"type":"Feature","properties":{{}},"geometry":{geometry}}}"#);
        let crs = r#""crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::25832"}}"#;
        self.write(name, &format!(r#"{{"type":"FeatureCollection",{crs},"features":[{feature}]}}"#));
    }

    /// A lake on the whole valley.
    fn flood_all(&self) {
        let all = "[[[500000,5300000],[500300,5300000],[500300,5300125],[500000,5300125],[500000,5300000]]]";
        self.feature("lake.geojson", "Polygon", all);
    }

    /// Runs the scene into a folder, with changes; returns `run.json` and `fields.nc`.
    #[track_caller]
    fn run(&self, out: &str, changes: &[&str]) -> (serde_json::Value, Netcdf) {
        let changes: Vec<&str> = changes.iter().flat_map(|change| ["--set", change]).collect();
        let answer =
            floodsim(self.folder.path(), &[&["run", "s.yaml", "--out", out, "--quiet"][..], &changes].concat());
        assert_eq!(answer.code, 0, "{}", answer.stderr);
        assert!(!answer.stderr.contains("HDF5"), "{}", answer.stderr);
        let text = std::fs::read_to_string(self.path(out).join("run.json")).unwrap();
        (serde_json::from_str(&text).unwrap(), Netcdf::read(&self.path(out).join("fields.nc")))
    }

    /// Asserts that the check with these changes ends with an exit code and says all these texts.
    #[track_caller]
    fn assert_check(&self, changes: &[&str], code: i32, expected: &[&str]) {
        let changes: Vec<&str> = changes.iter().flat_map(|change| ["--set", change]).collect();
        let check = floodsim(self.folder.path(), &[&["check", "s.yaml"][..], &changes].concat());
        assert_eq!(check.code, code, "{}", check.stdout);
        for text in expected {
            assert!(check.stdout.contains(text), "check does not say `{text}`, but\n{}", check.stdout);
        }
    }
}

fn volume(run: &serde_json::Value, key: &str) -> f64 {
    run["volume_m3"][key].as_f64().unwrap()
}

/// The values of a frame, the last one for none.
fn frame<'a>(fields: &'a Netcdf, name: &str, number: Option<usize>) -> &'a [f64] {
    let cells = COLUMNS * ROWS;
    let number = number.unwrap_or(fields.dimensions["time"] - 1);
    &fields.values(name)[number * cells..][..cells]
}

#[test]
fn two_halves_are_the_whole() {
    let scene = Scene::sound();
    let (whole, whole_fields) = scene.run("whole", &[]);
    let (first, first_fields) = scene.run("first", &["time.end=30 s"]);
    let (second, second_fields) = scene.run("second", &["time.end=30 s", "initial=[{fields: first/fields.nc}]"]);
    assert!(first.get("hot_start").is_none());
    assert!(second["hot_start"]["path"].as_str().unwrap().ends_with("fields.nc"), "{second}");
    // What the second begins with is what the first ended with, to single precision.
    let handed_on = volume(&second, "initial") / volume(&first, "final") - 1.0;
    assert!(handed_on.abs() < 1e-7, "{handed_on:e}");
    for name in ["depth", "water_level", "velocity_x", "velocity_y"] {
        let (end, start) = (frame(&first_fields, name, None), frame(&second_fields, name, Some(0)));
        let worst = end.iter().zip(start).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Levels of 100 m in single precision, and films without velocity.
        assert!(worst < 2e-5, "{name} differs by {worst:e} between the end of one run and the start of the next");
    }
    // Inflow is that of the whole; storage and outflow differ as far as the steps of the two do.
    let relative = |key: &str, sum: f64| sum / volume(&whole, key) - 1.0;
    let balance = [
        relative("in", volume(&first, "in") + volume(&second, "in")),
        relative("out", volume(&first, "out") + volume(&second, "out")),
        relative("final", volume(&second, "final")),
    ];
    assert!(volume(&whole, "out") > 100.0, "water must have left by the end: {whole}");
    assert!(balance[0].abs() < 1e-9 && balance[1].abs() < 1e-5 && balance[2].abs() < 1e-5, "{balance:?}");
    for run in [&whole, &first, &second] {
        assert!(volume(run, "error_relative").abs() < 1e-12);
    }
    let (a, b) = (frame(&whole_fields, "depth", None), frame(&second_fields, "depth", None));
    let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    let rms = (square / a.iter().filter(|depth| **depth > 1e-3).count() as f64).sqrt();
    let worst = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // The step that ends the first run is cut, and all steps after it are others; five times what was found (1.2e-4 and 9.4e-4 m).
    assert!(rms < 6e-4 && worst < 5e-3, "rms {rms:e} m, worst {worst:e} m");
    // The state counts: from the start of the first run the end is another one.
    let (run, wrong) = scene.run("wrong", &["time.end=30 s", "initial=[{fields: first/fields.nc, time: 0 s}]"]);
    let begun = |run: &serde_json::Value| run["hot_start"]["time_s"].as_f64();
    assert_eq!((begun(&run), begun(&second)), (Some(0.0), first["simulated_s"].as_f64()));
    let wrong = frame(&wrong, "depth", None);
    assert!(a.iter().zip(wrong).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) > 0.1);
}

/// The greatest speed (m/s) in the last frame.
fn fastest(fields: &Netcdf) -> f64 {
    let each = ["velocity_x", "velocity_y"]
        .map(|name| frame(fields, name, None).iter().filter(|v| **v > -9000.0).map(|v| v.abs()).fold(0.0, f64::max));
    each[0].max(each[1])
}

/// Volume (m³) in a frame, the last one for none.
fn volume_of(fields: &Netcdf, number: Option<usize>) -> f64 {
    frame(fields, "depth", number).iter().filter(|depth| **depth > 0.0).sum::<f64>() * 25.0
}

/// By how much a uniform stream may be off in depth and velocity (relative) where it goes on from a run of one motion in another, resting
/// ones first: twice what was found. Cells that move slide along those that rest beside the edges, which makes small waves.
const ALLOWED: [[(f64, f64); 2]; 2] = [[(1.5e-3, 1e-3), (6e-3, 1.2e-2)], [(0.03, 0.06), (0.02, 0.04)]];

/// Greatest speed (m/s) of a lake at rest that goes on from a run of one motion in another, Eulerian ones first.
const STILL: [[f64; 2]; 2] = [[1e-12, 1e-12], [1e-12, 1e-12]];

const MOTIONS: [&str; 2] = ["numerics.motion=eulerian", "numerics.motion=lagrangian"];

#[test]
fn a_lake_at_rest_stays_at_rest_over_a_hot_start() {
    let scene = Scene::sound();
    // The whole valley under water to its rim: nothing moves but by rounding.
    scene.flood_all();
    for (first, motion) in MOTIONS.iter().enumerate() {
        let out = format!("first{first}");
        // Where it may rain no water sleeps.
        let rain = "rain={rate: 0 mm/h}";
        let still = ["initial[0].level=107.3 m", "boundaries=[]", "time.end=20 s", motion, rain];
        let (_, before) = scene.run(&out, &still);
        for (second, motion) in MOTIONS.iter().enumerate() {
            let go_on = format!("initial=[{{fields: {out}/fields.nc}}]");
            let changes = ["boundaries=[]", "time.end=20 s", &go_on, motion, rain];
            let (run, fields) = scene.run(&format!("second{first}{second}"), &changes);
            let handed_on = volume(&run, "initial") / volume_of(&before, None) - 1.0;
            println!("{first} {second}: {:.1e} m/s, volume {handed_on:.1e}", fastest(&fields));
            assert!(handed_on.abs() < 1e-14 && volume(&run, "error_relative").abs() < 1e-13, "{handed_on:e}");
            let allowed = STILL[first][second];
            assert!(fastest(&fields) < allowed, "{first} {second}: {:e} m/s", fastest(&fields));
        }
    }
}

#[test]
fn a_film_at_the_shore_of_a_lake_keeps_its_ground() {
    let scene = Scene::sound();
    scene.flood_all();
    let (_, before) = scene.run("first", &["initial[0].level=107.3 m", "boundaries=[]", "time.end=1 s"]);
    scene.run("second", &["boundaries=[]", "time.end=1 s", "initial=[{fields: first/fields.nc}]"]);
    let [first, second] = ["first", "second"].map(|out| Netcdf::read(&scene.path(&format!("{out}/maps.nc"))));
    let (depth, bed) = (frame(&before, "depth", Some(0)), [&first, &second].map(|maps| maps.values("bed_elevation")));
    let wet: Vec<usize> = (0..COLUMNS * ROWS).filter(|&cell| depth[cell] > 0.0).collect();
    assert!(wet.iter().any(|&cell| depth[cell] < 1e-3), "there are films, of which the fields have no level");
    for cell in wet {
        // Single precision of 107 m.
        assert!(
            (bed[0][cell] - bed[1][cell]).abs() < 1e-5,
            "{} m deep: {} m, {} m",
            depth[cell],
            bed[0][cell],
            bed[1][cell]
        );
    }
}

#[test]
fn a_uniform_stream_goes_on() {
    let scene = Scene::sound();
    let rows: Vec<String> = (0..ROWS)
        .map(|_| (0..COLUMNS).map(|column| format!("{}", 50.0 - 0.01 * column as f64)).collect::<Vec<_>>().join(" "))
        .collect();
    let header = "ncols 60\nnrows 25\nxllcorner 500000\nyllcorner 5300000\ncellsize 5\nNODATA_value -9999\n";
    scene.write("dem.asc", &(header.to_owned() + &rows.join("\n") + "\n"));
    scene.flood_all();
    // Manning: 1 m deep at sqrt(0.002)/0.03.
    let velocity = 0.002_f64.sqrt() / 0.03;
    let stream = format!(
        "boundaries=[{{side: west, discharge: {} m3/s}}, {{side: east, normal_depth: {{slope: 0.002}}}}]",
        125.0 * velocity
    );
    // Five cells from the rim.
    let is_inside = |cell: usize| (5..55).contains(&(cell % COLUMNS)) && (5..20).contains(&(cell / COLUMNS));
    let off = |fields: &Netcdf, number: usize| {
        let worst = |name: &str, wanted: f64| {
            let values = frame(fields, name, Some(number)).iter().enumerate().filter(|(cell, _)| is_inside(*cell));
            values.map(|(_, value)| (value / wanted - 1.0).abs()).fold(0.0, f64::max)
        };
        (worst("depth", 1.0), worst("velocity_x", velocity))
    };
    for (first, motion) in MOTIONS.iter().enumerate() {
        let out = format!("first{first}");
        let (_, before) = scene.run(
            &out,
            &[&stream, "initial=[{water: lake.geojson, depth: 1 m}]", "time.end=600 s", "outputs.every=60 s", motion],
        );
        for (second, motion) in MOTIONS.iter().enumerate() {
            let go_on = format!("initial=[{{fields: {out}/fields.nc}}]");
            let (run, fields) = scene.run(
                &format!("second{first}{second}"),
                &[&stream, "time.end=60 s", "outputs.every=1 s", &go_on, motion],
            );
            let handed_on = volume(&run, "initial") / volume_of(&before, None) - 1.0;
            assert!(handed_on.abs() < 1e-14 && volume(&run, "error_relative").abs() < 1e-12, "{handed_on:e}");
            let (depth, speed) =
                (0..61).map(|k| off(&fields, k)).fold((0.0_f64, 0.0_f64), |a, b| (a.0.max(b.0), a.1.max(b.1)));
            println!("{first} {second}: depth off by {depth:.1e}, velocity by {speed:.1e} at worst");
            let (depth_allowed, speed_allowed) = ALLOWED[first][second];
            assert!(depth < depth_allowed && speed < speed_allowed, "{first} {second}: {depth:e}, {speed:e}");
        }
    }
}

#[test]
fn two_halves_of_moving_particles_are_as_near_as_the_two_motions() {
    let scene = Scene::sound();
    let rms = |a: &Netcdf, b: &Netcdf| {
        let (a, b) = (frame(a, "depth", None), frame(b, "depth", None));
        let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
        (square / a.iter().filter(|depth| **depth > 1e-3).count() as f64).sqrt()
    };
    let [(resting, resting_fields), (whole, whole_fields)] =
        [("resting", MOTIONS[0]), ("whole", MOTIONS[1])].map(|(out, motion)| scene.run(out, &[motion]));
    let spread = rms(&resting_fields, &whole_fields);
    for (number, motion) in MOTIONS.iter().enumerate() {
        let out = format!("first{number}");
        let (first, first_fields) = scene.run(&out, &["time.end=30 s", motion]);
        let go_on = format!("initial=[{{fields: {out}/fields.nc}}]");
        let (second, fields) = scene.run(&format!("second{number}"), &["time.end=30 s", &go_on, MOTIONS[1]]);
        let handed_on = volume(&second, "initial") / volume_of(&first_fields, None) - 1.0;
        assert!(handed_on.abs() < 1e-14 && volume(&second, "error_relative").abs() < 1e-12, "{handed_on:e}");
        let relative = |key: &str, sum: f64| sum / volume(&whole, key) - 1.0;
        let inflow = relative("in", volume(&first, "in") + volume(&second, "in"));
        let out = relative("out", volume(&first, "out") + volume(&second, "out"));
        let resting_out = relative("out", volume(&resting, "out"));
        println!(
            "{number}: rms {:.2} m of the whole and {:.2} m of the resting one, {spread:.2} m between these; outflow {out:.3}, {resting_out:.3}",
            rms(&whole_fields, &fields),
            rms(&resting_fields, &fields)
        );
        assert!(inflow.abs() < 1e-9 && out.abs() < 0.1, "{inflow:e}, {out}");
        assert!(rms(&whole_fields, &fields) < 1.5 * spread && rms(&resting_fields, &fields) < 1.5 * spread);
    }
}

#[test]
fn rivers_and_ponds_begin_with_their_depth() {
    let scene = Scene::sound();
    scene.feature("river.geojson", "LineString", "[[499990,5300062],[500310,5300062]]");
    scene.feature(
        "pond.geojson",
        "Polygon",
        "[[[500100,5300100],[500110,5300100],[500110,5300110],[500100,5300110],[500100,5300100]]]",
    );
    let initial = "initial=[{river: river.geojson, depth: 80 cm, width: 12 m}, {water: pond.geojson, depth: 0.5 m}]";
    let (run, fields) = scene.run("out", &[initial, "time.end=10 s"]);
    let depth = frame(&fields, "depth", Some(0));
    let count = |wanted: f64| depth.iter().filter(|depth| (**depth - wanted).abs() < 1e-6).count();
    assert_eq!((count(0.8), count(0.5)), (60 * 3, 4));
    assert!((volume(&run, "initial") - 25.0 * (60.0 * 3.0 * 0.8 + 4.0 * 0.5)).abs() < 1e-6);
    assert!(volume(&run, "error_relative").abs() < 1e-12);
    let (moving, _) = scene.run("moving", &[initial, "time.end=10 s", "boundaries=[]", "numerics.motion=lagrangian"]);
    assert!((volume(&moving, "initial") - volume(&run, "initial")).abs() < 1e-6);
    assert!(volume(&moving, "error_relative").abs() < 1e-12);
    let plan = floodsim(scene.folder.path(), &["plan", "s.yaml", "--set", initial, "--set", "time.end=10 s"]);
    assert_eq!(plan.code, 0, "{}", plan.stderr);
}

#[test]
fn an_output_folder_that_holds_an_input_is_refused_and_left_alone() {
    let scene = Scene::sound();
    scene.run("first", &[]);
    let fields = std::fs::read(scene.path("first/fields.nc")).unwrap();
    let water = "initial: [{reservoir: lake.geojson, level: 109 m}]";
    let next = SCENARIO.replace(water, "initial: [{fields: first/fields.nc}]");
    std::os::unix::fs::symlink("first", scene.path("link")).unwrap();
    for folder in ["first", "link", "../first", "."] {
        let folder =
            folder.replace("../first", &format!("../{}/first", scene.folder.path().file_name().unwrap().display()));
        scene.write("s.yaml", &next.replace("outputs: {", &format!("outputs: {{folder: {folder}, ")));
        for arguments in [&["check", "s.yaml"][..], &["run", "s.yaml", "--overwrite", "--quiet"]] {
            let answer = floodsim(scene.folder.path(), arguments);
            let said = answer.stdout + &answer.stderr;
            assert_eq!(answer.code, 8, "{said}");
            let located = "error[input-in-output-folder] initial[0].fields (s.yaml:5:20)";
            assert!(said.contains(located) && said.contains("remedy"), "{said}");
        }
        assert!(std::fs::read(scene.path("first/fields.nc")).unwrap() == fields, "the input was changed");
    }
    scene.write("s.yaml", &next);
    let other = floodsim(scene.folder.path(), &["run", "s.yaml", "--out", "second", "--overwrite", "--quiet"]);
    assert_eq!(other.code, 0, "{}", other.stderr);
}
