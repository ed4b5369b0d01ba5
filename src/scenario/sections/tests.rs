//! Every kind of scenario, written and read back.

use std::path::Path;

use crate::scenario::{
    BoundaryCondition, Breach, BreachTrigger, LineLevel, OpenBoundary, RainAmount, Scenario, SourcePlace, TerrainLayer,
    Timed, resolve,
};

/// The scenario without the places of its values, which differ between two files by nature.
fn without_places(scenario: &Scenario) -> Scenario {
    let mut plain = scenario.clone();
    plain.file = "".into();
    plain.crs.place = None;
    plain.resolution.place = None;
    if let Some(levels) = &mut plain.levels {
        levels.coarsest.place = None;
        levels.refine.iter_mut().for_each(|place| place.place = None);
    }
    plain.outputs.folder.place = None;
    for layer in &mut plain.layers {
        layer.place = None;
        let (TerrainLayer::Raster { clip, .. } | TerrainLayer::Points { clip, .. }) = &mut layer.value;
        clip.iter_mut().for_each(|clip| clip.place = None);
    }
    plain.ground.gaps.iter_mut().for_each(|gaps| gaps.place = None);
    plain.ground.buildings.iter_mut().for_each(|buildings| buildings.polygons.place = None);
    for line in &mut plain.ground.breaklines {
        line.lines.place = None;
        if let LineLevel::Constant(level) = &mut line.level {
            level.place = None;
        }
    }
    for water in &mut plain.initial {
        water.polygons.place = None;
        water.level.iter_mut().for_each(|level| level.place = None);
    }
    for water in &mut plain.start.depths {
        (water.place.place, water.depth.place) = (None, None);
    }
    if let Some(earlier) = &mut plain.start.earlier {
        earlier.fields.place = None;
        earlier.time.iter_mut().for_each(|time| time.place = None);
    }
    plain.walls.iter_mut().for_each(|wall| wall.place = None);
    plain.outputs.gauges.iter_mut().for_each(|gauges| gauges.place = None);
    for boundary in plain.open.iter_mut().chain(&mut plain.closed) {
        if let OpenBoundary::Lines(lines) = boundary {
            lines.place = None;
        }
    }
    let rough = &mut plain.roughness;
    rough.raster.iter_mut().chain(&mut rough.table).for_each(|file| file.place = None);
    rough.polygons.iter_mut().for_each(|file| file.place = None);
    forget_forcing(&mut plain);
    plain
}

/// The same for boundaries, sources, rain and sections; their keys count the entries, which the resolved file puts in order.
fn forget_forcing(plain: &mut Scenario) {
    fn forget(timed: &mut Timed) {
        match timed {
            Timed::Constant(value) => value.place = None,
            Timed::Series(table) => table.file.place = None,
        }
    }
    for boundary in &mut plain.boundaries {
        boundary.place = None;
        if let OpenBoundary::Lines(lines) = &mut boundary.value.place {
            lines.place = None;
        }
        match &mut boundary.value.condition {
            BoundaryCondition::Free => {}
            BoundaryCondition::Discharge { discharge, level } => {
                forget(discharge);
                level.iter_mut().for_each(forget);
            }
            BoundaryCondition::Stage(level) | BoundaryCondition::Level(level) => forget(level),
            BoundaryCondition::Wave { level, still } => {
                forget(level);
                still.iter_mut().for_each(forget);
            }
            BoundaryCondition::NormalDepth(slope) => slope.place = None,
            BoundaryCondition::Rating(table) => table.file.place = None,
        }
    }
    for source in &mut plain.sources {
        source.place = None;
        forget(&mut source.value.discharge);
        match &mut source.value.place {
            SourcePlace::At(at) => at.place = None,
            SourcePlace::Points(file) => file.place = None,
            // `line` and `lines` say the same.
            SourcePlace::Lines(file) => (file.place, file.key) = (None, String::new()),
        }
    }
    if let Some(rain) = &mut plain.rain {
        rain.place = None;
        match &mut rain.value.amount {
            RainAmount::Rate(rate) => forget(rate),
            RainAmount::Raster { file, .. } => file.place = None,
            RainAmount::Series { file, .. } => file.place = None,
        }
    }
    plain.outputs.sections.iter_mut().for_each(|sections| sections.place = None);
    plain.breach.iter_mut().for_each(forget_breach);
}

fn forget_breach(breach: &mut Breach) {
    breach.dam.place = None;
    breach.crest.iter_mut().chain(&mut breach.duration).for_each(|value| value.place = None);
    breach.share.iter_mut().for_each(|share| share.file.place = None);
    match &mut breach.trigger {
        BreachTrigger::At(at) => (at.place, at.key) = (None, String::new()),
        BreachTrigger::Level { level, place } => (level.place, place.place) = (None, None),
    }
    if let Some(shape) = &mut breach.shape {
        (shape.bottom_width.place, shape.invert.place) = (None, None);
        shape.position.iter_mut().for_each(|place| place.place = None);
    }
    if let Some(method) = &mut breach.method {
        (method.volume.place, method.invert.place) = (None, None);
        method.position.iter_mut().for_each(|place| place.place = None);
    }
}

#[track_caller]
fn assert_round_trip(text: &str) {
    let first = resolve(text, Path::new("/somewhere/scenario.yaml"), &[]).unwrap().scenario;
    let written = first.to_yaml();
    let second = resolve(&written, Path::new("/elsewhere/scenario.resolved.yaml"), &[]).unwrap().scenario;
    let (mut expected, mut found) = (without_places(&first), without_places(&second));
    expected.outputs.folder.value = std::path::absolute(&expected.outputs.folder.value).unwrap();
    // What the first leaves to the default the second says.
    expected.outputs.folder.key = "outputs.folder".to_owned();
    // The short form of the terrain has another key path.
    for (a, b) in expected.layers.iter_mut().zip(&mut found.layers) {
        a.key.clone_from(&b.key);
    }
    assert_eq!(expected, found);
    assert_eq!(written, second.to_yaml());
}

#[test]
fn a_resolved_scenario_reads_back_as_itself() {
    assert_round_trip(
        "floodsim: 1\nterrain: dem.tif\nroughness: {manning: 0.033}\ninitial: [{sea: a.geojson, level: 0.1 m}]\n\
             resolution: 20 ft\ntime: {end: 1 h 30 min}\n",
    );
}

#[test]
fn every_kind_of_resolution_reads_back_as_itself() {
    for resolution in [
        "0.35 m",
        "{finest: 1 ft}",
        "{finest: 35 cm, coarsest: 5.6 m, refine: []}",
        "{finest: 5 m, coarsest: 5 m, refine: [{polygons: town.gpkg:core}, {lines: \"dike: 1.shp\", to: 5 m}]}",
        "{finest: 20 ft, refine: [{lines: a.shp, to: 100 ft, within: 0.1 km}, {polygons: b.shp, to: 40 ft}, {lines: c.shp, within: 0}]}",
    ] {
        assert_round_trip(&format!(
            "floodsim: 1\nterrain: dem.tif\nroughness: {{manning: 0.033}}\ninitial: [{{sea: a.geojson, level: 0.1 m}}]\n\
                 resolution: {resolution}\ntime: {{end: 1 h}}\n",
        ));
    }
    let text = "floodsim: 1\nterrain: dem.tif\nroughness: {manning: 0.033}\ninitial: [{sea: a.geojson, level: 0.1 m}]\n\
         resolution: {finest: 5 m, refine: [{lines: levee.shp}]}\ntime: {end: 1 h}\n";
    let written = resolve(text, Path::new("/somewhere/scenario.yaml"), &[]).unwrap().scenario.to_yaml();
    let expected = "\nresolution:\n  finest: 5 m\n  coarsest: 40 m\n  refine:\n    - {lines: \"/somewhere/levee.shp\", to: 5 m, within: 20 m}\n";
    assert!(written.contains(expected), "{written}");
}

#[test]
fn every_kind_of_water_reads_back_as_itself() {
    for initial in [
        "[{sea: a.geojson, level: 0.1 m}, {water: p.gpkg:pond, depth: 50 cm}, {river: r.shp, depth: 1 ft, width: 3 m}, \
             {river: r.shp, depth: 1 m, width_field: \"w, m\"}, {river: r.shp, depth: 2 m}]",
        "[{fields: before/fields.nc}]",
        "[{fields: before/fields.nc, time: 90 s}]",
    ] {
        assert_round_trip(&format!(
            "floodsim: 1\nterrain: dem.tif\nroughness: {{manning: 0.033}}\ninitial: {initial}\n\
                 resolution: 20 m\ntime: {{end: 1 h}}\n",
        ));
    }
}

#[test]
fn a_breach_reads_back_as_itself() {
    for breach in [
        "{dam: dam.gpkg:crest, crest: 105 m}",
        "{dam: dam.gpkg, crest: 105 m, method: {name: froehlich1995, mode: piping, volume: 2.5 hm3, invert: 90 m, position: [7, 8.25]}}",
        "{dam: dam.geojson, crest_field: top, trigger: {at: 3 min}, shape: {bottom_width: 40 ft, invert: 90 m}, \
             growth: {law: linear, duration: 0.5 h}}",
        "{dam: dam.geojson, crest: 3 m, growth: {law: series, share: {series: g.csv, column: p, unit: '%', time: t, time_unit: h}}}",
        "{dam: dam.geojson, trigger: {level: 104.5 m, at_point: [5.5, 6]}, \
             shape: {bottom_width: 4 m, side_slope: 0, invert: 90 m, position: [7, 8.25]}, growth: {law: sine, duration: 9 s}}",
    ] {
        assert_round_trip(&format!(
            "floodsim: 1\nterrain: dem.tif\nroughness: {{manning: 0.033}}\ninitial: [{{sea: a.geojson, level: 0.1 m}}]\n\
                 resolution: 20 m\ntime: {{end: 1 h}}\nbreach: {breach}\n",
        ));
    }
}

#[test]
fn boundaries_sources_rain_and_sections_read_back_as_themselves() {
    let start = "floodsim: 1\nterrain: dem.tif\nroughness: {manning: 0.033}\nresolution: 20 m\ntime: {end: 1 h}\n";
    let boundaries = r#"
boundaries:
  - {side: all, type: open}
  - {edge: west, discharge: 250 l/s}
  - {lines: in.gpkg:upper, discharge: {series: q.csv, column: "Q, peak", unit: ft3/s, time: t, time_unit: h}, level: 12.3 m}
  - {lines: tide.geojson, stage: {series: tide.csv, after_end: hold}}
  - {side: north, level: 3 m}
  - {lines: swell.geojson, wave: {series: swell.csv}, still: {series: tide.csv}}
  - {lines: bay.geojson, wave: 3.2 m}
  - {side: south, normal_depth: {slope: 2 %}}
  - {side: east, rating: {table: w.csv, level: h, level_unit: cm, discharge_unit: m3/s}}
  - {lines: sea.geojson, type: free}
"#;
    let sources = "sources: [{at: [712345.5, -3.25], discharge: 2 m3/s}, {points: springs.gpkg:wells, discharge: {series: q.csv, unit: l/s}}, \
            {line: seep.gpkg:toe, discharge: 3 l/s}]\n";
    let rate =
        "rain: {rate: {series: rain.csv, unit: mm/h}, losses: {initial: 5 mm}}\noutputs: {sections: s.geojson}\n";
    let raster = "rain: {raster: rain.tif, unit: in/h, duration: 2 h, losses: {constant: 1 mm/h}}\n";
    let files = "rain: {raster_series: radar list.csv, unit: mm, stamp: end}\n";
    let netcdf = "rain: {raster_series: radar.nc:rate, start: 2026-06-01 06:00, losses: {initial: 2 mm}}\n";
    for rain in [rate, raster, files, netcdf] {
        assert_round_trip(&format!("{start}{boundaries}{sources}{rain}"));
    }
}

#[test]
fn every_kind_of_roughness_reads_back_as_itself() {
    let kinds = [
        "{raster: manning.tif}",
        "{raster: land cover.tif, table: manning.csv, default: 0.05, polygons: areas.gpkg:rough}",
        "{manning: 0.04, polygons: areas.geojson}",
    ];
    for kind in kinds {
        assert_round_trip(&format!(
            "floodsim: 1\nterrain: dem.tif\nroughness: {kind}\ninitial: [{{sea: a.geojson, level: 0.1 m}}]\n\
                 resolution: 20 m\ntime: {{end: 1 h}}\n"
        ));
    }
}

#[test]
fn a_preset_reads_back_as_its_choices() {
    assert_round_trip(
        "floodsim: 1\nterrain: dem.tif\nroughness: {manning: 0.033}\ninitial: [{sea: a.geojson, level: 0.1 m}]\n\
             resolution: 20 m\ntime: {end: 1 h}\nnumerics: {preset: fast, cfl: 0.4}\n",
    );
}

#[test]
fn a_scenario_with_every_key_reads_back_as_itself() {
    assert_round_trip(
        r#"
floodsim: 1
title: "a \"quoted\" title: with # signs, and ä\n"
crs: EPSG:27572
terrain:
  layers:
    - {points: survey.txt, interpolation: natural_neighbour, max_gap: 0.3 km, offset: -12.5 cm}
    - {raster: "b: 1.tif", unit: us_ft, offset: 1 ft, clip: "c.gpkg:in it", mode: min}
  reproject: true
  gaps: {fill: idw, max_cells: 12}
  breaklines:
    - {lines: a.gpkg:levee, mode: raise, z_field: "crest, m", width: 3 ft}
    - {lines: b.shp, mode: carve, z: 12.5 m}
    - {lines: c.shp, mode: raise}
roughness: {manning: 0}
structures:
  walls: [{lines: "walls.gpkg:dam wall"}, {lines: low.geojson, crest: 3 m}, {lines: lower.geojson, crest_field: z}]
  buildings: {polygons: b.gpkg:houses, mode: raise, height_field: h}
initial:
  - {reservoir: r.gpkg:lake, level_field: pegel}
  - {water: w.shp}
boundaries: [{side: all, type: open}, {lines: outlet.geojson, type: open}]
resolution: 0.1 m
time: {end: 3 d, reference: "1959-12-02 21:14"}
outputs:
  folder: out
  write: [tables, fields]
  cell: 7 m
  every: 1 min
  gauges: g.csv
  gauges_every: 333 ms
  arrival: {thresholds: [0.3 m, 1 ft], rise_on_wet: 1 mm}
  isochrones: []
numerics: {formulation: variational, seeding: equal_volume, bed: shepard, bed_slope: steep, wall: virtual_particles, cfl: 0.123456789, gravity: 3.71, dry_depth: 0.1 mm}
limits: {memory: 1.5 GiB, particles: 1e6}
"#,
    );
}
