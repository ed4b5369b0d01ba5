//! Limiters: from two slopes of one sign a slope between them, 0 at an extremum. Without branches.
//!
//! ```text
//! van Leer:             2 a b / (a + b)                            `VanLeer1974`
//! monotonised central:  min(2 min(|a|, |b|), |a + b| / 2)          `VanLeer1977`
//! monotonised by κ:     min(2 min(|a|, |b|), |(1 − κ) a + (1 + κ) b| / 2)   `VanLeer1985`
//! superbee:  min(2 min(|a|, |b|), max(|a|, |b|))   `Roe1986`
//! ```

/// Harmonic mean 2ab/(a + b) where `a` and `b` have the same sign, otherwise 0.
#[inline(always)]
pub fn van_leer(a: f64, b: f64) -> f64 {
    let product = a * b;
    let sum = a + b;
    let safe = if product > 0.0 { sum } else { 1.0 };
    let positive = if product > 0.0 { product } else { 0.0 };
    2.0 * positive / safe
}

/// Mean of the slopes that weighs `b` more by κ, but never more than twice the smaller one, where both have the same sign; otherwise 0.
/// κ = 0 is the central mean, 1/3 of third order with `b` towards the face.
#[inline(always)]
pub fn monotonised(a: f64, b: f64, kappa: f64) -> f64 {
    2.0 * half_monotonised(a, b, kappa)
}

/// Half of [`monotonised`]: the difference over the half of the way to a face.
#[inline(always)]
pub fn half_monotonised(a: f64, b: f64, kappa: f64) -> f64 {
    let (size_a, size_b) = (a.abs(), b.abs());
    let least = if size_a < size_b { size_a } else { size_b };
    let half_mean = 0.25 * (1.0 - kappa) * size_a + 0.25 * (1.0 + kappa) * size_b;
    let size = if least < half_mean { least } else { half_mean };
    let signed = if b > 0.0 { size } else { -size };
    if a * b > 0.0 { signed } else { 0.0 }
}

/// The larger slope, but never more than twice the smaller one, where both have the same sign; otherwise 0. It steepens every
/// gradient that it can.
#[inline(always)]
pub fn superbee(a: f64, b: f64) -> f64 {
    let (size_a, size_b) = (a.abs(), b.abs());
    let (least, most) = if size_a < size_b { (size_a, size_b) } else { (size_b, size_a) };
    let size = if 2.0 * least < most { 2.0 * least } else { most };
    let signed = if a > 0.0 { size } else { -size };
    if a * b > 0.0 { signed } else { 0.0 }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values that are exact in binary")]
mod tests {
    use super::{monotonised, superbee, van_leer};

    #[test]
    fn keeps_equal_slopes_and_stops_at_extrema() {
        assert_eq!(van_leer(3.0, 3.0), 3.0);
        assert_eq!(van_leer(-1.0, 2.0), 0.0);
        assert_eq!(van_leer(0.0, 2.0), 0.0);
        assert!((van_leer(1.0, 3.0) - 1.5).abs() < 1e-15);
        assert!(van_leer(1e-3, 1e6) < 2.01e-3, "never more than twice the smaller slope");
    }

    #[test]
    fn the_monotonised_central_mean_is_a_mean_until_twice_the_smaller_slope() {
        assert_eq!((monotonised(1.0, 2.0, 0.0), monotonised(-2.0, -1.0, 0.0)), (1.5, -1.5));
        assert_eq!((monotonised(1.0, 8.0, 0.0), monotonised(-8.0, -1.0, 0.0)), (2.0, -2.0));
        assert_eq!((monotonised(-1.0, 2.0, 0.0), monotonised(0.0, 2.0, 0.0)), (0.0, 0.0));
        assert_eq!((monotonised(1.0, 2.0, 0.5), monotonised(-2.0, -1.0, 0.5)), (1.75, -1.25));
        assert_eq!((monotonised(1.0, 8.0, 0.5), monotonised(-1.0, 2.0, 0.5)), (2.0, 0.0));
    }

    #[test]
    fn superbee_has_its_known_values() {
        assert_eq!((superbee(1.0, 1.5), superbee(-4.0, -1.0)), (1.5, -2.0));
        assert_eq!((superbee(-1.0, 2.0), superbee(0.0, 2.0)), (0.0, 0.0));
    }
}
