//! Water of the start without a level: which cells get it, and what is refused.

#![expect(clippy::float_cmp, reason = "made values are met exactly")]

use super::scene::{Scene, sourced, vector};
use crate::error::Severity;
use crate::prepare::{Prepared, prepare};
use crate::scenario::methods::{Motion, Seeding};
use crate::scenario::{EarlierRun, RiverWidth, WaterOfDepth};

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
    prepared.still_water.as_ref().unwrap().depth.iter().filter(|own| **own == depth).count()
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
    assert_eq!(prepared.needs.wet_cells, 100 + 22);
    for (width, cells) in [(RiverWidth::Constant(11.0), 60), (RiverWidth::Field("w".to_owned()), 60)] {
        scene.scenario.start.depths[1].river = Some(width);
        let prepared = prepare(&scene.scenario);
        assert_eq!((prepared.problems.len(), cells_of(&prepared, 0.75)), (0, cells));
    }
    assert!(prepared.inputs.iter().any(|input| input.path.ends_with("river.geojson")));
    assert!(prepared.initial_velocity.is_empty());
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
            scene.scenario.numerics.motion = Motion::Lagrangian;
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
