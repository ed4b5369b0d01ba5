//! Dam breaks on a level bed without friction.
//!
//! ```text
//! dry (Ritter):   d = (2c − ξ)²/(9g),  u = ⅔ (c + ξ)   for −c < ξ < 2c,   ξ = x/t, c = √(g d₀)
//! wet (Stoker):   the same up to ξ = u_m − c_m, then (d_m, u_m) up to the bore at speed s = d_m u_m/(d_m − d_r), where
//!                 u_m = 2 (c_l − c_m) = (d_m − d_r) √(g (d_m + d_r)/(2 d_m d_r))
//! ```
//!
//! Sources: `Ritter1892`, `Stoker1957`.

use crate::scenario::GRAVITY;

/// Dam break on dry bed: depth (m) and velocity (m/s) at `x` (m) from the dam, positive to the dry side, after `t` (s, above 0).
pub fn ritter(depth: f64, x: f64, t: f64) -> (f64, f64) {
    let c = (GRAVITY * depth).sqrt();
    if x <= -c * t {
        (depth, 0.0)
    } else if x < 2.0 * c * t {
        ((2.0 * c - x / t).powi(2) / (9.0 * GRAVITY), 2.0 / 3.0 * (c + x / t))
    } else {
        (0.0, 0.0)
    }
}

/// How far (m) from the dam the water on dry bed is `film` (m) deep after `t` (s).
pub fn ritter_front(depth: f64, film: f64, t: f64) -> f64 {
    t * (2.0 * (GRAVITY * depth).sqrt() - 3.0 * (GRAVITY * film).sqrt())
}

/// The place (m from the dam) beyond which there are `volume` (m²) of water after `t` (s): t (2c − (27 g volume/t)^(1/3)).
pub fn ritter_outermost(depth: f64, volume: f64, t: f64) -> f64 {
    t * (2.0 * (GRAVITY * depth).sqrt() - (27.0 * GRAVITY * volume / t).cbrt())
}

/// Dam break on wet bed, `d_l` over `d_r` (m, above 0): depth and velocity as for [`ritter`]; the middle state by bisection.
pub fn stoker(d_l: f64, d_r: f64, x: f64, t: f64) -> (f64, f64) {
    let c_l = (GRAVITY * d_l).sqrt();
    let speed_behind_shock = |d: f64| (d - d_r) * (0.5 * GRAVITY * (d + d_r) / (d * d_r)).sqrt();
    let (mut low, mut high) = (d_r, d_l);
    for _ in 0..200 {
        let d = 0.5 * (low + high);
        if 2.0 * (c_l - (GRAVITY * d).sqrt()) > speed_behind_shock(d) { low = d } else { high = d }
    }
    let (d_m, u_m) = (low, speed_behind_shock(low));
    let shock = d_m * u_m / (d_m - d_r);
    let xi = x / t;
    if xi < -c_l {
        (d_l, 0.0)
    } else if xi < u_m - (GRAVITY * d_m).sqrt() {
        ((2.0 * c_l - xi).powi(2) / (9.0 * GRAVITY), 2.0 / 3.0 * (c_l + xi))
    } else if xi < shock {
        (d_m, u_m)
    } else {
        (d_r, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_water_that_left_is_the_water_that_came() {
        // Volume is kept: what is missing above the dam lies below it.
        for right in [0.0, 0.1, 5.0] {
            let (n, t, from, to) = (400_000, 50.0, -1000.0, 1000.0);
            let dx = (to - from) / f64::from(n);
            let volume: f64 = (0..n)
                .map(|k| from + (f64::from(k) + 0.5) * dx)
                .map(|x| if right > 0.0 { stoker(10.0, right, x, t).0 } else { ritter(10.0, x, t).0 })
                .sum::<f64>()
                * dx;
            // The bore lies within one of the cells of the sum: dx times its height.
            assert!((volume - 1000.0 * (10.0 + right)).abs() < 0.05, "{right}: {volume}");
        }
    }

    #[test]
    fn the_front_is_where_the_film_is() {
        let x = ritter_front(10.0, 0.01, 50.0);
        assert!((ritter(10.0, x, 50.0).0 - 0.01).abs() < 1e-12);
        let (n, from) = (100_000, ritter_outermost(10.0, 25.0, 50.0));
        let dx = (1000.0 - from) / f64::from(n);
        let beyond: f64 = (0..n).map(|k| ritter(10.0, from + (f64::from(k) + 0.5) * dx, 50.0).0 * dx).sum();
        assert!((beyond - 25.0).abs() < 1e-6, "{beyond}");
    }
}
