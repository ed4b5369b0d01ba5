//! What particles see of each other across a ridge of one cell, which is narrower than their kernels.
//!
//! A pair counts with the share of its area
//!
//! ```text
//! (M76)  w_ij = [clamp((H − z_k)/(H − z), 0, 1)]²,   H = max(η_i, η_j),   z = max(z_i, z_j)
//! ```
//!
//! with z_k the highest crest on the way from i to j: nothing where the crest stands above the water, as at a shore; over a crest that
//! drowns, the thrust g d²/2 of the water above z comes down to that of the water above z_k, g (H − z_k)²/2.

use super::{Balanced, State};
use crate::bed::BedParticles;
use crate::math::Vec2;
use crate::solver::moving::MovingWater;

/// w_ij of two particles.
pub(super) fn share_in_sight(bed: &BedParticles, me: &State, other: &State) -> f64 {
    let sill = bed.sill(me.position, other.position);
    if sill == f64::NEG_INFINITY {
        return 1.0;
    }
    let level = me.surface.max(other.surface);
    let ground = (me.surface - me.depth).max(other.surface - other.depth);
    let share = (level - sill) / (level - ground).max(f64::MIN_POSITIVE);
    share.clamp(0.0, 1.0).powi(2)
}

impl Balanced {
    /// The bed with its ridges, where one may stand within the reach of a particle.
    #[inline]
    pub(super) fn ridges_near<'a>(&self, water: &'a MovingWater, place: Vec2) -> Option<&'a BedParticles> {
        let bed = &water.bed;
        (!bed.ridges.is_empty() && bed.has_ridge_within(place, water.neighbours.largest_support())).then_some(bed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Lattice;

    #[test]
    fn a_pair_counts_with_the_thrust_above_the_crest() {
        let lattice = Lattice::new(Vec2::ZERO, 5, 1, 1.0);
        let mut bed = BedParticles::from_elevation(lattice, vec![0.0, 0.0, 3.0, 0.0, 0.0], 0.0);
        let state = |x: f64, surface: f64, depth: f64| State {
            position: Vec2::new(x, 0.5),
            surface,
            depth,
            ..State::default()
        };
        let (near, far) = (state(1.5, 4.0, 4.0), state(3.5, 1.0, 1.0));
        assert!((share_in_sight(&bed, &near, &far) - 1.0).abs() < 1e-15, "no ridge is named");
        bed.set_ridges([2].into_iter());
        for (crest, share) in [(5.0, 0.0), (4.0, 0.0), (3.0, 0.0625), (2.0, 0.25), (0.0, 1.0), (-1.0, 1.0)] {
            bed.elevation[2] = crest;
            assert!((share_in_sight(&bed, &near, &far) - share).abs() < 1e-15, "{crest}");
            assert!((share_in_sight(&bed, &far, &near) - share).abs() < 1e-15, "{crest}");
        }
        bed.elevation[2] = 9.0;
        assert!((share_in_sight(&bed, &near, &state(0.5, 4.0, 4.0)) - 1.0).abs() < 1e-15, "both on one side");
    }
}
