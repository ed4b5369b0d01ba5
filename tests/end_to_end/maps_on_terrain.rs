//! Maps on the terrain's own raster: `outputs.cell: terrain`.

use std::path::PathBuf;

use tempfile::TempDir;

use crate::{Netcdf, floodsim};

/// Pixels of 1 m along both sides.
const SIDE: usize = 120;

const SCENARIO: &str = "\
floodsim: 1
crs: local
terrain: dem.asc
roughness: {manning: 0.03}
initial: [{reservoir: lake.geojson, level: 103 m}]
resolution: 10 m
time: {end: 60 s}
outputs: {cell: terrain, every: 30 s}
";

/// A plain that falls to the east by 2 %, with a levee of 4 m and a crest of 2 m across it, askew by 20°; a lake west of it.
struct Scene {
    folder: TempDir,
}

impl Scene {
    fn new() -> Scene {
        let scene = Scene { folder: TempDir::new().unwrap() };
        let rows: Vec<String> = (0..SIDE)
            .map(|row| {
                let values = (0..SIDE).map(|column| format!("{:.3}", Self::elevation(column, row)));
                values.collect::<Vec<_>>().join(" ")
            })
            .collect();
        let header = "ncols 120\nnrows 120\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n";
        scene.write("dem.asc", &(header.to_owned() + &rows.join("\n") + "\n"));
        // Up to the levee on the whole height.
        let polygon = "[[[0,0],[79,0],[36,120],[0,120],[0,0]]]";
        scene.write(
            "lake.geojson",
            &format!(
                r#"{{"type":"FeatureCollection","features":[{{"type":"Feature","properties":{{}},"geometry":{{"type":"Polygon","coordinates":{polygon}}}}}]}}"#
            ),
        );
        scene.write("s.yaml", SCENARIO);
        scene
    }

    /// Elevation (m) of a pixel; row 0 is the northernmost one.
    fn elevation(column: usize, row: usize) -> f64 {
        let (x, y) = (column as f64 + 0.5, SIDE as f64 - row as f64 - 0.5);
        let across = Self::beyond_levee(x, y).abs();
        let levee = 4.0 - 2.0 * (across - 1.0).max(0.0);
        102.0 - 0.02 * x + levee.max(0.0)
    }

    /// Distance (m) from the axis of the levee, positive in the east of it.
    fn beyond_levee(x: f64, y: f64) -> f64 {
        let (sin, cos) = 20.0_f64.to_radians().sin_cos();
        (x - 60.0) * cos + (y - 60.0) * sin
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: &str) {
        std::fs::write(self.path(name), content).unwrap();
    }

    /// Runs the scene into a folder, with changes; returns what it said.
    #[track_caller]
    fn run(&self, out: &str, changes: &[&str]) -> String {
        let changes: Vec<&str> = changes.iter().flat_map(|change| ["--set", change]).collect();
        let answer =
            floodsim(self.folder.path(), &[&["run", "s.yaml", "--out", out, "--quiet"][..], &changes].concat());
        assert_eq!(answer.code, 0, "{}", answer.stderr);
        answer.stderr
    }
}

#[test]
fn maps_have_the_pixels_of_the_terrain_and_no_water_behind_an_unbroken_levee() {
    let scene = Scene::new();
    scene.run("fine", &[]);
    let maps = Netcdf::read(&scene.path("fine/maps.nc"));
    let fields = Netcdf::read(&scene.path("fine/fields.nc"));
    assert_eq!((maps.dimensions["x"], maps.dimensions["y"]), (SIDE, SIDE));
    assert_eq!((fields.dimensions["x"], fields.dimensions["y"]), (SIDE / 10, SIDE / 10), "frames at the resolution");
    let (depth, level) = (maps.values("max_depth"), maps.values("max_water_level"));
    let (bed, arrival) = (maps.values("bed_elevation"), maps.values("arrival_time"));
    let mut before = 0;
    for row in 0..SIDE {
        for column in 0..SIDE {
            let (pixel, terrain) = (row * SIDE + column, Scene::elevation(column, row));
            // The raster is written to the millimetre.
            assert!((bed[pixel] - terrain).abs() < 6e-4, "the bed is the terrain itself");
            let beyond = Scene::beyond_levee(column as f64 + 0.5, SIDE as f64 - row as f64 - 0.5);
            if depth[pixel] > 0.0 {
                assert!((level[pixel] - depth[pixel] - bed[pixel]).abs() < 1e-4, "level less terrain");
                assert!(beyond < 1.0, "{} m of water {beyond:.1} m behind the levee", depth[pixel]);
                before += usize::from(beyond < -3.0);
            }
            if (-20.0..-5.0).contains(&beyond) {
                // The lake sways as its seeding on cells evens out.
                assert!((level[pixel] - 103.0).abs() < 0.15, "{} m at {beyond:.1} m before the levee", level[pixel]);
            }
            assert!(arrival[pixel] < 0.0 || depth[pixel] >= 0.01, "arrival where the threshold was reached");
        }
    }
    assert!(before > 4000, "{before} pixels under water before the levee");
}

#[test]
fn a_later_run_goes_on_from_frames_at_the_resolution_and_the_report_shows_both_grids() {
    let scene = Scene::new();
    scene.run("first", &[]);
    scene.run("second", &["initial=[{fields: first/fields.nc}]"]);
    let report = floodsim(scene.folder.path(), &["report", "second"]);
    assert_eq!(report.code, 0, "{}", report.stderr);
    // The terrain is the same in both, whatever the first fitted to its shore.
    let [first, second] =
        ["first", "second"].map(|out| Netcdf::read(&scene.path(out).join("maps.nc")).values("bed_elevation").to_vec());
    assert!(first == second);
    let page = std::fs::read_to_string(scene.path("second/report/index.html")).unwrap();
    assert!(page.contains("120 × 120 cells of 1 m"), "the grid of the maps");
    // The same maps with any number of threads.
    let answer = floodsim(scene.folder.path(), &["run", "s.yaml", "--out", "one", "--quiet", "--threads", "1"]);
    assert_eq!(answer.code, 0, "{}", answer.stderr);
    let [one, more] = ["one", "first"].map(|out| Netcdf::read(&scene.path(out).join("maps.nc")));
    assert!(one.bits() == more.bits());
}

#[test]
fn a_lattice_as_fine_as_the_terrain_keeps_its_cells_and_says_so() {
    let scene = Scene::new();
    let coarse = ["resolution=1 m", "time.end=1 s", "outputs.every=1 s"];
    let stderr = scene.run("same", &coarse);
    assert!(stderr.contains("warning[no-finer-raster] outputs.cell (s.yaml:8:17)"), "{stderr}");
    let maps = Netcdf::read(&scene.path("same/maps.nc"));
    assert_eq!((maps.dimensions["x"], maps.dimensions["y"]), (SIDE, SIDE));
    let answer = floodsim(scene.folder.path(), &["check", "s.yaml", "--set", "outputs.cell=pixels"]);
    assert!(answer.code != 0 && answer.stdout.contains("write `terrain`"), "{}", answer.stdout);
    let resolved = std::fs::read_to_string(scene.path("same/scenario.resolved.yaml")).unwrap();
    assert!(resolved.contains("  cell: terrain\n"), "{resolved}");
}
