//! What does not fit the earlier run, and what of it is reported.

use super::*;

#[test]
fn what_does_not_fit_the_earlier_run_is_refused_with_its_place() {
    let scene = Scene::sound();
    scene.run("first", &["time.end=20 s"]);
    let text = SCENARIO.replace("[{reservoir: lake.geojson, level: 109 m}]", "[{fields: first/fields.nc, time: 14 s}]");
    scene.write("s.yaml", &text);
    scene.assert_check(
        &[],
        4,
        &[
            "error[no-such-frame] initial[0].time (s.yaml:5:43)",
            "3 frames go from 0 s to 20 s",
            "remedy  take the nearest one, `time: 10 s`",
        ],
    );
    scene.assert_check(&["initial[0].time=last"], 0, &["warning[bed-of-earlier-run] initial[0].fields (s.yaml:5:20)"]);
    scene.assert_check(&["initial[0].time=20 s"], 0, &["0 errors"]);
    scene.assert_check(
        &["initial[0].time=last", "boundaries[1]={side: east, type: free}"],
        0,
        &["warning[free-after-earlier-run] boundaries[1]", "remedy"],
    );
    scene.assert_check(
        &["initial[0].time=last", "rain={rate: 20 mm/h, losses: {initial: 5 mm}}"],
        0,
        &["warning[losses-after-earlier-run] rain", "leave `rain.losses.initial` out"],
    );
    scene.assert_check(
        &["initial[0].time=last", "resolution=5.3 m"],
        4,
        &[
            "error[other-lattice] initial[0].fields (s.yaml:5:20)",
            "60 by 25 cells of 5 m",
            "57 by 24 of 5.3 m",
            "remedy",
        ],
    );
    let other = ["initial[0].time=last", "crs=EPSG:25833"];
    scene.assert_check(&other, 4, &["error[different-crs] initial[0].fields (s.yaml:5:20)", "UTM zone 32N", "remedy"]);
    scene.assert_check(&["initial[0].time=last", "boundaries=[]", "numerics.motion=lagrangian"], 0, &["0 errors"]);
    scene.run(
        "moving",
        &["time.end=10 s", "initial=[{reservoir: lake.geojson, level: 109 m}]", "numerics.motion=lagrangian"],
    );
    scene.assert_check(
        &["initial=[{fields: moving/fields.nc}]"],
        0,
        &["warning[drawn-fields] initial[0].fields", "moving/run.json"],
    );
    let refused = [
        "error[method-combination] initial[0].fields (s.yaml:5:20)",
        "the variational formulation does not go on",
        "cause",
        "remedy",
    ];
    let variational = ["initial[0].time=last", "boundaries=[]", "numerics={formulation: variational}"];
    scene.assert_check(&variational, 3, &refused);
    scene.feature(
        "house.geojson",
        "Polygon",
        "[[[500050,5300050],[500070,5300050],[500070,5300070],[500050,5300070],[500050,5300050]]]",
    );
    scene.assert_check(
        &["initial[0].time=last", "structures={buildings: {polygons: house.geojson}}"],
        4,
        &["error[water-without-terrain] initial[0].fields", "16 cells without terrain", "remedy"],
    );
    scene.write("first/fields.nc", "This is a letter to the surveyor.");
    scene.assert_check(&["initial[0].time=last"], 4, &["error[not-a-fields-file] initial[0].fields", "remedy"]);
}

#[test]
fn a_levee_on_dry_ground_that_is_left_out_is_told() {
    let scene = Scene::sound();
    scene.feature("levee.geojson", "LineString", "[[500150,5300117],[500250,5300117]]");
    let levee = "terrain={layers: [{raster: dem.asc}], breaklines: [{lines: levee.geojson, mode: raise, z: 130 m}]}";
    scene.run("first", &["time.end=20 s", levee]);
    let go_on = "initial=[{fields: first/fields.nc}]";
    let reported = "warning[other-dry-ground] initial";
    scene.assert_check(&[go_on], 0, &[reported, "on 20 cells", "remedy"]);
    let with_levee = floodsim(scene.folder.path(), &["check", "s.yaml", "--set", go_on, "--set", levee]);
    assert!(with_levee.code == 0 && !with_levee.stderr.contains(reported), "{}", with_levee.stderr);
}

#[test]
fn a_building_on_dry_ground_that_is_added_or_left_out_is_told() {
    let scene = Scene::sound();
    let ring = "[[[500240,5300110],[500260,5300110],[500260,5300120],[500240,5300120],[500240,5300110]]]";
    scene.feature("house.geojson", "Polygon", ring);
    let house = "structures={buildings: {polygons: house.geojson}}";
    let go_on = "initial=[{fields: first/fields.nc}]";
    scene.run("first", &["time.end=10 s"]);
    let lost = "on 8 cells that have no terrain here and had some there";
    scene.assert_check(
        &[go_on, house],
        0,
        &["warning[other-dry-ground] initial", lost, "500242.5, 5300112.5", "remedy"],
    );
    // Without its building the earlier run has no frame for its cells.
    std::fs::remove_dir_all(scene.path("first")).unwrap();
    scene.run("first", &["time.end=10 s", house]);
    scene.assert_check(&[go_on], 4, &["error[incomplete-frame] initial", "8 cells with terrain"]);
}

#[test]
fn structures_that_the_earlier_run_had_and_this_one_has_not_are_told() {
    let scene = Scene::sound();
    scene.feature("wall.geojson", "LineString", "[[500102.5,5300000],[500102.5,5300125]]");
    scene.feature("low.geojson", "LineString", "[[500200,5300117],[500250,5300117]]");
    let wall = "structures={walls: [{lines: wall.geojson}]}";
    scene.run("first", &["time.end=10 s", wall]);
    let go_on = "initial=[{fields: first/fields.nc}]";
    let reported = "warning[other-structures] initial";
    scene.assert_check(
        &[go_on],
        0,
        &[reported, "there and not here: wall wall.geojson", "first/scenario.resolved.yaml", "remedy"],
    );
    let both = "structures={walls: [{lines: wall.geojson}, {lines: low.geojson, crest: 130 m}]}";
    scene.assert_check(&[go_on, both], 0, &[reported, "here and not there: wall low.geojson, crest 130 m"]);
    let silent = |changes: &[&str]| {
        let changes: Vec<&str> = changes.iter().flat_map(|change| ["--set", change]).collect();
        let check = floodsim(scene.folder.path(), &[&["check", "s.yaml"][..], &changes].concat());
        assert!(check.code == 0 && !check.stdout.contains("other-structures"), "{}", check.stdout);
    };
    silent(&[go_on, wall]);
    // The same name in another folder is the same wall, and another line under the same name is not.
    std::fs::create_dir(scene.path("gis")).unwrap();
    std::fs::copy(scene.path("wall.geojson"), scene.path("gis/wall.geojson")).unwrap();
    silent(&[go_on, "structures={walls: [{lines: gis/wall.geojson}]}"]);
    scene.feature("wall.geojson", "LineString", "[[500102.5,5300000],[500102.5,5300060]]");
    scene.assert_check(&[go_on, wall], 0, &[reported, "with another content of its file: wall wall.geojson"]);
    std::fs::remove_file(scene.path("first/scenario.resolved.yaml")).unwrap();
    silent(&[go_on]);
}

#[test]
fn how_the_earlier_run_ended_is_told() {
    let scene = Scene::sound();
    scene.run("first", &["time.end=10 s"]);
    let text = std::fs::read_to_string(scene.path("first/run.json")).unwrap();
    assert!(text.contains(r#""status": "done""#) && text.contains(r#""name": "volume balance""#));
    let go_on = &["initial=[{fields: first/fields.nc}]"];
    scene.assert_check(go_on, 0, &["0 errors"]);
    let sound = floodsim(scene.folder.path(), &["check", "s.yaml", "--set", go_on[0]]).stdout;
    for code in ["failed-run", "unfinished-earlier-run", "gate-of-earlier-run", "moving-bed-of-earlier-run"] {
        assert!(!sound.contains(code), "{sound}");
    }
    for (from, to, code, expected) in [
        (r#""status": "done""#, r#""status": "failed""#, 4, "error[failed-run] initial[0].fields"),
        (r#""status": "done""#, r#""status": "stopped""#, 0, "warning[unfinished-earlier-run]"),
        (r#""passed": true"#, r#""passed": false"#, 0, "warning[gate-of-earlier-run]"),
        (r#""status": "done""#, r#""moving_bed": {}, "status": "done""#, 0, "warning[moving-bed-of-earlier-run]"),
    ] {
        scene.write("first/run.json", &text.replace(from, to));
        scene.assert_check(go_on, code, &[expected, "first/run.json"]);
    }
    // Without its summary the fields are taken as they are.
    std::fs::remove_file(scene.path("first/run.json")).unwrap();
    scene.assert_check(go_on, 0, &["0 errors"]);
}
