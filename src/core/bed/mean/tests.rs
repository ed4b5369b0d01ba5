//! Exactness for planes at any ratio and beside all that ends, means of rough terrain, mirrored and turned terrain, layers, surveys.

use crate::bed::{BedParticles, LeftOut, Nothing, place_bed};
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::methods::BedMethod;
use crate::terrain::PointInterpolation;
use crate::terrain::{Layer, Overlay, Raster, Survey, SurveyPoint, Terrain};

/// Cells of rasters (m).
const CELL: f64 = 2.0;

fn raster(columns: usize, rows: usize, elevation: impl Fn(Vec2) -> f64) -> Raster {
    let mut raster = Raster {
        columns,
        rows,
        west: 1000.0,
        north: 2000.0 + CELL * rows as f64,
        cell_x: CELL,
        cell_y: CELL,
        values: vec![0.0; columns * rows],
    };
    for i in 0..columns * rows {
        raster.values[i] = elevation(raster.centre(i % columns, i / columns));
    }
    raster
}

fn terrain(raster: Raster) -> Terrain {
    Terrain::new(vec![Layer::Raster(raster)]).unwrap()
}

/// A lattice over a raster, by the ratio of their spacings and a shift in cells of the raster.
fn lattice(raster: &Raster, ratio: f64, shift: f64) -> Lattice {
    let spacing = ratio * CELL;
    let count = |cells: usize| ((cells as f64 + shift) / ratio).ceil() as usize;
    let origin = Vec2::new(raster.west - shift * CELL, raster.south() - shift * CELL);
    Lattice::new(origin, count(raster.columns), count(raster.rows), spacing)
}

fn mean_bed(terrain: &Terrain, lattice: &Lattice) -> BedParticles {
    place_bed(terrain, lattice, BedMethod::Mean, &Nothing, 0.03)
}

fn plane(place: Vec2) -> f64 {
    80.0 + 0.3 * (place.x - 1000.0) - 0.17 * (place.y - 2000.0)
}

/// Numbers without a pattern, 0 to 1.
fn noise(place: Vec2) -> f64 {
    ((place.x * 12.9898 + place.y * 78.233).sin() * 43_758.545).rem_euclid(1.0)
}

/// Where a cell of a square of so many columns lies after a turn.
type Turn = fn(usize, usize, usize) -> (usize, usize);

/// A disc of ground that is left out.
struct Disc(Vec2, f64);

impl LeftOut for Disc {
    fn is_near(&self, _: usize) -> bool {
        true
    }

    fn holds(&self, _: usize, map: Vec2) -> bool {
        (map - self.0).norm() < self.1
    }
}

#[test]
fn a_plane_is_exact_at_any_ratio_and_shift_beside_edges_nodata_and_what_is_left_out() {
    let middle = Vec2::new(1033.0, 2041.0);
    let house = Disc(Vec2::new(1061.0, 2022.0), 9.5);
    for ratio in [0.3, 0.5, 0.77, 1.0, 1.25, 1.5, 2.0, 2.6, 3.0, 5.0, 7.3, 12.0] {
        for shift in [0.0, 0.25, 0.4, 0.5, 0.83] {
            let whole = raster(48, 40, |place| if (place - middle).norm() < 11.0 { f64::NAN } else { plane(place) });
            let lattice = lattice(&whole, ratio, shift);
            let mut with_house = whole.clone();
            for i in 0..with_house.values.len() {
                if house.holds(0, with_house.centre(i % 48, i / 48)) {
                    with_house.values[i] += 30.0;
                }
            }
            let (bare, built) = (terrain(whole), terrain(with_house));
            let beds = [mean_bed(&bare, &lattice), place_bed(&built, &lattice, BedMethod::Mean, &house, 0.03)];
            for (bed, is_built) in beds.iter().zip([false, true]) {
                for cell in 0..lattice.len() {
                    let place = lattice.to_map(lattice.centre(cell));
                    assert_eq!(bed.has_terrain(cell), bare.elevation(place).is_some(), "cell {cell}");
                    // In the house itself there may be nothing but what is left out.
                    let is_in_house = is_built && (place - house.0).norm() < house.1 + CELL;
                    let error = bed.elevation[cell] - plane(place);
                    assert!(
                        error.is_nan() || is_in_house || error.abs() < 1e-12 * 110.0,
                        "{error:e} at {place:?}, ratio {ratio}, shift {shift}, house {is_built}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_mean_of_rough_terrain_is_that_of_its_area() {
    // No upright steps: those are a matter of `upright.rs`.
    let rough = raster(36, 24, |place| 300.0 + 0.9 * noise(place));
    for ratio in [1, 2, 3, 4, 6, 12] {
        let lattice = lattice(&rough, ratio as f64, 0.0);
        let bed = mean_bed(&terrain(rough.clone()), &lattice);
        for cell in 0..lattice.len() {
            let (column, row) = lattice.column_row(cell);
            let north = rough.rows - (row + 1) * ratio;
            let values = (0..ratio * ratio).map(|i| rough.value(column * ratio + i % ratio, north + i / ratio));
            let mean = values.sum::<f64>() / (ratio * ratio) as f64;
            // Sums of up to 144 numbers of 300 m.
            assert!((bed.elevation[cell] - mean).abs() < 300.0 * 144.0 * f64::EPSILON, "ratio {ratio}, cell {cell}");
            if ratio == 1 {
                assert_eq!(bed.elevation[cell].to_bits(), rough.value(column, north).to_bits());
            }
        }
    }
    // Half of a cell each: the mean of both.
    let bed = mean_bed(&terrain(rough.clone()), &lattice(&rough, 1.0, 0.5));
    let corners = [(0, 23), (1, 23), (0, 22), (1, 22)].map(|(column, row)| rough.value(column, row));
    assert!((bed.elevation[bed.lattice.index(1, 1)] - corners.iter().sum::<f64>() / 4.0).abs() < 1e-12);
    // One and a half cells: whole ones count twice as much as half ones, and the rest of the offset is a matter of the slope.
    let bed = mean_bed(&terrain(rough.clone()), &lattice(&rough, 1.5, 0.0));
    let value = |column: usize, row: usize| rough.value(column, 23 - row);
    let mean = (4.0 * value(0, 0) + 2.0 * (value(1, 0) + value(0, 1)) + value(1, 1)) / 9.0;
    // The mean place lies a twelfth of a cell beside the middle, and slopes are 0.9 m to a cell at most.
    assert!((bed.elevation[0] - mean).abs() < 0.9 / 12.0 * 2.0);
}

#[test]
fn mirrored_and_turned_terrain_has_the_mirrored_and_turned_bed_to_the_bit() {
    for (ratio, is_torn) in [(0.5, false), (1.5, true), (2.0, false), (3.0, true), (2.25, false), (4.5, false)] {
        let own = raster(36, 36, |place| {
            let value = noise(place * 0.7);
            if is_torn && value > 0.93 { f64::NAN } else { 100.0 * value + place.x * 0.01 }
        });
        let lattice = lattice(&own, ratio, 0.0);
        let side = lattice.columns;
        assert_eq!(side * side, lattice.len());
        let bed = mean_bed(&terrain(own.clone()), &lattice);
        let turns: [Turn; 4] =
            [|i, j, n| (n - 1 - i, j), |i, j, n| (i, n - 1 - j), |i, j, _| (j, i), |i, j, n| (n - 1 - j, i)];
        for (number, turn) in turns.into_iter().enumerate() {
            let mut other = own.clone();
            for (i, value) in own.values.iter().enumerate() {
                // Rows of a raster count from the north.
                let (column, row) = turn(i % 36, 35 - i / 36, 36);
                other.values[(35 - row) * 36 + column] = *value;
            }
            let turned = mean_bed(&terrain(other), &lattice);
            for cell in 0..lattice.len() {
                let (column, row) = turn(cell % side, cell / side, side);
                let found = turned.elevation[lattice.index(column, row)];
                assert_eq!(found.to_bits(), bed.elevation[cell].to_bits(), "turn {number}, ratio {ratio}, cell {cell}");
            }
        }
    }
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let rough = raster(50, 41, |place| if noise(place) > 0.9 { f64::NAN } else { 40.0 * noise(place * 0.3) });
    let lattice = lattice(&rough, 2.3, 0.2);
    let terrain = terrain(rough);
    let bits = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let bed = pool.install(|| mean_bed(&terrain, &lattice));
        bed.elevation.iter().map(|z| z.to_bits()).collect::<Vec<_>>()
    };
    assert_eq!(bits(1), bits(2));
    assert_eq!(bits(1), bits(5));
}

#[test]
fn no_height_leaves_the_range_of_the_terrain_beside_a_cliff_and_flat_ground_stays_flat() {
    for ratio in [0.3, 0.8, 1.0, 1.4, 2.0, 3.7, 8.0] {
        for cliff in [1003.0, 1020.0, 1047.1, 1076.9] {
            let step = raster(40, 30, |place| {
                let is_torn = noise(place * 0.6) > 0.8;
                let is_high = place.x + 0.3 * (place.y - 2000.0) > cliff;
                if is_torn {
                    f64::NAN
                } else if is_high {
                    53.3
                } else {
                    3.3
                }
            });
            let bed = mean_bed(&terrain(step.clone()), &lattice(&step, ratio, 0.3));
            let levels = 3.3 - 1e-12..=53.3 + 1e-12;
            assert!(bed.elevation.iter().all(|z| z.is_nan() || levels.contains(z)), "ratio {ratio}, cliff {cliff}");
        }
        let flat = raster(40, 30, |place| if noise(place) > 0.8 { f64::NAN } else { 3.3 });
        let bed = mean_bed(&terrain(flat.clone()), &lattice(&flat, ratio, 0.3));
        assert!(bed.elevation.iter().all(|z| z.is_nan() || z.to_bits() == 3.3_f64.to_bits()), "ratio {ratio}");
    }
}

#[test]
fn several_layers_count_as_they_lie_over_each_other() {
    // A town in cells of 2 m over country in cells of 8 m.
    let country = |elevation: &dyn Fn(Vec2) -> f64| {
        let mut coarse = raster(20, 16, |_| 0.0);
        (coarse.cell_x, coarse.cell_y, coarse.north) = (8.0, 8.0, 2000.0 + 8.0 * 16.0);
        for i in 0..coarse.values.len() {
            coarse.values[i] = elevation(coarse.centre(i % 20, i / 20));
        }
        coarse
    };
    let town = |elevation: &dyn Fn(Vec2) -> f64| {
        let mut fine = raster(25, 21, |_| 0.0);
        (fine.west, fine.north) = (1036.0, 2090.0);
        for i in 0..fine.values.len() {
            fine.values[i] = elevation(fine.centre(i % 25, i / 25));
        }
        fine
    };
    let both = |elevation: &dyn Fn(Vec2) -> f64, overlay: Overlay, height: f64| {
        let raised = |place: Vec2| elevation(place) + height;
        let layers = [(Layer::Raster(country(elevation)), Overlay::Replace), (Layer::Raster(town(&raised)), overlay)];
        Terrain::with_overlays(layers.into()).unwrap()
    };
    for spacing in [8.0, 9.5, 16.0, 20.0] {
        let count = |length: f64| (length / spacing).ceil() as usize;
        let origin = Vec2::new(1000.0, 2000.0);
        let lattice = Lattice::new(origin, count(160.0), count(128.0), spacing);
        let bed = mean_bed(&both(&plane, Overlay::Replace, 0.0), &lattice);
        for cell in (0..lattice.len()).filter(|&cell| bed.has_terrain(cell)) {
            let error = bed.elevation[cell] - plane(lattice.to_map(lattice.centre(cell)));
            assert!(error.abs() < 1e-12 * 130.0, "{error:e} in cell {cell}, spacing {spacing}");
        }
        // Levels: each counts with its area in the cell.
        for (overlay, height, share) in [
            (Overlay::Replace, 4.0, 1.0),
            (Overlay::Min, 4.0, 0.0),
            (Overlay::Max, 4.0, 1.0),
            (Overlay::Min, -4.0, 1.0),
        ] {
            let bed = mean_bed(&both(&|_| 10.0, overlay, height), &lattice);
            let cell = lattice.cell_of(Vec2::new(36.0, 70.0)).unwrap();
            let west = lattice.centre(cell).x - 0.5 * spacing;
            let of_town = ((west + spacing - 36.0) / spacing).clamp(0.0, 1.0);
            let expected = 10.0 + share * height * of_town;
            // A cell of the country that the town covers in part counts at its own centre: some of the step is taken for a slope.
            let limit = if share > 0.0 { 0.5 } else { 1e-12 };
            let found = bed.elevation[cell];
            assert!((found - expected).abs() < limit, "{overlay:?} {height}, {spacing} m: {found}, not {expected}");
        }
    }
}

#[test]
fn survey_points_count_with_their_area_and_a_plane_is_exact() {
    // Points every 2 m, moved by up to half a metre, ten times as many in one corner.
    let mut points: Vec<SurveyPoint> = Vec::new();
    let mut push = |x: f64, y: f64| {
        let place = Vec2::new(x, y);
        let position = place + Vec2::new(noise(place) - 0.5, noise(place * 1.7) - 0.5);
        points.push(SurveyPoint { position, elevation: plane(position) });
    };
    (0..60 * 60).for_each(|i| push(1000.0 + 2.0 * f64::from(i % 60), 2000.0 + 2.0 * f64::from(i / 60)));
    (0..40 * 40).for_each(|i| push(1020.3 + 0.6 * f64::from(i % 40), 2020.1 + 0.6 * f64::from(i / 40)));
    for method in [PointInterpolation::NaturalNeighbour, PointInterpolation::InverseDistance] {
        for spacing in [2.5, 5.0, 10.0, 23.0] {
            // Inverse distance is no plane between the points.
            if method == PointInterpolation::InverseDistance && spacing < 6.0 {
                continue;
            }
            let survey = Survey::new(points.clone(), method, 10.0).unwrap();
            let terrain = Terrain::new(vec![Layer::Survey(survey)]).unwrap();
            let count = (112.0 / spacing) as usize;
            let lattice = Lattice::new(Vec2::new(1003.0, 2003.0), count, count, spacing);
            let bed = mean_bed(&terrain, &lattice);
            for cell in 0..lattice.len() {
                let error = bed.elevation[cell] - plane(lattice.to_map(lattice.centre(cell)));
                // Natural neighbours are ratios of areas, with coordinates of 100 m.
                assert!(error.abs() < 1e-9, "{error:e} in cell {cell}, {method:?}, {spacing} m");
            }
        }
    }
}
