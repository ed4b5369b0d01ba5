use super::*;
use crate::terrain::{Layer, Raster};

/// Pixels of `pixel` (m) over 400 m by 400 m, 0 where `is_low` and 3 m elsewhere, on ground that falls.
fn raster(pixel: f64, is_low: impl Fn(Vec2) -> bool) -> Layer {
    let count = (400.0 / pixel) as usize;
    let place = |cell: usize| {
        let (column, row) = ((cell % count) as f64, (cell / count) as f64);
        Vec2::new((column + 0.5) * pixel, 400.0 - (row + 0.5) * pixel)
    };
    let height = |place: Vec2| if is_low(place) { 0.0 } else { 3.0 } - 0.002 * place.x;
    let values = (0..count * count).map(place).map(height).collect();
    Layer::Raster(Raster { columns: count, rows: count, west: 0.0, north: 400.0, cell_x: pixel, cell_y: pixel, values })
}

fn terrain(pixel: f64, is_low: impl Fn(Vec2) -> bool) -> Terrain {
    Terrain::new(vec![raster(pixel, is_low)]).unwrap()
}

fn banks(terrain: &Terrain) -> Vec<Vec<Vec2>> {
    find(terrain, &Lattice::new(Vec2::ZERO, 40, 40, 10.0), &BedConstants::DEFAULT, |_| true)
}

#[test]
fn the_banks_of_a_channel_askew_are_straight_lines_on_them() {
    for degrees in [5.0_f64, 17.0, 30.0, 45.0, 63.0] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let off = |place: Vec2| (place.y - 200.0) * cosine - (place.x - 200.0) * sine;
        for (pixel, tolerance) in [(10.0, 3.0), (2.0, 0.6)] {
            let lines = banks(&terrain(pixel, |place| off(place).abs() < 25.0));
            assert_eq!(lines.len(), 2, "{degrees} degrees, pixels of {pixel} m: {lines:?}");
            for point in lines.iter().flatten() {
                let error = (off(*point).abs() - 25.0).abs();
                assert!(error < tolerance, "{degrees} degrees, pixels of {pixel} m: {point:?} is {error} m off");
            }
        }
    }
}

#[test]
fn a_corner_stays_a_corner_and_a_pond_is_a_ring() {
    let is_low = |place: Vec2| place.x > 100.0 && place.x < 304.0 && place.y > 120.0 && place.y < 260.0;
    let lines = banks(&terrain(4.0, is_low));
    assert_eq!(lines.len(), 1);
    for corner in [(100.0, 120.0), (304.0, 120.0), (304.0, 260.0), (100.0, 260.0)] {
        let corner = Vec2::new(corner.0, corner.1);
        let nearest = lines[0].iter().map(|point| (*point - corner).norm()).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-3, "{corner:?}: {nearest}, {lines:?}");
    }
}

#[test]
fn banks_on_the_sides_of_squares_are_left_to_them() {
    let is_low = |place: Vec2| place.x > 100.0 && place.x < 300.0 && place.y > 120.0 && place.y < 260.0;
    assert_eq!(banks(&terrain(10.0, is_low)).len(), 0);
    assert_eq!(banks(&terrain(2.0, is_low)).len(), 0);
    assert_eq!(banks(&terrain(2.0, |place| is_low(place - Vec2::new(4.0, 0.0)))).len(), 1);
}

#[test]
fn a_winding_bank_has_every_pixel_on_its_own_side() {
    for pixel in [10.0, 4.0, 2.0] {
        let middle = |x: f64| 200.0 + 60.0 * (x / 60.0).sin();
        let is_low = |place: Vec2| (place.y - middle(place.x)).abs() < 25.0;
        let lines = banks(&terrain(pixel, is_low));
        let (mut wrong, mut near) = (0, 0);
        let count = (400.0 / pixel) as usize;
        for cell in 0..count * count {
            let at = |k: usize| (k as f64 + 0.5) * pixel;
            let place = Vec2::new(at(cell % count), at(cell / count));
            if !(20.0..380.0).contains(&place.x) || ((place.y - middle(place.x)).abs() - 25.0).abs() > 2.0 * pixel {
                continue;
            }
            // From the middle of the channel a way to a pixel of the bank crosses one of the lines, and to its own pixels none;
            // a little askew, for lines turn between pixels of one column.
            let from = Vec2::new(place.x + 0.01, middle(place.x));
            let crossed = lines.iter().flat_map(|line| line.windows(2));
            let crossed = crossed.filter(|ends| crate::math::segments_cross([from, place], [ends[0], ends[1]]));
            near += 1;
            wrong += usize::from((crossed.count() % 2 == 1) == is_low(place));
        }
        assert!(wrong == 0 && near > 200, "pixels of {pixel} m: {wrong} of {near} on the wrong side");
    }
}

#[test]
fn slopes_and_rocks_have_no_banks() {
    assert_eq!(banks(&terrain(10.0, |_| true)), Vec::<Vec<Vec2>>::new());
    let rock = |place: Vec2| (place - Vec2::new(205.0, 205.0)).norm() > 5.0;
    assert_eq!(banks(&terrain(10.0, rock)), Vec::<Vec<Vec2>>::new());
}

#[test]
fn pixels_wider_than_cells_have_no_banks_beside_a_fine_raster() {
    // A slope of one in ten: between pixels of 40 m it rises by 4 m.
    let raster = |west: f64, north: f64, cell: f64, count: usize| {
        let place = |k: usize| west + ((k % count) as f64 + 0.5) * cell;
        let values = (0..count * count).map(|k| 0.1 * place(k)).collect();
        Layer::Raster(Raster { columns: count, rows: count, west, north, cell_x: cell, cell_y: cell, values })
    };
    let terrain = Terrain::new(vec![raster(0.0, 400.0, 40.0, 10), raster(200.0, 300.0, 2.0, 40)]).unwrap();
    assert_eq!(banks(&terrain), Vec::<Vec<Vec2>>::new());
}

#[test]
fn a_raster_as_wide_as_the_cells_has_its_banks_beside_a_finer_one() {
    let (sine, cosine) = 30.0_f64.to_radians().sin_cos();
    let off = |place: Vec2| (place.y - 200.0) * cosine - (place.x - 200.0) * sine;
    let is_low = |place: Vec2| off(place).abs() < 25.0;
    let inset = |cell: f64, count: usize| {
        let place =
            |k: usize| Vec2::new(100.0 + ((k % count) as f64 + 0.5) * cell, 300.0 - ((k / count) as f64 + 0.5) * cell);
        let values = (0..count * count).map(|k| if is_low(place(k)) { 0.0 } else { 3.0 }).collect();
        Layer::Raster(Raster {
            columns: count,
            rows: count,
            west: 100.0,
            north: 300.0,
            cell_x: cell,
            cell_y: cell,
            values,
        })
    };
    let whole = raster(10.0, is_low);
    let lines = banks(&Terrain::new(vec![whole, inset(2.0, 40)]).unwrap());
    assert_eq!(lines.len(), 2, "they go on over the seams: {lines:?}");
    let length = |line: &Vec<Vec2>| line.windows(2).map(|ends| (ends[1] - ends[0]).norm()).sum::<f64>();
    let sum = lines.iter().map(length).sum::<f64>();
    assert!((820.0..940.0).contains(&sum), "{sum} m of 2 · 462: {lines:?}");
    assert!(lines.iter().flatten().all(|point| (off(*point).abs() - 25.0).abs() < 3.0), "{lines:?}");
}
