//! Files that hold more than is read.

use super::*;

#[test]
fn what_a_file_holds_beside_what_is_wanted_is_not_dropped_in_silence() {
    let reported: &[&str] = &["1 of 2 features of mixed.geojson hold no line: feature 2"];
    let wall = "structures: {walls: [{lines: mixed.geojson}]}";
    assert_said(&[
        (wall, "warning[left-out] structures.walls[0].lines", reported),
        ("outputs: {sections: mixed.geojson}", "warning[left-out] outputs.sections", reported),
        ("outputs: {gauges: mixed.geojson}", "warning[left-out] outputs.gauges", &["hold no point: feature 1"]),
        ("initial: [{river: mixed.geojson, depth: 1 m}]", "warning[left-out] initial[0].river", reported),
        (
            "sources: [{points: mixed.geojson, discharge: 1 m3/s}]",
            "error[not-a-point] sources[0].points",
            &["hold no point: feature 1"],
        ),
        (
            "sources: [{line: nan.geojson, discharge: 1 m3/s}]",
            "error[not-a-place] sources[0].line",
            &["feature 1 of nan.geojson has a coordinate that is no place on Earth"],
        ),
    ]);
}

#[test]
fn rows_with_more_fields_than_columns_are_refused() {
    let series =
        "boundaries: [{line: inflow.geojson, discharge: {series: q.csv, column: q_m3_s}}, {side: all, type: closed}]";
    for (rows, refused) in [
        (
            "time_min,q_m3_s\n0,0,0,5\n10,0,5,5\n",
            Some("2 rows have more fields than the first line of q.csv, which names 2"),
        ),
        ("time_min,q_m3_s\n0,1,\n10,2,\n", None),
        ("time_min;q_m3_s\n0;1\n10;2\n", None),
        ("time_min,q_m3_s,q_m3_s\n0,1,2\n10,2,3\n", Some("q.csv has more than one column `q_m3_s`")),
    ] {
        let scene = Scene::with(series);
        scene.write("q.csv", rows);
        let check = floodsim(scene.folder.path(), &["check", "s.yaml"]);
        assert_eq!(check.code, if refused.is_some() { 4 } else { 0 }, "{rows}\n{}", check.stdout);
        assert!(check.stdout.contains(refused.unwrap_or("0 errors, 0 warnings")), "{rows}\n{}", check.stdout);
    }
    let scene = Scene::with("outputs: {gauges: gauges.csv}");
    scene.write("gauges.csv", "id,x,y\nA,1100,5,2070,5\n");
    let check = floodsim(scene.folder.path(), &["check", "s.yaml"]);
    assert!(check.code == 4 && check.stdout.contains("error[too-many-fields] outputs.gauges"), "{}", check.stdout);
    assert!(check.stdout.contains("it reads `A,1100,5,2070,5`"), "{}", check.stdout);
}
