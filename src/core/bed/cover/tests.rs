//! Areas and sides against the rectangles that they come from: one raster at any place on the lattice, several of unlike origin, data
//! that are missing beyond the last whole cell.

use super::*;
use crate::bed::{Nothing, place_bed};
use crate::methods::BedMethod;
use crate::terrain::{Layer, Raster, Terrain};

const SPACING: f64 = 10.0;

fn lattice() -> Lattice {
    Lattice::new(Vec2::ZERO, 12, 9, SPACING)
}

/// A raster of cells of half a metre with its south-western corner at a place (m), so many metres wide and high.
fn raster(west: f64, south: f64, width: f64, height: f64) -> Raster {
    let (columns, rows) = ((2.0 * width).round() as usize, (2.0 * height).round() as usize);
    let values = vec![3.0; columns * rows];
    Raster { columns, rows, west, north: south + height, cell_x: 0.5, cell_y: 0.5, values }
}

fn cover(rasters: Vec<Raster>) -> (Cover, BedParticles) {
    let terrain = Terrain::new(rasters.into_iter().map(Layer::Raster).collect()).unwrap();
    let bed = place_bed(&terrain, &lattice(), BedMethod::Mean, &Nothing, 0.03);
    (Cover::find(&terrain, &terrain, &bed), bed)
}

/// Area (m²) of all cells.
fn area(cover: &Cover, bed: &BedParticles) -> f64 {
    let cells = (0..bed.lattice.len()).filter(|&cell| bed.has_terrain(cell));
    cells.map(|cell| cover.cell(cell).area * SPACING * SPACING).sum()
}

#[test]
fn a_lattice_that_fits_the_raster_has_whole_cells() {
    let (cover, _) = cover(vec![raster(10.0, 20.0, 80.0, 50.0)]);
    assert_eq!(cover, Cover::default());
    // Round-off of map coordinates is no part of a cell.
    let (near, _) = self::cover(vec![Raster { west: 10.0 + 1e-7, ..raster(10.0, 20.0, 80.0, 50.0) }]);
    assert_eq!(near, Cover::default());
}

#[test]
fn the_cells_of_a_raster_at_any_place_have_its_area_and_its_sides() {
    for (west, south, width, height) in
        [(10.0, 20.0, 77.5, 50.0), (13.0, 22.5, 80.0, 51.0), (8.0, 17.5, 91.0, 58.5), (15.0, 15.0, 80.0, 60.0)]
    {
        let (cover, bed) = cover(vec![raster(west, south, width, height)]);
        let error = area(&cover, &bed) - width * height;
        assert!(error.abs() < 1e-9 * width * height, "{west} {south} {width} {height}: {error} m2");
        for part in cover.cells() {
            let [east, west, north, south] = part.sides;
            assert!((east - west).abs() < 1e-12 && (north - south).abs() < 1e-12, "{part:?}");
            assert!((east * north - part.area).abs() < 1e-12, "{part:?}");
            assert!((0.25..=2.25).contains(&part.area), "{part:?}");
        }
        for face in cover.faces() {
            assert!(face.sides.iter().all(|side| (side - face.open).abs() < 1e-12), "{face:?}");
        }
    }
}

#[test]
fn what_is_less_than_half_a_cell_belongs_to_the_cell_beside_it() {
    // From 8 to 99 m: a fifth of column 0 is given to column 1; nine tenths of column 9.
    let (cover, bed) = cover(vec![raster(8.0, 20.0, 91.0, 50.0)]);
    let row = 4;
    let cell = |column: usize| cover.cell(bed.lattice.index(column, row));
    assert!(!bed.has_terrain(bed.lattice.index(0, row)) && cover.holds(bed.lattice.index(0, row)));
    assert!((cell(1).area - 1.2).abs() < 1e-12 && (cell(9).area - 0.9).abs() < 1e-12);
    assert!((cell(9).middle.x + 0.05).abs() < 1e-12 && cell(9).middle.y.abs() < 1e-12, "{:?}", cell(9));
    let sides = cell(9).sides.into_iter().zip([1.0, 1.0, 0.9, 0.9]).map(|(side, exact)| (side - exact).abs());
    assert!(sides.fold(0.0, f64::max) < 1e-12, "its wall to the east is as long as it: {:?}", cell(9));
    assert_eq!(cell(5), CellInPart { cell: cell(5).cell, area: 1.0, sides: [1.0; 4], middle: Vec2::ZERO });
    let north = cover.faces().iter().find(|face| face.place == (row + 1, 2) && face.is_north).unwrap();
    assert!((north.open - 1.2).abs() < 1e-12, "{north:?}");
}

#[test]
fn rasters_of_unlike_origin_have_the_area_of_both() {
    // An L: 60 by 40 m, and 33 by 33 m that ends inside of cells on all sides.
    let (cover, bed) = cover(vec![raster(10.0, 10.0, 60.0, 40.0), raster(43.5, 32.5, 33.0, 33.0)]);
    let union = 60.0 * 40.0 + 33.0 * 33.0 - 26.5 * 17.5;
    assert!((area(&cover, &bed) - union).abs() < 1e-9 * union, "{} of {union} m2", area(&cover, &bed));
    // Where one ends before the other, water passes what both have.
    let walls = |face: &FaceInPart| face.sides.map(|side| side - face.open);
    assert!(cover.faces().iter().any(|face| walls(face).iter().any(|wall| *wall > 0.1)), "a step of the outline");
    assert!(cover.faces().iter().all(|face| walls(face).iter().all(|wall| *wall > -1e-12)));
}

#[test]
fn a_mirrored_terrain_has_mirrored_parts() {
    let rasters = || vec![raster(12.0, 10.0, 60.0, 43.0), raster(43.5, 32.5, 33.0, 33.0)];
    let (own, bed) = cover(rasters());
    let turned = |raster: Raster| Raster { west: 120.0 - raster.east(), ..raster };
    let (mirrored, _) = cover(rasters().into_iter().map(turned).collect());
    let mirror = |cell: usize| {
        let (column, row) = bed.lattice.column_row(cell);
        bed.lattice.index(11 - column, row)
    };
    assert_eq!(own.cells().len(), mirrored.cells().len());
    for part in own.cells() {
        let other = mirrored.cell(mirror(part.cell));
        let [east, west, north, south] = other.sides;
        let error = [west, east, north, south].iter().zip(part.sides).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-12 && (other.area - part.area).abs() < 1e-12, "{part:?} {other:?}");
    }
}

#[test]
fn missing_data_beyond_the_last_whole_cell_are_nobodys() {
    let mut with_hole = raster(8.0, 20.0, 91.0, 50.0);
    let without = cover(vec![raster(8.0, 20.0, 91.0, 50.0)]).0;
    // The strip from 8 to 10 m has no data from 40 to 50 m.
    for row in 40..60 {
        with_hole.values[row * 182..][..4].fill(f64::NAN);
    }
    let (cover, bed) = cover(vec![with_hole]);
    let cell = |row: usize| bed.lattice.index(1, row);
    assert_eq!([2, 3, 5, 6].map(|row| cover.cell(cell(row))), [2, 3, 5, 6].map(|row| without.cell(cell(row))));
    assert!((cover.cell(cell(4)).area - 1.0).abs() < 1e-12, "{:?}", cover.cell(cell(4)));
}

#[test]
fn half_covered_cells_are_halves_at_coordinates_of_any_size() {
    for west in [0.0, 500_000.1, 4_321_000.7] {
        let (spacing, columns, rows) = (0.3, 10, 8);
        let origin = Vec2::new(west, 5_000_000.3);
        // 9.5 cells wide, in cells of a sixth.
        let raster = Raster {
            columns: 57,
            rows: 48,
            west,
            north: origin.y + 48.0 * 0.05,
            cell_x: 0.05,
            cell_y: 0.05,
            values: vec![1.0; 57 * 48],
        };
        let terrain = Terrain::new(vec![Layer::Raster(raster)]).unwrap();
        let lattice = Lattice::new(origin, columns, rows, spacing);
        let bed = place_bed(&terrain, &lattice, BedMethod::Mean, &Nothing, 0.03);
        let cover = Cover::find(&terrain, &terrain, &bed);
        for row in 0..rows {
            let column = if bed.has_terrain(lattice.index(9, row)) { 9 } else { 8 };
            let part = cover.cell(lattice.index(column, row));
            let expected = if column == 9 { 0.5 } else { 1.5 };
            assert!((part.area - expected).abs() < 1e-9, "{west}, row {row}: {part:?}");
        }
    }
}
