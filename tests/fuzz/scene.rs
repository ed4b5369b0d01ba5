//! The sound inputs that are changed: scenarios that name as many keys as can be, and every file that they name.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::LazyLock;

use tempfile::TempDir;

use crate::{binary, judge};

/// Columns and rows of the terrain, the edge of its pixels (m), and its south-western corner.
pub const COLUMNS: usize = 24;
pub const ROWS: usize = 16;
pub const CELL: f64 = 5.0;
pub const CORNER: [f64; 2] = [1000.0, 2000.0];

/// The scenarios with their names, and the files that they name.
pub struct Scene {
    pub scenarios: Vec<(String, String)>,
    pub files: BTreeMap<String, Vec<u8>>,
}

/// What all targets share; made once.
pub static SCENE: LazyLock<Scene> = LazyLock::new(Scene::new);

/// Elevation (m) of a pixel: a valley that falls to the east; row 0 is the northernmost one.
pub fn elevation(column: usize, row: usize) -> f64 {
    10.0 + 0.6 * (row as f64 - 7.5).abs() - 0.05 * column as f64
}

/// An ESRI ASCII grid.
pub fn grid(value: impl Fn(usize, usize) -> f64) -> String {
    let row = |row: usize| (0..COLUMNS).map(|column| format!("{:.3} ", value(column, row))).collect::<String>() + "\n";
    let [west, south] = CORNER;
    let header = format!(
        "ncols {COLUMNS}\nnrows {ROWS}\nxllcorner {west}\nyllcorner {south}\ncellsize {CELL}\nNODATA_value -9999\n"
    );
    header + &(0..ROWS).map(row).collect::<String>()
}

/// A GeoJSON feature; coordinates count from the corner of the terrain.
fn feature(kind: &str, coordinates: &[[f64; 2]], properties: &str) -> String {
    let places: Vec<String> =
        coordinates.iter().map(|[x, y]| format!("[{:?}, {:?}]", CORNER[0] + x, CORNER[1] + y)).collect();
    let places = match kind {
        "Point" => places.join(", "),
        "LineString" => format!("[{}]", places.join(", ")),
        _ => format!("[[{}]]", places.join(", ")),
    };
    format!(
        r#"{{"type": "Feature", "properties": {{{properties}}}, "geometry": {{"type": "{kind}", "coordinates": {places}}}}}"#
    )
}

fn collection(features: &[String]) -> String {
    format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, features.join(", "))
}

fn line(properties: &str, from: [f64; 2], to: [f64; 2]) -> String {
    feature("LineString", &[from, to], properties)
}

fn rectangle(properties: &str, [west, south, east, north]: [f64; 4]) -> String {
    feature("Polygon", &[[west, south], [east, south], [east, north], [west, north], [west, south]], properties)
}

/// The vector files that are text.
fn vectors() -> Vec<(&'static str, String)> {
    let sections =
        [line(r#""id": "s1""#, [70.0, 75.0], [70.0, 5.0]), line(r#""id": "s2""#, [100.0, 75.0], [100.0, 5.0])];
    let points = [[50.0, 40.0], [60.0, 45.0]].map(|[x, y]| feature("Point", &[[x, y]], &format!(r#""id": "p{x}""#)));
    let files = [
        ("lake.geojson", rectangle(r#""level_m": 12.0"#, [0.0, 0.0, 40.0, 80.0])),
        ("all.geojson", rectangle("", [0.0, 0.0, 120.0, 80.0])),
        ("building.geojson", rectangle(r#""height_m": 5.0, "n": 0.2"#, [60.0, 20.0, 70.0, 30.0])),
        ("rough.geojson", rectangle(r#""n": 0.1"#, [50.0, 20.0, 90.0, 60.0])),
        ("river.geojson", line(r#""w": 10.0"#, [60.0, 40.0], [110.0, 40.0])),
        ("dam.geojson", line(r#""crest_m": 14.0"#, [42.0, 0.0], [42.0, 80.0])),
        ("wall.geojson", line(r#""crest": 11.0"#, [80.0, 10.0], [80.0, 30.0])),
        ("levee.geojson", line(r#""crest_m": 12.0"#, [90.0, 10.0], [100.0, 60.0])),
        ("inflow.geojson", line("", [0.0, 20.0], [0.0, 60.0])),
        ("outflow.geojson", line("", [120.0, 20.0], [120.0, 60.0])),
        ("springs.geojson", line("", [50.0, 20.0], [50.0, 60.0])),
        ("slide_path.geojson", line("", [22.0, 67.0], [40.0, 45.0])),
        ("axis.geojson", line(r#""id": "up""#, [-100.0, 40.0], [0.0, 40.0])),
    ];
    let files = files.map(|(name, feature)| (name, collection(&[feature])));
    let of_several = [("sections.geojson", collection(&sections)), ("points.geojson", collection(&points))];
    files.into_iter().chain(of_several).collect()
}

/// Survey points on the terrain, in no order.
fn survey() -> String {
    let point = |k: usize| {
        let (column, row) = (k * 7 % COLUMNS, k * 5 % ROWS);
        let (x, y) = (CORNER[0] + CELL * (column as f64 + 0.5), CORNER[1] + CELL * ((ROWS - row) as f64 - 0.5));
        format!("{x:.2} {y:.2} {:.3}\n", elevation(column, row))
    };
    (0..COLUMNS * ROWS).map(point).collect()
}

/// The other files that are text.
fn tables() -> Vec<(&'static str, String)> {
    let tables = [
        ("gauges.csv", "id,x,y\ng1,1050,2040\ng2,1090,2042\n"),
        ("discharge.csv", "time_min,q_m3_s\n0,1\n1,8\n2,3\n60,1\n"),
        ("tide.csv", "time_h,level_m\n0,11\n0.5,11.2\n2,10\n"),
        ("rating.csv", "level_m,q_m3_s\n9.0,0\n10,2\n12,20\n"),
        ("share.csv", "time_min,share\n0,0\n0.02,0.4\n0.05,1\n"),
        ("velocity.csv", "time_s,v_m_s\n0,0\n2,3\n8,0\n"),
        ("manning.csv", "class,name,n\n1,water,0.03\n2,grass,0.04\n3,wood,0.08\n4,road,0.02\n"),
        (
            "cross_sections.csv",
            "distance_m,elevation_m,width_m\n0,11,10\n0,12,20\n0,14,40\n100,10,10\n100,11,20\n100,13,40\n",
        ),
        ("rain_list.csv", "time_s,file\n0,rain.tif\n2,rain.asc\n4,rain.tif\n6,rain.tif\n"),
    ];
    let grids = [("dem.asc", grid(elevation)), ("rain.asc", grid(|_, _| 30.0)), ("survey.xyz", survey())];
    tables.into_iter().map(|(name, text)| (name, text.to_owned())).chain(grids).collect()
}

impl Scene {
    fn new() -> Scene {
        let folder = TempDir::new().unwrap();
        for (name, text) in vectors().into_iter().chain(tables()) {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        binary::write(folder.path());
        earlier_run(folder.path());
        let mut files = BTreeMap::new();
        read_files(folder.path(), folder.path(), &mut files);
        let scenarios = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/scenarios");
        let mut scenarios: Vec<(String, String)> = std::fs::read_dir(scenarios)
            .unwrap()
            .map(|entry| entry.unwrap())
            .map(|entry| (entry.file_name().into_string().unwrap(), std::fs::read_to_string(entry.path()).unwrap()))
            .collect();
        scenarios.sort();
        Scene { scenarios, files }
    }

    /// Writes all files into a folder.
    pub fn write(&self, folder: &Path) {
        std::fs::create_dir_all(folder.join("before")).unwrap();
        for (name, content) in &self.files {
            std::fs::write(folder.join(name), content).unwrap();
        }
    }

    /// The names of the files that a scenario names and that end so.
    pub fn named_in(&self, scenario: &str, ends: &[&str]) -> Vec<&str> {
        let is_named = |name: &str| {
            let follows = |at: usize| scenario[..at].ends_with([' ', '/']);
            scenario.match_indices(name).any(|(at, _)| follows(at))
        };
        let belongs = |name: &str| {
            is_named(name)
                || Path::new(name).extension().is_some_and(|end| end == "dbf" || end == "shx")
                    && scenario.contains(".shp")
        };
        self.files
            .keys()
            .map(String::as_str)
            .filter(|name| ends.iter().any(|end| name.ends_with(end)) && belongs(name))
            .collect()
    }
}

/// What a hot start begins with: the fields of a run of two seconds.
fn earlier_run(folder: &Path) {
    let scenario = "floodsim: 1\ncrs: local\nterrain: dem.asc\nroughness: {manning: 0.03}\ninitial: [{reservoir: lake.geojson}]\n\
                    resolution: 5 m\ntime: {end: 2 s}\noutputs: {every: 1 s, write: [fields], folder: before}\n";
    std::fs::write(folder.join("s.yaml"), scenario).unwrap();
    let ended = judge::run(folder, "before");
    assert_eq!(ended.code, Some(0), "{}", ended.said);
    std::fs::remove_file(folder.join("s.yaml")).unwrap();
}

fn read_files(root: &Path, folder: &Path, files: &mut BTreeMap<String, Vec<u8>>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            read_files(root, &path, files);
        } else {
            let name = path.strip_prefix(root).unwrap().to_str().unwrap().to_owned();
            files.insert(name, std::fs::read(&path).unwrap());
        }
    }
}
