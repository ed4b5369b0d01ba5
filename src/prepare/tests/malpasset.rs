//! The real data of Malpasset, in its own metres and in Lambert zone II; skipped, and said so, where they are not to be had.

use std::path::{Path, PathBuf};

use super::scene::{raster_layer, scenario, sourced, vector};
use crate::error::Severity;
use crate::math::Vec2;
use crate::output::OutputCrs;
use crate::prepare::{Prepared, prepare};
use crate::scenario::{CrsChoice, InitialWater, OpenBoundary, PointInterpolation, Scenario, TerrainLayer};

/// The folder of the data, by the variable `FLOODSIM_DATA`, or beside the repository.
pub(super) fn data() -> Option<PathBuf> {
    let root = std::env::var_os("FLOODSIM_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data"), PathBuf::from);
    let folder = root.join("malpasset");
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: {} is absent; set FLOODSIM_DATA to the folder of the real data", folder.display());
    None
}

fn water(i: usize, path: PathBuf, level: f64) -> InitialWater {
    let key = format!("initial[{i}]");
    InitialWater {
        polygons: vector(&format!("{key}.reservoir"), path),
        level: Some(sourced(&format!("{key}.level"), level)),
        level_field: None,
    }
}

pub(super) fn local(folder: &Path) -> Scenario {
    let mut scenario = scenario(20.0);
    scenario.layers = vec![sourced("terrain.layers[0].raster", raster_layer(folder.join("dem_20m.tif")))];
    scenario.initial =
        vec![water(0, folder.join("reservoir.geojson"), 100.0), water(1, folder.join("sea.geojson"), 0.0)];
    scenario.outputs.gauges = Some(vector("outputs.gauges", folder.join("gauges.csv")));
    scenario
}

fn assert_sound(prepared: &Prepared) {
    for problem in &prepared.problems {
        println!("{problem}");
    }
    let errors: Vec<_> = prepared.problems.iter().filter(|p| p.severity == Severity::Error).collect();
    assert!(errors.is_empty(), "{errors:#?}");
}

/// Volume below the level (m³), over the cells of the lattice whose centres lie in the polygon.
fn volume(prepared: &Prepared, body: usize) -> f64 {
    use geo::Contains;
    let (terrain, lattice) = (prepared.terrain.as_ref().unwrap(), &prepared.scene().lattice);
    let body = &prepared.scene().waters[body];
    (0..lattice.len())
        .map(|i| lattice.to_map(lattice.centre(i)))
        .filter(|c| body.polygon.contains(&geo::point!(x: c.x, y: c.y)))
        .filter_map(|c| terrain.elevation(c))
        .map(|z| (body.level - z).max(0.0) * lattice.cell_area())
        .sum()
}

#[test]
fn malpasset_in_its_own_metres_is_sound() {
    let Some(folder) = data() else { return };
    let mut scenario = local(&folder);
    scenario.open = vec![OpenBoundary::Lines(vector("boundaries.open[0].lines", folder.join("sea_boundary.geojson")))];
    let prepared = prepare(&scenario);
    assert_sound(&prepared);
    assert_eq!(prepared.scene().gauges.len(), 29);
    // README of the data: 48.95 million m³ in the 10 m raster.
    let volume = volume(&prepared, 0);
    assert!((volume / 48.95e6 - 1.0).abs() < 0.01, "{volume}");
    // The dam is gone: the rim leaks at the gorge, and its lowest place lies far below the level.
    let deepest = prepared.setup().still_water.volumes[0].leaks[0];
    assert!(
        deepest.bed_elevation < 60.0 && (deepest.position - Vec2::new(4680.0, 4250.0)).norm() < 100.0,
        "{deepest:?}"
    );
    // With the dam as a wall the gorge is closed.
    scenario.walls = vec![vector("structures.walls[0].lines", folder.join("dam_line.geojson"))];
    let prepared = prepare(&scenario);
    assert_sound(&prepared);
    let lake = &prepared.setup().still_water.volumes[0];
    assert_eq!(lake.leaks, [], "a lake behind a standing dam stays where it is");
}

#[test]
fn malpasset_in_lambert_coordinates_is_sound_in_every_format() {
    let Some(folder) = data() else { return };
    let lambert = folder.join("epsg27572");
    let reference = volume(&prepare(&local(&folder)), 0);
    for reservoir in ["reservoir.geojson", "reservoir.gpkg", "reservoir.shp"] {
        let mut scenario = scenario(20.0);
        scenario.crs.value = CrsChoice::FromTerrain;
        scenario.layers = vec![sourced("terrain.layers[0].raster", raster_layer(folder.join("dem_20m_epsg27572.tif")))];
        scenario.initial = vec![water(0, lambert.join(reservoir), 100.0), water(1, lambert.join("sea.geojson"), 0.0)];
        scenario.initial[0].level = None; // from the attribute level_m
        scenario.outputs.gauges = Some(vector("outputs.gauges", lambert.join("gauges.geojson")));
        let prepared = prepare(&scenario);
        assert_sound(&prepared);
        assert!(
            matches!(&prepared.scene().crs, OutputCrs::Projected { authority: Some(code), .. } if code == "EPSG:27572")
        );
        assert_eq!((prepared.scene().waters[0].level, prepared.scene().gauges.len()), (100.0, 29));
        // The rasters are the same, turned by a right angle; cell centres on the outline may fall on either side.
        assert!((volume(&prepared, 0) / reference - 1.0).abs() < 1e-4, "{reservoir}");
    }
}

#[test]
fn the_original_survey_makes_the_same_valley_as_the_raster() {
    let Some(folder) = data() else { return };
    let raster = prepare(&local(&folder));
    let raster = raster.terrain.as_ref().unwrap();
    for interpolation in [PointInterpolation::InverseDistance, PointInterpolation::NaturalNeighbour] {
        let mut scenario = local(&folder);
        let layer = TerrainLayer::Points {
            path: folder.join("cadam_points.csv.gz"),
            interpolation,
            max_gap: 300.0,
            offset: 0.0,
            clip: None,
            mode: crate::scenario::LayerMode::default(),
        };
        scenario.layers = vec![sourced("terrain.layers[0].points", layer)];
        let started = std::time::Instant::now();
        let prepared = prepare(&scenario);
        let seconds = started.elapsed().as_secs_f64();
        let gap = prepared.setup().gap.unwrap();
        let (terrain, lattice) = (prepared.terrain.as_ref().unwrap(), &prepared.scene().lattice);
        let mut differences: Vec<f64> = (0..lattice.len())
            .map(|i| lattice.to_map(lattice.centre(i)))
            .filter_map(|place| Some((terrain.elevation(place)? - raster.elevation(place)?).abs()))
            .collect();
        differences.sort_by(f64::total_cmp);
        let median = differences[differences.len() / 2];
        println!("{interpolation:?}: {seconds:.2} s, gap {gap:?}, median difference {median:.3} m");
        for problem in &prepared.problems {
            println!("{problem}");
        }
        assert!(gap.largest <= 300.0 && gap.percentile_95 < gap.largest && gap.percentile_95 > 10.0);
        assert!(differences.len() > 80_000 && median < 0.5, "{} cells, {median} m", differences.len());
        // The transformer A stands in the valley at 38.51 m (gauges.csv).
        assert!((terrain.elevation(Vec2::new(5550.0, 4400.0)).unwrap() - 38.51).abs() < 3.0);
    }
}
