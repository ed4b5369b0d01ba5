//! Files that are read without a fault and mean something else than they seem to: which layer, which column, which band, which datum;
//! maps that are not true to length, and terrain that does not hang together.

use std::path::PathBuf;

use gdal::DriverManager;
use gdal::raster::{Buffer, ColorInterpretation};
use gdal::spatial_ref::SpatialRef;
use gdal::vector::{Geometry, LayerAccess, LayerOptions, OGRwkbGeometryType};
use tempfile::TempDir;

use crate::{changed, floodsim};

/// Columns and rows of the terrain, its cell (m) and its north-western corner in EPSG:25832.
const COLUMNS: usize = 40;
const ROWS: usize = 30;
const CELL: f64 = 5.0;
const WEST: f64 = 690_000.0;
const NORTH: f64 = 5_300_000.0;

const SCENARIO: &str = "\
floodsim: 1
title: A pond on a plain
terrain: {layers: [{raster: dem.tif}]}
roughness: {manning: 0.03}
initial: [{water: pond.gpkg, level: 5 m}]
resolution: 5 m
time: {end: 4 s}
";

/// A plain at 20 m with a basin of 50 m by 50 m, floor at 0 m; column and row from the upper left.
fn elevation(column: usize, row: usize) -> f64 {
    if (10..20).contains(&column) && (10..20).contains(&row) { 0.0 } else { 20.0 }
}

/// A rectangle around the basin, moved to the east by so much (m).
fn around_the_basin(east: f64) -> String {
    let (west, east) = (WEST + 45.0 + east, WEST + 105.0 + east);
    let (south, north) = (NORTH - 105.0, NORTH - 45.0);
    format!("POLYGON(({west} {south},{east} {south},{east} {north},{west} {north},{west} {south}))")
}

struct Scene {
    folder: TempDir,
}

impl Scene {
    fn sound() -> Scene {
        let scene = Scene { folder: TempDir::new().unwrap() };
        scene.raster("dem.tif", "EPSG:25832", (0..COLUMNS, WEST), elevation);
        scene.layers("pond.gpkg", &[("pond", &around_the_basin(0.0))]);
        scene
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: &str) {
        std::fs::write(self.path(name), content).unwrap();
    }

    /// Writes a GeoTIFF of some columns of the terrain, the first of them at an easting.
    fn raster(
        &self,
        name: &str,
        crs: &str,
        (columns, west): (std::ops::Range<usize>, f64),
        value: impl Fn(usize, usize) -> f64,
    ) {
        let driver = DriverManager::get_driver_by_name("GTiff").unwrap();
        let mut dataset = driver.create_with_band_type::<f64, _>(self.path(name), columns.len(), ROWS, 1).unwrap();
        dataset.set_geo_transform(&[west, CELL, 0.0, NORTH, 0.0, -CELL]).unwrap();
        dataset.set_spatial_ref(&SpatialRef::from_definition(crs).unwrap()).unwrap();
        let value = &value;
        let values = (0..ROWS).flat_map(|row| columns.clone().map(move |column| value(column, row))).collect();
        let mut band = dataset.rasterband(1).unwrap();
        band.set_no_data_value(Some(-9999.0)).unwrap();
        band.write((0, 0), (columns.len(), ROWS), &mut Buffer::new((columns.len(), ROWS), values)).unwrap();
        dataset.close().unwrap();
    }

    /// Writes a GeoPackage of layers with one polygon each, or none.
    fn layers(&self, name: &str, layers: &[(&str, &str)]) {
        let driver = DriverManager::get_driver_by_name("GPKG").unwrap();
        let mut dataset = driver.create_vector_only(self.path(name)).unwrap();
        for (layer, polygon) in layers {
            let srs = SpatialRef::from_epsg(25832).unwrap();
            let options =
                LayerOptions { name: layer, srs: Some(&srs), ty: OGRwkbGeometryType::wkbPolygon, options: None };
            let mut layer = dataset.create_layer(options).unwrap();
            if !polygon.is_empty() {
                layer.create_feature(Geometry::from_wkt(polygon).unwrap()).unwrap();
            }
        }
        dataset.close().unwrap();
    }

    /// Writes the terrain as an ESRI ASCII grid, `dem.asc`, with so many columns by its header.
    fn grid(&self, columns: usize) {
        let rows: Vec<String> =
            (0..ROWS).map(|r| (0..COLUMNS).map(|c| format!("{} ", elevation(c, r))).collect()).collect();
        let south = NORTH - ROWS as f64 * CELL;
        let header = format!("ncols {columns}\nnrows {ROWS}\nxllcorner {WEST}\nyllcorner {south}\ncellsize {CELL}\n");
        self.write("dem.asc", &format!("{header}{}", rows.join("\n")));
    }

    /// Writes `pond.geojson`, the outline around the basin with some attributes.
    fn pond(&self, attributes: &str) {
        let (west, east, south, north) = (WEST + 45.0, WEST + 105.0, NORTH - 105.0, NORTH - 45.0);
        let ring = format!("[[[{west},{south}],[{east},{south}],[{east},{north}],[{west},{north}],[{west},{south}]]]");
        let crs = r#""crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::25832"}}"#;
        let geometry = format!(r#"{{"type":"Polygon","coordinates":{ring}}}"#);
        let feature = format!(r#"{{"type":"Feature","properties":{{{attributes}}},"geometry":{geometry}}}"#);
        self.write("pond.geojson", &format!(r#"{{"type":"FeatureCollection",{crs},"features":[{feature}]}}"#));
    }

    /// What `check` says of the scenario with texts replaced: its exit code and its words.
    fn check(&self, changes: &[(&str, &str)]) -> (i32, String) {
        self.write("s.yaml", &changed(SCENARIO, changes));
        let answer = floodsim(self.folder.path(), &["check", "s.yaml"]);
        (answer.code, answer.stdout)
    }

    /// Asserts an exit code of `check` and all these texts.
    #[track_caller]
    fn assert_said(&self, changes: &[(&str, &str)], code: i32, expected: &[&str]) {
        let (found, said) = self.check(changes);
        assert_eq!(found, code, "{said}");
        for text in expected {
            assert!(said.contains(text), "`{text}` is not in\n{said}");
        }
    }

    /// Asserts that `check` has nothing to say.
    #[track_caller]
    fn assert_silent(&self, changes: &[(&str, &str)]) {
        self.assert_said(changes, 0, &["0 errors, 0 warnings"]);
    }
}

#[test]
fn of_several_layers_none_is_taken_by_its_place() {
    let scene = Scene::sound();
    scene.assert_silent(&[]);
    scene.layers("pond.gpkg", &[("old", &around_the_basin(40.0)), ("pond", &around_the_basin(0.0))]);
    scene.assert_said(&[], 4, &["error[several-layers] initial[0].water", "it has old, pond", "`pond.gpkg:old`"]);
    scene.assert_silent(&[("pond.gpkg", "pond.gpkg:pond")]);
    // One without features is none to choose.
    scene.layers("pond.gpkg", &[("draft", ""), ("pond", &around_the_basin(0.0))]);
    scene.assert_silent(&[]);
}

#[test]
fn a_map_that_is_not_true_to_length_is_refused() {
    let scene = Scene::sound();
    scene.raster("dem.tif", "EPSG:3857", (0..COLUMNS, 1_280_000.0), elevation);
    let (code, said) = scene.check(&[("pond.gpkg", "pond.gpkg")]);
    assert_eq!(code, 4, "{said}");
    // The scene lies at 42.9 degrees north in it.
    for text in ["error[distorted-crs] terrain.layers[0].raster", "1 m on the ground is 1.36", "`crs: EPSG:32632`"] {
        assert!(said.contains(text), "`{text}` is not in\n{said}");
    }
    // The grid of Europe is some 1 % off here at most.
    scene.raster("dem.tif", "EPSG:3035", (0..COLUMNS, 4_400_000.0), elevation);
    assert!(!scene.check(&[]).1.contains("error[distorted-crs]"));
}

#[test]
fn polygons_in_another_reference_system_hold_the_same_water() {
    let scene = Scene::sound();
    let volume = |water: &str| {
        scene.write("s.yaml", &changed(SCENARIO, &[("pond.gpkg", water)]));
        let answer = floodsim(scene.folder.path(), &["run", "s.yaml", "--out", "out", "--overwrite", "--quiet"]);
        assert_eq!(answer.code, 0, "{}", answer.stderr);
        let record = std::fs::read_to_string(scene.path("out/run.json")).unwrap();
        serde_json::from_str::<serde_json::Value>(&record).unwrap()["volume_m3"]["initial"].as_f64().unwrap()
    };
    let own = volume("pond.gpkg");
    assert!((own / 12_500.0 - 1.0).abs() < 1e-9, "{own}");
    let corners = [(45.0, 105.0), (105.0, 105.0), (105.0, 45.0), (45.0, 45.0), (45.0, 105.0)];
    let run = SpatialRef::from_epsg(25832).unwrap();
    // Degrees, as GeoJSON without a `crs` has them, and the zone beside.
    for (epsg, crs) in [(4326, None), (25833, Some("urn:ogc:def:crs:EPSG::25833"))] {
        let mut other = SpatialRef::from_epsg(epsg).unwrap();
        other.set_axis_mapping_strategy(gdal::spatial_ref::AxisMappingStrategy::TraditionalGisOrder);
        let bring = gdal::spatial_ref::CoordTransform::new(&run, &other).unwrap();
        let mut x = corners.map(|(east, _)| WEST + east);
        let mut y = corners.map(|(_, south)| NORTH - south);
        bring.transform_coords(&mut x, &mut y, &mut []).unwrap();
        let ring: Vec<String> = x.iter().zip(y).map(|(x, y)| format!("[{x},{y}]")).collect();
        let name =
            crs.map_or(String::new(), |crs| format!(r#""crs":{{"type":"name","properties":{{"name":"{crs}"}}}},"#));
        let geometry = format!(r#"{{"type":"Polygon","coordinates":[[{}]]}}"#, ring.join(","));
        let feature = format!(r#"{{"type":"Feature","properties":{{}},"geometry":{geometry}}}"#);
        scene.write("pond.geojson", &format!(r#"{{"type":"FeatureCollection",{name}"features":[{feature}]}}"#));
        let brought = volume("pond.geojson");
        assert!((brought / own - 1.0).abs() < 1e-9, "{epsg}: {brought}, {own}");
    }
}

#[test]
fn tiles_that_do_not_meet_are_told() {
    let scene = Scene::sound();
    scene.raster("west.tif", "EPSG:25832", (0..25, WEST), elevation);
    scene.raster("east.tif", "EPSG:25832", (26..COLUMNS, WEST + 26.0 * CELL), elevation);
    let tiles = ("{raster: dem.tif}", "{raster: west.tif}, {raster: east.tif}");
    let said = ["[seam-without-data] terrain.layers[1].raster", "30 cells between parts of the terrain"];
    scene.assert_said(&[tiles], 0, &said);
    scene.assert_said(&[tiles, ("tif}]}", "tif}], gaps: error}")], 4, &said);
    scene.assert_silent(&[tiles, ("tif}]}", "tif}], gaps: wall}")]);
    // The same in one raster, and a gap that the terrain beside it leads around.
    scene.raster("dem.tif", "EPSG:25832", (0..COLUMNS, WEST), |c, r| if c == 25 { -9999.0 } else { elevation(c, r) });
    scene.assert_said(&[], 0, &["warning[seam-without-data] terrain.layers[0].raster"]);
    let in_part = |c, r| if c == 25 && r > 3 { -9999.0 } else { elevation(c, r) };
    scene.raster("dem.tif", "EPSG:25832", (0..COLUMNS, WEST), in_part);
    scene.assert_silent(&[]);
}

#[test]
fn where_an_alpha_band_is_clear_there_is_no_data() {
    let scene = Scene::sound();
    let driver = DriverManager::get_driver_by_name("GTiff").unwrap();
    let write = |alpha: fn(usize) -> f32| {
        let mut dataset = driver.create_with_band_type::<f32, _>(scene.path("dem.tif"), COLUMNS, ROWS, 2).unwrap();
        dataset.set_geo_transform(&[WEST, CELL, 0.0, NORTH, 0.0, -CELL]).unwrap();
        dataset.set_spatial_ref(&SpatialRef::from_epsg(25832).unwrap()).unwrap();
        let heights = (0..COLUMNS * ROWS).map(|i| elevation(i % COLUMNS, i / COLUMNS) as f32).collect();
        let clear = (0..COLUMNS * ROWS).map(|i| alpha(i % COLUMNS)).collect();
        for (band, values) in [(1, heights), (2, clear)] {
            let mut band = dataset.rasterband(band).unwrap();
            band.write((0, 0), (COLUMNS, ROWS), &mut Buffer::new((COLUMNS, ROWS), values)).unwrap();
        }
        dataset.rasterband(2).unwrap().set_color_interpretation(ColorInterpretation::AlphaBand).unwrap();
        dataset.close().unwrap();
    };
    write(|_| 255.0);
    scene.assert_silent(&[]);
    // The basin lies where it is clear.
    write(|column| if column < 25 { 0.0 } else { 255.0 });
    scene.assert_said(&[], 4, &["error[", "initial[0].water"]);
}

#[test]
fn a_grid_with_more_values_than_its_header_says_is_refused() {
    let scene = Scene::sound();
    let asc = [("dem.tif", "dem.asc"), ("title", "crs: EPSG:25832\ntitle")];
    scene.grid(COLUMNS);
    scene.assert_said(&asc, 0, &["0 errors"]);
    scene.grid(COLUMNS - 1);
    scene.assert_said(&asc, 4, &["error[too-many-values]", "1200 values, more than the 39 by 30 of its header"]);
}

#[test]
fn layers_of_two_vertical_datums_are_told_unless_one_has_an_offset() {
    let scene = Scene::sound();
    scene.raster("west.tif", "EPSG:25832+5783", (0..25, WEST), elevation);
    scene.raster("east.tif", "EPSG:25832+5709", (25..COLUMNS, WEST + 25.0 * CELL), elevation);
    let tiles = ("{raster: dem.tif}", "{raster: west.tif}, {raster: east.tif}");
    scene.assert_said(&[tiles], 0, &["warning[different-vertical-datum] terrain.layers[1].raster", "offset"]);
    scene.assert_silent(&[tiles, ("east.tif}", "east.tif, offset: -0.01 m}")]);
}

#[test]
fn codes_for_missing_values_among_survey_points_are_told() {
    let scene = Scene::sound();
    let points: String = (0..COLUMNS * ROWS)
        .map(|i| {
            let (column, row) = (i % COLUMNS, i / COLUMNS);
            let z = if (column, row) == (30, 20) { -9999.0 } else { elevation(column, row) };
            format!("{} {} {z}\n", WEST + CELL * (column as f64 + 0.5), NORTH - CELL * (row as f64 + 0.5))
        })
        .collect();
    scene.write("points.xyz", &points);
    let survey = [("{raster: dem.tif}", "{points: points.xyz, max_gap: 10 m}"), ("title", "crs: EPSG:25832\ntitle")];
    scene.assert_said(&survey, 0, &["warning[doubtful-elevation]", "1 elevations outside", "690152.5, 5299897.5"]);
}

#[test]
fn a_level_written_as_text_is_shown() {
    let scene = Scene::sound();
    let own = [("pond.gpkg, level: 5 m", "pond.geojson")];
    scene.pond(r#""level": "5.0""#);
    scene.assert_silent(&own);
    for text in ["5,0", "5 m"] {
        scene.pond(&format!(r#""level": {text:?}"#));
        scene.assert_said(&own, 4, &["error[no-level]", &format!("level (the text `{text}`, which is no number)")]);
    }
}

#[test]
fn the_vertical_unit_of_a_reference_system_is_not_passed_over() {
    let scene = Scene::sound();
    scene.grid(COLUMNS);
    let feet = SpatialRef::from_definition("EPSG:25832+6360").unwrap();
    scene.write("dem.prj", &feet.to_wkt().unwrap());
    let refused = ["error[unit-of-elevation] terrain.layers[0].raster", "say `unit: us_ft`"];
    scene.assert_said(&[("dem.tif", "dem.asc")], 4, &refused);
    scene.assert_silent(&[("dem.tif", "dem.asc, unit: us_ft")]);
}

#[test]
fn an_attribute_in_feet_is_not_read_as_metres() {
    let scene = Scene::sound();
    scene.pond(r#""level_ft": 5.0, "level": 5.0, "level_m": 5.0"#);
    let by = |field: &str| format!("pond.geojson, level_field: {field}");
    let in_feet = ("dem.tif", "dem.tif, unit: ft");
    let refused = ["error[unit-of-attribute] initial[0].water", "`level_ft` of pond.geojson"];
    scene.assert_said(&[("pond.gpkg, level: 5 m", &by("level_ft"))], 4, &refused);
    scene.assert_said(&[("pond.gpkg, level: 5 m", &by("LEVEL_FT"))], 4, &["error[unit-of-attribute]"]);
    scene.assert_silent(&[("pond.gpkg, level: 5 m", &by("level"))]);
    let asked = ["warning[unit-of-attribute] initial[0].water", "units of 0.3048 m", "`level_m` would say so"];
    scene.assert_said(&[("pond.gpkg, level: 5 m", &by("level")), in_feet], 0, &asked);
    scene.assert_silent(&[("pond.gpkg, level: 5 m", &by("level_m")), in_feet]);
    // An attribute that is not used is not looked at.
    scene.assert_silent(&[("pond.gpkg, level: 5 m", "pond.geojson"), in_feet]);
}

#[test]
fn the_column_that_the_unit_belongs_to_is_not_passed_over() {
    let scene = Scene::sound();
    let source =
        |keys: &str| format!("sources: [{{at: [690075, 5299925], discharge: {{series: q.csv{keys}}}}}]\nresolution");
    scene.write("q.csv", "time_min,level_m,q_m3_s\n0,431,1\n1,432,5\n");
    let expected = ["error[which-column] sources[0].discharge.series", "`level_m` or `q_m3_s`", "`column`"];
    scene.assert_said(&[("resolution", &source(", unit: m3/s"))], 4, &expected);
    scene.write("q.csv", "time_min,level_m,q_m3_s\n0,431,1\n1,432,5\n,,\n");
    scene.assert_silent(&[("resolution", &source(", column: q_m3_s"))]);
    scene.write("q.csv", "time_min,q\n0,1\n1,5\n");
    scene.assert_silent(&[("resolution", &source(", unit: m3/s"))]);
    scene.write("q.csv", "time_h,q_m3_s\n2026-06-01 00:00,1\n2026-06-01 02:00,5\n");
    scene.assert_said(
        &[("resolution", &source(""))],
        4,
        &["error[unit-beside-dates]", "name of their column has a unit: `time_h`"],
    );
}
