//! Still water of whole scenarios: its volume, its leaks, and whether it stays at rest.

use std::path::{Path, PathBuf};

use super::malpasset;
use super::scene::{flow_problem, raster_layer, sourced, vector};
use crate::prepare::{Prepared, prepare};
use crate::scenario::methods::BedMethod;
use crate::scenario::{Scenario, load};
use crate::seeding::SeededVolume;
use crate::solver::{EulerianMethods, EulerianSolver, FlowSolver};

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn shipped(name: &str) -> Scenario {
    load(&repository(&format!("scenarios/{name}/scenario.yaml")), &[]).unwrap().scenario
}

fn volumes(prepared: &Prepared) -> &[SeededVolume] {
    assert!(!prepared.has_errors(), "{:#?}", prepared.problems);
    let volumes = &prepared.setup().still_water.volumes;
    for (water, balance) in prepared.scene().waters.iter().zip(volumes) {
        println!("{}: {:+.4} %, {balance:?}", water.key, 100.0 * balance.relative_error());
    }
    volumes
}

/// The greatest speed (m/s) in some steps of Eulerian particles.
fn greatest_speed(scenario: &Scenario, prepared: Prepared, steps: usize) -> f64 {
    let mut solver = EulerianSolver::with_methods(
        flow_problem(scenario, prepared),
        EulerianMethods { sleeps: false, ..Default::default() },
    );
    let mut greatest = 0.0_f64;
    for _ in 0..steps {
        let choice = solver.choose_step();
        greatest = greatest.max(choice.max_speed);
        solver.advance(choice.time_step).unwrap();
    }
    greatest = greatest.max(solver.choose_step().max_speed);
    println!("{} steps to {:.0} s: {greatest:e} m/s", solver.steps(), solver.time());
    greatest
}

#[test]
fn lake_at_rest_is_exact_and_stays_at_rest() {
    let scenario = shipped("lake_at_rest");
    let prepared = prepare(&scenario);
    let [lake] = volumes(&prepared) else { unreachable!("one body") };
    assert!(lake.is_within_tolerance() && lake.leaks.is_empty());
    assert!(greatest_speed(&scenario, prepared, 1000) < 1e-10);
}

#[test]
fn demonstration_leaks_at_its_dam_alone_and_stays_at_rest_behind_it() {
    let mut scenario = shipped("demo");
    let gone = prepare(&scenario);
    let [lake] = volumes(&gone) else { unreachable!("one body") };
    assert!(lake.is_within_tolerance());
    // The axis of the dam runs along the edges between two columns of cells.
    assert!(lake.leaks.len() == 1 && (lake.leaks[0].position.x - 644_605.0).abs() < 1e-6, "{:?}", lake.leaks);
    scenario.walls = vec![vector("structures.walls[0].lines", repository("data/demo_valley/dam_line.geojson"))];
    scenario.open.clear();
    let standing = prepare(&scenario);
    let [lake] = volumes(&standing) else { unreachable!("one body") };
    assert!(lake.is_within_tolerance() && lake.leaks.is_empty());
    assert!(greatest_speed(&scenario, standing, 300) < 1e-10);
}

#[test]
fn malpasset_with_the_dam_in_place_stays_at_rest_down_to_the_sea() {
    let Some(folder) = malpasset::data() else { return };
    for (resolution, steps) in [(40.0, 1000), (20.0, 300)] {
        let mut scenario = malpasset::local(&folder);
        scenario.resolution.value = resolution;
        scenario.walls = vec![vector("structures.walls[0].lines", folder.join("dam_line.geojson"))];
        let prepared = prepare(&scenario);
        let volumes = volumes(&prepared);
        assert!(volumes.iter().all(|balance| balance.leaks.is_empty()));
        // Half-covered cells of 40 m at the dam, 55 m deep, are filled whole or not at all.
        assert!(resolution > 20.0 || volumes.iter().all(SeededVolume::is_within_tolerance));
        assert!(greatest_speed(&scenario, prepared, steps) < 1e-10);
    }
}

#[test]
fn reservoir_of_malpasset_and_the_sea_hold_their_volumes() {
    let Some(folder) = malpasset::data() else { return };
    for (file, resolution, bed) in [
        ("dem_10m.tif", 10.0, BedMethod::Pointwise),
        ("dem_10m.tif", 10.0, BedMethod::Shepard),
        ("dem_20m.tif", 20.0, BedMethod::Pointwise),
        ("dem_20m.tif", 20.0, BedMethod::Shepard),
    ] {
        let mut scenario = malpasset::local(&folder);
        scenario.layers = vec![sourced("terrain.layers[0].raster", raster_layer(folder.join(file)))];
        scenario.resolution.value = resolution;
        scenario.numerics.bed = bed;
        for is_standing in [false, true] {
            if is_standing {
                scenario.walls = vec![vector("structures.walls[0].lines", folder.join("dam_line.geojson"))];
            }
            let prepared = prepare(&scenario);
            let [reservoir, sea] = volumes(&prepared) else { unreachable!("two bodies") };
            // README of the data: 48.95 million m³ in the 10 m raster.
            assert!((reservoir.integral_m3 / 48.95e6 - 1.0).abs() < 2e-3);
            assert!(reservoir.is_within_tolerance() && sea.is_within_tolerance());
            // The dam line is where the reservoir ends in open water, and the only place.
            assert_eq!((reservoir.leaks.len(), sea.leaks.len()), (usize::from(!is_standing), 0));
        }
    }
}
