//! Water of the start without a level: which cells get it, and what is refused.

#![expect(clippy::float_cmp, reason = "made values are met exactly")]

use super::scene::{Scene, basin_elevation, centre_of, sourced, vector};
use crate::error::{Problem, Severity};
use crate::output::FILL;
use crate::prepare::{Prepared, prepare};
use crate::scenario::methods::{Formulation, Seeding};
use crate::scenario::{
    Breach, BreachTrigger, Breakline, BreaklineMode, EarlierRun, GrowthLaw, LineLevel, RiverWidth, WaterOfDepth,
};
use crate::scenario::{Channel, ChannelShape, ChannelWalls};

fn add(scene: &mut Scene, name: &str, depth: f64, river: Option<RiverWidth>) {
    let key = format!("initial[{}]", scene.scenario.start.depths.len() + 1);
    let kind = if river.is_some() { "river" } else { "water" };
    scene.scenario.start.depths.push(WaterOfDepth {
        place: vector(&format!("{key}.{kind}"), scene.path(name)),
        depth: sourced(&format!("{key}.depth"), depth),
        river,
    });
}

/// How many cells have this depth.
fn cells_of(prepared: &Prepared, depth: f64) -> usize {
    prepared.setup().still_water.depth.iter().filter(|own| **own == depth).count()
}

#[test]
fn areas_and_rivers_get_their_depth_where_no_level_puts_water() {
    let mut scene = Scene::sound();
    // Four cells of the lake and four of the plateau to the east of it, of which the river then takes two.
    scene.polygon("pond.geojson", &[(1090.0, 2070.0), (1110.0, 2070.0), (1110.0, 2080.0), (1090.0, 2080.0)]);
    add(&mut scene, "pond.geojson", 0.25, None);
    scene.lines_with("river.geojson", &[(&[(1101.0, 2077.5), (1199.0, 2077.5)], r#"{"w": 11}"#)]);
    add(&mut scene, "river.geojson", 0.75, Some(RiverWidth::Cell));
    let prepared = prepare(&scene.scenario);
    assert_eq!(prepared.problems, []);
    assert_eq!((cells_of(&prepared, 0.25), cells_of(&prepared, 0.75)), (2, 20));
    assert_eq!(prepared.scene().needs.wet_cells, 100 + 22);
    for (width, cells) in [(RiverWidth::Constant(11.0), 60), (RiverWidth::Field("w".to_owned()), 60)] {
        scene.scenario.start.depths[1].river = Some(width);
        let prepared = prepare(&scene.scenario);
        assert_eq!(cells_of(&prepared, 0.75), cells);
        // 61 cells, one of them in the lake, where the axis of 98 m has 11 m of width.
        let [reported] = &prepared.problems[..] else { panic!("{:?}", prepared.problems) };
        assert_eq!((reported.code, reported.key.as_str()), ("river-size", "initial[2].river"));
        assert!(
            reported.message.contains("1.144e3 m³, 1.4 times") && reported.message.contains("8.085e2 m³"),
            "{reported}"
        );
    }
    assert!(prepared.inputs.iter().any(|input| input.path.ends_with("river.geojson")));
    assert!(prepared.setup().initial_velocity.is_empty());
}

#[test]
fn a_river_stays_off_a_levee_that_crosses_it() {
    let mut scene = Scene::sound();
    scene.line("river.geojson", &[(1101.0, 2077.5), (1199.0, 2077.5)]);
    add(&mut scene, "river.geojson", 0.75, Some(RiverWidth::Cell));
    scene.line("levee.geojson", &[(1152.5, 2060.0), (1152.5, 2095.0)]);
    scene.scenario.ground.breaklines = vec![Breakline {
        lines: vector("terrain.breaklines[0].lines", scene.path("levee.geojson")),
        mode: BreaklineMode::Raise,
        level: LineLevel::Constant(sourced("terrain.breaklines[0].z", 30.0)),
        width: None,
    }];
    let prepared = prepare(&scene.scenario);
    assert_eq!(cells_of(&prepared, 0.75), 19);
}

/// A change that makes the water unfit, with the code and the key of what is reported.
type Unfit = (&'static str, &'static str, fn(&mut Scene));

#[test]
fn what_does_not_fit_is_refused_at_its_key() {
    let unfit: [Unfit; 8] = [
        ("outside-terrain", "initial[1].water", |scene| {
            scene.polygon("pond.geojson", &[(9090.0, 2070.0), (9110.0, 2070.0), (9110.0, 2080.0)]);
            add(scene, "pond.geojson", 0.25, None);
        }),
        ("self-crossing", "initial[1].water", |scene| {
            scene.polygon("pond.geojson", &[(1090.0, 2070.0), (1110.0, 2080.0), (1110.0, 2070.0), (1090.0, 2080.0)]);
            add(scene, "pond.geojson", 0.25, None);
        }),
        ("outside-terrain", "initial[1].river", |scene| {
            scene.line("river.geojson", &[(9101.0, 2077.5), (9199.0, 2077.5)]);
            add(scene, "river.geojson", 0.75, Some(RiverWidth::Cell));
        }),
        ("no-width", "initial[1].river", |scene| {
            scene.line("river.geojson", &[(1101.0, 2077.5), (1199.0, 2077.5)]);
            add(scene, "river.geojson", 0.75, Some(RiverWidth::Field("w".to_owned())));
        }),
        ("no-lines", "initial[1].river", |scene| {
            scene.polygon("river.geojson", &[(1090.0, 2070.0), (1110.0, 2070.0), (1110.0, 2080.0)]);
            add(scene, "river.geojson", 0.75, Some(RiverWidth::Cell));
        }),
        ("method-combination", "initial[1].river", |scene| {
            scene.line("river.geojson", &[(1101.0, 2077.5), (1199.0, 2077.5)]);
            add(scene, "river.geojson", 0.75, Some(RiverWidth::Cell));
            scene.scenario.numerics.formulation = Formulation::Variational;
            scene.scenario.numerics.seeding = Seeding::EqualVolume;
        }),
        ("missing-file", "initial[0].fields", |scene| {
            let fields = sourced("initial[0].fields", scene.path("fields.nc"));
            scene.scenario.start.earlier = Some(EarlierRun { fields, time: None });
        }),
        ("not-a-fields-file", "initial[0].fields", |scene| {
            scene.write("fields.nc", "This is a letter to the surveyor.");
            let fields = sourced("initial[0].fields", scene.path("fields.nc"));
            scene.scenario.start.earlier = Some(EarlierRun { fields, time: None });
        }),
    ];
    for (code, key, change) in unfit {
        let mut scene = Scene::sound();
        change(&mut scene);
        let prepared = prepare(&scene.scenario);
        let errors: Vec<_> = prepared.problems.iter().filter(|p| p.severity == Severity::Error).collect();
        assert_eq!(errors.len(), 1, "{code}: {:#?}", prepared.problems);
        assert_eq!((errors[0].code, errors[0].key.as_str()), (code, key), "{}", errors[0]);
        assert!(errors[0].remedy.is_some());
    }
}

/// How much water an earlier run had in the basin (m).
const DEPTH: f32 = 2.0;

/// What an earlier run wrote on a cell with a bed: still water in the basin, and the rest dry.
fn as_written(name: &str, column: usize, row: usize) -> f32 {
    let bed = basin_elevation(centre_of(column, row)) as f32;
    match name {
        "depth" if bed == 0.0 => DEPTH,
        "water_level" => {
            if bed == 0.0 {
                bed + DEPTH
            } else {
                FILL
            }
        }
        _ => 0.0,
    }
}

/// Goes on from a made file with two frames, at 0 s and 10 s, and the times given.
fn go_on(scene: &mut Scene, file: &str, times: &[f64], value: impl Fn(&str, usize, usize) -> f32) {
    let path = scene.path(file);
    let mut made = netcdf::create(&path).unwrap();
    made.add_unlimited_dimension("time").unwrap();
    let cells = (0..30).flat_map(|row| (0..40).map(move |column| (column, row)));
    let axes = [
        ("y", (0..30).map(|row| centre_of(0, row).y).collect::<Vec<f64>>()),
        ("x", (0..40).map(|column| centre_of(column, 0).x).collect()),
    ];
    for (name, values) in axes {
        made.add_dimension(name, values.len()).unwrap();
        made.add_variable::<f64>(name, &[name]).unwrap().put_values(&values, ..).unwrap();
    }
    made.add_variable::<f64>("time", &["time"]).unwrap().put_values(times, ..times.len()).unwrap();
    for name in ["depth", "water_level", "velocity_x", "velocity_y"] {
        let values: Vec<f32> = cells.clone().map(|(column, row)| value(name, column, row)).collect();
        let mut variable = made.add_variable::<f32>(name, &["time", "y", "x"]).unwrap();
        variable.set_fill_value(FILL).unwrap();
        for frame in 0..2 {
            variable.put_values(&values, (frame, .., ..)).unwrap();
        }
    }
    made.close().unwrap();
    scene.scenario.initial.clear();
    scene.scenario.start.earlier = Some(EarlierRun { fields: sourced("initial[0].fields", path), time: None });
}

/// Asserts that the preparation has this one problem, an error at the key of the file with cause and remedy.
#[track_caller]
fn assert_refused(scene: &Scene, code: &str) -> Problem {
    let problems = prepare(&scene.scenario).problems;
    assert_eq!(problems.len(), 1, "{code}: {problems:#?}");
    let problem = problems.into_iter().next().unwrap();
    assert_eq!((problem.severity, problem.code, problem.key.as_str()), (Severity::Error, code, "initial[0].fields"));
    assert!(problem.cause.is_some() && problem.remedy.is_some(), "{problem}");
    problem
}

#[test]
fn a_frame_that_is_not_whole_is_refused() {
    let mut scene = Scene::sound();
    go_on(&mut scene, "fields.nc", &[0.0, 10.0], as_written);
    let prepared = prepare(&scene.scenario);
    assert_eq!(prepared.problems, []);
    assert_eq!((cells_of(&prepared, f64::from(DEPTH)), prepared.setup().initial_velocity.len()), (100, 1200));

    go_on(&mut scene, "fields.nc", &[0.0, 10.0, 20.0], as_written);
    let problem = assert_refused(&scene, "incomplete-frame");
    assert!(problem.message.contains("frame 3") && problem.message.contains("1200 cells"), "{problem}");
    go_on(&mut scene, "fields.nc", &[0.0, 9.969_209_968_386_869e36], as_written);
    assert_refused(&scene, "incomplete-frame");
    for (name, value) in [("depth", FILL), ("depth", f32::NAN), ("velocity_x", FILL), ("velocity_y", f32::NAN)] {
        let holed = |own: &str, column: usize, row: usize| {
            if own == name && column < 10 && row == 4 { value } else { as_written(own, column, row) }
        };
        go_on(&mut scene, "fields.nc", &[0.0, 10.0], holed);
        let problem = assert_refused(&scene, "incomplete-frame");
        assert!(problem.message.contains("10 cells"), "{problem}");
        assert_eq!(problem.at, Some(centre_of(0, 4)));
    }
    let dry = |name: &str, column, row| if name == "depth" { 0.0 } else { as_written(name, column, row) };
    go_on(&mut scene, "fields.nc", &[0.0, 10.0], dry);
    assert_refused(&scene, "no-water");
    go_on(&mut scene, "fields.partial.nc", &[0.0, 10.0], as_written);
    assert_refused(&scene, "unfinished-run");
}

#[test]
fn values_that_no_water_has_are_damage() {
    let mut scene = Scene::sound();
    for (name, value) in [("depth", 1e6), ("velocity_x", -2e4), ("velocity_y", f32::INFINITY)] {
        let damaged = |own: &str, column: usize, row: usize| {
            if own == name && (column, row) == (14, 14) { value } else { as_written(own, column, row) }
        };
        go_on(&mut scene, "fields.nc", &[0.0, 10.0], damaged);
        assert_refused(&scene, "not-a-fields-file");
    }
}

#[test]
fn water_in_channels_is_not_lost() {
    let mut scene = Scene::sound();
    go_on(&mut scene, "fields.nc", &[0.0, 10.0], as_written);
    std::fs::create_dir(scene.path("tables")).unwrap();
    scene.write("tables/channels.csv", "id,time_s\n");
    let problem = assert_refused(&scene, "channels-of-earlier-run");
    assert!(problem.message.contains("is of a run with channels"), "{problem}");
    std::fs::remove_file(scene.path("tables/channels.csv")).unwrap();
    scene.scenario.channels.push(Channel {
        id: sourced("channels[0].id", "reach".to_owned()),
        length: sourced("channels[0].length", 800.0),
        shape: ChannelShape::Rectangle { width: 12.0, bed: 20.0, slope: 0.002 },
        manning: None,
        walls: ChannelWalls::default(),
        water: Vec::new(),
        joins: None,
        upstream: None,
        downstream: None,
        line: None,
        gauges: Vec::new(),
    });
    let prepared = prepare(&scene.scenario);
    let problem = prepared.problems.iter().find(|problem| problem.code == "channels-of-earlier-run").unwrap();
    assert_eq!((problem.severity, problem.key.as_str()), (Severity::Error, "initial[0].fields"));
}

#[test]
fn the_remedy_for_water_in_the_dam_keeps_a_dam() {
    let mut scene = Scene::sound();
    go_on(&mut scene, "fields.nc", &[0.0, 10.0], as_written);
    scene.line("dam.geojson", &[(1077.5, 2041.0), (1077.5, 2109.0)]);
    scene.scenario.breach = Some(Breach {
        dam: vector("breach.dam", scene.path("dam.geojson")),
        crest: Some(sourced("breach.crest", 10.0)),
        crest_field: None,
        trigger: BreachTrigger::At(sourced("breach.trigger.at", 1.0)),
        shape: None,
        law: GrowthLaw::Instantaneous,
        duration: None,
        share: None,
        method: None,
    });
    let prepared = prepare(&scene.scenario);
    let problem = prepared.problems.iter().find(|problem| problem.code == "water-in-dam").unwrap();
    let remedy = problem.remedy.as_deref().unwrap();
    assert!(remedy.contains("`mode: raise`") && remedy.contains("from its start"), "{remedy}");
    assert!(!remedy.contains("take `breach` out"), "{remedy}");
}

#[test]
fn what_this_scenario_changes_under_the_water_of_the_earlier_run_is_not_undone() {
    let mut scene = Scene::sound();
    // A levee across the basin: ten cells of it that the earlier run had under water, without a levee.
    scene.line("line.geojson", &[(1077.5, 2041.0), (1077.5, 2109.0)]);
    let levee = Breakline {
        lines: vector("terrain.breaklines[0].lines", scene.path("line.geojson")),
        mode: BreaklineMode::Raise,
        level: LineLevel::Constant(sourced("terrain.breaklines[0].z", 1.5)),
        width: None,
    };
    scene.scenario.ground.breaklines = vec![levee];
    go_on(&mut scene, "fields.nc", &[0.0, 10.0], as_written);
    let problem = assert_refused(&scene, "change-under-water");
    assert!(problem.message.contains("10 cells") && problem.message.contains("-1.500 m"), "{problem}");
    // The earlier run had it too.
    let overtopped = |name: &str, column: usize, row: usize| {
        let value = as_written(name, column, row);
        if name == "depth" && column == 15 && value > 0.0 { value - 1.5 } else { value }
    };
    go_on(&mut scene, "fields.nc", &[0.0, 10.0], overtopped);
    assert_eq!(prepare(&scene.scenario).problems, []);

    scene.scenario.ground.breaklines.clear();
    let raised = |rise: f32, columns: std::ops::Range<usize>| {
        move |name: &str, column: usize, row: usize| {
            let value = as_written(name, column, row);
            if name == "water_level" && value != FILL && columns.contains(&column) { value + rise } else { value }
        }
    };
    go_on(&mut scene, "fields.nc", &[0.0, 10.0], raised(0.3, 0..40));
    let problem = assert_refused(&scene, "other-terrain");
    assert!(problem.message.contains("0.300 m (median of 100 cells)"), "{problem}");
    // A few cells are a shore that was fitted.
    go_on(&mut scene, "fields.nc", &[0.0, 10.0], raised(0.3, 10..12));
    let prepared = prepare(&scene.scenario);
    assert_eq!(prepared.problems.len(), 1, "{:#?}", prepared.problems);
    let warning = &prepared.problems[0];
    assert_eq!((warning.severity, warning.code), (Severity::Warning, "bed-of-earlier-run"));
    assert!(warning.remedy.is_some() && warning.message.contains("20 wet cells"), "{warning}");
}
