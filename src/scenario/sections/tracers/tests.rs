use std::path::Path;

use super::*;
use crate::error::Error;
use crate::scenario::{Loaded, resolve};

fn load(tracers: &str) -> Result<Loaded, Error> {
    let text = format!(
        "floodsim: 1\nterrain: dem.tif\nroughness: {{manning: 0.03}}\ninitial: [{{reservoir: lake.geojson, level: 100 m}}]\n\
         boundaries: [{{side: west, discharge: 3 m3/s}}, {{side: east, type: open}}]\nsources: [{{at: [1, 2], discharge: 1 m3/s}}]\n\
         rain: {{rate: 10 mm/h}}\ntime: {{end: 1 h}}\ntracers: {tracers}\n"
    );
    let text = if tracers.contains("resolution:") { text } else { format!("{text}resolution: 5 m\n") };
    resolve(&text, Path::new("/somewhere/scenario.yaml"), &[])
}

#[test]
fn every_kind_is_read_and_reads_back_as_itself() {
    let text = "[{name: spill, half_life: 2 d, arrival_threshold: 5 %, from: [{water: a.gpkg:pond, concentration: 1.5e2 mg/l}, \
                {boundary: 1, concentration: 20 mg/l}, {source: 1, concentration: 0 mg/l}, {rain: true, concentration: 3mg/l}]}, \
                {name: old_water, from: [{boundary: 1, concentration: 1}]}]";
    let first = load(text).unwrap().scenario;
    let second = resolve(&first.to_yaml(), Path::new("/elsewhere/s.yaml"), &[]).unwrap().scenario;
    let plain = |mut scenario: Scenario| {
        let known: Vec<_> = (0..3).map(|entry| scenario.boundary_of_entry(entry)).collect();
        for tracer in &mut scenario.tracers {
            tracer.name.place = None;
            for from in &mut tracer.from {
                match &mut from.place {
                    TracerPlace::Water(polygons) => polygons.place = None,
                    TracerPlace::Boundary(entry) => *entry = known[*entry].unwrap(),
                    _ => {}
                }
            }
        }
        scenario.tracers
    };
    let tracers = plain(first);
    assert_eq!(tracers, plain(second));
    let [spill, water] = &tracers[..] else { panic!("{tracers:?}") };
    assert_eq!((spill.unit.as_str(), water.unit.as_str()), ("mg/l", "1"));
    assert!((spill.greatest() - 150.0).abs() < 1e-12 && (spill.arrival_threshold - 0.05).abs() < 1e-15);
    assert!((water.arrival_threshold - 0.01).abs() < 1e-15 && spill.half_life == Some(172_800.0));
    assert_eq!(water.from[0].place, TracerPlace::Boundary(0));
}

#[test]
fn what_does_not_go_together_is_refused_where_it_stands() {
    let from = "from: [{rain: true, concentration: 1}]";
    for (text, code, key) in [
        ("[{name: a}]".to_owned(), "missing-key", "tracers[0].from"),
        ("[{name: a, from: []}]".to_owned(), "empty-list", "tracers[0].from"),
        (format!("[{{name: 2 b, {from}}}]"), "tracer-name", "tracers[0].name"),
        (format!("[{{name: b, {from}}}, {{name: B, {from}}}]"), "tracer-name", "tracers[1].name"),
        ("[{name: a, from: [{concentration: 1}]}]".to_owned(), "missing-key", "tracers[0].from[0]"),
        ("[{name: a, from: [{rain: true, source: 1, concentration: 1}]}]".to_owned(), "conflict", "tracers[0].from[0]"),
        (
            "[{name: a, from: [{rain: true, concentration: -1 mg/l}]}]".to_owned(),
            "unit",
            "tracers[0].from[0].concentration",
        ),
        (
            "[{name: a, from: [{rain: true, concentration: much}]}]".to_owned(),
            "unit",
            "tracers[0].from[0].concentration",
        ),
        (
            "[{name: a, from: [{rain: true, concentration: 1 mg/l}, {source: 1, concentration: 1 g/l}]}]".to_owned(),
            "unit",
            "tracers[0].from[1].concentration",
        ),
        (
            "[{name: a, from: [{boundary: 3, concentration: 1}]}]".to_owned(),
            "no-such-entry",
            "tracers[0].from[0].boundary",
        ),
        (
            "[{name: a, from: [{boundary: 2, concentration: 1}]}]".to_owned(),
            "no-such-entry",
            "tracers[0].from[0].boundary",
        ),
        ("[{name: a, from: [{source: 0, concentration: 1}]}]".to_owned(), "range", "tracers[0].from[0].source"),
        ("[{name: a, from: [{source: 2, concentration: 1}]}]".to_owned(), "no-such-entry", "tracers[0].from[0].source"),
        (format!("[{{name: a, {from}, arrival_threshold: 2}}]"), "range", "tracers[0].arrival_threshold"),
        (format!("[{{name: a, {from}}}]\nresolution: auto"), "method-combination", "tracers"),
        (format!("[{{name: a, {from}}}]\nresolution: {{finest: 5 m}}"), "method-combination", "tracers"),
    ] {
        let Err(Error::Problems(found)) = load(&text) else { panic!("not refused: {text}") };
        let problem = found.into_iter().find(|problem| problem.kind == ProblemKind::Scenario).unwrap();
        assert_eq!((problem.code, problem.key.as_str()), (code, key), "{text}: {problem}");
        assert!(problem.remedy.is_some());
    }
}
