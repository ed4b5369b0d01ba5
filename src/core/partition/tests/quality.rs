//! How well shaped the cells are.

use super::checks::{faces_of_cells, lattice};
use super::random::{EDGE, FAMILIES, Family, scene_of};
use crate::math::Vec2;
use crate::partition::{Face, Partition};

/// Areas in spacings squared and perimeter squared over area of all cells.
pub fn shapes(made: &Partition, spacing: f64) -> Vec<(f64, f64)> {
    let shape = |(number, faces): (usize, &Vec<(Vec2, Vec2, Face)>)| {
        let perimeter: f64 = faces.iter().map(|(from, to, _)| (*to - *from).norm()).sum();
        let area = made.cells[number].area;
        (area / (spacing * spacing), perimeter * perimeter / area)
    };
    faces_of_cells(made).iter().enumerate().map(shape).collect()
}

/// Prints the figures of some cells: least and greatest area, worst perimeter squared over area (a square has 16), shares.
pub fn print_figures(name: &str, shapes: &[(f64, f64)]) {
    let mut areas: Vec<f64> = shapes.iter().map(|(area, _)| *area).collect();
    let mut ratios: Vec<f64> = shapes.iter().map(|(_, ratio)| *ratio).collect();
    areas.sort_by(f64::total_cmp);
    ratios.sort_by(f64::total_cmp);
    let at = |sorted: &[f64], share: f64| sorted[((sorted.len() - 1) as f64 * share) as usize];
    let below = |limit: f64| 100.0 * areas.iter().filter(|area| **area < limit).count() as f64 / areas.len() as f64;
    println!(
        "{name}: {} cells; area {:.3} {:.3} {:.3} {:.3} {:.3} {:.3} {:.3} (least, .1 %, 1 %, half, 99 %, 99.9 %, greatest); \
         below .3 {:.2} %, below .4 {:.2} %, above 1.8 {:.2} %; perimeter squared over area {:.1} {:.1} {:.1} {:.1}",
        areas.len(),
        areas[0],
        at(&areas, 0.001),
        at(&areas, 0.01),
        at(&areas, 0.5),
        at(&areas, 0.99),
        at(&areas, 0.999),
        at(&areas, 1.0),
        below(0.3),
        below(0.4),
        100.0 - below(1.8),
        at(&ratios, 0.5),
        at(&ratios, 0.99),
        at(&ratios, 0.999),
        at(&ratios, 1.0),
    );
}

/// The shapes of all cells of many scenes, and how many parts were blocked.
fn shapes_of(families: &[Family], seeds: std::ops::Range<u64>) -> (Vec<(f64, f64)>, usize) {
    let lattice = lattice(EDGE, EDGE, 1.0);
    let (mut all, mut blocked) = (Vec::new(), 0);
    for seed in seeds {
        let made = Partition::new(&lattice, |_| true, &scene_of(families, seed));
        all.extend(shapes(&made, 1.0));
        blocked += made.blocked;
    }
    (all, blocked)
}

#[test]
fn cells_of_random_scenes_are_well_shaped() {
    for family in FAMILIES {
        let (all, blocked) = shapes_of(&[family], 0..100);
        print_figures(&format!("{family:?}, {blocked} blocked"), &all);
    }
    let (all, blocked) = shapes_of(&FAMILIES, 0..400);
    print_figures(&format!("all families, {blocked} blocked"), &all);
    let share =
        |is_so: &dyn Fn(f64) -> bool| all.iter().filter(|(area, _)| is_so(*area)).count() as f64 / all.len() as f64;
    assert!(share(&|area| area < 0.4) < 5e-3 && share(&|area| area > 1.8) < 5e-4);
}
