//! Levees that are narrower than a cell, against the same on cells of the size of the pixels: they hold, and are overtopped at their crest.

use super::scene::{Scene, Tiff, flow_problem, raster_layer, scenario, sourced, vector};
use crate::error::Severity;
use crate::math::Vec2;
use crate::prepare::{Prepared, prepare};
use crate::scenario::methods::{BedMethod, Formulation};
use crate::scenario::{Breach, BreachTrigger, GrowthLaw};
use crate::solver::{EulerianSolver, FlowSolver};

/// How long the water runs (s).
const TIME: f64 = 60.0;

/// A levee of 3 m with a crest of 3 m and banks of 1 to 1 at an angle (degrees) across a square terrain of a side (m), in pixels of 1 m.
#[derive(Clone, Copy, Debug)]
struct Levee {
    degrees: f64,
    side: usize,
    gap: Option<Gap>,
}

/// A gap through a levee.
#[derive(Clone, Copy, Debug)]
struct Gap {
    /// From one distance (m) along the crest to another, at its foot.
    along: [f64; 2],
    /// The level (m) of its floor.
    floor: f64,
    /// The slope of its sides, 0 for upright ones (m along the crest for each metre of height).
    sides: f64,
}

impl Gap {
    /// Whether the levee stands at a distance (m) along the crest, and how high.
    fn height(self, along: f64, levee: f64) -> f64 {
        let outside = (self.along[0] - along).max(along - self.along[1]);
        if outside <= 0.0 {
            return self.floor.min(levee);
        }
        if self.sides > 0.0 { (self.floor + outside / self.sides).min(levee) } else { levee }
    }
}

/// What a run leaves behind a levee (m³).
struct Behind {
    /// The lake.
    lake: f64,
    /// In cells that lie beyond the crest altogether.
    beyond: f64,
    /// There, and by their area beyond the crest in the cells that it cuts.
    by_area: f64,
    /// The same at the start.
    at_start: f64,
}

impl Levee {
    /// Distance (m) to the east of the crest.
    fn across(self, place: Vec2) -> f64 {
        let (sin, cos) = self.degrees.to_radians().sin_cos();
        let (x, y) = (place.x - 0.5 * self.side as f64 - 3.3, place.y - 0.5 * self.side as f64);
        x * cos + y * sin
    }

    /// Distance (m) along the crest from the middle of the terrain.
    fn along(self, place: Vec2) -> f64 {
        let (sin, cos) = self.degrees.to_radians().sin_cos();
        let (x, y) = (place.x - 0.5 * self.side as f64 - 3.3, place.y - 0.5 * self.side as f64);
        y * cos - x * sin
    }

    fn height(self, place: Vec2) -> f64 {
        let levee = (3.0 - (self.across(place).abs() - 1.5).max(0.0)).clamp(0.0, 3.0);
        self.gap.map_or(levee, |gap| gap.height(self.along(place), levee))
    }

    /// The scenario of a lake to the west of it at a level (m), on cells of a size (m).
    fn scene(self, level: f64, spacing: f64) -> Scene {
        let folder = tempfile::tempdir().unwrap();
        let mut scene = Scene { folder, scenario: scenario(spacing) };
        let side = self.side as f64;
        let tiff = Tiff {
            size: (self.side, self.side),
            geo_transform: Some([0.0, 1.0, 0.0, side, 0.0, -1.0]),
            ..Tiff::default()
        };
        let centre = |c: usize, r: usize| Vec2::new(c as f64 + 0.5, side - 0.5 - r as f64);
        tiff.write(&scene.path("dem.tif"), |c, r| self.height(centre(c, r)) as f32);
        scene.scenario.layers = vec![sourced("terrain.layers[0].raster", raster_layer(scene.path("dem.tif")))];
        scene.scenario.numerics.bed = BedMethod::Mean;
        // To the line of the crest.
        let end = |y: f64| {
            let (sin, cos) = self.degrees.to_radians().sin_cos();
            // At 45° the crest leaves the terrain beside a corner.
            ((0.5 * side + 3.3 - (y - 0.5 * side) * sin / cos).clamp(0.0, side), y)
        };
        scene.polygon("lake.geojson", &[(0.0, 0.0), end(0.0), end(side), (0.0, side)]);
        scene.fill("lake.geojson", Some(level));
        scene
    }

    /// Lets the water of a level (m) run on cells of a size (m).
    fn run(self, level: f64, spacing: f64) -> Behind {
        self.run_scene(&self.scene(level, spacing), spacing)
    }

    fn run_scene(self, scene: &Scene, spacing: f64) -> Behind {
        let (scenario, prepared) = (&scene.scenario, prepare(&scene.scenario));
        assert!(!prepared.has_errors(), "{:#?}", prepared.problems);
        let lattice = prepared.scene().lattice.clone();
        let mut solver = EulerianSolver::new(flow_problem(scenario, prepared));
        let share = |cell: usize| {
            let pieces = (0..100).map(|k| Vec2::new((k % 10) as f64 - 4.5, (k / 10) as f64 - 4.5) * (0.1 * spacing));
            pieces.filter(|piece| self.across(lattice.centre(cell) + *piece) > 0.0).count() as f64 / 100.0
        };
        let shares: Vec<f64> = (0..lattice.len()).map(share).collect();
        let volume = |depths: Vec<f64>, least: f64| {
            let counted = depths.iter().zip(&shares).filter(|(_, share)| **share >= least);
            counted.map(|(depth, share)| depth * share * lattice.cell_area()).sum::<f64>()
        };
        let (lake, at_start) = (solver.ledger().initial, volume(solver.water().depths(), 0.0));
        while solver.time() < TIME {
            let step = solver.choose_step().time_step.min(TIME - solver.time());
            solver.advance(step).unwrap();
        }
        assert!(solver.ledger().relative_error().abs() < 1e-12);
        let depths = solver.water().depths();
        Behind { lake, beyond: volume(depths.clone(), 1.0), by_area: volume(depths, 0.0), at_start }
    }
}

#[test]
fn an_unbroken_levee_holds_at_any_angle_and_ratio() {
    for degrees in [0.0, 20.0, 45.0] {
        for ratio in [2.5, 5.0, 10.0] {
            let Behind { lake, beyond, by_area, at_start } = Levee { degrees, side: 200, gap: None }.run(2.0, ratio);
            // Water of the lake in cells that the crest cuts is shown on both sides of it, from the start.
            assert!(
                beyond <= 0.0 && (by_area - at_start).abs() < 0.005 * lake,
                "{degrees} degrees, ratio {ratio}: {by_area} m³ of {lake} m³, {at_start} m³ at first"
            );
        }
    }
}

#[test]
fn a_levee_is_overtopped_as_on_cells_of_its_pixels() {
    for degrees in [0.0, 20.0, 45.0] {
        let levee = Levee { degrees, side: 100, gap: None };
        let fine = levee.run(3.6, 1.0).beyond;
        for ratio in [5.0, 10.0] {
            let share = levee.run(3.6, ratio).beyond / fine;
            assert!((share - 1.0).abs() < 0.2, "{degrees} degrees, ratio {ratio}: {share} of {fine} m³");
        }
    }
}

#[test]
fn a_gap_narrower_than_a_cell_passes_as_much_as_on_cells_of_its_pixels() {
    for degrees in [0.0, 20.0, 45.0] {
        for from in [-2.0, 3.0] {
            let gap = Gap { along: [from, from + 4.0], floor: 0.0, sides: 0.0 };
            let levee = Levee { degrees, side: 100, gap: Some(gap) };
            let fine = levee.run(2.0, 1.0).beyond;
            for ratio in [5.0, 10.0] {
                let share = levee.run(2.0, ratio).beyond / fine;
                assert!((share - 1.0).abs() < 0.25, "{degrees} degrees, ratio {ratio}, {gap:?}: {share} of {fine} m³");
            }
        }
    }
    // The floor a third of the way up, sides of two in height to one.
    let gap = Gap { along: [-2.0, 2.0], floor: 1.0, sides: 0.5 };
    for degrees in [0.0, 20.0, 45.0] {
        let levee = Levee { degrees, side: 100, gap: Some(gap) };
        let share = levee.run(2.0, 5.0).beyond / levee.run(2.0, 1.0).beyond;
        assert!((share - 1.0).abs() < 0.25, "{degrees} degrees: {share}");
    }
}

/// The table of decision 0052: run it with `--ignored --nocapture`.
#[test]
#[ignore = "two minutes of runs on cells of 1 m"]
fn table_of_gaps() {
    for (width, floor, sides) in [(4.0, 0.0, 0.0), (7.0, 0.0, 0.0), (2.0, 0.0, 0.0), (3.0, 0.0, 1.0), (4.0, 1.0, 0.5)] {
        for degrees in [0.0, 20.0, 45.0] {
            let shares = [-2.0, 0.5, 3.0, 5.5].map(|from| {
                let gap = Gap { along: [from, from + width], floor, sides };
                let levee = Levee { degrees, side: 100, gap: Some(gap) };
                let fine = levee.run(2.0, 1.0).beyond;
                [5.0, 10.0].map(|spacing| levee.run(2.0, spacing).beyond / fine)
            });
            let ends = [0, 1].map(|k: usize| {
                let of_spacing = shares.iter().map(|share| share[k]);
                of_spacing.fold([f64::INFINITY, 0.0_f64], |[low, high], share| [low.min(share), high.max(share)])
            });
            println!(
                "{width} m, floor {floor} m, sides {sides}, {degrees}°: 5 m {:.2?}, 10 m {:.2?}",
                ends[0], ends[1]
            );
            assert!(ends.iter().all(|[low, _]| *low > 0.0), "nothing passes");
        }
    }
}

#[test]
fn what_is_built_into_a_gap_closes_it() {
    let gap = Gap { along: [-2.0, 2.0], floor: 0.0, sides: 0.0 };
    let levee = Levee { degrees: 0.0, side: 100, gap: Some(gap) };
    for spacing in [5.0, 10.0] {
        let mut scene = levee.scene(2.0, spacing);
        let ridge = prepare(&scene.scenario).setup.unwrap().bed;
        assert!(ridge.passes.iter().any(|sill| sill.share < 1.0));
        // A dam along the crest that breaks long after the run.
        scene.scenario.end_time = 2e4;
        scene.line("dam.geojson", &[(53.3, 30.0), (53.3, 70.0)]);
        scene.scenario.breach = Some(Breach {
            dam: vector("breach.dam", scene.path("dam.geojson")),
            crest: Some(sourced("breach.crest", 3.0)),
            crest_field: None,
            trigger: BreachTrigger::At(sourced("breach.trigger.at", 1e4)),
            shape: None,
            law: GrowthLaw::Linear,
            duration: Some(sourced("breach.growth.duration", 5.0)),
            share: None,
            method: None,
        });
        let prepared = prepare(&scene.scenario);
        assert!(!prepared.has_errors(), "{:#?}", prepared.problems);
        let cells: Vec<usize> =
            prepared.scene().forcing.breach.as_ref().unwrap().cells.iter().map(|cell| cell.cell).collect();
        let bed = &prepared.setup().bed;
        assert!(cells.iter().all(|&cell| bed.elevation[cell] >= 3.0), "cells of {spacing} m");
        let Behind { beyond, .. } = levee.run_scene(&scene, spacing);
        assert!(beyond <= 0.0, "cells of {spacing} m: {beyond} m³");
    }
}

fn ridge_warnings(prepared: &Prepared) -> Vec<String> {
    let of_ridges = prepared.problems.iter().filter(|problem| problem.code == "ridge-in-cell");
    of_ridges
        .map(|problem| {
            assert_eq!(problem.severity, Severity::Warning);
            assert!(problem.at.is_some() && problem.cause.is_some() && problem.remedy.is_some());
            problem.to_string()
        })
        .collect()
}

#[test]
fn check_warns_of_ridges_that_cells_do_not_see_and_of_moving_particles_that_pass_them() {
    let levee = Levee { degrees: 20.0, side: 100, gap: None };
    let mut scene = levee.scene(2.0, 10.0);
    let prepared = prepare(&scene.scenario);
    let warnings = ridge_warnings(&prepared);
    assert!(warnings.len() == 1 && warnings[0].contains("water passes them at their lowest place"), "{warnings:?}");
    assert!(!prepared.scene().ridges.is_empty());
    for ridge in &prepared.scene().ridges {
        let middle = (ridge.line[0] + ridge.line[1]) * 0.5;
        assert!(levee.across(middle).abs() < 15.0 && ridge.rise().is_some_and(|rise| rise > 0.1), "{ridge:?}");
        assert!(((ridge.line[1] - ridge.line[0]).norm() - 10.0).abs() < 1e-9);
        assert!(ridge.sill.is_some_and(|sill| (2.9..3.01).contains(&sill)), "{ridge:?}");
    }
    scene.scenario.numerics.formulation = Formulation::Variational;
    let warnings = ridge_warnings(&prepare(&scene.scenario));
    assert!(
        warnings.len() == 1
            && warnings[0].contains("the particles of the variational formulation pass them unhindered"),
        "{warnings:?}"
    );
    // The lattice of the pixels sees all.
    let prepared = prepare(&levee.scene(2.0, 1.0).scenario);
    assert!(ridge_warnings(&prepared).is_empty() && prepared.scene().ridges.is_empty());
}
