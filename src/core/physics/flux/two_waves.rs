//! Between two waves of speeds S_l and S_r, those that `Toro2001`, section 10.3, gives for the HLLC solver of `ToroSpruceSpeares1994`. It
//! is no HLLC: no flux passes, since the face is the contact.
//!
//! ```text
//! d_m = [ (c_l + c_r)/2 + (u_l − u_r)/4 ]₊² / g,   m_k = max(d_m, d_k)
//! |S_k − u_k| = c_k √( (m_k + d_k) m_k / 2 ) / d_k,   ζ_k = d_k |S_k − u_k|
//! ```
//!
//! Seen from the contact, which moves at u*, no volume passes, and the flux of momentum is
//! p* = p_k + d_k (S_k − u_k)(u* − u_k), the same from both sides. That is `between_waves`.

use super::side::{Side, between_waves};

/// p* (m³/s²) and u* (m/s) between two wet states.
#[inline(always)]
pub(super) fn star(left: Side, right: Side, g: f64) -> (f64, f64) {
    let bracket = 0.5 * (left.c + right.c) + 0.25 * (left.u - right.u);
    let d_0 = if bracket > 0.0 { bracket * bracket / g } else { 0.0 };
    let impedance = |side: Side| {
        let m = if d_0 > side.d { d_0 } else { side.d };
        side.c * (0.5 * (m + side.d) * m).sqrt()
    };
    between_waves(left, right, (impedance(left), impedance(right)), g)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::celerity;
    use crate::physics::flux::exact::ExactRiemann;

    #[test]
    fn is_exact_for_a_lone_shock() {
        // Behind a shock into still water of 1 m the solver is asked for the state that it is given on the left.
        let (g, d, d_r) = (9.81, 1.4_f64, 1.0_f64);
        let u = (d - d_r) * (0.5 * g * (d + d_r) / (d * d_r)).sqrt();
        let exact = ExactRiemann::solve(d, u, d_r, 0.0, g).star;
        assert!((exact.depth - d).abs() < 1e-9);
        let side = |d, u| Side { d, c: celerity(d, g), u };
        let (pressure, velocity) = star(side(d, u), side(d_r, 0.0), g);
        // The speed of the wave is estimated from d_0, a per cent off for such a shock.
        assert!((pressure / (0.5 * g * d * d) - 1.0).abs() < 5e-3, "{pressure}");
        assert!((velocity / u - 1.0).abs() < 1e-2, "{velocity} for {u}");
    }
}
