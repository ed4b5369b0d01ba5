//! Tracers through the whole program: what is written of them, in both motions, and what is refused.

use std::collections::BTreeSet;
use std::path::PathBuf;

use tempfile::TempDir;

use crate::{Netcdf, assert_check, changed, feature, floodsim, run_scene};

/// A channel of 240 m by 80 m on a slope of 2 %, with a square of marked water and an inflow of another tracer.
const SCENARIO: &str = "\
floodsim: 1
crs: local
terrain: dem.asc
roughness: {manning: 0.03}
initial: [{water: all.geojson, depth: 1 m}]
boundaries:
  - {side: east, type: open}
  - {side: west, discharge: 40 m3/s}
sources:
  - {points: two.geojson, discharge: 1 m3/s}
  - {at: [102, 2042], discharge: 2 m3/s}
tracers:
  - {name: spill, from: [{water: spill.geojson, concentration: 100 mg/l}], arrival_threshold: 0.2}
  - {name: salt, half_life: 30 s, from: [{boundary: 2, concentration: 7 g/l}, {source: 2, concentration: 3 g/l}]}
resolution: 4 m
time: {end: 20 s}
outputs: {every: 5 s, gauges: g.csv, gauges_every: 5 s}
";

const MOTIONS: [&str; 2] = ["eulerian", "lagrangian"];

struct Scene {
    folder: TempDir,
}

impl Scene {
    fn with(changes: &[(&str, &str)]) -> Scene {
        let scene = Scene { folder: TempDir::new().unwrap() };
        let row = (0..60).map(|column| format!("{:.2}", 9.0 - 0.08 * column as f64)).collect::<Vec<_>>().join(" ");
        let header = "ncols 60\nnrows 20\nxllcorner 0\nyllcorner 2000\ncellsize 4\nNODATA_value -9999\n";
        scene.write("dem.asc", &(header.to_owned() + &format!("{row}\n").repeat(20)));
        let square = |west: f64, east: f64, south: f64, north: f64| {
            let corners = [(west, south), (east, south), (east, north), (west, north), (west, south)];
            let corners: Vec<String> = corners.iter().map(|(x, y)| format!("[{x},{y}]")).collect();
            feature("Polygon", &format!("[{}]", corners.join(",")))
        };
        scene.write("all.geojson", &square(0.0, 240.0, 2000.0, 2080.0));
        scene.write("spill.geojson", &square(80.0, 104.0, 2032.0, 2052.0));
        scene.write("elsewhere.geojson", &square(800.0, 840.0, 2032.0, 2052.0));
        let points = [feature("Point", "42,2022"), feature("Point", "42,2062")].join(",");
        scene.write("two.geojson", &format!(r#"{{"type":"FeatureCollection","features":[{points}]}}"#));
        scene.write("g.csv", "id,x,y\nG,90,2042\n");
        scene.write("s.yaml", &changed(SCENARIO, changes));
        scene
    }

    fn of(motion: &str) -> Scene {
        Scene::with(&[("resolution: 4 m", &format!("numerics: {{motion: {motion}}}\nresolution: 4 m"))])
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: &str) {
        std::fs::write(self.path(name), content).unwrap();
    }
}

/// The balance of a tracer in `run.json`.
fn balance(run: &serde_json::Value, name: &str) -> serde_json::Value {
    let all = run["tracers"].as_array().unwrap();
    all.iter().find(|tracer| tracer["name"] == name).unwrap().clone()
}

#[test]
fn tracers_are_carried_and_written() {
    for motion in MOTIONS {
        let scene = Scene::of(motion);
        let (run, answer) = run_scene(scene.folder.path(), "out", &[]);
        assert!(answer.stdout.contains("tracer spill: 4.800000e4 at the start"), "{}", answer.stdout);
        let [spill, salt] = ["spill", "salt"].map(|name| balance(&run, name));
        let number = |record: &serde_json::Value, key: &str| record[key].as_f64().unwrap();
        // 480 m2 of 1 m with 100 mg/l; 40 m3/s of 7 g/l and 2 m3/s of 3 g/l for 20 s.
        assert!((number(&spill, "initial") / 48_000.0 - 1.0).abs() < 1e-12 && number(&spill, "in") == 0.0);
        assert!((number(&salt, "in") / (20.0 * (280.0 + 6.0)) - 1.0).abs() < 1e-9, "{salt}");
        assert!(number(&salt, "decayed") > 500.0 && spill["unit"] == "mg/l m3");
        for record in [&spill, &salt] {
            assert!(number(record, "error_relative").abs() < 1e-12, "{motion}: {record}");
        }

        let fields = Netcdf::read(&scene.path("out/fields.nc"));
        let (text, all) = &fields.variables["concentration_spill"];
        for expected in ["units", "mg/l", "depth-averaged concentration of spill", "area: mean time: point"] {
            assert!(text.contains(expected), "{text}");
        }
        let (depths, cells) = (fields.values("depth"), 60 * 20);
        assert!((depths.len(), all.len()) == (5 * cells, 5 * cells));
        let stored: f64 = (4 * cells..5 * cells).filter(|&k| depths[k] > 1e-3).map(|k| depths[k] * all[k] * 16.0).sum();
        assert!((stored / number(&spill, "stored") - 1.0).abs() < 1e-5, "{motion}: {stored} of {spill}");
        assert!(depths.iter().zip(all).all(|(depth, of)| if *depth > 1e-3 {
            (0.0..=100.0).contains(of)
        } else {
            *of < -9998.0
        }));

        let maps = Netcdf::read(&scene.path("out/maps.nc"));
        let (greatest, dilution) = (maps.values("max_concentration_spill"), maps.values("dilution_spill"));
        assert!(greatest.iter().zip(dilution).all(|(own, share)| (own - 100.0 * share).abs() < 1e-4 || *own < -9998.0));
        let arrival = maps.values("tracer_arrival_spill");
        let at_start = arrival.iter().filter(|time| **time == 0.0).count();
        let later = arrival.iter().filter(|time| **time > 0.0).count();
        // 30 cells are marked; the water goes some cells on.
        assert!(at_start == 30 && later > 10, "{motion}: {at_start} {later}");
        let reached = greatest.iter().filter(|own| **own >= 20.0).count();
        assert_eq!(at_start + later, reached, "{motion}");
        assert!(
            scene.path("out/cog/max_concentration_salt.tif").is_file()
                && scene.path("out/cog/dilution_salt.qml").is_file()
        );

        let series = std::fs::read_to_string(scene.path("out/tables/gauge_series.csv")).unwrap();
        let mut lines = series.lines();
        assert!(lines.next().unwrap().ends_with(",velocity_y_m_s,concentration_spill,concentration_salt"));
        let first: Vec<f64> = lines.next().unwrap().split(',').skip(6).map(|value| value.parse().unwrap()).collect();
        assert!((first[0] - 100.0).abs() < 1e-9 && first[1] == 0.0, "{first:?}");
        let table = std::fs::read_to_string(scene.path("out/tables/tracers.csv")).unwrap();
        assert!(
            table.starts_with(
                "time_s,tracer,unit,amount,initial,in,out,decayed,error_relative\n0.000,spill,mg/l m3,4.8"
            ),
            "{table}"
        );
        assert_eq!(table.lines().count(), 1 + 2 * 5);
    }
}

#[test]
fn maps_on_the_terrain_have_the_concentration_of_their_cells() {
    let scene = Scene::with(&[("resolution: 4 m", "resolution: 8 m"), ("{every: 5 s", "{cell: terrain, every: 5 s")]);
    run_scene(scene.folder.path(), "out", &[]);
    let maps = Netcdf::read(&scene.path("out/maps.nc"));
    let greatest = maps.values("max_concentration_spill");
    assert_eq!(greatest.len(), 60 * 20);
    // Pixels of a cell of 8 m have one value.
    let blocks = (0..10).flat_map(|row| (0..30).map(move |column| 2 * row * 60 + 2 * column));
    let is_one = |first: usize| [1, 60, 61].iter().all(|more| (greatest[first + more] - greatest[first]).abs() < 1e-6);
    assert!(blocks.into_iter().all(is_one));
    assert!(greatest.iter().any(|own| *own >= 99.0) && greatest.iter().all(|own| (0.0..=100.0).contains(own)));
}

#[test]
fn threads_change_no_byte_of_tracers() {
    for motion in MOTIONS {
        let scene = Scene::of(motion);
        let read = |out: &str, threads: &str| {
            run_scene(scene.folder.path(), out, &["--threads", threads]);
            let table = |name: &str| std::fs::read(scene.path(out).join("tables").join(name)).unwrap();
            let bits = |name: &str| {
                let file = Netcdf::read(&scene.path(out).join(name));
                file.bits()
                    .into_iter()
                    .map(|(name, (text, bits))| (name.to_owned(), text.to_owned(), bits))
                    .collect::<BTreeSet<_>>()
            };
            (table("tracers.csv"), table("gauge_series.csv"), bits("fields.nc"), bits("maps.nc"))
        };
        assert!(read("one", "1") == read("two", "2"), "{motion}");
    }
}

#[test]
fn marked_water_goes_on_with_the_resolved_scenario() {
    let scene = Scene::with(&[]);
    let (first, _) = run_scene(scene.folder.path(), "out", &[]);
    std::fs::copy(scene.path("out/scenario.resolved.yaml"), scene.path("s.yaml")).unwrap();
    let (second, _) = run_scene(scene.folder.path(), "again", &[]);
    assert_eq!(first["tracers"], second["tracers"]);
}

#[test]
fn what_tracers_do_not_go_with_is_refused_with_a_way_out() {
    let nowhere = Scene::with(&[("spill.geojson", "elsewhere.geojson")]);
    assert_check(
        nowhere.folder.path(),
        4,
        &["error[marks-no-water] tracers[0].from[0].water", "no cell with water at the start"],
    );
    let other = Scene::with(&[("boundary: 2", "boundary: 1"), ("source: 2", "source: 3")]);
    assert_check(
        other.folder.path(),
        3,
        &[
            "error[no-such-entry] tracers[1].from[0].boundary",
            "no water comes in by entry 1",
            "error[no-such-entry] tracers[1].from[1].source",
            "there is no entry 3 of `sources`: it has 2",
        ],
    );
    let names = Scene::with(&[("name: spill", "name: 2nd spill"), ("3 g/l", "3 mg/l")]);
    assert_check(
        names.folder.path(),
        3,
        &["error[tracer-name] tracers[0].name", "error[unit] tracers[1].from[1].concentration"],
    );
    let levels = Scene::with(&[("resolution: 4 m", "resolution: {finest: 4 m, coarsest: 16 m}")]);
    assert_check(levels.folder.path(), 3, &["error[method-combination] tracers", "levels of cells carry no tracers"]);
    let particles = Scene::with(&[("resolution: 4 m", "numerics: {formulation: variational}\nresolution: 4 m")]);
    assert_check(particles.folder.path(), 3, &["the particles of the variational formulation carry no tracers"]);
    let channel = Scene::with(&[(
        "resolution: 4 m",
        "channels: [{id: up, length: 100 m, width: 8 m, bed: 10 m, slope: 0.01}]\nresolution: 4 m",
    )]);
    assert_check(channel.folder.path(), 3, &["channels of one dimension carry no tracers"]);
}

#[test]
fn plan_advises_cells_that_move_for_marked_water_without_rain_and_check_says_what_they_cost() {
    let rain = "rain: {rate: 10 mm/h}\nresolution: 4 m";
    for (change, expected) in [("resolution: 4 m", "lagrangian"), (rain, "eulerian")] {
        let scene = Scene::with(&[("resolution: 4 m", change)]);
        let plan = floodsim(scene.folder.path(), &["plan", "s.yaml", "--json"]);
        let plan: serde_json::Value = serde_json::from_str(&plan.stdout).unwrap();
        assert_eq!((&plan["motion"]["advised"], &plan["motion"]["chosen"]), (&expected.into(), &"eulerian".into()));
    }
    let said = |motion: &str| floodsim(Scene::of(motion).folder.path(), &["check", "s.yaml"]).stdout;
    let [resting, moving] = MOTIONS.map(said);
    assert_eq!(resting, "s.yaml: 0 errors, 0 warnings\n");
    assert!(moving.starts_with("s.yaml: 0 errors, 0 warnings\n`motion: lagrangian` takes 5 to 12 times"), "{moving}");
}
