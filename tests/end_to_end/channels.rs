//! Channels of one dimension through the whole program: what is written, and what bad inputs get.

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::{changed, floodsim};

/// A plain that falls to the east by 1 %, 100 m long and 60 m wide, with a bed lower by 1 m in its middle third, where a channel of
/// 20 m comes in from the west. The lines of this scenario are counted on by the tests.
const SCENARIO: &str = "\
floodsim: 1
crs: local
terrain: dem.asc
roughness: {manning: 0.03}
channels:
  - id: upper
    length: 100 m
    width: 20 m
    bed: 10 m
    slope: 0.01
    upstream: {discharge: {series: q.csv, column: q, unit: m3/s, time_unit: min}}
    joins: {side: west, from: 2020, to: 2040}
boundaries:
  - {edge: east, normal_depth: {slope: 0.01}}
resolution: 5 m
time: {end: 2 min}
outputs: {every: 30 s}
";

const SECTIONS: &str = "\
distance_m,elevation_m,width_m
0,11,10
0,11.5,16
0,12.5,20
100,10,10
100,10.5,16
100,11.5,20
";

struct Scene {
    folder: TempDir,
}

impl Scene {
    fn with(changes: &[(&str, &str)], sections: &str) -> Scene {
        let scene = Scene { folder: TempDir::new().unwrap() };
        let cell = |column: usize, row: usize| {
            let low = if (4..8).contains(&row) { 0.0 } else { 1.0 };
            format!("{}", 10.0 - 0.05 * (column as f64 + 0.5) + low)
        };
        let rows: Vec<String> =
            (0..12).map(|row| (0..20).map(|column| cell(column, row)).collect::<Vec<_>>().join(" ")).collect();
        let header = "ncols 20\nnrows 12\nxllcorner 1000\nyllcorner 2000\ncellsize 5\nNODATA_value -9999\n";
        scene.write("dem.asc", &(header.to_owned() + &rows.join("\n") + "\n"));
        scene.write("q.csv", "t,q\n0,0\n0.5,30\n3,30\n");
        scene.write("x.csv", sections);
        scene.write("s.yaml", &changed(SCENARIO, changes));
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
        let answer = floodsim(self.folder.path(), &["run", "s.yaml", "--out", "out", "--quiet"]);
        assert_eq!(answer.code, 0, "{}", answer.stderr);
        let out = self.path("out");
        let text = std::fs::read_to_string(out.join("run.json")).unwrap();
        (serde_json::from_str(&text).unwrap(), out)
    }
}

/// The rows of a table as fields; the first one is its header.
fn table(folder: &Path, name: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(folder.join("tables").join(name)).unwrap();
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

const IN_SECTIONS: [(&str, &str); 3] =
    [("    width: 20 m\n", ""), ("    bed: 10 m\n", ""), ("    slope: 0.01\n", "    sections: x.csv\n")];

#[test]
fn a_hydrograph_comes_down_a_channel_into_the_terrain() {
    for (changes, sections) in [(&[][..], SECTIONS), (&IN_SECTIONS[..], SECTIONS)] {
        let scene = Scene::with(changes, sections);
        let (run, out) = scene.run();
        let volume = &run["volume_m3"];
        // 30 m³/s in 120 s, less what the rise of 30 s lacks.
        assert!((volume["in"].as_f64().unwrap() / (30.0 * 120.0 - 15.0 * 30.0) - 1.0).abs() < 1e-9, "{volume}");
        assert!(volume["error_relative"].as_f64().unwrap().abs() < 1e-12, "{volume}");
        let ways = table(&out, "boundaries.csv");
        let upstream = ways.iter().find(|row| row[0] == "channel upper upstream").unwrap();
        assert!(upstream[1] == "3150.000" && upstream[3] == "3150.000", "{upstream:?}");
        assert!(upstream[4].parse::<f64>().unwrap() < 1e-11, "{upstream:?}");
        let rows = table(&out, "channels.csv");
        assert_eq!(rows[0].join(","), "id,time_s,distance_m,bed_m,depth_m,level_m,velocity_m_s,discharge_m3_s");
        // 20 particles at 0, 30, 60, 90 and 120 s.
        assert_eq!(rows.len(), 1 + 20 * 5);
        let last = rows.last().unwrap();
        assert_eq!((last[0].as_str(), last[1].as_str(), last[2].as_str()), ("upper", "120.000", "97.500"));
        let discharge: f64 = last[7].parse().unwrap();
        assert!((discharge / 30.0 - 1.0).abs() < 0.1, "{last:?}");
        let balance = table(&out, "mass_balance.csv");
        let number = |row: &[String], column: usize| row[column].parse::<f64>().unwrap();
        for row in &balance[1..] {
            assert!((number(row, 1) - number(row, 5) - number(row, 6)).abs() < 0.002, "{row:?}");
        }
        assert!(number(balance.last().unwrap(), 5) > 500.0, "no water came into the terrain");
        let resolved = std::fs::read_to_string(out.join("scenario.resolved.yaml")).unwrap();
        assert!(resolved.contains("joins: {side: west, from: 2020, to: 2040}"), "{resolved}");
    }
}

#[test]
fn water_over_the_banks_of_a_channel_is_told() {
    // 30 m³/s stand higher than banks of 0.51 m and lower than those of 1.5 m.
    let low = SECTIONS.replace("0,12.5,20", "0,11.51,20").replace("100,11.5,20", "100,10.51,20");
    for (sections, is_told) in [(low.as_str(), true), (SECTIONS, false)] {
        let scene = Scene::with(&IN_SECTIONS, sections);
        let answer = floodsim(scene.folder.path(), &["run", "s.yaml", "--out", "out", "--quiet"]);
        assert_eq!(answer.code, 0, "{}", answer.stderr);
        let above = "channel upper: its water stood ";
        assert_eq!(answer.stdout.contains(above), is_told, "{}", answer.stdout);
        let run: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(scene.path("out/run.json")).unwrap()).unwrap();
        let height = run["above_banks"][0]["height_m"].as_f64();
        assert!(height.map_or(!is_told, |height| is_told && (0.01..1.5).contains(&height)), "{height:?}");
    }
}

#[test]
fn a_plan_counts_the_particles_of_channels() {
    let scene = Scene::with(&[], SECTIONS);
    let answer = floodsim(scene.folder.path(), &["plan", "s.yaml", "--json"]);
    assert_eq!(answer.code, 0, "{}", answer.stderr);
    let plan: serde_json::Value = serde_json::from_str(&answer.stdout).unwrap();
    assert_eq!(plan["particles"]["channels"], 20);
    let (run, _) = scene.run();
    let peak = plan["particles"]["peak"][1].as_f64().unwrap();
    assert!(run["particles"]["peak"].as_f64().unwrap() <= peak, "{plan}");
    let text = floodsim(scene.folder.path(), &["plan", "s.yaml"]).stdout;
    assert!(text.contains(", 20 in channels, "), "{text}");
    // The riverbed alone is below this limit.
    let bed = plan["particles"]["bed"].as_u64().unwrap();
    let limit = format!("limits.particles={}", bed + 10);
    let check = floodsim(scene.folder.path(), &["check", "s.yaml", "--set", &limit]);
    assert!(check.code == 5 && check.stdout.contains("with 20 strips of channels exceed"), "{}", check.stdout);
}

#[test]
fn a_sea_that_rises_runs_up_a_channel() {
    let changes = [
        ("    upstream: {discharge: {series: q.csv, column: q, unit: m3/s, time_unit: min}}\n", ""),
        ("normal_depth: {slope: 0.01}", "stage: 12 m"),
        ("end: 2 min", "end: 3 h"),
    ];
    let scene = Scene::with(&changes, SECTIONS);
    let (run, out) = scene.run();
    assert!(run["volume_m3"]["error_relative"].as_f64().unwrap().abs() < 1e-12);
    let rows = table(&out, "channels.csv");
    let level = |row: &Vec<String>| row[5].parse::<f64>().unwrap();
    for row in &rows[rows.len() - 20..] {
        assert!((level(row) - 12.0).abs() < 0.05, "{row:?}");
    }
}

#[test]
fn bad_channels_are_refused_where_they_stand() {
    let width = "width: 20 m";
    let joins = "joins: {side: west, from: 2020, to: 2040}";
    for (changes, sections, place, said) in [
        (vec![(width, "width: 40 m")], SECTIONS, "(s.yaml:12:", "40.000 m wide at its end, wider than its opening"),
        (vec![(width, "width: 10 m")], SECTIONS, "(s.yaml:12:", "narrower than its opening"),
        (
            vec![(joins, "joins: {side: west, from: 20, to: 40}")],
            SECTIONS,
            "(s.yaml:12:",
            "holds no edge of the terrain",
        ),
        (vec![("bed: 10 m", "bed: 12 m")], SECTIONS, "(s.yaml:12:", "ends 2.05 m above the lowest ground"),
        (vec![("length: 100 m", "length: 8 m")], SECTIONS, "(s.yaml:7:", "shorter than 3 particles"),
        (vec![("q.csv", "none.csv")], SECTIONS, "(s.yaml:11:", "none.csv"),
        (
            IN_SECTIONS.to_vec(),
            "distance_m,elevation_m,width_m\n0,11,10\n80,10,10\n",
            "(s.yaml:8:",
            "reach from 0 m to 80 m",
        ),
        (
            IN_SECTIONS.to_vec(),
            "distance_m,elevation_m,width_m\n0,11,10\n0,12,9\n100,10,10\n100,11,10\n",
            "(s.yaml:8:",
            "line 3 of",
        ),
        (
            IN_SECTIONS.to_vec(),
            "distance_m,elevation_m,width_m\n0,11,10\n0,12,11\n100,10,10\n",
            "(s.yaml:8:",
            "has 1 rows, the first one 2",
        ),
        (
            IN_SECTIONS.to_vec(),
            "distance_m,elevation_m,width_m\n0,11,10\n50,-9999,10\n100,10,10\n",
            "(s.yaml:8:",
            "a level that is none on Earth, in",
        ),
        (
            IN_SECTIONS.to_vec(),
            "distance_m,elevation_m,width_m\n0,11,10\n50,10.5,-9999\n100,10,10\n",
            "(s.yaml:8:",
            "line 3 of",
        ),
        (IN_SECTIONS.to_vec(), "distance,elevation,width\n0,11,10\n", "(s.yaml:8:", "has no unit of"),
        (IN_SECTIONS.to_vec(), "distance_m,elevation_m,width_m\n0,11,10\n100,x,10\n", "(s.yaml:8:", "no 3 numbers"),
    ] {
        let scene = Scene::with(&changes, sections);
        let answer = floodsim(scene.folder.path(), &["check", "s.yaml"]);
        let all = answer.stdout + &answer.stderr;
        assert!(all.contains(said) && all.contains(place), "`{said}` {place} is not in\n{all}");
    }
}
