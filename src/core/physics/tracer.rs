//! What is carried with the water: the concentration of a mixture, and of what leaves a cell.
//!
//! ```text
//! (M111)  C_f = C_i + θ_i ½ Λ(2 ∇C_i·x_ij − D C, D C)        D C = C_j − C_i, for water that leaves i towards j
//! (M112)  θ_i ≤ 1 as great as may be with   min C ≤ C_i − θ_i Σ_f V_f δ_f/(V_i − Σ_f V_f) ≤ max C
//! (M113)  C = Σ_k V_k C_k / Σ_k V_k,  held between the least and the greatest C_k
//! ```
//!
//! Λ is the monotonised central mean (`VanLeer1977`), so that C_f lies between both concentrations; δ_f = C_f − C_i with θ = 1, V_f what leaves over a
//! face. min and max are those of the cell and of the wet cells about it (`Zalesak1979`). What stays of the water after (M112) and what comes are the
//! parts of (M113), each within the bounds of the concentrations before it. The clamp in (M113) takes rounding alone.
//! Not here: mixing by turbulence. A tracer spreads by the flow, and by the scheme where water passes faces.

use super::limiter::half_monotonised;
use crate::math::smaller;

/// Parts of water that mix, each with its volume and its concentration.
#[derive(Clone, Copy, Debug)]
pub struct Mixture {
    volume: f64,
    amount: f64,
    least: f64,
    greatest: f64,
}

impl Mixture {
    /// Nothing yet.
    pub const NOTHING: Mixture =
        Mixture { volume: 0.0, amount: 0.0, least: f64::INFINITY, greatest: f64::NEG_INFINITY };

    /// With one more part; a volume (m³, or m of depth for all parts) of 0 or less is none.
    #[inline]
    pub fn with(self, volume: f64, concentration: f64) -> Self {
        if volume <= 0.0 {
            return self;
        }
        Mixture {
            volume: self.volume + volume,
            amount: self.amount + volume * concentration,
            least: if concentration < self.least { concentration } else { self.least },
            greatest: if concentration > self.greatest { concentration } else { self.greatest },
        }
    }

    /// The volume of all parts.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// The concentration (M113); `otherwise` where there is no water.
    #[inline]
    pub fn concentration_or(&self, otherwise: f64) -> f64 {
        if self.volume > 0.0 { (self.amount / self.volume).clamp(self.least, self.greatest) } else { otherwise }
    }
}

/// By how much the concentration at the face towards another cell is greater than that of its own cell, with θ = 1 (M111).
///
/// - `behind`: 2 ∇C·x − D C, the difference to a cell as far on the other side; on a lattice that of the cell there
/// - `difference`: that of the other cell less its own
#[inline]
pub fn at_face(behind: f64, difference: f64) -> f64 {
    half_monotonised(behind, difference, 0.0)
}

/// θ of (M112).
///
/// - `concentration`, with the least and greatest about the cell
/// - `left`: the volume that stays; `beyond`: Σ V_f δ_f
#[inline]
pub fn share_of_slopes(concentration: f64, [least, greatest]: [f64; 2], left: f64, beyond: f64) -> f64 {
    let room = if beyond > 0.0 { concentration - least } else { greatest - concentration };
    let size = beyond.abs();
    if size > 0.0 { smaller(room.max(0.0) * left.max(0.0) / size, 1.0) } else { 1.0 }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "values that are exact in binary")]
mod tests {
    use super::{Mixture, at_face, share_of_slopes};

    #[test]
    fn a_mixture_has_the_mean_of_its_parts() {
        let mixture = Mixture::NOTHING.with(3.0, 10.0).with(1.0, 2.0).with(0.0, 99.0);
        assert_eq!((mixture.volume(), mixture.concentration_or(7.0)), (4.0, 8.0));
        assert_eq!(Mixture::NOTHING.concentration_or(7.0), 7.0);
        // Equal parts stay what they are, though a third has no end in binary.
        let thirds = (0..7).fold(Mixture::NOTHING, |mixture, k| mixture.with(0.1 * f64::from(k), 1.0 / 3.0));
        assert_eq!(thirds.concentration_or(0.0), 1.0 / 3.0);
    }

    #[test]
    fn what_leaves_lies_between_both_cells() {
        // Linear: half of the way. At an extremum: the cell's own.
        assert_eq!(at_face(2.0, 2.0), 1.0);
        assert_eq!(at_face(-4.0, 2.0), 0.0);
        for behind in [-7.0, 0.2, 0.9, 9.0] {
            let beyond = at_face(behind, 1.0);
            assert!((0.0..=1.0).contains(&beyond), "{behind}: {beyond}");
        }
    }

    #[test]
    fn what_stays_keeps_within_the_bounds() {
        // 3 of 4 m³ leave 2 more concentrated than the cell: 1 m³ would have 10 − 6, and may have 8.
        let share = share_of_slopes(10.0, [8.0, 13.0], 1.0, 6.0);
        assert_eq!(10.0 - share * 6.0, 8.0);
        assert_eq!(share_of_slopes(10.0, [8.0, 13.0], 1.0, -2.0), 1.0);
        assert_eq!(share_of_slopes(10.0, [8.0, 13.0], 0.0, 6.0), 0.0);
    }
}
