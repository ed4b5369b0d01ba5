//! A bed that moves, through the whole program: the volume balance, the maps, and what bad inputs get.

use std::path::PathBuf;

use tempfile::TempDir;

use crate::{Netcdf, assert_check, changed, floodsim};

/// A lake of 200 m by 100 m and 10 m of depth, whose western shore rises by 1 in 2.
const SCENARIO: &str = "\
floodsim: 1
crs: local
terrain: dem.asc
roughness: {manning: 0.03}
initial: [{water: lake.geojson, level: 100 m}]
boundaries: [{side: all, type: closed}]
moving_bed: [{change: change.asc, at: 5 s, share: {series: share.csv}}]
resolution: 5 m
time: {end: 30 s}
outputs: {every: 5 s}
";

const SLIDE: (&str, &str) = (
    "{change: change.asc, at: 5 s, share: {series: share.csv}}",
    "{thickness: slide.asc, path: axis.geojson, velocity: {series: velocity.csv}}",
);

struct Scene {
    folder: TempDir,
}

impl Scene {
    fn new(changes: &[(&str, &str)]) -> Scene {
        let scene = Scene { folder: TempDir::new().unwrap() };
        scene.grid("dem.asc", |x, _| if x < 30.0 { 105.0 - 0.5 * x } else { 90.0 });
        scene.grid("change.asc", |x, y| if (100.0..140.0).contains(&x) && y < 50.0 { 2.0 } else { -9999.0 });
        scene.grid("slide.asc", |x, y| if (5.0..25.0).contains(&x) && (40.0..60.0).contains(&y) { 3.0 } else { 0.0 });
        scene.write("share.csv", "time_s,share\n0,0\n4,0.3\n10,1\n");
        scene.write("velocity.csv", "time_s,v_m_s\n0,0\n2,12\n10,0\n");
        scene.line("axis.geojson", &[(1015.0, 2050.0), (1100.0, 2050.0)]);
        let ring = "[[[1000,2000],[1200,2000],[1200,2100],[1000,2100],[1000,2000]]]";
        scene.write("lake.geojson", &format!(r#"{{"type":"Polygon","coordinates":{ring}}}"#));
        scene.write("s.yaml", &changed(SCENARIO, changes));
        scene
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    fn line(&self, name: &str, places: &[(f64, f64)]) {
        let places: Vec<String> = places.iter().map(|(x, y)| format!("[{x},{y}]")).collect();
        let geometry = format!(r#"{{"type":"LineString","coordinates":[{}]}}"#, places.join(","));
        self.write(name, &format!(r#"{{"type":"Feature","properties":{{}},"geometry":{geometry}}}"#));
    }

    /// Writes a raster of 40 by 20 cells of 5 m, by the place from its south-western corner.
    fn grid(&self, name: &str, value: impl Fn(f64, f64) -> f64) {
        let header = "ncols 40\nnrows 20\nxllcorner 1000\nyllcorner 2000\ncellsize 5\nNODATA_value -9999\n";
        let cell = |row: u32, column: u32| value(5.0 * f64::from(column) + 2.5, 97.5 - 5.0 * f64::from(row));
        let rows = (0..20).map(|row| (0..40).map(|column| cell(row, column).to_string()).collect::<Vec<_>>().join(" "));
        self.write(name, &(header.to_owned() + &rows.collect::<Vec<_>>().join("\n") + "\n"));
    }

    /// Runs the scene; returns `run.json` and the folder of the run.
    #[track_caller]
    fn run(&self) -> (serde_json::Value, PathBuf) {
        let answer = floodsim(self.folder.path(), &["run", "s.yaml", "--out", "out", "--quiet", "--overwrite"]);
        assert_eq!(answer.code, 0, "{}", answer.stderr);
        let out = self.path("out");
        let text = std::fs::read_to_string(out.join("run.json")).unwrap();
        (serde_json::from_str(&text).unwrap(), out)
    }

    /// `run.json` and the maps of a run.
    #[track_caller]
    fn run_and_read(&self) -> (serde_json::Value, Netcdf) {
        let (run, out) = self.run();
        (run, Netcdf::read(&out.join("maps.nc")))
    }

    /// Asserts that the check ends with this exit code and says all these texts.
    #[track_caller]
    fn assert_check(&self, code: i32, expected: &[&str]) {
        assert_check(self.folder.path(), code, expected);
    }
}

/// A number of the moving bed in `run.json`.
fn of_bed(run: &serde_json::Value, key: &str) -> f64 {
    run["moving_bed"][key].as_f64().unwrap()
}

#[track_caller]
fn assert_volume(run: &serde_json::Value) {
    let volume = |key: &str| run["volume_m3"][key].as_f64().unwrap();
    let errors = [volume("error_relative"), volume("grid_error_relative")];
    // The grid has single precision.
    assert!(errors[0].abs() < 1e-12 && errors[1] < 6e-8, "{errors:?}");
    assert!((volume("final") / volume("initial") - 1.0).abs() < 1e-12 && volume("in").abs() <= 0.0);
}

#[test]
fn ground_rises_by_its_share_and_the_water_with_it() {
    let scene = Scene::new(&[]);
    scene.assert_check(0, &["0 errors, 0 warnings"]);
    let (run, out) = scene.run();
    assert_volume(&run);
    // 8 by 10 cells by 2 m.
    let raised = 80.0 * 25.0 * 2.0;
    assert!((of_bed(&run, "raised_m3") / raised - 1.0).abs() < 1e-9 && of_bed(&run, "sunk_m3").abs() <= 0.0);
    assert!((of_bed(&run, "lifted_m3") / raised - 1.0).abs() < 1e-9 && (of_bed(&run, "began_s") - 5.0).abs() < 1e-12);
    let inputs = run["inputs"].as_array().unwrap();
    for name in ["change.asc", "share.csv"] {
        assert!(inputs.iter().any(|file| file["path"].as_str().unwrap().ends_with(name)), "{name} in {inputs:?}");
    }
    // Rows of the maps begin in the north or the south; the middle of the western half of the ground that rose is at 120 m.
    let bed = Netcdf::read(&out.join("maps.nc")).values("bed_elevation").to_vec();
    assert_eq!(bed.iter().filter(|z| (**z - 92.0).abs() < 1e-3).count(), 80);
    // Until it moves nothing does, and then the level above it rises.
    let fields = Netcdf::read(&out.join("fields.nc"));
    let level = fields.values("water_level");
    let frame =
        |number: usize| level[number * 800..][..800].iter().copied().filter(|z| z.is_finite()).fold(0.0, f64::max);
    assert!((frame(1) - 100.0).abs() < 1e-4 && frame(2) > 100.2, "{} m, {} m", frame(1), frame(2));
    // The resolved scenario is the same run.
    std::fs::copy(out.join("scenario.resolved.yaml"), scene.path("s.yaml")).unwrap();
    assert_eq!(of_bed(&scene.run().0, "lifted_m3").to_bits(), of_bed(&run, "lifted_m3").to_bits());
}

#[test]
fn a_slide_runs_into_the_lake_and_stays_there() {
    let scene = Scene::new(&[SLIDE]);
    scene.assert_check(0, &["0 errors, 0 warnings"]);
    let (run, out) = scene.run();
    assert_volume(&run);
    let volume = 400.0 * 3.0;
    for key in ["raised_m3", "sunk_m3"] {
        assert!((of_bed(&run, key) / volume - 1.0).abs() < 1e-9, "{key}: {}", of_bed(&run, key));
    }
    assert!(of_bed(&run, "lifted_m3") > volume);
    // It has come 60 m: from 5 to 25 m to 65 to 85 m.
    let maps = Netcdf::read(&out.join("maps.nc"));
    assert_eq!(maps.values("bed_elevation").iter().filter(|z| (**z - 93.0).abs() < 1e-3).count(), 16);
    let highest = maps.values("max_water_level").iter().copied().filter(|z| z.is_finite()).fold(0.0, f64::max);
    assert!(highest > 100.3, "{highest} m");
    // A line that ends before ends the slide, too.
    scene.line("axis.geojson", &[(1015.0, 2050.0), (1045.0, 2050.0)]);
    let (run, _) = scene.run();
    assert!((of_bed(&run, "raised_m3") / volume - 1.0).abs() < 1e-9);
}

#[test]
fn moving_particles_feel_the_bed_that_moves() {
    let moving = ("time: {", "numerics: {motion: lagrangian}\ntime: {");
    // At 5 m the waves of so small a slide are a question of the resolution.
    let fine = ("resolution: 5 m", "resolution: 2.5 m");
    for (changes, raised) in [(vec![moving], 80.0 * 25.0 * 2.0), (vec![moving, SLIDE, fine], 400.0 * 3.0)] {
        let [resting, moving] = [&changes[1..], &changes].map(|changes| Scene::new(changes).run_and_read());
        let [(run, _), (of_resting, _)] = [&moving, &resting];
        let volume = |key: &str| run["volume_m3"][key].as_f64().unwrap();
        assert!(volume("error_relative").abs() < 1e-12 && volume("grid_error_relative") < 1e-6);
        assert!((volume("final") / volume("initial") - 1.0).abs() < 1e-12 && volume("in").abs() <= 0.0);
        assert!((of_bed(run, "raised_m3") / raised - 1.0).abs() < 1e-9);
        for key in ["sunk_m3", "began_s"] {
            assert!((of_bed(run, key) - of_bed(of_resting, key)).abs() <= 1e-9 * of_bed(of_resting, key), "{key}");
        }
        let lifted = of_bed(run, "lifted_m3") / of_bed(of_resting, "lifted_m3");
        println!("lifted: {lifted} of what Eulerian particles record");
        assert!((lifted - 1.0).abs() < 0.05, "{lifted}");
        // The bed at the end is the same.
        assert!(moving.1.values("bed_elevation") == resting.1.values("bed_elevation"));
        let wave = |maps: &Netcdf| {
            let highest: Vec<f64> =
                maps.values("max_water_level").iter().copied().filter(|z| z.is_finite() && *z > 0.0).collect();
            highest.iter().sum::<f64>() / highest.len() as f64 - 100.0
        };
        let waves = [wave(&moving.1), wave(&resting.1)];
        println!("mean of the highest levels above the lake, moving and resting (m): {waves:?}");
        assert!((waves[0] / waves[1] - 1.0).abs() < 0.15, "{waves:?} m");
    }
    let variational = ("resolution: 5 m", "numerics: {formulation: variational}\nresolution: 5 m");
    Scene::new(&[variational]).assert_check(3, &["error[method-combination] moving_bed", "variational"]);
}

#[test]
fn a_bed_that_does_not_fit_is_refused_with_its_place() {
    let refused = |changes: &[(&str, &str)], change: &dyn Fn(&Scene), expected: &[&str]| {
        let scene = Scene::new(changes);
        change(&scene);
        scene.assert_check(4, expected);
    };
    refused(
        &[],
        &|scene| scene.grid("change.asc", |_, _| 0.0),
        &["error[moves-nothing] moving_bed[0].change", "changes no cell"],
    );
    refused(
        &[],
        &|scene| scene.write("share.csv", "time_s,share\n0,0\n9,0.9\n"),
        &["growth-end", "moving_bed[0].share"],
    );
    refused(&[SLIDE], &|scene| scene.grid("slide.asc", |x, _| 20.0 - x), &["negative-value", "thickness below 0"]);
    refused(&[SLIDE], &|scene| scene.grid("slide.asc", |_, _| 0.0), &["moves-nothing", "no thickness anywhere"]);
    refused(
        &[SLIDE],
        &|scene| scene.write("velocity.csv", "time_s,v_m_s\n0,0\n"),
        &["slide-rests", "moving_bed[0].path"],
    );
    refused(
        &[SLIDE],
        &|scene| scene.write("velocity.csv", "time_s,v\n0,0\n9,1\n"),
        &["missing-unit", "moving_bed[0].velocity"],
    );
    let away = |scene: &Scene| {
        scene.line("axis.geojson", &[(1015.0, 2050.0), (900.0, 2050.0)]);
        scene.write("velocity.csv", "time_s,v_m_s\n0,20\n");
    };
    refused(&[SLIDE], &away, &["slide-outside", "where it comes to rest"]);
    // A slide far from its line would go the way of it all the same.
    let far = |scene: &Scene| scene.line("axis.geojson", &[(5015.0, 2050.0), (5100.0, 2050.0)]);
    let outside = "error[outside-terrain] moving_bed[0].path";
    refused(&[SLIDE], &far, &[outside, "axis.geojson lie outside the terrain", "5015.0, 2050.0", "the same CRS"]);
    let two = r#"{"type":"MultiLineString","coordinates":[[[1000,2000],[1010,2000]],[[1000,2010],[1010,2010]]]}"#;
    refused(&[SLIDE], &|scene| scene.write("axis.geojson", two), &["slide-lines", "holds 2 lines"]);
    let boundary = ("{side: all, type: closed}", "{side: east, stage: 100 m}");
    let to_edge = |scene: &Scene| scene.grid("change.asc", |x, _| if x > 150.0 { 1.0 } else { 0.0 });
    refused(&[boundary], &to_edge, &["moves-boundary", "1197.5"]);
    let dam = ("resolution: 5 m", "breach: {dam: dam.geojson, crest: 101 m}\nresolution: 5 m");
    let across = |scene: &Scene| scene.line("dam.geojson", &[(1122.0, 2000.0), (1122.0, 2100.0)]);
    refused(&[dam], &across, &["moves-dam", "1122.5"]);
    let scene = Scene::new(&[("at: 5 s", "at: 40 s")]);
    scene.assert_check(3, &["moves-after-end", "at 40 s", "at 30 s"]);
    let scene = Scene::new(&[("at: 5 s", "at: 25 s")]);
    scene.assert_check(0, &["warning[moves-at-end]", "it ends at 35 s"]);
    let scene = Scene::new(&[]);
    scene.write("share.csv", "time_s,share\n0,0\n1,.1\n2,.2\n3,.3\n4,.4\n5,.5\n9,.7\n10,.8\n11,.9\n12,1\n");
    scene.assert_check(0, &["warning[series-gap] moving_bed[0].share.series", "from 5 s (line 7) to 9 s (line 8)"]);
    let scene = Scene::new(&[SLIDE]);
    scene.line("axis.geojson", &[(1015.0, 2050.0), (1015.0, 2098.0)]);
    scene.assert_check(0, &["warning[slide-volume]", "where it comes to rest", "1.2000e3 m³"]);
}

#[test]
fn a_line_that_does_not_fit_its_slide_is_told() {
    // From the lake up to the slide: drawn backwards.
    let scene = Scene::new(&[SLIDE]);
    scene.line("axis.geojson", &[(1100.0, 2050.0), (1015.0, 2050.0)]);
    scene.grid("slide.asc", |x, y| if (105.0..125.0).contains(&x) && (40.0..60.0).contains(&y) { 3.0 } else { 0.0 });
    scene.write("velocity.csv", "time_s,v_m_s\n0,20\n");
    scene.assert_check(
        0,
        &[
            "warning[path-beside-slide] moving_bed[0].path",
            "1100.0, 2050.0",
            "warning[slide-uphill] moving_bed[0].path",
            "at 87.00 m at its start",
            "remedy  draw the line from",
        ],
    );
    // On level ground a slide may go either way.
    let scene = Scene::new(&[SLIDE]);
    scene.grid("dem.asc", |x, y| if (105.0..125.0).contains(&x) && (40.0..60.0).contains(&y) { 93.0 } else { 90.0 });
    scene.grid("slide.asc", |x, y| if (105.0..125.0).contains(&x) && (40.0..60.0).contains(&y) { 3.0 } else { 0.0 });
    scene.line("axis.geojson", &[(1115.0, 2050.0), (1065.0, 2050.0)]);
    scene.assert_check(0, &["0 errors, 0 warnings"]);
}

#[test]
fn a_velocity_that_ends_above_0_before_the_slide_rests_is_told() {
    let held = |rows: &str, expected: &[&str]| {
        let scene = Scene::new(&[SLIDE]);
        scene.write("velocity.csv", &format!("time_s,v_m_s\n{rows}\n"));
        scene.assert_check(0, expected);
    };
    let code = "warning[series-held] moving_bed[0].velocity.series";
    // 12 m of 85 m in 2 s, and the rest at 12 m/s; at 1 m/s it moves on until the run ends at 30 s.
    held("0,0\n2,12", &[code, "ends at 2 s, before the slide rests; its last value of 12 m/s holds on for 6.08333 s"]);
    held("0,0\n2,1", &[code, "its last value of 1 m/s holds on for 28 s", "remedy  add rows"]);
    // It comes to the end of its line, or to rest on its way, or the rows go on until the run ends.
    for rows in ["0,20\n6,20", "0,0\n2,12\n4,0", "0,1\n30,1"] {
        held(rows, &["0 errors, 0 warnings"]);
    }
}

#[test]
fn a_change_finer_than_the_lattice_is_told_with_its_volumes() {
    let scene = Scene::new(&[]);
    let grid = |cell: u32, value: &dyn Fn(f64, f64) -> f64| {
        let (columns, rows) = (200 / cell, 100 / cell);
        let header = format!(
            "ncols {columns}\nnrows {rows}\nxllcorner 1000\nyllcorner 2000\ncellsize {cell}\nNODATA_value -9999\n"
        );
        let size = f64::from(cell);
        let place = |k: u32| size * (f64::from(k) + 0.5);
        let rows = (0..rows).map(|row| {
            let cell = |column: u32| value(place(column), 100.0 - place(row)).to_string();
            (0..columns).map(cell).collect::<Vec<_>>().join(" ")
        });
        scene.write("change.asc", &(header + &rows.collect::<Vec<_>>().join("\n") + "\n"));
    };
    // A bank 3 m wide, 100 m long and 8 m high, which the cells of 5 m make 5 m wide.
    grid(1, &|x, _| if (101.0..104.0).contains(&x) { 8.0 } else { 0.0 });
    scene.assert_check(
        0,
        &[
            "warning[change-volume] moving_bed[0].change",
            "raises 4.0000e3 m³",
            "it is 2.4000e3 m³",
            "finer `resolution`",
        ],
    );
    // Sunk ground does not make up for raised ground.
    grid(1, &|x, _| {
        if (101.0..104.0).contains(&x) {
            8.0
        } else if (106.0..109.0).contains(&x) {
            -8.0
        } else {
            0.0
        }
    });
    scene.assert_check(0, &["warning[change-volume]", "lowers 4.0000e3 m³"]);
    // What fills whole cells keeps its volume, up to the edge of the terrain.
    grid(1, &|x, _| if x > 150.0 { 2.0 } else { 0.0 });
    let change = floodsim(scene.folder.path(), &["check", "s.yaml"]).stdout;
    assert!(!change.contains("change-volume"), "{change}");
}

#[test]
fn changes_in_millimetres_are_no_doubtful_elevations() {
    let scene = Scene::new(&[("change: change.asc", "change: change.asc, unit: mm")]);
    scene.grid("change.asc", |x, _| if (100.0..140.0).contains(&x) { -2000.0 } else { 0.0 });
    scene.assert_check(0, &["0 errors, 0 warnings"]);
    scene.grid("change.asc", |x, _| if (100.0..140.0).contains(&x) { 12_000_000.0 } else { 0.0 });
    scene.assert_check(0, &["warning[doubtful-change] moving_bed[0].change", "12000.0 m", "`unit`"]);
    scene.grid("change.asc", |x, _| if (100.0..140.0).contains(&x) { -2e9 } else { 0.0 });
    scene.assert_check(4, &["error[implausible-value] moving_bed[0].change", "-2000000.0 m", "`unit`"]);
}
