//! Beds of made terrain: upright steps, ridges, gaps, and scattered points.

use floodsim::bed::{BedParticles, Nothing, PassSills, Surface, place_bed_with};
use floodsim::constants::Constants;
use floodsim::lattice::Lattice;
use floodsim::math::Vec2;
use floodsim::scenario::methods::BedMethod;
use floodsim::terrain::{Layer, Raster, Terrain};

use super::Case;

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "steep banks",
        about: "walls in cells of 20 m, pixels of 2 m, as high as 0 to 4 m, beside level ground: what of them is in the bed (m)",
        feels: &["bed.upright_slope"],
        run: |constants| steps(constants, 20.0, 10, 4.0),
    },
    Case {
        name: "low steps",
        about: "walls in cells of 20 m, pixels of 0.5 m, as high as 0 to 2 m, beside level ground: what of them is in the bed (m)",
        feels: &["bed.least_step"],
        run: |constants| steps(constants, 20.0, 40, 2.0),
    },
    Case {
        name: "steps of a flume",
        about: "walls in cells of 0.05 m, pixels of 2.5 mm, as high as 0 to 10 mm, beside level ground: what of them is in the bed (m)",
        feels: &["bed.step_share"],
        run: |constants| steps(constants, 0.05, 20, 0.01),
    },
    Case {
        name: "rubble",
        about: "cells of four sides, the largest a quarter to two thirds of the cell: mean difference of the bed from the mean of all (m)",
        feels: &["bed.least_side"],
        run: rubble,
    },
    Case {
        name: "low ridges",
        about: "ridges one pixel wide, 0 to 0.2 m high, between cells of 20 m: mean height by which they leak (m)",
        feels: &["bed.sill_rise"],
        run: |constants| ridges(constants, 20.0, 0.2),
    },
    Case {
        name: "ridges of a flume",
        about: "ridges one pixel wide, 0 to 1 mm high, between cells of 0.05 m: mean height by which they leak (m)",
        feels: &["bed.sill_share"],
        run: |constants| ridges(constants, 0.05, 1e-3),
    },
    Case {
        name: "gaps by pixels",
        about: "a gap of 0.4 cells in a wall, 2.2 to 6.2 pixels to a cell: mean error of the share of the face that is open",
        feels: &["bed.gap_pixels"],
        run: |constants| {
            let pixels = (0..11).map(|k| 2.2 + 0.4 * f64::from(k));
            mean(pixels.map(|pixels| (gap(constants, (pixels, pixels), 0.4) - 0.4).abs()))
        },
    },
    Case {
        name: "gaps by oblong pixels",
        about: "a gap of 0.4 cells in a wall, pixels 1 to 3 times as long as wide: mean error of the share of the face that is open",
        feels: &["bed.pixel_ratio"],
        run: |constants| {
            let ratios = (0..21).map(|k| 1.0 + 0.1 * f64::from(k));
            mean(ratios.map(|ratio| (gap(constants, (6.2 * ratio, 6.2), 0.4) - 0.4).abs()))
        },
    },
    Case {
        name: "wide gaps",
        about: "gaps of 0.5 to 1 cell in a wall, 40 pixels to a cell: mean width that is open, over that of a cell",
        feels: &["bed.gap_open"],
        run: |constants| mean((20..40).map(|width| gap(constants, (40.0, 40.0), f64::from(width) / 40.0))),
    },
    Case {
        name: "scattered points",
        about: "smooth ground known at two points to the cell, bed method shepard: mean error of the bed (m)",
        feels: &["bed.shepard_support", "bed.plane_samples", "bed.plane_spread"],
        run: |constants| scattered(constants, BedMethod::Shepard, 0.0),
    },
    Case {
        name: "lines of points",
        about: "the same ground known at 1.2 points to the cell, along lines 2.5 cells apart: mean error of the bed (m)",
        feels: &["bed.shepard_support", "bed.plane_samples", "bed.plane_spread"],
        run: |constants| scattered(constants, BedMethod::Shepard, 2.5),
    },
    Case {
        name: "scattered points, squares",
        about: "smooth ground known at two points to the cell, bed method moving_least_squares: mean error of the bed (m)",
        feels: &["bed.squares_support", "bed.squares_response", "bed.plane_samples", "bed.plane_spread"],
        run: |constants| scattered(constants, BedMethod::MovingLeastSquares, 0.0),
    },
];

fn mean(numbers: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = numbers.fold((0.0, 0.0), |(sum, count), number| (sum + number, count + 1.0));
    sum / count
}

/// Terrain of pixels from the origin on, by the height (m) at the middle of each.
fn terrain((columns, rows): (usize, usize), pixel: Vec2, height: impl Fn(Vec2) -> f64) -> Terrain {
    let north = rows as f64 * pixel.y;
    let place =
        |k: usize| Vec2::new(((k % columns) as f64 + 0.5) * pixel.x, north - ((k / columns) as f64 + 0.5) * pixel.y);
    let values = (0..columns * rows).map(|k| height(place(k))).collect();
    let raster = Raster { columns, rows, west: 0.0, north, cell_x: pixel.x, cell_y: pixel.y, values };
    Terrain::new(vec![Layer::Raster(raster)]).unwrap()
}

fn lattice(columns: usize, rows: usize, spacing: f64) -> Lattice {
    Lattice::new(Vec2::ZERO, columns, rows, spacing)
}

/// Mean bed (m) of 200 cells whose western 60 % lie at 0 m, and whose rest stands 0 to `highest` (m) above that.
fn steps(constants: &Constants, spacing: f64, pixels: usize, highest: f64) -> f64 {
    const CELLS: usize = 200;
    let pixel = spacing / pixels as f64;
    let height = |place: Vec2| {
        let across = place.x / spacing;
        if across.fract() > 0.6 { highest * (across.floor() + 0.5) / CELLS as f64 } else { 0.0 }
    };
    let terrain = terrain((CELLS * pixels, pixels), Vec2::new(pixel, pixel), height);
    let by = (BedMethod::Mean, &constants.bed);
    let bed = place_bed_with(&terrain, &lattice(CELLS, 1, spacing), by, &Nothing, 0.03);
    mean(bed.elevation.into_iter())
}

/// Mean of |z_b − z̄| over cells of four sides, of which the largest takes 10 to 26 of 40 columns of pixels.
fn rubble(constants: &Constants) -> f64 {
    let height = |place: Vec2| {
        let (cell, column) = ((place.x / 10.0).floor(), (4.0 * place.x.rem_euclid(10.0)).floor());
        let largest = 10.0 + cell;
        let rest = (40.0 - largest) / 3.0;
        if column < largest { 0.0 } else { 4.0 * (1.0 + ((column - largest) / rest).floor().min(2.0)) }
    };
    let terrain = terrain((17 * 40, 40), Vec2::new(0.25, 0.25), height);
    let by = (BedMethod::Mean, &constants.bed);
    let bed = place_bed_with(&terrain, &lattice(17, 1, 10.0), by, &Nothing, 0.03);
    let of_all =
        |cell: usize| mean((0..40).map(|k| height(Vec2::new(10.0 * cell as f64 + 0.25 * f64::from(k) + 0.125, 0.0))));
    mean(bed.elevation.iter().enumerate().map(|(cell, z)| (z - of_all(cell)).abs()))
}

/// Mean height (m) of ridges that are not in the sills of the faces: they stand in the middle of level cells, 0 to `highest` (m) high.
fn ridges(constants: &Constants, spacing: f64, highest: f64) -> f64 {
    const CELLS: usize = 100;
    let pixel = spacing / 5.0;
    let crest = |cell: f64| highest * (cell + 0.5) / CELLS as f64;
    let height = |place: Vec2| {
        let cell = (place.x / spacing).floor();
        if (place.x / spacing - cell - 0.5).abs() < 0.1 { crest(cell) } else { 0.0 }
    };
    let terrain = terrain((5 * CELLS, 5), Vec2::new(pixel, pixel), height);
    let mut bed = BedParticles::from_elevation(lattice(CELLS, 1, spacing), vec![0.0; CELLS], 0.03);
    bed.constants = constants.bed;
    let sills = PassSills::find(&terrain, &bed);
    mean((0..CELLS - 1).map(|cell| {
        let sill = sills.between(cell, cell + 1).max(0.0);
        (crest(cell as f64 + 1.0) - sill).max(0.0)
    }))
}

/// The share of a face that is open by a gap as wide as a share of the cell, in a wall of one pixel along the face; so many pixels to the cell
/// across the wall and along it.
fn gap(constants: &Constants, (across, along): (f64, f64), width: f64) -> f64 {
    const CELLS: usize = 7;
    let pixel = Vec2::new(1.0 / across, 1.0 / along);
    let height = |place: Vec2| {
        let is_wall = (3.5 - 0.5 * pixel.x..3.5 + 0.5 * pixel.x).contains(&place.x);
        let is_gap = (place.y - 3.5).abs() < 0.5 * width;
        if is_wall && !is_gap { 2.0 } else { 0.0 }
    };
    let count = |pixel: f64| (CELLS as f64 / pixel).ceil() as usize;
    let terrain = terrain((count(pixel.x), count(pixel.y)), pixel, height);
    let lattice = lattice(CELLS, CELLS, 1.0);
    let cells = lattice.len();
    let mut bed = BedParticles::from_elevation(lattice, vec![0.0; cells], 0.03);
    bed.constants = constants.bed;
    let sills = PassSills::find(&terrain, &bed);
    let share = |cell: usize| {
        let sill = sills.iter().find(|sill| sill.cell == cell && !sill.is_north);
        sill.map_or(1.0, |sill| {
            if sill.share < 1.0 {
                sill.share
            } else if sill.level > 1.0 {
                0.0
            } else {
                1.0
            }
        })
    };
    // Of the two faces of the cell with the wall the narrower one decides.
    share(3 * CELLS + 2).min(share(3 * CELLS + 3))
}

/// Ground known at points alone.
struct Points {
    places: Vec<Vec2>,
}

fn ground(place: Vec2) -> f64 {
    (0.5 * place.x).sin() + (0.35 * place.y).cos() + 0.1 * place.x
}

impl Surface for Points {
    fn elevation(&self, map: Vec2) -> Option<f64> {
        let nearest = self.places.iter().min_by(|a, b| (**a - map).norm().total_cmp(&(**b - map).norm()));
        nearest.map(|place| ground(*place))
    }

    fn samples(&self, centre: Vec2, radius: f64, out: &mut Vec<(Vec2, f64)>) {
        let near = self.places.iter().filter(|place| (**place - centre).norm() < radius);
        out.extend(near.map(|&place| (place, ground(place))));
    }
}

/// Mean error (m) of the bed of 20 by 20 cells of 1 m from points in any order, or on lines so far (m) apart.
fn scattered(constants: &Constants, method: BedMethod, lines: f64) -> f64 {
    const CELLS: usize = 20;
    let mut state = 7_u64;
    let mut next = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let place = |_| {
        let (x, y) = (CELLS as f64 * next(), CELLS as f64 * next());
        // Survey boats do not keep their line.
        if lines > 0.0 { Vec2::new(((x / lines).floor() + 0.25 * next()) * lines, y) } else { Vec2::new(x, y) }
    };
    let count = if lines > 0.0 { 480 } else { 800 };
    let points = Points { places: (0..count).map(place).collect() };
    let lattice = lattice(CELLS, CELLS, 1.0);
    let bed = place_bed_with(&points, &lattice, (method, &constants.bed), &Nothing, 0.03);
    mean(bed.elevation.iter().enumerate().map(|(cell, z)| (z - ground(lattice.centre(cell))).abs()))
}
