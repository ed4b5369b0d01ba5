//! Boundaries, sections and rain where cells move, and what the variational formulation refuses of them.

use super::*;

#[test]
fn the_variational_formulation_refuses_what_it_does_not_know() {
    let more = "sources: [{at: [1100, 2030], discharge: 1 m3/s}, {line: springs.geojson, discharge: 1 m3/s}]\nrain: {rate: 1 mm/h}\nresolution: 5 m";
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
fn a_river_on_cells_that_move_comes_in_and_leaves() {
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
fn water_of_cells_that_move_passes_a_section_as_that_of_resting_ones() {
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
    assert!((peak / resting_peak - 1.0).abs() < 0.2 && (time_of_peak - resting_time).abs() < 20.0, "{found:?}");
    assert!((passed / resting_passed - 1.0).abs() < 0.05, "{found:?}");
}

#[test]
fn rain_on_cells_that_move_runs_off_and_is_booked() {
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
    // All terrain got wet; where water runs off a bank a film of 1 mm is left.
    let wet = Netcdf::read(&out.join("maps.nc")).values("max_depth").iter().filter(|depth| **depth > 0.5e-3).count();
    assert_eq!(wet, 480);
    let again = floodsim(scene.folder.path(), &["run", "s.yaml", "--out", "again", "--quiet", "--threads", "3"]);
    assert_eq!(again.code, 0, "{}", again.stderr);
    for name in ["tables/sections.csv", "tables/boundaries.csv", "tables/mass_balance.csv"] {
        let read = |run: &str| std::fs::read_to_string(scene.path(run).join(name)).unwrap();
        assert_eq!(read("out"), read("again"), "{name}");
    }
}

#[test]
fn a_channel_too_narrow_for_cells_that_move_is_told() {
    for (spacing, is_told) in [("15 m", true), ("5 m", false)] {
        let numerics = format!("numerics: {{motion: lagrangian}}\nresolution: {spacing}");
        let scene = Scene::with(&[("resolution: 5 m", &numerics)]);
        let answer = floodsim(scene.folder.path(), &["run", "s.yaml", "--out", "out", "--quiet"]);
        assert_eq!(answer.code, 0, "{}", answer.stderr);
        assert_eq!(answer.stderr.contains("warning[nothing-moves] numerics.motion"), is_told, "{}", answer.stderr);
        let record = std::fs::read_to_string(scene.path("out/run.json")).unwrap();
        assert_eq!(record.contains("no cell moves"), is_told);
    }
}
