//! Scenarios of channels alone, without terrain, through the whole program: what they compute, what is written, what is refused.

mod profiles;
mod refused;

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::{Netcdf, changed, floodsim};

/// A river of trapezoids, 8 m wide at its bed with sides of two in one, that falls by 1 in 500. The lines of this scenario are counted
/// on by the tests.
const SCENARIO: &str = "\
floodsim: 1
roughness: {manning: 0.03}
channels:
  - id: river
    length: 2 km
    sections: x.csv
    upstream: {discharge: 40 m3/s}
    downstream: {normal_depth: {slope: 0.002}}
    gauges: [{id: weir, distance: 803 m}, {id: mouth, distance: 2 km}]
resolution: 10 m
time: {end: 3 h}
outputs: {every: 30 min, gauges_every: 10 min}
";

struct Scene {
    folder: TempDir,
}

impl Scene {
    fn of(scenario: &str) -> Scene {
        let scene = Scene { folder: TempDir::new().unwrap() };
        scene.write("s.yaml", scenario);
        scene.write("x.csv", &trapezoids(0.002));
        scene
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: &str) {
        std::fs::write(self.path(name), content).unwrap();
    }

    /// Runs the scene; returns `run.json` and the folder of the run.
    #[track_caller]
    fn run(&self) -> (serde_json::Value, PathBuf) {
        let answer = floodsim(self.folder.path(), &["run", "s.yaml", "--out", "out", "--quiet", "--overwrite"]);
        assert_eq!(answer.code, 0, "{}", answer.stderr);
        let out = self.path("out");
        (serde_json::from_str(&std::fs::read_to_string(out.join("run.json")).unwrap()).unwrap(), out)
    }

    fn check(&self) -> (i32, String) {
        let answer = floodsim(self.folder.path(), &["check", "s.yaml"]);
        (answer.code, answer.stdout + &answer.stderr)
    }
}

/// The sections of the river with a slope of its bed, which is at 100 m at the far end.
fn trapezoids(slope: f64) -> String {
    let section = |x: f64| {
        let bed = 100.0 - slope * x;
        format!("{x},{bed},8\n{x},{},24\n", bed + 4.0)
    };
    format!("distance_m,elevation_m,width_m\n{}{}", section(0.0), section(2000.0))
}

/// Depth (m) of uniform flow in the river (discharge m³/s), by bisection of Manning's formula.
fn normal_depth(discharge: f64, slope: f64, manning: f64) -> f64 {
    let (mut low, mut high) = (0.0, 4.0);
    for _ in 0..60 {
        let d: f64 = 0.5 * (low + high);
        let (area, perimeter) = ((8.0 + 2.0 * d) * d, 8.0 + 2.0 * d * 5.0_f64.sqrt());
        let carried = area * (area / perimeter).powf(2.0 / 3.0) * slope.sqrt() / manning;
        if carried < discharge { low = d } else { high = d }
    }
    low
}

/// The rows of a table as fields; the first one is its header.
fn table(folder: &Path, name: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(folder.join("tables").join(name)).unwrap();
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn number(field: &str) -> f64 {
    field.parse().unwrap()
}

fn files(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            found.push(format!("{name}/"));
            found.extend(files(&path).into_iter().map(|inner| format!("{name}/{inner}")));
        } else {
            found.push(name);
        }
    }
    found.sort();
    found
}

fn axes(names: &[&str]) -> String {
    let feature = |name: &&str| {
        format!(
            r#"{{"type":"Feature","properties":{{"id":"{name}"}},"geometry":{{"type":"LineString","coordinates":[[500000,5300000],[500050,5300000],[500050,5300050]]}}}}"#
        )
    };
    let crs = r#"{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::25832"}}"#;
    let all: Vec<String> = names.iter().map(feature).collect();
    format!(r#"{{"type":"FeatureCollection","crs":{crs},"features":[{}]}}"#, all.join(","))
}

#[test]
fn uniform_flow_takes_its_normal_depth_sub_and_supercritical() {
    for (slope, manning) in [(0.002, 0.03), (0.03, 0.02)] {
        let normal = normal_depth(40.0, slope, manning);
        let (area, top) = ((8.0 + 2.0 * normal) * normal, 8.0 + 4.0 * normal);
        let froude = 40.0 / area / (9.81 * area / top).sqrt();
        assert_eq!(froude > 1.0, slope > 0.01, "Froude number {froude}");
        let level = format!("discharge: 40 m3/s, level: {} m", 100.0 + normal);
        let text = changed(
            SCENARIO,
            &[
                ("manning: 0.03", "manning: 0"),
                ("length: 2 km", &format!("length: 2 km\n    manning: {manning}")),
                ("slope: 0.002", &format!("slope: {slope}")),
                ("discharge: 40 m3/s", if froude > 1.0 { &level } else { "discharge: 40 m3/s" }),
            ],
        );
        let scene = Scene::of(&text);
        scene.write("x.csv", &trapezoids(slope));
        let (run, out) = scene.run();
        let volume = &run["volume_m3"];
        assert!((number(&volume["in"].to_string()) / (40.0 * 10_800.0) - 1.0).abs() < 1e-9, "{volume}");
        assert!(volume["error_relative"].as_f64().unwrap().abs() < 1e-12, "{volume}");
        let rows = table(&out, "channels.csv");
        for row in &rows[rows.len() - 200..] {
            let (depth, velocity, discharge) = (number(&row[4]), number(&row[6]), number(&row[7]));
            assert!((depth / normal - 1.0).abs() < 0.005, "slope {slope}, normal depth {normal}: {row:?}");
            assert!((velocity * area / 40.0 - 1.0).abs() < 0.005, "slope {slope}: {row:?}");
            assert!((discharge / 40.0 - 1.0).abs() < 0.005, "slope {slope}: {row:?}");
        }
    }
}

#[test]
fn uniform_flow_over_a_berm_is_uniform_from_the_first_particle_on() {
    // A bed of 8 m and berms of 15 m on both sides, 1.5 m higher, with water that is faster than its own waves.
    let mut sections = String::from("distance_m,elevation_m,width_m\n");
    for x in [0.0, 2000.0] {
        let bed = 100.0 - 0.003 * x;
        for (rise, width) in [(0.0, 8.0), (1.5, 10.0), (1.5, 40.0), (4.0, 42.0)] {
            sections += &format!("{x},{},{width}\n", bed + rise);
        }
    }
    let changes =
        [("manning: 0.03", "manning: 0.024"), ("discharge: 40", "discharge: 60"), ("slope: 0.002", "slope: 0.003")];
    let scene = Scene::of(&changed(SCENARIO, &changes));
    scene.write("x.csv", &sections);
    let (_, out) = scene.run();
    let rows = table(&out, "channels.csv");
    let last = &rows[rows.len() - 200..];
    let (depth, velocity) = (number(&last[100][4]), number(&last[100][6]));
    assert!(depth > 1.6 && velocity > (9.81 * (depth - 1.5)).sqrt(), "{:?}", last[100]);
    for row in last {
        // With a level for each strip by itself the first particle was 0.1 % too deep.
        assert!(
            (number(&row[4]) / depth - 1.0).abs() < 1e-5 && (number(&row[6]) / velocity - 1.0).abs() < 1e-4,
            "{row:?}"
        );
        assert!((number(&row[7]) - 60.0).abs() < 1e-5, "{row:?}");
    }
}

#[test]
fn a_lake_rests_in_sections_of_any_width_and_bed() {
    // Beds that rise above the lake and fall below it, in sections that widen, narrow and step.
    let mut sections = String::from("distance_m,elevation_m,width_m\n");
    for k in 0..41 {
        let (x, k) = (50.0 * f64::from(k), f64::from(k));
        let (bed, wide) = (100.0 + 2.5 * (1.7 * k).sin(), 6.0 + 4.0 * (2.3 * k).cos());
        for (rise, share) in [(0.0, 0.2), (0.7, 1.0), (0.7, 1.5), (4.0, 2.0)] {
            sections += &format!("{x},{},{}\n", bed + rise, wide * share);
        }
    }
    let ends = "    upstream: {discharge: 40 m3/s}\n    downstream: {normal_depth: {slope: 0.002}}\n";
    let scene = Scene::of(&changed(SCENARIO, &[(ends, "    water: [{level: 101 m}]\n"), ("3 h", "30 min")]));
    scene.write("x.csv", &sections);
    let (run, out) = scene.run();
    let speed = run["max_speed_m_s"].as_f64().unwrap();
    assert!(speed < 1e-12, "{speed:e} m/s");
    let rows = table(&out, "channels.csv");
    let wet: Vec<&Vec<String>> = rows[rows.len() - 200..].iter().filter(|row| number(&row[4]) > 0.0).collect();
    assert!(wet.len() > 100 && wet.len() < 190, "{} particles with water", wet.len());
    assert!(wet.iter().all(|row| row[5] == "101.00000" && row[7] == "0.000000"), "{wet:?}");
}

#[test]
fn a_run_has_what_a_channel_has_and_nothing_of_a_map() {
    let scene = Scene::of(SCENARIO);
    let (run, out) = scene.run();
    let expected = [
        "channels.nc",
        "run.json",
        "scenario.resolved.yaml",
        "tables/",
        "tables/boundaries.csv",
        "tables/channel_gauge_series.csv",
        "tables/channel_gauges.csv",
        "tables/channels.csv",
        "tables/mass_balance.csv",
    ];
    assert_eq!(files(&out), expected);
    assert_eq!((&run["bed_particles"], &run["particles"]["peak"]), (&0.into(), &200.into()));
    let gates = run["gates"].to_string();
    assert!(gates.contains("volume balance") && !gates.contains("grid"), "{gates}");
    for row in &table(&out, "mass_balance.csv")[1..] {
        assert!(row[1] == row[6] && row[5] == "0.000", "{row:?}");
    }
    let report = floodsim(scene.folder.path(), &["report", "out"]);
    assert!(
        report.code == 4 && report.stderr.contains("error[no-maps]") && report.stderr.contains("has channels alone"),
        "{}",
        report.stderr
    );
    // The resolved scenario gives the same run.
    let again = ["run", "out/scenario.resolved.yaml", "--out", "again", "--quiet"];
    assert_eq!(floodsim(scene.folder.path(), &again).code, 0);
    for name in ["tables/channels.csv", "tables/channel_gauge_series.csv", "tables/mass_balance.csv"] {
        let read = |run: &str| std::fs::read(scene.path(run).join(name)).unwrap();
        assert_eq!(read("out"), read("again"), "{name}");
    }
}

#[test]
fn gauges_lie_between_the_particles_of_the_profiles() {
    let scene = Scene::of(SCENARIO);
    let (_, out) = scene.run();
    let series = table(&out, "channel_gauge_series.csv");
    assert_eq!(series[0].join(","), "id,time_s,depth_m,level_m,velocity_m_s,discharge_m3_s");
    assert_eq!(series.len(), 1 + 2 * 19);
    let profiles = table(&out, "channels.csv");
    let mut compared = 0;
    for row in series.iter().filter(|row| row[0] == "weir") {
        let at = |place: &str| profiles.iter().find(|p| p[1] == row[1] && p[2] == place);
        let (Some(above), Some(below)) = (at("795.000"), at("805.000")) else { continue };
        for (column, of_gauge) in [(4, &row[2]), (6, &row[4]), (7, &row[5])] {
            let between = 0.2 * number(&above[column]) + 0.8 * number(&below[column]);
            assert!((between - number(of_gauge)).abs() < 1e-4, "{row:?}: {above:?}, {below:?}");
        }
        compared += 1;
    }
    assert_eq!(compared, 7);
    let last = |id: &str| series.iter().rfind(|row| row[0] == id).unwrap()[2].clone();
    let profile_end = profiles.last().unwrap();
    assert_eq!((last("mouth"), profile_end[2].as_str()), (profile_end[4].clone(), "1995.000"));
    let results = table(&out, "channel_gauges.csv");
    assert_eq!(
        results[0].join(","),
        "id,channel,distance_m,bed_m,arrival_s,max_depth_m,max_level_m,time_of_max_s,max_speed_m_s,peak_discharge_m3_s,time_of_peak_s"
    );
    let weir = &results[1];
    assert_eq!((weir[0].as_str(), weir[1].as_str(), weir[3].as_str()), ("weir", "river", "98.3940"));
    // The front runs on a dry bed at a few metres a second.
    assert!((100.0..1000.0).contains(&number(&weir[4])) && number(&results[2][4]) > number(&weir[4]), "{results:?}");
    assert!((number(&weir[9]) / 40.0 - 1.0).abs() < 0.05, "{weir:?}");
}

#[test]
fn a_plan_of_channels_alone_holds_the_run() {
    let scene = Scene::of(SCENARIO);
    let answer = floodsim(scene.folder.path(), &["plan", "s.yaml", "--json"]);
    assert_eq!(answer.code, 0, "{}", answer.stderr);
    let plan: serde_json::Value = serde_json::from_str(&answer.stdout).unwrap();
    let (run, out) = scene.run();
    let bound = |key: &str, which: usize| plan[key][which].as_f64().unwrap();
    assert_eq!((&plan["particles"]["bed"], &plan["particles"]["channels"]), (&0.into(), &200.into()));
    assert!(run["particles"]["peak"].as_f64().unwrap() <= plan["particles"]["peak"][1].as_f64().unwrap(), "{plan}");
    let steps = run["steps"].as_f64().unwrap();
    assert!(bound("steps", 0) <= steps && steps <= bound("steps", 1), "{steps}: {plan}");
    let size: u64 = ["channels.nc", "tables/channels.csv", "tables/channel_gauge_series.csv"]
        .iter()
        .map(|name| out.join(name).metadata().unwrap().len())
        .sum();
    assert!(size as f64 / 1e6 <= bound("disk_mb", 1), "{size}: {plan}");
}

#[test]
fn a_run_of_less_than_a_litre_can_be_read_in_its_tables() {
    let scene = Scene::of(
        "\
floodsim: 1
roughness: {manning: 0.01}
channels:
  - id: f
    length: 1 m
    width: 1 cm
    bed: 0 m
    water: [{depth: 1 cm, to: 0.3 m}]
    upstream: {discharge: 0.01 l/s}
    downstream: {type: free}
    gauges: [{id: p1, distance: 0.5 m}]
resolution: 1 cm
time: {end: 2 s}
",
    );
    let (_, out) = scene.run();
    let balance = table(&out, "mass_balance.csv");
    // 0.3 m by 1 cm by 1 cm at the start, and 0.01 l/s for 2 s.
    assert!((number(&balance[1][1]) - 3e-5).abs() < 1e-12, "{:?}", balance[1]);
    let last = &balance[balance.len() - 1];
    let [stored, came, left] = [1, 2, 3].map(|column| number(&last[column]));
    assert!((came - 2e-5).abs() < 1e-8 && (stored - (3e-5 + came - left)).abs() < 2e-8, "{last:?}");
    let ways = table(&out, "boundaries.csv");
    assert!(ways[1..].iter().any(|row| (number(&row[1]) - 2e-5).abs() < 1e-8), "{ways:?}");
}
