//! `compare`: what differs between two runs, by hand-computed values of water at rest.

use std::path::Path;

use tempfile::TempDir;

use crate::{Netcdf, feature, floodsim, run_scene};

/// A basin of 200 m by 100 m, whose bed is at 10 m in the west and at 11.2 m in the east. Its water rests.
const SCENARIO: &str = "\
floodsim: 1
title: Basin
crs: local
terrain: dem.asc
roughness: {manning: 0.03}
initial: [{reservoir: all.geojson, level: 11 m}]
boundaries: [{side: all, type: closed}]
resolution: 10 m
time: {end: 10 s}
outputs: {every: 10 s, gauges: g.csv, write: [maps, tables]}
";

fn basin() -> TempDir {
    let folder = TempDir::new().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let row = |_| (0..20).map(|column| if column < 10 { "10" } else { "11.2" }).collect::<Vec<_>>().join(" ");
    let header = "ncols 20\nnrows 10\nxllcorner 1000\nyllcorner 2000\ncellsize 10\n";
    write("dem.asc", &(header.to_owned() + &(0..10).map(row).collect::<Vec<_>>().join("\n") + "\n"));
    write("all.geojson", &feature("Polygon", "[[1000,2000],[1200,2000],[1200,2100],[1000,2100],[1000,2000]]"));
    write("g.csv", "id,x,y\n\"west, deep\",1050,2050\neast,1150,2050\n");
    write("s.yaml", SCENARIO);
    folder
}

fn assert_says(text: &str, expected: &[&str]) {
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for expected in expected {
        assert!(words.contains(expected), "`{expected}` is not in\n{text}");
    }
}

#[test]
fn differences_are_those_of_the_two_waters() {
    let scene = basin();
    let folder = scene.path();
    run_scene(folder, "low", &[]);
    run_scene(folder, "high", &["--set", "initial[0].level=11.5 m", "--set", "outputs.cell=5 m"]);
    let compared = floodsim(folder, &["compare", "low", "high", "--out", "apart"]);
    assert_eq!((compared.code, compared.stderr.as_str()), (0, ""));
    // The west is 0.5 m deeper, the east 0.3 m deep for dry.
    assert_says(
        &compared.stdout,
        &[
            "first low (Basin)",
            "changed initial[0].level: 11 m -> 11.5 m",
            "outputs.cell: 10 m -> 5 m",
            "flooded 0.0100 km2, 0.0200 km2 (+100.0 %)",
            "in both 0.0100 km2; in the first alone 0.0000, in the second alone 0.0100; overlap 0.500",
            "max depth m +0.400 0.500 +0.500 1002.5, 2097.5",
            "max water level m +0.500 0.500 +0.500",
            "max speed m/s +0.000 0.000 +0.000",
            "arrival time s no place has it in both",
            "west, deep max_level_m 11.000 11.500 +0.500",
            "east max_depth_m 0.000 0.300 +0.300",
        ],
    );
    let maps = Netcdf::read(&folder.join("apart/differences.nc"));
    assert_eq!((maps.dimensions["y"], maps.dimensions["x"]), (20, 40));
    let west = |index: usize| index % 40 < 20;
    for (index, (depth, extent)) in
        maps.values("max_depth_difference").iter().zip(maps.values("flood_extent")).enumerate()
    {
        let (deeper, class) = if west(index) { (0.5, 3.0) } else { (0.3, 2.0) };
        assert!((depth - deeper).abs() < 1e-6 && (extent - class).abs() < 1e-9, "{index}: {depth} {extent}");
    }
    let table = std::fs::read_to_string(folder.join("apart/tables/differences.csv")).unwrap();
    assert!(table.contains("gauge,\"west, deep\",max_depth_m,1.0000,1.5000,0.5000\n"), "{table}");
    for name in ["flood_extent.tif", "max_depth_difference.tif", "max_depth_difference.qml"] {
        assert!(folder.join("apart/cog").join(name).exists(), "{name}");
    }
    let json: serde_json::Value =
        serde_json::from_str(&floodsim(folder, &["compare", "low", "low", "--json"]).stdout).unwrap();
    assert_eq!(
        (json["changes"]["scenario"].as_array().unwrap().len(), json["extent"]["both_m2"].as_f64()),
        (0, Some(1e4))
    );
    assert_refused(folder);
}

/// Folders without a run, runs of different places, and a folder that a comparison may not write to.
fn assert_refused(folder: &Path) {
    let refused = |arguments: &[&str], code: i32, expected: &[&str]| {
        let answer = floodsim(folder, &[&["compare"][..], arguments].concat());
        assert_eq!(answer.code, code, "{}", answer.stderr);
        assert_says(&answer.stderr, expected);
    };
    // A classic file whose head counts more than it holds, at which the library would crash.
    std::fs::create_dir(folder.join("damaged")).unwrap();
    let record = std::fs::read_to_string(folder.join("low/run.json")).unwrap();
    std::fs::write(folder.join("damaged/run.json"), record).unwrap();
    let head = [&b"CDF\x01\0\0\0\0\0\0\0\x0a\x7f\xff\xff\xff"[..], &[0; 40]].concat();
    std::fs::write(folder.join("damaged/maps.nc"), head).unwrap();
    refused(&["low", "damaged"], 4, &["error[not-a-run]", "its head counts more than the file has room for"]);
    refused(&["low", "nowhere"], 4, &["error[not-a-run]", "nowhere/maps.nc"]);
    refused(&["low", "high", "--out", "high", "--overwrite"], 8, &["error[input-in-output-folder]", "choose a folder"]);
    refused(&["low", "high", "--out", "apart"], 8, &["error[output-folder-not-empty]"]);
    let moved = std::fs::read_to_string(folder.join("dem.asc")).unwrap().replace("xllcorner 1000", "xllcorner 91000");
    std::fs::write(folder.join("dem.asc"), moved).unwrap();
    let polygon = "[[91000,2000],[91200,2000],[91200,2100],[91000,2100],[91000,2000]]";
    std::fs::write(folder.join("all.geojson"), feature("Polygon", polygon)).unwrap();
    std::fs::write(folder.join("g.csv"), "id,x,y\na,91050,2050\n").unwrap();
    run_scene(folder, "elsewhere", &[]);
    refused(&["low", "elsewhere"], 4, &["error[not-comparable]", "their maps are of different places"]);
    run_scene(folder, "utm", &["--set", "crs=EPSG:25832"]);
    refused(&["elsewhere", "utm"], 4, &["error[not-comparable]", "local metres and EPSG:25832"]);
}
