//! Variables and layers in the names of files.

use super::files::{expand, split_layer};

#[test]
fn variables_in_paths_are_replaced_and_missed() {
    let set = |name: &str| (name == "DATA").then(|| "/data".to_owned());
    assert_eq!(expand("${DATA}/dem.tif", set), Ok("/data/dem.tif".to_owned()));
    assert_eq!(expand("a/${DATA}/b${DATA}", set), Ok("a//data/b/data".to_owned()));
    assert_eq!(expand("plain.tif", set), Ok("plain.tif".to_owned()));
    assert_eq!(expand("${NONE}/dem.tif", set), Err("NONE".to_owned()));
}

#[test]
fn a_layer_follows_the_extension() {
    for (text, expected) in [
        ("a.gpkg:lake", ("a.gpkg", Some("lake"))),
        ("gis/a b.gpkg:lake one", ("gis/a b.gpkg", Some("lake one"))),
        ("a.geojson", ("a.geojson", None)),
        ("a:b/c.shp", ("a:b/c.shp", None)),
        ("odd:name", ("odd:name", None)),
        ("a.gpkg:", ("a.gpkg:", None)),
    ] {
        assert_eq!(split_layer(text), expected, "{text}");
    }
}
