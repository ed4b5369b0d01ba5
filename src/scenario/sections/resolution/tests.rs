//! A length or levels: what is read, what is refused and where, and what `--set` makes of either form.

use std::path::Path;

use super::*;
use crate::error::Error;
use crate::scenario::model::VectorSource;
use crate::scenario::sections::ScenarioFile;
use crate::scenario::{Loaded, resolve};

const REST: &str = "floodsim: 1\nterrain: dem.tif\nroughness: {manning: 0.03}\n\
    initial: [{reservoir: lake.geojson, level: 100 m}]\ntime: {end: 1 h}\n";

fn load(resolution: &str, overrides: &[&str]) -> Result<Loaded, Error> {
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    resolve(&format!("{REST}resolution: {resolution}\n"), Path::new("/somewhere/scenario.yaml"), &overrides)
}

fn scenario(resolution: &str, overrides: &[&str]) -> Scenario {
    load(resolution, overrides).unwrap_or_else(|error| panic!("{resolution} {overrides:?}: {error}")).scenario
}

fn problems(resolution: &str, overrides: &[&str]) -> Vec<Problem> {
    let Err(Error::Problems(found)) = load(resolution, overrides) else {
        panic!("not refused: {resolution} {overrides:?}")
    };
    found.into_iter().filter(|problem| problem.kind == ProblemKind::Scenario).collect()
}

/// The finest and the coarsest spacing (m); none where there are no levels.
fn spacings(scenario: &Scenario) -> (f64, Option<f64>) {
    (scenario.resolution.value, scenario.levels.as_ref().map(|levels| levels.coarsest.value))
}

#[test]
fn a_length_alone_has_no_levels() {
    let scenario = scenario("20 m", &[]);
    assert_eq!((spacings(&scenario), scenario.resolution.key.as_str()), ((20.0, None), "resolution"));
    assert!(scenario.to_yaml().contains("\nresolution: 20 m\n"), "{}", scenario.to_yaml());
}

#[test]
fn levels_are_read_with_their_defaults() {
    let text = "{finest: 5 m, refine: [{polygons: 'gis.gpkg:town'}, {lines: levee.shp}, {lines: dike.shp, to: 12 m}, \
                {lines: ditch.shp, to: 0.02 km, within: 0}, {polygons: fields.shp, to: 40 m}]}";
    let scenario = scenario(text, &[]);
    assert_eq!((spacings(&scenario), scenario.resolution.key.as_str()), ((5.0, Some(40.0)), "resolution.finest"));
    let levels = scenario.levels.as_ref().unwrap();
    let file = |name: &str| VectorSource { path: Path::new("/somewhere").join(name), layer: None };
    let lines = |name, within| RefineShape::Lines { source: file(name), within };
    let town = VectorSource { layer: Some("town".to_owned()), ..file("gis.gpkg") };
    let expected = [
        (5.0, RefineShape::Polygons(town)),
        (5.0, lines("levee.shp", 20.0)),
        (12.0, lines("dike.shp", 48.0)),
        (20.0, lines("ditch.shp", 0.0)),
        (40.0, RefineShape::Polygons(file("fields.shp"))),
    ];
    let found = levels.refine.iter().map(|place| (place.value.to, place.value.shape.clone()));
    assert_eq!(found.collect::<Vec<_>>(), expected);
    let keys: Vec<&str> = levels.refine.iter().map(|place| place.key.as_str()).collect();
    assert_eq!((keys[0], keys[1]), ("resolution.refine[0].polygons", "resolution.refine[1].lines"));
    assert!(levels.refine.iter().all(|place| place.place.is_some()));
    // Maps are of the finest cells, and what is refined comes in the order of the file.
    assert!((scenario.outputs.cell - 5.0).abs() < 1e-12);
    let of_places: Vec<usize> = levels.refine.iter().map(|place| levels.level_of(5.0, place.value.to)).collect();
    assert_eq!((levels.count(5.0), of_places), (4, vec![0, 0, 1, 2, 3]));
}

#[test]
fn the_coarsest_is_the_finest_times_a_power_of_two_to_the_last_bit() {
    // 35 cm and 1 ft are no round numbers in binary, and 10 ft is 3.048 m.
    for (finest, in_metres) in [("5 m", 5.0), ("35 cm", 0.35), ("1 ft", 0.3048), ("0.333333333 m", 0.333_333_333)] {
        for power in 0..7 {
            let ratio = f64::from(1 << power);
            let coarsest = format!("{} m", readable(in_metres * ratio));
            let scenario = scenario(&format!("{{finest: {finest}, coarsest: {coarsest}}}"), &[]);
            let exact = scenario.resolution.value * ratio;
            assert_eq!(spacings(&scenario).1.map(f64::to_bits), Some(exact.to_bits()), "{finest}, {coarsest}");
            let levels = scenario.levels.unwrap();
            assert_eq!(levels.count(scenario.resolution.value), power + 1, "{finest}, {coarsest}");
            for level in 0..=power {
                let spacing = in_metres * f64::from(1 << level);
                let of = |to: f64| levels.level_of(scenario.resolution.value, to);
                assert_eq!([of(spacing), of(1.9 * spacing)], [level; 2], "{finest}, {coarsest}");
                assert_eq!(of(0.99 * spacing), level.saturating_sub(1), "{finest}, {coarsest}");
            }
        }
    }
}

#[test]
fn a_coarsest_that_is_no_level_is_refused_and_each_remedy_is_one() {
    for (finest, coarsest, expected) in [
        ("5 m", "50 m", &["40 m", "80 m"][..]),
        ("5 m", "41 m", &["40 m", "80 m"]),
        ("5 m", "15 m", &["10 m", "20 m"]),
        ("5 m", "4 m", &["5 m"]),
        ("5 m", "640 m", &["320 m"]),
        ("0.333333333 m", "1 m", &["0.666667 m", "1.33333 m"]),
        ("35 cm", "3 m", &["2.8 m", "5.6 m"]),
    ] {
        let found = problems(&format!("{{finest: {finest}, coarsest: {coarsest}}}"), &[]);
        assert_eq!(found.len(), 1, "{found:?}");
        let problem = &found[0];
        assert_eq!((problem.code, problem.key.as_str()), ("levels-not-nested", "resolution.coarsest"), "{problem}");
        assert!(problem.cause.is_some() && problem.place.is_some(), "{problem}");
        let remedy = expected.iter().map(|length| format!("`coarsest: {length}`")).collect::<Vec<_>>().join(" or ");
        assert_eq!(problem.remedy, Some(format!("write {remedy}")));
        for length in expected {
            assert!(load(&format!("{{finest: {finest}, coarsest: {length}}}"), &[]).is_ok(), "{finest}, {length}");
        }
    }
}

#[test]
fn what_is_wrong_is_refused_where_it_stands() {
    let refine = |entry: &str| format!("{{finest: 5 m, refine: [{entry}]}}");
    for (text, code, key) in [
        ("{coarsest: 40 m}".to_owned(), "missing-key", "resolution.finest"),
        ("{finest: 5 m, coarse: 40 m}".to_owned(), "unknown-key", "resolution.coarse"),
        ("{finest: 5}".to_owned(), "missing-unit", "resolution.finest"),
        ("{finest: 0 m}".to_owned(), "range", "resolution.finest"),
        ("{finest: 5 m, coarsest: 0 m}".to_owned(), "range", "resolution.coarsest"),
        ("{finest: 5 m, coarsest: wide}".to_owned(), "not-a-quantity", "resolution.coarsest"),
        ("{finest: 5 m, refine: town.shp}".to_owned(), "wrong-type", "resolution.refine"),
        ("[5 m, 10 m]".to_owned(), "wrong-type", "resolution"),
        ("".to_owned(), "wrong-type", "resolution"),
        (refine("{to: 5 m}"), "missing-key", "resolution.refine[0]"),
        (refine("{polygons: , to: 5 m}"), "missing-key", "resolution.refine[0].polygons"),
        (refine("{polygons: a.shp, lines: b.shp}"), "conflict", "resolution.refine[0]"),
        (refine("{polygons: a.shp, within: 50 m}"), "conflict", "resolution.refine[0].within"),
        (refine("{lines: a.shp, within: -1 m}"), "range", "resolution.refine[0].within"),
        (refine("{lines: a.shp, width: 3 m}"), "unknown-key", "resolution.refine[0].width"),
        (refine("{polygons: a.shp, to: 0 m}"), "range", "resolution.refine[0].to"),
        (refine("{polygons: a.shp, to: 4.9 m}"), "range", "resolution.refine[0].to"),
        (refine("{polygons: a.shp, to: 41 m}"), "range", "resolution.refine[0].to"),
        (refine("{polygons: a.shp}, {lines: b.shp, to: 3 m}"), "range", "resolution.refine[1].to"),
    ] {
        let found = problems(&text, &[]);
        let told: Vec<_> = found.iter().map(|problem| (problem.code, problem.key.as_str())).collect();
        assert_eq!(told, [(code, key)], "{text}: {found:?}");
        assert!(found[0].remedy.is_some() && found[0].place.is_some(), "{}", found[0]);
    }
}

#[test]
fn all_that_is_wrong_with_levels_is_reported_at_once() {
    let text = "{finest: 5 m, coarsest: 50 m, refine: [{polygons: a.shp, to: 1 m}, {lines: b.shp, to: 1 km}]}";
    let found = problems(text, &[]);
    let told: Vec<_> = found.iter().map(|problem| (problem.code, problem.key.as_str())).collect();
    // What is coarser than all levels is not known where the coarsest is wrong.
    assert_eq!(told, [("levels-not-nested", "resolution.coarsest"), ("range", "resolution.refine[0].to")]);
    let cause = found[1].cause.as_deref();
    assert_eq!(cause, Some("no cell is finer than `finest`, which is 5 m"), "{}", found[1]);
    assert_eq!(found[1].remedy.as_deref(), Some("write `to: 5 m` or more, or a finer `finest`"));
    let found = problems("{finest: 5 m, refine: [{lines: b.shp, to: 1 km}]}", &[]);
    assert_eq!(found[0].remedy.as_deref(), Some("write `to: 40 m` or less, or take the entry out"));
}

#[test]
fn set_changes_either_form() {
    let of = |resolution: &str, overrides: &[&str]| spacings(&scenario(resolution, overrides));
    let levels = "{finest: 5 m, coarsest: 40 m}";
    assert_eq!(of(levels, &["resolution=10 m"]), (10.0, None));
    assert_eq!(of(levels, &["resolution.finest=10 m"]), (10.0, Some(40.0)));
    assert_eq!(of(levels, &["resolution.coarsest=20 m"]), (5.0, Some(20.0)));
    assert_eq!(of("20 m", &["resolution=10 m"]), (10.0, None));
    assert_eq!(of("20 m", &["resolution.finest=10 m"]), (10.0, Some(80.0)));
    assert_eq!(of("20 m", &["resolution.coarsest=40 m"]), (20.0, Some(40.0)));
    assert_eq!(of("20 m", &["resolution={finest: 3 m}", "resolution.coarsest=6 m"]), (3.0, Some(6.0)));
    assert_eq!(of("20 m", &[" resolution.coarsest=40 m", "resolution=5 m"]), (5.0, None));
    let found = problems(levels, &["resolution.finest=7 m"]);
    assert_eq!((found[0].code, found[0].key.as_str()), ("levels-not-nested", "resolution.coarsest"));
    let error = load("20 m", &["resolution.finset=5 m"]).unwrap_err();
    assert!(matches!(&error, Error::Usage(text) if text.contains("did you mean `finest`?")), "{error}");
}

#[test]
fn levels_are_for_eulerian_particles() {
    let levels = "{finest: 5 m}";
    for moving in ["numerics.motion=lagrangian", "numerics.formulation=variational"] {
        let found = problems(levels, &[moving]);
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!((found[0].code, found[0].key.as_str()), ("levels-for-eulerian", "resolution"), "{moving}");
        assert!(found[0].place.is_some() && found[0].cause.is_some(), "{}", found[0]);
        let remedy = found[0].remedy.as_deref().unwrap();
        assert!(remedy.starts_with("write `resolution: 5 m`, or "), "{remedy}");
        assert!(load("5 m", &[moving]).is_ok());
    }
    assert!(load(levels, &["numerics.motion=eulerian"]).is_ok());
}

#[test]
fn channels_alone_have_no_levels() {
    let channels = |resolution: &str| {
        let text = format!(
            "floodsim: 1\nroughness: {{manning: 0.03}}\ntime: {{end: 1 h}}\nresolution: {resolution}\n\
             channels: [{{id: river, length: 2 km, width: 8 m, bed: 100 m, upstream: {{discharge: 40 m3/s}}}}]\n"
        );
        resolve(&text, Path::new("scenario.yaml"), &[])
    };
    assert!(channels("5 m").is_ok());
    let Err(Error::Problems(found)) = channels("{finest: 5 m}") else { panic!("not refused") };
    let told: Vec<_> = found.iter().map(|problem| (problem.code, problem.key.as_str())).collect();
    assert_eq!(told, [("needs-terrain", "resolution")], "{found:?}");
    let remedy = found[0].remedy.as_deref().unwrap();
    assert!(remedy.starts_with("write `resolution: 5 m`, or add `terrain: "), "{remedy}");
}

#[test]
fn cells_of_maps_are_compared_with_the_finest() {
    let codes = |cell: &str| -> Vec<&str> {
        let warnings = load("{finest: 5 m, coarsest: 40 m}", &[&format!("outputs.cell={cell}")]).unwrap().warnings;
        warnings.iter().map(|warning| warning.code).collect()
    };
    assert_eq!(codes("4.9 m"), ["finer-than-resolution"]);
    assert!(codes("5 m").is_empty() && codes("terrain").is_empty());
}

#[test]
fn the_schema_has_all_forms() {
    let schema = schemars::schema_for!(ScenarioFile).to_value();
    let forms = schema.pointer("/$defs/Resolution/anyOf").and_then(|forms| forms.as_array()).unwrap();
    assert_eq!(forms[0]["const"], "auto");
    let names: Vec<_> =
        forms[1..].iter().map(|form| form["$ref"].as_str().unwrap().trim_start_matches("#/$defs/")).collect();
    assert_eq!(names, ["Length", "LevelsSection"]);
    assert_eq!(schema.pointer("/$defs/LevelsSection/additionalProperties"), Some(&false.into()));
}

#[test]
fn auto_is_a_word_or_a_section_of_limits_and_takes_lengths_later() {
    let bare = scenario("auto", &[]);
    assert_eq!((bare.auto, bare.resolution.value.is_nan(), bare.levels.is_none()), (Some(Auto::default()), true, true));
    let limits = scenario("{auto: {cpu: 10 min, memory: 2 GB, error: 10 cm}}", &[]);
    assert_eq!(limits.auto, Some(Auto { cpu: Some(600.0), memory: Some(2e9), error: Some(0.1) }));
    let alone = bare.with_lengths(10.0, 10.0);
    assert_eq!((spacings(&alone), alone.outputs.cell, alone.auto), ((10.0, None), 10.0, None));
    assert!(alone.to_yaml().contains("\nresolution: 10 m\n"), "{}", alone.to_yaml());
    let nested = bare.with_lengths(10.0, 40.0);
    assert_eq!(spacings(&nested), (10.0, Some(40.0)));
    assert_eq!(spacings(&resolve(&nested.to_yaml(), Path::new("s.yaml"), &[]).unwrap().scenario), (10.0, Some(40.0)));
    // `--set` puts a length in its place.
    assert_eq!(spacings(&scenario("auto", &["resolution=5 m"])), (5.0, None));
}

#[test]
fn auto_stands_alone() {
    for (text, code, key) in [
        ("{auto: {cpu: 1 h}, finest: 5 m}", "conflict", "resolution.finest"),
        ("{auto: {cpu: 1 h}, refine: [{lines: a.shp}]}", "conflict", "resolution.refine"),
        ("{auto: }", "missing-key", "resolution.auto"),
        ("{auto: {cpu: 5 m}}", "unit", "resolution.auto.cpu"),
        ("{auto: {error: 0 m}}", "range", "resolution.auto.error"),
        ("{auto: {time: 1 h}}", "unknown-key", "resolution.auto.time"),
    ] {
        let found = problems(text, &[]);
        let codes: Vec<(&str, &str)> = found.iter().map(|problem| (problem.code, problem.key.as_str())).collect();
        assert_eq!(codes, [(code, key)], "{text}");
    }
}
