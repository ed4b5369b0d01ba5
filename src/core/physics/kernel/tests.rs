//! Every kernel by quadrature.

use super::*;

const DIMENSIONS: [Dimension; 2] = [Dimension::One, Dimension::Two];

/// Calls a check with each shape and its name.
macro_rules! each_kernel {
    ($check:ident) => {
        $check::<CubicSpline>("cubic_spline");
        $check::<Quadratic>("quadratic");
        $check::<QuarticSpline>("quartic_spline");
        $check::<QuinticSpline>("quintic_spline");
        $check::<Gauss>("gauss");
        $check::<SuperGauss>("super_gauss");
        $check::<Bell>("bell");
        $check::<WendlandC2>("wendland_c2");
        $check::<WendlandC4>("wendland_c4");
    };
}

/// ∫ g(r) W dV and ∫ g(r) |W| dV by the midpoint rule over the support.
fn integrals<S: Shape>(dimension: Dimension, h: f64, g: impl Fn(f64) -> f64) -> (f64, f64) {
    let kernel = Smoothing::<S>::new(dimension);
    let cells = 20_000;
    let dr = kernel.support() * h / f64::from(cells);
    let terms = (0..cells).map(|k| {
        let r = (f64::from(k) + 0.5) * dr;
        let shell = match dimension {
            Dimension::One => 2.0,
            Dimension::Two => 2.0 * std::f64::consts::PI * r,
        };
        kernel.value(r, 1.0 / h) * shell * dr * g(r)
    });
    terms.fold((0.0, 0.0), |(sum, absolute), term| (sum + term, absolute + term.abs()))
}

#[test]
fn integrates_to_one() {
    fn check<S: Shape>(name: &str) {
        for h in [0.3, 1.0, 17.0] {
            for dimension in DIMENSIONS {
                // Midpoint rule with 20 000 cells on a piecewise smooth function: error below 1e-8.
                let (integral, _) = integrals::<S>(dimension, h, |_| 1.0);
                assert!((integral - 1.0).abs() < 1e-8, "{name} {dimension:?}: {integral}");
            }
        }
    }
    each_kernel!(check);
}

#[test]
fn slope_is_the_derivative() {
    fn check<S: Shape>(name: &str) {
        for dimension in DIMENSIONS {
            let kernel = Smoothing::<S>::new(dimension);
            for share in [0.05, 0.21, 0.39, 0.52, 0.68, 0.83, 0.96, 1.04, 1.3] {
                let (r, step) = (share * kernel.support() / 0.8, 1e-5);
                let difference = (kernel.value(r + step, 0.8) - kernel.value(r - step, 0.8)) / (2.0 * step);
                // Truncation 1e-10 times the third derivative, which jumps at the knots of the splines.
                assert!((difference - kernel.slope(r, 0.8)).abs() < 1e-8, "{name} {dimension:?} at {share}");
            }
        }
    }
    each_kernel!(check);
}

#[test]
fn support_ends_where_it_says() {
    fn check<S: Shape>(name: &str) {
        // The Gaussians are cut: their step is e⁻⁹ times a polynomial.
        let step = if name.contains("gauss") { 7e-4 } else { 1e-15 };
        for dimension in DIMENSIONS {
            let shape = S::new(dimension);
            let before = shape.shape(S::SUPPORT * (1.0 - 1e-9));
            assert!(before.abs() < step && (shape.shape(0.0) - 1.0).abs() < 1e-15, "{name}: {before:e}");
            for q in [S::SUPPORT, S::SUPPORT + 1e-9, 2.0 * S::SUPPORT] {
                let (value, slope) = (shape.shape(q), shape.slope_shape(q));
                assert!(value.abs() < 1e-30 && slope.abs() < 1e-30, "{name} at {q}: {value:e}, {slope:e}");
            }
        }
    }
    each_kernel!(check);
}

#[test]
fn falls_from_its_middle_outwards() {
    fn check<S: Shape>(name: &str) {
        for dimension in DIMENSIONS {
            let shape = S::new(dimension);
            let has_positive_slope = (0..300).any(|k| shape.slope_shape(f64::from(k) * 0.01) > 1e-15);
            // The price of its fourth order.
            assert_eq!(has_positive_slope, name == "super_gauss", "{name}");
        }
    }
    each_kernel!(check);
}

#[test]
fn all_kernels_are_stretched_to_one_second_moment() {
    fn check<S: Shape>(name: &str) {
        for dimension in DIMENSIONS {
            let spread = |(_, total): (f64, f64), (_, moment): (f64, f64)| (moment / total).sqrt();
            let found = spread(integrals::<S>(dimension, 1.7, |_| 1.0), integrals::<S>(dimension, 1.7, |r| r * r));
            let cubic = spread(
                integrals::<CubicSpline>(dimension, 1.7, |_| 1.0),
                integrals::<CubicSpline>(dimension, 1.7, |r| r * r),
            );
            // Two midpoint rules, the coarser one of 4000 cells.
            assert!((found / cubic - 1.0).abs() < 1e-6, "{name} {dimension:?}: {found} against {cubic}");
        }
    }
    each_kernel!(check);
}

#[test]
fn super_gaussian_has_no_second_moment() {
    for dimension in DIMENSIONS {
        let (moment, absolute) = integrals::<SuperGauss>(dimension, 1.0, |r| r * r);
        // What the cut at q = 3 leaves of it.
        assert!(moment.abs() < 0.02 * absolute, "{moment} of {absolute}");
    }
}

#[test]
fn cubic_spline_has_the_two_pieces_of_the_textbook() {
    assert!((CubicSpline.shape(0.5) - (1.0 - 1.5 * 0.25 + 0.75 * 0.125)).abs() < 1e-15);
    assert!((CubicSpline.shape(1.5) - 0.25 * 0.125).abs() < 1e-15);
}

/// Stretch and support of the documents: docs/theory.md holds the same table.
#[test]
fn stretches_are_those_of_the_documents() {
    fn check<S: Shape>(name: &str) {
        let theory = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/theory.md")).unwrap();
        let row = theory.lines().find(|line| line.starts_with(&format!("| `{name}` "))).unwrap();
        for dimension in DIMENSIONS {
            let kernel = Smoothing::<S>::new(dimension);
            let cell = format!("{:.3} ({:.2})", kernel.stretch(), kernel.support());
            println!("{name} {dimension:?} {cell}");
            assert!(row.contains(&cell), "{name}: {cell} is not in {row}");
        }
    }
    each_kernel!(check);
}
