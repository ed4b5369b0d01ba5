//! Shaded relief after `Horn1981`: the cosine of the angle between the ground and a sun in the north-west, 45° high.
//!
//! ```text
//! shade = (s_z − e (s_x ∂z/∂x + s_y ∂z/∂y)) / √(1 + e²|∇z|²)
//! ```
//!
//! with the unit vector s towards the sun and an exaggeration e that lets flat country show its forms.

use super::MapGrid;

/// Brightness from 0 (turned away from the sun) to 1 (facing it), `[rows, columns]`; NaN where there is no terrain.
///
/// `bed` is the elevation (m), row 0 in the north. The exaggeration follows the relief: steep terrain is shown as it is, flat
/// terrain up to eight times as steep.
pub fn hillshade(grid: &MapGrid, bed: &[f64]) -> Vec<f64> {
    debug_assert_eq!(bed.len(), grid.columns * grid.rows);
    let slopes: Vec<(f64, f64)> = (0..bed.len()).map(|index| slope(grid, bed, index)).collect();
    let steepness: Vec<f64> = slopes.iter().map(|(x, y)| x.hypot(*y)).filter(|s| s.is_finite()).collect();
    let mean = steepness.iter().sum::<f64>() / steepness.len().max(1) as f64;
    let exaggeration = (0.35 / mean.max(1e-9)).clamp(1.0, 8.0);
    let height = std::f64::consts::FRAC_1_SQRT_2; // sine and cosine of 45°
    let (sun_x, sun_y) = (-0.5, 0.5); // to the north-west
    slopes
        .iter()
        .map(|(slope_x, slope_y)| {
            let (x, y) = (exaggeration * slope_x, exaggeration * slope_y);
            let cosine = (height - sun_x * x - sun_y * y) / (1.0 + x * x + y * y).sqrt();
            if cosine.is_nan() { f64::NAN } else { cosine.clamp(0.0, 1.0) }
        })
        .collect()
}

/// Slope of a cell to the east and to the north by Horn's weights; beyond edges and gaps the centre value stands in.
fn slope(grid: &MapGrid, bed: &[f64], index: usize) -> (f64, f64) {
    let centre = bed[index];
    let (column, row) = ((index % grid.columns) as isize, (index / grid.columns) as isize);
    let at = |east: isize, north: isize| {
        let (c, r) = (column + east, row - north);
        let inside = c >= 0 && r >= 0 && c < grid.columns as isize && r < grid.rows as isize;
        let value = if inside { bed[r as usize * grid.columns + c as usize] } else { f64::NAN };
        if value.is_nan() { centre } else { value }
    };
    let span = 8.0 * grid.cell;
    let x = at(1, 1) + 2.0 * at(1, 0) + at(1, -1) - at(-1, 1) - 2.0 * at(-1, 0) - at(-1, -1);
    let y = at(-1, 1) + 2.0 * at(0, 1) + at(1, 1) - at(-1, -1) - 2.0 * at(0, -1) - at(1, -1);
    (x / span, y / span)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(slope_x: f64, slope_y: f64) -> f64 {
        let grid = MapGrid { columns: 5, rows: 5, west: 0.0, north: 50.0, cell: 10.0 };
        let bed: Vec<f64> =
            (0..25).map(|i| slope_x * 10.0 * (i % 5) as f64 - slope_y * 10.0 * (i / 5) as f64).collect();
        hillshade(&grid, &bed)[12]
    }

    #[test]
    fn slopes_that_face_the_sun_are_brighter() {
        assert!((plane(0.0, 0.0) - std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-12);
        assert!(plane(0.3, -0.3) > plane(0.0, 0.0)); // rising to the south-east faces north-west
        assert!(plane(-0.3, 0.3) < plane(0.0, 0.0));
        // A slope of one, square to the sun, which stands at 45°, is in full light.
        let full = std::f64::consts::FRAC_1_SQRT_2;
        assert!((plane(full, -full) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn gaps_stay_gaps() {
        let grid = MapGrid { columns: 3, rows: 1, west: 0.0, north: 1.0, cell: 1.0 };
        let shade = hillshade(&grid, &[1.0, f64::NAN, 1.0]);
        assert!(shade[1].is_nan() && shade[0].is_finite() && shade[2].is_finite());
    }
}
