//! Blocked buildings whose outlines cells follow.

use std::path::PathBuf;

use tempfile::TempDir;

use crate::{Netcdf, floodsim, run_scene};

/// A ring of places (m).
type Ring = Vec<(f64, f64)>;

/// Edge of a cell (m) of the scenes.
const CELL: f64 = 2.0;

/// A scenario in a square or a longer piece of ground, with houses.
struct Scene {
    folder: TempDir,
    columns: usize,
    rows: usize,
}

/// Numbers between 0 and 1, the same at every run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// A rectangle around a place, turned by an angle in degrees.
fn house((x, y): (f64, f64), (width, depth): (f64, f64), angle: f64) -> Ring {
    let (sin, cos) = angle.to_radians().sin_cos();
    let corner = |across: f64, up: f64| {
        let (a, b) = (across * 0.5 * width, up * 0.5 * depth);
        (x + a * cos - b * sin, y + a * sin + b * cos)
    };
    vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0)]
}

impl Scene {
    fn new((columns, rows): (usize, usize), elevation: impl FnMut(usize, usize) -> f64) -> Scene {
        let scene = Scene { folder: TempDir::new().unwrap(), columns, rows };
        let mut elevation = elevation;
        let mut text = format!("ncols {columns}\nnrows {rows}\nxllcorner 0\nyllcorner 0\ncellsize {CELL}\n");
        for row in (0..rows).rev() {
            let values: Vec<String> = (0..columns).map(|column| format!("{:.6}", elevation(column, row))).collect();
            text += &(values.join(" ") + "\n");
        }
        scene.write("dem.asc", &text);
        scene
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: &str) {
        std::fs::write(self.path(name), content).unwrap();
    }

    /// Polygons, each with its rings.
    fn polygons(&self, name: &str, polygons: &[Vec<Ring>]) {
        let ring = |ring: &Ring| {
            let places: Vec<String> = ring.iter().map(|(x, y)| format!("[{x},{y}]")).collect();
            format!("[{}]", places.join(","))
        };
        let feature = |rings: &Vec<Ring>| {
            let rings: Vec<String> = rings.iter().map(ring).collect();
            let geometry = format!(r#"{{"type":"Polygon","coordinates":[{}]}}"#, rings.join(","));
            format!(r#"{{"type":"Feature","properties":{{}},"geometry":{geometry}}}"#)
        };
        let features: Vec<String> = polygons.iter().map(feature).collect();
        self.write(name, &format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, features.join(",")));
    }

    /// Still water all over the ground, and houses in it.
    fn lake(&self, level: f64, houses: &[Vec<Ring>]) {
        let (width, height) = (self.columns as f64 * CELL, self.rows as f64 * CELL);
        self.polygons("houses.geojson", houses);
        self.polygons("lake.geojson", &[vec![house((0.5 * width, 0.5 * height), (width, height), 0.0)]]);
        self.write(
            "s.yaml",
            &format!(
                "floodsim: 1\ncrs: local\nterrain: {{layers: [{{raster: dem.asc}}]}}\nroughness: {{manning: 0.0}}\n\
                 initial: [{{water: lake.geojson, level: {level} m}}]\n\
                 structures: {{buildings: {{polygons: houses.geojson, mode: block}}}}\nresolution: {CELL} m\n\
                 time: {{end: 4 min}}\noutputs: {{every: 4 min}}\n"
            ),
        );
    }

    #[track_caller]
    fn run(&self, out: &str, options: &[&str]) -> serde_json::Value {
        run_scene(self.folder.path(), out, options).0
    }

    /// A quantity of the last frame by row from the south and column.
    fn last(&self, out: &str, name: &str) -> Vec<Vec<f64>> {
        let fields = Netcdf::read(&self.path(out).join("fields.nc"));
        let values = fields.values(name);
        let frame = &values[values.len() - self.columns * self.rows..];
        frame.chunks(self.columns).rev().map(<[f64]>::to_vec).collect()
    }
}

fn number(record: &serde_json::Value, path: &str) -> f64 {
    record.pointer(path).and_then(serde_json::Value::as_f64).unwrap()
}

/// Houses of 0.3 to 6 cells at any angle, some of them over each other, the larger ones with courtyards.
fn town() -> Vec<Vec<Ring>> {
    let mut numbers = Numbers(0x2545_f491_4f6c_dd1d);
    let mut some_house = |_| {
        let mut size = || 0.3 * CELL * 20_f64.powf(numbers.next());
        let (width, depth) = (size(), size());
        let (place, angle) =
            ((numbers.between(20.0, 100.0), numbers.between(20.0, 100.0)), numbers.between(0.0, 180.0));
        let mut rings = vec![house(place, (width, depth), angle)];
        if width.min(depth) > 3.0 * CELL {
            rings.push(house(place, (0.6 * width, 0.6 * depth), angle).into_iter().rev().collect());
        }
        rings
    };
    let mut houses: Vec<Vec<Ring>> = (0..34).map(&mut some_house).collect();
    // Wall to wall.
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    houses.extend([0.0, 6.0].map(|along| vec![house((15.0 + along * cos, 15.0 + along * sin), (6.0, 4.0), 20.0)]));
    houses
}

fn rough(columns: usize, rows: usize) -> Scene {
    let mut numbers = Numbers(7);
    Scene::new((columns, rows), |_, _| numbers.between(-1.0, 0.0))
}

#[test]
fn a_lake_about_a_town_is_at_rest() {
    let scene = rough(60, 60);
    scene.lake(1.0, &town());
    // Where it may rain no water sleeps.
    let record = scene.run("lake", &["--set", "rain={rate: 0 mm/h}"]);
    assert!(number(&record, "/steps") >= 1000.0, "{}", record["steps"]);
    assert!(number(&record, "/max_speed_m_s") < 1e-12, "{}", record["max_speed_m_s"]);
    assert!(number(&record, "/volume_m3/error_relative").abs() < 1e-12);
    assert!(number(&record, "/still_water/0/seeded_m3") > 1e4);
    // Cells between houses do not rule the step: on squares alone it is 0.094 s.
    let rain = ["--set", "rain={rate: 1 mm/h}", "--set", "time.end=20 s", "--set", "outputs.every=20 s"];
    let built = scene.run("built", &rain);
    let open = scene.run("open", &[&rain[..], &["--set", "structures={}"]].concat());
    let [built, open] = [&built, &open].map(|record| number(record, "/dt_s/median"));
    assert!(built > 0.4 * open, "steps of {built} s, {open} s without houses");
}

#[test]
fn the_number_of_threads_does_not_change_a_flood_in_a_town() {
    let scene = rough(60, 60);
    scene.lake(1.0, &town());
    scene.polygons("lake.geojson", &[vec![house((30.0, 60.0), (59.0, 119.0), 0.0)]]);
    let short = ["--set", "time.end=40 s", "--set", "outputs.every=40 s"];
    let record = scene.run("one", &[&short[..], &["--threads", "1"]].concat());
    scene.run("two", &[&short[..], &["--threads", "2"]].concat());
    assert!(number(&record, "/max_speed_m_s") > 1.0 && number(&record, "/volume_m3/error_relative").abs() < 1e-12);
    let [one, two] = ["one", "two"].map(|out| Netcdf::read(&scene.path(out).join("maps.nc")));
    assert_eq!(one.bits(), two.bits());
}

#[test]
fn a_flooded_town_holds_its_area_without_the_houses_times_the_depth() {
    let scene = Scene::new((40, 40), |_, _| 0.0);
    let mut numbers = Numbers(99);
    // On places of their own, from a tenth of a cell to four cells.
    let (mut houses, mut built) = (Vec::new(), 0.0);
    for k in 0..25_u32 {
        let size = CELL * 0.2 * 16_f64.powf(numbers.next());
        let depth = CELL * 0.2 * 16_f64.powf(numbers.next());
        let place = (10.0 + 15.0 * f64::from(k % 5), 10.0 + 15.0 * f64::from(k / 5));
        houses.push(vec![house(place, (size, depth), numbers.between(0.0, 90.0))]);
        built += size * depth;
    }
    scene.lake(1.5, &houses);
    let check = floodsim(scene.folder.path(), &["check", "s.yaml"]);
    // The water stands at the edge, and nothing else is told.
    let told = check.stdout.contains("1 warning") && check.stdout.contains("warning[closed-edge]");
    assert!(check.code == 0 && told, "{}", check.stdout);
    let record = scene.run("town", &["--set", "time.end=1 s", "--set", "outputs.every=1 s"]);
    let (held, expected) = (number(&record, "/volume_m3/initial"), 1.5 * (80.0 * 80.0 - built));
    assert!((held / expected - 1.0).abs() < 1e-12, "{held} m3 of {expected} m3");
    let integral = number(&record, "/still_water/0/integral_m3");
    assert!((integral / expected - 1.0).abs() < 1e-9, "{integral} m3 of {expected} m3");
}

#[test]
fn a_courtyard_stays_dry_while_a_flood_passes_its_house() {
    for (thickness, angle) in [(0.6, 0.0), (0.6, 20.0), (0.6, 45.0), (2.5, 33.0), (0.7, 71.0)] {
        let scene = Scene::new((30, 30), |_, _| 0.0);
        let (x, y, width, depth) = (34.3, 29.6, 21.0, 17.0);
        let inner = house((x, y), (width - 2.0 * thickness, depth - 2.0 * thickness), angle);
        scene.lake(5.0, &[vec![house((x, y), (width, depth), angle), inner.iter().rev().copied().collect()]]);
        scene.polygons("lake.geojson", &[vec![house((8.0, 30.0), (16.0, 60.0), 0.0)]]);
        let record = scene.run("ring", &["--set", "time.end=60 s", "--set", "outputs.every=60 s"]);
        assert!(number(&record, "/volume_m3/error_relative").abs() < 1e-12);
        let maps = Netcdf::read(&scene.path("ring/maps.nc"));
        let deepest = |column: usize, row: usize| maps.values("max_depth")[(29 - row) * 30 + column];
        assert!(deepest(1, 14) > 1.0 && deepest(28, 14) > 0.5, "{thickness} m at {angle}");
        let (sin, cos) = angle.to_radians().sin_cos();
        for (across, up) in (-3..=3).flat_map(|k| (-2..=2).map(move |l| (2.5 * f64::from(k), 2.5 * f64::from(l)))) {
            let place = (x + across * cos - up * sin, y + across * sin + up * cos);
            let found = deepest((place.0 / CELL) as usize, (place.1 / CELL) as usize);
            assert!(found <= 0.0 || found.is_nan(), "{found} m at {place:?}, {thickness} m at {angle}");
        }
    }
}

/// Level (m) upstream of a row of posts across a channel of 16 m, and how much it differs across.
fn upstream(houses: &[Vec<Ring>]) -> (f64, f64) {
    let scene = Scene::new((60, 8), |_, _| 0.0);
    scene.lake(1.0, houses);
    scene.write(
        "s.yaml",
        "floodsim: 1\ncrs: local\nterrain: {layers: [{raster: dem.asc}]}\nroughness: {manning: 0.02}\n\
         initial: [{water: lake.geojson, level: 1 m}]\n\
         boundaries:\n  - {side: west, discharge: 16 m3/s}\n  - {side: east, level: 1 m}\n\
         structures: {buildings: {polygons: houses.geojson, mode: block}}\nresolution: 2 m\n\
         time: {end: 6 min}\noutputs: {every: 6 min}\n",
    );
    let options = if houses.is_empty() { &["--set", "structures={}"][..] } else { &[] };
    scene.run("posts", options);
    let depth = scene.last("posts", "depth");
    let across: Vec<f64> = depth.iter().map(|row| row[15]).collect();
    let mean = across.iter().sum::<f64>() / 8.0;
    let unlike = (0..4).map(|row| (across[row] - across[7 - row]).abs()).fold(0.0, f64::max);
    (mean, unlike)
}

#[test]
fn a_row_of_posts_smaller_than_a_cell_raises_the_level_before_it() {
    let (open, _) = upstream(&[]);
    // A quarter of the section. On cells of 0.25 m posts of 1 m raise the level by 0.042 m.
    for (size, pitch) in [(0.5, 2.0), (1.0, 4.0), (2.0, 8.0)] {
        let count = (16.0_f64 / pitch).round() as u32;
        let posts = (0..count).map(|k| vec![house((60.3, pitch * (f64::from(k) + 0.5)), (size, size), 0.0)]);
        let (held, unlike) = upstream(&posts.collect::<Vec<_>>());
        let rise = held - open;
        println!("posts of {size} m raise the level by {rise:.4} m");
        assert!((0.02..0.09).contains(&rise), "posts of {size} m: {rise} m");
        assert!(unlike < 1e-4, "{unlike} m across");
    }
}

/// Mean, least and greatest depth (m) in a street of five cells between houses, at an angle to the lattice.
fn street(angle: f64) -> [f64; 3] {
    let (sin, cos) = angle.to_radians().sin_cos();
    let scale = 0.2;
    let place = |along: f64, left: f64| {
        (scale * (150.0 + along * cos - left * sin), scale * (200.0 + along * sin + left * cos))
    };
    let scene = Scene::new((100, 100), |column, row| {
        let (x, y) = ((column as f64 + 0.5) * CELL - scale * 150.0, (row as f64 + 0.5) * CELL - scale * 200.0);
        20.0 - 0.005 * (x * cos + y * sin)
    });
    let mut numbers = Numbers(5);
    let mut houses = vec![vec![vec![
        place(-60.0, -25.0),
        place(-40.0, -25.0),
        place(-40.0, 25.0),
        place(-60.0, 25.0),
        place(-60.0, -25.0),
    ]]];
    for side in [-1.0, 1.0] {
        let mut along = -60.0;
        while along < 1300.0 {
            let end = along + numbers.between(20.0, 70.0);
            let corners = [(along, 25.0), (end, 25.0), (end, 55.0), (along, 55.0), (along, 25.0)];
            houses.push(vec![corners.map(|(along, left)| place(along, side * left)).to_vec()]);
            along = end;
        }
    }
    scene.lake(1.0, &houses);
    let [from, to] = [-15.0, 15.0].map(|left| place(0.0, left));
    let line = format!("[[{},{}],[{},{}]]", from.0, from.1, to.0, to.1);
    scene.write(
        "in.geojson",
        &format!(r#"{{"type":"Feature","properties":{{}},"geometry":{{"type":"LineString","coordinates":{line}}}}}"#),
    );
    scene.write(
        "s.yaml",
        "floodsim: 1\ncrs: local\nterrain: {layers: [{raster: dem.asc}]}\nroughness: {manning: 0.03}\n\
         sources: [{line: in.geojson, discharge: 10 m3/s}]\nboundaries: [{side: all, type: open}]\n\
         structures: {buildings: {polygons: houses.geojson, mode: block}}\nresolution: 2 m\n\
         time: {end: 6 min}\noutputs: {every: 6 min}\n",
    );
    scene.run("street", &[]);
    let depth = scene.last("street", "depth");
    let places =
        (0..20).flat_map(|k| [-20.0, -10.0, 0.0, 10.0, 20.0].map(|left| place(300.0 + 10.0 * f64::from(k), left)));
    let found: Vec<f64> = places.map(|(x, y)| depth[(y / CELL) as usize][(x / CELL) as usize]).collect();
    let mean = found.iter().sum::<f64>() / found.len() as f64;
    [mean, found.iter().copied().fold(f64::INFINITY, f64::min), found.iter().copied().fold(0.0, f64::max)]
}

#[test]
fn a_street_askew_to_the_lattice_has_its_normal_depth_between_houses() {
    // 1 m2/s on a slope of 0.005 with n = 0.03, walls without friction.
    let exact = (1.0 * 0.03 / 0.005_f64.sqrt()).powf(0.6);
    for angle in [30.0, 45.0] {
        let found = street(angle);
        println!("at {angle} degrees {found:.4?} m, exact {exact:.4} m");
        assert!(found.iter().all(|depth| (depth / exact - 1.0).abs() < 0.02), "{found:?} m, exact {exact} m");
    }
}
