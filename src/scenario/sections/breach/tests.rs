use std::path::Path;

use crate::error::{Error, Problem, ProblemKind};
use crate::scenario::{Breach, BreachTrigger, GrowthLaw, resolve};

const START: &str = "floodsim: 1\nterrain: dem.tif\nroughness: {manning: 0.03}\n\
    initial: [{reservoir: lake.geojson, level: 100 m}]\nresolution: 5 m\ntime: {end: 1 h}\nbreach: ";

fn breach(text: &str) -> Breach {
    let scenario = resolve(&format!("{START}{text}\n"), Path::new("scenario.yaml"), &[]).unwrap().scenario;
    scenario.breach.unwrap()
}

fn problem(text: &str) -> Problem {
    let Err(Error::Problems(found)) = resolve(&format!("{START}{text}\n"), Path::new("scenario.yaml"), &[]) else {
        panic!("not refused: {text}")
    };
    found.into_iter().find(|problem| problem.kind == ProblemKind::Scenario).unwrap()
}

#[test]
fn a_dam_and_its_crest_are_enough() {
    let short = breach("{dam: dam.geojson, crest: 105 m}");
    assert_eq!((short.law, short.shape.is_none(), short.duration.is_none()), (GrowthLaw::Instantaneous, true, true));
    assert!(matches!(short.trigger, BreachTrigger::At(at) if at.value.abs() <= 0.0));
    assert_eq!(breach("{dam: dam.geojson, crest: 105 m, growth: instantaneous}").law, GrowthLaw::Instantaneous);
}

#[test]
fn every_key_is_read() {
    let full = breach(
        "{dam: dam.geojson, crest_field: z, trigger: {level: 101 m, at_point: [5, 6]}, \
         shape: {bottom_width: 40 m, side_slope: 0.7, invert: 90 m, position: [7, 8]}, \
         growth: {law: sine, duration: 35 min}}",
    );
    assert_eq!((full.law, full.crest_field.as_deref()), (GrowthLaw::Sine, Some("z")));
    let BreachTrigger::Level { level, place } = full.trigger else { panic!("not a level") };
    assert_eq!((level.value.to_bits(), place.key.as_str()), (101f64.to_bits(), "breach.trigger.at_point"));
    let shape = full.shape.unwrap();
    assert!((shape.side_slope - 0.7).abs() < 1e-15 && (full.duration.unwrap().value - 2100.0).abs() < 1e-9);
    assert!((shape.position.unwrap().value[1] - 8.0).abs() < 1e-15);
}

#[test]
fn what_does_not_go_together_is_refused_where_it_stands() {
    for (text, code, key) in [
        ("{dam: d.geojson, crest: 1 m, crest_field: z}", "conflict", "breach"),
        ("{dam: d.geojson, trigger: {level: 3 m}}", "missing-key", "breach.trigger"),
        ("{dam: d.geojson, trigger: {at: 3 s, at_point: [1, 2]}}", "conflict", "breach.trigger.at_point"),
        ("{dam: d.geojson, trigger: {level: 3 m, at_point: [1]}}", "wrong-type", "breach.trigger.at_point"),
        ("{dam: d.geojson, growth: sine}", "missing-key", "breach.growth"),
        ("{dam: d.geojson, growth: {law: linear}}", "missing-key", "breach.growth"),
        ("{dam: d.geojson, growth: {law: instantaneous, duration: 3 s}}", "conflict", "breach.growth.duration"),
        ("{dam: d.geojson, growth: series}", "missing-key", "breach.growth"),
        ("{dam: d.geojson, growth: {law: series}}", "missing-key", "breach.growth"),
        ("{dam: d.geojson, growth: {law: series, share: 3}}", "wrong-type", "breach.growth.share"),
        (
            "{dam: d.geojson, growth: {law: series, share: {series: g.csv, unit: m}}}",
            "unit",
            "breach.growth.share.unit",
        ),
        (
            "{dam: d.geojson, growth: {law: series, share: {series: g.csv, after_end: hold}}}",
            "conflict",
            "breach.growth.share.after_end",
        ),
        (
            "{dam: d.geojson, growth: {law: series, duration: 3 s, share: {series: g.csv}}}",
            "conflict",
            "breach.growth.duration",
        ),
        (
            "{dam: d.geojson, growth: {law: sine, duration: 3 s, share: {series: g.csv}}}",
            "conflict",
            "breach.growth.share",
        ),
        ("{dam: d.geojson, shape: {bottom_width: 3 m}}", "missing-key", "breach.shape.invert"),
        (
            "{dam: d.geojson, shape: {bottom_width: 3 m, invert: 1 m}, method: {name: froehlich2008, mode: piping, volume: 1 Mm3, invert: 1 m}}",
            "conflict",
            "breach.method",
        ),
        (
            "{dam: d.geojson, method: {name: froelich, mode: piping, volume: 1 Mm3, invert: 1 m}}",
            "unknown-name",
            "breach.method.name",
        ),
        (
            "{dam: d.geojson, method: {name: froehlich2008, mode: piping, volume: 1 m, invert: 1 m}}",
            "unit",
            "breach.method.volume",
        ),
        (
            "{dam: d.geojson, method: {name: froehlich2008, mode: piping, invert: 1 m}}",
            "missing-key",
            "breach.method.volume",
        ),
        ("{crest: 3 m}", "missing-key", "breach.dam"),
        ("{dam: d.geojson}\nnumerics: {formulation: variational}", "method-combination", "breach"),
    ] {
        let found = problem(text);
        assert_eq!((found.code, found.key.as_str()), (code, key), "{text}: {found}");
    }
}
