//! From the text of a scenario to a `Scenario`.

use super::*;
use crate::scenario::methods::{
    Formulation, Integrator, Motion, Preset, Reconstruction, Seeding, Stabilisation, Turbulence, WallMethod,
};
use crate::scenario::model::{CrsChoice, OutputPart, TerrainLayer};

/// The ten lines of the design, to the letter.
const TEN_LINES: &str = "floodsim: 1
title: Malpasset, 2 December 1959
crs: local            # the survey's own metres; a terrain that has a CRS needs no such line
terrain: {layers: [{raster: dem_20m.tif}]}
roughness: {manning: 0.033}
initial:
  - {reservoir: reservoir.geojson, level: 100 m}
  - {reservoir: sea.geojson, level: 0 m}
resolution: 20 m
time: {end: 4000 s}
outputs: {cell: 20 m, every: 100 s, gauges: gauges.csv}
";

fn loaded(text: &str, overrides: &[&str]) -> Result<Loaded, Error> {
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    resolve(text, Path::new("cases/malpasset/scenario.yaml"), &overrides)
}

fn problems(text: &str) -> Vec<Problem> {
    match loaded(text, &[]) {
        Err(Error::Problems(problems)) => {
            problems.into_iter().filter(|problem| problem.kind == ProblemKind::Scenario).collect()
        }
        other => panic!("problems are expected, not {other:?}"),
    }
}

fn exact(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits()
}

#[test]
fn the_ten_line_example_is_read_to_the_letter() {
    let Loaded { scenario, warnings } = loaded(TEN_LINES, &[]).unwrap();
    assert!(warnings.is_empty());
    assert_eq!(scenario.title, "Malpasset, 2 December 1959");
    assert_eq!(scenario.crs.value, CrsChoice::Local);
    let TerrainLayer::Raster { path, offset, unit, .. } = &scenario.layers[0].value else { panic!("not a raster") };
    assert_eq!(path, Path::new("cases/malpasset/dem_20m.tif"));
    assert!(exact(*offset, 0.0) && unit.is_none());
    assert!(exact(scenario.roughness.manning.unwrap(), 0.033) && exact(scenario.resolution.value, 20.0));
    assert!(exact(scenario.end_time, 4000.0) && exact(scenario.outputs.every, 100.0));
    assert_eq!(scenario.initial.len(), 2);
    let level = scenario.initial[0].level.as_ref().unwrap();
    assert!(exact(level.value, 100.0));
    assert_eq!(level.key, "initial[0].level");
    assert_eq!(level.place.as_ref().map(|place| (place.line, place.column)), Some((7, 43)));
    assert_eq!(scenario.outputs.gauges.as_ref().unwrap().value.path, Path::new("cases/malpasset/gauges.csv"));
}

#[test]
fn defaults_are_filled_in() {
    let text = TEN_LINES.replace("outputs: {cell: 20 m, every: 100 s, gauges: gauges.csv}\n", "");
    let scenario = loaded(&text, &[]).unwrap().scenario;
    let outputs = &scenario.outputs;
    assert_eq!(outputs.folder.value, Path::new("runs/malpasset"));
    assert!(exact(outputs.cell, 20.0) && exact(outputs.every, 120.0) && exact(outputs.gauges_every, 12.0));
    assert_eq!(outputs.thresholds, [0.01, 0.10, 0.30]);
    assert_eq!(outputs.isochrones, [300.0, 600.0, 900.0, 1800.0, 2700.0, 3600.0]);
    let numerics = &scenario.numerics;
    assert_eq!((numerics.motion, numerics.integrator), (Motion::Eulerian, Integrator::Heun));
    assert_eq!(
        (numerics.stabilisation, numerics.reconstruction),
        (Stabilisation::TwoRarefactions, Reconstruction::Limited)
    );
    assert!(exact(numerics.cfl, 0.5) && exact(numerics.gravity, 9.81) && exact(numerics.dry_depth, 1e-3));
    assert!(exact(scenario.limits.particles, 50e6) && scenario.limits.memory > 1e8);

    let moving = loaded(&text, &["numerics.motion=lagrangian"]).unwrap().scenario.numerics;
    assert_eq!((moving.integrator, moving.stabilisation), (Integrator::Heun, Stabilisation::TwoRarefactions));
    assert!(exact(moving.cfl, 0.5) && moving.reconstruction == Reconstruction::Limited);
    let classic = loaded(&text, &["numerics.formulation=variational"]).unwrap().scenario.numerics;
    assert_eq!((classic.motion, classic.stabilisation), (Motion::Lagrangian, Stabilisation::ArtificialViscosity));
    assert!(exact(classic.cfl, 0.4) && classic.reconstruction == Reconstruction::None);
}

#[test]
fn all_problems_are_reported_at_once() {
    let text = "floodsim: 1
titel: x
terrain: {layer: [{raster: a.tif}], layers: [{raster: a.tif, max_gap: 3 m}]}
roughness: {manning: -0.1}
initial:
  - {reservor: a.geojson, level: 20 kg}
  - {reservoir: b.geojson, sea: c.geojson}
resolution: 0 m
time: {end: 30}
outputs: {every: [1], arrival: {thresholds: [0 m, 0.1 m]}}
numerics: {formulation: variational, motion: eulerian, cfl: 1.5, kernel: cubic-spline}
";
    let found: Vec<(usize, &str, String)> =
        problems(text).into_iter().map(|p| (p.place.as_ref().unwrap().line, p.code, p.key)).collect();
    let expected = [
        (2, "unknown-key", "titel"),
        (3, "unknown-key", "terrain.layer"),
        (3, "conflict", "terrain.layers[0].max_gap"),
        (4, "range", "roughness.manning"),
        (6, "missing-key", "initial[0]"),
        (6, "unknown-key", "initial[0].reservor"),
        (6, "unit", "initial[0].level"),
        (7, "conflict", "initial[1]"),
        (8, "range", "resolution"),
        (9, "missing-unit", "time.end"),
        (10, "wrong-type", "outputs.every"),
        (10, "range", "outputs.arrival.thresholds[0]"),
        (11, "method-combination", "numerics.motion"),
        (11, "range", "numerics.cfl"),
        (11, "unknown-name", "numerics.kernel"),
    ];
    assert_eq!(found, expected.map(|(line, code, key)| (line, code, key.to_owned())));
}

#[test]
fn the_parts_to_write_are_chosen_by_name() {
    let text = |write: &str| TEN_LINES.replace("outputs: {", &format!("outputs: {{write: {write}, "));
    let written = |write: &str| loaded(&text(write), &[]).unwrap().scenario.outputs.write;
    assert_eq!(loaded(TEN_LINES, &[]).unwrap().scenario.outputs.write, OutputPart::ALL);
    assert_eq!(written("[tables, maps, tables]"), [OutputPart::Maps, OutputPart::Tables]);
    assert!(written("[]").is_empty());
    let found = problems(&text("[map, geopackage]"));
    let reported: Vec<_> = found.iter().map(|p| (p.code, p.key.as_str(), p.remedy.as_deref().unwrap())).collect();
    let all = "use one of fields, maps, cog, gpkg, tables, sections, channels";
    assert_eq!(
        reported,
        [("unknown-name", "outputs.write[0]", "did you mean `maps`?"), ("unknown-name", "outputs.write[1]", all),]
    );
    let text = text("[maps]").replace("every: 100 s", "every: 100 s, isochrones: [5 min]");
    let warnings = loaded(&text, &[]).unwrap().warnings;
    assert!(warnings.iter().any(|warning| warning.code == "not-written" && warning.key == "outputs.isochrones"));
}

fn all_pairs<A, B>(a: &'static [A], b: &'static [B]) -> impl Iterator<Item = (&'static A, &'static B)> {
    a.iter().flat_map(move |a| b.iter().map(move |b| (a, b)))
}

#[test]
fn exactly_the_combinations_that_a_core_has_are_accepted() {
    let mut accepted = Vec::new();
    for formulation in Formulation::ALL {
        for motion in Motion::ALL {
            for (stabilisation, reconstruction) in all_pairs(Stabilisation::ALL, Reconstruction::ALL) {
                for (integrator, seeding) in all_pairs(Integrator::ALL, Seeding::ALL) {
                    let names = [formulation.name(), motion.name(), stabilisation.name(), integrator.name()];
                    let text = format!(
                        "numerics={{formulation: {}, motion: {}, stabilisation: {}, integrator: {}, reconstruction: {}, seeding: {}}}",
                        names[0],
                        names[1],
                        names[2],
                        names[3],
                        reconstruction.name(),
                        seeding.name()
                    );
                    let Ok(Loaded { scenario, .. }) = loaded(TEN_LINES, &[&text]) else { continue };
                    let numerics = scenario.numerics;
                    assert_eq!((numerics.formulation, numerics.motion), (*formulation, *motion));
                    assert_eq!((numerics.integrator, numerics.seeding), (*integrator, *seeding));
                    assert_eq!((numerics.stabilisation, numerics.reconstruction), (*stabilisation, *reconstruction));
                    accepted.push((*formulation, *motion));
                }
            }
        }
    }
    let count = |formulation, motion| accepted.iter().filter(|pair| **pair == (formulation, motion)).count();
    // Cells have two stabilisations, particles of the variational formulation four; all with and without reconstruction, cells also with
    // the sharp one. Particles have two integrators and two fillings.
    assert_eq!(count(Formulation::Balanced, Motion::Eulerian), 2 * 3);
    assert_eq!(count(Formulation::Balanced, Motion::Lagrangian), 2 * 3);
    assert_eq!(count(Formulation::Variational, Motion::Eulerian), 0);
    assert_eq!(count(Formulation::Variational, Motion::Lagrangian), 4 * 2 * 4);
}

#[test]
fn a_preset_sets_choices_that_single_keys_beside_it_change() {
    let of = |overrides: &[&str]| loaded(TEN_LINES, overrides).unwrap().scenario.numerics;
    assert_eq!(of(&["numerics.preset=balanced"]), of(&[]));
    for preset in Preset::ALL {
        let name = format!("numerics.preset={}", preset.name());
        let single = preset.keys().map(|(key, value)| format!("numerics.{key}={value}"));
        assert_eq!(of(&[&name]), of(&single.each_ref().map(String::as_str)), "{name}");
    }
    assert_eq!(of(&["numerics.preset=fast"]).reconstruction, Reconstruction::Sharp);
    let changed = of(&["numerics={preset: accurate, cfl: 0.3, stabilisation: lax_friedrichs, reconstruction: }"]);
    assert!(exact(changed.cfl, 0.3) && changed.stabilisation == Stabilisation::LaxFriedrichs);
    assert_eq!(changed.reconstruction, Reconstruction::Limited);
}

#[test]
fn a_preset_goes_with_either_motion() {
    for preset in Preset::ALL {
        let text = format!("numerics={{preset: {}, motion: lagrangian}}", preset.name());
        let numerics = loaded(TEN_LINES, &[&text]).unwrap().scenario.numerics;
        assert_eq!(
            (numerics.motion, numerics.stabilisation),
            (Motion::Lagrangian, Stabilisation::TwoRarefactions),
            "{text}"
        );
    }
}

#[test]
fn the_remedy_of_a_preset_that_a_core_does_not_have_is_to_leave_it_out() {
    let found =
        problems(&format!("{TEN_LINES}numerics: {{preset: fast, formulation: variational, motion: lagrangian}}\n"));
    let said: Vec<_> = found.iter().map(|p| (p.key.as_str(), p.remedy.as_deref().unwrap())).collect();
    let remedy = "leave `preset` out, or write `formulation: balanced, motion: eulerian`, or write `formulation: balanced, motion: lagrangian`";
    assert_eq!(said, [("numerics.preset", remedy)]);
}

/// `key: value` of each pair between the backticks of a remedy that names other cores.
fn keys_of_other_cores(remedy: &str) -> Vec<String> {
    remedy.split("or write `").skip(1).filter_map(|rest| rest.split('`').next()).map(str::to_owned).collect()
}

#[test]
fn a_remedy_for_a_missing_method_leads_to_a_scenario_that_runs() {
    let mut followed = 0;
    for written in [
        "formulation: variational, stabilisation: two_rarefactions",
        "formulation: variational, reconstruction: sharp",
        "formulation: variational, motion: eulerian",
        "motion: eulerian, bed_slope: steep",
        "motion: lagrangian, turbulence: mixing_length",
        "kernel: gauss",
        "integrator: leapfrog, seeding: equal_volume",
        "stabilisation: artificial_viscosity, turbulence: mixing_length",
    ] {
        for problem in problems(&format!("{TEN_LINES}numerics: {{{written}}}\n")) {
            for other in keys_of_other_cores(problem.remedy.as_deref().unwrap()) {
                let is_kept = |pair: &&str| !pair.starts_with("formulation") && !pair.starts_with("motion");
                let kept: Vec<&str> = written.split(", ").filter(is_kept).collect();
                let text = [kept.join(", "), other].join(", ");
                let result = loaded(TEN_LINES, &[&format!("numerics={{{}}}", text.trim_start_matches(", "))]);
                assert!(result.is_ok(), "`{written}` leads to `{text}`: {result:?}");
                followed += 1;
            }
        }
    }
    assert!(followed >= 6, "only {followed} remedies name another core");
}

#[test]
fn every_method_that_acts_has_a_name() {
    for text in ["motion: eulerian", "motion: lagrangian", "formulation: variational"] {
        let numerics = loaded(TEN_LINES, &[&format!("numerics={{{text}}}")]).unwrap().scenario.numerics;
        let acting = numerics.acting();
        assert!(acting.len() > 6 && acting.iter().all(|(_, name)| !name.is_empty()), "{acting:?}");
        assert_eq!(
            acting.iter().any(|(family, _)| *family == "kernel"),
            text == "formulation: variational",
            "{acting:?}"
        );
    }
}

#[test]
fn walls_are_a_choice_of_the_variational_formulation() {
    let of = |text: &str| loaded(TEN_LINES, &[text]).unwrap().scenario.numerics.wall;
    assert_eq!(of("numerics.motion=lagrangian"), WallMethod::Mirror);
    assert_eq!(of("numerics={formulation: variational, wall: virtual_particles}"), WallMethod::VirtualParticles);
    for cells in ["", "motion: lagrangian, "] {
        let found = problems(&format!("{TEN_LINES}numerics: {{{cells}wall: virtual_particles}}\n"));
        assert_eq!((found[0].code, found[0].key.as_str()), ("method-combination", "numerics.wall"));
    }
}

#[test]
fn turbulence_is_a_choice_of_resting_particles() {
    let of = |text: &str| loaded(TEN_LINES, &[text]).unwrap().scenario.numerics.turbulence;
    assert_eq!(of("numerics.motion=eulerian"), Turbulence::None);
    assert_eq!(of("numerics.turbulence=mixing_length"), Turbulence::MixingLength);
    for moving in ["motion: lagrangian", "formulation: variational"] {
        let found = problems(&format!("{TEN_LINES}numerics: {{{moving}, turbulence: mixing_length}}\n"));
        assert_eq!((found[0].code, found[0].key.as_str()), ("method-combination", "numerics.turbulence"));
    }
}

#[test]
fn what_does_not_go_with_a_preset_is_reported_at_the_preset() {
    let found = problems(&format!("{TEN_LINES}numerics: {{preset: fsat}}\n"));
    assert_eq!((found[0].code, found[0].key.as_str()), ("unknown-name", "numerics.preset"));
    assert_eq!(found[0].remedy.as_deref(), Some("did you mean `fast`?"));
    let found =
        problems(&format!("{TEN_LINES}numerics: {{formulation: variational, motion: lagrangian, preset: fast}}\n"));
    let place = found[0].place.as_ref().map(|place| (place.line, place.column));
    assert_eq!(
        (found.len(), found[0].code, found[0].key.as_str()),
        (1, "method-combination", "numerics.preset"),
        "{found:?}"
    );
    assert_eq!(place, Some((12, 66)));
}

#[test]
fn a_wrong_indentation_is_named_as_such() {
    let text = TEN_LINES.replace("time: {end: 4000 s}", "time:\nend: 4000 s");
    let found = problems(&text);
    assert!(found.iter().any(|p| p.key == "time" && p.remedy.as_ref().unwrap().contains("indentation")), "{found:?}");
}

#[test]
fn overrides_change_the_scenario_and_their_faults_are_usage_errors() {
    let scenario = loaded(TEN_LINES, &["initial[0].level=95 m", "numerics.cfl=0.3"]).unwrap().scenario;
    assert!(exact(scenario.initial[0].level.as_ref().unwrap().value, 95.0) && exact(scenario.numerics.cfl, 0.3));
    let error = loaded(TEN_LINES, &["resoluton=5 m"]).unwrap_err();
    assert!(matches!(&error, Error::Usage(text) if text.contains("did you mean `resolution`?")), "{error}");
    let Err(Error::Problems(found)) = loaded(TEN_LINES, &["resolution=5 kg"]) else { panic!("not refused") };
    assert_eq!((found[0].key.as_str(), found[0].cause.as_deref()), ("resolution", Some("the value comes from --set")));
}

#[test]
fn intervals_longer_than_the_run_and_cells_finer_than_the_resolution_are_told() {
    let codes = |from: &str, to: &str| -> Vec<(&str, String)> {
        assert!(TEN_LINES.contains(from), "{from}");
        let warnings = loaded(&TEN_LINES.replace(from, to), &[]).unwrap().warnings;
        warnings.into_iter().map(|problem| (problem.code, problem.key)).collect()
    };
    let reported = |code: &'static str, key: &str| vec![(code, key.to_owned())];
    assert_eq!(codes("every: 100 s", "every: 67 min"), reported("longer-than-run", "outputs.every"));
    assert_eq!(codes("every: 100 s", "gauges_every: 2 h"), reported("longer-than-run", "outputs.gauges_every"));
    assert_eq!(codes("cell: 20 m", "cell: 19 m"), reported("finer-than-resolution", "outputs.cell"));
    assert_eq!(codes("cell: 20 m, every: 100 s", "cell: 30 m, every: 4000 s"), []);
}

#[test]
fn a_doubtful_roughness_is_a_warning() {
    let text = TEN_LINES.replace("0.033", "0.002");
    assert_eq!(loaded(&text, &[]).unwrap().warnings[0].code, "roughness");
    assert!(loaded(&TEN_LINES.replace("0.033", "0"), &[]).unwrap().warnings.is_empty());
}

#[test]
fn a_level_alone_is_told_to_be_that_at_the_boundary_and_a_still_one_needs_a_wave() {
    let with = |boundary: &str| format!("{TEN_LINES}boundaries: [{{side: west, {boundary}}}]\n");
    let warned = |boundary: &str| -> Vec<(&str, String)> {
        let warnings = loaded(&with(boundary), &[]).unwrap().warnings;
        warnings.into_iter().map(|problem| (problem.code, problem.key)).collect()
    };
    assert_eq!(warned("level: 3 m"), [("level-is-at-the-boundary", "boundaries[0].level".to_owned())]);
    for silent in ["level: 3 m, discharge: 2 m3/s", "stage: 3 m", "wave: 3 m", "wave: {series: w.csv}, still: 1 m"] {
        assert_eq!(warned(silent), [], "{silent}");
    }
    for (text, code, key) in [
        ("still: 1 m", "missing-key", "boundaries[0]"),
        ("stage: 2 m, still: 1 m", "conflict", "boundaries[0].still"),
        ("wave: 2 m, stage: 1 m", "conflict", "boundaries[0]"),
    ] {
        let found = problems(&with(text));
        assert_eq!((found[0].code, found[0].key.as_str()), (code, key), "{text}");
    }
}

#[test]
fn the_schema_knows_the_keys_of_the_example() {
    let schema = schemars::schema_for!(ScenarioFile);
    let properties = schema.get("properties").unwrap();
    for key in ["floodsim", "title", "crs", "terrain", "roughness", "initial", "resolution", "time", "outputs"] {
        assert!(properties.get(key).is_some(), "{key}");
    }
    assert_eq!(schema.get("additionalProperties"), Some(&serde_json::Value::Bool(false)));
    assert!(schema.get("required").unwrap().as_array().unwrap().iter().any(|key| key == "resolution"));
    assert!(schema.to_value().pointer("/$defs/BoundaryEntry/properties/type").is_some());
}

proptest::proptest! {
    #[test]
    fn any_change_of_the_example_is_read_or_refused(at in 0..TEN_LINES.len(), by in "[ -~\n]{0,4}", cut in 0..5_usize) {
        let end = (at + cut).min(TEN_LINES.len());
        let text = format!("{}{by}{}", &TEN_LINES[..at], &TEN_LINES[end..]);
        if let Err(error) = loaded(&text, &[]) {
            proptest::prop_assert_eq!(error.exit_code(), crate::error::ExitCode::Scenario);
        }
    }
}
