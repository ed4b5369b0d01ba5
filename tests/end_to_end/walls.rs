//! Walls that cells follow: gaps as wide as drawn, ends near the edge of the terrain, and lakes beside them.

use std::path::Path;

use tempfile::TempDir;

use crate::{feature, floodsim, run_scene};

const SCENARIO: &str = "\
floodsim: 1
crs: local
terrain: {layers: [{raster: dem.asc}], follow_banks: false}
structures: {walls: [{lines: wall.geojson}]}
roughness: {manning: 0.02}
initial: [{reservoir: lake.geojson, level: 3 m}]
boundaries: [{side: east, type: free}]
resolution: 10 m
time: {end: 60 s}
outputs: {every: 60 s, sections: gap.geojson}
";

/// A flat basin of 400 m by 200 m, a lake in its west, and a wall across it that leans by an angle (degrees) and stands on pieces of its way from the
/// southern edge (m).
fn scene(degrees: f64, pieces: &[[f64; 2]]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, content: &str| std::fs::write(folder.path().join(name), content).unwrap();
    let ground = vec![vec!["0"; 80].join(" "); 40].join("\n");
    write("dem.asc", &format!("ncols 80\nnrows 40\nxllcorner 0\nyllcorner 0\ncellsize 5\n{ground}\n"));
    let lean = degrees.to_radians().tan();
    let place = |up: f64| format!("[{},{up}]", 200.0 + lean * (up - 100.0));
    let feature =
        |geometry: String| format!(r#"{{"type":"Feature","properties":{{"id":"gap"}},"geometry":{geometry}}}"#);
    let line = |[from, to]: [f64; 2]| format!("[{},{}]", place(from), place(to));
    let lines = pieces.iter().copied().map(line).collect::<Vec<_>>().join(",");
    write("wall.geojson", &feature(format!(r#"{{"type":"MultiLineString","coordinates":[{lines}]}}"#)));
    let ring = format!("[[0,0],{},{},[0,200],[0,0]]", place(0.0), place(200.0));
    write("lake.geojson", &feature(format!(r#"{{"type":"Polygon","coordinates":[{ring}]}}"#)));
    write(
        "gap.geojson",
        &feature(format!(r#"{{"type":"LineString","coordinates":[{},{}]}}"#, place(-5.0), place(205.0))),
    );
    write("s.yaml", SCENARIO);
    folder
}

/// What passes the wall within a minute (m³).
fn passed(folder: &TempDir, resolution: &str) -> (f64, String) {
    let out = resolution.replace(' ', "");
    let (_, said) = run_scene(folder.path(), &out, &["--set", &format!("resolution={resolution}")]);
    let table = std::fs::read_to_string(folder.path().join(out).join("tables/sections.csv")).unwrap();
    let mut lines = table.lines();
    let column = lines.next().unwrap().split(',').position(|name| name.starts_with("volume")).unwrap();
    let volume: f64 = lines.last().unwrap().split(',').nth(column).unwrap().parse().unwrap();
    (volume.abs(), said.stderr)
}

#[test]
fn a_wall_that_ends_within_half_a_cell_of_the_edge_of_the_terrain_holds_a_lake() {
    for degrees in [0.0, 12.0, 40.0] {
        let folder = scene(degrees, &[[4.4, 195.8]]);
        let (record, _) = run_scene(folder.path(), "out", &[]);
        let speed = record["max_speed_m_s"].as_f64().unwrap();
        assert!(speed < 1e-12, "{degrees} degrees: {speed:e} m/s");
        assert!(record["steps"].as_f64().unwrap() > 50.0);
    }
    // One that ends farther inside leaves a gap.
    let folder = scene(0.0, &[[4.4, 194.0]]);
    let (record, _) = run_scene(folder.path(), "out", &[]);
    assert!(record["max_speed_m_s"].as_f64().unwrap() > 1.0);
}

#[test]
fn a_gap_narrower_than_a_cell_passes_what_it_does_on_fine_cells() {
    for (degrees, width, shares) in [(0.0, 4.0, 0.75..0.95), (20.0, 4.0, 0.75..0.95), (20.0, 12.0, 0.9..1.0)] {
        let half = 0.5 * width;
        let folder = scene(degrees, &[[0.0, 100.0 - half], [100.0 + half, 200.0]]);
        let [(coarse, said), (fine, _)] = ["10 m", "1.25 m"].map(|resolution| passed(&folder, resolution));
        println!("{degrees} degrees, {width} m: {coarse:.0} m3, on fine cells {fine:.0} m3");
        assert!(
            shares.contains(&(coarse / fine)),
            "{degrees} degrees, {width} m: {coarse} m3, on fine cells {fine} m3"
        );
        assert!(!said.contains("gap-on-lattice"), "{said}");
        assert_eq!(said.contains("warning[narrow-gap] structures.walls[0].lines"), width < 10.0, "{said}");
    }
}

#[test]
fn a_levee_across_a_wall_does_not_shorten_the_steps() {
    // Squares stay beside a levee, and the wall cuts slivers off the cells next to them.
    for degrees in [12.0, 33.0, 45.0] {
        let folder = scene(degrees, &[[0.0, 120.0]]);
        let levee = feature("LineString", "[120,60],[320,75]");
        std::fs::write(folder.path().join("levee.geojson"), levee).unwrap();
        let steps = |lines: &str| {
            let breaklines = format!("terrain.breaklines=[{lines}]");
            let options = ["--set", "resolution=7 m", "--set", &breaklines, "--overwrite"];
            run_scene(folder.path(), "out", &options).0["steps"].as_f64().unwrap()
        };
        let (with, without) = (steps("{lines: levee.geojson, mode: raise, z: 1 m}"), steps(""));
        println!("{degrees} degrees: {with} steps, {without} without the levee");
        assert!(
            without > 100.0 && with < 1.2 * without,
            "{degrees} degrees: {with} steps, {without} without the levee"
        );
    }
}

#[test]
fn water_at_a_closed_edge_of_the_terrain_is_told() {
    // All water west of a wall that stands on a tenth of its way alone.
    let folder = scene(0.0, &[[0.0, 20.0]]);
    for resolution in ["10 m", "{finest: 5 m, coarsest: 20 m}"] {
        let told = |out: &str, boundaries: &str| {
            let boundaries = format!("boundaries={boundaries}");
            let options = ["--set", &boundaries, "--set", &format!("resolution={resolution}"), "--overwrite"];
            run_scene(folder.path(), out, &options).0.get("closed_edge").cloned()
        };
        let closed = told("closed", "[]").unwrap();
        let number = |key: &str| closed[key].as_f64().unwrap();
        println!("{resolution}: {closed}");
        // The dry half has an edge of 600 m, some of it beside the wall.
        assert!((540.0..=1200.0).contains(&number("length_m")), "{closed}");
        assert!(number("first_s") < 10.0 && (190.0..220.0).contains(&number("x")), "{closed}");
        assert!((1.0..3.5).contains(&number("deepest_m")), "{closed}");
        // Sides along the flow alone are left.
        let sides = told("sides", "[{side: east, type: free}]").unwrap();
        assert!((340.0..=800.0).contains(&sides["length_m"].as_f64().unwrap()), "{sides}");
        assert_eq!(told("open", "[{side: all, type: open}]"), None, "{resolution}");
    }
}

/// A rough valley in a raster of 1 km by 1 km with a dam across it at an angle (degrees) and a wall in its lake, whose polygon ends `short` of the dam (m).
fn valley(degrees: f64, short: f64) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, content: &str| std::fs::write(folder.path().join(name), content).unwrap();
    let (sin, cos) = degrees.to_radians().sin_cos();
    let turned = |along: f64, across: f64| [500.0 + along * cos - across * sin, 500.0 + along * sin + across * cos];
    // Numbers between 0 and 1 that look like chance.
    let rough = |i: usize, j: usize| ((i as f64 * 12.9898 + j as f64 * 78.233).sin() * 43758.5453).rem_euclid(1.0);
    let height = |i: usize, j: usize| {
        let (x, y) = (10.0 * i as f64 - 495.0, 495.0 - 10.0 * j as f64);
        let (along, across) = (x * cos + y * sin, y * cos - x * sin);
        let sides = (across / 100.0).powi(2) + ((-along - 250.0).max(0.0) / 50.0).powi(2);
        format!("{:.3}", 103.0 - 0.01 * along + sides + rough(i, j))
    };
    let row = |j: usize| (0..100).map(|i| height(i, j)).collect::<Vec<_>>().join(" ");
    let ground = (0..100).map(row).collect::<Vec<_>>().join("\n");
    write("dem.asc", &format!("ncols 100\nnrows 100\nxllcorner 0\nyllcorner 0\ncellsize 10\n{ground}\n"));
    let places = |places: &[[f64; 2]]| {
        let place = |&[along, across]: &[f64; 2]| format!("{:?}", turned(along, across));
        places.iter().map(place).collect::<Vec<_>>().join(",")
    };
    let walls = [places(&[[0.0, -490.0], [0.0, 490.0]]), places(&[[-230.0, -120.0], [-90.0, 20.0], [-60.0, 150.0]])];
    write("wall.geojson", &feature("MultiLineString", &walls.map(|line| format!("[{line}]")).join(",")));
    let ring = [[-380.0, -240.0], [-short, -240.0], [-short, 240.0], [-380.0, 240.0], [-380.0, -240.0]];
    write("lake.geojson", &feature("Polygon", &format!("[{}]", places(&ring))));
    write("s.yaml", LAKE);
    folder
}

/// Rain of nothing keeps the lake awake.
const LAKE: &str = "\
floodsim: 1
crs: local
terrain: {layers: [{raster: dem.asc}]}
structures: {walls: [{lines: wall.geojson}]}
roughness: {manning: 0.03}
initial: [{reservoir: lake.geojson, level: 108 m}]
rain: {rate: 0 mm/h}
resolution: 10 m
time: {end: 30 s}
outputs: {every: 30 s}
";

#[test]
fn a_lake_on_rough_ground_rests_beside_walls_and_where_its_polygon_ends_before_one() {
    for (degrees, short) in [(0.0, 0.0), (13.0, 7.0), (30.0, 0.0), (45.0, 7.0)] {
        let folder = valley(degrees, short);
        for resolution in ["7 m", "10 m", "15 m", "20 m", "{finest: 7 m, coarsest: 28 m}"] {
            let (record, _) =
                run_scene(folder.path(), "out", &["--set", &format!("resolution={resolution}"), "--overwrite"]);
            let speed = record["max_speed_m_s"].as_f64().unwrap();
            println!("{degrees} degrees, {short} m short, {resolution}: {speed:e} m/s");
            assert!(speed < 1e-12, "{degrees} degrees, {short} m short, {resolution}: {speed:e} m/s");
        }
    }
}

#[test]
fn the_dam_of_the_tutorial_stands_as_a_wall_and_nothing_moves() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let out = tempfile::tempdir().unwrap();
    for resolution in ["20 m", "25 m", "40 m"] {
        let folder = out.path().join(resolution);
        let settings = [
            "structures={walls: [{lines: ../../data/demo_valley/dam_line.geojson}]}",
            "rain={rate: 0 mm/h}",
            "time.end=2 min",
            &format!("resolution={resolution}"),
        ];
        let mut given = vec!["scenarios/tutorial/scenario.yaml", "--quiet", "--out", folder.to_str().unwrap()];
        given.extend(settings.iter().flat_map(|setting| ["--set", setting]));
        let answer = floodsim(root, &given);
        assert_eq!(answer.code, 0, "{}", answer.stderr);
        let record = std::fs::read_to_string(folder.join("run.json")).unwrap();
        let record: serde_json::Value = serde_json::from_str(&record).unwrap();
        let speed = record["max_speed_m_s"].as_f64().unwrap();
        assert!(speed < 1e-12, "{resolution}: {speed:e} m/s");
    }
}
