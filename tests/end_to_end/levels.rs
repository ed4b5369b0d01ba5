//! Levels of cells: `resolution: {finest: ..., coarsest: ...}`.

use std::path::PathBuf;

use tempfile::TempDir;

use crate::{Netcdf, floodsim, run_scene};

/// Pixels of 5 m.
const COLUMNS: usize = 256;
const ROWS: usize = 96;

const SCENARIO: &str = "\
floodsim: 1
crs: local
terrain: dem.asc
roughness: {manning: 0.03}
initial: [{reservoir: lake.geojson, level: 118 m}]
resolution: {finest: 5 m, coarsest: 40 m}
time: {end: 120 s}
outputs: {every: 60 s, gauges: gauges.csv}
";

/// A valley that falls to the east, 200 m wide, with a gorge of 30 m in its middle third; a lake in its west whose dam is gone.
pub(crate) struct Scene {
    pub(crate) folder: TempDir,
}

impl Scene {
    pub(crate) fn new() -> Scene {
        let scene = Scene { folder: TempDir::new().unwrap() };
        let row = |row: usize| {
            let values = (0..COLUMNS).map(|column| format!("{:.3}", Self::elevation(column, row)));
            values.collect::<Vec<_>>().join(" ")
        };
        let rows: Vec<String> = (0..ROWS).map(row).collect();
        let header = format!("ncols {COLUMNS}\nnrows {ROWS}\nxllcorner 0\nyllcorner 0\ncellsize 5\n");
        scene.write("dem.asc", &(header + &rows.join("\n") + "\n"));
        scene.write_polygon("lake.geojson", "[[[0,0],[300,0],[300,480],[0,480],[0,0]]]");
        scene.write("gauges.csv", "id,x,y\nlake,150,240\ngorge,640,240\nplain,1000,240\n");
        scene.write("s.yaml", SCENARIO);
        scene
    }

    /// Elevation (m) of a pixel; row 0 is the northernmost one.
    fn elevation(column: usize, row: usize) -> f64 {
        let (x, y) = (5.0 * column as f64 + 2.5, 5.0 * (ROWS - row) as f64 - 2.5);
        let is_gorge = (450.0..800.0).contains(&x);
        let half = if is_gorge { 15.0 } else { 100.0 };
        let flank = ((y - 240.0).abs() - half).max(0.0);
        110.0 - 0.01 * x + 20.0 * (flank / 40.0).min(1.0) + 0.02 * flank
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: &str) {
        std::fs::write(self.path(name), content).unwrap();
    }

    pub(crate) fn write_polygon(&self, name: &str, polygon: &str) {
        let geometry = format!(r#"{{"type":"Polygon","coordinates":{polygon}}}"#);
        self.write(name, &format!(r#"{{"type":"Feature","properties":{{}},"geometry":{geometry}}}"#));
    }

    /// Runs the scene into a folder, with changes; returns its record.
    #[track_caller]
    pub(crate) fn run(&self, out: &str, changes: &[&str]) -> serde_json::Value {
        let changes: Vec<&str> = changes.iter().flat_map(|change| ["--set", change]).collect();
        run_scene(self.folder.path(), out, &changes).0
    }

    pub(crate) fn maps(&self, out: &str) -> Netcdf {
        Netcdf::read(&self.path(out).join("maps.nc"))
    }
}

pub(crate) fn cells(record: &serde_json::Value) -> Vec<(f64, u64)> {
    let levels = record["levels"].as_array().unwrap();
    levels.iter().map(|level| (level["spacing_m"].as_f64().unwrap(), level["cells"].as_u64().unwrap())).collect()
}

#[test]
fn levels_bring_the_maps_of_the_finest_lattice_for_less() {
    let scene = Scene::new();
    let fine = scene.run("fine", &["resolution=5 m"]);
    let nested = scene.run("nested", &[]);
    assert!(fine.get("levels").is_none());
    let levels = cells(&nested);
    let spacings: Vec<f64> = levels.iter().map(|level| level.0).collect();
    assert_eq!(spacings, [5.0, 10.0, 20.0, 40.0]);
    assert!(levels[0].1 > 1000 && levels[1].1 + levels[2].1 + levels[3].1 > 200, "{levels:?}");
    let evaluations = |record: &serde_json::Value| record["particle_evaluations"].as_f64().unwrap();
    assert!(evaluations(&nested) < 0.6 * evaluations(&fine), "{} of {}", evaluations(&nested), evaluations(&fine));
    let error = nested["volume_m3"]["error_relative"].as_f64().unwrap();
    assert!(error.abs() < 1e-12, "{error}");
    let (one, other) = (scene.maps("fine"), scene.maps("nested"));
    assert_eq!(one.dimensions, other.dimensions);
    let resolution = other.values("resolution");
    assert!(resolution.iter().all(|edge| [5.0, 10.0, 20.0, 40.0].contains(edge)));
    // The gorge is narrower than two coarse cells and is on fine ones; gauges are, too.
    let at = |x: f64, y: f64| (ROWS - 1 - (y / 5.0) as usize) * COLUMNS + (x / 5.0) as usize;
    for (x, y) in [(640.0, 240.0), (150.0, 240.0), (1000.0, 240.0)] {
        assert!((resolution[at(x, y)] - 5.0).abs() < 1e-9, "{} m at {x}, {y}", resolution[at(x, y)]);
    }
    let (a, b) = (one.values("max_depth"), other.values("max_depth"));
    let is_wet = |depth: &f64| *depth > 0.3;
    let both = a.iter().zip(b).filter(|(a, b)| is_wet(a) && is_wet(b)).count() as f64;
    let either = a.iter().zip(b).filter(|(a, b)| is_wet(a) || is_wet(b)).count() as f64;
    let off = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / either;
    println!(
        "extent {}, depth off by {off} m, evaluations {} of {}",
        both / either,
        evaluations(&nested),
        evaluations(&fine)
    );
    assert!(both / either > 0.95 && off < 0.12, "{} and {off} m", both / either);
}

#[test]
fn fast_water_between_smooth_banks_is_on_fine_cells() {
    let scene = Scene::new();
    // A valley whose ground a plane explains in each coarse cell. Nothing but the flow asks for fine ones.
    let bed = |column: usize, row: usize| {
        let (x, y) = (5.0 * column as f64 + 2.5, 5.0 * (ROWS - row) as f64 - 2.5);
        110.0 - 0.01 * x + 0.25 * (y - 240.0).hypot(10.0)
    };
    let row = |row: usize| (0..COLUMNS).map(|column| format!("{:.3}", bed(column, row))).collect::<Vec<_>>().join(" ");
    let header = format!("ncols {COLUMNS}\nnrows {ROWS}\nxllcorner 0\nyllcorner 0\ncellsize 5\n");
    scene.write("dem.asc", &(header + &(0..ROWS).map(row).collect::<Vec<_>>().join("\n") + "\n"));
    scene.write_polygon("lake.geojson", "[[[0,0],[500,0],[500,480],[0,480],[0,0]]]");
    scene.write(
        "s.yaml",
        &SCENARIO.replace("118 m", "135 m").replace("outputs: {every: 60 s, gauges: gauges.csv}\n", ""),
    );
    let changes = ["time.end=60 s"];
    let fine = scene.run("fine", &["resolution=5 m", changes[0]]);
    let nested = scene.run("nested", &changes);
    assert!(cells(&nested)[0].1 > 1000, "{:?}", cells(&nested));
    let evaluations = |record: &serde_json::Value| record["particle_evaluations"].as_f64().unwrap();
    let (one, other) = (scene.maps("fine"), scene.maps("nested"));
    let both = one.values("max_depth").iter().zip(other.values("max_depth")).filter(|(a, b)| a.min(**b) > 0.3);
    let (sum, count) = both.fold((0.0, 0.0), |(sum, count), (a, b)| (sum + (a - b).abs(), count + 1.0));
    let off = sum / count;
    println!("depth off by {off} m, evaluations {} of {}", evaluations(&nested), evaluations(&fine));
    // On cells of 40 m, which see this ground as well as finer ones, it is 0.62 m.
    assert!(off < 0.25 && evaluations(&nested) < 0.7 * evaluations(&fine), "{off} m");
}

#[test]
fn levels_that_are_fine_everywhere_bring_the_maps_of_one_lattice() {
    let scene = Scene::new();
    scene.write_polygon("all.geojson", "[[[0,0],[1280,0],[1280,480],[0,480],[0,0]]]");
    let thresholds = "outputs.arrival={thresholds: [0.01 m, 0.1 m, 0.3 m], rise_on_wet: 0.1 m}";
    let one = scene.run("one", &["resolution=5 m", thresholds]);
    let levels = "resolution={finest: 5 m, coarsest: 40 m, refine: [{polygons: all.geojson, to: 5 m}]}";
    let nested = scene.run("nested", &[levels, thresholds]);
    assert_eq!(cells(&nested)[1..].iter().map(|level| level.1).sum::<u64>(), 0);
    assert_eq!(one["steps"], nested["steps"]);
    let (one, nested) = (scene.maps("one"), scene.maps("nested"));
    let names = ["max_water_level", "max_speed", "time_of_max_depth", "arrival_time", "arrival_time_0p10m"];
    for name in [&names[..], &["arrival_time_0p30m", "flood_duration_0p30m"]].concat() {
        let apart = one.values(name).iter().zip(nested.values(name)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Levels are the ground in single precision and the depth above it.
        assert!(apart < 1e-4, "{name}: {apart}");
    }
}

#[test]
fn levels_give_the_same_bytes_for_any_number_of_threads_and_a_later_run_goes_on() {
    let scene = Scene::new();
    scene.run("more", &["time.end=60 s"]);
    let one = ["run", "s.yaml", "--out", "one", "--quiet", "--threads", "1", "--set", "time.end=60 s"];
    let answer = floodsim(scene.folder.path(), &one);
    assert_eq!(answer.code, 0, "{}", answer.stderr);
    for file in ["maps.nc", "fields.nc"] {
        let [one, more] = ["one", "more"].map(|out| Netcdf::read(&scene.path(out).join(file)));
        assert!(one.bits() == more.bits(), "{file}");
    }
    let later = scene.run("later", &["initial=[{fields: more/fields.nc}]", "resolution=5 m", "time.end=30 s"]);
    assert!(later["volume_m3"]["initial"].as_f64().unwrap() > 1e5);
}

#[test]
fn water_at_an_edge_that_coarse_cells_reach_over_has_its_volume_on_the_grid() {
    let scene = Scene::new();
    // Lattices that neither blocks nor coarse cells divide, deep water up to their north-eastern edges.
    for (columns, rows) in [(250, 90), (241, 83), (200, 77)] {
        let row = |row: usize| {
            let place = |column: usize| (5.0 * column as f64, 5.0 * (rows - row) as f64);
            let bed = |(x, y): (f64, f64)| 110.0 - 0.01 * x - 0.02 * y + (0.05 * x).sin() * (0.04 * y).cos();
            (0..columns).map(|column| format!("{:.3}", bed(place(column)))).collect::<Vec<_>>().join(" ")
        };
        let header = format!("ncols {columns}\nnrows {rows}\nxllcorner 0\nyllcorner 0\ncellsize 5\n");
        scene.write("dem.asc", &(header + &(0..rows).map(row).collect::<Vec<_>>().join("\n") + "\n"));
        let (east, north) = (5 * columns, 5 * rows);
        let lake = format!("[[[600,0],[{east},0],[{east},{north}],[600,{north}],[600,0]]]");
        scene.write_polygon("lake.geojson", &lake);
        scene.write("gauges.csv", "id,x,y\nlake,700,200\n");
        // A gate of the run holds the volume on the grid to that of the core.
        let record = scene.run(&format!("{columns}"), &["time.end=20 s", "outputs.every=10 s"]);
        let on_grid = record["volume_m3"]["grid_error_relative"].as_f64().unwrap();
        assert!(cells(&record).iter().skip(1).any(|level| level.1 > 100), "{:?}", cells(&record));
        assert!(on_grid < 1e-6, "{columns} by {rows}: {on_grid}");
    }
}

#[test]
fn what_does_not_go_with_levels_is_refused_with_a_remedy() {
    let scene = Scene::new();
    let check = |changes: &[&str]| {
        let changes: Vec<&str> = changes.iter().flat_map(|change| ["--set", change]).collect();
        floodsim(scene.folder.path(), &[&["check", "s.yaml"][..], &changes].concat())
    };
    // A pond that a coarse cell does not hold.
    scene.write_polygon("pond.geojson", "[[[1001,231],[1012,231],[1012,242],[1001,242],[1001,231]]]");
    let pond = "initial=[{reservoir: lake.geojson, level: 118 m}, {reservoir: pond.geojson, level: 101 m}]";
    let coarse = check(&[pond, "resolution.coarsest=80 m"]);
    assert_eq!(coarse.code, 4, "{}", coarse.stdout);
    assert!(coarse.stdout.contains("on the level of 20 m"), "{}", coarse.stdout);
    assert!(coarse.stdout.contains("take a smaller `resolution.coarsest`"), "{}", coarse.stdout);
    let fine = check(&[pond, "resolution.coarsest=5 m"]);
    assert_eq!(fine.code, 0, "{}", fine.stdout);
}

#[test]
fn places_of_the_user_are_as_fine_as_wanted() {
    let scene = Scene::new();
    scene.write_polygon("town.geojson", "[[[1100,100],[1200,100],[1200,200],[1100,200],[1100,100]]]");
    let refine = "resolution={finest: 5 m, coarsest: 40 m, refine: [{polygons: town.geojson, to: 10 m}]}";
    let record = scene.run("town", &[refine, "time.end=10 s"]);
    assert!(record["inputs"].to_string().contains("town.geojson"), "{}", record["inputs"]);
    let maps = scene.maps("town");
    let resolution = maps.values("resolution");
    for (x, y) in [(1105.0, 105.0), (1150.0, 150.0), (1195.0, 195.0)] {
        let edge = resolution[(ROWS - 1 - (y / 5.0) as usize) * COLUMNS + (x / 5.0) as usize];
        assert!(edge <= 10.0, "{edge} m at {x}, {y}");
    }
    let missing = "resolution={finest: 5 m, refine: [{lines: no.geojson}]}";
    let check = floodsim(scene.folder.path(), &["check", "s.yaml", "--set", missing]);
    assert_eq!(check.code, 4, "{}", check.stdout);
    assert!(check.stdout.contains("resolution.refine[0].lines"), "{}", check.stdout);
    let plan = floodsim(scene.folder.path(), &["plan", "s.yaml"]);
    assert_eq!(plan.code, 0, "{}", plan.stderr);
}

#[test]
fn a_dam_breaks_and_a_river_comes_in_on_levels() {
    let scene = Scene::new();
    let line = |name: &str, from: [f64; 2], to: [f64; 2]| {
        let geometry = format!(r#"{{"type":"LineString","coordinates":[{from:?},{to:?}]}}"#);
        scene.write(name, &format!(r#"{{"type":"Feature","properties":{{}},"geometry":{geometry}}}"#));
    };
    line("dam.geojson", [300.0, 480.0], [300.0, 0.0]);
    line("section.geojson", [900.0, 480.0], [900.0, 0.0]);
    line("west.geojson", [0.0, 300.0], [0.0, 180.0]);
    line("east.geojson", [1280.0, 0.0], [1280.0, 480.0]);
    scene.write(
        "s.yaml",
        &(SCENARIO.to_owned()
            + "breach: {dam: dam.geojson, crest: 122 m, trigger: {at: 20 s}}\n\
boundaries:\n\
  - {line: west.geojson, discharge: 40 m3/s}\n\
  - {line: east.geojson, normal_depth: {slope: 0.01}}\n\
rain: {rate: 20 mm/h}\n"),
    );
    let sections = "outputs.sections=section.geojson";
    let record = scene.run("dam", &[sections]);
    let volume = &record["volume_m3"];
    assert!(volume["error_relative"].as_f64().unwrap().abs() < 1e-12, "{volume}");
    let inflow = volume["in"].as_f64().unwrap();
    let rained = 0.02 / 3600.0 * 120.0 * (5.0 * COLUMNS as f64) * (5.0 * ROWS as f64);
    assert!((inflow / (40.0 * 120.0 + rained) - 1.0).abs() < 1e-6, "{inflow} of {}", 40.0 * 120.0 + rained);
    assert!(
        record["breach"]["began_s"].as_f64().is_some_and(|began| (began - 20.0).abs() < 1e-6),
        "{}",
        record["breach"]
    );
}
