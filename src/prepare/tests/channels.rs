//! Channels and boundaries that would bring in nothing, and tables that do not fit their channel.

use super::scene::{Scene, sourced, vector};
use crate::error::{ProblemKind, Severity};
use crate::prepare::{BYTES_OF_PROGRAM, Prepared, prepare};
use crate::scenario::methods::Formulation;
use crate::scenario::{Boundary, BoundaryCondition, BuildingMode, Buildings, OpenBoundary, Side, Timed};
use crate::scenario::{Channel, ChannelShape, ChannelWalls, ChannelWater, Joint};

/// A channel of 100 m by 20 m on a bed at 20 m, which is the plateau, that joins the western edge.
fn channel() -> Channel {
    let joint = Joint { side: Side::West, span: Some((2060.0, 2080.0)) };
    Channel {
        id: sourced("channels[0].id", "upper".to_owned()),
        length: sourced("channels[0].length", 100.0),
        shape: ChannelShape::Rectangle { width: 20.0, bed: 20.0, slope: 0.0 },
        manning: None,
        walls: ChannelWalls::default(),
        water: Vec::new(),
        joins: Some(sourced("channels[0].joins.side", joint)),
        upstream: None,
        downstream: None,
        line: None,
        gauges: Vec::new(),
    }
}

fn discharge() -> BoundaryCondition {
    let discharge = Timed::Constant(sourced("boundaries[0].discharge", 5.0));
    BoundaryCondition::Discharge { discharge, level: None }
}

/// Blocks the cells within a rectangle.
fn block(scene: &mut Scene, (west, south): (f64, f64), (east, north): (f64, f64)) {
    scene.polygon("buildings.geojson", &[(west, south), (east, south), (east, north), (west, north)]);
    let polygons = vector("structures.buildings.polygons", scene.path("buildings.geojson"));
    scene.scenario.ground.buildings = Some(Buildings { polygons, mode: BuildingMode::Block });
}

/// Code and key of what is found of a severity.
fn found(prepared: &Prepared, severity: Severity) -> Vec<(&str, &str)> {
    let of_kind = prepared.problems.iter().filter(|problem| problem.severity == severity);
    assert!(of_kind.clone().all(|problem| problem.remedy.is_some()), "{:#?}", prepared.problems);
    of_kind.map(|problem| (problem.code, problem.key.as_str())).collect()
}

#[test]
fn a_boundary_behind_a_building_opens_nothing() {
    let whole_side = ((1000.0, 2000.0), (1005.0, 2150.0));
    for (corners, is_refused) in [(whole_side, true), (((1000.0, 2000.0), (1005.0, 2100.0)), false)] {
        let mut scene = Scene::sound();
        block(&mut scene, corners.0, corners.1);
        let place = OpenBoundary::Side(Side::West);
        scene.scenario.boundaries = vec![sourced("boundaries[0]", Boundary { place, condition: discharge() })];
        let expected: &[(&str, &str)] = if is_refused { &[("opens-nothing", "boundaries[0]")] } else { &[] };
        assert_eq!(found(&prepare(&scene.scenario), Severity::Error), expected, "{corners:?}");
    }
    let mut scene = Scene::sound();
    block(&mut scene, (1000.0, 2030.0), (1005.0, 2120.0));
    scene.line("inflow.geojson", &[(1000.0, 2060.0), (1000.0, 2090.0)]);
    let place = OpenBoundary::Lines(vector("boundaries[0].line", scene.path("inflow.geojson")));
    scene.scenario.boundaries = vec![sourced("boundaries[0]", Boundary { place, condition: discharge() })];
    assert_eq!(found(&prepare(&scene.scenario), Severity::Error), [("opens-nothing", "boundaries[0]")]);
}

#[test]
fn a_channel_comes_out_behind_no_building() {
    for (south, north, expected) in
        [(2060.0, 2080.0, Some("opens-nothing")), (2070.0, 2080.0, Some("channel-width")), (2090.0, 2100.0, None)]
    {
        let mut scene = Scene::sound();
        block(&mut scene, (1000.0, south), (1010.0, north));
        scene.scenario.channels = vec![channel()];
        let expected: Vec<(&str, &str)> = expected.into_iter().map(|code| (code, "channels[0].joins.side")).collect();
        assert_eq!(found(&prepare(&scene.scenario), Severity::Error), expected, "{south} to {north}");
    }
}

#[test]
fn water_that_wets_nothing_is_refused_and_what_dries_is_not() {
    let water =
        |level: Option<f64>, depth: Option<f64>, from: f64, to: Option<f64>| ChannelWater { level, depth, from, to };
    for (water, expected) in [
        (water(Some(3.0), None, 0.0, None), Some("level-below-bed")),
        (water(Some(20.0), None, 0.0, None), Some("level-below-bed")),
        (water(Some(20.5), None, 100.5, None), Some("water-outside")),
        (water(None, Some(1.0), 50.0, Some(40.0)), Some("water-outside")),
        (water(None, Some(1.0), 50.0, Some(52.0)), Some("water-outside")),
        (water(None, Some(0.0), 50.0, None), None),
        (water(Some(20.5), None, 50.0, Some(53.0)), None),
    ] {
        let mut scene = Scene::sound();
        let mut channel = channel();
        channel.water = vec![sourced("channels[0].water[0].level", water.clone())];
        scene.scenario.channels = vec![channel];
        let expected: Vec<(&str, &str)> =
            expected.into_iter().map(|code| (code, "channels[0].water[0].level")).collect();
        assert_eq!(found(&prepare(&scene.scenario), Severity::Error), expected, "{water:?}");
    }
}

#[test]
fn a_channel_of_too_many_particles_is_refused_before_it_is_built() {
    let mut scene = Scene::sound();
    scene.scenario.channels = vec![Channel { length: sourced("channels[0].length", 1e12), ..channel() }];
    let prepared = prepare(&scene.scenario);
    assert_eq!(found(&prepared, Severity::Error), [("particle-limit", "channels[0].length")]);
    assert_eq!(prepared.problems[0].kind, ProblemKind::Limit);
    // 1200 cells and 20 particles of 17 strips, once and twice.
    let table = "distance_m,elevation_m,width_m\n0,20,20\n0,21,20\n100,20,20\n100,21,20\n";
    scene.write("x.csv", table);
    let shape = ChannelShape::Sections(sourced("channels[0].sections", scene.path("x.csv")));
    let first = Channel { shape: shape.clone(), ..channel() };
    let second = Channel { id: sourced("channels[1].id", "lower".to_owned()), shape, joins: None, ..channel() };
    scene.scenario.channels = vec![first, Channel { length: sourced("channels[1].length", 100.0), ..second }];
    for (limit, expected) in [(1200.0, None), (679.0, Some(("particle-limit", "channels[1].length")))] {
        scene.scenario.limits.particles = limit;
        let of_channels: Vec<(&str, &str)> = expected.into_iter().collect();
        let prepared = prepare(&scene.scenario);
        let errors = found(&prepared, Severity::Error).into_iter().filter(|(_, key)| key.starts_with("channels"));
        assert_eq!(errors.collect::<Vec<_>>(), of_channels, "{limit}");
    }
}

#[test]
fn sections_beyond_the_channel_are_warned_of() {
    for (last, is_beyond) in [(100.0, false), (105.0, false), (105.1, true), (400.0, true)] {
        let mut scene = Scene::sound();
        scene.write("x.csv", &format!("distance_m,elevation_m,width_m\n0,20,20\n{last},20,20\n"));
        let shape = ChannelShape::Sections(sourced("channels[0].sections", scene.path("x.csv")));
        scene.scenario.channels = vec![Channel { shape, ..channel() }];
        let prepared = prepare(&scene.scenario);
        let expected: &[(&str, &str)] = if is_beyond { &[("sections-beyond", "channels[0].sections")] } else { &[] };
        assert_eq!(found(&prepared, Severity::Error), []);
        assert_eq!(found(&prepared, Severity::Warning), expected, "{last}: {:#?}", prepared.problems);
    }
}

/// A discharge of 5 m³/s at a level (m).
fn inflow(key: &str, level: f64) -> BoundaryCondition {
    let constant = |name: &str, value: f64| Timed::Constant(sourced(&format!("{key}.{name}"), value));
    BoundaryCondition::Discharge { discharge: constant("discharge", 5.0), level: Some(constant("level", level)) }
}

#[test]
fn levels_at_the_ends_of_a_channel_are_above_its_bed() {
    // 5 m³/s on 20 m have a Froude number of 5 at (5/20 / (5·√9.81))^(2/3) = 0.063 m. The far end of the bed is at 20.5 m.
    let stage = |level: f64| BoundaryCondition::Stage(Timed::Constant(sourced("channels[0].up.stage", level)));
    let [refused, fast] = ["level-below-bed", "fast-inflow"];
    for (condition, errors, warnings) in [
        (inflow("channels[0].up", 20.57), vec![], vec![]),
        (inflow("channels[0].up", 20.55), vec![], vec![(fast, "channels[0].up.level")]),
        (inflow("channels[0].up", 20.5), vec![(refused, "channels[0].up.level")], vec![]),
        (inflow("channels[0].up", 0.5), vec![(refused, "channels[0].up.level")], vec![]),
        (stage(20.6), vec![], vec![]),
        (stage(20.4), vec![(refused, "channels[0].up.stage")], vec![]),
    ] {
        let mut scene = Scene::sound();
        let shape = ChannelShape::Rectangle { width: 20.0, bed: 20.0, slope: 0.005 };
        scene.scenario.channels = vec![Channel { shape, upstream: Some(condition.clone()), ..channel() }];
        let prepared = prepare(&scene.scenario);
        assert_eq!(found(&prepared, Severity::Error), errors, "{condition:?}");
        assert_eq!(found(&prepared, Severity::Warning), warnings, "{condition:?}");
    }
    // The bed of the last particle, which is higher than that of the end, counts where the bed falls outwards.
    let shape = ChannelShape::Rectangle { width: 20.0, bed: 20.0, slope: -0.1 };
    for (level, errors) in [(10.2, vec![(refused, "channels[0].up.level")]), (10.5, vec![])] {
        let mut scene = Scene::sound();
        let upstream = Some(inflow("channels[0].up", level));
        scene.scenario.channels = vec![Channel { shape: shape.clone(), upstream, ..channel() }];
        assert_eq!(found(&prepare(&scene.scenario), Severity::Error), errors, "{level}");
    }
}

#[test]
fn the_level_beside_the_discharge_of_a_boundary_is_above_its_ground() {
    for (level, errors, warnings) in [
        (19.0, vec![("boundary-dry", "boundaries[0]")], vec![]),
        (20.001, vec![], vec![("fast-inflow", "boundaries[0].level")]),
        (20.5, vec![], vec![]),
    ] {
        let mut scene = Scene::sound();
        let place = OpenBoundary::Side(Side::West);
        let boundary = Boundary { place, condition: inflow("boundaries[0]", level) };
        scene.scenario.boundaries = vec![sourced("boundaries[0]", boundary)];
        let prepared = prepare(&scene.scenario);
        assert_eq!(found(&prepared, Severity::Error), errors, "{level}");
        assert_eq!(found(&prepared, Severity::Warning), warnings, "{level}");
    }
}

#[test]
fn the_line_of_a_channel_ends_where_it_joins() {
    // The opening is at x = 1000 from y = 2060 to 2080, the channel 100 m long.
    let key = "channels[0].line";
    for (line, errors, warnings) in [
        ([(900.0, 2070.0), (1000.0, 2070.0)], vec![], vec![]),
        ([(900.0, 2000.0), (1000.0, 2056.0)], vec![], vec![("line-length", key)]),
        ([(1000.0, 2070.0), (900.0, 2070.0)], vec![("line-reversed", key)], vec![]),
        ([(880.0, 2070.0), (980.0, 2070.0)], vec![], vec![("line-beside-opening", key)]),
        ([(-5000.0, 2070.0), (-4900.0, 2070.0)], vec![("line-beside-opening", key)], vec![]),
        ([(900.0, 2070.0), (900.0, 2070.0)], vec![("line-length", key)], vec![]),
        ([(0.0, 2070.0), (9e8, 2070.0)], vec![("line-length", key)], vec![]),
        // No places on Earth: refused where the file is read.
        ([(0.0, 2070.0), (1e300, 2070.0)], vec![("not-a-place", key)], vec![]),
        ([(1e15, 0.0), (1e15, 100.0)], vec![("not-a-place", key)], vec![]),
    ] {
        let mut scene = Scene::sound();
        scene.line("axis.geojson", &line);
        let axis = Some(vector(key, scene.path("axis.geojson")));
        scene.scenario.channels = vec![Channel { line: axis, ..channel() }];
        let prepared = prepare(&scene.scenario);
        assert_eq!(found(&prepared, Severity::Error), errors, "{line:?}");
        assert_eq!(found(&prepared, Severity::Warning), warnings, "{line:?}");
    }
}

/// The scene without its terrain and all that needs it, with one channel of 20 m in particles of 5 cm.
fn flume() -> Scene {
    let mut scene = Scene::sound();
    scene.scenario.layers.clear();
    scene.scenario.initial.clear();
    scene.scenario.outputs.gauges = None;
    scene.scenario.resolution.value = 0.05;
    scene.scenario.channels = vec![Channel { length: sourced("channels[0].length", 20.0), joins: None, ..channel() }];
    scene
}

#[test]
fn the_limit_of_memory_counts_channels_and_moving_particles() {
    // 400 particles of one strip, in 400 bytes each.
    for (memory, expected) in [(160_000.0, vec![]), (159_999.0, vec![("memory-limit", "resolution")])] {
        let mut scene = flume();
        scene.scenario.limits.memory = BYTES_OF_PROGRAM + memory;
        let prepared = prepare(&scene.scenario);
        assert_eq!(found(&prepared, Severity::Error), expected);
        let reported = |text: &str| prepared.problems.iter().any(|problem| problem.message.contains(text));
        assert!(
            expected.is_empty() || reported("about 85.2 MB of memory; the limit is 85.2 MB"),
            "{:?}",
            prepared.problems
        );
    }
    // 1200 cells in 400 bytes each, and 100 particles in 300.
    for (memory, is_refused) in [(510_000.0, false), (509_999.0, true)] {
        let mut scene = Scene::sound();
        scene.scenario.numerics.formulation = Formulation::Variational;
        scene.scenario.outputs.gauges = None;
        scene.scenario.limits.memory = BYTES_OF_PROGRAM + memory;
        assert_eq!(!found(&prepare(&scene.scenario), Severity::Error).is_empty(), is_refused);
    }
}

#[test]
fn water_beyond_a_channel_is_told_in_plain_numbers() {
    let water = |from: f64, to: f64| {
        let water = ChannelWater { level: None, depth: Some(1.0), from, to: Some(to) };
        vec![sourced("channels[0].water[0].depth", water)]
    };
    for (to, warnings) in [(20.0, vec![]), (30.0, vec![("water-beyond", "channels[0].water[0].depth")])] {
        let mut scene = flume();
        scene.scenario.channels[0].water = water(0.0, to);
        let prepared = prepare(&scene.scenario);
        assert_eq!((found(&prepared, Severity::Error), found(&prepared, Severity::Warning)), (vec![], warnings));
    }
    let mut scene = flume();
    scene.scenario.channels[0].water = water(0.0, 0.01);
    let prepared = prepare(&scene.scenario);
    assert_eq!(found(&prepared, Severity::Error), [("water-outside", "channels[0].water[0].depth")]);
    let cause = prepared.problems[0].cause.as_deref().unwrap();
    assert_eq!(cause, "its particles lie from 0.025 m to 19.975 m");
}
