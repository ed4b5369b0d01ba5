//! Bowls of known volume, rims oblique to the lattice, islands, holes, dams, pockets and leaks.

use std::f64::consts::PI;

use geo::{BooleanOps, Coord, LineString, MultiPolygon, Polygon};

use super::*;
use crate::bed::{Nothing, place_bed};
use crate::constants::SeedingConstants;
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::methods::BedMethod;
use crate::seeding::lattice::lattice_filling;
use crate::terrain::{Layer, Raster, Terrain};

/// Terrain given by a formula.
pub(crate) struct Formula<F: Fn(Vec2) -> f64 + Sync>(pub F);

impl<F: Fn(Vec2) -> f64 + Sync> Surface for Formula<F> {
    fn elevation(&self, map: Vec2) -> Option<f64> {
        Some((self.0)(map)).filter(|z| !z.is_nan())
    }

    fn samples(&self, _: Vec2, _: f64, _: &mut Vec<(Vec2, f64)>) {}
}

/// A square lattice of the given number of cells along an edge, centred on the origin of the map.
pub(crate) fn lattice(cells: usize, spacing: f64) -> Lattice {
    let half = 0.5 * cells as f64 * spacing;
    Lattice::new(Vec2::new(-half, -half), cells, cells, spacing)
}

/// A regular polygon around a place (map).
pub(crate) fn regular(centre: Vec2, radius: f64, corners: usize, turn: f64) -> Polygon<f64> {
    let corner = |i: usize| {
        let angle = turn + 2.0 * PI * i as f64 / corners as f64;
        Coord { x: centre.x + radius * angle.cos(), y: centre.y + radius * angle.sin() }
    };
    Polygon::new(LineString::from((0..corners).map(corner).collect::<Vec<_>>()), Vec::new())
}

pub(crate) fn body(polygon: Polygon<f64>, level: f64) -> StillBody {
    StillBody { polygon: MultiPolygon(vec![polygon]), level }
}

fn fill<F: Fn(Vec2) -> f64 + Sync>(formula: F, lattice: &Lattice, bodies: &[StillBody]) -> (BedParticles, StillWater) {
    let surface = Formula(formula);
    let mut bed = place_bed(&surface, lattice, BedMethod::Pointwise, &Nothing, 0.03);
    let (still, shore) = fill_still_water(bodies, &bed, &surface, Barriers::default(), &SeedingConstants::DEFAULT);
    bed.set(&shore);
    (bed, still)
}

/// Every filled cell is level to rounding, and its volumes are those of the depths.
pub(crate) fn assert_consistent(bed: &BedParticles, still: &StillWater, bodies: &[StillBody]) {
    let mut seeded = vec![0.0; bodies.len()];
    for (cell, &depth) in still.depth.iter().enumerate() {
        match still.body[cell] {
            Some(number) => {
                let level = bodies[number as usize].level;
                assert!(depth > 0.0 && (depth + bed.elevation[cell] - level).abs() <= 1e-15 * level.abs().max(64.0));
                seeded[number as usize] += depth * bed.lattice.cell_area();
            }
            None => assert!(depth.abs() <= 0.0),
        }
    }
    for (seeded, balance) in seeded.iter().zip(&still.volumes) {
        assert!((seeded - balance.seeded_m3).abs() <= 1e-12 * seeded);
    }
    let particles: f64 = lattice_filling(&bed.lattice, still).iter().map(|seed| seed.volume).sum();
    let integral: f64 = still.volumes.iter().map(|volume| volume.integral_m3).sum();
    assert!((particles - integral).abs() <= 1e-12 * integral);
}

#[test]
fn bowls_hold_their_known_volume() {
    // Radius of the shore 100 m, depth in the middle 20 m; the polygon lies on the hillside above the shore.
    let cone = |p: Vec2| 80.0 + 20.0 * p.norm() / 100.0;
    let paraboloid = |p: Vec2| 80.0 + 20.0 * p.norm_squared() / 1e4;
    let rim = || [body(regular(Vec2::ZERO, 120.0, 40, 0.1), 100.0)];
    let cases: [(&(dyn Fn(Vec2) -> f64 + Sync), f64); 2] =
        [(&cone, PI * 1e4 * 20.0 / 3.0), (&paraboloid, PI * 1e4 * 20.0 / 2.0)];
    for (formula, volume) in cases {
        let (bed, still) = fill(formula, &lattice(60, 5.0), &rim());
        let balance = &still.volumes[0];
        // Midpoint rule on pieces of 5/9 m in a bowl of 100 m.
        assert!((balance.integral_m3 / volume - 1.0).abs() < 1e-4, "{balance:?}");
        // Cell by cell the integral itself.
        assert!(balance.relative_error().abs() < 1e-9, "{balance:?}");
        assert!(balance.shore_cells > 0 && balance.largest_bed_change_at_shore < 0.5 * 5.0, "{balance:?}");
        assert_eq!((balance.toggled, balance.leaks.len(), balance.pocket_cells), (0, 0, 0));
        assert_consistent(&bed, &still, &rim());
    }
}

#[test]
fn square_oblique_to_the_lattice_is_met_within_a_tenth_of_a_percent() {
    for turn in [0.0, 0.2, 0.5, PI / 4.0, 1.1] {
        let square = [body(regular(Vec2::new(1.3, -2.1), 70.0, 4, turn), 10.0)];
        let (bed, still) = fill(|_| 0.0, &lattice(40, 5.0), &square);
        let balance = &still.volumes[0];
        assert!((balance.integral_m3 / (10.0 * 2.0 * 70.0 * 70.0) - 1.0).abs() < 2e-5, "{balance:?}");
        assert!(balance.is_within_tolerance(), "turned by {turn}: {balance:?}");
        // On a flat bed all of the rim leaks: one gap around the whole square.
        assert_eq!(balance.leaks.len(), 1);
        assert_eq!(balance.leaks[0].depth.to_bits(), 10.0_f64.to_bits());
        assert_consistent(&bed, &still, &square);
    }
}

#[test]
fn island_and_hole_stay_dry() {
    // A cone of 30 m base radius and 15 m height stands in 10 m of water.
    let island = |p: Vec2| (15.0 - 0.5 * (p - Vec2::new(20.0, 10.0)).norm()).max(0.0);
    let mut polygon = regular(Vec2::ZERO, 90.0, 4, 0.3);
    polygon.interiors_push(regular(Vec2::new(-25.0, -20.0), 15.0, 24, 0.0).exterior().clone());
    let bodies = [body(polygon, 10.0)];
    let (bed, still) = fill(island, &lattice(100, 2.0), &bodies);
    // Of the island's cone, the part below 10 m: the whole one less the tip of 5 m and base radius 10 m.
    let rock = PI / 3.0 * (30.0 * 30.0 * 15.0 - 10.0 * 10.0 * 5.0);
    let hole = 24.0 / 2.0 * 15.0 * 15.0 * (2.0 * PI / 24.0).sin();
    let volume = 10.0 * (2.0 * 90.0 * 90.0 - hole) - rock;
    let balance = &still.volumes[0];
    assert!((balance.integral_m3 / volume - 1.0).abs() < 1e-4, "{} {volume}", balance.integral_m3);
    assert!(balance.is_within_tolerance(), "{balance:?}");
    assert_consistent(&bed, &still, &bodies);
    let depth_at = |x, y| still.depth[bed.lattice.cell_at(bed.lattice.to_local(Vec2::new(x, y))).unwrap()];
    assert_eq!((depth_at(20.0, 10.0), depth_at(-25.0, -20.0)), (0.0, 0.0));
    assert_eq!(depth_at(0.0, 50.0).to_bits(), 10.0_f64.to_bits());
}

#[test]
fn later_body_wins() {
    let west = body(regular(Vec2::new(-20.0, 0.0), 60.0, 4, 0.0), 5.0);
    let east = body(regular(Vec2::new(20.0, 0.0), 60.0, 4, 0.0), 3.0);
    let bodies = [west.clone(), east.clone()];
    let (bed, still) = fill(|_| 0.0, &lattice(120, 2.0), &bodies);
    let only_west: f64 = west.polygon.difference(&east.polygon).iter().map(geo::Area::unsigned_area).sum();
    assert!((still.volumes[0].area_m2 / only_west - 1.0).abs() < 1e-3);
    assert!((still.volumes[1].area_m2 / 7200.0 - 1.0).abs() < 1e-4);
    assert!(still.volumes.iter().all(SeededVolume::is_within_tolerance), "{:?}", still.volumes);
    assert_consistent(&bed, &still, &bodies);
}

#[test]
fn nodata_is_booked_and_stays_dry() {
    let half = |p: Vec2| if p.x > 0.0 { f64::NAN } else { 0.0 };
    let bodies = [body(regular(Vec2::ZERO, 50.0, 4, PI / 4.0), 2.0)];
    let (bed, still) = fill(half, &lattice(60, 2.0), &bodies);
    let balance = &still.volumes[0];
    // Half of the square of 70.7 m lies without terrain; over the first 2 m of it, one cell, the terrain is prolonged.
    let side = 50.0 * f64::sqrt(2.0);
    assert!((balance.area_without_terrain_m2 / ((0.5 * side - 2.0) * side) - 1.0).abs() < 5e-3, "{balance:?}");
    assert!((balance.integral_m3 / (2.0 * (0.5 * side + 2.0) * side) - 1.0).abs() < 5e-3, "{balance:?}");
    assert_consistent(&bed, &still, &bodies);
}

/// A valley running south with steep sides: 10 m deep along its axis at the dam, at y = 0.
fn valley(p: Vec2) -> f64 {
    0.02 * p.x * p.x + 0.1 * p.y
}

fn reservoir() -> [StillBody; 1] {
    let corners = [(-60.0, 0.0), (60.0, 0.0), (60.0, 110.0), (-60.0, 110.0)];
    [body(Polygon::new(LineString::from(corners.to_vec()), Vec::new()), 10.0)]
}

#[test]
fn open_dam_line_is_the_one_leak() {
    let (bed, still) = fill(valley, &lattice(72, 4.0), &reservoir());
    let balance = &still.volumes[0];
    assert!(balance.is_within_tolerance(), "{balance:?}");
    assert_eq!(balance.leaks.len(), 1, "{:?}", balance.leaks);
    let leak = balance.leaks[0];
    assert!(leak.position.x.abs() <= 2.0 && leak.position.y < 4.0 && leak.depth > 9.0, "{leak:?}");
    assert_consistent(&bed, &still, &reservoir());
}

#[test]
fn standing_dam_leaves_no_leak_and_no_gap_in_the_lake() {
    let surface = Formula(valley);
    // The dam lies askew to the rows; the rim of the polygon leaves slivers on both sides of it.
    let mut bed = place_bed(&surface, &lattice(72, 4.0), BedMethod::Pointwise, &Nothing, 0.03);
    let dam = [bed.lattice.to_local(Vec2::new(-70.0, -1.0)), bed.lattice.to_local(Vec2::new(70.0, 3.0))];
    let (still, shore) = fill_still_water(
        &reservoir(),
        &bed,
        &surface,
        Barriers { walls: &[dam], dam: &[] },
        &SeedingConstants::DEFAULT,
    );
    bed.set(&shore);
    let balance = &still.volumes[0];
    assert_eq!(balance.leaks, []);
    for cell in (0..bed.lattice.len()).filter(|&cell| still.body[cell].is_some()) {
        let local = bed.lattice.centre(cell);
        let behind_dam = (dam[1] - dam[0]).cross(local - dam[0]) > 0.0;
        assert!(behind_dam, "water below the dam at {local:?}");
    }
    let dry_lake_cells = (0..bed.lattice.len()).filter(|&cell| {
        let local = bed.lattice.centre(cell);
        let behind_dam = (dam[1] - dam[0]).cross(local - dam[0]) > 0.0;
        behind_dam && bed.elevation[cell] < 10.0 && still.body[cell].is_none()
    });
    assert_eq!(dry_lake_cells.count(), 0);
}

#[test]
fn pocket_left_out_by_the_rim_is_filled() {
    // The polygon cuts a corner of the bowl's shore: what it leaves out is shallow and small, and would fill at once.
    let paraboloid = |p: Vec2| 80.0 + 20.0 * p.norm_squared() / 1e4;
    let bodies = [body(regular(Vec2::ZERO, 100.4, 24, 0.0), 100.0)];
    let (bed, still) = fill(paraboloid, &lattice(60, 5.0), &bodies);
    let balance = &still.volumes[0];
    assert!(balance.pocket_cells > 0 && balance.leaks.is_empty(), "{balance:?}");
    assert!(balance.is_within_tolerance(), "{balance:?}");
    let below = (0..bed.lattice.len()).filter(|&cell| bed.elevation[cell] < 100.0).count();
    assert_eq!(balance.cells, below);
}

#[test]
fn lake_with_a_rim_inside_its_shore_and_an_open_dam_is_filled_up_to_the_shore() {
    // A trough whose shore lies at |x| = 33.3 m; the polygon ends one cell or two before it, and at the dam at y = 0.
    let trough = |p: Vec2| 0.3 * p.x.abs();
    for half_width in [31.0, 31.4, 30.6, 29.3] {
        let corners = [(-half_width, -60.0), (half_width, -60.0), (half_width, 0.0), (-half_width, 0.0)];
        let bodies = [body(Polygon::new(LineString::from(corners.to_vec()), Vec::new()), 10.0)];
        let (bed, still) = fill(trough, &lattice(60, 2.0), &bodies);
        let balance = &still.volumes[0];
        assert!(balance.pocket_cells > 0 && balance.leaks.len() == 1, "{balance:?}");
        for cell in (0..bed.lattice.len()).filter(|&cell| bed.elevation[cell] < 10.0) {
            let centre = bed.lattice.to_map(bed.lattice.centre(cell));
            let is_filled = still.body[cell].is_some();
            // Up to two cells from the dam the ground beside the polygon is the open ground before it.
            assert!(is_filled || centre.y > -4.0, "rim at {half_width}: dry at {centre:?} within the lake");
        }
    }
}

#[test]
fn canal_between_upright_banks_is_as_wide_filled_as_dry() {
    // Ten cells of a raster wide: half a cell less at each bank is a tenth of it.
    let (columns, rows, cell) = (60, 30, 2.0);
    let values = (0..columns * rows).map(|i| if (10..20).contains(&(i / columns)) { 0.0 } else { 6.0 }).collect();
    let raster = Raster { columns, rows, west: 0.0, north: 60.0, cell_x: cell, cell_y: cell, values };
    let terrain = Terrain::new(vec![Layer::Raster(raster)]).unwrap();
    // A level below half of the banks, and one above: between the centres of the raster the banks reach it beside, and not at, their edge.
    for (coarseness, level) in [1, 2, 5].into_iter().flat_map(|coarseness| [(coarseness, 1.5), (coarseness, 4.0)]) {
        let bodies = [body(regular(Vec2::new(60.0, 30.0), 200.0, 4, 0.0), level)];
        let lattice = Lattice::new(Vec2::ZERO, columns / coarseness, rows / coarseness, cell * coarseness as f64);
        let dry = place_bed(&terrain, &lattice, BedMethod::Pointwise, &Nothing, 0.03);
        let mut bed = place_bed(&terrain, &lattice, BedMethod::Pointwise, &Nothing, 0.03);
        let (still, shore) = fill_still_water(&bodies, &bed, &terrain, Barriers::default(), &SeedingConstants::DEFAULT);
        bed.set(&shore);
        let balance = &still.volumes[0];
        let volume = level * 20.0 * 120.0;
        assert!((balance.integral_m3 / volume - 1.0).abs() < 1e-9 && (balance.seeded_m3 / volume - 1.0).abs() < 1e-9);
        assert_eq!(bed.elevation, dry.elevation);
    }
}

#[test]
fn a_building_in_a_film_is_as_large_as_on_dry_ground() {
    // A house of 8 m by 16 m, 0.8 m high, askew: as a formula, and as a raster of 0.4 m, which is wider by half of its cells. Cells of 1 m.
    let (along, across) = (Vec2::new(0.44, 0.9), Vec2::new(-0.9, 0.44));
    let ground = |p: Vec2| if p.dot(along).abs() < 8.0 && p.dot(across).abs() < 4.0 { 0.8 } else { 0.0 };
    let columns = 100;
    let centre = |i: usize| Vec2::new((i % columns) as f64 - 49.5, 49.5 - (i / columns) as f64) * 0.4;
    let values = (0..columns * columns).map(|i| ground(centre(i))).collect();
    let raster = Raster { columns, rows: columns, west: -20.0, north: 20.0, cell_x: 0.4, cell_y: 0.4, values };
    let terrain = Terrain::new(vec![Layer::Raster(raster)]).unwrap();
    assert_house_stands(&Formula(ground));
    assert_house_stands(&terrain);
}

/// Fills a film of 0.02 m on a surface of 40 m by 40 m, and asserts that its banks stand, and that it holds its integral or, where there is
/// no room for that, fills all other cells.
fn assert_house_stands(surface: &impl Surface) {
    let level = 0.02;
    let dry = place_bed(surface, &lattice(40, 1.0), BedMethod::Pointwise, &Nothing, 0.03);
    let mut bed = place_bed(surface, &lattice(40, 1.0), BedMethod::Pointwise, &Nothing, 0.03);
    let bodies = [body(regular(Vec2::ZERO, 100.0, 4, 0.0), level)];
    let (still, shore) = fill_still_water(&bodies, &bed, surface, Barriers::default(), &SeedingConstants::DEFAULT);
    bed.set(&shore);
    let (mut standing, mut other) = (0, 0);
    for (z_b, before) in bed.elevation.iter().zip(&dry.elevation) {
        if *before > level {
            assert_eq!(z_b.to_bits(), before.to_bits(), "a cell of the house is cut down from {before} m to {z_b} m");
            standing += 1;
        } else {
            assert!((0.0..level).contains(z_b));
            other += 1;
        }
    }
    assert!(standing > 100);
    let balance = &still.volumes[0];
    let holds = balance.integral_m3.min(level * f64::from(other));
    assert!((balance.seeded_m3 / holds - 1.0).abs() < 1e-9, "{balance:?}");
}

#[test]
fn body_of_a_few_cells_says_that_it_misses() {
    let bodies = [body(regular(Vec2::new(0.4, 0.3), 3.0, 4, 0.0), 1.0)];
    let (_, still) = fill(|_| 0.0, &lattice(10, 5.0), &bodies);
    let balance = &still.volumes[0];
    assert!((balance.integral_m3 - 18.0).abs() < 0.1);
    assert!(!balance.is_within_tolerance());
}

#[test]
fn bed_at_the_shore_holds_the_share_of_the_cell_and_stays_within_its_terrain() {
    let paraboloid = |p: Vec2| 80.0 + 20.0 * p.norm_squared() / 1e4;
    let bodies = [body(regular(Vec2::ZERO, 120.0, 40, 0.1), 100.0)];
    let (bed, still) = fill(paraboloid, &lattice(60, 5.0), &bodies);
    let mut partly_wet = 0;
    for cell in (0..bed.lattice.len()).filter(|&cell| still.body[cell].is_some()) {
        let centre = bed.lattice.to_map(bed.lattice.centre(cell));
        let corner = |x: f64, y: f64| paraboloid(Vec2::new(centre.x.abs() + x, centre.y.abs() + y));
        // The lowest and highest terrain of the cell lie at its corners towards and away from the middle of the bowl.
        let (lowest, highest) = (corner(-2.5, -2.5), corner(2.5, 2.5));
        assert!(lowest <= bed.elevation[cell] && bed.elevation[cell] <= highest.min(100.0));
        partly_wet += usize::from(highest > 100.0);
    }
    // A cell whose corner alone stands out of the water may count as wholly wet.
    assert!(still.volumes[0].shore_cells > 100 && still.volumes[0].shore_cells <= partly_wet);
}

#[test]
fn rim_through_open_water_makes_no_sill() {
    // The dam line cuts the cells of one row at a third of their height.
    let corners = [(-60.0, 1.3), (60.0, 1.3), (60.0, 110.0), (-60.0, 110.0)];
    let bodies = [body(Polygon::new(LineString::from(corners.to_vec()), Vec::new()), 10.0)];
    let (bed, still) = fill(valley, &lattice(72, 4.0), &bodies);
    let balance = &still.volumes[0];
    assert!(balance.leaks.len() == 1 && balance.relative_error().abs() < 5e-3, "{balance:?}");
    for cell in 0..bed.lattice.len() {
        let centre = bed.lattice.to_map(bed.lattice.centre(cell));
        if centre.y < 4.0 && centre.x.abs() < 16.0 {
            assert_eq!(bed.elevation[cell].to_bits(), valley(centre).to_bits());
        }
    }
}

#[test]
fn edge_of_the_terrain_holds_what_the_polygon_draws_beyond_it() {
    // The terrain ends at x = 21, within a cell whose centre has none, and the polygon at x = 20.5; depth 2 m.
    let half = |p: Vec2| if p.x > 20.9 { f64::NAN } else { 0.05 * p.y };
    let corners = [(-30.0, -20.0), (20.5, -20.0), (20.5, 20.0), (-30.0, 20.0)];
    let bodies = [body(Polygon::new(LineString::from(corners.to_vec()), Vec::new()), 0.0)];
    let (bed, still) = fill(half, &lattice(60, 2.0), &bodies);
    let balance = &still.volumes[0];
    assert!(balance.integral_m3 > 0.0 && balance.relative_error().abs() < 0.02, "{balance:?}");
    assert_consistent(&bed, &still, &bodies);
}

#[test]
fn dam_through_a_row_of_centres_holds_however_it_is_drawn() {
    // Cells of 4 m with centres at y = 2: the dam stands on those, the lake north of it begins at y = 3 with 2 m of depth.
    let surface = Formula(|p: Vec2| if p.y < 80.0 && p.x.abs() < 80.0 { 0.0 } else { 5.0 });
    let corners = [(-80.0, 3.0), (80.0, 3.0), (80.0, 80.0), (-80.0, 80.0)];
    let bodies = [body(Polygon::new(LineString::from(corners.to_vec()), Vec::new()), 2.0)];
    let piece = |from: f64, to: f64| [Vec2::new(from, 2.0), Vec2::new(to, 2.0)];
    let drawn = [
        vec![piece(-90.0, 90.0)],
        vec![piece(90.0, -90.0)],
        vec![piece(-90.0, 2.0), piece(90.0, 2.0)],
        vec![piece(2.0, -90.0), piece(2.0, 90.0)],
    ];
    for dam in drawn {
        let mut bed = place_bed(&surface, &lattice(72, 4.0), BedMethod::Pointwise, &Nothing, 0.03);
        let dam: Vec<[Vec2; 2]> = dam.iter().map(|piece| piece.map(|p| bed.lattice.to_local(p))).collect();
        let (still, shore) =
            fill_still_water(&bodies, &bed, &surface, Barriers { walls: &dam, dam: &[] }, &SeedingConstants::DEFAULT);
        bed.set(&shore);
        assert_eq!(still.volumes[0].leaks, [], "{dam:?}");
        for cell in 0..bed.lattice.len() {
            let centre = bed.lattice.to_map(bed.lattice.centre(cell));
            let is_lake = centre.y > 1.0 && bed.elevation[cell] < 2.0;
            assert_eq!(still.body[cell].is_some(), is_lake, "{centre:?}, {dam:?}");
        }
    }
}

#[test]
fn opening_in_raster_ground_is_as_wide_before_the_rim_as_beyond_it() {
    // A ridge of 20 m with a gap of two cells of 10 m; between the centres of the cells the raster rises from 0 m to 10 m.
    let height = |x: f64, y: f64| {
        let is_high = (x.abs() < 10.0 && y.abs() > 10.0) || x < -140.0 || y.abs() > 100.0;
        if is_high { 10.0 } else { 0.0 }
    };
    let surface = |p: Vec2| {
        let (x, y) = ((p.x / 10.0 - 0.5).floor() * 10.0 + 5.0, (p.y / 10.0 - 0.5).floor() * 10.0 + 5.0);
        let (s, t) = ((p.x - x) / 10.0, (p.y - y) / 10.0);
        let south = height(x, y) * (1.0 - s) + height(x + 10.0, y) * s;
        let north = height(x, y + 10.0) * (1.0 - s) + height(x + 10.0, y + 10.0) * s;
        south * (1.0 - t) + north * t
    };
    for rim in [-10.0, -5.0, 0.0, 5.0] {
        let corners = [(-140.0, -100.0), (rim, -100.0), (rim, 100.0), (-140.0, 100.0)];
        let bodies = [body(Polygon::new(LineString::from(corners.to_vec()), Vec::new()), 2.0)];
        let (bed, still) = fill(surface, &lattice(30, 10.0), &bodies);
        for cell in 0..bed.lattice.len() {
            let centre = bed.lattice.to_map(bed.lattice.centre(cell));
            if centre.x.abs() < 30.0 && centre.y.abs() < 10.0 {
                assert_eq!(bed.elevation[cell].to_bits(), 0.0f64.to_bits(), "rim at {rim}: {centre:?}");
            }
        }
        assert!(still.volumes[0].relative_error().abs() < 0.03, "{:?}", still.volumes[0]);
    }
}

#[test]
fn a_polygon_that_ends_short_of_the_edge_of_the_terrain_raises_no_bed_along_it() {
    // The terrain ends at the line y = 0.3 x.
    let ground = |p: Vec2| if p.y > 0.3 * p.x { 0.02 * p.x } else { f64::NAN };
    for short in [0.0, 0.3, 0.9, 1.7] {
        let corners = [(-50.0, -15.0 + short), (50.0, 15.0 + short), (50.0, 60.0), (-50.0, 60.0)];
        let bodies = [body(Polygon::new(LineString::from(corners.to_vec()), Vec::new()), 10.0)];
        let lattice = lattice(50, 2.0);
        let dry = place_bed(&Formula(ground), &lattice, BedMethod::Pointwise, &Nothing, 0.03);
        let (bed, still) = fill(ground, &lattice, &bodies);
        for cell in (0..lattice.len()).filter(|&cell| dry.has_terrain(cell)) {
            let change = bed.elevation[cell] - dry.elevation[cell];
            // The ground falls by 0.02 m from the middle of a cell to its edge.
            assert!(change.abs() < 0.021, "{short} m short: bed changed by {change} m");
            assert!(still.body[cell].is_some(), "{short} m short: dry at {:?}", lattice.centre(cell));
        }
        let volume = &still.volumes[0];
        let is_booked = volume.at_edge_m3 > 0.0 && volume.is_within_tolerance();
        assert!(short < 0.5 || volume.pocket_cells > 0 || is_booked, "{short} m short: {volume:?}");
    }
}
