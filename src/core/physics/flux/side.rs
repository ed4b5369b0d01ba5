//! The water on one side of a face, and the state between two waves.

/// The water on one side of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// Depth (m), above 0.
    pub d: f64,
    /// Celerity √(g d) (m/s).
    pub c: f64,
    /// Velocity (m/s), positive from left to right.
    pub u: f64,
}

/// p* and u* between two waves that carry the impedances ζ, `z_l` and `z_r` (m²/s), depth times speed of the wave in the water:
///
/// ```text
/// p* = [ζ_r p_l + ζ_l p_r + ζ_l ζ_r (u_l − u_r)]₊ / (ζ_l + ζ_r),   u* = (ζ_l u_l + ζ_r u_r + p_l − p_r) / (ζ_l + ζ_r)
/// ```
///
/// What the conservation of volume and momentum over both waves leaves, p being the same on both sides of the face.
#[inline(always)]
pub(super) fn between_waves(left: Side, right: Side, (z_l, z_r): (f64, f64), g: f64) -> (f64, f64) {
    let (p_l, p_r) = (0.5 * g * left.d * left.d, 0.5 * g * right.d * right.d);
    let per_sum = 1.0 / (z_l + z_r);
    let pressure = (z_r * p_l + z_l * p_r + z_l * z_r * (left.u - right.u)) * per_sum;
    (if pressure > 0.0 { pressure } else { 0.0 }, (z_l * left.u + z_r * right.u + p_l - p_r) * per_sum)
}
