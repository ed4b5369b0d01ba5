use geo::Winding;

use super::*;
use crate::geodata::spatial_ref;

fn file_of(name: &str, content: &str) -> Result<VectorFile, Problem> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    open(&path, None)
}

fn square(size: f64, properties: &str) -> String {
    format!(
        r#"{{"type":"FeatureCollection","features":[{{"type":"Feature","properties":{properties},"geometry":{{"type":"Polygon","coordinates":[[[0,0],[{size},0],[{size},{size}],[0,{size}],[0,0]]]}}}}]}}"#
    )
}

fn lambert() -> Crs {
    Crs::Projected(spatial_ref("EPSG:27572").unwrap())
}

#[test]
fn attributes_are_found_whatever_their_case_and_by_ten_letters() {
    let file = file_of(
        "a.geojson",
        &square(1000.0, r#"{"Level_M": 100.5, "text_level": "7.5", "water_leve": 3, "none": null}"#),
    )
    .unwrap();
    let feature = &file.features[0];
    assert_eq!(feature.number("level_m"), Some(100.5));
    assert_eq!(feature.number("text_level"), Some(7.5));
    assert_eq!(feature.number("water_level_m"), Some(3.0));
    assert_eq!(feature.attribute("none"), None);
    let lacking = r#"{"type": "Feature", "properties": {}, "geometry": {"type": "Point", "coordinates": [1, 2]}}"#;
    let has_all = r#"{"type": "Feature", "properties": {"level_m": 0, "id": "x", "n": 1.5, "empty": ""},
        "geometry": {"type": "Point", "coordinates": [1, 2]}}"#;
    let text = format!(r#"{{"type": "FeatureCollection", "features": [{has_all}, {lacking}]}}"#);
    let features = file_of("b.geojson", &text).unwrap().features;
    assert_eq!((features[0].number("level_m"), features[0].number("n")), (Some(0.0), Some(1.5)));
    assert_eq!(features[0].attribute("empty"), None);
    assert_eq!(features[1].attributes, []);
    assert_eq!(feature.polygons[0].exterior().0.len(), 5);
}

/// Writes a point at a height with the attributes `Höhe` and `Ort` to a file of some format.
fn write_point(path: &Path, (driver, options): (&str, Option<&[&str]>), crs: &str) {
    use gdal::vector::{Feature, LayerOptions, OGRFieldType};
    let mut dataset = gdal::DriverManager::get_driver_by_name(driver).unwrap().create_vector_only(path).unwrap();
    let srs = spatial_ref(crs).unwrap();
    let layer = LayerOptions { name: "a", srs: Some(&srs), ty: OGRwkbGeometryType::wkbPoint25D, options };
    let layer = dataset.create_layer(layer).unwrap();
    layer.create_defn_fields(&[("Höhe", OGRFieldType::OFTReal), ("Ort", OGRFieldType::OFTString)]).unwrap();
    let mut feature = Feature::new(layer.defn()).unwrap();
    feature.set_geometry(Geometry::from_wkt("POINT Z (500000 5300000 100)").unwrap()).unwrap();
    feature.set_field_double(0, 2.9).unwrap();
    feature.set_field_string(1, "Mühle").unwrap();
    feature.create(&layer).unwrap();
    drop(feature);
    dataset.close().unwrap();
}

#[test]
fn letters_of_a_shapefile_that_does_not_say_how_they_are_encoded_are_read_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.shp");
    let (crs, run) = ("EPSG:25832", Crs::Projected(spatial_ref("EPSG:25832").unwrap()));
    for (encoding, is_stated) in [("ISO-8859-1", true), ("ISO-8859-1", false), ("UTF-8", false)] {
        write_point(&path, ("ESRI Shapefile", Some(&[format!("ENCODING={encoding}").as_str()])), crs);
        if !is_stated {
            let _ = std::fs::remove_file(path.with_extension("cpg"));
            let mut table = std::fs::read(path.with_extension("dbf")).unwrap();
            table[29] = 0;
            std::fs::write(path.with_extension("dbf"), table).unwrap();
        }
        let (features, warnings) = open(&path, None).unwrap().in_run_crs(&path, &run).unwrap();
        assert_eq!(features[0].number("höhe").or(features[0].number("Höhe")), Some(2.9), "{encoding}: {features:?}");
        assert_eq!(features[0].attribute("ort"), Some(&Value::Text("Mühle".to_owned())));
        let codes: Vec<&str> = warnings.iter().map(|problem| problem.code).collect();
        let reported: &[&str] = if encoding == "UTF-8" || is_stated { &[] } else { &["assumed-encoding"] };
        assert_eq!(codes, reported, "{encoding}");
    }
}

#[test]
fn heights_count_in_the_vertical_unit_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    // NAVD88 in metres, in feet and in US survey feet.
    for (vertical, unit) in [("", 1.0), ("+5703", 1.0), ("+8228", 0.3048), ("+6360", 1200.0 / 3937.0)] {
        let path = folder.path().join(format!("a{vertical}.gpkg"));
        write_point(&path, ("GPKG", None), &format!("EPSG:26915{vertical}"));
        let height = open(&path, None).unwrap().features[0].points[0].1.unwrap();
        assert!((height - 100.0 * unit).abs() < 1e-6, "{vertical}: {height}");
    }
}

#[test]
fn outlines_run_to_the_left_and_holes_to_the_right_however_a_file_has_them() {
    let polygon = |rings: &str| {
        let text = format!(r#"{{"type": "Polygon", "coordinates": [{rings}]}}"#);
        file_of("a.geojson", &text).unwrap().features[0].polygons[0].clone()
    };
    let (left, right) = ("[[0,0],[9,0],[9,9],[0,9],[0,0]]", "[[0,0],[0,9],[9,9],[9,0],[0,0]]");
    let (hole_left, hole_right) = ("[[1,1],[2,1],[2,2],[1,2],[1,1]]", "[[1,1],[1,2],[2,2],[2,1],[1,1]]");
    let tidy = polygon(&format!("{left}, {hole_right}"));
    assert!(tidy.exterior().is_ccw() && tidy.interiors()[0].is_cw());
    for rings in [(left, hole_left), (right, hole_left), (right, hole_right)] {
        let other = polygon(&format!("{}, {}", rings.0, rings.1));
        assert!(other.exterior().is_ccw() && other.interiors()[0].is_cw(), "{rings:?}");
    }
}

#[test]
fn a_geojson_without_crs_is_taken_in_the_coordinates_of_the_run_unless_it_looks_like_degrees() {
    let path = Path::new("a.geojson");
    let (features, warnings) =
        file_of("a.geojson", &square(1000.0, "{}")).unwrap().in_run_crs(path, &Crs::Local).unwrap();
    assert!(warnings.is_empty() && features.len() == 1);
    let (features, warnings) =
        file_of("a.geojson", &square(1000.0, "{}")).unwrap().in_run_crs(path, &lambert()).unwrap();
    assert_eq!((warnings[0].code, features[0].coordinates().nth(2)), ("assumed-crs", Some(Vec2::new(1000.0, 1000.0))));
    // A flume of a few metres in local coordinates looks like degrees, and is none.
    let (_, warnings) = file_of("a.geojson", &square(10.0, "{}")).unwrap().in_run_crs(path, &Crs::Local).unwrap();
    assert!(warnings.is_empty());
}

#[test]
fn a_file_in_another_crs_is_brought_to_that_of_the_run() {
    let text = r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[6.7565,43.5122]}}]}"#;
    let (features, _) = file_of("a.geojson", text).unwrap().in_run_crs(Path::new("a"), &lambert()).unwrap();
    let mut expected = [Vec2::new(6.7565, 43.5122)];
    transform(&mut expected, &spatial_ref("EPSG:4326").unwrap(), &spatial_ref("EPSG:27572").unwrap()).unwrap();
    assert_eq!(features[0].points[0].0, expected[0]);
    assert!(expected[0].x > 900_000.0 && expected[0].y > 1_800_000.0);
}

#[test]
fn what_is_no_vector_file_is_refused_in_words() {
    assert_eq!(file_of("a.geojson", "hello").unwrap_err().code, "not-a-vector");
    assert_eq!(file_of("a.geojson", "").unwrap_err().code, "empty-file");
    assert_eq!(open(Path::new("nowhere/a.geojson"), None).unwrap_err().code, "missing-file");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.geojson");
    std::fs::write(&path, square(1.0, "{}")).unwrap();
    let problem = open(&path, Some("nosuch")).unwrap_err();
    assert!(problem.code == "no-such-layer" && problem.remedy.is_some(), "{problem}");
}

#[test]
fn empty_geometries_and_collections_are_taken_apart() {
    let text = r#"{"type":"FeatureCollection","features":[
        {"type":"Feature","properties":{},"geometry":null},
        {"type":"Feature","properties":{},"geometry":{"type":"Polygon","coordinates":[]}},
        {"type":"Feature","properties":{},"geometry":{"type":"GeometryCollection","geometries":[
            {"type":"MultiLineString","coordinates":[[[0,0],[500,0]],[[0,1],[500,1]]]},
            {"type":"MultiPoint","coordinates":[[0,0,5],[700,1,6]]}]}}]}"#;
    let file = file_of("a.geojson", text).unwrap();
    assert!(file.features[0].polygons.is_empty() && file.features[1].polygons.is_empty());
    assert_eq!((file.features[2].lines.len(), file.features[2].points[1]), (2, (Vec2::new(700.0, 1.0), Some(6.0))));
}
