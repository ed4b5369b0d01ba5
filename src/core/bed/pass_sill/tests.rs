use super::*;
use crate::bed::{Nothing, ground_in_gaps, place_bed};
use crate::lattice::Lattice;
use crate::methods::BedMethod;
use crate::terrain::{Layer, Raster, Terrain};

/// A terrain of square pixels (m) with its south-western corner at a place.
fn terrain(corner: Vec2, (columns, rows): (usize, usize), pixel: f64, z: impl Fn(Vec2) -> f64) -> Terrain {
    let north = corner.y + rows as f64 * pixel;
    let mut raster = Raster {
        columns,
        rows,
        west: corner.x,
        north,
        cell_x: pixel,
        cell_y: pixel,
        values: vec![0.0; columns * rows],
    };
    for row in 0..rows {
        for column in 0..columns {
            raster.values[row * columns + column] = z(raster.centre(column, row));
        }
    }
    Terrain::new(vec![Layer::Raster(raster)]).unwrap()
}

fn lattice(corner: Vec2, columns: usize, rows: usize, spacing: f64) -> Lattice {
    Lattice::new(corner, columns, rows, spacing)
}

/// Height (m) of a levee of 3 m with banks of 1 to 1 and a crest of 1.5 m, at an angle through the middle of 120 m by 120 m.
fn levee(place: Vec2, degrees: f64, shift: f64) -> f64 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let distance = ((place.x - 60.0 - shift) * cos + (place.y - 60.0) * sin).abs();
    (3.0 - (distance - 0.75).max(0.0)).clamp(0.0, 3.0)
}

/// The cells that water of a level (m) reaches from the cell in the south-west, past faces with higher sills and over no higher bed.
fn reached(bed: &BedParticles, level: f64) -> Vec<bool> {
    let lattice = &bed.lattice;
    let mut reached = vec![false; lattice.len()];
    let mut open = vec![0];
    reached[0] = true;
    while let Some(cell) = open.pop() {
        let (column, row) = lattice.column_row(cell);
        let ways = [
            (column > 0).then(|| cell - 1),
            (column + 1 < lattice.columns).then_some(cell + 1),
            (row > 0).then(|| cell - lattice.columns),
            (row + 1 < lattice.rows).then_some(cell + lattice.columns),
        ];
        for other in ways.into_iter().flatten() {
            if !reached[other] && bed.elevation[other] < level && bed.passes.between(cell, other) < level {
                reached[other] = true;
                open.push(other);
            }
        }
    }
    reached
}

#[test]
fn no_unbroken_levee_leaks_at_any_angle_ratio_and_origin() {
    for (k, degrees) in [0.0, 7.0, 20.0, 33.0, 45.0, 70.0, 90.0].into_iter().enumerate() {
        for (ratio, offset) in [(2.0, 0.0), (2.5, 0.0), (3.0, 0.4), (5.0, 0.0), (7.3, 0.0), (10.0, 0.5), (20.0, 0.0)] {
            let shift = 1.7 * k as f64 - 4.0;
            let terrain = terrain(Vec2::ZERO, (120, 120), 1.0, |place| levee(place, degrees, shift));
            let cells = ((120.0 - offset) / ratio) as usize;
            let lattice = lattice(Vec2::new(offset, offset), cells, cells, ratio);
            let mut bed = place_bed(&terrain, &lattice, BedMethod::Mean, &Nothing, 0.0);
            bed.passes = PassSills::find(&terrain, &bed);
            assert!(bed.passes.iter().all(|sill| sill.level < 3.0 + 1e-9), "no sill is higher than the crest");
            let (dry, wet) = (reached(&bed, 2.4), reached(&bed, 3.01));
            assert!(wet.iter().all(|&is_reached| is_reached), "{degrees} degrees, ratio {ratio}: overtopped");
            let (sin, cos) = degrees.to_radians().sin_cos();
            for cell in (0..lattice.len()).filter(|&cell| dry[cell]) {
                let place = lattice.to_map(lattice.centre(cell));
                let beyond = (place.x - 60.0 - shift) * cos + (place.y - 60.0) * sin;
                assert!(beyond < 0.71 * ratio, "{degrees} degrees, ratio {ratio}: {beyond} m beyond the crest");
            }
        }
    }
}

#[test]
fn a_sill_is_the_lowest_way_inside_two_cells() {
    // Two cells of five pixels; a wall between them in column 6, with a notch of 1.5 m in its row 1 that a ridge of 2 m closes from
    // the east but for a way round.
    let z = |place: Vec2| match (place.x as usize, place.y as usize) {
        (6, 3) => 1.5,
        (6, _) => 3.0,
        (7, 1..) => 2.0,
        (2, 2) => -0.5,
        (9, 4) => -0.25,
        _ => 0.0,
    };
    let terrain = terrain(Vec2::ZERO, (10, 5), 1.0, z);
    let lattice = lattice(Vec2::ZERO, 2, 1, 5.0);
    let bed = BedParticles::from_elevation(lattice, vec![0.0, 0.6], 0.0);
    let passes = PassSills::find(&terrain, &bed);
    let sills: Vec<_> = passes.iter().copied().collect();
    assert_eq!(sills, [PassSill::whole(0, false, 2.0)]);
    assert_eq!((passes.between(1, 0), passes.between(0, 1)), (2.0, 2.0));
    // A bed that sees the ridge has no sill.
    let terrain = self::terrain(Vec2::ZERO, (10, 5), 1.0, |place| if place.x as usize == 6 { 2.0 } else { 0.0 });
    let bed = BedParticles::from_elevation(bed.lattice, vec![0.0, 2.0], 0.0);
    assert!(PassSills::find(&terrain, &bed).is_empty());
}

#[test]
fn terrain_no_finer_than_the_lattice_and_smooth_terrain_have_no_sills() {
    let rough = |place: Vec2| 3.0 * ((place.x * 12.9 + place.y * 78.2).sin() * 43758.5).fract();
    for spacing in [0.5, 1.0] {
        let terrain = terrain(Vec2::ZERO, (20, 20), 1.0, rough);
        let lattice = lattice(Vec2::new(0.25, 0.25), 8, 8, spacing);
        let bed = place_bed(&terrain, &lattice, BedMethod::Pointwise, &Nothing, 0.0);
        assert!(PassSills::find(&terrain, &bed).is_empty());
    }
    let plane = terrain(Vec2::ZERO, (60, 60), 1.0, |place| 0.3 * place.x - 0.1 * place.y);
    let bed = place_bed(&plane, &lattice(Vec2::ZERO, 6, 6, 10.0), BedMethod::Mean, &Nothing, 0.0);
    assert!(PassSills::find(&plane, &bed).is_empty());
}

#[test]
fn pixels_without_data_are_walls() {
    let z = |place: Vec2| if place.x as usize == 6 && place.y < 4.0 { f64::NAN } else { 0.1 * place.y };
    let joined = |rows: usize| {
        let terrain = terrain(Vec2::ZERO, (10, rows), 1.0, z);
        let lattice = lattice(Vec2::ZERO, 2, 1, rows as f64);
        let lattice = {
            let plain = lattice;
            Lattice::new(plain.origin, plain.columns, plain.rows, 5.0)
        };
        let bed = BedParticles::from_elevation(lattice, vec![0.0, 0.0], 0.0);
        PassSills::find(&terrain, &bed).between(0, 1)
    };
    // Round the end of the wall in the northernmost row, and nowhere.
    assert!((joined(5) - 0.45).abs() < 1e-12, "{}", joined(5));
    assert!(joined(4) >= SHUT, "{}", joined(4));
}

#[test]
fn sills_of_a_mirrored_terrain_are_mirrored() {
    let rough = |x: f64, y: f64| 2.0 + ((x * 12.9 + y * 78.2).sin() * 43758.5).fract();
    for spacing in [2.5, 4.0, 5.0] {
        let lattice = lattice(Vec2::ZERO, (40.0 / spacing) as usize, (40.0 / spacing) as usize, spacing);
        let find = |is_mirrored: bool| {
            let x = |place: Vec2| if is_mirrored { 40.0 - place.x } else { place.x };
            let terrain = terrain(Vec2::ZERO, (40, 40), 1.0, |place| rough(x(place), place.y));
            let bed = BedParticles::from_elevation(lattice.clone(), vec![2.0; lattice.len()], 0.0);
            PassSills::find(&terrain, &bed)
        };
        let (plain, mirrored) = (find(false), find(true));
        assert!(!plain.is_empty());
        let columns = lattice.columns;
        let image = |cell: usize| cell / columns * columns + columns - 1 - cell % columns;
        for sill in plain.iter() {
            let other = sill.other(&lattice);
            assert_eq!(mirrored.between(image(sill.cell), image(other)).to_bits(), sill.level.to_bits());
        }
        assert_eq!(plain.iter().count(), mirrored.iter().count());
    }
}

#[test]
fn gaps_of_a_mirrored_terrain_are_mirrored() {
    // A rough levee across a rough plain, with gaps of some widths; pixels astride of the edges of cells, too.
    let rough = |x: f64, y: f64| ((x * 12.9 + y * 78.2).sin() * 43758.5).fract();
    let z = |x: f64, y: f64| {
        let across = x - 30.3 - 0.4 * y;
        let is_gap = (10.0..13.0).contains(&y) || (33.0..38.0).contains(&y) || (60.0..66.0).contains(&y);
        0.1 * rough(x, y) + if across.abs() < 2.6 && !is_gap { 3.0 + 0.3 * rough(y, x) } else { 0.0 }
    };
    for spacing in [5.0, 6.5, 8.0, 10.0] {
        let cells = (80.0 / spacing) as usize;
        let size = cells as f64 * spacing;
        let find = |is_mirrored: bool| {
            let x = |place: Vec2| if is_mirrored { size - place.x } else { place.x };
            let terrain = terrain(Vec2::ZERO, (size as usize, 80), 1.0, |place| z(x(place), place.y));
            let lattice = lattice(Vec2::ZERO, cells, cells, spacing);
            let mut bed = place_bed(&terrain, &lattice, BedMethod::Mean, &Nothing, 0.0);
            bed.set(&ground_in_gaps(&terrain, &bed));
            bed.passes = PassSills::find(&terrain, &bed);
            bed
        };
        let (plain, mirrored) = (find(false), find(true));
        let image = |cell: usize| cell / cells * cells + cells - 1 - cell % cells;
        let gaps = |bed: &BedParticles| bed.passes.iter().filter(|sill| sill.share < 1.0).count();
        assert!(gaps(&plain) > 3 && gaps(&plain) == gaps(&mirrored), "{} and {}", gaps(&plain), gaps(&mirrored));
        for cell in 0..plain.elevation.len() {
            assert_eq!(
                plain.elevation[cell].to_bits(),
                mirrored.elevation[image(cell)].to_bits(),
                "{spacing} m: bed of {cell}"
            );
        }
        for sill in plain.passes.iter() {
            let [a, b] = [sill.cell, sill.other(&plain.lattice)].map(image);
            let its = mirrored.passes.iter().find(|its| its.cell == a.min(b) && its.is_north == sill.is_north).unwrap();
            assert_eq!(
                [its.level, its.share, its.crest].map(f64::to_bits),
                [sill.level, sill.share, sill.crest].map(f64::to_bits)
            );
        }
    }
}

#[test]
fn sills_are_found_again_where_the_bed_changed() {
    let terrain = terrain(Vec2::ZERO, (120, 120), 1.0, |place| levee(place, 20.0, 0.0));
    let lattice = lattice(Vec2::ZERO, 12, 12, 10.0);
    let mut bed = place_bed(&terrain, &lattice, BedMethod::Mean, &Nothing, 0.0);
    let mut passes = PassSills::find(&terrain, &bed);
    let changed = [5, 17, 18, 66, 143];
    for cell in changed {
        bed.elevation[cell] += 0.7;
    }
    passes.find_again(&changed, &terrain, &bed);
    assert_eq!(passes, PassSills::find(&terrain, &bed));
}

#[test]
fn gaps_are_found_again_across_tiles() {
    // A levee from south to north with a gap every 37 m, on a lattice of nine tiles.
    let z = |place: Vec2| {
        let is_gap = (place.y % 37.0) < 5.0;
        let ground = 0.1 * ((place.x * 12.9 + place.y * 78.2).sin() * 43758.5).fract();
        ground + if (place.x - 322.5 - 0.1 * place.y).abs() < 3.0 && !is_gap { 3.0 } else { 0.0 }
    };
    let terrain = terrain(Vec2::ZERO, (700, 700), 1.0, z);
    let lattice = lattice(Vec2::ZERO, 70, 70, 10.0);
    let mut bed = place_bed(&terrain, &lattice, BedMethod::Mean, &Nothing, 0.0);
    bed.set(&ground_in_gaps(&terrain, &bed));
    let mut passes = PassSills::find(&terrain, &bed);
    assert!(passes.iter().filter(|sill| sill.share < 1.0).count() > 20);
    let changed: Vec<usize> = (0..lattice.len()).filter(|cell| cell % 70 == 5 || cell % 611 == 0).collect();
    for &cell in &changed {
        bed.elevation[cell] -= 0.3;
    }
    passes.find_again(&changed, &terrain, &bed);
    assert_eq!(passes, PassSills::find(&terrain, &bed));
}
