//! Cells that follow lines: banks drawn as breaklines, walls.

use std::path::PathBuf;

use gdal::vector::LayerAccess;
use tempfile::TempDir;

use crate::{Netcdf, floodsim, run_scene};

const SIDE: usize = 100;
const CELL: f64 = 10.0;
/// How deep the channel is cut (m).
const CUT: f64 = 6.0;
const SLOPE: f64 = 0.002;

const SCENARIO: &str = "\
floodsim: 1
crs: local
terrain: {layers: [{raster: dem.asc}], breaklines: [{lines: banks.geojson, mode: follow}]}
roughness: {manning: 0.03}
sources: [{line: inflow.geojson, discharge: 150 m3/s}]
boundaries: [{side: all, type: open}]
resolution: 10 m
time: {end: 25 min}
outputs: {every: 25 min, sections: section.geojson, gauges: gauges.csv}
";

/// A rectangular channel in a plane that falls along it, at an angle to the lattice. With 3 m²/s its water has a normal depth of 1.521 m.
struct Scene {
    folder: TempDir,
    /// Angle to the lattice (degrees).
    degrees: f64,
    width: f64,
}

impl Scene {
    /// Five cells wide, at 30 degrees.
    fn new() -> Scene {
        Scene::askew(30.0, 50.0, 0.0)
    }

    /// At an angle (degrees), so wide (m), in ground that is rough by so much (m) to either side.
    fn askew(degrees: f64, width: f64, rough: f64) -> Scene {
        let scene = Scene { folder: TempDir::new().unwrap(), degrees, width };
        let half = 0.5 * width;
        scene.write_raster("dem.asc", (0.0, 0.0), CELL, [SIDE, SIDE], rough);
        scene.write_line("banks.geojson", &[(1200.0, half), (-40.0, half), (-40.0, -half), (1200.0, -half)]);
        scene.write_line("inflow.geojson", &[(0.0, 10.0 - half), (0.0, half - 10.0)]);
        scene.write_line("section.geojson", &[(450.0, -60.0), (450.0, 60.0)]);
        let gauge = |id: &str, along: f64, left: f64| {
            let (x, y) = scene.place(along, left);
            format!("{id},{x},{y}\n")
        };
        let gauges = gauge("middle", 400.0, 0.0) + &gauge("left", 400.0, 21.0) + &gauge("right", 500.0, -21.0);
        scene.write("gauges.csv", &format!("id,x,y\n{gauges}"));
        scene.write("s.yaml", &SCENARIO.replace("150 m3/s", &format!("{} m3/s", 3.0 * width)));
        scene
    }

    /// A raster of the ground from its south-western corner on, in pixels (m) by columns and rows, rough by so much (m).
    fn write_raster(&self, name: &str, corner: (f64, f64), pixel: f64, [columns, rows]: [usize; 2], rough: f64) {
        let (sin, cos) = self.degrees.to_radians().sin_cos();
        let noise = |column: usize, row: usize| rough * (12.9898 * column as f64 + 78.233 * row as f64).sin();
        let elevation = |column: usize, row: usize| {
            let x = corner.0 + (column as f64 + 0.5) * pixel - 150.0;
            let y = corner.1 + ((rows - row) as f64 - 0.5) * pixel - 200.0;
            let (along, left) = (x * cos + y * sin, y * cos - x * sin);
            let cut = if left.abs() < 0.5 * self.width && along > -40.0 { CUT } else { 0.0 };
            format!("{:.4}", 20.0 - SLOPE * along - cut + noise(column, row))
        };
        let row = |row: usize| (0..columns).map(|column| elevation(column, row)).collect::<Vec<_>>().join(" ");
        let values = (0..rows).map(row).collect::<Vec<_>>().join("\n");
        let header = format!("ncols {columns}\nnrows {rows}\nxllcorner {}\nyllcorner {}\n", corner.0, corner.1);
        self.write(name, &format!("{header}cellsize {pixel}\n{values}\n"));
    }

    /// The place so far (m) along the channel and to the left of its middle.
    fn place(&self, along: f64, left: f64) -> (f64, f64) {
        let (sin, cos) = self.degrees.to_radians().sin_cos();
        (150.0 + along * cos - left * sin, 200.0 + along * sin + left * cos)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: &str) {
        std::fs::write(self.path(name), content).unwrap();
    }

    /// A line through places along and to the left of the channel.
    fn write_line(&self, name: &str, places: &[(f64, f64)]) {
        let places = places.iter().map(|&(along, left)| self.place(along, left));
        let places: Vec<String> = places.map(|(x, y)| format!("[{x},{y}]")).collect();
        let geometry = format!(r#"{{"type":"LineString","coordinates":[{}]}}"#, places.join(","));
        self.write(name, &format!(r#"{{"type":"Feature","properties":{{"id":"s"}},"geometry":{geometry}}}"#));
    }

    #[track_caller]
    fn run(&self, out: &str, options: &[&str]) -> serde_json::Value {
        run_scene(self.folder.path(), out, options).0
    }

    /// Mean depth (m) of the last frame in the middle of the channel.
    fn depth(&self, out: &str) -> f64 {
        let fields = Netcdf::read(&self.path(out).join("fields.nc"));
        let depth = fields.values("depth");
        let frame = &depth[depth.len() - SIDE * SIDE..];
        let at = |along: f64, left: f64| {
            let (x, y) = self.place(along, left);
            frame[(SIDE - 1 - (y / CELL) as usize) * SIDE + (x / CELL) as usize]
        };
        let across = [-0.2, 0.0, 0.2].map(|share| share * self.width);
        let places = || (0..20).flat_map(|k| across.map(|left| (300.0 + 10.0 * f64::from(k), left)));
        places().map(|(along, left)| at(along, left)).sum::<f64>() / places().count() as f64
    }
}

#[test]
fn a_channel_askew_to_the_lattice_has_its_normal_depth_between_banks_that_cells_follow() {
    let scene = Scene::new();
    let record = scene.run("follow", &["--set", "rain={rate: 1 mm/h, duration: 1 min}"]);
    // What runs off along the banks is held in no pit, up to steps of the bed where cells leave the terrain.
    let (held, last) = (&record["volume_m3"]["held_back"]["in_pits_m3"], &record["volume_m3"]["final"]);
    assert!(held.as_f64().unwrap() < 0.05 * last.as_f64().unwrap(), "{held} of {last} m3");
    let error = record["volume_m3"]["error_relative"].as_f64().unwrap();
    assert!(error.abs() < 1e-12, "{error}");
    let followed = scene.depth("follow");
    assert!((followed / 1.521 - 1.0).abs() < 0.01, "{followed} m");
    // Without the lines the banks are stairs.
    let of_stairs = scene.run("stairs", &["--set", "terrain.breaklines=[]", "--set", "terrain.follow_banks=false"]);
    println!("CPU time {} s between banks that cells follow, {} s between stairs", record["cpu_s"], of_stairs["cpu_s"]);
    let stairs = scene.depth("stairs");
    println!("depth {followed:.4} m between banks that cells follow, {stairs:.3} m between stairs, exact 1.521 m");
    assert!(stairs > 1.2 * followed, "{stairs} m");
    let table = |name: &str| std::fs::read_to_string(scene.path("follow/tables").join(name)).unwrap();
    let column = |line: &str, number: usize| line.split(',').nth(number).unwrap().parse::<f64>().unwrap();
    assert_eq!(table("gauges.csv").lines().count(), 4);
    for gauge in table("gauges.csv").lines().skip(1) {
        let depth = column(gauge, 5);
        assert!((depth / 1.521 - 1.0).abs() < 0.02, "{gauge}");
    }
    let peak = column(table("sections.csv").lines().nth(1).unwrap(), 3).abs();
    assert!((peak / 150.0 - 1.0).abs() < 0.01, "{peak} m3/s");
}

/// Without the lines of the user.
const FOUND: [&str; 2] = ["--set", "terrain.breaklines=[]"];

#[test]
fn banks_that_the_terrain_shows_are_followed_without_a_line_of_the_user() {
    let scene = Scene::new();
    scene.run("found", &FOUND);
    let found = scene.depth("found");
    println!("depth {found:.4} m between banks that the program finds, exact 1.521 m");
    assert!((found / 1.521 - 1.0).abs() < 0.02, "{found} m");
    // They are shown: two long ones, joined at the head of the channel or not.
    let file = gdal::Dataset::open(scene.path("found/results.gpkg")).unwrap();
    let mut layer = file.layer_by_name("banks").unwrap();
    let length: f64 = layer.features().map(|bank| bank.geometry().unwrap().length()).sum();
    assert!((1500.0..2100.0).contains(&length), "{length} m");
    let resolved = std::fs::read_to_string(scene.path("found/scenario.resolved.yaml")).unwrap();
    assert!(resolved.contains("follow_banks: true"), "{resolved}");
}

#[test]
fn banks_are_found_at_any_angle_in_narrow_channels_and_in_rough_ground() {
    let channels = [
        (5.0, 50.0, 0.0),
        (10.0, 50.0, 0.0),
        (20.0, 50.0, 0.1),
        (25.0, 30.0, 0.0),
        (40.0, 50.0, 0.05),
        (45.0, 50.0, 0.0),
    ];
    for (degrees, width, rough) in channels {
        let scene = Scene::askew(degrees, width, rough);
        scene.run("found", &FOUND);
        let found = scene.depth("found");
        println!("depth {found:.4} m at {degrees} degrees, {width} m wide, rough by {rough} m; exact 1.521 m");
        assert!((found / 1.521 - 1.0).abs() < 0.03, "{found} m at {degrees} degrees");
    }
}

#[test]
fn banks_of_a_raster_are_followed_beside_a_finer_inset() {
    let scene = Scene::new();
    scene.write_raster("inset.asc", (630.0, 420.0), 2.5, [72, 92], 0.0);
    let with_inset = "terrain.layers=[{raster: dem.asc}, {raster: inset.asc}]";
    let record = scene.run("inset", &[&FOUND[..], &["--set", with_inset]].concat());
    let depth = scene.depth("inset");
    println!("depth {depth:.4} m outside of the inset, exact 1.521 m; {}", record["banks"]);
    assert!((depth / 1.521 - 1.0).abs() < 0.03, "{depth} m");
    assert!(record["banks"]["length_m"].as_f64().unwrap() > 1500.0, "{}", record["banks"]);
}

#[test]
fn no_bank_is_found_beside_lines_of_the_user_and_in_the_ground_of_a_lake() {
    let scene = Scene::new();
    let short = ["--set", "time.end=1 min", "--set", "outputs.every=1 min"];
    // Beside the user's own lines the terrain shows nothing new.
    let record = scene.run("lines", &short);
    assert_eq!(record.get("banks"), None);
    let record = scene.run("found", &[&FOUND[..], &short].concat());
    assert!(record["banks"]["length_m"].as_f64().unwrap() > 1500.0, "{record}");
    let lake = r#"initial=[{reservoir: "lake.geojson", level: 30 m}]"#;
    let ring = r#"{"type":"Polygon","coordinates":[[[0,0],[1000,0],[1000,1000],[0,1000],[0,0]]]}"#;
    scene.write("lake.geojson", &format!(r#"{{"type":"Feature","properties":{{}},"geometry":{ring}}}"#));
    let record = scene.run("lake", &[&FOUND[..], &short, &["--set", lake]].concat());
    assert_eq!(record.get("banks"), None);
}

#[test]
fn a_flood_wall_of_one_pixel_behind_a_quay_holds() {
    let folder = TempDir::new().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    // A quay at 20 degrees, 3 m high, and 8 m behind it a wall of 3 m more; pixels of 2.5 m, cells of 10 m.
    let (sin, cos) = 20.0_f64.to_radians().sin_cos();
    let left = |x: f64, y: f64| (y - 200.0) * cos - (x - 200.0) * sin;
    let elevation = |x: f64, y: f64| match left(x, y) {
        behind if (8.0..12.0).contains(&behind) => 6.0,
        behind => {
            if behind > 0.0 {
                3.0
            } else {
                0.0
            }
        }
    };
    let row = |row: usize| {
        let values = (0..160).map(|k| elevation(2.5 * k as f64 + 1.25, 400.0 - 2.5 * row as f64 - 1.25).to_string());
        values.collect::<Vec<_>>().join(" ")
    };
    let rows: Vec<String> = (0..160).map(row).collect();
    write("dem.asc", &("ncols 160\nnrows 160\nxllcorner 0\nyllcorner 0\ncellsize 2.5\n".to_owned() + &rows.join("\n")));
    let place = |x: f64, off: f64| format!("[{x},{}]", 200.0 + (off + (x - 200.0) * sin) / cos);
    let ring = [place(0.0, 12.0), place(400.0, 12.0), "[400,400]".to_owned(), "[0,400]".to_owned(), place(0.0, 12.0)];
    let geometry = format!(r#"{{"type":"Polygon","coordinates":[[{}]]}}"#, ring.join(","));
    write("lake.geojson", &format!(r#"{{"type":"Feature","properties":{{}},"geometry":{geometry}}}"#));
    write(
        "s.yaml",
        "floodsim: 1\ncrs: local\nterrain: dem.asc\nroughness: {manning: 0.03}\n\
         initial: [{reservoir: lake.geojson, level: 5 m}]\nresolution: 10 m\ntime: {end: 2 min}\noutputs: {every: 2 min}\n",
    );
    run_scene(folder.path(), "out", &[]);
    let fields = Netcdf::read(&folder.path().join("out/fields.nc"));
    let depth = fields.values("depth");
    let frame = &depth[depth.len() - 1600..];
    let before = |k: &usize| left(10.0 * (k % 40) as f64 + 5.0, 395.0 - 10.0 * (k / 40) as f64) < -10.0;
    let passed = (0..1600).filter(before).filter(|&k| frame[k] > 1e-3).count();
    assert_eq!(passed, 0, "cells with water before the quay");
}

#[test]
fn the_number_of_threads_does_not_change_cells_that_follow_lines() {
    let scene = Scene::new();
    let short = ["--set", "time.end=3 min", "--set", "outputs.every=3 min"];
    scene.run("one", &[&short[..], &["--threads", "1"]].concat());
    scene.run("two", &[&short[..], &["--threads", "2"]].concat());
    let [one, two] = ["one", "two"].map(|out| Netcdf::read(&scene.path(out).join("maps.nc")));
    assert_eq!(one.values("max_depth"), two.values("max_depth"));
    assert_eq!(one.values("max_speed"), two.values("max_speed"));
}

#[test]
fn lines_that_are_followed_have_no_level() {
    let scene = Scene::new();
    let refused = |changes: &[&str]| {
        let answer = floodsim(scene.folder.path(), &[&["check", "s.yaml"][..], changes].concat());
        assert!([2, 3].contains(&answer.code), "{}", answer.stdout);
        answer.stdout
    };
    let level = refused(&["--set", "terrain.breaklines=[{lines: banks.geojson, mode: follow, z: 3 m}]"]);
    assert!(level.contains("conflict") && level.contains("mode: follow"), "{level}");
}

const JUMP: &str = "\
floodsim: 1
crs: local
terrain: flat.asc
roughness: {manning: 0}
initial: [{water: water.geojson, level: 1 m}]
boundaries:
  - {side: west, discharge: 257.1 m3/s, level: 1 m}
  - {side: east, type: open}
structures: {walls: [{lines: wall.geojson}]}
resolution: 1 m
time: {end: 30 s}
outputs: {every: 30 s}
";

#[test]
fn an_oblique_jump_has_its_exact_depth_and_speed_along_its_wall() {
    // Water of 1 m at 8.57 m/s meets a wall at 8.95 degrees: behind the jump 1.5 m at 7.956 m/s.
    let (columns, rows) = (40, 30);
    let scene = Scene::new();
    let flat = vec![vec!["0"; columns].join(" "); rows].join("\n");
    scene.write("flat.asc", &format!("ncols {columns}\nnrows {rows}\nxllcorner 0\nyllcorner 0\ncellsize 1\n{flat}\n"));
    let slope = 8.95_f64.to_radians().tan();
    let line = |kind: &str, places: &str| {
        format!(r#"{{"type":"Feature","properties":{{}},"geometry":{{"type":"{kind}","coordinates":{places}}}}}"#)
    };
    let far = 32.0 * slope;
    scene.write("wall.geojson", &line("LineString", &format!("[[10,0],[42,{far}]]")));
    let at_edge = 30.0 * slope;
    let corners = format!("[[[0,0],[10,0],[40,{at_edge}],[40,30],[0,30],[0,0]]]");
    scene.write("water.geojson", &line("Polygon", &corners));
    scene.write("s.yaml", JUMP);
    scene.run("jump", &[]);
    let fields = Netcdf::read(&scene.path("jump/fields.nc"));
    let last = |name: &str| {
        let values = fields.values(name);
        values[values.len() - columns * rows..].to_vec()
    };
    let [depth, u, v] = ["depth", "velocity_x", "velocity_y"].map(last);
    let (mut count, mut depths, mut speeds) = (0, 0.0, 0.0);
    for cell in 0..columns * rows {
        let (x, y) = ((cell % columns) as f64 + 0.5, (rows - cell / columns) as f64 - 0.5);
        let from_wall = y - (x - 10.0) * slope;
        if (18.0..36.0).contains(&x) && (0.1..2.0).contains(&from_wall) {
            let speed = u[cell].hypot(v[cell]);
            assert!((depth[cell] / 1.5 - 1.0).abs() < 0.005, "{} m at {x}, {y}", depth[cell]);
            assert!((speed / 7.956 - 1.0).abs() < 0.005, "{speed} m/s at {x}, {y}");
            (count, depths, speeds) = (count + 1, depths + depth[cell], speeds + speed);
        }
    }
    let mean = |sum: f64| sum / f64::from(count);
    println!("along the wall {:.4} m, {:.3} m/s; exact 1.4999 m, 7.956 m/s", mean(depths), mean(speeds));
    assert!(count > 20, "{count}");
}
