//! Van Leer's limiter, the harmonic mean of two slopes of the same sign: `vanLeer1974`.

/// Harmonic mean 2ab/(a + b) where `a` and `b` have the same sign, otherwise 0.
#[inline(always)]
pub fn van_leer(a: f64, b: f64) -> f64 {
    let product = a * b;
    if product > 0.0 { 2.0 * product / (a + b) } else { 0.0 }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values that are exact in binary")]
mod tests {
    use super::van_leer;

    #[test]
    fn keeps_equal_slopes_and_stops_at_extrema() {
        assert_eq!(van_leer(3.0, 3.0), 3.0);
        assert_eq!(van_leer(-1.0, 2.0), 0.0);
        assert_eq!(van_leer(0.0, 2.0), 0.0);
        assert!((van_leer(1.0, 3.0) - 1.5).abs() < 1e-15);
        assert!(van_leer(1e-3, 1e6) < 2.01e-3, "never more than twice the smaller slope");
    }
}
