//! Still water at quays that the terrain has in its pixels: no bed is invented at them, and what that adds or takes is reported.

use super::scene::{Scene, Tiff, flow_problem, raster_layer, scenario, sourced};
use crate::bed::{Nothing, place_bed};
use crate::math::Vec2;
use crate::prepare::{Prepared, prepare};
use crate::scenario::methods::BedMethod;
use crate::seeding::SeededVolume;
use crate::solver::{EulerianMethods, EulerianSolver, FlowSolver};
use crate::terrain::{Layer, Raster, Terrain};

/// Pixels of 1 m along a side of the terrain.
const SIDE: usize = 200;
/// The level of the water over its flat floor (m).
const LEVEL: f64 = 3.0;

/// A quay at an angle (degrees) to the lattice, or a canal between two, in pixels of 1 m.
#[derive(Clone, Copy, Debug)]
struct Quay {
    degrees: f64,
    /// Height of its top over the floor (m).
    top: f64,
    /// Half of the width of the canal (m); the water goes on to the edge of the terrain without.
    half_canal: Option<f64>,
}

impl Quay {
    /// Distance (m) from its line, or from the axis of the canal.
    fn across(self, place: Vec2) -> f64 {
        let (sin, cos) = self.degrees.to_radians().sin_cos();
        (place.x - 100.3) * cos + (place.y - 100.2) * sin
    }

    fn height(self, place: Vec2) -> f64 {
        let across = self.across(place);
        let is_land = self.half_canal.map_or(across > 0.0, |half| across.abs() > half);
        if is_land { self.top } else { 0.0 }
    }

    fn pixel(self, column: usize, row: usize) -> f64 {
        self.height(Vec2::new(column as f64 + 0.5, SIDE as f64 - 0.5 - row as f64))
    }

    /// The scenario of its water on cells of a size (m); the polygon ends so many metres (m) beyond its line.
    fn scene(self, spacing: f64, beyond: f64) -> Scene {
        let mut scene = Scene { folder: tempfile::tempdir().unwrap(), scenario: scenario(spacing) };
        let side = SIDE as f64;
        let tiff =
            Tiff { size: (SIDE, SIDE), geo_transform: Some([0.0, 1.0, 0.0, side, 0.0, -1.0]), ..Tiff::default() };
        tiff.write(&scene.path("dem.tif"), |column, row| self.pixel(column, row) as f32);
        scene.scenario.layers = vec![sourced("terrain.layers[0].raster", raster_layer(scene.path("dem.tif")))];
        scene.scenario.numerics.bed = BedMethod::Mean;
        let end = |y: f64| {
            let (sin, cos) = self.degrees.to_radians().sin_cos();
            ((100.3 + (beyond - (y - 100.2) * sin) / cos).clamp(0.0, side), y)
        };
        let rim: Vec<(f64, f64)> = (0..=40).map(|k| end(f64::from(k) * side / 40.0)).collect();
        scene.polygon("water.geojson", &[&[(0.0, side), (0.0, 0.0)], &rim[..]].concat());
        scene.fill("water.geojson", Some(LEVEL));
        scene
    }

    /// The volume over its floor (m³) inside a polygon that ends beyond it.
    fn volume(self) -> f64 {
        let pixels = (0..SIDE * SIDE).filter(|k| self.pixel(k % SIDE, k / SIDE) <= 0.0);
        LEVEL * pixels.count() as f64
    }

    /// Asserts that filling it changes no bed, and that the water stands still.
    fn assert_bed_is_that_of_the_terrain(self, prepared: Prepared, scene: &Scene) -> SeededVolume {
        assert!(!prepared.has_errors(), "{:#?}", prepared.problems);
        let values = (0..SIDE * SIDE).map(|k| self.pixel(k % SIDE, k / SIDE)).collect();
        let raster =
            Raster { columns: SIDE, rows: SIDE, west: 0.0, north: SIDE as f64, cell_x: 1.0, cell_y: 1.0, values };
        let terrain = Terrain::new(vec![Layer::Raster(raster)]).unwrap();
        let bed = &prepared.setup().bed;
        let dry = place_bed(&terrain, &bed.lattice, BedMethod::Mean, &Nothing, 0.03);
        assert_eq!(bed.elevation, dry.elevation, "{self:?}");
        let volume = prepared.setup().still_water.volumes[0].clone();
        let mut solver = EulerianSolver::with_methods(
            flow_problem(&scene.scenario, prepared),
            EulerianMethods { sleeps: false, ..Default::default() },
        );
        for _ in 0..20 {
            let choice = solver.choose_step();
            assert!(choice.max_speed < 1e-12, "{self:?}");
            solver.advance(choice.time_step).unwrap();
        }
        volume
    }
}

fn warnings(prepared: &Prepared) -> usize {
    prepared.problems.iter().filter(|problem| problem.code == "volume-at-banks").count()
}

#[test]
fn no_bed_is_invented_at_a_quay_and_what_that_adds_is_reported() {
    for degrees in [0.0, 20.0, 30.0, 45.0] {
        for (top, spacing, beyond) in [(4.0, 5.0, 30.0), (4.0, 10.0, 0.0), (8.0, 10.0, 30.0), (8.0, 5.0, -2.0)] {
            let quay = Quay { degrees, top, half_canal: None };
            let scene = quay.scene(spacing, beyond);
            let prepared = prepare(&scene.scenario);
            let warned = warnings(&prepared);
            let water = quay.assert_bed_is_that_of_the_terrain(prepared, &scene);
            println!("{quay:?}, cells of {spacing} m, polygon to {beyond} m: {water:?}");
            assert!(water.relative_error().abs() < 1e-9, "{water:?}");
            assert_eq!((water.shore_cells, warned), (0, usize::from(water.share_at_banks().abs() > 0.02)));
            // As the cells have it, the quay runs within half a cell of where it is.
            let along = SIDE as f64 / degrees.to_radians().cos();
            let half_a_cell = LEVEL * along * 0.5 * spacing;
            assert!((water.seeded_m3 - quay.volume()).abs() < half_a_cell, "{quay:?}: {water:?}");
        }
    }
}

#[test]
fn a_canal_between_quays_says_how_much_wider_or_narrower_its_cells_are() {
    for (degrees, spacing) in [(0.0, 5.0), (20.0, 5.0), (30.0, 10.0), (45.0, 10.0)] {
        let canal = Quay { degrees, top: 6.0, half_canal: Some(21.5) };
        let scene = canal.scene(spacing, 300.0);
        let prepared = prepare(&scene.scenario);
        let warned = warnings(&prepared);
        let water = canal.assert_bed_is_that_of_the_terrain(prepared, &scene);
        println!("{canal:?}, cells of {spacing} m: {water:?}");
        let differs = water.seeded_m3 - canal.volume();
        // The integral meets the pixels to a thirtieth: its scan lines are an eighth of a cell apart.
        assert!((water.at_banks_m3 - differs).abs() < 0.035 * canal.volume(), "{water:?}, {differs} m³");
        assert_eq!(warned, usize::from(water.share_at_banks().abs() > 0.02), "{water:?}");
    }
}
