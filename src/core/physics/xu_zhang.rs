//! Breach of an embankment dam of homogeneous or zoned fill by its erodibility, after `XuZhang2009`: from V_w (m³), the water above its bottom, and
//! h (m), its height. Here h stands for the height of the dam and the depth of that water, too.
//!
//! ```text
//! B   = h 0.787 (h/15)^0.133 (V_w^⅓/h)^0.652 e^b          mean width
//! B_t = h 1.062 (h/15)^0.092 (V_w^⅓/h)^0.508 e^b          width at the top
//! Q   = √(g V_w^(5/3)) 0.175 (h/15)^0.199 (V_w^⅓/h)^−1.274 e^b
//! T   = 0.304 (h/15)^0.707 (V_w^⅓/h)^1.228 e^b hours      until all erosion ends: longer than a breach takes to form
//! ```
//!
//! b is the sum of three coefficients: of the fill, of the failure, of the erodibility. Not here: dams with core walls and with concrete faces, and
//! the formula for the height of the breach, which is given.

use super::breach::FailureMode;

/// How easily water carries a dam away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Erodibility {
    /// Sand and silt, poorly compacted.
    High,
    /// Between both.
    Medium,
    /// Clay, well compacted.
    Low,
}

impl Erodibility {
    /// All of them, with their names.
    pub const ALL: [(Erodibility, &str); 3] =
        [(Erodibility::High, "high"), (Erodibility::Medium, "medium"), (Erodibility::Low, "low")];
}

/// What the formulas say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErodedBreach {
    /// Mean width (m).
    pub mean_width: f64,
    /// Slope of the sides, horizontal to vertical.
    pub side_slope: f64,
    /// Peak discharge (m³/s).
    pub discharge: f64,
    /// Time (s) until all erosion ends.
    pub time: f64,
}

/// Coefficients of one quantity: of the fill, of overtopping and piping, of high, medium and low erodibility.
type Coefficients = (f64, [f64; 2], [f64; 3]);

const OF_MEAN_WIDTH: Coefficients = (-0.226, [0.149, -0.389], [0.291, -0.140, -0.391]);
const OF_TOP_WIDTH: Coefficients = (-0.089, [0.299, -0.239], [0.411, -0.062, -0.289]);
const OF_DISCHARGE: Coefficients = (-0.649, [-0.705, -1.039], [-0.007, -0.375, -1.362]);
const OF_TIME: Coefficients = (-0.189, [-0.579, -0.611], [-1.205, -0.564, 0.579]);

/// The formulas for a volume (m³) and a height (m), both positive.
pub fn eroded_breach(
    volume: f64,
    height: f64,
    mode: FailureMode,
    erodibility: Erodibility,
    gravity: f64,
) -> ErodedBreach {
    let (h, shape) = (height / 15.0, volume.cbrt() / height);
    let power = |(fill, modes, erodibilities): Coefficients, factor: f64, of_height: f64, of_shape: f64| {
        let of_mode = modes[usize::from(mode == FailureMode::Piping)];
        let of_erodibility = erodibilities[erodibility as usize];
        factor * h.powf(of_height) * shape.powf(of_shape) * (fill + of_mode + of_erodibility).exp()
    };
    let mean_width = height * power(OF_MEAN_WIDTH, 0.787, 0.133, 0.652);
    let top_width = height * power(OF_TOP_WIDTH, 1.062, 0.092, 0.508);
    ErodedBreach {
        mean_width,
        // The mean width is that at half the height: both sides lean by half of the difference.
        side_slope: ((top_width - mean_width) / height).max(0.0),
        discharge: (gravity * volume.powf(5.0 / 3.0)).sqrt() * power(OF_DISCHARGE, 0.175, 0.199, -1.274),
        time: 3600.0 * power(OF_TIME, 0.304, 0.707, 1.228),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn breaches_by_hand() {
        let of = |mode, erodibility| eroded_breach(1e7, 30.0, mode, erodibility, 9.81);
        let near = |found: ErodedBreach, [width, slope, discharge, hours]: [f64; 4]| {
            let pairs = [
                (found.mean_width, width),
                (found.side_slope, slope),
                (found.discharge, discharge),
                (found.time / 3600.0, hours),
            ];
            pairs.iter().all(|(value, expected)| (value / expected - 1.0).abs() < 1e-3)
        };
        // V_w^⅓/h = 215.4435/30 = 7.181449. Mean width, overtopping, medium: 30 · 0.787 · 2^0.133 · 7.181449^0.652 · e^−0.217
        // = 23.61 · 1.096571 · 3.616334 · 0.804929 = 75.364 m; at the top 107.19 m.
        let medium = of(FailureMode::Overtopping, Erodibility::Medium);
        assert!(near(medium, [75.364, 1.0609, 6171.7, 1.475]), "{medium:?}");
        let high = of(FailureMode::Overtopping, Erodibility::High);
        assert!(near(high, [115.96, 1.869, 8917.1, 0.7769]), "{high:?}");
        let low = of(FailureMode::Piping, Erodibility::Low);
        assert!(near(low, [34.24, 0.5215, 1647.0, 4.479]), "{low:?}");
    }
}
