//! Mixing by turbulence: the eddy viscosity of a mixing length that goes with the depth.
//!
//! ```text
//! (M35)  ν = √( (κ_K u* d/6)² + (β² l² |S|)² ),   l² = λ² d² (1 − 2λ/(3κ_K)),   |S|² = 2 (∂u/∂x)² + 2 (∂v/∂y)² + (∂u/∂y + ∂v/∂x)²
//! ```
//!
//! The first part is made at the bed: the mean over the depth of κ_K u* z (1 − z/d). The second one is made by shear in the plane. Its length is β
//! times that of the vertical, κ_K z near the bed and λ d above (`Escudier1966`), of which l² is the mean square over the depth. β = 6 after `Stansby2003`,
//! who found it by the wake of a conical island. Together β l = 0.50 d.
//!
//! **Departs from the source**: `Stansby2003` has the vertical resolved; here lengths and shear are means over the depth.

/// Constant of von Kármán.
const KAPPA: f64 = 0.41;

/// β² l²/d², the square of the mixing length of the plane over that of the depth.
///
/// - `lambda` λ: mixing length over depth away from the bed (`Escudier1966`)
/// - `beta` β: mixing length of the plane over that of the vertical (`Stansby2003`)
pub fn square_of_length(lambda: f64, beta: f64) -> f64 {
    beta * beta * lambda * lambda * (1.0 - 2.0 * lambda / (3.0 * KAPPA))
}

/// Eddy viscosity ν (m²/s), 0 or more.
///
/// - `depth` (m), 0 or more
/// - `shear_velocity` u* (m/s), 0 or more: √g n |v| / d^(1/6) with Manning's n
/// - `strain` |S| (1/s), 0 or more
/// - `square_of_length`: that of [`square_of_length`]
#[inline(always)]
pub fn eddy_viscosity(depth: f64, shear_velocity: f64, strain: f64, square_of_length: f64) -> f64 {
    let of_bed = KAPPA / 6.0 * shear_velocity * depth;
    let of_plane = square_of_length * depth * depth * strain;
    (of_bed * of_bed + of_plane * of_plane).sqrt()
}

/// |S| (1/s) of the gradients ∂u/∂x, ∂u/∂y, ∂v/∂x, ∂v/∂y (1/s).
#[inline(always)]
pub fn strain([u_x, u_y, v_x, v_y]: [f64; 4]) -> f64 {
    let shear = u_y + v_x;
    (2.0 * (u_x * u_x + v_y * v_y) + shear * shear).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAMBDA: f64 = 0.09;
    const BETA: f64 = 6.0;

    fn squared_length() -> f64 {
        square_of_length(LAMBDA, BETA)
    }

    #[test]
    fn the_length_is_the_mean_square_over_the_depth() {
        // The two layers summed up in a thousand strips.
        let strips = 1000;
        let square = |k: usize| {
            let length = (KAPPA * (k as f64 + 0.5) / f64::from(strips)).min(LAMBDA);
            length * length
        };
        let mean = (0..strips as usize).map(square).sum::<f64>() / f64::from(strips);
        assert!((squared_length() - BETA * BETA * mean).abs() < 1e-6 * squared_length(), "{} {mean}", squared_length());
        assert!((squared_length().sqrt() - 0.499).abs() < 1e-3);
    }

    #[test]
    fn both_parts_alone_and_none() {
        assert!(eddy_viscosity(2.0, 0.0, 0.0, squared_length()).abs() <= 0.0);
        assert!((eddy_viscosity(2.0, 0.3, 0.0, squared_length()) - 0.041).abs() < 1e-15);
        assert!((eddy_viscosity(2.0, 0.0, 0.5, squared_length()) - 0.5 * 4.0 * squared_length()).abs() < 1e-15);
    }

    #[test]
    fn strain_is_the_same_in_turned_axes() {
        // A shear du/dy = 3 seen at 45 degrees is a stretch of 1.5 along one axis and −1.5 along the other, with a turn that does not count.
        assert!((strain([0.0, 3.0, 0.0, 0.0]) - 3.0).abs() < 1e-15);
        assert!((strain([1.5, 1.5, -1.5, -1.5]) - 3.0).abs() < 1e-15);
        assert!(strain([0.0, 2.0, -2.0, 0.0]).abs() <= 0.0, "a turn as of a rigid body");
    }
}
