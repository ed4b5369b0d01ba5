//! A dam across the basin of the scene: its ridge, the lake behind it, and every way in which its breach may not fit.

mod growth;

use super::scene::{Scene, Tiff, basin_elevation, centre_of, sourced, vector};
use crate::error::{Problem, Severity};
use crate::prepare::{Prepared, prepare};
use crate::scenario::{
    Boundary, BoundaryCondition, Breach, BreachFormula, BreachMethod, BreachMode, BreachShape, BreachTrigger,
    Breakline, BreaklineMode, ColumnUnit, GrowthLaw, LineLevel, OpenBoundary, Side, TableFile, Timed,
};
use crate::solver::Opening;

const CREST: f64 = 10.0;

/// A dam across the middle of the basin, which reaches into the plateau on both sides, and a lake at 8 m behind it.
fn dam() -> Scene {
    let mut scene = Scene::sound();
    scene.line("dam.geojson", &[(1077.5, 2041.0), (1077.5, 2109.0)]);
    scene.polygon("reservoir.geojson", &[(1045.0, 2045.0), (1080.0, 2045.0), (1080.0, 2105.0), (1045.0, 2105.0)]);
    scene.scenario.initial[0].level = Some(sourced("initial[0].level", 8.0));
    scene.scenario.breach = Some(Breach {
        dam: vector("breach.dam", scene.path("dam.geojson")),
        crest: Some(sourced("breach.crest", CREST)),
        crest_field: None,
        trigger: BreachTrigger::At(sourced("breach.trigger.at", 0.0)),
        shape: Some(BreachShape {
            bottom_width: sourced("breach.shape.bottom_width", 20.0),
            side_slope: 0.5,
            invert: sourced("breach.shape.invert", 2.0),
            position: None,
        }),
        law: GrowthLaw::Linear,
        duration: Some(sourced("breach.growth.duration", 5.0)),
        share: None,
        method: None,
    });
    scene
}

fn prepared(change: impl FnOnce(&Scene, &mut Breach)) -> Prepared {
    let mut scene = dam();
    let mut breach = scene.scenario.breach.take().unwrap();
    change(&scene, &mut breach);
    scene.scenario.breach = Some(breach);
    prepare(&scene.scenario)
}

#[test]
fn the_dam_stands_on_the_lattice_and_holds_the_lake() {
    let prepared = prepared(|_, _| {});
    assert_eq!(prepared.problems, []);
    let (bed, water) = (&prepared.setup().bed, &prepared.setup().still_water);
    let breach = prepared.scene().forcing.breach.clone().unwrap();
    assert_eq!(breach.cells.len(), 14);
    for cell in &breach.cells {
        let expected = if cell.ground < CREST { CREST } else { cell.ground };
        assert_eq!(bed.elevation[cell.cell].to_bits(), expected.to_bits());
        assert!(water.depth[cell.cell].abs() <= 0.0, "the dam is dry, although the polygon covers it");
    }
    assert_eq!(breach.cells.iter().filter(|cell| cell.ground < CREST).count(), 10);
    let wet: Vec<usize> = (0..water.depth.len()).filter(|&cell| water.depth[cell] > 0.0).collect();
    assert_eq!(wet.len(), 50);
    for &cell in &wet {
        assert!(bed.lattice.centre(cell).x < 75.0, "{:?}", bed.lattice.centre(cell));
        assert!((bed.elevation[cell] + water.depth[cell] - 8.0).abs() < 1e-12);
    }
    let Opening::Trapezoid { middle, .. } = breach.opening else { panic!("no trapezoid") };
    assert!((middle - 34.0).abs() < 1e-9);
    assert!(prepared.inputs.iter().any(|input| input.path.ends_with("dam.geojson")));
}

/// The ends, south to north where it is true, of the line through which the flood of a dam is measured, however the dam was drawn.
fn measured_northwards(change: impl Fn(&mut Scene)) -> bool {
    let northwards = [[2041.0, 2109.0], [2109.0, 2041.0]].map(|[from, to]| {
        let mut scene = dam();
        scene.line("dam.geojson", &[(1077.5, from), (1077.5, to)]);
        change(&mut scene);
        let line = prepare(&scene.scenario).scene().sections.last().cloned().unwrap().line;
        line[0].y < line[1].y
    });
    assert_eq!(northwards[0], northwards[1], "it depends on how the dam was drawn");
    northwards[0]
}

#[test]
fn what_leaves_the_lake_counts_as_positive_whatever_lies_beside_the_dam_at_the_start() {
    // The left side, towards which water is counted, is west of a line that runs north.
    assert!(!measured_northwards(|_| {}), "the lake is in the west");
    for (x, counts_west) in [(1060.0, false), (1095.0, true)] {
        let empty = |scene: &mut Scene| {
            scene.scenario.initial.clear();
            let level = sourced("breach.trigger.level", 8.0);
            let place = sourced("breach.trigger.at_point", [x, 2075.0]);
            scene.scenario.breach.as_mut().unwrap().trigger = BreachTrigger::Level { level, place };
        };
        assert_eq!(measured_northwards(empty), counts_west, "a lake that fills around {x}");
    }
    // The floor lies 3 m lower in the west: water is deeper there and stands lower.
    let deep = |scene: &mut Scene| {
        Tiff { no_data: Some(-9999.0), ..Tiff::default() }.write(&scene.path("dem.tif"), |column, row| {
            let place = centre_of(column, row);
            (basin_elevation(place) - if place.x < 1075.0 && basin_elevation(place) <= 0.0 { 3.0 } else { 0.0 }) as f32
        });
    };
    let tailwater = |scene: &mut Scene| {
        deep(scene);
        scene.scenario.initial[0].level = Some(sourced("initial[0].level", 4.5));
        scene.polygon("tail.geojson", &[(1080.0, 2050.0), (1100.0, 2050.0), (1100.0, 2100.0), (1080.0, 2100.0)]);
        scene.fill("tail.geojson", Some(5.0));
    };
    assert!(measured_northwards(tailwater), "the higher water is in the east");
    let dry = |scene: &mut Scene| {
        deep(scene);
        scene.scenario.initial.clear();
    };
    assert!(measured_northwards(dry), "the ground falls to the west");
}

#[test]
fn water_finds_its_way_through_the_narrowest_opening_of_a_dam_askew_to_the_lattice() {
    for share in [0.42, 0.44, 0.46, 0.48, 0.5, 0.52, 0.54, 0.56] {
        let mut scene = dam();
        scene.line("dam.geojson", &[(1060.0, 2041.0), (1095.0, 2109.0)]);
        let shape = scene.scenario.breach.as_mut().unwrap().shape.as_mut().unwrap();
        shape.bottom_width.value = 0.5;
        shape.position = Some(sourced("breach.shape.position", [1060.0 + 35.0 * share, 2041.0 + 68.0 * share]));
        shape.side_slope = 0.0;
        let prepared = prepare(&scene.scenario);
        let codes: Vec<&str> = prepared.problems.iter().map(|problem| problem.code).collect();
        assert!(!codes.contains(&"opening-blocked") && codes.contains(&"breach-coarse"), "{share}: {codes:?}");
    }
}

#[test]
fn without_a_shape_the_whole_dam_goes() {
    let prepared = prepared(|_, breach| breach.shape = None);
    assert_eq!(prepared.problems, []);
    let breach = prepared.scene().forcing.breach.clone().unwrap();
    assert_eq!(breach.opening, Opening::Whole);
    assert!(breach.cells.iter().all(|cell| breach.bed(cell, 1.0).to_bits() == cell.ground.to_bits()));
}

/// `Froehlich2008` for piping down to 2 m, of a volume of water (m³).
fn by_formula(volume: f64) -> BreachMethod {
    BreachMethod {
        formula: BreachFormula::Froehlich2008,
        mode: BreachMode::Piping,
        volume: sourced("breach.method.volume", volume),
        invert: sourced("breach.method.invert", 2.0),
        position: None,
        width_factor: 1.0,
        time_factor: 1.0,
    }
}

#[test]
fn a_formula_gives_width_sides_and_time() {
    let prepared = prepared(|_, breach| {
        (breach.shape, breach.duration) = (None, None);
        breach.method = Some(by_formula(50_000.0));
    });
    let breach = prepared.scene().forcing.breach.clone().unwrap();
    // 0.27 · 50000^0.32 · 8^0.04 = 0.27 · 31.888 · 1.0867 = 9.357 m on average, 0.7 · 8 m less at the bottom;
    // 63.2 √(50000/(9.81 · 64)) = 564.0 s.
    let Opening::Trapezoid { bottom_width, side_slope, invert, .. } = breach.opening else { panic!("no trapezoid") };
    assert!((bottom_width - 3.757).abs() < 2e-3 && (side_slope - 0.7).abs() < 1e-12 && (invert - 2.0).abs() < 1e-12);
    assert!((breach.duration - 564.0).abs() < 0.1, "{}", breach.duration);
}

#[test]
fn factors_of_a_study_multiply_the_formula() {
    let with = |width_factor: f64, time_factor: f64| {
        let prepared = prepared(|_, breach| {
            (breach.shape, breach.duration) = (None, None);
            breach.method = Some(BreachMethod { width_factor, time_factor, ..by_formula(50_000.0) });
        });
        let breach = prepared.scene().forcing.breach.clone().unwrap();
        let Opening::Trapezoid { bottom_width, .. } = breach.opening else { panic!("no trapezoid") };
        // The mean width is that at half the height, with sides of 0.7 to 1.
        (bottom_width + 0.7 * 8.0, breach.duration)
    };
    let (one, other) = (with(1.0, 1.0), with(1.5, 0.5));
    assert!((other.0 / one.0 - 1.5).abs() < 1e-12 && (other.1 / one.1 - 0.5).abs() < 1e-12, "{one:?} {other:?}");
}

/// A change that makes the breach unfit, with the code and the key of what is reported.
type Unfit = (&'static str, &'static str, fn(&Scene, &mut Breach));

fn width(breach: &mut Breach, width: f64) {
    breach.shape.as_mut().unwrap().bottom_width.value = width;
}

fn at_level(level: f64, place: [f64; 2]) -> BreachTrigger {
    BreachTrigger::Level {
        level: sourced("breach.trigger.level", level),
        place: sourced("breach.trigger.at_point", place),
    }
}

#[test]
fn what_does_not_fit_is_refused_at_its_key() {
    let unfit: [Unfit; 14] = [
        ("opening-above-water", "breach.dam", |_, b| b.shape.as_mut().unwrap().invert.value = 9.0),
        ("breach-beyond-dam", "breach.shape.bottom_width", |_, b| {
            b.shape.as_mut().unwrap().position = Some(sourced("breach.shape.position", [1077.5, 2046.0]));
        }),
        ("crest-below-terrain", "breach.crest", |_, b| b.crest.as_mut().unwrap().value = -1.0),
        ("no-crest", "breach.dam", |_, b| b.crest = None),
        ("breach-wider-than-dam", "breach.shape.bottom_width", |_, b| width(b, 61.0)),
        ("breach-without-area", "breach.shape.bottom_width", |_, b| {
            width(b, 0.0);
            b.shape.as_mut().unwrap().side_slope = 0.0;
        }),
        ("invert-below-terrain", "breach.shape.invert", |_, b| b.shape.as_mut().unwrap().invert.value = -0.5),
        ("invert-above-crest", "breach.shape.invert", |_, b| b.shape.as_mut().unwrap().invert.value = 10.0),
        ("position-off-dam", "breach.shape.position", |_, b| {
            b.shape.as_mut().unwrap().position = Some(sourced("breach.shape.position", [1100.0, 2070.0]));
        }),
        ("outside-terrain", "breach.dam", |scene, _| scene.line("dam.geojson", &[(7000.0, 2041.0), (7000.0, 2109.0)])),
        ("dam-lines", "breach.dam", |scene, _| {
            scene.polygon("dam.geojson", &[(1077.5, 2041.0), (1077.5, 2109.0), (1080.0, 2109.0)]);
        }),
        ("trigger-after-end", "breach.trigger.at", |_, b| {
            b.trigger = BreachTrigger::At(sourced("breach.trigger.at", 10.0));
        }),
        ("level-never-reached", "breach.trigger.level", |_, b| b.trigger = at_level(8.1, [1060.0, 2070.0])),
        ("outside-terrain", "breach.trigger.at_point", |_, b| b.trigger = at_level(8.0, [3.0, 2070.0])),
    ];
    for (code, key, change) in unfit {
        let prepared = prepared(change);
        let errors: Vec<_> = prepared.problems.iter().filter(|p| p.severity == Severity::Error).collect();
        assert_eq!(errors.len(), 1, "{code}: {:#?}", prepared.problems);
        assert_eq!((errors[0].code, errors[0].key.as_str()), (code, key), "{}", errors[0]);
        assert!(errors[0].remedy.is_some());
    }
}

/// The problem of a code among those of a scene with a dam.
#[track_caller]
fn reported(code: &str, change: impl FnOnce(&mut Scene)) -> Problem {
    let mut scene = dam();
    change(&mut scene);
    let problems = prepare(&scene.scenario).problems;
    let found = problems.iter().find(|problem| problem.code == code).cloned();
    found.unwrap_or_else(|| panic!("{code}: {problems:#?}"))
}

#[test]
fn what_stands_in_the_way_of_the_water_is_told() {
    let wall = reported("wall-in-breach", |scene| {
        scene.line("wall.geojson", &[(1077.5, 2041.0), (1077.5, 2109.0)]);
        scene.scenario.walls = vec![vector("structures.walls[0].lines", scene.path("wall.geojson"))];
    });
    assert_eq!((wall.severity, wall.key.as_str()), (Severity::Error, "breach.dam"));
    let bank = reported("opening-blocked", |scene| {
        scene.line("bank.geojson", &[(1090.0, 2041.0), (1090.0, 2109.0)]);
        scene.scenario.ground.breaklines = vec![Breakline {
            lines: vector("terrain.breaklines[0].lines", scene.path("bank.geojson")),
            mode: BreaklineMode::Raise,
            level: LineLevel::Constant(sourced("terrain.breaklines[0].z", 9.0)),
            width: None,
        }];
    });
    assert_eq!((bank.severity, bank.key.as_str()), (Severity::Warning, "breach.dam"));
    let volume = reported("breach-volume", |scene| {
        let breach = scene.scenario.breach.as_mut().unwrap();
        (breach.shape, breach.duration) = (None, None);
        breach.method = Some(by_formula(1.0));
    });
    assert_eq!((volume.severity, volume.key.as_str()), (Severity::Warning, "breach.method.volume"));
}

/// Opens the eastern edge, below the dam.
fn open_below(scene: &mut Scene, condition: BoundaryCondition) {
    let place = OpenBoundary::Side(Side::East);
    scene.scenario.boundaries = vec![sourced("boundaries[0]", Boundary { place, condition })];
}

#[test]
fn an_edge_where_water_only_leaves_brings_none_to_the_dam() {
    let slope = || BoundaryCondition::NormalDepth(sourced("boundaries[0].normal_depth.slope", 0.01));
    reported("opening-above-water", |scene| {
        open_below(scene, slope());
        scene.scenario.breach.as_mut().unwrap().shape.as_mut().unwrap().invert.value = 9.0;
    });
    reported("level-never-reached", |scene| {
        open_below(scene, BoundaryCondition::Free);
        scene.scenario.breach.as_mut().unwrap().trigger = at_level(8.1, [1060.0, 2070.0]);
    });
    let mut fed = dam();
    open_below(&mut fed, BoundaryCondition::Stage(Timed::Constant(sourced("boundaries[0].stage", 9.0))));
    fed.scenario.breach.as_mut().unwrap().trigger = at_level(8.1, [1060.0, 2070.0]);
    let problems = prepare(&fed.scenario).problems;
    assert!(problems.iter().all(|problem| problem.code != "level-never-reached"), "{problems:#?}");
}

#[test]
fn water_above_the_crest_is_told_and_a_refused_dam_leaks_without_a_word() {
    let over =
        reported("water-above-crest", |scene| scene.scenario.initial[0].level.as_mut().unwrap().value = CREST + 0.5);
    assert_eq!((over.severity, over.key.as_str()), (Severity::Warning, "breach.dam"));
    assert!(over.at.is_some() && over.message.contains("above its crest"), "{over}");
    let refused = prepared(|_, breach| width(breach, 61.0));
    assert_eq!(refused.problems.iter().map(|problem| problem.code).collect::<Vec<_>>(), ["breach-wider-than-dam"]);
}

#[test]
fn a_dam_that_lies_below_the_ground_on_most_of_its_way_is_told() {
    // 50 m of 150 m cross the basin; the plateau of 20 m lies on both sides of it.
    let part =
        reported("crest-below-terrain", |scene| scene.line("dam.geojson", &[(1077.5, 2005.0), (1077.5, 2145.0)]));
    assert_eq!((part.severity, part.key.as_str()), (Severity::Warning, "breach.crest"));
    let place = part.at.unwrap();
    assert!(part.message.contains("90 m of 140 m of the dam lie below the terrain, by up to 10.00 m"), "{part}");
    assert!((place.x - 1077.5).abs() < 2.5 && !(2050.0..2100.0).contains(&place.y), "{part}");
}

#[test]
fn a_breach_wider_than_the_dam_stands_free_is_refused_with_both_lengths() {
    let widened = |bottom: f64| {
        let mut scene = dam();
        width(scene.scenario.breach.as_mut().unwrap(), bottom);
        prepare(&scene.scenario).problems
    };
    // 50 m of the dam cross the basin; sides of 0.5 to 1 over 8 m make the breach 8 m wider at the crest.
    let problems = widened(48.0 + 1.0 / 3.0);
    assert_eq!(problems.iter().map(|problem| problem.code).collect::<Vec<_>>(), ["breach-wider-than-dam"]);
    let said = "56.3 m wide at the crest, and the dam is 68.0 m long, and stands above the ground over 50.0 m of it";
    assert!(problems[0].severity == Severity::Error && problems[0].message.contains(said), "{}", problems[0]);
    let cause = problems[0].cause.as_deref().unwrap();
    assert!(cause.starts_with("bottom width 48.3333 m, sides 0.5 to 1"), "{cause}");
    assert_eq!(widened(42.0), []);
}

#[test]
fn a_dam_that_is_to_break_far_above_its_crest_is_told() {
    let fed = |scene: &mut Scene, level: f64| {
        open_below(scene, BoundaryCondition::Stage(Timed::Constant(sourced("boundaries[0].stage", 9.0))));
        scene.scenario.breach.as_mut().unwrap().trigger = at_level(level, [1060.0, 2070.0]);
    };
    let above = reported("trigger-above-crest", |scene| fed(scene, CREST + 1.5));
    assert_eq!((above.severity, above.key.as_str()), (Severity::Warning, "breach.trigger.level"));
    assert!(above.message.contains("1.5 m above its crest") && above.at.is_some() && above.remedy.is_some(), "{above}");
    // Water that runs over it for some decimetres breaks a dam.
    let mut overtopped = dam();
    fed(&mut overtopped, CREST + 0.5);
    let problems = prepare(&overtopped.scenario).problems;
    assert!(problems.iter().all(|problem| problem.code != "trigger-above-crest"), "{problems:#?}");
}

#[test]
fn doubtful_breaches_are_warnings() {
    let doubtful: [Unfit; 3] = [
        ("breach-coarse", "breach.shape.bottom_width", |_, b| width(b, 3.0)),
        ("breach-unfinished", "breach.growth.duration", |_, b| b.duration.as_mut().unwrap().value = 11.0),
        ("dam-end-open", "breach.dam", |scene, _| scene.line("dam.geojson", &[(1077.5, 2041.0), (1077.5, 2092.0)])),
    ];
    for (code, key, change) in doubtful {
        let prepared = prepared(change);
        let found = prepared.problems.iter().find(|problem| problem.code == code);
        let found = found.unwrap_or_else(|| panic!("{code}: {:#?}", prepared.problems));
        assert_eq!((found.severity, found.key.as_str()), (Severity::Warning, key));
    }
}
