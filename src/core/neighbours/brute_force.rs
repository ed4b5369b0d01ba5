//! All neighbours by the plain loop: the oracle of the cell grid.

use crate::math::Vec2;

/// Indices j with |x_j − position| < max(support, support_j), in ascending order.
pub fn within_brute_force(positions: &[Vec2], supports: &[f32], position: Vec2, support: f64) -> Vec<u32> {
    (0..positions.len())
        .filter(|&j| {
            let reach = support.max(f64::from(supports[j]));
            (positions[j] - position).norm_squared() < reach * reach
        })
        .map(|j| j as u32)
        .collect()
}
