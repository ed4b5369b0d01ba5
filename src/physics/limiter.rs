//! Limiters: from two slopes of one sign a slope between them, 0 at an extremum.
//!
//! ```text
//! van Leer:      2 a b / (a + b)                                                  `VanLeer1974`
//! monotonised:   min(2 min(a, b), (1 − s)(a + b)/2 + s max(a, b))                 s = 0 `VanLeer1977`, s = 1 superbee `Roe1986`
//! ```

/// Harmonic mean 2ab/(a + b) where `a` and `b` have the same sign, otherwise 0.
#[inline(always)]
pub fn van_leer(a: f64, b: f64) -> f64 {
    let product = a * b;
    if product > 0.0 { 2.0 * product / (a + b) } else { 0.0 }
}

/// The monotonised mean of two slopes of the same sign, otherwise 0; without a branch.
///
/// - `sharpness` s: 0 for the central mean, 1 for superbee, which steepens every gradient that it can
#[inline(always)]
pub fn monotonised(a: f64, b: f64, sharpness: f64) -> f64 {
    let (size_a, size_b) = (a.abs(), b.abs());
    let (least, most) = if size_a < size_b { (size_a, size_b) } else { (size_b, size_a) };
    let between = 0.5 * (least + most) + sharpness * (0.5 * (most - least));
    let size = if 2.0 * least < between { 2.0 * least } else { between };
    let signed = if a > 0.0 { size } else { -size };
    if a * b > 0.0 { signed } else { 0.0 }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values that are exact in binary")]
mod tests {
    use super::{monotonised, van_leer};

    #[test]
    fn keeps_equal_slopes_and_stops_at_extrema() {
        assert_eq!(van_leer(3.0, 3.0), 3.0);
        assert_eq!(van_leer(-1.0, 2.0), 0.0);
        assert_eq!(van_leer(0.0, 2.0), 0.0);
        assert!((van_leer(1.0, 3.0) - 1.5).abs() < 1e-15);
        assert!(van_leer(1e-3, 1e6) < 2.01e-3, "never more than twice the smaller slope");
    }

    #[test]
    fn monotonised_mean_has_its_known_values() {
        // Slopes 1 and 1.5: the central mean, or the larger one; 1 and 4: twice the smaller one by both.
        assert_eq!([0.0, 1.0].map(|s| monotonised(1.0, 1.5, s)), [1.25, 1.5]);
        assert_eq!([0.0, 1.0].map(|s| monotonised(-4.0, -1.0, s)), [-2.0, -2.0]);
        assert_eq!([0.0, 1.0].map(|s| monotonised(-1.0, 2.0, s)), [0.0, 0.0]);
        assert_eq!(monotonised(0.0, 2.0, 0.0), 0.0);
    }
}
