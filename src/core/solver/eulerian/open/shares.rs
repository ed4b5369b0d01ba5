//! Discharges of a boundary as a whole: spread over its faces by conveyance (M45), and found by its rating curve.

use super::inside::Inside;
use crate::boundary::Rating;
use crate::physics::open_boundary::HALVINGS;
use crate::solver::eulerian::Scale;

/// The shares of a discharge (M45).
pub(super) struct Shares {
    /// Level (m) of the water.
    level: f64,
    counts_roughness: bool,
    sum: f64,
}

impl Shares {
    /// Of a discharge `total` (m²/s, over all faces) among these faces.
    pub(super) fn new((inside, width): (&[Inside], &impl Fn(&Inside) -> f64), total: f64, g: f64) -> Self {
        let lowest = inside.iter().map(|i| i.bed).fold(f64::INFINITY, f64::min);
        let critical =
            |level: f64| inside.iter().map(|i| width(i) * (g * (level - i.bed).max(0.0).powi(3)).sqrt()).sum::<f64>();
        // All through the lowest face alone stands highest.
        let (mut low, mut high) = (lowest, lowest + (total * total / g).cbrt());
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if critical(middle) < total {
                low = middle;
            } else {
                high = middle;
            }
        }
        let counts_roughness = inside.iter().all(|i| i.friction > 0.0);
        let wet = inside.iter().filter(|i| i.is_wet).map(|i| (width(i) * i.depth, i.bed + i.depth));
        let (area, moment) = wet.fold((0.0, 0.0), |(area, sum), (depth, level)| (area + depth, sum + depth * level));
        let level = if area > 0.0 { high.max(moment / area) } else { high };
        let mut shares = Shares { level, counts_roughness, sum: 0.0 };
        shares.sum = inside.iter().map(|i| width(i) * i.facing.0 * shares.weight(i)).sum();
        shares
    }

    fn weight(&self, inside: &Inside) -> f64 {
        let depth = (self.level - inside.bed).max(0.0);
        let conveyance = depth * depth.cbrt() * depth.cbrt();
        if self.counts_roughness { conveyance / inside.friction.sqrt() } else { conveyance }
    }

    pub(super) fn of(&self, inside: &Inside) -> f64 {
        if self.sum > 0.0 { self.weight(inside) / self.sum } else { 0.0 }
    }
}

/// The level (m), counted as in the solver, at which what leaves through the faces is what the rating says.
pub(super) fn rated_level(rating: &Rating, inside: &[Inside], datum: f64, scale: &Scale) -> f64 {
    let g = scale.gravity;
    let wet = || inside.iter().filter(|i| i.is_wet && i.invariant > 0.0);
    let mut low = wet().map(|i| i.sill).fold(f64::INFINITY, f64::min);
    let mut high = wet().map(|i| i.sill + 0.25 * i.invariant * i.invariant / g).fold(f64::NEG_INFINITY, f64::max);
    if low > high {
        return 0.0;
    }
    for _ in 0..HALVINGS {
        let level = 0.5 * (low + high);
        let leaves: f64 = wet()
            .map(|i| {
                let s = i.below(level, g);
                i.width * (s.depth * s.outwards)
            })
            .sum::<f64>()
            * scale.spacing;
        if leaves > rating.discharge(level + datum) {
            low = level;
        } else {
            high = level;
        }
    }
    high
}
