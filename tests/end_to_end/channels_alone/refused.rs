//! What channels alone do not have, and what is wrong with their files.

use super::*;

#[test]
fn what_needs_terrain_is_refused_where_it_stands() {
    let (roughness, outputs) = ("{manning: 0.03}", "{every: 30 min, gauges_every: 10 min}");
    let end = "    downstream: {normal_depth: {slope: 0.002}}\n";
    for (changes, key, place) in [
        (vec![("floodsim: 1\n", "floodsim: 1\nrain: {rate: 5 mm/h}\n")], "rain", 2),
        (vec![("floodsim: 1\n", "floodsim: 1\ninitial: [{sea: sea.geojson, level: 0 m}]\n")], "initial", 2),
        (vec![("floodsim: 1\n", "floodsim: 1\nboundaries: [{side: east, type: open}]\n")], "boundaries", 2),
        (vec![("floodsim: 1\n", "floodsim: 1\nsources: [{at: [0, 0], discharge: 1 m3/s}]\n")], "sources", 2),
        (vec![("floodsim: 1\n", "floodsim: 1\nstructures: {walls: [{lines: w.geojson}]}\n")], "structures", 2),
        (vec![("floodsim: 1\n", "floodsim: 1\ncrs: terrain\n")], "crs", 2),
        (vec![(roughness, "{raster: n.tif}")], "roughness.raster", 2),
        (vec![(roughness, "{manning: 0.03, polygons: p.gpkg}")], "roughness.polygons", 2),
        (vec![(outputs, "{cell: 5 m}")], "outputs.cell", 12),
        (vec![(outputs, "{gauges: g.csv}")], "outputs.gauges", 12),
        (vec![(outputs, "{sections: s.geojson}")], "outputs.sections", 12),
        (vec![(outputs, "{isochrones: [5 min]}")], "outputs.isochrones", 12),
        (vec![("resolution", "numerics: {bed: shepard}\nresolution")], "numerics.bed", 10),
        (vec![(end, "    joins: {side: west}\n")], "channels[0].joins", 8),
    ] {
        let (code, said) = Scene::of(&changed(SCENARIO, &changes)).check();
        let expected = format!("error[needs-terrain] {key} (s.yaml:{place}:");
        assert!(code == 3 && said.contains(&expected), "`{expected}` is not in\n{said}");
        assert!(said.contains("needs terrain, and this scenario has channels alone\n  cause   "), "{said}");
    }
    // Without channels it is the terrain that is missing; an empty list is none.
    for changes in [[("channels:", "tracks:")], [("channels:\n  - id: river", "channels: []\nriver:\n    id: river")]] {
        let (code, said) = Scene::of(&changed(SCENARIO, &changes)).check();
        assert!(code == 3 && said.contains("the required key `terrain` is missing"), "{said}");
    }
    let (code, said) =
        Scene::of(&changed(SCENARIO, &[("resolution", "numerics: {motion: lagrangian}\nresolution")])).check();
    assert!(code == 3 && said.contains("nothing moves in channels alone"), "{said}");
}

#[test]
fn channels_alone_with_their_own_roughness_need_no_other() {
    let (rough, length) = ("roughness: {manning: 0.03}\n", "length: 2 km");
    let own = [(rough, ""), (length, "length: 2 km\n    manning: 0.03"), ("end: 3 h", "end: 1 h")];
    let scene = Scene::of(&changed(SCENARIO, &own));
    assert_eq!(scene.check(), (0, "s.yaml: 0 errors, 0 warnings\n".to_owned()));
    let (_, out) = scene.run();
    let other = Scene::of(&changed(SCENARIO, &[("end: 3 h", "end: 1 h")]));
    let tables = [out.clone(), other.run().1].map(|out| std::fs::read(out.join("tables/channels.csv")).unwrap());
    assert_eq!(tables[0], tables[1]);
    let resolved = std::fs::read_to_string(out.join("scenario.resolved.yaml")).unwrap();
    assert!(!resolved.contains("roughness"), "{resolved}");
    scene.write("s.yaml", &resolved);
    assert_eq!(scene.check().0, 0);
    // A channel without its own, or terrain beside the channels, needs one.
    let terrain = ("floodsim: 1\n", "floodsim: 1\nterrain: dem.tif\n");
    for changes in [vec![own[0]], vec![own[0], own[1], terrain]] {
        let (code, said) = Scene::of(&changed(SCENARIO, &changes)).check();
        assert!(code == 3 && said.contains("error[missing-key] roughness"), "{said}");
    }
}

#[test]
fn bad_gauges_and_lines_are_refused_where_they_stand() {
    let lines = "gauges: [{id: weir, distance: 803 m}, {id: mouth, distance: 2 km}]";
    for (changes, expected) in [
        (vec![("2 km}]", "2.1 km}]")], "error[gauge-outside] channels[0].gauges[1].distance (s.yaml:9:"),
        (vec![("mouth", "weir")], "error[duplicate-gauge] channels[0].gauges[1].id (s.yaml:9:"),
        (
            vec![("length: 2 km", "length: 2 km\n    manning: 0")],
            "error[no-roughness] channels[0].downstream.normal_depth",
        ),
        (vec![("803 m", "-3 m")], "channels[0].gauges[0].distance (s.yaml:9:"),
        (vec![(lines, "line: none.geojson")], "channels[0].line (s.yaml:9:"),
        (vec![(lines, "line: axes.geojson")], "error[no-lines] channels[0].line (s.yaml:9:"),
    ] {
        let scene = Scene::of(&changed(SCENARIO, &changes));
        scene.write("axes.geojson", &axes(&["a", "b"]));
        let (code, said) = scene.check();
        assert!(code != 0 && said.contains(expected), "`{expected}` is not in\n{said}");
    }
}

#[test]
fn a_level_below_the_bed_of_an_end_is_refused_where_it_stands() {
    let discharge = "upstream: {discharge: 40 m3/s}";
    for (end, expected) in [
        (
            "upstream: {discharge: 40 m3/s, level: 50 m}",
            "error[level-below-bed] channels[0].upstream.level (s.yaml:7:43)",
        ),
        (
            "upstream: {discharge: {series: q.csv}, level: {series: z.csv}}",
            "error[level-below-bed] channels[0].upstream.level.series (s.yaml:7:60)",
        ),
        (
            "upstream: {discharge: 40 m3/s, level: 100.05 m}",
            "warning[fast-inflow] channels[0].upstream.level (s.yaml:7:43)",
        ),
        ("upstream: {stage: 99 m}", "error[level-below-bed] channels[0].upstream.stage (s.yaml:7:23)"),
    ] {
        let scene = Scene::of(&changed(SCENARIO, &[(discharge, end)]));
        scene.write("q.csv", "time_h,q_m3_s\n0,40\n3,40\n");
        scene.write("z.csv", "time_h,level_m\n0,103\n1,99\n3,103\n");
        let (code, answer) = scene.check();
        assert!(
            code == if expected.starts_with("error") { 4 } else { 0 } && answer.contains(expected),
            "{end}: {answer}"
        );
    }
}
