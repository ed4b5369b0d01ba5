//! What changes nothing of the results: threads, intervals of frames, parts that are left out, the resolved scenario.

use super::*;

#[test]
fn one_and_two_threads_give_equal_bytes() {
    // All in one folder, since the record of a run holds it.
    let folder = TempDir::new().unwrap();
    let scenario = shipped("demo");
    let run_as = |name: &str, threads: &str, by_flag: bool| {
        let flag: &[&str] = if by_flag { &["--threads", threads] } else { &[] };
        let mut command = Command::new(assert_cmd::cargo::cargo_bin("floodsim"));
        command.args(["run", &scenario, "--out", "out", "--quiet"]).args(SHORT_DEMO).args(flag);
        command.current_dir(folder.path()).stdout(Stdio::null()).stderr(Stdio::null());
        if !by_flag {
            command.env("SOURCE_DATE_EPOCH", "1704067199").env("RAYON_NUM_THREADS", threads);
        }
        assert!(command.status().unwrap().success());
        let out = folder.path().join(name);
        std::fs::rename(folder.path().join("out"), &out).unwrap();
        assert_eq!(manifest(&out)["threads"].to_string(), threads);
        out
    };
    let (one, two) = (run_as("one", "1", true), run_as("two", "2", true));
    assert_eq!(lasting(&one), lasting(&two));
    let (files_one, files_two) = (files(&one), files(&two));
    assert!(files_one.keys().eq(files_two.keys()) && files_one.len() >= 8 + 2 * MAPS.len());
    for (name, bytes) in &files_one {
        if name.ends_with(".nc") {
            // The date, and the command with its number of threads, are in the global attributes.
            let (mut one, mut two) = (Netcdf::read(&one.join(name)), Netcdf::read(&two.join(name)));
            for attribute in ["date_created", "history"] {
                one.attributes.remove(attribute).zip(two.attributes.remove(attribute)).unwrap();
            }
            assert!(one.bits() == two.bits() && one.attributes == two.attributes, "{name} differs");
        } else if name != "run.json" {
            assert!(*bytes == files_two[name], "{name} differs");
        }
    }

    // With the date stated and the threads not in the command, nothing at all may differ but the record of times.
    let (one, two) = (run_as("stated one", "1", false), run_as("stated two", "2", false));
    assert_eq!(lasting(&one), lasting(&two));
    let (files_one, files_two) = (files(&one), files(&two));
    assert!(files_one.keys().eq(files_two.keys()));
    for (name, bytes) in files_one.iter().filter(|(name, _)| *name != "run.json") {
        assert!(*bytes == files_two[name], "{name} differs");
    }
    assert!(Netcdf::read(&one.join("maps.nc")).attributes["date_created"].contains("2023-12-31T23:59:59Z"));
}

#[test]
fn what_is_left_out_is_not_written_and_changes_nothing_of_the_rest() {
    let folder = TempDir::new().unwrap();
    let run_with = |parts: &str, out: &str| {
        let write = format!("outputs.write={parts}");
        let settings = [&SHORT_DEMO[..], &["--set", &write]].concat();
        run(folder.path(), &shipped("demo"), if parts.is_empty() { &SHORT_DEMO } else { &settings });
        std::fs::rename(folder.path().join("out"), folder.path().join(out)).unwrap();
        folder.path().join(out)
    };
    let whole = run_with("", "whole");
    let files_whole = files(&whole);
    let is_of = |name: &str, parts: &[&str]| {
        let part = match name {
            "fields.nc" => "fields",
            "maps.nc" => "maps",
            "results.gpkg" => "gpkg",
            _ => name.split_once('/').map_or("always", |(folder, _)| folder),
        };
        part == "always" || parts.contains(&part)
    };
    for (number, parts) in
        [&["maps", "tables"][..], &["fields"], &["tables"], &["cog", "gpkg"], &[]].into_iter().enumerate()
    {
        let out = run_with(&format!("[{}]", parts.join(",")), &format!("out{number}"));
        let found = files(&out);
        let expected: Vec<&String> = files_whole.keys().filter(|name| is_of(name, parts)).collect();
        assert_eq!(found.keys().collect::<Vec<_>>(), expected, "{parts:?}");
        for name in expected.into_iter().filter(|name| name.starts_with("cog/") || name.starts_with("tables/")) {
            assert!(found[name] == files_whole[name], "{parts:?}: {name} differs");
        }
        for name in ["maps.nc", "fields.nc"].into_iter().filter(|name| is_of(name, parts)) {
            assert!(
                Netcdf::read(&whole.join(name)).bits() == Netcdf::read(&out.join(name)).bits(),
                "{parts:?}: {name}"
            );
        }
        let (one, two) = (manifest(&whole), manifest(&out));
        assert!(one["not_written"].is_null());
        let left_out = ["fields", "maps", "cog", "gpkg", "tables", "sections", "channels"];
        let left_out: Vec<&str> = left_out.into_iter().filter(|part| !parts.contains(part)).collect();
        assert_eq!(two["not_written"], serde_json::json!(left_out));
        for key in ["volume_m3", "gates", "steps", "particle_evaluations", "max_speed_m_s"] {
            assert_eq!(one[key], two[key], "{parts:?}: {key}");
        }
    }
    let report = floodsim(folder.path(), &["report", "out2"]);
    assert!(report.code == 4 && report.stderr.contains("add `maps` to `outputs.write`"), "{}", report.stderr);
}

#[test]
fn the_resolved_scenario_gives_the_same_maps() {
    let folder = TempDir::new().unwrap();
    run(folder.path(), &shipped("demo"), &SHORT_DEMO);
    let resolved = folder.path().join("resolved.yaml");
    std::fs::rename(folder.path().join("out"), folder.path().join("first")).unwrap();
    // Its paths are absolute: it runs from anywhere.
    std::fs::copy(folder.path().join("first/scenario.resolved.yaml"), &resolved).unwrap();
    run(folder.path(), &resolved.display().to_string(), &[]);
    for name in ["maps.nc", "fields.nc"] {
        let [first, second] = ["first", "out"].map(|run| Netcdf::read(&folder.path().join(run).join(name)));
        assert!(first.bits() == second.bits(), "{name} differs");
    }
    let text = |run: &str| std::fs::read_to_string(folder.path().join(run).join("scenario.resolved.yaml")).unwrap();
    let without_folder = |text: String| -> Vec<String> {
        text.lines().filter(|line| !line.trim_start().starts_with("folder:")).map(str::to_owned).collect()
    };
    assert_eq!(without_folder(text("first")), without_folder(text("out")));
}

#[test]
fn the_maps_are_the_same_for_any_interval_of_frames() {
    let maps = |every: &str| {
        let folder = TempDir::new().unwrap();
        let every = format!("outputs.every={every}");
        let longer = [&SHORT_DEMO[..4], &["--set", "time.end=11 min", "--set", &every]].concat();
        run(folder.path(), &shipped("demo"), &longer);
        let frames = Netcdf::read(&folder.path().join("out/fields.nc")).dimensions["time"];
        (frames, Netcdf::read(&folder.path().join("out/maps.nc")))
    };
    let ((frames_dense, dense), (frames_sparse, sparse)) = (maps("10 s"), maps("600 s"));
    assert_eq!((frames_dense, frames_sparse), (67, 3));
    let reached = dense.values("arrival_time").iter().filter(|time| **time >= 0.0).count();
    assert!(reached > 1000, "{reached} cells were reached");
    let (dense, sparse) = (dense.bits(), sparse.bits());
    for (name, map) in &dense {
        assert!(*map == sparse[name], "{name} differs");
    }
}
