//! Exactness for planes and quadratics, boundedness at steps, the same bits on any number of threads.

use super::*;
use crate::bed::Nothing;

/// A terrain given by a formula, by its samples, and by where it ends.
struct Made<F: Fn(Vec2) -> f64 + Sync> {
    formula: F,
    points: Vec<Vec2>,
    has_terrain: fn(Vec2) -> bool,
}

impl<F: Fn(Vec2) -> f64 + Sync> Surface for Made<F> {
    fn elevation(&self, map: Vec2) -> Option<f64> {
        (self.has_terrain)(map).then(|| (self.formula)(map))
    }

    fn samples(&self, centre: Vec2, radius: f64, out: &mut Vec<(Vec2, f64)>) {
        let near = self.points.iter().filter(|&&p| (p - centre).norm() <= radius && (self.has_terrain)(p));
        out.extend(near.map(|&p| (p, (self.formula)(p))));
    }
}

fn lattice() -> Lattice {
    Lattice::new(Vec2::new(100.0, 200.0), 12, 9, 4.0)
}

/// Points about every `step` metres over the lattice, moved by up to `jitter` of the step.
fn points(step: f64, jitter: f64) -> Vec<Vec2> {
    let size = lattice().size();
    let (columns, rows) = ((size.x / step) as usize, (size.y / step) as usize);
    let noise = |i: usize, factor: f64| ((i as f64 + 0.5) * factor).fract() - 0.5;
    (0..columns * rows)
        .map(|i| {
            let place = Vec2::new((i % columns) as f64 + 0.5, (i / columns) as f64 + 0.5);
            let moved = place + Vec2::new(noise(i, 0.618_034), noise(i, 0.754_878)) * (2.0 * jitter);
            lattice().to_map(moved * step)
        })
        .collect()
}

fn everywhere(_: Vec2) -> bool {
    true
}

/// Terrain with a hole, a bay and a strip one cell wide.
fn ragged(map: Vec2) -> bool {
    let local = lattice().to_local(map);
    let in_hole = (local - Vec2::new(14.0, 14.0)).norm() < 6.0;
    let beside_strip = local.x > 32.0 && !(16.0..20.0).contains(&local.y);
    !in_hole && !beside_strip
}

fn plane(place: Vec2) -> f64 {
    12.0 + 0.3 * (place.x - 100.0) - 0.17 * (place.y - 200.0)
}

fn quadratic(place: Vec2) -> f64 {
    let (x, y) = (place.x - 120.0, place.y - 215.0);
    5.0 + 0.2 * x - 0.1 * y + 0.5 * (0.02 * x * x + 2.0 * 0.007 * x * y - 0.03 * y * y)
}

#[test]
fn shepard_height_is_exact_for_a_plane() {
    for (step, jitter) in [(1.0, 0.0), (1.0, 0.45), (2.3, 0.3), (4.0, 0.0), (9.0, 0.4)] {
        for has_terrain in [everywhere, ragged] {
            let terrain = Made { formula: plane, points: points(step, jitter), has_terrain };
            let bed = place_bed(&terrain, &lattice(), BedMethod::Shepard, &Nothing, 0.03);
            for index in 0..bed.lattice.len() {
                let place = bed.lattice.to_map(bed.lattice.centre(index));
                assert_eq!(bed.has_terrain(index), has_terrain(place));
                let error = bed.elevation[index] - plane(place);
                // Round-off of sums over some 60 samples with values up to 26 m.
                assert!(error.is_nan() || error.abs() < 26.0 * 1e-12, "{error:e} at {place:?}, step {step}");
            }
        }
    }
}

#[test]
fn least_squares_are_exact_for_a_plane_and_inside_for_a_quadratic() {
    for (step, jitter) in [(1.0, 0.0), (1.0, 0.45), (2.3, 0.3), (4.0, 0.0), (9.0, 0.4)] {
        for has_terrain in [everywhere as fn(Vec2) -> bool, ragged] {
            let made = |formula| Made { formula, points: points(step, jitter), has_terrain };
            let [flat, curved] = [made(plane as fn(Vec2) -> f64), made(quadratic)]
                .map(|terrain| place_bed(&terrain, &lattice(), BedMethod::MovingLeastSquares, &Nothing, 0.03));
            for index in (0..flat.lattice.len()).filter(|&index| flat.has_terrain(index)) {
                let place = flat.lattice.to_map(flat.lattice.centre(index));
                let error = flat.elevation[index] - plane(place);
                // Round-off of sums over some hundred samples with values up to 26 m, four times amplified.
                assert!(error.abs() < 26.0 * 4e-12, "{error:e} at {place:?}, step {step}");
                let (column, row) = flat.lattice.column_row(index);
                let is_inside = (1..11).contains(&column) && (1..8).contains(&row);
                // Where samples are dense and all around; elsewhere the plane may stand in.
                if is_inside && step < 2.0 && !std::ptr::fn_addr_eq(has_terrain, ragged as fn(Vec2) -> bool) {
                    let error = curved.elevation[index] - quadratic(place);
                    assert!(error.abs() < 26.0 * 4e-12, "{error:e} at {place:?}, step {step}");
                }
            }
        }
    }
}

/// The bed with its curvatures.
fn with_curvature(mut bed: BedParticles) -> BedParticles {
    derive_curvatures(&mut bed);
    bed
}

#[test]
fn slope_is_exact_for_a_plane_and_along_a_strip() {
    for has_terrain in [everywhere, ragged] {
        let terrain = Made { formula: plane, points: Vec::new(), has_terrain };
        let bed = with_curvature(place_bed(&terrain, &lattice(), BedMethod::Pointwise, &Nothing, 0.03));
        for index in (0..bed.lattice.len()).filter(|&index| bed.has_terrain(index)) {
            let strip = !has_terrain(Vec2::new(146.0, 202.0)) && bed.lattice.centre(index).x > 36.0;
            // In a strip of one cell, nothing is known across it: the slope along it remains.
            let expected = if strip { Vec2::new(0.3, 0.0) } else { Vec2::new(0.3, -0.17) };
            assert!((bed.slope(index) - expected).norm() < 1e-12, "{:?} in cell {index}", bed.slope(index));
            let curvature = bed.curvature[index];
            assert!(curvature.xx.abs() + curvature.xy.abs() + curvature.yy.abs() < 1e-13);
        }
    }
}

#[test]
fn curvature_is_exact_for_a_quadratic_at_edges_too() {
    let terrain = Made { formula: quadratic, points: Vec::new(), has_terrain: everywhere };
    let bed = with_curvature(place_bed(&terrain, &lattice(), BedMethod::Pointwise, &Nothing, 0.03));
    for curvature in &bed.curvature {
        let error = [curvature.xx - 0.02, curvature.xy - 0.007, curvature.yy + 0.03];
        // Elevations of 10 m carry 1e-15 m; differences over 4 m and a condition of some hundreds give 1e-13 / m.
        assert!(error.iter().all(|e| e.abs() < 1e-12), "{error:?}");
    }
}

#[test]
fn curvature_beside_nodata_is_exact_or_zero() {
    let terrain = Made { formula: quadratic, points: Vec::new(), has_terrain: ragged };
    let bed = with_curvature(place_bed(&terrain, &lattice(), BedMethod::Pointwise, &Nothing, 0.03));
    let exact = |k: &Sym2| (k.xx - 0.02).abs() + (k.xy - 0.007).abs() + (k.yy + 0.03).abs() < 1e-11;
    let known = (0..bed.lattice.len()).filter(|&index| bed.has_terrain(index));
    let (exact, other): (Vec<_>, Vec<_>) = known.partition(|&index| exact(&bed.curvature[index]));
    assert!(other.iter().all(|&index| bed.curvature[index] == Sym2::default()));
    // Only the strip, of which three cells see nothing but each other, may lack a curvature.
    assert!(other.len() <= 3 && exact.len() > 60, "{} exact, {} zero", exact.len(), other.len());
}

#[test]
fn lonely_cell_is_flat() {
    let terrain =
        Made { formula: plane, points: Vec::new(), has_terrain: |p| (p.x - 110.0).abs() + (p.y - 210.0).abs() < 1.0 };
    let bed = with_curvature(place_bed(&terrain, &lattice(), BedMethod::Shepard, &Nothing, 0.03));
    let known: Vec<usize> = (0..bed.lattice.len()).filter(|&index| bed.has_terrain(index)).collect();
    assert_eq!(known.len(), 1);
    assert_eq!((bed.slope(known[0]), bed.curvature[known[0]]), (Vec2::ZERO, Sym2::default()));
}

#[test]
fn heights_at_a_step_stay_between_its_levels() {
    for (step, jitter) in [(1.0, 0.0), (1.0, 0.45), (2.3, 0.4)] {
        for cliff in [103.3, 119.0, 121.7, 146.9] {
            let formula = move |p: Vec2| if p.x + 0.3 * (p.y - 200.0) < cliff { 0.0 } else { 50.0 };
            let terrain = Made { formula, points: points(step, jitter), has_terrain: ragged };
            for method in [BedMethod::Shepard, BedMethod::MovingLeastSquares] {
                let bed = place_bed(&terrain, &lattice(), method, &Nothing, 0.03);
                let levels = -1e-9..=50.0 + 1e-9;
                let outside: Vec<f64> =
                    bed.elevation.iter().copied().filter(|z| !levels.contains(z) && !z.is_nan()).collect();
                assert!(outside.is_empty(), "{outside:?} with the cliff at {cliff}, step {step}, {method:?}");
            }
        }
    }
}

#[test]
fn detail_finer_than_the_lattice_is_smoothed() {
    // A washboard of 2 m on a lattice of 4 m: pointwise heights see one phase of it, the kernel mean its mean.
    let washboard = |p: Vec2| (std::f64::consts::PI * p.x).cos();
    let terrain = Made { formula: washboard, points: points(0.25, 0.0), has_terrain: everywhere };
    let bed = place_bed(&terrain, &lattice(), BedMethod::Shepard, &Nothing, 0.03);
    let inner = (0..bed.lattice.len()).filter(|&i| (1..11).contains(&bed.lattice.column_row(i).0));
    let largest = inner.map(|i| bed.elevation[i].abs()).fold(0.0, f64::max);
    // The transform of the B-spline at 2 m is below 1 %; the pointwise heights are all 1.
    assert!(largest < 0.02, "{largest}");
}

#[test]
fn same_bits_for_any_number_of_threads() {
    let rough = |p: Vec2| 3.0 * (0.7 * p.x).sin() * (0.9 * p.y).cos();
    let terrain = Made { formula: rough, points: points(1.0, 0.4), has_terrain: ragged };
    let bits = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let bed = pool.install(|| with_curvature(place_bed(&terrain, &lattice(), BedMethod::Shepard, &Nothing, 0.03)));
        let elevations = bed.elevation.iter().map(|z| z.to_bits());
        elevations.chain(bed.curvature.iter().map(|k| k.xy.to_bits())).collect::<Vec<_>>()
    };
    assert_eq!(bits(1), bits(2));
    assert_eq!(bits(1), bits(5));
}
