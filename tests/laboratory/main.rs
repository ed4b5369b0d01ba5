//! Experiments with measurements, as `floodsim validate` runs them; left out, in plain words, where their data are not there.
#![allow(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

use std::path::{Path, PathBuf};
use std::process::Command;

use floodsim::validation::{Row, Status, rows_from_csv};

/// The folder of the data, by the variable `FLOODSIM_DATA`, or beside the repository.
fn data() -> PathBuf {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    std::path::absolute(std::env::var_os("FLOODSIM_DATA").map_or_else(beside, PathBuf::from)).unwrap()
}

/// Exit code, what was said, and the rows of one experiment at its coarse resolution, run from a folder that is not that of the source.
fn validate(experiment: &str, data: &Path, methods: &str) -> (i32, String, Vec<Row>) {
    let folder = tempfile::tempdir().unwrap();
    let (csv, figures) = (folder.path().join("rows.csv"), folder.path().join("figures"));
    let output = Command::new(env!("CARGO_BIN_EXE_floodsim"))
        .current_dir(&folder)
        .env("FLOODSIM_DATA", data)
        .args(["validate", experiment, "--threads", "2"])
        .args(methods.split(' ').flat_map(|family| ["--vary", family]))
        .args([Path::new("--csv"), &csv, Path::new("--figures"), &figures])
        .output()
        .unwrap();
    let rows = rows_from_csv(&std::fs::read_to_string(&csv).unwrap()).unwrap();
    if !rows.is_empty() {
        let members: Vec<&str> = methods.split(' ').map(|family| family.split_once('=').unwrap().1).collect();
        let figure = figures.join(format!("{experiment}_{}.svg", members.join("_")));
        let figure = std::fs::read_to_string(figure).unwrap();
        assert!(figure.starts_with("<svg") && figure.contains("<polyline"));
    }
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap(), rows)
}

/// The rows of an experiment; none, with a line on why, where its data are not there.
fn rows(experiment: &str, folder: &str, methods: &str) -> Option<Vec<Row>> {
    if !data().join(folder).is_dir() {
        println!("{experiment} skipped, because {} is not there", data().join(folder).display());
        return None;
    }
    let (_, said, rows) = validate(experiment, &data(), methods);
    assert_eq!(rows.len(), 1, "{said}");
    Some(rows)
}

#[test]
fn the_front_through_a_gap_is_not_before_that_of_ritter() {
    let Some(rows) = rows("parma_partial_dam_break", "parma_dbdb", "motion=eulerian") else { return };
    assert_eq!((rows[0].status, rows[0].norm.as_str()), (Status::Pass, "none"), "{}", rows[0].note);
    assert!(rows[0].note.contains("A120 "), "{}", rows[0].note);
}

#[test]
fn the_reservoir_before_a_box_falls_as_measured() {
    let Some(rows) = rows("marin_box", "kleefsman_marin", "motion=eulerian") else { return };
    // docs/validation/laboratory.md has the errors at both resolutions; hydrostatic water comes down faster than the real one.
    assert!(rows[0].error_depth.unwrap() < 0.04, "{:?}", rows[0]);
    assert_eq!(rows[0].status, Status::Holds);
}

#[test]
fn the_jump_before_a_building_moves_upstream_as_measured() {
    let Some(plain) = rows("isolated_obstacle", "isolated_obstacle", "motion=eulerian turbulence=none") else { return };
    let Some(mixed) = rows("isolated_obstacle", "isolated_obstacle", "motion=eulerian turbulence=mixing_length") else {
        return;
    };
    // 0.0179 m without and 0.0162 m with mixing at 10 cm (0.0216 m without where no cell follows the walls); the limit is 0.020 m.
    assert_eq!((plain[0].status, mixed[0].status), (Status::Pass, Status::Pass), "{plain:?} {mixed:?}");
    assert!(mixed[0].error_depth < plain[0].error_depth);
    assert!(mixed[0].note.starts_with("turbulence mixing_length; RMSE in m: G1 "), "{}", mixed[0].note);
}

#[test]
fn the_building_at_the_scale_of_the_field_is_that_of_the_flume() {
    let Some(rows) = rows("ea_test6b_scaled", "ea_test6b", "motion=eulerian") else { return };
    // Measured at 2 m: 0.316 m from the measurements, 0.058 m from the flume at the same number of cells, on another raster: the building is
    // eight cells long. At 1 m, where the limit of 0.04 m holds, 0.022 m.
    assert!(rows[0].error_depth.unwrap() < 0.36, "{:?}", rows[0]);
    let apart = rows[0].note.split("RMSE from the flume times 20 in m: ").nth(1).unwrap();
    assert!(apart.split(' ').next().unwrap().parse::<f64>().unwrap() < 0.06, "{apart}");
}

#[test]
fn a_round_column_collapses_over_a_wet_bed() {
    let Some(rows) = rows("radial_dam_break", "radial_dam_break", "motion=eulerian") else { return };
    // Within the acceptance limits of 1 m at 2 m already.
    assert_eq!((rows[0].status, rows[0].norm.as_str()), (Status::Pass, "mean_relative"), "{}", rows[0].note);
}

#[test]
fn a_pond_is_left_at_the_level_of_its_sill() {
    let Some(rows) = rows("ea_test1", "ea_test1", "motion=eulerian") else { return };
    assert_eq!((rows[0].status, rows[0].norm.as_str()), (Status::Pass, "max_abs_gauges"), "{}", rows[0].note);
    assert!(rows[0].error_depth.unwrap() <= 0.02, "{}", rows[0].note);
}

#[test]
fn a_flood_over_a_plain_is_symmetric_and_in_time() {
    let Some(rows) = rows("ea_test4", "ea_test4", "motion=eulerian") else { return };
    assert_eq!(rows[0].status, Status::Pass, "{}", rows[0].note);
    assert!(rows[0].note.contains("maps and their mirror images: arrival 0.0e0 apart at most"), "{}", rows[0].note);
}

#[test]
fn a_wave_runs_up_a_valley_as_measured_up_to_25_s() {
    let Some(rows) = rows("monai_valley", "monai_valley", "motion=eulerian") else { return };
    assert_eq!((rows[0].status, rows[0].norm.as_str()), (Status::Pass, "rmse_gauges"), "{}", rows[0].note);
    // Each of the gauges by itself, in the note.
    for gauge in ["ch5", "ch7", "ch9"] {
        let error = rows[0].note.split(&format!("{gauge} ")).nth(1).unwrap();
        assert!(error.split(',').next().unwrap().parse::<f64>().unwrap() <= 0.006, "{}", rows[0].note);
    }
}

#[test]
fn the_flood_of_merewether_reaches_its_marks() {
    let Some(rows) = rows("merewether", "merewether", "motion=eulerian") else { return };
    assert_eq!((rows[0].status, rows[0].norm.as_str()), (Status::Pass, "mean_abs_marks"), "{}", rows[0].note);
    assert!(rows[0].error_depth.unwrap() <= 0.15, "{}", rows[0].note);
}

#[test]
fn the_flood_of_malpasset_comes_when_and_as_high_as_it_did() {
    let Some(rows) = rows("malpasset", "malpasset", "motion=eulerian") else { return };
    // Measured at 40 m: 3.20 m at the gauges of the scale model, arrival 59 s off, which is short of the acceptance limit of 20 m.
    assert!(rows[0].error_depth.unwrap() < 3.4, "{:?}", rows[0]);
    let arrival = rows[0].note.split("mean absolute error of arrival ").nth(1).unwrap().split(' ').next().unwrap();
    assert!(arrival.parse::<f64>().unwrap() <= 60.0, "{}", rows[0].note);
}

#[test]
fn the_lake_of_malpasset_and_the_sea_rest_while_the_dam_stands() {
    if !data().join("malpasset").is_dir() {
        println!("skipped, because {} is not there", data().join("malpasset").display());
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/malpasset/dam_standing.yaml");
    for resolution in ["20 m", "{finest: 10 m, coarsest: 80 m}"] {
        let output = Command::new(env!("CARGO_BIN_EXE_floodsim"))
            .env("FLOODSIM_DATA", data())
            .args([Path::new("run"), &scenario, Path::new("--out"), folder.path(), Path::new("--overwrite")])
            // Where it may rain no water sleeps.
            .args(["--set", "rain={rate: 0 mm/h}", "--set", "time.end=60 s", "--set", "outputs.every=60 s"])
            .args(["--set", &format!("resolution={resolution}"), "--set", "outputs.write=[tables]"])
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let record = std::fs::read_to_string(folder.path().join("run.json")).unwrap();
        let record: serde_json::Value = serde_json::from_str(&record).unwrap();
        let speed = record["max_speed_m_s"].as_f64().unwrap();
        assert!(speed < 1e-12 && record["steps"].as_u64().unwrap() > 50, "{resolution}: {speed:e} m/s");
    }
}

#[test]
fn without_data_a_case_is_left_out_in_plain_words() {
    let nowhere = tempfile::tempdir().unwrap();
    let (code, said, rows) = validate("marin_box", nowhere.path(), "motion=eulerian");
    assert_eq!((code, rows.len()), (4, 0), "{said}");
    assert!(said.contains("skipped, because FLOODSIM_DATA holds no folder `kleefsman_marin`"), "{said}");
}

#[test]
fn a_suite_without_any_data_is_no_success() {
    let nowhere = tempfile::tempdir().unwrap();
    for data in [Some(nowhere.path()), None] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_floodsim"));
        command.args(["validate", "--suite", "field"]).env_remove("FLOODSIM_DATA").current_dir(&nowhere);
        let output = command.envs(data.map(|folder| ("FLOODSIM_DATA", folder))).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(4), "{said}");
        assert!(
            said.contains("error[no-data] FLOODSIM_DATA\n") && said.contains("merewether, malpasset not run"),
            "{said}"
        );
        assert!(said.contains("remedy  set FLOODSIM_DATA to the folder of the data"), "{said}");
    }
}

#[test]
fn moving_particles_are_left_out_of_channels() {
    let (code, said, rows) = validate("rajar_a", &data(), "motion=lagrangian");
    assert_eq!((code, rows.len()), (2, 0), "{said}");
    assert!(
        said.contains("skipped, because it is for Eulerian particles: it is about channels in one dimension"),
        "{said}"
    );
    assert!(said.contains("nothing was run"), "{said}");
}

#[test]
fn reaches_in_one_dimension_give_what_two_give() {
    for (flume, bound) in [("rajar_a", 0.045), ("rajar_b", 0.016)] {
        let (code, said, rows) = validate(flume, &data(), "motion=eulerian");
        assert_eq!((code, rows.len()), (0, 1), "{said}\n{rows:?}");
        // The acceptance limit asks for CPU time saved, too, which a busy machine may miss: it is reported here, and the command holds the run to it.
        // The acceptance limit of the difference is 0.05; measured are 0.043 in A, where the lower reach is off most, and 0.015 in B (0.010 before
        // decision 0036); along the axis below the dam 0.024 and 0.005 (docs/validation/laboratory.md).
        assert!(rows[0].error_depth.is_some_and(|error| error < bound), "{:?}", rows[0]);
        let along_the_axis = rows[0].note.split("coupled ").skip(1);
        let along_the_axis: Vec<f64> =
            along_the_axis.filter_map(|text| text.split(" %").next()?.parse().ok()).collect();
        assert!(along_the_axis.len() == 2 && along_the_axis.iter().all(|percent| *percent < 3.0), "{:?}", rows[0]);
        assert!(rows[0].note.contains(" % saved of "), "{}", rows[0].note);
    }
}
