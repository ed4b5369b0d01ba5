//! The smallest inputs that provoke problems which no test of their subject has: one case for each code.

use tempfile::TempDir;

use crate::{assert_check, floodsim};

/// A basin with its floor at 0 m in a plateau at 20 m, from (1000, 2000) on, 200 m by 150 m, and a lake in it.
const SCENARIO: &str = "\
floodsim: 1
crs: local
terrain: {layers: [{raster: dem.asc}]}
roughness: {manning: 0.03}
initial: [{reservoir: lake.geojson, level: 5 m}]
resolution: 5 m
time: {end: 4 s}
";

/// Corners of the lake, on the plateau around the basin.
const LAKE: &str = "[[[1045,2045],[1105,2045],[1105,2105],[1045,2105],[1045,2045]]]";

/// The Moon, from which no coordinates of the Earth come.
const MOON: &str = r#"GEOGCS["Moon",DATUM["Moon",SPHEROID["Moon",1737400,0]],PRIMEM["Reference",0],UNIT["degree",0.0174532925199433]]"#;

/// A file: its name and what it holds.
type File<'a> = (&'a str, String);

/// The elevation of a column and a row, counted from the upper left in cells of 5 m.
fn basin(column: usize, row: usize) -> f64 {
    if (10..20).contains(&column) && (10..20).contains(&row) { 0.0 } else { 20.0 }
}

/// An ESRI ASCII grid of the terrain with so many cells along each cell of 5 m.
fn grid(parts: usize, value: impl Fn(usize, usize) -> f64) -> File<'static> {
    let (columns, rows, cell) = (40 * parts, 30 * parts, 5.0 / parts as f64);
    let row = |row: usize| (0..columns).map(|column| value(column, row).to_string()).collect::<Vec<_>>().join(" ");
    let values: Vec<String> = (0..rows).map(row).collect();
    let header =
        format!("ncols {columns}\nnrows {rows}\nxllcorner 1000\nyllcorner 2000\ncellsize {cell}\nNODATA_value -9999\n");
    ("dem.asc", format!("{header}{}\n", values.join("\n")))
}

/// A GeoJSON of features of a kind, each with its coordinates, all with the attribute `id: a`.
fn drawn<'a>(name: &'a str, kind: &str, coordinates: &[&str]) -> File<'a> {
    let feature = |coordinates: &&str| {
        let geometry = format!(r#"{{"type":"{kind}","coordinates":{coordinates}}}"#);
        format!(r#"{{"type":"Feature","properties":{{"id":"a"}},"geometry":{geometry}}}"#)
    };
    let features: Vec<String> = coordinates.iter().map(feature).collect();
    (name, format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, features.join(",")))
}

/// The folder of the scenario with lines in place of those with the same keys, and with further files.
fn scene(lines: &str, files: &[File]) -> TempDir {
    let folder = TempDir::new().unwrap();
    let write = |name: &str, content: &str| std::fs::write(folder.path().join(name), content).unwrap();
    let key = |line: &str| line.split(':').next().unwrap_or_default().to_owned();
    let keys: Vec<String> = lines.lines().map(key).collect();
    let kept: String =
        SCENARIO.lines().filter(|line| !keys.contains(&key(line))).map(|line| format!("{line}\n")).collect();
    write("s.yaml", &format!("{kept}{lines}\n"));
    for (name, content) in [grid(1, basin), drawn("lake.geojson", "Polygon", &[LAKE])].iter().chain(files) {
        write(name, content);
    }
    folder
}

/// Asserts that the check of each scenario says this (`error[code] key` or `warning[code] key`) with a place in the scenario, and no
/// other error. Problems of the scenario itself end with exit code 3, those of its inputs with 4.
#[track_caller]
fn assert_found(cases: &[(&str, &[File], i32, &str)]) {
    for (lines, files, code, expected) in cases {
        let folder = scene(lines, files);
        assert_check(folder.path(), *code, &[&format!("{expected} (s.yaml:")]);
        let said = floodsim(folder.path(), &["check", "s.yaml"]).stdout;
        assert_eq!(said.matches("error[").count(), usize::from(expected.starts_with("error")), "{lines}\n{said}");
    }
}

#[test]
fn the_scene_itself_is_sound() {
    let folder = scene("", &[]);
    let check = floodsim(folder.path(), &["check", "s.yaml"]);
    assert_eq!((check.code, check.stdout.as_str()), (0, "s.yaml: 0 errors, 0 warnings\n"));
}

#[test]
fn channels_that_do_not_fit_themselves_or_each_other() {
    let of = |id: &str, shape: &str, length: &str, from: f64| {
        let joint = format!("joins: {{side: west, from: {from}, to: {}}}", from + 20.0);
        format!("{{id: {id}, length: {length}, {shape}, {joint}}}")
    };
    let even = "width: 20 m, bed: 20 m";
    let channels = |list: &[String]| format!("channels: [{}]", list.join(", "));
    let [short, high] =
        [(even, "14 m"), ("width: 20 m, bed: 25 m", "100 m")].map(|(shape, length)| [of("a", shape, length, 2060.0)]);
    let overlapping = ["a", "b"].map(|id| of(id, even, "100 m", 2060.0));
    let of_one_name = [2060.0, 2100.0].map(|from| of("a", even, "100 m", from));
    let sectioned = channels(&[of("a", "sections: x.csv", "100 m", 2060.0)]);
    let behind = format!("boundaries: [{{line: inflow.geojson, discharge: 1 m3/s}}]\n{}", channels(&overlapping[..1]));
    let inflow = drawn("inflow.geojson", "LineString", &["[[1000,2062],[1000,2078]]"]);
    let table = |rows: &str| [("x.csv", format!("distance_m,elevation_m,width_m\n{rows}\n"))];
    assert_found(&[
        (&channels(&short), &[], 3, "error[channel-short] channels[0].length"),
        (&channels(&high), &[], 0, "warning[channel-step] channels[0].joins.side"),
        (&channels(&overlapping), &[], 4, "error[channels-overlap] channels[1].joins.side"),
        (&behind, &[inflow], 4, "error[overlapping-boundaries] boundaries[0]"),
        (&channels(&of_one_name), &[], 3, "error[duplicate-channel] channels[1].id"),
        (&sectioned, &table("0,20,0\n100,20,20"), 4, "error[section-closed] channels[0].sections"),
        (
            &sectioned,
            &table("0,20,20\n0,19,20\n100,20,20\n100,21,20"),
            4,
            "error[section-not-rising] channels[0].sections",
        ),
        (&sectioned, &table("0,20,20\n0,21,20\n100,20,20"), 4, "error[section-rows] channels[0].sections"),
        (&sectioned, &table("0,20,20\n50,20,20"), 4, "error[sections-short] channels[0].sections"),
    ]);
}

#[test]
fn keys_without_a_value_are_no_keys() {
    assert_found(&[
        ("rain: {raster: , unit: mm/h}", &[], 3, "error[missing-key] rain.raster"),
        ("boundaries: [{side: west, discharge: }]", &[], 3, "error[missing-key] boundaries[0]"),
        ("initial: [{reservoir: , level: 5 m}]", &[], 3, "error[missing-key] initial[0].reservoir"),
    ]);
}

#[test]
fn lengths_and_times_out_of_all_proportion() {
    assert_found(&[("time: {end: 1e-308 s}", &[], 3, "error[range] time.end")]);
    let header = "ncols 3\nnrows 3\nxllcorner 9\nyllcorner 47\ncellsize 0.00005\n";
    let degrees = ("dem.asc", format!("{header}{}", "1 1 1\n".repeat(3)));
    assert_found(&[("crs: EPSG:25832", &[degrees], 4, "error[geographic-crs] terrain.layers[0].raster")]);
    let wide = scene("outputs: {cell: 1 km}", &[]);
    assert_check(wide.path(), 3, &["error[resolution-too-coarse] outputs.cell"]);
}

#[test]
fn tables_and_series_that_cannot_be_read() {
    let inflow = |series: &str| format!("boundaries: [{{side: west, discharge: {{series: q.csv{series}}}}}]");
    let rain = |series: &str| format!("rain: {{raster_series: {series}, unit: mm/h}}");
    let binary = |name| (name, "\0\u{1}\u{2}".to_owned());
    let twice = ("q.csv", "time_s,q,q\n0,1,1\n10,1,1\n".to_owned());
    let list = ("r.csv", "time_s,file\n0,dem.asc\n2,dem.asc\n".to_owned());
    let cut = ("r.nc", format!("CDF\u{1}{}", "x".repeat(60)));
    assert_found(&[
        (&inflow(", column: q"), &[twice], 4, "error[duplicate-column] boundaries[0].discharge.series"),
        (&inflow(""), &[binary("q.csv")], 4, "error[not-a-table] boundaries[0].discharge.series"),
        (&rain("r.csv"), &[binary("r.csv")], 4, "error[not-a-list] rain.raster_series"),
        (&rain("r.nc"), &[cut], 4, "error[not-a-netcdf] rain.raster_series"),
        (&rain(r#"r.csv, start: "2026-06-01 06:00:00""#), &[list], 4, "error[start-without-date] rain.raster_series"),
    ]);
}

#[test]
fn gauges_sections_and_sources_that_are_none_or_twice() {
    let short = "[[1075,2070],[1075,2076]]";
    let sections = "outputs: {sections: lines.geojson}";
    let two = drawn("lines.geojson", "LineString", &["[[1020,2050],[1020,2100]]", "[[1030,2050],[1030,2100]]"]);
    let one = || drawn("lines.geojson", "LineString", &[short]);
    assert_found(&[
        (sections, &[two], 4, "error[duplicate-section] outputs.sections"),
        (sections, &[one()], 0, "warning[section-short] outputs.sections"),
        ("outputs: {gauges: g.csv}", &[("g.csv", "id,x,y\n".to_owned())], 4, "error[no-gauges] outputs.gauges"),
        ("sources: [{points: lines.geojson, discharge: 1 m3/s}]", &[one()], 4, "error[no-points] sources[0].points"),
    ]);
}

#[test]
fn files_and_systems_that_cannot_be_taken() {
    let warped = "crs: EPSG:25832\nterrain: {layers: [{raster: dem.asc}], reproject: true}";
    let lake = "initial: [{reservoir: lake.csv, level: 5 m}]";
    let well_known = |geometry: &str| ("lake.csv", format!("id,WKT\n1,\"{geometry}\"\n"));
    let circle = "CURVEPOLYGON(CIRCULARSTRING(1045 2075,1105 2075,1045 2075))";
    let triangle = "POLYGON((1045 2045,1105 2045,1105 2105,1045 2045))";
    let touching = "[[[1045,2045],[1075,2060],[1105,2045],[1105,2105],[1075,2060],[1045,2105],[1045,2045]]]";
    let moon = |name| (name, MOON.to_owned());
    assert_found(&[
        (
            "terrain: {layers: [{raster: \"${FLOODSIM_NO_SUCH_FOLDER}/dem.asc\"}]}",
            &[],
            3,
            "error[unset-variable] terrain.layers[0].raster",
        ),
        (lake, &[well_known(circle)], 4, "error[unsupported-geometry] initial[0].reservoir"),
        (
            &format!("{warped}\n{lake}"),
            &[well_known(triangle), moon("lake.prj")],
            4,
            "error[no-transformation] initial[0].reservoir",
        ),
        (warped, &[moon("dem.prj")], 4, "error[warp-failed] terrain.layers[0].raster"),
        ("", &[drawn("lake.geojson", "Polygon", &[touching])], 0, "warning[untidy-polygon] initial[0].reservoir"),
    ]);
}

#[test]
fn terrain_and_structures_that_differ_on_the_lattice() {
    let gap = "[[[1150,2050],[1150,2072.5]],[[1150,2077.5],[1150,2100]]]";
    let stepped = grid(1, |column, row| if column < 3 && row < 8 { -9999.0 } else { basin(column, row) });
    // A wall of 2 m, 10 m high, through cells of 5 m.
    let walled = grid(5, |column, row| if (150..152).contains(&column) { 30.0 } else { basin(column / 5, row / 5) });
    let held = |column: usize, row: usize| if row < 15 || row % 2 == 1 { 8.0 } else { basin(column, row) };
    let held = grid(1, |column, row| if basin(column, row) > 0.0 { 20.0 } else { held(column, row) });
    let shape = "shape: {bottom_width: 30 m, side_slope: 0, invert: 2 m}, growth: {law: linear, duration: 2 s}";
    let dam = || drawn("lines.geojson", "LineString", &["[[1077.5,2041],[1077.5,2109]]"]);
    assert_found(&[
        (
            "structures: {walls: [{lines: lines.geojson}]}\nnumerics: {formulation: variational}",
            &[drawn("lines.geojson", "MultiLineString", &[gap])],
            0,
            "warning[gap-on-lattice] structures.walls[0].lines",
        ),
        ("boundaries: [{side: west, stage: 21 m}]", &[stepped], 0, "warning[side-in-part] boundaries[0]"),
        ("", &[walled], 0, "warning[steps-in-cells] resolution"),
        (
            &format!("breach: {{dam: lines.geojson, crest: 10 m, trigger: {{at: 0 s}}, {shape}}}"),
            &[dam(), held],
            0,
            "warning[terrain-in-breach] breach.shape.invert",
        ),
    ]);
}

#[test]
fn a_polygon_that_ends_within_its_water_misses_its_volume() {
    let inside = "[[[1055,2055],[1080,2055],[1080,2080],[1055,2080],[1055,2055]]]";
    let folder = scene("", &[drawn("lake.geojson", "Polygon", &[inside])]);
    let run = floodsim(folder.path(), &["run", "s.yaml", "--out", "out", "--quiet"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("warning[seeded-volume] initial[0].reservoir"), "{}", run.stderr);
    assert!(run.stderr.contains("draw the polygon up to the shore"), "{}", run.stderr);
}
