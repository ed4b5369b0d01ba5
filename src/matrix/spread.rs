//! How a value of a study is spread: between which bounds, or by which distribution, and what it is at a share of it.
//!
//! A value has one number and one unit, `35 min`. Its quantile x(p), 0 < p < 1:
//!
//! ```text
//! uniform      x = a + p (b − a)
//! triangular   x = a + √(p (b − a)(c − a))             p ≤ (c − a)/(b − a), with its mode c
//!              x = b − √((1 − p)(b − a)(b − c))        above
//! normal       x = μ + σ Φ⁻¹(p)
//! lognormal    x = m s^Φ⁻¹(p)                          with its median m, and a factor s of which 68 % lie within
//! ```

use crate::study::{Amount, rounded};

/// A distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Law {
    /// Equally likely from `from` to `to`.
    Uniform { from: f64, to: f64 },
    /// From `from` to `to`, likeliest at `mode`.
    Triangular { from: f64, mode: f64, to: f64 },
    /// With a mean and a standard deviation.
    Normal { mean: f64, deviation: f64 },
    /// With a median, and the factor by which 68 % lie below and above it at most.
    Lognormal { median: f64, factor: f64 },
}

impl Law {
    /// The value that a share `p` of all values does not exceed; 0 < `p` < 1.
    pub fn quantile(self, p: f64) -> f64 {
        debug_assert!(p > 0.0 && p < 1.0);
        match self {
            Law::Uniform { from, to } => from + p * (to - from),
            Law::Triangular { from: a, mode: c, to: b } if p * (b - a) <= c - a => a + (p * (b - a) * (c - a)).sqrt(),
            Law::Triangular { from: a, mode: c, to: b } => b - ((1.0 - p) * (b - a) * (b - c)).sqrt(),
            Law::Normal { mean, deviation } => mean + deviation * standard_normal(p),
            Law::Lognormal { median, factor } => median * factor.powf(standard_normal(p)),
        }
    }

    /// The distribution in words; `unit` follows its numbers.
    pub fn words(self, unit: &str) -> String {
        let text = |number: f64| Amount { number, unit: unit.to_owned() }.text();
        match self {
            Law::Uniform { from, to } => format!("uniform from {} to {}", text(from), text(to)),
            Law::Triangular { from, mode, to } => {
                format!("triangular from {} to {}, likeliest {}", text(from), text(to), text(mode))
            }
            Law::Normal { mean, deviation } => {
                format!("normal, mean {}, standard deviation {}", text(mean), text(deviation))
            }
            Law::Lognormal { median, factor } => {
                format!("lognormal, median {}, 68 % within a factor of {}", text(median), rounded(factor))
            }
        }
    }
}

/// Φ⁻¹(p), by halving: Φ(x) = erfc(−x/√2)/2 rises.
fn standard_normal(p: f64) -> f64 {
    /// Beyond it lies less than the smallest share that a double can be apart from 0 or 1.
    const WIDEST: f64 = 40.0;
    /// Halvings after which the bounds are neighbours.
    const HALVINGS: usize = 64;
    let (mut low, mut high) = (-WIDEST, WIDEST);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if 0.5 * libm::erfc(-middle * std::f64::consts::FRAC_1_SQRT_2) < p { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_tables() {
        // Abramowitz and Stegun, table 26.1 and 26.5.
        for (p, x) in
            [(0.5, 0.0), (0.841_344_746_068_543, 1.0), (0.975, 1.959_963_984_540_054), (0.001, -3.090_232_306_167_813)]
        {
            assert!((standard_normal(p) - x).abs() < 1e-12, "{p}: {}", standard_normal(p));
        }
        let triangle = Law::Triangular { from: 0.0, mode: 1.0, to: 4.0 };
        // Its area up to 1 is a quarter; half of it lies below 4 − √6.
        assert!((triangle.quantile(0.25) - 1.0).abs() < 1e-12);
        assert!((triangle.quantile(0.5) - (4.0 - 6.0_f64.sqrt())).abs() < 1e-12);
        let one_above = 0.841_344_746_068_543;
        assert!((Law::Lognormal { median: 30.0, factor: 2.0 }.quantile(one_above) - 60.0).abs() < 1e-9);
        assert!((Law::Normal { mean: 3.0, deviation: 0.5 }.quantile(one_above) - 3.5).abs() < 1e-12);
        assert!((Law::Uniform { from: 1.0, to: 3.0 }.quantile(0.25) - 1.5).abs() < 1e-12);
    }
}
