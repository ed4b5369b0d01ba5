//! What checks and runs find of the water: that it stands at a closed edge, still rises at the end, or runs off nowhere.

use std::path::Path;

use tempfile::TempDir;

use crate::{assert_check, changed, feature, floodsim, run_scene};

/// A plain of 300 m by 100 m that falls to the east by 1 %, from 10 m; a lake in the west of it, and what is open.
const SCENARIO: &str = "\
floodsim: 1
crs: local
terrain: dem.asc
roughness: {manning: 0.03}
initial: [{reservoir: lake.geojson, level: 11 m}]
boundaries: [{side: east, type: open}]
resolution: 5 m
time: {end: 20 min}
outputs: {every: 1 min}
";

/// The same in rain.
const RAIN: &str = "\
floodsim: 1
crs: local
terrain: dem.asc
roughness: {manning: 0.03}
rain: {rate: 60 mm/h, duration: 20 min}
boundaries: [{side: east, type: open}]
resolution: 5 m
time: {end: 2 h}
outputs: {every: 30 min}
";

/// The scene of a scenario with changes, on a plain from which a depth (m) is taken in some cells.
fn plain(scenario: &str, changes: &[(&str, &str)], pit: impl Fn(usize, usize) -> f64) -> TempDir {
    let folder = TempDir::new().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let cell = |row: usize, column: usize| format!("{}", 10.0 - 0.05 * (column as f64 + 0.5) - pit(row, column));
    let row = |row: usize| (0..60).map(|column| cell(row, column)).collect::<Vec<_>>().join(" ");
    let header = "ncols 60\nnrows 20\nxllcorner 1000\nyllcorner 2000\ncellsize 5\nNODATA_value -9999\n";
    write("dem.asc", &(header.to_owned() + &(0..20).map(row).collect::<Vec<_>>().join("\n") + "\n"));
    write("lake.geojson", &feature("Polygon", "[[1000,2000],[1050,2000],[1050,2100],[1000,2100],[1000,2000]]"));
    write("s.yaml", &changed(scenario, changes));
    folder
}

/// The codes of the warnings of a run, and its record.
#[track_caller]
fn run(folder: &Path) -> (Vec<String>, serde_json::Value, String) {
    let (record, answer) = run_scene(folder, "out", &["--overwrite"]);
    let warnings = record["warnings"].as_array().cloned().unwrap_or_default();
    let codes = warnings.iter().map(|warning| warning["code"].as_str().unwrap().to_owned()).collect();
    (codes, record, answer.stderr)
}

fn has(codes: &[String], code: &str) -> bool {
    codes.iter().any(|one| one == code)
}

#[test]
fn water_that_the_edge_cuts_off_is_told_until_a_wall_is_said_to_stand_there() {
    let folder = plain(SCENARIO, &[], |_, _| 0.0);
    // The lake has 100 m of the western edge and 50 m of each side; 1.475 m are the most of them.
    let found =
        ["warning[closed-edge] initial[0].reservoir (s.yaml:5", "over 200 m", "up to 1.48 m deep", "type: closed"];
    assert_check(folder.path(), 0, &found);
    let plan = floodsim(folder.path(), &["plan", "s.yaml"]);
    assert!(format!("{}{}", plan.stdout, plan.stderr).contains("closed-edge"), "{}", plan.stderr);
    let sides = "boundaries: [{side: east, type: open}, {side: west, type: closed}]";
    let west = plain(SCENARIO, &[("boundaries: [{side: east, type: open}]", sides)], |_, _| 0.0);
    assert_check(west.path(), 0, &["over 100 m"]);
    let all = "boundaries: [{side: east, type: open}, {side: all, type: closed}]";
    let known = plain(SCENARIO, &[("boundaries: [{side: east, type: open}]", all)], |_, _| 0.0);
    let answer = floodsim(known.path(), &["check", "s.yaml"]);
    assert!(!answer.stdout.contains("closed-edge") && answer.code == 0, "{}", answer.stdout);
    let (codes, record, _) = run(known.path());
    assert!(!has(&codes, "closed-edge") && record["closed_edge"].is_null(), "{codes:?}");
    // What another entry opens stays open.
    assert!(record["volume_m3"]["out"].as_f64().unwrap() > 1000.0, "{}", record["volume_m3"]);
}

#[test]
fn a_flood_that_comes_to_a_closed_edge_is_told_where_and_how_deep() {
    let closed = ("boundaries: [{side: east, type: open}]", "boundaries: [{side: west, type: closed}]");
    let folder = plain(SCENARIO, &[closed], |_, _| 0.0);
    let (codes, record, said) = run(folder.path());
    assert!(has(&codes, "closed-edge"), "{codes:?}");
    assert!(said.contains("warning[closed-edge] boundaries\n") && said.contains("of the closed edge"), "{said}");
    assert!(record["closed_edge"]["deepest_m"].as_f64().unwrap() > 0.5, "{}", record["closed_edge"]);
    let page = floodsim(folder.path(), &["report", "out"]);
    assert_eq!(page.code, 0, "{}", page.stderr);
    let page = std::fs::read_to_string(folder.path().join("out/report/index.html")).unwrap();
    assert!(page.contains("of the closed edge of the terrain"));
}

#[test]
fn a_side_is_not_closed_and_open_at_once() {
    let sides = "boundaries: [{side: east, type: open}, {side: east, type: closed}]";
    let folder = plain(SCENARIO, &[("boundaries: [{side: east, type: open}]", sides)], |_, _| 0.0);
    assert_check(folder.path(), 3, &["error[conflict] boundaries[1]", "`boundaries[0]` opens this side"]);
}

#[test]
fn a_flood_that_still_grows_at_the_end_is_told() {
    let short = plain(SCENARIO, &[("end: 20 min", "end: 30 s"), ("every: 1 min", "every: 5 s")], |_, _| 0.0);
    let (codes, record, said) = run(short.path());
    assert!(has(&codes, "run-too-short"), "{codes:?}");
    assert!(said.contains("warning[run-too-short] time.end\n  the flood still grows when the run ends"), "{said}");
    let growth = &record["growth_at_end"];
    let (share, last) = (growth["share"].as_f64().unwrap(), growth["last_arrival_s"].as_f64().unwrap());
    // The front runs on to the end, and slows down.
    assert!((0.03..0.12).contains(&share) && (27.0..=30.0).contains(&last), "{growth}");
    let (codes, record, _) = run(plain(SCENARIO, &[], |_, _| 0.0).path());
    assert!(!has(&codes, "run-too-short") && record["growth_at_end"].is_null(), "{codes:?}");
}

#[test]
fn rain_in_films_and_pits_is_in_the_balance_and_told() {
    // Half a millimetre, below which nothing flows.
    let thin = plain(RAIN, &[("rate: 60 mm/h", "rate: 1.5 mm/h")], |_, _| 0.0);
    let (codes, record, said) = run(thin.path());
    let held = &record["volume_m3"]["held_back"];
    let of = |held: &serde_json::Value, key: &str| held[key].as_f64().unwrap();
    assert!((of(held, "in_films_m3") / 15.0 - 1.0).abs() < 1e-9 && of(held, "in_pits_m3").abs() < 1e-12, "{held}");
    assert!(has(&codes, "rain-held-back") && said.contains("100 % of the rain runs off nowhere"), "{codes:?} {said}");

    // 20 mm on a pit of 20 m by 20 m: what falls on it and on the 100 m of plain above it stays there, 48 m³, and what runs in over its sides. With
    // the films it is all that is there in the end.
    let pit = |row: usize, column: usize| if (8..12).contains(&row) && (20..24).contains(&column) { 0.5 } else { 0.0 };
    let (codes, record, said) = run(plain(RAIN, &[], pit).path());
    let held = &record["volume_m3"]["held_back"];
    assert!((of(held, "of_rain_m3") / 600.0 - 1.0).abs() < 1e-9, "{held}");
    let all = of(held, "in_pits_m3") + of(held, "in_films_m3");
    assert!((48.0..80.0).contains(&of(held, "in_pits_m3")), "{held}");
    assert!((record["volume_m3"]["final"].as_f64().unwrap() / all - 1.0).abs() < 0.01, "{held}");
    assert!(has(&codes, "rain-held-back") && said.contains("in pits of the bed below their rims"), "{codes:?} {said}");

    // What runs off is not held.
    let (codes, record, _) = run(plain(RAIN, &[("rate: 60 mm/h", "rate: 120 mm/h")], |_, _| 0.0).path());
    let held = &record["volume_m3"]["held_back"];
    assert!(of(held, "in_pits_m3").abs() < 1e-12 && of(held, "in_films_m3") < 30.0, "{held}");
    assert!(!has(&codes, "rain-held-back"), "{codes:?}");
}
