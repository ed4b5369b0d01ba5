//! What a bad scenario gets: a located message with a remedy, exit code 3 (2 for wrong usage), and no run folder.

mod files;

use tempfile::TempDir;

use crate::floodsim;

/// A scenario without fault; its files do not exist, but no test here comes as far as opening them.
const GOOD: &str = "floodsim: 1
title: Test
terrain: {layers: [{raster: dem.tif}]}
roughness: {manning: 0.033}
initial:
  - {reservoir: reservoir.geojson, level: 100 m}
resolution: 20 m
time: {end: 4000 s}
outputs: {cell: 20 m, every: 100 s}
";

/// Asserts that both `check` and `run` refuse the file `s.yaml` of this content with exit code 3 and all these texts,
/// and that nothing else is in the folder afterwards.
#[track_caller]
fn assert_refused(content: &[u8], expected: &[&str]) {
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("s.yaml"), content).unwrap();
    let check = floodsim(folder.path(), &["check", "s.yaml"]);
    assert_eq!((check.code, check.stderr.as_str()), (3, ""), "{}", check.stdout);
    let run = floodsim(folder.path(), &["s.yaml"]);
    assert_eq!((run.code, run.stdout.as_str()), (3, ""), "{}", run.stderr);
    for text in expected {
        assert!(check.stdout.contains(text), "check does not say `{text}`, but\n{}", check.stdout);
        assert!(run.stderr.contains(text), "run does not say `{text}`, but\n{}", run.stderr);
    }
    assert!(check.stdout.len() < 5000, "the message is too long to be read:\n{}", check.stdout);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "something was left in the folder");
}

#[track_caller]
fn assert_change_refused(from: &str, to: &str, expected: &[&str]) {
    assert!(GOOD.contains(from), "`{from}` is not in the good scenario");
    assert_refused(GOOD.replace(from, to).as_bytes(), expected);
}

#[test]
fn unknown_keys_are_all_reported_with_the_nearest_known_one() {
    let text = GOOD
        .replace("manning: 0.033", "mannning: 0.033")
        .replace("resolution", "resoluton")
        .replace("cell: 20 m, every: 100 s", "cell: 20 m, evry: 100 s, gauge: g.csv");
    assert_refused(
        text.as_bytes(),
        &[
            "error[unknown-key] roughness.mannning (s.yaml:4:13)\n  unknown key `mannning`\n  remedy  did you mean `manning`?",
            "error[unknown-key] resoluton (s.yaml:7:1)\n  unknown key `resoluton`\n  remedy  did you mean `resolution`?",
            "error[unknown-key] outputs.evry (s.yaml:9:23)",
            "did you mean `every`?",
            "did you mean `gauges`?",
            "error[missing-key] roughness (s.yaml:4:12)\n  an entry here needs one of the keys manning, raster",
            "error[missing-key] resolution",
        ],
    );
}

#[test]
fn an_unknown_key_without_a_near_one_lists_the_known_ones() {
    assert_change_refused(
        "{end: 4000 s}",
        "{end: 4000 s, colour: red}",
        &["time.colour", "the keys here are end, reference"],
    );
    assert_change_refused("title: Test", "weather: {}", &["unknown key `weather`"]);
}

#[test]
fn value_errors_and_missing_files_come_in_the_same_pass() {
    let text = GOOD.replace("100 m", "100 kg").replace("4000 s", "late").replace("title", "titel");
    assert_refused(
        text.as_bytes(),
        &[
            "error[unit] initial[0].level (s.yaml:6:43)\n  `100 kg` is not a length: `kg` is no unit of it",
            "remedy  use one of the units m, mm, cm, dm, km, ft, in",
            "error[not-a-quantity] time.end (s.yaml:8:13)\n  `late` is not a time",
            "did you mean `title`?",
            "error[missing-file] terrain.layers[0].raster (s.yaml:3:29)\n  the file `dem.tif` does not exist",
            "error[missing-file] initial[0].reservoir",
        ],
    );
}

#[test]
fn wrong_units_list_the_accepted_ones() {
    assert_change_refused(
        "resolution: 20 m",
        "resolution: 100 s",
        &["resolution (s.yaml:7:13)", "`s` is no unit of it"],
    );
    assert_change_refused("4000 s", "30 m", &["`30 m` is not a time", "use one of the units s, ms, min, h, d"]);
    assert_change_refused("0.033", "0.033 m", &["`0.033 m` is not a plain number", "write the number alone"]);
}

#[test]
fn a_number_without_its_unit_is_refused_with_the_unit_to_add() {
    assert_change_refused("resolution: 20 m", "resolution: 20", &["error[missing-unit] resolution", "write `20 m`"]);
    assert_change_refused("4000 s", "4000", &["error[missing-unit] time.end", "write `4000 s`"]);
    assert_change_refused("level: 100 m", "level: 100", &["error[missing-unit] initial[0].level", "write `100 m`"]);
}

#[test]
fn values_out_of_range_say_the_range() {
    for (from, to, key) in [
        ("0.033", "-0.033", "roughness.manning (s.yaml:4:22)"),
        ("0.033", "0.6", "roughness.manning"),
        ("0.033", "33", "roughness.manning"),
        ("resolution: 20 m", "resolution: 0 m", "resolution (s.yaml:7:13)"),
        ("resolution: 20 m", "resolution: -20 m", "resolution"),
        ("4000 s", "0 s", "time.end"),
        ("4000 s", "-1 h", "time.end"),
        ("4000 s", "4000 d", "time.end"),
        ("cell: 20 m", "cell: 0", "outputs.cell"),
        ("every: 100 s", "every: 0 s", "outputs.every"),
        ("every: 100 s", "arrival: {thresholds: [0.1 m, -1 cm]}", "outputs.arrival.thresholds[1]"),
        ("title: Test", "numerics: {cfl: 0}", "numerics.cfl"),
        ("title: Test", "numerics: {cfl: 1.01}", "numerics.cfl"),
        ("title: Test", "limits: {particles: 0}", "limits.particles"),
    ] {
        assert_change_refused(from, to, &[&format!("error[range] {key}"), "is out of range", "it must be"]);
    }
}

#[test]
fn what_is_not_finite_is_no_quantity() {
    for value in [".nan", ".inf", "nan m", "inf m", "1e999 m"] {
        let expected = ["error[not-a-quantity] resolution (s.yaml:7:13)", "is not a length"];
        assert_change_refused("resolution: 20 m", &format!("resolution: {value}"), &expected);
    }
    assert_change_refused(
        "0.033",
        ".nan",
        &["error[not-a-quantity] roughness.manning", "`.nan` is not a plain number"],
    );
}

#[test]
fn wrong_types_say_what_is_expected() {
    assert_change_refused(
        "resolution: 20 m",
        "resolution: [20 m]",
        &["resolution", "a length is expected here, not a list"],
    );
    assert_change_refused("resolution: 20 m", "resolution:", &["a length is expected here, not nothing"]);
    assert_change_refused("{manning: 0.033}", "0.033", &["a section is expected here, not `0.033`"]);
    assert_change_refused("title: Test", "boundaries: {side: north}", &["a list is expected here, not a section"]);
    assert_change_refused("raster: dem.tif", "raster: {a: b}", &["the name of a file is expected here, not a section"]);
    assert_refused(b"", &["a section is expected here, not nothing"]);
    assert_refused(b"just words", &["a section is expected here, not `just words`"]);
}

#[test]
fn a_wrong_indentation_is_named_as_such() {
    assert_change_refused(
        "time: {end: 4000 s}",
        "time:\nend: 4000 s",
        &["error[wrong-type] time", "look at the indentation"],
    );
}

#[test]
fn missing_keys_come_with_an_example() {
    for (line, key, example) in [
        ("floodsim: 1\n", "floodsim", "add `floodsim: 1`"),
        ("terrain: {layers: [{raster: dem.tif}]}\n", "terrain", "add `terrain: dem.tif`"),
        ("roughness: {manning: 0.033}\n", "roughness", "add `roughness: {manning: 0.033}`"),
        ("resolution: 20 m\n", "resolution", "add `resolution: 20 m`"),
        ("time: {end: 4000 s}\n", "time", "add `time: {end: 1 h}`"),
    ] {
        assert_change_refused(line, "", &[&format!("error[missing-key] {key}"), "is missing", example]);
    }
    let without_water = GOOD.replace("initial:\n  - {reservoir: reservoir.geojson, level: 100 m}\n", "");
    assert_refused(without_water.as_bytes(), &["add `initial: [{reservoir: reservoir.geojson, level: 100 m}]`"]);
    assert_change_refused("{reservoir: reservoir.geojson, level: 100 m}", "{level: 100 m}", &["reservoir, sea, water"]);
    let rating = "time: {end: 4000 s}\nboundaries: [{side: east, rating: {level: h}}]";
    assert_change_refused("time: {end: 4000 s}", rating, &["boundaries[0].rating.table", "add `table: values.csv`"]);
    assert_change_refused(
        "raster: dem.tif",
        "points: p.txt",
        &["terrain.layers[0]", "survey points need the key `max_gap`"],
    );
}

#[test]
fn keys_that_exclude_each_other_are_refused() {
    assert_change_refused("level: 100 m}", "level: 100 m, sea: s.shp}", &["reservoir and sea exclude each other"]);
    assert_change_refused(
        "level: 100 m}",
        "level: 100 m, level_field: z}",
        &["`level` and `level_field` exclude each other"],
    );
    assert_change_refused("raster: dem.tif", "raster: dem.tif, max_gap: 1 m", &["`max_gap` does not go with `raster`"]);
}

#[test]
fn empty_lists_are_refused() {
    let empty = GOOD.replace("\n  - {reservoir: reservoir.geojson, level: 100 m}", " []");
    assert_refused(empty.as_bytes(), &["error[empty-list] initial (s.yaml:5:10)", "this list is empty"]);
    assert_change_refused("[{raster: dem.tif}]", "[]", &["error[empty-list] terrain.layers"]);
    assert_change_refused(
        "every: 100 s",
        "arrival: {thresholds: []}",
        &["error[empty-list] outputs.arrival.thresholds"],
    );
}

#[test]
fn isochrones_out_of_order_or_twice_are_refused() {
    for times in ["[1 min, 30 s, 1 h]", "[1 min, 60 s]"] {
        let isochrones = format!("isochrones: {times}");
        assert_change_refused(
            "every: 100 s",
            &isochrones,
            &["error[conflict]", "the times of the isochrones must rise"],
        );
    }
}

#[test]
fn methods_that_do_not_exist_or_do_not_go_together_are_refused() {
    let numerics = |text: &str| format!("numerics: {{{text}}}");
    assert_change_refused(
        "title: Test",
        &numerics("formulation: variational, motion: eulerian"),
        &["error[method-combination] numerics.motion (s.yaml:2:46)", "have no `motion: eulerian`"],
    );
    assert_change_refused(
        "title: Test",
        &numerics("stabilisation: artificial_viscosity"),
        &["error[method-combination] numerics.stabilisation", "have no `stabilisation: artificial_viscosity`"],
    );
    assert_change_refused(
        "title: Test",
        &numerics("motion: lagrangian, stabilisation: artificial_viscosity"),
        &[
            "error[method-combination] numerics.stabilisation (s.yaml:2:47)",
            "cause   the pairs of the balanced formulation are Riemann problems",
        ],
    );
    assert_change_refused(
        "title: Test",
        &numerics("integrator: leapfrog"),
        &[
            "error[method-combination] numerics.integrator (s.yaml:2:24)",
            "have no `integrator: leapfrog`",
            "cause",
            "remedy",
        ],
    );
    assert_change_refused(
        "title: Test",
        &numerics("seeding: equal_volume"),
        &[
            "error[method-combination] numerics.seeding (s.yaml:2:21)",
            "have no `seeding: equal_volume`",
            "motion: lagrangian",
        ],
    );
    assert_change_refused(
        "title: Test",
        &numerics("motion: eulerain"),
        &["`eulerain` is not a motion", "did you mean `eulerian`?"],
    );
    assert_change_refused(
        "title: Test",
        &numerics("stabilisation: two_shocks"),
        &["Eulerian particles have no `stabilisation: two_shocks`", "lie in the middle", "leave `stabilisation` out"],
    );
    assert_change_refused(
        "title: Test",
        &numerics("motion: lagrangian, bed_slope: steep"),
        &["Lagrangian particles have no `bed_slope: steep`", "formulation: variational"],
    );
    assert_change_refused(
        "title: Test",
        &numerics("cfl: 0.8"),
        &[
            "error[method-combination] numerics.cfl (s.yaml:2:17)",
            "unstable beyond a Courant number of 0.6",
            "cfl: 0.5",
        ],
    );
    assert_change_refused(
        "title: Test",
        &numerics("stabilisation: hllc"),
        &["`hllc` is not a stabilisation", "write `two_rarefactions`, or `two_waves` with `formulation: variational`"],
    );
    assert_change_refused("title: Test", &numerics("kernel: wendland"), &["did you mean `wendland_c2`?"]);
    assert_change_refused("title: Test", &numerics("kernel: poly6"), &["use one of cubic_spline, quadratic"]);
    assert_change_refused(
        "title: Test",
        &numerics("kernel: wendland_c2"),
        &[
            "error[method-combination] numerics.kernel (s.yaml:2:20)",
            "have no `kernel: wendland_c2`",
            "formulation: variational",
        ],
    );
}

#[test]
fn combinations_of_methods_are_all_reported_at_once_and_wrong_names_draw_no_further_ones() {
    assert_change_refused(
        "title: Test",
        "numerics: {stabilisation: artificial_viscosity, integrator: leapfrog, seeding: equal_volume, kernel: bell}",
        &["] numerics.stabilisation (", "] numerics.integrator (", "] numerics.seeding (", "] numerics.kernel ("],
    );
    let folder = TempDir::new().unwrap();
    for (name, other) in [("formulation", "variatonal"), ("motion", "lagrangain")] {
        let methods = format!("numerics: {{{name}: {other}, stabilisation: two_shocks, seeding: equal_volume}}");
        std::fs::write(folder.path().join("s.yaml"), GOOD.replace("title: Test", &methods)).unwrap();
        let check = floodsim(folder.path(), &["check", "s.yaml"]).stdout;
        assert!(check.contains("did you mean") && !check.contains("method-combination"), "{check}");
    }
    std::fs::write(folder.path().join("s.yaml"), GOOD).unwrap();
    let by_hand = floodsim(folder.path(), &["check", "s.yaml", "--set", "numerics.seeding=equal_volume"]).stdout;
    assert!(by_hand.contains("error[method-combination] numerics.seeding\n"), "{by_hand}");
}

#[test]
fn a_later_version_of_the_format_is_refused() {
    assert_change_refused("floodsim: 1", "floodsim: 2", &["error[version] floodsim (s.yaml:1:11)", "version `2`"]);
}

#[test]
fn duplicate_keys_are_found_beside_other_problems() {
    let text = format!("{}resolution: 10 m\n", GOOD.replace("0.033", "-1"));
    assert_refused(
        text.as_bytes(),
        &["error[duplicate-key] (s.yaml:10:1)\n  the key `resolution` stands twice", "error[range] roughness.manning"],
    );
}

#[test]
fn bad_overrides_are_usage_errors() {
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("s.yaml"), GOOD).unwrap();
    for (text, reason) in [
        ("resolution", "not of the form key.path=value"),
        ("initial[7].level=1 m", "`initial` has 1 entries"),
        ("time.end.late=1 s", "`time.end` is not a section"),
        ("resoluton=10 m", "did you mean `resolution`?"),
        ("numerics.clf=0.3", "did you mean `cfl`?"),
        ("time.end=[", "not valid YAML"),
    ] {
        for command in ["check", "run"] {
            let answer = floodsim(folder.path(), &[command, "s.yaml", "--set", text]);
            assert_eq!((answer.code, answer.stdout.as_str()), (2, ""), "{text}: {}", answer.stderr);
            assert!(answer.stderr.contains(reason), "{text}: {}", answer.stderr);
        }
    }
    let wrong_value = floodsim(folder.path(), &["check", "s.yaml", "--set", "resolution=5 kg"]);
    assert_eq!(wrong_value.code, 3);
    assert!(wrong_value.stdout.contains("the value comes from --set"), "{}", wrong_value.stdout);
}

#[test]
fn findings_are_the_same_as_json() {
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("s.yaml"), GOOD.replace("resolution: 20 m", "resolution: 20 kg")).unwrap();
    let answer = floodsim(folder.path(), &["check", "s.yaml", "--json"]);
    assert_eq!(answer.code, 3);
    let all: serde_json::Value = serde_json::from_str(&answer.stdout).unwrap();
    let problems = all["problems"].as_array().unwrap();
    let problem = problems.iter().find(|problem| problem["key"] == "resolution").unwrap();
    assert_eq!(problem["code"], "unit");
    assert_eq!((&problem["line"], &problem["column"]), (&7.into(), &13.into()));
    assert_eq!(all["errors"].as_u64(), Some(problems.len() as u64));
    // In the order of the lines.
    let lines: Vec<u64> = problems.iter().filter_map(|problem| problem["line"].as_u64()).collect();
    assert!(lines.len() == problems.len() && lines.is_sorted(), "{lines:?}");
}
